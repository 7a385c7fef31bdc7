"""Some hundreds of graded cells from the origin outward, with dense matrices.

The pressure is uniform on each cell, and displacements are averaged over a cell, which makes the
influence matrix symmetric. The linear problem of the free cells is solved directly. The cells are
concentric rings (`fretwear.mechanics.contact.rings`) or the strips of a line contact
(`fretwear.mechanics.contact.strips`).
"""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, ClassVar, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from fretwear.arrays import Array, Element, Mask, Places, Single
from fretwear.mechanics.contact.cells import (
    OPEN_PER_SIDE,
    Geometry,
    HalfSpace,
    Index,
    Region,
    Way,
    Zone,
)
from fretwear.mechanics.contact.film import Film
from fretwear.mechanics.contact.gradients import Exchange, projected_gradients
from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.kernels import scaled
from fretwear.mechanics.contact.problem import Contact, ContactProblem, solve_on

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

# Fraction of the cells that must hold the contact, and the growth factor of the cells.
_ROOM, _GROWTH = 0.88, 1.12
# Cells are extended by others that are at least so many times wider.
_WIDER = 1.5
# Largest number of solutions, and factor on the tolerance of a contact: the plastic flow of a step
# may be shallower than the tolerance, and a factorization is more accurate.
_SOLUTIONS, _OF_TOLERANCE = 100, 1e-3
# Least tolerance of projected gradients, which rounding allows.
_LEAST_TOLERANCE = 1e-12
# Solutions without a new minimum of wrong cells, after which cells change sides one by one.
_PATIENCE = 8

Distance = TypeVar("Distance", float, Array)


