"""Closed forms of a smooth sphere in partial slip: unworn, and after endless wear.

Everything is axisymmetric about the axis of the sphere, in SI units; ``r`` is the distance from
that axis. Arrays of any shape are accepted for ``r`` and returned in the same shape.

References
----------
H. Hertz (1882), Über die Berührung fester elastischer Körper, J. reine angew. Math. 92, 156–171.
C. Cattaneo (1938), Sul contatto di due corpi elastici, Rend. Accad. Naz. Lincei 27.
R. D. Mindlin (1949), Compliance of elastic bodies in contact, J. Appl. Mech. 16, 259–268.
K. L. Johnson (1985), Contact Mechanics, Cambridge University Press, chapters 3, 4 and 7.
M. Ciavarella (1998), The generalized Cattaneo partial slip plane contact problem,
Int. J. Solids Struct. 35, 2349–2362.
J. Jäger (1998), A new principle in contact mechanics, J. Tribol. 120, 677–684.
V. L. Popov, M. Heß (2015), Method of Dimensionality Reduction in Contact Mechanics and Friction,
Springer.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq

from fretwear.mechanics.materials import (
    composite_modulus,
    composite_shear_modulus,
    coupling_ratio,
    require_positive,
)

__all__ = [
    "CattaneoMindlin",
    "HertzContact",
    "LimitingState",
    "composite_modulus",
    "composite_shear_modulus",
    "coupling_ratio",
]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class HertzContact:
    """A smooth elastic sphere pressed on an elastic half-space without friction.

    Parameters
    ----------
    radius : float
        Radius R of the sphere, m (composite radius for two curved bodies).
    load : float
        Normal load P, N.
    composite_modulus : float
        Composite modulus E*, Pa.

    Raises
    ------
    ValueError
        If a parameter is not a positive, finite number.

    Notes
    -----
    Hertz (1882); Johnson (1985), section 4.2 and, for the surface outside, equation 3.42.
    """

    radius: float
    load: float
    composite_modulus: float

    def __post_init__(self) -> None:
        require_positive(
            radius=self.radius, load=self.load, composite_modulus=self.composite_modulus
        )

    @property
    def contact_radius(self) -> float:
        """Contact radius a = (3 P R / 4 E*)^(1/3), m."""
        return math.cbrt(0.75 * self.load * self.radius / self.composite_modulus)

    @property
    def approach(self) -> float:
        """Approach of the bodies δ = a²/R, m."""
        return self.contact_radius**2 / self.radius

    @property
    def peak_pressure(self) -> float:
        """Pressure at the centre p0 = 3 P / (2 π a²), Pa."""
        return 1.5 * self.load / (math.pi * self.contact_radius**2)

    def with_load(self, load: float) -> "HertzContact":
        """Contact of the same bodies under another load (N)."""
        return HertzContact(self.radius, load, self.composite_modulus)

    def pressure(self, r: ArrayLike) -> FloatArray:
        """Pressure p0 √(1 - r²/a²) in Pa, zero outside the contact, at distances ``r`` in m."""
        distance = np.asarray(r, dtype=float)
        inside = np.maximum(1.0 - (distance / self.contact_radius) ** 2, 0.0)
        return np.asarray(self.peak_pressure * np.sqrt(inside))

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap between the deformed surfaces in m, zero inside the contact, at distances ``r`` in m.

        Outside, g = [ (r² - 2a²) acos(a/r) + a √(r² - a²) ] / (π R). The two terms cancel to
        order (r - a)^(3/2) at the edge, so a series replaces them there.
        """
        a = self.contact_radius
        ratio = np.maximum(np.asarray(r, dtype=float) / a, 1.0)
        root = np.sqrt((ratio - 1.0) * (ratio + 1.0))
        exact = (ratio**2 - 2.0) * np.arctan(root) + root
        series = root**3 * (4.0 / 3.0 - root**2 * (8.0 / 15.0 - root**2 * 12.0 / 35.0))
        return np.asarray(np.where(root < 0.01, series, exact) * (a * a / (math.pi * self.radius)))


