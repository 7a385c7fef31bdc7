"""Concentric rings: a contact with rotational symmetry, a few hundred cells, dense matrices.

The pressure is uniform on each ring, and displacements are averaged over a ring. So the influence
matrix is symmetric, and the mean of a paraboloid is its value at the root mean square radius of the
ring, where fields are given.

References
----------
K. L. Johnson (1985), Contact Mechanics, Cambridge University Press, section 3.4 (the displacement
of a uniform pressure on a disc).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import ClassVar

import numpy as np

from fretwear.arrays import Array, Places
from fretwear.mechanics.contact.dense import DenseCells, Distance
from fretwear.mechanics.contact.film import Film

# Ratio of two radii below which a series gives the influence of discs on each other.
_SMALL = 1e-3
# Narrow rings, for which differences of discs lose too many digits: largest width over the radius
# of the other, larger ring, and over their own.
_NARROW, _OF_RADIUS = 1e-5, 1e-2


@dataclass(frozen=True)
class Rings(DenseCells):
    """Concentric rings around the origin, given by the radii of their edges."""

    of_tolerance: ClassVar[float] = 0.25
    _whole: ClassVar[float] = math.pi

    def _measure(self, distance: Distance) -> Distance:
        return distance * distance

    @staticmethod
    def distance(x: Array, y: Array) -> Array:
        """Distance of points from the origin, m."""
        return np.hypot(x, y)

    @staticmethod
    def shares(x: Array, y: Array, radii: Array, cuts: tuple[Places, Places, Places]) -> Array:
        """Fraction of rectangles within circles."""
        # Area below a circle up to a side.
        below_x, below_y = (_below_circle(sides[:, None], radii) for sides in (x, y))
        row, column, circle = cuts
        radius = radii[circle]
        area = np.zeros(radius.size)
        for i, j in product((0, 1), (0, 1)):
            width, height = x[row + i], y[column + j]
            corner = below_x[row + i, circle] + below_y[column + j, circle]
            corner -= 0.25 * np.pi * radius**2
            is_within = width**2 + height**2 <= radius**2
            area += (1 if i == j else -1) * np.where(is_within, width * height, corner)
        return area / (np.diff(x)[row] * np.diff(y)[column])

    @cached_property
    def x(self) -> Array:
        """Root mean square of the radii of each ring, m, shape (n,)."""
        square = np.square(self.edges)
        return np.asarray(np.sqrt(0.5 * (square[1:] + square[:-1])))

    @property
    def extent(self) -> tuple[float, float]:
        """Half-widths of the square inside the outermost ring, m."""
        return self.edges[-1] / math.sqrt(2.0), self.edges[-1] / math.sqrt(2.0)

    def influence(self, modulus: float, film: Film | None = None) -> Array:
        """Mean displacement of each ring under a unit pressure on each, m/Pa, shape (n, n)."""
        edges = np.asarray(self.edges)
        unit = mean_influence(edges)
        integrals = unit / modulus
        if film is not None:
            # ½ c: F = c/k, c = 2/E*
            integrals += film.on_rings(edges, 0.5 * unit)
        return np.asarray(integrals / self.areas)

    def largest_mean(self, field: Array, width: float) -> float:
        """Largest mean of a field over an annulus of a width, m, around a ring."""
        r = self.x
        inner, outer = np.maximum(r - 0.5 * width, 0.0) ** 2, (r + 0.5 * width) ** 2
        square = np.square(self.edges)
        contents = np.concatenate([[0.0], np.cumsum(field[:, 0] * np.diff(square))])
        content = np.interp(outer, square, contents) - np.interp(inner, square, contents)
        return float((content / (outer - inner)).max())


def _below_circle(side: Array, radius: Array) -> Array:
    """Area, m², under a circle around the origin from x = 0 to a side, m, or to its radius."""
    share = np.minimum(side / radius, 1.0)
    area: Array = share * np.sqrt(1.0 - share**2) + np.arcsin(share)
    area *= 0.5 * radius**2
    return area


def mean_influence(edges: Array) -> Array:
    """Displacement integrated over each ring under a unit pressure on each, times E*, m³.

    Take discs of radii s and t, b the larger of the two and k the ratio of the smaller to it. Under
    a unit pressure on one, the displacement integrated over the other is (8/3) b³ [(1 + k²) E(k) −
    (1 − k²) K(k)] / E*; rings are differences of discs. ``edges`` are the radii of the edges of n
    rings from 0 outward, m; the result, shape (n, n), is symmetric.
    """
    discs = np.diag((16.0 / 3.0) * edges**3)
    larger, smaller = np.tril_indices(edges.size, -1)
    ratio = edges[smaller] / edges[larger]
    complement = (1.0 - ratio) * (1.0 + ratio)
    second, first = elliptic_integrals(np.sqrt(complement))
    square = ratio**2
    bracket = (1.0 + square) * second - complement * first
    # For a small disc the two terms cancel.
    series = 0.75 * math.pi * square * (1.0 - 0.125 * square)
    bracket = np.where(ratio < _SMALL, series, bracket)
    discs[larger, smaller] = discs[smaller, larger] = (8.0 / 3.0) * edges[larger] ** 3 * bracket
    influence = np.diff(np.diff(discs, axis=0), axis=1)
    widths, middles = np.diff(edges), 0.5 * (edges[1:] + edges[:-1])
    lost = widths[:, None] < _NARROW * np.maximum.outer(middles, middles)
    narrow = lost & (widths < _OF_RADIUS * middles)[:, None] & (widths[:, None] <= widths)
    if narrow.any():
        across = 2.0 * math.pi * (middles * widths)[:, None] * np.diff(_mean_under_discs(edges))
        influence = np.where(narrow, across, np.where(narrow.T, across.T, influence))
    return influence


def _mean_under_discs(edges: Array) -> Array:
    """Mean displacement over narrow rings under a unit pressure on each disc, times E*, m.

    Differences of two discs of nearly the same radius lose half the digits. At the middle radius r
    of a ring, a disc of radius t causes (4/π) t E(k) inside its edge and (4/π) r [E(k) − (1 − k²)
    K(k)] outside, with k as above (Johnson, eq. 3.29). Near the edge this is singular as −(2/π) x
    ln|x| of the distance x = t − r, whose mean over the ring is known; the mean of the rest is
    nearly its value in the middle. Shape (n, n + 1).
    """
    middles, discs = 0.5 * (edges[1:] + edges[:-1])[:, None], edges[None, 1:]
    larger, distance = np.maximum(middles, discs), discs - middles
    apart = np.abs(distance) / larger
    second, first = elliptic_integrals(np.sqrt(apart * (2.0 - apart)))
    outer = second - apart * (2.0 - apart) * first
    sunk = 4.0 / math.pi * larger * np.where(distance > 0.0, second, outer)

    def integral(x: Array) -> Array:
        return 0.5 * x * x * (np.log(np.maximum(np.abs(x), np.finfo(np.float64).tiny)) - 0.5)

    width = np.diff(edges)[:, None]
    mean = (integral(distance + 0.5 * width) - integral(distance - 0.5 * width)) / width
    sunk -= 2.0 / math.pi * (mean - distance * np.log(np.abs(distance)))
    return np.concatenate([np.zeros((edges.size - 1, 1)), sunk], axis=1)


def elliptic_integrals(complement: Array) -> tuple[Array, Array]:
    """E and K by their complementary moduli k', not zero, by arithmetic-geometric means.

    scipy.special has both, but takes longer to import than a short run. The means converge
    quadratically from any start.
    """
    mean, geometric = np.ones(complement.shape), complement
    total, power = 0.5 * (1.0 - complement) * (1.0 + complement), 0.5
    while True:
        half = 0.5 * (mean - geometric)
        mean, geometric = mean - half, np.sqrt(mean * geometric)
        power *= 2.0
        total += power * half**2
        if not half.size or half.max() < 1e-9:
            break
    first = 0.5 * np.pi / mean
    return first * (1.0 - total), first
