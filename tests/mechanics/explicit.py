"""Wear by small explicit steps: Archard's law as it is written, one contact after the other."""

from dataclasses import dataclass

import numpy as np

from fretwear.mechanics.contact import ContactProblem
from fretwear.mechanics.geometry import Array
from fretwear.mechanics.geometry.grid import Grid
from fretwear.mechanics.solver import solve_contact
from fretwear.mechanics.state import WearProblem

_TOLERANCE = 1e-9


@dataclass(frozen=True)
class Worn:
    """Wear and plastic depth, m, pressure, Pa, and gap of the reduced problem, m."""

    wear: Array
    plastic: Array
    pressure: Array
    reduced_gap: Array


def explicit_wear(problem: WearProblem, window: Grid, cycles: float, steps: int) -> Worn:
    """Euler's method for dW/dN = β p g* on a window that the contact never leaves.

    Before each step the bodies yield where the pressure reaches its limit, for good, and the
    contact at the reduced load is solved on the shape of that moment.
    """
    bodies, unworn = problem.half_space(window), problem.unworn(window)
    rate = problem.growth_rate * cycles / steps
    wear, plastic = np.zeros(window.shape), np.zeros(window.shape)
    pressure, reduced = None, None
    for step in range(steps + 1):
        contact = solve_contact(
            problem.contact(bodies, unworn + wear + plastic), pressure, _TOLERANCE
        )
        pressure = contact.pressure
        plastic = plastic + contact.penetration
        if reduced is None or contact.penetration.any():
            reduced = solve_contact(
                ContactProblem(bodies, unworn + wear + plastic, problem.stick_load),
                None if reduced is None else reduced.pressure,
                _TOLERANCE,
            )
            gap = np.where(reduced.pressure > 0, 0.0, np.maximum(reduced.gap, 0.0))
        if step < steps:
            worn = rate * pressure * gap
            wear = wear + worn
            gap = gap + worn
    return Worn(wear, plastic, pressure, gap)
