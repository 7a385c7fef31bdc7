"""A coating of the flat: an elastic layer on its surface, bonded to the substrate.

The parameters of the flat are then those of the substrate. The layer keeps its thickness: wear
changes the shape of the surface but not its elasticity.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic.dataclasses import dataclass

from fretwear.mechanics.contact.film import Film
from fretwear.quantity import Part, Quantity


class Coating(Part):
    """What covers the flat."""

    thickness: float  # m

    def film(self, shear_modulus: float, poisson_ratio: float) -> Film:
        """The elastic film on a substrate of a shear modulus, Pa, and a Poisson's ratio."""
        raise NotImplementedError


@dataclass(frozen=True)
class ElasticLayer(Coating):
    """An isotropic elastic layer of even thickness."""

    thickness: Annotated[
        float,
        Quantity("m", r"$h_\mathrm{c}$", "thickness", "um", like="3 um", gt=0.0),
        "Thickness of the layer.",
    ]
    youngs_modulus: Annotated[
        float,
        Quantity("Pa", r"$E_\mathrm{c}$", "Young's modulus", "GPa", like="400 GPa", gt=0.0),
        "Young's modulus of the layer.",
    ]
    poisson_ratio: Annotated[
        float,
        Quantity("1", r"$ν_\mathrm{c}$", "Poisson's ratio", like="0.2", gt=-1.0, le=0.5),
        "Poisson's ratio of the layer.",
    ]
    kind: Literal["elastic_layer"] = "elastic_layer"

    def film(self, shear_modulus: float, poisson_ratio: float) -> Film:
        """The elastic film on a substrate of a shear modulus, Pa, and a Poisson's ratio."""
        own = 0.5 * self.youngs_modulus / (1.0 + self.poisson_ratio)
        return Film(self.thickness, (own, shear_modulus), (self.poisson_ratio, poisson_ratio))
