"""A few hundred graded cells from the origin outward, with dense matrices.

The common part of concentric rings (`fretwear.mechanics.geometry.rings`) and the strips of a line
contact (`fretwear.mechanics.geometry.line`): cells between edges from 0 outward, uniform pressure
on each, displacements averaged over a cell. The influence matrix is therefore symmetric, and the
linear problem of the free cells is solved directly.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from fretwear.mechanics.geometry import (
    Array,
    Index,
    Mask,
    Single,
    Workspace,
    Zone,
)
from fretwear.mechanics.team import ALONE, Team

if TYPE_CHECKING:
    from fretwear.mechanics.state import State, WearProblem

# Fraction of the cells that must hold the contact, and the factor by which they grow.
_ROOM = 0.88
_GROWTH = 1.12
# Number of cells of a grid written at once.
_CELLS_AT_ONCE = 50_000


@dataclass(frozen=True)
class DenseCells:
    """Cells from the origin outward."""

    edges: tuple[float, ...]  # distances of the edges of the cells from 0 outward, m

    of_tolerance: ClassVar[float] = 1.0

    @property
    def areas(self) -> Array:
        """Areas of the cells, m², or widths in a line contact, m, shape (n, 1)."""
        raise NotImplementedError

    def influence(self, modulus: float) -> Array:
        """Mean displacement of each cell under a unit pressure on each, m/Pa, shape (n, n)."""
        raise NotImplementedError

    @property
    def shape(self) -> tuple[int, int]:
        """Of fields: one column."""
        return len(self.edges) - 1, 1

    @property
    def x(self) -> Array:
        """Position at which a paraboloid takes its mean over a cell, m, shape (n,)."""
        raise NotImplementedError

    @property
    def y(self) -> Array:
        """The x axis stands for all."""
        return np.zeros(1)

    @property
    def extent(self) -> tuple[float, float]:
        """Half-widths of the written region, m."""
        return self.edges[-1], self.edges[-1]

    @cached_property
    def unit_area(self) -> float:
        """Mean of `areas`."""
        return float(self.areas.mean())

    @cached_property
    def weights(self) -> Array:
        """`areas` over their mean."""
        result: Array = self.areas / self.unit_area
        return result

    def integral(self, field: Array) -> float:
        """Integral of a field over the whole contact."""
        return float((self.areas * field).sum())

    def half_space(
        self,
        modulus: float,
        team: Team = ALONE,  # noqa: ARG002 - some hundreds of cells need one
        parts: dict[Any, Any] | None = None,  # noqa: ARG002 - there are none
    ) -> DenseHalfSpace:
        """The elastic bodies on the cells."""
        return DenseHalfSpace(self, modulus)

    def zone(self, cells: Mask, radius: float) -> Zone:
        """The zone of some cells that reaches as far as a distance, m."""
        edges = np.asarray(self.edges)
        cells = cells & (edges[:-1, None] < radius)
        last = self._last(cells)
        area = self.integral(cells.astype(np.float64))
        if last >= 0:
            within, beyond = edges[last : last + 2]
            part = self._measure(beyond) - self._measure(max(radius, within))
            share = part / (self._measure(beyond) - self._measure(within))
            area -= float(self.areas[last, 0] * share)
        steps = np.flatnonzero(cells[1:, 0] != cells[:-1, 0])
        inner = np.where(cells[steps, 0], steps, steps + 1)
        return Zone(area, inner, 2 * steps + 1 - inner)

    def _measure(self, distance: Any) -> Any:
        """A function of the distance from the origin that is proportional to the area within."""
        return distance

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
        places = self._measure(np.asarray(self.edges))
        within = np.concatenate([[0.0], np.cumsum(field[:, 0] * np.diff(places))])
        others = self._measure(np.asarray(other.edges))
        found = interpolated(places, within, np.minimum(others, places[-1]))
        means: NDArray[Any] = (np.diff(found) / np.diff(others))[:, None]
        return means

    def where(self, smaller: Any) -> Index:
        """Indices of the cells shared with another set, if one extends the other."""
        common = min(len(self.edges), len(smaller.edges))
        alike = self.edges[:common] == smaller.edges[:common]
        return slice(0, common - 1 if alike else 0), slice(0, 1)

    def along(
        self,
        axis: int,  # noqa: ARG002
    ) -> list[tuple[tuple[slice | int, slice | int], Array]]:
        """Index of all cells, and their distances, m."""
        return [((slice(None), 0), self.x)]

    def ahead_of(self, problem: WearProblem, contact: State) -> Self:
        """Cells that reach further if the next step may bring the contact to the border."""
        return self._around(problem, contact.pressure)

    def holding(
        self,
        workspace: Workspace,
        pressure: Array,
        approach: float,  # noqa: ARG002
    ) -> Self:
        """These cells, or more if the contact needs them."""
        return self._around(workspace.problem, pressure)

    def _around(self, problem: WearProblem, pressure: Array) -> Self:
        """Cells that hold a contact, and where it is rough a wavelength more, to the next tip."""
        beyond = problem.wavelengths[0] if problem.wavelengths else 0.0
        return self.reaching(self._radius(pressure) + beyond)

    def _last(self, field: NDArray[Any]) -> int:
        """The outermost cell where a field is not zero; -1 for none."""
        cells = np.flatnonzero(field)
        return int(cells[-1]) if cells.size else -1

    def _radius(self, field: NDArray[Any]) -> float:
        """Largest distance from the origin at which a field is not zero, m."""
        return self.edges[self._last(field) + 1]

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

    def plane(self, spacing: tuple[float, float]) -> Any:
        """The grid on which fields are written."""
        raise NotImplementedError

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

    def _distance(self, x: Array, y: Array) -> Array:
        """Distance of points from the origin, m."""
        raise NotImplementedError

    def _within(self, sides: tuple[Array, Array, Array, Array], radius: Array) -> Array:
        """Fraction of rectangles between two x and two y, m, within a distance, m."""
        raise NotImplementedError


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
    result: Array = values[at] + slopes[at] * beyond
    result += ((rises - slopes[:-1]) / steps - bend)[at] * square
    result += (bend / steps)[at] * (square * beyond)
    return result


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
        result: Array = self.influence @ pressure
        return result

    def relative_displacement(self, pressure: Array) -> tuple[Single, float]:
        """`displacement` in single precision in some unit, m, and the unit."""
        return self.team.scaled(self.displacement(pressure))

    def around(self, cells: Mask) -> DenseHalfSpace:  # noqa: ARG002 - parts would gain nothing
        """The same bodies."""
        return self
