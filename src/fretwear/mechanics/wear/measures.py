"""Numbers that describe a state of the contact, and the loop of force and displacement of a cycle.

Under P = const the tangential force rises from zero by µ (P − P') as P' falls from P to P*, while
distant points move by µκ (d − d'), d' being the approach of the same shape under P': one family of
normal contacts gives the whole curve. After a reversal it is followed at twice the size (Masing
1926; for contacts Jäger 1998).

The curve of d against P is concave, and Betti's theorem gives the area between it and a chord
without any contact in between: twice that area is ∬ p g dA with the pressure at one end and the gap
at the other. With the area of the whole curve, ∮ Q dδ = ∬ 4µps dA.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import isfinite, nan, pi, sqrt
from typing import TypeAlias

import numpy as np

from fretwear.arrays import Array, Mask
from fretwear.mechanics.contact.cells import (
    WITHIN_A_CELL,
    Beside,
    Geometry,
    Region,
    Workspace,
)
from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.protocols import Plane
from fretwear.mechanics.slip.coupled import Sheared
from fretwear.mechanics.slip.models import ReducedContact, contact_under
from fretwear.mechanics.wear.edges import (
    Lines,
    deviation,
    half_extent,
    half_width,
    next_tip,
    open_within_outline,
    stick_half_width,
)
from fretwear.mechanics.wear.state import Pulse, State, WearProblem, in_contact
from fretwear.theory import HertzContact

# Jump of a half-width, m, and gap at the top of the tip that it would jump to, m, by its name.
NextTips: TypeAlias = dict[str, tuple[float, float]]

# Points of a quarter of a loop, contacts solved between its ends, and how well they must predict
# its next point.
POINTS, _CONTACTS, _CLOSE = 64, 4, 1e-3
# The area of a curve with an arc this flat gives it more accurately than contacts are solved.
_STRAIGHT, _TOLERANCE = 1e-6, 1e-5
# Part of the reduced gap beside a stick zone that wear has opened when it has doubled the gap.
_DOUBLED = 0.5
# Cells beside a stick edge, and the ratio of the last to their mean up to which they resolve it.
_ALONG, _RESOLVED = 4, 1.3
# Exponent of the load in the approach of a sphere.
_SPHERE = 2.0 / 3.0


@dataclass(frozen=True)
class Measures:
    """The scalars of a state, of the whole contact, as in `fretwear.results`."""

    approach: float  # m
    tangential_displacement: float  # m
    normal_force: float  # N
    tangential_force: float  # N
    regime: float  # 0 in partial, 1 in gross slip
    sliding_ratio: float  # 1
    contact_radius: float  # m
    stick_radius: float  # m
    scar_half_width_x: float  # m
    scar_half_width_y: float  # m
    contact_half_width_x: float  # m
    contact_half_width_y: float  # m
    stick_half_width_x: float  # m
    stick_half_width_y: float  # m
    contact_area: float  # m²
    stick_area: float  # m²
    mean_stick_pressure: float  # Pa
    stick_load_share: float  # 1
    peak_pressure: float  # Pa
    central_pressure: float  # Pa
    wear_volume: float  # m³
    maximum_wear_depth: float  # m
    plastic_volume: float  # m³
    dissipated_energy: float  # J


def measure(problem: WearProblem, state: State) -> Measures:
    """The scalars of a state.

    A half-width is the distance of the outermost edge on the axis, interpolated within a cell, or
    the mean of both sides if the contact is not even. A radius is that of a disc as large as all
    within the outline of a zone; in a line contact it is the half-width.
    """
    geometry, reduced, pressure = state.geometry, state.reduced, state.pressure
    integral, stick = geometry.integral, reduced.stick
    follows = problem.slip_model.follows_shape
    (contact_x, stick_x), (contact_y, stick_y) = (
        half_widths(state, geometry.along(axis)) for axis in (0, 1)
    )
    scar_x, scar_y = scar_half_widths(state)
    contact, stuck = _regions(problem, state)
    contact_area, zone = geometry.zone(contact).area, geometry.zone(stuck)
    # The part of the cells beyond the edge of the zone bears the harmonic mean of the pressures on
    # both sides: the pressure of the zone there while the surface is unworn, and none once slip has
    # worn the surface beside.
    stick_load = integral(np.where(stick, pressure, 0.0))
    beyond = integral(stick.astype(float)) - zone.area
    within, beside = (pressure.ravel()[cells].sum() for cells in (zone.inside, zone.outside))
    if beside > 0.0:
        stick_load -= beyond * 2.0 / zone.inside.size * float(within * beside / (within + beside))
    stick_load = min(stick_load, problem.plastic_limit * zone.area) if zone.area > 0.0 else 0.0
    peak, carried = float(pressure.max()), integral(pressure)
    if follows and not state.plastic.any():
        # The peak at the stick edge grows as rings get narrower, up to the plastic limit where they
        # are narrow enough to yield: take the mean over an annulus as wide as a cell.
        peak = geometry.largest_mean(pressure, min(problem.spacing))
    displacement = problem.tangential_displacement(state.mean_approach, reduced)
    force = problem.tangential_force(problem.slipping_load(state, geometry), reduced)
    energy = problem.dissipated_energy(state, geometry)
    work = 4.0 * (displacement + problem.flexibility * force) * force
    return Measures(
        approach=state.approach,
        tangential_displacement=displacement,
        normal_force=state.load,
        tangential_force=force,
        regime=0.0 if stick.any() else 1.0,
        sliding_ratio=energy / work if work else nan,
        contact_radius=_radius(geometry, contact.cells, contact_area, contact_x),
        stick_radius=_radius(geometry, stick, zone.area, stick_x),
        scar_half_width_x=scar_x,
        scar_half_width_y=scar_y,
        contact_half_width_x=contact_x,
        contact_half_width_y=contact_y,
        stick_half_width_x=stick_x,
        stick_half_width_y=stick_y,
        contact_area=contact_area,
        stick_area=zone.area,
        mean_stick_pressure=stick_load / zone.area if zone.area else nan,
        stick_load_share=stick_load / carried if zone.area and carried else nan,
        peak_pressure=peak,
        central_pressure=float(pressure[geometry.along(0)[0][0]][0]),
        wear_volume=integral(state.wear),
        maximum_wear_depth=float(state.wear.max()),
        plastic_volume=integral(state.plastic),
        dissipated_energy=energy,
    )


def half_widths(state: State, lines: Lines) -> tuple[float, float]:
    """Half-widths of contact and stick zone, m, on the lines of cells of an axis."""
    reduced, plane_strain = state.reduced, state.geometry.plane_strain
    closed = in_contact(state)
    contact = half_width(lines, closed, state.gap, tips=True, plane_strain=plane_strain)
    # If the zone recedes because the bodies yield, the surface beside it has not worn yet.
    if state.plastic.any():
        stick = half_width(lines, reduced.stick, reduced.gap, plane_strain=plane_strain)
        return contact, stick
    return contact, stick_half_width(lines, reduced.pressure)


def scar_half_widths(state: State) -> tuple[float, float]:
    """Half the extents of the scar along x and y, m; those of rings and strips are the same."""
    geometry, depth = state.geometry, state.wear
    if not isinstance(geometry, Grid):
        return (half_extent(geometry.x, depth[:, 0], is_even=True),) * 2
    along_x = half_extent(geometry.x, depth.max(axis=1), is_even=geometry.even[0])
    if geometry.plane_strain:
        return along_x, along_x
    return along_x, half_extent(geometry.y, depth.max(axis=0), is_even=geometry.even[1])


def _radius(geometry: Geometry, cells: Mask, area: float, half_width: float) -> float:
    """Radius of a zone of an area, m², on cells that are no finer at its edge, or its half-width.

    The area within its outline is that of the zone and of the open cells within it.
    """
    if not isinstance(geometry, Grid) or geometry.plane_strain:
        return half_width
    within = open_within_outline(cells, geometry.x, geometry.y, geometry.even)
    return sqrt(max(area + within * geometry.unit_area, 0.0) / pi)


def _regions(problem: WearProblem, state: State) -> tuple[Region, Region]:
    """The regions of contact and of stick."""
    contact, stick = np.array([half_widths(state, lines) for lines in state.geometry.ways]).T
    touching = Region(in_contact(state), contact, Beside(state.pressure, state.gap, state.opening))
    sticking = Region(state.reduced.stick, stick, _beside_stick(problem, state), touching)
    return touching, sticking


def _beside_stick(problem: WearProblem, state: State) -> Beside:
    worn = state.opening + state.plastic if problem.slip_model.follows_shape else None
    return Beside(state.reduced.pressure, state.reduced.gap, worn, by_pressure=True)


def fractions(problem: WearProblem, state: State, plane: Plane) -> tuple[Array, Array]:
    """Fractions of each cell of a plane in contact and in stick; they integrate to the areas."""
    contact, stick = (state.geometry.covered(r, plane) for r in _regions(problem, state))
    return contact, stick


def next_tips(state: State) -> NextTips:
    """The tips next to touching, by the name of the half-width, m, that would jump to them."""
    zones = {
        "contact": (in_contact(state), state.gap),
        "stick": (state.reduced.stick, state.reduced.gap),
    }
    return {
        f"{zone}_half_width_{axis_name}": next_tip(state.geometry.along(axis), *fields)
        for zone, fields in zones.items()
        for axis, axis_name in enumerate("xy")
    }


def scatter(state: State) -> dict[str, float]:
    """Standard deviations, in SI units, of the scalars that follow from where edges cut cells.

    The edges of a zone lie somewhere in their cells, one independent of another: `Zone.deviations`.
    The load in a stick zone changes by the pressure at its edge, and its mean pressure by the
    difference of this from the mean.
    """
    geometry, pressure, deviations = state.geometry, state.pressure, {}
    zones = {
        "contact": (in_contact(state), Beside(state.pressure, state.gap, state.opening)),
        "stick": (state.reduced.stick, Beside(state.reduced.pressure, state.reduced.gap)),
    }
    for zone_name, (cells, beside) in zones.items():
        zone = geometry.zone(Region(cells, geometry.extent[0], beside))
        deviations[f"{zone_name}_area"] = float(np.linalg.norm(zone.deviations))
        for axis, axis_name in enumerate("xy"):
            name = f"{zone_name}_half_width_{axis_name}"
            deviations[name] = deviation(geometry.along(axis), cells)
        along_x = deviations[f"{zone_name}_half_width_x"]
        radius = _radius(geometry, cells, zone.area, 0.0)
        by_area = deviations[f"{zone_name}_area"] / (2.0 * pi * radius) if radius else along_x
        deviations[f"{zone_name}_radius"] = by_area
    for axis, extent in enumerate(scar_half_widths(state)):
        if isinstance(geometry, Grid):
            width = geometry.spacing[axis]
        else:
            width = float(np.interp(extent, geometry.x, np.ravel(geometry.widths)))
        deviations[f"scar_half_width_{'xy'[axis]}"] = WITHIN_A_CELL * width * (extent > 0.0)
    inside, outside = (pressure.ravel()[side] for side in (zone.inside, zone.outside))
    at_edge = 2.0 * inside * outside / np.maximum(inside + outside, np.finfo(float).tiny)
    carried, area = geometry.integral(pressure), zone.area
    mean = geometry.integral(np.where(cells, pressure, 0.0)) / area if area else 0.0
    of_load, of_mean = (
        float(np.linalg.norm(change * zone.deviations)) for change in (at_edge, at_edge - mean)
    )
    deviations["stick_load_share"] = of_load / carried if carried else 0.0
    deviations["mean_stick_pressure"] = of_mean / area if area else 0.0
    return deviations


def mean_slip_friction(problem: WearProblem, state: State) -> float:
    """Coefficient of friction, mean over the slip zone weighted by pressure."""
    law, integral = problem.friction_law, state.geometry.integral
    slipping = np.where(state.reduced.stick, 0.0, state.pressure)
    return law.coefficient * integral(law.ratio * slipping) / integral(slipping)


def share_beyond_friction(problem: WearProblem, state: State) -> float:
    """Share of the stick zone in which friction cannot bear µ (p − p*) of a slip model: p* > 2p."""
    stick, integral = state.reduced.pressure, state.geometry.integral
    whole = integral((stick > 0.0).astype(np.float64))
    borne = 2.0 * problem.friction_law.ratio * state.pressure
    beyond = integral((stick > borne).astype(np.float64))
    return beyond / whole if whole > 0.0 else 0.0


def unresolved_peak(problem: WearProblem, state: State, peak: float) -> float:
    """How much larger than a peak pressure, Pa, the true one may be because cells do not show it.

    Wear beside a stick zone moves pressure to its edge, where the pressure of elastic bodies
    becomes singular after a finite number of cycles, if slip follows the shape: it rises with
    the inverse root of the distance, so that the largest mean over a cell grows without bound
    as cells get narrower, up to the plastic limit. The mean over the last of four equal cells
    at such an edge is twice that over all of them, and likewise at the end of a punch. On a grid,
    whose cells at the edge are no narrower than others, the peak counts as regular until wear has
    doubled the gap of the reduced contact there.
    """
    geometry, reduced, pressure = state.geometry, state.reduced, state.pressure
    largest, stick = float(pressure.max()), reduced.stick
    if problem.rough is None and geometry.refines_edges:
        ends = isfinite(problem.indenter.end)
        insides = [
            along[max(cells[-1] - _ALONG + 1, 0) : cells[-1] + 1]
            for zone in (stick, pressure > 0.0)[: 1 + ends]
            for inside, along in zip(zone.T, pressure.T, strict=True)
            if (cells := np.flatnonzero(inside)).size
        ]
        is_singular = any(bool(p[-1] > _RESOLVED * p.mean()) for p in insides)
    else:
        beside = geometry.zone(Region(stick, geometry.extent[0])).outside
        opened, gap = (field.ravel()[beside] for field in (state.opening, reduced.gap))
        is_singular = bool(problem.slip_model.follows_shape and (opened > _DOUBLED * gap).any())
    return max((problem.plastic_limit if is_singular else largest) - peak, 0.0)


@dataclass(frozen=True)
class Loop:
    """Force, N, and displacement, m, round one cycle from +Q to −Q and back.

    There are 4 · `POINTS` + 1 phases, the first equal to the last; the displacement includes the
    rig in series.
    """

    force: Array
    displacement: Array
    opening: float  # displacement U₀, m, at which the force vanishes


def loop(workspace: Workspace[WearProblem], state: State, contacts: int = _CONTACTS) -> Loop:
    """The loop of a state, whose shape is kept during the cycle.

    At most ``contacts`` contacts between P and P* are solved, fewer if the curve is accurate before
    to a thousandth of the displacement.
    """
    problem: WearProblem = workspace.problem.of(state)
    coefficient, flexibility = problem.friction_law.coefficient, problem.flexibility
    if state.pulse is not None:
        return _pulsating_loop(problem, state, state.pulse)
    if largest := problem.loading.stroke:
        force, opening = coefficient * state.load * np.linspace(0.0, 1.0, POINTS + 1), largest
        displacement = np.zeros_like(force)
    else:
        loads, approaches, halfway = _curve(workspace, problem, state, contacts)
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
    # From +Q down: twice the curve, then gliding to the other end where the whole contact slides.
    glide = np.linspace(largest - 2.0 * displacement[-1], -largest, POINTS + 1)[1:]
    falling = np.concatenate([largest - 2.0 * displacement, glide])
    path = np.concatenate([force[-1] - 2.0 * force, np.full(POINTS, -force[-1])])
    force, displacement = (np.concatenate([half, -half[1:]]) for half in (path, falling))
    if problem.wears_unevenly:
        force *= problem.load_at(displacement / largest) / state.load
    return Loop(force, displacement, opening)


def _pulsating_loop(problem: WearProblem, state: State, pulse: Pulse) -> Loop:
    """The loop under a load in phase with the force, whose halves differ.

    Distant points have moved by µκ [d(P) + d(P₁) − 2d(P′)] since the force was −Q, and by
    µκ [d(P₂) + d(P) − 2d(P″)] the other way since it was Q: `fretwear.mechanics.wear.pulsating`.
    """
    compliance = problem.friction_law.coefficient * problem.coupling
    phase = np.linspace(0.0, 1.0, 2 * POINTS + 1)
    least, low, high = pulse.least_load, state.reduced.load, state.load
    under = pulse.approach(least + (high - least) * phase)
    rising, falling = (
        under + float(pulse.approach(end)) - 2.0 * pulse.approach(end + (low - end) * way)
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


def _curve(
    workspace: Workspace[WearProblem], problem: WearProblem, state: State, contacts: int
) -> tuple[Array, Array, float]:
    """Loads, N, from P to P*, the approaches, m, under them, and the approach under their mean."""
    if not problem.slip_model.follows_shape:
        return _unworn_curve(problem.hertz, state.reduced.load)
    geometry, low = state.geometry, state.reduced
    slipping = problem.friction_law.ratio * state.pressure, state.gap, state.approach
    high = ReducedContact(*slipping, problem.slipping_load(state, geometry))
    bodies = workspace.on(geometry)
    shape = bodies.unworn + state.opening + state.plastic
    half_space, shape = problem.slip_model.family(problem, bodies.half_space, shape, state.pressure)
    if not low.load > 0.0:
        lowest = float(shape.min())
        low = replace(low, gap=shape - lowest, approach=lowest)
    whole = geometry.integral(low.gap * high.pressure)
    family, areas, rise = [low, high], [whole], high.approach - low.approach
    halfway = _approach_between(low, high, whole)
    if whole <= _STRAIGHT * rise * (high.load - low.load):
        contacts = 0
    for solved_before in range(contacts):
        # Halfway where the curve bends most, which is between its ends at first.
        at = int(np.argmax(areas))
        lower, upper = family[at : at + 2]
        load = 0.5 * (lower.load + upper.load)
        # The square of the pressure of a sphere falls evenly with P^(2/3), to zero beyond its edge.
        least, most, place = (end**_SPHERE for end in (lower.load, upper.load, load))
        square, stick = upper.pressure**2, lower.stick
        fall = square - lower.pressure**2
        fall = np.where(stick, fall, fall[stick].mean() if stick.any() else square.max())
        guess = np.sqrt(np.maximum(square - (most - place) / (most - least) * fall, 0.0))
        guess *= load / geometry.integral(guess)
        contact = contact_under(half_space, shape, load, None, guess, _TOLERANCE)
        expected = _approach_between(lower, upper, areas[at])
        halfway = halfway if solved_before else contact.approach
        family.insert(at + 1, contact)
        areas[at : at + 1] = [
            geometry.integral(lower.gap * contact.pressure),
            geometry.integral(contact.gap * upper.pressure),
        ]
        if abs(contact.approach - expected) <= _CLOSE * rise:
            break
    return (*_sampled(family, areas, whole), halfway)


def _of_vectors(
    sheared: Sheared, force: Array, displacement: Array, half: float
) -> tuple[Array, Array, float]:
    """The curve of friction in two directions from that in one, and its place at half the force.

    It ends at the force, N, and the displacement, m, of the tractions. The depth of the curve below
    its chord is scaled so that the area below it is their energy, of which δ is the derivative by
    Q.
    """
    end = sheared.displacement if sheared.stick.any() else float(displacement[-1])
    chord, force = displacement[-1] / force[-1] * force, sheared.force / force[-1] * force
    arc, depth = displacement - chord, half - 0.5 * float(displacement[-1])
    below = float(np.trapezoid(arc, force))
    scale = (sheared.energy - 0.5 * end * sheared.force) / below if below else 0.0
    return force, end / sheared.force * force + scale * arc, 0.5 * end + scale * depth


def _unworn_curve(hertz: HertzContact, least: float) -> tuple[Array, Array, float]:
    """`_curve` of the unworn smooth contact, from its load to a reduced one, N, in closed form.

    The heights above the chord are scaled so that the polygon has the area of the curve.
    """

    def approach_under(load: float) -> float:
        return hertz.with_load(load).approach if load > 0.0 else 0.0

    # Cube roots of the loads; Gaussian ones for the area.
    ends = np.cbrt([least, hertz.load])
    nodes, weights = np.polynomial.legendre.leggauss(POINTS)
    roots = ends.mean() + 0.5 * np.diff(ends) * nodes
    loads = np.linspace(ends[1], ends[0], POINTS + 1) ** 3
    loads[[0, -1]] = hertz.load, least
    approaches = np.array([*map(approach_under, loads)])
    exact = np.array([*map(approach_under, roots**3)]) @ (weights * 3.0 * roots**2)
    exact *= 0.5 * float(np.diff(ends)[0])
    chord = np.interp(loads, loads[[-1, 0]], approaches[[-1, 0]])
    arc, below = approaches - chord, -float(np.trapezoid(chord, loads))
    arc *= (exact - below) / -float(np.trapezoid(arc, loads))
    return loads, chord + arc, approach_under(0.5 * (least + hertz.load))


def _sampled(family: list[ReducedContact], areas: list[float], whole: float) -> tuple[Array, Array]:
    """Loads and approaches from the last contact of a family to the first.

    Between two contacts the curve is their chord plus the arc of a sphere's curve, scaled so that
    twice the area above the chord is as given and sums up to the area of the whole curve.
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
