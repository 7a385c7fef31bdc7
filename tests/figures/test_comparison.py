"""Two cases laid over each other."""

from collections.abc import Callable

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from fretwear import figures


def test_both_cases_are_in_every_panel_and_ratios_are_told(
    smooth: xr.Dataset, rough: xr.Dataset, check_texts: Callable[[Figure], list[str]]
) -> None:
    figure = figures.compare_cases({"A": smooth, "B": rough})
    words = check_texts(figure)
    assert "A: elastic, smooth" in words
    assert "B: $p_\\mathrm{lim}$ = 4500 MPa, $A$ = 0.3 µm" in words
    assert "Profiles and ratios at cycle 1000" in words
    for axes in figure.axes[:5]:
        labels = {str(line.get_label()).split(",")[0] for line in axes.get_lines()}
        assert {"A", "B"} <= labels
    ratio = float(rough["wear_volume"][-1] / smooth["wear_volume"][-1])
    assert f"×{ratio:.3g}" in words
    points = next(n for n in figure.axes[5].get_lines() if n.get_label() == "ratio")
    assert ratio in points.get_xdata()


def test_a_case_that_is_the_same_has_ratios_of_one(smooth: xr.Dataset) -> None:
    figure = figures.compare_cases({"A": smooth, "again": smooth})
    points = next(n for n in figure.axes[5].get_lines() if n.get_label() == "ratio")
    np.testing.assert_array_equal(points.get_xdata(), 1.0)


def test_more_than_two_cases_are_referred_to_other_figures(smooth: xr.Dataset) -> None:
    with pytest.raises(ValueError, match="Two cases are compared, not 3; compare_profiles"):
        figures.compare_cases(dict.fromkeys("abc", smooth))
