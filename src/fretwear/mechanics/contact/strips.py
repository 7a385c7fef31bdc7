"""The strips of a line contact in plane strain.

A cylinder along y touches in a strip. Fields depend on x alone, loads are per length, and widths
take the place of the areas of a contact in three dimensions. The surface of a half-plane under a
load per length sinks without bound, so displacements are relative to the surface at a distance from
the middle, `fretwear.theory.LineContact.reference`: K. L. Johnson (1985), Contact Mechanics,
Cambridge
University Press, section 2.4.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np

from fretwear.arrays import Array, Places
from fretwear.mechanics.contact.cells import (
    ANYWHERE,
    WITHIN_A_CELL,
    Geometry,
    Region,
    Way,
    Zone,
)
from fretwear.mechanics.contact.dense import WIDENED, DenseCells, DenseHalfSpace, Distance
from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.slip.protocols import FrettingProblem, WornContact
from fretwear.theory import LineContact, share_of_band

# Widths of strips in units of the Hertzian half-width: the narrowest, at the stick edge, where the
# elastic pressure grows without bound, and the widest; and growth of the width with the distance.
NARROWEST_STRIP, _WIDEST, _GRADING = 1e-4, 0.004, 0.05
# The widest in units of the present half-width of a contact that slides as a whole.
_WIDEST_SLIDING = 0.006
# Least number of strips across an unworn slip zone.
_ACROSS_SLIP = 20.0
# Where bodies yield, the stick edge moves inward, and the band that yields moves with it: there
# strips stay narrow longer, and a band in the limit of many cycles has so many of them at first.
_INWARD_GRADING, _ACROSS_BAND = 0.03, 6.0


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
    def within(x: Array, y: Array, radii: Array, cuts: tuple[Places, Places, Places]) -> Array:  # noqa: ARG004
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

    @classmethod
    def first(cls, problem: FrettingProblem) -> Strips:
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
        annulus = (hertz.contact_radius - stick) / _ACROSS_SLIP
        narrowest = wider * min(NARROWEST_STRIP * hertz.contact_radius, annulus)
        inward = _GRADING * wider
        if not math.isinf(problem.slip_limit):
            limiting = problem.indenter.limiting(hertz, min(1.0 - load / hertz.load, 0.9999))
            band = limiting.width_above(problem.slip_limit)
            # A band too narrow for the strips of an elastic contact to yield leaves them as is.
            share = share_of_band(band, narrowest)
            narrowest *= min(1.0, band / _ACROSS_BAND / narrowest) ** share
            inward *= min(1.0, _INWARD_GRADING / inward) ** share
        widths = narrowest, _WIDEST * scale
        # A strip that holds no more than the stick zone would be a sliver.
        stick = stick if stick > narrowest else 0.0
        inner = stick - _distances(stick, *widths, inward)[::-1]
        inner[0] = 0.0
        outside = stick + _distances(outer - stick, *widths, _GRADING * wider)[1:]
        return cls((*inner.tolist(), *outside.tolist()), hertz.reference)

    def ahead_of(self, problem: FrettingProblem, worn: WornContact) -> Strips:
        """Strips that reach far enough, and wider ones where a contact slides as a whole.

        It has no edge of stick, and its scar may become many times wider than the unworn contact.
        """
        reaching = super().ahead_of(problem, worn)
        if problem.wavelengths is not None or worn.reduced.pressure.any():
            return reaching
        radius = self._radius(worn.wear + worn.pressure)
        widest = _WIDEST_SLIDING * problem.coarseness * radius
        outermost = reaching.edges[-1] - reaching.edges[-2]
        return reaching if outermost > 0.5 * widest else reaching._merged(widest)

    def _merged(self, widest: float) -> Strips:
        """Every strip joined with the next, if both together are at most so wide, m."""
        edges, kept = self.edges, [0.0]
        for edge, following in pairwise((*edges[1:], math.inf)):
            if following - kept[-1] > widest:
                kept.append(edge)
        return replace(self, edges=tuple(kept))

    def influence(self, modulus: float) -> Array:
        """Mean displacement of each strip under a unit pressure on each, m/Pa, shape (n, n).

        −(2/πE*) ∫ ln(|x − ξ|/L) dξ of the strips and their images, L the reference.
        """
        edges = np.asarray(self.edges) / self.reference
        twice = _logarithm(edges[:, None] + edges) - _logarithm(edges[:, None] - edges)
        integrals = np.diff(np.diff(twice, axis=0), axis=1) * self.reference**2
        return -2.0 / (math.pi * modulus) * integrals / np.diff(self.edges)[:, None]


@dataclass(frozen=True)
class Row(Grid):
    """Equal strips on both sides of the middle of a line contact that is not even."""

    reference: float = 1.0  #: distance, m, at which displacements are zero
    plane_strain: ClassVar[bool] = True

    @classmethod
    def first(cls, problem: FrettingProblem) -> Row:
        """Strips for the first loading of a problem."""
        assert isinstance(problem.hertz, LineContact)
        row = cls((2, 1), problem.spacing, (False, True), problem.hertz.reference)
        return row._out_to(problem.extent[0] + (problem.wavelengths or (0.0,))[0])

    def ahead_of(self, problem: FrettingProblem, worn: WornContact) -> Row:
        """Strips that reach far enough for the next step."""
        return self._holding(problem, worn.pressure, WIDENED)

    def holding(self, workspace: Any, pressure: Array, approach: float) -> Row:  # noqa: ARG002
        """These strips, or more if the contact needs them."""
        return self._holding(workspace.problem, pressure)

    def _holding(self, problem: FrettingProblem, pressure: Array, widened: float = 1.0) -> Row:
        touched = np.abs(self.x[pressure[:, 0] > 0.0]).max(initial=0.0) + self.spacing[0]
        half = widened * touched + (problem.wavelengths or (0.0,))[0]
        return self if half <= self.extent[0] else self._out_to(1.1 * half)

    def _out_to(self, half: float) -> Row:
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

    def along(self, axis: int) -> list[tuple[Way, Array]]:  # noqa: ARG002
        """The positive and the negative side: indices, and distances, m."""
        return super().along(0)

    def half_space(self, modulus: float) -> DenseHalfSpace:  # type: ignore[override]
        """The elastic bodies on the strips."""
        cells = np.arange(self.shape[0])
        column = influence_of_cell(cells.size, self.spacing[0], self.reference, modulus)
        return DenseHalfSpace(self, column[np.abs(cells[:, None] - cells)])

    def zone(self, region: Region) -> Zone:
        """The zone of a region, which ends at its distance in the mean of both sides."""
        cells = region.cells
        steps = np.flatnonzero(cells[1:, 0] != cells[:-1, 0])
        inner = np.where(cells[steps, 0], steps, steps + 1)
        deviations = np.full(steps.size, ANYWHERE * self.unit_area)
        deviations[[0, -1] if steps.size else []] *= WITHIN_A_CELL / ANYWHERE
        area = self.integral(self.covered(region, self))
        return Zone(area, inner, 2 * steps + 1 - inner, deviations)

    def covered(self, region: Region, plane: Geometry) -> Array:  # noqa: ARG002 - these strips
        """The fraction of each strip in a region."""
        fractions, inside = region.cells.astype(np.float64), np.flatnonzero(region.cells)
        if inside.size:
            ends = inside[[0, -1]]
            beyond = 0.5 * (np.diff(ends)[0] + 1) - region.radius / self.spacing[0]
            fractions[ends] = np.clip(1.0 - beyond, 0.0, 1.0)
        return fractions


def influence_of_cell(count: int, spacing: float, reference: float, modulus: float) -> Array:
    """Mean displacement of equal cells under a unit pressure on one, m/Pa, by their distance.

    It has no images, for a contact that is not even. Parameters are as for `Strips`, with ``count``
    distances.
    """
    at = np.arange(-1.0, count + 1.0) * (spacing / reference)
    return -2.0 / (math.pi * modulus) * reference**2 / spacing * np.diff(_logarithm(at), 2)


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
