"""Transforms and sums of fields on a grid, by ducc0 where it is installed, else by scipy.fft.

Transforms are not normalized. Both libraries agree to rounding; ducc0 is up to twice as fast.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fretwear.arrays import Array, Real, Single

try:
    import ducc0
except ImportError:
    import scipy.fft  # takes half a second

    ducc0 = None

# Columns that are transformed together stay in a core's cache.
_COLUMNS = 64


def inner(one: Real, second: Real) -> float:
    """Inner product of two fields of one precision."""
    return float(np.vdot(one, second))


def scaled(field: Array) -> tuple[Single, float]:
    """A field in units of its largest magnitude, in single precision, and the unit; 1 for zeros."""
    unit = float(np.abs(field).max())
    unit = unit if unit >= np.finfo(np.float64).tiny else 1.0
    return in_single(field, unit), unit


def in_single(field: Real, unit: float) -> Single:
    """A field in some unit, in single precision."""
    result = np.empty(field.shape, np.float32)
    np.multiply(field, 1.0 / unit, out=result, casting="same_kind")
    return result


def dct(kind: int, field: Real, axes: tuple[int, ...], buffer: Real | None = None) -> Real:
    """Discrete cosine transform of a field along some axes, in its memory or in a given buffer.

    I is f₀ + (−1)ᵏ fₙ + 2 ∑ fⱼ cos(πjk/n) with the sum over 0 < j < n, II is
    2 ∑ fⱼ cos(πk(2j + 1)/2n), III is f₀ + 2 ∑ fₖ cos(πk(2j + 1)/2n) with the sum over k > 0, IV is
    2 ∑ fⱼ cos(π(2k + 1)(2j + 1)/4n). The field is contiguous along its last axis.
    """
    target = field if buffer is None else buffer
    if ducc0 is not None:
        ducc0.fft.dct(field, axes=axes, type=kind, out=target)
        return target
    result = scipy.fft.dctn(field, type=kind, axes=axes, overwrite_x=target is field)
    target[...] = result
    return target


def dst(kind: int, field: Array, axes: tuple[int, ...]) -> Array:
    """Discrete sine transform of a field along some axes, I to IV, with the factors of `dct`."""
    if ducc0 is not None:
        result: Array = ducc0.fft.dst(field, axes=axes, type=kind)
        return result
    return np.asarray(scipy.fft.dstn(field, type=kind, axes=axes))


def fast_length(least: int) -> int:
    """Smallest length, not below the least one, at which real transforms are fast."""
    if ducc0 is not None:
        return int(ducc0.fft.good_size(least, True))
    return int(scipy.fft.next_fast_len(least, real=True))


def filtered(fields: Sequence[Real], spectra: Sequence[Real]) -> list[Real]:
    """One field, or two, by Fourier transforms, real factors and inverse transforms of a window.

    ``spectra`` are the factors for frequencies from zero up along both axes, and set the size of
    the window, which is zero beyond the fields. Negative frequencies along x have the same factors.
    Two fields have three spectra: of the first by the first, of the second by the second and,
    skew-symmetric, of each by the other; in the last, negative frequencies have the opposite ones.
    """
    rows, columns = fields[0].shape
    padded, length = (2 * (count - 1) for count in spectra[0].shape)
    waves = [_rfft(field, length) for field in fields]
    for first in range(0, length // 2 + 1, _COLUMNS):
        block = slice(first, first + _COLUMNS)
        parts = [_fft(wave[:, block], padded) for wave in waves]
        of_block = [spectrum[:, block] for spectrum in spectra]
        crossed: list[np.ndarray] = []
        if len(parts) == 2:
            crossed = [_times(part.copy(), of_block[2], odd=True) for part in parts[::-1]]
        for wave, part, spectrum in zip(waves, parts, of_block, strict=False):
            _times(part, spectrum)
            if crossed:
                part -= crossed.pop(0)
            wave[:, block] = _ifft(part)[:rows]
    return [np.ascontiguousarray(_irfft(wave, length)[:, :columns]) for wave in waves]


def _times(waves: np.ndarray, spectrum: Real, *, odd: bool = False) -> np.ndarray:
    """Waves, which are overwritten, times a spectrum that is even or odd along x."""
    below = spectrum[-2:0:-1]
    waves[: len(spectrum)] *= spectrum
    waves[len(spectrum) :] *= -below if odd else below
    return waves


def _rfft(field: Real, length: int) -> np.ndarray:
    """Half of the transform along y, padded to a length."""
    if ducc0 is None:
        return np.asarray(scipy.fft.rfft(field, length, axis=1))
    if field.shape[1] != length:
        padded = np.zeros((len(field), length), field.dtype)
        padded[:, : field.shape[1]] = field
        field = padded
    return np.asarray(ducc0.fft.r2c(field, axes=(1,)))


def _irfft(waves: np.ndarray, length: int) -> np.ndarray:
    if ducc0 is None:
        return np.asarray(scipy.fft.irfft(waves, length, axis=1, norm="forward"))
    return np.asarray(ducc0.fft.c2r(waves, axes=(1,), forward=False, lastsize=length))


def _fft(waves: np.ndarray, length: int) -> np.ndarray:
    """The transform along x, padded to a length, in memory of its own."""
    padded = np.zeros((length, waves.shape[1]), waves.dtype)
    padded[: len(waves)] = waves
    if ducc0 is None:
        return np.asarray(scipy.fft.fft(padded, axis=0, overwrite_x=True))
    return np.asarray(ducc0.fft.c2c(padded, axes=(0,), out=padded))


def _ifft(waves: np.ndarray) -> np.ndarray:
    if ducc0 is None:
        return np.asarray(scipy.fft.ifft(waves, axis=0, norm="forward", overwrite_x=True))
    return np.asarray(ducc0.fft.c2c(waves, axes=(0,), forward=False, out=waves))
