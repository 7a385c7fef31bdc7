"""The page of a report: what is on it, in the order of the page."""

from __future__ import annotations

import base64
import json
import math
import re
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
import plotly
import xarray as xr
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from fretwear.data.atomic import DataFileError
from fretwear.data.effects import WRITTEN, Points, effects_table, key_results, point_values
from fretwear.data.merge import check_belongs
from fretwear.figures.datasets import history_of
from fretwear.report.matrix import build_matrix
from fretwear.report.plots import courses, curve, explorer
from fretwear.results import CASE_ID, STATUS, PointStatus, headlines
from fretwear.run.case_files import failures
from fretwear.study.mistakes import few_of
from fretwear.study.parameters import parameter, value_text
from fretwear.study.plan import Plan
from fretwear.units import NO_UNIT, axis_label, cycle_text, number_text, span

_TRACE = 0.01  # share of the largest value below which a relative error means nothing
_MOST_ROWS = 2000
_PAGE_WIDTH = 190.0 / 25.4 * 72.0  # of a figure over two columns of a journal, points
# Figures in reading order; other figures are behind a fold.
_FIRST = ["fretting_map", "coating_life", "exposed_area", "contact_", "stick_", "wear_map"]
_FIRST += ["pressure_", "shear_", "wear_profiles", "gap_profiles", "wear_rate_profiles"]


class Section(NamedTuple):
    """A section of a report that a package adds."""

    id: str  # anchor, unique in the page
    title: str
    body: Markup  # HTML, in which text from outside is escaped
    figures: tuple[str, ...] = ()  # names of figures of the study, shown below the body
    is_first: bool = False  # whether it is the answer of the study, above all else


class Image(NamedTuple):
    """A figure inside the page."""

    name: str
    caption: str
    uri: str  # its data
    share: float = 1.0  # its width over the page's, so that text has one size in all figures


def table_html(frame: pd.DataFrame, *, index: bool = False) -> Markup:
    """Return a table that scrolls sideways on narrow screens; all text is escaped."""
    with pd.option_context("display.max_colwidth", None):
        table = frame.to_html(index=index, border=0)
    return Markup(f'<div class="scroll" tabindex="0">{table}</div>')


