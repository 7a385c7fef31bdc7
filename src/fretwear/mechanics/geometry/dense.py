"""Some hundreds of graded cells from the origin outward, with dense matrices; strips of a line.

The cells between edges from 0 outward have a uniform pressure each, and displacements are averaged
over a cell. The influence matrix is therefore symmetric, and the linear problem of the free cells
is solved directly. Concentric rings are in `fretwear.mechanics.geometry.rings`.

A cylinder along y touches in a strip: plane strain. Fields depend on x alone, loads are per length,
and where a contact of three dimensions has areas, this one has widths. The surface of a half-plane
under a load per length sinks without bound, so displacements count from that at a distance from the
middle, `fretwear.theory.LineContact.reference`: K. L. Johnson (1985), Contact Mechanics, Cambridge
University Press, section 2.4.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from fretwear.arrays import Array, Mask, Single
from fretwear.mechanics.geometry import Index, Workspace, Zone
from fretwear.mechanics.geometry.grid import Grid
from fretwear.mechanics.team import ALONE, Team
from fretwear.theory import LineContact, share_of_band

# Fraction of the cells that must hold the contact, and the factor by which they grow.
_ROOM, _GROWTH = 0.88, 1.12
# Number of cells of a grid written at once.
_CELLS_AT_ONCE = 50_000
# Widths of strips in units of the Hertzian half-width: at the stick edge, where the elastic
# pressure grows without bound, and of the widest; and how the width grows with the distance.
NARROWEST, _WIDEST, _GRADING = 1e-4, 0.004, 0.05
# Strips across an unworn slip zone, at least.
_ACROSS_SLIP = 20.0
# Where bodies yield, the stick edge moves inward, and the band that yields moves with it: there
# strips stay narrow longer, and a band in the limit of many cycles has so many of them at first.
_INWARD_GRADING, _ACROSS_BAND = 0.03, 6.0


@dataclass(frozen=True)
class DenseCells:
    """Cells from the origin outward."""

    edges: tuple[float, ...]  # distances of the edges of the cells from 0 outward, m

    of_tolerance: ClassVar[float] = 1.0
    # Area within a distance from the origin, over `_measure` of the distance.
    _whole: ClassVar[float]

    def _measure(self, distance: Any) -> Any:
        """A function of the distance from the origin that is proportional to the area within."""
        raise NotImplementedError

    def _distance(self, x: Array, y: Array) -> Any:
        """Distance of points from the origin, m."""
        raise NotImplementedError

    def _within(self, sides: tuple[Array, Array, Array, Array], radius: Array) -> Any:
        """Fraction of rectangles between two x and two y, m, within a distance, m."""
        raise NotImplementedError

    def influence(self, modulus: float) -> Array:
        """Mean displacement of each cell under a unit pressure on each, m/Pa, shape (n, n)."""
        raise NotImplementedError

    @property
    def x(self) -> Array:
        """Position at which a paraboloid takes its mean over a cell, m, shape (n,)."""
        raise NotImplementedError

    @property
    def y(self) -> Array:
        """The x axis stands for all."""
        return np.zeros(1)

    @property
    def shape(self) -> tuple[int, int]:
        """Of fields: one column."""
        return len(self.edges) - 1, 1

    @property
    def extent(self) -> tuple[float, float]:
        """Half-widths of the written region, m."""
        raise NotImplementedError

    @cached_property
    def areas(self) -> Any:
        """Areas of the cells, m², or widths in a line contact, m, shape (n, 1)."""
        return self._whole * np.diff(self._measure(np.asarray(self.edges)))[:, None]

    @cached_property
    def unit_area(self) -> float:
        """Mean of `areas`."""
        return float(self.areas.mean())

    @cached_property
    def weights(self) -> Any:
        """`areas` over their mean."""
        return self.areas / self.unit_area

    def integral(self, field: Array) -> float:
        """Integral of a field over the whole contact."""
        return float((self.areas * field).sum())

    def half_space(self, modulus: float, team: Team = ALONE, parts: Any = None) -> DenseHalfSpace:  # noqa: ARG002
        """The elastic bodies on the cells; some hundreds need one thread, and have no parts."""
        return DenseHalfSpace(self, modulus)

    def zone(self, cells: Mask, radius: float) -> Zone:
        """The zone of some cells that reaches as far as a distance, m."""
        edges = np.asarray(self.edges)
        cells = cells & (edges[:-1, None] < radius)
        area = self.integral(cells.astype(np.float64))
        if cells.any():
            last = np.flatnonzero(cells)[-1]
            within, beyond = edges[last : last + 2]
            part = self._measure(beyond) - self._measure(max(radius, within))
            share = part / (self._measure(beyond) - self._measure(within))
            area -= float(self.areas[last, 0] * share)
        steps = np.flatnonzero(cells[1:, 0] != cells[:-1, 0])
        inner = np.where(cells[steps, 0], steps, steps + 1)
        return Zone(area, inner, 2 * steps + 1 - inner)

    def covered(self, cells: Mask, radius: float, plane: Any) -> NDArray[np.float64]:
        """The part of each cell of a grid in the zone of some cells that ends at a distance, m.

        As in `zone`: times the area of a cell, their sum is the area of the zone.
        """
        edges = np.asarray(self.edges)
        cells = cells[:, 0] & (edges[:-1] < radius)
        last = int(np.flatnonzero(cells).max(initial=-1))
        if last < 0:
            return np.zeros(plane.shape)
        cut = np.unique(np.append(edges, radius))
        place = np.searchsorted(edges, cut[:-1], "right") - 1
        inside = (cells[np.minimum(place, cells.size - 1)] | (place > last)) & (cut[:-1] < radius)
        parts = {"": inside[:, None].astype(np.float64)}
        return replace(self, edges=tuple(cut.tolist())).written(parts, plane)[""]

    def resized(self, field: NDArray[Any], other: Any) -> NDArray[Any]:
        """A field on other cells: of the same integral, zero beyond the outermost of these.

        Cells that both have from the innermost outward keep their values. Between other edges, the
        integral from the origin is interpolated monotonically: positive fields remain positive.
        """
        count = self.where(other)[0].stop
        if count:
            result = np.zeros(other.shape, dtype=field.dtype)
            result[:count] = field[:count]
            return result
        places, others = (self._measure(np.asarray(each.edges)) for each in (self, other))
        within = np.concatenate([[0.0], np.cumsum(field[:, 0] * np.diff(places))])
        found = interpolated(places, within, np.minimum(others, places[-1]))
        return np.asarray((np.diff(found) / np.diff(others))[:, None])

    def where(self, smaller: Any) -> Index:
        """Indices of the cells shared with another set, if one extends the other."""
        common = min(len(self.edges), len(smaller.edges))
        alike = self.edges[:common] == smaller.edges[:common]
        return slice(0, common - 1 if alike else 0), slice(0, 1)

    def along(self, axis: int) -> list[tuple[tuple[slice | int, slice | int], Array]]:  # noqa: ARG002
        """Index of all cells, and their distances, m."""
        return [((slice(None), 0), self.x)]

    def ahead_of(self, problem: Any, contact: Any) -> Self:
        """Cells that reach further if the next step may bring the contact to the border."""
        return self.holding(Workspace(problem), contact.pressure, contact.approach)

    def holding(self, workspace: Workspace, pressure: Array, approach: float) -> Self:  # noqa: ARG002
        """These cells, or more if the contact needs them."""
        waves = workspace.problem.wavelengths
        # Where it is rough a wavelength more, to the next tip.
        return self.reaching(self._radius(pressure) + (waves[0] if waves else 0.0))

    def _radius(self, field: NDArray[Any]) -> float:
        """Largest distance from the origin at which a field is not zero, m."""
        return self.edges[int(np.flatnonzero(field).max(initial=-1)) + 1]

    def reaching(self, radius: float) -> Self:
        """These cells, or ones that reach further if a contact of a radius, m, needs them."""
        return self if radius <= _ROOM * self.extent[0] else self._out_to(_GROWTH * self.edges[-1])

    def extended(self, other: Any) -> Self:
        """These cells, extended to the size of others."""
        return self if other.edges[-1] <= self.edges[-1] else self._out_to(other.edges[-1])

    def _out_to(self, radius: float) -> Self:
        last, width = self.edges[-1], self.edges[-1] - self.edges[-2]
        count = math.ceil((radius - last) / width * (1.0 - 1e-9))
        added = (last + (step + 1) * width for step in range(count))
        return replace(self, edges=(*self.edges, *added))

    def plane(self, spacing: tuple[float, float]) -> Grid:
        """The grid on which fields are written: a quarter of what the cells hold, or a row."""
        x, y = (
            max(1, math.floor(each / size)) for each, size in zip(self.extent, spacing, strict=True)
        )
        return Grid((x, y), spacing)

    def written(self, fields: dict[str, NDArray[Any]], plane: Any) -> dict[str, NDArray[Any]]:
        """Means of fields over the cells of a grid; of states, that of most of a cell.

        Across a cell a field falls evenly by the lesser of its slopes on either side: integrals are
        kept, and no mean lies beyond the values around it.
        """
        steps = np.ceil(np.diff(self.edges) / (0.5 * min(plane.spacing))).astype(int)
        cell = np.repeat(np.arange(steps.size), steps)
        part = np.arange(cell.size) - np.repeat(np.cumsum(steps) - steps, steps)
        edges = np.asarray(self.edges)
        parts = edges[cell] + np.diff(edges)[cell] * part / steps[cell]
        measures = self._measure(np.append(parts, edges[-1]))
        middle = 0.5 * (self._measure(edges[1:]) + self._measure(edges[:-1]))
        beyond = 0.5 * (measures[1:] + measures[:-1]) - middle[cell]
        parts_of = {name: field[cell, 0] for name, field in fields.items()}
        for name, field in fields.items():
            if field.dtype.kind == "f":
                slopes = np.diff(field[:, 0]) / np.diff(middle)
                before, slopes = np.append(0.0, slopes), np.append(slopes, slopes[-1])
                least = np.where(np.abs(slopes) < np.abs(before), slopes, before)
                parts_of[name] += beyond * np.where(slopes * before > 0.0, least, 0.0)[cell]
        found = {name: np.empty(plane.shape, field.dtype) for name, field in fields.items()}
        rows = max(1, _CELLS_AT_ONCE // plane.shape[1])
        for first in range(0, plane.shape[0], rows):
            block = slice(first, min(first + rows, plane.shape[0]))
            at, share, starts = self._shares(parts, plane, block)
            for name, values in parts_of.items():
                if values.dtype.kind == "f":
                    means = np.add.reduceat(share * values[at], starts)
                else:
                    kinds = np.unique(values)
                    each = [np.add.reduceat(share * (values[at] == kind), starts) for kind in kinds]
                    means = kinds[np.argmax(each, axis=0)]
                found[name][block] = means.reshape(-1, plane.shape[1])
        return found

    def _shares(
        self, parts: Array, plane: Any, block: slice
    ) -> tuple[NDArray[np.intp], Array, NDArray[np.intp]]:
        """Parts of these cells in each cell of some rows of a grid, their shares, and the first.

        ``parts`` are the inner edges of the parts, m.
        """
        x = np.arange(block.start, block.stop + 1)[:, None] * plane.spacing[0]
        y = np.arange(plane.shape[1] + 1)[None, :] * plane.spacing[1]
        near, far = self._distance(x[:-1], y[:, :-1]), self._distance(x[1:], y[:, 1:])
        low = np.searchsorted(parts, near.ravel(), "right") - 1
        count = np.maximum(np.searchsorted(parts, far.ravel()) - low, 1)
        starts = np.cumsum(count) - count
        at = np.arange(count.sum()) - np.repeat(starts - low, count)
        continues = at > np.repeat(low, count)
        row, column = np.divmod(np.repeat(np.arange(count.size), count)[continues], plane.shape[1])
        sides = x[row, 0], x[row + 1, 0], y[0, column], y[0, column + 1]
        # Fraction of its cell within each part.
        within = np.zeros(at.size)
        within[continues] = self._within(sides, parts[at[continues]])
        up_to = np.where(np.append(continues[1:], False), np.append(within[1:], 1.0), 1.0)
        return at, up_to - within, starts


def interpolated(places: Array, values: Array, others: Array) -> Array:
    """Values at other positions, by monotone cubics: Fritsch and Carlson (1980).

    "Monotone piecewise cubic interpolation", SIAM J. Numer. Anal. 17; slopes are the harmonic means
    of Fritsch and Butland (1984). scipy has them too, and takes longer to import than a short run.
    """
    steps, rises = np.diff(places), np.diff(values) / np.diff(places)
    before, after = 2.0 * steps[1:] + steps[:-1], steps[1:] + 2.0 * steps[:-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = (before / rises[:-1] + after / rises[1:]) / (before + after)
        inner = np.where(rises[:-1] * rises[1:] > 0.0, 1.0 / inverse, 0.0)
    ends = [_slope_at_end(steps[i], steps[j], rises[i], rises[j]) for i, j in ((0, 1), (-1, -2))]
    slopes = np.concatenate([ends[:1], inner, ends[1:]])
    bend = (slopes[:-1] + slopes[1:] - 2.0 * rises) / steps
    at = np.clip(np.searchsorted(places, others, "right") - 1, 0, steps.size - 1)
    beyond = others - places[at]
    square = beyond * beyond
    linear = values[at] + slopes[at] * beyond + ((rises - slopes[:-1]) / steps - bend)[at] * square
    return np.asarray(linear + (bend / steps)[at] * (square * beyond))


def _slope_at_end(step: float, following: float, rise: float, next_rise: float) -> float:
    """Of the parabola through three values, as far as it is monotone."""
    slope = ((2.0 * step + following) * rise - step * next_rise) / (step + following)
    if slope * rise <= 0.0:
        return 0.0
    return 3.0 * rise if rise * next_rise < 0.0 and abs(slope) > 3.0 * abs(rise) else slope


class DenseHalfSpace:
    """The elastic half-space under a pressure that is uniform on each cell."""

    team: ClassVar[Team] = ALONE

    def __init__(self, geometry: DenseCells, composite_modulus: float) -> None:
        self.geometry = geometry
        self.influence = geometry.influence(composite_modulus)
        # The largest displacement of a cell per pressure on itself, m/Pa.
        self.self_influence = float(self.influence.diagonal().max())
        # Influence over that, times the weights of the cells; symmetric.
        matrix = geometry.weights * self.influence / self.self_influence
        self.matrix = 0.5 * (matrix + matrix.T)

    def displacement(self, pressure: Array) -> Array:
        """Normal surface displacement w, m, of a pressure, Pa, in the mean over each cell."""
        return np.asarray(self.influence @ pressure)

    def relative_displacement(self, pressure: Array) -> tuple[Single, float]:
        """`displacement` in single precision in some unit, m, and the unit."""
        return self.team.scaled(self.displacement(pressure))

    def around(self, cells: Mask) -> DenseHalfSpace:  # noqa: ARG002 - parts would gain nothing
        """The same bodies."""
        return self


@dataclass(frozen=True)
class Line(DenseCells):
    """Strips of the half x > 0 of an even line contact.

    Displacements are zero at the distance ``reference``, m, from the centre line.
    """

    reference: float
    _whole: ClassVar[float] = 2.0

    def _measure(self, distance: Any) -> Any:
        return distance

    def _distance(self, x: Array, y: Array) -> Any:
        return x + 0.0 * y

    def _within(self, sides: tuple[Array, Array, Array, Array], radius: Array) -> Any:
        left, right, _, _ = sides
        return (radius - left) / (right - left)

    @property
    def extent(self) -> tuple[float, float]:
        """Half-width of the written row, m; none along y."""
        return self.edges[-1], 0.0

    @cached_property
    def x(self) -> Any:
        """Root mean square of the positions in each strip, m, shape (n,)."""
        edges = np.asarray(self.edges)
        left, right = edges[:-1], edges[1:]
        return np.sqrt((left * left + left * right + right * right) / 3.0)

    @classmethod
    def first(cls, problem: Any) -> Line:
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
        narrowest = wider * min(NARROWEST * hertz.contact_radius, annulus)
        inward = _GRADING * wider
        if not math.isinf(problem.plastic_limit):
            limiting = problem.indenter.limiting(hertz, min(1.0 - load / hertz.load, 0.9999))
            band = limiting.width_above(problem.plastic_limit)
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

    def influence(self, modulus: float) -> Array:
        """Mean displacement of each strip under a unit pressure on each, m/Pa, shape (n, n).

        −(2/πE*) ∫ ln(|x − ξ|/L) dξ of the strips and their images, L the reference.
        """
        edges = np.asarray(self.edges) / self.reference
        twice = _logarithm(edges[:, None] + edges) - _logarithm(edges[:, None] - edges)
        integrals = np.diff(np.diff(twice, axis=0), axis=1) * self.reference**2
        return -2.0 / (math.pi * modulus) * integrals / np.diff(self.edges)[:, None]


def influence_of_cell(count: int, spacing: float, reference: float, modulus: float) -> Array:
    """Mean displacement of equal cells under a unit pressure on one, m/Pa, by their distance.

    Without images: for a contact that is not even. Parameters as of `Line`, ``count`` distances.
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
