"""The elastic half-space: surface displacement under a pressure given on a window of cells.

The pressure is piecewise constant on rectangular cells. Its displacement is a discrete
convolution with the influence coefficients of Love (1929); zero padding makes the convolution
exact (free space, no periodic images). Where pressure is even in x and y, only the quarter
x > 0, y > 0 is kept: the even extension turns the Fourier transform into cosine transforms,
DCT-II of the data and DCT-I of the kernel, with the same result to rounding.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
import scipy.fft
from numpy.typing import NDArray

Array = NDArray[np.float64]


def inner(a: Array, b: Array) -> float:
    """Sum of the products of two fields.

    Not by BLAS: its threads gain nothing here, stand in the way of cases that run side by side,
    and make the last bits depend on their number.
    """
    return float(np.einsum("ij,ij->", a, b))


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

    def covered(self, shape: tuple[int, int]) -> NDArray[np.bool_]:
        """Which cells of a window of another shape belong to this one too."""
        result = np.zeros(shape, dtype=np.bool_)
        result[self._common(shape)[0]] = True
        return result

    def _centers(self, axis: int) -> Array:
        first = 0.5 if self.quarter else 0.5 * (1 - self.shape[axis])
        cells = np.arange(self.shape[axis], dtype=np.float64)
        return (cells + first) * self.spacing[axis]

    def holding(self, cells: NDArray[np.bool_], margin: int) -> tuple[int, int]:
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


def influence_coefficients(
    shape: tuple[int, int], spacing: tuple[float, float], composite_modulus: float
) -> Array:
    """Normal displacement of cell (i, j) per unit pressure on cell (0, 0).

    Love, "The stress produced in a semi-infinite solid by pressure on part of the boundary",
    Phil. Trans. R. Soc. A 228 (1929), for a rectangle; the four corner terms of neighboring
    cells coincide, so the logarithms are taken once per corner.

    Parameters
    ----------
    shape
        Number of offsets i = 0 … nx-1 and j = 0 … ny-1.
    spacing
        Cell size along x and y, m.
    composite_modulus
        E*, Pa.

    Returns
    -------
    Array, m/Pa, shape (nx, ny).
    """
    dx, dy = spacing
    x = ((np.arange(shape[0] + 1) - 0.5) * dx)[:, None]
    y = ((np.arange(shape[1] + 1) - 0.5) * dy)[None, :]
    corner = x * np.arcsinh(y / np.abs(x)) + y * np.arcsinh(x / np.abs(y))
    coefficients: Array = np.diff(np.diff(corner, axis=0), axis=1) / (np.pi * composite_modulus)
    return coefficients


class HalfSpace(Protocol):
    """What the contact solver needs to know of the elastic bodies on a window."""

    window: Window
    self_influence: float

    def displacement(self, pressure: Array) -> Array:
        """Normal surface displacement w, m, of a pressure, Pa; both of the window's shape."""
        ...

    def precondition(self, displacement: Array, compliance: float) -> Array:
        """Approximate inverse of `displacement` plus a uniform Winkler layer, m/Pa.

        Symmetric, positive definite, a quarter of the cost: the window is not padded.
        """
        ...

    def part(self, shape: tuple[int, int]) -> HalfSpace:
        """The same bodies on a smaller window around the same origin."""
        ...


