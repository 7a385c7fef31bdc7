"""Files with surfaces: measured topographies and profiles, as arrays of heights in m.

What a case keeps of a file is its name and its checksum (`Source`): the same file is the same
surface wherever it is. Formats of profilometers and microscopes are read by SurfaceTopography,
which is optional and imported when a topography is read; profiles are plain text.
"""

from __future__ import annotations

import hashlib
import re
import stat
import warnings
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fretwear.parts import Plain
from fretwear.units import LENGTH, QuantityError, parse_quantity, size_text

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

MOST_BYTES = 2**30
_MOST_BYTES_OF_TEXT = 10**7
_LEAST_POINTS = 4
_RELAXATIONS = 200
_TOLD = re.compile(r"(?P<name>[^/]+) sha256:(?P<checksum>[0-9a-f]{64})")


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

    @property
    def slug(self) -> str:
        """The name and the beginning of the checksum, for the id of a case."""
        stem = re.sub(r"[^A-Za-z0-9._-]+", "-", self.name.partition(".")[0])[:24]
        return f"{stem}-{self.checksum[:6]}"


@dataclass(frozen=True)
class SourceFile(Plain):
    """The name of a file, relative to the study file; its checksum is the value."""

    usual: str

    @property
    def example(self) -> str:
        """A sensible name."""
        return self.usual

    def read(self, value: object, units_required: bool) -> Source:
        """Return the file's name and checksum."""
        if isinstance(value, Source):
            return value
        if not isinstance(value, str) or not value.strip():
            raise QuantityError("must be the name of a file", f"such as {self.example}")
        # As stored in a dataset; a study needs the file itself.
        if not units_required and (known := _TOLD.fullmatch(value)):
            return Source(known["name"], known["checksum"])
        path = getattr(value, "folder", Path()) / value
        try:
            status = path.stat()
            checksum = ""
            if stat.S_ISREG(status.st_mode) and status.st_size <= MOST_BYTES:
                checksum = _checksum(path, status.st_mtime_ns, status.st_size)
        except (FileNotFoundError, NotADirectoryError, ValueError):
            status = None
        except OSError as error:
            raise QuantityError(f"cannot be read: {error.strerror}") from error
        if status is None:
            raise QuantityError(
                f"is no file: there is none at {path}", "names are relative to the study file"
            )
        if not stat.S_ISREG(status.st_mode):
            raise QuantityError(
                f"is {'a folder' if stat.S_ISDIR(status.st_mode) else 'no plain file'}",
                "name the file with the surface",
            )
        if not status.st_size:
            raise QuantityError("is empty")
        if not checksum:
            raise QuantityError(
                f"has {size_text(status.st_size)}, more than the {size_text(MOST_BYTES)} allowed",
                "export the part of the surface that touches",
            )
        return Source(path.name, checksum, str(path))

    def canonical(self, value: Any) -> str:
        """Return name and checksum in a line, which `read` takes back."""
        return str(value)

    def coordinates(self, name: str, value: Any) -> Any:
        """Yield the same line."""
        yield name, self, str(value)

    def text(self, value: Any) -> str:
        """Return the name."""
        return str(value).partition(" sha256:")[0]

    def schema(self) -> dict[str, Any]:
        """JSON Schema of the value in a study file."""
        return {"type": "string", "minLength": 1, "examples": [self.example]}


@lru_cache(maxsize=256)
def _checksum(path: Path, modified: int, size: int) -> str:
    del modified, size
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


@dataclass(frozen=True, eq=False)
class Topography:
    """Heights on a grid of points around the origin, in m.

    Attributes
    ----------
    x, y : array
        Coordinates of the points, shapes (nx,) and (ny,), increasing.
    heights : array, shape (nx, ny)
        Upwards out of the body; their mean is 0.
    missing : int
        Number of points that were not measured and have been filled in.
    """

    x: Array
    y: Array
    heights: Array
    missing: int

    @property
    def spacing(self) -> tuple[float, float]:
        """Distance of the points along x and along y, m."""
        return float(self.x[1] - self.x[0]), float(self.y[1] - self.y[0])

    @property
    def sides(self) -> tuple[float, float]:
        """Lengths of the sides, a point's share at the border included, m."""
        return len(self.x) * self.spacing[0], len(self.y) * self.spacing[1]


