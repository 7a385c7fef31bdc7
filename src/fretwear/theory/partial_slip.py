"""Closed forms of smooth contacts in partial slip: unworn, and after infinitely many cycles."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from fretwear.theory.line_contact import LineContact
from fretwear.theory.point_contact import FloatArray, HertzContact, find_root, require_positive

_PLACES = 10_001


def gross_slip_energy(
    hertz: HertzContact, friction: float, coupling: float, displacement: float
) -> float:
    """Energy dissipated in one cycle of a contact that slides as a whole, J, or J/m of a cylinder.

    A sphere dissipates 4µP (U − 0.8 U_t); a cylinder 4µP (U − U_t), plus 2µ²κP²/πE* in partial slip
    before it slides. ``friction`` is µ, ``coupling`` κ, and ``displacement`` the amplitude U, m, of
    distant points, above U_t = µκ δ.
    """
    stored = 0.8 * hertz.approach
    if isinstance(hertz, LineContact):
        stored = hertz.approach - hertz.load / (2.0 * math.pi * hertz.composite_modulus)
    return 4.0 * friction * hertz.load * (displacement - friction * coupling * stored)


def share_of_band(band: float, cell: float) -> float:
    """Share of the effect of a yielding band that cells of a width resolve, both m; 0 to 1.

    The pressure at the stick edge of a `LimitingState` falls with the root of the distance, so its
    mean over a cell is twice its value at the far side of the cell. This mean exceeds a limit only
    if the cell is narrower than four times the band. A band at least as wide as the cell counts in
    full.
    """
    return min(max(math.log(4.0 * band / cell, 4.0), 0.0), 1.0) if band > 0.0 else 0.0


@dataclass(frozen=True)
class PartialSlip:
    """An unworn smooth sphere in partial slip: constant load, tangential force between ±Q.

    Cattaneo (1938), Mindlin (1949). In the form of Ciavarella (1998) and Jäger (1998) the traction
    at +Q is µ (p - p*), p* being the pressure under the reduced load P* = P - Q/µ, whose contact
    is the stick zone and whose gap g* gives the slip. Friction or coupling that is not positive, or
    Q outside [0, µP), raises a ValueError.
    """

    hertz: HertzContact  #: the normal contact, under the load P
    friction: float  #: coefficient of friction µ
    tangential_load: float  #: amplitude Q of the tangential force, N
    coupling: float  #: tangential over normal compliance κ = E*/G*

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
        """Radius of the stick zone c = a (1 - X)^(1/3), or a (1 - X)^(1/2) of a cylinder, m."""
        return self.stick_contact.contact_radius

    @property
    def stick_load_share(self) -> float:
        """Share of the load that the stick zone carries."""
        outside = max(0.0, 1.0 - (self.stick_radius / self.hertz.contact_radius) ** 2)
        return 1.0 - outside * math.sqrt(outside)

    @property
    def tangential_displacement(self) -> float:
        """Displacement of the bodies at +Q, δ_x = µ κ (δ(P) - δ(P*)), m."""
        pressed = self.hertz.approach - self.stick_contact.approach
        return self.friction * self.coupling * pressed

    def shear_traction(self, r: ArrayLike) -> FloatArray:
        """Traction in the direction of Q at +Q, µ (p - p*) in Pa, at distances ``r`` in m."""
        return self.friction * (self.hertz.pressure(r) - self.stick_contact.pressure(r))

    def slip(self, r: ArrayLike) -> FloatArray:
        """Slip amplitude from 0 to +Q, s = µ κ g* in m, at distances ``r`` in m.

        The formula continues beyond the contact, where nothing slips: the surfaces there pass each
        other by µ κ (g* - g), g being the gap under the full load.
        """
        return self.friction * self.coupling * self.stick_contact.gap(r)

    @property
    def dissipated_energy(self) -> float:
        """Energy dissipated in one full cycle +Q → -Q → +Q, J.

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
class LinePartialSlip(PartialSlip):
    """An unworn cylinder in partial slip: loads are per length, and κ = 1 in plane strain."""

    coupling: float = 1.0

    @property
    def stick_load_share(self) -> float:
        """Share of the load that the stick zone carries."""
        ratio = self.stick_radius / self.hertz.contact_radius
        return 2.0 / math.pi * (math.asin(ratio) + ratio * math.sqrt((1.0 - ratio) * (1.0 + ratio)))

    @property
    def dissipated_energy(self) -> float:
        """Energy per length dissipated in one full cycle, J/m.

        D = (4 µ²κ P² / π E*) [ y ln y + (1 - y²)/2 ] with y = 1 - X is the area of the loop that
        Masing's rule makes of `tangential_displacement`. The bracket cancels to X³/6 for small X,
        so a series is used there.
        """
        x = self.load_ratio
        if x < 1e-2:
            loop = x**3 * (1.0 / 6.0 + x * (1.0 / 12.0 + x * (1.0 / 20.0 + x / 30.0)))
        else:
            loop = (1.0 - x) * math.log1p(-x) + 0.5 * x * (2.0 - x)
        sliding = (self.friction * self.hertz.load) ** 2 * self.coupling
        return 4.0 * sliding / (math.pi * self.hertz.composite_modulus) * loop


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
        """πS/E*, m, of the punch's pressure S/√(c² - r²): approach beyond a sphere's, d∞ - c²/R."""
        return self.approach - self.stick_radius**2 / self.hertz.radius

    @property
    def central_pressure(self) -> float:
        """Central pressure, (E*/π) (c/R + d∞/c) of a sphere, Pa."""
        return float(self.pressure(0.0))

    def pressure(self, r: ArrayLike) -> FloatArray:
        """Pressure in Pa at distances ``r`` in m: infinite at r = c, zero outside the stick zone.

        A Hertzian contact and a flat punch, both of radius c, superposed. Sphere:
        p∞ = (E*/π) [ (2/R) √(c² - r²) + (d∞ - c²/R) / √(c² - r²) ]; cylinder:
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
        punch_depth = self._beside(np.sqrt((distance - c) * (distance + c)), c)
        height = (2.0 / math.pi) * self._punch_approach * punch_depth - self._stick_contact.gap(
            distance
        )
        return np.asarray(np.maximum(height, 0.0))

    def width_above(self, pressure: float) -> float:
        """Width of the band at the stick edge where p∞ exceeds a pressure (Pa), m.

        At a plastic limit this is the width of the yielding zone, which a much coarser grid misses
        or underestimates.
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
        """Largest wear of both bodies together, m, to some parts in 10⁹."""
        places = np.linspace(self.stick_radius, self.contact_radius, _PLACES)
        return float(self.wear_depth(places).max())

    @property
    def wear_volume(self) -> float:
        """Volume worn off both bodies together, m³."""
        c, edge = self.stick_radius, self.contact_radius
        root = math.sqrt((edge - c) * (edge + c))
        angle = math.atan2(root, c)
        punch = self._punch_approach * (edge**2 * angle - c * root) / math.pi
        sphere = edge**2 * (edge**2 - 4.0 * c**2) * angle + c * root * (edge**2 + 2.0 * c**2)
        return 2.0 * math.pi * (punch - sphere / (4.0 * math.pi * self.hertz.radius))

    def _beside(self, root: FloatArray, c: float) -> FloatArray:
        """Shape of the surface beside a flat punch, at distances given as √(r² - c²)."""
        return np.asarray(np.arctan2(root, c))