@dataclass(frozen=True)
class DenseCells(Geometry):
    """Cells from the origin outward."""

    edges: tuple[float, ...]  # distances of the edges of the cells from 0 outward, m

    # Area within a distance from the origin, over `_measure` of the distance.
    _whole: ClassVar[float]

    @abstractmethod
    def _measure(self, distance: Distance) -> Distance:
        """A function proportional to the area within a distance from the origin."""

    @staticmethod
    @abstractmethod
    def distance(x: Array, y: Array) -> Array:
        """Distance of points from the origin, m."""

    @staticmethod
    @abstractmethod
    def shares(x: Array, y: Array, radii: Array, cuts: tuple[Places, Places, Places]) -> Array:
        """Fraction of each cell that lies within each distance that cuts it.

        The cells lie between edges ``x`` and ``y``, m; ``cuts`` index the cells along x, along y,
        and the distances.
        """

    @abstractmethod
    def influence(self, modulus: float, film: Film | None = None) -> Array:
        """Mean displacement of each cell under a unit pressure on each, m/Pa, shape (n, n)."""

    @property
    def y(self) -> Array:
        """Zero: the cells lie on the x axis."""
        return np.zeros(1)

    @property
    def shape(self) -> tuple[int, int]:
        """Number of cells, in one column."""
        return len(self.edges) - 1, 1

    @cached_property
    def areas(self) -> Array:
        """Areas of the cells, m², or widths in a line contact, m, shape of a field."""
        measures = self._measure(np.asarray(self.edges))
        return np.asarray(self._whole * np.diff(measures)[:, None])

    @property
    def widths(self) -> Array:
        """Widths of the cells, m, shape (n, 1)."""
        return np.asarray(np.diff(self.edges)[:, None])

    @cached_property
    def unit_area(self) -> float:
        """Mean of `areas`."""
        return float(self.areas.mean())

    @cached_property
    def weights(self) -> Array:
        """`areas` over their mean."""
        return np.asarray(self.areas / self.unit_area)

    def integral(self, field: Array) -> float:
        """Integral of a field over the whole contact."""
        return float((self.areas * field).sum())

    def half_space(self, modulus: float, film: Film | None = None) -> DenseHalfSpace:
        """The elastic bodies on the cells."""
        return DenseHalfSpace(self, self.influence(modulus, film), modulus, film)

    def zone(self, region: Region) -> Zone:
        """The zone of a region, which ends at its distance.

        Other edges, as between ridges, lie anywhere in a cell; areas are corrected as on a grid.
        """
        edges, radius = np.asarray(self.edges), region.radius
        cells = region.cells & (edges[:-1, None] < radius)
        inner, outer = self._sides(cells[:, 0])
        area = self.integral(self._counted(cells[:, 0])[:, None])
        if cells.any():
            last = np.flatnonzero(cells)[-1]
            nearer, farther = edges[last : last + 2]
            part = self._measure(farther) - self._measure(max(radius, nearer))
            share = part / (self._measure(farther) - self._measure(nearer))
            area -= float(self.areas[last, 0] * share)
        return Zone(area, inner, outer)

    def covered(self, region: Region, plane: Geometry) -> Array:
        """Fraction of each cell of a grid inside a region, which ends at its radius."""
        edges, radius = np.asarray(self.edges), region.radius
        cells = region.cells[:, 0] & (edges[:-1] < radius)
        last = int(np.flatnonzero(cells).max(initial=-1))
        if last < 0:
            return np.zeros(plane.shape)
        cut = np.unique(np.append(edges, radius))
        place = np.searchsorted(edges, cut[:-1], "right") - 1
        counted = self._counted(cells)[np.minimum(place, cells.size - 1)]
        share = np.where(place > last, 1.0, counted) * (cut[:-1] < radius)
        parts = {"": share[:, None]}
        return replace(self, edges=tuple(cut.tolist())).written(parts, plane)[""]

    def _sides(self, cells: Mask) -> tuple[Places, Places]:
        """Cells inside and outside each edge of a zone, outward; all with one axis."""
        steps = np.flatnonzero(cells[1:] != cells[:-1])
        inner = np.where(cells[steps], steps, steps + 1)
        return inner, 2 * steps + 1 - inner

    def _counted(self, cells: Mask) -> Array:
        """Fraction of each cell inside a zone, whose edge lies within its outermost cell."""
        counted = cells.astype(np.float64)
        np.subtract.at(counted, self._sides(cells)[0][:-1], OPEN_PER_SIDE)
        return counted

    def resized(self, field: NDArray[Element], target: Geometry) -> NDArray[Element]:
        """A field on other cells, with the same integral and zero beyond the outermost of these.

        Inner cells that both sets share keep their values. Between other edges, the integral from
        the origin is interpolated monotonically: positive fields remain positive.
        """
        count = self.where(target)[0].stop
        if count:
            result = np.zeros(target.shape, dtype=field.dtype)
            result[:count] = field[:count]
            return result
        both = self.edges, _edges(target)
        places, others = (self._measure(np.asarray(edges)) for edges in both)
        nearer = np.minimum(others, places[-1])
        content = field[:, 0].astype(float) * np.diff(places)
        integrals = interpolated(places, np.append(0.0, np.cumsum(content)), nearer)
        means = np.diff(integrals) / np.diff(others)
        return means[:, None].astype(field.dtype)

    def where(self, target: Geometry) -> Index:
        """Indices of the cells shared with another set, if one extends the other."""
        edges = _edges(target)
        common = min(len(self.edges), len(edges))
        alike = self.edges[:common] == edges[:common]
        return slice(0, common - 1 if alike else 0), slice(0, 1)

    def axis_cells(self, axis: int) -> list[tuple[Way, Array]]:
        """Index of all cells, and their distances, m."""
        return [((slice(None), 0), self.x)]

    def radius_of(self, field: Array) -> float:
        """Largest distance from the origin at which a field is not zero, m."""
        return self.edges[int(np.flatnonzero(field).max(initial=-1)) + 1]

    def reaching(self, radius: float) -> Self:
        """These cells, or cells that reach further if a contact of a radius, m, needs them."""
        return self if radius <= _ROOM * self.extent[0] else self._out_to(_GROWTH * self.edges[-1])

    def extended(self, target: Geometry) -> Self:
        """These cells, extended to the size of others."""
        *_, inner, outer = _edges(target)
        last, width = self.edges[-1], self.edges[-1] - self.edges[-2]
        if outer <= last:
            return self
        if outer - inner <= _WIDER * width:
            return self._out_to(outer)
        # The other cells belong to a contact that has grown; these would become far too many.
        added = (edge for edge in _edges(target) if edge > last + 0.5 * width)
        return replace(self, edges=(*self.edges, *added))

    def _out_to(self, radius: float) -> Self:
        last, width = self.edges[-1], self.edges[-1] - self.edges[-2]
        count = math.ceil((radius - last) / width * (1.0 - 1e-9))
        added = (last + (step + 1) * width for step in range(count))
        return replace(self, edges=(*self.edges, *added))

    def plane(self, spacing: tuple[float, float]) -> Grid:
        """The output grid: a quarter of the square that the cells cover, or a row."""
        x, y = (
            max(1, math.floor(half / size)) for half, size in zip(self.extent, spacing, strict=True)
        )
        return Grid((x, y), spacing)

    def written(
        self, fields: dict[str, NDArray[Element]], plane: Geometry
    ) -> dict[str, NDArray[Element]]:
        """Means of fields over the cells of a grid; for states, the one that covers most of a cell.

        Within a cell a field is linear with the smaller of its slopes to either side. So integrals
        are kept, and each mean lies between the values around it.
        """
        assert isinstance(plane, Grid)
        steps = np.ceil(np.diff(self.edges) / (0.5 * min(plane.spacing))).astype(int)
        cell = np.repeat(np.arange(steps.size), steps)
        part = np.arange(cell.size) - np.repeat(np.cumsum(steps) - steps, steps)
        edges: Array = np.asarray(self.edges)
        parts = edges[cell] + np.diff(edges)[cell] * part / steps[cell]
        measures = self._measure(np.append(parts, edges[-1]))
        middle = 0.5 * (self._measure(edges[1:]) + self._measure(edges[:-1]))
        offset = 0.5 * (measures[1:] + measures[:-1]) - middle[cell]
        columns: list[Array] = []
        kinds = {n: np.unique(f) for n, f in fields.items() if f.dtype.kind != "f"}
        for name, field in fields.items():
            if name in kinds:
                columns += [(field[cell, 0] == kind).astype(np.float64) for kind in kinds[name]]
                continue
            slopes = np.diff(field[:, 0]) / np.diff(middle)
            backward, slopes = np.append(0.0, slopes), np.append(slopes, slopes[-1])
            least = np.where(np.abs(slopes) < np.abs(backward), slopes, backward)
            falls = np.where(slopes * backward > 0.0, least, 0.0)
            columns.append(field[cell, 0] + offset * falls[cell])
        means = iter(self._means(parts, np.stack(columns, axis=1), plane))
        return {
            name: kinds[name][np.argmax([next(means) for _ in kinds[name]], axis=0)]
            if name in kinds
            else next(means)
            for name in fields
        }

    def _means(self, parts: Array, values: Array, plane: Grid) -> Array:
        """Means over the cells of a grid, shape (fields, nx, ny), of values within parts.

        ``parts`` are the inner edges of the parts, m, and ``values`` have shape (parts, fields).
        """
        jumps = np.diff(values, axis=0)
        # If fields are uniform in most parts, few edges suffice.
        steps = np.flatnonzero(jumps.any(axis=1))
        if 2 * steps.size > len(jumps):
            steps = np.arange(len(jumps))
        share, cut_parts = _beyond(type(self), tuple(parts[steps + 1].tolist()), plane)
        means = values[np.append(0, steps + 1)].T[:, share]
        return np.asarray(means + (cut_parts @ jumps[steps]).T).reshape(-1, *plane.shape)