class QuarterHalfSpace:
    """Half-space seen from the quarter x > 0, y > 0 of an even problem.

    Parameters
    ----------
    window
        A quarter window.
    composite_modulus
        E*, Pa.
    workers
        Threads of one transform.
    """

    def __init__(self, window: Window, composite_modulus: float, workers: int = 1) -> None:
        self.window = window
        self._modulus = composite_modulus
        self._workers = workers
        self._parts: dict[tuple[int, int], HalfSpace] = {}
        nx, ny = window.shape
        kernel = influence_coefficients((2 * nx + 1, 2 * ny + 1), window.spacing, composite_modulus)
        self.self_influence = float(kernel[0, 0])
        spectrum = scipy.fft.dctn(kernel, type=1, workers=workers)
        self._spectrum: Array = np.ascontiguousarray(spectrum[: 2 * nx, : 2 * ny])
        self._unpadded: Array = np.ascontiguousarray(spectrum[: 2 * nx : 2, : 2 * ny : 2])

    def displacement(self, pressure: Array) -> Array:
        """Normal surface displacement w, m, of a pressure, Pa; both of the window's shape."""
        nx, ny = self.window.shape
        rows = scipy.fft.dct(pressure, n=2 * ny, axis=1, workers=self._workers)
        both = scipy.fft.dct(rows, n=2 * nx, axis=0, workers=self._workers)
        both *= self._spectrum
        rows = scipy.fft.idct(both, axis=0, overwrite_x=True, workers=self._workers)[:nx]
        result: Array = scipy.fft.idct(rows, axis=1, overwrite_x=True, workers=self._workers)[
            :, :ny
        ]
        return result

    def precondition(self, displacement: Array, compliance: float) -> Array:
        """Approximate inverse of `displacement` plus a uniform Winkler layer, m/Pa."""
        transformed = scipy.fft.dctn(displacement, workers=self._workers)
        transformed /= self._unpadded + compliance
        result: Array = scipy.fft.idctn(transformed, overwrite_x=True, workers=self._workers)
        return result

    def part(self, shape: tuple[int, int]) -> HalfSpace:
        """The same bodies on a smaller window around the same origin."""
        if shape == self.window.shape:
            return self
        if shape not in self._parts:
            # Only the last one is kept: a zone that changes its size seldom changes it back.
            window = Window(shape, self.window.spacing, self.window.quarter)
            self._parts = {shape: QuarterHalfSpace(window, self._modulus, self._workers)}
        return self._parts[shape]


class WholeHalfSpace:
    """Half-space on a whole window, for problems without symmetry.

    Parameters
    ----------
    window
        A whole window.
    composite_modulus
        E*, Pa.
    workers
        Threads of one transform.
    """

    def __init__(self, window: Window, composite_modulus: float, workers: int = 1) -> None:
        self.window = window
        self._modulus = composite_modulus
        self._workers = workers
        self._parts: dict[tuple[int, int], HalfSpace] = {}
        nx, ny = window.shape
        kernel = influence_coefficients((nx + 1, ny + 1), window.spacing, composite_modulus)
        self.self_influence = float(kernel[0, 0])
        kernel = np.concatenate([kernel, kernel[-2:0:-1]], axis=0)
        kernel = np.concatenate([kernel, kernel[:, -2:0:-1]], axis=1)
        spectrum = scipy.fft.rfft2(kernel, workers=workers).real
        self._spectrum: Array = np.ascontiguousarray(spectrum)
        self._unpadded: Array = np.ascontiguousarray(spectrum[::2, : ny + 1 : 2])

    def displacement(self, pressure: Array) -> Array:
        """Normal surface displacement w, m, of a pressure, Pa; both of the window's shape."""
        nx, ny = self.window.shape
        rows = scipy.fft.rfft(pressure, n=2 * ny, axis=1, workers=self._workers)
        both = scipy.fft.fft(rows, n=2 * nx, axis=0, workers=self._workers)
        both *= self._spectrum
        rows = scipy.fft.ifft(both, axis=0, overwrite_x=True, workers=self._workers)[:nx]
        result: Array = scipy.fft.irfft(rows, n=2 * ny, axis=1, workers=self._workers)[:, :ny]
        return result

    def precondition(self, displacement: Array, compliance: float) -> Array:
        """Approximate inverse of `displacement` plus a uniform Winkler layer, m/Pa."""
        transformed = scipy.fft.rfft2(displacement, workers=self._workers)
        transformed /= self._unpadded + compliance
        result: Array = scipy.fft.irfft2(
            transformed, s=self.window.shape, overwrite_x=True, workers=self._workers
        )
        return result

    def part(self, shape: tuple[int, int]) -> HalfSpace:
        """The same bodies on a smaller window around the same origin."""
        if shape == self.window.shape:
            return self
        if shape not in self._parts:
            # Only the last one is kept: a zone that changes its size seldom changes it back.
            window = Window(shape, self.window.spacing, self.window.quarter)
            self._parts = {shape: WholeHalfSpace(window, self._modulus, self._workers)}
        return self._parts[shape]


def half_space(window: Window, composite_modulus: float, workers: int = 1) -> HalfSpace:
    """The half-space of a window: on the quarter where the window is one, else whole."""
    kind = QuarterHalfSpace if window.quarter else WholeHalfSpace
    return kind(window, composite_modulus, workers)
