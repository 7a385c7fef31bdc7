"""What a pressure wears off on a path of slip."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from fretwear.mechanics.materials import Friction
from fretwear.parts import Part, Quantity


class WearLaw(Part):
    """Worn depth in proportion to pressure and path of slip."""

    def coefficient(self, friction: Friction) -> float:
        """Worn depth of both bodies together per pressure and path of slip, 1/Pa."""
        raise NotImplementedError


@dataclass(frozen=True)
class Archard(WearLaw):
    """Archard (1953), J. Appl. Phys. 24, 981-988: the coefficient is a constant."""

    wear_coefficient: Annotated[
        float,
        Quantity(
            "Pa-1",
            "$K_w$",
            "wear coefficient",
            "/ Pa",
            above=0.0,
            description="Archard's wear coefficient K_w: depth per pressure and path of slip.",
        ),
    ]
    kind: Literal["archard"] = "archard"

    def coefficient(self, friction: Friction) -> float:
        """K_w, 1/Pa."""
        del friction
        return self.wear_coefficient

    @property
    def slug(self) -> str:
        """The coefficient is not told in the id."""
        return ""
