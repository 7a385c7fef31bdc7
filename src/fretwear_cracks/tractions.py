"""Stresses of an elastic half-space under pressure and shear traction on equal cells.

The stress of a cell is even or odd along x and along y, and so are parts of the tractions: a layer
of stresses is a convolution by cosine and sine transforms of one quarter, padded with zeros so that
it has no periodic images.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fretwear.arrays import Array
from fretwear.mechanics.contact.cells import Even
from fretwear.mechanics.contact.kernels import dct, dst
from fretwear_cracks.influence import ODD, TURNED, of_rectangles, of_strips

# Corners of cells, seen from points, of which functions are computed at a time.
_AT_A_TIME = 2**16

# Parts of fields along x and y, odd (1) or even (0), on the cells of the positive sides.
_Parts = dict[tuple[int, int], Array]


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
        return self._centres(0, both=True)

    @cached_property
    def y(self) -> Array:
        """Centres of the cells along y, m, of a layer: y > 0 of an even one, 0 of strips."""
        return np.zeros(1) if self.plane_strain else self._centres(1, both=not self.even[1])

    def _centres(self, axis: int, *, both: bool) -> Array:
        half = self._half[axis]
        cells = np.arange(-half if both else 0, half, dtype=np.float64)
        return (cells + 0.5) * self.spacing[axis]

    @cached_property
    def _half(self) -> tuple[int, int]:
        """Number of cells along x and y on the positive side."""
        nx, ny = self.pressure.shape[1:]
        return nx if self.even[0] else nx // 2, ny if self.even[1] or self.plane_strain else ny // 2

    @cached_property
    def _padded(self) -> tuple[int, int]:
        """Number of cells along x and y of the padded quarter."""
        return 2 * self._half[0], 2 * self._half[1]

    def layer(self, depth: float) -> tuple[Array, Array]:
        """Stresses at the cells at one depth, m, at the positions `x` and `y`.

        Two arrays, Pa, in the order of `COMPONENTS`: by each pressure, shape (m, 6, nx, ny), and by
        each shear traction, shape (k, 6, nx, ny). σ_xy and σ_yz are odd along y if the fields
        are even, the other components even.
        """
        if self.plane_strain:
            of_pressure, of_shear = self.section(depth)
            return of_pressure[..., None], of_shear[..., None]
        nx, ny = self._padded
        x = (np.arange(nx + 2.0) - 0.5) * self.spacing[0]
        y = (np.arange(ny + 2.0) - 0.5) * self.spacing[1]
        return self._convolved(self._of_kinds(of_rectangles, x[:, None], y, depth), (0, 1))

    def section(self, depth: float) -> tuple[Array, Array]:
        """Stresses as of `layer`, but on the plane y = 0: without the axis of y."""
        x = (np.arange(self._padded[0] + 2.0) - 0.5)[:, None] * self.spacing[0]
        if self.plane_strain:
            kernels = of_strips(x, depth, self.poisson_ratio)
        else:
            y = np.arange(self._half[1] + 1.0) * self.spacing[1]
            kernels = 2.0 * self._of_kinds(of_rectangles, x, y, depth)
        return self._convolved(kernels, (0,))

    def at(self, points: Array) -> tuple[Array, Array]:
        """Stresses at points (x, y, z), m, shape (n, 3), by the sum over all loaded cells.

        Two arrays, Pa: by each pressure, shape (m, 6, n), and by each shear traction, (k, 6, n).
        """
        kinds = [self.on_both_sides(fields, odd=n > 1) for n, fields in enumerate(self._kinds)]
        stresses = [np.zeros((len(fields), 6, len(points))) for fields in kinds]
        loaded = np.any([fields.any(axis=0) for fields in kinds], axis=0)
        if not loaded.any():
            return _summed(stresses)
        box = tuple(slice(at.min(), at.max() + 1) for at in np.nonzero(loaded))
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
                fields = _on_both_sides(fields, axis + 1, int(odd))
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

    # The convolution.

    @cached_property
    def _parts(self) -> list[_Parts]:
        """Even and odd parts of all kinds of fields."""
        of_kinds = []
        for kind, fields in enumerate(self._kinds):
            odd_sides = (int(self.even[0]), int(self.even[1])) if kind > 1 else (0, 0)
            parts: _Parts = {odd_sides: fields}
            for axis in (0, 1):
                if self.even[axis] or (axis == 1 and self.plane_strain):
                    continue
                split: _Parts = {}
                for (x, y), values in parts.items():
                    negative, positive = np.split(values, 2, axis + 1)
                    for odd, sign in ((0, 0.5), (1, -0.5)):
                        part = 0.5 * positive + sign * np.flip(negative, axis + 1)
                        split[(odd, y) if axis == 0 else (x, odd)] = part
                parts = split
            of_kinds.append(parts)
        return of_kinds

    @cached_property
    def _spectra(self) -> dict[tuple[int, ...], list[_Parts]]:
        return {}

    def _sources(self, axes: tuple[int, ...]) -> list[_Parts]:
        """Frequencies of the parts along some axes."""
        if axes not in self._spectra:
            self._spectra[axes] = [
                {odd: _of_fields(part, odd, axes, self._padded) for odd, part in parts.items()}
                for parts in self._parts
            ]
        return self._spectra[axes]

    def _convolved(self, kernels: Array, axes: tuple[int, ...]) -> tuple[Array, Array]:
        """Convolve all kinds of fields with kernels of shape (kinds, 6, offsets, offsets or rows).

        With the axis of x alone, rows are summed to the results at y = 0.
        """
        nx, ny = self._half
        in_section = len(axes) == 1
        shape = (2 * nx,) if in_section else (2 * nx, ny if self.even[1] else 2 * ny)
        stresses = []
        for kernel, parity, sources in zip(kernels, ODD, self._sources(axes), strict=False):
            stress = np.zeros((len(next(iter(sources.values()))), 6, *shape))
            for component, of_cell in enumerate(parity):
                spectrum = _of_kernel(kernel[component], of_cell, axes)
                for of_part, source in sources.items():
                    odd = (of_part[0] ^ of_cell[0], of_part[1] ^ of_cell[1])
                    if in_section and odd[1]:
                        continue  # zero at y = 0, and in plane strain everywhere
                    if in_section:
                        # Rows at y > 0 lie at negative offsets seen from y = 0.
                        field = np.einsum("kxr,xr->kx", source, spectrum)
                        sign = (of_part[0] & of_cell[0]) + of_cell[1]
                    else:
                        field = self._back(source * spectrum, 1, odd[1])
                        sign = (of_part[0] & of_cell[0]) + (of_part[1] & of_cell[1])
                        if not self.even[1]:
                            field = _on_both_sides(field, 2, odd[1])
                    field = (-1.0) ** sign * self._back(field, 0, odd[0])
                    stress[:, component, nx:] += field
                    stress[:, component, nx - 1 :: -1] += -field if odd[0] else field
            stresses.append(stress)
        return _summed(stresses)

    def _back(self, spectrum: Array, axis: int, odd: int) -> Array:
        """Fields of a spectrum on the cells of the positive side along an axis."""
        along = np.moveaxis(spectrum, axis + 1, -1)[..., slice(1, None) if odd else slice(-1)]
        field = _transformed(along, 3, odd, -1)[..., : self._half[axis]]
        return np.moveaxis(field / (2.0 * self._padded[axis]), -1, axis + 1)


def _summed(stresses: Sequence[Array]) -> tuple[Array, Array]:
    """Stresses of pressure, and of shear along both axes together."""
    return stresses[0], sum(stresses[2:], stresses[1])


def _of_fields(
    fields: Array, odd: tuple[int, int], axes: tuple[int, ...], padded: tuple[int, int]
) -> Array:
    """Frequencies 0 to n of fields that are padded by zeros to n cells on the positive side."""
    for axis in axes:
        ends = [(0, 0)] * fields.ndim
        ends[axis + 1] = (0, padded[axis] - fields.shape[axis + 1])
        moved = _transformed(np.pad(fields, ends), 2, odd[axis], axis + 1)
        # A sine transform lacks the first frequency, a cosine transform the last: both are zero.
        ends[axis + 1] = (1, 0) if odd[axis] else (0, 1)
        fields = np.pad(moved, ends)
    return fields


def _of_kernel(kernel: Array, odd: tuple[int, int], axes: tuple[int, ...]) -> Array:
    """Frequencies of a kernel that is given at offsets from zero to the length of the window."""
    for axis in axes:
        along = np.moveaxis(kernel, axis, -1)
        if odd[axis]:
            moved = np.zeros(along.shape)
            moved[..., 1:-1] = _transformed(along[..., 1:-1], 1, odd[axis], -1)
        else:
            moved = _transformed(along, 1, odd[axis], -1)
        kernel = np.moveaxis(moved, -1, axis)
    return kernel


def _transformed(fields: Array, kind: int, odd: int, axis: int) -> Array:
    """The cosine transform of fields along an axis, or if they are odd the sine transform."""
    axes = (axis % fields.ndim,)
    if not odd:
        return dct(kind, fields, axes, np.empty(fields.shape))
    return dst(kind, fields, axes)


def _on_both_sides(fields: Array, axis: int, odd: int) -> Array:
    """Fields that are odd or even along an axis, from those on the positive side."""
    flipped = np.flip(fields, axis)
    return np.concatenate([-flipped if odd else flipped, fields], axis)
