"""The interface that geometries share, and the unworn bodies on them.

A geometry is a set of cells: rectangles (`fretwear.mechanics.contact.grid`), concentric rings
(`fretwear.mechanics.contact.rings`) or the strips of a line contact
(`fretwear.mechanics.contact.strips`). It defines the positions of the cells, the area of each, and
how the geometry is enlarged. Its half-space is the elastic bodies on these cells: it gives the
displacement under a pressure, and solves the normal contact.

Every field has two axes; on rings and strips the second one has a single cell. In a line contact
loads are per length: areas are widths, m, and forces N/m.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from fretwear.arrays import Array, Element, Even, Mask, Places, Real, Single
from fretwear.mechanics.contact.kernels import inner

Index = tuple[slice, slice]
# Places of cells along an axis from the origin outward.
Way = tuple[slice | int, slice | int]

# Part of a cell that does not belong to a zone, for each of its sides on the edge of the zone.
OPEN_PER_SIDE = (math.pi - 1.0 + math.log(2.0)) / 24.0
# Free cells that carry less than this part of the others cannot be scaled to carry the rest.
_LEAST_MOVABLE = 1e-12
# Largest error of the sum of tractions that carry a force, and steps to the shift that restores it.
BALANCED, _LARGEST_SHIFTS = 1e-13, 200
# Standard deviations of edges, in cells: anywhere in a cell with equal probability, and located
# within it. The outermost edge of Hertzian contacts of 30 to 34 cells has a root mean square error
# of 0.08 on strips and grids and 0.11 on rings, wherever it cuts a cell.
ANYWHERE, WITHIN_A_CELL = 1.0 / math.sqrt(12.0), 0.1


@dataclass(frozen=True)
class Zone:
    """A part of the whole contact, and the cells at its edge.

    These are places in the flattened field, once for each side that two cells share.
    """

    area: float  #: m²
    inside: Places  #: cells of the zone, shape (sides,)
    outside: Places  #: cells beside the zone, shape (sides,)
    #: Standard deviation of the area, by where edges cut these cells, m², shape (sides,).
    deviations: Array


@dataclass(frozen=True)
class Beside:
    """What tells where the edge of a zone cuts equal cells."""

    pressure: Array  #: pressure in the zone, Pa, zero beside, shape of the geometry
    gap: Array  #: gap that opens from the edge, m
    worn: Array | None = None  #: how far wear has opened it, m; None if it has not beside the edge
    by_pressure: bool = False  #: whether the pressure tells it, not the gap


@dataclass(frozen=True)
class Region:
    """The cells of a zone, and what is known of where its edges cut them."""

    cells: Mask
    radius: float  #: distance of its outermost edge on the x axis, m
    #: Without it, edges lie anywhere in equal cells.
    beside: Beside | None = None
    #: The region of contact around a stick zone, where both may end at the same side of a cell.
    around: Region | None = None


class Geometry(ABC):
    """The cells of a contact; fields on them have its ``shape``."""

    #: Tolerance of the integration on these cells, over the requested one.
    of_tolerance: ClassVar[float] = 1.0
    #: Whether displacements have no component along y, as in a line contact.
    plane_strain: ClassVar[bool] = False

    if TYPE_CHECKING:  # a field of some geometries

        @property
        def shape(self) -> tuple[int, int]:
            """Number of cells along x and y."""

    @property
    @abstractmethod
    def x(self) -> Array:
        """Positions of the cells along x, m, shape (nx,)."""

    @property
    @abstractmethod
    def y(self) -> Array:
        """Positions of the cells along y, m, shape (ny,)."""

    @property
    @abstractmethod
    def extent(self) -> tuple[float, float]:
        """Half-widths along x and y of the region that is written, m."""

    @property
    def even(self) -> Even:
        """Whether one side of the cells along x and along y stands for both."""
        return True, True

    @property
    @abstractmethod
    def unit_area(self) -> float:
        """Mean area of a cell and its images by symmetry, m²; a width in a line contact, m."""

    @property
    @abstractmethod
    def widths(self) -> Array | float:
        """Widths of the cells, m, shape of a field or one number; the lesser of rectangles."""

    @property
    def weights(self) -> Array | None:
        """Areas of the cells over their mean; None if all are equal."""
        return None

    @abstractmethod
    def integral(self, field: Array) -> float:
        """Integral of a field over the whole contact (field unit times m²)."""

    @abstractmethod
    def zone(self, region: Region) -> Zone:
        """The zone of a region: its area, and the cells at its edges."""

    @abstractmethod
    def covered(self, region: Region, plane: Geometry) -> Array:
        """The fraction of each cell of a grid within a region; together its area by `zone`."""

    def largest_mean(self, field: Array, width: float) -> float:
        """Largest mean of a field over a cell, or over an annulus of a width, m, on rings."""
        return float(field.max())

    @abstractmethod
    def along(self, axis: int) -> list[tuple[Way, Array]]:
        """Cells on or nearest to an axis: index, and distances from the origin, m."""

    @abstractmethod
    def half_space(self, modulus: float) -> HalfSpace:
        """The elastic bodies of a composite modulus, Pa."""

    # Other cells.

    @abstractmethod
    def where(self, other: Geometry) -> Index:
        """Indices of these cells that another geometry of the same kind has too."""

    @abstractmethod
    def resized(self, field: NDArray[Element], other: Geometry) -> NDArray[Element]:
        """A field of these cells on others; zero where there were none."""

    def extended(self, other: Geometry) -> Geometry:
        """These cells, extended to the size of others; the others, if both are equal cells."""
        return other

    # Output.

    def plane(self, spacing: tuple[float, float]) -> Geometry:
        """The grid of a spacing, m, on which fields are written: as a rule, these cells."""
        return self

    def written(
        self,
        fields: dict[str, NDArray[Element]],
        plane: Geometry,
    ) -> dict[str, NDArray[Element]]:
        """Fields as means over the cells of that grid."""
        return fields


class HalfSpace(ABC):
    """The elastic bodies under a pressure that is uniform on each cell of a geometry."""

    geometry: Geometry
    #: Largest displacement of a cell per pressure on itself, m/Pa.
    self_influence: float
    #: Whether solutions tell how pressure depends on the approach, `Contact.stiffness`.
    gives_stiffness: ClassVar[bool] = False

    @abstractmethod
    def displacement(self, pressure: Array) -> Array:
        """Normal surface displacement w, m, of a pressure, Pa."""

    @abstractmethod
    def relative_displacement(self, pressure: Array) -> tuple[Single, float]:
        """`displacement` in single precision in some unit, m, and the unit."""

    def along_x(self, coupling: float, mean: float) -> HalfSpace:
        """The bodies under tractions along x: displacements over ``mean`` κ of bodies of κ.

        These are the bodies themselves where the influence does not depend on the direction.
        """
        return self

    def around(self, cells: Mask) -> HalfSpace:
        """The same bodies, on fewer cells if these hold the given ones and a margin."""
        return self

    @abstractmethod
    def solve(
        self, problem: ContactProblem, start: Array | None, tolerance: float, *, verified: bool
    ) -> Contact:
        """Solve a normal contact of these bodies; see `solve_contact`.

        ``start`` is None if no guess of the pressure exists.
        """


class ContactError(RuntimeError):
    """No pressure distribution was found that satisfies the contact conditions to the tolerance.

    ``convolutions`` is the number of half-space convolutions spent on it.
    """

    def __init__(self, message: str, convolutions: int = 0) -> None:
        super().__init__(message)
        self.convolutions = convolutions


def find_shift(
    missing: Callable[[float], tuple[float, float]], guess: float, enough: float
) -> float:
    """Find where what is missing, with its fall per step, vanishes; the last call is there.

    Newton's method within a bracket; where it does not halve its steps, bisection. What is missing
    falls continuously, so that in the end the bracket closes up to rounding.
    """
    low, high, last = -np.inf, np.inf, 1.0
    for _ in range(_LARGEST_SHIFTS):
        left, slope = missing(guess)
        if abs(left) <= enough:
            return guess
        low, high = (guess, high) if left > 0.0 else (low, guess)
        step = left / slope if slope > 0.0 else math.copysign(math.inf, left)
        if math.isfinite(high - low):
            if not (low < guess + step < high and abs(step) <= 0.5 * last):
                step = 0.5 * (low + high) - guess
        else:
            step = min(max(step, -2.0 * last), 2.0 * last)
        if guess + step in (low, high):
            return guess
        guess, last = guess + step, abs(step)
    raise ContactError(f"no shift of the tractions carries the force: {left:.1e} lacks")


def projected(
    pressure: Array,
    limit: float | Array,
    total: float,
    compliance: Array | float = 1.0,
    weights: Array | None = None,
) -> tuple[Array, float]:
    """The nearest pressure of a weighted sum within the bounds; see `ContactProblem.projected`."""
    # The approach is found in units of the largest change.
    unit = float(np.max(compliance)) * max(float(np.abs(pressure).max()), total / pressure.size)
    moves, result = unit / np.asarray(compliance), pressure
    sinks = moves if weights is None else weights * moves

    def missing(shift: float) -> tuple[float, float]:
        nonlocal result
        result = np.clip(pressure + shift * moves, 0.0, limit)
        carried = float((result if weights is None else weights * result).sum())
        free = (result > 0.0) & (result < limit)
        return 1.0 - carried / total, float((free * sinks).sum()) / total

    shift = find_shift(missing, 0.0, BALANCED)
    return result, unit * shift


class Layer(Protocol):
    """Local compliance between the bodies: a displacement that depends on its cell's pressure.

    It grows with pressure, so the contact problem stays convex.
    """

    # Approach of the bodies at which the layer holds, m; None if it does not depend on it.
    level: float | None = None

    def at(self, approach: float) -> Layer:
        """The layer at another approach, m."""
        return self

    def per_approach(self, pressure: Array) -> Array:
        """Derivative of the displacement by the approach."""
        return np.zeros_like(pressure)

    def displacement(self, pressure: Array) -> Array:
        """Displacement, m, under a pressure, Pa; both of the geometry's shape."""
        result = np.zeros_like(pressure)
        self.add_displacement(pressure, result)
        return result

    def add_displacement(self, pressure: Array, result: Array) -> None:
        """Add the displacement under a pressure to a field."""

    def tangent_in(self, unit: float, pressure: Array) -> Single:
        """Derivative of the displacement in some unit, m/Pa; not negative."""


