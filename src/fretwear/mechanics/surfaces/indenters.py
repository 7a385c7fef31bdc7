"""The smooth shape of the bodies before any load: an indenter on a flat."""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic.dataclasses import dataclass

from fretwear.arrays import Array, Even
from fretwear.mechanics.surfaces.materials import Bodies
from fretwear.mechanics.surfaces.pressing import Normal
from fretwear.quantity import MATERIALS, Part, Quantity, pair
from fretwear.theory import (
    EllipticContact,
    FlatPunchContact,
    HertzContact,
    LimitingState,
    LineContact,
    LineLimitingState,
    LinePartialSlip,
    PartialSlip,
    Reduced,
    RoundContact,
    RoundedPunch,
)
from fretwear.units import LINE_CONTACT, POINT_CONTACT, ContactFrame

LEAST_AXIS_RATIO = 0.05
"""Least ratio of the half-axes of an ellipse that still counts as a point contact."""

SIDE_SLOPE = 1e3
"""Slope of the sides of a punch that ends: a scar is wider than the punch by its depth over it."""

UNKNOWN_RADIUS = 1.0
"""Radius, m, that stands in for a shape whose file is missing."""


class Indenter(Part):
    """The smooth shape of the bodies."""

    #: Whether the gap depends only on the distance from the axis.
    is_axisymmetric: ClassVar[bool] = False
    detail: ClassVar[str] = "detail"  #: word for the feature whose length is `finest`
    cells: ClassVar[int] = 16  #: cells that resolve it; half as many just suffice
    is_hertzian: ClassVar[bool] = True  #: whether its smooth contact is Hertzian
    #: Whether its smooth contact is known before a run; otherwise only its scales are.
    has_closed_form: ClassVar[bool] = True
    frame: ClassVar[ContactFrame] = POINT_CONTACT  #: or a line contact, in plane strain
    #: The closed forms of the contact that sets the scales.
    smooth: ClassVar[type[HertzContact]] = HertzContact
    partial_slip: ClassVar[type[PartialSlip]] = PartialSlip
    limiting: ClassVar[type[LimitingState]] = LimitingState

    @property
    def even(self) -> Even:
        """Whether the gap is exactly even along x and along y, so that one side suffices."""
        return self.is_axisymmetric, self.is_axisymmetric

    def gap(self, x: Array, y: Array) -> Array:
        """Gap at zero load and zero approach, m, at coordinates in m that broadcast."""
        raise NotImplementedError

    radius: float  #: m, of a sphere or a cylinder

    @property
    def curvature_radius(self) -> float:
        """Radius, m, of the sphere whose Hertzian contact sets the scales of this indenter."""
        return self.radius

    @property
    def finest(self) -> tuple[float, float]:
        """Length along x and along y, m, that a grid must resolve; inf if there is none."""
        return math.inf, math.inf

    @property
    def is_known(self) -> bool:
        """Whether the shape is available; it is not if its file is missing."""
        return True

    def hertz(self, normal: Normal, modulus: float) -> HertzContact:
        """The smooth contact that sets the scales, of bodies with a composite modulus, Pa."""
        return normal.hertz(self._unit(modulus))

    def _unit(self, modulus: float) -> HertzContact:
        """The smooth contact under a unit load."""
        return self.smooth(self.curvature_radius, 1.0, modulus)

    def half_widths(self, contact: HertzContact) -> tuple[float, float]:
        """Half-widths along x and y, m, of the smooth contact."""
        return contact.contact_radius, contact.contact_radius

    @property
    def end(self) -> float:
        """Distance from centre or axis, m, at which the body ends; inf if it does not."""
        return math.inf

    def edge(self, contact: HertzContact) -> float:
        """Width, m, of the zone of peak pressure at the edge of the smooth contact; inf if none."""
        return math.inf

    def coupling(self, bodies: Bodies) -> float:
        """κ, tangential compliance of the bodies relative to the normal one."""
        return bodies.coupling

    def couplings(self, bodies: Bodies) -> tuple[float, ...]:
        """Other values of κ in an elongated contact: from its curvatures along x and y."""
        return ()


@dataclass(frozen=True)
class Sphere(Indenter):
    """A sphere, as the paraboloid (x² + y²)/2R of Hertz's theory."""

    radius: Annotated[
        float,
        Quantity("m", "$R$", "sphere radius", "mm", like="10 mm", gt=0.0),
        "Radius of the sphere.",
    ]
    kind: Literal["sphere"] = "sphere"
    synonyms: ClassVar[tuple[str, ...]] = ("ball", "paraboloid")

    is_axisymmetric: ClassVar[bool] = True

    def gap(self, x: Array, y: Array) -> Array:
        """(x² + y²)/2R, m."""
        result: Array = (x**2 + y**2) / (2.0 * self.radius)
        return result

    slug = ""  # the usual indenter is left out of the id


