"""The section of a report on a fit, and its figures."""

import re

import numpy as np
import pytest
import xarray as xr

from fretwear.data.safe import write_text
from fretwear.fitting.section import fit_figures, fit_sections
from fretwear.study.study import load_study


@pytest.fixture
def cases(titanium, tmp_path):
    titanium.write(tmp_path / "fit.nc")
    titanium.write_json(tmp_path / "fit.json")
    return tmp_path / "cases"


def test_a_report_has_values_intervals_correlations_and_warnings_of_a_fit(titanium, cases):
    (section,) = fit_sections(xr.Dataset(), cases)
    text = re.sub(r"\s+", " ", re.sub("<[^>]*>", " ", section.body))
    for name in titanium.names:
        assert name in text
    assert "0.9523" in text
    assert "−0.56" in text
    assert "5 um, correlated over 0 nm" in text
    for warning in titanium.warnings:
        assert warning in text


def test_the_study_of_the_best_values_is_ready_to_run(titanium, cases):
    (section,) = fit_sections(xr.Dataset(), cases)
    (written,) = re.findall("<pre>(.*?)</pre>", section.body, re.DOTALL)
    file = cases.with_name("fitted.yaml")
    write_text(file, written.replace("&#39;", "'").replace("&#34;", '"'))
    (point,) = load_study(file).points()
    assert point.case.debris_fraction == pytest.approx(titanium.values["debris_fraction"], 1e-4)


def test_the_figure_shows_readings_fit_and_residuals(titanium, cases):
    (figure,) = fit_figures(xr.Dataset(), cases)
    upper, lower = figure.figure.axes
    x, depth = titanium.measurements[0].comparison.measurement.readings
    readings, curve = upper.get_lines()
    assert readings.get_xydata() == pytest.approx(np.column_stack([x * 1e3, depth * 1e6]))
    assert curve.get_ydata() == pytest.approx(titanium.measurements[0].fitted * 1e6, abs=2.5)
    residuals = lower.get_lines()[1].get_ydata()
    assert residuals == pytest.approx(depth * 1e6 - curve.get_ydata())
    assert "residuals" in figure.caption


def test_a_study_without_a_fit_has_no_section(tmp_path):
    assert not [*fit_sections(xr.Dataset(), tmp_path / "cases")]
    assert not [*fit_figures(xr.Dataset(), tmp_path / "cases")]
