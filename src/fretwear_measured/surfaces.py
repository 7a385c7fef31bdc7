"""Bodies with a surface from a file: measured roughness and profiles of indenters."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

import numpy as np
from pydantic.dataclasses import dataclass

from fretwear.arrays import Array
from fretwear.mechanics.surfaces.indenters import UNKNOWN_RADIUS, RoundIndenter
from fretwear.mechanics.surfaces.roughness import STEEPEST, TIPS, Roughness
from fretwear.quantity import Coordinates, Part, Plain, Quantity, Schema, each, is_list, means_none
from fretwear.theory import Reduced
from fretwear.units import LENGTH, QuantityError, format_quantity
from fretwear_measured.files import (
    FORMS,
    UNKNOWN,
    FileKey,
    FileParameter,
    Rectangle,
    Source,
    SourceFile,
    Topography,
    read_profile,
    read_topography,
)

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

_TABLE = 1000
_MOST_MISSING = 0.05  # of the points within the contact
_SIDE = Quantity("m", "", "", "mm", like="0.5 mm", ge=0.0)


class Patch(FileParameter):
    """A rectangle [x, y, width, height]; None for the whole map."""

    _sides: ClassVar[Schema] = {"type": "array", "items": {"type": ["string", "number"]}}
    schema: ClassVar[Schema] = {
        "anyOf": [{"const": "none"}, {**_sides, "minItems": 4, "maxItems": 4}]
    }

    def read(self, value: object, folder: Path | None = None) -> Rectangle | None:
        """Return the lengths, m."""
        if value is None or means_none(value):
            return None
        if not is_list(value) or len(value) != 4:
            raise QuantityError("must be [x, y, width, height]", self.like)
        x, y, width, height = each(value, lambda one: _SIDE.read(one, folder))
        if 0.0 in (width, height):
            raise QuantityError("must have a width and a height larger than 0")
        return x, y, width, height

    def canonical(self, value: Rectangle | None) -> object:
        """Return a list of lengths, m, or ``none``."""
        return "none" if value is None else [*value]

    def coordinates(self, name: str, value: Rectangle | None) -> Coordinates:
        """Yield the rectangle as one text, in m."""
        yield name, str(self.canonical(value))


class FromFile(Part):
    """A part whose shape is in a file."""

    file: Source

    @property
    def is_known(self) -> bool:
        """Whether the file is available."""
        return bool(self.file.path)

    def surface(self) -> object:
        """Read the file, if it is available; `QuantityError` says what is wrong with it."""
        raise NotImplementedError

    @property
    def mistake(self) -> tuple[str, str] | None:
        """What is wrong with the file."""
        try:
            self.surface()
        except QuantityError as error:
            return f"file {self.file.name}: {error.rule}", error.hint
        return None

    @property
    def slug(self) -> str:
        """The name of the file, from a letter or digit on, and the beginning of its checksum."""
        stem = re.sub(r"[^A-Za-z0-9._-]+", "-", self.file.name.partition(".")[0]).lstrip("._-")
        return f"{stem[:24] or 'file'}-{self.file.checksum[:6]}"


@dataclass(frozen=True)
class ProfileIndenter(FromFile, RoundIndenter):
    """A body of revolution with a profile from a file, interpolated by monotone cubics."""

    file: Annotated[
        Source,
        SourceFile("file", "file of the indenter", "tip.csv"),
        "Distance from the axis and height, with names and units in the first line.",
    ]
    kind: Literal["profile"] = "profile"

    def surface(self) -> tuple[Array, Array] | None:
        """Distances from the axis and heights, m."""
        return read_profile(self.file) if self.is_known else None

    @property
    def file_summary(self) -> str:
        """What the file holds."""
        distance, height = read_profile(self.file)
        width, rise = (format_quantity(column[-1], LENGTH, 4) for column in (distance, height))
        return f"{self.file.name}: {distance.size} points to r = {width}, where it is {rise} high"

    def gap(self, x: Array, y: Array) -> Array:
        """Height above the tip, m; beyond the last point it continues with the slope there."""
        curve, *_ = _curves(self.file)
        radius, end = np.hypot(x, y), self.reach
        outside = float(curve(end, 1)) * np.maximum(radius - end, 0.0)
        return np.asarray(curve(np.minimum(radius, end)) + outside)

    @property
    def curvature_radius(self) -> float:
        """Chosen so that a contact ends within nine tenths of the profile, m."""
        return 4.5 * self.reach if self.is_known else UNKNOWN_RADIUS

    @property
    def profile(self) -> Reduced:
        """Itself, reduced by quadrature."""
        return self

    @property
    def reach(self) -> float:
        """Coordinate to which it is known, m."""
        return float(read_profile(self.file)[0][-1])

    @property
    def flat_radius(self) -> float:
        """Zero, whatever its shape: its slope is smooth."""
        return 0.0

    def depth(self, radius: float) -> float:
        """g, m."""
        return float(_curves(self.file)[1](radius))

    def slope(self, radii: Array) -> Array:
        """g′."""
        return np.asarray(_curves(self.file)[1](radii, 1))

    def integral(self, radius: float) -> float:
        """∫₀^a g dt, m²."""
        return float(_curves(self.file)[2](radius))


@lru_cache(maxsize=8)
def _curves(source: Source) -> tuple[PPoly, PPoly, PPoly]:
    """The profile f(r), g(t) = t ∫ f′(t sin φ) dφ over a right angle, m, and its integral, m²."""
    from scipy.interpolate import CubicSpline, PchipInterpolator

    distance, height = read_profile(source)
    # A profile has no kink on its axis.
    curve = PchipInterpolator(np.r_[-distance[:0:-1], distance], np.r_[height[:0:-1], height])
    radii = np.linspace(0.0, 3.0 * distance[-1], _TABLE)
    sines = np.sin((np.arange(_TABLE) + 0.5) * 0.5 * math.pi / _TABLE)
    slopes = curve(np.minimum(np.outer(radii, sines), distance[-1]), 1)
    reduced = CubicSpline(radii, 0.5 * math.pi * radii * slopes.mean(axis=1))
    return curve, reduced, reduced.antiderivative()


@dataclass(frozen=True)
class MeasuredRoughness(FromFile, Roughness):
    """A measured topography, its centre under the tip of the indenter.

    Heights are taken from the file, upwards out of the body, minus their mean or the best-fitting
    plane; a bicubic spline interpolates between the points, and the border is continued outward. A
    map of the indenter is turned over about the y axis.
    """

    file: Annotated[
        Source,
        SourceFile("file", "measured surface", "surfaces/disc.x3p"),
        "File of a profilometer or a microscope, relative to the study file.",
    ]
    tilt: Annotated[
        Literal["remove", "keep"],
        Plain("tilt", "tilt of the surface", like="remove"),
        "Whether to level the surface.",
    ] = "remove"
    patch: Annotated[
        Rectangle | None,
        Patch("patch", "patch of the surface", "[0 mm, 0 mm, 0.5 mm, 0.5 mm]"),
        "Part to use, [x, y, width, height] from the corner; none: all.",
    ] = None
    body: Annotated[
        Literal["flat", "indenter"],
        Plain("body", "body of the surface", like="flat"),
        "Body with this surface.",
    ] = "flat"
    form: Annotated[
        str,
        FileKey("form", "form removed from the surface", "sphere", FORMS),
        "Best-fitting shape to subtract.",
    ] = ""
    outliers: Annotated[
        str,
        FileKey("outliers", "spikes", "fill", ("keep", "fill"), "keep"),
        "Whether points more than 10 rms from their neighbours are filled.",
    ] = "keep"
    unit: Annotated[
        str, FileKey("unit", "unit of lengths", "um"), "Unit of lengths, if the file has none."
    ] = ""
    size: Annotated[
        str,
        FileKey("size", "sides of the map", "[900 um, 900 um]"),
        "Lengths of its sides, if the file has none.",
    ] = ""
    format: Annotated[
        str, FileKey("format", "format", "xyz"), "Format of SurfaceTopography, if not detected."
    ] = ""
    channel: Annotated[
        str, FileKey("channel", "channel", "0"), "Number or name of the channel to read."
    ] = ""
    kind: Literal["measured"] = "measured"
    synonyms: ClassVar[tuple[str, ...]] = ("map", "file")

    # By default two cells, at least one, to the distance of two points: `finest` is twice that.
    detail: ClassVar[str] = "distance of two points"
    cells: ClassVar[int] = 4

    def surface(self) -> Topography:
        """The topography."""
        if not self.is_known:
            return UNKNOWN
        return read_topography(
            self.file,
            self.form or ("plane" if self.tilt == "remove" else "none"),
            self.patch,
            outliers=self.outliers,
            unit=self.unit or None,
            size=self.size,
            file_format=self.format,
            channel=self.channel,
        )

    @property
    def file_summary(self) -> str:
        """What the file holds."""
        return f"{self.file.name}: {self.surface().summary}"

    @property
    def checksum(self) -> str:
        """The checksum of the heights as the library reads them."""
        return self.surface().checksum

    @property
    def missing_points(
        self,
    ) -> Annotated[float, Quantity("1", "missing", "points without a height, filled")]:
        """Number of points that were not measured."""
        return self.surface().missing

    @property
    def finest(self) -> tuple[float, float]:
        """Twice the distance of points along x and y, m."""
        x, y = self.surface().spacing
        return 2.0 * x, 2.0 * y

    def height(self, x: Array, y: Array) -> Array:
        """Contribution to the gap, m: material that protrudes from either body reduces it."""
        data, x = self.surface(), x if self.body == "flat" else -np.asarray(x)
        x, y = np.clip(x, data.x[0], data.x[-1]), np.clip(y, data.y[0], data.y[-1])
        if x.shape[1:] != (1,) or y.size != y.shape[-1]:
            return -np.asarray(data.spline.ev(*np.broadcast_arrays(x, y)))
        # Evaluation on grid lines is faster, but requires increasing coordinates.
        way = 1 if x[-1, 0] >= x[0, 0] else -1
        return -np.asarray(data.spline(x[::way, 0], y.ravel()))[::way]

    @property
    def rms_height(
        self,
    ) -> Annotated[float, Quantity("m", r"$h_\mathrm{rms}$", "rms height of the roughness", "um")]:
        """Root mean square of the heights."""
        return float(self.surface().heights.std())

    @property
    def rms_slope(
        self,
    ) -> Annotated[float, Quantity("1", r"$h^\prime_\mathrm{rms}$", "rms slope of the roughness")]:
        """Root mean square of the slope between neighbouring points."""
        data = self.surface()
        slopes = (np.diff(data.heights, axis=n) / step for n, step in enumerate(data.spacing))
        return math.sqrt(sum(np.square(slope).mean() for slope in slopes))

    def warnings(self, radius: float, curvature: float) -> Iterator[tuple[str, str]]:
        """Missing points within the contact, a curvature that counts twice, and spikes."""
        if not self.is_known:
            return
        data = self.surface()
        share, size = data.missing_within(radius), data.heights.size
        same = self.body == "indenter" and abs(data.curvature - curvature) < 0.2 * curvature
        if share > _MOST_MISSING:
            yield (
                "lies on a surface with missing points, which were filled in",
                f"{100.0 * share:.0f} % of the points within the contact radius and "
                f"{data.missing:.0f} of {size} in the map were not measured",
            )
        if data.positions:
            what = "lies on a surface interpolated between uneven positions"
            yield what, f"{data.positions} positions, {size} points"
        if same and self.form in ("", "none", "plane"):
            what = "has the curvature of its indenter twice, because the map has it too"
            yield what, f"the map has a radius of {1e3 / data.curvature:.3g} mm"
        if data.spikes:
            what = "lies on a surface with spikes, which may carry the load"
            yield what, f"{data.spikes} points differ from their neighbours by more than 10 rms"

    @property
    def sides(self) -> tuple[float, float]:
        """Lengths of the sides, m."""
        return self.surface().sides

    @property
    def wavelengths(self) -> tuple[float, float]:
        """A quarter of the sides, m; the next tip is hardly farther away."""
        return self.sides[0] / 4.0, self.sides[1] / 4.0

    @property
    def highest(self) -> float:
        """Largest magnitude of a height, m; 0 where it is not known."""
        return self.surface().highest

    @property
    def tips(self) -> float:
        """Typical height of tips, m."""
        return min(TIPS * self.rms_height, self.highest)

    @property
    def steepest(self) -> float:
        """Three times the root mean square of the slope."""
        return STEEPEST * self.rms_slope