@lru_cache(maxsize=4)
def _beyond(
    kind: type[DenseCells], radii: tuple[float, ...], plane: Grid
) -> tuple[Places, csr_matrix]:
    """How distances from the origin, m, cut the cells of a grid.

    For each cell, the result has the number of distances that do not pass its nearest corner, and a
    sparse matrix (cells, distances) with the fraction of its area beyond each of the others.
    """
    x, y = (np.arange(n + 1.0) * d for n, d in zip(plane.shape, plane.spacing, strict=True))
    distance = kind.distance(x[:, None], y[None, :])
    first = np.searchsorted(radii, distance[:-1, :-1].ravel(), "right")
    count = np.searchsorted(radii, distance[1:, 1:].ravel()) - first
    np.maximum(count, 0, out=count)
    starts = np.append(0, np.cumsum(count))
    cut = np.arange(starts[-1]) - np.repeat(starts[:-1] - first, count)
    row, column = np.divmod(np.repeat(np.arange(count.size), count), plane.shape[1])

    from scipy.sparse import csr_matrix  # takes half a second

    nearer = kind.shares(x, y, np.asarray(radii), (row, column, cut))
    return first, csr_matrix((1.0 - nearer, cut, starts), (count.size, len(radii)))


def _edges(cells: Geometry) -> tuple[float, ...]:
    assert isinstance(cells, DenseCells)
    return cells.edges


