# ruff: noqa: D102 - units stand beside each attribute
"""What cells and slip ask of a problem, and of the state before; all numbers are in SI units."""

from __future__ import annotations

from typing import Any, Protocol

from fretwear.arrays import Array, Even
from fretwear.mechanics.surfaces.indenters import Indenter
from fretwear.mechanics.surfaces.loading import Loading, Sliding
from fretwear.mechanics.surfaces.materials import Bodies, Friction
from fretwear.mechanics.surfaces.pressing import Normal
from fretwear.mechanics.surfaces.roughness import Roughness
from fretwear.theory import HertzContact


class FrettingProblem(Protocol):
    """A wear problem, as far as cells and slip depend on it."""

    @property
    def spacing(self) -> tuple[float, float]: ...  # cell size along x and y, m
    @property
    def extent(self) -> tuple[float, float]: ...  # half-widths of the first cells, m
    @property
    def coarseness(self) -> float: ...  # how many times wider than usual rings and strips are
    @property
    def even(self) -> Even: ...  # whether the unworn gap is even along x and y
    @property
    def wavelengths(self) -> tuple[float, float] | None: ...  # to the next tip, m; None: smooth
    @property
    def rough(self) -> Roughness | None: ...
    @property
    def indenter(self) -> Indenter: ...
    @property
    def hertz(self) -> HertzContact: ...  # the unworn smooth contact
    @property
    def stick_load(self) -> float: ...  # its reduced load, N
    @property
    def slip_limit(self) -> float: ...  # largest pressure where the bodies slip, Pa
    @property
    def normal(self) -> Normal: ...
    @property
    def friction_law(self) -> Friction: ...
    @property
    def bodies(self) -> Bodies: ...
    @property
    def loading(self) -> Loading: ...
    @property
    def unworn_sliding(self) -> Sliding: ...  # condition on the unworn reduced contact
    @property
    def coupling(self) -> float: ...  # κ of a single direction in this contact
    @property
    def tilt(self) -> float: ...  # slope along x of the reduced contact, due to a bulk stress
    @property
    def flexibility(self) -> float: ...  # in series with the contact, m/N
    # The condition on the reduced contact at a load, N, and an approach, m.
    def sliding(self, load: float, approach: float) -> Sliding: ...
    # Distances along x and y beyond which the unworn surface lies above an approach, m.
    def reach(self, approach: float) -> tuple[float, float]: ...


class WornContact(Protocol):
    """The end of a step, as far as cells for the next one depend on it."""

    @property
    def pressure(self) -> Array: ...  # Pa
    @property
    def wear(self) -> Array: ...  # m
    @property
    def plastic(self) -> Array: ...  # plastic depth, m
    @property
    def reduced(self) -> Any: ...  # the contact whose pressure sticks
