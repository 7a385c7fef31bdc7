"""Numbers that describe a state of the contact, and how well its cells tell them.

The edge of a smooth contact lies between the last cell inside and the first one outside. Rough
contacts end at a tip, whose lowest point lies somewhere in its cell.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite, nan, pi, sqrt
from types import SimpleNamespace
from typing import NamedTuple, TypeAlias

import numpy as np

from fretwear.arrays import Array, Even, Mask
from fretwear.mechanics.contact.cells import (
    WITHIN_A_CELL,
    Beside,
    Geometry,
    Region,
    Way,
)
from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.wear.loops import loop
from fretwear.mechanics.wear.state import State, WearProblem, Workspace

# Jump of a half-width, m, and gap at the top of the tip that it would jump to, m, by its name.
NextTips: TypeAlias = dict[str, tuple[float, float]]

# Part of the reduced gap beside a stick zone that wear has opened when it has doubled the gap.
_DOUBLED = 0.5
# Cells beside a stick edge, and the ratio of the last to their mean up to which they resolve it.
_ALONG, _RESOLVED = 4, 1.3
# Cells on an axis or a part of it: places, and distances from the origin, m.
Lines: TypeAlias = Sequence[tuple[Way, Array]]
# Gap, over the gap of the first cell outside, above which a cell is not in contact.
_NO_GAP = 1e-2
# Depth of a scar over its maximum at which a profilometer sees its end.
_SHALLOW = 0.01


def measure(problem: WearProblem, state: State) -> SimpleNamespace:
    """The scalars of a state in SI units, of the whole contact, by their names in `results`.

    A half-width is the distance of the outermost edge on the axis, interpolated within a cell, or
    the mean of both sides if the contact is not even. A radius belongs to the disc with the area
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
    contact_radius = _radius(geometry, contact.cells, contact_area, contact_x)
    stick_radius = _radius(geometry, stick, zone.area, stick_x)
    displacement = problem.tangential_displacement(state.mean_approach, reduced)
    force = problem.tangential_force(problem.slipping_load(state, geometry), reduced)
    energy = problem.dissipated_energy(state, geometry)
    work = 4.0 * (displacement + problem.flexibility * force) * force
    return SimpleNamespace(
        approach=state.approach,
        tangential_displacement=displacement,
        normal_force=state.load,
        tangential_force=force,
        regime=0.0 if stick.any() else 1.0,
        sliding_ratio=energy / work if work else nan,
        contact_radius=contact_radius,
        stick_radius=stick_radius,
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
        central_pressure=float(np.mean([pressure[line][0] for line, _ in geometry.along(0)])),
        wear_volume=integral(state.wear),
        maximum_wear_depth=float(state.wear.max()),
        plastic_volume=integral(state.plastic),
        dissipated_energy=energy,
    )


def half_widths(state: State, lines: Lines) -> tuple[float, float]:
    """Half-widths of contact and stick zone, m, on the lines of cells of an axis."""
    reduced, plane_strain = state.reduced, state.geometry.plane_strain
    closed = state.in_contact
    contact = half_width(lines, closed, state.gap, tips=True, plane_strain=plane_strain)
    # If the zone recedes because the bodies yield, the surface beside it has not worn yet.
    if state.plastic.any():
        stick = half_width(lines, reduced.stick, reduced.gap, plane_strain=plane_strain)
        return contact, stick
    return contact, stick_half_width(lines, reduced.pressure)


def scar_half_widths(state: State) -> tuple[float, float]:
    """Half the extents of the scar along x and y, m; equal on rings and strips."""
    geometry, depth = state.geometry, state.wear
    along_x = half_extent(geometry.x, depth.max(axis=1), is_even=geometry.even[0])
    if not isinstance(geometry, Grid) or geometry.plane_strain:
        return along_x, along_x
    return along_x, half_extent(geometry.y, depth.max(axis=0), is_even=geometry.even[1])


def _radius(geometry: Geometry, cells: Mask, area: float, half_width: float) -> float:
    """Radius of a zone of an area, m², on cells that are no finer at its edge, or its half-width.

    The area within its outline includes open cells in the zone.
    """
    if not isinstance(geometry, Grid) or geometry.plane_strain:
        return half_width
    within = open_within_outline(cells, geometry.x, geometry.y, geometry.even)
    return sqrt(max(area + within * geometry.unit_area, 0.0) / pi)


