import shutil
import struct

import pytest

from fretwear.study.selection import select_case


def test_show_tells_parameters_and_results_beside_the_closed_forms(desk, case_file):
    result = desk.call("show", case_file)
    assert result.exit_code == 0
    case = select_case("tiny.yaml", None, ["load=50 N"])
    rows = {line[2:].split("  ")[0]: line.split("  ") for line in result.stdout.splitlines()}
    assert case.case_id in result.stdout
    assert rows["normal load P"][-1].strip() == "50 N"
    assert rows["plastic limit of the pressure"][-1].strip() == "none"
    width = [cell.strip() for cell in rows["contact half-width along x"] if cell.strip()]
    first, last, hertz = (float(cell.split()[0]) for cell in width[1:])
    assert hertz == pytest.approx(case.hertz_radius * 1e6, rel=1e-3)
    assert first == pytest.approx(hertz, rel=0.02)
    assert last > first
    pressure = [cell.strip() for cell in rows["pressure in the middle of the contact"] if cell]
    assert pressure[-1] == f"{case.hertz_pressure * 1e-9:.4g} GPa"


def test_every_result_has_a_unit_for_people(desk, case_file):
    lines = desk.call("show", case_file).stdout.splitlines()
    results = lines[lines.index("Results") + 2 : -2]
    assert len(results) == 13
    for line in results:
        assert line.split()[-1] in ("um", "nm", "um2", "um3", "MPa", "GPa", "nJ", "uJ")


@pytest.mark.parametrize(("name", "begins"), [("a.png", b"\x89PNG"), ("a.svg", b"<?xml")])
def test_plot_draws_the_case(desk, case_file, name, begins):
    result = desk.call("plot", case_file, "-o", name)
    assert result.exit_code == 0
    content = (desk.folder / name).read_bytes()
    assert content.startswith(begins)
    if name.endswith(".png"):
        width, height = struct.unpack(">II", content[16:24])
        assert (width, height) > (1000, 600)


def test_plot_puts_the_figure_beside_the_case(desk, case_file):
    shutil.copy(case_file, "mine.nc")
    assert desk.call("plot", "mine.nc").exit_code == 0
    assert desk.files() == ["mine.nc", "mine.png", "tiny.yaml"]


@pytest.mark.parametrize(
    ("output", "reason"),
    [("a.doc", ".png, .svg or .pdf"), ("tiny.yaml/a.png", "is not a folder")],
)
def test_a_figure_that_cannot_be_written_is_refused(desk, case_file, output, reason):
    result = desk.call("plot", case_file, "-o", output)
    assert result.exit_code == 2
    assert reason in result.stderr
    assert desk.files() == ["tiny.yaml"]


@pytest.mark.parametrize("command", ["show", "plot"])
def test_a_missing_or_damaged_case_file_is_refused(desk, case_file, command):
    damaged = desk.folder / "damaged.nc"
    damaged.write_bytes(case_file.read_bytes()[:-1000])
    for name in ("damaged.nc", "missing.nc", "tiny.yaml"):
        result = desk.call(command, name)
        assert result.exit_code == 2
        assert f"fretwear: error: {name}: " in result.stderr
    assert desk.files() == ["damaged.nc", "tiny.yaml"]
