"""The elastic half-space: surface displacement under a pressure given on a window of cells.

The pressure is piecewise constant on rectangular cells. Its displacement is a discrete
convolution with the influence coefficients of Love (1929); zero padding makes the convolution
exact (free space, no periodic images). Where pressure is even in x and y, only the quarter
x > 0, y > 0 is kept: the even extension turns the Fourier transform into cosine transforms,
DCT-II of the data and DCT-I of the kernel, with the same result to rounding.

A DCT-II of n numbers and as many zeros is never made as such: its even frequencies are the DCT-II
of the n numbers, its odd ones their DCT-IV. Half as long and without the zeros, both together
take less time, and the spectra of the four parities of two axes are fields of the window's shape.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import cached_property, partial
from weakref import WeakValueDictionary

import numpy as np
import scipy.fft

from fretwear.mechanics.arrays import Array, Spectrum
from fretwear.mechanics.transforms import dct2, dct3, dct4, fft, ifft, irfft, rfft
from fretwear.mechanics.window import Window

_PARTS = 4
_BLOCK = 2**15


def influence_coefficients(
    shape: tuple[int, int], spacing: tuple[float, float], composite_modulus: float
) -> Array:
    """Normal displacement of cell (i, j) per unit pressure on cell (0, 0).

    Love, "The stress produced in a semi-infinite solid by pressure on part of the boundary",
    Phil. Trans. R. Soc. A 228 (1929), for a rectangle; the four corner terms of neighbouring
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


class HalfSpace(ABC):
    """The elastic bodies on a window.

    Parameters
    ----------
    window
        The cells; a quarter window for `QuarterHalfSpace`, a whole one for `WholeHalfSpace`.
    composite_modulus
        E*, Pa.
    workers
        Threads of one transform.

    Attributes
    ----------
    self_influence
        Displacement of a cell per pressure on itself, m/Pa.
    """

    def __init__(self, window: Window, composite_modulus: float, workers: int = 1) -> None:
        self.window = window
        self._modulus = composite_modulus
        self._workers = workers
        self._parts: dict[tuple[int, int], HalfSpace] = {}
        kernel = influence_coefficients(self._padding, window.spacing, composite_modulus)
        self.self_influence = float(kernel[0, 0])
        self._transform(kernel)

    @property
    @abstractmethod
    def _padding(self) -> tuple[int, int]:
        """Number of offsets along x and y at which the kernel is needed."""

    @abstractmethod
    def _transform(self, kernel: Array) -> None:
        """Keep the spectrum of the kernel, given at the offsets `_padding`."""

    @abstractmethod
    def displacement(self, pressure: Array) -> Array:
        """Normal surface displacement w, m, of a pressure, Pa; both of the window's shape."""

    def inverse(self, compliance: float = 0.0) -> Callable[[Array], Array]:
        """Approximate inverse of `displacement` plus a uniform Winkler layer.

        Parameters
        ----------
        compliance
            Of the layer, m/Pa, not negative.

        Returns
        -------
        A function from a displacement, m, to a pressure, Pa, shape of the window: symmetric,
        positive definite, a quarter of the cost of `displacement`, as the window is not padded.
        It may put the result in the place of its argument.
        """
        return partial(self._divided, self._inverse_spectrum(compliance))

    @abstractmethod
    def _inverse_spectrum(self, compliance: float) -> Array:
        """Inverse of the spectrum of the window without padding, with a Winkler layer."""

    @abstractmethod
    def _divided(self, inverse_spectrum: Array, displacement: Array) -> Array:
        """Periodic convolution with the field of a spectrum, on the window without padding."""

    def part(self, shape: tuple[int, int]) -> HalfSpace:
        """The same bodies on a smaller window around the same origin."""
        if shape == self.window.shape:
            return self
        if shape not in self._parts:
            # A few are kept: zones that change their size seldom change it back.
            window = Window(shape, self.window.spacing, self.window.quarter)
            self._parts[shape] = type(self)(window, self._modulus, self._workers)
            if len(self._parts) > _PARTS:
                del self._parts[next(iter(self._parts))]
        return self._parts[shape]


