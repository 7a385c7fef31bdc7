"""Closed forms of a smooth cylinder or punch on a flat in plane strain; loads are per length."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from fretwear.theory.point_contact import FloatArray, HertzContact, find_root, require_positive

_PUNCHES = 200
# Logarithm of the smallest load of a given approach, over E* times the reference distance.
_LIGHTEST = -70.0


@dataclass(frozen=True)
class LineContact(HertzContact):
    """A smooth elastic cylinder pressed on an elastic half-space without friction.

    ``radius`` is the radius of the cylinder, m, ``load`` the normal load per length, N/m, and
    ``contact_radius`` the half-width of the contact, m; positions ``r`` are distances from its
    centre line.
    """

    def with_approach(self, approach: float) -> Self:
        """Contact of the same bodies at an approach (m) as of `approach`, under at most E* R."""
        require_positive(approach=approach)
        most = self.composite_modulus * self.reference

        def missing(folds: float) -> float:
            return approach - self.with_load(most * math.exp(folds)).approach

        return self.with_load(most * math.exp(find_root(missing, _LIGHTEST, 0.0)))

    def scar_half_width(self, volume: float, radius: float) -> float:
        """Half-width, m, of a body of a radius, m, that has lost a volume per length, m².

        A segment of half-width b and depth b²/2R has the area 2b³/3R.
        """
        return self.contact_radius + math.cbrt(1.5 * (volume * radius))

    @cached_property
    def contact_radius(self) -> float:
        """Half-width of the contact a = (4 P R / π E*)^(1/2), m."""
        return math.sqrt(4.0 * self.load * self.radius / (math.pi * self.composite_modulus))

    @property
    def reference(self) -> float:
        """Distance R, m, from the centre line to the surface point that defines the approach.

        The surface of a loaded half-plane sinks without bound towards its middle, or rises without
        bound away from it.
        """
        return self.radius

    @property
    def approach(self) -> float:
        """Approach δ = (P / π E*) [2 ln(2R/a) + 1], m."""
        return self.load * (self.compliance + 1.0 / (math.pi * self.composite_modulus))

    @property
    def compliance(self) -> float:
        """dδ/dP = 2 ln(2R/a) / π E*, m²/N, normal or tangential."""
        scale = 2.0 / (math.pi * self.composite_modulus)
        return scale * math.log(2.0 * self.reference / self.contact_radius)

    @property
    def peak_pressure(self) -> float:
        """Peak pressure p0 = E* a / 2R, Pa."""
        return 0.5 * self.composite_modulus * self.contact_radius / self.radius

    def load_at(self, contact_radius: float) -> float:
        """Load per length, N/m, of a contact of given half-width, m."""
        return 0.25 * math.pi * self.composite_modulus * contact_radius**2 / self.radius

    def spread_pressure(self, radius: float) -> float:
        """Uniform pressure, Pa, that carries the load on a contact of given half-width, m."""
        return self.load / (2.0 * radius)

    def spread_radius(self, pressure: float) -> float:
        """Half-width, m, of the contact that carries the load at a uniform pressure, Pa."""
        return self.load / (2.0 * pressure)

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap between the deformed surfaces in m, zero inside the contact, at ``r`` in m.

        Outside, g = (a²/2R) [ t √(t² - 1) - arcosh t ], t = r/a. The terms cancel to order
        (t - 1)^(3/2) at the edge, so a series replaces them there.
        """
        a = self.contact_radius
        ratio = np.maximum(np.abs(np.asarray(r, dtype=float)) / a, 1.0)
        root = np.sqrt((ratio - 1.0) * (ratio + 1.0))
        exact = ratio * root - np.arcsinh(root)
        series = root**3 * (2.0 / 3.0 - root**2 * (1.0 / 5.0 - root**2 * 3.0 / 28.0))
        return np.asarray(np.where(root < 0.01, series, exact) * (0.5 * a * a / self.radius))


