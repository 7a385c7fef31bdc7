"""The elastic bodies under shear tractions on a grid: displacements along x and y.

A traction q on both bodies, in opposite directions, moves their surfaces past each other by
(Cerruti; Johnson 1985, section 3.6)

    u_x = 1/(πE*) ∬ [1/r + n x²/r³] q_x + n xy/r³ q_y,    u_y likewise,    n = 2 (κ − 1),

for κ = E*/G*. On average over all directions that is κ times the normal displacement under a
pressure, the kernel of a single direction. The integrals over a rectangular cell are differences of
x arsinh(y/|x|) for y²/r³, of y arsinh(x/|y|) for x²/r³ and of −r for xy/r³ at its corners; 1/r is
the sum of the first two.

As for pressure (`fretwear.mechanics.convolution`), frequencies fall into two branches along each
axis. Where the contact is even, q_x is even and q_y odd along that axis: if it is along both,
cosine and sine transforms of a quarter do. Otherwise, q_x + i q_y is one complex field on the whole
window.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import cached_property
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fretwear.arrays import Array
from fretwear.mechanics.convolution import dct, dst, offsets

if TYPE_CHECKING:
    from fretwear.mechanics.geometry.grid import Grid

Complex = NDArray[np.complex128]
Branch = tuple[int, int]
# Kernels of x on x, of y on y, and of either on the other.
Kernels = tuple[Array, Array, Array]

_BRANCHES: tuple[Branch, ...] = tuple(product((0, 1), (0, 1)))


def shear_influence(
    shape: tuple[int, int], spacing: tuple[float, float], modulus: float, coupling: float
) -> Kernels:
    """Displacements of cell (i, j) along x and y per unit traction on cell (0, 0), m/Pa.

    Three fields (nx, ny): of u_x by q_x, of u_y by q_y, both even along both axes, and of either by
    the other, odd along both. ``modulus`` is E*, Pa, and ``coupling`` κ.
    """
    x, y = (
        ((np.arange(count + 1) - 0.5) * size)[(None, slice(None))[:: 1 if axis else -1]]
        for axis, (count, size) in enumerate(zip(shape, spacing, strict=True))
    )
    mixing = 2.0 * (coupling - 1.0)
    corners = x * np.arcsinh(y / np.abs(x)), y * np.arcsinh(x / np.abs(y)), -np.hypot(x, y)
    across, along, cross = (
        np.diff(np.diff(corner, axis=0), axis=1) / (np.pi * modulus) for corner in corners
    )
    return across + (1.0 + mixing) * along, (1.0 + mixing) * across + along, mixing * cross


class ShearSpace(ABC):
    """The elastic bodies under a traction that is uniform on each cell of a window.

    A traction, Pa, and a displacement, m, have shape (2, nx, ny): along x and along y.
    """

    def __init__(self, geometry: Grid, modulus: float, coupling: float) -> None:
        self.geometry = geometry
        shape = offsets(geometry.shape, geometry.even)
        influence = shear_influence(shape, geometry.spacing, modulus, coupling)
        self.self_influence = float(influence[0][0, 0])
        even = [dct(1, field, (0, 1)) for field in influence[:2]]
        # The transform of a field that is odd is the negative of that of sines.
        odd = np.zeros_like(even[0])
        odd[1:-1, 1:-1] = dst(1, np.ascontiguousarray(influence[2][1:-1, 1:-1]), (0, 1))
        self._spectra: Kernels = even[0], even[1], odd

    @abstractmethod
    def displacement(self, traction: Array) -> Array:
        """Relative displacement of the surfaces, m, under a traction, Pa."""

    @abstractmethod
    def inverse(self) -> Callable[[Array], Array]:
        """Approximate inverse of `displacement`, symmetric and positive definite.

        A quarter of the cost of a displacement, as the window is not padded.
        """


def _inverted(kernels: Kernels) -> Kernels:
    """The inverse of a field of symmetric matrices of two rows."""
    along, across, cross = kernels
    determinant = along * across - cross**2
    return across / determinant, along / determinant, -cross / determinant


class QuarterShear(ShearSpace):
    """Cosine transforms of q_x and sine transforms of q_y, of a contact even along both axes."""

    @cached_property
    def _factors(self) -> dict[Branch, Kernels]:
        """Spectra of each branch at the frequencies of cosines, of sines, and of both."""
        nx, ny = self.geometry.shape
        scale = 16 * nx * ny
        result = {}
        for branch in _BRANCHES:
            along, across, cross = (
                field[branch[0] :: 2, branch[1] :: 2] / scale for field in self._spectra
            )
            cosine, sine = _places(branch, (nx, ny))
            both = tuple(slice(0 if odd else 1, n) for odd, n in zip(branch, (nx, ny), strict=True))
            result[branch] = (
                np.ascontiguousarray(along[cosine]),
                np.ascontiguousarray(across[sine]),
                np.ascontiguousarray(cross[both]),
            )
        return result

    def displacement(self, traction: Array) -> Array:
        """Relative displacement of the surfaces, m, under a traction, Pa."""
        result = np.zeros_like(traction)
        for branch in _BRANCHES:
            result += self._filtered(traction, branch, self._factors[branch])
        return result

    def inverse(self) -> Callable[[Array], Array]:
        """Approximate inverse by the branch of the window without padding."""
        nx, ny = self.geometry.shape
        kernels = tuple(field[::2, ::2] for field in self._spectra)
        scale = 4 * nx * ny
        along, across, cross = kernels
        cosine, sine = _places((0, 0), (nx, ny))
        both = slice(1, nx), slice(1, ny)
        of_both = _inverted((along[both], across[both], cross[both]))
        # Frequencies that only one of the components has: zero, or the largest.
        inverses = [np.array(1.0 / along[cosine]), np.array(1.0 / across[sine])]
        inverses[0][1:, 1:], inverses[1][:-1, :-1] = of_both[:2]
        factors = (inverses[0] / scale, inverses[1] / scale, of_both[2] / scale)
        return lambda field: self._filtered(field, (0, 0), factors)

    @staticmethod
    def _filtered(field: Array, branch: Branch, kernels: Kernels) -> Array:
        along, across, cross = kernels
        result = np.empty_like(field)
        first, second = result
        first[...], second[...] = field
        for axis, odd in enumerate(branch):
            dct(4 if odd else 2, first, (axis,))
            dst(4 if odd else 2, second, (axis,), into=second)
        # Sines begin with the frequency one, cosines with zero.
        cosines = tuple(slice(None) if odd else slice(1, None) for odd in branch)
        sines = tuple(slice(None) if odd else slice(None, -1) for odd in branch)
        of_second = cross * second[sines]
        second *= across
        second[sines] += cross * first[cosines]
        first *= along
        first[cosines] += of_second
        for axis, odd in enumerate(branch):
            dct(4 if odd else 3, first, (axis,))
            dst(4 if odd else 3, second, (axis,), into=second)
        return result


def _places(branch: Branch, shape: tuple[int, int]) -> tuple[tuple[slice, ...], tuple[slice, ...]]:
    """Places of the frequencies of cosines and of sines in the spectrum of a branch."""
    cosine = tuple(slice(0, n) for n in shape)
    sine = tuple(
        slice(0, n) if odd else slice(1, n + 1) for odd, n in zip(branch, shape, strict=True)
    )
    return cosine, sine


class WholeShear(ShearSpace):
    """Complex transforms of q_x + i q_y on all cells, mirrored where they are even.

    With Z its transform and Z' the conjugate of that at the opposite frequency, u_x + i u_y has the
    transform M Z + D Z' for M = (K_xx + K_yy)/2 and D = (K_xx − K_yy)/2 + i K_xy.
    """

    @cached_property
    def _whole(self) -> tuple[int, int]:
        nx, ny = (
            2 * n if even else n
            for n, even in zip(self.geometry.shape, self.geometry.even, strict=True)
        )
        return nx, ny

    def _spectrum(self, field: Array, branch: Branch, *, is_odd: bool) -> Array:
        """The spectrum at all frequencies of a branch, negative ones last."""
        for axis, (odd, n) in enumerate(zip(branch, self._whole, strict=True)):
            frequency = 2 * np.arange(n) + odd
            folded = np.minimum(frequency, 2 * n - frequency)
            signs = np.where(is_odd & (frequency > n), -1.0, 1.0)
            field = field.take(folded, axis) * np.expand_dims(signs, 1 - axis)
        return field

    def _mean_and_difference(self, kernels: Kernels) -> tuple[Array, Complex]:
        along, across, cross = kernels
        return 0.5 * (along + across), 0.5 * (along - across) + 1j * cross

    def _kernels(self, branch: Branch) -> Kernels:
        along, across, cross = self._spectra
        return (
            self._spectrum(along, branch, is_odd=False),
            self._spectrum(across, branch, is_odd=False),
            -self._spectrum(cross, branch, is_odd=True),
        )

    @cached_property
    def _factors(self) -> dict[Branch, tuple[Array, Complex]]:
        return {
            branch: self._mean_and_difference(
                tuple(0.25 * field for field in self._kernels(branch))  # type: ignore[arg-type]
            )
            for branch in _BRANCHES
        }

    @cached_property
    def _waves(self) -> dict[Branch, Complex | None]:
        """The waves that shift frequencies by half a step, by branch."""
        nx, ny = self._whole
        along, across = (np.exp(1j * np.pi * np.arange(n) / n) for n in (nx, ny))
        one_x, one_y = np.ones(nx), np.ones(ny)
        waves: dict[Branch, Complex | None] = {(0, 0): None}
        waves |= {
            (x, y): np.multiply.outer(along if x else one_x, across if y else one_y)
            for x, y in _BRANCHES[1:]
        }
        return waves

    def displacement(self, traction: Array) -> Array:
        """Relative displacement of the surfaces, m, under a traction, Pa."""
        field = self._packed(traction)
        result = np.zeros_like(field)
        for branch in _BRANCHES:
            result += self._filtered(field, branch, self._factors[branch])
        return self._unpacked(result)

    def inverse(self) -> Callable[[Array], Array]:
        """Approximate inverse by the branch of the window without padding."""
        # At the frequency between the positive and the negative ones, a field that is odd vanishes.
        factors = self._mean_and_difference(_inverted(self._kernels((0, 0))))
        return lambda field: self._unpacked(self._filtered(self._packed(field), (0, 0), factors))

    def _packed(self, field: Array) -> Complex:
        first, second = field
        for axis, even in enumerate(self.geometry.even):
            if even:
                first = np.concatenate([np.flip(first, axis), first], axis)
                second = np.concatenate([-np.flip(second, axis), second], axis)
        return np.asarray(first + 1j * second)

    def _unpacked(self, field: Complex) -> Array:
        start = (
            n // 2 if even else 0 for n, even in zip(self._whole, self.geometry.even, strict=True)
        )
        part = field[tuple(slice(first, None) for first in start)]
        return np.stack([part.real, part.imag])

    def _filtered(self, field: Complex, branch: Branch, factors: tuple[Array, Complex]) -> Complex:
        import scipy.fft

        wave, (mean, difference) = self._waves[branch], factors
        field = field if wave is None else field * wave.conj()
        waves = scipy.fft.fft2(field, overwrite_x=wave is not None)
        opposite = waves.conj()
        for axis, odd in enumerate(branch):
            opposite = np.flip(opposite, axis)
            if not odd:
                opposite = np.roll(opposite, 1, axis)
        waves *= mean
        waves += difference * opposite
        result: Complex = scipy.fft.ifft2(waves, overwrite_x=True)
        if wave is not None:
            result *= wave
        return result


def shear_space(geometry: Grid, modulus: float, coupling: float) -> ShearSpace:
    """The bodies on a window, by the transforms that its symmetry allows."""
    kind = QuarterShear if all(geometry.even) else WholeShear
    return kind(geometry, modulus, coupling)
