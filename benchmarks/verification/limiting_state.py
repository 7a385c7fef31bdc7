"""The smooth elastic sphere after 30000 cycles against the limit of infinitely many."""

from benchmarks.pages import Check, Data, Section, percent, table, worst
from benchmarks.verification.problems import DEPTH, VOLUME, Snapshot, snapshots
from tests.mechanics.problems import HERTZ, P0, A, fretting

from fretwear.theory import LimitingState

CYCLES = 30000.0
CELLS, RATIOS = 110, (0.2, 0.5, 0.9)
APART = 6  # cells between points that are kept of profiles
NARROW = 0.2
NAMES = {
    "central_pressure": "central pressure",
    "deepest_wear": "deepest wear",
    "wear_volume": "wear volume",
    "half_width": "contact half-width",
}
REQUIRED = dict(zip(NAMES, (0.005, 0.01, 0.01, 0.01), strict=True))
REQUIRED_NARROW = dict(zip(NAMES, (0.005, 0.02, 0.02, 0.01), strict=True))
SCATTER = ((51, 10), (102, 10), (204, 5))
"""Whole cells on the stick radius of X = 0.2, and positions of its edge within the next one."""


def values(snapshot: Snapshot) -> dict[str, float]:
    """Results in units of the Hertzian contact."""
    found = snapshot.measures
    return {
        "central_pressure": found.central_pressure / P0,
        "deepest_wear": snapshot.deepest_wear / DEPTH,
        "wear_volume": found.wear_volume / VOLUME,
        "half_width": found.contact_half_width_x / A,
    }


def limits(ratio: float) -> dict[str, float]:
    """The same of the limiting state."""
    state = LimitingState(HERTZ, ratio)
    return {
        "central_pressure": state.central_pressure / P0,
        "deepest_wear": state.deepest_wear / DEPTH,
        "wear_volume": state.wear_volume / VOLUME,
        "half_width": state.contact_radius / A,
    }


def _last(cells: float, ratio: float) -> Snapshot:
    return snapshots(fretting(cells, load_ratio=ratio), [CYCLES])[CYCLES]


def along_x(snapshot: Snapshot) -> dict[str, list[float]]:
    """Pressure and wear depth along x in some cells, in units of the Hertzian contact."""
    state = snapshot.state
    some = slice(0, None, APART)
    return {
        "x": [float(x) for x in state.geometry.x[some] / A],
        "pressure": [float(p) for p in state.pressure[some, 0] / P0],
        "wear_depth": [float(w) for w in state.wear[some, 0] / DEPTH],
    }


def run() -> Data:
    stick = LimitingState(HERTZ, NARROW).stick_radius / A
    scatter = [
        {
            "whole": whole,
            "position": position / count,
            "cells": (whole + position / count) / stick,
            **values(_last((whole + position / count) / stick, NARROW)),
        }
        for whole, count in SCATTER
        for position in range(count)
    ]
    last = {ratio: _last(CELLS, ratio) for ratio in RATIOS}
    return {
        "ratios": [{"ratio": ratio, **values(one)} for ratio, one in last.items()],
        "along_x": [{"ratio": ratio, **along_x(one)} for ratio, one in last.items()],
        "scatter": scatter,
    }


def deviation(row: Data, ratio: float, name: str) -> float:
    return row[name] / limits(ratio)[name] - 1


def required(ratio: float) -> dict[str, float]:
    return REQUIRED_NARROW if ratio == NARROW else REQUIRED


def checks(data: Data) -> list[Check]:
    found = [
        Check(
            f"{NAMES[name]}, X = {row['ratio']}, a/{CELLS}",
            deviation(row, row["ratio"], name),
            required(row["ratio"])[name],
        )
        for row in data["ratios"]
        for name in NAMES
    ]
    for name in ("deepest_wear", "wear_volume"):
        label = f"{NAMES[name]}, X = {NARROW}, a/{CELLS}, any position of the stick edge"
        rows = _group(data, 102)
        largest = worst(deviation(row, NARROW, name) for row in rows)
        found.append(Check(label, largest, REQUIRED_NARROW[name]))
    return found


def _group(data: Data, whole: int) -> list[Data]:
    return [row for row in data["scatter"] if row["whole"] == whole]


def text(data: Data) -> str:
    main = table(
        [f"deviation, a/{CELLS}", *(f"X = {r}" for r in RATIOS)],
        (
            [label, *(percent(deviation(row, row["ratio"], name)) for row in data["ratios"])]
            for name, label in NAMES.items()
        ),
    )
    scatter = _group(data, SCATTER[1][0])
    return f"""\
A smooth elastic sphere after 30000 cycles, against the closed forms of the limit.

{main}

At X = {NARROW} the worn annulus is 12 cells wide at a/110. As its inner edge moves through a cell, the wear volume deviates by
{_range(scatter, "wear_volume")}, the deepest wear by {_range(scatter, "deepest_wear")}.
"""


def _range(rows: list[Data], name: str) -> str:
    found = [deviation(row, NARROW, name) for row in rows]
    return f"{percent(min(found))} … {percent(max(found))}"


SECTION = Section(
    "limiting_state", "The limit of many cycles, smooth and elastic", run, text, checks
)
