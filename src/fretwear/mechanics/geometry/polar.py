"""Rings at several angles: a smooth contact that friction in two directions stretches along y.

A sphere with friction as a vector keeps the symmetry about both axes, but not by rotation. Fields
have a value on each ring at angles that divide a quarter evenly, both axes included, and vary
between them like the waves cos 2kθ and sin 2kθ that these values determine. The influence of waves
comes from `fretwear.mechanics.geometry.harmonics`: one wave of pressure causes one of displacement,
and waves of shear couple in pairs. So a displacement takes a product of small matrices for each
wave, and a few conjugate gradients, preconditioned by the problem of uniform rings, solve the
linear problem of the free cells.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self, cast

import numpy as np
from numpy.typing import NDArray

from fretwear.arrays import Array, Element, Mask, Single
from fretwear.mechanics.contact import Contact, ContactProblem
from fretwear.mechanics.geometry import CellProblem, Parts, Real, Region, Way, Zone
from fretwear.mechanics.geometry.dense import DenseHalfSpace
from fretwear.mechanics.geometry.grid import Grid
from fretwear.mechanics.geometry.harmonics import RingHarmonics
from fretwear.mechanics.geometry.rings import Rings
from fretwear.mechanics.shear import ShearSpace
from fretwear.mechanics.team import ALONE, Team, kernels

# Intervals between the angles of a quarter, of elastic bodies and of those that yield.
_INTERVALS, _YIELDING = 4, 8
# How often the edge of a zone is moved for its area on a grid to be that at all angles.
_ADJUSTMENTS = 4
# Factor by which conjugate gradients reduce the residual of a linear problem, and their number.
_REDUCTION, _ITERATIONS = 1e-4, 60
# Compliance of rings without a free cell, over their own.
_BOUND = 1e6
# Iterations up to which a preconditioner is kept, and part of the rings that it may lack.
_FEW, _CHANGED = 12, 0.03


@dataclass(frozen=True)
class Polar(Rings):
    """Concentric rings, each with values at angles of a quarter from the x to the y axis."""

    intervals: int = _INTERVALS  #: between the angles of a quarter

    @classmethod
    def first(cls, problem: CellProblem) -> Self:
        """Rings as of one direction, at more angles where bodies yield.

        There the edge of stick is not round, and a peak of pressure crosses rings with it.
        """
        yields = not math.isinf(problem.slip_limit)
        return replace(super().first(problem), intervals=_YIELDING if yields else _INTERVALS)

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rings and of angles."""
        return len(self.edges) - 1, self.intervals + 1

    @property
    def angles(self) -> Array:
        """Angles from the x axis, rad, shape (angles,)."""
        return np.linspace(0.0, 0.5 * math.pi, self.intervals + 1)

    @property
    def shares(self) -> Array:
        """Part of a ring that each angle represents, by the trapezoidal rule."""
        shares = np.full(self.intervals + 1, 1.0 / self.intervals)
        shares[[0, -1]] *= 0.5
        return shares

    @property
    def y(self) -> Array:
        """Zero for each angle: unworn bodies have the same gap at all of them."""
        return np.zeros(self.intervals + 1)

    @property
    def rings(self) -> Rings:
        """The rings without the angles."""
        return Rings(self.edges)

    def along(self, axis: int) -> list[tuple[Way, Array]]:
        """Cells on an axis, and their distances, m."""
        return [((slice(None), -axis), self.x)]

    @property
    def ways(self) -> list[list[tuple[Way, Array]]]:
        """Cells at each angle."""
        return [[((slice(None), angle), self.x)] for angle in range(self.intervals + 1)]

    def zone(self, region: Region) -> Zone:
        """The zone of a region, which ends at its distance at each angle."""
        rings, count = self.rings, self.intervals + 1
        radii, zones = np.broadcast_to(region.radii, count), []
        for angle, share in enumerate(self.shares):
            zone = rings.zone(Region(region.cells[:, angle, None], float(radii[angle])))
            inside, outside = (count * rows + angle for rows in (zone.inside, zone.outside))
            # An edge cuts the same cells at neighbouring angles.
            deviations = math.sqrt(count) * share * zone.deviations
            zones.append((share * zone.area, inside, outside, deviations))
        areas, *places = zip(*zones, strict=True)
        inside, outside, deviations = map(np.concatenate, places)
        return Zone(float(sum(areas)), inside, outside, deviations)

    def covered(self, region: Region, plane: Grid) -> Array:
        """The fraction of each cell of a grid within a region.

        Its edge lies at its distance at each angle, and nearly so between angles.
        """
        radii = np.broadcast_to(region.radii, self.intervals + 1).astype(np.float64)
        cells = region.cells & (np.asarray(self.edges[:-1])[:, None] < radii)
        if not cells.any():
            return np.zeros(plane.shape)
        # Open parts within the zone.
        within = np.logical_or.accumulate(cells[::-1])[::-1]
        holes = 1.0 - self.written({"": np.where(within, cells, 1.0)}, plane)[""]
        edge = self._between(radii[:, None, None] * np.ones(plane.shape), plane)
        x, y = (
            np.arange(n + 1.0) * side for n, side in zip(plane.shape, plane.spacing, strict=True)
        )
        sides = x[:-1, None], x[1:, None], y[None, :-1], y[None, 1:]
        area, fractions = self.zone(region).area, np.zeros(plane.shape)
        for _ in range(_ADJUSTMENTS):
            fractions = np.clip(self._within(sides, edge) - holes, 0.0, 1.0)
            edge *= math.sqrt(area / plane.integral(fractions))
        return fractions

    def largest_mean(self, field: Array, width: float) -> float:
        """Largest mean of a field over a part of an annulus of a width, m, at one angle."""
        return max(self.rings.largest_mean(column[:, None], width) for column in field.T)

    def written(
        self, fields: dict[str, NDArray[Element]], plane: Grid
    ) -> dict[str, NDArray[Element]]:
        """Means of fields over the cells of a grid, at the angle of the middle of each cell."""
        angles = range(self.intervals + 1)
        columns = {
            f"{name} {angle}": field[:, angle, None]
            for name, field in fields.items()
            for angle in angles
        }
        at_angles = self.rings.written(columns, plane)
        result: dict[str, NDArray[Element]] = {}
        for name in fields:
            planes = np.stack([at_angles[f"{name} {angle}"] for angle in angles])
            if planes.dtype.kind == "f":
                result[name] = self._between(planes, plane).astype(planes.dtype)
            else:
                nearest = np.rint(self._angle(plane)).astype(np.intp)
                result[name] = np.take_along_axis(planes, nearest[None], 0)[0]
        return result

    def _angle(self, plane: Grid) -> Array:
        """Angles of the middles of the cells of a grid, in intervals."""
        return np.asarray(np.arctan2(plane.y, plane.x[:, None]) / self.angles[1])

    def _between(self, fields: NDArray[np.float64], plane: Grid) -> Array:
        """Fields on a grid at each angle, shape (angles, nx, ny), at the angle of each cell.

        They follow cubics through the values at neighbouring angles, and stay between these.
        """
        last, angle = self.intervals, self._angle(plane)
        before = np.clip(angle.astype(np.intp), 0, last - 1)
        part = angle - before
        # Slopes of the parabolas through three angles, one-sided on the axes.
        slopes = np.empty_like(fields)
        slopes[1:-1] = 0.5 * (fields[2:] - fields[:-2])
        for end, inward in ((0, 1), (last, -1)):
            near, far = fields[end + inward], fields[end + 2 * inward]
            slopes[end] = inward * (2.0 * near - 1.5 * fields[end] - 0.5 * far)
        (low, high), (first, second) = (
            [np.take_along_axis(values, place[None], 0)[0] for place in (before, before + 1)]
            for values in (fields, slopes)
        )
        rise = high - low
        bend = part * (1.0 - part) * ((1.0 - part) * (first - rise) - part * (second - rise))
        result = low + part * rise + bend
        return np.asarray(np.clip(result, np.minimum(low, high), np.maximum(low, high)))

    def half_space(
        self,
        modulus: float,
        team: Team = ALONE,  # noqa: ARG002
        parts: Parts | None = None,  # noqa: ARG002
    ) -> PolarHalfSpace:
        """The elastic bodies on the cells."""
        return PolarHalfSpace(self, modulus)

    @cached_property
    def cosines(self) -> Array:
        """Values of cos 2kθ at the angles, shape (angles, waves)."""
        waves = np.arange(self.intervals + 1)
        return np.asarray(np.cos(2.0 * waves * self.angles[:, None]))

    @cached_property
    def sines(self) -> Array:
        """Values of sin 2kθ at the angles, shape (angles, waves); exactly zero on both axes."""
        waves = np.arange(self.intervals + 1)
        sines: Array = np.sin(2.0 * waves * self.angles[:, None])
        sines[[0, -1]] = sines[:, [0, -1]] = 0.0
        return sines

    @cached_property
    def factors(self) -> Array:
        """Squares of the waves over their mean square at the angles, shape (waves,).

        The last wave cannot be told from a uniform one of alternating sign.
        """
        factors = np.full(self.intervals + 1, 2.0)
        factors[[0, -1]] = 1.0
        return factors


