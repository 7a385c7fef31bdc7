"""Numbers that describe a state of the contact: widths, areas, peaks, volumes, energy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretwear.mechanics.arrays import Array, Mask
from fretwear.mechanics.slip import Friction
from fretwear.mechanics.state import State
from fretwear.mechanics.window import Window

CONTACT_GAP = 1e-5
"""Largest gap of a cell in contact, relative to the approach.

Where worn surfaces conform, pressure and gap vanish together: a contact read off p > 0 would
collapse to the stick zone after many cycles.
"""


@dataclass(frozen=True)
class Measures:
    """Scalars of one state, for the whole contact; SI units.

    Attributes
    ----------
    approach, tangential_displacement
        m.
    contact_half_width_x, contact_half_width_y, stick_half_width_x, stick_half_width_y
        Outermost edge on the axis, interpolated within a cell, m.
    contact_area, stick_area
        m².
    peak_pressure, central_pressure
        Pa.
    wear_volume, plastic_volume
        m³.
    dissipated_energy
        In one cycle, J.
    """

    approach: float
    tangential_displacement: float
    contact_half_width_x: float
    contact_half_width_y: float
    stick_half_width_x: float
    stick_half_width_y: float
    contact_area: float
    stick_area: float
    peak_pressure: float
    central_pressure: float
    wear_volume: float
    plastic_volume: float
    dissipated_energy: float


def measure(state: State, friction: Friction) -> Measures:
    """Measure a state of the contact under a friction law."""
    window, reduced = state.window, state.reduced
    contact = in_contact(state)
    stick = reduced.stick
    center = tuple(0 if window.quarter else n // 2 for n in window.shape)
    return Measures(
        approach=state.approach,
        tangential_displacement=friction.tangential_displacement(state.approach, reduced),
        contact_half_width_x=half_width(window, contact, state.gap, 0),
        contact_half_width_y=half_width(window, contact, state.gap, 1),
        stick_half_width_x=stick_half_width(window, reduced.pressure, 0),
        stick_half_width_y=stick_half_width(window, reduced.pressure, 1),
        contact_area=window.integral(contact.astype(float)),
        stick_area=window.integral(stick.astype(float)),
        peak_pressure=float(state.pressure.max()),
        central_pressure=float(state.pressure[center]),
        wear_volume=window.integral(state.wear),
        plastic_volume=window.integral(state.plastic),
        dissipated_energy=friction.dissipated_energy(window, state.pressure, reduced),
    )


def in_contact(state: State) -> Mask:
    """Cells under pressure, and those whose gap is at most `CONTACT_GAP` of the approach.

    The approach counts from the smooth sphere: bodies that touch in deep valleys of roughness
    only have a negative one.
    """
    result: Mask = (state.pressure > 0) | (state.gap <= CONTACT_GAP * abs(state.approach))
    return result


def half_width(window: Window, inside: Mask, gap: Array, axis: int) -> float:
    """Distance of the outermost edge of a zone from the origin along an axis, m.

    Beyond the edge of an elastic contact the gap grows with the power 3/2 of the distance; the
    zero of that law through the first two cells outside is the edge, kept between the centres
    of the last cell inside and the first one outside.

    Parameters
    ----------
    window
        Where the fields are given.
    inside
        Cells of the zone.
    gap
        m, zero in the zone.
    axis
        0 for the x axis, 1 for the y axis.

    Returns
    -------
    float, m; 0 where the axis has no cell of the zone.
    """
    along = _half_axis(window, axis)
    zone = np.flatnonzero(inside[along])
    if zone.size == 0:
        return 0.0
    spacing = window.spacing[axis]
    last = int(zone[-1])
    center = (last + 0.5) * spacing
    outside = gap[along][last + 1 : last + 3]
    if outside.size < 2:
        return center + 0.5 * spacing
    near, far = np.cbrt(outside) ** 2
    beyond = float(near / (far - near)) if far > near else 0.5
    return center + spacing * (1.0 - min(max(beyond, 0.0), 1.0))


def stick_half_width(window: Window, pressure: Array, axis: int) -> float:
    """Distance of the outermost edge of the stick zone from the origin along an axis, m.

    Near its edge the square of the pressure at the reduced load falls linearly in the square of
    the coordinate, exactly so for a sphere. The zero of that law through the cells next to the
    outermost one is the edge, kept within a cell of the outermost center. Wear beside the stick
    zone leaves this pressure as it is, so the edge of an elastic run stays where it is.

    Parameters
    ----------
    window
        Where the pressure is given.
    pressure
        p*, Pa, zero outside the stick zone.
    axis
        0 for the x axis, 1 for the y axis.

    Returns
    -------
    float, m; 0 where the axis has no cell that sticks.
    """
    line = pressure[_half_axis(window, axis)]
    zone = np.flatnonzero(line > 0)
    if zone.size == 0:
        return 0.0
    spacing = window.spacing[axis]
    last = int(zone[-1])
    center = (last + 0.5) * spacing
    edge = center + 0.5 * spacing
    if last >= 2 and line[last - 1] > 0 and line[last - 2] > line[last - 1]:
        near, far = line[last - 1] ** 2, line[last - 2] ** 2
        inner, innermost = ((last - 0.5) * spacing) ** 2, ((last - 1.5) * spacing) ** 2
        edge = float(np.sqrt(inner + (inner - innermost) * near / (far - near)))
    return min(max(edge, center), center + spacing)


def _half_axis(window: Window, axis: int) -> tuple[slice | int, slice | int]:
    """Index of the cells on the positive half of an axis, or nearest to it."""
    first = [0 if window.quarter else n // 2 for n in window.shape]
    return (slice(first[0], None), first[1]) if axis == 0 else (first[0], slice(first[1], None))
