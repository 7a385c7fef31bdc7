"""The interface that geometries share, and the unworn bodies on them.

A geometry is a set of cells: rectangles (`fretwear.mechanics.contact.grid`), concentric rings
(`fretwear.mechanics.contact.rings`) or the strips of a line contact
(`fretwear.mechanics.contact.strips`). It defines the positions and areas of the cells, and how the
set grows. Its half-space holds the elastic bodies on these cells and gives their displacement under
a pressure; `fretwear.mechanics.contact.problem.solve_on` solves a normal contact of each kind.

Every field has two axes; on rings and strips the second one has a single cell. In a line contact
loads are per length: areas are widths, m, and forces N/m.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from numpy.typing import NDArray

from fretwear.arrays import Array, Element, Even, Mask, Places, Single
from fretwear.mechanics.contact.film import Film

Index = tuple[slice, slice]
# Cells along an axis, from the origin outward.
Way = tuple[slice | int, slice | int]

# Fraction of a cell outside a zone, for each of its sides on the edge of the zone.
OPEN_PER_SIDE = (math.pi - 1.0 + math.log(2.0)) / 24.0


@dataclass(frozen=True)
class Zone:
    """A part of the whole contact, and the cells at its edge.

    These are places in the flattened field, once for each side that two cells share.
    """

    area: float  #: m²
    inside: Places  #: cells of the zone, shape (sides,)
    outside: Places  #: cells beside the zone, shape (sides,)


@dataclass(frozen=True)
class Evidence:
    """Fields that locate the edge of a zone within equal cells."""

    pressure: Array  #: pressure in the zone, Pa, zero outside, shape of the geometry
    gap: Array  #: gap that opens from the edge outward, m
    worn: Array | None = None  #: part of that gap due to wear, m; None if nothing has worn there
    by_pressure: bool = False  #: whether to locate the edge by the pressure instead of the gap


@dataclass(frozen=True)
class Region:
    """The cells of a zone, and the fields that locate its edges within them."""

    cells: Mask
    radius: float  #: distance of its outermost edge on the x axis, m
    #: Without evidence, an edge lies anywhere in its cell.
    evidence: Evidence | None = None
    #: The contact around a stick zone: both may end at the same side of a cell.
    contact: Region | None = None


class Geometry(ABC):
    """The cells of a contact; fields on them have its ``shape``."""

    #: Tolerance of the integration on these cells relative to the requested one.
    of_tolerance: ClassVar[float] = 1.0
    #: Whether the contact is a line contact, without displacements along y.
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
        """Half-widths along x and y of the output region, m."""

    @property
    def even(self) -> Even:
        """Whether fields are even along x and along y, so that the cells cover one side only."""
        return True, True

    @property
    @abstractmethod
    def unit_area(self) -> float:
        """Mean area of a cell and its images by symmetry, m²; a width in a line contact, m."""

    @property
    @abstractmethod
    def widths(self) -> Array | float:
        """Widths of the cells, m: a field or one number; the shorter sides of rectangles."""

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
        """Fraction of each cell of a grid inside a region; they sum to its area by `zone`."""

    def largest_mean(self, field: Array, width: float) -> float:
        """Largest mean of a field over one cell, or on rings over an annulus of a width, m."""
        return float(field.max())

    @abstractmethod
    def axis_cells(self, axis: int) -> list[tuple[Way, Array]]:
        """Cells on or nearest to an axis: index, and distances from the origin, m."""

    @abstractmethod
    def half_space(self, modulus: float, film: Film | None = None) -> HalfSpace:
        """The elastic bodies of a composite modulus, Pa, with a film on the flat."""

    # Other cells.

    @abstractmethod
    def where(self, target: Geometry) -> Index:
        """Indices of these cells that another geometry of the same kind has too."""

    @abstractmethod
    def resized(self, field: NDArray[Element], target: Geometry) -> NDArray[Element]:
        """A field of these cells on other cells; zero where these cells had none."""

    def extended(self, target: Geometry) -> Geometry:
        """These cells, extended to the size of others; the others, if both are equal cells."""
        return target

    # Output.

    def plane(self, spacing: tuple[float, float]) -> Geometry:
        """The output grid of a spacing, m; these cells where they form a grid."""
        return self

    def written(
        self,
        fields: dict[str, NDArray[Element]],
        plane: Geometry,
    ) -> dict[str, NDArray[Element]]:
        """Means of fields over the cells of that grid."""
        return fields


class HalfSpace(ABC):
    """The elastic bodies under a pressure that is uniform on each cell of a geometry."""

    geometry: Geometry
    #: Largest displacement of a cell per pressure on itself, m/Pa.
    self_influence: float
    #: Whether solutions have a `Contact.stiffness`.
    gives_stiffness: ClassVar[bool] = False

    @abstractmethod
    def displacement(self, pressure: Array) -> Array:
        """Normal surface displacement w, m, of a pressure, Pa."""

    @abstractmethod
    def relative_displacement(self, pressure: Array) -> tuple[Single, float]:
        """`displacement` in single precision in some unit, m, and the unit."""

    def along_x(self, coupling: float, mean: float) -> HalfSpace:
        """The bodies of κ under tractions along x; displacements are divided by ``mean``.

        Same as `alike` if the influence does not depend on the direction.
        """
        return self.alike(mean)

    def alike(self, mean: float) -> HalfSpace:
        """The bodies under tractions, averaged over all directions; displacements over ``mean``.

        Without a film these are the bodies themselves.
        """
        return self

    def cropped(self, cells: Mask) -> HalfSpace:
        """The same bodies on a smaller geometry that holds some cells and a margin, if any."""
        return self