def _regions(problem: WearProblem, state: State) -> tuple[Region, Region]:
    """The regions of contact and of stick."""
    contact, stick = half_widths(state, state.geometry.along(0))
    touching = Region(state.in_contact, contact, Beside(state.pressure, state.gap, state.opening))
    worn = state.opening + state.plastic if problem.slip_model.follows_shape else None
    beside = Beside(state.reduced.pressure, state.reduced.gap, worn, by_pressure=True)
    return touching, Region(state.reduced.stick, stick, beside, touching)


def fractions(problem: WearProblem, state: State, plane: Geometry) -> tuple[Array, Array]:
    """Fractions of each cell of a plane in contact and in stick; they integrate to the areas."""
    contact, stick = (state.geometry.covered(r, plane) for r in _regions(problem, state))
    return contact, stick


class Described(NamedTuple):
    """A snapshot in numbers."""

    scalars: dict[str, float]  # the measures of every step, and scalars of its loop and of bodies
    tips: NextTips


def described(workspace: Workspace, state: State) -> Described:
    """Describe a snapshot."""
    problem = workspace.problem.of(state)
    scalars = vars(measure(problem, state))
    if problem.friction_law.follows_slip:
        scalars["mean_slip_friction"] = mean_slip_friction(problem, state)
    # One contact between its ends tells where the force vanishes.
    full = 4.0 * loop(workspace, state, contacts=1).opening * scalars["tangential_force"]
    scalars["sliding_criterion"] = scalars["dissipated_energy"] / full if full else nan
    shares = problem.wear_law.shares
    for index, (body, wear) in enumerate(state.wear_of_each(problem.wear_law).items()):
        volume = shares[index] * scalars["wear_volume"] if shares else state.geometry.integral(wear)
        scalars[f"wear_volume_{body}"] = volume
    return Described(scalars, next_tips(state))