class _Straight(Indenter):
    """A body with the same profile all along y: a line contact in plane strain."""

    frame: ClassVar[ContactFrame] = LINE_CONTACT
    even: ClassVar[Even] = (True, True)
    smooth: ClassVar[type[HertzContact]] = LineContact
    partial_slip: ClassVar[type[PartialSlip]] = LinePartialSlip
    limiting: ClassVar[type[LimitingState]] = LineLimitingState

    def coupling(self, bodies: Bodies) -> float:
        """κ = 1: a half-plane is as compliant along the surface as across it."""
        return 1.0


@dataclass(frozen=True)
class Cylinder(_Straight):
    """A cylinder along y, as the parabola x²/2R: a line contact in plane strain."""

    radius: Annotated[
        float,
        Quantity("m", "$R$", "cylinder radius", "mm", like="6 mm", gt=0.0),
        "Radius R of the cylinder.",
    ]
    kind: Literal["cylinder"] = "cylinder"
    synonyms: ClassVar[tuple[str, ...]] = ("roller", "line")

    def gap(self, x: Array, y: Array) -> Array:
        """x²/2R, m."""
        result: Array = x**2 / (2.0 * self.radius)
        return result


_EdgeRadius = Annotated[
    float, Quantity("m", r"$R_\mathrm{e}$", "radius of the edge", "mm", like="10 mm", gt=0.0)
]
_HalfWidth = Annotated[
    float,
    Quantity(
        "m",
        r"$b_\mathrm{end}$",
        "half-width of the punch",
        "mm",
        like="2.4 mm",
        gt=0.0,
        infinite="no end",
        omitted_value=math.inf,
    ),
    "Half-width of the punch; none: without end.",
]


class _Punch(Indenter):
    """A flat with a rounded edge: gap (r − b)²/2R_e at the distance r > b from centre or axis."""

    edge_radius: float
    half_width: float
    is_hertzian: ClassVar[bool] = False

    @property
    def flat(self) -> float:
        """b, m."""
        raise NotImplementedError

    def gap(self, x: Array, y: Array) -> Array:
        """(r − b)²/2R_e outside the flat, m; the sides outside the end of the punch."""
        distance = np.hypot(x, y if "y" in self.frame.axes else 0.0)
        excess = np.maximum(distance - self.flat, 0.0)
        result: Array = excess**2 / (2.0 * self.edge_radius)
        if math.isfinite(self.half_width):
            result += SIDE_SLOPE * np.maximum(distance - self.half_width, 0.0)
        return result

    @property
    def end(self) -> float:
        """b_end, m."""
        return self.half_width

    @property
    def mistake(self) -> tuple[str, str] | None:
        """The flat must not be wider than the punch."""
        if self.half_width >= self.flat:
            return None
        text = self.parameters()["half_width"].text
        return (
            f"ends at {text(self.half_width)}, on its flat to {text(self.flat)}",
            f"write half_width: {text(self.flat + self.edge_radius)}, where a round edge ends",
        )

    @property
    def curvature_radius(self) -> float:
        """R_e + 5b, m: at 5b the slope of the edge is one fifth."""
        return self.edge_radius + 5.0 * self.flat

    def edge(self, contact: HertzContact) -> float:
        """Width a − b of the part of the rounded edge that touches, m."""
        return contact.contact_radius - self.flat


@dataclass(frozen=True)
class FlatPunch(_Punch, _Straight):
    """A flat punch along y with rounded edges: gap (|x| − b)²/2R_e beyond the flat to ±b."""

    flat_half_width: Annotated[
        float, Quantity("m", "$b$", "half-width of the flat", "um", like="100 um", gt=0.0)
    ]
    edge_radius: _EdgeRadius
    half_width: _HalfWidth = math.inf
    kind: Literal["flat_punch"] = "flat_punch"

    @property
    def flat(self) -> float:
        """b, m."""
        return self.flat_half_width

    def _unit(self, modulus: float) -> HertzContact:
        return FlatPunchContact(self.edge_radius, 1.0, modulus, flat_half_width=self.flat)


class _Elliptic(Indenter):
    """An indenter with the gap x²/2R_x + y²/2R_y along its own axes: an elliptical contact."""

    @property
    def radii_of_gap(self) -> tuple[float, float]:
        """R_x and R_y along the axes of the ellipse, m."""
        raise NotImplementedError

    @property
    def rotation(self) -> float:
        """Angle from the x axis to the first axis of the ellipse, rad."""
        return 0.0

    @property
    def even(self) -> Even:
        """Both, if the ellipse has its axes along x and y."""
        return self.rotation == 0.0, self.rotation == 0.0

    @property
    def curvature_radius(self) -> float:
        """Radius, m, of the sphere with a contact of the same area."""
        return self._unit(1.0).radius

    def _unit(self, modulus: float) -> EllipticContact:
        return EllipticContact.of(*self.radii_of_gap, 1.0, modulus)

    def half_widths(self, contact: HertzContact) -> tuple[float, float]:
        """Half-widths along x and y, m, of the rectangle around the ellipse."""
        assert isinstance(contact, EllipticContact)
        first, second = contact.half_widths
        cos, sin = math.cos(self.rotation), math.sin(self.rotation)
        return math.hypot(first * cos, second * sin), math.hypot(first * sin, second * cos)

    def coupling(self, bodies: Bodies) -> float:
        """κ in the centre of the ellipse."""
        return bodies.coupling_weighing(self._unit(1.0).shear_weights(-self.rotation)[0])

    @property
    def mistake(self) -> tuple[str, str] | None:
        """The contact must not be too elongated, as with unlike radii or nearly parallel axes."""
        ratio = self._unit(1.0).axis_ratio
        slender = min(ratio, 1.0 / ratio)
        if slender >= LEAST_AXIS_RATIO:
            return None
        return (
            f"has a contact {1.0 / slender:.3g} times as long as it is wide, and one of more than "
            f"{1.0 / LEAST_AXIS_RATIO:g} is no point contact",
            "take a cylinder, whose contact is a line",
        )

    def couplings(self, bodies: Bodies) -> tuple[float, ...]:
        """κ of the curvatures along both axes of the ellipse."""
        _, *weights = self._unit(1.0).shear_weights(-self.rotation)
        return tuple(bodies.coupling_weighing(weight) for weight in weights)


