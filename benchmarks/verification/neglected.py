"""What the model neglects, solved for what it is: two tangential directions, unlike bodies."""

import numpy as np
from benchmarks.pages import Check, Data, Section, table
from tests.mechanics.neglected import UnlikeCylinder, VectorFriction

RATIO, CELLS, TIMES = 0.8, 16, (0.25, 1.0, 3.0)
POISSON = (0.2, 0.3, 0.45)
FRICTION = 0.3
DRAGGED = ((0.1, 0.3), (0.39, 0.3), (1.0, 0.3), (0.1, 0.6), (0.39, 0.6), (1.0, 0.6))
LIFTED = ((0.03, 0.3), (0.1, 0.1), (0.1, 0.3), (0.09, 0.9), (0.3, 0.3))
FORGOTTEN = 1e-12
STRIPS = 128


def first_cycle(poisson_ratio: float) -> Data:
    """Energy and slip of the unworn contact, relative to a single direction."""
    single, vector = (VectorFriction(poisson_ratio, RATIO, CELLS, n) for n in (1, 2))
    pressure = single.pressed()
    alone, both = (sphere.slip(pressure)[0] for sphere in (single, vector))
    middle = np.abs(np.hypot(*single.places) - 0.8) < 0.1
    along = (
        sphere.along(np.where(middle, s, 0.0)) for sphere, s in ((vector, both), (single, alone))
    )
    x, y = (float(there.sum() / here.sum()) for there, here in zip(*along, strict=True))
    return {
        "nu": poisson_ratio,
        "energy": float(pressure @ both / (pressure @ alone)),
        "x": x,
        "y": y,
    }


def wear(poisson_ratio: float) -> list[Data]:
    """Volume and depths at some times, relative to a single direction."""
    single, vector = (VectorFriction(poisson_ratio, RATIO, CELLS, n) for n in (1, 2))
    rows = []
    for tau, alone, both in zip(TIMES, single.worn(TIMES), vector.worn(TIMES), strict=True):
        along = zip(vector.along(both), single.along(alone), strict=True)
        x, y = (float(there.max() / here.max()) for there, here in along)
        volume, deepest = both.sum() / alone.sum(), both.max() / alone.max()
        rows.append(
            {"tau": tau, "volume": float(volume), "deepest": float(deepest), "x": x, "y": y}
        )
    return rows


def dragged(ratio: float, force: float) -> Data:
    """Cycles of unlike cylinders relative to alike ones, if pressure alone couples."""
    alike, unlike = (
        UnlikeCylinder(beta, FRICTION, lifts=False).cycles(force, 3)
        for beta in (0.0, ratio * FRICTION)
    )
    return {
        "beta over friction": ratio,
        "ratio": force,
        "first": unlike[0].energy / alike[0].energy - 1,
        "later": [
            max(
                float(np.abs(one.path - same.path).max() / same.path.max()),
                float(np.abs(one.wear - same.wear).max() / same.wear.max()),
                abs(one.energy / same.energy - 1),
            )
            for one, same in zip(unlike[1:], alike[1:], strict=True)
        ],
        "mean": float(np.abs(unlike[-1].mean_traction).max()) / (FRICTION / 2),
    }


def lifted(beta: float, friction: float) -> Data:
    """The second cycle where tractions move the surfaces normally too."""
    alike, unlike = (
        UnlikeCylinder(each, friction, lifts=True, strips=STRIPS).cycles(0.6, 2, 8, loading=16)[-1]
        for each in (0.0, beta)
    )
    change = np.abs(unlike.wear - alike.wear).sum() / alike.wear.sum()
    return {
        "beta": beta,
        "friction": friction,
        "energy": unlike.energy / alike.energy - 1,
        "local": float(change),
    }


def run() -> Data:
    return {
        "cycle": [first_cycle(nu) for nu in POISSON],
        "wear": wear(0.3),
        "dragged": [dragged(*each) for each in DRAGGED],
        "lifted": [lifted(*each) for each in LIFTED],
    }


def checks(data: Data) -> list[Check]:
    later = max(max(row["later"]) for row in data["dragged"])
    return [Check("unlike bodies: later cycles forget the loading", later, FORGOTTEN)]


def text(data: Data) -> str:
    def change(factor: float) -> str:
        return f"{100 * (factor - 1):+.1f} %".replace("-", "−")

    cycle = [
        [str(row["nu"]), change(row["energy"]), change(row["x"]), change(row["y"])]
        for row in data["cycle"]
    ]
    worn = [
        [str(row["tau"]), *(change(row[name]) for name in ("volume", "deepest", "x", "y"))]
        for row in data["wear"]
    ]
    pulled = [
        [
            str(row["beta over friction"]),
            str(row["ratio"]),
            change(1 + row["first"]),
            f"{max(row['later']):.0e}",
            f"{row['mean']:.2f}",
        ]
        for row in data["dragged"]
    ]
    moved = [
        [
            str(row["beta"]),
            str(row["friction"]),
            change(1 + row["energy"]),
            f"{-100 * 2 * row['beta'] ** 2:.1f} %".replace("-", "−"),
            f"{100 * row['local']:.1f} %",
            f"{100 * row['beta'] * (row['friction'] + 2 * row['beta']):.1f} %",
        ]
        for row in data["lifted"]
    ]
    mean = "mean traction/µp0"
    return f"""\
`tests/mechanics/neglected.py` solves what the model leaves out.

**Two tangential directions.** Friction as a vector on a smooth sphere, X = {RATIO}, {CELLS} cells
on the contact radius, against the same solver with one direction. Energy of the unworn contact, and
its slip beside both axes, between 0.7 and 0.9 a:

{table(["ν", "energy", "slip, x axis", "slip, y axis"], cycle)}

Wear at ν = 0.3, by explicit steps: maximum depth, and depth beside both axes.

{table(["τ", "wear volume", "maximum", "x axis", "y axis"], worn)}

**Unlike bodies.** A cylinder is loaded and cycled in increments, with Coulomb friction from the
start and Dundurs' β. While tractions move the surfaces along x only, slip, wear and energy are
the values for β = 0 from the second cycle on; the tractions at +Q and −Q keep a mean where the
contact sticks.

{table(["β/µ", "X", "energy, cycle 1", "difference, cycles 2 and 3", mean], pulled)}

Where tractions move the surfaces along z too, the pressure changes in every cycle. At X = 0.6,
beside the estimates of the warning; local wear is the mean difference over the mean:

{table(["β", "µ", "energy", "−2β²", "local wear", "β(µ + 2β)"], moved)}
"""


SECTION = Section("neglected", "What the model neglects", run, text, checks)
