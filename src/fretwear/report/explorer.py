"""The explorer's data: profiles, zones and histories of the cases, packed for its script."""

from __future__ import annotations

import json
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, product
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from fretwear.data.files import open_case, open_history
from fretwear.figures.datasets import representative_cycles
from fretwear.figures.wording import parameter
from fretwear.report.page import compressed
from fretwear.report.results import PointResult, labels_of, marked_label
from fretwear.study.plan import Plan
from fretwear.units import MICROMETRE, Unit, readable_unit
from fretwear.vocabulary import CYCLE, MAXIMUM_WEAR_DEPTH, RESULTS, ContactState, Variable, X

PROFILES = ("pressure", "shear_traction", "gap", "wear_depth")
"""Fields along x, a panel each."""

READOUT = (
    "contact_half_width_x",
    "stick_half_width_x",
    "peak_pressure",
    "central_pressure",
    MAXIMUM_WEAR_DEPTH.name,
    "wear_volume",
    "dissipated_energy",
)
"""Numbers at every snapshot."""

HISTORY = (("contact_half_width_x", "stick_half_width_x"), ("wear_volume",))
"""Numbers at every step: the curves of each panel."""

MISSING = -32768
_STEPS = 32767
_ALIGNMENT = 8

_MOST_CASES = 300
_MOST_BYTES = 8_000_000
_MOST_SNAPSHOTS = 60
_MOST_STEPS = 400
_BEYOND_CONTACT = 1.3


