"""Profiles of scars, from tables and from the files of instruments."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fretwear.arrays import Array
from fretwear.results import X
from fretwear.units import BY_SI_UNIT, QuantityError
from fretwear_measured.files import Source, read_line, read_topography
from fretwear_measured.maps import POSITION_AND_HEIGHT
from fretwear_measured.tables import TABLES, Layout, Sought, Table, has_word, open_table

_FEWEST = 5
_NARROWEST, _FARTHEST, LARGEST_FORCE = 1e-12, 1e2, 1e9  # m, m, N or N/m
_DEPTH, _HEIGHT = "depth tiefe wear", "height heights z höhe profile vertical"
_METRE = BY_SI_UNIT["m"]
_POSITION = Sought(_METRE, ("x position distance lateral length abstand", "y"), "z vertical")
_WORN = Sought(_METRE, ("depth tiefe height heights z höhe", "wear profile vertical"))
_PAIR = (
    Sought(_METRE, ("before initial unworn vorher pre",), "x position distance"),
    Sought(_METRE, ("after final worn nachher post",), "unworn x position distance"),
)
# A scar whose readings have the wrong sign is this many times deeper above its base line.
_WRONG_WAY = 3.0


def profile_of(
    file: Source, layout: Layout, unit: str | None, along: str, line: float | None
) -> tuple[Array, Array, str]:
    """Positions and depths of a profile, m, and what they were taken from.

    Heights or depths before and after the test, in two columns, give their difference.
    `QuantityError` says why a file cannot be used.
    """
    path = Path(file.path)
    table = open_table(path, layout) if path.suffix.lower() in TABLES else None
    if table is not None and not _is_map(table):
        example = "such as x (um),depth (um)"
        is_pair = all(map(table.ranked, _PAIR)) or len(layout.columns or ()) > 2
        sought = [_POSITION, *(_PAIR if is_pair else [_WORN])]
        table = table.aligned(table.choose(sought, example))
        numbers, (x, *parts) = table.read(sought, example)
        name = table.names[numbers[-1]] if table.names else ""
        is_height = not has_word(name, _DEPTH) and (is_pair or has_word(name, _HEIGHT))
        depth = (parts[-1] - parts[0] if is_pair else parts[0]) * (-1.0 if is_height else 1.0)
        origin = f"positions from {table.label(numbers[0])}, {'heights' if is_height else 'depths'}"
        origin += f" from {' less '.join(table.label(n) for n in numbers[:0:-1])}"
        origin += f"; {table.note}" if table.note else ""
    else:
        is_height, unit = True, unit or ", ".join(layout.units or ())
        scan = None if table else read_line(file, unit)
        x, depth = (scan[0], -scan[1]) if scan else _line_of_map(file, unit, along, line)
        origin = "a line of an instrument"
    there = np.isfinite(x) & np.isfinite(depth)
    if missing := int((~there).sum()):
        origin += f"; {missing} of {there.size} readings are missing"
    x, depth = x[there], depth[there]
    check_sizes(x, depth, _FARTHEST)
    if (np.diff(x) < 0.0).all():
        x, depth = x[::-1], depth[::-1]
    if (wrong := np.flatnonzero(np.diff(x) <= 0.0)).size:
        rule = f"is not sorted: reading {wrong[0] + 2} is not beyond x = {x[wrong[0]]:g} m"
        raise QuantityError(rule, "give the readings of one line in order, each place once")
    ends = max(2, x.size // 10)
    flat = np.r_[0:ends, x.size - ends : x.size]
    over = depth - np.polyval(np.polyfit(x[flat], depth[flat], 1), x)
    if x.size >= 10 and -over.min() > _WRONG_WAY * max(over.max(), 1e-30):
        rule = "has the wrong sign: depths count downwards from the surface, and this scar rises"
        kind = "depth" if is_height else "height"
        raise QuantityError(rule, f"name the column {kind} if it holds {kind}s")
    return x, depth, origin


def check_sizes(x: Array, values: Array, most: float) -> None:
    """Refuse too few readings, and values that a wrong unit makes of them."""
    if x.size < _FEWEST:
        raise QuantityError(f"has {x.size} readings; at least {_FEWEST} are needed")
    if np.abs(x).max() > _FARTHEST or np.abs(values).max() > most:
        raise QuantityError("has values that no scar has", "check the units of its columns")
    if np.ptp(x) < _NARROWEST:
        raise QuantityError(f"is {np.ptp(x):g} m wide", "check the units of its columns")


def _is_map(table: Table) -> bool:
    """Whether a table has heights over x and y, at several y."""
    found = [*map(table.ranked, POSITION_AND_HEIGHT)]
    if table.layout.columns or not all(found) or len({*map(tuple, found)}) < len(found):
        return False
    return np.unique(table.values[:, min(found[1])]).size > 1


def _line_of_map(file: Source, unit: str, along: str, line: float | None) -> tuple[Array, Array]:
    """Positions and depths along a line of a map of heights, m."""
    surface = read_topography(file, "none", unit=unit)
    is_x = along == X.name
    # What was not measured is no reading, although the map is filled there.
    heights = np.where(surface.measured, surface.heights, np.nan)
    heights, x, across = (
        (heights, surface.x, surface.y) if is_x else (heights.T, surface.y, surface.x)
    )
    place = 0.0 if line is None else line - 0.5 * (across[-1] - across[0])
    if abs(place) > abs(across[-1]) * (1.0 + 1e-9):
        raise QuantityError(f"has no line at {line:g} m: it is {2 * across[-1]:g} m wide")
    return x, -heights[:, int(abs(across - place).argmin())]
