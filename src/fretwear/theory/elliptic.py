"""Elliptical contact after Hertz, of bodies with unlike curvatures along two directions.

K. L. Johnson (1985), Contact Mechanics, Cambridge University Press, sections 4.2 (Hertz) and 7.2;
elliptic integrals in the form of B. C. Carlson, which has no special case for a circle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

_DIRECTIONS = 720


@dataclass(frozen=True)
class EllipticContact:
    """Elastic contact of bodies with the gap x²/2R_x + y²/2R_y.

    Attributes
    ----------
    radius_x, radius_y : float
        Relative radii of curvature, m.
    load : float
        Normal load P, N.
    composite_modulus : float
        E*, Pa.
    """

    radius_x: float
    radius_y: float
    load: float
    composite_modulus: float

    @cached_property
    def half_widths(self) -> tuple[float, float]:
        """Half-axes of the ellipse along x and along y, m."""
        ratio = _axis_ratio(self.radius_x / self.radius_y)
        # P = (2π/3) p₀ a b and 1/2R_x = (p₀/E*) (b/a²) R_D(0, b²/a², 1)/3 for b, a along y, x.
        integral = _carlson_d(ratio**2, 1.0) / 3.0
        cube = 3.0 * self.load * self.radius_x * integral / (math.pi * self.composite_modulus)
        along_x = math.cbrt(cube)
        return along_x, ratio * along_x

    @property
    def contact_radius(self) -> float:
        """Of the circle of the same area, m."""
        return math.sqrt(math.prod(self.half_widths))

    @property
    def peak_pressure(self) -> float:
        """p₀ = 3P/2πab, Pa."""
        return 1.5 * self.mean_pressure

    @property
    def mean_pressure(self) -> float:
        """P/πab, Pa."""
        return self.spread_pressure(self.contact_radius)

    @property
    def approach(self) -> float:
        """δ = (p₀/E*) b K, m."""
        along_x, along_y = self.half_widths
        integral = _complete_first(min(along_x, along_y) / max(along_x, along_y))
        return integral * min(along_x, along_y) * self.peak_pressure / self.composite_modulus

    def with_load(self, load: float) -> EllipticContact:
        """Contact of the same bodies under another load (N)."""
        return replace(self, load=load)

    def load_within(self, radius: float) -> float:
        """Load, N, within a similar ellipse, whose half-axes have the given geometric mean, m."""
        outside = max(0.0, 1.0 - (radius / self.contact_radius) ** 2)
        return self.load * (1.0 - outside * math.sqrt(outside))

    def spread_pressure(self, radius: float) -> float:
        """Uniform pressure, Pa, that carries the load on the area of a circle, radius in m."""
        return self.load / (math.pi * radius**2)

    def spread_radius(self, pressure: float) -> float:
        """Radius, m, of the circle that carries the load at a uniform pressure, Pa."""
        return math.sqrt(self.load / (math.pi * pressure))

    def shear_weights(self) -> tuple[float, float, float]:
        """How the tangential displacement along x weighs Poisson's ratio; see `coupling_of`.

        Returns
        -------
        In the centre, and for the curvatures of the displacement along x and along y: for a circle
        1/2, 1/4 and 3/4.
        """
        along_x, along_y = self.half_widths
        sums = [[0.0, 0.0] for _ in range(3)]
        # Along a line in the direction φ through a point, the pressure integrates to a quadratic
        # form of its place.
        for step in range(_DIRECTIONS):
            angle = (step + 0.5) * math.pi / _DIRECTIONS
            cos, sin = math.cos(angle) ** 2, math.sin(angle) ** 2
            reach = 1.0 / math.sqrt(cos / along_x**2 + sin / along_y**2)
            for total, weight in zip(sums, (reach, reach**3 * sin, reach**3 * cos), strict=True):
                total[0] += weight * cos
                total[1] += weight
        centre, x, y = (weighted / plain for weighted, plain in sums)
        return centre, x, y


@lru_cache(maxsize=4096)
def _axis_ratio(radius_ratio: float) -> float:
    """b/a of the half-axes along y and x from R_x/R_y: R_x/R_y = R_D(0, 1, k²)/R_D(0, k², 1)."""
    low, high = 1e-6, 1e6
    for _ in range(100):
        middle = math.sqrt(low * high)
        found = _carlson_d(1.0, middle**2) / _carlson_d(middle**2, 1.0)
        # The more the ellipse extends along y, the flatter the gap along y.
        low, high = (low, middle) if found < radius_ratio else (middle, high)
    return math.sqrt(low * high)


def _carlson_d(second: float, third: float) -> float:
    """R_D(0, y, z) by duplication; B. C. Carlson, Numer. Algor. 10 (1995), 13–26."""
    x, y, z = 0.0, second, third
    total, factor = 0.0, 1.0
    mean = (x + y + 3.0 * z) / 5.0
    largest = max(abs(mean - each) for each in (x, y, z))
    start_x, start_y, start_mean = x, y, mean
    while factor * largest > 1e-3 * abs(mean):
        root_x, root_y, root_z = math.sqrt(x), math.sqrt(y), math.sqrt(z)
        step = root_x * root_y + root_x * root_z + root_y * root_z
        total += factor / (root_z * (z + step))
        factor /= 4.0
        x, y, z, mean = ((each + step) / 4.0 for each in (x, y, z, mean))
    rest_x, rest_y = (factor * (start_mean - each) / mean for each in (start_x, start_y))
    rest_z = -(rest_x + rest_y) / 3.0
    product = rest_x * rest_y
    second_order = product - 6.0 * rest_z**2
    third_order = (3.0 * product - 8.0 * rest_z**2) * rest_z
    fourth_order = 3.0 * (product - rest_z**2) * rest_z**2
    fifth_order = product * rest_z**3
    series = (
        1.0
        - 3.0 * second_order / 14.0
        + third_order / 6.0
        + 9.0 * second_order**2 / 88.0
        - 3.0 * fourth_order / 22.0
        - 9.0 * second_order * third_order / 52.0
        + 3.0 * fifth_order / 26.0
    )
    return 3.0 * total + factor * series / (mean * math.sqrt(mean))


def _complete_first(complement: float) -> float:
    """K of the complementary modulus k', by the arithmetic-geometric mean."""
    first, second = 1.0, complement
    while abs(first - second) > 1e-15 * first:
        first, second = 0.5 * (first + second), math.sqrt(first * second)
    return math.pi / (first + second)