@dataclass(frozen=True)
class Explorer:
    """The explorer of a study.

    Attributes
    ----------
    data : str
        What its script reads: see `Packer.text`.
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
    places = select_points(plan, done, min(most, _affordable(plan)))
    ids = list(dict.fromkeys(results[place].id for place in places if results[place].done))
    series = [read_series(cases / f"{case_id}.nc") for case_id in ids]
    units = _units(series)
    packer = Packer()
    header = {
        "words": _words(units),
        "states": {state.name.lower(): state.value for state in ContactState},
        "histories": _histories(units),
        "profiles": PROFILES,
        "readout": READOUT,
        "axes": _axes(plan, places),
        "points": [
            {
                "number": results[place].number,
                "index": plan.points[place].point.index,
                "title": results[place].title,
                "status": results[place].status.word,
                "reason": results[place].reason,
                "case": ids.index(results[place].id) if results[place].done else -1,
            }
            for place in places
        ],
        "cases": [
            _packed(case_id, one, units, packer) for case_id, one in zip(ids, series, strict=True)
        ],
        # There is most to see in the case with the largest wear.
        "start": int(np.argmax([_volume(results[place]) for place in places])),
    }
    return Explorer(packer.text(header), _note(len(places), len(results)))


def _volume(result: PointResult) -> float:
    return result.last("wear_volume") if result.done else -1.0


def _affordable(plan: Plan) -> int:
    """Return how many cases fit into the page by the estimated length of their profiles."""
    lengths = [
        2 * len(PROFILES) * point.estimate.cells_x * len(point.case.output_cycles)
        for point in plan.points
        if point.case is not None and point.estimate is not None
    ]
    return max(1, int(_MOST_BYTES * len(lengths) / sum(lengths)))


def _note(held: int, points: int) -> str:
    if held == points:
        return ""
    return (
        f"This page holds {held} of the {points} points of the study, evenly spread; "
        "summary.nc has the profiles of all."
    )


def _axes(plan: Plan, places: Sequence[int]) -> list[dict[str, Any]]:
    """Return the varied parameters of a grid with the values that are held; else nothing."""
    if plan.study.design.kind != "grid":
        return []
    axes = []
    for position, axis in enumerate(plan.study.axes):
        levels = sorted({plan.points[place].point.index[position] for place in places})
        labels = labels_of(axis)
        words = parameter(axis.coordinate).words
        axes.append({"words": words, "levels": [[level, labels[level]] for level in levels]})
    return axes


# --- which points are held ----------------------------------------------------------------------


def select_points(plan: Plan, done: Collection[int], most: int) -> list[int]:
    """Select points that span the study evenly.

    A grid stays one: its axes are thinned, the longest first, and keep their ends, so that every
    combination of the remaining values is there.

    Parameters
    ----------
    plan : Plan
        The study's plan.
    done : collection of int
        Positions in ``plan.points`` of those that have results.
    most : int
        How many points at most, at least 1.

    Returns
    -------
    list of int
        Positions in ``plan.points``, increasing; at least one that is done, if there is one.
    """
    count = len(plan.points)
    if plan.study.design.kind == "grid" and count > most:
        lengths = [len(axis.values) for axis in plan.study.axes]
        kept = set(product(*thinned_levels(lengths, most)))
        places = [place for place, planned in enumerate(plan.points) if planned.point.index in kept]
    else:
        places = evenly(count, most)
    if done and not set(done).intersection(places):
        known = sorted(done)
        return [known[place] for place in evenly(len(known), most)]
    return places


def thinned_levels(lengths: Sequence[int], most: int) -> list[list[int]]:
    """Return levels of every axis of a grid with at most `most` combinations."""
    kept = list(lengths)
    while math.prod(kept) > most and max(kept) > 1:
        kept[kept.index(max(kept))] -= 1
    return [evenly(length, number) for length, number in zip(lengths, kept, strict=True)]


def evenly(count: int, most: int) -> list[int]:
    """Return at most `most` of the places 0 to `count` − 1, evenly spread, with both ends."""
    if count <= most:
        return list(range(count))
    return [int(place) for place in np.rint(np.linspace(0, count - 1, most))]


# --- what is held of a case ---------------------------------------------------------------------


@dataclass(frozen=True)
class CaseSeries:
    """One case along x > 0 on the line nearest y = 0, and over the cycles; SI units.

    Attributes
    ----------
    line : xarray.Dataset
        The fields of `PROFILES` and ``contact_state``, dimensions ``(cycle, x)``, and the numbers
        of `READOUT`, dimension ``cycle``, at the snapshots; x reaches somewhat beyond the contact.
    history : xarray.Dataset
        ``cycle`` and the numbers of `HISTORY`, dimension ``step``.
    """

    line: xr.Dataset
    history: xr.Dataset


def read_series(path: Path) -> CaseSeries:
    """Read what the explorer shows of one case.

    Of more than 60 snapshots or 400 steps, evenly spread ones are taken.

    Parameters
    ----------
    path : pathlib.Path
        A case file.

    Raises
    ------
    CaseFileError
        When the file is missing or damaged.
    """
    deepest = MAXIMUM_WEAR_DEPTH.name
    with open_case(path) as case, open_history(path) as history:
        kept = representative_cycles([int(n) for n in case["cycle"].values], _MOST_SNAPSHOTS)
        case = case.sel(cycle=list(kept))
        x = case["x"].values
        reach = _BEYOND_CONTACT * float(case["contact_half_width_x"].max())
        inside = np.flatnonzero((x > 0.0) & (x <= max(reach, 2.0 * float(np.abs(x).min()))))
        row = int(np.abs(case["y"].values).argmin())
        numbers = [name for name in READOUT if name != deepest]
        line = case[[*PROFILES, "contact_state", *numbers]].isel(y=row, x=inside).load()
        line[deepest] = line["wear_depth"].max("x")
        steps = evenly(history.sizes["step"], _MOST_STEPS)
        return CaseSeries(line, history[[CYCLE.name, *chain(*HISTORY)]].isel(step=steps).load())


def _units(series: Sequence[CaseSeries]) -> dict[str, Unit]:
    """Return the unit of every result, one for all cases; depths and gaps have the same."""

    def fitting(variable: Variable) -> Unit:
        values = np.concatenate([one.line[variable.name].values.ravel() for one in series])
        return readable_unit(values, variable.si_unit)

    depth = fitting(MAXIMUM_WEAR_DEPTH)
    same = dict.fromkeys(("gap", "wear_depth", MAXIMUM_WEAR_DEPTH.name), depth)
    results = [RESULTS[name] for name in (*PROFILES, *READOUT)]
    return {one.name: one.unit or fitting(one) for one in results} | same


def _words(units: Mapping[str, Unit]) -> dict[str, dict[str, str]]:
    """Return words, label and unit of all that is shown, by name."""
    found = {
        name: {"words": RESULTS[name].words, "label": marked_label(name), "unit": unit.name}
        for name, unit in units.items()
    }
    for result in found.values():
        result["label"] += f" ({result['unit']})"
    unit = MICROMETRE.name
    found[X.name] = {"words": X.words, "label": f"{X.name} ({unit})", "unit": unit}
    found[CYCLE.name] = {"words": CYCLE.words, "label": CYCLE.label, "unit": ""}
    return found


def _histories(units: Mapping[str, Unit]) -> list[dict[str, Any]]:
    """Return the panels of `HISTORY`; what its curves' words have in common labels a panel."""
    panels = []
    for names in HISTORY:
        words = [RESULTS[name].words.split() for name in names]
        own = (
            0
            if len(names) == 1
            else next(n for n in range(9) if len({*map(tuple, (w[n:] for w in words))}) == 1)
        )
        common = " ".join(words[0][own:])
        panels.append(
            {
                "label": f"{common[:1].upper()}{common[1:]} ({units[names[0]].name})",
                "curves": [
                    {"name": name, "text": " ".join(each[:own])}
                    for name, each in zip(names, words, strict=True)
                ],
            }
        )
    return panels


