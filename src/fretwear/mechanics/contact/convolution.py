"""Free-space convolution of a field on a window with a kernel that is even along x and y.

Zero padding makes a discrete convolution exact: free space, no periodic images. The frequencies of
the padded window fall into two branches per axis: the even ones belong to the window repeated
periodically, the odd ones to the window repeated with alternating sign. Neither branch needs the
zeros, so two transforms of the window replace a longer one of the padded window, in less time. The
kernel has a spectrum of the window's size for each of the branches of two axes.

If the field is even along both axes, only the quarter with positive coordinates is kept, and the
transforms are cosine transforms: DCT-II for the even branch, DCT-IV for the odd one. ducc0 makes
them where it is installed, up to twice as fast here as scipy.fft, which makes them otherwise; both
agree to rounding. None is normalized: a transform and its inverse (III undoes II, IV undoes itself)
together multiply by twice the number of cells on the positive side.

On small windows, products with matrices of cosines are up to four times as fast as transforms.

Other fields are convolved as a whole, by real Fourier transforms of the padded window.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, Generic

import numpy as np

from fretwear.arrays import Array, Even, Real, Single
from fretwear.mechanics.contact.kernels import dct, filtered, in_single

# Rows of so many bytes are transformed together; they fit the cache of a core.
_BLOCK_BYTES = 2**20
# If a square with the cells along both axes as its side takes at most so many bytes, matrices of
# cosines are faster than transforms.
_DENSE_BYTES = 110_000


class Convolution(ABC, Generic[Real]):
    """Convolution of fields on a window with one kernel, in double or in single precision.

    ``factors`` multiply the transforms of a field. They are the kernel's spectrum, divided by what
    the transforms of a convolution leave, in the form of `_filtered`.
    """

    def __init__(self, factors: Sequence[Real], even: Even) -> None:
        self._factors: Sequence[Real] = factors
        self._even = even

    def in_single(self, unit: float) -> Convolution[Single]:
        """The same in single precision, with the kernel in some unit."""
        alike: Any = type(self)
        factors = [in_single(factor, unit) for factor in self._factors]
        result: Convolution[Single] = alike(factors, self._even)
        return result

    def __call__(self, field: Real) -> Real:
        """The convolution of a field, which is not changed."""
        return self._filtered(field, self._factors)

    def inverse(self, added: float = 0.0) -> Callable[[Real], Real]:
        """Approximate inverse of the convolution plus a multiple of the field.

        It maps a field to a field, is symmetric and positive definite, and costs a quarter of a
        convolution because the window is not padded. It may overwrite its argument.
        """
        spectrum, cells = self._unpadded
        inverted = 1.0 / cells / (4 * cells * spectrum + added)
        factors = [inverted.astype(spectrum.dtype, copy=False)]
        return lambda field: self._filtered(field, factors)

    @property
    @abstractmethod
    def _unpadded(self) -> tuple[Real, int]:
        """The factor at the frequencies of the window without padding, and cells of the whole."""

    @abstractmethod
    def _filtered(self, field: Real, factors: Sequence[Real]) -> Real:
        """A field whose transforms are multiplied by factors."""


def offsets(shape: tuple[int, int], even: Even) -> tuple[int, int]:
    """Number of offsets along x and y at which the kernel is needed on a window."""
    nx, ny = (2 * n if is_even else n for n, is_even in zip(shape, even, strict=True))
    return nx + 1, ny + 1


def convolution(kernel: Array, even: Even) -> Convolution[Array]:
    """Convolution with a kernel given at the `offsets` of a window, which is overwritten."""
    spectrum = dct(1, kernel, (0, 1))
    # Two transforms along each of the axes of the padded window leave this factor.
    spectrum /= 4 * (kernel.shape[0] - 1) * (kernel.shape[1] - 1)
    if not all(even):
        return WholeConvolution([spectrum], even)
    # The highest frequency does not occur in any field.
    factor = np.block([[spectrum[x:-1:2, y:-1:2] for y in (0, 1)] for x in (0, 1)])
    return QuarterConvolution([factor], even)


class QuarterConvolution(Convolution[Real]):
    """Convolution by cosine transforms, of a field that is even along both axes.

    The rows and the columns of its factor are those of the even branch, then of the odd one.
    """

    @property
    def _unpadded(self) -> tuple[Real, int]:
        rows, columns = self._factors[0].shape
        return self._factors[0][: rows // 2, : columns // 2], rows * columns

    def _filtered(self, field: Real, factors: Sequence[Real]) -> Real:
        sizes = [*zip(field.shape, factors[0].shape, strict=True)]
        if sum(field.shape) ** 2 * field.itemsize <= _DENSE_BYTES:
            along_x, along_y = (_cosines(*size, field.dtype) for size in sizes)
            waves: Real = along_x[0] @ field @ along_y[0].T
            waves *= factors[0]
            result: Real = along_x[1].T @ waves @ along_y[1]
            return result
        columns, all_columns = sizes[1]
        even, *odd = (factors[0][:, n : n + columns] for n in range(0, all_columns, columns))
        both: Real = np.empty((2, *field.shape), field.dtype) if odd else field[None]
        kinds = ((2, 3), (4, 4))[: len(both)]
        for wave, (forward, _) in zip(both, kinds, strict=True):
            dct(forward, field, (0,), buffer=wave)
        rows = both.reshape(even.shape)
        count = max(1, _BLOCK_BYTES // (field.itemsize * columns))
        for first in range(0, len(rows), count):
            block = slice(first, first + count)
            part = rows[block]
            halfway = [dct(4, part, (1,), buffer=np.empty_like(part)) for _ in odd]
            dct(2, part, (1,))
            part *= even[block]
            dct(3, part, (1,))
            for wave, factor in zip(halfway, odd, strict=True):
                wave *= factor[block]
                part += dct(4, wave, (1,))
        for wave, (_, backward) in zip(both, kinds, strict=True):
            dct(backward, wave, (0,))
        return np.add(*both) if odd else field


@lru_cache(64)
def _cosines(cells: int, frequencies: int, precision: np.dtype[Any]) -> list[Any]:
    """Matrices of the transform along an axis and, transposed, back; of one branch or of both."""
    matrices = [[dct(2, np.eye(cells), (0,)), dct(3, np.eye(cells), (1,))]]
    matrices += [[dct(4, np.eye(cells), (0,))] * 2] * (frequencies > cells)
    return [np.concatenate(each).astype(precision) for each in zip(*matrices, strict=True)]


class WholeConvolution(Convolution[Real]):
    """Convolution by Fourier transforms of all cells of a window, mirrored where they are even."""

    @property
    def _unpadded(self) -> tuple[Real, int]:
        rows, columns = self._factors[0].shape
        return self._factors[0][::2, ::2], (rows - 1) * (columns - 1)

    def _filtered(self, field: Real, factors: Sequence[Real]) -> Real:
        """Unfold the field along the axes in which it is even, convolve it, and fold it again."""
        whole = field
        for axis in np.flatnonzero(self._even):
            whole = np.concatenate([np.flip(whole, int(axis)), whole], axis)
        (result,) = filtered([whole], factors)
        first = (n - kept for n, kept in zip(whole.shape, field.shape, strict=True))
        return np.ascontiguousarray(result[tuple(slice(start, None) for start in first)])
