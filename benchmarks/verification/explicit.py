"""The implicit integrator against small explicit steps."""

import math

import numpy as np
from benchmarks.pages import Data, Section, named, worst
from benchmarks.verification.problems import snapshots
from tests.mechanics.oracles import extrapolated_wear
from tests.mechanics.problems import ROUGH, SMOOTH, A, fretting

from fretwear.mechanics.contact.grid import Grid

CELLS = 16
CYCLES = 2500.0
STEPS = 500
TOLERANCE = 0.01
CASES = {
    "smooth, elastic": (SMOOTH, math.inf),
    "smooth, capped": (SMOOTH, 1.5),
    "rough, elastic": (ROUGH, math.inf),
    "rough, capped": (ROUGH, 1.8),
}
"""Surface and plastic limit over p0 of each case; the limits are low so that coarse grids yield."""


def compare(name: str) -> Data:
    surface, limit = CASES[name]
    extent = (1.7 * A, 1.7 * A)
    problem = fretting(CELLS, roughness=surface, limit=limit, extent=extent)
    state = snapshots(problem, [CYCLES], TOLERANCE)[CYCLES].state
    window = Grid(state.geometry.shape, problem.spacing)
    expected = extrapolated_wear(problem, window, CYCLES, STEPS)
    volume, sunk = float(expected.wear.sum()), float(expected.plastic.sum())
    worn = state.geometry.resized(state.wear, window)
    flowed = state.geometry.resized(state.plastic, window)
    return {
        "name": name,
        "steps": state.step,
        "volume": float(worn.sum()) / volume - 1,
        "depth": float(np.abs(worn - expected.wear).sum()) / volume,
        "plastic": float(flowed.sum()) / sunk - 1 if sunk else 0.0,
    }


def run() -> Data:
    return {"cases": [compare(name) for name in CASES]}


def rows(data: Data) -> list[list[str]]:
    steps = [case["steps"] for case in data["cases"]]
    found = {
        words: worst(case[name] for case in data["cases"])
        for name, words in (("volume", "volume"), ("depth", "depth"), ("plastic", "plastic volume"))
    }
    words = f"{min(steps)} to {max(steps)} default steps, smooth and rough"
    return [[words, f"{2 * STEPS} explicit steps", named(found)]]


SECTION = Section("explicit", "The integrator against explicit steps", run)
