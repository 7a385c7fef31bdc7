"""An elastic film bonded to a half-space: what it adds to the displacements of the surface.

A traction of the wavenumber k moves the surface by F(k) times the traction. With m = G₁/G₂ of film
and substrate, θ = e^(−2kh), λ = 1 − 4(1 − ν₁)/(1 + m(3 − 4ν₂)) and χ = (m − 1)/(m + 3 − 4ν₁), the
normal displacement by a pressure and the displacement along k by a shear traction along k have

    F = (1 − ν₁)/(G₁k) (1 ± 4khχθ − λχθ²)/(1 − (λ + χ + 4χk²h²)θ + λχθ²)

with + and − (O'Sullivan and King 1988, J. Tribol. 110, 235-240; Nogi and Kato 1997, J. Tribol. 119,
493-500). Across k it is (1 + ρθ)/(1 − ρθ)/(G₁k) with ρ = (G₁ − G₂)/(G₁ + G₂).

At short waves F tends to c₁/k, the half-space of the film's material, and at long ones to c₂/k, the
substrate. So F = c₁/k + (c₂ − c₁)e^(−kz)/k + D with z = 2h has a closed transform apart from D,
which vanishes at both ends; one quadrature tabulates its transform in units of h. Half-spaces
without a film have c₂/k, and this module computes the difference.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Literal

import numpy as np

from fretwear.arrays import Array

# The depth z over h, the largest kh of a quadrature, and the distances over h of its table: even
# steps to the first, and the quadrature to the second, which grows with the length over which a
# stiff film bends. Beyond it transforms fall by a power of the distance.
_DEPTH, _LARGEST_WAVE = 2.0, 18.0
_EVEN, _FAR, _FARTHEST = 6.0, 30.0, 1e12
# Nodes of a panel, and the phase that it spans at most.
_NODES, _PHASE = 20, 20.0
# Cells over which transforms are integrated: within so many h, at least and at most so many.
# Beyond, transforms are interpolated linearly between so many distances.
_NEAR, _LEAST_NEAR, _MOST_NEAR, _PLACES = 8.0, 24, 64, 4000
# Nodes per cell along an axis, half of them if it is shorter than a fraction of h; and in the cell
# itself.
_PER_CELL, _SHORT, _IN_ITSELF = 4, 0.25, 32
# Panels of the waves of rings at most.
_MOST_PANELS = 100

_legendre = lru_cache(np.polynomial.legendre.leggauss)
_Transform = Literal["radial", "twisted", "line"]
# Powers of the distance by which transforms fall at last.
_POWERS: dict[_Transform, tuple[int, int]] = {"radial": (3, 5), "twisted": (2, 3), "line": (2, 4)}


@dataclass(frozen=True)
class Film:
    """A film on the flat, and the displacement that is asked for."""

    thickness: float  #: h, m
    shear_moduli: tuple[float, float]  #: G of film and substrate, Pa
    poisson_ratios: tuple[float, float]  #: ν of film and substrate
    #: The normal displacement under a pressure; or that along x under a traction along x. The
    #: latter depends on the direction or, if alike, is averaged over all directions.
    way: Literal["normal", "along", "alike"] = "normal"
    per: float = 1.0  #: divisor of all displacements

    # Responses times k, 1/Pa, at kh.

    def normal(self, waves: Array) -> Array:
        """KF of the normal displacement under a pressure."""
        return self._in_plane(waves, 4.0)

    def along(self, waves: Array) -> Array:
        """KF of the displacement along k under a shear traction along k."""
        return self._in_plane(waves, -4.0)

    def across(self, waves: Array) -> Array:
        """KF of the displacement across k under a shear traction across k."""
        first, second = self.shear_moduli
        part = (first - second) / (first + second) * np.exp(-2.0 * waves)
        return np.asarray((1.0 + part) / (1.0 - part) / first)

    def _in_plane(self, waves: Array, factor: float) -> Array:
        (first, second), (nu1, nu2) = self.shear_moduli, self.poisson_ratios
        ratio = first / second
        of_pressure = 1.0 - 4.0 * (1.0 - nu1) / (1.0 + ratio * (3.0 - 4.0 * nu2))
        of_shear = (ratio - 1.0) / (ratio + 3.0 - 4.0 * nu1)
        fall, both = np.exp(-2.0 * waves), of_pressure * of_shear
        top = 1.0 + factor * of_shear * waves * fall - both * fall**2
        bottom = 1.0 - (of_pressure + of_shear + 4.0 * of_shear * waves**2) * fall + both * fall**2
        return np.asarray((1.0 - nu1) / first * top / bottom)

    def _response(self, transform: _Transform) -> Callable[[Array], Array]:
        if self.way == "normal":
            return self.normal
        if transform == "line":  # plane strain
            return self.along
        sign = -1.0 if transform == "twisted" else 1.0
        return lambda waves: 0.5 * (self.along(waves) + sign * self.across(waves))

    def rise(self, transform: _Transform) -> float:
        """C₂ − c₁ of a response, 1/Pa."""
        long, short = self._response(transform)(np.array([0.0, 1e3])) / self.per
        return float(long - short)

    def widening(self, modulus: float) -> float:
        """Largest width of a line contact over its width without the film; 1 for a stiffer film.

        ``modulus`` is E* of the bodies without the film, Pa.
        """
        return math.sqrt(max(1.0, 1.0 - 0.5 * modulus * self.rise("radial")))

    # Displacements that the film adds to those of a half-space of the substrate.

    def on_cells(self, shape: tuple[int, int], spacing: tuple[float, float]) -> Array:
        """Displacement of cell (i, j) per unit pressure on cell (0, 0), m/Pa, shape (nx, ny).

        Near cells are integrated; elsewhere the value in the middle suffices.
        """
        x, y = (np.arange(float(n)) * size for n, size in zip(shape, spacing, strict=True))
        distance = np.hypot(x[:, None], y)
        distance[0, 0] = min(spacing)
        places = np.geomspace(min(spacing), 1.01 * distance.max(), _PLACES)
        near = [
            min(n, max(_LEAST_NEAR, min(math.ceil(_NEAR * self.thickness / size), _MOST_NEAR)))
            for n, size in zip(shape, spacing, strict=True)
        ]
        cells, of_near = np.zeros(shape), np.zeros(near)
        for transform in ("radial", "twisted") if self.way == "along" else ("radial",):
            values = np.interp(distance, places, self._far(transform, places))
            cells += _turned(transform, values, x[:, None], y)
            of_near += self._near(transform, near, spacing)
        cells *= math.prod(spacing)
        cells[: near[0], : near[1]] = of_near
        return cells

    def _far(self, transform: _Transform, places: Array) -> Array:
        """What a film adds to a transform at distances, m, of points."""
        depth = _DEPTH * self.thickness
        far = np.hypot(places, depth)
        part = 1.0 if transform == "radial" else (places / (far + depth)) ** 2
        factor = self.rise(transform) / (2.0 * math.pi)
        return np.asarray(factor * (part / far - 1.0 / places) + self._rest(transform, places))

    def _near(
        self, transform: _Transform, shape: Sequence[int], spacing: tuple[float, float]
    ) -> Array:
        """The same integrated over cells: in closed form at their corners, and by quadrature."""
        corners = [(np.arange(n + 1) - 0.5) * d for n, d in zip(shape, spacing, strict=True)]
        x, y = np.asarray(corners[0][:, None], np.float64), np.asarray(corners[1], np.float64)
        depth, sign = _DEPTH * self.thickness, 1.0 if transform == "radial" else -1.0
        added = _below(x, y, depth) - x * np.arcsinh(y / np.abs(x))
        added += sign * (_below(y, x, depth) - y * np.arcsinh(x / np.abs(y)))
        factor = self.rise(transform) / (2.0 * math.pi)
        result = factor * np.diff(np.diff(added, axis=0), axis=1)

        def rest(x: Array, y: Array) -> Array:
            values = self._rest(transform, np.hypot(x, y))
            return _turned(transform, values, x, y)

        is_short = max(spacing) <= _SHORT * self.thickness
        nodes, weights = _legendre(_PER_CELL // 2 if is_short else _PER_CELL)
        x, y = (
            (np.arange(n)[:, None] + 0.5 * nodes) * d for n, d in zip(shape, spacing, strict=True)
        )
        values = rest(x[:, :, None, None], y)
        means = np.einsum("iajb,a,b->ij", values, 0.5 * weights, 0.5 * weights)
        # The cell itself, by a quarter whose nodes are dense at the middle.
        nodes, weights = _legendre(_IN_ITSELF)
        parts = (0.5 + 0.5 * nodes) ** 3
        weights = 1.5 * weights * np.cbrt(parts) ** 2
        own = rest(0.5 * spacing[0] * parts[:, None], 0.5 * spacing[1] * parts)
        means[0, 0] = weights @ own @ weights
        return np.asarray(result + math.prod(spacing) * means)

    def on_strips(self, reference: float) -> Callable[[Array], Array]:
        """A function of distances, m, whose second derivative is the displacement, 1/Pa.

        The displacement by a unit load per length is zero at the distance ``reference``, m.
        """
        depth, rise = _DEPTH * self.thickness, self.rise("line") / math.pi
        spline = _table(self._plain, "line")
        scale = self.thickness**2 / self.per
        twice, far = spline.antiderivative(2), float(self._rest("line", np.array(reference)))
        far += rise * math.log(reference / math.hypot(reference, depth))

        def integral(x: Array) -> Array:
            x = np.abs(x)
            log = np.log(np.maximum(x, np.finfo(float).tiny) / np.hypot(x, depth))
            bent = 0.5 * x**2 * log + 0.25 * depth**2 * np.log1p((x / depth) ** 2)
            bent -= depth * x * np.arctan2(x, depth)
            return np.asarray(rise * bent + scale * twice(x / self.thickness) - 0.5 * far * x**2)

        return integral

    def on_rings(self, edges: Array, unit: Array) -> Array:
        """Displacement integrated over each ring under a unit pressure on each, m³/Pa.

        Waves of rings are differences of 2πr J₁(kr)/k at the radii of their edges, and the integral
        is ∫ b b' kF dk/2π. From the largest wavenumber on, kF stays as it is there; ``unit`` is the
        integral for kF = 1. ``edges`` are the radii, m, of the edges of n rings from 0 outward; the
        result, shape (n, n), is symmetric.
        """
        response, reach = self._response("radial"), 2.0 * float(edges[-1])
        largest = min(_LARGEST_WAVE / self.thickness, _MOST_PANELS * _PHASE / reach)
        waves, weights, rings = _waves_of_rings(tuple(edges.tolist()), largest)
        first, last = response(np.array([0.0, largest * self.thickness])) / self.per
        values = response(waves * self.thickness) / self.per - last
        moved = (2.0 * math.pi * weights * values)[:, None] * rings
        return np.asarray(rings.T @ moved + (last - first) * unit)

    @property
    def _plain(self) -> Film:
        """The film whose tables all films of its elasticity and way share."""
        return replace(self, thickness=1.0, per=1.0)

    def _rest(self, transform: _Transform, distances: Array) -> Array:
        """The transform of D at distances, m: in 1/(Pa m), on a line in 1/Pa."""
        scale = self.per * (1.0 if transform == "line" else self.thickness)
        values = _table(self._plain, transform)(np.minimum(distances / self.thickness, _FARTHEST))
        return np.asarray(values / scale)


def _turned(transform: _Transform, values: Array, x: Array, y: Array) -> Array:
    """Values of a transform by distance at places, m: twisted ones change sign with direction."""
    if transform == "radial":
        return values
    square = np.maximum(x**2 + y**2, np.finfo(float).tiny)
    return np.asarray(values * ((y - x) * (y + x) / square))


def _below(x: Array, y: Array, depth: float) -> Array:
    """Integral of x/(ρ + z) over y, of the distance ρ from a point at a depth z, m.

    Its difference over the corners of a cell is the integral of ∂²(ρ − z ln(ρ + z))/∂x²; the sum of
    that along x and along y is 1/ρ, and the transforms of e^(−kz)/k follow from both.
    """
    distance = np.sqrt(x**2 + y**2 + depth**2)
    turn = np.arctan(depth * y / (x * distance)) - np.arctan(y / x)
    return np.asarray(x * np.arcsinh(y / np.hypot(x, depth)) + depth * turn)


def _nodes(largest: float, distance: float) -> tuple[Array, Array]:
    """Nodes and weights of an integral over wavenumbers that oscillates over a distance."""
    count = math.ceil(largest * distance / _PHASE)
    nodes, weights = _legendre(_NODES)
    half = 0.5 * largest / count
    waves = half * (nodes + 1.0) + 2.0 * half * np.arange(count)[:, None]
    return waves.ravel(), np.tile(half * weights, count)


@lru_cache(1)
def _waves_of_rings(edges: tuple[float, ...], largest: float) -> tuple[Array, Array, Array]:
    """Wavenumbers up to a largest, weights, and waves r J₁(kr)/k of rings, m².

    The last has shape (waves, n). Pressure and tractions ask for the same in turn.
    """
    from scipy.special import j1  # takes half a second

    waves, weights = _nodes(largest, 2.0 * edges[-1])
    at_edges = edges * j1(np.outer(waves, edges))
    return waves, weights, np.diff(at_edges, axis=1) / waves[:, None]


@lru_cache(32)
def _table(film: Film, transform: _Transform) -> Any:
    """The transform of D over the distance, for a film of unit thickness, as a cubic spline."""
    from scipy.interpolate import CubicSpline  # takes half a second
    from scipy.special import j0, jv

    first, second = film.shear_moduli
    far = _FAR * max(1.0, first / second) ** (1.0 / 3.0)
    waves, weights = _nodes(_LARGEST_WAVE, far)
    response, rise = film._response(transform), film.rise(transform)
    rest = response(waves) - response(np.array(1e3)) - rise * np.exp(-_DEPTH * waves)
    rest *= weights
    outer = np.geomspace(_EVEN, far, math.ceil(math.log(far / _EVEN) / 0.03))[1:]
    places = np.append(np.linspace(0.0, _EVEN, 61), outer)
    phases = np.outer(places, waves)
    if transform == "radial":
        values = j0(phases) @ rest / (2.0 * math.pi)
    elif transform == "twisted":
        # A wave along k at an angle φ, cos 2φ, becomes −cos 2θ, here times y² − x² over r².
        values = jv(2, phases) @ rest / (2.0 * math.pi)
    else:
        values = np.cos(phases) @ (rest / waves) / math.pi
    powers, last = np.array(_POWERS[transform]), slice(-12, None, 11)
    falls = np.linalg.solve((far / places[last, None]) ** powers, values[last])
    far_places = np.geomspace(far, _FARTHEST, 160)[1:]
    values = np.append(values, (far / far_places[:, None]) ** powers @ falls)
    return CubicSpline(np.append(places, far_places), values)