def interpolated(places: Array, values: Array, others: Array) -> Array:
    """Values at other positions, by monotone cubics."""
    from scipy.interpolate import PchipInterpolator

    return np.asarray(PchipInterpolator(places, values)(others))


class DenseHalfSpace(HalfSpace):
    """The elastic half-space under a pressure that is uniform on each cell."""

    gives_stiffness: ClassVar[bool] = True

    def __init__(
        self, geometry: Geometry, influence: Array, modulus: float, film: Film | None
    ) -> None:
        self.geometry, self.influence = geometry, influence
        self._modulus, self._film = modulus, film
        # The largest displacement of a cell per pressure on itself, m/Pa.
        self.self_influence = float(self.influence.diagonal().max())
        # Influence over `self_influence`, times the weights of the cells; symmetric.
        weights = 1.0 if geometry.weights is None else geometry.weights
        matrix = weights * self.influence / self.self_influence
        self.matrix = 0.5 * (matrix + matrix.T)

    def displacement(self, pressure: Array) -> Array:
        """Normal surface displacement w, m, of a pressure, Pa, in the mean over each cell."""
        return np.asarray(self.influence @ pressure)

    def relative_displacement(self, pressure: Array) -> tuple[Single, float]:
        """`displacement` in single precision in some unit, m, and the unit."""
        return scaled(self.displacement(pressure))

    def alike(self, mean: float) -> HalfSpace:
        """The bodies under tractions, averaged over all directions; displacements over ``mean``."""
        if self._film is None:
            return self
        film = replace(self._film, way="alike", per=mean)
        return _under_tractions(self.geometry, self._modulus, film)

    @staticmethod
    def _next_free(problem: ContactProblem, pressure: Array, separation: Array) -> int | None:
        """The cell that leaves its bound if none is free; None if there is no such cell.

        The cell next to closing takes up a missing load, the cell next to opening an excess.
        """
        carried = float(problem.weighted(pressure).sum())
        lacks = problem.load is not None and problem.total > carried
        bound = pressure <= 0.0 if lacks else pressure > 0.0
        order = np.where(bound, separation if lacks else -separation, np.inf)
        return int(np.argmin(order)) if bound.any() else None

    def responses(
        self, problem: ContactProblem, pressure: Array, gap: Array, free: Mask
    ) -> tuple[Array, Array]:
        """Pressures on free cells that close a gap, m, and those that cause a unit approach.

        Solving for the residual of a pressure lets the next solution correct the rounding of this
        one.
        """
        layer, unit = problem.layer, self.self_influence
        tangent, sinks = None, np.ones_like(pressure)
        if layer is not None:
            tangent = layer.scaled_tangent(unit, pressure)
            sinks -= layer.per_approach(pressure)
        moved, uniform = self._solved(np.stack([gap / -unit, sinks]), tangent, free)
        return moved, uniform

    def _solved(self, displacements: Array, tangent: Single | None, free: Mask) -> Array:
        """Pressures on free cells that cause displacements in units of the self-influence.

        ``tangent`` is the compliance of a layer in that unit. Fields have the shape of the
        geometry; displacements and pressures have one axis before. Pressures are zero elsewhere.
        """
        cells, result = np.flatnonzero(free), np.zeros_like(displacements)
        weights = np.ones_like(free, np.float64)
        if self.geometry.weights is not None:
            weights *= self.geometry.weights
        block = self.matrix[np.ix_(cells, cells)]
        if tangent is not None:
            block[np.diag_indices(cells.size)] += weights[free] * tangent[free]
        pressures = np.linalg.solve(block, (weights * displacements)[:, free].T)
        result[:, free] = pressures.T
        return result

    def factored(self, problem: ContactProblem, start: Array, tolerance: float) -> Contact | None:
        """The solution by active sets from a start, Pa; None if a set occurs again.

        Semismooth Newton: Hintermüller, Ito and Kunisch, "The primal-dual active set strategy as a
        semismooth Newton method", SIAM J. Optim. 13 (2002). Cells leave a bound by the sign of
        their gap, and the free ones by their pressure; see `Exchange`.
        """
        tolerance *= _OF_TOLERANCE
        limit, layer = problem.limit, problem.layer
        unit = self.self_influence
        pressure = problem.clip_to_load(start)
        free: Mask = (pressure > 0.0) & (pressure < limit)
        displacement = self.displacement(pressure)
        approach = problem.approach or 0.0
        if layer is not None and layer.level is not None and problem.approach is None:
            approach = layer.level
        exchange = Exchange(_PATIENCE)
        for step in range(1, _SOLUTIONS + 1):
            separation = problem.separation(pressure, displacement)
            if not free.any():
                cell = self._next_free(problem, pressure, separation)
                if cell is None:
                    return None
                free.ravel()[cell] = True
            moved, uniform = self.responses(problem, pressure, separation - approach, free)
            sinks = 0.0
            if problem.load is not None:
                missing = problem.total - float(problem.weighted(pressure + moved).sum())
                sinks = missing / float(problem.weighted(uniform).sum())
                approach += sinks * unit
            if layer is not None:
                layer = layer.at(approach)
                problem = replace(problem, layer=layer)
            unbounded = pressure + moved + sinks * uniform
            displacement = self.displacement(unbounded)
            gap = problem.shape + displacement - approach
            if layer is not None:
                gap += layer.displacement(np.clip(unbounded, 0.0, limit))
            scale = float(np.abs(displacement).max())
            worst = float(np.abs(gap[free]).max())
            margin = 0.3 * tolerance * scale
            low, high = unbounded <= 0.0, unbounded >= limit
            stays = free & ~low & ~high
            now = stays | (~free & low & (gap < -margin)) | (~free & high & (gap > margin))
            pressure = np.clip(unbounded, 0.0, limit)
            if (now == free).all() and worst <= tolerance * scale:
                excess = -float(gap[low].min(initial=0.0)), float(gap[high].max(initial=0.0))
                residual = max(worst, *excess) / scale
                gap[free] = 0.0
                return Contact(
                    pressure,
                    gap,
                    approach,
                    high,
                    residual,
                    convolutions=step,
                    stiffness=uniform / unit,
                )
            if not (stays == free).all():
                displacement = self.displacement(pressure)
            changed = exchange.of(np.flatnonzero(now != free))
            free.ravel()[changed] = now.ravel()[changed]
        return None


@solve_on.register
def solve_by_factors(
    bodies: DenseHalfSpace,
    problem: ContactProblem,
    start: Array | None,
    tolerance: float,
    *,
    verified: bool,
) -> Contact:
    """Solve a normal contact by factors of the matrix of its free cells."""
    start = problem.first_guess() if start is None else start
    contact = bodies.factored(problem, start, tolerance)
    if contact is None:
        accurate = max(_OF_TOLERANCE * tolerance, _LEAST_TOLERANCE)
        contact = projected_gradients(problem, start, accurate)
        if problem.layer is not None:
            problem = replace(problem, layer=problem.layer.at(contact.approach))
        free = (contact.pressure > 0.0) & ~contact.saturated
        _, uniform = bodies.responses(problem, contact.pressure, contact.gap, free)
        contact = replace(
            contact,
            gap=np.where(free, 0.0, contact.gap),
            stiffness=uniform / bodies.self_influence,
            convolutions=contact.convolutions + _SOLUTIONS,
        )
    return contact


@lru_cache(2)
def _under_tractions(geometry: Geometry, modulus: float, film: Film) -> HalfSpace:
    """Bodies under tractions, cached because they are needed again on the same cells."""
    return geometry.half_space(modulus, film)
