"""Numbers that describe a state of the contact: widths, areas, peaks, volumes, energy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretwear.mechanics.geometry import Array, Geometry, Mask, Zone
from fretwear.mechanics.geometry.line import Line
from fretwear.mechanics.geometry.rings import Rings
from fretwear.mechanics.state import State, WearProblem, in_contact

# Ratio to the gap of the first cell outside above which a gap is not one of contact.
_NO_GAP = 1e-2


@dataclass(frozen=True)
class Measures:
    """Scalars of one state, for the whole contact; SI units."""

    approach: float  # δ, m
    # Of distant points along x at +Q relative to each other, µκ (δ − δ*), m.
    tangential_displacement: float
    normal_force: float  # P, N
    tangential_force: float  # amplitude Q = µ (P − P*), N
    regime: float  # 0 in partial slip, 1 where nothing sticks
    sliding_ratio: float  # A = D/(4UQ), U the displacement amplitude of the rig
    # Outermost edge on the axis, interpolated within a cell, m; where the contact is not even,
    # the mean of both sides.
    contact_half_width_x: float
    contact_half_width_y: float
    stick_half_width_x: float
    stick_half_width_y: float
    contact_area: float  # m²
    stick_area: float  # m²
    # Load that the stick zone carries, over its area, Pa, and over the whole load; 0 where
    # nothing sticks.
    mean_stick_pressure: float
    stick_load_share: float
    peak_pressure: float  # Pa
    central_pressure: float  # Pa
    wear_volume: float  # m³
    maximum_wear_depth: float  # m
    plastic_volume: float  # m³
    dissipated_energy: float  # in one cycle, D = ∬ 4 µ p s dA, J


def measure(problem: WearProblem, state: State) -> Measures:
    """Measure a state of the contact."""
    geometry, reduced = state.geometry, state.reduced
    contact = in_contact(state)
    contact_radius = half_width(geometry, contact, state.gap, 0)
    stick_radius, stick_radius_y = (_stick_half_width(state, axis) for axis in (0, 1))
    zone = geometry.zone(reduced.stick, stick_radius)
    stick_load = _stick_load(problem, state, zone)
    displacement = problem.tangential_displacement(state.approach, reduced)
    force = problem.tangential_force(state.load, reduced)
    energy = problem.dissipated_energy(state, geometry)
    imposed = displacement + problem.flexibility * force
    return Measures(
        approach=state.approach,
        tangential_displacement=displacement,
        normal_force=state.load,
        tangential_force=force,
        regime=0.0 if reduced.stick.any() else 1.0,
        sliding_ratio=energy / (4.0 * imposed * force) if imposed * force else 0.0,
        contact_half_width_x=contact_radius,
        contact_half_width_y=half_width(geometry, contact, state.gap, 1),
        stick_half_width_x=stick_radius,
        stick_half_width_y=stick_radius_y,
        contact_area=geometry.zone(contact, contact_radius).area,
        stick_area=zone.area,
        mean_stick_pressure=stick_load / zone.area if zone.area else 0.0,
        stick_load_share=stick_load / (geometry.integral(state.pressure) or 1.0),
        peak_pressure=_peak(problem, state),
        central_pressure=float(state.pressure[geometry.along(0)[0][0]][0]),
        wear_volume=geometry.integral(state.wear),
        maximum_wear_depth=float(state.wear.max()),
        plastic_volume=geometry.integral(state.plastic),
        dissipated_energy=energy,
    )


def _stick_load(problem: WearProblem, state: State, zone: Zone) -> float:
    """Load that the stick zone carries, N, where its cells cover more or less than its area.

    What they cover beyond its edge has the harmonic mean of the pressures on both sides: as much
    as the zone has there while nothing is worn, and nothing once slip has worn the surface beside.
    """
    stick, pressure, integral = state.reduced.stick, state.pressure, state.geometry.integral
    load = integral(np.where(stick, pressure, 0.0))
    beyond = integral(stick.astype(float)) - zone.area
    within, beside = (pressure.ravel()[each].sum() for each in (zone.inside, zone.outside))
    if beside > 0.0:
        load -= beyond * 2.0 / zone.inside.size * float(within * beside / (within + beside))
    return min(load, problem.limit * zone.area) if zone.area > 0.0 else 0.0


def _peak(problem: WearProblem, state: State) -> float:
    """Largest pressure of a cell, Pa; on elastic rings, of an annulus as wide as a cell.

    At the stick edge it grows without bound as rings get narrower.
    """
    rings = state.geometry
    if isinstance(rings, Rings) and np.isinf(problem.limit):
        return float(rings.means(state.pressure, rings.x, min(problem.spacing)).max())
    return float(state.pressure.max())


def half_width(geometry: Geometry, inside: Mask, gap: Array, axis: int) -> float:
    """Distance of the outermost edge of a zone from the origin along an axis, m.

    Beyond the edge of a smooth contact the gap g grows with the power 3/2 of the distance, beyond
    one that has worn in evenly. The zero of r = e + b g^(2/3) + c g through three cells outside is
    the edge, kept between the centres of the last cell inside and the first one outside.

    Parameters
    ----------
    geometry
        Geometry of the fields.
    inside
        Cells of the zone.
    gap
        m, zero in the zone.
    axis
        0 for the x axis, 1 for the y axis.

    Returns
    -------
    float, m; 0 if no cell on the axis belongs to the zone.
    """
    edge = _worn_edge if isinstance(geometry, Line) else _edge
    edges = [edge(at, inside[along], gap[along]) for along, at in geometry.along(axis)]
    return sum(edges) / len(edges)


def _worn_edge(distance: Array, inside: Mask, gap: Array) -> float:
    """Edge of a contact whose gap opens with the power 3/2, or linearly where it has worn.

    Both laws through the first two cells outside predict the gap of the third; its position between
    them weighs their zeros. The strips may be so narrow that several beyond the edge count as in
    contact, and the zero lies among them.
    """
    zone = np.flatnonzero(inside)
    last = int(zone[-1]) if zone.size else 0
    if zone.size == 0 or gap.size < last + 4:
        return _edge(distance, inside, gap)
    x, outside = distance[last + 1 : last + 4], gap[last + 1 : last + 4]
    zeros, foretold = [], []
    for power in (1.0, 1.5):
        near, far, _ = outside ** (1.0 / power)
        slope = (far - near) / (x[1] - x[0])
        if slope <= 0.0:
            return _edge(distance, inside, gap)
        zeros.append(x[0] - near / slope)
        foretold.append((slope * (x[2] - zeros[-1])) ** power)
    weight = (outside[2] - foretold[0]) / (foretold[1] - foretold[0])
    weight = min(max(weight, 0.0), 1.0)
    least = distance[np.flatnonzero(gap[: last + 1] <= _NO_GAP * outside[0])]
    found = (1.0 - weight) * zeros[0] + weight * zeros[1]
    return float(min(max(found, least[-1] if least.size else 0.0), x[0]))


def _edge(distance: Array, inside: Mask, gap: Array) -> float:
    zone = np.flatnonzero(inside)
    if zone.size == 0:
        return 0.0
    last = int(zone[-1])
    outside = gap[last + 1 : last + 4]
    if outside.size < 2:
        return _border(distance, last)
    center, first, second = (float(each) for each in distance[last : last + 3])
    near, far, *_ = roots = np.cbrt(outside)
    if outside.size == 3 and 0.0 < near < far < roots[2]:
        law = np.stack([np.ones(3), roots**2, outside], axis=1)
        edge = np.linalg.solve(law / law.max(axis=0), distance[last + 1 : last + 4])[0]
    else:
        # Equal gaps do not determine the edge.
        near, far = near**2, far**2
        edge = (
            first - near / (far - near) * (second - first) if far > near else 0.5 * (center + first)
        )
    return float(min(max(edge, center), first))


def _stick_half_width(state: State, axis: int) -> float:
    """Distance of the edge of the stick zone from the origin along an axis, m.

    If it recedes because the bodies yield, the surface that opens beside it has not worn yet.
    """
    geometry, reduced = state.geometry, state.reduced
    if state.plastic.any():
        return half_width(geometry, reduced.stick, reduced.gap, axis)
    return stick_half_width(geometry, reduced.pressure, axis)


def stick_half_width(geometry: Geometry, pressure: Array, axis: int) -> float:
    """Distance of the outermost edge of the stick zone from the origin along an axis, m.

    Near its edge the square of the pressure at the reduced load falls linearly in the square of
    the coordinate, exactly so for a sphere. The zero of that law through the cells next to the
    outermost one is the edge, kept within a cell of the outermost center. Wear beside the stick
    zone leaves this pressure as it is, so the edge of an elastic run stays where it is.

    Parameters
    ----------
    geometry
        Geometry of the pressure.
    pressure
        p*, Pa, zero outside the stick zone.
    axis
        0 for the x axis, 1 for the y axis.

    Returns
    -------
    float, m; 0 if no cell on the axis sticks.
    """
    edges = [_stick_edge(at, pressure[along]) for along, at in geometry.along(axis)]
    return sum(edges) / len(edges)


def _stick_edge(distance: Array, line: Array) -> float:
    zone = np.flatnonzero(line > 0)
    if zone.size == 0:
        return 0.0
    last = int(zone[-1])
    center, border = float(distance[last]), _border(distance, last)
    edge = border
    if last >= 2 and line[last - 1] > 0 and line[last - 2] > line[last - 1]:
        near, far = line[last - 1] ** 2, line[last - 2] ** 2
        inner, innermost = distance[last - 1] ** 2, distance[last - 2] ** 2
        edge = float(np.sqrt(inner + (inner - innermost) * near / (far - near)))
    return min(max(edge, center), 2.0 * border - center)


def _border(distance: Array, last: int) -> float:
    """Outer border of a cell on an axis, halfway to the next one, m."""
    inner, outer = (last, last + 1) if last + 1 < distance.size else (last - 1, last)
    return float(distance[last] + 0.5 * (distance[outer] - distance[inner]))
