"""Closed forms of a smooth cylinder on a flat in plane strain; loads are per length.

References
----------
K. L. Johnson (1985), Contact Mechanics, Cambridge University Press, sections 4.2 and 7.2.
M. Ciavarella (1998), The generalized Cattaneo partial slip plane contact problem,
Int. J. Solids Struct. 35, 2349–2362.
M. Ciavarella, D. A. Hills (1999), A note on some oscillating contact problems subject to wear,
J. Mech. Eng. Sci. 213, 851–857 (the limit of many cycles).
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fretwear.theory.limiting_state import find_root, require_partial_slip
from fretwear.theory.materials import require_positive

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class LineContact:
    """A smooth elastic cylinder pressed on an elastic half-space without friction.

    Parameters
    ----------
    radius : float
        Radius R of the cylinder, m.
    load : float
        Normal load per length P, N/m.
    composite_modulus : float
        Composite modulus E*, Pa.

    Raises
    ------
    ValueError
        If a parameter is not a positive, finite number.
    """

    radius: float
    load: float
    composite_modulus: float

    def __post_init__(self) -> None:
        require_positive(
            radius=self.radius, load=self.load, composite_modulus=self.composite_modulus
        )

    @classmethod
    def at_approach(cls, radius: float, approach: float, modulus: float) -> "LineContact":
        """Contact at an approach (m) as `approach` counts it."""
        require_positive(radius=radius, approach=approach, composite_modulus=modulus)

        def missing(half_width: float) -> float:
            found = cls(radius, cls(radius, 1.0, modulus).load_at(half_width), modulus)
            return approach - found.approach

        half_width = find_root(missing, 1e-12 * radius, radius)
        return cls(radius, cls(radius, 1.0, modulus).load_at(half_width), modulus)

    @property
    def contact_radius(self) -> float:
        """Half-width of the contact a = (4 P R / π E*)^(1/2), m."""
        return math.sqrt(4.0 * self.load * self.radius / (math.pi * self.composite_modulus))

    @property
    def approach(self) -> float:
        """Approach δ = (P / π E*) [2 ln(2R/a) + 1], m.

        The surface of a loaded half-plane sinks without bound towards its middle, or rises without
        bound away from it: the approach counts from the surface at the distance R.
        """
        scale = self.load / (math.pi * self.composite_modulus)
        return scale * (2.0 * math.log(2.0 * self.radius / self.contact_radius) + 1.0)

    @property
    def compliance(self) -> float:
        """dδ/dP = 2 ln(2R/a) / π E*, m²/N; tangential forces meet the same."""
        scale = 2.0 / (math.pi * self.composite_modulus)
        return scale * math.log(2.0 * self.radius / self.contact_radius)

    @property
    def peak_pressure(self) -> float:
        """Peak pressure p0 = E* a / 2R, Pa."""
        return 0.5 * self.composite_modulus * self.contact_radius / self.radius

    @property
    def mean_pressure(self) -> float:
        """P / 2a, Pa."""
        return self.spread_pressure(self.contact_radius)

    def with_load(self, load: float) -> "LineContact":
        """Contact of the same bodies under another load per length (N/m)."""
        return LineContact(self.radius, load, self.composite_modulus)

    def load_at(self, contact_radius: float) -> float:
        """Load per length, N/m, of a contact of some half-width, m."""
        return 0.25 * math.pi * self.composite_modulus * contact_radius**2 / self.radius

    def load_within(self, radius: float) -> float:
        """Load per length, N/m, that the middle of the contact carries to a distance, m."""
        ratio = min(1.0, radius / self.contact_radius)
        inside = math.asin(ratio) + ratio * math.sqrt((1.0 - ratio) * (1.0 + ratio))
        return self.load * inside * 2.0 / math.pi

    def spread_pressure(self, radius: float) -> float:
        """Uniform pressure, Pa, that carries the load on a contact of some half-width, m."""
        return self.load / (2.0 * radius)

    def spread_radius(self, pressure: float) -> float:
        """Half-width, m, of the contact that carries the load at a uniform pressure, Pa."""
        return self.load / (2.0 * pressure)

    def pressure(self, x: ArrayLike) -> FloatArray:
        """Pressure p0 √(1 - x²/a²) in Pa, zero outside the contact, at positions ``x`` in m."""
        position = np.asarray(x, dtype=float)
        inside = np.maximum(1.0 - (position / self.contact_radius) ** 2, 0.0)
        return np.asarray(self.peak_pressure * np.sqrt(inside))

    def gap(self, x: ArrayLike) -> FloatArray:
        """Gap between the deformed surfaces in m, zero inside the contact, at ``x`` in m.

        Outside, g = (a²/2R) [ t √(t² - 1) - arcosh t ], t = abs(x)/a. The terms cancel to order
        (t - 1)^(3/2) at the edge, so a series replaces them there.
        """
        a = self.contact_radius
        ratio = np.maximum(np.abs(np.asarray(x, dtype=float)) / a, 1.0)
        root = np.sqrt((ratio - 1.0) * (ratio + 1.0))
        exact = ratio * root - np.arcsinh(root)
        series = root**3 * (2.0 / 3.0 - root**2 * (1.0 / 5.0 - root**2 * 3.0 / 28.0))
        return np.asarray(np.where(root < 0.01, series, exact) * (0.5 * a * a / self.radius))


@dataclass(frozen=True)
class LinePartialSlip:
    """An unworn cylinder in partial slip: the load held, the tangential load between ±Q.

    Parameters
    ----------
    hertz : LineContact
        The normal contact, under the load per length P.
    friction : float
        Coefficient of friction µ.
    tangential_load : float
        Amplitude Q of the tangential load per length, N/m; zero to below µP.
    coupling : float
        Ratio κ of tangential to normal compliance: 1 in plane strain.

    Raises
    ------
    ValueError
        If friction or coupling is not positive, or Q lies outside [0, µP).
    """

    hertz: LineContact
    friction: float
    tangential_load: float
    coupling: float = 1.0

    def __post_init__(self) -> None:
        require_positive(friction=self.friction, coupling=self.coupling)
        require_partial_slip(self.load_ratio)

    @property
    def load_ratio(self) -> float:
        """Tangential load over the load of gross sliding, X = Q / µP."""
        return self.tangential_load / (self.friction * self.hertz.load)

    @property
    def stick_contact(self) -> LineContact:
        """Normal contact under the reduced load P* = P - Q/µ."""
        return self.hertz.with_load(self.hertz.load * (1.0 - self.load_ratio))

    @property
    def stick_radius(self) -> float:
        """Half-width of the stick zone c = a (1 - X)^(1/2), m."""
        return self.stick_contact.contact_radius

    @property
    def tangential_displacement(self) -> float:
        """Displacement δ_x = µκ (δ(P) - δ(P*)) of the bodies at +Q, m.

        Like the approach, relative to the surface at the distance R.
        """
        relative_approach = self.hertz.approach - self.stick_contact.approach
        return self.friction * self.coupling * relative_approach

    def slip(self, x: ArrayLike) -> FloatArray:
        """Slip amplitude from 0 to +Q, s = µκ g* in m, at positions ``x`` in m."""
        return self.friction * self.coupling * self.stick_contact.gap(x)

    @property
    def dissipated_energy(self) -> float:
        """Energy per length dissipated in one full cycle, J/m.

        D = (4 µ²κ P² / π E*) [ y ln y + (1 - y²)/2 ] with y = 1 - X, the area of the loop that
        Masing's rule makes of `tangential_displacement`; a series where it cancels to X³/6.
        """
        x = self.load_ratio
        if x < 1e-2:
            loop = x**3 * (1.0 / 6.0 + x * (1.0 / 12.0 + x / 20.0))
        else:
            loop = (1.0 - x) * math.log1p(-x) + 0.5 * x * (2.0 - x)
        sliding = (self.friction * self.hertz.load) ** 2 * self.coupling
        return 4.0 * sliding / (math.pi * self.hertz.composite_modulus) * loop


@dataclass(frozen=True)
class LineLimitingState:
    """A smooth cylinder after infinitely many cycles under constant load amplitudes.

    All pressure has moved into the stick zone, which wear cannot change and which ends like the
    edge of a flat punch: Ciavarella and Hills (1999).

    Parameters
    ----------
    hertz : LineContact
        The unworn normal contact.
    load_ratio : float
        Tangential load over the load of gross sliding, X = Q / µP, in [0, 1).

    Raises
    ------
    ValueError
        If the load ratio lies outside [0, 1).
    """

    hertz: LineContact
    load_ratio: float

    def __post_init__(self) -> None:
        require_partial_slip(self.load_ratio)

    @property
    def _stick_contact(self) -> LineContact:
        return self.hertz.with_load(self.hertz.load * (1.0 - self.load_ratio))

    @property
    def stick_radius(self) -> float:
        """Half-width of the stick zone c = a (1 - X)^(1/2), m."""
        return self._stick_contact.contact_radius

    @property
    def _punch_load(self) -> float:
        """Load per length that the flat punch carries, X P, N/m."""
        return self.load_ratio * self.hertz.load

    @property
    def approach(self) -> float:
        """Approach, m, from the surface at the distance R as in `LineContact.approach`."""
        scale = 2.0 * self._punch_load / (math.pi * self.hertz.composite_modulus)
        punch = scale * math.log(2.0 * self.hertz.radius / self.stick_radius)
        return self._stick_contact.approach + punch

    @property
    def central_pressure(self) -> float:
        """Central pressure, Pa."""
        return float(self.pressure(0.0))

    def pressure(self, x: ArrayLike) -> FloatArray:
        """Pressure in Pa at positions ``x`` in m: infinite at x = ±c, zero outside the stick zone.

        p∞ = (E*/2R) √(c² - x²) + X P / (π √(c² - x²)).
        """
        c, position = self.stick_radius, np.abs(np.asarray(x, dtype=float))
        root = np.sqrt(np.maximum((c - position) * (c + position), 0.0))
        with np.errstate(divide="ignore", invalid="ignore"):
            punch = np.where(self._punch_load > 0.0, self._punch_load / (math.pi * root), 0.0)
        total = 0.5 * self.hertz.composite_modulus / self.hertz.radius * root + punch
        return np.asarray(np.where(position <= c, total, 0.0))

    def wear_depth(self, x: ArrayLike) -> FloatArray:
        """Wear of both bodies together in m, at positions ``x`` in m."""
        return np.asarray(np.maximum(self._height_above_cylinder(x), 0.0))

    def width_above(self, pressure: float) -> float:
        """Width of the band at the stick edge where p∞ exceeds a pressure (Pa), m."""
        c, slope = self.stick_radius, 0.5 * self.hertz.composite_modulus / self.hertz.radius
        discriminant = pressure * pressure - 4.0 * slope * self._punch_load / math.pi
        if discriminant <= 0.0:
            return c
        # The smaller root of slope w² - p w + XP/π = 0 in w = √(c² - x²).
        root = 2.0 * self._punch_load / (math.pi * (pressure + math.sqrt(discriminant)))
        return c if root >= c else root * root / (c + math.sqrt((c - root) * (c + root)))

    @cached_property
    def contact_radius(self) -> float:
        """Half-width b at which the worn shape meets the unworn cylinder, m."""
        if self.load_ratio == 0.0:
            return self.stick_radius
        outside = 2.0 * self.stick_radius
        while self._height_above_cylinder(outside) > 0.0:
            outside *= 2.0
        height = self._height_above_cylinder
        return find_root(lambda x: float(height(x)), self._deepest_position, outside)

    @property
    def deepest_wear(self) -> float:
        """Largest wear of both bodies together, m."""
        return float(self.wear_depth(self._deepest_position))

    @property
    def wear_volume(self) -> float:
        """Volume per length of worn material of both bodies together, m²."""
        c = self.stick_radius
        ratio = self.contact_radius / c
        root = math.sqrt((ratio - 1.0) * (ratio + 1.0))
        below = ratio * math.asinh(root) - root
        punch = 2.0 * self._punch_load / (math.pi * self.hertz.composite_modulus) * c * below
        return 2.0 * (punch - 0.5 * c**3 / self.hertz.radius * (root**3 / 3.0 - below))

    def _height_above_cylinder(self, x: ArrayLike) -> FloatArray:
        """Surface beside a flat punch minus the Hertzian gap, both zero at |x| = c, m."""
        c = self.stick_radius
        ratio = np.maximum(np.abs(np.asarray(x, dtype=float)) / c, 1.0)
        rise = np.arcsinh(np.sqrt((ratio - 1.0) * (ratio + 1.0)))
        scale = 2.0 * self._punch_load / (math.pi * self.hertz.composite_modulus)
        return np.asarray(scale * rise - self._stick_contact.gap(ratio * c))

    @property
    def _deepest_position(self) -> float:
        """Where the wear is deepest, m: x² = c² + X a²/2."""
        a = self.hertz.contact_radius
        return math.sqrt(self.stick_radius**2 + 0.5 * self.load_ratio * a * a)
