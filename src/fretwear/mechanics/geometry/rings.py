"""Concentric rings: a contact with rotational symmetry, some hundreds of cells, dense matrices.

The pressure is uniform on each ring, and displacements are their means over a ring. So the
influence of rings on each other is symmetric, and a mean of the paraboloid is its value at the
root mean square of the ring's radii, where fields are given.

References
----------
K. L. Johnson (1985), Contact Mechanics, Cambridge University Press, section 3.4 (the displacement
of a uniform pressure on a disc).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ellipe, ellipkm1

from fretwear.mechanics import kernels
from fretwear.mechanics.geometry import Array, Index, Mask, Problem, Single, Step, Workspace
from fretwear.mechanics.geometry.grid import Grid
from fretwear.theory import LimitingState

# Widths in units of the Hertzian contact radius: at the stick edge, where the elastic pressure
# grows without bound, and of the widest rings; and how the width grows with the distance from it.
_NARROWEST = 2e-4
_WIDEST = 0.008
_GRADING = 0.1
# Where bodies yield, the stick edge moves inward, and the band that yields moves with it: there
# rings stay narrow longer, and a band in the limit of many cycles has so many of them at first.
_INWARD_GRADING = 0.03
_ACROSS_BAND = 6.0
# The square plane of the output lies within the outermost ring, the contact within this part of it.
_ROOM = 0.94
_GROWTH = 1.12


@dataclass(frozen=True)
class Rings:
    """Concentric rings around the origin.

    Parameters
    ----------
    edges
        Radii of the edges of the rings from 0 outward, m.
    """

    edges: tuple[float, ...]

    @classmethod
    def first(cls, problem: Problem) -> Rings:
        """Rings for the first loading of a problem, graded to the edge of its stick zone.

        Raises
        ------
        ValueError
            If the problem has no rotational symmetry.
        """
        if not problem.is_axisymmetric:
            raise ValueError("rings need a smooth indenter with rotational symmetry")
        hertz = problem.hertz
        scale, load = hertz.contact_radius, problem.stick_load
        edge = hertz.with_load(load).contact_radius if load > 0.0 else 0.0
        outer, narrowest = math.sqrt(2.0) * max(problem.extent), _NARROWEST * scale
        if math.isinf(problem.limit):
            return cls.graded(edge, outer, narrowest, _WIDEST * scale)
        limiting = LimitingState(hertz, min(1.0 - load / hertz.load, 0.9999))
        narrowest = min(narrowest, limiting.width_above(problem.limit) / _ACROSS_BAND)
        return cls.graded(edge, outer, narrowest, _WIDEST * scale, _INWARD_GRADING)

    @classmethod
    def graded(
        cls,
        edge: float,
        outer: float,
        narrowest: float,
        widest: float,
        inward: float = _GRADING,
    ) -> Rings:
        """Rings that are fine about an edge.

        Parameters
        ----------
        edge, outer
            Where they are narrowest, and where they end, m.
        narrowest, widest
            Their widths, m.
        inward
            Growth of the width with the distance inward from the edge.
        """
        inner = edge - _distances(edge, narrowest, widest, inward)[::-1]
        outside = edge + _distances(outer - edge, narrowest, widest, _GRADING)[1:]
        inner[0] = 0.0
        return cls(tuple(float(each) for each in (*inner, *outside)))

    @cached_property
    def areas(self) -> Array:
        """Areas of the rings, m², shape (n, 1)."""
        return math.pi * np.diff(np.square(self.edges))[:, None]

    @property
    def shape(self) -> tuple[int, int]:
        """Of fields: one column."""
        return len(self.edges) - 1, 1

    @cached_property
    def x(self) -> Array:
        """Root mean square of the radii of each ring, m, shape (n,)."""
        square = np.square(self.edges)
        result: Array = np.sqrt(0.5 * (square[1:] + square[:-1]))
        return result

    @property
    def y(self) -> Array:
        """The x axis stands for all directions."""
        return np.zeros(1)

    @property
    def extent(self) -> tuple[float, float]:
        """Half-widths of the square within the outermost ring, m."""
        return self.edges[-1] / math.sqrt(2.0), self.edges[-1] / math.sqrt(2.0)

    @property
    def unit_area(self) -> float:
        """Mean area of a ring, m²."""
        return float(self.areas.mean())

    @cached_property
    def weights(self) -> Array:
        """Areas of the rings over their mean."""
        result: Array = self.areas / self.unit_area
        return result

    def integral(self, field: Array) -> float:
        """Integral of a field over the whole contact (field unit times m²)."""
        return float((self.areas * field).sum())

    def half_space(
        self,
        modulus: float,
        workers: int = 1,  # noqa: ARG002 - some hundreds of rings need one
        parts: dict[Any, Any] | None = None,  # noqa: ARG002 - there are none
    ) -> RingHalfSpace:
        """The elastic bodies on the rings."""
        return RingHalfSpace(self, modulus)

    def resized(self, field: NDArray[Any], other: Any) -> NDArray[Any]:
        """A field on rings that reach further or less far; zero where there were none."""
        result = np.zeros(other.shape, dtype=field.dtype)
        count = min(self.shape[0], other.shape[0])
        result[:count] = field[:count]
        return result

    def where(self, smaller: Any) -> Index:
        """Where the rings lie that reach less far."""
        return slice(0, min(self.shape[0], smaller.shape[0])), slice(0, 1)

    def along(
        self,
        axis: int,  # noqa: ARG002
    ) -> list[tuple[tuple[slice | int, slice | int], Array]]:
        """Index of all rings, and their radii, m."""
        return [((slice(None), 0), self.x)]

    def ahead_of(self, pressure: Array) -> Rings:
        """Rings that reach further if the next step may bring the contact to the border."""
        return self._reaching(pressure)

    def holding(
        self,
        workspace: Workspace,  # noqa: ARG002 - a smooth contact grows at its border
        pressure: Array,
        approach: float,  # noqa: ARG002
    ) -> Rings:
        """These rings, or ones that the contact fits into."""
        return self._reaching(pressure)

    def _reaching(self, pressure: Array) -> Rings:
        loaded = np.flatnonzero(pressure)
        radius = self.edges[loaded[-1] + 1] if loaded.size else 0.0
        if radius <= _ROOM * self.extent[0]:
            return self
        width, outer = self.edges[-1] - self.edges[-2], _GROWTH * self.edges[-1]
        count = math.ceil((outer - self.edges[-1]) / width)
        added = (self.edges[-1] + (step + 1) * width for step in range(count))
        return Rings((*self.edges, *added))

    def plane(self, spacing: tuple[float, float]) -> Grid:
        """The grid on which fields are written: the quarter of the square within the rings."""
        x, y = (
            max(1, math.floor(each / size)) for each, size in zip(self.extent, spacing, strict=True)
        )
        return Grid((x, y), spacing)

    def sampled(self, field: NDArray[Any], plane: Grid) -> NDArray[Any]:
        """A field on a grid: interpolated along the radius, or of the ring if it has no values."""
        r = np.hypot(plane.x[:, None], plane.y[None, :])
        if field.dtype.kind == "f":
            result: NDArray[Any] = np.interp(r, self.x, field[:, 0])
            return result
        ring = np.searchsorted(self.edges, r, side="right") - 1
        nearest: NDArray[Any] = field[np.minimum(ring, self.shape[0] - 1), 0]
        return nearest


def _distances(length: float, narrowest: float, widest: float, grading: float) -> Array:
    """Distances from 0 to a length whose spacing grows with the distance between two bounds."""
    first, last = narrowest / grading, widest / grading
    middle = math.log(last / first) / grading
    # The count of rings up to a distance: linear, logarithmic, linear.
    start = first / narrowest
    total = (
        length / narrowest
        if length < first
        else start + math.log(min(length, last) / first) / grading
    )
    total += max(length - last, 0.0) / widest
    count = np.linspace(0.0, total, math.ceil(total) + 1)
    growing = first * np.exp(grading * np.clip(count - start, 0.0, middle))
    result: Array = np.where(count < start, count * narrowest, growing)
    result += np.maximum(count - start - middle, 0.0) * widest
    result[-1] = length
    return result


def mean_influence(edges: Array) -> Array:
    """Displacement integrated over each ring under a unit pressure on each, times E*, m³.

    Over a disc of radius s beside or within one of radius t under a unit pressure, the larger of
    both being b and k the ratio of the smaller to it, the displacement integrates to
    (8/3) b³ [(1 + k²) E(k) − (1 − k²) K(k)] / E*; rings are differences of discs.

    Parameters
    ----------
    edges
        Radii of the edges of n rings from 0 outward, m.

    Returns
    -------
    Array, shape (n, n), symmetric.
    """
    larger = np.maximum(edges[:, None], edges[None, :])
    ratio = np.minimum(edges[:, None], edges[None, :]) / np.where(larger > 0.0, larger, 1.0)
    complement = np.maximum((1.0 - ratio) * (1.0 + ratio), np.finfo(np.float64).tiny)
    bracket = (1.0 + ratio**2) * ellipe(ratio**2) - complement * ellipkm1(complement)
    discs = (8.0 / 3.0) * larger**3 * bracket
    result: Array = np.diff(np.diff(discs, axis=0), axis=1)
    return result


class RingHalfSpace:
    """The elastic half-space under a pressure that is uniform on each ring.

    Parameters
    ----------
    geometry
        The rings.
    composite_modulus
        E*, Pa.

    Attributes
    ----------
    self_influence
        Largest displacement of a ring per pressure on itself, m/Pa.
    """

    def __init__(self, geometry: Rings, composite_modulus: float) -> None:
        self.geometry = geometry
        integrals = mean_influence(np.asarray(geometry.edges)) / composite_modulus
        self.influence: Array = integrals / geometry.areas
        self.self_influence = float(self.influence.diagonal().max())

    def displacement(self, pressure: Array) -> Array:
        """Normal surface displacement w, m, of a pressure, Pa, in the mean over each ring."""
        result: Array = self.influence @ pressure
        return result

    def relative_displacement(self, pressure: Array) -> tuple[Single, float]:
        """`displacement` in single precision in some unit, m, and the unit."""
        return kernels.scaled(self.displacement(pressure))

    def around(self, cells: Mask) -> RingHalfSpace:  # noqa: ARG002 - parts would gain nothing
        """The same bodies."""
        return self

    def preconditioned(
        self,
        tangent: Single | None,  # noqa: ARG002 - the problem is solved directly
        free: Mask,  # noqa: ARG002
    ) -> RingHalfSpace:
        """The linear problems of sets of free rings."""
        return self

    def on(self, free: Mask, *, under_load: bool = True) -> FreeRings:
        """The linear problem of the free rings, under a given load or at a given approach."""
        return FreeRings(self, free, under_load=under_load)


class FreeRings:
    """A set of free rings, solved directly; see `fretwear.mechanics.geometry.FreeCells`."""

    uniform: Single
    uniform_sum: float

    def __init__(self, half_space: RingHalfSpace, free: Mask, *, under_load: bool) -> None:
        self._rings = np.flatnonzero(free)
        self._under_load = under_load
        self._weights = half_space.geometry.weights[self._rings, 0]
        self._relative = half_space.influence[:, self._rings] / half_space.self_influence
        # Multiplied by the areas it is symmetric, but for rounding.
        matrix = self._weights[:, None] * self._relative[self._rings]
        self._matrix = 0.5 * (matrix + matrix.T)
        self._shape = half_space.geometry.shape

    def solve(
        self,
        residual: Array,
        unit: float,
        tangent: Single | None,
        reduction: float,  # noqa: ARG002 - solved to rounding
        enough: float,  # noqa: ARG002
    ) -> Step:
        """Solution by Cholesky's factors."""
        from scipy.linalg import cho_factor, cho_solve

        rings, matrix = self._rings, self._matrix.copy()
        if tangent is not None:
            matrix[np.diag_indices(rings.size)] += self._weights * tangent[rings, 0]
        right = np.stack([residual[rings, 0] / unit, np.ones(rings.size)], axis=1)
        factors = cho_factor(matrix, lower=True, overwrite_a=True, check_finite=False)
        found, uniform = cho_solve(factors, self._weights[:, None] * right, check_finite=False).T
        self.uniform, self.uniform_sum = np.zeros(self._shape, np.float32), np.inf
        if self._under_load:
            sums = self._weights @ found, self._weights @ uniform
            found = found - sums[0] / sums[1] * uniform
            self.uniform[rings, 0], self.uniform_sum = uniform, float(sums[1])
        pressure = np.zeros(self._shape, np.float32)
        pressure[rings, 0] = found
        # What the rounded pressure does, so that displacements belong to pressures.
        rounded = pressure[rings, 0].astype(np.float64)
        displacement = (self._relative @ rounded)[:, None].astype(np.float32)
        largest, missed = float(np.abs(displacement).max()), float(self._weights @ rounded)
        return Step(pressure, displacement, largest, missed, 1)
