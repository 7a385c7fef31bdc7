"""Closed forms of a smooth contact after infinitely many cycles of partial slip.

References
----------
K. L. Johnson (1985), Contact Mechanics, Cambridge University Press, chapters 3 and 4.
V. L. Popov, M. Heß (2015), Method of Dimensionality Reduction in Contact Mechanics and Friction,
Springer.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from fretwear.theory.hertz import FloatArray, HertzContact


@dataclass(frozen=True)
class LimitingState:
    """A smooth elastic sphere after infinitely many cycles under constant load amplitudes.

    Wear stops when the slip zone carries no load: all pressure has moved into the stick zone,
    which wear cannot change and which ends like the edge of a flat punch.

    The stick zone is indented by d∞ over its radius c; outside, the worn shape follows the surface
    of the deformed half-space, f∞(r), until it meets the unworn sphere r²/2R at a∞. Superposition
    of a Hertzian contact and a flat punch: Johnson (1985), sections 3.4 and 4.2; the same with the
    method of dimensionality reduction: Popov and Heß (2015). A load ratio outside [0, 1) raises a
    ValueError.
    """

    hertz: HertzContact  #: the unworn normal contact
    load_ratio: float  #: tangential load over the load of gross sliding, X = Q/µP

    # 2E*/R over the slope of the Hertzian pressure against √(c² - r²).
    _flatness: ClassVar[float] = math.pi

    def __post_init__(self) -> None:
        if not 0.0 <= self.load_ratio < 1.0:
            raise ValueError(
                f"load_ratio is {self.load_ratio!r}, but partial slip needs 0 <= load_ratio < 1"
            )

    @property
    def _stick_contact(self) -> HertzContact:
        """Contact under the reduced load."""
        return self.hertz.with_load(self.hertz.load * (1.0 - self.load_ratio))

    @property
    def stick_radius(self) -> float:
        """Radius of the stick zone c = a (1 - X)^(1/3), of a cylinder a (1 - X)^(1/2), m."""
        return self.hertz.contact_radius * math.cbrt(1.0 - self.load_ratio)

    @property
    def approach(self) -> float:
        """Approach of the bodies d∞ = P/(2 E* c) + c²/(3R), m."""
        c = self.stick_radius
        punch = self.hertz.load / (2.0 * self.hertz.composite_modulus * c)
        return punch + c * c / (3.0 * self.hertz.radius)

    @property
    def _punch_approach(self) -> float:
        """πS/E*, m, of the punch's pressure S/√(c² - r²): approach beyond a sphere's, d∞ - c²/R."""
        return self.approach - self.stick_radius**2 / self.hertz.radius

    @property
    def central_pressure(self) -> float:
        """Central pressure, of a sphere (E*/π) (c/R + d∞/c), Pa."""
        return float(self.pressure(0.0))

    def pressure(self, r: ArrayLike) -> FloatArray:
        """Pressure in Pa at distances ``r`` in m: infinite at r = c, zero outside the stick zone.

        That of a Hertzian contact of radius c and of a flat punch, of a sphere
        p∞ = (E*/π) [ (2/R) √(c² - r²) + (d∞ - c²/R) / √(c² - r²) ], of a cylinder
        p∞ = (E*/2R) √(c² - r²) + X P / (π √(c² - r²)).
        """
        c, distance = self.stick_radius, np.abs(np.asarray(r, dtype=float))
        root = np.sqrt(np.maximum((c - distance) * (c + distance), 0.0))
        strength = self.hertz.composite_modulus / math.pi * self._punch_approach
        with np.errstate(divide="ignore", invalid="ignore"):
            punch = np.where(strength > 0.0, strength / root, 0.0)
        return np.asarray(np.where(distance <= c, self._stick_contact.pressure(r) + punch, 0.0))

    def wear_depth(self, r: ArrayLike) -> FloatArray:
        """Wear of both bodies together in m, at distances ``r`` in m: f∞ - r²/2R where positive.

        Written as the surface beside a flat punch minus the Hertzian gap, both zero at r = c, so
        that nothing cancels there.
        """
        c = self.stick_radius
        distance = np.maximum(np.abs(np.asarray(r, dtype=float)), c)
        beside = self._beside(np.sqrt((distance - c) * (distance + c)), c)
        height = (2.0 / math.pi) * self._punch_approach * beside - self._stick_contact.gap(distance)
        return np.asarray(np.maximum(height, 0.0))

    def width_above(self, pressure: float) -> float:
        """Width of the band at the stick edge where p∞ exceeds a pressure (Pa), m.

        If the pressure is a plastic limit, this is the size of the yielding zone, which a much
        coarser grid misses or underestimates.
        """
        c, radius = self.stick_radius, self.hertz.radius
        half = self._flatness * pressure * radius / (4.0 * self.hertz.composite_modulus)
        product = self._flatness / (2.0 * math.pi) * self._punch_approach * radius
        discriminant = half * half - product
        if discriminant <= 0.0:
            return c
        # The smaller root of w² - 2 half w + product = 0 in w = √(c² - r²).
        root = product / (half + math.sqrt(discriminant))
        return c if root >= c else root * root / (c + math.sqrt((c - root) * (c + root)))

    def worn_shape(self, r: ArrayLike) -> FloatArray:
        """Height of the worn body above its lowest point in m, at distances ``r`` in m.

        r²/2R inside the stick zone and beyond a∞; between them, of a sphere,
        f∞ = [ r² asin(c/r) - c √(r² - c²) ] / (π R) + d∞ [ 1 - (2/π) asin(c/r) ].
        """
        unworn = np.asarray(r, dtype=float) ** 2 / (2.0 * self.hertz.radius)
        return np.asarray(unworn + self.wear_depth(r))

    @cached_property
    def contact_radius(self) -> float:
        """Radius a∞ at which the worn shape meets the unworn sphere, m.

        There f∞ = r²/2R: with a∞ = c √(1 + t²), t² + t / atan t = 1 + (4/3) X / (1 - X).
        """
        if self.load_ratio == 0.0:
            return self.stick_radius
        total = 1.0 + 4.0 / 3.0 * self.load_ratio / (1.0 - self.load_ratio)
        root = find_root(lambda t: total - t * t - t / math.atan(t), 1e-12, math.sqrt(total))
        return self.stick_radius * math.hypot(1.0, root)

    @property
    def deepest_wear(self) -> float:
        """Largest wear of both bodies together, m."""
        return float(self.wear_depth(self._deepest))

    @property
    def wear_volume(self) -> float:
        """Volume of worn material of both bodies together, m³, of a cylinder per length, m²."""
        c, edge = self.stick_radius, self.contact_radius
        root = math.sqrt((edge - c) * (edge + c))
        angle = math.atan2(root, c)
        punch = self._punch_approach * (edge**2 * angle - c * root) / math.pi
        sphere = edge**2 * (edge**2 - 4.0 * c**2) * angle + c * root * (edge**2 + 2.0 * c**2)
        return 2.0 * math.pi * (punch - sphere / (4.0 * math.pi * self.hertz.radius))

    def _beside(self, root: FloatArray, c: float) -> FloatArray:
        """Shape of the surface beside a flat punch, at distances given as √(r² - c²)."""
        return np.asarray(np.arctan2(root, c))

    @cached_property
    def _deepest(self) -> float:
        """Radius at which the wear is deepest, m."""
        c = self.stick_radius
        if self.load_ratio == 0.0:
            return c

        def slope(offset: float) -> float:
            # the derivative of the height, times √(r² - c²), which removes its pole at r = c
            r = c + offset
            root = math.sqrt(offset * (r + c))
            hertzian = root * (r * math.atan2(root, c) + c * root / r) / self.hertz.radius
            return self._punch_approach * c / r - hertzian

        outside = c
        while slope(outside) > 0.0:
            outside *= 2.0
        return c + find_root(slope, 0.0, outside)


def find_root(falling: Callable[[float], float], low: float, high: float) -> float:
    """Zero of a function, positive at ``low`` and negative at ``high``, to rounding.

    The Illinois variant of regula falsi: Dowell and Jarratt (1971), BIT 11, 168-174.
    """
    above, below, last = falling(low), falling(high), 0
    for _ in range(200):
        middle = (low * below - high * above) / (below - above)
        if not low < middle < high:
            middle = 0.5 * (low + high)
        value = falling(middle)
        if value == 0.0 or not low < middle < high:
            return middle
        if value > 0.0:
            low, above = middle, value
            below *= 0.5 if last > 0 else 1.0
            last = 1
        else:
            high, below = middle, value
            above *= 0.5 if last < 0 else 1.0
            last = -1
    return 0.5 * (low + high)
