"""The strips of a line contact in plane strain.

A cylinder along y touches in a strip. Fields depend on x alone, loads are per length, and widths
replace the areas of a contact in three dimensions. The surface of a half-plane under a load per
length sinks without bound, so displacements are relative to the surface at a distance from the
middle, `fretwear.theory.LineContact.reference`: K. L. Johnson (1985), Contact Mechanics, Cambridge
University Press, section 2.4.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import ClassVar

import numpy as np

from fretwear.arrays import Array, Places
from fretwear.mechanics.contact.cells import Geometry, Region, Way, Zone
from fretwear.mechanics.contact.dense import DenseCells, DenseHalfSpace, Distance
from fretwear.mechanics.contact.film import Film
from fretwear.mechanics.contact.grid import Grid


@dataclass(frozen=True)
class Strips(DenseCells):
    """Strips of the half x > 0 of an even line contact.

    Displacements are zero at the distance ``reference``, m, from the centre line.
    """

    reference: float
    plane_strain: ClassVar[bool] = True
    _whole: ClassVar[float] = 2.0

    def _measure(self, distance: Distance) -> Distance:
        return distance

    @staticmethod
    def distance(x: Array, y: Array) -> Array:
        """Distance of points from the centre line, m."""
        return x + 0.0 * y

    @staticmethod
    def shares(x: Array, y: Array, radii: Array, cuts: tuple[Places, Places, Places]) -> Array:
        """Fraction of cells within distances from the centre line."""
        row, _, cut = cuts
        return np.asarray((radii[cut] - x[row]) / np.diff(x)[row])

    @property
    def extent(self) -> tuple[float, float]:
        """Half-width of the written row, m; none along y."""
        return self.edges[-1], 0.0

    @cached_property
    def x(self) -> Array:
        """Root mean square of the positions in each strip, m, shape (n,)."""
        edges = np.asarray(self.edges)
        left, right = edges[:-1], edges[1:]
        return np.asarray(np.sqrt((left * left + left * right + right * right) / 3.0))

    def merged(self, widest: float) -> Strips:
        """Pairs of neighbouring strips joined where both together are at most so wide, m."""
        edges, kept = self.edges, [0.0]
        for edge, following in pairwise((*edges[1:], math.inf)):
            if following - kept[-1] > widest:
                kept.append(edge)
        return replace(self, edges=tuple(kept))

    def influence(self, modulus: float, film: Film | None = None) -> Array:
        """Mean displacement of each strip under a unit pressure on each, m/Pa, shape (n, n).

        −(2/πE*) ∫ ln(|x − ξ|/L) dξ of the strips and their images, L the reference.
        """
        edges, sunk = np.asarray(self.edges), _sinking(self.reference, modulus, film)
        twice = sunk(edges[:, None] + edges) - sunk(edges[:, None] - edges)
        return np.diff(np.diff(twice, axis=0), axis=1) / np.diff(edges)[:, None]


@dataclass(frozen=True)
class Row(Grid):
    """Equal strips on both sides of the middle of a line contact that is not even."""

    reference: float = 1.0  #: distance, m, at which displacements are zero
    plane_strain: ClassVar[bool] = True

    def out_to(self, half: float) -> Row:
        """Strips of the same width out to a distance, m."""
        return self.of_shape((2 * math.ceil(half / self.spacing[0]), 1))

    @property
    def unit_area(self) -> float:
        """Width of a strip, m."""
        return self.spacing[0]

    @property
    def extent(self) -> tuple[float, float]:
        """Half-width of the row, m; none along y."""
        return 0.5 * self.shape[0] * self.spacing[0], 0.0

    @property
    def y(self) -> Array:
        """Zero: the strips lie on the x axis."""
        return np.zeros(1)

    def axis_cells(self, axis: int) -> list[tuple[Way, Array]]:
        """The positive and the negative side: indices, and distances, m."""
        return super().axis_cells(0)

    def half_space(  # type: ignore[override]
        self, modulus: float, film: Film | None = None
    ) -> DenseHalfSpace:
        """The elastic bodies on the strips."""
        cells = np.arange(self.shape[0])
        column = influence_of_cell(cells.size, self.spacing[0], self.reference, modulus, film)
        return DenseHalfSpace(self, column[np.abs(cells[:, None] - cells)], modulus, film)

    def zone(self, region: Region) -> Zone:
        """The zone of a region, which ends at its distance in the mean of both sides."""
        cells = region.cells
        steps = np.flatnonzero(cells[1:, 0] != cells[:-1, 0])
        inner = np.where(cells[steps, 0], steps, steps + 1)
        area = self.integral(self.covered(region, self))
        return Zone(area, inner, 2 * steps + 1 - inner)

    def covered(self, region: Region, plane: Geometry) -> Array:
        """The fraction of each strip in a region."""
        fractions, held = region.cells.astype(np.float64), np.flatnonzero(region.cells)
        if held.size:
            ends = held[[0, -1]]
            excess = 0.5 * (np.diff(ends)[0] + 1) - region.radius / self.spacing[0]
            fractions[ends] = np.clip(1.0 - excess, 0.0, 1.0)
        return fractions


def influence_of_cell(
    count: int, spacing: float, reference: float, modulus: float, film: Film | None = None
) -> Array:
    """Mean displacement of equal cells under a unit pressure on one, m/Pa, by their distance.

    It has no images, as for a contact that is not even. Parameters are those of `Strips`, with
    ``count`` distances.
    """
    sunk = _sinking(reference, modulus, film)
    return np.asarray(np.diff(sunk(np.arange(-1.0, count + 1.0) * spacing), 2) / spacing)


def _sinking(reference: float, modulus: float, film: Film | None) -> Callable[[Array], Array]:
    """A function of distances, m, whose second derivative is the displacement by a load, 1/Pa."""
    factor = -2.0 / (math.pi * modulus) * reference**2
    if film is None:
        return lambda x: factor * _logarithm(x / reference)
    of_film = film.on_strips(reference)
    return lambda x: factor * _logarithm(x / reference) + of_film(x)


def _logarithm(x: Array) -> Array:
    """A function whose second derivative is ln|x|."""
    square = x * x
    return 0.25 * square * np.log(np.maximum(square, np.finfo(np.float64).tiny)) - 0.75 * square
