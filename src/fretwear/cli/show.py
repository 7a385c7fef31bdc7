"""``fretwear show`` and ``fretwear compare``: parameters and key results as text and as JSON."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fretwear.cli.common import (
    FIGURE_FORMATS,
    FirstFile,
    SecondFile,
    ShownFile,
    Status,
    aligned,
    check_output,
    check_results,
    failing_as,
)
from fretwear.units import (
    DIMENSIONS,
    NUMBER,
    format_quantity,
    number_text,
    readable_unit,
    smallest_unit,
    with_unit,
)
from fretwear.vocabulary import MAXIMUM_WEAR_DEPTH, RESULTS, PointStatus

if TYPE_CHECKING:
    import xarray as xr

_CASE_RESULTS = (
    "contact_half_width_x",
    "contact_half_width_y",
    "stick_half_width_x",
    "contact_area",
    "stick_area",
    "central_pressure",
    "peak_pressure",
    "approach",
    "tangential_displacement",
    "dissipated_energy",
    "wear_volume",
    "plastic_volume",
)
_STUDY_RESULTS = ("contact_half_width_x", "stick_half_width_x", "peak_pressure", "wear_volume")
_MOST_POINTS = 100
_DIGITS = 4


def show(
    file: ShownFile,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print JSON in SI units, for scripts.")
    ] = False,
) -> None:
    """Print the parameters of a case and its key results beside those of smooth elastic bodies.

    Of a merged study, print the key results of every point.
    """
    check_results(file)

    from fretwear.data.files import open_case, open_history, open_summary
    from fretwear.data.safe import DataFileError

    with failing_as(Status.WRONG_INPUT, DataFileError):
        if _is_summary(file):
            with open_summary(file) as summary:
                content = study_content(summary)
            lines = list(study_lines(content))
        else:
            with open_case(file) as case, open_history(file) as history:
                content = case_content(case, history)
                lines = list(case_lines(case, content))
    if as_json:
        lines = [json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False)]
    for line in lines:
        typer.echo(line)


def compare(
    first: FirstFile,
    second: SecondFile,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FIG.png",
            help="Draw both over each other, to this file: .png, .svg or .pdf.",
            show_default="no figure",
        ),
    ] = None,
) -> None:
    """Print the parameters in which two cases differ, and their key results with the ratios."""
    for file in (first, second):
        check_results(file)
    path = None if output is None else check_output(output, *FIGURE_FORMATS)

    from fretwear.data.files import open_case, open_history
    from fretwear.data.safe import DataFileError

    with (
        failing_as(Status.WRONG_INPUT, DataFileError),
        open_case(first) as a,
        open_case(second) as b,
        open_history(first) as history_a,
        open_history(second) as history_b,
    ):
        typer.echo(f"A  {first}\nB  {second}\n")
        for line in comparison_lines(a, b):
            typer.echo(line)
        if path is None:
            return
        from fretwear.figures import compare_cases, save_as

        figure = compare_cases({"A": a, "B": b}, {"A": history_a, "B": history_b})
    with failing_as(Status.FAILED, DataFileError):
        save_as(figure, path)
    typer.echo(f"\n{path}")


def case_content(case: xr.Dataset, history: xr.Dataset) -> dict[str, Any]:
    """Return what there is to tell of a case, in SI units; what is not finite is None.

    Parameters
    ----------
    case : xarray.Dataset
        The dataset of the case.
    history : xarray.Dataset
        Its dense history.
    """
    results = {name: case[name] for name in _CASE_RESULTS}
    results[MAXIMUM_WEAR_DEPTH.name] = case["wear_depth"].max(("x", "y"), keep_attrs=True)
    return {
        "case_id": case.attrs["case_id"],
        "title": case.attrs["title"],
        "source": case.attrs["source"],
        "cells": [case.sizes["x"], case.sizes["y"]],
        "symmetry": case.attrs["symmetry"],
        "steps": history.sizes["step"] - 1,
        "convolutions": int(history["convolutions"].sum()),
        "parameters": {
            str(value.name): {"value": _finite(value.item()), "units": value.attrs.get("units")}
            for value in _parameters(case)
        },
        "cycle": case["cycle"].values.tolist(),
        "results": {
            name: {
                "values": [_finite(value) for value in result.values.tolist()],
                "units": result.attrs["units"],
            }
            for name, result in results.items()
        },
        "unworn": _unworn(case),
    }


def case_lines(case: xr.Dataset, content: dict[str, Any]) -> Iterator[str]:
    """Yield the content of a case as lines for people."""
    yield content["title"]
    if content["case_id"] not in content["title"]:
        yield content["case_id"]
    yield content["source"]
    cells, part = content["cells"], "all" if content["symmetry"] == "none" else "a quarter"
    yield (
        f"{cells[0]} x {cells[1]} cells ({part} of the contact), {content['steps']} steps, "
        f"{content['convolutions']} convolutions"
    )
    yield ""
    yield "Parameters"
    yield from aligned(
        [
            (each.attrs["long_name"], _parameter_text(each.item(), each.attrs.get("units")))
            for each in _parameters(case)
        ]
    )
    yield ""
    yield "Results"
    rows = [("", *(f"cycle {content['cycle'][i]:.0f}" for i in (0, -1)), "unworn")]
    for name, result in content["results"].items():
        values = [result["values"][0], result["values"][-1], content["unworn"].get(name)]
        rows.append((RESULTS[name].words, *_texts(values, result["units"])))
    yield from aligned(rows)
    yield ""
    yield (
        "Unworn: closed forms for a smooth elastic sphere with these parameters "
        "(Hertz, Cattaneo and Mindlin)."
    )


def study_content(summary: xr.Dataset) -> dict[str, Any]:
    """Return what there is to tell of a merged study, in SI units; what is not finite is None."""
    import numpy as np

    status = summary["status"]

    def flat(values: xr.DataArray) -> list[Any]:
        return values.broadcast_like(status).transpose(*status.dims).values.ravel().tolist()

    def last_known(values: xr.DataArray) -> list[Any]:
        """Take the last value that is a number: cases may end at different cycles."""
        array = values.transpose(*status.dims, "cycle").values
        last = array.shape[-1] - 1 - np.argmax(np.isfinite(array)[..., ::-1], axis=-1)
        return np.take_along_axis(array, last[..., np.newaxis], axis=-1).ravel().tolist()

    varied = [
        str(name)
        for name, value in summary.coords.items()
        if value.dims and set(value.dims) <= set(status.dims) and name not in ("case_id", "point")
    ]
    columns = {
        "case_id": flat(summary["case_id"]),
        "status": [PointStatus(value).word for value in flat(status)],
        **{name: flat(summary[name]) for name in varied},
        **{name: last_known(summary[name]) for name in _STUDY_RESULTS},
    }
    units = {name: summary[name].attrs.get("units", "") for name in (*varied, *_STUDY_RESULTS)}
    return {
        "study": summary.attrs["study"],
        "title": summary.attrs["title"],
        "source": summary.attrs["source"],
        "cycle": float(summary["cycle"].max()),
        "units": units,
        "points": [
            dict(zip(columns, map(_finite, row), strict=True))
            for row in zip(*columns.values(), strict=True)
        ],
    }


def study_lines(content: dict[str, Any]) -> Iterator[str]:
    """Yield what there is to tell of a merged study as lines for people."""
    points, units = content["points"], content["units"]
    yield content["title"]
    yield f"study {content['study']}, {content['source']}"
    counts = Counter(point["status"] for point in points)
    told = ", ".join(f"{counts[status.word]} {status.word}" for status in PointStatus)
    yield f"{len(points)} point{'s' * (len(points) != 1)}: {told}"
    yield ""
    yield f"After the last cycle, {content['cycle']:.0f}"
    listed = points[:_MOST_POINTS]
    columns = [["id", *(point["case_id"] for point in listed)]]
    for name in units:
        values = [point[name] for point in listed]
        if name in _STUDY_RESULTS:
            texts = _texts(values, units[name])
            columns.append([RESULTS[name].words, *texts])
        else:
            columns.append([name, *(_parameter_text(value, units[name]) for value in values)])
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
        known = [case.coords.get(name) for case in (a, b)]
        attributes = next(each.attrs for each in known if each is not None)
        texts = (
            "-" if each is None else _parameter_text(each.item(), attributes.get("units"))
            for each in known
        )
        rows.append((attributes["long_name"], *texts))
    if len(rows) > 1:
        yield "Parameters that differ"
        yield from aligned(rows)
    else:
        yield "All parameters are the same."
    yield ""
    yield "Results"
    at = [f"cycle {cycle}" for cycle in compared_cycles(a, b)]
    rows = [("", f"A, {at[0]}", f"B, {at[1]}", "B/A")]
    for result in compared_results(a, b):
        values = _texts([result.first, result.second], result.variable.si_unit)
        ratio = f"{result.ratio:.3g}" if result.first else "-"
        rows.append((result.variable.words, *values, ratio))
    yield from aligned(rows)


def _is_summary(file: Path) -> bool:
    """Whether a file is that of a merged study; where it is damaged nobody knows."""
    from fretwear.data.files import damage

    # The library may crash on a file that is not whole: the checksum comes first.
    if damage(file, "file"):
        return False
    import netCDF4

    with netCDF4.Dataset(file) as content:
        return "study" in content.ncattrs()


def _unworn(dataset: xr.Dataset) -> dict[str, float]:
    """Return what closed forms say of the smooth elastic sphere with these parameters."""
    from fretwear.study.case import Case
    from fretwear.theory import CattaneoMindlin, HertzContact

    case = Case(**json.loads(dataset.attrs["parameters"]))
    hertz = HertzContact(case.radius, case.load, case.composite_modulus)
    sliding = CattaneoMindlin(hertz, case.friction, case.tangential_load, case.coupling)
    return {
        "contact_half_width_x": hertz.contact_radius,
        "contact_half_width_y": hertz.contact_radius,
        "stick_half_width_x": sliding.stick_radius,
        "contact_area": math.pi * hertz.contact_radius**2,
        "stick_area": math.pi * sliding.stick_radius**2,
        "central_pressure": hertz.peak_pressure,
        "peak_pressure": hertz.peak_pressure,
        "approach": hertz.approach,
        "tangential_displacement": sliding.tangential_displacement,
        "dissipated_energy": sliding.dissipated_energy,
    }


def _parameters(case: xr.Dataset) -> list[xr.DataArray]:
    return [value for value in case.coords.values() if value.ndim == 0]


def _parameter_text(value: float | str | None, units: str | None) -> str:
    """Write a parameter as a study file has it."""
    if value is None or isinstance(value, str):
        return value or "none"
    (dimension,) = (each for each in (*DIMENSIONS, NUMBER) if each.si_unit == units)
    return format_quantity(value, dimension, _DIGITS)


def _texts(values: Sequence[float | None], si_unit: str) -> list[str]:
    """Write results in one unit for people, so that they compare at sight."""
    common = readable_unit([value for value in values if value is not None], si_unit)
    # Nothing is no thousands of anything.
    of_zero = smallest_unit(si_unit) if common.is_power else common
    texts = []
    for value in values:
        unit = common if value else of_zero
        known = value is not None
        texts.append(with_unit(number_text(unit.of(value), _DIGITS), unit) if known else "-")
    return texts


def _finite(value: Any) -> Any:
    """Return a value for JSON, which knows no number that is not finite."""
    return None if isinstance(value, float) and not math.isfinite(value) else value
