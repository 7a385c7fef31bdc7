"""Readings of a measurement, from texts and from the files of instruments: scars and loops."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np

from fretwear.arrays import Array
from fretwear.results import X
from fretwear.units import BY_SI_UNIT, QuantityError, listed
from fretwear_measured.files import Source, read_line, read_topography
from fretwear_measured.tables import Layout, read_text_table

_TEXTS = (".csv", ".txt", ".dat", ".asc", ".tsv", ".prn")
_FEWEST = 5
_NARROWEST, _FARTHEST, _LARGEST_FORCE = 1e-12, 1e2, 1e9  # m, m, N or N/m
_POSITIONS = ("x", "y", "position", "distance", "lateral", "length")
_DEPTHS = ("depth", "wear")
_HEIGHTS = ("height", "z", "profile", "heights")
_DISPLACEMENTS = ("displacement", "position", "stroke", "x")
_FORCES = ("force", "friction", "q", "fx", "load")
# A scar whose readings have the wrong sign is this many times deeper above its base line.
_WRONG_WAY = 3.0
_DISORDER = 0.1  # of the displacement of a loop, by which noise may go back


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
    _check_sizes(x, depth, _FARTHEST)
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


def recording_of(path: Path, layout: Layout, force_unit: str) -> tuple[Array, Array]:
    """Displacements, m, and forces, N or N/m, of a recording of loops."""
    if path.suffix.lower() not in _TEXTS:
        raise QuantityError(f"must be a text, with the ending {listed(_TEXTS, 'or')}")
    table, force_is = read_text_table(path, layout), BY_SI_UNIT[force_unit]
    example = f"such as displacement (um),force ({force_is.example.split()[-1]})"
    x, _ = table.column(0, _DISPLACEMENTS, BY_SI_UNIT["m"], example)
    force, _ = table.column(1, _FORCES, force_is, example)
    there = np.isfinite(x) & np.isfinite(force)
    _check_sizes(x[there], force[there], _LARGEST_FORCE)
    return x[there], force[there]


def _check_sizes(x: Array, values: Array, most: float) -> None:
    if x.size < _FEWEST:
        raise QuantityError(f"has {x.size} readings; at least {_FEWEST} are needed")
    if np.abs(x).max() > _FARTHEST or np.abs(values).max() > most:
        raise QuantityError("has values that no scar has", "check the units of its columns")
    if np.ptp(x) < _NARROWEST:
        raise QuantityError(f"is {np.ptp(x):g} m wide", "check the units of its columns")


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


def cycles_of(x: Array) -> list[slice]:
    """The complete cycles of a recorded displacement, from one rise through its mean to the next.

    A hysteresis of a quarter of the amplitude ignores noise at the mean.
    """
    middle, reach = 0.5 * (x.max() + x.min()), 0.125 * np.ptp(x)
    side = np.where(x > middle + reach, 1, np.where(x < middle - reach, -1, 0))
    places = np.flatnonzero(side)
    rises = places[1:][(side[places[1:]] > 0) & (side[places[:-1]] < 0)]
    return [slice(start, end) for start, end in pairwise(rises)]


def last_loop(x: Array, force: Array) -> tuple[Array, Array]:
    """The last complete loop of a recording, from its largest displacement on, as it dissipates."""
    if len(cycles := cycles_of(x)) > 1:
        x, force = x[cycles[-1]], force[cycles[-1]]
    if float(force @ (np.roll(x, -1) - np.roll(x, 1))) < 0.0:
        x, force = x[::-1], force[::-1]
    begin = int(x.argmax())
    x, force = np.roll(x, -begin), np.roll(force, -begin)
    down, up = np.split(x, [int(x.argmin()) + 1])
    back = (
        (down - np.minimum.accumulate(down)).max(),
        (np.maximum.accumulate(up) - up).max(initial=0),
    )
    if max(back) > _DISORDER * np.ptp(x):
        rule = "is not one loop: its displacement does not fall and rise once"
        raise QuantityError(rule, "give the readings of one cycle, one after the other")
    return x, force