def _packed(
    case_id: str, series: CaseSeries, units: Mapping[str, Unit], packer: Packer
) -> dict[str, Any]:
    """Pack the arrays of a case; return where they are and what is short enough for the header."""
    line, history = series.line, series.history

    def values(dataset: xr.Dataset, name: str) -> NDArray[np.float64]:
        return np.asarray(units[name].of(dataset[name].values.astype(np.float64)))

    x = MICROMETRE.of(line["x"].values)
    spacing = float(x[1] - x[0]) if x.size > 1 else 2.0 * float(x[0])
    return {
        "id": case_id,
        "friction": float(line["friction"]),
        "x": [float(x[0]), spacing, x.size],
        "cycles": line[CYCLE.name].values.astype(np.float64).tolist(),
        "states": [run_lengths(row) for row in line["contact_state"].values.astype(np.int8)],
        "profiles": {name: packer.add_rounded(values(line, name)) for name in PROFILES},
        "scalars": {
            name: [float(f"{value:.6g}") for value in values(line, name)] for name in READOUT
        },
        "steps": {
            "number": history.sizes["step"],
            "cycle": packer.add_floats(history[CYCLE.name].values),
            **{name: packer.add_floats(values(history, name)) for name in chain(*HISTORY)},
        },
    }


def run_lengths(states: NDArray[np.int8]) -> list[int]:
    """Return a row of states as pairs: a state, and for how many cells it lasts."""
    edges = np.flatnonzero(np.diff(states)) + 1
    starts, ends = np.r_[0, edges], np.r_[edges, states.size]
    pairs = zip(states[starts], ends - starts, strict=True)
    return [int(number) for pair in pairs for number in pair]


# --- how it is packed ---------------------------------------------------------------------------


class Packer:
    """Collects arrays and tells where each of them stands.

    The script reads little-endian numbers; every array begins at a multiple of eight bytes.
    """

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._size = 0

    def add_rounded(self, values: ArrayLike) -> dict[str, Any]:
        """Add values rounded to a 32767th of the largest in their row, two bytes each.

        Parameters
        ----------
        values : array_like, shape (rows, columns)
            The values; NaN is kept.

        Returns
        -------
        dict
            ``at``, the position in bytes, and ``scales``, by which the integers of each row have
            to be multiplied.
        """
        rows = np.atleast_2d(np.asarray(values, dtype=np.float64))
        largest = np.nan_to_num(np.abs(rows)).max(axis=1, initial=0.0, keepdims=True)
        scales = np.where(largest > 0.0, largest / _STEPS, 1.0)
        known = np.isfinite(rows)
        integers = np.where(known, np.rint(np.where(known, rows, 0.0) / scales), MISSING)
        return {"at": self._add(integers.astype("<i2")), "scales": scales[:, 0].tolist()}

    def add_floats(self, values: ArrayLike) -> int:
        """Add values as single-precision numbers; return the position in bytes."""
        return self._add(np.asarray(values, dtype="<f4"))

    def text(self, header: Mapping[str, Any]) -> str:
        """Return everything as base64 of a gzip stream.

        The stream holds the length of the header as a little-endian 32-bit number and four
        unused bytes, the header as JSON padded with spaces, and the arrays.

        Parameters
        ----------
        header : mapping
            Must suit JSON; no NaN.
        """
        words = json.dumps(header, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
        encoded = words.encode("utf-8")
        encoded += b" " * (-len(encoded) % _ALIGNMENT)
        content = [len(encoded).to_bytes(_ALIGNMENT, "little"), encoded, *self._parts]
        return compressed(b"".join(content))

    def _add(self, array: NDArray[Any]) -> int:
        position, data = self._size, array.tobytes()
        data += b"\0" * (-len(data) % _ALIGNMENT)
        self._parts.append(data)
        self._size += len(data)
        return position