@dataclass(frozen=True)
class ContactProblem:
    """A normal contact of elastic bodies and a shape, under a load or at an approach."""

    half_space: HalfSpace  #: the elastic bodies on a geometry
    shape: Array  #: gap at zero load and zero approach, m, shape of the geometry
    load: float | None  #: normal load P of the whole contact, N; None if the approach is given
    #: Largest pressure, Pa, of all cells or of each; infinite when elastic.
    limit: float | Array = np.inf
    layer: Layer | None = None  #: local compliance
    approach: float | None = None  #: δ, m, if given instead of a load

    def __post_init__(self) -> None:
        if (self.load is None) == (self.approach is None):
            raise ValueError("a contact problem is given either a load or an approach")
        # A transposed map of heights is not in C order.
        object.__setattr__(self, "shape", np.ascontiguousarray(self.shape, np.float64))

    @property
    def total(self) -> float:
        """Weighted sum of the pressure over the cells that carries the load, Pa."""
        return (self.load or 0.0) / self.half_space.geometry.unit_area

    def separation(self, pressure: Array, displacement: Array) -> Array:
        """K p + W(p) + h, m: the gap plus the approach."""
        result = displacement + self.shape
        if self.layer is not None:
            self.layer.add_displacement(pressure, result)
        return result

    def first_guess(self) -> Array:
        """A pressure that grows with depth, shape of the geometry.

        Under a load it acts on the lowest fifth of the surface, in an arbitrary scale; at a given
        approach on everything below it, scaled to minimal energy.
        """
        shape, given, half_space = self.shape, self.approach, self.half_space
        level = float(np.quantile(shape, 0.2)) if given is None else given
        guess: Array = np.maximum(level - shape, 0.0)
        if given is not None:
            moved = half_space.displacement(guess)
            stiff = inner(guess, self.weighted(moved))
            work = inner(guess, self.weighted(guess))
            return guess * (work / stiff) if stiff > 0 else guess
        # A flat surface has no lowest fifth.
        return guess if guess.any() else np.ones_like(shape)

    def weighted(self, values: Real) -> Real:
        """A field times the weights of the cells."""
        weights = self.half_space.geometry.weights
        return values if weights is None else np.multiply(weights, values, dtype=values.dtype)

    def clip_to_load(self, pressure: Array) -> Array:
        """The pressure clipped to the bounds, its free cells scaled so that it carries the load.

        Scaling leaves open cells open and saturated cells saturated; a shift would free them. Each
        pass saturates one more cell or is the last, so the loop ends.
        """
        limit, result = self.limit, np.clip(pressure, 0.0, self.limit)
        while self.load is not None:
            full: Mask = result >= limit
            weighted = self.weighted(result)
            held, movable = float(weighted[full].sum()), float(weighted[~full].sum())
            if self.total <= held:
                # Saturated cells must yield too.
                return np.asarray(result * (self.total / (held + movable)))
            if movable <= _LEAST_MOVABLE * held:
                # All loaded cells are at the limit and still do not carry the load.
                return self.projected(result)[0]
            factor = (self.total - held) / movable
            result = np.clip(np.where(full, result, factor * result), 0.0, limit)
            if factor <= 1.0 or np.array_equal(full, result >= limit):
                break
        return result

    def projected(
        self, pressure: Array, compliance: Array | float = 1.0
    ) -> tuple[Array, Array | float]:
        """The nearest pressure within the bounds that carries the load, and the approach it takes.

        It is the minimum of Σ c (p − p₀)² over the cells of a compliance c, m/Pa: p₀ + δ/c, clipped
        to the bounds. Without a load the approach δ, m, is zero.
        """
        if self.load is None:
            return np.clip(pressure, 0.0, self.limit), 0.0
        weights = self.half_space.geometry.weights
        return projected(pressure, self.limit, self.total, compliance, weights)


@dataclass(frozen=True)
class Contact:
    """The solution of a `ContactProblem`; fields have the shape of the geometry."""

    pressure: Array  #: Pa
    #: m; where the pressure is at its limit, negative: the bodies yield there by its magnitude.
    gap: Array
    approach: float  #: δ, m
    saturated: Mask  #: cells at the pressure limit
    #: Largest violation of the conditions on the gap, relative to the largest displacement; if
    #: verified, from a separate convolution.
    residual: float
    convolutions: int  #: half-space convolutions spent
    stiffness: Array | None = None  #: pressure per approach, Pa/m, where it is known

    @property
    def yields(self) -> bool:
        """Whether any cell yields."""
        return bool(self.gap.min(where=self.saturated, initial=0.0) < 0)

    @property
    def penetration(self) -> Array:
        """Depth by which saturated cells yield, m; zero elsewhere."""
        result: Array = np.where(self.saturated, np.maximum(-self.gap, 0.0), 0.0)
        return result
