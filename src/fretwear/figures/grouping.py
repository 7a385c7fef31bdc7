"""Lay out the points of a study, however many names it varies, in panels that can be read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from fretwear.figures.datasets import missing_variable

Array = NDArray[np.float64]
Value = Any
"""A value of a parameter: a float, or a string such as a slip model's name."""

MOST_ROWS, MOST_PANELS_ACROSS, MOST_STYLES, MOST_COLORS = 5, 4, 4, 60
MOST_KEYED_COLORS = 8
_BOOKKEEPING = {"case_id", "point", "status", "id"}
_PREFERRED_STYLE = ("plastic_limit", "slip_model")
_PREFERRED_COLOR = ("roughness_amplitude", "roughness")


@dataclass(frozen=True)
class Line:
    """One point of a study: its place, its varied values and one quantity over the cycles."""

    point: Mapping[str, int]
    values: Mapping[str, Value]
    cycles: Array
    quantity: Array


@dataclass(frozen=True)
class Layout:
    """Which varied names make rows, panels across, colours and line styles of a figure.

    Parameters
    ----------
    rows, across : tuple of str
        Names whose combinations make the rows, and the panels of a row.
    color, style : str or None
        Name told by colour, and by line style.
    followers : tuple of str
        Names whose value is told by that of the colour's name, as in paired lists.
    levels : mapping of str to tuple
        The values of each name that the figure shows, in the study's order.
    thinned : mapping of str to int
        How many values a name has, for names of which only some are shown.
    """

    rows: tuple[str, ...] = ()
    across: tuple[str, ...] = ()
    color: str | None = None
    style: str | None = None
    followers: tuple[str, ...] = ()
    levels: Mapping[str, tuple[Value, ...]] = field(default_factory=dict)
    thinned: Mapping[str, int] = field(default_factory=dict)

    def row_values(self) -> list[dict[str, Value]]:
        """Return the values that each row stands for."""
        return _combinations(self.rows, self.levels)

    def across_values(self) -> list[dict[str, Value]]:
        """Return the values that each panel of a row stands for."""
        return _combinations(self.across, self.levels)

    def index(self, name: str | None, line: Line) -> int:
        """Return the place of a line's value among those shown of `name`, 0 for no name."""
        return 0 if name is None else self.levels[name].index(line.values[name])


def study_lines(summary: xr.Dataset, variable: str) -> list[Line]:
    """Return one line per finished point of a merged study.

    Parameters
    ----------
    summary : xarray.Dataset
        A merged study (varied names, then ``cycle``; or ``point``, ``cycle``), the dataset of one
        case, or the history of one case (``step``, with ``cycle`` a variable).
    variable : str
        A quantity that depends on the cycle, such as ``wear_volume``.

    Raises
    ------
    ValueError
        When the dataset lacks the quantity.
    """
    if variable not in summary:
        raise missing_variable(summary, variable)
    along = "step" if "step" in summary[variable].dims else "cycle"
    table = summary[variable].transpose(..., along)
    dims = [str(dim) for dim in table.dims[:-1]]
    cycles = summary["cycle"].values.astype(np.float64)
    parameters = _parameters(summary, dims)
    quantities = table.values.astype(np.float64)
    lines = []
    for place in np.argwhere(np.isfinite(quantities).any(axis=-1)).tolist():
        index = tuple(place)
        values = {name: column[tuple(index[i] for i in axes)] for name, axes, column in parameters}
        point = dict(zip(dims, index, strict=True))
        lines.append(Line(point, values, cycles, quantities[index]))
    return lines


def choose_layout(lines: Sequence[Line]) -> Layout:
    """Choose panels, colours and line styles for the names that the lines vary.

    Colour tells the roughness amplitude or, if that is fixed, the name with most values; the line
    style the plastic limit or another name with few values, unless many lines crowd a panel; the
    remaining names make panels. Of a name with more values than can be shown, some are left out,
    evenly.
    """
    levels = _levels(lines)
    names, followers = _independent(
        [name for name, values in levels.items() if len(values) > 1], levels, lines
    )
    crowded = any(len(levels[name]) > MOST_KEYED_COLORS for name in names)
    style = None if crowded else _style_name(names, levels)
    rest = [name for name in names if name != style]
    color = _color_name(rest, levels)
    facets = [name for name in rest if name != color]
    rows, across = (facets[:1], facets[1:2]) if len(facets) > 1 else ([], facets)
    extra = {name: (levels[name][-1],) for name in facets[2:]}
    shown = {**levels, **_thinned(levels, rows, across, color), **extra}
    missing = {n: len(levels[n]) for n in names if len(shown[n]) < len(levels[n])}
    told = tuple(follower for follower, leader in followers.items() if leader == color)
    return Layout(tuple(rows), tuple(across), color, style, told, shown, missing)


