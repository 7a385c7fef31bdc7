"""Round flat punch with a rounded edge, by the method of dimensionality reduction.

V. L. Popov and M. Heß (2015), Method of Dimensionality Reduction in Contact Mechanics and
Friction, Springer: the profile f = (r − b)²/2R of the edge becomes
g(t) = (t/R)(√(t² − b²) − b arccos(b/t)), from which load and pressure follow by integration.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

_POINTS = 200


@dataclass(frozen=True)
class RoundPunchContact:
    """Elastic contact of a flat with a punch that is flat up to the radius b.

    Attributes
    ----------
    flat_radius : float
        b, m.
    edge_radius : float
        R of the parabola (r − b)²/2R beyond, m.
    load : float
        Normal load P, N.
    composite_modulus : float
        E*, Pa.
    """

    flat_radius: float
    edge_radius: float
    load: float
    composite_modulus: float

    @cached_property
    def contact_radius(self) -> float:
        """a, m."""
        flat = self.flat_radius
        # The load is more than that of a paraboloid without its flat, less than with a on top.
        low, high = (
            flat,
            flat + math.cbrt(0.75 * self.load * self.edge_radius / self.composite_modulus),
        )
        while self.load_at(high) < self.load:
            high += high - flat
        for _ in range(200):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.load_at(middle) < self.load else (low, middle)
        return 0.5 * (low + high)

    def load_at(self, contact_radius: float) -> float:
        """Load, N, of a contact of some radius, m."""
        root, angle = self._edge(contact_radius)
        square, flat = contact_radius**2, self.flat_radius
        bracket = square * root - root**3 / 3.0 - 0.5 * flat * (flat * root + square * angle)
        return 2.0 * self.composite_modulus / self.edge_radius * bracket

    def _edge(self, radius: float) -> tuple[float, float]:
        root = math.sqrt(max(0.0, radius**2 - self.flat_radius**2))
        return root, math.acos(min(1.0, self.flat_radius / radius))

    @property
    def approach(self) -> float:
        """δ = g(a), m."""
        root, angle = self._edge(self.contact_radius)
        return self.contact_radius / self.edge_radius * (root - self.flat_radius * angle)

    @property
    def mean_pressure(self) -> float:
        """P/πa², Pa."""
        return self.spread_pressure(self.contact_radius)

    @property
    def central_pressure(self) -> float:
        """p(0), Pa."""
        return self.pressure(0.0)

    @cached_property
    def peak_pressure(self) -> float:
        """Largest pressure, near the end of the flat, Pa."""
        flat, edge = self.flat_radius, self.contact_radius
        radii = (flat + (edge - flat) * (step / 100.0) ** 2 for step in range(-10, 91))
        return max(self.pressure(max(0.0, radius)) for radius in (0.0, 0.9 * flat, *radii))

    def pressure(self, radius: float) -> float:
        """p(r) = (E*/π) ∫ g′(t)/√(t² − r²) dt over max(r, b) … a, Pa, at a distance r in m."""
        edge, flat = self.contact_radius, self.flat_radius
        if radius >= edge:
            return 0.0
        start = math.sqrt(max(radius, flat) ** 2 - radius**2)
        length = math.sqrt(edge**2 - radius**2) - start
        total = 0.0
        for step in range(_POINTS):
            # Points crowd at the start, where g′ sets out like a square root.
            place = (step + 0.5) / _POINTS
            distance = math.hypot(radius, start + length * place**2)
            root, angle = self._edge(distance)
            slope = (2.0 * root - flat * angle) / self.edge_radius
            total += slope / distance * 2.0 * place
        return self.composite_modulus / math.pi * total * length / _POINTS

    def with_load(self, load: float) -> RoundPunchContact:
        """Contact of the same bodies under another load (N)."""
        return replace(self, load=load)

    def load_within(self, radius: float) -> float:
        """Load, N, that a disc of some radius, m, in the middle of the contact carries."""
        edge, total = min(radius, self.contact_radius), 0.0
        for step in range(_POINTS):
            place = (step + 0.5) / _POINTS * edge
            total += self.pressure(place) * place
        return 2.0 * math.pi * total * edge / _POINTS

    def spread_pressure(self, radius: float) -> float:
        """Uniform pressure, Pa, that carries the load on a contact of some radius, m."""
        return self.load / (math.pi * radius**2)

    def spread_radius(self, pressure: float) -> float:
        """Radius, m, of the contact that carries the load at a uniform pressure, Pa."""
        return math.sqrt(self.load / (math.pi * pressure))
