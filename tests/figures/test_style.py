"""One style for everybody, on screens and on paper; the same data give the same bytes."""

import hashlib
import os
import subprocess
import sys
import xml.etree.ElementTree as ET
from itertools import pairwise

import matplotlib
import matplotlib.colors
import numpy as np
import pytest

from fretwear import figures
from fretwear.data.safe import DataFileError
from fretwear.figures.film import ZONE_COLORS
from fretwear.figures.style import CATEGORICAL, JournalFigure, sequential_colours, text_colour


def _luminance(color):
    red, green, blue = matplotlib.colors.to_rgb(color)
    channels = [
        n / 12.92 if n <= 0.04045 else ((n + 0.055) / 1.055) ** 2.4 for n in (red, green, blue)
    ]
    return 0.2126 * channels[0] + 0.7152 * channels[1] + 0.0722 * channels[2]


@pytest.mark.parametrize("color", [*CATEGORICAL, *sequential_colours(6), "white"])
def test_text_in_any_colour_stands_out_from_white(color):
    assert 1.05 / (_luminance(text_colour(color)) + 0.05) >= 4.5
    # Colours that are dark enough stay as they are.
    assert text_colour("#000000") == "#000000"
    assert text_colour(CATEGORICAL[0].lower()) == CATEGORICAL[0].lower()


def test_both_widths_have_text_of_one_size_and_later_cycles_and_zones_differ_in_grey():
    shades = [_luminance(color) for color in sequential_colours(6)]
    assert shades == sorted(shades, reverse=True)
    assert np.diff(np.cbrt(shades)).max() < -0.02
    shades = [_luminance(color) for color in ZONE_COLORS.values()]
    assert all(first > 1.5 * second for first, second in pairwise(shades))
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
figures.save_figure(figures.wear_map(case), Path(sys.argv[2]))
"""


def _digests(folder):
    return {file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in folder.iterdir()}


def test_another_process_and_other_settings_of_the_user_give_the_same_bytes(rough, tmp_path):
    rough.to_netcdf(tmp_path / "case.nc")
    subprocess.run(
        [sys.executable, "-c", SCRIPT, tmp_path / "case.nc", tmp_path / "there" / "map"],
        check=True,
        env={**os.environ, "PYTHONHASHSEED": "1"},
    )
    with matplotlib.rc_context({"svg.fonttype": "none", "savefig.dpi": 50, "font.size": 5}):
        figures.save_figure(figures.wear_map(rough), tmp_path / "here" / "map")
    found = _digests(tmp_path / "here")
    assert set(found) == {"map.svg", "map.png"}
    assert found == _digests(tmp_path / "there")


def test_a_vector_file_is_well_formed_undated_and_loads_nothing(smooth, tmp_path):
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


def test_a_file_that_cannot_be_written_leaves_nothing(smooth, tmp_path):
    for name in ("figure.docx", "figure"):
        with pytest.raises(ValueError, match=r"\.png, \.svg or \.pdf"):
            figures.save_as(figures.pressure_profiles(smooth), tmp_path / name)
    (tmp_path / "folder").write_text("a file where a folder should be", encoding="utf-8")
    with pytest.raises(DataFileError):
        figures.save_as(figures.pressure_profiles(smooth), tmp_path / "folder" / "figure.svg")
    assert [file.name for file in tmp_path.iterdir()] == ["folder"]


def test_matplotlibs_own_way_to_save_and_to_show_gives_journal_quality(smooth, tmp_path):
    with matplotlib.rc_context({"savefig.dpi": 50, "savefig.bbox": "tight"}):
        figures.pressure_profiles(smooth, columns=2).savefig(tmp_path / "p.png")
    (path,) = figures.save_figure(figures.pressure_profiles(smooth), tmp_path / "q", ("png",))
    for file, millimetres in ((tmp_path / "p.png", 190.0), (path, 90.0)):
        width = int.from_bytes(file.read_bytes()[16:20], "big")
        assert width == pytest.approx(millimetres / 25.4 * 300.0, abs=1.0)
    assert figures.pressure_profiles(smooth)._repr_png_().startswith(b"\x89PNG")
    with matplotlib.rc_context({"pdf.fonttype": 3}):
        figures.pressure_profiles(smooth).savefig(tmp_path / "p.pdf")
    content = (tmp_path / "p.pdf").read_bytes()
    assert b"/FontFile2" in content
    assert b"/Type3" not in content
