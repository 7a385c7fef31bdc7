"""Materials of the bodies: their elasticity, and the friction between them."""

from __future__ import annotations

from functools import cached_property, partial
from typing import Annotated, Literal

import numpy as np
from pydantic.dataclasses import dataclass

from fretwear.arrays import Array
from fretwear.mechanics.contact.film import Film
from fretwear.mechanics.surfaces.coating import Coating
from fretwear.mechanics.values import OverCycles
from fretwear.quantity import MATERIALS, Part, Quantity, pair
from fretwear.theory import composite_modulus, coupling_ratio

# Positive, and at most what no pair reaches short of seizure, clean metals in vacuum included.
_COEFFICIENT = partial(Quantity, "1", gt=0.0, le=10.0)


class Bodies(Part):
    """The elastic bodies, represented by one half-space."""

    composite_modulus: float  # E*, Pa
    coupling: float  # κ = E*/G*, tangential compliance relative to the normal one
    dundurs_beta = 0.0  # |β|, which couples normal and tangential directions; neglected

    @property
    def contraction(self) -> float:
        """Poisson's ratio of the flat; by default that of two equal bodies."""
        return 2.0 * (self.coupling - 1.0) / (2.0 * self.coupling - 1.0)

    def stretch(self, *, plane_strain: bool) -> float:
        """Strain of the flat along x per stress along x, 1/Pa; by default of two equal bodies."""
        shortens = 1.0 if plane_strain else 1.0 - self.contraction**2
        return 0.5 / self.composite_modulus / shortens

    def coupling_weighing(self, weight: float) -> float:
        """κ in a contact in which Poisson's ratio has a given weight, 1/2 for a circle."""
        return self.coupling

    def covered(self, coating: Coating) -> Film:
        """The film of a coating on the flat; by default on one of two equal bodies."""
        nu = self.contraction
        return coating.film(self.composite_modulus * (1.0 - nu), nu)


@dataclass(frozen=True)
class ElasticBodies(Bodies):
    """Two isotropic elastic bodies, of the same or different materials.

    The couplings between normal and tangential directions of different materials (Dundurs' β) are
    neglected. Through them pressure drags the bodies over each other, which a contact under a
    constant load forgets in some cycles, and friction separates them.
    """

    youngs_modulus: Annotated[
        float | tuple[float, float],
        Quantity("Pa", "$E$", "Young's modulus", "GPa", gt=0.0, places=MATERIALS),
        "Young's modulus E, or a pair [body I, body II].",
    ]
    poisson_ratio: Annotated[
        float | tuple[float, float],
        Quantity("1", "$ν$", "Poisson's ratio", gt=-1.0, le=0.5, places=MATERIALS),
        "Poisson's ratio, or a pair [body I, body II].",
    ]
    kind: Literal["elastic"] = "elastic"

    slug = ""  # materials are left out of the id

    @property
    def contraction(self) -> float:
        """Poisson's ratio of the flat."""
        return self._constants[3]

    def stretch(self, *, plane_strain: bool) -> float:
        """Strain of the flat along x per stress along x, 1/Pa: 1/E, in plane strain (1 − ν²)/E."""
        _, _, modulus, nu = self._constants
        return (1.0 - nu**2 if plane_strain else 1.0) / modulus

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

    def covered(self, coating: Coating) -> Film:
        """The film of a coating on the flat."""
        _, _, modulus, nu = self._constants
        return coating.film(0.5 * modulus / (1.0 + nu), nu)

    @cached_property
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
    greatest: float  # largest coefficient of all cycles
    follows_slip = False  # whether µ depends on the place through its slip
    ratio: float | Array = 1.0  # µ of each place over the coefficient, if it follows slip

    def slipped(self, energy: Array | None) -> Friction:
        """The friction of places that have dissipated an energy per area, J/m²."""
        return self


@dataclass(frozen=True)
class OverEnergy(Part):
    """A coefficient of friction that changes where the surfaces slip.

    It is end − (end − start) e^(−e/energy), e being the energy per area dissipated at a place.
    """

    start: Annotated[
        float,
        _COEFFICIENT("$µ_0$", "coefficient of friction before slip", like="0.2"),
    ]
    end: Annotated[
        float,
        _COEFFICIENT("$µ_1$", "coefficient of friction after slip", like="0.8"),
    ]
    energy: Annotated[
        float,
        Quantity(
            "J m-2", "$e_µ$", "energy that changes friction", "J/mm^2", like="0.5 J/mm^2", gt=0.0
        ),
    ]

    def read_by(self, *_: object) -> OverEnergy | float:
        """The law itself; a number if friction does not change."""
        return self.start if self.start == self.end else self

    def slipped(self, energy: Array) -> Array:
        """Coefficients of places that have dissipated an energy per area, J/m²."""
        return np.asarray(self.end - (self.end - self.start) * np.exp(-energy / self.energy))

    def __float__(self) -> float:
        return self.start

    def __str__(self) -> str:
        """``0.2 to 0.8 over 0.5 J/mm²``."""
        return (
            f"{self.start:g} to {self.end:g} over {self.parameters()['energy'].text(self.energy)}"
        )


@dataclass(frozen=True)
class Coulomb(Friction):
    """A coefficient of friction: constant, given over the cycles, or following slip."""

    friction: Annotated[
        float | OverCycles | OverEnergy,
        _COEFFICIENT("$µ$", "coefficient of friction", like="0.5", forms=(OverCycles, OverEnergy)),
        "Coefficient; {cycles: [0, 500], values: [0.2, 0.6]}, linear in between; or {start: 0.2, "
        "end: 0.8, energy: 0.5 J/mm^2} by local dissipated energy.",
    ]
    kind: Literal["coulomb"] = "coulomb"

    @property
    def coefficient(self) -> float:  # type: ignore[override]
        """Coefficient of friction µ, at cycle 0 where it changes."""
        return float(self.friction)

    @property
    def _values(self) -> tuple[float, ...]:
        if isinstance(self.friction, OverEnergy):
            return self.friction.start, self.friction.end
        return self.friction.values if isinstance(self.friction, OverCycles) else (self.friction,)

    @property
    def follows_slip(self) -> bool:  # type: ignore[override]
        """Whether µ depends on the place through its slip."""
        return isinstance(self.friction, OverEnergy)

    def slipped(self, energy: Array | None) -> Coulomb:
        """The friction of places that have dissipated an energy per area, J/m²."""
        if not isinstance(self.friction, OverEnergy) or energy is None:
            return self
        law = Coulomb.unchecked(friction=self.friction)
        vars(law)["ratio"] = self.friction.slipped(energy) / self.friction.start
        return law

    @property
    def least(self) -> float:  # type: ignore[override]
        """Smallest coefficient of all cycles."""
        return min(self._values)

    @property
    def greatest(self) -> float:  # type: ignore[override]
        """Largest coefficient of all cycles."""
        return max(self._values)

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