class PolarHalfSpace(DenseHalfSpace):
    """The elastic half-space under a pressure that is uniform across each ring."""

    def __init__(self, geometry: Polar, modulus: float) -> None:
        self.geometry: Polar = geometry
        self.team, self._modulus = ALONE, modulus
        self._harmonics = RingHarmonics(np.asarray(geometry.edges), geometry.intervals)
        waves = range(geometry.intervals + 1)
        #: Influence of each wave, m/Pa, shape (waves, n, n).
        self.influence = np.stack([self._harmonics.along(wave) for wave in waves]) / modulus
        # Half of what the last wave displaces has its phase.
        self.influence[-1] *= 0.5
        self.self_influence = float(self.influence[0].diagonal().max())
        areas = np.diff(np.square(geometry.edges))
        self._areas: Array = areas / areas.mean()
        scaled = self.influence * (self._areas[:, None] / self.self_influence)
        self._matrices: Single = (0.5 * (scaled + scaled.transpose(0, 2, 1))).astype(np.float32)
        self._kept: _Inverse | None = None
        #: Amplitudes of waves by values at angles, (waves, angles), and back.
        self._to_waves = np.ascontiguousarray(
            (geometry.shares[:, None] * geometry.cosines * geometry.factors).T
        )
        self._from_waves = np.ascontiguousarray(geometry.cosines)
        self._sheared: tuple[float, PolarShear[Array]] | None = None

    def displacement(self, pressure: Array) -> Array:
        """Normal surface displacement w, m, of a pressure, Pa, in the mean over each ring."""
        along = self.influence.reshape(-1, len(self._areas))
        return np.asarray(
            _displaced(along, None, self._to_waves, self._from_waves, pressure[None])[0]
        )

    def sheared(self, coupling: float) -> PolarShear[Array]:
        """The same bodies under shear tractions, of κ = E*/G*."""
        if self._sheared is None or self._sheared[0] != coupling:
            shear = PolarShear.of(self.geometry, self._harmonics, self._modulus, coupling)
            self._sheared = coupling, shear
        return self._sheared[1]

    def solve(
        self, problem: ContactProblem, start: Array | None, tolerance: float, *, verified: bool
    ) -> Contact:
        """Solve a normal contact by factors of the matrix of its free cells."""
        # A resumed run must begin with the same.
        self._kept = None
        return super().solve(problem, start, tolerance, verified=verified)

    def _solved(self, displacements: Array, tangent: Single | None, free: Mask) -> Array:
        """Pressures on free cells that cause displacements in units of the self-influence.

        They are solved by conjugate gradients in single precision. The preconditioner is the
        inverse for rings any part of which is free, with the mean compliance of a layer on each; it
        is kept for further solutions of a contact as long as it serves them.
        """
        shares = self.geometry.shares
        rings: Mask = np.asarray(free.any(axis=1))
        count = int(np.flatnonzero(rings)[-1]) + 1
        free, areas, rings = free[:count], self._areas[:count, None], rings[:count]
        layer = np.zeros(free.shape)
        if tangent is not None:
            layer += np.where(free, tangent[:count], 0.0)
        mean = (layer @ shares) / np.maximum(free @ shares, 1e-12)
        compliance = np.where(rings, areas[:, 0] * mean, _BOUND)
        if self._kept is None or not self._kept.suits(rings):
            self._kept = _Inverse(rings, self._inverse(compliance))
        freed = rings & ~self._kept.rings[:count]
        added = freed / (self._matrices[0].diagonal()[:count] + compliance)
        left = displacements[:, :count] * areas * free
        scale = np.maximum(np.abs(left).max(axis=(1, 2), keepdims=True), np.finfo(float).tiny)
        pressures = _by_angles(left / scale).reshape(-1, count)
        taken = kernels.solve_on_rings(
            self._matrices.reshape(-1, len(self._areas)),
            self._kept.matrices,
            self._to_waves.astype(np.float32),
            self._from_waves.astype(np.float32),
            added[None].astype(np.float32),
            shares[None].astype(np.float32),
            _by_angles(areas * layer),
            _by_angles(free),
            _REDUCTION,
            _ITERATIONS,
            pressures,
        )
        if taken > _FEW:
            self._kept = None
        result = np.zeros_like(displacements)
        result[:, :count] = pressures.reshape(len(left), -1, count).transpose(0, 2, 1) * scale
        return result

    def _inverse(self, compliance: Array) -> Single:
        """Inverse of the influence of each wave between rings that have compliances of their own.

        The matrices of all waves stand below each other.
        """
        count = compliance.size
        inverse = self._matrices[:, :count, :count].copy()
        inverse[:, np.arange(count), np.arange(count)] += compliance.astype(np.float32)
        inverse = inverse.reshape(-1, count)
        kernels.invert(inverse)
        return inverse


