"""Hertz's elliptical contact of bodies with different curvatures along two directions.

K. L. Johnson (1985), Contact Mechanics, Cambridge University Press, sections 4.2 (Hertz) and 7.2;
elliptic integrals in the form of B. C. Carlson, Numer. Algor. 10 (1995), 13–26, which has no
special case for a circle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Self

from fretwear.theory.hertz import HertzContact

_DIRECTIONS = 720


@dataclass(frozen=True)
class EllipticContact(HertzContact):
    """Elastic contact of bodies with the gap x²/2R_x + y²/2R_y.

    ``radius`` is that of the sphere whose contact has the same area at every load.
    """

    axis_ratio: float = 1.0  # half-axis along y over that along x

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
        integral = _complete(min(along_x, along_y) / max(along_x, along_y))[0]
        return integral * min(along_x, along_y) * self.peak_pressure / self.composite_modulus

    def with_approach(self, approach: float) -> Self:
        """Contact of the same bodies at an approach (m): P grows with δ^1.5."""
        return self.with_load((approach / self.approach) ** 1.5 * self.load)

    def shear_weights(self, angle: float = 0.0) -> tuple[float, float, float]:
        """Weight of Poisson's ratio in the displacement due to a traction; see `coupling_ratio`.

        The traction points along a direction at an angle, rad, to x.

        Returns
        -------
        In the centre, and for the curvatures of the displacement along x and along y: for a circle
        1/2 and, at no angle, 1/4 and 3/4.
        """
        return _shear_weights(*self.half_widths, angle)


@lru_cache(maxsize=64)
def _shear_weights(along_x: float, along_y: float, angle: float) -> tuple[float, float, float]:
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
    """R_D(0, y, z): 3D/z^(3/2) for z > y, else 3B/(z √y), with D as below and B = K − D."""
    complete, difference = _complete(math.sqrt(min(second, third) / max(second, third)))
    if third > second:
        return 3.0 * difference / (third * math.sqrt(third))
    return 3.0 * (complete - difference) / (third * math.sqrt(second))


def _complete(complement: float) -> tuple[float, float]:
    """K and D = (K − E)/k² of the complementary modulus k′, by the arithmetic-geometric mean.

    With the differences c of the means, D/K = 1/2 + Σ 2^(n−1) c_n²/k² over n ≥ 1.
    """
    mean, root = 0.5 * (1.0 + complement), math.sqrt(complement)
    difference = 0.5 * (1.0 - complement)
    term, share = 0.25 * (1.0 - complement) / (1.0 + complement), 0.5
    while abs(term) > 1e-17:
        share += term
        mean, root = 0.5 * (mean + root), math.sqrt(mean * root)
        term *= 2.0 * (difference / (4.0 * mean)) ** 2
        difference *= difference / (4.0 * mean)
    complete = math.pi / (mean + root)
    return complete, share * complete
