"""Readings of a scar, from texts and from the files of instruments."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fretwear.arrays import Array
from fretwear.results import X
from fretwear.units import BY_SI_UNIT, QuantityError
from fretwear_measured.files import Source, read_line, read_topography
from fretwear_measured.tables import Layout, read_text_table

_TEXTS = (".csv", ".txt", ".dat", ".asc", ".tsv", ".prn")
_FEWEST = 5
_POSITIONS = ("x", "y", "position", "distance", "lateral", "length")
_DEPTHS = ("depth", "wear")
_HEIGHTS = ("height", "z", "profile", "heights")
# A scar whose readings have the wrong sign is this many times deeper above its base line.
_WRONG_WAY = 3.0


def profile_of(
    file: Source, layout: Layout, unit: str | None, along: str, line: float | None
) -> tuple[Array, Array]:
    """Positions and depths of a profile, m; `QuantityError` says why a file cannot be used."""
    path = Path(file.path)
    if path.suffix.lower() in _TEXTS:
        table, example = read_text_table(path, layout), "such as x (um),depth (um)"
        x, _ = table.column(0, _POSITIONS, BY_SI_UNIT["m"], example)
        depth, name = table.column(1, (*_DEPTHS, *_HEIGHTS), BY_SI_UNIT["m"], example)
        depth = -depth if any(word in name.split() for word in _HEIGHTS) else depth
    else:
        x, depth = _line_of_instrument(file, unit, along, line)
    there = np.isfinite(x) & np.isfinite(depth)
    x, depth = x[there], depth[there]
    if x.size < _FEWEST:
        raise QuantityError(f"has {x.size} readings; at least {_FEWEST} are needed")
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
        raise QuantityError(rule, "name the column height if it holds heights")
    return x, depth


def _line_of_instrument(
    file: Source, unit: str | None, along: str, line: float | None
) -> tuple[Array, Array]:
    """Positions and depths along a line scan, or along a line of a map of heights, m."""
    if (scan := read_line(file, unit)) is not None:
        return scan[0], -scan[1]
    surface = read_topography(file, "none", unit=unit)
    is_x = along == X.name
    heights, x, across = (
        (surface.heights, surface.x, surface.y)
        if is_x
        else (surface.heights.T, surface.y, surface.x)
    )
    place = 0.0 if line is None else line - 0.5 * (across[-1] - across[0])
    if abs(place) > abs(across[-1]) * (1.0 + 1e-9):
        raise QuantityError(f"has no line at {line:g} m: it is {2 * across[-1]:g} m wide")
    return x, -heights[:, int(abs(across - place).argmin())]
