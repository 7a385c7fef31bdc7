"""Files of surfaces: maps of heights and profiles.

A case keeps the name and the checksum of a file (`Source`): the same file is the same surface
wherever it lies. Formats of profilometers and microscopes are read by SurfaceTopography,
which is optional and imported when a topography is read; profiles are plain text. A file may come
from anybody: it is read by a child process with limits of memory and time.
"""

from __future__ import annotations

import faulthandler
import hashlib
import json
import math
import os
import re
import signal
import stat
import warnings
import zipfile
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property, lru_cache, wraps
from pathlib import Path
from typing import TYPE_CHECKING, ParamSpec, TypeVar

import numpy as np

from fretwear.arrays import Array, Mask
from fretwear.parts import Coordinates, Plain, Schema
from fretwear.platform import HAS_FORK, STOPPING
from fretwear.units import LENGTH, QuantityError, parse_quantity, size_text

if TYPE_CHECKING:
    from scipy.interpolate import RectBivariateSpline

Arguments = ParamSpec("Arguments")
Content = TypeVar("Content")
Rectangle = tuple[float, float, float, float]

MOST_BYTES = 2**30
MOST_POINTS = 25_000_000
# Limits of the process that reads a file: memory, bytes, processor time and clock time, s.
_MOST_MEMORY = 4 * MOST_BYTES
_MOST_SECONDS, _MOST_SECONDS_WAITED = 10, 60
_MOST_BYTES_OF_TEXT, _MOST_LINES = 10**7, 10**5
_LEAST_POINTS = 4
_RELAXATIONS = 200
_REMEDY = "export the part of the surface that touches"
_STORED = re.compile(r"(?P<name>[^/]+) sha256:(?P<checksum>[0-9a-f]{64})")


class Located(str):
    """A file name as a study file has it, relative to the folder of that file."""

    __slots__ = ("folder",)
    folder: Path

    @classmethod
    def at(cls, name: str, folder: Path) -> Located:
        """Return a name in a folder."""
        located = cls(name)
        located.folder = folder
        return located


@dataclass(frozen=True)
class Source:
    """A file identified by name and checksum; its folder does not count and may be empty."""

    name: str
    checksum: str
    path: str = field(default="", compare=False)

    def __str__(self) -> str:
        return f"{self.name} sha256:{self.checksum}"


@dataclass(frozen=True)
class SourceFile(Plain):
    """The name of a file, relative to the study file; its checksum is the value."""

    example: str = ""

    def read(self, value: object, units_required: bool) -> Source:
        """Return the file's name and checksum."""
        if isinstance(value, Source):
            return value
        if not isinstance(value, str) or not value.strip():
            raise QuantityError("must be the name of a file", f"such as {self.example}")
        # As stored in a dataset; a study needs the file itself.
        if not units_required and (stored := _STORED.fullmatch(value)):
            return Source(stored["name"], stored["checksum"])
        path, checksum = getattr(value, "folder", Path()) / value, ""
        try:
            status = path.stat()
            is_file, size = stat.S_ISREG(status.st_mode), status.st_size
            if is_file and size <= MOST_BYTES:
                checksum = _checksum(path, status.st_mtime_ns, size)
        except (FileNotFoundError, NotADirectoryError, ValueError):
            rule = f"is no file: there is none at {path}"
            raise QuantityError(rule, "names are relative to the study file") from None
        except OSError as error:
            raise QuantityError(f"cannot be read: {error.strerror}") from error
        if not is_file:
            what = "a folder" if stat.S_ISDIR(status.st_mode) else "no plain file"
            raise QuantityError(f"is {what}", "name the file with the surface")
        if not size:
            raise QuantityError("is empty")
        if not checksum:
            raise QuantityError(
                f"has {size_text(size)}, more than the {size_text(MOST_BYTES)} allowed",
                _REMEDY,
            )
        return Source(path.name, checksum, str(path))

    def canonical(self, value: object) -> str:
        """Return name and checksum in a line, which `read` takes back."""
        return str(value)

    def coordinates(self, name: str, value: object) -> Coordinates:
        """Yield the same line."""
        yield name, self, str(value)

    def text(self, value: object) -> str:
        """Return the name."""
        return str(value).partition(" sha256:")[0]

    def schema(self) -> Schema:
        """JSON Schema of the value in a study file."""
        return {"type": "string", "minLength": 1, "examples": [self.example]}


