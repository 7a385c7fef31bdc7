"""Elastic constants of two bodies, and closed forms of their smooth point contacts.

The contact of any convex profile f of revolution follows from the method of dimensionality
reduction, which turns the profile into g(t) = t ∫₀^t f′(r)/√(t² − r²) dr. A contact of radius a
has the approach g(a), the load 2E* ∫₀^a (g(a) − g(t)) dt and the pressure
(E*/π) ∫_r^a g′(t)/√(t² − r²) dt.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Protocol, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]

_DIRECTIONS = 720
# Midpoints of 400 equal parts of the unit interval.
_MIDPOINTS = (np.arange(400) + 0.5) / 400
_TINY = float(np.finfo(float).tiny)


def require_positive(**values: float) -> None:
    """Raise a ValueError naming the first value that is not a positive, finite number."""
    for name, value in values.items():
        if not (math.isfinite(value) and value > 0.0):
            raise ValueError(f"{name} is {value!r}, but must be a positive, finite number")


def composite_modulus(
    youngs_modulus_1: float, poisson_ratio_1: float, youngs_modulus_2: float, poisson_ratio_2: float
) -> float:
    """Modulus of normal contact, 1/E* = (1 - ν1²)/E1 + (1 - ν2²)/E2, in Pa: Johnson, eq. 4.31.

    Young's moduli E are in Pa, large for a rigid body. A modulus that is not positive, or a
    Poisson's ratio outside (-1, 0.5], raises a ValueError.
    """
    bodies = (youngs_modulus_1, poisson_ratio_1), (youngs_modulus_2, poisson_ratio_2)
    for number, (modulus, ratio) in enumerate(bodies, start=1):
        require_positive(**{f"youngs_modulus_{number}": modulus})
        if not -1.0 < ratio <= 0.5:
            raise ValueError(
                f"poisson_ratio_{number} is {ratio!r}, but a Poisson's ratio lies in (-1, 0.5]"
            )
    return 1.0 / sum((1.0 - ratio**2) / modulus for modulus, ratio in bodies)


def coupling_ratio(
    youngs_modulus_1: float,
    poisson_ratio_1: float,
    youngs_modulus_2: float,
    poisson_ratio_2: float,
    weight: float = 0.5,
) -> float:
    """Tangential over normal compliance, κ = E*/G*; (2 - ν)/(2 (1 - ν)) for equal bodies.

    The modulus G* of tangential contact follows from 1/G* = (2 - ν1)/4G1 + (2 - ν2)/4G2: Mindlin
    (1949). A traction q distributed like a normal pressure p moves the surfaces by κ times the
    normal displacement: exactly in the circular contact of a sphere on average over directions,
    and pointwise if the anisotropy of the tangential kernel is neglected. A traction moves points
    ahead of it more than points beside it. The two have the same weight in a circular contact,
    w = 1/2, but not in others: 1/G* = (1 - ν1 + w ν1)/2G1 + …; see
    `EllipticContact.shear_weights`.
    """
    # (2 − ν)/4G with G = E/(2 (1 + ν)).
    bodies = (youngs_modulus_1, poisson_ratio_1), (youngs_modulus_2, poisson_ratio_2)
    normal, transverse = composite_modulus(*bodies[0], *bodies[1]), 2.0 * (1.0 - weight)
    shear = 1.0 / sum(
        (2.0 - transverse * ratio) * (1.0 + ratio) / (2.0 * modulus) for modulus, ratio in bodies
    )
    return normal / shear


@dataclass(frozen=True)
class HertzContact:
    """A smooth elastic sphere pressed on an elastic half-space without friction.

    Hertz (1882); Johnson (1985), section 4.2 and, for the surface outside, equation 3.42. A
    parameter that is not a positive, finite number raises a ValueError.
    """

    radius: float  #: R of the sphere, m (composite radius for two curved bodies)
    load: float  #: normal load P, N
    composite_modulus: float  #: E*, Pa

    def __post_init__(self) -> None:
        radius, load, modulus = self.radius, self.load, self.composite_modulus
        # Plans create hundreds of thousands of contacts.
        if not (0.0 < radius < math.inf and 0.0 < load < math.inf and 0.0 < modulus < math.inf):
            require_positive(radius=radius, load=load, composite_modulus=modulus)

    @cached_property
    def contact_radius(self) -> float:
        """Contact radius a = (3 P R / 4 E*)^(1/3), m."""
        return math.cbrt(0.75 * self.load * self.radius / self.composite_modulus)

    @property
    def approach(self) -> float:
        """Approach of the bodies δ = a²/R, m."""
        return self.contact_radius**2 / self.radius

    @property
    def mean_pressure(self) -> float:
        """P / π a², Pa."""
        return self.spread_pressure(self.contact_radius)

    @property
    def peak_pressure(self) -> float:
        """Pressure at the centre p0 = 3 P / (2 π a²), Pa."""
        return 1.5 * self.load / (math.pi * self.contact_radius**2)

    def with_load(self, load: float) -> Self:
        """Contact of the same bodies under another load (N)."""
        return replace(self, load=load)

    def scar_half_width(self, volume: float, radius: float) -> float:
        """Half-width, m, of a body of a radius of curvature, m, that has lost a volume, m³.

        A cap of half-width b and depth b²/2R has the volume πb⁴/4R.
        """
        cap = 4.0 / math.pi * (volume * radius)
        return self.contact_radius + math.sqrt(math.sqrt(cap))

    def with_approach(self, approach: float) -> Self:
        """Contact of the same bodies at an approach (m): P grows with δ^1.5."""
        require_positive(approach=approach)
        return self.with_load((approach / self.approach) ** 1.5 * self.load)

    def load_at(self, contact_radius: float) -> float:
        """Load, N, of a contact of given radius, m."""
        return 4.0 * self.composite_modulus * contact_radius**3 / (3.0 * self.radius)

    def spread_pressure(self, radius: float) -> float:
        """Uniform pressure, Pa, that carries the load on a contact of given radius, m."""
        return self.load / (math.pi * radius**2)

    def spread_radius(self, pressure: float) -> float:
        """Radius, m, of the contact that carries the load at a uniform pressure, Pa."""
        return math.sqrt(self.load / (math.pi * pressure))

    def pressure(self, r: ArrayLike) -> FloatArray:
        """Pressure p0 √(1 - r²/a²) in Pa, zero outside the contact, at distances ``r`` in m."""
        distance = np.asarray(r, dtype=float)
        pressed = np.maximum(1.0 - (distance / self.contact_radius) ** 2, 0.0)
        return np.asarray(self.peak_pressure * np.sqrt(pressed))

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap between the deformed surfaces in m, zero inside the contact, at distances ``r`` in m.

        Outside, g = [ (r² - 2a²) acos(a/r) + a √(r² - a²) ] / (π R). The terms cancel to order
        (r - a)^(3/2) at the edge, so a series replaces them there.
        """
        a = self.contact_radius
        ratio = np.maximum(np.asarray(r, dtype=float) / a, 1.0)
        root = np.sqrt((ratio - 1.0) * (ratio + 1.0))
        exact = (ratio**2 - 2.0) * np.arctan(root) + root
        series = root**3 * (4.0 / 3.0 - root**2 * (8.0 / 15.0 - root**2 * 12.0 / 35.0))
        return np.asarray(np.where(root < 0.01, series, exact) * (a * a / (math.pi * self.radius)))


