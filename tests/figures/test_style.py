"""The look that all figures share can be read by everybody, on screens and on paper."""

from itertools import pairwise

import matplotlib.colors
import numpy as np
import pytest

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
