"""The explorer's data: which cases it holds, and their curves packed for its script."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from itertools import chain, product
from pathlib import Path
from typing import Any, NamedTuple

import netCDF4
import numpy as np
from numpy.typing import NDArray

from fretwear.data.files import HISTORY_GROUP, opened_summary
from fretwear.data.merge import PROFILES as MERGED
from fretwear.data.merge import StudyLayout
from fretwear.data.stack import representative_cycles
from fretwear.report.above import MAPS, MOST_SQUARES, Above
from fretwear.report.page import compressed
from fretwear.report.results import PointResult, display_units, levels_of, variable_of
from fretwear.study.case import Case
from fretwear.study.parameters import parameter
from fretwear.study.plan import Plan
from fretwear.units import MICROMETRE, Unit, readable_unit
from fretwear.vocabulary import CYCLE, HEADLINES, RESULTS, ContactState, X, Y

Array = NDArray[np.float64]

PROFILES = ("pressure", "shear_traction", "gap", "wear_depth")
"""Fields along x, a panel of the explorer each."""

_MOST_CASES = 200
_MOST_SNAPSHOTS = 60
_MOST_STEPS = 400
_MOST_VALUES = 4_000_000
_BEYOND_CONTACT = 1.3
_LEVELS = 10_000
_PANELS = (("contact_half_width_x", "stick_half_width_x"), ("wear_volume",))
_STEPPED = (CYCLE.name, *chain(*_PANELS))
_NAMES = {field.name: name for name, field in MERGED.items()}


class Explorer(NamedTuple):
    """What the script of the explorer reads, and a note on the cases it holds if not all."""

    data: str
    note: str


class Curves(NamedTuple):
    """One case along x on the line nearest y = 0, and over the cycles; SI units."""

    x: Array  # shape (n,): positions, to a little beyond the largest contact
    cycles: Array  # shape (k,): snapshots; of more than 60, representative ones
    profiles: Mapping[str, Array]  # shape (k, n): the fields of `PROFILES`
    states: NDArray[np.int8]  # shape (k, n): state of the contact
    numbers: Mapping[str, Array]  # shape (k,): the `HEADLINES` at every snapshot
    history: Mapping[str, Array]  # at every step: ``cycle``, half-widths and wear volume
    friction: float | None  # its coefficient, where it is the same in all cycles


def read_curves(path: Path, plan: Plan, places: Sequence[int]) -> dict[str, Curves]:
    """Read the curves of some points of a merged study, by the ids of their cases.

    Raises
    ------
    DataFileError
        When the file is missing or damaged.
    """
    positions = [position for position, _ in StudyLayout(plan.study).points()]
    points = {plan.points[place].id: place for place in places}
    with opened_summary(path) as file:
        numbers = {name: file[name][...] for name in HEADLINES}
        return {
            case_id: _curves(file, positions[place], numbers, plan.points[place].case)
            for case_id, place in points.items()
        }


def _curves(
    file: netCDF4.Dataset, position: tuple[int, ...], every: Mapping[str, Array], case: Case | None
) -> Curves:
    assert case is not None
    numbers = {name: values[position] for name, values in every.items()}
    snapshots = np.flatnonzero(np.isfinite(list(numbers.values())).all(axis=0))
    cycles, x = file[CYCLE.name][...], file[X.name][...]
    kept = representative_cycles(cycles[snapshots].tolist(), _MOST_SNAPSHOTS)
    snapshots = np.searchsorted(cycles, kept)
    numbers = {name: values[snapshots] for name, values in numbers.items()}
    reach = _BEYOND_CONTACT * float(numbers["contact_half_width_x"].max())
    # Outside the window of the case the gap is not known.
    is_stored = np.isfinite(file[_NAMES["gap"]][position][snapshots[-1]])
    inside = np.flatnonzero(is_stored & (np.abs(x) <= max(reach, 2.0 * float(np.abs(x).min()))))

    def profile(field: str) -> NDArray[Any]:
        return np.asarray(file[_NAMES[field]][position][np.ix_(snapshots, inside)])

    group = file[HISTORY_GROUP]
    history = {name: group[name][position] for name in _STEPPED}
    taken = np.isfinite(list(history.values())).all(axis=0)
    return Curves(
        x=x[inside],
        cycles=cycles[snapshots],
        profiles={name: profile(name).astype(np.float64) for name in PROFILES},
        states=profile("contact_state"),
        numbers=numbers,
        history={name: values[taken] for name, values in history.items()},
        friction=case.friction if isinstance(case.friction, float) and not case.blocks else None,
    )


def held_points(plan: Plan, results: Sequence[PointResult], most: int = _MOST_CASES) -> list[int]:
    """Select points that span the study evenly and whose profiles are not too long together.

    They are increasing positions in ``plan.points``, at least one of a point that is done. A grid
    stays one: its axes are thinned, the longest first, and keep their ends, so that every
    combination of the remaining values is there.
    """
    count = len(plan.points)
    lengths = [
        (len(PROFILES) * point.estimate.cells_x + (0 if all(point.case.even) else MOST_SQUARES))
        * len(point.case.output_cycles)
        for point in (plan.points[place] for place in evenly(count, _MOST_CASES))
        if point.case is not None and point.estimate is not None
    ]
    if lengths:
        most = min(most, max(1, _MOST_VALUES * len(lengths) // max(1, sum(lengths))))
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
    curves: Mapping[str, Curves],
    above: Mapping[str, Above],
) -> Explorer | None:
    """Pack what can be explored of a study; None when no case is done.

    These are the points at the `places` from `held_points`, with curves and surfaces by case id
    from `read_curves` and `read_above`.
    """
    if not curves:
        return None
    ids = list(curves)
    units = display_units(results)
    # Depths and gaps are compared by eye.
    units |= dict.fromkeys(("gap", "wear_depth"), units["maximum_wear_depth"])
    units |= {name: RESULTS[name].unit or units[name] for name in PROFILES}
    heights = [each for one in above.values() for each in one.heights or ()]
    height = readable_unit(np.concatenate([np.zeros(1), *heights]), "m")
    held, axes = [results[place] for place in places], _axes(plan, places)
    header = {
        "words": _words(units, height, results),
        "states": {state.name.lower(): state.value for state in ContactState},
        "profiles": PROFILES,
        "readout": HEADLINES,
        "histories": _histories(units, results),
        "axes": axes
        or [{"words": "point", "levels": [(r.number, f"{r.number}: {r.title}") for r in held]}],
        "points": [
            {
                "number": result.number,
                "index": plan.points[place].index if axes else [result.number],
                "title": result.title,
                "status": result.status.word,
                "reason": result.reason,
                "case": ids.index(result.id) if result.done else -1,
            }
            for place, result in zip(places, held, strict=True)
        ],
        "maps": MAPS,
        "cases": [
            {"id": case_id, **_packed(each, above[case_id], units, height)}
            for case_id, each in curves.items()
        ],
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


def _histories(units: Mapping[str, Unit], results: Sequence[PointResult]) -> list[dict[str, Any]]:
    """Return the panels over the cycles: the label of each and the names of its curves."""
    panels = []
    for names in _PANELS:
        # The curves of a panel differ in their first word: contact and stick half-width.
        texts, common = zip(*(RESULTS[name].words.split(maxsplit=1) for name in names), strict=True)
        label = common[0].capitalize() if len(names) > 1 else variable_of(names[0], results).label
        curves = [{"name": name, "text": text} for name, text in zip(names, texts, strict=True)]
        panels.append({"label": f"{label} ({units[names[0]].name})", "curves": curves})
    return panels


def _packed(
    curves: Curves, above: Above, units: Mapping[str, Unit], height: Unit
) -> dict[str, Any]:
    """Return a case as JSON has it, in the units shown and with the digits needed."""
    x = MICROMETRE.of(curves.x)
    spacing = float(x[1] - x[0]) if x.size > 1 else 2.0 * float(x[0])
    steps = evenly(curves.history[CYCLE.name].size, _MOST_STEPS)

    def short(unit: Unit | None, values: Array) -> list[float]:
        shown = unit.of(values) if unit else values
        return [float(f"{value:.7g}") for value in shown.tolist()]

    return {
        "friction": curves.friction,
        "x": [float(x[0]), spacing, x.size],
        "cycles": curves.cycles.tolist(),
        "states": [run_lengths(row) for row in curves.states],
        "profiles": {
            name: [differences(units[name].of(row)) for row in rows]
            for name, rows in curves.profiles.items()
        },
        "numbers": {name: short(units[name], values) for name, values in curves.numbers.items()},
        "history": {n: short(units.get(n), each[steps]) for n, each in curves.history.items()},
        "view": above.view and above.view.packed(units),
        "heights": above.heights and [short(height, each) for each in above.heights],
    }


def run_lengths(states: Array) -> list[int]:
    """Return a row of states as pairs: a state, and for how many cells it lasts."""
    edges = np.flatnonzero(np.diff(states)) + 1
    starts, ends = np.r_[0, edges], np.r_[edges, states.size]
    pairs = zip(states[starts], ends - starts, strict=True)
    return [int(number) for pair in pairs for number in pair]


def differences(row: Array) -> dict[str, Any]:
    """Round a row to a 10 000th of its largest value; neighbours differ by small integers then.

    A value is ``scale`` times the sum of all ``steps`` up to its own, None where it is NaN.
    """
    known = np.isfinite(row)
    scale = float(np.abs(row[known]).max(initial=0.0)) / _LEVELS
    steps = np.full(row.shape, None)
    steps[known] = np.diff(np.rint(row[known] / (scale or 1.0)), prepend=0.0).astype(int)
    return {"scale": scale, "steps": steps.tolist()}
