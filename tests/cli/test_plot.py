import shutil
import struct


def test_plot_draws_the_case_beside_it_or_where_it_is_told_to(desk, case_file):
    shutil.copy(case_file, "mine.nc")
    assert desk.call("plot", "mine.nc").exit_code == 0
    assert desk.call("plot", case_file, "-o", "a.svg").exit_code == 0
    assert desk.files() == ["a.svg", "mine.nc", "mine.png", "tiny.yaml"]
    assert (desk.folder / "a.svg").read_text(encoding="utf-8").startswith("<?xml")
    content = (desk.folder / "mine.png").read_bytes()
    assert content.startswith(b"\x89PNG")
    assert struct.unpack(">II", content[16:24]) > (1000, 600)


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


def test_without_ffmpeg_a_gif_is_offered(desk, case_file, monkeypatch):
    monkeypatch.setenv("PATH", str(desk.folder))
    result = desk.call("animate", case_file, "-o", "a.mp4")
    assert result.exit_code == 2
    assert "a.gif instead" in result.stderr
    assert desk.files() == ["tiny.yaml"]