def shown_lines(lines: Sequence[Line], layout: Layout) -> list[Line]:
    """Return the lines all of whose values the layout shows."""
    encoded = {*layout.rows, *layout.across, layout.color, layout.style, *layout.thinned} - {None}
    return [
        line
        for line in lines
        if all(line.values[name] in layout.levels[name] for name in encoded if name is not None)
    ]


def _parameters(
    summary: xr.Dataset, dims: Sequence[str]
) -> list[tuple[str, tuple[int, ...], NDArray[Any]]]:
    """Return name, places of its dimensions among `dims`, and values of each varied name."""
    found = []
    for name, coordinate in summary.coords.items():
        along = [str(dim) for dim in coordinate.dims]
        if name in _BOOKKEEPING or not along or not set(along) <= set(dims):
            continue
        is_text = coordinate.dtype.kind in "OUS"
        values = coordinate.values.astype(str if is_text else np.float64).astype(object)
        found.append((str(name), tuple(dims.index(dim) for dim in along), values))
    return found


def _levels(lines: Sequence[Line]) -> dict[str, tuple[Value, ...]]:
    levels: dict[str, dict[Value, None]] = {}
    for line in lines:
        for name, value in line.values.items():
            levels.setdefault(name, {})[value] = None
    return {name: tuple(values) for name, values in levels.items()}


def _style_name(names: Sequence[str], levels: Mapping[str, tuple[Value, ...]]) -> str | None:
    if len(names) < 2:
        return None
    few = [name for name in names if len(levels[name]) <= MOST_STYLES]
    preferred = [name for name in _PREFERRED_STYLE if name in few]
    if preferred:
        return preferred[0]
    others = [name for name in few if name not in _PREFERRED_COLOR]
    return min(others, key=lambda name: len(levels[name]), default=None)


def _color_name(names: Sequence[str], levels: Mapping[str, tuple[Value, ...]]) -> str | None:
    preferred = [name for name in _PREFERRED_COLOR if name in names]
    return preferred[0] if preferred else max(names, key=lambda n: len(levels[n]), default=None)


def _independent(
    names: Sequence[str], levels: Mapping[str, tuple[Value, ...]], lines: Sequence[Line]
) -> tuple[list[str], dict[str, str]]:
    """Part the names into those that vary on their own, and those that another one tells."""
    kept: list[str] = []
    followers: dict[str, str] = {}
    for name in names:
        leader = next(
            (
                other
                for other in kept
                if _tells(other, name, lines) and _can_tell(levels[other], levels[name])
            ),
            None,
        )
        if leader is None:
            kept.append(name)
        else:
            followers[name] = leader
    return kept, followers


def _can_tell(leader: tuple[Value, ...], name: tuple[Value, ...]) -> bool:
    """Tell whether a reader can read one name off another: not few values off a colour bar."""
    return len(leader) <= MOST_KEYED_COLORS or len(name) > MOST_STYLES


def _tells(leader: str, name: str, lines: Sequence[Line]) -> bool:
    pairs = {(line.values[leader], line.values[name]) for line in lines}
    return len(pairs) == len({first for first, _ in pairs})


def _thinned(
    levels: Mapping[str, tuple[Value, ...]],
    rows: Sequence[str],
    across: Sequence[str],
    color: str | None,
) -> dict[str, tuple[Value, ...]]:
    limits = dict.fromkeys(rows, MOST_ROWS) | dict.fromkeys(across, MOST_PANELS_ACROSS)
    if not rows:
        limits |= dict.fromkeys(across, MOST_ROWS * MOST_PANELS_ACROSS)
    if color is not None:
        limits[color] = MOST_COLORS
    return {name: _evenly(levels[name], most) for name, most in limits.items()}


def _evenly(values: tuple[Value, ...], most: int) -> tuple[Value, ...]:
    if len(values) <= most:
        return values
    picks = np.unique(np.linspace(0, len(values) - 1, most).round().astype(int))
    return tuple(values[index] for index in picks)


def _combinations(
    names: Sequence[str], levels: Mapping[str, tuple[Value, ...]]
) -> list[dict[str, Value]]:
    return [
        dict(zip(names, values, strict=True)) for values in product(*(levels[n] for n in names))
    ]
