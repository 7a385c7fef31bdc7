"""The elastic bodies under shear tractions on a grid: displacements along x and y.

A traction q on both bodies, in opposite directions, moves their surfaces past each other by
(Cerruti; Johnson 1985, section 3.6)

    u_x = 1/(πE*) ∬ [1/r + n x²/r³] q_x + n xy/r³ q_y,    u_y likewise,    n = 2 (κ − 1),

for κ = E*/G*. Averaged over all directions, this is κ times the normal displacement under a
pressure, a single kernel. The integrals over a rectangular cell are differences of x arsinh(y/|x|)
for y²/r³, of y arsinh(x/|y|) for x²/r³ and of −r for xy/r³ at its corners; 1/r is the sum of the
first two.

As for pressure (`fretwear.mechanics.contact.convolution`), frequencies fall into two branches along
each axis. Along an axis in which the contact is even, q_x is even and q_y odd; if it is even along
both, transforms of a quarter suffice. Otherwise, the whole window is padded with zeros.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from functools import cached_property, lru_cache
from itertools import product
from typing import Any, Generic, TypeAlias, cast

import numpy as np

from fretwear.arrays import Array, Real, Single
from fretwear.mechanics.contact.cells import HalfSpace
from fretwear.mechanics.contact.convolution import offsets
from fretwear.mechanics.contact.grid import Grid, GridHalfSpace
from fretwear.mechanics.contact.kernels import dct, dst, filtered

Branch = tuple[int, int]
# Spectra of the influence of x on x, of y on y, and of either on the other.
Spectra: TypeAlias = tuple[Real, Real, Real]

_BRANCHES: tuple[Branch, ...] = tuple(product((0, 1), (0, 1)))


def shear_influence(
    shape: tuple[int, int], spacing: tuple[float, float], modulus: float, coupling: float
) -> Spectra[Array]:
    """Displacements of cell (i, j) along x and y per unit traction on cell (0, 0), m/Pa.

    Three fields (nx, ny): u_x by q_x and u_y by q_y, both even along both axes, and u_x by q_y or
    u_y by q_x, odd along both. ``modulus`` is E*, Pa, and ``coupling`` κ.
    """
    x, y = (
        ((np.arange(count + 1) - 0.5) * size)[(None, slice(None))[:: 1 if axis else -1]]
        for axis, (count, size) in enumerate(zip(shape, spacing, strict=True))
    )
    mixing = 2.0 * (coupling - 1.0)
    corners = x * np.arcsinh(y / np.abs(x)), y * np.arcsinh(x / np.abs(y)), -np.hypot(x, y)
    across, second, cross = (
        np.diff(np.diff(corner, axis=0), axis=1) / (np.pi * modulus) for corner in corners
    )
    return across + (1.0 + mixing) * second, (1.0 + mixing) * across + second, mixing * cross


class GridShear(ABC, Generic[Real]):
    """The elastic bodies under a traction that is uniform on each cell of a window.

    A traction, Pa, and a displacement, m, have shape (2, nx, ny): along x and along y. Spectra are
    transforms of the `shear_influence`.
    """

    def __init__(self, geometry: Grid, moduli: tuple[float, float], spectra: Spectra[Real]) -> None:
        self.geometry: Grid = geometry
        self._moduli = moduli
        #: Whether tractions are even along an axis, so that forces along y balance.
        self.is_even = any(geometry.even)
        self._spectra: Spectra[Real] = spectra
        #: Displacement of a cell along x by a traction along x on it alone, m/Pa.
        self.self_influence = float(shear_influence((1, 1), geometry.spacing, *moduli)[0][0, 0])

    @abstractmethod
    def displacement(self, traction: Real) -> Real:
        """Relative displacement of the surfaces, m, under a traction, Pa."""

    @abstractmethod
    def inverse(self, traction: Real) -> Real:
        """Approximate inverse of `displacement`, symmetric and positive definite.

        It costs at most a quarter of a displacement.
        """

    @property
    def coarser(self) -> GridShear[Array] | None:
        """The bodies on cells twice as wide, if these are many."""
        grid = self.geometry.coarser
        return None if grid is None else shear_space(grid, *self._moduli)

    @cached_property
    def single(self) -> GridShear[Single]:
        """The same in single precision, for displacements in units of the self-influence."""
        xx, yy, xy = ((field / self.self_influence).astype(np.float32) for field in self._spectra)
        kind: Any = type(self)
        result: GridShear[Single] = kind(self.geometry, self._moduli, (xx, yy, xy))
        return result

    def _branch(self, branch: Branch) -> Spectra[Real]:
        """The spectra at the frequencies of a branch."""
        xx, yy, xy = (field[branch[0] :: 2, branch[1] :: 2] for field in self._spectra)
        return xx, yy, xy


def _scaled(spectra: Spectra[Real], divisor: int) -> Spectra[Real]:
    xx, yy, xy = (np.divide(f, divisor, dtype=f.dtype) for f in spectra)
    return xx, yy, xy


def _inverted(kernels: Spectra[Real]) -> Spectra[Real]:
    """The inverse of a field of symmetric two-by-two matrices."""
    xx, yy, xy = kernels
    determinant = xx * yy - xy**2
    return yy / determinant, xx / determinant, -xy / determinant


class QuarterShear(GridShear[Real]):
    """Cosine transforms of q_x and sine transforms of q_y, of a contact even along both axes.

    The sine transform II at the frequency k equals the cosine transform at n − k of the field with
    alternating signs, and IV likewise at n − 1 − k, so both components are transformed at once.
    """

    @cached_property
    def _signs(self) -> Real:
        nx, ny = self.geometry.shape
        signs = np.ones((2, nx, ny), self._spectra[0].dtype)
        signs[1, ::2, 1::2] = signs[1, 1::2, ::2] = -1.0
        return cast("Real", signs)

    @cached_property
    def _factors(self) -> dict[Branch, Spectra[Real]]:
        """Spectra of each branch at the frequencies of cosines, of sines, and of both."""
        nx, ny = self.geometry.shape
        result: dict[Branch, Spectra[Real]] = {}
        for branch in _BRANCHES:
            xx, yy, xy = _scaled(self._branch(branch), 16 * nx * ny)
            cosine, sine = _places(branch, (nx, ny))
            both = tuple(slice(0 if odd else 1, n) for odd, n in zip(branch, (nx, ny), strict=True))
            result[branch] = (
                np.ascontiguousarray(xx[cosine]),
                np.ascontiguousarray(yy[sine][::-1, ::-1]),
                np.ascontiguousarray(xy[both]),
            )
        return result

    def displacement(self, traction: Real) -> Real:
        """Relative displacement of the surfaces, m, under a traction, Pa."""
        field = traction * self._signs
        result = [self._moved(field, odd, (0, 1), self._factors) for odd in (0, 1)]
        result[0] += result[1]
        result[0] *= self._signs
        return result[0]

    @cached_property
    def _inverse(self) -> dict[Branch, Spectra[Real]]:
        """The inverse of these spectra in the branch of the window without padding."""
        nx, ny = self.geometry.shape
        xx, yy, xy = self._branch((0, 0))
        cosine, sine = _places((0, 0), (nx, ny))
        both = slice(1, nx), slice(1, ny)
        of_both = _inverted((xx[both], yy[both], xy[both]))
        # Frequencies of one component only: zero, or the largest.
        xx, yy = np.reciprocal(xx[cosine]), np.reciprocal(yy[sine])
        xx[1:, 1:], yy[:-1, :-1] = of_both[:2]
        yy = np.ascontiguousarray(yy[::-1, ::-1])
        return {(0, 0): _scaled((xx, yy, of_both[2]), 4 * nx * ny)}

    def inverse(self, traction: Real) -> Real:
        """Approximate inverse by the branch of the window without padding."""
        result = self._moved(traction * self._signs, 0, (0,), self._inverse)
        result *= self._signs
        return result

    @staticmethod
    def _moved(
        field: Real, odd: int, others: Sequence[int], factors: Mapping[Branch, Spectra[Real]]
    ) -> Real:
        """A field of alternating signs, filtered in one branch along x and some along y."""
        kinds, result = ((2, 3), (4, 4)), None
        of_x = dct(kinds[odd][0], field, (1,), buffer=np.empty_like(field))
        for odd_y in others:
            xx, yy, xy = factors[odd, odd_y]
            waves = dct(kinds[odd_y][0], of_x, (2,), buffer=np.empty_like(field))
            # Sines, in reverse, begin with the frequency one, cosines with zero.
            first, second = waves[0], waves[1]
            both = second[::-1, ::-1]
            cosines = slice(1 - odd, None), slice(1 - odd_y, None)
            sines = slice(None, odd - 1 or None), slice(None, odd_y - 1 or None)
            of_second = xy * both[sines]
            second *= yy
            both[sines] += xy * first[cosines]
            first *= xx
            first[cosines] += of_second
            dct(kinds[odd_y][1], waves, (2,))
            result = waves if result is None else np.add(result, waves, out=result)
        assert result is not None
        return dct(kinds[odd][1], result, (1,))


def _places(branch: Branch, shape: tuple[int, int]) -> tuple[tuple[slice, ...], tuple[slice, ...]]:
    """Places of the frequencies of cosines and of sines in the spectrum of a branch."""
    cosine = tuple(slice(0, n) for n in shape)
    sine = tuple(
        slice(0, n) if odd else slice(1, n + 1) for odd, n in zip(branch, shape, strict=True)
    )
    return cosine, sine


class WholeShear(GridShear[Real]):
    """Fourier transforms of all cells, mirrored along the axes in which the contact is even."""

    @cached_property
    def _whole(self) -> tuple[int, int]:
        nx, ny = (
            2 * n if even else n
            for n, even in zip(self.geometry.shape, self.geometry.even, strict=True)
        )
        return nx, ny

    @cached_property
    def _factors(self) -> Spectra[Real]:
        """Spectra of the kernels on the padded window, as `filtered` takes them."""
        nx, ny = self._whole
        return _scaled(self._spectra, 4 * nx * ny)

    @cached_property
    def _inverse(self) -> Spectra[Real]:
        """The inverse of these spectra in the branch of the window without padding."""
        nx, ny = self._whole
        return _scaled(_inverted(self._branch((0, 0))), nx * ny)

    def displacement(self, traction: Real) -> Real:
        """Relative displacement of the surfaces, m, under a traction, Pa."""
        return self._filtered(traction, self._factors)

    def inverse(self, traction: Real) -> Real:
        """Approximate inverse by transforms of the window without padding."""
        return self._filtered(traction, self._inverse)

    def _filtered(self, field: Real, factors: Spectra[Real]) -> Real:
        for axis in 1 + np.flatnonzero(self.geometry.even):
            sign = np.array([1.0, -1.0], field.dtype)[:, None, None]
            field = np.concatenate([np.flip(field, int(axis)) * sign, field], axis)
        result = np.stack(filtered([*np.ascontiguousarray(field)], factors))
        x, y = (n - inner for n, inner in zip(self._whole, self.geometry.shape, strict=True))
        return np.ascontiguousarray(result[:, x:, y:])


def bodies_under_shear(half_space: HalfSpace, coupling: float) -> GridShear[Array]:
    """The bodies of a half-space under shear tractions, of κ = E*/G*; on grids only."""
    if not isinstance(half_space, GridHalfSpace):
        raise NotImplementedError("tractions along two directions are computed on grids only")
    return shear_space(half_space.geometry, half_space.modulus, coupling)


@lru_cache(2)
def shear_space(geometry: Grid, modulus: float, coupling: float) -> GridShear[Array]:
    """The bodies on a window, by the transforms that its symmetry allows."""
    shape = offsets(geometry.shape, geometry.even)
    influence = shear_influence(shape, geometry.spacing, modulus, coupling)
    even = [dct(1, field, (0, 1)) for field in influence[:2]]
    # The transform of a field odd along both axes is the negative of its sine transforms.
    odd = np.zeros_like(even[0])
    odd[1:-1, 1:-1] = dst(1, np.ascontiguousarray(influence[2][1:-1, 1:-1]), (0, 1))
    moduli, spectra = (modulus, coupling), (even[0], even[1], odd)
    if all(geometry.even):
        return QuarterShear(geometry, moduli, spectra)
    return WholeShear(geometry, moduli, spectra)