@dataclass(frozen=True)
class CattaneoMindlin:
    """An unworn smooth sphere in partial slip: the load held, the tangential force between ±Q.

    Parameters
    ----------
    hertz : HertzContact
        The normal contact, under the load P.
    friction : float
        Coefficient of friction µ.
    tangential_load : float
        Amplitude Q of the tangential force, N; zero to below µP.
    coupling : float
        Ratio κ = E*/G* of tangential to normal compliance.

    Raises
    ------
    ValueError
        If friction or coupling is not positive, or Q lies outside [0, µP).

    Notes
    -----
    Cattaneo (1938), Mindlin (1949). In the form of Ciavarella (1998) and Jäger (1998) the traction
    at +Q is µ (p - p*), p* being the pressure under the reduced load P* = P - Q/µ, whose contact
    is the stick zone and whose gap g* gives the slip.
    """

    hertz: HertzContact
    friction: float
    tangential_load: float
    coupling: float

    def __post_init__(self) -> None:
        require_positive(friction=self.friction, coupling=self.coupling)
        limit = self.friction * self.hertz.load
        if not 0.0 <= self.tangential_load < limit:
            raise ValueError(
                f"tangential_load is {self.tangential_load!r} N, but partial slip needs "
                f"0 <= tangential_load < friction * load = {limit:g} N"
            )

    @property
    def load_ratio(self) -> float:
        """Tangential load over the load of gross sliding, X = Q / µP."""
        return self.tangential_load / (self.friction * self.hertz.load)

    @property
    def stick_contact(self) -> HertzContact:
        """Normal contact under the reduced load P* = P - Q/µ."""
        return self.hertz.with_load(self.hertz.load - self.tangential_load / self.friction)

    @property
    def stick_radius(self) -> float:
        """Radius of the stick zone c = a (1 - X)^(1/3), m."""
        return self.stick_contact.contact_radius

    @property
    def tangential_displacement(self) -> float:
        """Displacement of the bodies at +Q, δ_x = µ κ (a² - c²)/R, m."""
        relative_approach = self.hertz.approach - self.stick_contact.approach
        return self.friction * self.coupling * relative_approach

    def shear_traction(self, r: ArrayLike) -> FloatArray:
        """Traction in the direction of Q at +Q, µ (p - p*) in Pa, at distances ``r`` in m."""
        return self.friction * (self.hertz.pressure(r) - self.stick_contact.pressure(r))

    def slip(self, r: ArrayLike) -> FloatArray:
        """Slip amplitude from 0 to +Q, s = µ κ g* in m, at distances ``r`` in m.

        Defined by the gap under the reduced load, also beyond the contact, where nothing slips: the
        surfaces there pass each other by µ κ (g* - g), g being the gap under the full load.
        """
        return self.friction * self.coupling * self.stick_contact.gap(r)

    @property
    def dissipated_energy(self) -> float:
        """Energy dissipated in one full cycle +Q → -Q → +Q, J.

        Notes
        -----
        Mindlin and Deresiewicz (1953), J. Appl. Mech. 20, 327–344; Johnson (1985), section 7.4:
        D = (36 µ² P² / 10 a G*) { 1 - (1-X)^(5/3) - (5X/6) [1 + (1-X)^(2/3)] }. The braces cancel
        to 5 X³ / 162 for small X, so the series is used there.
        """
        x = self.load_ratio
        if x < 1e-2:
            series = 1.0 + x * (2.0 / 3.0 + x * (7.0 / 15.0 + x * 28.0 / 81.0))
            loop = 5.0 * x**3 / 162.0 * series
        else:
            rest = 1.0 - x
            loop = 1.0 - rest ** (5.0 / 3.0) - (5.0 * x / 6.0) * (1.0 + rest ** (2.0 / 3.0))
        composite_shear = self.hertz.composite_modulus / self.coupling
        sliding = (self.friction * self.hertz.load) ** 2
        return 3.6 * sliding / (self.hertz.contact_radius * composite_shear) * loop