@lru_cache(maxsize=256)
def _checksum(path: Path, modified: int, size: int) -> str:  # noqa: ARG001 - tell files apart
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def read_once(most: int) -> Callable[[Callable[Arguments, Content]], Callable[Arguments, Content]]:
    """Keep what a function returned, or its `QuantityError`, for its latest arguments."""

    def keeping(read: Callable[Arguments, Content]) -> Callable[Arguments, Content]:
        @lru_cache(most)
        def outcome(*given: Arguments.args, **named: Arguments.kwargs) -> Content | QuantityError:
            try:
                return read(*given, **named)
            except QuantityError as error:
                return error

        @wraps(read)
        def result_of(*given: Arguments.args, **named: Arguments.kwargs) -> Content:
            result = outcome(*given, **named)  # type: ignore[arg-type]
            if isinstance(result, QuantityError):
                raise QuantityError(result.rule, result.hint)
            return result

        return result_of

    return keeping


def _in_child(read: Callable[[], Sequence[Array]]) -> list[Array]:
    """Return the arrays that a function returns in a child process with limits.

    A small file may ask for any memory and time, or crash a library. `QuantityError` if the
    function raises it, exceeds the limits, or crashes. Systems without ``fork`` read it in this
    process, without limits.
    """
    if not HAS_FORK:
        return [*read()]
    ours, theirs = os.pipe()
    with warnings.catch_warnings(action="ignore", category=DeprecationWarning):
        child = os.fork()  # other threads do not exist in the child, which uses nothing of theirs
    if not child:
        with suppress(BaseException):
            os.close(ours)
            _answer(read, theirs)
        os._exit(0)
    try:
        os.close(theirs)
        with os.fdopen(ours, "rb") as pipe:
            header, values = pipe.readline(), pipe.read()
    finally:
        os.kill(child, signal.SIGKILL)
        status = os.waitpid(child, 0)[1]
    ending = os.WTERMSIG(status) if os.WIFSIGNALED(status) else 0
    if ending in (signal.SIGXCPU, signal.SIGALRM):
        raise QuantityError(f"cannot be read within {_MOST_SECONDS} s of processor time", _REMEDY)
    try:
        shapes, rule, hint = json.loads(header)
        sizes = [math.prod(shape) for shape in shapes]
        parts = np.split(np.frombuffer(values), np.cumsum(sizes))
        arrays = [part.reshape(shape) for part, shape in zip(parts, shapes, strict=False)]
    except ValueError:
        raise QuantityError("cannot be read: the library that reads it crashed") from None
    if rule:
        raise QuantityError(rule, hint)
    return arrays


def _answer(read: Callable[[], Sequence[Array]], pipe: int) -> None:
    """Write the arrays that a function returns, or why there are none, to a pipe."""
    import resource  # which a system with ``fork`` has

    for number in (*STOPPING, signal.SIGALRM):
        signal.signal(number, signal.SIG_DFL)
    signal.alarm(_MOST_SECONDS_WAITED)
    faulthandler.disable()  # the parent tells of a crash
    warnings.simplefilter("ignore")
    resource.setrlimit(resource.RLIMIT_CPU, (_MOST_SECONDS, _MOST_SECONDS + 1))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with suppress(OSError, ValueError):  # the limit of the system may be lower
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        most = pages * resource.getpagesize() + _MOST_MEMORY
        resource.setrlimit(resource.RLIMIT_AS, (most, most))
    arrays: Sequence[Array] = ()
    problem = "", ""
    try:
        arrays = read()
    except QuantityError as error:
        problem = error.rule, error.hint
    except MemoryError:
        problem = f"cannot be read within {size_text(_MOST_MEMORY)} of memory", _REMEDY
    with os.fdopen(pipe, "wb") as answer:
        shapes = [array.shape for array in arrays]
        answer.write(json.dumps([shapes, *problem]).encode() + b"\n")
        for array in arrays:
            answer.write(array.tobytes())