@dataclass(frozen=True)
class EllipticContact(HertzContact):
    """Elastic contact of bodies with the gap x²/2R_x + y²/2R_y.

    ``radius`` belongs to the sphere whose contact has the same area at every load.
    """

    axis_ratio: float = 1.0  # half-axis along y over half-axis along x

    @classmethod
    def of(
        cls, radius_x: float, radius_y: float, load: float, composite_modulus: float
    ) -> EllipticContact:
        """Contact of bodies with given relative radii of curvature, m."""
        ratio = _axis_ratio(radius_x / radius_y)
        # 1/2R_x = (p₀/E*) (b/a²) R_D(0, b²/a², 1)/3 with half-axes a, b along x, y.
        integral = _carlson_d(ratio**2, 1.0) / 3.0
        radius = 4.0 / math.pi * radius_x * integral * ratio * math.sqrt(ratio)
        return cls(radius, load, composite_modulus, ratio)

    @property
    def half_widths(self) -> tuple[float, float]:
        """Half-axes of the ellipse along x and along y, m."""
        root = math.sqrt(self.axis_ratio)
        return self.contact_radius / root, self.contact_radius * root

    @property
    def approach(self) -> float:
        """δ = (p₀/E*) b K, m."""
        short, long = sorted(self.half_widths)
        square = (short / long) ** 2
        integral = (square * _carlson_d(1.0, square) + _carlson_d(square, 1.0)) / 3.0
        return integral * short * self.peak_pressure / self.composite_modulus

    def shear_weights(self, angle: float = 0.0) -> tuple[float, float, float]:
        """Weights of Poisson's ratio in the displacement due to a traction; see `coupling_ratio`.

        The traction points at an angle, rad, to x. The weights apply to the displacement in the
        centre and to its curvatures along x and along y: 1/2, 1/4 and 3/4 for a circle and a
        traction along x. They follow because the pressure integrates, along any line through a
        point, to a quadratic form of the position of the point.
        """
        direction = (np.arange(_DIRECTIONS) + 0.5) * math.pi / _DIRECTIONS
        cos, sin = np.cos(direction) ** 2, np.sin(direction) ** 2
        along_x, along_y = self.half_widths
        reach = 1.0 / np.sqrt(cos / along_x**2 + sin / along_y**2)
        weights = np.stack([reach, reach**3 * sin, reach**3 * cos])
        aligned = weights @ np.cos(direction - angle) ** 2
        centre, x, y = (aligned / weights.sum(axis=1)).tolist()
        return centre, x, y


