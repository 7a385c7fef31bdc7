"""One case on a page, and two cases laid over each other."""

from collections.abc import Callable

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from fretwear import figures
from fretwear.running.simulate import Result


@pytest.mark.parametrize("dense", [False, True])
def test_all_of_a_case_on_one_page(
    dense: bool, smooth_run: Result, check_texts: Callable[[Figure], list[str]]
) -> None:
    history = smooth_run.history if dense else None
    figure = figures.overview(smooth_run.dataset, history)
    words = check_texts(figure)
    assert {
        "Pressure (MPa)",
        "Shear traction (MPa)",
        "Gap (µm)",
        "Wear depth (µm)",
        "Half-width along x (µm)",
        "contact",
        "stick",
    } <= set(words)
    assert any("$P$ = 40 N" in text and "smooth" in text for text in words)


def test_a_rough_capped_case_has_an_overview(
    rough, check_texts: Callable[[Figure], list[str]]
) -> None:
    words = check_texts(figures.overview(rough))
    assert any("4500 MPa" in text for text in words)


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
