"""The points of a study as lines: panels, colours and styles of all, and a few for profiles."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from fretwear.data.effects import rank_correlations
from fretwear.figures.datasets import require, with_cycles
from fretwear.study.parameters import symbol_text, words_text
from fretwear.units import in_unit
from fretwear.vocabulary import CASE_ID, POINT, STATUS

Array = NDArray[np.float64]
Value = Any
"""A value of a parameter: a float, or a string such as a slip model's name."""
Levels = Mapping[str, tuple[Value, ...]]
"""The different values of each varied name, in the study's order."""

_MOST_ROWS, _MOST_PANELS_ACROSS, _MOST_STYLES, _MOST_COLORS, _MOST_KEYED = 3, 3, 4, 60, 8
_BOOKKEEPING = {CASE_ID.name, POINT.name, STATUS.name, "id"}
_PREFERRED_STYLE = ("plastic_limit", "slip_model")
_PREFERRED_COLOR = ("roughness_amplitude", "roughness")
_PREFERRED_CONTRASTS = (*_PREFERRED_COLOR, *_PREFERRED_STYLE)
_MOST_CONTRASTS = 2
_MOST_NAMED = 8
# Slip that disregards the worn shape is for comparison: where there is another, it is not shown.
_SIMPLIFIED = ("slip_model", "cattaneo_mindlin")


@dataclass(frozen=True)
class Line:
    """One point of a study: its place, its varied values and one quantity over the cycles.

    `cycles` and `quantity` are of every step where these are known, else of the snapshots, which
    are `marks` of shape (2, k): cycles and values; none of a history alone. A mean over seeds has
    the standard `deviation` of the quantity.
    """

    point: Mapping[str, int]
    values: Mapping[str, Value]
    cycles: Array
    quantity: Array
    marks: Array
    deviation: Array | None = None


def study_lines(
    summary: xr.Dataset, variable: str, history: xr.Dataset | None = None
) -> list[Line]:
    """Return one line per finished point of a study, of a quantity such as ``wear_volume``.

    The dataset is a merged study (varied names, then ``cycle``; or ``point``, ``cycle``), that of
    one case, or the history of either (…, ``step``, with ``cycle`` a variable). Its `history`
    gives the lines every step. It is a `ValueError` when it lacks the quantity.
    """
    require(summary, variable)
    summary = with_cycles(summary)
    dims = [str(dim) for dim in summary[variable].dims if dim not in ("cycle", "step")]
    steps = summary if history is None or variable not in history else history
    (cycles, quantities), (dense_cycles, dense) = (
        _over_cycles(each, variable, dims) for each in (summary, steps)
    )
    columns: dict[str, tuple[list[str], NDArray[Any]]] = {}
    for name, coordinate in summary.coords.items():
        along = [str(dim) for dim in coordinate.dims]
        if name not in _BOOKKEEPING and along and set(along) <= set(dims):
            units = coordinate.attrs.get("units", "")
            column = np.empty(coordinate.shape, dtype=object)
            column.ravel()[:] = [in_unit(v, units) for v in coordinate.values.ravel().tolist()]
            columns[str(name)] = along, column
    lines = []
    for at in map(tuple, np.argwhere(np.isfinite(quantities).any(axis=-1)).tolist()):
        point = dict(zip(dims, at, strict=True))
        values = {
            n: column[tuple(point[d] for d in along)] for n, (along, column) in columns.items()
        }
        marks = np.stack([cycles[at], quantities[at]])[:, np.isfinite(quantities[at])]
        marks = marks if "cycle" in summary.dims else marks[:, :0]
        known = np.isfinite(dense[at])
        lines.append(Line(point, values, dense_cycles[at][known], dense[at][known], marks))
    return lines


def means_over(dim: str, lines: Sequence[Line], summary: xr.Dataset) -> list[Line]:
    """Return the means and deviations of the lines that differ along a dimension alone.

    They are taken at every cycle of any of them, between steps along straight lines. What varies
    along the dimension is no value of theirs.
    """
    groups: dict[tuple[tuple[str, int], ...], list[Line]] = {}
    for line in lines:
        point = tuple(place for place in line.point.items() if place[0] != dim)
        groups.setdefault(point, []).append(line)
    kept = [name for name in lines[0].values if dim not in summary[name].dims]
    means = []
    for point, group in groups.items():
        cycles = np.unique(np.concatenate([line.cycles for line in group]))
        marked = np.unique(np.concatenate([line.marks[0] for line in group]))
        values = np.stack([np.interp(cycles, line.cycles, line.quantity) for line in group])
        mean = values.mean(axis=0)
        deviation = values.std(axis=0, ddof=1) if len(group) > 1 else None
        marks = np.stack([marked, np.interp(marked, cycles, mean)])
        known = {name: group[0].values[name] for name in kept}
        means.append(Line(dict(point), known, cycles, mean, marks, deviation))
    return means