@lru_cache(maxsize=4096)
def _axis_ratio(radius_ratio: float) -> float:
    """b/a of the half-axes along y and x from R_x/R_y: R_x/R_y = R_D(0, 1, k²)/R_D(0, k², 1)."""

    def excess(logarithm: float) -> float:
        # The more the ellipse extends along y, the flatter the gap along y.
        square = math.exp(2.0 * logarithm)
        return _carlson_d(1.0, square) / _carlson_d(square, 1.0) - radius_ratio

    return math.exp(find_root(excess, -math.log(1e6), math.log(1e6)))


def _carlson_d(y: float, z: float) -> float:
    """R_D(0, y, z) by duplication: Carlson (1995), Numerical Algorithms 10, 13-26."""
    x, total, part = 0.0, 0.0, 1.0
    while max(x, y, z) - min(x, y, z) > 1e-8 * z:
        root = math.sqrt(z)
        mean = math.sqrt(x * y) + (math.sqrt(x) + math.sqrt(y)) * root
        total += 3.0 * part / (root * (z + mean))
        x, y, z, part = (x + mean) / 4.0, (y + mean) / 4.0, (z + mean) / 4.0, part / 4.0
    return total + part / math.sqrt((x + y + 3.0 * z) / 5.0) ** 3


class Reduced(Protocol):
    """The reduced profile g of a body of revolution, in the method of dimensionality reduction."""

    def __hash__(self) -> int: ...

    @property
    def reach(self) -> float:
        """Radius, m, that no contact may exceed."""

    @property
    def flat_radius(self) -> float:
        """Radius, m, up to which g is zero."""

    def depth(self, radius: float) -> float:
        """g, m, at a radius in m."""

    def slope(self, radii: FloatArray) -> FloatArray:
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
        """Reduced profile g = (t/R)(√(t² − b²) − b arccos(b/t)), m, at a radius t, m."""
        root, angle = self._edge(radius)
        return float(radius / self.edge_radius * (root - self.flat_radius * angle))

    def slope(self, radii: FloatArray) -> FloatArray:
        """g′ = (2√(t² − b²) − b arccos(b/t))/R."""
        root, angle = self._edge(radii)
        return np.asarray((2.0 * root - self.flat_radius * angle) / self.edge_radius)

    def integral(self, radius: float) -> float:
        """∫₀^a g dt, m²."""
        root, angle = self._edge(radius)
        flat = self.flat_radius
        rounded = root**3 / 3.0 - 0.5 * flat * (radius**2 * angle - flat * root)
        return float(rounded / self.edge_radius)

    def _edge(self, radii: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """√(t² − b²) and arccos(b/t), which keep their digits as t approaches b."""
        outside = np.maximum(radii, self.flat_radius)
        root = np.sqrt((outside - self.flat_radius) * (outside + self.flat_radius))
        return root, np.arctan2(root, self.flat_radius)


@dataclass(frozen=True)
class RoundContact(HertzContact):
    """Elastic contact of a body of revolution with a flat.

    ``radius`` belongs to the sphere whose contact has the same radius under this load.
    """

    profile: Reduced = field(kw_only=True)

    @classmethod
    @lru_cache(maxsize=4096)
    def under(cls, profile: Reduced, load: float, composite_modulus: float) -> Self:
        """Contact of a profile under a load, N."""
        edge, load_at = profile.reach, cls(1.0, load, composite_modulus, profile=profile).load_at
        edge = find_root(lambda radius: load - load_at(radius), 1e-9 * edge, edge)
        radius = 4.0 * composite_modulus * edge**3 / (3.0 * load)
        return cls(radius, load, composite_modulus, profile=profile)

    @property
    def approach(self) -> float:
        """δ = g(a), m."""
        return self.profile.depth(self.contact_radius)

    @cached_property
    def peak_pressure(self) -> float:
        """Largest pressure, Pa, usually where the profile leaves its flat."""
        # Sines of equally spaced angles crowd at the edge, where a sharp edge has its peak.
        angles, step = np.linspace(0.0, 0.5 * math.pi, 201)[:-1], 0.5 * math.pi / 200
        for part in (step, 0.02 * step):
            best = angles[self.pressure(self.contact_radius * np.sin(angles)).argmax()]
            angles = best + np.linspace(-part, part, 101)
        return float(self.pressure(self.contact_radius * np.sin(angles)).max())

    def pressure(self, r: ArrayLike) -> FloatArray:
        """Pressure in Pa, zero outside the contact, at distances ``r`` in m.

        Substitutes t² = s² + v² in (E*/π) ∫ g′(t)/√(t² − r²) dt, where s is r or, if larger, the
        radius of the flat. The integrand is then bounded and smooth.
        """
        distance, edge = np.abs(np.asarray(r, dtype=float)), self.contact_radius
        inner = np.maximum(distance, self.profile.flat_radius)
        length = np.sqrt(np.maximum((edge - inner) * (edge + inner), 0.0))
        risen = _MIDPOINTS * length[..., None]
        radii = np.hypot(inner[..., None], risen)
        offset = np.sqrt((inner - distance) * (inner + distance))
        share = risen / np.maximum(np.hypot(offset[..., None], risen), _TINY)
        total = (self.profile.slope(radii) / radii * share).sum(axis=-1)
        scale = _MIDPOINTS.size * math.pi
        return np.asarray(total * length / scale * self.composite_modulus)

    def with_load(self, load: float) -> Self:
        """Contact of the same bodies under another load (N)."""
        return self.under(self.profile, load, self.composite_modulus)

    def with_approach(self, approach: float) -> Self:
        """Contact of the same bodies at an approach (m), at the most that of the whole profile."""
        profile = self.profile
        edge = find_root(lambda radius: approach - profile.depth(radius), 0.0, profile.reach)
        return self.with_load(self.load_at(edge))

    def load_at(self, contact_radius: float) -> float:
        """Load, N, of a contact of given radius, m."""
        spared = contact_radius * self.profile.depth(contact_radius)
        return 2.0 * self.composite_modulus * (spared - self.profile.integral(contact_radius))


def find_root(falling: Callable[[float], float], low: float, high: float) -> float:
    """Zero, to rounding, of a falling function, or the end nearest to it if it lies outside.

    Ridders (1979), IEEE Transactions on Circuits and Systems 26, 979-980; SciPy takes long to load.
    """
    positive, negative, root = falling(low), falling(high), math.nan
    if positive <= 0.0 or negative >= 0.0:
        return low if positive <= 0.0 else high
    while low < (place := 0.5 * (low + high)) < high:
        middle, step, last = place, place - low, root
        value = falling(middle)
        root = middle + step * value / (math.sqrt(value**2 - positive * negative) or 1.0)
        for place in (middle, root):
            value = value if place == middle else falling(place)
            if value == 0.0 or place == last:
                return place
            if value > 0.0 and place > low:
                low, positive = place, value
            elif value < 0.0 and place < high:
                high, negative = place, value
    return place
