"""What the contact solver and the integrator require of a geometry.

A geometry is a set of cells: rectangles (`fretwear.mechanics.geometry.grid`), concentric rings
(`fretwear.mechanics.geometry.rings`) or the strips of a line contact
(`fretwear.mechanics.geometry.dense`). It defines the positions of the cells, the area of each, and
how the geometry is enlarged. Its half-space is the elastic bodies on these cells: displacement
under a pressure, and the linear problem of the cells in contact.

Every field has two axes; on rings and strips the second one has a single cell. In a line contact
loads are per length: areas are widths, m, and forces N/m.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from fretwear.mechanics.team import ALONE, Team

if TYPE_CHECKING:
    from fretwear.mechanics.state import State, WearProblem

Array = NDArray[np.float64]
Single = NDArray[np.float32]
Mask = NDArray[np.bool_]
# A field in double or single precision; the result has the precision of the argument.
Real = TypeVar("Real", Array, Single)
Index = tuple[slice, slice]
# Whether something is even along x and along y.
Even = tuple[bool, bool]


@dataclass(frozen=True)
class Zone:
    """A part of the whole contact, and the cells at its edge.

    These are places in the flattened field, once for each side that two cells share.
    """

    area: float  #: m²
    inside: NDArray[np.intp]  #: cells of the zone, shape (sides,)
    outside: NDArray[np.intp]  #: those beside it


class Geometry(Protocol):
    """Cells around the origin: an immutable value that can be compared, hashed and stored."""

    @property
    def of_tolerance(self) -> float:
        """Fraction of the tolerance allowed to a step: less where other errors are small."""

    @classmethod
    def first(cls, problem: WearProblem) -> Geometry:
        """The geometry for the first loading of a problem."""

    @property
    def shape(self) -> tuple[int, int]:
        """Of fields."""

    @property
    def x(self) -> Array:
        """Coordinates along x, m."""

    @property
    def y(self) -> Array:
        """Coordinates along y, m."""

    @property
    def extent(self) -> tuple[float, float]:
        """Distance of the border from the origin along x and y, m."""

    @property
    def unit_area(self) -> float:
        """Area of the whole contact represented by a cell of weight 1, m²."""

    @property
    def weights(self) -> Array | None:
        """Areas of the cells over the unit; None if all are equal."""

    def integral(self, field: Array) -> float:
        """Integral of a field over the whole contact (field unit times m²)."""

    def zone(self, cells: Mask, radius: float) -> Zone:
        """The zone that some cells stand for, and that reaches as far as a radius along x, m."""

    def half_space(
        self, modulus: float, team: Team = ALONE, parts: dict[Any, Any] | None = None
    ) -> HalfSpace:
        """The elastic bodies on the cells; ``parts`` are existing half-spaces to be shared."""

    def resized(self, field: Array, other: Any) -> Array:
        """A field on a larger or smaller geometry: zero on cells that this one lacks."""

    def where(self, smaller: Any) -> Index:
        """Indices of the cells of a smaller geometry."""

    def along(self, axis: int) -> list[tuple[tuple[slice | int, slice | int], Array]]:
        """Cells from the origin along an axis: index, and distances, m; both ways if not even."""

    def ahead_of(self, problem: WearProblem, contact: State) -> Geometry:
        """A geometry for the next step, larger or refined elsewhere, or this one."""

    def holding(self, workspace: Workspace, pressure: Array, approach: float) -> Geometry:
        """Itself, or the smallest of a series of larger ones that holds the contact."""

    def extended(self, other: Any) -> Any:
        """Itself, extended to the size of another."""

    def plane(self, spacing: tuple[float, float]) -> Any:
        """The grid of rectangles on which fields are written."""

    def written(self, fields: dict[str, NDArray[Any]], plane: Any) -> dict[str, NDArray[Any]]:
        """Means of fields over the cells of such a grid; of states, that of most of a cell."""


class HalfSpace(Protocol):
    """The elastic bodies on the cells of a geometry."""

    @property
    def geometry(self) -> Any:
        """The cells."""

    @property
    def team(self) -> Team:
        """Threads that share what is computed on the cells."""

    @property
    def self_influence(self) -> float:
        """Displacement of a cell per pressure on itself, m/Pa: the unit of compliance."""

    @property
    def matrix(self) -> Array | None:
        """Influence over `self_influence`, times the weights, for direct solutions; may be None."""

    def displacement(self, pressure: Array) -> Array:
        """Normal surface displacement w, m, of a pressure, Pa."""

    def relative_displacement(self, pressure: Array) -> tuple[Single, float]:
        """`displacement` to a few parts in 10⁷, in some unit, m, and the unit."""

    def around(self, cells: Mask) -> HalfSpace:
        """The same bodies on the smallest geometry that holds some cells and a margin."""


class Ground:
    """The unworn bodies of a problem on one geometry, computed when needed."""

    def __init__(self, problem: WearProblem, geometry: Any, parts: dict[Any, Any]) -> None:
        self._problem, self.geometry, self._parts = problem, geometry, parts

    @cached_property
    def half_space(self) -> Any:
        """The elastic bodies."""
        return self._problem.half_space(self.geometry, self._parts)

    @cached_property
    def unworn(self) -> Array:
        """Gap at zero load and zero approach, m."""
        return self._problem.unworn(self.geometry)


class Workspace:
    """The workspace of a run: the unworn bodies on the two geometries used last."""

    def __init__(self, problem: Any) -> None:
        self.problem = problem
        self._grounds: dict[Any, Ground] = {}
        self._parts: dict[Any, Any] = {}

    def on(self, geometry: Any) -> Ground:
        """The unworn bodies on a geometry."""
        ground = self._grounds.pop(geometry, None) or Ground(self.problem, geometry, self._parts)
        self._grounds[geometry] = ground
        if len(self._grounds) > 2:
            del self._grounds[next(iter(self._grounds))]
        return ground

    def keep_only(self, geometry: Any) -> None:
        """Drop the bodies on all geometries but one."""
        self._grounds = {geometry: self.on(geometry)}
