"""Elliptical contact after Hertz, of bodies with unlike curvatures along two directions.

K. L. Johnson (1985), Contact Mechanics, Cambridge University Press, sections 4.2 (Hertz) and 7.2;
elliptic integrals in the form of B. C. Carlson, which has no special case for a circle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

from fretwear.theory.hertz import HertzContact

_DIRECTIONS = 720


@dataclass(frozen=True)
class EllipticContact(HertzContact):
    """Elastic contact of bodies with the gap x²/2R_x + y²/2R_y.

    ``radius`` is that of the sphere whose contact has the same area at every load.

    Attributes
    ----------
    axis_ratio : float
        Half-axis along y over that along x.
    """

    axis_ratio: float = 1.0

    @classmethod
    def of(
        cls, radius_x: float, radius_y: float, load: float, composite_modulus: float
    ) -> EllipticContact:
        """Contact of bodies by their relative radii of curvature, m."""
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
        along_x, along_y = self.half_widths
        integral = _complete_first(min(along_x, along_y) / max(along_x, along_y))
        return integral * min(along_x, along_y) * self.peak_pressure / self.composite_modulus

    def with_load(self, load: float) -> EllipticContact:
        """Contact of the same bodies under another load (N)."""
        return replace(self, load=load)

    def shear_weights(self, angle: float = 0.0) -> tuple[float, float, float]:
        """How the displacement by a traction weighs Poisson's ratio; see `coupling_ratio`.

        The traction points along a direction at an angle, rad, to x.

        Returns
        -------
        In the centre, and for the curvatures of the displacement along x and along y: for a circle
        1/2 and, at no angle, 1/4 and 3/4.
        """
        along_x, along_y = self.half_widths
        sums = [[0.0, 0.0] for _ in range(3)]
        # Along a line in the direction φ through a point, the pressure integrates to a quadratic
        # form of its place.
        for step in range(_DIRECTIONS):
            direction = (step + 0.5) * math.pi / _DIRECTIONS
            cos, sin = math.cos(direction) ** 2, math.sin(direction) ** 2
            aligned = math.cos(direction - angle) ** 2
            reach = 1.0 / math.sqrt(cos / along_x**2 + sin / along_y**2)
            for total, weight in zip(sums, (reach, reach**3 * sin, reach**3 * cos), strict=True):
                total[0] += weight * aligned
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
