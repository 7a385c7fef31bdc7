"""Surfaces from files: measured roughness, and indenters given by height maps."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any, ClassVar, Literal

import numpy as np

from fretwear.mechanics.geometry import Array
from fretwear.mechanics.roughness import STEEPEST, TIPS, Roughness
from fretwear.mechanics.surfaces import UNKNOWN_RADIUS, FromFile, Indenter
from fretwear.parts import Choice, Patch, Quantity
from fretwear.topography import Source, SourceFile, Topography, read_topography
from fretwear.units import QuantityError

Rectangle = tuple[float, float, float, float]


class _Map(FromFile):
    """A part with a map of heights from a file."""

    patch: Rectangle | None

    # Points are as fine as a grid is to be, or half as fine.
    detail: ClassVar[str] = "distance of two points"
    cells: ClassVar[int] = 4

    @property
    def _levelled(self) -> bool:
        return False

    def read(self) -> Topography | None:
        """The topography; None for a case read from a dataset, without its file."""
        return read_topography(self.file, self._levelled, self.patch) if self.is_known else None

    @property
    def missing_points(
        self,
    ) -> Annotated[float, Quantity("1", "missing", "points without a height, filled")]:
        """Number of points that were not measured."""
        data = self.read()
        return math.nan if data is None else float(data.missing)

    @property
    def finest(self) -> tuple[float, float]:
        """Twice the distance of points along x and y, m."""
        data = self.read()
        return (math.inf, math.inf) if data is None else (2 * data.spacing[0], 2 * data.spacing[1])


@dataclass(frozen=True)
class MeasuredRoughness(_Map, Roughness):
    """A measured topography, its centre under the tip of the indenter.

    Heights are those of the file, upwards out of the body, minus their mean or the best-fitting
    plane; a bicubic spline interpolates between the points, and the border is continued outward. A
    map of the indenter is turned over about the y axis.
    """

    file: Annotated[
        Source,
        SourceFile("file", "measured surface", "surfaces/disc.x3p"),
        "File of a profilometer or a microscope, relative to the study file.",
    ]
    tilt: Annotated[
        str,
        Choice("tilt", "tilt of the surface", ("remove", "keep")),
        "Whether to level the surface.",
    ] = "remove"
    patch: Annotated[
        tuple[float, float, float, float] | None,
        Patch("patch", "patch of the surface"),
        "Part to use, [x, y, width, height] from the corner; none: all.",
    ] = None
    body: Annotated[
        str,
        Choice("body", "body of the surface", ("flat", "indenter")),
        "The body that has this surface.",
    ] = "flat"
    kind: Literal["measured"] = "measured"

    def height(self, x: Array, y: Array) -> Array:
        """Contribution to the gap, m: material that protrudes from either body reduces it."""
        across = x if self.body == "flat" else -np.asarray(x)
        return -_interpolated(self.file, self._levelled, self.patch, across, y)

    @property
    def _levelled(self) -> bool:
        return self.tilt == "remove"

    @property
    def rms_height(
        self,
    ) -> Annotated[float, Quantity("m", r"$h_\mathrm{rms}$", "rms height of the roughness", "um")]:
        """Root mean square of the heights."""
        data = self.read()
        return math.nan if data is None else float(data.heights.std())

    @property
    def rms_slope(
        self,
    ) -> Annotated[float, Quantity("1", r"$h^\prime_\mathrm{rms}$", "rms slope of the roughness")]:
        """Root mean square of the slope between neighbouring points."""
        data = self.read()
        if data is None:
            return math.nan
        squares = (
            np.square(np.diff(data.heights, axis=axis) / data.spacing[axis]).mean()
            for axis in (0, 1)
        )
        return math.sqrt(sum(squares))

    @property
    def sides(self) -> tuple[float, float]:
        """Lengths of the sides, m."""
        data = self.read()
        return (math.inf, math.inf) if data is None else data.sides

    @property
    def wavelengths(self) -> tuple[float, float]:
        """A quarter of the sides, m; the next tip is hardly farther away."""
        return self.sides[0] / 4.0, self.sides[1] / 4.0

    @property
    def highest(self) -> float:
        """Largest magnitude of a height, m."""
        data = self.read()
        return 0.0 if data is None else float(np.abs(data.heights).max())

    @property
    def tips(self) -> float:
        """Typical height of tips, m."""
        return min(TIPS * self.rms_height, self.highest)

    @property
    def steepest(self) -> float:
        """Three times the root mean square of the slope."""
        return STEEPEST * self.rms_slope


@dataclass(frozen=True)
class HeightMapIndenter(_Map, Indenter):
    """An indenter by a map of its heights.

    They point upwards out of the body, which is turned over about the y axis. The best-fitting
    paraboloid sets the scales of the contact, has its apex at the origin, and continues the shape
    beyond the map, with the difference at the border.
    """

    file: Annotated[
        Source,
        SourceFile("file", "file of the indenter", "tip.x3p"),
        "File of a profilometer or a microscope, relative to the study file.",
    ]
    patch: Annotated[
        Rectangle | None,
        Patch("patch", "patch of the height map"),
        "Part to use, [x, y, width, height] from the corner; none: all.",
    ] = None
    kind: Literal["height_map"] = "height_map"

    is_hertzian: ClassVar[bool] = False
    has_closed_form: ClassVar[bool] = False

    def gap(self, x: Array, y: Array) -> Array:
        """Apex less height, m."""
        fit = _paraboloid(self.file, self.patch)
        x, y = fit.apex[0] - np.asarray(x), fit.apex[1] + np.asarray(y)
        data = self.read()
        assert data is not None
        # Within the map the fit cancels; beyond, it continues the surface.
        inside = np.clip(x, data.x[0], data.x[-1]), np.clip(y, data.y[0], data.y[-1])
        heights = _interpolated(self.file, False, self.patch, *inside)
        result: Array = fit.height(*fit.apex) - heights + fit.height(*inside) - fit.height(x, y)
        return result

    @property
    def curvature_radius(self) -> float:
        """Radius, m, of a sphere of the mean curvature of the paraboloid."""
        return _paraboloid(self.file, self.patch).radius if self.is_known else UNKNOWN_RADIUS

    def read(self) -> Topography | None:
        """The topography, which has an apex."""
        if self.is_known:
            _paraboloid(self.file, self.patch)
        return super().read()


@dataclass(frozen=True)
class _Paraboloid:
    """c₀ + c₁x + c₂y + c₃x² + c₄xy + c₅y², m."""

    terms: tuple[float, ...]

    def height(self, x: Any, y: Any) -> Any:
        """Height, m."""
        flat, slope_x, slope_y, xx, xy, yy = self.terms
        return flat + x * (slope_x + xx * x + xy * y) + y * (slope_y + yy * y)

    @property
    def apex(self) -> tuple[float, float]:
        """Where it is highest, m."""
        _, slope_x, slope_y, xx, xy, yy = self.terms
        x, y = np.linalg.solve([[2.0 * xx, xy], [xy, 2.0 * yy]], [-slope_x, -slope_y])
        return float(x), float(y)

    @property
    def radius(self) -> float:
        """Inverse of the mean curvature, m; not positive or infinite where there is no apex."""
        *_, xx, xy, yy = self.terms
        mean, part = -(xx + yy), math.hypot(xx - yy, xy)
        return 1.0 / mean if mean > part else math.inf


@lru_cache(maxsize=8)
def _paraboloid(file: Source, patch: Rectangle | None) -> _Paraboloid:
    """The best-fitting paraboloid; `QuantityError` if its apex is not on the map."""
    data = read_topography(file, False, patch)
    x, y = data.x[:, None] / data.x[-1], data.y[None, :] / data.y[-1]
    powers = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
    columns = [np.broadcast_to(x**i * y**j, data.heights.shape).ravel() for i, j in powers]
    found, *_ = np.linalg.lstsq(np.stack(columns, axis=1), data.heights.ravel(), rcond=None)
    terms = [
        float(each / (data.x[-1] ** i * data.y[-1] ** j))
        for each, (i, j) in zip(found, powers, strict=True)
    ]
    fit = _Paraboloid(tuple(terms))
    if math.isinf(fit.radius):
        raise QuantityError(
            "is not convex as a whole: heights must fall off from a tip to all sides",
            "heights are upwards out of the indenter; take a patch around its tip",
        )
    if abs(fit.apex[0]) > data.x[-1] or abs(fit.apex[1]) > data.y[-1]:
        raise QuantityError(
            "has its tip beyond the map", "level it, or take a patch around its tip"
        )
    return fit


def _interpolated(
    file: Source, levelled: bool, patch: Rectangle | None, x: Array, y: Array
) -> Array:
    """Heights, m, interpolated between the points of a map, and those of its border outside."""
    data, spline = _spline(file, levelled, patch)
    x, y = np.clip(x, data.x[0], data.x[-1]), np.clip(y, data.y[0], data.y[-1])
    if x.shape[1:] != (1,) or y.size != y.shape[-1]:
        result: Array = spline.ev(*np.broadcast_arrays(x, y))
        return result
    # Evaluation on grid lines is faster, but requires increasing coordinates.
    rises = bool(x[-1, 0] >= x[0, 0])
    found: Array = spline(x[:, 0] if rises else x[::-1, 0], y.ravel())
    return found if rises else found[::-1]


@lru_cache(maxsize=4)
def _spline(file: Source, levelled: bool, patch: Rectangle | None) -> tuple[Topography, Any]:
    from scipy.interpolate import RectBivariateSpline

    data = read_topography(file, levelled, patch)
    return data, RectBivariateSpline(data.x, data.y, data.heights)
