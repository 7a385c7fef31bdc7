"""Free-space convolution of a field on a window with a kernel that is even along x and y.

Zero padding makes a discrete convolution exact: free space, no periodic images. Where the field
is even too, only the quarter x > 0, y > 0 is kept: the even extension turns the Fourier transform
into cosine transforms, DCT-II of the field and DCT-I of the kernel, with the same result to
rounding.

A DCT-II of n numbers and as many zeros is never made as such: its even frequencies are the DCT-II
of the n numbers, its odd ones their DCT-IV. Half as long and without the zeros, both together
take less time, and the spectra of the four parities of two axes are fields of the window's shape.

Transforms are made by ducc0 where it is installed, which is up to twice as fast here, else by
scipy.fft; both give the same to rounding. None is normalized: a cosine transform and its inverse
(III undoes II, IV undoes itself) together multiply by twice the number of cells along each of the
axes, a Fourier transform and its inverse by the number of cells.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from functools import cached_property, partial
from typing import Any, Generic

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from fretwear.mechanics.geometry import Array, Real, Single
from fretwear.mechanics.kernels import blocks_of_rows

try:
    import ducc0
except ImportError:
    ducc0 = None

Spectrum = NDArray[np.complexfloating[Any, Any]]

_BLOCK_BYTES = 2**18


class Convolution(ABC, Generic[Real]):
    """Convolution of fields on a window with one kernel, in double or in single precision."""

    @abstractmethod
    def __call__(self, field: Real) -> Real:
        """The convolution of a field, which is left as it is."""

    @abstractmethod
    def in_single(self, unit: float) -> Convolution[Single]:
        """The same in single precision, its kernel in some unit."""

    def inverse(self, added: float = 0.0) -> Callable[[Real], Real]:
        """Approximate inverse of the convolution plus a multiple of the field, not negative.

        Returns
        -------
        A function of a field: symmetric, positive definite, a quarter of the cost of a
        convolution, as the window is not padded. It may put the result in the place of its
        argument.
        """
        return partial(self._divided, self._inverse_spectrum(added))

    @abstractmethod
    def _inverse_spectrum(self, added: float) -> Real:
        """Inverse of the spectrum of the window without padding, plus a number."""

    @abstractmethod
    def _divided(self, inverse_spectrum: Real, field: Real) -> Real:
        """Periodic convolution with the field of a spectrum, on the window without padding."""


class CosineConvolution(Convolution[Real]):
    """On the quarter x > 0, y > 0 of an even problem.

    Parameters
    ----------
    spectra
        Of the kernel, by parity of the frequency along x and along y; fields of the window's
        shape, divided by what the transforms of a convolution multiply by.
    workers
        Threads of one transform.
    """

    def __init__(self, spectra: Sequence[Sequence[Real]], workers: int) -> None:
        self._spectra: Sequence[Sequence[Real]] = spectra
        self._workers = workers
        self._shape = spectra[0][0].shape
        self._precision: np.dtype[Any] = spectra[0][0].dtype

    @staticmethod
    def offsets(shape: tuple[int, int]) -> tuple[int, int]:
        """Number of offsets along x and y at which the kernel is needed on a window."""
        return 2 * shape[0] + 1, 2 * shape[1] + 1

    @staticmethod
    def with_kernel(kernel: Array, workers: int) -> CosineConvolution[Array]:
        """With a kernel given at the `offsets` of a window, which is overwritten."""
        spectrum = scipy.fft.dctn(kernel, type=1, overwrite_x=True, workers=workers)
        # What two transforms along each of the axes of the padded window leave.
        spectrum /= 4 * (kernel.shape[0] - 1) * (kernel.shape[1] - 1)
        return CosineConvolution(
            [[np.ascontiguousarray(spectrum[x:-1:2, y:-1:2]) for y in (0, 1)] for x in (0, 1)],
            workers,
        )

    def in_single(self, unit: float) -> CosineConvolution[Single]:
        """The same in single precision, its kernel in some unit."""
        return CosineConvolution(
            [[(field / unit).astype(np.float32) for field in row] for row in self._spectra],
            self._workers,
        )

    def __call__(self, field: Real) -> Real:
        """The convolution of a field, which is left as it is."""
        even = dct(2, field, (0,), self._workers, into=np.empty_like(field))
        odd = dct(4, field, (0,), self._workers, into=self._odd)
        for parity, spectra in zip((even, odd), self._spectra, strict=True):
            for rows in self._blocks:
                self._convolve_rows(parity[rows], spectra[0][rows], spectra[1][rows])
        dct(3, even, (0,), self._workers)
        even += dct(4, odd, (0,), self._workers)
        return even

    def _convolve_rows(self, field: Real, even: Real, odd: Real) -> None:
        """Multiply rows by spectra of the even and the odd frequencies along y, in place."""
        between = dct(4, field, (1,), self._workers, into=self._between[: len(field)])
        between *= odd
        dct(4, between, (1,), self._workers)
        dct(2, field, (1,), self._workers)
        field *= even
        dct(3, field, (1,), self._workers)
        field += between

    # Memory that was used a moment ago is faster than new memory, and so are blocks of rows that
    # the processor's cache holds.

    @cached_property
    def _odd(self) -> Real:
        return np.empty(self._shape, self._precision)

    @cached_property
    def _blocks(self) -> list[slice]:
        return blocks_of_rows(self._shape, _BLOCK_BYTES // self._precision.itemsize)

    @cached_property
    def _between(self) -> Real:
        return np.empty((self._blocks[0].stop, self._shape[1]), self._precision)

    def _inverse_spectrum(self, added: float) -> Real:
        nx, ny = self._shape
        # The even frequencies are those of the window without padding.
        result: Real = 16 * nx * ny * self._spectra[0][0]
        result += added
        np.divide(0.25 / (nx * ny), result, out=result)
        return result

    def _divided(self, inverse_spectrum: Real, field: Real) -> Real:
        dct(2, field, (0, 1), self._workers)
        field *= inverse_spectrum
        dct(3, field, (0, 1), self._workers)
        return field


class FourierConvolution(Convolution[Real]):
    """On a whole window, for fields without symmetry.

    Parameters
    ----------
    spectrum
        Of the kernel on the padded window, real; divided by the number of its cells.
    workers
        Threads of one transform.
    """

    def __init__(self, spectrum: Real, workers: int) -> None:
        self._spectrum: Real = spectrum
        self._workers = workers
        self._shape = spectrum.shape[0] // 2, spectrum.shape[1] - 1

    @staticmethod
    def offsets(shape: tuple[int, int]) -> tuple[int, int]:
        """Number of offsets along x and y at which the kernel is needed on a window."""
        return shape[0] + 1, shape[1] + 1

    @staticmethod
    def with_kernel(kernel: Array, workers: int) -> FourierConvolution[Array]:
        """With a kernel given at the `offsets` of a window."""
        even = np.concatenate([kernel, kernel[-2:0:-1]], axis=0)
        even = np.concatenate([even, even[:, -2:0:-1]], axis=1)
        spectrum = scipy.fft.rfft2(even, workers=workers)
        # What two transforms along each of the axes of the padded window leave.
        return FourierConvolution(spectrum.real / even.size, workers)

    def in_single(self, unit: float) -> FourierConvolution[Single]:
        """The same in single precision, its kernel in some unit."""
        return FourierConvolution((self._spectrum / unit).astype(np.float32), self._workers)

    def __call__(self, field: Real) -> Real:
        """The convolution of a field, which is left as it is."""
        nx, ny = self._shape
        rows, columns = self._padded
        rows[:, :ny] = field
        columns[:nx] = rfft(rows, self._workers)
        columns[nx:] = 0.0
        fft(columns, self._workers)
        columns *= self._spectrum
        fft(columns, self._workers, forward=False)
        result: Real = irfft(columns[:nx], 2 * ny, self._workers)[:, :ny].copy()
        return result

    @cached_property
    def _padded(self) -> tuple[Real, Spectrum]:
        """Rows with zeros behind them, and the columns of their transforms."""
        nx, ny = self._shape
        precision = self._spectrum.dtype
        columns = np.result_type(precision, np.complex64)
        return np.zeros((nx, 2 * ny), precision), np.empty((2 * nx, ny + 1), columns)

    def _inverse_spectrum(self, added: float) -> Real:
        nx, ny = self._shape
        # Every other frequency is one of the window without padding.
        result: Real = self._spectrum[::2, ::2] * (4 * nx * ny)
        result += added
        np.divide(1.0 / (nx * ny), result, out=result)
        return result

    def _divided(self, inverse_spectrum: Real, field: Real) -> Real:
        columns = rfft(field, self._workers)
        fft(columns, self._workers)
        columns *= inverse_spectrum
        fft(columns, self._workers, forward=False)
        result: Real = irfft(columns, self._shape[1], self._workers)
        return result


def dct(
    kind: int, field: Real, axes: tuple[int, ...], workers: int = 1, into: Real | None = None
) -> Real:
    """Discrete cosine transform of a field.

    II is 2 ∑ fⱼ cos(πk(2j + 1)/2n), III is f₀ + 2 ∑ fₖ cos(πk(2j + 1)/2n) with the sum over k > 0,
    IV is 2 ∑ fⱼ cos(π(2k + 1)(2j + 1)/4n).

    Parameters
    ----------
    kind
        2, 3 or 4.
    field
        Contiguous along its last axis.
    axes
        Which to transform.
    workers
        Threads.
    into
        Room for the result, of the field's shape, if it is not to take the field's place.

    Returns
    -------
    The result. It lies in the field's place or in the room given; scipy.fft makes room of its own.
    """
    if ducc0 is not None:
        target = field if into is None else into
        ducc0.fft.dct(field, axes=axes, type=kind, out=target, nthreads=workers)
        return target
    in_place = into is None
    result: Real = scipy.fft.dctn(
        field, type=kind, axes=axes, overwrite_x=in_place, workers=workers
    )
    return _put(result, field) if in_place else result


def rfft(rows: Real, workers: int = 1) -> Spectrum:
    """Fourier transform of real rows: their non-negative frequencies."""
    result: Spectrum
    if ducc0 is not None:
        result = ducc0.fft.r2c(rows, axes=(1,), nthreads=workers)
    else:
        result = scipy.fft.rfft(rows, axis=1, workers=workers)
    return result


def irfft(spectrum: Spectrum, count: int, workers: int = 1) -> Any:
    """Real rows of so many cells from their non-negative frequencies: `rfft` undone."""
    if ducc0 is not None:
        return ducc0.fft.c2r(spectrum, axes=(1,), lastsize=count, forward=False, nthreads=workers)
    return scipy.fft.irfft(spectrum, n=count, axis=1, norm="forward", workers=workers)


def fft(columns: Spectrum, workers: int = 1, *, forward: bool = True) -> None:
    """Fourier transform of columns in place, or its inverse."""
    if ducc0 is not None:
        ducc0.fft.c2c(columns, axes=(0,), forward=forward, out=columns, nthreads=workers)
        return
    transform = scipy.fft.fft if forward else scipy.fft.ifft
    norm = "backward" if forward else "forward"
    _put(transform(columns, axis=0, norm=norm, overwrite_x=True, workers=workers), columns)


def _put(result: NDArray[Any], target: NDArray[Any]) -> Any:
    """Copy a result to where it belongs, unless it was made there."""
    if not np.may_share_memory(result, target):
        target[...] = result
    return target