def _over_cycles(dataset: xr.Dataset, variable: str, dims: Sequence[str]) -> tuple[Array, Array]:
    """Return the cycles and the values of each point, the cycles along the last axis."""
    values = dataset[variable].transpose(*dims, ...)
    cycles = dataset["cycle"].broadcast_like(values).transpose(*values.dims)
    return cycles.values.astype(np.float64), values.values.astype(np.float64)


@dataclass(frozen=True)
class Layout:
    """Which varied names make rows, panels across, colours and line styles of a figure.

    The value of `paired` names is told by that of the colour's name, as in paired lists. `levels`
    are the values that the figure shows of each name; of those of which it shows only some,
    `thinned` has how many there are.
    """

    rows: tuple[str, ...] = ()
    across: tuple[str, ...] = ()
    color: str | None = None
    style: str | None = None
    paired: tuple[str, ...] = ()
    levels: Levels = field(default_factory=dict)
    thinned: Mapping[str, int] = field(default_factory=dict)

    @property
    def is_keyed(self) -> bool:
        """Whether the colours are few enough for a key, without a bar of colours."""
        return self.color is None or len(self.levels[self.color]) <= _MOST_KEYED

    def panels(self, most_across: int) -> tuple[list[dict[str, Value]], int]:
        """Return the values that each panel stands for, row by row, and the panels in a row."""
        names = (*self.rows, *self.across)
        combinations = product(*(self.levels[name] for name in names))
        panels = [dict(zip(names, values, strict=True)) for values in combinations]
        across = math.prod(len(self.levels[name]) for name in self.across)
        return panels, across if self.rows else min(across, most_across)

    def index(self, name: str | None, line: Line) -> int:
        """Return the place of a line's value among those shown of `name`, 0 for no name."""
        return 0 if name is None else self.levels[name].index(line.values[name])


def choose_layout(lines: Sequence[Line]) -> Layout:
    """Choose panels, colours and line styles for the names that the lines vary.

    Colour tells the roughness amplitude or, if that is fixed, the name with most values; the line
    style the plastic limit or another name with few values, unless many lines crowd a panel; the
    remaining names make panels. Of a name with more values than can be shown, some are left out,
    evenly.
    """
    levels = _levels(lines)
    names, told_by = _independent(levels, lines)
    style = None
    if len(names) > 1 and all(len(levels[name]) <= _MOST_KEYED for name in names):
        few = [name for name in names if len(levels[name]) <= _MOST_STYLES]
        others = (name for name in few if name not in _PREFERRED_COLOR)
        fewest = min(others, key=lambda name: len(levels[name]), default=None)
        style = _first_of(_PREFERRED_STYLE, few) or fewest
    rest = [name for name in names if name != style]
    finest = max(rest, key=lambda name: len(levels[name]), default=None)
    color = _telling(levels, lines) or _first_of(_PREFERRED_COLOR, rest) or finest
    if color not in rest and color is not None:  # each of them tells the others
        rest, style = [color], None
    facets = [name for name in rest if name != color]
    rows, facets = (facets[:1], facets[1:]) if len(facets) > 1 else ([], facets)
    across, held = facets[:1], facets[1:]
    most: dict[str | None, int] = {color: _MOST_COLORS}
    most |= dict.fromkeys(rows, _MOST_ROWS)
    most |= dict.fromkeys(across, _MOST_PANELS_ACROSS * (1 if rows else _MOST_ROWS))
    shown = dict(levels)
    for name, values in levels.items():
        if len(values) > most.get(name, math.inf):
            picks = np.linspace(0, len(values) - 1, most[name]).round().astype(int)
            shown[name] = tuple(values[index] for index in np.unique(picks))
    shown |= {name: (levels[name][-1],) for name in held}
    thinned = {n: len(levels[n]) for n in names if len(shown[n]) < len(levels[n])}
    paired = tuple(name for name, leader in told_by.items() if leader == color)
    return Layout(tuple(rows), tuple(across), color, style, paired, shown, thinned)


def shown_lines(lines: Sequence[Line], layout: Layout) -> list[Line]:
    """Return the lines all of whose values the layout shows."""
    return [
        line
        for line in lines
        if all(line.values[name] in layout.levels[name] for name in layout.thinned)
    ]


