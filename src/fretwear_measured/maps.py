"""Maps of heights in files of instruments, as grids in metres.

SurfaceTopography, which is optional, reads the formats of profilometers and microscopes. Texts hold
columns x, y and z, or a matrix with a line for each y. The keys `unit` and `size` give what a file
lacks; what it says differently is refused.
"""

from __future__ import annotations

import io
import re
import warnings
import zipfile
from collections.abc import Collection, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fretwear.arrays import Array, Places
from fretwear.units import LENGTH, QuantityError, format_quantity, listed, parse_quantity
from fretwear_measured.tables import (
    LARGEST,
    TEXTS,
    NoTableError,
    Sought,
    Table,
    ensure,
    library,
    pick,
    read_text,
    table_of_text,
    unmarked,
)

LEAST_POINTS = 4
POSITION_AND_HEIGHT = (
    Sought(LENGTH, ("x",)),
    Sought(LENGTH, ("y",)),
    Sought(LENGTH, ("z height heights höhe hoehe hauteur topography",)),
)
_STEEPEST, _FARTHEST = 10.0, 1e3  # heights over the longer side: a map's, and those of marks
_FEW = 9  # positions in order by chance
_OFF_GRID, _FULL = 0.1, 0.25  # of a step; share of the points of a grid with a height
_LONG_EDGE = 3.0  # of the median
_LONGEST = 1.0  # side, m
_ANGSTROM = {"A": "0.1 nm", "Å": "0.1 nm"}
_ADD_UNIT = "add unit: um, or unit: [mm, mm, um] for x, y and z"
_SAVE = (
    "save it as a map in binary x3p, or as text with the columns x (um), y (um), z (um), "
    "decimal points and nan for missing heights"
)

Triple = tuple[float, float, float]


class Map(NamedTuple):
    """What a file holds: a map, or a line scan with one line."""

    heights: Array  #: m, shape (nx, ny), NaN where missing
    sides: tuple[float, float]  #: m
    reader: str  #: how it was read, for people
    positions: int = 0  #: uneven positions between which heights were interpolated; 0 on a grid
    x: Array | None = None  #: positions of a line scan, m


def read_map(path: Path, unit: str, size: str, file_format: str, channel: str) -> Map:
    """Read a map; `QuantityError` says why it cannot be read and what to do."""
    is_text = path.suffix.lower() in (*TEXTS, ".xyz") and not file_format
    found = _map_of_text(path, unit, size) if is_text else None
    found = found or open_surface(path, unit, size, file_format, channel)
    rule = "is a line scan, but a map of heights over x and y is needed"
    ensure(found.heights.shape[1] > 1, rule, _SAVE)
    rule = f"({found.reader}) has sides of {_by(found.sides)}"
    ensure(max(found.sides) <= _LONGEST, rule, f"check its units, or {_SAVE}")
    return found._replace(heights=without_marks(found.heights, max(found.sides)))


def without_marks(heights: Array, side: float) -> Array:
    """Heights with NaN in place of marks of missing points, such as -9999 or -1.8e308.

    They are those of `unmarked`, or farther from the median than 1000 times the longer side.
    """
    kept = unmarked(heights)
    if not np.isfinite(kept).any():
        return kept
    middle = np.diff(np.nanpercentile(kept, (25, 75)))[0]
    rule = f"has heights that differ by more than {_STEEPEST:g} times its longer side"
    remedy = "check its units; if it has none: unit: [mm, mm, um]"
    ensure(middle <= _STEEPEST * side, rule, remedy)
    kept[np.abs(kept - np.nanmedian(kept)) > _FARTHEST * side] = np.nan
    return kept


