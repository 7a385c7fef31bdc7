"""The smooth shape of the bodies before any load: an indenter on a flat."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

from fretwear.mechanics.geometry import Array, Even
from fretwear.mechanics.loading import Normal
from fretwear.mechanics.materials import Bodies
from fretwear.parts import Part, Quantity
from fretwear.theory import (
    CattaneoMindlin,
    HertzContact,
    LimitingState,
    LineContact,
    LineLimitingState,
    LinePartialSlip,
)


class Indenter(Part):
    """The smooth shape of the bodies.

    Attributes
    ----------
    is_axisymmetric
        Whether the gap depends on the distance from the axis alone.
    detail, cells
        What `finest` is the length of, in a word, and how many cells resolve it; half as many
        would just do.
    is_line
        Whether the contact is a strip in plane strain: loads are per length, N/m.
    smooth, partial_slip, limiting
        The closed forms of the contact that gives the scales.
    """

    is_axisymmetric: ClassVar[bool] = False
    detail: ClassVar[str] = "detail"
    cells: ClassVar[int] = 16
    is_line: ClassVar[bool] = False
    smooth: ClassVar[type[HertzContact | LineContact]] = HertzContact
    partial_slip: ClassVar[type[CattaneoMindlin | LinePartialSlip]] = CattaneoMindlin
    limiting: ClassVar[type[LimitingState | LineLimitingState]] = LimitingState

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

    def hertz(self, normal: Normal, modulus: float) -> HertzContact | LineContact:
        """The smooth contact that gives the scales, of bodies of a composite modulus, Pa."""
        return normal.hertz(self.smooth, self.curvature_radius, modulus)

    def coupling(self, bodies: Bodies) -> float:
        """κ, tangential compliance of the bodies relative to the normal one."""
        return bodies.coupling


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


@dataclass(frozen=True)
class Cylinder(Indenter):
    """A cylinder along y, as the parabola x²/2R: a line contact in plane strain."""

    radius: Annotated[
        float,
        Quantity(
            "m",
            "$R$",
            "cylinder radius",
            "mm",
            like="6 mm",
            above=0.0,
            description="Radius R of the cylinder.",
        ),
    ]
    kind: Literal["cylinder"] = "cylinder"

    is_line: ClassVar[bool] = True
    even: ClassVar[Even] = (True, True)
    smooth: ClassVar[type[HertzContact | LineContact]] = LineContact
    partial_slip: ClassVar[type[CattaneoMindlin | LinePartialSlip]] = LinePartialSlip
    limiting: ClassVar[type[LimitingState | LineLimitingState]] = LineLimitingState

    def gap(self, x: Array, y: Array) -> Array:  # noqa: ARG002 - the same all along
        """x²/2R, m."""
        result: Array = x**2 / (2.0 * self.radius)
        return result

    @property
    def curvature_radius(self) -> float:
        """R, m."""
        return self.radius

    def coupling(self, bodies: Bodies) -> float:  # noqa: ARG002 - of any bodies
        """κ = 1: a half-plane is as compliant along the surface as across it."""
        return 1.0
