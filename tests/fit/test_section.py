"""The section of a report on a fit, and its figures."""

import re

import numpy as np
import pytest
import xarray as xr

from fretwear.data.atomic import DataFileError, write_text
from fretwear.study.reading import load_study
from fretwear_fit.runs import Prediction, Runs
from fretwear_fit.section import fit_figures, fit_sections


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


def test_a_file_that_is_no_fit_is_refused_in_a_sentence(cases):
    path = cases.with_name("fit.json")
    record = path.read_text()
    for text in ("{}", "[1]", record[: len(record) // 2]):
        path.write_text(text)
        with pytest.raises(DataFileError, match=r"fit\.json: it is not the file of a fit"):
            [*fit_sections(xr.Dataset(), cases)]
    path.write_text(record.replace("debris_fraction", "<script>x</script>"))
    (section,) = fit_sections(xr.Dataset(), cases)
    assert "<script>" not in section.body


def test_a_damaged_record_of_a_run_is_run_again(titanium, tmp_path, monkeypatch):
    case = titanium.study.points()[0].case
    (right,) = Runs({("wear_depth", "x")}, tmp_path)([case])
    (path,) = tmp_path.glob("*.json")
    whole = path.read_text()
    monkeypatch.setattr(Prediction, "of", lambda *_: right)
    for text, computed in ((whole[: len(whole) // 2], 1), (whole, 0)):
        path.write_text(text)
        again = Runs({("wear_depth", "x")}, tmp_path)
        again([case])
        assert again.computed == computed
        assert path.read_text() == whole
