"""Stresses of an elastic half-space under pressure and shear traction on equal cells.

The stress of a cell is even or odd along x and along y, and so are parts of the tractions: a layer
of stresses is a convolution by cosine and sine transforms of one quarter, padded with zeros so that
it has no periodic images.

Waves of the tractions decay with depth like exp(−kz). In layers deeper than a few cells only the
long ones are left: the stress of a point load, taken at every second, fourth … cell and averaged
over a cell by the factor sin(kh/2)/(kh/2), has the same spectrum there as the cell's, and few
frequencies are transformed back.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fretwear.arrays import Array
from fretwear.mechanics.contact.cells import Even
from fretwear.mechanics.contact.kernels import dct, dst
from fretwear_cracks.influence import ODD, TURNED, of_points, of_rectangles, of_strips

# Windows are padded to a multiple of this, the longest stride of a deep layer.
_LONGEST_STRIDE = 8
# Strides over depth: of waves two strides long exp(−3π) = 8e-5 is left there.
_STRIDE_OF_DEPTH = 1.0 / 3.0
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
        nx, ny = (-(-2 * n // _LONGEST_STRIDE) * _LONGEST_STRIDE for n in self._half)
        return nx, ny

    def layer(self, depth: float) -> tuple[Array, Array]:
        """Stresses at the cells at one depth, m, at the positions `x` and `y`.

        Two arrays, Pa, in the order of `COMPONENTS`: by each pressure, shape (m, 6, nx, ny), and by
        each shear traction, shape (k, 6, nx, ny). σ_xy and σ_yz are odd along y if the fields
        are even, the other components even.
        """
        if self.plane_strain:
            of_pressure, of_shear = self.section(depth)
            return of_pressure[..., None], of_shear[..., None]
        strides = self._strides(depth)
        if min(strides) == 1:
            nx, ny = self._padded
            x = (np.arange(nx + 2.0) - 0.5) * self.spacing[0]
            y = (np.arange(ny + 2.0) - 0.5) * self.spacing[1]
            kernels = self._of_kinds(of_rectangles, x[:, None], y, depth)
            return self._convolved(kernels, (0, 1), self._padded)
        return self._convolved(self._of_long_waves(depth, strides), (0, 1), self._counts(strides))

    def section(self, depth: float) -> tuple[Array, Array]:
        """Stresses as of `layer`, but on the plane y = 0: without the axis of y."""
        strides = self._strides(depth)
        if not self.plane_strain and min(strides) > 1:
            kernels, counts = self._of_long_waves(depth, strides), self._counts(strides)
            return self._convolved(kernels, (0, 1), counts, in_section=True)
        x = (np.arange(self._padded[0] + 2.0) - 0.5)[:, None] * self.spacing[0]
        if self.plane_strain:
            kernels = of_strips(x, depth, self.poisson_ratio)
        else:
            y = np.arange(self._half[1] + 1.0) * self.spacing[1]
            kernels = 2.0 * self._of_kinds(of_rectangles, x, y, depth)
        return self._convolved(kernels, (0,), self._padded, in_section=True)

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

    def _strides(self, depth: float) -> tuple[int, int]:
        """Strides along x and y at which the long waves that reach a depth, m, are sampled."""
        of_depth = [max(1.0, _STRIDE_OF_DEPTH * depth / step) for step in self.spacing]
        x, y = (min(_LONGEST_STRIDE, 1 << int(math.log2(ratio))) for ratio in of_depth)
        return x, y

    def _counts(self, strides: tuple[int, int]) -> tuple[int, int]:
        """Number of frequencies along x and y that a sampling with strides has."""
        x, y = (n // stride for n, stride in zip(self._padded, strides, strict=True))
        return x, y

    def _of_long_waves(self, depth: float, strides: tuple[int, int]) -> Array:
        """Stresses of a cell at every second, fourth … cell, as of that many cells."""
        offsets, factors = [], []
        for n, stride, step in zip(self._padded, strides, self.spacing, strict=True):
            offsets.append(np.arange(0.0, n + 1, stride) * step)
            factors.append(stride * step)
        x, y = offsets
        kernels = self._of_kinds(of_points, x[:, None], y, depth)
        kernels *= math.prod(factors)
        return kernels

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

    def _convolved(
        self,
        kernels: Array,
        axes: tuple[int, ...],
        counts: tuple[int, int],
        *,
        in_section: bool = False,
    ) -> tuple[Array, Array]:
        """Convolve all kinds of fields with kernels of shape (kinds, 6, offsets, offsets or rows).

        That many frequencies are used along x and y, in a section with the results at y = 0 only.
        """
        nx, ny = self._half
        shape = (2 * nx,) if in_section else (2 * nx, ny if self.even[1] else 2 * ny)
        by_offsets = len(axes) == 2
        smooth = by_offsets and counts != self._padded
        averages = self._averages(counts)
        stresses = []
        for kernel, parity, sources in zip(kernels, ODD, self._sources(axes), strict=False):
            stress = np.empty((len(next(iter(sources.values()))), 6, *shape))
            for component, of_cell in enumerate(parity):
                is_empty = True
                spectrum = _of_kernel(kernel[component], of_cell, axes)
                if smooth:
                    spectrum *= averages
                for of_part, source in sources.items():
                    odd = (of_part[0] ^ of_cell[0], of_part[1] ^ of_cell[1])
                    if in_section and odd[1]:
                        continue  # zero at y = 0, and in plane strain everywhere
                    if by_offsets:
                        field = source[:, : counts[0] + 1, : counts[1] + 1] * spectrum
                        signs = [of_part[axis] & of_cell[axis] for axis in axes]
                        if in_section:
                            field = field.sum(axis=-1) - 0.5 * field[..., 0]
                            field /= self._padded[1]
                        else:
                            field = self._back(field, 1, odd[1], counts)
                    else:
                        # Rows at y > 0 lie at negative offsets seen from y = 0.
                        field = np.einsum("kxr,xr->kx", source, spectrum)
                        signs = [of_part[0] & of_cell[0], of_cell[1]]
                    field = self._back(field, 0, odd[0], counts)
                    if sum(signs) % 2:
                        field = -field
                    if not (in_section or self.even[1]):
                        field = _on_both_sides(field, 2, odd[1])
                    positive, negative = (
                        stress[:, component, nx:],
                        stress[:, component, nx - 1 :: -1],
                    )
                    if is_empty:
                        positive[...] = field
                        np.multiply(field, -1.0 if odd[0] else 1.0, out=negative)
                    else:
                        positive += field
                        negative += -field if odd[0] else field
                    is_empty = False
                if is_empty:
                    stress[:, component] = 0.0
            stresses.append(stress)
        return _summed(stresses)

    def _averages(self, counts: tuple[int, int]) -> Array:
        """Factors by which a mean over a cell changes each frequency."""
        x, y = (
            np.sinc(np.arange(count + 1) / (2.0 * n))
            for count, n in zip(counts, self._padded, strict=True)
        )
        return x[:, None] * y

    def _back(self, spectrum: Array, axis: int, odd: int, counts: tuple[int, int]) -> Array:
        """Fields of a spectrum on the cells of the positive side along an axis."""
        if counts[axis] < self._padded[axis]:
            matrix = self._to_cells[axis][odd][:, : counts[axis] + 1]
            is_last = axis + 2 == spectrum.ndim
            return spectrum @ matrix.T if is_last else matrix @ spectrum
        along = np.moveaxis(spectrum, axis + 1, -1)[..., slice(1, None) if odd else slice(-1)]
        field = _transformed(along, 3, odd, -1)[..., : self._half[axis]]
        return np.moveaxis(field / (2.0 * self._padded[axis]), -1, axis + 1)

    @cached_property
    def _to_cells(self) -> list[list[Array]]:
        """Matrices from frequencies to cells along x and y, of even and of odd fields.

        The first half of the frequencies are all that are left of a layer that has a stride.
        """
        matrices = []
        for n, half in zip(self._padded, self._half, strict=True):
            angles = np.pi / n * (np.arange(half) + 0.5)[:, None] * np.arange(n // 2 + 1)
            weights = np.where(np.arange(n // 2 + 1) > 0, 1.0, 0.5) / n
            matrices.append([np.cos(angles) * weights, np.sin(angles) * weights])
        return matrices


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