@dataclass(frozen=True)
class Ellipsoid(_Elliptic):
    """A body with two radii: gap x²/2R_x + y²/2R_y."""

    radius_x: Annotated[float, Quantity("m", "$R_x$", "radius along x", "mm", like="10 mm", gt=0.0)]
    radius_y: Annotated[float, Quantity("m", "$R_y$", "radius along y", "mm", like="40 mm", gt=0.0)]
    kind: Literal["ellipsoid"] = "ellipsoid"

    def gap(self, x: Array, y: Array) -> Array:
        """x²/2R_x + y²/2R_y, m."""
        result: Array = x**2 / (2.0 * self.radius_x) + y**2 / (2.0 * self.radius_y)
        return result

    @property
    def radii_of_gap(self) -> tuple[float, float]:
        """R_x and R_y, m."""
        return self.radius_x, self.radius_y


@dataclass(frozen=True)
class CrossedCylinders(_Elliptic):
    """Two cylinders: the flat body is one along x, and the other lies at an angle to it."""

    radii: Annotated[
        float | tuple[float, float],
        Quantity("m", "$R$", "cylinder radius", "mm", like="5 mm", gt=0.0, places=MATERIALS),
        "Radius of both cylinders, or a pair [at the angle, along x].",
    ]
    angle: Annotated[
        float,
        Quantity("rad", "$ϑ$", "angle of the axes", "deg", like="90 deg", gt=0.0, le=0.5 * math.pi),
        "Angle between the axes; slip is along the axis of the second cylinder.",
    ] = 0.5 * math.pi
    kind: Literal["crossed_cylinders"] = "crossed_cylinders"

    @property
    def _terms(self) -> tuple[float, float, float]:
        """Coefficients of x², xy and y² of the gap, 1/m."""
        first, second = pair(self.radii)
        if self.angle == 0.5 * math.pi:
            return 0.5 / first, 0.0, 0.5 / second
        sin, cos = math.sin(self.angle), math.cos(self.angle)
        return 0.5 * sin**2 / first, -sin * cos / first, 0.5 * (cos**2 / first + 1.0 / second)

    def gap(self, x: Array, y: Array) -> Array:
        """(x sinϑ − y cosϑ)²/2R₁ + y²/2R₂, m."""
        square_x, product, square_y = self._terms
        result: Array = square_x * x**2 + square_y * y**2
        return result + product * x * y if product else result

    @property
    def rotation(self) -> float:
        """Angle from the x axis to the flatter principal axis of the gap, rad."""
        square_x, product, square_y = self._terms
        return 0.5 * math.atan2(-product, square_y - square_x) if product else 0.0

    @property
    def radii_of_gap(self) -> tuple[float, float]:
        """Principal radii of the gap, m."""
        square_x, product, square_y = self._terms
        if not product:
            return 0.5 / square_x, 0.5 / square_y
        mean, part = 0.5 * (square_x + square_y), 0.5 * math.hypot(square_x - square_y, product)
        return 0.5 / (mean - part), 0.5 / (mean + part)


class RoundIndenter(Indenter):
    """A body of revolution with any convex profile."""

    is_axisymmetric: ClassVar[bool] = True
    is_hertzian: ClassVar[bool] = False

    @property
    def profile(self) -> Reduced:
        """The profile in the method of dimensionality reduction."""
        raise NotImplementedError

    def _unit(self, modulus: float) -> HertzContact:
        if not self.is_known:
            return super()._unit(modulus)
        return RoundContact.under(self.profile, 1.0, modulus)


@dataclass(frozen=True)
class RoundPunch(_Punch, RoundIndenter):
    """A round flat punch with a rounded edge: gap (r − b)²/2R_e beyond the flat of radius b."""

    flat_radius: Annotated[
        float, Quantity("m", "$b$", "radius of the flat", "um", like="100 um", gt=0.0)
    ]
    edge_radius: _EdgeRadius
    half_width: _HalfWidth = math.inf
    kind: Literal["round_punch"] = "round_punch"

    @property
    def flat(self) -> float:
        """b, m."""
        return self.flat_radius

    @property
    def profile(self) -> Reduced:
        """Its closed form."""
        return RoundedPunch(self.flat_radius, self.edge_radius)
