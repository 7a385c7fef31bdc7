"""The unworn smooth sphere: Hertz, Cattaneo and Mindlin against the spacing."""

import numpy as np
from benchmarks.pages import Check, Data, Section, order_of, percent, table, worst
from tests.mechanics.problems import COUPLING, FRICTION, HERTZ, LOAD, P0, A, fretting

from fretwear.mechanics.wear.integrator import first_loading
from fretwear.mechanics.wear.measures import Measures
from fretwear.theory import PartialSlip

CELLS = (32, 45, 64, 91, 110, 128, 156, 181, 220)
REQUIRED_AT = 110
RATIO, RATIOS = 0.8, (0.2, 0.5, 0.8, 0.9)
NAMES = {
    "peak_pressure": "peak pressure",
    "approach": "approach",
    "half_width": "contact half-width",
    "area": "contact area",
    "pressure": "pressure, L1",
    "stick_area": "stick area",
    "displacement": "tangential displacement",
    "slip": "slip, largest error",
    "energy": "dissipated energy",
}
REQUIRED = {
    "peak_pressure": 1e-3,
    "approach": 5e-4,
    "half_width": 3e-3,
    "slip": 1e-2,
    "energy": 5e-3,
}
TANGENTIAL = ("stick_area", "displacement", "slip", "energy")


def deviations(cells: float, ratio: float) -> dict[str, float]:
    """Relative deviations from the closed forms with ``cells`` cells on the contact radius."""
    problem = fretting(cells, load_ratio=ratio)
    theory = PartialSlip(HERTZ, FRICTION, ratio * FRICTION * LOAD, COUPLING)
    state = first_loading(problem)
    found = Measures(problem, state)
    window = state.geometry
    r = np.hypot(*np.meshgrid(window.x, window.y, indexing="ij"))
    annulus = (r > theory.stick_radius) & (r < A)
    slip = theory.slip(r)[annulus]
    slip_error = problem.slip(state.reduced)[annulus] - slip
    stick_area = np.pi * theory.stick_radius**2
    return {
        "peak_pressure": found.peak_pressure / P0 - 1,
        "approach": found.approach / HERTZ.approach - 1,
        "half_width": found.contact_half_width_x / A - 1,
        "area": found.contact_area / (np.pi * A**2) - 1,
        "pressure": window.integral(np.abs(state.pressure - HERTZ.pressure(r))) / LOAD,
        "stick_area": found.stick_area / stick_area - 1,
        "displacement": found.tangential_displacement / theory.tangential_displacement - 1,
        "slip": float(np.abs(slip_error).max() / slip.max()),
        "energy": found.dissipated_energy / theory.dissipated_energy - 1,
    }


def run() -> Data:
    return {
        "spacings": [{"cells": cells, **deviations(cells, RATIO)} for cells in CELLS],
        "ratios": [{"ratio": ratio, **deviations(REQUIRED_AT, ratio)} for ratio in RATIOS],
    }


def checks(data: Data) -> list[Check]:
    return [
        Check(
            f"{NAMES[name]}, a/{REQUIRED_AT}",
            max((row[name] for row in data["ratios"]), key=abs),
            required,
        )
        for name, required in REQUIRED.items()
    ]


def text(data: Data) -> str:
    spacing = [1 / row["cells"] for row in data["spacings"]]
    shown = [row for row in data["spacings"] if row["cells"] in (110, 220)]
    found = table(
        ["deviation", *(f"a/{row['cells']}" for row in shown), "order", "largest, four X"],
        (
            [
                label,
                *(percent(row[name]) for row in shown),
                _order(spacing, [row[name] for row in data["spacings"]]),
                percent(worst(row[name] for row in data["ratios"])) if name in TANGENTIAL else "",
            ]
            for name, label in NAMES.items()
        ),
    )
    ratios = ", ".join(f"{row['ratio']}" for row in data["ratios"])
    return f"""\
The first loading against Hertz (1882), Cattaneo (1938) and Mindlin (1949) at X = {RATIO}; last column: largest deviation at
a/{REQUIRED_AT} for X = {ratios}.

{found}
"""


def _order(spacing: list[float], errors: list[float]) -> str:
    return f"{order_of(spacing, errors):.1f}" if min(errors) * max(errors) > 0 else "–"


SECTION = Section("closed_forms", "Closed forms of the unworn sphere", run, text, checks)