@dataclass(frozen=True)
class LimitingState:
    """A smooth elastic sphere after infinitely many cycles under constant load amplitudes.

    Wear stops when the slip zone carries no load: all pressure has moved into the stick zone,
    which wear cannot change and which ends like the edge of a flat punch.

    Parameters
    ----------
    hertz : HertzContact
        The unworn normal contact.
    load_ratio : float
        Tangential load over the load of gross sliding, X = Q / µP, in [0, 1).

    Raises
    ------
    ValueError
        If the load ratio lies outside [0, 1).

    Notes
    -----
    The stick zone is indented by d∞ over its radius c; outside, the worn shape follows the surface
    of the deformed half-space, f∞(r), until it meets the unworn sphere r²/2R at a∞. Superposition
    of a Hertzian contact and a flat punch: Johnson (1985), sections 3.4 and 4.2; the same with the
    method of dimensionality reduction: Popov and Heß (2015).
    """

    hertz: HertzContact
    load_ratio: float

    def __post_init__(self) -> None:
        if not 0.0 <= self.load_ratio < 1.0:
            raise ValueError(
                f"load_ratio is {self.load_ratio!r}, but partial slip needs 0 <= load_ratio < 1"
            )

    @property
    def stick_radius(self) -> float:
        """Radius of the stick zone c = a (1 - X)^(1/3), m."""
        return self.hertz.contact_radius * math.cbrt(1.0 - self.load_ratio)

    @property
    def approach(self) -> float:
        """Approach of the bodies d∞ = P/(2 E* c) + c²/(3R), m."""
        c = self.stick_radius
        punch = self.hertz.load / (2.0 * self.hertz.composite_modulus * c)
        return punch + c * c / (3.0 * self.hertz.radius)

    @property
    def _punch_approach(self) -> float:
        """Approach beyond that of the Hertzian contact of radius c, d∞ - c²/R, m."""
        return self.approach - self.stick_radius**2 / self.hertz.radius

    @property
    def central_pressure(self) -> float:
        """Pressure on the axis, (E*/π) (c/R + d∞/c), Pa."""
        c = self.stick_radius
        modulus = self.hertz.composite_modulus
        return modulus / math.pi * (c / self.hertz.radius + self.approach / c)

    def pressure(self, r: ArrayLike) -> FloatArray:
        """Pressure in Pa at distances ``r`` in m: infinite at r = c, zero outside the stick zone.

        p∞ = (E*/π) [ (2/R) √(c² - r²) + (d∞ - c²/R) / √(c² - r²) ].
        """
        c = self.stick_radius
        distance = np.abs(np.asarray(r, dtype=float))
        root = np.sqrt(np.maximum((c - distance) * (c + distance), 0.0))
        with np.errstate(divide="ignore", invalid="ignore"):
            punch = np.where(self._punch_approach > 0.0, self._punch_approach / root, 0.0)
        total = 2.0 * root / self.hertz.radius + punch
        factor = self.hertz.composite_modulus / math.pi
        return np.asarray(np.where(distance <= c, factor * total, 0.0))

    def wear_depth(self, r: ArrayLike) -> FloatArray:
        """Wear of both bodies together in m, at distances ``r`` in m."""
        return np.asarray(np.maximum(self._height_above_sphere(r), 0.0))

    def width_above(self, pressure: float) -> float:
        """Width of the band at the stick edge where p∞ exceeds a pressure (Pa), m.

        Where the pressure is a plastic limit, this is the size of what yields: a grid much coarser
        than it sees no yielding, or too little.
        """
        c, punch = self.stick_radius, self._punch_approach
        half = math.pi * pressure * self.hertz.radius / (4.0 * self.hertz.composite_modulus)
        discriminant = half * half - 0.5 * punch * self.hertz.radius
        if discriminant <= 0.0:
            return c
        # the smaller root of (2/R) w² - (π p/E*) w + (d∞ - c²/R) = 0 in w = √(c² - r²)
        root = 0.5 * punch * self.hertz.radius / (half + math.sqrt(discriminant))
        return c if root >= c else root * root / (c + math.sqrt((c - root) * (c + root)))

    def worn_shape(self, r: ArrayLike) -> FloatArray:
        """Height of the worn sphere above its lowest point in m, at distances ``r`` in m.

        r²/2R inside the stick zone and beyond a∞; between them
        f∞ = [ r² asin(c/r) - c √(r² - c²) ] / (π R) + d∞ [ 1 - (2/π) asin(c/r) ].
        """
        sphere = np.asarray(r, dtype=float) ** 2 / (2.0 * self.hertz.radius)
        return np.asarray(sphere + self.wear_depth(r))

    @cached_property
    def contact_radius(self) -> float:
        """Radius a∞ at which the worn shape meets the unworn sphere, m."""
        if self.load_ratio == 0.0:
            return self.stick_radius
        outside = 2.0 * self.stick_radius
        while self._height_above_sphere(outside) > 0.0:
            outside *= 2.0
        root = brentq(
            self._height_above_sphere, self._deepest_radius, outside, xtol=1e-15 * outside
        )
        return float(root)

    @property
    def deepest_wear(self) -> float:
        """Largest wear of both bodies together, m."""
        return float(self.wear_depth(self._deepest_radius))

    @property
    def wear_volume(self) -> float:
        """Volume of worn material of both bodies together, m³."""
        c, edge = self.stick_radius, self.contact_radius
        root = math.sqrt((edge - c) * (edge + c))
        angle = math.atan2(root, c)
        punch = self._punch_approach * (edge**2 * angle - c * root) / math.pi
        sphere = edge**2 * (edge**2 - 4.0 * c**2) * angle + c * root * (edge**2 + 2.0 * c**2)
        return 2.0 * math.pi * (punch - sphere / (4.0 * math.pi * self.hertz.radius))

    def _height_above_sphere(self, r: ArrayLike) -> FloatArray:
        """f∞(r) - r²/2R outside the stick zone, m.

        Written as the surface beside a flat punch minus the Hertzian gap, both zero at r = c, so
        that nothing cancels there.
        """
        c = self.stick_radius
        distance = np.maximum(np.asarray(r, dtype=float), c)
        angle = np.arctan2(np.sqrt((distance - c) * (distance + c)), c)
        gap = self.hertz.with_load(self.hertz.load * (1.0 - self.load_ratio)).gap(distance)
        return np.asarray((2.0 / math.pi) * self._punch_approach * angle - gap)

    @cached_property
    def _deepest_radius(self) -> float:
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
        return c + float(brentq(slope, 0.0, outside, xtol=1e-15 * c))