@dataclass(frozen=True, eq=False)
class _Inverse:
    """A preconditioner: inverses of waves below each other, for some rings."""

    rings: Mask
    matrices: Single

    def suits(self, rings: Mask) -> bool:
        """Whether it preconditions a problem of the same rings, but for a few."""
        if rings.size > self.rings.size:
            return False
        changed = rings != self.rings[: rings.size]
        changes = np.count_nonzero(changed) + np.count_nonzero(self.rings[rings.size :])
        return bool(changes <= _CHANGED * rings.size)


def _by_angles(field: NDArray[np.generic]) -> Single:
    """A field in single precision with the angles before the rings, as kernels take it."""
    return np.ascontiguousarray(field.swapaxes(-1, -2), np.float32)


class PolarShear(ShearSpace[Real]):
    """The elastic bodies under shear tractions on rings at several angles.

    With complex numbers q_x + i q_y = ∑ c_j e^{2ijθ}, j = −m … m for m intervals, tractions even
    along both axes have real c_j. The wave j is displaced by itself and by 1 − j.
    """

    is_even = True

    def __init__(self, geometry: Polar, along: Real, across: Real) -> None:
        self.geometry: Polar = geometry
        #: Influence of the waves j on j, by |j|, shape ((m + 1) n, n), and of 1 − j on j, for
        #: j = 1 … m, then 0 … 1 − m, shape (2 m n, n).
        self._influence: tuple[Real, Real] = along, across
        last, count = geometry.intervals, len(geometry.edges) - 1
        diagonal: Array = np.asarray(along[:count].diagonal()[:, None], np.float64)
        self._own, self.self_influence = (
            np.broadcast_to(diagonal, geometry.shape),
            float(diagonal.max()),
        )
        order = np.concatenate([1 + np.arange(last), -np.arange(last), [-last]])
        number = np.abs(order)
        # Components along x and y of these waves at the angles, shape (2, waves, angles).
        cosines, sines = geometry.cosines.T, geometry.sines.T
        there: Array = np.stack([cosines[number], np.sign(order)[:, None] * sines[number]])
        # Both waves of the largest number have the same values at the angles.
        there[:, number == last] *= 0.5

        def by_rows(amplitudes: Array) -> Real:
            return cast("Real", np.concatenate([*amplitudes], axis=1).astype(along.dtype))

        #: Amplitudes of waves by components at angles, (waves, 2 (m + 1)), and back.
        self._to_waves: Real = by_rows(there * geometry.shares)
        self._from_waves: Real = cast("Real", np.ascontiguousarray(by_rows(there).T))

    @classmethod
    def of(
        cls, geometry: Polar, harmonics: RingHarmonics, modulus: float, coupling: float
    ) -> PolarShear[Array]:
        """The bodies of a composite modulus, Pa, and κ."""
        last: int = geometry.intervals
        order = (*range(1, last + 1), *range(0, -last, -1))
        along = np.concatenate([harmonics.along(wave) for wave in range(last + 1)])
        across = np.concatenate([harmonics.across(wave) for wave in order])
        mixing = coupling - 1.0
        return PolarShear(geometry, coupling / modulus * along, mixing / modulus * across)

    @property
    def own(self) -> Array:
        """Displacement of each ring by a uniform traction along x on it alone, m/Pa."""
        return self._own

    @cached_property
    def single(self) -> PolarShear[Single]:
        """The same in single precision, for displacements in units of the self-influence."""
        unit = self.self_influence
        along, across = ((influence / unit).astype(np.float32) for influence in self._influence)
        return PolarShear(self.geometry, along, across)

    @cached_property
    def _inverse(self) -> Real:
        """Inverse influence of waves on themselves."""
        areas = np.diff(np.square(self.geometry.edges)) / np.square(self.geometry.edges[-1])
        along = self._influence[0]
        matrices = along.reshape(-1, areas.size, areas.size) * areas[:, None].astype(along.dtype)
        inverse = np.ascontiguousarray(0.5 * (matrices + matrices.transpose(0, 2, 1)))
        kernels.invert(inverse.reshape(along.shape))
        return cast("Real", (inverse * areas.astype(along.dtype)).reshape(along.shape))

    def displacement(self, traction: Real) -> Real:
        """Relative displacement of the surfaces, m, under a traction, Pa."""
        return self._moved(traction, *self._influence)

    def inverse(self, traction: Real) -> Real:
        """The inverse, if waves did not couple: a slip in one direction moved by its mean."""
        return self._moved(traction, self._inverse, None)

    def _moved(self, field: Real, along: Real, across: Real | None) -> Real:
        return _displaced(along, across, self._to_waves, self._from_waves, field)


def _displaced(along: Real, across: Real | None, to: Real, back: Real, fields: Real) -> Real:
    """Displacement by fields at angles, shape (fields, n, angles): see the kernel."""
    rows = np.ascontiguousarray(fields.transpose(0, 2, 1)).reshape(-1, fields.shape[1])
    moved = np.empty_like(rows)
    kernels.displace_waves(along, across, to, back, rows, moved)
    at_angles = moved.reshape(len(fields), -1, fields.shape[1]).transpose(0, 2, 1)
    return cast("Real", np.ascontiguousarray(at_angles))
