"""Equal rectangular cells: a window around the origin, and its half-space."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Self

import numpy as np
from numpy.typing import NDArray

from fretwear.arrays import Array, Element, Even, Mask, Places, Single
from fretwear.mechanics.contact.cells import (
    OPEN_PER_SIDE,
    Evidence,
    Geometry,
    Index,
    Region,
    Way,
    Zone,
)
from fretwear.mechanics.contact.convolution import Convolution, convolution, offsets
from fretwear.mechanics.contact.film import Film
from fretwear.mechanics.contact.kernels import fast_length, scaled
from fretwear.mechanics.contact.solver import ConvolvedBodies

# A window grows by a factor if any of so many cells at its border bear pressure.
BORDER = 2
_GROWTH = 1.12
# Margin in cells around the zone of a part of the half-space, and number of parts kept.
_MARGIN = 4
_PARTS = 6
# Number of cells outside a zone from whose gaps its edge follows.
_REACH = 3
# A smaller relative fall of the squared pressure from one cell to the next counts as none.
_FLAT, _LEAST = 1e-6, np.finfo(np.float64).tiny
# From so many cells along an axis on, a start is computed on cells twice as wide.
_LEAST_COARSENED = 64
# Number of influence coefficients computed at a time.
_BLOCK = 2**15


@dataclass(frozen=True)
class Grid(Geometry):
    """A rectangle of equal cells around the origin, or its part with positive coordinates."""

    #: Number of cells along x and y: even if the cells lie on both sides; a product of 2, 3 and 5
    #: for a half-space that is not even along both axes.
    shape: tuple[int, int]
    spacing: tuple[float, float]  #: cell size along x and y, m
    #: Whether fields are even along x and along y; if so, only cells on the positive side are kept.
    even: Even = (True, True)

    def __post_init__(self) -> None:
        if any(n % 2 and not even for n, even in zip(self.shape, self.even, strict=True)):
            raise ValueError(f"{self.shape} cells are not symmetric about the origin")

    @property
    def widths(self) -> float:
        """The shorter side of a cell, m."""
        return min(self.spacing)

    @property
    def unit_area(self) -> float:
        """Area of one cell and its images by symmetry, m²."""
        return self.spacing[0] * self.spacing[1] * (1 << sum(self.even))

    @cached_property
    def x(self) -> Array:
        """Cell centres along x, m, shape (nx,)."""
        return self._centers(0)

    @cached_property
    def y(self) -> Array:
        """Cell centres along y, m, shape (ny,)."""
        return self._centers(1)

    def _centers(self, axis: int) -> Array:
        first = 0.5 if self.even[axis] else 0.5 * (1 - self.shape[axis])
        cells = np.arange(self.shape[axis], dtype=np.float64)
        return (cells + first) * self.spacing[axis]

    @property
    def extent(self) -> tuple[float, float]:
        """Distance of the window's border from the origin along x and y, m."""
        x, y = ((n - i) * d for n, i, d in zip(self.shape, self._first, self.spacing, strict=True))
        return x, y

    @property
    def _first(self) -> tuple[int, int]:
        """Index of the first cell on the positive side along x and y."""
        x, y = (0 if is_even else n // 2 for n, is_even in zip(self.shape, self.even, strict=True))
        return x, y

    def integral(self, field: Array) -> float:
        """Integral of a field over the whole contact (field unit times m²)."""
        return float(field.sum()) * self.unit_area

    def zone(self, region: Region) -> Zone:
        """The zone of a region, its area corrected for the open parts of cells at its edge."""
        inner, outer, border = self._sides(region.cells)
        parts = self._open_of(region, inner, outer)
        area = self.unit_area * (float(region.cells.sum()) - float(parts.sum()))
        area -= OPEN_PER_SIDE * border.size * self.unit_area
        return Zone(area, inner, outer)

    def covered(self, region: Region, plane: Geometry) -> Array:
        """Fraction of each cell inside a region.

        A cell at the edge loses the part that `zone` subtracts for each of its sides there; if that
        part is negative, the cell outside gains it.
        """
        inner, outer, border = self._sides(region.cells)
        fractions = region.cells.astype(np.float64).ravel()
        parts = self._open_of(region, inner, outer)
        np.subtract.at(fractions, np.where(parts > 0.0, inner, outer), parts)
        np.subtract.at(fractions, border, OPEN_PER_SIDE)
        return fractions.reshape(region.cells.shape)

    def _open_of(self, region: Region, inner: Places, outer: Places) -> Array:
        """`_open` of a region; a stick zone ends at the edge of its contact at the latest."""
        parts = self._open(inner, outer, region.evidence)
        if (contact := region.contact) is None:
            return parts
        ends = ~contact.cells.ravel()[outer]
        of_contact = self._open(inner, outer, contact.evidence)
        return np.where(ends, np.maximum(parts, of_contact), parts)

    def _open(self, inner: Places, outer: Places, evidence: Evidence | None) -> Array:
        """Part of a cell beyond the edge of a zone, for each of its sides there, shape (sides,).

        The rows of cells along x give the area of a zone, and so do the rows along y; each is
        weighted by the squared component of the edge's normal, along which the squared pressure
        falls linearly. The gap grows with the power 3/2 of the distance from the edge, and in a
        valley from both ends, so that its power 2/3 is a parabola, here through three cells
        outside. Where wear has cut a corner into the surface, the gap grows linearly. The weight of
        this law is the wear of the next cell inside over the rise of the gap from the first to the
        second cell outside.

        Beside a stick zone wear leaves no law of the gap. There the squared pressure falls linearly
        to zero at the edge, here through the last two cells inside. If that edge lies beyond the
        first cell outside, the mean takes its place, with the weight of the wear and plastic flow
        there over the gap: both make the pressure fall more steeply.

        Without a law, or if the gap does not grow, the part is its mean. A cell counts completely
        as soon as part of it belongs to the zone, so counting cells overestimates the area by a
        fraction of a cell for each side (Yastrebov, Anciaux and Molinari 2017, "On the accurate
        computation of the true contact-area in mechanical contact of random rough surfaces",
        Tribol. Int. 114).
        """
        parts = np.full(inner.size, OPEN_PER_SIDE)
        if evidence is None:
            return parts
        ahead, columns = outer - inner, self.shape[1]
        is_along_x, wide = abs(ahead) == columns, columns + 2 * _REACH
        row, column = np.divmod(inner, columns)
        places = (row + _REACH) * wide + column + _REACH
        step = np.where(is_along_x, np.sign(ahead) * wide, ahead)

        def across(field: Array, *shifts: int) -> list[Array]:
            # Values at numbers of cells from the one inside.
            framed = self._framed(field).ravel()
            return [framed[places + shift * step] for shift in shifts]

        if evidence.by_pressure:
            last, previous = (value**2 for value in across(evidence.pressure, 0, -1))
            grows = previous > 0.0
            edge = 1.0 - last[grows] / np.maximum(previous - last, _FLAT * previous)[grows]
            if evidence.worn is not None:
                (gap,) = across(evidence.gap, 1)
                part = np.minimum(sum(across(evidence.worn, 0, 1)) / np.maximum(gap, _LEAST), 1.0)
                edge = np.where(edge < 0.0, part[grows] * (0.5 + OPEN_PER_SIDE), edge)
        else:
            gaps = across(evidence.gap, 1, 2, _REACH)
            roots = [np.cbrt(gap) ** 2 for gap in gaps]
            bend = roots[2] - 2.0 * roots[1] + roots[0]
            fall = roots[1] - roots[0] - 0.5 * bend
            grows = (roots[0] > 0.0) & (roots[1] > 0.0) & (fall > 0.0)
            near, rise = gaps[0][grows], (gaps[1] - gaps[0])[grows]
            root, bend, fall = roots[0][grows], bend[grows], fall[grows]
            edge = 2.0 * root / (fall + np.sqrt(np.maximum(fall**2 - 2.0 * bend * root, 0.0)))
            if evidence.worn is not None:
                (worn,), rise = across(evidence.worn, -1), np.maximum(rise, 1e-3 * near)
                edge += np.minimum(worn[grows] / rise, 1.0) * (near / rise - edge)
        # Distance of the edge from the first cell outside, in cells.
        along_x, along_y = self._slopes(evidence.pressure, inner[grows])
        squares = np.where(is_along_x[grows], along_x, along_y), along_x + along_y
        share = np.divide(*squares, out=np.full(edge.size, 0.5), where=squares[1] > 0.0)
        parts[grows] = share * (np.clip(edge, 0.0, 1.0) - 0.5)
        return parts

    def _framed(self, field: Array) -> Array:
        """A field with `_REACH` more cells on each side: images where it is even, else zeros."""
        framed = np.zeros([count + 2 * _REACH for count in field.shape])
        framed[_REACH:-_REACH, _REACH:-_REACH] = field
        mirrored = slice(2 * _REACH - 1, _REACH - 1, -1)
        if self.even[0]:
            framed[:_REACH] = framed[mirrored]
        if self.even[1]:
            framed[:, :_REACH] = framed[:, mirrored]
        return framed

    def _slopes(self, pressure: Array, cells: Places) -> tuple[Array, Array]:
        """Squared gradient components of the squared pressure, along x and y, at some cells."""
        scale = max(float(pressure.max()), 1.0)
        x, y = np.divmod(cells, self.shape[1])
        (last_x, last_y), slopes = (count - 1 for count in self.shape), []
        here = (pressure[x, y] / scale) ** 2
        for i, j in ((1, 0), (0, 1)):
            backward = (pressure[np.maximum(x - i, 0), np.maximum(y - j, 0)] / scale) ** 2
            forward = (pressure[np.minimum(x + i, last_x), np.minimum(y + j, last_y)] / scale) ** 2
            # In a row of one cell the pressure falls to both sides.
            slopes.append(np.where(backward + forward > 0.0, 0.5 * (forward - backward), here) ** 2)
        return slopes[0], slopes[1]

    def _sides(self, cells: Mask) -> tuple[Places, ...]:
        """Sides at the edge of a zone: cells inside, those outside, and cells at the border.

        They index the flattened field. Axes in which the zone is even have no edge.
        """
        columns = cells.shape[1]
        along_x = np.flatnonzero(cells[1:] != cells[:-1])
        row, column = np.divmod(np.flatnonzero(cells[:, 1:] != cells[:, :-1]), max(columns - 1, 1))
        along_y = row * columns + column
        first = np.concatenate([along_x, along_y])
        second = np.concatenate([along_x + columns, along_y + 1])
        inner = np.where(cells.ravel()[first], first, second)
        border, steps = [], (columns, 1)
        for axis, (count, is_even) in enumerate(zip(cells.shape, self.even, strict=True)):
            for end in (count - 1,) if is_even else (count - 1, 0):
                crossed = np.flatnonzero(cells.take(end, axis))
                border.append(end * steps[axis] + crossed * steps[1 - axis])
        return inner, first + second - inner, np.concatenate(border)

    def half_space(self, modulus: float, film: Film | None = None) -> GridHalfSpace:
        """The elastic bodies on the cells."""
        return GridHalfSpace(self, modulus, film=film)

    def resized(self, field: NDArray[Element], target: Geometry) -> NDArray[Element]:
        """A field of this window on another one around the same origin.

        The result is zero on cells that this window lacks; cells that the other lacks are dropped.
        """
        result = np.zeros(target.shape, dtype=field.dtype)
        result[target.where(self)] = field[self.where(target)]
        return result

    def where(self, target: Geometry) -> Index:
        """Indices of the cells of this window shared with another."""
        slices = []
        for size, count, is_even in zip(self.shape, target.shape, self.even, strict=True):
            kept = min(size, count)
            first = 0 if is_even else (size - kept) // 2
            slices.append(slice(first, first + kept))
        return slices[0], slices[1]

    def axis_cells(self, axis: int) -> list[tuple[Way, Array]]:
        """Cells on or nearest to an axis: index, and distances from the origin, m.

        If fields are even there is one row. Otherwise there are two for either side of the origin,
        one on each side of the axis.
        """
        first, across = self._first, 1 - axis
        distances = (self.x, self.y)[axis][first[axis] :]
        ways = [slice(first[axis], None)]
        if not self.even[axis]:
            ways.append(slice(first[axis] - 1, None, -1))
        rows = [first[across]]
        if not self.even[across] and self.shape[across] > 1:
            rows.append(first[across] - 1)
        return [
            ((way, row) if axis == 0 else (row, way), distances) for row in rows for way in ways
        ]

    def cropped(self, cells: Mask) -> Grid:
        """The smallest window, fast to transform, that holds some cells and a margin."""
        extents = []
        for axis, (count, first) in enumerate(zip(self.shape, self._first, strict=True)):
            occupied = [*np.flatnonzero(cells.any(axis=1 - axis))] or [0]
            half = max(occupied[-1] + 1 - first, first - occupied[0])
            extents.append(float(min(half + _MARGIN, count - first) * self.spacing[axis]))
        shape = fast_shape((extents[0], extents[1]), self.spacing, self.even)
        return self.of_shape((min(shape[0], self.shape[0]), min(shape[1], self.shape[1])))

    @property
    def coarser(self) -> Grid | None:
        """The window in cells twice as wide, if it has many."""
        (nx, ny), (dx, dy) = self.shape, self.spacing
        if min(nx, ny) < _LEAST_COARSENED or nx % 4 or ny % 4:
            return None
        return replace(self, shape=(nx // 2, ny // 2), spacing=(2.0 * dx, 2.0 * dy))

    def of_shape(self, shape: tuple[int, int]) -> Self:
        """A window of another shape with the same cells."""
        return self if shape == self.shape else replace(self, shape=shape)

    def covering(self, extent: tuple[float, float]) -> Grid:
        """The smallest window, fast to transform, that holds this one and an extent."""
        shape = fast_shape(extent, self.spacing, self.even)
        return self.of_shape((max(shape[0], self.shape[0]), max(shape[1], self.shape[1])))

    def grown(self, sides: tuple[bool, bool]) -> Grid:
        """The next larger window along x, along y or both; this one if neither is asked for."""
        x, y = (
            half * (_GROWTH if side else 1.0) for half, side in zip(self.extent, sides, strict=True)
        )
        return self.covering((x, y)) if any(sides) else self

    def touched(
        self, pressure: Array, border: tuple[int, int] = (BORDER, BORDER)
    ) -> tuple[bool, bool]:
        """Whether there is pressure in the outermost cells along x and along y."""
        x, y = (
            bool(field[-count:].any() or (not is_even and field[:count].any()))
            for field, count, is_even in zip((pressure, pressure.T), border, self.even, strict=True)
        )
        return x, y


def fast_shape(
    extent: tuple[float, float], spacing: tuple[float, float], even: Even = (True, True)
) -> tuple[int, int]:
    """Smallest shape that is fast to transform and covers a half-extent (m) along x and y."""
    shape = []
    for half, cell, is_even in zip(extent, spacing, even, strict=True):
        count = fast_length(max(4, math.ceil(half / cell - 1e-9)))
        shape.append(count if is_even else 2 * count)
    return shape[0], shape[1]


def influence_coefficients(
    shape: tuple[int, int],
    spacing: tuple[float, float],
    composite_modulus: float,
    weights: tuple[float, float] = (1.0, 1.0),
    film: Film | None = None,
) -> Array:
    """Normal displacement of cell (i, j) per unit pressure on cell (0, 0), m/Pa, shape (nx, ny).

    ``weights`` multiply the parts y²/r³ and x²/r³ of 1/r. With 1 and 2κ − 1, up to a factor, the
    result is the displacement along x by a traction along x (Cerruti).

    Love, "The stress produced in a semi-infinite solid by pressure on part of the boundary", Phil.
    Trans. R. Soc. A 228 (1929), for a rectangle. Neighbouring cells share corners, so the
    logarithms are taken once per corner.
    """
    dx, dy = spacing
    corners = (np.arange(shape[0] + 1) - 0.5) * dx
    y = (np.arange(shape[1] + 1) - 0.5) * dy
    coefficients = np.empty(shape)

    rows = max(1, _BLOCK // shape[1])
    for first in range(0, shape[0], rows):
        x = corners[first : first + rows + 1, None]
        corner = weights[0] * x * np.arcsinh(y / np.abs(x))
        corner += weights[1] * y * np.arcsinh(x / np.abs(y))
        block = np.diff(np.diff(corner, axis=0), axis=1)
        np.divide(block, np.pi * composite_modulus, out=coefficients[first : first + rows])
    if film is not None:
        coefficients += film.on_cells(shape, spacing)
    return coefficients


class GridHalfSpace(ConvolvedBodies):
    """The elastic half-space under a pressure that is uniform on each cell of a window.

    Its displacement is a discrete convolution with the influence coefficients of Love. The
    composite modulus E* is in Pa; ``weights`` and ``film`` come from `influence_coefficients`.
    """

    def __init__(
        self,
        geometry: Grid,
        composite_modulus: float,
        weights: tuple[float, float] = (1.0, 1.0),
        film: Film | None = None,
    ) -> None:
        self.geometry: Grid = geometry
        self.modulus, self._weights, self.film = composite_modulus, weights, film
        shape = offsets(geometry.shape, geometry.even)
        kernel = influence_coefficients(shape, geometry.spacing, composite_modulus, weights, film)
        self.self_influence = float(kernel[0, 0])
        self._convolution = convolution(kernel, geometry.even)

    def displacement(self, pressure: Array) -> Array:
        """Normal surface displacement w, m, of a pressure, Pa; both of the window's shape."""
        return self._convolution(pressure)

    @cached_property
    def single(self) -> Convolution[Single]:
        """`displacement` in units of `self_influence`, and its inverse, in single precision.

        Accurate to a few parts in 10⁷: enough for a step, not for the final solution.
        """
        return self._convolution.in_single(self.self_influence)

    def relative_displacement(self, pressure: Array) -> tuple[Single, float]:
        """`displacement` in single precision in some unit, m, and the unit."""
        field, unit = scaled(pressure)
        return self.single(field), unit * self.self_influence

    def cropped(self, cells: Mask) -> GridHalfSpace:
        """The same bodies on the smallest window that holds some cells and a margin."""
        return self._on(self.geometry.cropped(cells), self._weights, self.film)

    @cached_property
    def coarser(self) -> GridHalfSpace | None:
        """The same bodies on cells twice as wide, if these are many."""
        grid = self.geometry.coarser
        weights, film = self._weights, self.film
        return None if grid is None else GridHalfSpace(grid, self.modulus, weights, film)

    def along_x(self, coupling: float, mean: float) -> GridHalfSpace:
        """The bodies under tractions along x; displacements are divided by ``mean``."""
        weights = 1.0 / mean, (2.0 * coupling - 1.0) / mean
        film = self.film and replace(self.film, way="along", per=mean)
        return self._on(self.geometry, weights, film)

    def alike(self, mean: float) -> GridHalfSpace:
        """The bodies under tractions, averaged over all directions; displacements over ``mean``."""
        film = self.film and replace(self.film, way="alike", per=mean)
        return self._on(self.geometry, self._weights, film)

    def _on(self, grid: Grid, weights: tuple[float, float], film: Film | None) -> GridHalfSpace:
        """The bodies on a window of the same cells; the same object if nothing differs."""
        if (grid.shape, weights, film) == (self.geometry.shape, self._weights, self.film):
            return self
        return _part(grid, self.modulus, weights, film)


@lru_cache(_PARTS)
def _part(
    grid: Grid, modulus: float, weights: tuple[float, float], film: Film | None
) -> GridHalfSpace:
    """Bodies on a window, cached because zones often keep their size."""
    return GridHalfSpace(grid, modulus, weights, film)
