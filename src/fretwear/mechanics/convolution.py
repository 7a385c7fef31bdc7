"""Free-space convolution of a field on a window with a kernel that is even along x and y.

Zero padding makes a discrete convolution exact: free space, no periodic images. Its frequencies
fall into two branches, neither of which needs the zeros: the even ones are those of the window
repeated periodically, the odd ones those of the window repeated with alternating sign. Half as
long and without the zeros, both together take less time, and for the two branches of two axes the
spectra of the kernel are fields of the window's size.

Along an axis in which the field is even, only the half with positive coordinates is kept, and the
transforms are cosine transforms: DCT-II for the even branch, DCT-IV for the odd one. Along an axis
without symmetry the even branch is a Hartley transform, cas θ = cos θ − sin θ, which is real as
they are; for the odd one the field is split into its even and odd halves, and the DCT-IV of each is
taken, of the odd half in reverse order, which turns sines into cosines up to a sign that the
inverse undoes. A cell of a whole window thus costs as much as one of a quarter.

Where neither axis is even, the compiled library does all of it if there is one: by complex
transforms of the same two branches, of lines that hold a frequency along x.

Other transforms are made by ducc0 where it is installed, which is up to twice as fast here, else by
scipy.fft; both give the same to rounding. None is normalized: a transform and its inverse (III
undoes II, IV and Hartley's undo themselves) together multiply by twice the number of cells on the
positive side.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import pairwise
from typing import Any, Generic

import numpy as np

from fretwear.mechanics.geometry import Array, Even, Index, Real, Single
from fretwear.mechanics.team import ALONE, Team, blocks_of_rows, library

try:
    import ducc0
except ImportError:
    ducc0 = None

_BLOCK_BYTES = 2**20
# Threads take columns by whole vectors of the transforms, in so many parts for each of them.
_COLUMNS = 16
_PARTS = 4


@dataclass(frozen=True)
class _Axis:
    """The transforms along one axis of a window."""

    number: int
    is_even: bool

    def forward(self, field: Real, into: Real | None = None) -> None:
        """The even branch, in place if no buffer is given."""
        if self.is_even:
            dct(2, field, (self.number,), into=into)
        else:
            hartley(field, self.number, into=into)

    def backward(self, field: Real) -> None:
        """The inverse of `forward`, in place."""
        if self.is_even:
            dct(3, field, (self.number,))
        else:
            hartley(field, self.number)

    def odd_forward(self, field: Real, into: Real) -> None:
        """The odd branch: of the odd half in reverse order, then of the even half."""
        if self.is_even:
            dct(4, field, (self.number,), into=into)
            return
        (down, up), (odd, even) = self._halves(field), self._halves(into)
        reverse = self._reversed
        np.add(up, down[reverse], out=even)
        np.subtract(up[reverse], down, out=odd)
        self._odd_transform(into)

    def add_odd_backward(self, odd_branch: Real, field: Real) -> None:
        """Add the inverse of `odd_forward`, whose argument is overwritten, to a field."""
        self._odd_transform(odd_branch)
        if self.is_even:
            field += odd_branch
            return
        (down, up), (odd, even) = self._halves(field), self._halves(odd_branch)
        reverse = self._reversed
        up += even
        up += odd[reverse]
        down += even[reverse]
        down -= odd

    def _odd_transform(self, field: Real) -> None:
        if self.is_even:
            dct(4, field, (self.number,))
        elif self.number == 0:
            for half in self._halves(field):
                dct(4, half, (0,))
        else:
            dct(4, field.reshape(len(field), 2, -1), (2,))

    @property
    def _reversed(self) -> tuple[slice, ...]:
        return (*[slice(None)] * self.number, slice(None, None, -1))

    def _halves(self, field: Real) -> tuple[Real, Real]:
        half = field.shape[self.number] // 2
        if self.number == 0:
            return field[:half], field[half:]
        return field[:, :half], field[:, half:]


class Convolution(Generic[Real]):
    """Convolution of fields on a window with one kernel, in double or in single precision.

    Parameters
    ----------
    spectra
        Of the kernel, by branch of the frequency along x and along y, divided by the factor of the
        transforms of a convolution. Along x they are those of a half, with one more for the even
        branch if the field is not even; along y in the order of the branch.
    even
        Whether fields are even along x and along y.
    team
        Threads that share the work.
    """

    def __init__(self, spectra: Sequence[Sequence[Real]], even: Even, team: Team) -> None:
        self._spectra: Sequence[Sequence[Real]] = spectra
        self._precision: np.dtype[Any] = spectra[0][0].dtype
        self._half, columns = spectra[1][0].shape
        self._shape = (self._half if even[0] else 2 * self._half), columns
        self._even, self.team = even, team.for_cells(self._shape[0] * columns)
        self._x, self._y = _Axis(0, even[0]), _Axis(1, even[1])

    @staticmethod
    def offsets(shape: tuple[int, int], even: Even) -> tuple[int, int]:
        """Number of offsets along x and y at which the kernel is needed on a window."""
        nx, ny = (2 * n if is_even else n for n, is_even in zip(shape, even, strict=True))
        return nx + 1, ny + 1

    @staticmethod
    def with_kernel(kernel: Array, even: Even, team: Team = ALONE) -> Convolution[Array]:
        """Convolution with a kernel given at the `offsets` of a window, which is overwritten."""
        spectrum = dct(1, kernel, (0, 1), workers=team.workers)
        # What two transforms along each of the axes of the padded window leave.
        spectrum /= 4 * (kernel.shape[0] - 1) * (kernel.shape[1] - 1)
        # A length that is a product of 2, 3 and 5 divides a power of 30.
        is_fast = not any(pow(30, 64, offsets - 1) for offsets in kernel.shape)
        if is_fast and not any(even) and hasattr(library, "SingleWindow"):
            return WholeConvolution([spectrum[x::2, y::2] for x in (0, 1) for y in (0, 1)], team)
        rows = [spectrum[: -1 if even[0] else None : 2], spectrum[1::2]]
        if not even[0]:
            rows[1] = 0.5 * rows[1]
        return Convolution(
            team.each(lambda each: list(_by_branch(each, even[1])), rows), even, team
        )

    def in_single(self, unit: float) -> Convolution[Single]:
        """The same in single precision, with the kernel in some unit."""
        spectra = [
            [self.team.cellwise(np.divide, field, unit, dtype=np.float32) for field in row]
            for row in self._spectra
        ]
        return Convolution(spectra, self._even, self.team)

    def __call__(self, field: Real) -> Real:
        """The convolution of a field, which is not changed."""
        result, odd = np.empty_like(field), self._odd

        def forward(columns: Index) -> None:
            self._x.odd_forward(field[columns], odd[columns])
            self._x.forward(field[columns], into=result[columns])

        def backward(columns: Index) -> None:
            self._x.backward(result[columns])
            self._x.add_odd_backward(odd[columns], result[columns])

        views = [self._row_views(branch) for branch in (result, odd)]
        tasks = [
            (views[branch][view][block], even, uneven)
            for branch, view, block, even, uneven in self._tasks
        ]
        self.team.each(forward, self._columns)
        self.team.each(self._convolve_rows, tasks)
        self.team.each(backward, self._columns)
        return result

    def _convolve_rows(self, task: tuple[Real, Real, Real]) -> None:
        """Multiply rows by spectra of the even and the odd branch along y, in place."""
        field, even, odd = task
        room = self._rooms.pop()
        between = room[: len(field)]
        self._y.odd_forward(field, between)
        between *= odd
        self._y.forward(field)
        field *= even
        self._y.backward(field)
        self._y.add_odd_backward(between, field)
        self._rooms.append(room)

    def _row_views(self, field: Real) -> list[Real]:
        return [field] if self._even[0] else [field[: self._half], field[self._half :]]

    def _of_rows(self, spectrum: Real, is_odd: bool) -> list[Real]:
        """The parts of a spectrum that belong to `_row_views` of a branch."""
        if self._even[0]:
            return [spectrum]
        # Frequencies of a Hartley transform rise to the middle and fall again.
        return [spectrum[: self._half], spectrum if is_odd else spectrum[self._half : 0 : -1]]

    # Memory that was used a moment ago is faster than new memory, and so are blocks of rows that
    # the processor's cache holds.

    @cached_property
    def _odd(self) -> Real:
        return np.empty(self._shape, self._precision)

    @cached_property
    def _columns(self) -> list[Index]:
        """The columns in parts for the threads, since transforms along x are independent."""
        parts, count = 1 if self.team.workers == 1 else _PARTS * self.team.workers, self._shape[1]
        ends: list[int] = [count * part // parts // _COLUMNS * _COLUMNS for part in range(parts)]
        return [
            (slice(None), slice(first, last))
            for first, last in pairwise([*ends, count])
            if first < last
        ]

    @cached_property
    def _rooms(self) -> list[Real]:
        """Buffers for a block of rows, for each thread."""
        shape = self._blocks[0].stop, self._shape[1]
        return [np.empty(shape, self._precision) for _ in range(self.team.workers)]

    @property
    def _blocks(self) -> tuple[slice, ...]:
        shape = self._half, self._shape[1]
        return blocks_of_rows(shape, _BLOCK_BYTES // self._precision.itemsize)

    @cached_property
    def _tasks(self) -> list[tuple[int, int, slice, Real, Real]]:
        """Branch along x, view, block of rows, and its two spectra."""
        return [
            (branch, view, block, even[block], odd[block])
            for branch, spectra in enumerate(self._spectra)
            for view, (even, odd) in enumerate(
                zip(*(self._of_rows(each, bool(branch)) for each in spectra), strict=True)
            )
            for block in self._blocks
        ]

    def inverse(self, added: float = 0.0) -> Callable[[Real], Real]:
        """Approximate inverse of the convolution plus a multiple of the field, not negative.

        Returns
        -------
        A function of a field: symmetric, positive definite, a quarter of the cost of a
        convolution, as the window is not padded. It may put the result into its argument.
        """
        cells = self._half * (self._shape[1] // (1 if self._even[1] else 2))
        # The even frequencies are those of the window without padding.
        result = self.team.cellwise(
            lambda spectrum: 0.25 / cells / (16 * cells * spectrum + added),
            self._spectra[0][0],
            dtype=self._precision.type,
        )
        return partial(self._divided, self._of_rows(result, False))

    def _divided(self, inverse_spectrum: Sequence[Real], field: Real) -> Real:
        """Periodic convolution with the field of a spectrum, on the window without padding."""
        tasks = [
            (rows[block], spectrum[block])
            for rows, spectrum in zip(self._row_views(field), inverse_spectrum, strict=True)
            for block in self._blocks
        ]
        self.team.each(lambda columns: self._x.forward(field[columns]), self._columns)
        self.team.each(self._divide_rows, tasks)
        self.team.each(lambda columns: self._x.backward(field[columns]), self._columns)
        return field

    def _divide_rows(self, task: tuple[Real, Real]) -> None:
        rows, spectrum = task
        self._y.forward(rows)
        rows *= spectrum
        self._y.backward(rows)


class WholeConvolution(Convolution[Real]):
    """The same by the compiled library, which shares all of it, where a field is not even at all.

    Parameters
    ----------
    spectra
        Of the kernel, by branch of the frequency along x and along y: for half of the frequencies
        along both axes, divided by the number of cells of the padded window.
    """

    def __init__(self, spectra: Sequence[Real], team: Team) -> None:
        self._precision = spectra[0].dtype
        self._shape = rows, columns = 2 * len(spectra[-1]), 2 * spectra[-1].shape[1]
        self.team, self._given = team.for_cells(rows * columns), tuple[Any, ...](spectra)
        kind = library.SingleWindow if self._precision == np.float32 else library.DoubleWindow
        self._window = kind(rows, columns)
        # Forth and back, a field is doubled.
        self._factors: list[Any] = team.each(
            lambda each: _by_lanes(0.5 * each, kind.lanes), spectra
        )

    def in_single(self, unit: float) -> Convolution[Single]:
        """The same in single precision, with the kernel in some unit."""
        single = self.team.each(lambda each: (each / unit).astype(np.float32), self._given)
        return WholeConvolution(single, self.team)

    def __call__(self, field: Real) -> Real:
        """The convolution of a field, which is not changed."""
        result = np.empty_like(field)
        self._window.convolve(self.team.threads, field, self._factors, result)
        return result

    def inverse(self, added: float = 0.0) -> Callable[[Real], Real]:
        """That of `Convolution`."""
        cells = self._shape[0] * self._shape[1]
        factor = 0.5 / cells / (8 * cells * self._factors[0] + self._precision.type(added))

        def divided(field: Real) -> Real:
            self._window.convolve(self.team.threads, field, [factor], field)
            return field

        return divided


def _by_lanes(spectrum: Real, lanes: int) -> Real:
    """The rows of a spectrum as lanes of vectors."""
    more = -len(spectrum) % lanes
    padded = np.pad(spectrum, ((0, more), (0, 0)), mode="edge")
    blocks = padded.reshape(-1, lanes, spectrum.shape[1]).swapaxes(1, 2)
    return np.ascontiguousarray(blocks).reshape(-1, lanes)


def _by_branch(spectrum: Array, is_even: bool) -> Iterator[Array]:
    """The columns of a spectrum by branch, each in the order of the transforms along y."""
    even, odd = spectrum[:, ::2], spectrum[:, 1::2]
    if is_even:
        yield np.ascontiguousarray(even[:, :-1])
        yield np.ascontiguousarray(odd)
    else:
        yield np.concatenate([even[:, :-1], even[:, :0:-1]], axis=1)
        yield 0.5 * np.concatenate([odd, odd], axis=1)


def dct(
    kind: int, field: Real, axes: tuple[int, ...], into: Real | None = None, workers: int = 1
) -> Real:
    """Discrete cosine transform of a field.

    I is f₀ + (−1)ᵏ fₙ + 2 ∑ fⱼ cos(πjk/n) with the sum over 0 < j < n, II is
    2 ∑ fⱼ cos(πk(2j + 1)/2n), III is f₀ + 2 ∑ fₖ cos(πk(2j + 1)/2n) with the sum over k > 0, IV is
    2 ∑ fⱼ cos(π(2k + 1)(2j + 1)/4n).

    Parameters
    ----------
    kind
        1, 2, 3 or 4.
    field
        Contiguous along its last axis.
    axes
        Axes to transform.
    into
        Buffer for the result, of the field's shape; by default it replaces the field.
    workers
        Threads.

    Returns
    -------
    The result, in the memory of the field or in the given buffer.
    """
    target = field if into is None else into
    if ducc0 is not None:
        ducc0.fft.dct(field, axes=axes, type=kind, out=target, nthreads=workers)
        return target
    import scipy.fft

    result = scipy.fft.dctn(
        field, type=kind, axes=axes, overwrite_x=target is field, workers=workers
    )
    # It may have been computed in the memory of the field.
    if not np.may_share_memory(result, target):
        target[...] = result
    return target


def hartley(field: Real, axis: int, into: Real | None = None) -> Real:
    """Hartley transform of a field along an axis, ∑ fⱼ cas(2πjk/n) with cas θ = cos θ − sin θ.

    The result is in the memory of the field, or in the given buffer.
    """
    target = field if into is None else into
    if ducc0 is not None:
        ducc0.fft.separable_hartley(field, axes=(axis,), out=target)
        return target
    import scipy.fft

    spectrum = scipy.fft.fft(field, axis=axis)
    np.add(spectrum.real, spectrum.imag, out=target)
    return target
