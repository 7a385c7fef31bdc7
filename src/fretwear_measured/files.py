"""Files of surfaces: maps of heights and profiles.

A case keeps the name and the checksum of a file (`Source`): the same file is the same surface
wherever it lies. Formats of profilometers and microscopes are read by SurfaceTopography,
which is optional and imported when a topography is read; tables of numbers by
`fretwear_measured.tables`.
"""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import GetJsonSchemaHandler
from pydantic_core import core_schema

from fretwear.arrays import Array, Mask
from fretwear.quantity import Plain, Readable, Schema, is_list
from fretwear.units import LENGTH, QuantityError, format_quantity, listed
from fretwear_measured.maps import LEAST_POINTS, open_surface, read_map, without_marks
from fretwear_measured.tables import Sought, ensure, open_table

if TYPE_CHECKING:
    from scipy.interpolate import RectBivariateSpline

Rectangle = tuple[float, float, float, float]

_RELAXATIONS = 200
_SPIKE = 10.0
_CROSS = 0.25 * np.array([[0, 1, 0], [1, 0, 1], [0, 1, 0]])
_STORED = re.compile(r"(?P<name>[^/]+) sha256:(?P<checksum>[0-9a-f]{64})")


@dataclass(frozen=True)
class Source:
    """A file identified by name and checksum; its folder does not count and may be empty."""

    name: str
    checksum: str
    path: str = field(default="", compare=False)

    def __str__(self) -> str:
        return f"{self.name} sha256:{self.checksum}"


class FileParameter(Plain, Readable):
    """A parameter of a file."""

    schema: ClassVar[Schema]

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> Schema:
        del schema, handler
        return {**self.schema, **self.described}


@dataclass(frozen=True)
class SourceFile(FileParameter):
    """The name of a file, relative to the study file; its checksum is the value."""

    @property
    def schema(self) -> Schema:  # type: ignore[override]
        """A name."""
        return {"type": "string", "minLength": 1, "examples": [self.example]}

    def read(self, value: object, folder: Path | None = None) -> Source | None:
        """Return the file's name and checksum; names are relative to a folder."""
        if value is None or isinstance(value, Source):
            return value
        if not isinstance(value, str) or not value.strip():
            raise QuantityError("must be the name of a file", f"such as {self.example}")
        # As stored in a dataset; a study needs the file itself.
        if folder is None and (stored := _STORED.fullmatch(value)):
            return Source(stored["name"], stored["checksum"])
        path = (folder or Path()) / value
        try:
            checksum = _checksum(path, path.stat().st_mtime_ns)
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            rule = f"is no file that can be read: {path}: {reason}"
            raise QuantityError(rule, "names are relative to the study file") from error
        return Source(path.name, checksum, str(path))

    def canonical(self, value: object) -> str:
        """Return name and checksum in a line, which `read` takes back."""
        return str(value)

    def text(self, value: object) -> str:
        """Return the name."""
        return str(value).partition(" sha256:")[0]


@lru_cache(maxsize=256)
def _checksum(path: Path, modified: int) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


@dataclass(frozen=True)
class FileKey(FileParameter):
    """A key beside the name of a file, as text; empty: as the file says it."""

    options: tuple[str, ...] = ()  # all that it may be
    omitted_value: Any = ""

    @property
    def schema(self) -> Schema:  # type: ignore[override]
        """One of the options, or any text, number or list."""
        if self.options:
            return {"enum": [*self.options]}
        return {"type": ["string", "integer", "array"], "examples": [self.example]}

    def read(self, value: object, folder: Path | None = None) -> str:
        """Return the text; a list becomes a text with commas."""
        if value is None or value == "":
            return ""
        values = value if is_list(value) else [value]
        if not all(isinstance(one, str | int) for one in values):
            raise QuantityError("must be text", f"such as {self.example}")
        if self.options and value not in self.options:
            raise QuantityError(f"must be {listed(self.options, 'or')}")
        return ", ".join(str(one) for one in values)