@dataclass(frozen=True, eq=False)
class Topography:
    """Heights on a grid of points around the origin, in m."""

    x: Array  #: coordinates of the points, shape (nx,), increasing
    y: Array  #: shape (ny,)
    heights: Array  #: upwards out of the body, shape (nx, ny); their mean is 0
    missing: float  #: number of points that were not measured and have been filled in

    @property
    def spacing(self) -> tuple[float, float]:
        """Distance of the points along x and along y, m."""
        return float(self.x[1] - self.x[0]), float(self.y[1] - self.y[0])

    @property
    def sides(self) -> tuple[float, float]:
        """Lengths of the sides, a point's share at the border included, m."""
        return len(self.x) * self.spacing[0], len(self.y) * self.spacing[1]

    @cached_property
    def rms_height(self) -> float:
        """Root mean square of the heights, m."""
        return float(self.heights.std())

    @cached_property
    def rms_slope(self) -> float:
        """Root mean square of the slope between neighbouring points."""
        slopes = (np.diff(self.heights, axis=axis) / self.spacing[axis] for axis in (0, 1))
        return math.sqrt(sum(np.square(slope).mean() for slope in slopes))

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
UNKNOWN = Topography(_FAR, _FAR, np.full((2, 2), math.nan), math.nan)


@read_once(4)
def read_topography(
    source: Source, levelled: bool = True, patch: tuple[float, ...] | None = None
) -> Topography:
    """Read a measured surface.

    Parameters
    ----------
    source
        The file.
    levelled
        Whether to subtract the best-fitting plane, rather than just the mean.
    patch
        Corner x, y, width and height, m, of the part to read, from the file's corner; None: all.

    Raises
    ------
    QuantityError
        If the file cannot be used; the message says why.
    """
    try:
        # The child then need not import it.
        import SurfaceTopography  # noqa: F401
    except ImportError as error:
        raise QuantityError(
            "needs the package SurfaceTopography, which is not installed",
            "install it: pip install 'fretwear[surfaces]'",
        ) from error
    x, y, heights, missing = _in_child(lambda: _read_map(source, levelled, patch))
    return Topography(x, y, heights, float(missing))


def _read_map(source: Source, levelled: bool, patch: tuple[float, ...] | None) -> Sequence[Array]:
    """Coordinates of the points, m, levelled heights, m, and number of missing points."""
    values, sides = _opened(source)
    points = [
        (np.arange(count) + 0.5) * (size / count)
        for count, size in zip(values.shape, sides, strict=True)
    ]
    if patch is not None:
        inside = [
            (at >= corner) & (at <= corner + side)
            for at, corner, side in zip(points, patch[:2], patch[2:], strict=True)
        ]
        values = values[np.ix_(*inside)]
        points = [at[within] for at, within in zip(points, inside, strict=True)]
    if min(values.shape) < _LEAST_POINTS:
        raise QuantityError(
            f"has {values.shape[0]} x {values.shape[1]} points in the part to be read, too few for "
            "a surface",
            "give a map, and a patch that lies in it",
        )
    measured = np.isfinite(values)
    if measured.sum() < _LEAST_POINTS:
        raise QuantityError("has no heights: every point is missing")
    x, y = ((np.arange(len(at)) - 0.5 * (len(at) - 1)) * (at[1] - at[0]) for at in points)
    powers = ((0, 0), (1, 0), (0, 1)) if levelled else ((0, 0),)
    mean, *slopes = fitted(x, y, np.where(measured, values, 0.0), measured, powers)
    values -= mean
    for slope, distance in zip(slopes, (x[:, None], y), strict=False):
        values -= slope * distance
    return x, y, _filled(values, measured), np.array(float((~measured).sum()))


def fitted(
    x: Array, y: Array, heights: Array, measured: Mask, powers: Sequence[tuple[int, int]]
) -> Array:
    """Coefficients c of the best fit Σ c xⁱyʲ to the measured heights, by its normal equations.

    Heights are 0 where not measured. Sums over rows, then over columns, take the memory of one row.
    """
    most = 2 * max(map(max, powers)) + 1
    of_x, of_y = (np.vander(at / at[-1], most, increasing=True) for at in (x, y))
    moments, right = (
        np.einsum("xi,xj->ij", of_x, np.einsum("xy,yj->xj", values, of_y))
        for values in (measured.astype(float), heights)
    )
    gram = [[moments[i + k, j + m] for k, m in powers] for i, j in powers]
    solution, *_ = np.linalg.lstsq(gram, [right[i, j] for i, j in powers], rcond=None)
    scales = [x[-1] ** i * y[-1] ** j for i, j in powers]
    result: Array = solution / scales
    return result


