"""Stresses of an elastic half-space under pressure and shear traction on equal cells.

On the plane y = 0 they are convolutions along x, by Fourier transforms padded with zeros, of the
rows of cells; at points they are sums over cells.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from fretwear.arrays import Array, Even
from fretwear_cracks.influence import ODD, TURNED, of_rectangles, of_strips

# Corners of cells, seen from points, of which functions are computed at a time.
_AT_A_TIME = 2**16


@dataclass(frozen=True)
class Tractions:
    """Fields of pressure and of shear traction, whose stresses may be superposed.

    They act on equal cells around the origin, or on the positive side alone along axes along
    which all fields are even, and shear along y odd. In a line contact the cells are strips, and ny
    is 1.
    """

    pressure: Array  #: Pa, shape (m, nx, ny)
    shear: Array  #: along x, Pa, shape (k, nx, ny)
    spacing: tuple[float, float]  #: cell size along x and y, m
    even: Even  #: whether fields are even along x and along y
    poisson_ratio: float  #: of the half-space
    plane_strain: bool = False  #: whether cells are strips along y
    across: Array | None = None  #: shear along y, Pa, shape (k, nx, ny), part of the shear traction

    @cached_property
    def x(self) -> Array:
        """Centres of the cells along x, m, on both sides."""
        half = self._half[0]
        return np.asarray((np.arange(-half, half) + 0.5) * self.spacing[0])

    @cached_property
    def _half(self) -> tuple[int, int]:
        """Number of cells along x and y on the positive side."""
        nx, ny = self.pressure.shape[1:]
        return nx if self.even[0] else nx // 2, ny if self.even[1] or self.plane_strain else ny // 2

    @cached_property
    def _length(self) -> int:
        """Cells along x with the zeros beside them."""
        return int(next_fast_len(4 * self._half[0], real=True))

    def section(self, depth: float) -> tuple[Array, Array]:
        """Stresses at one depth, m, on the plane y = 0, at the positions `x`.

        Two arrays, Pa, in the order of `COMPONENTS`: by each pressure, shape (m, 6, nx), and by
        each shear traction, shape (k, 6, nx).
        """
        count = 2 * self._half[0]
        x = (np.arange(count + 1.0) - 0.5)[:, None] * self.spacing[0]
        if self.plane_strain:
            kernels = of_strips(x, depth, self.poisson_ratio)
        else:
            y = np.arange(self._half[1] + 1.0) * self.spacing[1]
            kernels = self._of_kinds(of_rectangles, x, y, depth)
        stresses = []
        for kernel, parity, rows in zip(kernels, ODD, self._rows, strict=False):
            signs = np.array([-1.0 if odd_x else 1.0 for odd_x, _ in parity])
            behind = signs[:, None, None] * kernel[:, :0:-1]
            between = np.zeros((6, self._length - 2 * count + 1, kernel.shape[2]))
            spectrum = rfft(np.concatenate([kernel, between, behind], axis=1), axis=1)
            stress = np.empty((rows[0].shape[1], 6, count))
            for is_odd, fields in enumerate(rows):
                some = [component for component, (_, odd_y) in enumerate(parity) if odd_y == is_odd]
                product = fields @ np.moveaxis(spectrum[some], 0, -1)
                summed = irfft(product, self._length, axis=0)[:count]
                stress[:, some] = np.moveaxis(summed, 0, -1)
            stresses.append(stress)
        return _summed(stresses)

    @cached_property
    def _rows(self) -> list[tuple[Array, Array]]:
        """Spectra along x of the rows of cells, for each kind, shape (frequencies, k, rows).

        Rows at −y and y are added for components that are even along y, subtracted for odd ones.
        """
        rows = []
        for number, fields in enumerate(self._kinds):
            whole = rfft(self.on_both_sides(fields, odd=number > 1), self._length, axis=1)
            whole = np.moveaxis(whole, 1, 0)
            if self.plane_strain:
                rows.append((whole, 0.0 * whole))
            else:
                behind, ahead = np.split(whole, 2, axis=2)
                behind = np.flip(behind, axis=2)
                rows.append((behind + ahead, behind - ahead))
        return rows

    def at(self, points: Array) -> tuple[Array, Array]:
        """Stresses at points (x, y, z), m, shape (n, 3), by the sum over all loaded cells.

        Two arrays, Pa: by each pressure, shape (m, 6, n), and by each shear traction, (k, 6, n).
        """
        kinds = [self.on_both_sides(fields, odd=n > 1) for n, fields in enumerate(self._kinds)]
        stresses = [np.zeros((len(fields), 6, len(points))) for fields in kinds]
        loaded = np.any([fields.any(axis=0) for fields in kinds], axis=0)
        if not loaded.any():
            return _summed(stresses)
        box = tuple(slice(indices.min(), indices.max() + 1) for indices in np.nonzero(loaded))
        columns = [fields[:, *box].reshape(len(fields), -1).T for fields in kinds]
        x, y = (
            (np.arange(part.start, part.stop + 1.0) - half) * step
            for part, half, step in zip(box, self._half, self.spacing, strict=True)
        )
        at_once = max(1, _AT_A_TIME // (x.size * y.size))
        for first in range(0, len(points), at_once):
            some = slice(first, first + at_once)
            px, py, pz = points[some].T[..., None, None]
            # Seen from a point, corners lie in the opposite order.
            if self.plane_strain:
                kernels = -of_strips(px - x[:, None], pz, self.poisson_ratio)
            else:
                kernels = self._of_kinds(of_rectangles, px - x[:, None], py - y, pz)
            for stress, column, kernel in zip(stresses, columns, kernels, strict=True):
                summed = kernel.reshape(6, px.size, -1) @ column
                stress[..., some] = np.moveaxis(summed, -1, 0)
        return _summed(stresses)

    def on_both_sides(self, fields: Array, *, odd: bool = False) -> Array:
        """Fields on all cells, from those on the positive sides; odd ones change sign."""
        for axis in (0, 1):
            if self.even[axis] and not (axis == 1 and self.plane_strain):
                flipped = np.flip(fields, axis + 1)
                fields = np.concatenate([-flipped if odd else flipped, fields], axis + 1)
        return fields

    # The kinds of tractions: pressure, shear along x and, if there is any, shear along y.

    @property
    def _kinds(self) -> tuple[Array, ...]:
        kinds = self.pressure, self.shear
        return kinds if self.across is None else (*kinds, self.across)

    def _of_kinds(
        self, of_cells: Callable[..., Array], x: Array, y: Array, depth: Array | float
    ) -> Array:
        """Kernels of the kinds, shape (kinds, 6, ...); x and y are exchanged for shear along y."""
        kernels = of_cells(x, y, depth, self.poisson_ratio)
        if self.across is None:
            return kernels
        y_first = np.swapaxes(np.atleast_2d(y), -1, -2), np.swapaxes(x, -1, -2)
        turned = np.swapaxes(of_cells(*y_first, depth, self.poisson_ratio)[1], -1, -2)
        return np.concatenate([kernels, turned[None, [*TURNED]]])


def _summed(stresses: Sequence[Array]) -> tuple[Array, Array]:
    """Stresses of pressure, and of shear along both axes together."""
    return stresses[0], sum(stresses[2:], stresses[1])
