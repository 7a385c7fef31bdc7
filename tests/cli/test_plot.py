import json
import shutil
import struct

import pytest


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


def test_animate_writes_a_gif_beside_the_case_and_advises_more_snapshots(desk, case_file):
    shutil.copy(case_file, "mine.nc")
    result = desk.call("animate", "mine.nc", "--dpi", "50")
    assert result.exit_code == 0
    content = (desk.folder / "mine.gif").read_bytes()
    assert content.startswith(b"GIF89a")
    assert result.stdout.startswith("mine.gif: 3 pictures, ")
    advice = result.stderr.partition("output: {cycles: [")[2].partition("]")[0]
    cycles = [int(cycle) for cycle in advice.split(", ")]
    assert (cycles[0], cycles[-1]) == (0, 200)


def test_programs_are_told_what_was_written(desk, case_file):
    arguments = ["animate", case_file, "-o", "a.gif", "--dpi", "50", "--log-format", "json"]
    result = desk.call(*arguments)
    told = [json.loads(line) for line in result.stderr.splitlines()]
    assert any(line.get("pictures") == 3 and line.get("bytes", 0) > 1000 for line in told)


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["case.nc", "-o", "a.avi"], "must end in .gif or .mp4"),
        (["case.nc", "-o", "a.mp4"], "a.gif instead"),
        (["missing.nc"], "missing.nc: "),
        (["tiny.yaml"], "tiny.yaml: "),
    ],
)
def test_what_cannot_be_animated_is_refused(desk, case_file, arguments, reason, monkeypatch):
    shutil.copy(case_file, "case.nc")
    monkeypatch.setenv("PATH", str(desk.folder))
    result = desk.call("animate", *arguments)
    assert result.exit_code == 2
    assert reason in result.stderr
    assert desk.files() == ["case.nc", "tiny.yaml"]
