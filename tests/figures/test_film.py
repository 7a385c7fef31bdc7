"""An animation shows the snapshots of a case, each with its cycle, in axes that stay."""

import shutil
import subprocess

import numpy as np
import pytest
from PIL import Image

from fretwear import figures
from fretwear.figures.film import FfmpegMissingError, durations, well_spaced_cycles

CYCLES = (0, 1, 10, 100, 1000)


def _curve(figure, label):
    lines = [line for axes in figure.axes for line in axes.get_lines()]
    line = next(line for line in lines if line.get_label() == label)
    return line.get_xdata(), line.get_ydata()


def test_every_picture_is_a_snapshot_on_the_whole_contact(rough, check_texts):
    animation = figures.animation(rough)
    assert animation.cycles == CYCLES
    limits = []
    for cycle in CYCLES:
        figure = animation.show(cycle)
        words = check_texts(figure)
        assert any(text.startswith(f"Cycle {cycle} ") for text in words)
        assert {"stick", "slip", "open", "Pressure (MPa)", "Wear depth (µm)"} <= set(words)
        x, pressure = _curve(figure, "Pressure")
        half = rough["pressure"].sel(cycle=cycle).isel(y=0).values / 1e6
        np.testing.assert_allclose(pressure, np.concatenate([half[::-1], half]), rtol=1e-6)
        np.testing.assert_allclose(x, -x[::-1])
        zones = figure.axes[1].get_images()[0].get_array()
        np.testing.assert_array_equal(
            zones[zones.shape[0] // 2 :, zones.shape[1] // 2 :],
            rough["contact_state"].sel(cycle=cycle).values.T,
        )
        limits.append([(axes.get_xlim(), axes.get_ylim()) for axes in figure.axes])
    assert all(other == limits[0] for other in limits)


def test_a_gif_has_one_picture_a_snapshot_and_rests_at_the_end(smooth_run, tmp_path):
    seen: list[tuple[int, int]] = []
    animation = figures.animation(smooth_run.dataset, smooth_run.history)
    path = animation.save(
        tmp_path / "wear.gif", dots_per_inch=60, progress=lambda *at: seen.append(at)
    )
    assert seen == [(number, 5) for number in range(1, 6)]
    with Image.open(path) as film:
        assert film.n_frames == 5
        assert film.info["loop"] == 0
        assert film.width == pytest.approx(190 / 25.4 * 60, abs=1)
        durations = []
        for number in range(film.n_frames):
            film.seek(number)
            durations.append(film.info["duration"])
    assert durations == pytest.approx([1000 * n for n in animation.seconds], abs=10)
    assert durations[-1] == max(durations)


def test_snapshots_far_apart_are_shown_longer_and_cycles_for_a_smooth_film_are_whole():
    seconds = durations([0, 10, 20, 1000])
    assert seconds[0] > seconds[1]
    assert seconds[2] > seconds[1]
    assert seconds[3] == max(seconds)
    for last in (1, 50, 7000, 30000):
        cycles = well_spaced_cycles(last)
        assert cycles[0] == 0
        assert cycles[-1] == last
        assert all(isinstance(cycle, int) for cycle in cycles)
        assert cycles == sorted(set(cycles))
    assert 25 <= len(well_spaced_cycles(30000)) <= 32


def test_other_snapshots_and_films_are_refused_and_without_ffmpeg_a_gif_is_offered(
    smooth, tmp_path, monkeypatch
):
    animation = figures.animation(smooth, cycles=[0, 1000])
    assert animation.cycles == (0, 1000)
    with pytest.raises(ValueError, match=r"shows \[0, 1000\]"):
        animation.show(10)
    with pytest.raises(ValueError, match=r"no snapshot at \[5\]"):
        figures.animation(smooth, cycles=[0, 5])
    animation = figures.animation(smooth, cycles=[0, 1])
    for name in ("wear.avi", "wear"):
        with pytest.raises(ValueError, match=r"\.gif or \.mp4"):
            animation.save(tmp_path / name)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(FfmpegMissingError, match=r"wear\.gif instead"):
        animation.save(tmp_path / "wear.mp4")
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(shutil.which("ffprobe") is None, reason="needs Debian's ffmpeg")
def test_an_mp4_lasts_as_long_as_its_pictures_and_plays_everywhere(smooth, tmp_path):
    animation = figures.animation(smooth, cycles=[0, 10, 1000])
    path = animation.save(tmp_path / "wear.mp4", dots_per_inch=51)
    entries = "stream=codec_name,pix_fmt,duration"
    command = ["ffprobe", "-v", "error", "-show_entries", entries, "-of", "csv=p=0", path]
    told = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    codec, pixels, seconds = told.strip().split(",")
    assert (codec, pixels) == ("h264", "yuv420p")
    assert float(seconds) == pytest.approx(sum(animation.seconds), abs=0.2)
