"""Tractions over a cycle, by superposition, and the stress tensors of its phases.

From +Q to −Q a contact in partial slip reverses as it was loaded, at twice the size: where the
tangential force has fallen by 2µ(P − P̂), the shear traction has by 2µ(p − p̂), p̂ being the reduced
pressure of the same shape under the load P̂ (Ciavarella 1998, Jäger 1998), with the influence that
the slip model uses. The way back has the opposite signs. The shape follows from gap and pressure:
h = g + δ − w. Friction as a vector reverses by twice the traction that the force P̂ would load.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fretwear.arrays import Array, Even
from fretwear.mechanics.contact.cells import HalfSpace
from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.strips import Row, Strips
from fretwear.mechanics.slip.coupled import shear
from fretwear.mechanics.slip.models import ReducedContact, contact_under
from fretwear.mechanics.slip.shear import bodies_under_shear
from fretwear_cracks.edges import stresses_at_edge
from fretwear_cracks.influence import ODD
from fretwear_cracks.tractions import Tractions

# Tolerance of the contacts between the ends of the loop, which differ by much more.
_TOLERANCE = 1e-5
# Traction over the largest bound that counts as none.
_TINY = 1e-12


@dataclass(frozen=True)
class LoadedSurface:
    """The surface of a contact at +Q, on the cells of the positive sides where it is even."""

    pressure: Array  #: Pa, shape (nx, ny); in a line contact ny is 1
    shear: Array  #: along x at +Q, Pa
    gap: Array  #: m
    spacing: tuple[float, float]  #: cell size along x and y, m
    even: Even  #: whether it is even along x and along y
    friction: float  #: coefficient µ, of places that have not slipped if it follows slip
    composite_modulus: float  #: E*, Pa
    poisson_ratio: float  #: of the flat
    #: Distance at which displacements of a line contact are zero, m; None of a point contact.
    reference: float | None = None
    #: Shear along y at +Q, Pa, and κ, of friction in two directions.
    across: Array | None = None
    coupling: float = 1.0
    #: Whether slip follows from the influence of tractions along x, as of `Cerruti`.
    is_directed: bool = False
    tilt: float = 0.0  #: slope along x of the reduced contact at +Q, due to a bulk stress
    ratio: Array | float = 1.0  #: µ of each cell over the coefficient

    @property
    def friction_at_edge(self) -> float:
        """µ at the end of contact on the plane y = 0."""
        row = 0 if self.even[1] or self.plane_strain else self.pressure.shape[1] // 2
        loaded = np.flatnonzero(self.pressure[:, row])
        ratio = np.broadcast_to(self.ratio, self.pressure.shape)
        return self.friction * float(ratio[loaded[-1], row])

    @property
    def plane_strain(self) -> bool:
        """Whether it is a line contact."""
        return self.reference is not None

    @cached_property
    def half_space(self) -> HalfSpace:
        """The elastic bodies."""
        shape, spacing = (self.pressure.shape[0], self.pressure.shape[1]), self.spacing
        if self.reference is not None:
            if not self.even[0]:
                row = Row((shape[0], 1), spacing, (False, True), self.reference)
                return row.half_space(self.composite_modulus)
            edges = np.arange(shape[0] + 1.0) * spacing[0]
            return Strips(tuple(edges.tolist()), self.reference).half_space(self.composite_modulus)
        return Grid(shape, spacing, self.even).half_space(self.composite_modulus)

    @cached_property
    def sheared(self) -> HalfSpace:
        """The elastic bodies under shear along x, in units of displacements under pressure."""
        if not self.is_directed:
            return self.half_space
        return self.half_space.along_x(self.coupling, self.coupling)

    def vectors_over_half_a_loop(self, count: int) -> tuple[Array, Array | None]:
        """Shear along x and, if there is any, y as of `over_half_a_loop`.

        Slip turns a little between the two ways; a traction beyond friction is cut to it.
        """
        if self.across is None:
            return self.over_half_a_loop(count), None
        full, bound = np.stack([self.shear, self.across]), self.friction * self.pressure
        bodies = bodies_under_shear(self.half_space, self.coupling)
        shears, loaded = np.empty((2, count, *self.shear.shape)), full
        shears[:, 0] = full
        force = self.half_space.geometry.integral(self.shear)
        for step in range(count - 1, 0, -1):
            part = step / count
            loaded = shear(bodies, bound, part * force, start=part * full).traction
            vector = full - 2.0 * loaded
            length = np.hypot(*vector)
            shears[:, step] = vector * np.minimum(
                1.0, bound / np.maximum(length, bound.max() * _TINY)
            )
        return shears[0], shears[1]

    def over_half_a_loop(self, count: int) -> Array:
        """Shear along x at that many equal steps of the force from +Q to −Q, Pa.

        The shape is (count, nx, ny); the end at −Q, where all have the opposite sign, is left out.
        Friction acts along x alone.
        """
        shears = np.empty((count, *self.pressure.shape))
        shears[0] = self.shear
        full = below = self.ratio * self.pressure
        limit = self.friction * full
        for step in range(1, count):
            below = self.reduced(step / count, below).pressure
            fallen = 2.0 * self.friction * (full - below)
            shears[step] = np.clip(self.shear - fallen, -limit, limit)
        return shears

    def reduced(self, part: float, start: Array) -> ReducedContact:
        """The reduced contact after part of the way from +Q to −Q; 1 gives the one at +Q."""
        geometry, full = self.half_space.geometry, self.ratio * self.pressure
        load = geometry.integral(full - self.shear / self.friction * part)
        shape = self.gap - self.sheared.displacement(full)
        shape += part * self.tilt * geometry.x[:, None]
        start = start * (load / geometry.integral(start))
        return contact_under(self.sheared, shape, load, None, start, _TOLERANCE)


@dataclass(frozen=True)
class StressHistory:
    """Stresses below a surface at the phases of a loop, by equal steps of the tangential force.

    The first phase is +Q, the middle one −Q, and the last one step before +Q again.
    """

    surface: LoadedSurface
    phases: int  #: how many; even
    bulk_stress: float = 0.0  #: amplitude along x in the flat, Pa, in phase with the force
    mean_stress: float = 0.0  #: steady part of the stress along x in the flat, Pa

    @cached_property
    def tractions(self) -> Tractions:
        """The pressure, and the shear tractions of the first half of the loop."""
        surface = self.surface
        along, across = surface.vectors_over_half_a_loop(self.phases // 2)
        return Tractions(
            surface.pressure[None],
            along,
            surface.spacing,
            surface.even,
            surface.poisson_ratio,
            surface.plane_strain,
            across,
        )

    def section(self, depth: float) -> tuple[Array, Array]:
        """Stresses at one depth, m, on the plane y = 0: steady (6, nx), alternating (h, 6, nx), Pa.

        The alternating part is added at the phases of the first half of the loop and subtracted, in
        the same order, in the second half; see `Tractions.section`.
        """
        return self._with_bulk(self.tractions.section(depth))

    def at(self, points: Array) -> tuple[Array, Array]:
        """Stresses as of `section` at points (x, y, z), m, shapes (6, n) and (h, 6, n)."""
        return self._with_bulk(self.tractions.at(points))

    def at_edges(self) -> list[tuple[float, Array, Array]]:
        """Stresses of the surface at both ends of contact on the plane y = 0.

        For each end, if it can be told, its x, m, and both parts, shapes (6,) and (h, 6).
        """
        surface, tractions = self.surface, self.tractions
        pressure, shears = (
            tractions.on_both_sides(field) for field in (tractions.pressure, tractions.shear)
        )
        mirror = np.array([-1.0 if odd_x else 1.0 for odd_x, _ in ODD[0]])
        ends = []
        for side in (-1, 1):
            # The end at x > 0 is that at x < 0 of the mirror image under the opposite shear.
            edge = stresses_at_edge(
                pressure[0, ::-side],
                shears[:, ::-side],
                surface.friction_at_edge,
                surface.spacing,
                surface.poisson_ratio,
                plane_strain=tractions.plane_strain,
            )
            if edge is not None:
                steady, alternating = edge.of_pressure, edge.of_shears
                if side > 0:
                    steady, alternating = mirror * steady, -mirror * alternating
                both = self._with_bulk((steady[None], alternating))
                ends.append((-side * edge.x, *both))
        return ends

    def _with_bulk(self, parts: tuple[Array, Array]) -> tuple[Array, Array]:
        steady, alternating = parts[0][0], parts[1]
        ratio = 1.0 - 4.0 * np.arange(len(alternating)) / self.phases
        bulk = self.bulk_stress * ratio.reshape(-1, *[1] * (alternating.ndim - 2))
        across = self.surface.poisson_ratio if self.surface.plane_strain else 0.0
        for component, share in ((0, 1.0), (1, across)):
            steady[component] += share * self.mean_stress
            alternating[:, component] += share * bulk
        return steady, alternating


def over_the_loop(steady: Array, alternating: Array) -> Array:
    """Stresses at all phases, from both parts, along a first axis."""
    return np.concatenate([steady + alternating, steady - alternating])
