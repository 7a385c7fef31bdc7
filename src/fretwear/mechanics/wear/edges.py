"""Edges of contact, stick and scar: where they cut cells, and how well that is known.

The edge of a smooth contact lies between the last cell inside and the first one outside. Rough
contacts end at a tip, whose lowest point lies somewhere in its cell.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import nan, sqrt
from typing import TypeAlias

import numpy as np

from fretwear.arrays import Array, Mask
from fretwear.mechanics.contact.cells import WITHIN_A_CELL, Even, Way

# Cells on an axis or a part of it: places, and distances from the origin, m.
Lines: TypeAlias = Sequence[tuple[Way, Array]]

# Gap, over the gap of the first cell outside, above which a cell is not in contact.
_NO_GAP = 1e-2
# Depth of a scar over its maximum at which a profilometer sees its end.
_SHALLOW = 0.01


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
            edge = max([edge, *(tip.edge for tip in beyond if tip.lowest < 0.0)])
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
        (abs(tip.lowest), (tip.edge - float(at[last])) / len(lines), tip.lowest)
        for line, at in lines
        if (zone := np.flatnonzero(inside[line])).size
        for last in zone[-1:]
        for tip in _tips_beyond(line, at, inside, gap)
    ]
    return min(tips)[1:] if tips else (0.0, nan)


@dataclass(frozen=True)
class _Tip:
    """A tip beyond a zone, on the line of an axis."""

    lowest: float  # gap at its lowest point, m
    edge: float  # outer edge of its contact, or its place, m from the origin


def _tips_beyond(line: Way, distance: Array, inside: Mask, gap: Array) -> list[_Tip]:
    """The tips on a line beyond the last cell of a zone, the nearest first.

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
        tips.append(_Tip(lowest, float(edge)))
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