@lru_cache(maxsize=4)
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
    import numpy as np

    surface = _opened(source)
    sizes, values = surface.physical_sizes, np.ma.filled(surface.heights().astype(float), np.nan)
    points = [
        (np.arange(count) + 0.5) * (size / count)
        for count, size in zip(values.shape, sizes, strict=True)
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
            f"has {values.shape[0]} x {values.shape[1]} points where it is to be read, too few for "
            "a surface",
            "give a map, and a patch that lies in it",
        )
    known = np.isfinite(values)
    if known.sum() < _LEAST_POINTS:
        raise QuantityError("has no heights: every point is missing")
    x, y = ((np.arange(len(at)) - 0.5 * (len(at) - 1)) * (at[1] - at[0]) for at in points)
    terms = np.stack(np.broadcast_arrays(1.0, x[:, None], y[None, :]), axis=-1)
    terms = terms if levelled else terms[..., :1]
    plane, *_ = np.linalg.lstsq(terms[known], values[known], rcond=None)
    values = values - terms @ plane
    return Topography(x, y, _filled(values, known), int(values.size - known.sum()))


def _opened(source: Source) -> Any:
    """Open a file by SurfaceTopography, in m."""
    try:
        from SurfaceTopography import open_topography
    except ImportError as error:
        raise QuantityError(
            "needs the package SurfaceTopography, which is not installed",
            "install it: pip install 'fretwear[surfaces]'",
        ) from error
    try:
        # The readers of some forty formats raise and warn of all sorts of things.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            surface = open_topography(source.path).topography()
    except Exception as error:
        told = re.sub(r"\s+", " ", str(error).strip())[:150] or type(error).__name__
        if type(error).__name__ == "CannotDetectFileFormat":
            told = "its format is none that SurfaceTopography knows"
        elif "physical_sizes" in told:
            told = "it does not say its lengths, so its scale is not known"
        raise QuantityError(f"cannot be read as a topography: {told}") from error
    if surface.dim != 2:
        raise QuantityError("is a line scan, but a map of heights over x and y is needed")
    if surface.unit is None:
        raise QuantityError(
            "does not say the unit of its lengths", "export it in a format with units, such as x3p"
        )
    return surface.to_unit("m")


def _filled(values: Array, known: NDArray[np.bool_]) -> Array:
    """Fill missing points with the height of the nearest one, then smooth these."""
    import numpy as np

    if known.all():
        return values
    from scipy.ndimage import distance_transform_edt

    nearest = distance_transform_edt(~known, return_distances=False, return_indices=True)
    result: Array = values[tuple(nearest)]
    for _ in range(_RELAXATIONS):
        wide = np.pad(result, 1, mode="edge")
        around = wide[2:, 1:-1] + wide[:-2, 1:-1] + wide[1:-1, 2:] + wide[1:-1, :-2]
        result = np.where(known, result, 0.25 * around)
    return result


@lru_cache(maxsize=16)
def read_profile(source: Source) -> tuple[Array, Array]:
    """Read the profile of a body of revolution: distances from its axis and heights, m.

    Its first line names the columns with their units, such as ``r (mm), z (um)``; each other line
    has a distance from the axis and the height of the body's surface above its tip.

    Raises
    ------
    QuantityError
        If the file cannot be used; the message says why.
    """
    import numpy as np

    if Path(source.path).stat().st_size > _MOST_BYTES_OF_TEXT:
        raise QuantityError(f"is larger than the {size_text(_MOST_BYTES_OF_TEXT)} of a profile")
    try:
        lines = Path(source.path).read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise QuantityError(f"cannot be read as text: {error}") from error
    rows = [re.split(r"[,;\s]+", line.strip()) for line in lines[1:] if line.strip()]
    units = re.findall(r"[(\[]\s*([^)\]]+?)\s*[)\]]", lines[0] if lines else "")
    if len(units) != 2:
        raise QuantityError(
            "has no units in its first line", "name both columns there, such as: r (mm), z (um)"
        )
    scales = [parse_quantity(f"1 {unit}", LENGTH, units_required=True) for unit in units]
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
