"""The section of a report on a fit, and its figures."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd
import xarray as xr
from markupsafe import Markup

from fretwear.cli.common import CommandError
from fretwear.data.atomic import DataFileError
from fretwear.data.groups import open_group
from fretwear.units import QuantityError
from fretwear_fit.fit import Record, parameter_table
from fretwear_measured.tables import TABLES

if TYPE_CHECKING:
    from fretwear.figures.study import StudyFigure
    from fretwear.figures.style import JournalFigure
    from fretwear.report import Section


def fit_sections(summary: xr.Dataset, cases: Path) -> Iterator[Section]:
    """Yield the section on the fit beside a folder of case files, if there is one."""
    from fretwear.report import Section

    path = cases.parent / "fit.json"
    if path.exists():
        body = _body(json.loads(path.read_bytes()))
        drawn = sorted(file.stem for file in (cases.parent / "figures").glob("fit_*.svg"))
        yield Section("fit", "Fit to measurements", body, (*drawn,), is_first=True)


def _body(record: Record) -> Markup:
    """The section, of the content of ``fit.json``."""
    from fretwear.report import table_html

    body = Markup("<p>χ² is {:.4g} with {} degrees of freedom, p = {:.2g}; {} runs.</p>").format(
        record["chi_square"], record["degrees_of_freedom"], record["p_value"], record["runs"]
    )
    body += table_html(parameter_table(record), index=True)
    if len(record["parameters"]) > 1:
        correlation = pd.DataFrame(record["correlation"]).round(2)
        body += Markup("<h3>Correlations</h3>") + table_html(correlation, index=True)
    items = Markup("").join(Markup("<li>{}</li>").format(told) for told in record["warnings"])
    body += Markup("<h3>What the data leave open</h3><ul>{}</ul>").format(items) if items else ""
    return body + Markup(
        "<p>All further results belong to the initial values of the study file, not to the fit.</p>"
    )


def fit_figures(summary: xr.Dataset, cases: Path) -> Iterator[StudyFigure]:
    """Yield a figure for each profile and loop that a fit beside a folder of cases was made to."""
    from fretwear.figures.study import StudyFigure

    path = cases.parent / "fit.nc"
    for name, figure in plots_of_file(path) if path.exists() else ():
        yield StudyFigure(name, figure.caption, figure)


def plots_of_file(path: Path) -> Iterator[tuple[str, JournalFigure]]:
    """Yield the figures of each profile and loop of a fit, or of a recording, with their names."""
    if path.suffix.lower() in TABLES:
        from fretwear_fit.figures import recording_figure
        from fretwear_fit.loops import split_recording

        try:
            yield "loops", recording_figure(split_recording(path, 1.0))
        except QuantityError as error:
            remedy = "fretwear loops has options for this, and draws the same by --figure FIG.png"
            raise CommandError(f"{path}: {error.rule}; {remedy}") from error
        return
    try:
        data, predicted, fitted = (
            open_group(path, group, "Fit again").load()
            for group in ("observed_data", "posterior_predictive", "constant_data")
        )
    except DataFileError:
        return
    # Reports have the section, and do not wait for matplotlib.
    from fretwear_fit.figures import fit_figure

    for name in map(str, data.data_vars):
        number = name.removeprefix("data_")
        if (places := data.coords.get(f"position_{number}")) is not None:
            yield f"fit_{number}", fit_figure(data[name], predicted[name], fitted[name], places)
