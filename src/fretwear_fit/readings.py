"""Readings of a measurement, from texts and from the files of instruments: scars and loops."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fretwear.arrays import Array
from fretwear.mechanics.surfaces.files import read_line, read_topography
from fretwear.tables import read_text_table
from fretwear.units import BY_SI_UNIT, QuantityError, listed
from fretwear.vocabulary import X

if TYPE_CHECKING:
    from fretwear_fit.request import Measurement

_TEXTS = (".csv", ".txt", ".dat", ".asc", ".tsv")
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


def readings_of(about: Measurement) -> tuple[Array, Array]:
    """Positions and depths of a profile, m, or displacements, m, and forces, N, of a loop.

    `QuantityError` says why a file cannot be used.
    """
    assert about.file is not None
    path = Path(about.file.path)
    if about.is_loop:
        if path.suffix.lower() not in _TEXTS:
            raise QuantityError(f"must be a text, with the ending {listed(_TEXTS, 'or')}")
        return last_loop(*_loop_columns(path, about))
    is_text = path.suffix.lower() in _TEXTS
    x, depth = _profile_columns(path, about) if is_text else _line_of_instrument(about)
    there = np.isfinite(x) & np.isfinite(depth)
    x, depth = x[there], depth[there]
    _check_sizes(x, depth, _FARTHEST)
    if (np.diff(x) < 0.0).all():
        x, depth = x[::-1], depth[::-1]
    for place, (before, after) in enumerate(pairwise(x), start=2):
        if after == before:
            raise QuantityError(f"has the position {after:g} m twice, at reading {place}")
        if after < before:
            rule = f"is not sorted: reading {place} goes back to x = {after:g} m"
            raise QuantityError(rule, "give the readings of one line in order")
    if not np.ptp(depth) and about.noise is None:
        rule = "is flat: it shows no wear"
        raise QuantityError(rule, "give its noise, such as noise: 50 nm, for an upper limit")
    ends = max(2, x.size // 10)
    flat = np.r_[0:ends, x.size - ends : x.size]
    over = depth - np.polyval(np.polyfit(x[flat], depth[flat], 1), x)
    if x.size >= 10 and -over.min() > _WRONG_WAY * max(over.max(), 1e-30):
        rule = "has the wrong sign: depths count downwards from the surface, and this scar rises"
        raise QuantityError(rule, "name the column height if it holds heights")
    return x, depth


def _profile_columns(path: Path, about: Measurement) -> tuple[Array, Array]:
    table, example = read_text_table(path, about.layout), "such as x (um),depth (um)"
    x, _ = table.column(0, _POSITIONS, BY_SI_UNIT["m"], example)
    depth, name = table.column(1, (*_DEPTHS, *_HEIGHTS), BY_SI_UNIT["m"], example)
    return x, -depth if any(word in name.split() for word in _HEIGHTS) else depth


def _loop_columns(path: Path, about: Measurement) -> tuple[Array, Array]:
    table = read_text_table(path, about.layout)
    force_is = BY_SI_UNIT[about.force_noise.si_unit if about.force_noise is not None else "N"]
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


def _line_of_instrument(about: Measurement) -> tuple[Array, Array]:
    """Positions and depths along a line scan, or along a line of a map of heights, m."""
    assert about.file is not None
    if (line := read_line(about.file, about.unit)) is not None:
        return line[0], -line[1]
    surface = read_topography(about.file, False, unit=about.unit)
    heights = surface.heights if about.along == X.name else surface.heights.T
    along, across = (surface.x, surface.y) if about.along == X.name else (surface.y, surface.x)
    place = 0.0 if about.line is None else about.line - 0.5 * (across[-1] - across[0])
    if abs(place) > abs(across[-1]) * (1.0 + 1e-9):
        raise QuantityError(f"has no line at {about.line:g} m: it is {2 * across[-1]:g} m wide")
    return along, -heights[:, int(abs(across - place).argmin())]


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
