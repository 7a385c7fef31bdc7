"""The explorer's data: which cases it holds, and their curves packed for its script."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from fretwear.report.above import MAPS
from fretwear.report.cases import HISTORY, PROFILES, READOUT, Array, CaseRecord
from fretwear.report.page import compressed
from fretwear.report.results import PointResult, levels_of, variable_of
from fretwear.study.parameters import parameter
from fretwear.study.plan import Plan
from fretwear.units import MICROMETRE, Unit, readable_unit
from fretwear.vocabulary import CYCLE, RESULTS, ContactState, X, Y

_MOST_CASES, _FEW_OF_MANY = 200, 100
_MOST_VALUES = 4_000_000
_MOST_STEPS = 400
_LEVELS = 10_000
_PANELS = (("contact_half_width_x", "stick_half_width_x"), ("wear_volume",))


class Explorer(NamedTuple):
    """What the script of the explorer reads, and a note on the cases it holds if not all."""

    data: str
    note: str


def held_points(plan: Plan, results: Sequence[PointResult], most: int = 0) -> list[int]:
    """Select points that span the study evenly and whose profiles are not too long together.

    A grid stays one: its axes are thinned, the longest first, and keep their ends, so that every
    combination of the remaining values is there.

    Parameters
    ----------
    plan : Plan
        The study's plan.
    results : sequence of PointResult
        What became of its points, in their order.
    most : int
        How many points at most; 0: all of up to 200 points, 100 of more.

    Returns
    -------
    list of int
        Positions in ``plan.points``, increasing; at least one that is done, if there is one.
    """
    lengths = [
        len(PROFILES) * point.estimate.cells_x * len(point.case.output_cycles)
        for point in plan.points
        if point.case is not None and point.estimate is not None
    ]
    count = len(plan.points)
    most = most or (_MOST_CASES if count <= _MOST_CASES else _FEW_OF_MANY)
    most = min(most, max(1, int(_MOST_VALUES * len(lengths) / sum(lengths))))
    if plan.study.design.kind == "grid" and count > most:
        kept = set(product(*thinned_levels([len(axis.values) for axis in plan.study.axes], most)))
        places = [place for place, planned in enumerate(plan.points) if planned.index in kept]
    else:
        places = evenly(count, most)
    done = [place for place, result in enumerate(results) if result.done]
    if done and not set(done).intersection(places):
        return [done[place] for place in evenly(len(done), most)]
    return places


def thinned_levels(lengths: Sequence[int], most: int) -> list[list[int]]:
    """Return levels of every axis of a grid with at most `most` combinations."""
    kept = list(lengths)
    while math.prod(kept) > most and max(kept) > 1:
        kept[kept.index(max(kept))] -= 1
    return [evenly(length, number) for length, number in zip(lengths, kept, strict=True)]


def evenly(count: int, most: int) -> list[int]:
    """Return at most `most` of the places 0 to `count` − 1, evenly spread, with both ends."""
    return [int(place) for place in np.rint(np.linspace(0, count - 1, min(count, most)))]


def build_explorer(
    plan: Plan,
    results: Sequence[PointResult],
    places: Sequence[int],
    records: Mapping[str, CaseRecord],
) -> Explorer | None:
    """Pack what can be explored of a study.

    Parameters
    ----------
    plan : Plan
        The study's plan.
    results : sequence of PointResult
        What became of its points, in their order.
    places : sequence of int
        The points it holds, from `held_points`.
    records : mapping of str to CaseRecord
        Their cases, by id.

    Returns
    -------
    Explorer or None
        None when no case is done.
    """
    if not records:
        return None
    ids = list(records)
    units = _units(list(records.values()), results)
    height = readable_unit(
        np.concatenate([np.zeros(1), *(h for r in records.values() for h in r.heights or ())]), "m"
    )
    held = [results[place] for place in places]
    header = {
        "words": _words(units, height, results),
        "states": {state.name.lower(): state.value for state in ContactState},
        "profiles": PROFILES,
        "readout": READOUT,
        "histories": _histories(units),
        "axes": _axes(plan, places),
        "points": [
            {
                "number": result.number,
                "index": plan.points[place].index,
                "title": result.title,
                "status": result.status.word,
                "reason": result.reason,
                "case": ids.index(result.id) if result.done else -1,
            }
            for place, result in zip(places, held, strict=True)
        ],
        "maps": MAPS,
        "cases": [_packed(record, units, height) for record in records.values()],
        # There is most to see in the case with the largest wear.
        "start": int(np.argmax([r.values.get("wear_volume", -1.0) for r in held])),
    }
    note = (
        f"This page holds {len(held)} of the {len(results)} points of the study, evenly spread; "
        "summary.nc has the profiles of all."
    )
    text = json.dumps(header, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    data = compressed(text.encode("utf-8"))
    return Explorer(data, note if len(held) < len(results) else "")


def _axes(plan: Plan, places: Sequence[int]) -> list[dict[str, Any]]:
    """Return the varied parameters of a grid with the values that are held; else nothing."""
    axes = []
    for position, axis in enumerate(plan.study.axes if plan.study.design.kind == "grid" else ()):
        levels = sorted({plan.points[place].index[position] for place in places})
        texts = [level.label for level in levels_of(axis)]
        words = parameter(axis.coordinate).words
        axes.append({"words": words, "levels": [[level, texts[level]] for level in levels]})
    return axes


def _units(records: Sequence[CaseRecord], results: Sequence[PointResult]) -> dict[str, Unit]:
    """Return the unit of every result, one for all cases; depths and gaps have the same."""

    def fitting(name: str) -> Unit:
        values = np.concatenate([record.numbers[name] for record in records])
        return readable_unit(values, variable_of(name, results).si_unit)

    depths = ("gap", "wear_depth", "maximum_wear_depth")
    depth = fitting("maximum_wear_depth")
    return {
        name: depth if name in depths else variable_of(name, results).unit or fitting(name)
        for name in (*PROFILES, *READOUT)
    }


def _words(
    units: Mapping[str, Unit], height: Unit, results: Sequence[PointResult]
) -> dict[str, dict[str, str]]:
    """Return words, label and unit of all that is shown, by name."""

    def told(words: str, label: str, unit: str) -> dict[str, str]:
        return {"words": words, "label": f"{label} ({unit})" if unit else label, "unit": unit}

    shown = {name: variable_of(name, results) for name in units}
    return {
        **{axis.name: told(axis.words, axis.name, MICROMETRE.name) for axis in (X, Y)},
        CYCLE.name: told(CYCLE.words, CYCLE.label, ""),
        "height": told("height", "Height", height.name),
        "bearing_area": told("bearing area", "Bearing area", "% of the contact"),
        **{n: told(v.words, v.label, units[n].name) for n, v in shown.items()},
    }


def _histories(units: Mapping[str, Unit]) -> list[dict[str, Any]]:
    """Return the panels over the cycles: the label of each and the names of its curves."""
    panels = []
    for names in _PANELS:
        # The curves of a panel differ in their first word: contact and stick half-width.
        texts, common = zip(*(RESULTS[name].words.split(maxsplit=1) for name in names), strict=True)
        label = common[0].capitalize() if len(names) > 1 else RESULTS[names[0]].label
        curves = [{"name": name, "text": text} for name, text in zip(names, texts, strict=True)]
        panels.append({"label": f"{label} ({units[names[0]].name})", "curves": curves})
    return panels


def _packed(record: CaseRecord, units: Mapping[str, Unit], height: Unit) -> dict[str, Any]:
    """Return a case as JSON has it, in the units shown and with the digits needed."""
    x = MICROMETRE.of(record.x)
    spacing = float(x[1] - x[0]) if x.size > 1 else 2.0 * float(x[0])
    steps = evenly(record.history[CYCLE.name].size, _MOST_STEPS)
    return {
        "id": record.id,
        "friction": None if record.friction_changes else record.parameters["friction"],
        "x": [float(x[0]), spacing, x.size],
        "cycles": record.cycles.tolist(),
        "states": [run_lengths(row) for row in record.states],
        "view": record.view and record.view.packed(units),
        "heights": record.heights and [_short(height.of(each)) for each in record.heights],
        "profiles": {
            name: [differences(units[name].of(row)) for row in rows]
            for name, rows in record.profiles.items()
        },
        "numbers": {name: _short(units[name].of(record.numbers[name])) for name in READOUT},
        "history": {
            CYCLE.name: _short(record.history[CYCLE.name][steps]),
            **{name: _short(units[name].of(record.history[name][steps])) for name in HISTORY},
        },
    }


def _short(values: Array) -> list[float]:
    return [float(f"{value:.7g}") for value in values]


def run_lengths(states: Array) -> list[int]:
    """Return a row of states as pairs: a state, and for how many cells it lasts."""
    edges = np.flatnonzero(np.diff(states)) + 1
    starts, ends = np.r_[0, edges], np.r_[edges, states.size]
    pairs = zip(states[starts], ends - starts, strict=True)
    return [int(number) for pair in pairs for number in pair]


def differences(row: Array) -> dict[str, Any]:
    """Round a row to a 10 000th of its largest value; neighbours differ by small integers then.

    Parameters
    ----------
    row : array of shape (n,)
        The values; NaN where there is none.

    Returns
    -------
    dict
        ``scale`` and ``steps``: a value is `scale` times the sum of all steps up to its own,
        which is None where there is no value.
    """
    known = np.isfinite(row)
    scale = float(np.abs(row[known]).max(initial=0.0)) / _LEVELS
    steps = np.full(row.shape, None)
    steps[known] = np.diff(np.rint(row[known] / (scale or 1.0)), prepend=0.0).astype(int)
    return {"scale": scale, "steps": steps.tolist()}
