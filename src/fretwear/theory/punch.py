"""Contact of a body of revolution with any convex profile: a round punch, a measured profile.

By the method of dimensionality reduction the profile f becomes g(t) = t ∫₀^t f′(r)/√(t² − r²) dr.
A contact of the radius a has the approach g(a), the load 2E* ∫₀^a (g(a) − g(t)) dt and the pressure
(E*/π) ∫_r^a g′(t)/√(t² − r²) dt: V. L. Popov and M. Heß (2015), Method of Dimensionality Reduction
in Contact Mechanics and Friction, Springer.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from fretwear.theory.hertz import HertzContact
from fretwear.theory.limiting_state import find_root

_POINTS = 400


class Reduced(Protocol):
    """The profile of a body of revolution in the method of dimensionality reduction."""

    def __hash__(self) -> int: ...

    @property
    def reach(self) -> float:
        """Radius, m, that no contact may exceed."""

    def depth(self, radius: float) -> float:
        """g, m, at a radius in m."""

    def slope(self, radii: NDArray[np.float64]) -> NDArray[np.float64]:
        """g′ at radii in m."""

    def integral(self, radius: float) -> float:
        """∫₀^a g dt, m², up to a radius in m."""


@dataclass(frozen=True)
class RoundedPunch:
    """A punch, flat up to the radius b, with the gap (r − b)²/2R beyond, m."""

    flat_radius: float
    edge_radius: float

    @property
    def reach(self) -> float:
        """Radius, m, at which the edge has become steep."""
        return self.flat_radius + self.edge_radius

    def depth(self, radius: float) -> float:
        """G = (t/R)(√(t² − b²) − b arccos(b/t)), m."""
        root, angle = self._edge(radius)
        return radius / self.edge_radius * (root - self.flat_radius * angle)

    def slope(self, radii: NDArray[np.float64]) -> NDArray[np.float64]:
        """g′ = (2√(t² − b²) − b arccos(b/t))/R."""
        outside = np.maximum(radii, self.flat_radius)
        root = np.sqrt(outside**2 - self.flat_radius**2)
        angle = np.arccos(self.flat_radius / outside)
        result: NDArray[np.float64] = (2.0 * root - self.flat_radius * angle) / self.edge_radius
        return result

    def integral(self, radius: float) -> float:
        """∫₀^a g dt, m²."""
        root, angle = self._edge(radius)
        flat = self.flat_radius
        return (root**3 / 3.0 - 0.5 * flat * (radius**2 * angle - flat * root)) / self.edge_radius

    def _edge(self, radius: float) -> tuple[float, float]:
        outside = max(radius, self.flat_radius)
        root = math.sqrt(outside**2 - self.flat_radius**2)
        return root, math.acos(self.flat_radius / outside)


@dataclass(frozen=True)
class RoundContact(HertzContact):
    """Elastic contact of a body of revolution with a flat.

    ``radius`` is that of the sphere whose contact has the same radius under this load.
    """

    profile: Reduced = field(kw_only=True)

    @classmethod
    @lru_cache(maxsize=4096)
    def under(cls, profile: Reduced, load: float, composite_modulus: float) -> Self:
        """Contact under a load, N."""

        def missing(radius: float) -> float:
            return load - _load_at(profile, radius, composite_modulus)

        edge = profile.reach
        if missing(edge) < 0.0:
            edge = find_root(missing, 1e-9 * edge, edge)
        radius = 4.0 * composite_modulus * edge**3 / (3.0 * load)
        return cls(radius, load, composite_modulus, profile=profile)

    @property
    def approach(self) -> float:
        """δ = g(a), m."""
        return self.profile.depth(self.contact_radius)

    @property
    def central_pressure(self) -> float:
        """p(0), Pa."""
        return float(self.pressure_at(0.0))

    @cached_property
    def peak_pressure(self) -> float:
        """Largest pressure, Pa: anywhere, as a rule where the profile leaves a flat."""
        radii = np.linspace(0.0, 1.0, 201)[:-1] * self.contact_radius
        around = max(radii, key=self.pressure_at) + np.linspace(-1.0, 1.0, 101) * radii[1]
        return max(self.pressure_at(abs(radius)) for radius in around)

    def pressure_at(self, radius: float) -> float:
        """Pressure, Pa, at a distance from the axis, m.

        (E*/π) ∫ g′(t)/√(t² − r²) dt by t² = r² + v², where the integrand is bounded.
        """
        edge = self.contact_radius
        if radius >= edge:
            return 0.0
        length = math.sqrt(edge**2 - radius**2)
        at = np.hypot(radius, (np.arange(_POINTS) + 0.5) / _POINTS * length)
        total = float((self.profile.slope(at) / at).sum())
        return total * length / (_POINTS * math.pi) * self.composite_modulus

    def with_load(self, load: float) -> Self:
        """Contact of the same bodies under another load (N)."""
        return self.under(self.profile, load, self.composite_modulus)

    def with_approach(self, approach: float) -> Self:
        """Contact of the same bodies at an approach (m)."""
        profile = self.profile
        edge = find_root(lambda radius: approach - profile.depth(radius), 0.0, profile.reach)
        return self.with_load(self.load_at(edge))

    def load_at(self, contact_radius: float) -> float:
        """Load, N, of a contact of given radius, m."""
        return _load_at(self.profile, contact_radius, self.composite_modulus)

    def load_within(self, radius: float) -> float:
        """Load, N, carried by a central disc of given radius, m."""
        edge = min(radius, self.contact_radius)
        places = (np.arange(_POINTS) + 0.5) / _POINTS * edge
        total = math.fsum(r * self.pressure_at(r) for r in places)
        return 2.0 * math.pi * edge / _POINTS * total


def _load_at(profile: Reduced, radius: float, modulus: float) -> float:
    return 2.0 * modulus * (radius * profile.depth(radius) - profile.integral(radius))
