"""The window of cells on which a contact is computed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.fft

from fretwear.mechanics.arrays import Array, Mask


@dataclass(frozen=True)
class Window:
    """A rectangle of equal cells around the origin, whole or only its quarter x > 0, y > 0.

    Parameters
    ----------
    shape
        Number of cells along x and y (of the quarter, if ``quarter``).
    spacing
        Cell size along x and y, m.
    quarter
        Whether the cells are those of the quarter x > 0, y > 0 of an even problem.
    """

    shape: tuple[int, int]
    spacing: tuple[float, float]
    quarter: bool = True

    @property
    def copies(self) -> int:
        """How many times each cell occurs in the whole contact."""
        return 4 if self.quarter else 1

    @property
    def cell_area(self) -> float:
        """Area of one cell, m²."""
        return self.spacing[0] * self.spacing[1]

    @cached_property
    def x(self) -> Array:
        """Cell centers along x, m, shape (nx,)."""
        return self._centers(0)

    @cached_property
    def y(self) -> Array:
        """Cell centers along y, m, shape (ny,)."""
        return self._centers(1)

    @property
    def extent(self) -> tuple[float, float]:
        """Distance of the window's border from the origin along x and y, m."""
        half = 1.0 if self.quarter else 0.5
        return (half * self.shape[0] * self.spacing[0], half * self.shape[1] * self.spacing[1])

    def integral(self, field: Array) -> float:
        """Integral of a field over the whole contact (field unit times m²)."""
        return float(field.sum()) * self.cell_area * self.copies

    def resized(self, field: Array, shape: tuple[int, int]) -> Array:
        """A field of this window on a window of another shape around the same origin.

        Cells that this window lacks get zero; cells that the other lacks are dropped.
        """
        target, source = self._common(shape)
        result = np.zeros(shape, dtype=field.dtype)
        result[target] = field[source]
        return result

    def covered(self, shape: tuple[int, int]) -> Mask:
        """Which cells of a window of another shape belong to this one too."""
        result = np.zeros(shape, dtype=np.bool_)
        result[self._common(shape)[0]] = True
        return result

    def part(self, shape: tuple[int, int]) -> tuple[slice, slice]:
        """Where in this window the cells of one of a smaller shape lie."""
        return self._common(shape)[1]

    def _centers(self, axis: int) -> Array:
        first = 0.5 if self.quarter else 0.5 * (1 - self.shape[axis])
        cells = np.arange(self.shape[axis], dtype=np.float64)
        return (cells + first) * self.spacing[axis]

    def holding(self, cells: Mask, margin: int) -> tuple[int, int]:
        """Shape, fast to transform, of the smallest window that holds some cells and a margin."""
        extents = []
        for axis, count in enumerate(self.shape):
            occupied = np.flatnonzero(cells.any(axis=1 - axis))
            reach = count if self.quarter else (count + 1) // 2
            last = 0 if occupied.size == 0 else int(occupied[-1])
            first = 0 if occupied.size == 0 else int(occupied[0])
            half = last + 1 if self.quarter else max(last + 1 - reach, count - reach - first)
            extents.append(min(half + margin, reach) * self.spacing[axis])
        shape = fast_shape((extents[0], extents[1]), self.spacing, quarter=self.quarter)
        return min(shape[0], self.shape[0]), min(shape[1], self.shape[1])

    def _common(self, shape: tuple[int, int]) -> tuple[tuple[slice, slice], tuple[slice, slice]]:
        """Slices of the cells common to a window of another shape and to this one, in each."""
        other, own = [], []
        for new, old in zip(shape, self.shape, strict=True):
            kept = min(new, old)
            first = (0, 0) if self.quarter else ((new - kept) // 2, (old - kept) // 2)
            other.append(slice(first[0], first[0] + kept))
            own.append(slice(first[1], first[1] + kept))
        return (other[0], other[1]), (own[0], own[1])


def fast_shape(
    extent: tuple[float, float], spacing: tuple[float, float], *, quarter: bool = True
) -> tuple[int, int]:
    """Smallest shape that is fast to transform and covers a half-extent (m) along x and y."""
    cells = [max(4, int(np.ceil(e / s - 1e-9))) for e, s in zip(extent, spacing, strict=True)]
    nx, ny = (scipy.fft.next_fast_len(n, real=True) for n in cells)
    return (nx, ny) if quarter else (2 * nx, 2 * ny)
