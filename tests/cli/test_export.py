"""``fretwear export``: a case as files of other programs."""

import pytest


@pytest.mark.slow
def test_cases_are_exported(desk, case_file):
    said = desk.call("export", case_file, "--to", "csv", "-o", "case.csv").stdout
    assert said.splitlines() == ["case-cycle-x-y.csv", "case-cycle.csv"]
    desk.call("export", case_file, "--to", "abaqus", "-o", "case.inp", "--cycle", 20)
    assert "cycle 20" in (desk.folder / "case.inp").read_text()


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (("--to", "csv", "--cycle", 7), "cycle 7 is not a snapshot; there are 0, 20 and 200"),
        (("--to", "vtk", "-o", "a.csv"), "must end in .pvd"),
        (("--to", "stl"), "'stl' is not one of"),
    ],
)
def test_wrong_requests_are_refused(desk, case_file, options, reason):
    assert reason in desk.call("export", case_file, *options, status=2).stderr
    assert desk.files() == ["tiny.yaml"]
