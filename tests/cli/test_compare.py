import re

import pytest


@pytest.fixture(scope="module")
def other_file(tmp_path_factory, case_file):
    """A case of a smaller load."""
    from typer.testing import CliRunner

    from fretwear.cli import app

    path = tmp_path_factory.mktemp("other") / "other.nc"
    study = case_file.parent / "tiny.yaml"
    done = CliRunner().invoke(app, ["run", str(study), "--set", "load=25 N", "-o", str(path)])
    assert done.exit_code == 0
    return path


def _rows(text):
    return [
        [cell for cell in re.split(r"\s{2,}", line.strip()) if cell] for line in text.splitlines()
    ]


def test_compare_tells_what_differs_and_by_which_factor(desk, case_file, other_file):
    result = desk.call("compare", other_file, case_file)
    assert result.exit_code == 0
    rows = {row[0]: row[1:] for row in _rows(result.stdout) if row}
    assert rows["normal load"] == ["25 N", "50 N"]
    assert "coefficient of friction" not in " ".join(rows)
    first, second, ratio = rows["wear volume"]
    volumes = [float(text.split()[0]) for text in (first, second)]
    assert float(ratio) == pytest.approx(volumes[1] / volumes[0], rel=0.01)
    # Hertz: the radius goes with the cube root of the load.
    assert float(rows["contact half-width along x"][2]) == pytest.approx(2 ** (1 / 3), rel=0.03)
    assert desk.files() == ["tiny.yaml"]


def test_compare_says_when_nothing_differs(desk, case_file):
    result = desk.call("compare", case_file, case_file)
    assert "All parameters are the same." in result.stdout


def test_compare_draws_both_where_it_is_told_to(desk, case_file, other_file):
    result = desk.call("compare", case_file, other_file, "-o", "both.svg")
    assert result.exit_code == 0
    assert (desk.folder / "both.svg").read_text(encoding="utf-8").startswith("<?xml")
    assert result.stdout.splitlines()[-1] == "both.svg"


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [(["missing.nc"], "missing.nc: "), (["tiny.yaml"], "tiny.yaml: "), (["-o", "a.doc"], ".pdf")],
)
def test_what_cannot_be_compared_is_refused(desk, case_file, arguments, reason):
    result = desk.call(
        "compare", case_file, *arguments, *([case_file] if "-o" in arguments else [])
    )
    assert result.exit_code == 2
    assert reason in result.stderr
    assert desk.files() == ["tiny.yaml"]
