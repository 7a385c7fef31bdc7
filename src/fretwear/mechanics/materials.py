"""Materials of the bodies: their elasticity, the friction between them, laws for their wear."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Literal, Protocol

from fretwear.mechanics.values import OfBodies, OverCycles
from fretwear.parts import Mapped, Part, PerBody, Quantity, pair
from fretwear.theory import composite_modulus, coupling_ratio


class Bodies(Part):
    """The elastic bodies, represented by one half-space."""

    composite_modulus: float  # E*, Pa
    coupling: float  # κ = E*/G*, tangential compliance relative to the normal one
    dundurs_beta = 0.0  # |β|, which couples normal and tangential directions; neglected

    def coupling_weighing(self, weight: float) -> float:  # noqa: ARG002 - a single κ
        """κ in a contact in which Poisson's ratio has a given weight, 1/2 for a circle."""
        return self.coupling


@dataclass(frozen=True)
class ElasticBodies(Bodies):
    """Two isotropic elastic bodies, of the same or different materials.

    The couplings between normal and tangential directions of different materials (Dundurs' β) are
    neglected. Pressure drags such bodies over each other, which the contact forgets in cycles under
    a constant load, and friction moves them apart.
    """

    youngs_modulus: Annotated[
        float | tuple[float, float],
        PerBody(Quantity("Pa", "$E$", "Young's modulus", "GPa", above=0.0)),
        "Young's modulus E, or a pair [body I, body II].",
    ]
    poisson_ratio: Annotated[
        float | tuple[float, float],
        PerBody(Quantity("1", "$ν$", "Poisson's ratio", above=-1.0, at_most=0.5)),
        "Poisson's ratio, or a pair [body I, body II].",
    ]
    kind: Literal["elastic"] = "elastic"

    slug = ""  # materials are left out of the id

    @property
    def _constants(self) -> tuple[float, float, float, float]:
        moduli, ratios = pair(self.youngs_modulus), pair(self.poisson_ratio)
        return moduli[0], ratios[0], moduli[1], ratios[1]

    @cached_property
    def composite_modulus(self) -> float:  # type: ignore[override]
        """E* in Pa, from 1/E* = (1−ν1²)/E1 + (1−ν2²)/E2."""
        return composite_modulus(*self._constants)

    @cached_property
    def coupling(self) -> float:  # type: ignore[override]
        """κ = E*/G*, with 1/G* = (2−ν1)/(4G1) + (2−ν2)/(4G2)."""
        return coupling_ratio(*self._constants)

    def coupling_weighing(self, weight: float) -> float:
        """κ in a contact in which Poisson's ratio has a given weight, 1/2 for a circle."""
        return coupling_ratio(*self._constants, weight)

    @property
    def dundurs_beta(self) -> float:  # type: ignore[override]
        """½ |(1−2ν1)/G1 − (1−2ν2)/G2| / ((1−ν1)/G1 + (1−ν2)/G2), 0 for equal bodies."""
        modulus1, nu1, modulus2, nu2 = self._constants
        first, second = (1.0 + nu1) / modulus1, (1.0 + nu2) / modulus2
        difference = abs((1.0 - 2.0 * nu1) * first - (1.0 - 2.0 * nu2) * second)
        return 0.5 * difference / ((1.0 - nu1) * first + (1.0 - nu2) * second)


class Friction(Part):
    """The law for the tangential traction of slipping cells."""

    coefficient: float  # coefficient of friction µ, at cycle 0 where it changes
    least: float  # smallest coefficient of all cycles


@dataclass(frozen=True)
class Coulomb(Friction):
    """A coefficient of friction, constant or given over the cycles."""

    friction: Annotated[
        float | OverCycles,
        OverCycles.of(Quantity("1", "$µ$", "coefficient of friction", like="0.5", above=0.0)),
        "Coefficient of friction µ; or {cycles: [0, 500], values: [0.2, 0.6]}, "
        "linear between these cycles.",
    ]
    kind: Literal["coulomb"] = "coulomb"

    @property
    def coefficient(self) -> float:  # type: ignore[override]
        """Coefficient of friction µ, at cycle 0 where it changes."""
        return float(self.friction)

    @property
    def _values(self) -> tuple[float, ...]:
        return self.friction.values if isinstance(self.friction, OverCycles) else (self.friction,)

    @property
    def least(self) -> float:  # type: ignore[override]
        """Smallest coefficient of all cycles."""
        return min(self._values)

    @property
    def kinks(self) -> tuple[float, ...]:
        """Cycles at which the coefficient does not change smoothly."""
        return self.friction.cycles if isinstance(self.friction, OverCycles) else ()

    def at(self, cycle: float) -> Coulomb:
        """The friction of a cycle."""
        if not isinstance(self.friction, OverCycles):
            return self
        return Coulomb.unchecked(friction=self.friction.at(cycle))

    @property
    def slug(self) -> str:
        """``mu0.5``, ``mu0.2to0.6``."""
        first, *later = self._values
        return f"mu{first:.4g}" + (f"to{later[-1]:.4g}" if later else "")


