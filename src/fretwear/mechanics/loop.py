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
    # In t, P' = P t³, the approach of a sphere is a parabola.
    least = np.cbrt(state.reduced.load / state.load)
    angles = np.pi * np.arange(contacts + 1) / contacts
    known = 0.5 * (1.0 + least) - 0.5 * (1.0 - least) * np.cos(angles)
    approach = _approaches(workspace, problem, state, known)
    coefficient, flexibility = problem.friction.coefficient, problem.flexibility
    compliance = coefficient * problem.coupling
    place = np.linspace(1.0, least, points + 1)
    force = coefficient * state.load * (1.0 - place**3)
    fallen = approach[-1] - _interpolated(known, approach, place)
    displacement = compliance * fallen + flexibility * force
    largest = compliance * (state.approach - state.reduced.approach) + flexibility * force[-1]
    # From +Q down: twice the curve, then gliding to the other end where the whole contact slides.
    glide = np.linspace(largest - 2.0 * displacement[-1], -largest, points + 1)[1:]
    falling = np.concatenate([largest - 2.0 * displacement, glide])
    path = np.concatenate([force[-1] - 2.0 * force, np.full(points, -force[-1])])
    return Loop(np.concatenate([path, -path[1:]]), np.concatenate([falling, -falling[1:]]))


def opening(workspace: Workspace, state: State) -> float:
    """Displacement U₀, m, at which the force of the loop of a state vanishes."""
    problem: WearProblem = workspace.problem.of(state)
    if stroke := problem.loading.stroke:
        return stroke
    least = np.cbrt(state.reduced.load / state.load)
    places = np.array([least, np.cbrt(0.5 * (1.0 + least**3)), 1.0])
    _, half, whole = _approaches(workspace, problem, state, places)
    coefficient = problem.friction.coefficient
    # The rig gives way by twice half the largest force, and back by all of it.
    way = state.approach - state.reduced.approach - 2.0 * (whole - half)
    return float(coefficient * problem.coupling * way)


def _gliding(force: float, stroke: float, points: int) -> Loop:
    """The loop of a contact of which the sliding alone is imposed: a rectangle."""
    reversal, glide = (
        np.linspace(force, -force, points + 1),
        np.linspace(stroke, -stroke, points + 1),
    )
    path = np.concatenate([reversal, np.full(points, -force)])
    way = np.concatenate([np.full(points + 1, stroke), glide[1:]])
    return Loop(np.concatenate([path, -path[1:]]), np.concatenate([way, -way[1:]]))


def _approaches(workspace: Workspace, problem: WearProblem, state: State, places: Array) -> Array:
    """Approaches, m, of the present shape under P t³; of the unworn one if slip is its slip."""
    if not problem.slip_model.follows_shape:
        return problem.hertz.approach * places**2
    ground = workspace.on(state.geometry)
    shape = ground.unworn + state.opening + state.plastic
    reduced, found = state.reduced, [state.approach]
    # The square of the pressure of a sphere falls evenly with t².
    after, square = 1.0, state.pressure**2
    stick = reduced.pressure > 0.0
    fall = (square - reduced.pressure**2) / (1.0 - places[0] ** 2)
    fall = np.where(stick, fall, np.mean(fall[stick])) if stick.any() else square
    for place in places[-2:0:-1]:
        load = float(state.load * place**3)
        guess = np.sqrt(np.maximum(square - (after**2 - place**2) * fall, 0.0))
        # Nothing is left where it falls faster than that; any start will do.
        guess = guess if guess.any() else np.sqrt(square)
        guess *= load / state.geometry.integral(guess)
        contact = contact_under(ground.half_space, shape, load, guess, _TOLERANCE)
        found.append(contact.approach)
        before, after, last, square = after, place, square, contact.pressure**2
        fall = (last - square) / (before**2 - after**2)
    found.append(reduced.approach if reduced.load > 0.0 else float(shape.min()))
    return np.array(found[::-1])


def _interpolated(known: Array, values: Array, places: Array) -> Array:
    """The cubic spline through values at known places: not-a-knot, as de Boor (1978) has it."""
    widths = np.diff(known)
    slopes = np.diff(values) / widths
    # Second derivatives; at both ends they are straight over two intervals.
    matrix = np.zeros((known.size, known.size))
    right = np.zeros(known.size)
    inner = np.arange(1, known.size - 1)
    matrix[inner, inner - 1], matrix[inner, inner + 1] = widths[:-1], widths[1:]
    matrix[inner, inner] = 2.0 * (widths[:-1] + widths[1:])
    right[inner] = 6.0 * np.diff(slopes)
    for row, (first, second) in ((0, widths[:2]), (-1, widths[-2:])):
        ends = slice(0, 3) if row == 0 else slice(-3, None)
        matrix[row, ends] = second, -(first + second), first
    bends = np.linalg.solve(matrix, right)
    left = np.clip(np.searchsorted(known, places, "right") - 1, 0, known.size - 2)
    way, width = places - known[left], widths[left]
    bend, change = bends[left], bends[left + 1] - bends[left]
    slope = slopes[left] - width * (3.0 * bend + change) / 6.0
    result: Array = values[left] + way * (slope + way * (bend / 2.0 + way * change / (6.0 * width)))
    return result
