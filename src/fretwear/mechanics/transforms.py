"""Discrete cosine and Fourier transforms along axes of a field.

By ducc0 where it is installed, which is up to twice as fast here, else by scipy.fft. Both give
the same to rounding. None is normalized: a cosine transform and its inverse (III undoes II, IV
undoes itself) together multiply by twice the number of cells along each of the axes, a Fourier
transform and its inverse by the number of cells.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from fretwear.mechanics.arrays import Real, Spectrum

try:
    import ducc0
except ImportError:
    ducc0 = None


def dct2(field: Real, axes: tuple[int, ...], workers: int = 1, into: Real | None = None) -> Real:
    """DCT-II: 2 ∑ fⱼ cos(πk(2j + 1)/2n).

    Parameters
    ----------
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
    return _transform(field, 2, axes, workers, into)


def dct3(field: Real, axes: tuple[int, ...], workers: int = 1, into: Real | None = None) -> Real:
    """DCT-III: f₀ + 2 ∑ fₖ cos(πk(2j + 1)/2n), the sum over k > 0; parameters as of `dct2`."""
    return _transform(field, 3, axes, workers, into)


def dct4(field: Real, axes: tuple[int, ...], workers: int = 1, into: Real | None = None) -> Real:
    """DCT-IV: 2 ∑ fⱼ cos(π(2k + 1)(2j + 1)/4n); parameters as of `dct2`."""
    return _transform(field, 4, axes, workers, into)


def rfft(rows: Real, workers: int = 1) -> Spectrum:
    """Fourier transform of real rows: their non-negative frequencies."""
    if ducc0 is not None:
        result: Spectrum = ducc0.fft.r2c(rows, axes=(1,), nthreads=workers)
        return result
    result = scipy.fft.rfft(rows, axis=1, workers=workers)
    return result


def irfft(spectrum: Spectrum, count: int, workers: int = 1) -> Any:
    """Real rows of so many cells from their non-negative frequencies: `rfft` undone."""
    if ducc0 is not None:
        result = ducc0.fft.c2r(spectrum, axes=(1,), lastsize=count, forward=False, nthreads=workers)
        return result
    result = scipy.fft.irfft(spectrum, n=count, axis=1, norm="forward", workers=workers)
    return result


def fft(columns: Spectrum, workers: int = 1) -> None:
    """Fourier transform of columns in place."""
    _fourier(columns, workers, forward=True)


def ifft(columns: Spectrum, workers: int = 1) -> None:
    """Inverse Fourier transform of columns in place."""
    _fourier(columns, workers, forward=False)


def _fourier(columns: Spectrum, workers: int, *, forward: bool) -> None:
    if ducc0 is not None:
        ducc0.fft.c2c(columns, axes=(0,), forward=forward, out=columns, nthreads=workers)
        return
    transform = scipy.fft.fft if forward else scipy.fft.ifft
    norm = "backward" if forward else "forward"
    _put(transform(columns, axis=0, norm=norm, overwrite_x=True, workers=workers), columns)


def _transform(
    field: Real, kind: int, axes: tuple[int, ...], workers: int, into: Real | None
) -> Real:
    if ducc0 is not None:
        target = field if into is None else into
        ducc0.fft.dct(field, axes=axes, type=kind, out=target, nthreads=workers)
        return target
    in_place = into is None
    result: Real = scipy.fft.dctn(
        field, type=kind, axes=axes, overwrite_x=in_place, workers=workers
    )
    if not in_place:
        return result
    _put(result, field)
    return field


def _put(result: NDArray[Any], target: NDArray[Any]) -> None:
    """Copy a result to where it belongs, unless it was made there."""
    if not np.may_share_memory(result, target):
        target[...] = result
