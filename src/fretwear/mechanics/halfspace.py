"""The elastic half-space: surface displacement under a pressure given on a window of cells.

The pressure is piecewise constant on rectangular cells. Its displacement is a discrete
convolution with the influence coefficients of Love (1929); zero padding makes the convolution
exact (free space, no periodic images). Where pressure is even in x and y, only the quarter
x > 0, y > 0 is kept: the even extension turns the Fourier transform into cosine transforms,
DCT-II of the data and DCT-I of the kernel, with the same result to rounding.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import cached_property, partial

import numpy as np
import scipy.fft

from fretwear.mechanics.arrays import Array
from fretwear.mechanics.transforms import cosine, inverse_cosine
from fretwear.mechanics.window import Window

_PARTS = 4


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
        spectrum = self._transform(kernel)
        self._spectrum: Array = np.ascontiguousarray(self._padded(spectrum))
        # Every other frequency is one of the window without padding.
        self._unpadded: Array = np.ascontiguousarray(self._spectrum[::2, ::2])

    @property
    @abstractmethod
    def _padding(self) -> tuple[int, int]:
        """Number of offsets along x and y at which the kernel is needed."""

    @abstractmethod
    def _transform(self, kernel: Array) -> Array:
        """Spectrum of the kernel, given at the offsets `_padding`."""

    @abstractmethod
    def _padded(self, spectrum: Array) -> Array:
        """The part of the spectrum that a padded field has too."""

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
        return partial(self._divided, self._unpadded_scale / (self._unpadded + compliance))

    @property
    @abstractmethod
    def _unpadded_scale(self) -> float:
        """What undoes the factor of the transforms of the window without padding."""

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

    def _transform(self, kernel: Array) -> Array:
        spectrum: Array = scipy.fft.dctn(kernel, type=1, workers=self._workers)
        return spectrum

    def _padded(self, spectrum: Array) -> Array:
        return spectrum[:-1, :-1]

    @cached_property
    def _work(self) -> Array:
        nx, ny = self.window.shape
        return np.empty((2 * nx, 2 * ny))

    @cached_property
    def _scaled_spectrum(self) -> Array:
        """The spectrum with the factor that the two transforms leave."""
        return self._spectrum / (4 * self._spectrum.size)

    def displacement(self, pressure: Array) -> Array:
        """Normal surface displacement w, m, of a pressure, Pa; both of the window's shape."""
        nx, ny = self.window.shape
        work, rows = self._work, self._work[:nx]
        rows[:, :ny] = pressure
        rows[:, ny:] = 0.0
        work[nx:] = 0.0
        cosine(rows, (1,), self._workers)
        cosine(work, (0,), self._workers)
        work *= self._scaled_spectrum
        inverse_cosine(work, (0,), self._workers)
        inverse_cosine(rows, (1,), self._workers)
        return rows[:, :ny].copy()

    @property
    def _unpadded_scale(self) -> float:
        return 0.25 / self._unpadded.size

    def _divided(self, inverse_spectrum: Array, displacement: Array) -> Array:
        cosine(displacement, (0, 1), self._workers)
        displacement *= inverse_spectrum
        inverse_cosine(displacement, (0, 1), self._workers)
        return displacement


class WholeHalfSpace(HalfSpace):
    """Half-space on a whole window, for problems without symmetry."""

    @property
    def _padding(self) -> tuple[int, int]:
        nx, ny = self.window.shape
        return nx + 1, ny + 1

    def _transform(self, kernel: Array) -> Array:
        even = np.concatenate([kernel, kernel[-2:0:-1]], axis=0)
        even = np.concatenate([even, even[:, -2:0:-1]], axis=1)
        spectrum: Array = scipy.fft.rfft2(even, workers=self._workers).real
        return spectrum

    def _padded(self, spectrum: Array) -> Array:
        return spectrum

    def displacement(self, pressure: Array) -> Array:
        """Normal surface displacement w, m, of a pressure, Pa; both of the window's shape."""
        nx, ny = self.window.shape
        rows = scipy.fft.rfft(pressure, n=2 * ny, axis=1, workers=self._workers)
        both = scipy.fft.fft(rows, n=2 * nx, axis=0, workers=self._workers)
        both *= self._spectrum
        rows = scipy.fft.ifft(both, axis=0, overwrite_x=True, workers=self._workers)[:nx]
        result: Array = scipy.fft.irfft(rows, n=2 * ny, axis=1, workers=self._workers)[:, :ny]
        return result

    @property
    def _unpadded_scale(self) -> float:
        return 1.0

    def _divided(self, inverse_spectrum: Array, displacement: Array) -> Array:
        transformed = scipy.fft.rfft2(displacement, workers=self._workers)
        transformed *= inverse_spectrum
        result: Array = scipy.fft.irfft2(
            transformed, s=self.window.shape, overwrite_x=True, workers=self._workers
        )
        return result


def half_space(window: Window, composite_modulus: float, workers: int = 1) -> HalfSpace:
    """The half-space of a window: on the quarter where the window is one, else whole."""
    kind = QuarterHalfSpace if window.quarter else WholeHalfSpace
    return kind(window, composite_modulus, workers)
