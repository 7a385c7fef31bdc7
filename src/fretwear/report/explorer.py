"""The data of the explorer: the cases it holds, with the curves and maps that its script draws."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from itertools import chain, product
from pathlib import Path
from typing import Any, NamedTuple

import netCDF4
import numpy as np
from numpy.typing import NDArray

from fretwear.arrays import Array
from fretwear.data.files import HISTORY_GROUP, MERGED_PROFILES, opened_case, opened_summary
from fretwear.data.stack import representative_cycles
from fretwear.report.page import compressed
from fretwear.report.results import PointResult, display_units, levels_of, result_variable
from fretwear.study.case import Case
from fretwear.study.parameters import parameter
from fretwear.study.plan import Plan, estimate
from fretwear.units import MICROMETRE, Unit, readable_unit
from fretwear.vocabulary import CYCLE, HEADLINES, RESULTS, SYMMETRIES, ContactState, X, Y

Packed = dict[str, Any]
"""Data that the script reads, as in JSON."""

EXPLORED_PROFILES = ("pressure", "shear_traction", "gap", "wear_depth")
"""Fields along x or y, one in each panel of the explorer."""
MAPS = ("pressure", "wear_depth")
"""Fields over x and y of contacts that are not even, one in each map of the explorer."""
EXPLORED_HISTORIES = (("contact_half_width_x", "stick_half_width_x"), ("wear_volume",))
"""Results over the cycles, by panel; results of a panel differ in their first word."""

_MOST_CASES = 200
_MOST_SNAPSHOTS = 60
_MOST_STEPS = 400
_MOST_VALUES = 4_000_000
_MOST_SQUARES = 64
_SHARES = 101
_LEVELS = 10_000
_AROUND_PROFILE, _AROUND_MAP = 1.3, 1.05
_WORN, _BEYOND = 0.01, 1.15
_NAMES = {field.name: name for name, field in MERGED_PROFILES.items()}


class Explorer(NamedTuple):
    """The explorer of a page."""

    data: str  # the data of its script
    axes: list[Packed]  # the words of each parameter that can be chosen, and its levels
    alone: str  # the title of its only point; empty if there is a choice
    numbers: frozenset[int]  # numbers of the points that can be shown
    note: str  # a note on the points it holds, unless it holds all


def build_explorer(
    plan: Plan, results: Sequence[PointResult], folder: Path, most: int = _MOST_CASES
) -> Explorer | None:
    """Pack at most `most` points of a study for the explorer; None if no case is done.

    `folder` has the merged study, ``summary.nc``, and the files of its ``cases``. Raises a
    `DataFileError` if one is missing or damaged.
    """
    if not any(result.done for result in results):
        return None
    places = held_points(plan, results, most)
    held = [results[place] for place in places]
    units = display_units(results)
    # Depths and gaps are compared by eye.
    units |= dict.fromkeys(("gap", "wear_depth"), units["maximum_wear_depth"])
    units |= {name: RESULTS[name].unit or units[name] for name in EXPLORED_PROFILES}
    done = {plan.points[place].id: plan.points[place] for place in places if results[place].done}
    cases: list[Packed] = []
    with opened_summary(folder / "summary.nc") as file:
        numbers = {name: file[name][...] for name in HEADLINES}
        for case_id, planned in done.items():
            assert planned.case is not None
            packed = _curves(file, planned.place, numbers, units)
            path = folder / "cases" / f"{case_id}.nc"
            with opened_case(path) as stored:
                snapshots = np.searchsorted(stored["cycle"][:], np.array(packed["cycles"]))
                packed |= {"id": case_id, **_surfaces(stored, planned.case, snapshots, units)}
                packed["across"] = _across(stored, snapshots, units)
            is_constant = isinstance(planned.case.friction, float) and not planned.case.blocks
            cases.append({**packed, "friction": planned.case.friction if is_constant else None})
    heights = [curve for case in cases for curve in case["heights"] or ()]
    height = readable_unit(np.concatenate([np.zeros(1), *heights]), "m")
    for case in cases:
        case["heights"] = case["heights"] and [
            _short(height.of(curve)) for curve in case["heights"]
        ]
    ids, axes = list(done), _axes(plan, places)
    header = {
        "words": _words(units, height, results),
        "profiles": EXPLORED_PROFILES,
        "maps": MAPS,
        "readout": HEADLINES,
        "histories": EXPLORED_HISTORIES,
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
        "cases": cases,
        # The case with the largest wear shows most.
        "start": int(np.argmax([r.values.get("wear_volume", -1.0) for r in held])),
    }
    single = [(result.number, f"{result.number}: {result.title}") for result in held]
    text = json.dumps(header, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    note = (
        f"This page holds {len(held)} of the {len(results)} points of the study, evenly spread; "
        "summary.nc has the profiles of all points."
    )
    return Explorer(
        compressed(text.encode("utf-8")),
        axes or [{"words": "point", "levels": single}],
        "" if len(held) > 1 else held[0].title,
        frozenset(result.number for result in held if result.done),
        note if len(held) < len(results) else "",
    )


def _curves(
    file: netCDF4.Dataset,
    position: tuple[int, ...],
    every: Mapping[str, Array],
    units: Mapping[str, Unit],
) -> Packed:
    """Read one case along x on the line nearest y = 0, and over the cycles."""
    numbers = {name: values[position] for name, values in every.items()}
    snapshots = np.flatnonzero(np.isfinite(numbers["contact_half_width_x"]))
    cycles, x = file[CYCLE.name][...], file[X.name][...]
    kept = representative_cycles(cycles[snapshots].tolist(), _MOST_SNAPSHOTS)
    snapshots = np.searchsorted(cycles, kept)
    numbers = {name: values[snapshots] for name, values in numbers.items()}
    # The scar of a stroke extends beyond the contact.
    worn = np.nan_to_num(file[_NAMES["wear_depth"]][position][snapshots[-1]])
    scar = float(np.abs(x[worn > _WORN * worn.max()]).max(initial=0.0))
    reach = max(_AROUND_PROFILE * float(numbers["contact_half_width_x"].max()), _BEYOND * scar)
    # The gap is unknown outside the window of the case.
    is_stored = np.isfinite(file[_NAMES["gap"]][position][snapshots[-1]])
    inside = np.flatnonzero(is_stored & (np.abs(x) <= max(reach, 2.0 * float(np.abs(x).min()))))

    def profiles(field: str) -> Array:
        values = file[_NAMES[field]][position][np.ix_(snapshots, inside)]
        return np.asarray(values, dtype=np.float64)

    history = {
        name: file[HISTORY_GROUP][name][position]
        for name in (CYCLE.name, *chain(*EXPLORED_HISTORIES))
    }
    taken = np.flatnonzero(np.isfinite(list(history.values())).all(axis=0))
    taken = taken[evenly(taken.size, _MOST_STEPS)]
    x = MICROMETRE.of(x[inside])
    return {
        **_line(x, profiles, units),
        "cycles": cycles[snapshots].tolist(),
        "numbers": {name: _short(units[name].of(values)) for name, values in numbers.items()},
        "history": {
            name: _short(units[name].of(values[taken]) if name in units else values[taken])
            for name, values in history.items()
        },
    }


def _line(x: Array, profiles: Callable[[str], Array], units: Mapping[str, Unit]) -> Packed:
    """Pack places on a line, µm, with zones and profiles there, of shape (snapshots, places)."""
    half = 0.5 * float(x[1] - x[0]) if x.size > 1 else float(x[0])
    return {
        "x": [float(x[0]), 2.0 * half, x.size],
        "zones": [
            {
                state.name.lower(): stretches(row == state, x, half)
                for state in (ContactState.STICK, ContactState.SLIP)
            }
            for row in profiles("contact_state")
        ],
        "profiles": {
            name: [delta_coded(units[name].of(row)) for row in profiles(name)]
            for name in EXPLORED_PROFILES
        },
    }


def _across(
    file: netCDF4.Dataset, places: NDArray[np.intp], units: Mapping[str, Unit]
) -> Packed | None:
    """Read a case along y on the line nearest x = 0; None for a line contact."""
    if Y.name not in file.variables:
        return None
    x, y = (file[axis.name][:].astype(np.float64) for axis in (X, Y))
    widths = {
        name: file[name][:].astype(np.float64)[places]
        for name in ("contact_half_width_y", "stick_half_width_y")
    }
    reach = _AROUND_PROFILE * float(widths["contact_half_width_y"].max())
    inside = np.flatnonzero(np.abs(y) <= max(reach, 2.0 * float(np.abs(y).min())))
    middle = int(np.abs(x).argmin())

    def profiles(name: str) -> Array:
        rows = [file[name][place, middle][inside] for place in places]
        return np.array(rows, dtype=np.float64)

    line = _line(MICROMETRE.of(y[inside]), profiles, units)
    return line | {"numbers": {name: _short(MICROMETRE.of(w)) for name, w in widths.items()}}


def _surfaces(
    file: netCDF4.Dataset, case: Case, places: NDArray[np.intp], units: Mapping[str, Unit]
) -> Packed:
    """Read maps of a contact that is not even, and heights, m, of a rough one before and after.

    Either is None if it does not apply. The heights are those above which 0, 1, … 100 % of the
    contact lie.
    """
    is_seen = len(case.frame.axes) > 1 and not all(case.even)
    is_rough = case.rough is not None and case.rough.is_known
    if not is_seen and not is_rough:
        return {"view": None, "heights": None}
    view, heights = None, None
    if is_seen:
        view = _view(file, places, units)
    if is_rough and case.rough is not None:
        names = case.frame.axes
        axes = [file[name][:].astype(np.float64) for name in names]
        half_widths = [float(file[f"contact_half_width_{name}"][-1]) for name in names]
        lost = file["wear_depth"][-1].astype(np.float64) + file["plastic_depth"][-1]
        worn = np.stack([np.zeros_like(lost), lost])
        surfaces = case.rough.in_contact(axes, half_widths, worn)
        heights = [surface[evenly(surface.size, _SHARES)] for surface in surfaces]
    return {"view": view, "heights": heights}


def _view(file: netCDF4.Dataset, places: NDArray[np.intp], units: Mapping[str, Unit]) -> Packed:
    """Return means of the fields over squares of cells, to a little beyond the contact."""
    touching = file["contact_state"][places[-1]] > ContactState.OPEN
    at, cells = [], []
    for axis, is_even in enumerate(SYMMETRIES[file.getncattr("symmetry")]):
        along = file["xy"[axis]][:].astype(np.float64)
        reach = float(np.abs(along[touching.any(axis=1 - axis)]).max())
        kept = np.flatnonzero(np.abs(along) <= _AROUND_MAP * reach)
        along = along[kept]
        if is_even:
            along, kept = np.r_[-along[::-1], along], np.r_[kept[::-1], kept]
        step = -(-kept.size // _MOST_SQUARES)
        squares = kept.size // step
        # Excess cells at the ends are dropped.
        first = (kept.size - squares * step) // 2
        cells.append(kept[first : first + squares * step])
        at.append(along[first : first + squares * step].reshape(squares, step).mean(axis=1))
    shape = [size for a, c in zip(at, cells, strict=True) for size in (a.size, c.size // a.size)]

    fields: dict[str, list[list[Packed]]] = {name: [] for name in MAPS}
    for name, place in product(MAPS, places):
        field = file[name][place].astype(np.float64)[np.ix_(*cells)].reshape(shape)
        rows = units[name].of(field.mean(axis=(1, 3))).T
        fields[name].append([delta_coded(row) for row in rows])
    lines = (MICROMETRE.of(along) for along in at)
    ranges = [[x[0], (x[-1] - x[0]) / max(1, x.size - 1), x.size] for x in lines]
    return {"x": ranges[0], "y": ranges[1], "fields": fields}


def _short(values: Array) -> list[float | None]:
    return [float(f"{value:.7g}") if math.isfinite(value) else None for value in values.tolist()]


def delta_coded(row: Array) -> Packed:
    """Round a row to a 10 000th of its largest value, so that neighbours differ by small integers.

    A value is ``scale`` times the sum of all ``steps`` up to its own; the step of a NaN is None.
    """
    finite = np.isfinite(row)
    scale = float(np.abs(row[finite]).max(initial=0.0)) / _LEVELS
    steps = np.full(row.shape, None)
    steps[finite] = np.diff(np.rint(row[finite] / (scale or 1.0)), prepend=0.0).astype(int)
    return {"scale": scale, "steps": steps.tolist()}


def stretches(inside: NDArray[np.bool_], x: Array, half: float) -> list[list[float | None]]:
    """Return the ends of stretches of cells with centres `x`; `half` is half a cell."""
    ends = np.flatnonzero(np.diff(inside, prepend=False, append=False)).reshape(-1, 2)
    return [_short(np.array([x[a] - half, x[b - 1] + half])) for a, b in ends]


def held_points(plan: Plan, results: Sequence[PointResult], most: int = _MOST_CASES) -> list[int]:
    """Select points that span the study evenly, and whose profiles are not too long together.

    Returns increasing positions in ``plan.points``, at least one of a point that is done. A grid
    remains a grid: its axes are thinned, the longest first, and keep their ends, so that every
    combination of the remaining values is present.
    """
    count = len(plan.points)
    in_maps = len(MAPS) * _MOST_SQUARES**2
    lengths = [
        (
            len(EXPLORED_PROFILES) * sum(_sides(point.case))
            + (0 if all(point.case.even) else in_maps)
        )
        * len(point.case.output_cycles)
        for point in (plan.points[place] for place in evenly(count, _MOST_CASES))
        if point.case is not None
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


def _sides(case: Case) -> tuple[int, int]:
    """Numbers of cells along x and, in a point contact, along y."""
    cells = estimate(case)
    return cells.cells_x, cells.cells_y if len(case.frame.axes) > 1 else 0


def thinned_levels(lengths: Sequence[int], most: int) -> list[list[int]]:
    """Return levels of every axis of a grid with at most `most` combinations."""
    kept = list(lengths)
    while math.prod(kept) > most and max(kept) > 1:
        kept[kept.index(max(kept))] -= 1
    return [evenly(length, number) for length, number in zip(lengths, kept, strict=True)]


def evenly(count: int, most: int) -> list[int]:
    """Return at most `most` of the places 0 to `count` − 1, evenly spread, with both ends."""
    return [int(place) for place in np.rint(np.linspace(0, count - 1, min(count, most)))]


def _axes(plan: Plan, places: Sequence[int]) -> list[Packed]:
    """Return the varied parameters of a grid with the values that are held; empty otherwise."""
    axes = []
    for position, axis in enumerate(plan.study.axes if plan.study.design.kind == "grid" else ()):
        levels = sorted({plan.points[place].index[position] for place in places})
        texts = [level.label for level in levels_of(axis)]
        words = parameter(axis.coordinate).words
        axes.append({"words": words, "levels": [(level, texts[level]) for level in levels]})
    return axes


def _words(
    units: Mapping[str, Unit], height: Unit, results: Sequence[PointResult]
) -> dict[str, dict[str, str]]:
    """Return words, label and unit of every quantity shown, by name."""
    shown = {name: result_variable(name, results) for name in units}
    rows = [
        *((axis.name, axis.words, axis.name, MICROMETRE.name) for axis in (X, Y)),
        (CYCLE.name, CYCLE.words, CYCLE.label, ""),
        ("height", "height", "Height", height.name),
        ("bearing_area", "bearing area", "Bearing area", "% of the contact"),
        *((name, about.words, about.label, units[name].name) for name, about in shown.items()),
    ]
    return {
        name: {"words": words, "label": f"{label} ({unit})" if unit else label, "unit": unit}
        for name, words, label, unit in rows
    }
