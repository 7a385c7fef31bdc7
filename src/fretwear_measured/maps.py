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
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fretwear.arrays import Array
from fretwear.units import LENGTH, QuantityError, format_quantity, listed, parse_quantity
from fretwear_measured.tables import read_text

LEAST_POINTS = 4
_TEXTS = (".csv", ".txt", ".dat", ".xyz", ".asc", ".tsv", ".prn")
_NAMES = ("x",), ("y",), ("z", "height", "heights", "höhe", "hoehe", "hauteur", "topography")
_MARKS = "nan|no[ _]?data|bad|n/?a|-+|[*]+|null|[-+]?inf(inite|inity)?|invalid|masked|void|none"
_CELL = re.compile(rf"(?P<number>[-+−]?(\d+[.,]?\d*|[.,]\d+)(e[-+]?\d+)?)|{_MARKS}|", re.I)
_WORD = re.compile(r"[^\s(\[]+(?:\s*[(\[][^)\]]*[)\]])?")
_HEAD = re.compile(r"(.*?)[\s_]*(?:[(\[/]\s*([^)\]]*?)\s*[)\]]?|[\s_]([nuµμm]?m))?")
_SIDE = re.compile(r"#[^:]+:\s*[\d.,]+\s*\S?m\s*$")  # as Gwyddion writes it
_MOST_HEADLINES = 500
_STEEPEST, _FARTHEST = 10.0, 1e3  # heights over the longer side: a map's, and those of marks
_FAR_AWAY = 10.0  # of a mark, over the range of the other heights
_OFF_GRID, _FULL = 0.1, 0.25  # of a step; share of the points of a grid with a height
_MOST_CUBIC, _LONG_EDGE = 200_000, 3.0  # points, of the median
_LARGEST, _LONGEST = 1e300, 1.0  # a number, a side in m
_ADD_UNIT = "add unit: um, or unit: [mm, mm, um] for x, y and z"
_SAVE = "save it as a map in binary x3p, or as text with x (um), y (um), z (um)"
_LINE_SCAN = "is a line scan, but a map of heights over x and y is needed", _SAVE

Triple = tuple[float, float, float]


class Map(NamedTuple):
    """What a file holds."""

    heights: Array  #: m, shape (nx, ny), NaN where missing
    sides: tuple[float, float]  #: m
    reader: str  #: how it was read, for people
    positions: int = 0  #: uneven positions between which heights were interpolated; 0 on a grid


def read_map(path: Path, unit: str, size: str, file_format: str, channel: str) -> Map:
    """Read a map; `QuantityError` says why it cannot be read and what to do."""
    is_text = path.suffix.lower() in _TEXTS and not file_format
    found = _map_of_text(path, unit, size) if is_text else None
    found = found or _map_of_surface(path, unit, size, file_format, channel)
    if max(found.sides) > _LONGEST:
        says = " x ".join(format_quantity(side, LENGTH, 4) for side in found.sides)
        raise QuantityError(f"({found.reader}) has sides of {says}", f"check its units, or {_SAVE}")
    return found._replace(heights=without_marks(found.heights, max(found.sides)))


def without_marks(heights: Array, side: float) -> Array:
    """Heights with NaN in place of marks of missing points, such as -9999 or -1.8e308.

    They are a lowest or highest value that repeats, ten times as far away from the other heights as
    these reach, or farther from the median than 1000 times the longer side.
    """
    kept = np.where(np.abs(heights) < _LARGEST, heights, np.nan)
    if not np.isfinite(kept).any():
        return kept
    for extreme in (np.nanmin(kept), np.nanmax(kept)):
        mark = kept == extreme
        others = kept[np.isfinite(kept) & ~mark]
        if mark.sum() > 1 and others.size:
            away = max(others.min() - extreme, extreme - others.max())
            kept[mark & (away > _FAR_AWAY * np.ptp(others) > 0.0)] = np.nan
    if np.diff(np.nanpercentile(kept, (25, 75)))[0] > _STEEPEST * side:
        rule = f"has heights that differ by more than {_STEEPEST:g} times its longer side"
        raise QuantityError(rule, "check its units; if it has none: unit: [mm, mm, um]")
    kept[np.abs(kept - np.nanmedian(kept)) > _FARTHEST * side] = np.nan
    return kept