@dataclass(frozen=True)
class FlatPunchContact(LineContact):
    """A punch, flat to x = ±b and (abs(x) - b)²/2R high beyond; ``radius`` is its edge radius R.

    Its pressure is the sum over flat punches of all half-widths t from b to a, with loads
    dP = (E*/R) t arccos(b/t) dt: Ciavarella, Hills and Monno (1998).
    """

    flat_half_width: float = field(kw_only=True)

    @cached_property
    def contact_radius(self) -> float:
        """Half-width of the contact a, m."""
        outside = 2.0 * self.flat_half_width
        while self.load_at(outside) < self.load:
            outside *= 2.0
        return find_root(lambda edge: self.load - self.load_at(edge), self.flat_half_width, outside)

    @property
    def reference(self) -> float:
        """R + 5b, m: five times the distance at which the slope of the edge is one fifth."""
        return self.radius + 5.0 * self.flat_half_width

    @property
    def approach(self) -> float:
        """Approach δ = ∫ dδ/dP dP, m."""
        flat, edge = self.flat_half_width, self.contact_radius
        angle, root = self._edge(edge)
        rounded = (0.5 * edge**2 + flat**2) * angle - 1.5 * flat * root
        return self.load * self.compliance + rounded / (math.pi * self.radius)

    @cached_property
    def peak_pressure(self) -> float:
        """Largest pressure, Pa, on the rounded edges."""
        places = np.linspace(self.flat_half_width, self.contact_radius, 402)
        best = int(np.argmax(self.pressure(places[1:-1]))) + 1
        near_peak = np.linspace(places[best - 1], places[best + 1], 401)[1:]
        return float(self.pressure(near_peak).max())

    def load_at(self, contact_radius: float) -> float:
        """P = (E*/2R) [a² arccos(b/a) - b √(a² - b²)], N/m, for a half-width a, m."""
        angle, root = self._edge(contact_radius)
        flattened = contact_radius**2 * angle - self.flat_half_width * root
        return 0.5 * self.composite_modulus / self.radius * flattened

    def pressure(self, r: ArrayLike) -> FloatArray:
        """Pressure in Pa, zero outside the contact, at positions ``r`` in m."""
        edge = self.contact_radius
        flat = 0.5 * math.pi - self._edge(edge)[0]
        sine = np.abs(np.asarray(r, dtype=float)) / edge
        angle = np.arcsin(np.minimum(sine, 1.0))
        # The logarithms cancel at the end of the flat.
        angle = np.where(np.abs(angle - flat) < 1e-9, flat + 1e-9, angle)
        with np.errstate(divide="ignore", invalid="ignore"):
            rise = np.log(np.abs(np.sin(angle + flat) / np.sin(angle - flat))) * np.sin(angle)
            tangents = np.tan(0.5 * (angle + flat)) * np.tan(0.5 * (angle - flat))
            rise += np.log(np.abs(tangents)) * math.sin(flat)
        open_angle = math.pi - 2.0 * flat
        scale = 2.0 * self.load / (math.pi * edge * (open_angle - math.sin(2.0 * flat)))
        pressure = scale * (open_angle * np.cos(angle) + rise)
        return np.asarray(np.where(sine < 1.0, pressure, 0.0))

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap between the deformed surfaces in m, zero inside the contact, at ``r`` in m."""
        distance = np.maximum(np.abs(np.asarray(r, dtype=float)), self.contact_radius)
        # The half-widths of flat punches, m, and the loads per length that they carry, N/m.
        angles = (np.arange(_PUNCHES) + 0.5) * math.pi / _PUNCHES
        half = 0.5 * (self.contact_radius - self.flat_half_width)
        edges = self.flat_half_width + half * (1.0 - np.cos(angles))
        weights = half * np.sin(angles) * math.pi / _PUNCHES
        loads = edges * np.arccos(self.flat_half_width / edges) * weights
        loads *= self.composite_modulus / self.radius
        risen = np.arccosh(np.maximum(distance[..., None] / edges, 1.0)) @ loads
        scale = 2.0 / (math.pi * self.composite_modulus)
        height = (distance - self.flat_half_width) ** 2 / (2.0 * self.radius)
        return np.asarray(np.maximum(height - scale * risen, 0.0))

    def _edge(self, edge: float) -> tuple[float, float]:
        """arccos(b/a) and √(a² - b²), which keep their digits as a approaches b."""
        flat = self.flat_half_width
        root = math.sqrt(max((edge - flat) * (edge + flat), 0.0))
        return math.atan2(root, flat), root