@dataclass(frozen=True)
class FallingCoefficient(Part):
    """Wear per energy that falls with the density φ of friction power: (α₀ − α₁) e^(−εφ) + α₁."""

    slow: Annotated[
        float | OfBodies,
        OfBodies.of(Quantity("Pa-1", "$α_0$", "wear per energy at low power", "mm^3/J", above=0.0)),
    ]
    fast: Annotated[
        float | OfBodies,
        OfBodies.of(
            Quantity("Pa-1", "$α_1$", "wear per energy at high power", "mm^3/J", above=0.0)
        ),
    ]
    decay: Annotated[float, Quantity("m2 W-1", "$ε$", "decay with power", "mm^2/W", above=0.0)]
    frequency: Annotated[
        float,
        Quantity("s-1", "$f$", "frequency", "Hz", at_least=0.0, unsaid=0.0),
        "Frequency for this law alone, instead of the frequency of the case.",
    ] = 0.0

    @property
    def problem(self) -> tuple[str, str] | None:
        """The bodies must have the same shares at any power."""
        # A value for both bodies together has no shares: −1 is the share of no body.
        slow, fast = (_shares(value) or (-1.0,) for value in (self.slow, self.fast))
        if math.isclose(slow[0], fast[0], rel_tol=1e-6):
            return None
        return (
            "must have parts of the bodies, [indenter, flat], that are alike in slow and fast",
            "slow: [2.55e-4 mm^3/J, 2.55e-4 mm^3/J], fast: [5e-5 mm^3/J, 5e-5 mm^3/J]",
        )

    def __float__(self) -> float:
        return float(self.slow)

    def total(self, power_density: float) -> float:
        """α, 1/Pa, of both bodies at a power per contact area, W/m²."""
        fading = math.exp(-self.decay * power_density)
        slow, fast = float(self.slow), float(self.fast)
        return (slow - fast) * fading + fast


def _shares(value: float | OfBodies | FallingCoefficient) -> tuple[float, float] | None:
    value = value.slow if isinstance(value, FallingCoefficient) else value
    return value.shares if isinstance(value, OfBodies) else None


class Means(Protocol):
    """Means over the contact area and a cycle that a wear law may read."""

    @property
    def frequency(self) -> float:
        """Frequency of the motion, Hz."""

    @property
    def energy_density(self) -> float:
        """Dissipated energy per cycle and area of contact, J/m²."""


class WearLaw(Part):
    """Worn depth in proportion to pressure and path of slip."""

    slug = ""  # the coefficient is left out of the id
    needs_frequency = False  # whether the coefficient depends on the frequency of the motion
    # Fractions of indenter and flat in the wear; None if only their sum is known.
    shares: tuple[float, float] | None = None

    def coefficient(self, friction: Friction) -> float:
        """Worn depth of both bodies together per pressure and path of slip, 1/Pa."""
        raise NotImplementedError

    def driver(self, contact: Means) -> float:  # noqa: ARG002 - a constant has none
        """The quantity that the coefficient follows in the course of wear, read off a contact."""
        return 0.0

    def driven(self, driver: float) -> WearLaw:  # noqa: ARG002
        """The law with the coefficient that it has at a value of its driver."""
        return self


@dataclass(frozen=True)
class Archard(WearLaw):
    """Archard (1953), J. Appl. Phys. 24, 981-988: the coefficient is a constant."""

    wear_coefficient: Annotated[
        float | OfBodies,
        OfBodies.of(Quantity("Pa-1", "$K_w$", "wear coefficient", "/ Pa", above=0.0)),
        "Archard's wear coefficient K_w: depth per pressure and path of slip, of "
        "both bodies together or [indenter, flat]. Or give energy_wear_coefficient.",
    ]
    kind: Literal["archard"] = "archard"

    def coefficient(self, friction: Friction) -> float:  # noqa: ARG002 - of any friction
        """K_w, 1/Pa."""
        return float(self.wear_coefficient)

    @property
    def shares(self) -> tuple[float, float] | None:  # type: ignore[override]
        """Fractions of indenter and flat in the wear."""
        return _shares(self.wear_coefficient)


@dataclass(frozen=True)
class EnergyWear(WearLaw):
    """Wear volume in proportion to the dissipated energy: K = αµ (Fouvry et al. 1996).

    Fouvry, Kapsa and Vincent, "Quantification of fretting damage", Wear 200 (1996), 186-205.
    """

    energy_wear_coefficient: Annotated[
        float | OfBodies | FallingCoefficient,
        OfBodies.of(
            Quantity(
                "Pa-1", "$α$", "energy wear coefficient", "mm^3/J", like="5e-5 mm^3/J", above=0.0
            ),
            Mapped(FallingCoefficient),
        ),
        "Wear volume per dissipated energy α, of both bodies together or "
        "[indenter, flat]; or a mapping of slow, fast and decay where it falls "
        "with the mean density of friction power, at the frequency of the case. "
        "Or give wear_coefficient.",
    ]
    kind: Literal["energy"] = "energy"

    def coefficient(self, friction: Friction) -> float:
        """K = αµ, 1/Pa; at zero power if α falls with power."""
        return float(self.energy_wear_coefficient) * friction.coefficient

    @property
    def needs_frequency(self) -> bool:  # type: ignore[override]
        """Whether α falls with power, at the frequency of the case."""
        value = self.energy_wear_coefficient
        return isinstance(value, FallingCoefficient) and not value.frequency

    def driver(self, contact: Means) -> float:
        """Power per area of contact, W/m², if α falls with it; else 0."""
        value = self.energy_wear_coefficient
        if not isinstance(value, FallingCoefficient):
            return 0.0
        return contact.energy_density * (value.frequency or contact.frequency)

    def driven(self, driver: float) -> EnergyWear:
        """The law with the constant α of a power density, W/m²."""
        value = self.energy_wear_coefficient
        if not isinstance(value, FallingCoefficient):
            return self
        total, shares = value.total(driver), self.shares
        constant = total if shares is None else OfBodies(share * total for share in shares)
        return EnergyWear.unchecked(energy_wear_coefficient=constant)

    @property
    def shares(self) -> tuple[float, float] | None:  # type: ignore[override]
        """Fractions of indenter and flat in the wear."""
        return _shares(self.energy_wear_coefficient)
