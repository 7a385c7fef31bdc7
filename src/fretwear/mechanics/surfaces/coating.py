"""A coating of the flat: an elastic layer on its surface, bonded to the substrate.

The parameters of the flat are then those of the substrate. The elastic layer keeps its thickness:
wear changes the shape of the surface, but not its elasticity. Where the flat has worn by the
thickness, wear coefficient and plastic limit are those of the substrate.
"""

from __future__ import annotations

import dataclasses
from typing import Annotated, Literal

import numpy as np
from pydantic.dataclasses import dataclass

from fretwear.arrays import Array, Mask
from fretwear.mechanics.contact.film import Film
from fretwear.quantity import Part, Quantity

# Wear that stops at an interface misses it by less than this part of its depth.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Coating(Part):
    """An isotropic elastic layer of even thickness on the flat."""

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
    wear_coefficient: Annotated[
        float | None,
        Quantity("Pa-1", r"$K_\mathrm{c}$", "wear coefficient", "/ Pa", like="1e-15 / Pa", gt=0.0),
        "K_w or α of the layer until it is worn through; by default as the case.",
    ] = None
    plastic_limit: Annotated[
        float | None,
        Quantity("Pa", r"$p_\mathrm{lim,c}$", "plastic limit", "MPa", like="12 GPa", gt=0.0),
        "Highest pressure on the layer; by default as the case.",
    ] = None
    kind: Literal["elastic_layer"] = "elastic_layer"

    def film(self, shear_modulus: float, poisson_ratio: float) -> Film:
        """The elastic film on a substrate of a shear modulus, Pa, and a Poisson's ratio."""
        own = 0.5 * self.youngs_modulus / (1.0 + self.poisson_ratio)
        return Film(self.thickness, (own, shear_modulus), (self.poisson_ratio, poisson_ratio))


@dataclasses.dataclass(frozen=True)
class Interface:
    """The interface of coating and substrate, below which the flat wears at another rate."""

    depth: float  # wear of both bodies together that reaches it, m
    ratio: float  # wear coefficient of both bodies below it over that above
    shares: tuple[float, float]  # of the flat in the wear above it and below

    def reached(self, wear: Array) -> Mask:
        """Places at which wear, m, has reached the interface."""
        return np.asarray(wear >= (1.0 - _ROUNDING) * self.depth)

    def slope(self, wear: Array) -> Array:
        """Wear coefficient at a wear depth, m, over that above the interface."""
        return np.where(self.reached(wear), self.ratio, 1.0)

    def mean_slope(self, start: Array, end: Array) -> Array:
        """The slope in the mean over a step in which wear rises from one depth, m, to another."""
        above = np.clip(self.depth - start, 0.0, end - start)
        exposure = above + (end - start - above) / (self.ratio or np.inf)
        moves = exposure > 0.0
        return np.where(moves, (end - start) / np.where(moves, exposure, 1.0), self.slope(end))

    def cycles_left(self, wear: Array, rate: Array) -> float:
        """Cycles after which a rate of wear, m, first reaches the interface; 0 if wear has."""
        if self.reached(wear).any():
            return 0.0
        wears = rate > 0.0
        return float(((self.depth - wear[wears]) / rate[wears]).min(initial=np.inf))

    @property
    def alone(self) -> Interface:
        """The interface by the wear depth of the flat alone."""
        above, below = self.shares
        if not above:
            return self
        return Interface(self.depth * above, self.ratio * below / above, (1.0, 1.0))

    def opened(self, part: float) -> Interface:
        """The interface by the gap that a part of the wear opens."""
        return dataclasses.replace(self, depth=part * self.depth)

    def exposure(self, added: float) -> float:
        """Wear depth, m, of a coating without end while the bodies, unworn, wear by ``added``."""
        if not self.ratio:
            return added
        above = min(self.depth, added)
        return above + (added - above) / self.ratio

    def deepened(self, wear: Array, added: Array) -> Array:
        """Wear depth, m, once so much has been added that no interface would slow or speed up."""
        above = np.minimum(added, np.maximum(self.depth - wear, 0.0))
        return np.asarray(wear + above + self.ratio * (added - above))

    def of_flat(self, wear: Array) -> Array:
        """The part of a wear depth, m, that is of the flat."""
        above = np.minimum(wear, self.depth)
        return np.asarray(self.shares[0] * above + self.shares[1] * (wear - above))
