"""The contacts of the table, taken from the source study."""

import math
from typing import Any

from fretwear import Case
from fretwear.mechanics.contact.cells import ContactProblem
from fretwear.mechanics.contact.grid import Grid
from fretwear.run import simulate

STUDY: dict[str, Any] = {
    "radius": "10 mm",
    "youngs_modulus": "208 GPa",
    "poisson_ratio": 0.3,
    "load": "50 N",
    "tangential_load": "20 N",
    "friction": 0.5,
    "wear_coefficient": "7e-13 / Pa",
    "cycles": 30000,
}
WAVES = {"kind": "wavy", "amplitude": "0.2 um", "slope_x": "5.7 deg", "slope_y": "1 deg"}
LIMIT = "4500 MPa"
MARGIN = 1.15


def study_case(**changes: Any) -> Case:
    """The study's case with some parameters changed."""
    return Case(**{**STUDY, **changes})


def smooth_case(cells_on_radius: float, **changes: Any) -> Case:
    """The smooth elastic case with so many cells on the Hertz radius."""
    spacing = study_case().hertz_radius / cells_on_radius
    return study_case(cell=(spacing, spacing), **changes)


def rough_case(coarser: float = 1.0, cycles: int = 7000) -> Case:
    """The rough capped case; spacing 0.5 µm × 2 µm, times a factor."""
    cell = (0.5e-6 * coarser, 2e-6 * coarser)
    return study_case(roughness=WAVES, plastic_limit=LIMIT, cycles=cycles, cell=cell)


def first_contact(cells: int, *, rough: bool) -> ContactProblem:
    """The first loading on so many quarter cells along x and y: smooth elastic or rough capped."""
    case = study_case(**({"roughness": WAVES, "plastic_limit": LIMIT} if rough else {}))
    problem = simulate.wear_problem(case)
    size = MARGIN * case.hertz_radius / cells
    window = Grid((cells, cells), (size, size))
    bodies = window.half_space(problem.bodies.composite_modulus)
    limit = problem.plastic_limit if rough else math.inf
    return ContactProblem(bodies, problem.unworn(window), problem.hertz.load, limit)
