"""Strips of a line contact: plane strain, half of an even contact, dense matrices.

A cylinder along y touches in a strip. Fields depend on x alone, loads are per length, and where a
contact of three dimensions has areas, this one has widths. The surface of a half-plane under a
load per length sinks without bound, so displacements count from that at a distance from the middle,
`fretwear.theory.LineContact.reference`.

References
----------
K. L. Johnson (1985), Contact Mechanics, Cambridge University Press, section 2.4.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from fretwear.mechanics.geometry import Array
from fretwear.mechanics.geometry.dense import DenseCells
from fretwear.mechanics.geometry.grid import Grid
from fretwear.theory import LineContact

if TYPE_CHECKING:
    from fretwear.mechanics.state import WearProblem

# Widths in units of the Hertzian half-width: at the stick edge, where the elastic pressure grows
# without bound, and of the widest strips; and how the width grows with the distance from it.
_NARROWEST = 1e-4
_WIDEST = 0.004
_GRADING = 0.05
# Where bodies yield, the stick edge moves inward, and the band that yields moves with it: there
# strips stay narrow longer, and a band in the limit of many cycles has so many of them at first.
_INWARD_GRADING = 0.03
_ACROSS_BAND = 6.0


@dataclass(frozen=True)
class Line(DenseCells):
    """Strips of the half x > 0 of an even line contact.

    Parameters
    ----------
    edges
        Positions of the edges of the strips from 0 outward, m.
    reference
        Distance from the centre line of the point at which displacements are zero, m.
    """

    reference: float

    @classmethod
    def first(cls, problem: WearProblem) -> Line:
        """Strips for the first loading of a problem, graded to the edge of its stick zone.

        Strips of a rough contact, which sticks and slips in many places, are equal.
        """
        hertz, outer, wider = problem.hertz, problem.extent[0], problem.coarseness
        assert isinstance(hertz, LineContact)
        if problem.wavelengths is not None:
            width = problem.spacing[0]
            edges = np.arange(math.ceil((outer + problem.wavelengths[0]) / width) + 1) * width
            return cls(tuple(edges.tolist()), hertz.reference)
        load, scale = problem.stick_load, wider * hertz.contact_radius
        stick = hertz.with_load(load).contact_radius if load > 0.0 else 0.0
        narrowest, inward = _NARROWEST * scale, _GRADING * wider
        if not math.isinf(problem.limit):
            band = problem.limiting.width_above(problem.limit)
            narrowest, inward = min(narrowest, band / _ACROSS_BAND), min(inward, _INWARD_GRADING)
        widths = narrowest, _WIDEST * scale
        inner = stick - _distances(stick, *widths, inward)[::-1]
        inner[0] = 0.0
        outside = stick + _distances(outer - stick, *widths, _GRADING * wider)[1:]
        return cls((*inner.tolist(), *outside.tolist()), hertz.reference)

    @cached_property
    def areas(self) -> Array:
        """Widths of the strips and their images, m, shape (n, 1)."""
        return 2.0 * np.diff(self.edges)[:, None]

    @cached_property
    def x(self) -> Array:
        """Root mean square of the positions in each strip, m, shape (n,)."""
        edges = np.asarray(self.edges)
        left, right = edges[:-1], edges[1:]
        result: Array = np.sqrt((left * left + left * right + right * right) / 3.0)
        return result

    def influence(self, modulus: float) -> Array:
        """Mean displacement of each strip under a unit pressure on each, m/Pa, shape (n, n).

        −(2/πE*) ∫ ln(|x − ξ|/L) dξ of the strips and their images, L the reference.
        """
        edges = np.asarray(self.edges) / self.reference
        twice = _logarithm(edges[:, None] + edges) - _logarithm(edges[:, None] - edges)
        integrals = np.diff(np.diff(twice, axis=0), axis=1) * self.reference**2
        return -2.0 / (math.pi * modulus) * integrals / np.diff(self.edges)[:, None]

    def plane(self, spacing: tuple[float, float]) -> Grid:
        """The row of cells on which fields are written."""
        return Grid((max(1, math.floor(self.extent[0] / spacing[0])), 1), spacing)

    def _distance(self, x: Array, y: Array) -> Array:
        """Distance of points from the middle, m."""
        result: Array = x + 0.0 * y
        return result

    def _within(self, sides: tuple[Array, Array, Array, Array], radius: Array) -> Array:
        """Fraction of cells of a row within a distance from the centre line, m."""
        left, right, _, _ = sides
        return (radius - left) / (right - left)


def influence_of_cell(count: int, spacing: float, reference: float, modulus: float) -> Array:
    """Mean displacement of equal cells under a unit pressure on one, m/Pa, by their distance.

    Without images: for a contact that is not even. Parameters as of `Line`, ``count`` distances.
    """
    at = np.arange(-1.0, count + 1.0) * (spacing / reference)
    second: Array = np.diff(_logarithm(at), 2)
    return -2.0 / (math.pi * modulus) * reference**2 / spacing * second


def _logarithm(x: Array) -> Array:
    """A function whose second derivative is ln|x|."""
    square = x * x
    return 0.25 * square * np.log(np.maximum(square, np.finfo(np.float64).tiny)) - 0.75 * square


def _distances(length: float, narrowest: float, widest: float, grading: float) -> Array:
    """Distances from 0 to a length whose spacing grows with the distance between two bounds."""
    first, last = narrowest / grading, widest / grading
    middle = math.log(last / first) / grading
    # The count of strips up to a distance: linear, logarithmic, linear.
    start = first / narrowest
    total = length / narrowest
    if length >= first:
        total = start + math.log(min(length, last) / first) / grading
    total += max(length - last, 0.0) / widest
    count = np.linspace(0.0, total, math.ceil(total) + 1)
    growing = first * np.exp(grading * np.clip(count - start, 0.0, middle))
    result: Array = np.where(count < start, count * narrowest, growing)
    result += np.maximum(count - start - middle, 0.0) * widest
    result[-1] = length
    return result