def _levels(lines: Sequence[Line]) -> dict[str, tuple[Value, ...]]:
    names = lines[0].values if lines else ()
    return {name: tuple(dict.fromkeys(line.values[name] for line in lines)) for name in names}


def _telling(levels: Levels, lines: Sequence[Line]) -> str | None:
    """Return the name that explains most of points drawn at random: by rank correlation."""
    drawn = [
        name
        for name, values in levels.items()
        if len(values) > max(_MOST_KEYED, 0.9 * len(lines))
        and not any(isinstance(value, str) for value in values)
    ]
    if len(drawn) < 2:
        return None
    last = np.array([[line.quantity[-1]] for line in lines])
    drawn_values = np.array([[line.values[name] for name in drawn] for line in lines], dtype=float)
    correlations = np.abs(rank_correlations(drawn_values, last))[:, 0]
    return drawn[int(np.argmax(np.nan_to_num(correlations)))]


def _first_of(preferred: Sequence[str], names: Sequence[str]) -> str | None:
    return next((name for name in preferred if name in names), None)


def _independent(levels: Levels, lines: Sequence[Line]) -> tuple[list[str], dict[str, str]]:
    """Part the varied names into those that vary on their own, and those that another one tells."""
    kept: list[str] = []
    told_by: dict[str, str] = {}
    for name in (name for name, values in levels.items() if len(values) > 1):
        for other in kept:
            pairs = {(line.values[other], line.values[name]) for line in lines}
            # A colour bar is no use for a few values.
            readable = len(levels[other]) <= _MOST_KEYED or len(levels[name]) > _MOST_STYLES
            if readable and len(pairs) == len(levels[other]):
                told_by[name] = other
                break
        else:
            kept.append(name)
    return kept, told_by


@dataclass(frozen=True)
class RepresentativeCases:
    """Cases that differ in the names of `contrasts` and agree, where possible, in the others.

    `ids` are the case ids by title, as ``smooth, elastic``; a single case has none. `common` says
    in words which values of the study's other varied names all of them have, and `left_out` in a
    sentence, which begins with a space, which values in between none of them has.
    """

    contrasts: tuple[str, ...]
    ids: dict[str, str]
    common: str
    left_out: str


def representative_cases(summary: xr.Dataset) -> RepresentativeCases:
    """Return up to four finished cases of a merged study, reproducibly.

    They span the extremes of roughness amplitude and plastic limit, or of the first two other
    names if the study does not vary these. All other names have their last value for which all
    of the cases are done, or as many as possible; the slip model is that of the worn shape. Points
    drawn at random have no others alike: of them those of least and most wear are taken. It is a
    `ValueError` when no point is done.
    """
    lines = study_lines(summary, "wear_volume")
    if not lines:
        raise ValueError("No point of the study is done: there is no case to choose.")
    levels = _levels(lines)
    varied = [name for name, values in levels.items() if len(values) > 1]
    preferred = [name for name in _PREFERRED_CONTRASTS if name in varied]
    contrasts = tuple(dict.fromkeys([*preferred, *varied]))[:_MOST_CONTRASTS]
    others = [name for name in varied if name not in contrasts]
    extremes: dict[str, tuple[Value, Value]] = {}
    groups: dict[tuple[Value, ...], list[Line]] = {}
    for name in contrasts:
        is_text = any(isinstance(value, str) for value in levels[name])
        ordered = levels[name] if is_text else sorted(levels[name])
        extremes[name] = ordered[0], ordered[-1]
    for line in lines:
        if all(line.values[name] in extremes[name] for name in contrasts):
            groups.setdefault(tuple(line.values[name] for name in others), []).append(line)
    slip, simplified = _SIMPLIFIED
    best = max(
        reversed(list(groups.values())),
        key=lambda group: (len(group), group[0].values.get(slip) != simplified),
        default=[],
    )
    if not best or len(best) == 1 < len(lines):
        by_wear = sorted(lines, key=lambda line: float(np.nanmax(line.quantity)))
        best = [by_wear[0], by_wear[-1]]
    titles = (", ".join(symbol_text(n, line.values[n]) for n in contrasts) for line in best)
    ids = (str(summary["case_id"].isel(line.point).item()) for line in best)
    shown = _levels(best)
    common = ", ".join(words_text(n, shown[n][0]) for n in others if len(shown[n]) == 1)
    missed = [words_text(n, v) for n in contrasts for v in levels[n] if v not in shown[n]]
    left_out = f" Not shown: {', '.join(missed)}." if missed else ""
    if len(missed) > _MOST_NAMED:
        left_out = f" These are {len(best)} of {len(lines)} cases."
    return RepresentativeCases(contrasts, dict(zip(titles, ids, strict=True)), common, left_out)
