"""The loop of force and displacement of a cycle.

Under P = const the tangential force rises from zero by µ (P − P') as P' falls from P to P*, while
distant points move by µκ (d − d'), d' being the approach of the same shape under P'. So one family
of normal contacts gives the whole curve. After a reversal the curve is followed at twice the size
(Masing 1926; for contacts Jäger 1998).

The curve of d against P is concave. Betti's theorem gives the area between the curve and a chord
without contacts in between: twice that area is ∬ p g dA with the pressure at one end and the gap at
the other. With the area of the whole curve, ∮ Q dδ = ∬ 4µps dA.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fretwear.arrays import Array
from fretwear.mechanics.slip.coupled import Sheared
from fretwear.mechanics.slip.models import Pressed, ReducedContact, contact_under, lowered
from fretwear.mechanics.wear.state import Pulse, State, WearProblem, Workspace
from fretwear.theory import HertzContact

# Points of a quarter of a loop, largest number of contacts solved between its ends, and accuracy
# with which they must predict the next point.
POINTS, _CONTACTS, _CLOSE = 64, 4, 1e-3
# Flatter arcs need no contacts: the area of the curve gives them more accurately.
_STRAIGHT, _TOLERANCE = 1e-6, 1e-4
# Contacts of similar shapes start from each other if their loads differ by no more than this part.
_SIMILAR = 0.2
# Exponent of the load in the approach of a sphere.
_SPHERE = 2.0 / 3.0


@dataclass(frozen=True)
class Loop:
    """Force, N, and displacement, m, over one cycle from +Q to −Q and back.

    There are 4 · `POINTS` + 1 phases, the first equal to the last; the displacement includes the
    rig in series.
    """

    force: Array
    displacement: Array
    opening: float  # displacement U₀, m, at which the force vanishes


def loop(workspace: Workspace, state: State) -> Loop:
    """The loop of a state, whose shape does not change during the cycle.

    Contacts between P and P* are solved until the curve is accurate to a thousandth of the
    displacement.
    """
    problem: WearProblem = workspace.problem.of(state)
    coefficient, flexibility = problem.friction_law.coefficient, problem.flexibility
    if state.pulse is not None:
        return _pulsating_loop(problem, state, state.pulse)
    if largest := problem.loading.stroke:
        force, opening = coefficient * state.load * np.linspace(0.0, 1.0, POINTS + 1), largest
        displacement = np.zeros_like(force)
    else:
        loads, approaches, halfway = _curve(workspace, problem, state)
        compliance = coefficient * problem.coupling
        force = coefficient * (loads[0] - loads)
        displacement = compliance * (approaches[0] - approaches)
        half = compliance * (approaches[0] - halfway)
        # The rig gives way by twice half the largest force, and back by all of it.
        opening = compliance * (approaches[0] - state.reduced.approach) - 2.0 * half
        if state.reduced.sheared is not None:
            force, displacement, half = _of_vectors(
                state.reduced.sheared, force, displacement, half
            )
            opening = state.reduced.sheared.displacement - 2.0 * half
        displacement = displacement + flexibility * force
        largest = problem.tangential_displacement(state.approach, state.reduced)
        largest += flexibility * float(force[-1])
    # From +Q down: twice the curve; then gliding to the other end if the whole contact slides.
    glide = np.linspace(largest - 2.0 * displacement[-1], -largest, POINTS + 1)[1:]
    falling = np.concatenate([largest - 2.0 * displacement, glide])
    path = np.concatenate([force[-1] - 2.0 * force, np.full(POINTS, -force[-1])])
    force, displacement = (np.concatenate([half, -half[1:]]) for half in (path, falling))
    if problem.wears_unevenly:
        force *= problem.load_at(displacement / largest) / state.load
    return Loop(force, displacement, opening)


def _pulsating_loop(problem: WearProblem, state: State, pulse: Pulse) -> Loop:
    """The loop under a load in phase with the force, whose halves differ.

    Distant points have moved by µκ [d(P) + d(P₁) − 2d(P′)] since the force was −Q, and back by µκ
    [d(P₂) + d(P) − 2d(P″)] since it was Q: `fretwear.mechanics.wear.pulsating`.
    """
    compliance = problem.friction_law.coefficient * problem.coupling
    phase = np.linspace(0.0, 1.0, 2 * POINTS + 1)
    least, low, high = pulse.least_load, state.reduced.load, state.load
    approaches = pulse.approach(least + (high - least) * phase)
    rising, falling = (
        approaches + float(pulse.approach(end)) - 2.0 * pulse.approach(end + (low - end) * way)
        for end, way in ((least, phase), (high, phase[::-1]))
    )
    amplitude = problem.tangential_displacement(state.mean_approach, state.reduced)
    up, down = compliance * rising - amplitude, amplitude - compliance * falling
    force = problem.tangential_force(high, state.reduced) * (2.0 * phase - 1.0)
    return Loop(
        np.concatenate([force[::-1], force[1:]]),
        np.concatenate([down[::-1], up[1:]]),
        0.5 * float(down[POINTS] - up[POINTS]),
    )


def _curve(workspace: Workspace, problem: WearProblem, state: State) -> tuple[Array, Array, float]:
    """Loads, N, from P to P*, the approaches, m, under them, and the approach under their mean."""
    if not problem.slip_model.follows_shape:
        return _unworn_curve(problem.hertz, state.reduced.load)
    geometry, low = state.geometry, state.reduced
    slipping = problem.friction_law.ratio * state.pressure, state.gap, state.approach
    high = ReducedContact(*slipping, problem.slipping_load(state, geometry))
    bodies = workspace.on(geometry)
    shape = bodies.unworn + state.opening + state.plastic
    sliding = problem.reduced_condition(state.load, state.approach)
    whole_contact = state.pressure, state.gap, state.approach
    pressed = Pressed(bodies.half_space, shape, *whole_contact, sliding, _TOLERANCE)
    half_space, shape = problem.slip_model.family(problem, pressed)
    if not low.load > 0.0:
        lowest = float(shape.min())
        low = replace(low, gap=shape - lowest, approach=lowest)
    whole = geometry.integral(low.gap * high.pressure)
    family, areas, rise = [low, high], [whole], high.approach - low.approach
    halfway = _approach_between(low, high, whole)
    bends = whole > _STRAIGHT * rise * (high.load - low.load)
    similar, workspace.of_loop = workspace.of_loop, []
    for number in range(_CONTACTS if bends else 0):
        # Halfway where the curve bends most, at first between its ends.
        index = int(np.argmax(areas))
        lower, upper = family[index : index + 2]
        load = 0.5 * (lower.load + upper.load)
        guess = lowered(upper.pressure, load / upper.load)
        if number < len(similar) and abs(similar[number][1].load - load) < _SIMILAR * load:
            cells, contact = similar[number]
            guess = cells.resized(contact.pressure, geometry)
        guess *= load / geometry.integral(guess)
        contact = contact_under(half_space, shape, load, None, guess, _TOLERANCE)
        workspace.of_loop.append((geometry, contact))
        expected = _approach_between(lower, upper, areas[index])
        halfway = halfway if number else contact.approach
        family.insert(index + 1, contact)
        areas[index : index + 1] = [
            geometry.integral(lower.gap * contact.pressure),
            geometry.integral(contact.gap * upper.pressure),
        ]
        if abs(contact.approach - expected) <= _CLOSE * rise:
            break
    return (*_sampled(family, areas, whole), halfway)


def _of_vectors(
    sheared: Sheared, force: Array, displacement: Array, half: float
) -> tuple[Array, Array, float]:
    """The curve of friction in two directions from the curve in one, and its middle by force.

    The curve ends at the force, N, and the displacement, m, of the tractions. Its depth below the
    chord is scaled until the area below it is their energy, whose derivative by Q is δ.
    """
    end = sheared.displacement if sheared.stick.any() else float(displacement[-1])
    chord, force = displacement[-1] / force[-1] * force, sheared.force / force[-1] * force
    arc, depth = displacement - chord, half - 0.5 * float(displacement[-1])
    area = float(np.trapezoid(arc, force))
    scale = (sheared.energy - 0.5 * end * sheared.force) / area if area else 0.0
    return force, end / sheared.force * force + scale * arc, 0.5 * end + scale * depth


def _unworn_curve(hertz: HertzContact, least: float) -> tuple[Array, Array, float]:
    """`_curve` of the unworn smooth contact, from its load to a reduced one, N, in closed form.

    The heights above the chord are scaled until the polygon has the area of the curve.
    """

    def approach_under(load: float) -> float:
        return hertz.with_load(load).approach if load > 0.0 else 0.0

    # Cube roots of the loads; Gaussian nodes for the area.
    ends = np.cbrt([least, hertz.load])
    nodes, weights = np.polynomial.legendre.leggauss(POINTS)
    roots = ends.mean() + 0.5 * np.diff(ends) * nodes
    loads = np.linspace(ends[1], ends[0], POINTS + 1) ** 3
    loads[[0, -1]] = hertz.load, least
    approaches = np.array([*map(approach_under, loads)])
    exact = np.array([*map(approach_under, roots**3)]) @ (weights * 3.0 * roots**2)
    exact *= 0.5 * float(np.diff(ends)[0])
    chord = np.interp(loads, loads[[-1, 0]], approaches[[-1, 0]])
    arc, area = approaches - chord, -float(np.trapezoid(chord, loads))
    arc *= (exact - area) / -float(np.trapezoid(arc, loads))
    return loads, chord + arc, approach_under(0.5 * (least + hertz.load))


def _sampled(family: list[ReducedContact], areas: list[float], whole: float) -> tuple[Array, Array]:
    """Loads and approaches from the last contact of a family to the first.

    Between two contacts the curve is their chord plus the arc of a sphere's curve. Scaled arcs give
    the area between each pair, and the areas sum up to that of the whole curve.
    """
    corners, approaches = np.array([(contact.load, contact.approach) for contact in family]).T
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


def _arc(lower: float, upper: float, loads: Array | float = 0.0) -> tuple[Array, float]:
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