class QuarterHalfSpace(HalfSpace):
    """Half-space seen from the quarter x > 0, y > 0 of an even problem."""

    @property
    def _padding(self) -> tuple[int, int]:
        nx, ny = self.window.shape
        return 2 * nx + 1, 2 * ny + 1

    def _transform(self, kernel: Array) -> None:
        nx, ny = self.window.shape
        spectrum = scipy.fft.dctn(kernel, type=1, overwrite_x=True, workers=self._workers)
        # What two transforms along each of the axes of the padded window leave.
        spectrum /= 16 * nx * ny
        self._spectra: list[list[Array]] = [
            [np.ascontiguousarray(spectrum[x:-1:2, y:-1:2]) for y in (0, 1)] for x in (0, 1)
        ]

    def displacement(self, pressure: Array) -> Array:
        """Normal surface displacement w, m, of a pressure, Pa; both of the window's shape."""
        even = dct2(pressure, (0,), self._workers, into=np.empty_like(pressure))
        odd = dct4(pressure, (0,), self._workers, into=self._odd)
        for field, spectra in zip((even, odd), self._spectra, strict=True):
            for rows in self._blocks:
                self._convolve_rows(field[rows], spectra[0][rows], spectra[1][rows])
        dct3(even, (0,), self._workers)
        even += dct4(odd, (0,), self._workers)
        return even

    def _convolve_rows(self, field: Array, even: Array, odd: Array) -> None:
        """Multiply rows by spectra of the even and the odd frequencies along y, in place."""
        between = dct4(field, (1,), self._workers, into=self._between[: len(field)])
        between *= odd
        dct4(between, (1,), self._workers)
        dct2(field, (1,), self._workers)
        field *= even
        dct3(field, (1,), self._workers)
        field += between

    # Memory that was used a moment ago is faster than new memory, and so are blocks of rows that
    # the processor's cache holds.

    @cached_property
    def _odd(self) -> Array:
        return np.empty(self.window.shape)

    @cached_property
    def _between(self) -> Array:
        nx, ny = self.window.shape
        return np.empty((min(nx, max(1, _BLOCK // ny)), ny))

    @cached_property
    def _blocks(self) -> list[slice]:
        length = len(self._between)
        return [slice(first, first + length) for first in range(0, self.window.shape[0], length)]

    def _inverse_spectrum(self, compliance: float) -> Array:
        nx, ny = self.window.shape
        # The even frequencies are those of the window without padding.
        result: Array = 16 * nx * ny * self._spectra[0][0]
        result += compliance
        return np.divide(0.25 / (nx * ny), result, out=result)

    def _divided(self, inverse_spectrum: Array, displacement: Array) -> Array:
        dct2(displacement, (0, 1), self._workers)
        displacement *= inverse_spectrum
        dct3(displacement, (0, 1), self._workers)
        return displacement


class WholeHalfSpace(HalfSpace):
    """Half-space on a whole window, for problems without symmetry."""

    @property
    def _padding(self) -> tuple[int, int]:
        nx, ny = self.window.shape
        return nx + 1, ny + 1

    def _transform(self, kernel: Array) -> None:
        even = np.concatenate([kernel, kernel[-2:0:-1]], axis=0)
        even = np.concatenate([even, even[:, -2:0:-1]], axis=1)
        spectrum = scipy.fft.rfft2(even, workers=self._workers)
        # What two transforms along each of the axes of the padded window leave.
        self._spectrum: Array = spectrum.real / even.size

    def displacement(self, pressure: Array) -> Array:
        """Normal surface displacement w, m, of a pressure, Pa; both of the window's shape."""
        nx, ny = self.window.shape
        rows, columns = self._padded
        rows[:, :ny] = pressure
        columns[:nx] = rfft(rows, self._workers)
        columns[nx:] = 0.0
        fft(columns, self._workers)
        columns *= self._spectrum
        ifft(columns, self._workers)
        return irfft(columns[:nx], 2 * ny, self._workers)[:, :ny].copy()

    @cached_property
    def _padded(self) -> tuple[Array, Spectrum]:
        """Rows with zeros behind them, and the columns of their transforms."""
        nx, ny = self.window.shape
        return np.zeros((nx, 2 * ny)), np.empty((2 * nx, ny + 1), dtype=np.complex128)

    def _inverse_spectrum(self, compliance: float) -> Array:
        nx, ny = self.window.shape
        # Every other frequency is one of the window without padding.
        result: Array = self._spectrum[::2, ::2] * (4 * nx * ny)
        result += compliance
        return np.divide(1.0 / (nx * ny), result, out=result)

    def _divided(self, inverse_spectrum: Array, displacement: Array) -> Array:
        columns = rfft(displacement, self._workers)
        fft(columns, self._workers)
        columns *= inverse_spectrum
        ifft(columns, self._workers)
        return irfft(columns, self.window.shape[1], self._workers)


_in_use: WeakValueDictionary[tuple[Window, float, int], HalfSpace] = WeakValueDictionary()


def half_space(window: Window, composite_modulus: float, workers: int = 1) -> HalfSpace:
    """The half-space of a window: on the quarter where the window is one, else whole.

    One that is still in use is not made again.
    """
    key = window, composite_modulus, workers
    bodies = _in_use.get(key)
    if bodies is None:
        kind = QuarterHalfSpace if window.quarter else WholeHalfSpace
        bodies = _in_use[key] = kind(window, composite_modulus, workers)
    return bodies
