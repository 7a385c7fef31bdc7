"""Parameters for the initiation of fatigue cracks at points, from the stresses of a loop.

A loop is symmetric about its mean: with a steady part σ_m, the stresses are σ_m ± σ_a(t). So
amplitudes are the largest values of σ_a, and the longest chord of the path of a shear stress or of
a deviator is twice its largest distance from the mean.

Stresses are given at points, in the order of `COMPONENTS`: the steady part, Pa, has the shape
(6, n), the alternating part, Pa, the shape (h, 6, n) with one sign of each pair of phases.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fretwear.arrays import Array

# Planes are first tried at this angle, degrees, then around the best one at half of it and less,
# until that is as small as the second.
_COARSE, _FINE = 10.0, 0.2
# Values of phases, planes and points computed at a time.
_AT_A_TIME = 2**19
# Steps that gain less are not followed.
_BETTER = 1.0 + 1e-6


class OverPlanes(NamedTuple):
    """The largest value of a parameter over all planes of each point."""

    value: Array  #: shape (n,)
    normal: Array  #: unit normal of the plane, with z ≥ 0, shape (n, 3)


@dataclass(frozen=True)
class PointLoops:
    """Loops of stress at points of an elastic body."""

    steady: Array  #: Pa, shape (6, n)
    alternating: Array  #: Pa, shape (h, 6, n)
    youngs_modulus: float  #: Pa
    poisson_ratio: float

    def smith_watson_topper(self) -> OverPlanes:
        """Largest normal stress times the amplitude of normal strain, Pa, on the worst plane.

        Smith, Watson and Topper, "A stress-strain function for the fatigue of metals", J. Mater. 5
        (1970); zero where no plane is ever in tension.
        """
        nu = self.poisson_ratio

        def on_planes(loops: _Loops, planes: Array) -> Array:
            normal = loops.alternating(planes)
            largest = loops.largest(planes, normal)
            normal *= 1.0 + nu
            normal -= nu * loops.traces
            strain = np.abs(normal, out=normal).max(axis=-1)
            return np.asarray(np.maximum(largest, 0.0) * strain / self.youngs_modulus)

        return self._worst_plane(on_planes)

    def fatemi_socie(self, normal_sensitivity: float, yield_strength: float) -> OverPlanes:
        """Amplitude of shear strain, times 1 + k σ_n,max/σ_y, on the worst plane.

        Fatemi and Socie, "A critical plane approach to multiaxial fatigue damage including
        out-of-phase loading", Fatigue Fract. Eng. Mater. Struct. 11 (1988), with k and the yield
        strength σ_y, Pa; compression does not count.
        """
        shear_modulus = self.youngs_modulus / (2.0 * (1.0 + self.poisson_ratio))

        def on_planes(loops: _Loops, planes: Array) -> Array:
            normal = loops.alternating(planes)
            worse = np.maximum(loops.largest(planes, normal), 0.0) / yield_strength
            square = loops.squared(planes)
            square -= np.multiply(normal, normal, out=normal)
            strain = np.sqrt(np.maximum(square.max(axis=-1), 0.0)) / shear_modulus
            return np.asarray(strain * (1.0 + normal_sensitivity * worse))

        return self._worst_plane(on_planes)

    def crossland(self, mean_stress_sensitivity: float) -> Array:
        """√J2,a + α P_H,max, Pa, shape (n,).

        √J2,a is half the longest chord of the path of the deviator over √2, P_H,max the largest
        mean of the three normal stresses.

        Crossland, "Effect of large hydrostatic pressures on the torsional fatigue strength of an
        alloy steel", Proc. Int. Conf. Fatigue of Metals, London (1956).
        """
        amplitude = von_mises(np.moveaxis(self.alternating, 1, 0)).max(axis=0) / math.sqrt(3.0)
        traces = abs(self.alternating[:, :3].sum(axis=1)).max(axis=0)
        mean = (self.steady[:3].sum(axis=0) + traces) / 3.0
        return np.asarray(amplitude + mean_stress_sensitivity * mean)

    def _worst_plane(self, on_planes: Callable[[_Loops, Array], Array]) -> OverPlanes:
        """Maximize a parameter over the planes of each point.

        It is a function of loops of n points and of unit normals, shape (planes, 3) for all points
        or (n, planes, 3), with values of the shape (n, planes).
        """
        coarse, count = _hemisphere(math.radians(_COARSE)), self.steady.shape[1]
        value, normal = np.empty(count), np.empty((count, 3))
        at_once = max(1, _AT_A_TIME // (len(self.alternating) * len(coarse)))
        for first in range(0, count, at_once):
            points = np.arange(first, min(first + at_once, count))
            loops = _Loops.of(self, points)
            tried = on_planes(loops, coarse)
            normal[points] = coarse[tried.argmax(axis=1)]
            value[points] = tried.max(axis=1)
            angle = np.full(points.size, 0.5 * math.radians(_COARSE))
            while (searched := np.flatnonzero(angle > math.radians(_FINE))).size:
                some = points[searched]
                around = _around(normal[some], angle[searched])
                tried = on_planes(loops.part(searched), around)
                places, rows = tried.argmax(axis=1), np.arange(some.size)
                trial = tried[rows, places]
                better = trial > value[some] * _BETTER
                normal[some[better]] = around[rows, places][better]
                value[some[better]] = trial[better]
                angle[searched[~better]] *= 0.5
        normal[normal[:, 2] < 0.0] *= -1.0
        return OverPlanes(value, normal)


@dataclass(frozen=True)
class _Loops:
    """The same for products with planes: tensors of n points and h phases, shape (n, 6, h)."""

    mean: Array  # (n, 6, 1)
    part_of_phase: Array
    squares: Array
    traces: Array  # (n, 1, h)

    @classmethod
    def of(cls, loops: PointLoops, points: NDArray[np.intp]) -> _Loops:
        """The loops at some of the points."""
        xx, yy, zz, xy, xz, yz = parts = np.moveaxis(loops.alternating[..., points], 1, 0)
        # With the squared tensors, n·σ²·n is the square of the traction |σn|.
        squares = [xx * xx + xy * xy + xz * xz, xy * xy + yy * yy + yz * yz]
        squares += [xz * xz + yz * yz + zz * zz, xx * xy + xy * yy + xz * yz]
        squares += [xx * xz + xy * yz + xz * zz, xy * xz + yy * yz + yz * zz]
        of_phase, squared = (
            np.ascontiguousarray(np.transpose(a, (2, 0, 1))) for a in (parts, squares)
        )
        traces = of_phase[:, :3].sum(axis=1, keepdims=True)
        return cls(loops.steady[:, points].T[:, :, None], of_phase, squared, traces)

    def part(self, points: NDArray[np.intp]) -> _Loops:
        """Some of these points."""
        return _Loops(*(values[points] for values in vars(self).values()))

    def alternating(self, planes: Array) -> Array:
        """Alternating normal stress on planes, shape (n, planes, h)."""
        return np.asarray(_weights(planes) @ self.part_of_phase)

    def squared(self, planes: Array) -> Array:
        """Square of the alternating traction on planes, shape (n, planes, h)."""
        return np.asarray(_weights(planes) @ self.squares)

    def largest(self, planes: Array, alternating: Array) -> Array:
        """Largest normal stress on planes, shape (n, planes), given the alternating one."""
        steady = (_weights(planes) @ self.mean)[..., 0]
        return np.asarray(steady + abs(alternating).max(axis=-1))


def von_mises(stress: Array) -> Array:
    """The von Mises stress of tensors of shape (6, ...)."""
    xx, yy, zz, xy, xz, yz = stress
    differences = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    return np.asarray(np.sqrt(0.5 * differences + 3.0 * (xy**2 + xz**2 + yz**2)))


def _weights(planes: Array) -> Array:
    """Weights of the components of a tensor in n·σ·n, shape (..., 6) for normals (..., 3)."""
    x, y, z = np.moveaxis(planes, -1, 0)
    return np.stack([x * x, y * y, z * z, 2 * x * y, 2 * x * z, 2 * y * z], axis=-1)


def _hemisphere(angle: float) -> Array:
    """Unit vectors with z ≥ 0 about an angle apart, shape (planes, 3)."""
    vectors = []
    for polar in np.linspace(0.0, math.pi / 2, math.ceil(math.pi / 2 / angle) + 1):
        count = max(1, math.ceil(2 * math.pi * math.sin(polar) / angle))
        turn = 2 * math.pi / count * np.arange(count)
        up = np.full(count, math.cos(polar))
        vectors.append(
            np.stack([math.sin(polar) * np.cos(turn), math.sin(polar) * np.sin(turn), up])
        )
    return np.concatenate(vectors, axis=1).T


def _around(normals: Array, angles: Array) -> Array:
    """Unit vectors in eight directions at an angle from each of some, shape (n, 8, 3)."""
    least = np.eye(3)[abs(normals).argmin(axis=1)]
    first = np.cross(normals, least)
    first /= np.linalg.norm(first, axis=1)[:, None]
    second = np.cross(normals, first)
    turn = 2 * math.pi / 8 * np.arange(8)[:, None]
    sideways = np.cos(turn) * first[:, None] + np.sin(turn) * second[:, None]
    tilt = angles[:, None, None]
    return np.asarray(np.cos(tilt) * normals[:, None] + np.sin(tilt) * sideways)
