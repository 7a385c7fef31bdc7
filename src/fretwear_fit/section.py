"""The section of a report on a fit, and its figures: data with fit, interval and residuals."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from markupsafe import Markup
from matplotlib.figure import Figure

from fretwear.data.atomic import DataFileError
from fretwear.data.files import open_group
from fretwear.figures.study import StudyFigure
from fretwear.figures.style import CATEGORICAL, MUTED, JournalFigure, caption, styled
from fretwear.report import Section, table_html
from fretwear.units import readable_unit
from fretwear_fit.results import parameter_table

_HEIGHT = 80.0


def fit_sections(summary: xr.Dataset, cases: Path) -> Iterator[Section]:  # noqa: ARG001 - of all
    """Yield the section on the fit beside a folder of case files, if there is one."""
    path = cases.parent / "fit.json"
    if path.exists():
        yield Section("fit", "Fit to measurements", _body(json.loads(path.read_bytes())))


def _body(record: Mapping[str, Any]) -> Markup:
    """The section, of the content of ``fit.json``."""
    body = Markup("<p>χ² is {:.4g} with {} degrees of freedom, p = {:.2g}; {} runs.</p>").format(
        record["chi_square"], record["degrees_of_freedom"], record["p_value"], record["runs"]
    )
    body += table_html(parameter_table(record), index=True)
    if len(record["parameters"]) > 1:
        correlation = pd.DataFrame(record["correlation"]).round(2)
        body += Markup("<h3>Correlations</h3>") + table_html(correlation, index=True)
    items = Markup("").join(Markup("<li>{}</li>").format(told) for told in record["warnings"])
    body += Markup("<h3>What the data leave open</h3><ul>{}</ul>").format(items) if items else ""
    return body


def fit_figures(summary: xr.Dataset, cases: Path) -> Iterator[StudyFigure]:  # noqa: ARG001 - of all
    """Yield a figure for each profile and loop that a fit beside a folder of cases was made to."""
    path = cases.parent / "fit.nc"
    for name, figure in plots_of_file(path) if path.exists() else ():
        words = figure.caption if isinstance(figure, JournalFigure) else ""
        yield StudyFigure(name, words, figure)


def plots_of_file(path: Path) -> Iterator[tuple[str, Figure]]:
    """Yield name and figure of each profile and loop of a file of a fit; none of another file."""
    try:
        data, predicted = (
            open_group(path, group, "Fit again").load()
            for group in ("observed_data", "posterior_predictive")
        )
    except DataFileError:
        return
    for name in map(str, data.data_vars):
        number = name.removeprefix("data_")
        if (places := data.coords.get(f"position_{number}")) is not None:
            yield f"fit_{number}", fit_figure(data[name], predicted[name], places)


@styled
def fit_figure(measured: xr.DataArray, predicted: xr.DataArray, places: xr.DataArray) -> Figure:
    """A measured profile or loop, the fit with its interval of 95 %, and the residuals.

    The arrays are those of the groups ``observed_data`` and ``posterior_predictive`` of a fit.
    """
    draws = predicted.values.reshape(-1, measured.size)
    mean, (low, high) = draws.mean(axis=0), np.quantile(draws, (0.025, 0.975), axis=0)
    si_unit = str(measured.attrs["units"])
    along, unit = readable_unit(places.values, "m"), readable_unit(measured.values, si_unit)
    x, readings, is_profile = along.of(places.values), unit.of(measured.values), si_unit == "m"
    figure = JournalFigure(1, _HEIGHT)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    upper.plot(x, readings, ".", ms=2.5, color=MUTED, label="measured")
    ends = unit.of(low), unit.of(high)
    if is_profile:
        upper.fill_between(x, *ends, color=CATEGORICAL[0], alpha=0.2, lw=0)
        upper.invert_yaxis()
    else:
        upper.vlines(x, *ends, color=CATEGORICAL[0], alpha=0.2)
    line = "-" if is_profile else "_"
    upper.plot(x, unit.of(mean), line, ms=3, color=CATEGORICAL[0], label="fitted, 95 %")
    upper.set_ylabel(f"{'Depth' if is_profile else 'Force'} ({unit.name})")
    upper.legend()
    lower.axhline(0.0, lw=0.6, color=MUTED)
    lower.plot(x, readings - unit.of(mean), ".", ms=2.5, color=MUTED)
    lower.set_xlabel(f"{'Position' if is_profile else 'Displacement'} ({along.name})")
    lower.set_ylabel(f"Residual ({unit.name})")
    title = str(measured.attrs["long_name"])
    caption(figure, f"{title}: readings, fit with 95 % of its predictions, and residuals.")
    return figure
