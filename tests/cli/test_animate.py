import json
import shutil

import pytest


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
