"""``fretwear show`` and ``fretwear compare``: parameters and key results as text and as JSON."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
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
from fretwear.results import (
    FORCES,
    RESULTS,
    SYMMETRIES,
    PointStatus,
    contact_frame,
    headlines,
)
from fretwear.units import cycle_text, in_unit, number_text, readable_unit, with_error

if TYPE_CHECKING:
    import xarray as xr

_MORE_RESULTS = "contact_half_width_x contact_half_width_y stick_half_width_x stick_half_width_y"
_MORE_RESULTS += " contact_area stick_area approach"
_MORE_RESULTS += " tangential_displacement plastic_volume central_pressure peak_pressure"
_MARK = "† In one cell or on one line; ± ∞: grows at the edge of a worn stick zone as cells narrow."
_UNWORN = "Unworn: closed forms for smooth elastic bodies (Hertz, Cattaneo and Mindlin)."
_BOTH = "Draw both cases superimposed into this file: .png, .svg or .pdf."
_LESS_ACCURATE = 0.02
_MOST_POINTS = 100
_KEY_RESULTS = 4  # of a point of a study: volume, depth, contact and stick zone
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

    from fretwear.data.atomic import DataFileError
    from fretwear.data.files import open_summary

    content: dict[str, Any] = {}
    with suppress(DataFileError), open_summary(file) as summary:
        if "study" in summary.attrs:
            content = study_content(summary)
            lines = [*study_lines(content)]
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
    forces = [name for given, names in FORCES.items() if given not in case.coords for name in names]
    results = {}
    names = dict.fromkeys((*headlines(case), *_MORE_RESULTS.split(), *forces))
    for name in (name for name in names if name in case):
        errors = case.get(RESULTS[name].error.name)
        results[name] = {
            "values": case[name].values.tolist(),
            "errors": None if errors is None else errors.values.tolist(),
            "units": case[name].attrs["units"],
        }
    return {
        **{name: case.attrs.get(name) for name in ("case_id", "code_digest", "title", "source")},
        "warnings": case.attrs.get("warnings", "").splitlines(),
        "cells": [case.sizes[axis] for axis in ("x", "y") if axis in case.sizes],
        "symmetry": case.attrs["symmetry"],
        "steps": history.sizes["step"] - 1,
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
    yield from dict.fromkeys([content["title"], content["case_id"], content["source"]])
    part = ("all", "half", "a quarter")[sum(SYMMETRIES[content["symmetry"]])]
    cells = " x ".join(map(str, content["cells"]))
    yield f"{cells} cells ({part} of the contact), {content['steps']} steps"
    yield from ("", "Parameters")
    about_case = content["parameters"]
    is_smooth = about_case.get("roughness_amplitude", {}).get("value") == 0.0
    shown = {n: v for n, v in about_case.items() if not (is_smooth and "roughness_slope" in n)}
    yield from aligned([_in_words(name, **about) for name, about in shown.items()])
    yield from ("", "Results")
    cycles, rows, loose = content["cycle"], [], []
    frame = contact_frame(content["results"])
    for name, result in content["results"].items():
        about, values = RESULTS[name].in_frame(frame), result["values"]
        errors = result["errors"] or [0.0] * len(values)
        ends = [values[0], values[-1], content["unworn"].get(name, math.nan)]
        rows.append((about.marked, *_texts(ends, about, [errors[0], errors[-1], 0.0])))
        pairs = zip(errors, values, strict=True)
        shares = [error / abs(v) if v and math.isfinite(error) else 0.0 for error, v in pairs]
        if about.is_headline and (largest := max(shares)) > _LESS_ACCURATE:
            cycle = cycle_text(cycles[shares.index(largest)])
            loose.append((about.words, f"± {number_text(100.0 * largest, 2)} %", f"cycle {cycle}"))
    yield from aligned([("", *(f"cycle {cycles[i]:.0f}" for i in (0, -1)), "unworn", ""), *rows])
    if loose:
        yield from ("", f"Less accurate than {100.0 * _LESS_ACCURATE:.0f} %, at the latest")
        yield from aligned(loose)
    if content["warnings"]:
        yield from ("", *content["warnings"])
    yield from ("", _MARK, _UNWORN)


def study_content(summary: xr.Dataset) -> dict[str, Any]:
    """Return the points and results of a merged study, in SI units."""
    from fretwear.data.effects import final_results, point_values, varied_names

    final, key = final_results(summary), headlines(summary)[:_KEY_RESULTS]
    names = [n for name in key for n in (name, RESULTS[name].error.name) if n in final]
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


def study_lines(content: dict[str, Any]) -> Iterator[str]:
    """Yield the lines that show a merged study."""
    points, units = content["points"], content["units"]
    yield content["title"]
    yield f"study {content['study']}, {content['source']}"
    counts = Counter(point["status"] for point in points)
    statuses = ", ".join(f"{counts[status.word]} {status.word}" for status in PointStatus)
    yield f"{len(points)} point{'s' * (len(points) != 1)}: {statuses}"
    yield from ("", f"After the last cycle, {content['cycle']:.0f}")
    shown = points[:_MOST_POINTS]
    columns = [["id", *(point["case_id"] for point in shown)]]
    for name in (name for name in units if not name.endswith("_error")):
        values = [point[name] for point in shown]
        if name in RESULTS:
            about = RESULTS[name].in_units(units[name])
            *texts, unit = _texts(values, about, [p.get(f"{name}_error", 0.0) for p in shown])
            columns.append([f"{about.words} ({unit})", *texts])
        else:
            columns.append([name, *(_in_words(name, value, units[name])[1] for value in values)])
    done = PointStatus.DONE.word
    columns.append(["", *(point["status"].replace(done, "") for point in shown)])
    yield from aligned([*zip(*columns, strict=True)])
    if len(points) > _MOST_POINTS:
        yield f"  and {len(points) - _MOST_POINTS} more points; --json prints all of them"
    yield from content["warnings"]


def comparison_lines(a: xr.Dataset, b: xr.Dataset) -> Iterator[str]:
    """Yield the lines that compare two cases, called A and B."""
    from fretwear.data.dataset import compared_cycles, compared_results, different_parameters

    rows: list[tuple[str, ...]] = [("", "A", "B")]
    for name in different_parameters(a, b):
        found = [case.coords.get(name) for case in (a, b)]
        words = [
            ("", "–") if value is None else _in_words(name, value.item(), **_about(value))
            for value in found
        ]
        rows.append((words[0][0] or words[1][0], words[0][1], words[1][1]))
    yield "Parameters that differ" if len(rows) > 1 else "All parameters are the same."
    yield from aligned(rows) if len(rows) > 1 else ()
    yield from ("", "Results")
    at = [f"cycle {cycle}" for cycle in compared_cycles(a, b)]
    rows = [("", f"A, {at[0]}", f"B, {at[1]}", "", "B/A")]
    for result in compared_results(a, b):
        texts = _texts([result.first, result.second], result.variable, [*result.errors])
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


def _about(value: xr.DataArray) -> dict[str, Any]:
    return {key: value.attrs.get(key) for key in ("units", "long_name")}


def _in_words(
    name: str, value: float | str | None, units: str | None = "", long_name: str | None = None
) -> tuple[str, str]:
    """Return the words of a parameter and its value as text."""
    from fretwear.study.parameters import parameter, value_text

    value = in_unit(math.inf if value is None else value, units or "")
    return long_name or parameter(name).in_frame_of(value).words, value_text(name, value)


def _texts(values: list[float], about: Any, errors: list[float]) -> list[str]:
    """Return values of a result with their errors as text in one readable unit, then the unit."""
    # A ratio has the unit, or none, that it has elsewhere.
    unit = about.unit if about.si_unit == "1" else None
    unit = unit or readable_unit(values, about.si_unit)
    pairs = zip(values, errors, strict=True)
    return [*(with_error(unit.of(v), unit.of(e or 0.0), _DIGITS) for v, e in pairs), unit.name]
