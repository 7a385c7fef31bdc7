"""Bearing-area curves, read back from the axes."""

import numpy as np
import pytest

from fretwear import figures
from fretwear.figures.bearing import compare_bearing_areas


def test_curves_are_the_heights_of_the_roughness_less_what_is_lost(rough, check_texts):
    figure = figures.bearing_area(rough)
    (axes,) = figure.axes
    first, last = (line.get_xydata().T for line in axes.get_lines())
    for share, height in (first, last):
        assert (np.diff(share) > 0.0).all()
        assert (np.diff(height) <= 0.0).all()
    assert first[1].mean() == pytest.approx(0.0, abs=1e-6 * first[1].max())
    size = {"nm": 1e9, "µm": 1e6}[axes.get_ylabel().split("(")[1].rstrip(")")]
    # The waves are symmetric about their mean: 0.3 µm up and down.
    assert first[1].max() == pytest.approx(0.3e-6 * size, rel=0.05)
    x, y = rough.x.values[:, None], rough.y.values[None, :]
    at_last = rough.isel(cycle=-1)
    half_widths = at_last.contact_half_width_x.item(), at_last.contact_half_width_y.item()
    inside = np.hypot(x / half_widths[0], y / half_widths[1]) <= 1.0
    lost = (at_last.wear_depth + at_last.plastic_depth).values[inside]
    assert first[1].mean() - last[1].mean() == pytest.approx(size * lost.mean(), rel=1e-4)
    assert {"cycle 0", "cycle 1000"} <= set(check_texts(figure))


def test_cases_are_compared_on_one_scale_of_heights(rough, check_texts, smooth):
    figure = compare_bearing_areas({"one": rough, "other": rough})
    one, other = figure.axes
    for mine, theirs in zip(one.get_lines(), other.get_lines(), strict=True):
        np.testing.assert_array_equal(mine.get_xydata(), theirs.get_xydata())
    assert one.get_ylim() == other.get_ylim()
    assert {"one", "other", "cycle 0", "cycle 1000"} <= set(check_texts(figure))
    with pytest.raises(ValueError, match="this case is smooth"):
        figures.bearing_area(smooth)
