"""Free-space convolution of a field on a window with a kernel that is even along x and y.

Zero padding makes a discrete convolution exact: free space, no periodic images. Its frequencies
fall into two branches, neither of which needs the zeros: the even ones belong to the window
repeated periodically, the odd ones to the window repeated with alternating sign. Half as long and
without the zeros, both together take less time, and for the two branches of two axes the spectra of
the kernel are fields of the window's size.

Where the field is even along both axes, only the quarter with positive coordinates is kept, and
the transforms are cosine transforms: DCT-II for the even branch, DCT-IV for the odd one. They are
made by ducc0 where it is installed, which is up to twice as fast here, else by scipy.fft; both give
the same to rounding. None is normalized: a transform and its inverse (III undoes II, IV undoes
itself) together multiply by twice the number of cells on the positive side.

Any other field is convolved as a whole by the compiled library: by complex transforms of the same
two branches, of lines that hold a frequency along x.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from functools import cached_property
from itertools import pairwise, product
from typing import Generic, Protocol

import numpy as np

from fretwear.arrays import Array, Single
from fretwear.mechanics.geometry import Even, Real
from fretwear.mechanics.team import ALONE, Team, blocks_of_rows, kernels

try:
    import ducc0
except ImportError:
    ducc0 = None

_BLOCK_BYTES = 2**20
# Threads take columns by whole vectors of the transforms, in so many parts for each of them.
_COLUMNS = 16
_PARTS = 4


class Convolution(ABC, Generic[Real]):
    """Convolution of fields on a window with one kernel, in double or in single precision.

    Its spectra are the kernel's, by branch of the frequency along x and along y, for one
    half of the frequencies along both axes, divided by the factor of a convolution's transforms.
    """

    def __init__(self, spectra: Sequence[Real], even: Even, team: Team) -> None:
        self._spectra: Sequence[Real] = spectra
        self._even = even
        half_x, half_y = spectra[-1].shape
        self._cells = 4 * half_x * half_y
        self.team = team.for_cells(half_x * half_y if all(even) else self._cells)
        self._factors: list[Real] = self.team.each(self._factor, spectra)

    def in_single(self, unit: float) -> Convolution[Single]:
        """The same in single precision, with the kernel in some unit."""
        spectra = [
            self.team.cellwise(np.divide, spectrum, unit, dtype=np.float32)
            for spectrum in self._spectra
        ]
        return self._alike(spectra)

    def __call__(self, field: Real) -> Real:
        """The convolution of a field, which is not changed."""
        return self._filtered(field, self._factors)

    def inverse(self, added: float = 0.0) -> Callable[[Real], Real]:
        """Approximate inverse of the convolution plus a multiple of the field, not negative.

        It is a function of a field: symmetric, positive definite, a quarter of the cost of a
        convolution, as the window is not padded. It may put the result into its argument.
        """
        cells, spectrum = self._cells, self._spectra[0]
        # The even frequencies belong to the window without padding.
        inverted = self.team.cellwise(
            lambda part: 1.0 / cells / (4 * cells * part + added),
            spectrum,
            dtype=spectrum.dtype.type,
        )
        factor = self._factor(inverted)
        return lambda field: self._filtered(field, [factor])

    def _factor(self, spectrum: Real) -> Real:
        """A spectrum in the form that the transforms take."""
        return spectrum

    @abstractmethod
    def _alike(self, spectra: Sequence[Single]) -> Convolution[Single]:
        """The same kind of convolution by other spectra."""

    @abstractmethod
    def _filtered(self, field: Real, factors: Sequence[Real]) -> Real:
        """A field whose transforms, of all branches or the even one, are multiplied by factors."""


def offsets(shape: tuple[int, int], even: Even) -> tuple[int, int]:
    """Number of offsets along x and y at which the kernel is needed on a window."""
    nx, ny = (2 * n if is_even else n for n, is_even in zip(shape, even, strict=True))
    return nx + 1, ny + 1


def convolution(kernel: Array, even: Even, team: Team = ALONE) -> Convolution[Array]:
    """Convolution with a kernel given at the `offsets` of a window, which is overwritten."""
    # On one thread: how a transform is shared out changes its last bits.
    spectrum = dct(1, kernel, (0, 1))
    # Two transforms along each of the axes of the padded window leave this factor.
    spectrum /= 4 * (kernel.shape[0] - 1) * (kernel.shape[1] - 1)
    branches = [spectrum[x::2, y::2] for x in (0, 1) for y in (0, 1)]
    if not all(even):
        return WholeConvolution(branches, even, team)
    # No field has the frequency above all others.
    rows, columns = branches[-1].shape
    branches = team.each(lambda branch: np.ascontiguousarray(branch[:rows, :columns]), branches)
    return QuarterConvolution(branches, even, team)


class QuarterConvolution(Convolution[Real]):
    """Convolution by cosine transforms, of a field that is even along both axes."""

    def _alike(self, spectra: Sequence[Single]) -> Convolution[Single]:
        return QuarterConvolution(spectra, self._even, self.team)

    def _filtered(self, field: Real, factors: Sequence[Real]) -> Real:
        by_branch: list[Real] = [field]
        if len(factors) > 1:
            by_branch = [np.empty_like(field), np.empty_like(field)]

        def forward(columns: slice) -> None:
            for kind, branch in zip((2, 4), by_branch, strict=False):
                dct(kind, field[:, columns], (0,), into=branch[:, columns])

        def multiply(task: tuple[int, slice]) -> None:
            branch, rows = task
            block = by_branch[branch][rows]
            even, *odd = (factor[rows] for factor in factors[2 * branch : 2 * branch + 2])
            between = [dct(4, block, (1,), into=np.empty_like(block)) for _ in odd]
            dct(2, block, (1,))
            block *= even
            dct(3, block, (1,))
            for part, factor in zip(between, odd, strict=True):
                part *= factor
                block += dct(4, part, (1,))

        def backward(columns: slice) -> None:
            result, *odd = (branch[:, columns] for branch in by_branch)
            dct(3, result, (0,))
            for part in odd:
                result += dct(4, part, (0,))

        # Columns in parts for the threads, and rows in blocks that a processor's cache holds.
        columns: list[slice] = [slice(None)]
        parts, length = _PARTS * self.team.workers, field.shape[1]
        if parts > _PARTS:
            ends: list[int] = [length * n // parts // _COLUMNS * _COLUMNS for n in range(parts)]
            columns = [slice(*part) for part in pairwise([*ends, length]) if part[0] < part[1]]
        rows: Sequence[slice] = blocks_of_rows(field.shape, _BLOCK_BYTES // field.itemsize)
        self.team.each(forward, columns)
        self.team.each(multiply, [*product(range(len(by_branch)), rows)])
        self.team.each(backward, columns)
        return by_branch[0]


class Window(Protocol):
    """Compiled convolutions of fields of one shape and precision."""

    lanes: int  #: number of rows that a vector holds

    def convolve(self, team: Team, field: Real, factors: Sequence[Real], result: Real) -> None:
        """Convolve a field on all cells of the window by its factors into another."""

    def convolve_pair(self, team: Team, pair: Real, factors: Sequence[Real], result: Real) -> None:
        """Convolve two fields into two, by factors of the first, of the second and between them.

        Factors between them are odd along both axes; their spectrum has the opposite sign.
        """


def compiled_window(rows: int, columns: int, precision: np.dtype[np.floating]) -> Window:
    """Compiled convolutions on a window of some precision."""
    kind = kernels.SingleWindow if precision == np.float32 else kernels.DoubleWindow
    result: Window = kind(rows, columns)
    return result


def by_lanes(window: Window, spectrum: Real) -> Real:
    """A spectrum with rows as lanes of vectors, halved: two transforms double a field."""
    lanes = window.lanes
    padded = np.pad(0.5 * spectrum, ((0, -len(spectrum) % lanes), (0, 0)), mode="edge")
    blocks = padded.reshape(-1, lanes, spectrum.shape[1]).swapaxes(1, 2)
    return np.ascontiguousarray(blocks).reshape(-1, lanes)


class WholeConvolution(Convolution[Real]):
    """Convolution by the compiled library, on all cells of a window, mirrored if they are even."""

    @cached_property
    def _window(self) -> Window:
        rows, columns = self._spectra[-1].shape
        return compiled_window(2 * rows, 2 * columns, self._spectra[0].dtype)

    def _factor(self, spectrum: Real) -> Real:
        """A spectrum in the form that the library takes."""
        return by_lanes(self._window, spectrum)

    def _alike(self, spectra: Sequence[Single]) -> Convolution[Single]:
        return WholeConvolution(spectra, self._even, self.team)

    def _filtered(self, field: Real, factors: Sequence[Real]) -> Real:
        """Unfold the field along the axes in which it is even, convolve it, and fold it again."""
        whole = field
        for axis in np.flatnonzero(self._even):
            whole = np.concatenate([np.flip(whole, int(axis)), whole], axis)
        result = np.empty_like(whole, order="C")
        self._window.convolve(self.team, whole, factors, result)
        first = (
            n // 2 if is_even else 0 for n, is_even in zip(result.shape, self._even, strict=True)
        )
        return np.ascontiguousarray(result[tuple(slice(start, None) for start in first)])


def dct(kind: int, field: Real, axes: tuple[int, ...], into: Real | None = None) -> Real:
    """Discrete cosine transform of a field along some axes, in its memory or in a given buffer.

    I is f₀ + (−1)ᵏ fₙ + 2 ∑ fⱼ cos(πjk/n) with the sum over 0 < j < n, II is
    2 ∑ fⱼ cos(πk(2j + 1)/2n), III is f₀ + 2 ∑ fₖ cos(πk(2j + 1)/2n) with the sum over k > 0, IV is
    2 ∑ fⱼ cos(π(2k + 1)(2j + 1)/4n). The field is contiguous along its last axis.
    """
    target = field if into is None else into
    if ducc0 is not None:
        ducc0.fft.dct(field, axes=axes, type=kind, out=target)
        return target
    import scipy.fft

    result = scipy.fft.dctn(field, type=kind, axes=axes, overwrite_x=target is field)
    # It may have been computed in the memory of the field.
    if not np.may_share_memory(result, target):
        target[...] = result
    return target


def dst(kind: int, field: Array, axes: tuple[int, ...], into: Array | None = None) -> Array:
    """Discrete sine transform of a field along some axes, I to IV, with the factors of `dct`.

    It needs new memory or a given buffer, which may be the field.
    """
    if ducc0 is not None:
        result: Array = ducc0.fft.dst(field, axes=axes, type=kind, out=into)
        return result
    import scipy.fft

    result = np.asarray(scipy.fft.dstn(field, type=kind, axes=axes))
    if into is None:
        return result
    into[...] = result
    return into
