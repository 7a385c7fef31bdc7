"""One case over its cycles, and the zones of its contact."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from fretwear.vocabulary import ContactState

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Evolution:
    """A case over its cycles.

    Parameters
    ----------
    dataset : xarray.Dataset
        Dataset of the case, quarter or whole contact.
    history : xarray.Dataset
        Its scalars at every accepted step.
    """

    dataset: xr.Dataset
    history: xr.Dataset

    @cached_property
    def cycles(self) -> tuple[int, ...]:
        """Snapshots, cycle 0 first."""
        return tuple(int(cycle) for cycle in self.dataset["cycle"].values)

    @property
    def last(self) -> int:
        """The last cycle."""
        return self.cycles[-1]

    @property
    def worn_cycles(self) -> tuple[int, ...]:
        """Snapshots after cycle 0."""
        return tuple(cycle for cycle in self.cycles if cycle > 0)

    def nearest(self, cycle: int) -> int:
        """The snapshot nearest a cycle."""
        return min(self.cycles, key=lambda candidate: abs(candidate - cycle))

    def field(self, name: str, cycle: int) -> Array:
        """One field at a snapshot, SI unit, shape (nx, ny)."""
        snapshot = self.dataset[name].sel(cycle=cycle).transpose("x", "y")
        return snapshot.values.astype(np.float64)

    def state(self, cycle: int) -> NDArray[np.int8]:
        """State of every cell at a snapshot, values of `ContactState`, shape (nx, ny)."""
        snapshot = self.dataset["contact_state"].sel(cycle=cycle).transpose("x", "y")
        return np.asarray(snapshot.values, dtype=np.int8)

    def scalar(self, name: str, cycle: int) -> float:
        """One scalar at a snapshot, SI unit."""
        return float(self.dataset[name].sel(cycle=cycle))

    def parameter(self, name: str) -> float:
        """One case parameter, SI unit."""
        return float(self.dataset[name])

    def track(self, name: str) -> tuple[Array, Array]:
        """Cycle and one scalar at every accepted step."""
        cycles = self.history["cycle"].values.astype(np.float64)
        return cycles, self.history[name].values.astype(np.float64)

    def at(self, name: str, cycle: float) -> float:
        """One scalar at any cycle, linear between accepted steps."""
        return float(np.interp(cycle, *self.track(name)))

    @cached_property
    def spacing(self) -> float:
        """The larger side of a cell, m."""
        sides = [float(np.diff(self.dataset[name].values).mean()) for name in ("x", "y")]
        return max(sides)

    @cached_property
    def x(self) -> Array:
        """Positions along x, m, shape (nx, 1)."""
        return self.dataset["x"].values.astype(np.float64)[:, np.newaxis]

    @cached_property
    def y(self) -> Array:
        """Positions along y, m, shape (1, ny)."""
        return self.dataset["y"].values.astype(np.float64)[np.newaxis, :]

    @cached_property
    def radius(self) -> Array:
        """Distance of every cell from the middle, m, shape (nx, ny)."""
        distance: Array = np.hypot(self.x, self.y)
        return distance

    @property
    def is_rough(self) -> bool:
        """Whether the surface has waves."""
        return self.parameter("roughness_amplitude") > 0.0

    @property
    def wavenumbers(self) -> tuple[float, float]:
        """k_x and k_y of the waves, rad/m: k = (π/2)·tan θ/A."""
        amplitude = self.parameter("roughness_amplitude")
        slopes = (self.parameter("roughness_slope_x"), self.parameter("roughness_slope_y"))
        along_x, along_y = (0.5 * np.pi * np.tan(slope) / amplitude for slope in slopes)
        return float(along_x), float(along_y)

    def zones(self, cycle: int) -> Zones:
        """The stick and slip zones at a snapshot."""
        state = self.state(cycle)
        half_cell = 0.5 * self.spacing
        edges = []
        for zone in (state == ContactState.STICK, state != ContactState.OPEN):
            farthest = float(self.radius[zone].max(initial=0.0))
            edges.append(farthest + half_cell if zone.any() else 0.0)
        return Zones(self.radius, *edges)


@dataclass(frozen=True)
class Zones:
    """The stick zone as a disc and the slip zone as the ring around it.

    On a smooth sphere they are just that. On a rough one the disc is the smallest around all
    stick cells, the ring ends with the outermost cell in contact: valleys belong to both.

    Parameters
    ----------
    radius : array of shape (nx, ny)
        Distance of every cell from the middle, m.
    stick_radius, contact_radius : float
        c and b, m.
    """

    radius: Array
    stick_radius: float
    contact_radius: float

    @property
    def stick(self) -> Mask:
        """Cells of the stick zone."""
        inside: Mask = self.radius <= self.stick_radius
        return inside

    @property
    def slip(self) -> Mask:
        """Cells of the slip zone."""
        return self.between(0.0, 1.0)

    def between(self, start: float, end: float) -> Mask:
        """Cells of the slip zone from one fraction of its width to another."""
        fraction = self.place(self.radius)
        inside: Mask = (fraction > start) & (fraction <= end)
        return inside

    def place(self, radius: Array) -> Array:
        """Where a radius, m, lies in the slip zone: 0 at the edge of stick, 1 at its rim."""
        width = self.contact_radius - self.stick_radius
        result: Array = (radius - self.stick_radius) / width
        return result


@dataclass(frozen=True)
class Rings:
    """Means of a field over rings around the middle; they average waves out.

    Attributes
    ----------
    radius : array of shape (n,)
        Mean radius of each ring, m.
    mean : array of shape (n,)
        Mean of the field in each ring.
    cells : array of shape (n,)
        Number of cells of each ring.
    """

    radius: Array
    mean: Array
    cells: Array


def rings(evolution: Evolution, field: Array, within: Mask) -> Rings:
    """Average a field over rings, two cells wide or half a wave where that is wider.

    Parameters
    ----------
    evolution : Evolution
        Where the field belongs.
    field : array of shape (nx, ny)
        Any quantity.
    within : mask of shape (nx, ny)
        Cells that count.
    """
    width = ring_width(evolution)
    number = (evolution.radius[within] / width).astype(np.int64)
    cells = np.bincount(number).astype(np.float64)
    kept = cells > 0
    totals = np.bincount(number, weights=field[within])
    radii = np.bincount(number, weights=evolution.radius[within])
    return Rings(radii[kept] / cells[kept], totals[kept] / cells[kept], cells[kept])


def ring_width(evolution: Evolution) -> float:
    """Width of the rings of `rings`, m."""
    width = 2.0 * evolution.spacing
    if evolution.is_rough:
        along_x, along_y = evolution.wavenumbers
        width = max(width, np.pi / max(along_x, along_y))
    return width
