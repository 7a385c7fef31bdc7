"""The unworn gap between the bodies before any load: an indenter, smooth or rough, on a flat."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

import numpy as np

from fretwear.mechanics.geometry import Array, Even
from fretwear.parts import Part, Quantity

MAX_SLOPE = math.pi / 4.0


class Indenter(Part):
    """The smooth shape of the bodies.

    Attributes
    ----------
    is_axisymmetric
        Whether the gap depends on the distance from the axis alone.
    """

    is_axisymmetric: ClassVar[bool] = False

    @property
    def even(self) -> Even:
        """Whether the gap is even along x and along y, exactly: then one side tells all."""
        return self.is_axisymmetric, self.is_axisymmetric

    def gap(self, x: Array, y: Array) -> Array:
        """Gap at zero load and zero approach, m, at coordinates in m that broadcast."""
        raise NotImplementedError

    @property
    def curvature_radius(self) -> float:
        """Radius, m, of the sphere whose Hertzian contact gives the scales of this one."""
        raise NotImplementedError

    @property
    def finest(self) -> tuple[float, float]:
        """Length along x and along y, m, that a grid has to resolve; inf where there is none."""
        return math.inf, math.inf


@dataclass(frozen=True)
class Sphere(Indenter):
    """A sphere, as the paraboloid (x² + y²)/2R of Hertz's theory."""

    radius: Annotated[
        float,
        Quantity(
            "m",
            "$R$",
            "sphere radius",
            "mm",
            like="10 mm",
            above=0.0,
            description="Radius R of the sphere.",
        ),
    ]
    kind: Literal["sphere"] = "sphere"

    is_axisymmetric: ClassVar[bool] = True

    def gap(self, x: Array, y: Array) -> Array:
        """(x² + y²)/2R, m."""
        result: Array = (x**2 + y**2) / (2.0 * self.radius)
        return result

    @property
    def curvature_radius(self) -> float:
        """R, m."""
        return self.radius

    @property
    def slug(self) -> str:
        """The usual indenter is not told in the id."""
        return ""


class Roughness(Part):
    """What the surfaces are beside their smooth shape."""

    @property
    def even(self) -> Even:
        """Whether the height is even along x and along y, exactly: then one side tells all."""
        return False, False

    def height(self, x: Array, y: Array) -> Array:
        """Added to the gap, m, at coordinates in m that broadcast."""
        raise NotImplementedError

    @property
    def finest(self) -> tuple[float, float]:
        """Length along x and along y, m, that a grid has to resolve; inf where there is none."""
        raise NotImplementedError

    @property
    def highest(self) -> float:
        """Bound of the magnitude of the height, m."""
        raise NotImplementedError

    @property
    def wavelengths(self) -> tuple[float, float]:
        """Distance between neighbouring tips along x and along y, m; inf where there is one."""
        return self.finest


def even_in(indenter: Indenter, roughness: Roughness | None) -> Even:
    """Along which axes the gap between smooth or rough bodies is even."""
    along_x, along_y = indenter.even
    if roughness is None:
        return along_x, along_y
    return along_x and roughness.even[0], along_y and roughness.even[1]


@dataclass(frozen=True)
class WavyRoughness(Roughness):
    """Wavy roughness R(x, y) = A cos(k_y y) sin(π/2 + k_x x), with k = (π/2)·tanθ/A.

    The mean slope of a wave along its direction is tanθ, and its length λ = 4A/tanθ.
    An amplitude of zero is a smooth surface whatever the slopes.
    """

    amplitude: Annotated[
        float,
        Quantity(
            "m",
            "$A$",
            "roughness amplitude",
            "um",
            at_least=0.0,
            zero="smooth",
            absent=0.0,
            description="Amplitude of the waves; 0 um is smooth.",
        ),
    ]
    slope_x: Annotated[
        float,
        Quantity(
            "rad",
            "$θ_x$",
            "roughness slope along x",
            "deg",
            at_least=0.0,
            below=MAX_SLOPE,
            absent=0.0,
            description="Mean slope along x, the direction of slip; 0 deg: no wave along x.",
        ),
    ]
    slope_y: Annotated[
        float,
        Quantity(
            "rad",
            "$θ_y$",
            "roughness slope along y",
            "deg",
            like="1 deg",
            at_least=0.0,
            below=MAX_SLOPE,
            absent=0.0,
            description="Mean slope along y; 0 deg: no wave along y.",
        ),
    ]
    kind: Literal["wavy"] = "wavy"

    @property
    def even(self) -> Even:
        """Both."""
        return True, True

    def height(self, x: Array, y: Array) -> Array:
        """A cos(k_x x) cos(k_y y), m."""
        along_x = self.amplitude * np.cos(self.wavenumber_x * x)
        result: Array = along_x * np.cos(self.wavenumber_y * y)
        return result

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

    @property
    def finest(self) -> tuple[float, float]:
        """(λ_x, λ_y) in m."""
        return self.wavelength_x, self.wavelength_y

    @property
    def highest(self) -> float:
        """A in m."""
        return self.amplitude

    @property
    def problem(self) -> tuple[str, str] | None:
        """A wave needs a slope."""
        if self.amplitude > 0.0 and self.slope_x == 0.0 and self.slope_y == 0.0:
            return (
                "needs a slope larger than zero along x or y",
                "for a smooth surface write roughness: none",
            )
        return None

    @property
    def is_trivial(self) -> bool:
        """Whether there is no height."""
        return self.amplitude == 0.0

    @property
    def slug(self) -> str:
        """``A0.2um``."""
        return f"A{self.amplitude * 1e6:.4g}um".replace("+", "")

    def _wavenumber(self, slope: float) -> float:
        return 0.5 * math.pi * math.tan(slope) / self.amplitude if self.amplitude else 0.0