@dataclass(frozen=True, eq=False)
class Topography:
    """Heights on a grid of points around the origin, in m."""

    x: Array  #: coordinates of the points, shape (nx,), increasing
    y: Array  #: shape (ny,)
    heights: Array  #: upwards out of the body, shape (nx, ny); their mean is 0
    measured: Mask  #: whether each point was measured; the others have been filled in
    spikes: int = 0  #: points that differed from their neighbours by more than 10 rms heights
    checksum: str = ""  #: of the heights and sides as read from the file
    summary: str = ""  #: what was read and how, for people
    positions: int = 0  #: uneven positions between which heights were interpolated; 0 on a grid

    @property
    def spacing(self) -> tuple[float, float]:
        """Distance of the points along x and along y, m."""
        return float(self.x[1] - self.x[0]), float(self.y[1] - self.y[0])

    @property
    def sides(self) -> tuple[float, float]:
        """Lengths of the sides, a point's share at the border included, m."""
        return len(self.x) * self.spacing[0], len(self.y) * self.spacing[1]

    @property
    def missing(self) -> float:
        """Number of points that were not measured; NaN where it is not known."""
        return float((~self.measured).sum()) if np.isfinite(self.x).all() else math.nan

    def missing_within(self, radius: float) -> float:
        """Share of the points within a radius, m, of the centre that were not measured."""
        inside = np.hypot(self.x[:, None], self.y) <= radius
        return float(np.mean(~self.measured[inside])) if inside.any() else 0.0

    @cached_property
    def curvature(self) -> float:
        """Mean curvature of the best-fitting paraboloid, 1/m, positive where it is convex."""
        x, y = self.x[:, None], self.y
        terms = [np.ones(()), x, y, x * x, y * y]
        return -float(fitted(terms, self.heights, self.measured)[3:].sum())

    @cached_property
    def highest(self) -> float:
        """Largest magnitude of a height, m; 0 where it is not known."""
        return float(np.nan_to_num(np.abs(self.heights).max()))

    @cached_property
    def spline(self) -> RectBivariateSpline:
        """Heights between the points."""
        from scipy.interpolate import RectBivariateSpline

        return RectBivariateSpline(self.x, self.y, self.heights)


# Stands for the topography of a case that is read from a dataset, without its file.
_FAR = np.array([0.0, math.inf])
UNKNOWN = Topography(_FAR, _FAR, np.full((2, 2), math.nan), np.ones((2, 2), bool))

FORMS = ("none", "plane", "sphere", "cylinder", "paraboloid")
"""Shapes that may be removed from a map: the best-fitting one of each kind; none: the mean."""


@lru_cache(4)
def read_topography(
    source: Source,
    form: str = "plane",
    patch: tuple[float, ...] | None = None,
    *,
    outliers: str = "keep",
    unit: str | None = None,
    size: str = "",
    file_format: str = "",
    channel: str = "",
) -> Topography:
    """Read a measured surface.

    Parameters
    ----------
    source
        The file.
    form
        The best-fitting one of `FORMS` to subtract; none: just the mean.
    patch
        Corner x, y, width and height, m, of the part to read, from the file's corner; None: all.
    outliers
        ``fill`` replaces points that differ from their neighbours by more than 10 rms heights.
    unit, size, file_format, channel
        What the file does not say: its unit of length, or units of x, y and z, "mm, mm, um"; its
        sides, "900 um, 900 um"; a format and the number or name of a channel of SurfaceTopography.

    Raises
    ------
    QuantityError
        If the file cannot be used; the message says why.
    """
    found = read_map(Path(source.path), unit or "", size, file_format, channel)
    values, sides = found.heights, found.sides
    checksum = hashlib.sha256(np.append(values, sides).tobytes()).hexdigest()[:8]
    points = [
        (np.arange(n) + 0.5) * (side / n) for n, side in zip(values.shape, sides, strict=True)
    ]
    if patch is not None:
        corners = zip(points, patch[:2], patch[2:], strict=True)
        inside = [(axis >= corner) & (axis <= corner + side) for axis, corner, side in corners]
        values = values[np.ix_(*inside)]
        points = [axis[within] for axis, within in zip(points, inside, strict=True)]
    rule = "has {} x {} points in the part to be read, too few for a surface".format(*values.shape)
    is_wide = min(values.shape) >= LEAST_POINTS
    ensure(is_wide, rule, "give a map, and a patch that lies in it")
    measured = np.isfinite(values)
    ensure(measured.sum() >= LEAST_POINTS, "has no heights: every point is missing")
    summary = _summary_of(points, values)
    x, y = ((np.arange(len(axis)) - 0.5 * (len(axis) - 1)) * (axis[1] - axis[0]) for axis in points)
    values = _without(form, x, y, values, measured)
    spikes = find_spikes(values, measured)
    if outliers == "fill" and spikes.any():
        measured = measured & ~spikes
        values, spikes = _without(form, x, y, values, measured), spikes & False
    filled = _filled(values, measured)
    summary = f"{summary}, rms {format_quantity(filled.std(), LENGTH, 3)} less form; {found.reader}"
    count = int(spikes.sum())
    return Topography(x, y, filled, measured, count, checksum, summary, found.positions)


def _summary_of(points: Sequence[Array], values: Array) -> str:
    """Points, sides, missing points and heights of a map, and where it is highest, as text."""

    def length(value: float) -> str:
        return format_quantity(value, LENGTH, 4)

    sides = " x ".join(length(axis.size * (axis[1] - axis[0])) for axis in points)
    top = np.unravel_index(np.nanargmax(values), values.shape)
    at_x, at_y = (length(axis[n]) for axis, n in zip(points, top, strict=True))
    return (
        f"{values.shape[0]} x {values.shape[1]} points over {sides}, "
        f"{np.count_nonzero(np.isnan(values))} missing; heights {length(np.nanmin(values))} to "
        f"{length(np.nanmax(values))}, highest at x = {at_x}, y = {at_y} from the corner"
    )


