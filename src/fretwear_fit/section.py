"""The section of a report on a fit, and its figures: data with fit, band and residuals."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from markupsafe import Markup
from matplotlib.figure import Figure
from ruamel.yaml import YAML

from fretwear.data.atomic import DataFileError
from fretwear.data.files import open_group
from fretwear.figures.study import StudyFigure
from fretwear.figures.style import CATEGORICAL, MUTED, JournalFigure, caption, styled
from fretwear.report import Section, macros
from fretwear.units import BY_SI_UNIT, format_quantity, number_text, readable_unit

_CATEGORY = "Fit"
_AGAIN = "Fit again"
_HEIGHT = 80.0
_BOTH = ("value", "error")


def fit_sections(summary: xr.Dataset, cases: Path) -> Iterator[Section]:  # noqa: ARG001 - of all
    """Yield the section on the fit beside a folder of case files, if there is one."""
    path = cases.parent / "fit.json"
    if path.exists() and path.with_suffix(".nc").exists():
        with _refusing(path):
            section = _section(json.loads(path.read_bytes()))
        yield section


def _section(record: Mapping[str, Any]) -> Section:
    """The section, of the content of ``fit.json``."""
    levels = ("0.68", "0.95")
    rows = [
        (
            name,
            _text(about["value"], about["unit"]),
            *(
                " to ".join(_text(end, about["unit"]) for end in about["intervals"][level])
                for level in levels
            ),
        )
        for name, about in record["parameters"].items()
    ]
    names = [*record["parameters"]]
    correlation = [
        (name, *(f"{value:.2f}".replace("-", "−") for value in row.values()))
        for name, row in record["correlation"].items()
    ]
    lines = [_line(about) for about in record["measurements"]]
    chi = (
        f"χ² is {record['chi_square']:.4g} with {record['degrees_of_freedom']} degrees of freedom, "
        f"p = {record['p_value']:.2g}; the fit took {record['runs']} runs."
    )
    stream = StringIO()
    YAML().dump(record["fitted_study"], stream)
    heads = ["parameter", "best value", "68 %", "95 %"]
    body = macros("fretwear_fit")["fit"](
        heads,
        rows,
        names,
        correlation,
        lines,
        chi,
        record["warnings"],
        stream.getvalue(),
    )
    return Section("fit", "Fit to measurements", Markup(body))


def fit_figures(summary: xr.Dataset, cases: Path) -> Iterator[StudyFigure]:  # noqa: ARG001 - of all
    """Yield a figure for each profile and loop that a fit beside a folder of cases was made to."""
    path = cases.parent / "fit.nc"
    if not (path.exists() and path.with_suffix(".json").exists()):
        return
    with _refusing(path):
        data, predicted = (
            open_group(path, group, _AGAIN).load()
            for group in ("observed_data", "posterior_predictive")
        )
        numbers = [
            name.removeprefix("data_")
            for name in map(str, data.data_vars)
            if f"position_{name.removeprefix('data_')}" in data.coords
        ]
    for number in numbers:
        is_profile = data[f"data_{number}"].attrs["units"] == "m"
        figure = (fit_profile if is_profile else fit_loop)(data, predicted, number)
        words = figure.caption if isinstance(figure, JournalFigure) else ""
        yield StudyFigure(f"fit_{number}", words, _CATEGORY, figure)


@styled
def fit_profile(data: xr.Dataset, predicted: xr.Dataset, number: str) -> Figure:
    """A measured profile, what the fit predicts for it, and what is left.

    `data` and `predicted` are the groups ``observed_data`` and ``posterior_predictive`` of a fit;
    the band has 95 % of the predictions, noise included.
    """
    name = f"data_{number}"
    x, measured = data[f"position_{number}"].values, data[name].values
    draws = predicted[name].values.reshape(-1, measured.size)
    mean, (low, high) = draws.mean(axis=0), np.quantile(draws, (0.025, 0.975), axis=0)
    along, deep = readable_unit(x, "m"), readable_unit(measured, "m")
    figure = JournalFigure(1, _HEIGHT)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    places = along.of(x)
    upper.fill_between(places, deep.of(low), deep.of(high), color=CATEGORICAL[0], alpha=0.2, lw=0)
    upper.plot(places, deep.of(measured), ".", ms=2.5, color=MUTED, label="measured")
    upper.plot(places, deep.of(mean), color=CATEGORICAL[0], label="fitted, 95 %")
    upper.invert_yaxis()
    upper.set_ylabel(f"Depth ({deep.name})")
    upper.legend()
    lower.axhline(0.0, lw=0.6, color=MUTED)
    lower.plot(places, deep.of(measured - mean), ".", ms=2.5, color=MUTED)
    lower.set(xlabel=f"Position ({along.name})", ylabel="Residual")
    title = str(data[name].attrs["long_name"])
    caption(figure, f"{title}: readings, fit with the band of 95 % of predictions, and residuals.")
    return figure


@styled
def fit_loop(data: xr.Dataset, predicted: xr.Dataset, number: str) -> Figure:
    """A measured loop of force against displacement, and what the fit predicts for it.

    `data` and `predicted` are as for `fit_profile`; lines have 95 % of the predicted forces.
    """
    name = f"data_{number}"
    x, measured = data[f"position_{number}"].values, data[name]
    draws = predicted[name].values.reshape(-1, measured.size)
    mean, (low, high) = draws.mean(axis=0), np.quantile(draws, (0.025, 0.975), axis=0)
    along, force = (
        readable_unit(values, unit)
        for values, unit in ((x, "m"), (measured.values, str(measured.attrs["units"])))
    )
    figure = JournalFigure(1, _HEIGHT)
    axes, places = figure.subplots(), along.of(x)
    band = force.of(low), force.of(high)
    axes.vlines(places, *band, color=CATEGORICAL[0], alpha=0.2)
    axes.plot(places, force.of(measured.values), ".", ms=2.5, color=MUTED, label="measured")
    axes.plot(places, force.of(mean), "_", ms=3, color=CATEGORICAL[0], label="fitted, 95 %")
    axes.set(xlabel=f"Displacement ({along.name})", ylabel=f"Force ({force.name})")
    axes.legend()
    title = str(measured.attrs["long_name"])
    caption(figure, f"{title}: readings, and the nearest points of the fitted loop with 95 %.")
    return figure


@contextmanager
def _refusing(path: Path) -> Iterator[None]:
    """Refuse a file that is not as a fit is stored."""
    try:
        yield
    except (OSError, LookupError, AttributeError, TypeError, ValueError) as cause:
        raise DataFileError(path, f"it is not the file of a fit ({cause})", _AGAIN) from cause


def _text(value: float, unit: str, digits: int = 4) -> str:
    if unit in BY_SI_UNIT and unit not in ("1", "Pa-1"):
        return format_quantity(value, BY_SI_UNIT[unit], digits)
    return f"{number_text(value, digits)} {'' if unit == '1' else unit}".strip()


def _line(about: Mapping[str, Any]) -> tuple[str, str, str]:
    """Measurement, noise and base line in words."""
    noise = "given"
    if "noise" in about:
        size, reach = (_text(about[key], "m", 3) for key in ("noise", "correlation_length"))
        noise = f"{size}, correlated over {reach}"
    shifts = []
    for name in ("offset", "tilt", "shift"):
        if name in about:
            digits = 2 if name == "tilt" else 3
            texts = [_text(about[name][key], about[name]["unit"], digits) for key in _BOTH]
            shifts.append(f"{name} {' ± '.join(texts)}")
    return about["measurement"], noise, ", ".join(shifts)
