"""The explorer's data, packed for the script of the page."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fretwear.figures.wording import MEGAPASCAL, MICROMETRE, Unit, parameter, readable_unit
from fretwear.report.explorer.chosen import chosen_points
from fretwear.report.explorer.packing import Packer
from fretwear.report.explorer.series import (
    HISTORY,
    PROFILES,
    SCALARS,
    CaseSeries,
    read_series,
    runs,
)
from fretwear.report.results import PointResult, labels_of
from fretwear.study.plan import Plan

_MOST_CASES = 300
_MOST_BYTES = 8_000_000
_PROFILE_BYTES = 2 * len(PROFILES)


@dataclass(frozen=True)
class Explorer:
    """The explorer of a study.

    Parameters
    ----------
    data : str
        What its script reads: `fretwear.report.explorer.packing.Packer.text`.
    note : str
        Which cases it holds, if not all; empty otherwise.
    """

    data: str
    note: str


def build_explorer(
    plan: Plan, results: Sequence[PointResult], cases: Path, *, most: int = _MOST_CASES
) -> Explorer | None:
    """Read the cases of a study and pack what can be explored of them.

    Parameters
    ----------
    plan : Plan
        The study's plan.
    results : sequence of PointResult
        What became of its points, in their order.
    cases : pathlib.Path
        Folder of the case files.
    most : int
        How many points it holds at most; fewer when their profiles are long.

    Returns
    -------
    Explorer or None
        None when no case is done.

    Raises
    ------
    CaseFileError
        When a case file is missing or damaged.
    """
    done = [place for place, result in enumerate(results) if result.done]
    if not done:
        return None
    places = chosen_points(plan, done, min(most, _affordable(plan)))
    ids = list(dict.fromkeys(results[place].id for place in places if results[place].done))
    series = [read_series(cases / f"{case_id}.nc") for case_id in ids]
    units = _units(series)
    packer = Packer()
    header = {
        "axes": _axes(plan, places),
        "points": [_point(plan, results[place], place, ids) for place in places],
        "cases": [_packed(one, units, packer) for one in series],
        "units": {name: unit.name for name, unit in units.items()},
        "start": _start(results, places),
    }
    return Explorer(packer.text(header), _note(len(places), len(results)))


def _affordable(plan: Plan) -> int:
    """Return how many cases fit into the page by the estimated length of their profiles."""
    lengths = [
        _PROFILE_BYTES * point.estimate.cells_x * len(point.case.output_cycles)
        for point in plan.points
        if point.case is not None and point.estimate is not None
    ]
    return max(1, int(_MOST_BYTES * len(lengths) / sum(lengths)))


def _note(held: int, points: int) -> str:
    if held == points:
        return ""
    return (
        f"Of the {points} points of the study this page holds {held}, chosen evenly; the profiles "
        "of all are in summary.nc."
    )


def _start(results: Sequence[PointResult], places: Sequence[int]) -> int:
    """Return the place in `places` of the case that has worn most: there is most to see."""
    volumes = [results[place].values.get("volume", -1.0) for place in places]
    return int(np.argmax(volumes))


def _axes(plan: Plan, places: Sequence[int]) -> list[dict[str, Any]]:
    """Return the varied parameters of a grid with the values that are there; else nothing."""
    if plan.study.design.kind != "grid":
        return []
    axes = []
    for position, axis in enumerate(plan.study.axes):
        levels = sorted({plan.points[place].point.index[position] for place in places})
        labels = labels_of(axis)
        axes.append(
            {
                "words": parameter(axis.coordinate).words,
                "levels": [[level, labels[level]] for level in levels],
            }
        )
    return axes


def _point(plan: Plan, result: PointResult, place: int, ids: Sequence[str]) -> dict[str, Any]:
    return {
        "number": result.number,
        "index": list(plan.points[place].point.index),
        "title": result.title,
        "status": result.status,
        "reason": result.reason,
        "case": ids.index(result.id) if result.done else -1,
    }


def _units(series: Sequence[CaseSeries]) -> dict[str, Unit]:
    def fitting(name: str, base: str) -> Unit:
        return readable_unit(_all(one.scalars[name] for one in series), base)

    depth = fitting("deepest", "m")
    return {
        "x": MICROMETRE,
        "pressure": MEGAPASCAL,
        "shear": MEGAPASCAL,
        "gap": depth,
        "wear": depth,
        "deepest": depth,
        "contact": MICROMETRE,
        "stick": MICROMETRE,
        "peak": MEGAPASCAL,
        "central": MEGAPASCAL,
        "volume": fitting("volume", "m3"),
        "energy": fitting("energy", "J"),
    }


def _all(values: Iterable[Any]) -> Any:
    return np.concatenate([np.ravel(one) for one in values])


def _packed(one: CaseSeries, units: dict[str, Unit], packer: Packer) -> dict[str, Any]:
    """Pack the arrays of a case; return where they are and what is short enough for the header."""
    spacing = float(one.x[1] - one.x[0]) if one.x.size > 1 else 2.0 * float(one.x[0])
    return {
        "id": one.id,
        "friction": one.friction,
        "x": [float(MICROMETRE.of(one.x[0])), float(MICROMETRE.of(spacing)), one.x.size],
        "cycles": one.cycles.tolist(),
        "states": [runs(row) for row in one.states],
        "profiles": {
            name: packer.add_rounded(units[name].of(values))
            for name, values in one.profiles.items()
        },
        "scalars": {
            name: _short(units[name].of(one.scalars[name])) for name in (*SCALARS, "deepest")
        },
        "steps": {
            "number": one.steps.size,
            "cycle": packer.add_floats(one.steps),
            **{name: packer.add_floats(units[name].of(one.history[name])) for name in HISTORY},
        },
    }


def _short(values: Any) -> list[float]:
    return [float(f"{value:.6g}") for value in values]
