"""Stresses at the surface, at an end of contact on the plane y = 0.

There the tension of a sliding contact is largest, and cells cannot show it: tractions end like the
root of the distance d to the edge, and uniform ones leave an error like √(h/a). The square of such
a traction is smooth across the edge, p² ~ d, so it is interpolated from the means over cells and
continued outwards; its root is integrated over cells that shrink towards the edge. The shear
traction is a sum of such pressures: µ(p − p*) at +Q, and less by 2µ(p − p̂) on the way to −Q.

Beyond the edge no traction acts, so σ_xx, σ_yy and σ_xy are the only stresses of the surface there.
A pressure that ends otherwise has no such value: where wear has taken all load from the slip zone,
the pressure of elastic bodies is singular at the edge of stick, and so are the surface stresses.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from fretwear.arrays import Array, Mask
from fretwear_cracks.influence import of_rectangles, of_strips

# Cells along x and y, on each side of the edge, that are divided.
_NEAR = (8, 12)
# Sizes of the smallest divisions along x and y, in cells, the ratio of one to the next, and the
# points of each, along an axis, at which tractions are read.
_SMALLEST, _GROWTH, _READINGS = (1e-4, 1e-2), 1.3, 3
# Pressures below this part of the largest are noise, and a cell with less than this part of the
# next one's pressure lies mostly beyond the edge.
_NOISE, _PARTIAL = 1e-3, 0.3
# Cells whose squares are continued outwards, and corrections of means of the root to values.
_CONTINUED, _CORRECTIONS = 5, 4
# Misfit, over the largest value, of squares to the parabola that continues them.
_MISFIT = 0.1


class Edge(NamedTuple):
    """The end of contact at x < 0 on the plane y = 0, and the stresses of its surface."""

    x: float  #: m
    of_pressure: Array  #: Pa, shape (6,), in the order of `COMPONENTS`
    of_shears: Array  #: of each of the shear tractions, shape (k, 6)


def stresses_at_edge(
    pressure: Array,
    shears: Array,
    friction: float,
    spacing: tuple[float, float],
    poisson_ratio: float,
    *,
    plane_strain: bool,
) -> Edge | None:
    """Stresses at the end of contact at x < 0.

    None if too few cells are loaded to find it, or if the pressure does not end there like a root:
    worn elastic bodies have singular pressure and stresses at the edge of stick.

    `pressure`, Pa, shape (nx, ny), and `shears`, shape (k, nx, ny), the first of them that at +Q,
    are on cells of both sides around the origin; in a line contact ny is 1.
    """
    x, y = (
        (np.arange(count) + 0.5 * (1 - count)) * step
        for count, step in zip(pressure.shape, spacing, strict=True)
    )
    row = 0.5 * (pressure[:, (y.size - 1) // 2] + pressure[:, y.size // 2])
    noise = _NOISE * float(pressure.max())
    outer = _outermost(row, noise)
    if outer is None or not 2 <= outer < x.size - _NEAR[0]:
        return None
    box = slice(max(outer - _NEAR[0], 0), outer + _NEAR[0] + 1), slice(None)
    if not plane_strain:
        middle = y.size // 2
        box = box[0], slice(max(middle - _NEAR[1], 0), middle + _NEAR[1])
    near_x, near_y = x[box[0]], y[box[1]]
    at_plus = pressure - shears[0] / friction
    hats = pressure - (shears[0] - shears) / (2.0 * friction)
    fields = np.stack([pressure, at_plus, *hats[1:]])
    squares, are_roots = zip(*(_continued(field[box], noise) for field in fields), strict=True)
    across = np.ones((1, 1)) if plane_strain else _weights(np.zeros(1), near_y)
    on_plane = (squares[0] @ across.T)[:, 0]
    if not are_roots[0][are_roots[0].size // 2] or not on_plane[0] < 0.0 < on_plane.max():
        return None
    inside = int(np.flatnonzero(on_plane > 0.0)[0])
    place = float(brentq(_interpolated, *near_x[inside - 1 : inside + 1], (on_plane, near_x)))
    # Corners of the divisions, with the place of the edge in the middle of the smallest.
    edges_x = _graded(near_x, spacing[0], place, _SMALLEST[0])
    read_x = _weights(_readings(edges_x), near_x)
    if plane_strain:
        kernels = of_strips(place - edges_x[:, None], 0.0, poisson_ratio)
        far = of_strips(place - _corners(x, spacing[0])[:, None], 0.0, poisson_ratio)
        read_y, parts = np.ones((1, 1)), (edges_x.size - 1, _READINGS, 1, 1)
        sign = -1.0
    else:
        edges_y = _graded(near_y, spacing[1], 0.0, _SMALLEST[1])
        read_y = _weights(_readings(edges_y), near_y)
        parts = (edges_x.size - 1, _READINGS, edges_y.size - 1, _READINGS)
        kernels = of_rectangles(place - edges_x[:, None], -edges_y, 0.0, poisson_ratio)
        # Seen from a corner of cells, functions of others are infinite.
        beside = _SMALLEST[1] * spacing[1] - _corners(y, spacing[1])
        far = of_rectangles(place - _corners(x, spacing[0])[:, None], beside, 0.0, poisson_ratio)
        sign = 1.0
    far[:, :, *box] = 0.0
    stresses = np.empty((2, len(fields), 6))
    for number, (field, square) in enumerate(zip(fields, squares, strict=True)):
        divided = np.sqrt(np.maximum(read_x @ square @ read_y.T, 0.0))
        divided = divided.reshape(parts).mean(axis=(1, 3))
        stresses[:, number] = sign * np.einsum("kcxy,xy->kc", kernels, divided)
        stresses[:, number] += sign * np.einsum("kcxy,xy->kc", far, field)
    of_pressure, of_shear = stresses
    full, at_start = friction * of_shear[0], friction * (of_shear[0] - of_shear[1])
    later = at_start - 2.0 * (full - friction * of_shear[2:])
    return Edge(place, of_pressure[0], np.concatenate([at_start[None], later]))


def _outermost(row: Array, noise: float) -> int | None:
    """The first loaded cell of a row that does not lie mostly beyond the edge."""
    if row.size <= _CONTINUED:
        return None
    loaded = row > noise
    loaded[:-1] &= row[:-1] > _PARTIAL * row[1:]
    behind = np.lib.stride_tricks.sliding_window_view(loaded, _CONTINUED + 1).all(axis=1)
    places = np.flatnonzero(behind)
    return int(places[0]) if places.size else None


def _continued(field: Array, noise: float) -> tuple[Array, Mask]:
    """The square of a pressure on cells, continued beyond its edge at the low end of each row.

    And whether each row ends like a root.
    """
    square, is_root = field * field, np.zeros(field.shape[1], bool)
    cells = np.arange(1.0, _CONTINUED + 1)
    nodes, weights = np.polynomial.legendre.leggauss(4)
    # The parabola of least squares, at points of these cells and at those beyond.
    fit = np.linalg.pinv(np.vander(cells, 3))
    at_nodes = np.vander((cells[:, None] + 0.5 * nodes).ravel(), 3) @ fit
    for column in range(field.shape[1]):
        outer = _outermost(field[:, column], noise)
        if outer is None:
            square[:, column] = 0.0
            continue
        behind = slice(outer + 1, outer + 1 + _CONTINUED)
        means = field[behind, column]
        values = means * means
        for _ in range(_CORRECTIONS):
            roots = np.sqrt(np.maximum(at_nodes @ values, noise**2)).reshape(_CONTINUED, -1)
            values = values * (means / (roots @ weights * 0.5)) ** 2
        fitted = np.vander(cells, 3) @ (fit @ values)
        if abs(fitted - values).max() < _MISFIT * values.max():
            continued = np.vander(np.arange(-outer, 1.0), 3) @ (fit @ values)
            # Beyond the edge a parabola may turn upwards.
            square[: outer + 1, column] = np.minimum.accumulate(continued[::-1])[::-1]
            square[behind, column], is_root[column] = fitted, True
        else:
            # Not the root of anything smooth: it ends between two cells.
            square[:outer, column] = -square[outer, column]
    return square, is_root


def _corners(centres: Array, step: float) -> Array:
    return np.append(centres - 0.5 * step, centres[-1] + 0.5 * step)


def _graded(centres: Array, step: float, place: float, smallest: float) -> Array:
    """Corners from one end of cells to the other, ever closer to each other towards a place."""
    low, high = centres[0] - 0.5 * step, centres[-1] + 0.5 * step
    longest = max(place - low, high - place) / (smallest * step)
    away = 0.5 * smallest * step * _GROWTH ** np.arange(np.log(2.0 * longest) / np.log(_GROWTH))
    below, above = (away[away < 0.9 * reach] for reach in (place - low, high - place))
    return np.concatenate([[low], place - below[::-1], place + above, [high]])


def _readings(corners: Array) -> Array:
    """Points at which each division is read, evenly spaced."""
    within = (np.arange(_READINGS) + 0.5) / _READINGS
    return (corners[:-1, None] + np.diff(corners)[:, None] * within).ravel()


def _weights(points: Array, centres: Array) -> Array:
    """Cubic interpolation between the centres of cells, shape (points, cells)."""
    places = (points - centres[0]) / (centres[1] - centres[0])
    first = np.clip(places.astype(int) - 1, 0, centres.size - 4)
    weights = np.zeros((points.size, centres.size))
    rows = np.arange(points.size)[:, None]
    nodes = np.arange(4.0)
    apart = np.where(np.eye(4), 1.0, nodes[:, None] - nodes)
    along = np.where(np.eye(4), 1.0, (places - first)[:, None, None] - nodes)
    weights[rows, first[:, None] + np.arange(4)] = (along / apart).prod(axis=2)
    return weights


def _interpolated(place: float, values: Array, centres: Array) -> float:
    return float((_weights(np.array([place]), centres) @ values)[0])
