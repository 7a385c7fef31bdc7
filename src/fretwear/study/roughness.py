"""The roughness of a case: one wave along x times one along y."""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from fretwear.study.fields import Quantity, refuse
from fretwear.study.quantities import ANGLE, LENGTH

MAX_SLOPE = math.pi / 4.0


class WavyRoughness(BaseModel):
    """Wavy roughness R(x, y) = A cos(k_y y) sin(π/2 + k_x x), with k = (π/2)·tanθ/A.

    The mean slope of a wave along its direction is tanθ, and its length λ = 4A/tanθ.
    An amplitude of zero is a smooth surface whatever the slopes.

    Attributes
    ----------
    amplitude : float
        A in m; text with a unit is accepted.
    slope_x, slope_y : float
        Mean slopes θ along x and y in rad, from 0 (no wave in that direction) to below 45°.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    kind: Annotated[Literal["wavy"], Field(description="Kind of roughness.")] = "wavy"
    amplitude: Annotated[
        float,
        Quantity(LENGTH, at_least=0.0),
        Field(description="Amplitude of the waves; 0 um is smooth."),
    ]
    slope_x: Annotated[
        float,
        Quantity(ANGLE, at_least=0.0, below=MAX_SLOPE),
        Field(description="Mean slope along x, the direction of slip; 0 deg: no wave along x."),
    ]
    slope_y: Annotated[
        float,
        Quantity(ANGLE.like("1 deg"), at_least=0.0, below=MAX_SLOPE),
        Field(description="Mean slope along y; 0 deg: no wave along y."),
    ]

    @model_validator(mode="after")
    def _has_a_wave(self) -> Self:
        if self.amplitude > 0.0 and self.slope_x == 0.0 and self.slope_y == 0.0:
            raise refuse(
                "needs a slope larger than zero along x or y",
                "for a smooth surface write roughness: none",
            )
        return self

    @property
    def wavenumber_x(self) -> float:
        """k_x in rad/m; 0 without a wave along x."""
        return self._wavenumber(self.slope_x)

    @property
    def wavenumber_y(self) -> float:
        """k_y in rad/m; 0 without a wave along y."""
        return self._wavenumber(self.slope_y)

    @property
    def wavelength_x(self) -> float:
        """λ_x in m; inf without a wave along x."""
        return 2.0 * math.pi / self.wavenumber_x if self.wavenumber_x else math.inf

    @property
    def wavelength_y(self) -> float:
        """λ_y in m; inf without a wave along y."""
        return 2.0 * math.pi / self.wavenumber_y if self.wavenumber_y else math.inf

    def _wavenumber(self, slope: float) -> float:
        return 0.5 * math.pi * math.tan(slope) / self.amplitude if self.amplitude else 0.0