def next_tips(state: State) -> NextTips:
    """The tips next to touching, by the name of the half-width, m, that would jump to them."""
    zones = {
        "contact": (state.in_contact, state.gap),
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
        "contact": (state.in_contact, Beside(state.pressure, state.gap, state.opening)),
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
        # The end of a scar is interpolated between the depths of two cells.
        within = 0.5 * WITHIN_A_CELL * width
        deviations[f"scar_half_width_{'xy'[axis]}"] = within * (extent > 0.0)
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


def uncertainty(problem: WearProblem, state: State, peak: float) -> tuple[dict[str, float], float]:
    """The `scatter` of a snapshot, and how much higher than its peak, Pa, the pressure may be."""
    return scatter(state), unresolved_peak(problem, state, peak)


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
    if problem.rough is None and not isinstance(geometry, Grid):
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


def half_width(
    lines: Lines, inside: Mask, gap: Array, *, tips: bool = False, plane_strain: bool = False
) -> float:
    """Distance of the outermost edge of a zone from the origin on the lines of an axis, m.

    Beyond the edge of a smooth contact the gap g grows with the power 3/2 of the distance, and
    linearly if the contact has worn in. The zero of r = e + b g^(2/3) + c g through three cells
    outside is the edge, kept between the centres of the last cell inside and the first one
    outside. With ``tips``, one beyond whose lowest point touches between centres is the edge.

    ``inside`` are the cells of the zone, and ``gap`` is in m and zero in the zone. The result is 0
    if no cell on the lines belongs to the zone.
    """
    edges = []
    for line, at in lines:
        edge = _edge(at, inside[line], gap[line], plane_strain)
        if tips and edge > 0.0:
            beyond = _tips_beyond(line, at, inside, gap)
            edge = max([edge, *(place for lowest, place in beyond if lowest < 0.0)])
        edges.append(edge)
    return sum(edges) / len(edges)


def _edge(distance: Array, inside: Mask, gap: Array, plane_strain: bool) -> float:
    zone = np.flatnonzero(inside)
    if zone.size == 0:
        return 0.0
    last = int(zone[-1])
    x, outside = distance[last + 1 : last + 4], gap[last + 1 : last + 4]
    if outside.size < 2:
        return _border(distance, last)
    if plane_strain and outside.size == 3:
        # The gap of a line contact opens with the power 3/2, or linearly where it has worn. Both
        # laws through two cells predict the gap of the third; its place between these predictions
        # gives the weights of the zeros.
        powers = np.array([1.0, 1.5])
        near, far = outside[:2, None] ** (1.0 / powers)
        slopes = (far - near) / (x[1] - x[0])
        if (slopes > 0.0).all():
            zeros = x[0] - near / slopes
            predicted = (slopes * (x[2] - zeros)) ** powers
            weight = (outside[2] - predicted[0]) / (predicted[1] - predicted[0])
            weight = min(max(weight, 0.0), 1.0)
            # Strips may be so narrow that several beyond the edge count as in contact.
            closed = distance[np.flatnonzero(gap[: last + 1] <= _NO_GAP * outside[0])]
            zero = (1.0 - weight) * zeros[0] + weight * zeros[1]
            return float(min(max(zero, closed[-1] if closed.size else 0.0), x[0]))
    center, first = float(distance[last]), float(x[0])
    near, far, *_ = roots = np.cbrt(outside)
    if outside.size == 3 and 0.0 < near < far < roots[2]:
        law = np.stack([np.ones(3), roots**2, outside], axis=1)
        edge = np.linalg.solve(law / law.max(axis=0), x)[0]
    elif far > near:
        near, far = near**2, far**2
        edge = first - near / (far - near) * (float(x[1]) - first)
    else:
        # Equal gaps do not determine the edge.
        edge = 0.5 * (center + first)
    return float(min(max(edge, center), first))


def stick_half_width(lines: Lines, pressure: Array) -> float:
    """Distance of the outermost edge of the stick zone from the origin on the lines of an axis, m.

    Near its edge the square of the pressure p*, Pa, at the reduced load falls linearly in the
    square of the coordinate, exactly so for a sphere. The zero of that law through the cells next
    to the outermost one is the edge, kept within a cell of the outermost center. Wear beside the
    stick zone leaves this pressure as it is, so the edge of an elastic run stays where it is.
    The result is 0 if no cell on the lines sticks.
    """
    edges = []
    for along, distance in lines:
        line = pressure[along]
        zone = np.flatnonzero(line > 0)
        if not zone.size:
            edges.append(0.0)
            continue
        last = int(zone[-1])
        center, edge = float(distance[last]), _border(distance, last)
        most = 2.0 * edge - center
        if last >= 2 and line[last - 1] > 0 and line[last - 2] > line[last - 1]:
            near, far = line[last - 1] ** 2, line[last - 2] ** 2
            inner, innermost = distance[last - 1] ** 2, distance[last - 2] ** 2
            edge = float(np.sqrt(inner + (inner - innermost) * near / (far - near)))
        edges.append(min(max(edge, center), most))
    return sum(edges) / len(edges)


def deviation(lines: Lines, inside: Mask) -> float:
    """Standard deviation of the half-width of a zone on the lines of an axis, m."""
    ends = [(at, np.flatnonzero(inside[line])) for line, at in lines]
    widths = [np.diff(at)[zone[-1:]].sum() for at, zone in ends]
    return WITHIN_A_CELL * float(np.mean(widths))


def next_tip(lines: Lines, inside: Mask, gap: Array) -> tuple[float, float]:
    """The tip beyond a zone that is next to touching: jump of the half-width, m, and its gap, m.

    The half-width on the lines of an axis jumps so far where the tip touches, or does not after
    all. The gap is at the top of the tip, below zero where it touches; 0 and NaN if there is none.
    """
    tips = [
        (abs(lowest), (edge - float(at[last])) / len(lines), lowest)
        for line, at in lines
        if (zone := np.flatnonzero(inside[line])).size
        for last in zone[-1:]
        for lowest, edge in _tips_beyond(line, at, inside, gap)
    ]
    return min(tips)[1:] if tips else (0.0, nan)


def _tips_beyond(line: Way, distance: Array, inside: Mask, gap: Array) -> list[tuple[float, float]]:
    """The tips on a line beyond the last cell of a zone, the nearest first, in m.

    They have the gap at the lowest point and the outer edge of the contact, or the tip's place.
    Parabolas along the line and across it have their vertices where the tip is lowest. A paraboloid
    of radius R that is pressed in by δ touches within √(Rδ).
    """
    here, last = gap[line], int(np.flatnonzero(inside[line])[-1])
    near, middle, far = here[last:-2], here[last + 1 : -1], here[last + 2 :]
    minima = last + 1 + np.flatnonzero((middle < near) & (middle <= far))
    if not minima.size:
        return []
    axis = 0 if isinstance(line[0], slice) else 1
    across, row = np.moveaxis(gap, axis, 0)[line[axis]], line[1 - axis]
    assert isinstance(row, int)
    rows = [min(max(beside, 0), across.shape[1] - 1) for beside in (row - 1, row, row + 1)]
    tips = []
    for tip in minima.tolist():
        place, bend, fall = _vertex(here[tip - 1 : tip + 2])
        *_, deeper = _vertex(across[tip, rows])
        lowest = float(here[tip]) - fall - deeper
        radius = sqrt(max(-lowest, 0.0) / bend)
        edge = distance[tip] + (place + min(radius, 0.5)) * (distance[tip + 1] - distance[tip])
        tips.append((lowest, float(edge)))
    return tips


def _vertex(gaps: Array) -> tuple[float, float, float]:
    """The parabola through three cells: place of its vertex, second difference, fall to the vertex.

    The place is in cells from the middle one; the vertex counts only within it, rounding apart.
    """
    near, middle, far = gaps.tolist()
    rise, bend = 0.5 * (far - near), far + near - 2.0 * middle
    if bend <= 0.0 or abs(rise) > 0.501 * bend:
        return 0.0, max(bend, 0.0), 0.0
    return -rise / bend, bend, 0.5 * rise**2 / bend


def _border(distance: Array, last: int) -> float:
    """Outer border of a cell on an axis, halfway to the next one, m."""
    inner, outer = (last, last + 1) if last + 1 < distance.size else (last - 1, last)
    return float(distance[last] + 0.5 * (distance[outer] - distance[inner]))


def open_within_outline(inside: Mask, x: Array, y: Array, even: Even) -> int:
    """Number of cells within the outline of a zone that do not belong to it, of those kept.

    The outline is the convex hull of the centres of the zone's cells and of their images where the
    zone is ``even``: valleys between tips and the middle of a ring count, and a tip that touches
    outside moves it little. ``x`` and ``y`` are the centres of the cells, m.
    """
    columns = np.flatnonzero(inside.any(axis=1))
    if not columns.size:
        return 0
    at, zone = x[columns], inside[columns]
    top = y[y.size - 1 - zone[:, ::-1].argmax(axis=1)]
    bottom = -top if even[1] else y[zone.argmax(axis=1)]
    if even[0]:
        at = np.concatenate([-at[::-1], at])
        top, bottom = (np.concatenate([ends[::-1], ends]) for ends in (top, bottom))
    between = x[np.searchsorted(x, at[0]) : columns[-1] + 1]
    slack = 1e-6 * float(at[-1] - at[0])
    highest = np.interp(between, *_highest_chords(at, top)) + slack
    lowest = -highest if even[1] else -np.interp(between, *_highest_chords(at, -bottom)) - slack
    within = np.searchsorted(y, highest, "right") - np.searchsorted(y, lowest, "left")
    return int(within.sum()) - int(inside.sum())


def _highest_chords(x: Array, heights: Array) -> tuple[list[float], list[float]]:
    """The corners of the upper convex hull of points in ascending x."""
    corners: list[tuple[float, float]] = []
    for place, height in zip(x.tolist(), heights.tolist(), strict=True):
        while len(corners) > 1:
            (first, low), (middle, high) = corners[-2:]
            if (high - low) * (place - first) > (height - low) * (middle - first):
                break
            corners.pop()
        corners.append((place, height))
    places, hull = zip(*corners, strict=True)
    return [*places], [*hull]


def half_extent(x: Array, depth: Array, *, is_even: bool) -> float:
    """Half the extent of a scar along an axis, m: between the outermost places on either side.

    Beyond them, the scar is nowhere deeper than `_SHALLOW` of its maximum. ``depth``, m, is the
    largest on each line of cells across the axis at ``x``, m; 0 if nothing is worn.
    """
    if not depth.any():
        return 0.0
    end = _scar_end(x, depth)
    return end if is_even else 0.5 * (end + _scar_end(-x[::-1], depth[::-1]))


def _scar_end(x: Array, depth: Array) -> float:
    """The outermost place at which a scar is as deep as `_SHALLOW` of its maximum, m.

    Beside a cell that is not worn, the depth goes on to fall linearly, if it does so fast enough to
    end there. At the edge of an unworn contact it falls faster, anywhere in the cell.
    """
    level = _SHALLOW * float(depth.max())
    last = int(np.flatnonzero(depth > level)[-1])
    if last + 1 == x.size:
        return float(x[last])
    near, beyond, part = float(depth[last]), float(depth[last + 1]), 0.5
    before = float(depth[last - 1]) if last else near
    if beyond > 0.0:
        part = (near - level) / (near - beyond)
    elif near - level < before - near:
        part = (near - level) / (before - near)
    return float(x[last] + part * (x[last + 1] - x[last]))
