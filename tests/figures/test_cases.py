"""One case on a page, and two cases laid over each other."""

import numpy as np
import pytest

from fretwear import figures


def test_all_of_a_case_on_one_page(smooth_run, rough, check_texts):
    words = check_texts(figures.overview(smooth_run.dataset, smooth_run.history))
    axes = {"Pressure (MPa)", "Shear traction (MPa)", "Gap (µm)", "Wear depth (µm)"}
    assert axes | {"Half-width along x (µm)", "contact", "stick"} <= set(words)
    assert any("$P$ = 40 N" in text and "smooth" in text for text in words)
    words = check_texts(figures.overview(rough))
    assert axes <= set(words)
    assert any("4500 MPa" in text for text in words)


def test_both_cases_are_in_every_panel_and_ratios_are_told(smooth, rough, check_texts):
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
    figure = figures.compare_cases({"A": smooth, "again": smooth})
    points = next(n for n in figure.axes[5].get_lines() if n.get_label() == "ratio")
    np.testing.assert_array_equal(points.get_xdata(), 1.0)
    with pytest.raises(ValueError, match="Two cases are compared, not 3; compare_profiles"):
        figures.compare_cases(dict.fromkeys("abc", smooth))
