"""One style for everybody, on screens and on paper; the same data give the same bytes."""

import hashlib
import os
import subprocess
import sys
import xml.etree.ElementTree as ET
from itertools import pairwise
from pathlib import Path

import matplotlib
import matplotlib.colors
import numpy as np
import pytest
import xarray as xr

from fretwear import figures
from fretwear.data.safe import DataFileError
from fretwear.figures.animation import ZONE_COLORS
from fretwear.figures.style import CATEGORICAL, JournalFigure, sequential_colours, text_colour


def _luminance(color: str) -> float:
    red, green, blue = matplotlib.colors.to_rgb(color)
    channels = [
        n / 12.92 if n <= 0.04045 else ((n + 0.055) / 1.055) ** 2.4 for n in (red, green, blue)
    ]
    return 0.2126 * channels[0] + 0.7152 * channels[1] + 0.0722 * channels[2]


@pytest.mark.parametrize("color", [*CATEGORICAL, *sequential_colours(6), "white"])
def test_text_in_any_colour_stands_out_from_white(color: str) -> None:
    assert 1.05 / (_luminance(text_colour(color)) + 0.05) >= 4.5


def test_dark_colours_are_text_as_they_are() -> None:
    assert text_colour("#000000") == "#000000"
    assert text_colour(CATEGORICAL[0].lower()) == CATEGORICAL[0].lower()


def test_later_cycles_are_darker_so_that_grey_tells_them_too() -> None:
    shades = [_luminance(color) for color in sequential_colours(6)]
    assert shades == sorted(shades, reverse=True)
    lightness = np.cbrt(shades)
    assert np.diff(lightness).max() < -0.02


def test_zones_differ_in_grey() -> None:
    shades = [_luminance(color) for color in ZONE_COLORS.values()]
    assert all(first > 1.5 * second for first, second in pairwise(shades))


def test_both_widths_have_text_of_one_size() -> None:
    heights = []
    for columns in (1, 2):
        figure = JournalFigure(columns, 40.0)
        text = figure.text(0.5, 0.5, "Pressure", fontsize=7.5)
        figure.set_dpi(300)
        figure.draw_without_rendering()
        heights.append(text.get_window_extent().height)
    assert heights[0] == heights[1]


SCRIPT = """
import sys, xarray as xr
from pathlib import Path
from fretwear import figures
case = xr.load_dataset(sys.argv[1])
figures.save_figure(figures.overview(case), Path(sys.argv[2]))
"""


def _digests(folder: Path) -> dict[str, str]:
    return {file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in folder.iterdir()}


def test_other_processes_write_the_same_bytes(rough: xr.Dataset, tmp_path: Path) -> None:
    rough.to_netcdf(tmp_path / "case.nc")
    found = []
    for seed in ("1", "2"):
        folder = tmp_path / seed
        subprocess.run(
            [sys.executable, "-c", SCRIPT, tmp_path / "case.nc", folder / "overview"],
            check=True,
            env={**os.environ, "PYTHONHASHSEED": seed},
        )
        found.append(_digests(folder))
    assert found[0] == found[1]
    assert set(found[0]) == {"overview.svg", "overview.png"}


def test_settings_of_the_user_do_not_change_the_bytes(smooth: xr.Dataset, tmp_path: Path) -> None:
    figures.save_figure(figures.pressure_profiles(smooth), tmp_path / "a" / "figure")
    with matplotlib.rc_context({"svg.fonttype": "none", "savefig.dpi": 50, "font.size": 5}):
        figures.save_figure(figures.pressure_profiles(smooth), tmp_path / "b" / "figure")
    assert _digests(tmp_path / "a") == _digests(tmp_path / "b")


def test_a_vector_file_is_well_formed_undated_and_loads_nothing(
    smooth: xr.Dataset, tmp_path: Path
) -> None:
    (path,) = figures.save_figure(figures.wear_map(smooth), tmp_path / "map", ("svg",))
    root = ET.fromstring(path.read_text(encoding="utf-8"))
    assert root.tag.endswith("svg")
    links = [
        value
        for element in root.iter()
        for name, value in element.attrib.items()
        if name.endswith("href")
    ]
    assert links
    assert all(link.startswith(("#", "data:")) for link in links)
    assert not [element for element in root.iter() if element.tag.endswith("date")]


def test_a_bitmap_has_300_dots_per_inch(smooth: xr.Dataset, tmp_path: Path) -> None:
    (path,) = figures.save_figure(figures.pressure_profiles(smooth), tmp_path / "p", ("png",))
    header = path.read_bytes()
    width = int.from_bytes(header[16:20], "big")
    assert width == pytest.approx(90.0 / 25.4 * 300.0, abs=1.0)


@pytest.mark.parametrize("name", ["figure.docx", "figure"])
def test_an_unknown_ending_is_refused_with_those_that_work(
    name: str, smooth: xr.Dataset, tmp_path: Path
) -> None:
    with pytest.raises(ValueError, match=r"\.png, \.svg or \.pdf"):
        figures.save_as(figures.pressure_profiles(smooth), tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_a_file_that_cannot_be_written_leaves_nothing(smooth: xr.Dataset, tmp_path: Path) -> None:
    (tmp_path / "folder").write_text("a file where a folder should be", encoding="utf-8")
    with pytest.raises(DataFileError):
        figures.save_as(figures.pressure_profiles(smooth), tmp_path / "folder" / "figure.svg")
    assert [file.name for file in tmp_path.iterdir()] == ["folder"]


def test_a_notebook_shows_a_figure_without_pyplot(smooth: xr.Dataset) -> None:
    picture = figures.pressure_profiles(smooth)._repr_png_()
    assert picture.startswith(b"\x89PNG")


def test_a_pdf_brings_its_fonts_along_as_truetype(smooth: xr.Dataset, tmp_path: Path) -> None:
    with matplotlib.rc_context({"pdf.fonttype": 3}):
        figures.pressure_profiles(smooth).savefig(tmp_path / "p.pdf")
    content = (tmp_path / "p.pdf").read_bytes()
    assert b"/FontFile2" in content
    assert b"/Type3" not in content


def test_matplotlibs_own_way_to_save_gives_journal_quality(
    smooth: xr.Dataset, tmp_path: Path
) -> None:
    with matplotlib.rc_context({"savefig.dpi": 50, "savefig.bbox": "tight"}):
        figures.pressure_profiles(smooth, columns=2).savefig(tmp_path / "p.png")
    width = int.from_bytes((tmp_path / "p.png").read_bytes()[16:20], "big")
    assert width == pytest.approx(190.0 / 25.4 * 300.0, abs=1.0)
