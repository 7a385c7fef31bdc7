"""``fretwear show`` and ``fretwear compare``: parameters and key results as text and as JSON."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import chain, zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fretwear.cli.common import (
    FIGURE_FORMATS,
    aligned,
    argument,
    check_output,
    check_results,
    finite,
    opened,
    option,
    say,
)
from fretwear.units import in_unit, number_text, readable_unit, with_error
from fretwear.vocabulary import FORCES, HEADLINES, RESULTS, SYMMETRIES, PointStatus, Variable

if TYPE_CHECKING:
    import xarray as xr

_MORE_RESULTS = "contact_half_width_y stick_half_width_y contact_area stick_area approach"
_MORE_RESULTS += " tangential_displacement plastic_volume central_pressure peak_pressure"
_CASE_RESULTS = (*HEADLINES, *_MORE_RESULTS.split())
_STUDY_RESULTS = {name: RESULTS[name].error.name for name in HEADLINES[:4]}  # with their errors
_MARK = "† In a single cell; ± ∞: at the edge of a worn stick zone it grows as cells get narrower."
_UNWORN = (
    "Unworn: closed forms for smooth elastic bodies with these parameters "
    "(Hertz, Cattaneo and Mindlin)."
)
_BOTH = "Draw both cases superimposed into this file: .png, .svg or .pdf."
_MOST_POINTS = 100
_DIGITS = 4


def show(
    file: Annotated[Path, argument("OUT.nc", "Case file, or summary.nc of a study.")],
    as_json: Annotated[
        bool, typer.Option("--json", help="Print JSON in SI units, for scripts.")
    ] = False,
) -> None:
    """Print the parameters and key results of a case, beside closed forms of smooth elastic bodies.

    For a merged study, print the key results of every point.
    """
    check_results(file)

    from fretwear.data.files import open_summary
    from fretwear.data.safe import DataFileError

    content: dict[str, object] = {}
    with suppress(DataFileError), open_summary(file) as summary:
        if "study" in summary.attrs:
            content = study_content(summary)
            lines = [*describe_study(content)]
    if not content:  # a case, or a file whose problem `opened` reports
        with opened(file) as (case, history):
            content = case_content(case, history)
            lines = [*case_lines(content)]
    if as_json:
        lines = [json.dumps(finite(content), indent=2, ensure_ascii=False, allow_nan=False)]
    for line in lines:
        say(line if as_json else line.replace("\n", "\\n"))


def compare(
    first: Annotated[Path, argument("A.nc", "Case file (netCDF).")],
    second: Annotated[Path, argument("B.nc", "Case file to compare it with.")],
    output: Annotated[Path | None, option("-o/--output", "FIG.png", _BOTH, "no figure")] = None,
) -> None:
    """Print the parameters in which two cases differ, and their key results with the ratios."""
    path = None if output is None else check_output(output, *FIGURE_FORMATS)
    with opened(first) as (a, history_a), opened(second) as (b, history_b):
        say(f"A  {first}\nB  {second}\n")
        for line in comparison_lines(a, b):
            say(line.replace("\n", "\\n"))
        if path is not None:
            from fretwear.figures import compare_cases, save_as

            figure = compare_cases({"A": a, "B": b}, {"A": history_a, "B": history_b})
            save_as(figure, path)
            say(f"\n{path}")


def case_content(case: xr.Dataset, history: xr.Dataset) -> dict[str, Any]:
    """Return the parameters and results of a case, in SI units."""
    forces = (results for given, results in FORCES.items() if given not in case.coords)
    results = {}
    for name in (name for name in (*_CASE_RESULTS, *chain(*forces)) if name in case):
        error, units = RESULTS[name].error.name, case[name].attrs["units"]
        errors = case[error].values.tolist() if error in case else None
        results[name] = {"values": case[name].values.tolist(), "errors": errors, "units": units}
    return {
        **{name: case.attrs.get(name) for name in ("case_id", "code_digest", "title", "source")},
        "warnings": case.attrs.get("warnings", "").splitlines(),
        "cells": [case.sizes[axis] for axis in ("x", "y") if axis in case.sizes],
        "symmetry": case.attrs["symmetry"],
        "steps": history.sizes["step"] - 1,
        "convolutions": int(history["convolutions"].sum()) if "convolutions" in history else None,
        "parameters": {
            str(value.name): {"value": value.item()}
            | {about: value.attrs.get(about) for about in ("units", "long_name")}
            for value in case.coords.values()
            if value.ndim == 0
        },
        "cycle": case["cycle"].values.tolist(),
        "results": results,
        "unworn": _unworn(case),
    }


def case_lines(content: dict[str, Any]) -> Iterator[str]:
    """Yield the content of a case as lines for people."""
    yield content["title"]
    if content["case_id"] not in content["title"]:
        yield content["case_id"]
    yield content["source"]
    part = ("all", "half", "a quarter")[sum(SYMMETRIES[content["symmetry"]])]
    taken = ""
    if content["convolutions"] is not None:  # A file saved by another program lacks it.
        taken = f", {content['steps']} steps, {content['convolutions']} convolutions"
    yield f"{' x '.join(map(str, content['cells']))} cells ({part} of the contact){taken}"
    yield from (f"Doubtful: {warning}" for warning in content["warnings"])
    yield from ("", "Parameters")
    shown = dict(content["parameters"])
    if shown.get("roughness_amplitude", {}).get("value") == 0.0:  # slopes are then meaningless
        shown = {name: shown[name] for name in shown if not name.startswith("roughness_slope")}
    yield from aligned([_in_words(name, *about.values()) for name, about in shown.items()])
    yield from ("", "Results")
    rows = [("", *(f"cycle {content['cycle'][i]:.0f}" for i in (0, -1)), "unworn", "")]
    for name, result in content["results"].items():
        values = [result["values"][0], result["values"][-1], content["unworn"].get(name)]
        errors = result["errors"] or [None]
        about = RESULTS[name].in_units(result["units"])
        rows.append((about.marked, *_texts(values, about, [errors[0], errors[-1]])))
    yield from aligned(rows)
    yield from ("", _MARK, _UNWORN)


def study_content(summary: xr.Dataset) -> dict[str, Any]:
    """Return the points and results of a merged study, in SI units."""
    from fretwear.data.effects import final_results, point_values, varied_names

    final = final_results(summary)
    names = [*_STUDY_RESULTS, *(name for name in _STUDY_RESULTS.values() if name in final)]
    columns = {
        "case_id": point_values(summary, "case_id").tolist(),
        "status": [PointStatus(state).word for state in point_values(summary, "status")],
        **{name: point_values(summary, name).tolist() for name in varied_names(summary)},
        **{name: final[name].ravel().tolist() for name in names},
    }
    points = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
    return {
        **{name: summary.attrs[name] for name in ("study", "title", "source")},
        "warnings": summary.attrs.get("warnings", "").splitlines(),
        "cycle": float(summary["cycle"].max()),
        "units": {name: summary[name].attrs.get("units", "") for name in [*columns][2:]},
        "points": points,
    }


def describe_study(content: dict[str, Any]) -> Iterator[str]:
    """Yield the lines that show a merged study."""
    points, units = content["points"], content["units"]
    yield content["title"]
    yield f"study {content['study']}, {content['source']}"
    yield from (f"Doubtful: {warning}" for warning in content["warnings"])
    counts = Counter(point["status"] for point in points)
    statuses = ", ".join(f"{counts[status.word]} {status.word}" for status in PointStatus)
    yield f"{len(points)} point{'s' * (len(points) != 1)}: {statuses}"
    yield from ("", f"After the last cycle, {content['cycle']:.0f}")
    listed = points[:_MOST_POINTS]
    columns = [["id", *(point["case_id"] for point in listed)]]
    for name in (name for name in units if name not in _STUDY_RESULTS.values()):
        values = [point[name] for point in listed]
        if name in _STUDY_RESULTS:
            about = RESULTS[name].in_units(units[name])
            errors = [point.get(_STUDY_RESULTS[name]) for point in listed]
            *texts, unit = _texts(values, about, errors)
            columns.append([f"{about.words} ({unit})", *texts])
        else:
            columns.append([name, *(_in_words(name, value, units[name])[1] for value in values)])
    states = [point["status"] for point in listed]
    columns.append(["", *("" if state == PointStatus.DONE.word else state for state in states)])
    yield from aligned(list(zip(*columns, strict=True)))
    if len(points) > _MOST_POINTS:
        yield f"  and {len(points) - _MOST_POINTS} more points; --json prints all of them"


def comparison_lines(a: xr.Dataset, b: xr.Dataset) -> Iterator[str]:
    """Yield the lines that compare two cases, called A and B."""
    from fretwear.data.dataset import compared_cycles, compared_results, different_parameters

    rows: list[tuple[str, ...]] = [("", "A", "B")]
    for name in different_parameters(a, b):
        texts = ["–", "–"]
        for place, case in reversed([*enumerate((a, b))]):
            if name in case.coords:
                value = case[name]
                about = (value.attrs.get(key) for key in ("units", "long_name"))
                words, texts[place] = _in_words(name, value.item(), *about)
        rows.append((words, *texts))
    yield "Parameters that differ" if len(rows) > 1 else "All parameters are the same."
    yield from aligned(rows) if len(rows) > 1 else ()
    yield from ("", "Results")
    at = [f"cycle {cycle}" for cycle in compared_cycles(a, b)]
    rows = [("", f"A, {at[0]}", f"B, {at[1]}", "", "B/A")]
    for result in compared_results(a, b):
        texts = _texts((result.first, result.second), result.variable, result.errors)
        ratio = number_text(result.ratio, 3) if math.isfinite(result.ratio) else "–"
        rows.append((result.variable.marked, *texts, ratio))
    yield from aligned(rows)
    yield from ("", _MARK)


def _unworn(dataset: xr.Dataset) -> dict[str, float]:
    """Return the closed forms of a dataset's case; none if it is of another version."""
    from fretwear.study.unworn import unworn

    with suppress(TypeError, ValueError):
        return unworn(dataset.fretwear.case)
    return {}


def _in_words(
    name: str, value: float | str | None, units: str | None = "", long_name: str | None = None
) -> tuple[str, str]:
    """Return the words of a parameter and its value as text."""
    from fretwear.study.parameters import parameter, value_text

    value = in_unit(math.inf if value is None else value, units or "")
    return long_name or parameter(name).suiting(value).words, value_text(name, value)


def _texts(
    values: Sequence[float | None], about: Variable, errors: Sequence[float | None]
) -> list[str]:
    """Return values of a result with their errors as text in one readable unit, then the unit."""
    present = [value for value in values if value is not None]
    # A ratio has the unit, or none, that it has elsewhere.
    usual = about.unit if about.si_unit == "1" else None
    unit = usual or readable_unit(present, about.si_unit)
    texts = [
        "–" if value is None else with_error(unit.of(value), unit.of(error or 0.0), _DIGITS)
        for value, error in zip_longest(values, errors)
    ]
    return [*texts, unit.name]