def _without(form: str, x: Array, y: Array, values: Array, measured: Mask) -> Array:
    """Heights less the best-fitting form of a kind."""
    x, z = x[:, None], values - values[measured].mean()
    plane = [np.ones(()), x, y]
    kinds = {
        "none": [plane[:1]],
        "plane": [plane],
        "paraboloid": [[*plane, x * x, x * y, y * y]],
        "cylinder": [[*plane, x * x], [*plane, y * y]],  # along y or along x
        "sphere": [[*plane, x * x + y * y + z * z]],
    }
    fits = [(terms, fitted(terms, z, measured)) for terms in kinds[form]]
    if form == "sphere":  # z = q + s z² on a sphere with the centre at z = 1/2s
        factors = fits[0][1]
        q = sum(map(np.multiply, factors, (*plane, x * x + y * y)))
        root = 1.0 - 4.0 * factors[-1] * q
        remedy = "choose form: paraboloid or plane"
        ensure((root > 0.0).all(), "is not a part of a sphere", remedy)
        return np.asarray(z - 2.0 * q / (1.0 + np.sqrt(root)))
    lefts = [z - sum(map(np.multiply, factors, terms)) for terms, factors in fits]
    return min(lefts, key=np.nanvar)


def fitted(terms: Sequence[Array], heights: Array, measured: Mask) -> Array:
    """Factors of terms, functions of x and y, whose sum fits the measured heights best."""
    rows = np.stack([np.broadcast_to(term, heights.shape)[measured] for term in terms])
    sizes = np.linalg.norm(rows, axis=1)
    rows /= sizes[:, None]
    solution, *_ = np.linalg.lstsq(rows @ rows.T, rows @ heights[measured], rcond=None)
    return np.asarray(solution / sizes)


def find_spikes(values: Array, measured: Mask) -> Mask:
    """Points that differ from the median of their neighbours by more than 10 rms heights."""
    from scipy.ndimage import median_filter

    heights = np.where(measured, values, 0.0)
    # Of a normal distribution, so that spikes do not count.
    rms = 1.4826 * float(np.median(np.abs(heights[measured])))
    away = np.abs(heights - median_filter(heights, 3, mode="nearest"))
    return np.asarray(measured & (away > _SPIKE * rms) & (rms > 0.0))


@lru_cache(8)
def read_line(source: Source, unit: str | None = None) -> tuple[Array, Array] | None:
    """Positions and heights along a line scan, m; None if the file holds a map."""
    path = Path(source.path)
    if path.suffix.lower() == ".xyz":  # SurfaceTopography takes no map with points left out
        with suppress(QuantityError):
            read_map(path, unit or "", "", "", "")
            return None
    found = open_surface(path, unit or "", "", "", "")
    if found.x is None:
        return None
    return found.x, without_marks(found.heights[:, 0], float(np.ptp(found.x)))


def _filled(values: Array, measured: Mask) -> Array:
    """Fill missing points with the height of the nearest measured one, then smooth these."""
    if measured.all():
        return values
    from scipy.ndimage import convolve, distance_transform_edt

    nearest = distance_transform_edt(~measured, return_distances=False, return_indices=True)
    result: Array = values[tuple(nearest)]
    for _ in range(_RELAXATIONS):
        result = np.where(measured, result, convolve(result, _CROSS, mode="nearest"))
    return result


@lru_cache(16)
def read_profile(source: Source) -> tuple[Array, Array]:
    """Read the profile of a body of revolution: distances from its axis and heights, m.

    A text whose columns are named with their units, such as ``r (mm), z (um)``; each line has a
    distance from the axis and the height of the body's surface above its tip.

    Raises
    ------
    QuantityError
        If the file cannot be used; the message says why.
    """
    sought = Sought(LENGTH, ("r", "x", "radius distance")), Sought(LENGTH, ("z", "height profile"))
    table = open_table(Path(source.path))
    _, (distance, height) = table.read(sought, "such as: r (mm), z (um)")
    is_whole = len(distance) >= LEAST_POINTS and np.isfinite([distance, height]).all()
    ensure(is_whole, f"must have at least {LEAST_POINTS} points, all of them numbers")
    goes_out = distance[0] == 0.0 and (np.diff(distance) > 0.0).all()
    ensure(goes_out, "must begin at the axis, r = 0, and go outwards from line to line")
    is_tip = height[0] == height.min() and height[-1] == height.max()
    ensure(is_tip, "must be lowest on the axis and highest at its end: a convex tip")
    return distance, height - height[0]
