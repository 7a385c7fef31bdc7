"""``fretwear export``: a case or its stresses as files of other programs."""

import pytest


def test_cases_and_stresses_are_exported(desk, case_file):
    said = desk.call("export", case_file, "--to", "csv", "-o", "case.csv").stdout
    assert said.splitlines() == ["case-cycle-x-y.csv", "case-cycle.csv"]
    desk.call("export", case_file, "--to", "abaqus", "-o", "case.inp", "--cycle", 20)
    assert "cycle 20" in (desk.folder / "case.inp").read_text()
    desk.call("stress", case_file, "-o", "stress.nc", "--phases", 2, "--depth", "20 um")
    pytest.importorskip("pyevtk")
    said = desk.call("export", "stress.nc", "--to", "vtk").stdout
    assert said.splitlines() == ["stress-0000.vtr", "stress-0001.vtr", "stress.pvd"]


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