def scales_of(stated: Sequence[str], unit: str) -> Triple:
    """Metres of the units of x, y, z: those in the file, else those of the key `unit`."""
    keys = [one.strip() for one in unit.split(",")]
    ensure(len(keys) in (1, 3), f"needs one unit or three, not unit: [{unit}]", _ADD_UNIT)
    pairs = [*zip(stated, keys * (3 // len(keys)), strict=True)]
    ensure(all(map(any, pairs)), "does not say the unit of its lengths", _ADD_UNIT)
    x, y, z = (_length(own or key) for own, key in pairs)
    fills = len(keys) == 1 and not all(stated)
    differs = (abs(_length(o) / _length(k) - 1.0) > 1e-9 for o, k in pairs if o and k)
    says = listed(f"{axis} ({own or '?'})" for axis, own in zip("xyz", stated, strict=True))
    rule = f"says {says}, which unit: {unit} contradicts"
    ensure(fills or not any(differs), rule, "remove the key unit")
    return x, y, z


def _length(unit: str) -> float:
    return parse_quantity(f"1 {_ANGSTROM.get(unit, unit)}", LENGTH, units_required=True)


def _by(sides: Sequence[float]) -> str:
    return " x ".join(format_quantity(side, LENGTH, 4) for side in sides)


def _sides(size: str) -> tuple[float, float]:
    """Lengths of the sides, m, of a text such as "900 um, 900 um"."""
    length = replace(LENGTH, example="900 um")
    sides = [parse_quantity(one, length, units_required=True) for one in size.split(",")]
    is_pair = len(sides) == 2 and min(sides) > 0.0
    ensure(is_pair, f"needs two sides, not size: [{size}]", "size: [900 um, 900 um]")
    return sides[0], sides[1]


def _checked(sides: Sequence[float], points: Sequence[int], size: str) -> tuple[float, float]:
    """The sides in a file, m; the key `size` may differ from them by a step of the points."""
    asked = _sides(size) if size else sides
    trios = zip(sides, asked, points, strict=True)
    same = all(abs(own - key) <= 1.5 * own / count for own, key, count in trios)
    rule = f"has sides of {_by(sides)}, which size: [{size}] contradicts"
    ensure(same, rule, "remove the key size")
    return sides[0], sides[1]


def _map_of_text(path: Path, unit: str, size: str) -> Map | None:
    """The map of a text; None if SurfaceTopography may know it."""
    try:
        text = re.sub("(?i)no[ _]data", "nan", read_text(path))
        is_of_zygo = text.startswith("Zygo XYZ Data File")
        table = table_of_text(text.partition("\n#")[2] if is_of_zygo else text)
        is_named = len(table.names) == table.values.shape[1]
        of_x, of_y = map(table.ranked, POSITION_AND_HEIGHT[:2])
        has_axes = is_named and of_x and of_y and of_x.keys() != of_y.keys()
        is_matrix = table.values.shape[1] > 3 and not has_axes
        numbers = [*table.words] if is_matrix else table.choose(POSITION_AND_HEIGHT, "")
        rows = _whole_rows(table, numbers)
    except NoTableError:
        return None  # some instruments name their binary files .dat
    except QuantityError as error:
        raise QuantityError(error.rule, _SAVE) from error
    if is_matrix:
        return _map_of_matrix(table, rows, unit, size)
    scales = scales_of(("m", "m", "um") if is_of_zygo else [table.units[n] for n in numbers], unit)
    sizes = [format_quantity(scale, LENGTH).removeprefix("1 ") for scale in scales]
    labels = [table.names[n] if is_named else f"number {n}" for n in numbers]
    columns = ", ".join(f"{name} ({one})" for name, one in zip(labels, sizes, strict=True))
    reader = f"text, columns {columns}"
    if is_of_zygo:  # columns and lines of a camera
        found = re.match(r"(?:.*\n){7}(?:\S+ ){6}([\d.eE+-]+) ", text)
        pixel = float(found[1]) if found else 0.0
        remedy = f"calibrate it in MetroPro, or {_SAVE}"
        ensure(pixel > 0.0, "is an xyz file of Zygo without a lateral calibration", remedy)
        reader = f"xyz of Zygo, {format_quantity(pixel, LENGTH, 4)} per pixel, heights in um"
        scales = (pixel, pixel, 1e-6)
    x, y, z = (s * table.values[rows, n] for s, n in zip(scales, numbers, strict=True))
    return _map_of_points(x, y, z, reader, size)


def _whole_rows(table: Table, numbers: Sequence[int]) -> Places:
    """The rows with numbers; `QuantityError` if some are short, or have words in some columns."""
    for number in numbers:
        table.numbers(number)
    rows = np.flatnonzero(np.isfinite(table.values).any(axis=1))
    widths = np.array(table.widths)[rows]
    rule = f"has {widths[1:].min(initial=9)} numbers in a line, but {widths.max()} in others"
    ensure((widths[1:] == widths.max()).all(), f"{rule}: its end may be missing")
    return rows


def _lines_of(places: Array) -> tuple[Array, float]:
    """Positions of the lines of a grid, and the step of which all are multiples; 0 without one."""
    lines = np.unique(places)
    lines = lines[np.append(True, np.diff(lines) > 1e-6 * np.ptp(lines))]
    ensure(len(lines) > 1, "is no map: its points lie on one line", _SAVE)
    steps = np.diff(lines)
    for first in (np.median(steps), steps.min()):
        counts = np.append(0, np.cumsum(np.rint(steps / first)))
        step = float(np.ptp(lines) / max(counts[-1], 1.0))
        away = np.abs(lines - lines[0] - step * counts).max()
        if away < _OFF_GRID * step and (np.diff(counts) > 0).all():
            return lines, step
    return lines, 0.0


def _map_of_points(x: Array, y: Array, z: Array, reader: str, size: str) -> Map:
    """The map of heights at positions, m; lines that are left out are missing points."""
    there = np.isfinite(x) & np.isfinite(y)
    x, y, z = x[there], y[there], z[there]
    ensure(x.size >= LEAST_POINTS**2, f"has {x.size} points with x and y, too few for a map", _SAVE)
    (lines_x, step_x), (lines_y, step_y) = _lines_of(x), _lines_of(y)
    if not (step_x and step_y):
        return _interpolated((x, y), z, (lines_x, lines_y), reader)
    at_x, at_y = (np.rint((p - p.min()) / s).astype(int) for p, s in ((x, step_x), (y, step_y)))
    shape = int(at_x.max()) + 1, int(at_y.max()) + 1
    if x.size < _FULL * shape[0] * shape[1]:
        return _interpolated((x, y), z, (lines_x, lines_y), reader)
    is_single = len(np.unique(at_x * shape[1] + at_y)) == x.size
    ensure(is_single, "has several heights at one place", "save each map in a file of its own")
    heights = np.full(shape, np.nan)
    heights[at_x, at_y] = z
    return Map(heights, _checked((step_x * shape[0], step_y * shape[1]), shape, size), reader)


def _interpolated(
    places: Sequence[Array], z: Array, lines: Sequence[Collection[float]], reader: str
) -> Map:
    """The map between uneven or scattered positions, with about as many points."""
    from scipy.interpolate import CloughTocher2DInterpolator
    from scipy.spatial import Delaunay, QhullError

    widths, known = [np.ptp(one) for one in places], np.isfinite(z)
    # Few positions along an axis are the lines of a scan.
    few = [len(one) if 4 * len(one) < z.size else 0 for one in lines]
    square = np.sqrt(widths[0] * widths[1] / z.size)
    counts = [
        own or (z.size // across if across else round(width / square))
        for own, across, width in zip(few, few[::-1], widths, strict=True)
    ]
    cells = [(p - p.min()) * n / w for p, n, w in zip(places, counts, widths, strict=True)]
    points = np.stack(cells, axis=1)[known]
    grid = np.stack(np.meshgrid(*(np.arange(n) + 0.5 for n in counts), indexing="ij"), axis=-1)
    try:
        mesh = Delaunay(points)
    except (QhullError, ValueError) as error:
        raise QuantityError("is no map: its points lie on one line", _SAVE) from error
    heights = CloughTocher2DInterpolator(mesh, z[known])(grid)
    # Triangles with long edges span holes.
    corners = points[mesh.simplices]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1).max(axis=-1)
    heights[(edges > _LONG_EDGE * np.median(edges))[mesh.find_simplex(grid)]] = np.nan
    reader += f", interpolated between {len(points)} uneven positions"
    return Map(heights, (float(widths[0]), float(widths[1])), reader, len(points))


def _axes_of(values: Array) -> tuple[Array, Array] | None:
    """Positions in the first line and column of a matrix; None if they are heights too."""
    axes, are_axes, are_even = (values[0, 1:], values[1:, 0]), [], []
    for n, axis in enumerate(axes):
        steps, inside = np.diff(axis), np.diff(values[1:, 1:], axis=1 - n)
        is_even = bool(np.ptp(steps) < 0.05 * abs(steps.mean()))
        is_ordered = bool((steps > 0.0).all() or (steps < 0.0).all())
        waves = bool((inside > 0.0).any() and (inside < 0.0).any())
        # The heights of a slope are ordered as well, but go on like that inside.
        goes_on = abs(np.nanmedian(inside) - steps.mean()) < 0.2 * abs(steps.mean())
        are_axes.append(is_ordered and not goes_on and (is_even or waves))
        are_even.append(is_even and axis.size > _FEW)
    if all(are_axes):
        return axes
    for name, is_axis, is_even in zip(("line", "column"), are_axes, are_even, strict=True):
        if is_axis and is_even:
            rule = f"has a matrix whose first {name} holds positions or numbers of its points"
            remedy = "save the heights alone, or x in the first line and y in the column"
            raise QuantityError(rule, remedy)
    return None


def _map_of_matrix(table: Table, rows: Places, unit: str, size: str) -> Map | None:
    """The map of a matrix with a line for each y, its axes perhaps in the first line and column."""
    if (np.diff(table.lines) > 1).any():
        return None  # several channels
    values, above = table.values[rows], [*table.above]
    if table.widths[0] == values.shape[1] - 1:  # an axis without a corner
        values[0] = np.roll(values[0], 1)
    elif len(table.names) == values.shape[1]:  # a corner with words
        with suppress(ValueError):
            line = [float(name.replace(",", ".")) for name in table.names[1:]]
            values = np.vstack([[np.nan, *line], values])
    values = np.where(np.abs(values) < LARGEST, values, np.nan)
    axes = _axes_of(values)
    values = values if axes is None else values[1:, 1:]
    if axes and all(
        np.array_equal(axis - axis[0], np.arange(axis.size)) and axis[0] in (0, 1) for axis in axes
    ):
        rule = "has a matrix whose first line and column count its points"
        ensure(size and unit, rule, "add size: [900 um, 900 um] and unit: um")
        above = []
    elif axes:
        # Units of x, y and z in brackets in the corner.
        own = re.findall(r"[(\[]\s*([^)\]\s]+)\s*[)\]]", above[-1] if above else "")
        if len(own) == 1:  # of the axes; of the heights too if nothing else is said
            own = [*own, *own, "" if unit else own[0]]
        scales = scales_of(own if len(own) == 3 else ("", "", ""), unit)
        x, y = np.meshgrid(scales[0] * axes[0], scales[1] * axes[1], indexing="ij")
        heights = scales[2] * values.T.ravel()
        return _map_of_points(x.ravel(), y.ravel(), heights, "text, matrix with axes", size)
    # As Keyence writes it, in any language: "XY Calibration","277.7","nm" and "Unit","um".
    said = "\n".join(above).replace('"', "")
    if pitch := re.search(r"^XY[^,;\t]*[,;\t]([\d.,]+)[,;\t](\w+)$", said, re.M):
        text, lateral = pitch.groups()
        vertical = re.search(r"^(?:Unit|Einheit)[,;\t](\w+)$", said, re.M)
        scales = scales_of((lateral, lateral, vertical[1] if vertical else ""), unit)
        step, shape = scales[0] * float(text.replace(",", ".")), values.T.shape
        sides = _checked([step * count for count in shape], shape, size)
        return Map(scales[2] * values.T, sides, f"text, matrix, {text} {lateral} per point")
    if unit and size and not above:
        return Map(scales_of(("", "", ""), unit)[2] * values.T, _sides(size), "text, matrix")
    # SurfaceTopography knows many lines above a matrix, but no decimal commas.
    clean = io.StringIO()
    np.savetxt(clean, values)
    above = [re.sub(r"(\d),(\d)", r"\1.\2", line) for line in above]
    content = "\n".join([*above, clean.getvalue()]).encode()
    return open_surface(io.BytesIO(content), unit, size, "asc", "")


def open_surface(
    file: Path | io.BytesIO, unit: str, size: str, file_format: str, channel: str
) -> Map:
    """What SurfaceTopography reads of a map or a line scan."""
    with library("SurfaceTopography", "surfaces", "a topography", _SAVE):
        from SurfaceTopography import open_topography
        from SurfaceTopography.IO import lookup_reader_by_format as formats

        rule = f"has no reader for format: {file_format}"
        ensure(file_format in ("", *formats), rule, f"formats are {listed(sorted(formats))}")
        if isinstance(file, Path) and "x3p" in (file_format, file.suffix.lower()[1:]):
            file = _mended(file)
        with (
            warnings.catch_warnings(action="ignore"),
            open_topography(file, file_format or None) as reader,
        ):
            chosen = _channel(reader, channel)
            says_sides = chosen.dim == 1 or chosen.physical_sizes is not None
            rule = "does not say the lengths of its sides"
            ensure(size or says_sides, rule, "add size: [900 um, 900 um] and unit: um")
            own = {} if chosen.unit else chosen.info.get("raw_metadata") or {}
            lateral = chosen.unit or own.get("xunit") or ""
            scales = scales_of((lateral, lateral, chosen.unit or ""), unit)
            keys: dict[str, Any] = {}
            if not says_sides:
                keys = {"physical_sizes": tuple(np.divide(_sides(size), scales[:2]))}
            surface = chosen.topography(**keys)
            heights = scales[2] * np.ma.filled(surface.heights().astype(float), np.nan)
            if heights.shape[1:] in ((), (1,)):
                places = surface.positions() if chosen.dim == 1 else surface.positions()[0]
                x = scales[0] * np.asarray(places, float).ravel()
                return Map(heights.reshape(-1, 1), (0.0, 0.0), "", x=x)
            sides = np.multiply(surface.physical_sizes, scales[:2]).tolist()
            name = f"{reader.format()}, channel {chosen.name}"
            return Map(heights, _checked(sides, heights.shape, size), name)


def _channel(reader: Any, asked: str) -> Any:
    """The channel with a number or a name, or the usual one."""
    remedy = "export the heights (topography), not a phase or an amplitude"
    ensure(reader.channels, "has no channel of heights", remedy)
    names = [one.name for one in reader.channels]
    number = int(asked) if asked.isdecimal() and asked not in names else asked
    chosen = reader.channels[pick(number, names, "height channel")] if asked else None
    return chosen or reader.default_channel


def _mended(path: Path) -> io.BytesIO:
    """An x3p as SurfaceTopography takes it.

    The revision is the old one, names of the instrument are not empty, heights are binary, and a
    profile is a surface with one line.
    """
    with zipfile.ZipFile(path) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    xml = content["main.xml"].decode()
    xml = re.sub(r"(<(?:\w+:)?Revision>)[^<]*", r"\1ISO5436 - 2000", xml)
    xml = re.sub(r"(<(?:\w+:)?FeatureType>)\s*PRF", r"\1SUR", xml)
    empty = r"<((?:\w+:)?(?:Manufacturer|Model|Serial|Version))\s*(?:/>|>\s*</\1>)"
    xml = re.sub(empty, r"<\1>unknown</\1>", xml)
    if texts := re.findall(r"<(?:\w+:)?Datum\s*(?:/>|>([^<]*)<)", xml):
        heights = [float(text.rpartition(";")[2].strip() or "nan") for text in texts]
        content["heights.bin"] = np.array(heights, "<f8").tobytes()
        link = r"<\1DataLink><\1PointDataLink>heights.bin</\1PointDataLink></\1DataLink>"
        xml = re.sub(r"(?s)<((?:\w+:)?)DataList>.*</\1DataList>", link, xml)
        xml = re.sub(r"(?s)(<(?:\w+:)?CZ>.*?DataType>)\w", r"\1D", xml)
    mended = io.BytesIO()
    with zipfile.ZipFile(mended, "w") as archive:
        for name, data in (content | {"main.xml": xml.encode()}).items():
            archive.writestr(name, data)
    mended.seek(0)
    return mended
