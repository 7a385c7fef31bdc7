"""Closed forms of an unworn smooth sphere in partial slip.

References
----------
C. Cattaneo (1938), Sul contatto di due corpi elastici, Rend. Accad. Naz. Lincei 27.
R. D. Mindlin (1949), Compliance of elastic bodies in contact, J. Appl. Mech. 16, 259–268.
K. L. Johnson (1985), Contact Mechanics, Cambridge University Press, chapter 7.
M. Ciavarella (1998), The generalized Cattaneo partial slip plane contact problem,
Int. J. Solids Struct. 35, 2349–2362.
J. Jäger (1998), A new principle in contact mechanics, J. Tribol. 120, 677–684.
"""

import math
from dataclasses import dataclass

from numpy.typing import ArrayLike

from fretwear.theory.hertz import FloatArray, HertzContact
from fretwear.theory.line_contact import LineContact
from fretwear.theory.materials import require_positive


def gross_slip_energy(
    hertz: HertzContact, friction: float, coupling: float, displacement: float
) -> float:
    """Energy dissipated in one cycle of a contact that slides as a whole, J, or J/m of a cylinder.

    4µP (U − 0.8 U_t) of a sphere; of a cylinder 4µP (U − U_t) and what slips before it slides,
    2µ²κP²/πE*. ``friction`` is µ, ``coupling`` κ, and ``displacement`` the amplitude U, m, of
    distant points, above U_t = µκ δ.
    """
    stored = 0.8 * hertz.approach
    if isinstance(hertz, LineContact):
        stored = hertz.approach - hertz.load / (2.0 * math.pi * hertz.composite_modulus)
    return 4.0 * friction * hertz.load * (displacement - friction * coupling * stored)


@dataclass(frozen=True)
class CattaneoMindlin:
    """An unworn smooth sphere in partial slip: constant load, tangential force between ±Q.

    Cattaneo (1938), Mindlin (1949). In the form of Ciavarella (1998) and Jäger (1998) the traction
    at +Q is µ (p - p*), p* being the pressure under the reduced load P* = P - Q/µ, whose contact
    is the stick zone and whose gap g* gives the slip. A ValueError says that friction or coupling
    is not positive, or Q not in [0, µP).
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
        """Radius of the stick zone c = a (1 - X)^(1/3), of a cylinder a (1 - X)^(1/2), m."""
        return self.stick_contact.contact_radius

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

        Defined by the gap under the reduced load, also beyond the contact, where nothing slips: the
        surfaces there pass each other by µ κ (g* - g), g being the gap under the full load.
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
class LinePartialSlip(CattaneoMindlin):
    """An unworn cylinder in partial slip: loads are per length, and κ = 1 in plane strain."""

    coupling: float = 1.0

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
