# ruff: noqa: D102 - units stand beside each attribute
"""What cells ask of the problem on them, of the state before, and of the plane they are written on.

All numbers are in SI units, and fields have the shape of the geometry.
"""

from __future__ import annotations

from typing import Any, Protocol

from fretwear.arrays import Array
from fretwear.theory import HertzContact


class Plane(Protocol):
    """The equal cells on which fields are written; planes of the same cells have the same hash."""

    def __hash__(self) -> int: ...
    @property
    def shape(self) -> tuple[int, int]: ...  # number of cells along x and y
    @property
    def spacing(self) -> tuple[float, float]: ...  # cell size along x and y, m
    @property
    def even(self) -> tuple[bool, bool]: ...  # whether one side along x, and y, stands for both
    @property
    def x(self) -> Array: ...  # positions of the cells, m, shape (nx,)
    @property
    def y(self) -> Array: ...  # the same along y, shape (ny,)


class Body(Protocol):
    """The indenter, as far as cells depend on it."""

    @property
    def is_axisymmetric(self) -> bool: ...
    # The state after infinitely many cycles at a load ratio Q/µP, in closed form.
    def limiting(self, hertz: Any, load_ratio: float) -> Any: ...


class CellProblem(Protocol):
    """The part of a problem by which a geometry chooses its cells."""

    @property
    def spacing(self) -> tuple[float, float]: ...  # cell size along x and y, m
    @property
    def extent(self) -> tuple[float, float]: ...  # half-widths of the first cells, m
    @property
    def coarseness(self) -> float: ...  # how many times wider than usual rings and strips are
    @property
    def even(self) -> tuple[bool, bool]: ...  # whether the unworn gap is even along x and y
    @property
    def wavelengths(self) -> tuple[float, float] | None: ...  # to the next tip, m; None: smooth
    @property
    def rough(self) -> object | None: ...  # the roughness of the surfaces
    @property
    def indenter(self) -> Body: ...
    @property
    def hertz(self) -> HertzContact: ...  # the unworn smooth contact
    @property
    def stick_load(self) -> float: ...  # its reduced load, N
    @property
    def slip_limit(self) -> float: ...  # largest pressure where the bodies slip, Pa
    # Distances along x and y beyond which the unworn surface lies above an approach, m.
    def reach(self, approach: float) -> tuple[float, float]: ...
    # The elastic bodies; windows share their parts.
    def half_space(self, geometry: Any, parts: Any) -> Any: ...
    def unworn(self, geometry: Any) -> Array: ...  # gap at zero load and zero approach, m


class LoadedCells(Protocol):
    """Pressures, as far as the choice of cells depends on them."""

    @property
    def pressure(self) -> Array: ...  # Pa


class WornContact(LoadedCells, Protocol):
    """The end of a step, as far as cells for the next one depend on it."""

    @property
    def wear(self) -> Array: ...  # m
    @property
    def plastic(self) -> Array: ...  # plastic depth, m
    @property
    def reduced(self) -> LoadedCells: ...  # the contact whose pressure sticks
