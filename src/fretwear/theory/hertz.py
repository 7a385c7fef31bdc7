"""Closed forms of a smooth sphere pressed on a half-space.

References
----------
H. Hertz (1882), Über die Berührung fester elastischer Körper, J. reine angew. Math. 92, 156–171.
K. L. Johnson (1985), Contact Mechanics, Cambridge University Press, chapters 3 and 4.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fretwear.theory.materials import require_positive

FloatArray = NDArray[np.float64]


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
        names = ("radius", "load", "composite_modulus")
        require_positive(**{name: getattr(self, name) for name in names})

    @property
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

    def with_approach(self, approach: float) -> Self:
        """Contact of the same bodies at an approach (m): P = (4/3) E* √R δ^1.5."""
        require_positive(approach=approach)
        load = 4.0 / 3.0 * self.composite_modulus * math.sqrt(self.radius) * approach**1.5
        return self.with_load(load)

    def load_at(self, contact_radius: float) -> float:
        """Load, N, of a contact of given radius, m."""
        return 4.0 * self.composite_modulus * contact_radius**3 / (3.0 * self.radius)

    def load_within(self, radius: float) -> float:
        """Load, N, carried by a central disc of given radius, m."""
        outside = max(0.0, 1.0 - (radius / self.contact_radius) ** 2)
        return self.load * (1.0 - outside * math.sqrt(outside))

    def spread_pressure(self, radius: float) -> float:
        """Uniform pressure, Pa, that carries the load on a contact of given radius, m."""
        return self.load / (math.pi * radius**2)

    def spread_radius(self, pressure: float) -> float:
        """Radius, m, of the contact that carries the load at a uniform pressure, Pa."""
        return math.sqrt(self.load / (math.pi * pressure))

    def pressure(self, r: ArrayLike) -> FloatArray:
        """Pressure p0 √(1 - r²/a²) in Pa, zero outside the contact, at distances ``r`` in m."""
        distance = np.asarray(r, dtype=float)
        inside = np.maximum(1.0 - (distance / self.contact_radius) ** 2, 0.0)
        return np.asarray(self.peak_pressure * np.sqrt(inside))

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap between the deformed surfaces in m, zero inside the contact, at distances ``r`` in m.

        Outside, g = [ (r² - 2a²) acos(a/r) + a √(r² - a²) ] / (π R); near the edge, where both
        terms cancel to order (r - a)^(3/2), a series.
        """
        a = self.contact_radius
        ratio = np.maximum(np.asarray(r, dtype=float) / a, 1.0)
        root = np.sqrt((ratio - 1.0) * (ratio + 1.0))
        exact = (ratio**2 - 2.0) * np.arctan(root) + root
        series = root**3 * (4.0 / 3.0 - root**2 * (8.0 / 15.0 - root**2 * 12.0 / 35.0))
        return np.asarray(np.where(root < 0.01, series, exact) * (a * a / (math.pi * self.radius)))
