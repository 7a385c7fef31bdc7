"""The unworn smooth sphere against Hertz, Cattaneo and Mindlin."""

import numpy as np
from benchmarks.pages import Data, Section, named, worst
from tests.mechanics.problems import COUPLING, FRICTION, HERTZ, LOAD, P0, A, fretting

from fretwear.mechanics.wear.integrator import first_loading
from fretwear.mechanics.wear.measures import Measures
from fretwear.theory import PartialSlip

CELLS = 110  # on the contact radius
RATIOS = (0.2, 0.5, 0.8, 0.9)


def deviations(ratio: float) -> dict[str, float]:
    """Relative deviations from the closed forms at a ratio Q/µP."""
    problem = fretting(CELLS, load_ratio=ratio)
    theory = PartialSlip(HERTZ, FRICTION, ratio * FRICTION * LOAD, COUPLING)
    state = first_loading(problem)
    found = Measures(problem, state)
    window = state.geometry
    r = np.hypot(*np.meshgrid(window.x, window.y, indexing="ij"))
    annulus = (r > theory.stick_radius) & (r < A)
    slip = theory.slip(r)[annulus]
    slip_error = problem.slip(state.reduced)[annulus] - slip
    return {
        "peak_pressure": found.peak_pressure / P0 - 1,
        "approach": found.approach / HERTZ.approach - 1,
        "half_width": found.contact_half_width_x / A - 1,
        "displacement": found.tangential_displacement / theory.tangential_displacement - 1,
        "slip": float(np.abs(slip_error).max() / slip.max()),
        "energy": found.dissipated_energy / theory.dissipated_energy - 1,
    }


def run() -> Data:
    return {"ratios": [{"ratio": ratio, **deviations(ratio)} for ratio in RATIOS]}


def rows(data: Data) -> list[list[str]]:
    largest = {name: worst(row[name] for row in data["ratios"]) for name in data["ratios"][0]}
    found = {
        "pressure, approach, displacement": worst(
            largest[name] for name in ("peak_pressure", "approach", "displacement")
        ),
        "contact radius": largest["half_width"],
        "slip": largest["slip"],
        "energy": largest["energy"],
    }
    return [["unworn sphere", "Hertz, Cattaneo, Mindlin", named(found)]]


SECTION = Section("closed_forms", "Closed forms of the unworn sphere", run)