def answer_text(effects: pd.DataFrame, points: Points | None = None) -> str:
    """Return the table of effects, or the shares of a sample, as JSON, for ``answer.json``.

    Infinite levels are "none", as in study files.
    """
    rows = effects.drop(columns="factor").to_dict("records")
    if points is not None and points.drawn:
        rows = [*points.shares()]
    claims = [
        _plain({**row, "parameter": WRITTEN.get(str(row["parameter"]), row["parameter"])})
        for row in rows
    ]
    return json.dumps(claims, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def _plain(value: object) -> object:
    """Return values as in JSON and study files."""
    if isinstance(value, dict):
        return {WRITTEN.get(key, key): _plain(inner) for key, inner in value.items()}
    if not isinstance(value, float):
        return value
    return None if math.isnan(value) else "none" if math.isinf(value) else float(value)


def build_report(
    plan: Plan,
    summary: xr.Dataset,
    folder: Path,
    *,
    sections: Iterable[Section] = (),
    tell: Callable[[str], None] = lambda _: None,
) -> tuple[str, str]:
    """Build the report of a study, one HTML page that loads no other file, and `answer_text`.

    The results `folder` holds the figures with their index, in ``figures``, and its ``cases``.
    `tell` takes every warning. Raises a `DataFileError` if a figure is missing, or if the summary
    belongs to another study or to an earlier state of the study of the plan.
    """
    check_belongs(summary, plan.study)
    points = Points.of(summary)
    effects = effects_table(points)
    matrix = build_matrix(points, effects)
    plots = {
        cell.curve: curve(points, effects, *cell.curve.split("/"))
        for _, rows in matrix.tables
        for row in rows
        for cell in row.cells
    }
    warnings = summary.attrs["warnings"].splitlines()
    for warning in few_of(warnings):
        tell(f"warning: {warning}")
    images = _images(folder / "figures")
    added = list(sections)
    placed = {name for section in added for name in section.figures}
    of_core = [image for image in images if image.name not in placed]
    shown = [image for start in _FIRST for image in of_core if image.name.startswith(start)]
    if (plot := explorer(summary)) is not None:
        plots["explorer"] = plot
    if points.drawn:
        history = history_of(summary)
        for result in headlines({*map(str, history)}):
            plots[f"{result}/cycles"] = courses(points, history, result)
    values = key_results(summary)
    templates = Environment(
        loader=PackageLoader("fretwear.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
    )
    html = templates.get_template("report.html.j2").render(
        study=plan.study,
        facts=_facts(plan, summary, points),
        warnings=warnings,
        undone=_undone(summary, folder),
        matrix=matrix,
        plots=Markup(json.dumps(plots, separators=(",", ":")).replace("</", "<\\/")),
        shown=shown,
        explorer=plot and [*plot["cases"]],
        plotly=Markup(plotly.offline.get_plotlyjs()) if plots else "",
        sections=added,
        images={image.name: image for image in images},
        rest=[image for image in of_core if image not in shown],
        cases=table_html(values[:_MOST_ROWS])
        if len(values) > 1
        else table_html(values.T.set_axis([""], axis=1), index=True),
        count=len(values),
        computation=_computation(plan, summary),
        text=plan.study.file.read_text(encoding="utf-8"),
    )
    return html, answer_text(effects, points)


def _facts(plan: Plan, summary: xr.Dataset, points: Points) -> list[str]:
    """Return the contents in a few words each: cases, cycles, errors of the key results."""
    cases, done = plan.study.cases().values(), len(points.table)
    count = point_values(summary, STATUS.name).size
    finished = str(count) if done == count else f"{done} of {count}"
    facts = [f"{finished} case{'s' * (count != 1)}"]
    facts.append(f"{span({case.cycles for case in cases}, cycle_text)} cycles")
    largest = []
    for name in headlines(points.results):
        values, error = points.results[name], points.results.get(f"{name}_error")
        if error is not None:
            kept = np.abs(values) > _TRACE * np.nanmax(np.abs(values), initial=0.0)
            shares = error[kept] / np.abs(values[kept])
            share = float(shares.max(initial=0.0, where=np.isfinite(shares)))
            largest.append((share, points.variables[name].words))
    share, words = max(largest, default=(0.0, ""))
    text = f"{words} ± {number_text(100.0 * share, 2)} %"
    return [*facts, f"largest error after the last cycle: {text}"] if words else facts


def _undone(summary: xr.Dataset, folder: Path) -> list[tuple[str, str, str]]:
    """Return the case id, the status and the reason of points without results."""
    reasons = failures(folder / "cases")
    ids, states = (point_values(summary, name).tolist() for name in (CASE_ID.name, STATUS.name))
    return [
        (case_id, PointStatus(state).word, reasons.get(case_id, ""))
        for case_id, state in zip(ids, states, strict=True)
        if state != PointStatus.DONE
    ]


def _computation(plan: Plan, summary: xr.Dataset) -> dict[str, str]:
    """Return how the cases were computed, and quantities that follow from their parameters."""
    cases = plan.study.cases().values()
    rows = {
        "Study": str(plan.study.file.name),
        "Computed with": str(summary.attrs.get("source", "")),
        "Slip model": ", ".join(sorted({case.slip_model.kind for case in cases})),
    }
    for name in ("cell_x", "cell_y", "tolerance", "hertz_radius", "hertz_pressure"):
        if name in summary.coords:
            values = np.asarray(summary[name].values, dtype=np.float64).ravel()
            text = span(values[np.isfinite(values)], partial(value_text, name))
            rows[axis_label(parameter(name).words, NO_UNIT)] = text
    return rows


def _images(folder: Path) -> list[Image]:
    """Return figures with their data; a bitmap replaces a vector file too large for a page."""
    path, images = folder / "index.json", []
    try:
        for entry in json.loads(path.read_bytes()):
            path, kind, share = folder / f"{entry['name']}.svg", "svg+xml", 1.0
            content = path.read_bytes()
            if width := re.search(rb'<svg[^>]*\swidth="(\d+(?:\.\d+)?)pt"', content[:2000]):
                share = round(min(1.0, float(width[1]) / _PAGE_WIDTH), 3)
            if (bitmap := path.with_suffix(".png")).exists():
                content, kind = bitmap.read_bytes(), "png"
            uri = f"data:image/{kind};base64,{base64.b64encode(content).decode('ascii')}"
            images.append(Image(entry["name"], entry["caption"], uri, share))
    except (OSError, ValueError) as cause:
        raise DataFileError(
            path, f"it cannot be read ({cause})", "Draw the figures again"
        ) from cause
    return images