def _opened(source: Source) -> tuple[Array, tuple[float, float]]:
    """Heights, NaN where missing, and lengths of the sides of a map of SurfaceTopography, m."""
    from SurfaceTopography import open_topography

    try:
        unpacked = sum(member.file_size for member in zipfile.ZipFile(source.path).infolist())
    except (OSError, ValueError, zipfile.BadZipFile):
        unpacked = 0
    if unpacked > MOST_BYTES:
        has = f"has {size_text(unpacked)} when unpacked"
        raise QuantityError(f"{has}, more than the {size_text(MOST_BYTES)} allowed", _REMEDY)
    try:
        # The readers of some forty formats raise all sorts of errors.
        reader = open_topography(source.path)
        shape = reader.default_channel.nb_grid_pts
        if math.prod(shape) <= MOST_POINTS:
            surface = reader.topography()
    except MemoryError:
        raise
    except Exception as error:
        reason = re.sub(r"\s+", " ", str(error).strip())[:150] or type(error).__name__
        if type(error).__name__ == "CannotDetectFileFormat":
            reason = "its format is none that SurfaceTopography knows"
        elif "physical_sizes" in reason:
            reason = "it does not say its lengths, so its scale is not known"
        raise QuantityError(f"cannot be read as a topography: {reason}") from error
    if math.prod(shape) > MOST_POINTS:
        has = f"has {' x '.join(map(str, shape))} points"
        raise QuantityError(f"{has}, more than the {MOST_POINTS:,} allowed", _REMEDY)
    if surface.dim != 2:
        raise QuantityError("is a line scan, but a map of heights over x and y is needed")
    if surface.unit is None:
        rule = "does not say the unit of its lengths"
        raise QuantityError(rule, "export it in a format with units, such as x3p")
    surface = surface.to_unit("m")
    x, y = surface.physical_sizes
    return np.ma.filled(surface.heights().astype(float), np.nan), (x, y)


def _filled(values: Array, measured: Mask) -> Array:
    """Fill missing points with the height of the nearest measured one, then smooth these."""
    if measured.all():
        return values
    from scipy.ndimage import distance_transform_edt

    nearest = distance_transform_edt(~measured, return_distances=False, return_indices=True)
    result: Array = values[tuple(nearest)]
    for _ in range(_RELAXATIONS):
        wide = np.pad(result, 1, mode="edge")
        around = wide[2:, 1:-1] + wide[:-2, 1:-1] + wide[1:-1, 2:] + wide[1:-1, :-2]
        result = np.where(measured, result, 0.25 * around)
    return result


@read_once(16)
def read_profile(source: Source) -> tuple[Array, Array]:
    """Read the profile of a body of revolution: distances from its axis and heights, m.

    Its first line names the columns with their units, such as ``r (mm), z (um)``; each other line
    has a distance from the axis and the height of the body's surface above its tip.

    Raises
    ------
    QuantityError
        If the file cannot be used; the message says why.
    """
    path = Path(source.path)
    if path.stat().st_size > _MOST_BYTES_OF_TEXT:
        raise QuantityError(f"is larger than the {size_text(_MOST_BYTES_OF_TEXT)} of a profile")
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise QuantityError(f"cannot be read as text: {error}") from error
    if len(lines) > _MOST_LINES:
        raise QuantityError(f"has {len(lines):,} lines, more than the {_MOST_LINES:,} of a profile")
    units = re.findall(r"[(\[]\s*([^)\]]+?)\s*[)\]]", lines[0] if lines else "")
    if len(units) != 2:
        rule = "has no units in its first line"
        raise QuantityError(rule, "name both columns there, such as: r (mm), z (um)")
    scales = [parse_quantity(f"1 {unit}", LENGTH, units_required=True) for unit in units]
    rows = [re.split(r"[,;\s]+", line.strip()) for line in lines[1:] if line.strip()]
    try:
        table = np.array([[float(cell) for cell in row] for row in rows]) * scales
    except ValueError as error:
        raise QuantityError(f"must have two numbers a line: {error}") from error
    if len(table) < _LEAST_POINTS or not np.isfinite(table).all():
        raise QuantityError(f"must have at least {_LEAST_POINTS} points, all of them numbers")
    distance, height = table.T
    if distance[0] != 0.0 or not (np.diff(distance) > 0.0).all():
        raise QuantityError("must begin at the axis, r = 0, and go outwards from line to line")
    if not (height[1:] >= height[0]).all() or height[-1] < height.max():
        raise QuantityError("must be lowest on the axis and highest at its end: a convex tip")
    return distance, height - height[0]
