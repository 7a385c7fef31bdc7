"""The bodies and the friction between them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Literal

from fretwear.parts import Part, PerBody, Quantity, pair
from fretwear.theory import composite_modulus, coupling_ratio


class Bodies(Part):
    """What deforms: the elastic bodies as far as one half-space stands for both."""

    @property
    def composite_modulus(self) -> float:
        """E* in Pa."""
        raise NotImplementedError

    @property
    def coupling(self) -> float:
        """κ = E*/G*, tangential compliance relative to the normal one."""
        raise NotImplementedError


@dataclass(frozen=True)
class ElasticBodies(Bodies):
    """Two isotropic elastic bodies, alike or not.

    The coupling of normal pressure and tangential displacement between different materials
    (Dundurs' β) is neglected.
    """

    youngs_modulus: Annotated[
        float | tuple[float, float],
        PerBody(
            "Pa",
            "$E$",
            "Young's modulus",
            "GPa",
            above=0.0,
            description="Young's modulus E, or a pair [body I, body II].",
        ),
    ]
    poisson_ratio: Annotated[
        float | tuple[float, float],
        PerBody(
            "1",
            "$ν$",
            "Poisson's ratio",
            above=-1.0,
            at_most=0.5,
            description="Poisson's ratio, or a pair [body I, body II].",
        ),
    ]
    kind: Literal["elastic"] = "elastic"

    @property
    def _constants(self) -> tuple[float, float, float, float]:
        moduli, ratios = pair(self.youngs_modulus), pair(self.poisson_ratio)
        return moduli[0], ratios[0], moduli[1], ratios[1]

    @cached_property
    def composite_modulus(self) -> float:
        """E* in Pa, from 1/E* = (1−ν1²)/E1 + (1−ν2²)/E2."""
        return composite_modulus(*self._constants)

    @cached_property
    def coupling(self) -> float:
        """κ = E*/G*, with 1/G* = (2−ν1)/(4G1) + (2−ν2)/(4G2)."""
        return coupling_ratio(*self._constants)

    @property
    def slug(self) -> str:
        """Materials are not told in the id."""
        return ""


class Friction(Part):
    """What the tangential traction of slipping cells is."""

    @property
    def coefficient(self) -> float:
        """Coefficient of friction µ."""
        raise NotImplementedError


@dataclass(frozen=True)
class Coulomb(Friction):
    """A constant coefficient of friction."""

    friction: Annotated[
        float,
        Quantity(
            "1",
            "$µ$",
            "coefficient of friction",
            like="0.5",
            above=0.0,
            description="Coefficient of friction µ.",
        ),
    ]
    kind: Literal["coulomb"] = "coulomb"

    @property
    def coefficient(self) -> float:
        """Coefficient of friction µ."""
        return self.friction

    @property
    def slug(self) -> str:
        """``mu0.5``."""
        return f"mu{self.friction:.4g}".replace("+", "")
