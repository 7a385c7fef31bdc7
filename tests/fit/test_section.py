"""The section of a report on a fit, and its figures."""

import json
import re

import netCDF4
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


@pytest.mark.parametrize(
    "change",
    [
        lambda stored: stored.clear(),
        lambda stored: stored.update(parameters=[1]),
        lambda stored: stored["parameters"]["debris_fraction"].update(value="much"),
        lambda stored: stored["parameters"]["debris_fraction"].update(intervals={}),
        lambda stored: stored.update(chi_square=None),
        lambda stored: stored["measurements"].append(7),
        lambda stored: stored.update(warnings=3),
        lambda stored: stored["parameters"]["debris_fraction"].update(value=10**400),
    ],
)
def test_a_record_of_a_fit_that_somebody_has_made_up_is_refused(cases, change):
    path = cases.with_name("fit.json")
    stored = json.loads(path.read_text())
    change(stored)
    for text in (json.dumps(stored), "[" * 90_000, "[1]"):
        path.write_text(text)
        with pytest.raises(
            DataFileError, match=r"fit\.json: it is not the file of a fit.*Fit again"
        ):
            [*fit_sections(xr.Dataset(), cases)]


def test_text_in_a_record_of_a_fit_stays_text(cases):
    path = cases.with_name("fit.json")
    path.write_text(path.read_text().replace("debris_fraction", "<script>x</script>"))
    (section,) = fit_sections(xr.Dataset(), cases)
    assert "<script>" not in section.body


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda file: file.renameGroup("observed_data", "data"), "not the file of a fit"),
        (lambda file: file["observed_data"]["data_1"].setncattr("long_name", 7), "no profile"),
        (lambda file: file["observed_data/data_1"].__setitem__(0, np.inf), "no profile"),
        (lambda file: file["posterior_predictive"].renameVariable("data_1", "a"), "not the file"),
        (lambda file: file["posterior_predictive"].renameDimension("draw", "a"), "no profile"),
    ],
)  # fmt: skip
def test_draws_of_a_fit_that_somebody_has_made_up_are_refused(cases, change, words):
    path = cases.with_name("fit.nc")
    with netCDF4.Dataset(path, "a") as file:
        change(file)
    with pytest.raises(DataFileError, match=rf"fit\.nc: .*{words}.*Fit again"):
        [*fit_figures(xr.Dataset(), cases)]


@pytest.mark.parametrize(
    "change",
    [
        lambda stored: stored.clear(),
        lambda stored: stored.update(cycles=[0.0]),
        lambda stored: stored.update(numbers=[1]),
        lambda stored: stored["numbers"].clear(),
        lambda stored: stored["profiles"].clear(),
        lambda stored: stored.update(loops=[[], []]),
        lambda stored: stored["numbers"].update(wear_volume=["much"] * 3),
        lambda stored: stored["numbers"].update(wear_volume=[10**400]),
        lambda stored: stored["profiles"]["wear_depth x"][1][1].__setitem__(0, float("nan")),
    ],
)
def test_a_kept_run_that_somebody_has_made_up_is_run_again(titanium, tmp_path, change, monkeypatch):
    case = titanium.study.points()[0].case
    lines = {("wear_depth", "x")}
    found = Runs(lines, tmp_path)
    (right,) = found([case])
    (path,) = tmp_path.glob("*.json")
    whole = path.read_text()
    monkeypatch.setattr(Prediction, "of", lambda *_: right)
    for text in (json.dumps(change(stored := json.loads(whole)) or stored), "[" * 90_000, "[]"):
        path.write_text(text)
        again = Runs(lines, tmp_path)
        again([case])
        assert again.computed == 1
        assert path.read_text() == whole
    kept = Runs(lines, tmp_path)
    kept([case])
    assert kept.computed == 0
