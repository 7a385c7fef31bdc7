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
    from scipy.interpolate import CubicSpline

    problem: WearProblem = workspace.problem.of(state)
    if stroke := problem.loading.stroke:
        return _gliding(problem.friction.coefficient * state.load, stroke, points)
    reduced = state.reduced
    # In t, P' = P t³, the approach of a sphere is a parabola.
    least = np.cbrt(reduced.load / state.load)
    half = np.cbrt(0.5 * (1.0 + least**3))
    angles = np.pi * np.arange(1, contacts) / contacts
    inner = 0.5 * (1.0 + least) - 0.5 * (1.0 - least) * np.cos(angles)
    known = np.array([least, *np.unique([*inner, half]), 1.0])
    approach = _approaches(workspace, problem, state, known)
    coefficient, flexibility = problem.friction.coefficient, problem.loading.flexibility
    compliance = coefficient * problem.coupling
    place = np.linspace(1.0, least, points + 1)
    force = coefficient * state.load * (1.0 - place**3)
    fallen = approach[-1] - CubicSpline(known, approach)(place)
    displacement = compliance * fallen + flexibility * force
    largest = compliance * (state.approach - reduced.approach) + flexibility * force[-1]
    middle = float(approach[known == half][0])
    opening = largest - 2.0 * compliance * (approach[-1] - middle) - flexibility * force[-1]
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


def _approaches(workspace: Workspace, problem: WearProblem, state: State, places: Array) -> Array:
    """Approaches, m, of the present shape under P t³; of the unworn one if slip is its slip."""
    if not problem.slip_model.follows_shape:
        return problem.hertz.approach * places**2
    ground = workspace.on(state.geometry)
    shape = ground.unworn + state.opening + state.plastic
    found, guess = [state.approach], state.pressure
    for load in state.load * places[-2:0:-1] ** 3:
        guess = guess * (load / state.geometry.integral(guess))
        contact = contact_under(ground.half_space, shape, float(load), guess, _TOLERANCE)
        found.append(contact.approach)
        guess = contact.pressure
    reduced = state.reduced
    found.append(reduced.approach if reduced.load > 0.0 else float(shape.min()))
    return np.array(found[::-1])