def scales_of(stated: Sequence[str], unit: str) -> Triple:
    """Metres of the units of x, y, z: those in the file, else those of the key `unit`."""
    keys = [one.strip() for one in unit.split(",")]
    if len(keys) not in (1, 3):
        raise QuantityError(f"needs one unit or three, not unit: [{unit}]", _ADD_UNIT)
    pairs = [*zip(stated, keys * (3 // len(keys)), strict=True)]
    if not all(own or key for own, key in pairs):
        raise QuantityError("does not say the unit of its lengths", _ADD_UNIT)
    fills = len(keys) == 1 and not all(stated)
    differs = (abs(_length(o) / _length(k) - 1.0) > 1e-9 for o, k in pairs if o and k)
    if not fills and any(differs):
        says = listed(f"{axis} ({own or '?'})" for axis, own in zip("xyz", stated, strict=True))
        raise QuantityError(f"says {says}, which unit: {unit} contradicts", "remove the key unit")
    x, y, z = (_length(own or key) for own, key in pairs)
    return x, y, z


def _length(unit: str) -> float:
    if unit in ("A", "Å"):
        return 1e-10
    try:
        return parse_quantity(f"1 {unit}", LENGTH, units_required=True)
    except QuantityError as error:
        raise QuantityError(f"has {unit!r}, no unit of length", error.hint or _ADD_UNIT) from error


def _units_in(line: str) -> Sequence[str]:
    """Units of x, y and z in brackets in a line."""
    units = re.findall(r"[(\[]\s*([^)\]\s]+)\s*[)\]]", line)
    return units * (3 // len(units)) if len(units) in (1, 3) else ("", "", "")


def _sides(size: str) -> tuple[float, float]:
    """Lengths of the sides, m, of a text such as "900 um, 900 um"."""
    sides = [parse_quantity(one, LENGTH, units_required=True) for one in size.split(",")]
    if len(sides) != 2 or min(sides) <= 0.0:
        raise QuantityError(f"needs two sides, not size: [{size}]", "size: [900 um, 900 um]")
    return sides[0], sides[1]


def _checked(sides: Sequence[float], points: Sequence[int], size: str) -> tuple[float, float]:
    """The sides in a file, m; the key `size` may differ from them by a step of the points."""
    asked = _sides(size) if size else sides
    for own, key, count in zip(sides, asked, points, strict=True):
        if abs(own - key) > 1.5 * own / count:
            says = " x ".join(format_quantity(side, LENGTH, 4) for side in sides)
            rule = f"has sides of {says}, which size: [{size}] contradicts"
            raise QuantityError(rule, "remove the key size")
    return sides[0], sides[1]


def _map_of_text(path: Path, unit: str, size: str) -> Map | None:
    """The map of a text; None if it holds neither columns nor a matrix."""
    try:
        text = re.sub("(?i)no[ _]data", "nan", read_text(path))
    except QuantityError:
        return None  # some instruments name their binary files .dat
    if text.startswith("Zygo XYZ Data File"):
        return _map_of_zygo(text, unit, size)
    if (block := _block_of(text)) is None:
        return None
    above, separator, values = block
    if values.shape[1] == 3 and any(map(_SIDE.match, above)):
        return None  # a narrow matrix
    heads: Sequence[tuple[str, str]] = ()
    for line in above[-2:]:
        cells = _cells(line, separator) if separator else _WORD.findall(line.lstrip("# "))
        found = [_HEAD.fullmatch(cell) for cell in cells]
        own = [(one[1].casefold(), one[2] or one[3] or "") if one else ("", "") for one in found]
        # Units may have a line of their own.
        only_units = len(own) == len(heads) and not any(name for name, _ in own)
        heads = [(n, u) for (n, _), (_, u) in zip(heads, own, strict=True)] if only_units else own
    named = len(heads) == values.shape[1]
    names = [name for name, _ in heads] if named else []
    chosen = [
        [n for n, name in enumerate(names) if name in words]
        or [n for n, name in enumerate(names) if {*words} & {*re.findall(r"\w+", name)}]
        for words in _NAMES
    ]
    if values.shape[1] > 3 and (not all(chosen[:2]) or chosen[0] == chosen[1]):
        return _map_of_matrix(above, values, unit, size)
    chosen = chosen if named else [[0], [1], [2]]
    if any(len(one) != 1 for one in chosen):
        rule = f"has the columns {listed(names)}, not one each for x, y and z"
        raise QuantityError(rule, "name them x (um), y (um), z (um)")
    numbers = [one[0] for one in chosen]
    scales = scales_of([heads[n][1] for n in numbers] if named else ("", "", ""), unit)
    x, y, z = (scale * values[:, n] for scale, n in zip(scales, numbers, strict=True))
    sizes = [format_quantity(scale, LENGTH).removeprefix("1 ") for scale in scales]
    labels = [names[n] if named else f"number {n}" for n in numbers]
    columns = ", ".join(f"{name} ({one})" for name, one in zip(labels, sizes, strict=True))
    return _map_of_points(x, y, z, f"text, columns {columns}", size)


def _map_of_zygo(text: str, unit: str, size: str) -> Map:
    """The map of an xyz file of Zygo: columns and lines of a camera, heights in µm."""
    head, _, rows = text.partition("\n#")
    try:
        pixel = float(head.splitlines()[7].split()[6])
        numbers = [row.split() for row in rows.splitlines() if row.strip().strip("#")]
        columns, lines, heights = np.array(numbers, float).T
    except (ValueError, IndexError) as error:
        raise QuantityError(
            "is a damaged xyz file of Zygo", f"export it again, or {_SAVE}"
        ) from error
    if not pixel > 0.0:
        raise QuantityError("has no lateral calibration", f"calibrate it in MetroPro, or {_SAVE}")
    scales_of(("m", "m", "um"), unit)
    reader = f"xyz of Zygo, {format_quantity(pixel, LENGTH, 4)} per pixel, heights in um"
    return _map_of_points(pixel * columns, pixel * lines, 1e-6 * heights, reader, size)


def _lines_of(places: Array) -> tuple[Array, float]:
    """Positions of the lines of a grid, and the step of which all are multiples; 0 without one."""
    lines = np.unique(places)
    lines = lines[np.append(True, np.diff(lines) > 1e-6 * np.ptp(lines))]
    if len(lines) < 2:
        raise QuantityError("is no map: its points lie on one line", "give a map of x, y and z")
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
    if x.size < LEAST_POINTS**2:
        raise QuantityError(f"has {x.size} points with x and y, too few for a map", _SAVE)
    (lines_x, step_x), (lines_y, step_y) = _lines_of(x), _lines_of(y)
    if not (step_x and step_y):
        return _interpolated((x, y), z, (lines_x, lines_y), reader)
    at_x, at_y = (np.rint((p - p.min()) / s).astype(int) for p, s in ((x, step_x), (y, step_y)))
    shape = int(at_x.max()) + 1, int(at_y.max()) + 1
    if x.size < _FULL * shape[0] * shape[1]:
        return _interpolated((x, y), z, (lines_x, lines_y), reader)
    if len(np.unique(at_x * shape[1] + at_y)) < x.size:
        raise QuantityError(
            "has several heights at one place", "save each map in a file of its own"
        )
    heights = np.full(shape, np.nan)
    heights[at_x, at_y] = z
    return Map(heights, _checked((step_x * shape[0], step_y * shape[1]), shape, size), reader)


def _interpolated(places: Sequence[Array], z: Array, lines: Sequence[Array], reader: str) -> Map:
    """The map between uneven or scattered positions, with about as many points."""
    from scipy.interpolate import CloughTocher2DInterpolator, LinearNDInterpolator
    from scipy.spatial import Delaunay, QhullError

    widths, known = [np.ptp(at) for at in places], np.isfinite(z)
    # Few positions along an axis are the lines of a scan.
    few = [len(one) if 4 * len(one) < z.size else 0 for one in lines]
    square = np.sqrt(widths[0] * widths[1] / z.size)
    counts = [
        own or (z.size // across if across else round(width / square))
        for own, across, width in zip(few, few[::-1], widths, strict=True)
    ]
    scaled = [(p - p.min()) * n / w for p, n, w in zip(places, counts, widths, strict=True)]
    points = np.stack(scaled, 1)[known]
    grid = [np.arange(count) + 0.5 for count in counts]
    wanted = np.stack(np.meshgrid(*grid, indexing="ij"), -1)
    try:
        mesh = Delaunay(points)
    except (QhullError, ValueError) as error:
        raise QuantityError("is no map: its points lie on one line", _SAVE) from error
    between = CloughTocher2DInterpolator if z.size < _MOST_CUBIC else LinearNDInterpolator
    heights = between(mesh, z[known])(wanted)
    # Triangles with long edges span holes.
    corners = points[mesh.simplices]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1).max(axis=-1)
    spans_hole = edges > _LONG_EDGE * np.median(edges)
    heights[spans_hole[mesh.find_simplex(wanted)]] = np.nan
    reader += f", interpolated between {len(points)} uneven positions"
    return Map(heights, (float(widths[0]), float(widths[1])), reader, len(points))


def _cells(line: str, separator: str | None) -> list[str]:
    return [cell.strip(' "') for cell in line.rstrip(";,\t ").split(separator)]


def _is_data(cells: Sequence[str]) -> bool:
    """Whether all cells are numbers or marks of missing points, and one is a number."""
    found = [_CELL.fullmatch(cell) for cell in cells]
    return all(found) and any(cell and cell["number"] for cell in found)


def _block_of(text: str) -> tuple[list[str], str | None, Array] | None:
    """The lines above a block of numbers, the sign between these, and their values."""
    lines = [line for line in text.splitlines() if line.strip()]
    for first, neighbours in enumerate(pairwise(lines[:_MOST_HEADLINES])):
        for separator in ("\t", ";", ",", None):
            one, following = (_cells(line, separator) for line in neighbours)
            count = len(following)
            if (
                count >= 3
                and count - 1 <= len(one) <= count
                and _is_data(one)
                and _is_data(following)
            ):
                break
        else:
            continue
        rows = [_cells(line, separator) for line in lines[first:]]
        corner = _cells(lines[first - 1], separator)[1 - count :] if first else []
        if len(rows[0]) == count - 1:  # an axis without a corner
            rows[0].insert(0, "")
        elif len(corner) == count - 1 and _is_data(corner):  # or with words in it
            rows.insert(0, ["", *corner])
        fits = [len(row) == count for row in rows]
        end = fits.index(False) if False in fits else len(rows)
        if any(fits[end:]):
            return None  # several channels
        if broken := next((row for row in rows[end:] if _is_data(row)), None):
            rule = f"has {len(broken)} numbers in a line, but {count} in others"
            raise QuantityError(rule, "export it again: its end may be missing")
        cells = np.char.replace(rows[:end], "−", "-")
        if separator != ",":
            cells = np.char.replace(cells, ",", ".")
        try:
            values = cells.astype(float)
        except ValueError:
            numbers = [[_is_data([cell]) for cell in row] for row in cells]
            values = np.where(numbers, cells, "nan").astype(float)
        return lines[:first], separator, np.where(np.abs(values) < _LARGEST, values, np.nan)
    return None


def _axes_of(values: Array) -> tuple[Array, Array] | None:
    """Positions in the first line and column of a matrix; None if they are heights too."""
    axes = values[0, 1:], values[1:, 0]
    steps = [np.diff(axis) for axis in axes]
    ordered = [bool((step > 0).all() or (step < 0).all()) for step in steps]
    even = [o and np.ptp(s) < 0.05 * abs(s.mean()) for o, s in zip(ordered, steps, strict=True)]
    # The heights of a plane, or of a slope, are ordered as well, but go on like that inside.
    inside = np.diff(values[1:, 1:], axis=1), np.diff(values[1:, 1:], axis=0)
    waves = [(step > 0).any() and (step < 0).any() for step in inside]
    jumps = [
        not abs(np.median(i[np.isfinite(i)]) - s.mean()) < 0.2 * abs(s.mean())
        for i, s in zip(inside, steps, strict=True)
    ]
    if (all(even) and any(jumps)) or (all(ordered) and all(waves)):
        return axes
    if any(e and j and s.size > 8 for e, j, s in zip(even, jumps, steps, strict=True)):
        which = "line" if even[0] else "column"
        rule = f"has a matrix whose first {which} holds positions or numbers of its points"
        raise QuantityError(
            rule, "save the heights alone, or x in the first line and y in the column"
        )
    return None


def _map_of_matrix(above: Sequence[str], values: Array, unit: str, size: str) -> Map:
    """The map of a matrix with a line for each y, its axes perhaps in the first line and column."""
    if axes := _axes_of(values):
        values = values[1:, 1:]
        if all(np.array_equal(at, at[0] + np.arange(at.size)) and at[0] in (0, 1) for at in axes):
            if not (size and unit):
                rule = "has a matrix whose first line and column count its points"
                raise QuantityError(rule, "add size: [900 um, 900 um] and unit: um")
            above = []
        else:
            scales = scales_of(_units_in(above[-1] if above else ""), unit)
            x, y = np.meshgrid(scales[0] * axes[0], scales[1] * axes[1], indexing="ij")
            heights = scales[2] * values.T.ravel()
            return _map_of_points(x.ravel(), y.ravel(), heights, "text, matrix with axes", size)
    # As Keyence writes it, in any language: "XY Calibration","277.7","nm" and "Unit","um".
    cells = [_cells(line, separator) for line in above for separator in (",", ";", "\t")]
    pitch = [
        row for row in cells if len(row) == 3 and row[0].startswith("XY") and _is_data(row[1:2])
    ]
    if pitch:
        word, number, lateral = pitch[0]
        own = [row[1] for row in cells if len(row) == 2 and row[0] in ("Unit", "Einheit")]
        scales = scales_of((lateral, lateral, own[0] if own else ""), unit)
        step, shape = scales[0] * float(number.replace(",", ".")), values.T.shape
        sides = _checked([step * count for count in shape], shape, size)
        return Map(scales[2] * values.T, sides, f"text, matrix, {word} {number} {lateral}")
    if unit and size and not above:
        return Map(scales_of(("", "", ""), unit)[2] * values.T, _sides(size), "text, matrix")
    # SurfaceTopography knows many lines above a matrix, but no decimal commas.
    clean = io.StringIO()
    np.savetxt(clean, values)
    above = [re.sub(r"(\d),(\d)", r"\1.\2", line) for line in above]
    above = [f"# {line}" if _is_data(line.split()) else line for line in above]
    content = "\n".join([*above, clean.getvalue()]).encode()
    return _map_of_surface(io.BytesIO(content), unit, size, "asc", "")


def _map_of_surface(
    file: Path | io.BytesIO, unit: str, size: str, file_format: str, channel: str
) -> Map:
    """The map that SurfaceTopography reads."""
    surface, scales, reader = open_surface(file, unit, size, file_format, channel, dim=2)
    heights = np.ma.filled(surface.heights().astype(float), np.nan)
    if heights.shape[1] == 1:
        raise QuantityError(*_LINE_SCAN)
    sides = [one * scale for one, scale in zip(surface.physical_sizes, scales, strict=False)]
    return Map(scales[2] * heights, (sides[0], sides[1]), reader)


def open_surface(
    file: Path | io.BytesIO, unit: str, size: str, file_format: str, channel: str, dim: int = 1
) -> tuple[Any, Triple, str]:
    """What SurfaceTopography reads, the metres of its units along x, y, z, and how it was read."""
    try:
        from SurfaceTopography import open_topography
        from SurfaceTopography.IO import lookup_reader_by_format
    except ImportError as error:
        raise QuantityError(
            "needs the package SurfaceTopography, which is not installed",
            "install it: pip install 'fretwear[surfaces]'",
        ) from error
    if file_format not in ("", *lookup_reader_by_format):
        formats = listed(sorted(lookup_reader_by_format))
        raise QuantityError(f"has no reader for format: {file_format}", f"formats are {formats}")
    try:
        # The readers of some forty formats raise all sorts of errors.
        if isinstance(file, Path) and "x3p" in (file_format, file.suffix.lower()[1:]):
            file = _mended(file)
        with (
            warnings.catch_warnings(action="ignore"),
            open_topography(file, file_format or None) as reader,
        ):
            chosen = _channel(reader.channels, channel, lambda: reader.default_channel)
            if chosen.dim < dim:
                raise QuantityError(*_LINE_SCAN)
            own = (chosen.info.get("raw_metadata") or {}) if chosen.unit is None else {}
            lateral = chosen.unit or own.get("xunit") or ""
            sides, points = chosen.physical_sizes, chosen.nb_grid_pts
            if sides is None and chosen.dim == 2 and not size:
                rule = "does not say the lengths of its sides"
                raise QuantityError(rule, "add size: [900 um, 900 um] and unit: um")
            scales, named = scales_of((lateral, lateral, chosen.unit or ""), unit), {}
            if sides is None and chosen.dim == 2:
                asked = zip(_sides(size), scales, strict=False)
                named = {"physical_sizes": tuple(side / scale for side, scale in asked)}
            elif chosen.dim == 2:
                metres = [side * scale for side, scale in zip(sides, scales, strict=False)]
                _checked(metres, points, size)
            surface = chosen.topography(**named)
            return surface, scales, f"{reader.format()}, channel {chosen.name}"
    except QuantityError:
        raise
    except Exception as error:
        reason = re.sub(r"\s+", " ", str(error).strip())[:150] or type(error).__name__
        if type(error).__name__ == "CannotDetectFileFormat":
            reason = "no reader knows its format"
            if isinstance(file, Path) and file.suffix.lower() in (".gz", ".zip"):
                raise QuantityError(
                    "is an archive", "unpack it, and name the file in it"
                ) from error
        raise QuantityError(f"cannot be read as a topography: {reason}", _SAVE) from error


def _channel(channels: Sequence[Any], asked: str, default: Any) -> Any:
    """The channel with a number or a name, or the usual one."""
    if not channels:
        rule = "has no channel of heights"
        raise QuantityError(rule, "export the heights (topography), not a phase or an amplitude")
    names = [one.name for one in channels]
    if not asked:
        return default()
    if asked in names:
        return channels[names.index(asked)]
    if asked.isdecimal() and int(asked) < len(channels):
        return channels[int(asked)]
    there = listed(f"{number}: {name}" for number, name in enumerate(names))
    raise QuantityError(f"has no channel {asked} of heights", f"its channels are {there}")


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
