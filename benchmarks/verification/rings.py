"""The three-dimensional run against the independent solver on rings."""

import math

from benchmarks.pages import Data, Section, named, worst
from benchmarks.verification.problems import (
    DEPTH,
    STUDY_LIMIT,
    TIME_PER_CYCLE,
    VOLUME,
    snapshots,
)
from tests.mechanics.problems import P0, fretting, independent

TIMES = (0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 20.0)
NAMES = {"central_pressure": "central pressure", "deepest_wear": "depth", "wear_volume": "volume"}
# At X = 0.2 one run has the stick edge where the staircase of cells errs least, and one where it
# errs most; see the section on the limiting state.
ELASTIC = ((0.2, 330.49), (0.2, 329.95), (0.5, 220.0), (0.9, 110.0))
CAPPED = ((0.2, 220.0), (0.5, 220.0), (0.8, 143.0), (0.9, 110.0))


def compare(ratio: float, cells: float, limit: float) -> Data:
    """Deviations of one run at all times."""
    reference_values = independent(ratio, limit)
    problem = fretting(cells, load_ratio=ratio, limit=limit)
    found = snapshots(problem, [time / TIME_PER_CYCLE for time in TIMES])
    deviations: dict[str, list[float]] = {name: [] for name in NAMES}
    for time, snapshot in zip(TIMES, found.values(), strict=True):
        known, measures = reference_values[time], snapshot.measures
        values = (
            measures.central_pressure / P0,
            snapshot.deepest_wear / DEPTH,
            measures.wear_volume / VOLUME,
        )
        for name, value in zip(NAMES, values, strict=True):
            deviations[name].append(value / known[name] - 1)
    return {"ratio": ratio, "cells": cells, "deviations": deviations}


def run() -> Data:
    return {
        "elastic": [compare(ratio, cells, math.inf) for ratio, cells in ELASTIC],
        "capped": [compare(ratio, cells, STUDY_LIMIT) for ratio, cells in CAPPED],
    }


def rows(data: Data) -> list[list[str]]:
    capped = data["capped"]
    kinds = {
        "elastic sphere, τ = 0.5 to 20": data["elastic"],
        "yielding sphere, X = 0.8 and 0.9": [row for row in capped if row["ratio"] >= 0.8],
        "the same, X = 0.2 and 0.5, on cells wider than the band": [
            row for row in capped if row["ratio"] < 0.8
        ],
    }
    return [
        [
            words,
            "independent solution on rings",
            named({
                name: worst(value for row in chosen for value in row["deviations"][key])
                for key, name in NAMES.items()
            }),
        ]
        for words, chosen in kinds.items()
    ]  # fmt: skip


SECTION = Section("rings", "Wear history against the solver on rings", run)
