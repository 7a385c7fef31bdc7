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
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar, Protocol, Self

from numpy.typing import NDArray

from fretwear.arrays import Array, Element, Mask, Places, Single
from fretwear.theory import HertzContact

if TYPE_CHECKING:
    from fretwear.mechanics.contact.grid import Grid, GridHalfSpace
    from fretwear.mechanics.contact.problem import Contact, ContactProblem
    from fretwear.mechanics.slip.cerruti import ShearSpace
    from fretwear.mechanics.surfaces.indenters import Indenter
    from fretwear.mechanics.surfaces.roughness import Roughness
    from fretwear.mechanics.wear.state import Stage, WearProblem

Index = tuple[slice, slice]
# Places of cells along an axis from the origin outward.
Way = tuple[slice | int, slice | int]
# Whether something is even along x and along y.
Even = tuple[bool, bool]
# The elastic bodies on parts of a window, by the shapes of these and the weights of directions.
Parts = dict[tuple[int, int, tuple[float, float]], "GridHalfSpace"]

# Part of a cell that does not belong to a zone, for each of its sides on the edge of the zone.
OPEN_PER_SIDE = (math.pi - 1.0 + math.log(2.0)) / 24.0
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
    deviations: (
        Array  #: standard deviation of the area, by where edges cut these cells, m², shape (sides,)
    )


@dataclass(frozen=True)
class Beside:
    """What tells where the edge of a zone cuts equal cells."""

    pressure: Array  #: pressure in the zone, Pa, zero beside, shape of the geometry
    gap: Array  #: gap that opens from the edge, m
    worn: Array | None = None  #: how far wear has opened it, m; None if it has not beside the edge


@dataclass(frozen=True)
class Region:
    """The cells of a zone, and what is known of where its edges cut them."""

    cells: Mask
    radii: Array | float  #: distances of its outermost edges on `ways`, m
    #: Without it, edges lie anywhere in equal cells.
    beside: Beside | None = None


class CellProblem(Protocol):
    """The part of a problem by which a geometry chooses its cells; in SI units."""

    @property
    def spacing(self) -> tuple[float, float]:
        """Cell size along x and y, m."""

    @property
    def extent(self) -> tuple[float, float]:
        """Half-widths along x and y of the region that the first cells cover, m."""

    @property
    def coarseness(self) -> float:
        """How many times wider than usual rings and strips are."""

    @property
    def even(self) -> Even:
        """Whether the unworn gap is even along x and along y."""

    @property
    def wavelengths(self) -> tuple[float, float] | None:
        """Distance to the next asperity tip along x and y, m; None if smooth."""

    @property
    def rough(self) -> Roughness | None:
        """The roughness of the surfaces, if any."""

    @property
    def indenter(self) -> Indenter:
        """The smooth part of the unworn gap."""

    @property
    def hertz(self) -> HertzContact:
        """The unworn smooth contact."""

    @property
    def stick_load(self) -> float:
        """Reduced load of the unworn smooth contact, N."""

    @property
    def slip_limit(self) -> float:
        """Largest pressure where the bodies slip, Pa; infinite when elastic."""

    def reach(self, approach: float) -> tuple[float, float]:
        """Distance along x and y beyond which the unworn surface lies above an approach, m."""


