"""The loop of force and displacement that a contact goes through in a cycle.

Under P = const the tangential force rises from zero by µ (P − P') as P' falls from P to P*, while
distant points move by µκ (d − d'), d' being the approach of the same shape under P': one family of
normal contacts gives the whole curve. After a reversal it is followed at twice the size (Masing
1926; for contacts Jäger 1998).

The curve of d against P is concave, and the area between it and a chord is known without any
contact in between: with Betti's theorem, twice that area is ∬ p g dA with the pressure of the one
end and the gap of the other. That of the whole curve makes ∮ Q dδ = ∬ 4µps dA.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fretwear.mechanics.geometry import Array, Workspace
from fretwear.mechanics.slip import ReducedContact, contact_under
from fretwear.mechanics.state import State, WearProblem

POINTS = 64
_CONTACTS = 4
_CLOSE = 1e-3
# A curve with an arc this flat is known from its area better than contacts are solved.
_STRAIGHT = 1e-6
_TOLERANCE = 1e-5
# Exponent of the load in the approach of a sphere.
_SPHERE = 2.0 / 3.0


@dataclass(frozen=True)
class Loop:
    """Force, N, and displacement, m, round one cycle from +Q to −Q and back.

    At 4 · `POINTS` + 1 phases, the first equal to the last; the displacement includes that of a rig
    in series.
    """

    force: Array
    displacement: Array
    opening: float  # displacement U₀, m, at which the force vanishes

    @property
    def energy(self) -> float:
        """∮ Q dδ, J."""
        return float(np.trapezoid(self.force, self.displacement))


def loop(workspace: Workspace, state: State, contacts: int = _CONTACTS) -> Loop:
    """The loop of a state of a problem, whose shape is kept for the cycle.

    A limited number of contacts between P and P* are solved, fewer if the curve is known earlier to
    a thousandth of the displacement.
    """
    problem: WearProblem = workspace.problem.of(state)
    coefficient, flexibility = problem.friction.coefficient, problem.flexibility
    if stroke := problem.loading.stroke:
        force = coefficient * state.load * np.linspace(0.0, 1.0, POINTS + 1)
        return _masing(force, np.zeros_like(force), stroke, stroke)
    loads, approaches, halfway = _curve(workspace, problem, state, contacts)
    compliance, force = coefficient * problem.coupling, coefficient * (state.load - loads)
    displacement = compliance * (state.approach - approaches) + flexibility * force
    largest = compliance * (state.approach - state.reduced.approach) + flexibility * force[-1]
    # The rig gives way by twice half the largest force, and back by all of it.
    slid = compliance * (2.0 * halfway - state.approach - state.reduced.approach)
    return _masing(force, displacement, largest, slid)


def _masing(force: Array, displacement: Array, largest: float, opening: float) -> Loop:
    """The loop that follows from a curve of first loading, with gliding up to the largest U."""
    # From +Q down: twice the curve, then gliding to the other end where the whole contact slides.
    glide = np.linspace(largest - 2.0 * displacement[-1], -largest, POINTS + 1)[1:]
    falling = np.concatenate([largest - 2.0 * displacement, glide])
    path = np.concatenate([force[-1] - 2.0 * force, np.full(POINTS, -force[-1])])
    return Loop(np.concatenate([path, -path[1:]]), np.concatenate([falling, -falling[1:]]), opening)


def _curve(
    workspace: Workspace, problem: WearProblem, state: State, contacts: int
) -> tuple[Array, Array, float]:
    """Loads, N, from P to P*, approaches, m, under them, and that under their mean."""
    geometry, low = state.geometry, state.reduced
    high = ReducedContact(state.pressure, state.gap, state.approach, state.load)
    if problem.slip_model.follows_shape:
        ground = workspace.on(geometry)
        shape = ground.unworn + state.opening + state.plastic
        if not low.load > 0.0:
            lowest = float(shape.min())
            low = replace(low, gap=shape - lowest, approach=lowest)
        whole = geometry.integral(low.gap * high.pressure)
    else:
        # The loop of the unworn sphere, whose slip is used.
        contacts, high = 0, replace(high, approach=problem.hertz.approach)
        low = replace(low, approach=high.approach * (low.load / high.load) ** _SPHERE)
        whole = 2.0 * high.approach / high.load**_SPHERE * _arc(low.load, high.load)[1]
    family, areas, rise = [low, high], [whole], high.approach - low.approach
    halfway = _approach_between(low, high, whole)
    if whole <= _STRAIGHT * rise * (high.load - low.load):
        contacts = 0
    for found_before in range(contacts):
        # Halfway where the curve bends most, which is between its ends at first.
        at = int(np.argmax(areas))
        lower, upper = family[at : at + 2]
        load = 0.5 * (lower.load + upper.load)
        # The square of the pressure of a sphere falls evenly with P^(2/3), to zero beyond its edge.
        least, most, place = (each**_SPHERE for each in (lower.load, upper.load, load))
        square, stick = upper.pressure**2, lower.stick
        fall = square - lower.pressure**2
        fall = np.where(stick, fall, fall[stick].mean() if stick.any() else square.max())
        guess = np.sqrt(np.maximum(square - (most - place) / (most - least) * fall, 0.0))
        guess *= load / geometry.integral(guess)
        found = contact_under(ground.half_space, shape, load, None, guess, _TOLERANCE)
        expected = _approach_between(lower, upper, areas[at])
        halfway = halfway if found_before else found.approach
        family.insert(at + 1, found)
        areas[at : at + 1] = [
            geometry.integral(lower.gap * found.pressure),
            geometry.integral(found.gap * upper.pressure),
        ]
        if abs(found.approach - expected) <= _CLOSE * rise:
            break
    return (*_sampled(family, areas, whole), halfway)


def _sampled(family: list[ReducedContact], areas: list[float], whole: float) -> tuple[Array, Array]:
    """Loads and approaches from the last contact of a family to the first.

    Between two contacts, their chord and as much of the arc of a sphere's curve as leaves twice
    the area between them, and in sum twice that of the whole curve.
    """
    corners, approaches = np.array([(each.load, each.approach) for each in family]).T
    ends = np.trapezoid(approaches[[0, -1]], corners[[0, -1]])
    chords = 2.0 * (np.trapezoid(approaches, corners) - ends)
    fit = (whole - chords) / sum(areas) if whole > 0.0 else 0.0
    steps = np.diff(np.linspace(0, POINTS, len(areas) + 1).round().astype(int))
    loads, curve = [corners[:1]], [approaches[:1]]
    for lower, upper, area, count in zip(family, family[1:], areas, steps, strict=False):
        places = np.linspace(np.cbrt(lower.load), np.cbrt(upper.load), count + 1) ** 3
        places[[0, -1]] = lower.load, upper.load
        arc = _arc(lower.load, upper.load, places)[0]
        arc *= 0.5 * fit * area / np.trapezoid(arc, places)
        chord = np.interp(places, (lower.load, upper.load), (lower.approach, upper.approach))
        loads.append(places[1:])
        curve.append((chord + arc)[1:])
    return np.concatenate(loads)[::-1], np.concatenate(curve)[::-1]


def _arc(lower: float, upper: float, loads: Array | float = 0.0) -> tuple[Any, float]:
    """Height of P^(2/3) above its chord between two loads, and the area between them."""
    ends = np.array([lower, upper])
    heights = ends**_SPHERE
    area = 0.6 * float(upper ** (1.0 + _SPHERE) - lower ** (1.0 + _SPHERE))
    arc = np.asarray(loads) ** _SPHERE - np.interp(loads, ends, heights)
    return arc, area - float(np.trapezoid(heights, ends))


def _approach_between(lower: ReducedContact, upper: ReducedContact, area: float) -> float:
    """Approach, m, under the mean of two loads."""
    arc, whole = _arc(lower.load, upper.load, 0.5 * (lower.load + upper.load))
    return float(0.5 * (lower.approach + upper.approach + area / whole * arc))
