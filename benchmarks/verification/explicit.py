"""The implicit integrator against small explicit steps."""

import math

import numpy as np
from benchmarks.pages import Check, Data, Section, percent, table, worst
from benchmarks.verification.problems import snapshots
from tests.mechanics.oracles import Worn, explicit_wear
from tests.mechanics.problems import ROUGH, SMOOTH, A, fretting

from fretwear.arrays import Array
from fretwear.mechanics.contact.grid import Grid

CELLS = 16
CYCLES = 2500.0
STEPS = 500
TOLERANCES = (0.01, 0.001)
REQUIRED = 0.01
CASES = {
    "smooth, elastic": (SMOOTH, math.inf),
    "smooth, capped": (SMOOTH, 1.5),
    "rough, elastic": (ROUGH, math.inf),
    "rough, capped": (ROUGH, 1.8),
}
"""Surface and plastic limit over p0 of each case; the limits are low so that coarse grids yield."""


def extrapolated(coarse: Worn, fine: Worn) -> tuple[Array, Array]:
    """Wear and plastic depth without the first-order error of the steps."""
    return 2 * fine.wear - coarse.wear, 2 * fine.plastic - coarse.plastic


def compare(name: str) -> Data:
    surface, limit = CASES[name]
    extent = (1.7 * A, 1.7 * A)
    problem = fretting(CELLS, roughness=surface, limit=limit, extent=extent)
    implicit = {tol: snapshots(problem, [CYCLES], tol)[CYCLES].state for tol in TOLERANCES}
    window = Grid(implicit[TOLERANCES[-1]].geometry.shape, problem.spacing)
    coarse = explicit_wear(problem, window, CYCLES, STEPS)
    fine = explicit_wear(problem, window, CYCLES, 2 * STEPS)
    wear, plastic = extrapolated(coarse, fine)
    volume, sunk = float(wear.sum()), float(plastic.sum())
    rows = []
    for tolerance, state in implicit.items():
        worn = state.geometry.resized(state.wear, window)
        flowed = state.geometry.resized(state.plastic, window)
        rows.append(
            {
                "tolerance": tolerance,
                "steps": state.step,
                "volume": float(worn.sum()) / volume - 1,
                "depth": float(np.abs(worn - wear).sum()) / volume,
                "plastic": float(flowed.sum()) / sunk - 1 if sunk else 0.0,
            }
        )
    return {
        "name": name,
        "halving": float(fine.wear.sum() / coarse.wear.sum() - 1),
        "implicit": rows,
        "plastic_share": sunk / volume,
    }


def run() -> Data:
    return {"cases": [compare(name) for name in CASES]}


def checks(data: Data) -> list[Check]:
    return [
        Check(
            f"{case['name']}, wear depth (L1) and volumes at tolerance {REQUIRED}",
            worst(case["implicit"][0][key] for key in ("volume", "depth", "plastic")),
            REQUIRED,
        )
        for case in data["cases"]
    ]


def text(data: Data) -> str:
    rows = [
        [
            case["name"],
            str(row["steps"]),
            percent(row["volume"]),
            percent(row["depth"]).lstrip("+"),
            percent(row["plastic"]) if case["plastic_share"] else "–",
        ]
        for case in data["cases"]
        for row in case["implicit"][:1]
    ]
    return f"""\
Default steps against {STEPS} and {2 * STEPS} explicit steps, extrapolated: X = 0.8, a/{CELLS}, {CYCLES:.0f} cycles, plastic limits of
1.5 p0 (smooth) and 1.8 p0 (rough).

{table(["", "steps", "wear volume", "wear depth, L1", "plastic volume"], rows)}
"""


SECTION = Section("explicit", "The integrator against explicit steps", run, text, checks)
