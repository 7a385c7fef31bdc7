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
cosine and sine transforms of a quarter do. Otherwise, the whole window is padded with zeros.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from fretwear.arrays import Array
from fretwear.mechanics.convolution import dct, dst, offsets

if TYPE_CHECKING:
    from fretwear.mechanics.geometry.grid import Grid

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
        self.geometry, self._moduli = geometry, (modulus, coupling)
        shape = offsets(geometry.shape, geometry.even)
        influence = shear_influence(shape, geometry.spacing, modulus, coupling)
        self.self_influence = float(influence[0][0, 0])
        even = [dct(1, field, (0, 1)) for field in influence[:2]]
        # The transform of a field that is odd is the negative of the transform of sines.
        odd = np.zeros_like(even[0])
        odd[1:-1, 1:-1] = dst(1, np.ascontiguousarray(influence[2][1:-1, 1:-1]), (0, 1))
        self._spectra: Kernels = even[0], even[1], odd

    @property
    def coarser(self) -> ShearSpace:
        """The bodies on cells twice as wide, of an even number along each axis."""
        (nx, ny), (dx, dy) = self.geometry.shape, self.geometry.spacing
        geometry = replace(self.geometry, shape=(nx // 2, ny // 2), spacing=(2.0 * dx, 2.0 * dy))
        return shear_space(geometry, *self._moduli)

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
        for odd in (0, 1):
            along = _transformed(traction, odd, 0)
            across = np.zeros_like(traction)
            for other in (0, 1):
                branch = odd, other
                across += self._filtered(along, branch, self._factors[branch])
            result += _transformed(across, odd, 0, back=True)
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

        def invert(field: Array) -> Array:
            result = self._filtered(_transformed(field, 0, 0), (0, 0), factors)
            return _transformed(result, 0, 0, back=True)

        return invert

    @staticmethod
    def _filtered(field: Array, branch: Branch, kernels: Kernels) -> Array:
        """Filter a field that is transformed along x: transform it along y, and back."""
        along, across, cross = kernels
        first, second = result = _transformed(field, branch[1], 1)
        # Sines begin with the frequency one, cosines with zero.
        cosines = tuple(slice(None) if odd else slice(1, None) for odd in branch)
        sines = tuple(slice(None) if odd else slice(None, -1) for odd in branch)
        of_second = cross * second[sines]
        second *= across
        second[sines] += cross * first[cosines]
        first *= along
        first[cosines] += of_second
        return _transformed(result, branch[1], 1, back=True)


def _transformed(field: Array, odd: int, axis: int, *, back: bool = False) -> Array:
    """Transform q_x by cosines and q_y by sines along an axis, in one branch; or back, in place."""
    kind, result = 4 if odd else 3 if back else 2, field if back else np.empty_like(field)
    dct(kind, field[0], (axis,), into=result[0])
    dst(kind, field[1], (axis,), into=result[1])
    return result


def _places(branch: Branch, shape: tuple[int, int]) -> tuple[tuple[slice, ...], tuple[slice, ...]]:
    """Places of the frequencies of cosines and of sines in the spectrum of a branch."""
    cosine = tuple(slice(0, n) for n in shape)
    sine = tuple(
        slice(0, n) if odd else slice(1, n + 1) for odd, n in zip(branch, shape, strict=True)
    )
    return cosine, sine


class WholeShear(ShearSpace):
    """Fourier transforms of all cells with as many zeros, mirrored where they are even."""

    @cached_property
    def _whole(self) -> tuple[int, int]:
        nx, ny = (
            2 * n if even else n
            for n, even in zip(self.geometry.shape, self.geometry.even, strict=True)
        )
        return nx, ny

    def _kernels(self, step: int) -> Kernels:
        """Spectra at every frequency along x, and those along y that are not negative, or half."""
        nx, ny = self._whole
        along_x, along_y = np.arange(0, 2 * nx, step), np.arange(0, ny + 1, step)
        places = np.ix_(np.minimum(along_x, 2 * nx - along_x), along_y)
        along, across, cross = (field[places] for field in self._spectra)
        # An odd field has nothing at the largest frequency, which is its own opposite.
        cross *= np.where(along_x == nx, 0.0, np.sign(along_x - nx))[:, None] * (along_y < ny)
        return along, across, cross

    @cached_property
    def _factors(self) -> Kernels:
        return self._kernels(1)

    def displacement(self, traction: Array) -> Array:
        """Relative displacement of the surfaces, m, under a traction, Pa."""
        return self._filtered(traction, 2, self._factors)

    def inverse(self) -> Callable[[Array], Array]:
        """Approximate inverse by transforms of the window without padding."""
        factors = _inverted(self._kernels(2))
        return lambda field: self._filtered(field, 1, factors)

    def _filtered(self, field: Array, times: int, kernels: Kernels) -> Array:
        import scipy.fft

        (nx, ny), (along, across, cross) = self._whole, kernels
        for axis in 1 + np.flatnonzero(self.geometry.even):
            mirrored = np.flip(field, int(axis)) * np.array([1.0, -1.0])[:, None, None]
            field = np.concatenate([mirrored, field], axis)
        # Rows of zeros need no transforms.
        rows, columns = times * nx, times * ny
        waves = scipy.fft.rfft(field, columns, axis=2)
        first, second = waves = scipy.fft.fft(waves, rows, axis=1, overwrite_x=True)
        of_second = cross * second
        second *= across
        second += cross * first
        first *= along
        first += of_second
        waves = scipy.fft.ifft(waves, axis=1, overwrite_x=True)
        x, y = (n - inner for n, inner in zip(self._whole, self.geometry.shape, strict=True))
        result = scipy.fft.irfft(waves[:, x:nx], columns, axis=2, overwrite_x=True)
        return np.ascontiguousarray(result[:, :, y:ny])


def shear_space(geometry: Grid, modulus: float, coupling: float) -> ShearSpace:
    """The bodies on a window, by the transforms that its symmetry allows."""
    kind = QuarterShear if all(geometry.even) else WholeShear
    return kind(geometry, modulus, coupling)