class Geometry(ABC):
    """The cells of a contact; fields on them have its ``shape``."""

    #: Tolerance of the integration on these cells, over the requested one.
    of_tolerance: ClassVar[float] = 1.0
    #: Whether displacements have no component along y, as in a line contact.
    plane_strain: ClassVar[bool] = False
    #: Whether cells are narrower than others where pressure grows without bound.
    refines_edges: ClassVar[bool] = False

    @classmethod
    @abstractmethod
    def first(cls, problem: CellProblem) -> Self:
        """The cells for the first loading of a problem."""

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
    def sides(self) -> tuple[float, float] | None:
        """Sides of equal cells along x and y, m; None if cells differ."""
        return None

    @property
    @abstractmethod
    def unit_area(self) -> float:
        """Mean area of a cell and its images by symmetry, m²; a width in a line contact, m."""

    @property
    @abstractmethod
    def widths(self) -> Array | float:
        """Widths of the cells, m, shape of a field or one number; the lesser of rectangles."""

    @property
    @abstractmethod
    def weights(self) -> Array | None:
        """Areas of the cells over their mean; None if all are equal."""

    @abstractmethod
    def integral(self, field: Array) -> float:
        """Integral of a field over the whole contact (field unit times m²)."""

    @abstractmethod
    def zone(self, region: Region) -> Zone:
        """The zone of a region: its area, and the cells at its edges."""

    @abstractmethod
    def covered(self, region: Region, plane: Grid) -> Array:
        """The fraction of each cell of a grid within a region; together its area by `zone`."""

    @abstractmethod
    def largest_mean(self, field: Array, width: float) -> float:
        """Largest mean of a field over a cell, or over an annulus of a width, m, on rings."""

    @abstractmethod
    def along(self, axis: int) -> list[tuple[Way, Array]]:
        """Cells on or nearest to an axis: index, and distances from the origin, m."""

    @property
    def ways(self) -> list[list[tuple[Way, Array]]]:
        """Lines of cells as `along` has them, on which `zone` looks for the edges of a zone."""
        return [self.along(0)]

    @abstractmethod
    def half_space(self, modulus: float, parts: Parts | None = None) -> HalfSpace:
        """The elastic bodies of a composite modulus, Pa; ``parts`` are shared between windows."""

    # Other cells.

    @abstractmethod
    def where(self, other: Geometry) -> Index:
        """Indices of these cells that another geometry of the same kind has too."""

    @abstractmethod
    def resized(self, field: NDArray[Element], other: Geometry) -> NDArray[Element]:
        """A field of these cells on others; zero where there were none."""

    @abstractmethod
    def extended(self, other: Geometry) -> Self:
        """These cells, extended to the size of others."""

    @abstractmethod
    def ahead_of(self, problem: CellProblem, stage: Stage) -> Self:
        """Cells that suit the next step."""

    @abstractmethod
    def holding(self, workspace: Workspace, pressure: Array, approach: float) -> Self:
        """These cells, or more if the contact under a pressure, Pa, needs them."""

    # Output.

    @abstractmethod
    def plane(self, spacing: tuple[float, float]) -> Grid:
        """The grid of a spacing, m, on which fields are written."""

    @abstractmethod
    def written(
        self, fields: dict[str, NDArray[Element]], plane: Grid
    ) -> dict[str, NDArray[Element]]:
        """Fields as means over the cells of that grid."""


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

    def along_x(self, coupling: float, mean: float) -> HalfSpace:  # noqa: ARG002 - the same in all
        """The bodies under tractions along x: displacements over ``mean`` κ of bodies of κ.

        These are the bodies themselves where the influence does not depend on the direction.
        """
        return self

    def sheared(self, coupling: float) -> ShearSpace[Array]:
        """The same bodies under shear tractions, of κ = E*/G*, if they have both directions."""
        raise NotImplementedError(f"{type(self).__name__} has no tractions along two directions")

    @abstractmethod
    def around(self, cells: Mask) -> HalfSpace:
        """The same bodies on fewer cells, which hold the given ones and a margin."""

    @abstractmethod
    def solve(
        self, problem: ContactProblem, start: Array | None, tolerance: float, *, verified: bool
    ) -> Contact:
        """Solve a normal contact of these bodies; see `solve_contact`.

        ``start`` is None if no guess of the pressure exists.
        """


class UnwornBodies:
    """The unworn bodies of a problem on one geometry, computed when needed."""

    def __init__(self, problem: WearProblem, geometry: Geometry, parts: Parts) -> None:
        self._problem, self.geometry, self._parts = problem, geometry, parts

    @cached_property
    def half_space(self) -> HalfSpace:
        """The elastic bodies."""
        return self._problem.half_space(self.geometry, self._parts)

    @cached_property
    def unworn(self) -> Array:
        """Gap at zero load and zero approach, m."""
        return self._problem.unworn(self.geometry)


class Workspace:
    """The workspace of a run: the unworn bodies on the two geometries used last."""

    def __init__(self, problem: WearProblem) -> None:
        self.problem = problem
        self._bodies: dict[Geometry, UnwornBodies] = {}
        # Shared by all windows: separate parts would cost each of them an array or two more.
        self._parts: Parts = {}

    def on(self, geometry: Geometry) -> UnwornBodies:
        """The unworn bodies on a geometry."""
        bodies = self._bodies.pop(geometry, None)
        bodies = bodies or UnwornBodies(self.problem, geometry, self._parts)
        self._bodies[geometry] = bodies
        if len(self._bodies) > 2:
            del self._bodies[next(iter(self._bodies))]
        return bodies

    def keep_only(self, geometry: Geometry) -> None:
        """Drop the bodies on all geometries but one."""
        self._bodies = {geometry: self.on(geometry)}
