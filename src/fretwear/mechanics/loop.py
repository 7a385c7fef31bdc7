"""The loop of force and displacement that a contact goes through in a cycle.

Under P = const the tangential force rises from zero by µ (P − P'), P' falling from P to P*, while
distant points move by µκ (d − d'), d' the approach of the same shape under P': one family of normal
contacts holds the whole curve. After a reversal it is run through at twice the size, as Masing
(1926) has it and Jäger (1998) shows for contacts, so a cycle dissipates ∮ Q dδ = ∬ 4µps dA.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretwear.mechanics.geometry import Array, Workspace
from fretwear.mechanics.slip import contact_under
from fretwear.mechanics.state import State, WearProblem

POINTS = 64
_CONTACTS = 8
_TOLERANCE = 1e-5


@dataclass(frozen=True)
class Loop:
    """Force, N, and displacement, m, round one cycle from +Q to −Q and back."""

    # At 4 · `POINTS` + 1 places, the first and the last the same; the displacement is that of the
    # rig where there is one in series.
    force: Array
    displacement: Array
    opening: float  # displacement U₀ at which the force vanishes, m

    @property
    def energy(self) -> float:
        """∮ Q dδ, J."""
        return float(np.trapezoid(self.force, self.displacement))


def loop(
    workspace: Workspace, state: State, contacts: int = _CONTACTS, points: int = POINTS
) -> Loop:
    """The loop of a state.

    Parameters
    ----------
    workspace
        Of the problem.
    state
        Whose shape is kept for the cycle.
    contacts
        How many contacts between those under P and P* are solved.
    points
        Places on a quarter of the loop.
    """
    problem: WearProblem = workspace.problem.of(state)
    if stroke := problem.loading.stroke:
        return _gliding(problem.friction.coefficient * state.load, stroke, points)
    ground, reduced = workspace.on(state.geometry), state.reduced
    shape = ground.unworn + state.opening + state.plastic
    lowest = float(shape.min())
    # In t, P' = P t³, the approach of a sphere is a parabola.
    least = np.cbrt(reduced.load / state.load)
    first = reduced.approach if reduced.load > 0.0 else lowest
    half = np.cbrt(0.5 * (1.0 + least**3))
    inner = 0.5 * (1.0 + least) - 0.5 * (1.0 - least) * np.cos(
        np.pi * np.arange(1, contacts) / contacts
    )
    places = np.unique([*inner, half])
    approaches, guess = [], state.pressure
    for place in places[::-1]:
        guess = guess * place**3 * state.load / state.geometry.integral(guess)
        contact = contact_under(
            ground.half_space, shape, float(place**3 * state.load), guess, _TOLERANCE
        )
        approaches.append(contact.approach)
        guess = contact.pressure
    known = np.array([least, *places, 1.0])
    approach = np.array([first, *approaches[::-1], state.approach])
    place = np.linspace(1.0, least, points + 1)
    coefficient = problem.friction.coefficient
    force = coefficient * state.load * (1.0 - place**3)
    fallen = state.approach - _interpolated(known, approach, place)
    compliance = coefficient * problem.coupling
    flexibility = problem.loading.flexibility
    displacement = compliance * fallen + flexibility * force
    largest = compliance * (state.approach - reduced.approach) + flexibility * force[-1]
    middle = float(approach[known == half][0])
    opening = largest - 2.0 * compliance * (state.approach - middle) - flexibility * force[-1]
    # From +Q down: twice the curve, then gliding to the other end where the whole contact slides.
    glide = np.linspace(largest - 2.0 * displacement[-1], -largest, points + 1)[1:]
    falling = np.concatenate([largest - 2.0 * displacement, glide])
    path = np.concatenate([force[-1] - 2.0 * force, np.full(points, -force[-1])])
    return Loop(np.concatenate([path, -path[1:]]), np.concatenate([falling, -falling[1:]]), opening)


def _gliding(force: float, stroke: float, points: int) -> Loop:
    """The loop of a contact of which the sliding alone is imposed: a rectangle."""
    reversal, glide = (
        np.linspace(force, -force, points + 1),
        np.linspace(stroke, -stroke, points + 1),
    )
    path = np.concatenate([reversal, np.full(points, -force)])
    way = np.concatenate([np.full(points + 1, stroke), glide[1:]])
    return Loop(np.concatenate([path, -path[1:]]), np.concatenate([way, -way[1:]]), stroke)


def _interpolated(known: Array, values: Array, places: Array) -> Array:
    """Values between some places, by a cubic spline."""
    from scipy.interpolate import CubicSpline

    result: Array = CubicSpline(known, values)(places)
    return result