@dataclass(frozen=True)
class LineLimitingState(LimitingState):
    """A smooth cylinder after infinitely many cycles under constant load amplitudes.

    The counterpart of `LimitingState` with loads per length: Ciavarella and Hills (1999).
    """

    hertz: LineContact

    _flatness: ClassVar[float] = 4.0

    @property
    def stick_radius(self) -> float:
        """Half-width of the stick zone c = a (1 - X)^(1/2), m."""
        return self._stick_contact.contact_radius

    @property
    def _punch_approach(self) -> float:
        """πS/E*, m, of the pressure S/√(c² - x²) of the flat punch, which carries X P = πS."""
        return self.load_ratio * self.hertz.load / self.hertz.composite_modulus

    @property
    def approach(self) -> float:
        """Approach, m, relative to the surface point at `LineContact.reference`."""
        rise = math.log(2.0 * self.hertz.reference / self.stick_radius)
        return self._stick_contact.approach + 2.0 / math.pi * self._punch_approach * rise

    @cached_property
    def contact_radius(self) -> float:
        """Half-width a∞ = c cosh t at which the worn shape meets the cylinder, m.

        The wear depth is zero there: sinh 2t / 2t = 1 / (1 - X).
        """
        if self.load_ratio == 0.0:
            return self.stick_radius
        total = 1.0 / (1.0 - self.load_ratio)
        most = 1.0 + math.log(2.0 * total)
        root = find_root(lambda t: total - math.sinh(2.0 * t) / (2.0 * t), 1e-12, most)
        return self.stick_radius * math.cosh(root)

    @property
    def wear_volume(self) -> float:
        """Volume per length worn off both bodies together, m²."""
        c = self.stick_radius
        ratio = self.contact_radius / c
        root = math.sqrt((ratio - 1.0) * (ratio + 1.0))
        punch_area = ratio * math.asinh(root) - root
        cylinder = 0.5 * c**3 / self.hertz.radius * (root**3 / 3.0 - punch_area)
        return 2.0 * (2.0 / math.pi * self._punch_approach * c * punch_area - cylinder)

    def _beside(self, root: FloatArray, c: float) -> FloatArray:
        return np.asarray(np.arcsinh(root / c))
