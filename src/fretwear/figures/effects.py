"""What the parameters of a study do to its results: all pairs, heat maps, Sobol indices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from textwrap import wrap

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, NullFormatter, NullLocator

from fretwear.data.effects import (
    GOOD,
    SEED,
    Array,
    Indices,
    Points,
    is_sampled,
    result_indices,
    sobol_indices,
    unit_points,
)
from fretwear.figures.axes import (
    MOST_WITH_MINOR_TICKS,
    ValueAxis,
    label_outer,
    make_panels,
    outside_key,
    parameter_label,
)
from fretwear.figures.maps import add_scale
from fretwear.figures.style import (
    CATEGORICAL,
    INK,
    MARKERS,
    MUTED,
    JournalFigure,
    look,
    place_label,
    sequential_colormap,
    sequential_colours,
    styled,
)
from fretwear.study.parameters import parameter, symbol_text, value_text
from fretwear.units import fixed_digits, number_text
from fretwear.vocabulary import HEADLINES

_ROW, _HEAD = 25.0, 16.0
_MOST_TICKS = 7
_MOST_WRITTEN = 72
_MOST_MAPS = 6
_DENSE = 150
_FEWEST = 16


@styled
def effects(summary: xr.Dataset, quantities: Sequence[str] = HEADLINES) -> Figure:
    """Draw final results of a merged study, a row each, against every parameter, a column each.

    A thin line joins cases that differ in this parameter alone; its colour tells the value of the
    other parameter on which the change depends most. The points of a sampled study and seeds,
    which have no order, have no such lines: these are scatter plots. Results that no case has, or
    that are zero in all, are left out. It is a `ValueError` when no parameter is varied, or no
    point is done.
    """
    points = Points.of(summary)
    names = [n for n in quantities if np.nan_to_num(points.results.get(n, 0.0)).any()]
    if not points.levels or not names:
        raise ValueError("There are no two cases to compare: the study varies nothing.")
    down, across = len(names), len(points.levels)
    figure = JournalFigure(2 if across > 2 else 1, _HEAD + _ROW * down)
    grid = figure.subplots(down, across, sharex="col", sharey="row", squeeze=False)
    dividers = {
        (name, varied): points.effect(varied, name).divider if points.lines[varied] else None
        for name in names
        for varied in points.levels
    }
    # No two levels of the parameters that part lines look alike, as long as there are colours
    # enough; a parameter beyond that has a ramp of colours and no marks.
    looks: dict[tuple[str | None, int], tuple[str, str]] = {}
    taken = 0
    for parting in filter(None, dict.fromkeys(dividers.values())):
        count = len(points.levels[parting])
        pairs = list(zip(CATEGORICAL, MARKERS, strict=False))[taken : taken + count]
        if len(pairs) == count:
            taken += count
        else:
            pairs = [(color, "") for color in sequential_colours(count)]
        looks |= {(parting, place): pair for place, pair in enumerate(pairs)}
    for row, name in zip(grid, names, strict=True):
        results = points.results[name]
        axis = ValueAxis.of(points.variables[name], results[np.isfinite(results)])
        for axes, varied in zip(row, points.levels, strict=True):
            divider = dividers[name, varied]
            _draw_effect(axes, points, varied, axis.unit.of(results), divider, looks)
        axis.set_limits(row[0], np.ones(len(points.ids)), results)
        row[0].set_ylabel(axis.wrapped_label, fontsize=6.0)
        place_label(row[0].yaxis)
        for axes in row if down * across > MOST_WITH_MINOR_TICKS else ():
            axes.yaxis.set_minor_locator(NullLocator())
    for axes, varied in zip(grid[-1], points.levels, strict=True):
        if not points.lines[varied] and varied in points.parameters:
            axes.set_xlabel(parameter_label(varied))
            _scale(axes.xaxis, points.parameters[varied])
            continue
        levels = points.levels[varied]
        axes.set_xlabel(parameter(varied).words)
        axes.set_xlim(-0.25, len(levels) - 0.75)
        shown = np.unique(np.linspace(0, len(levels) - 1, min(_MOST_TICKS, len(levels))).round())
        texts = [value_text(varied, levels[int(place)]) for place in shown]
        axes.set_xticks(shown, texts, fontsize=5.5, rotation=30 if sum(map(len, texts)) > 26 else 0)
    label_outer(list(grid.flat), across)
    keyed = {level: pair for level, pair in looks.items() if pair[1]}
    if keyed:
        handles = [Line2D([], [], color=color, marker=mark) for color, mark in keyed.values()]
        texts = [symbol_text(str(n), points.levels[str(n)][level]) for n, level in keyed]
        outside_key(figure, handles, texts)
    return figure


def _draw_effect(
    axes: Axes,
    points: Points,
    varied: str,
    values: Array,
    divider: str | None,
    looks: Mapping[tuple[str | None, int], tuple[str, str]],
) -> None:
    x, lines = _places(points, varied), points.lines[varied]
    # What a seed does is chance: a line would look like a trend.
    if not lines or varied == SEED:
        axes.plot(x, values, ".", markersize=2.5, color=CATEGORICAL[0])
        axes.margins(x=0.06)
        return
    place = points.place(divider).tolist() if divider else [0] * len(x)
    look_of = [looks.get((divider, each), (MUTED, ".")) for each in place]
    for color, mark in dict.fromkeys(look_of):
        of = np.array([each == (color, mark) for each in look_of])
        # One path with gaps: thousands of lines are drawn in the time of a few.
        rows = [row for line in lines if of[line[0]] for row in (*line, -1)]
        path_x, path_y = (np.append(each, np.nan)[rows] for each in (x, values))
        axes.plot(path_x, path_y, color=color, lw=0.7, alpha=0.8, label="_lines")
        if len(x) <= _DENSE:
            axes.plot(x[of], values[of], mark or ".", markersize=2.0, color=color, label="_points")
    if divider and not looks[divider, 0][1]:
        low, high = (value_text(divider, points.levels[divider][end]) for end in (0, -1))
        told = f"light: {parameter(divider).symbol} = {low}, dark: {high}"
        axes.set_title(told, fontsize=5.0, pad=2.0)


def _places(points: Points, varied: str) -> Array:
    """Return where the points stand on the axis of a parameter: its value, or its place."""
    if points.lines[varied] or varied not in points.parameters:
        return points.place(varied).astype(np.float64)
    return np.asarray(parameter(varied).unit.of(points.parameters[varied]))


def _scale(axis: Axis, values: Array) -> None:
    """Make an axis of values logarithmic where these span much."""
    if (values > 0.0).all() and values.max() > 8.0 * values.min():
        (axis.axes.set_xscale if axis is axis.axes.xaxis else axis.axes.set_yscale)("log")
        axis.set_major_formatter(FuncFormatter(lambda value, _: number_text(value, 2)))
        axis.set_minor_formatter(NullFormatter())


@styled
def effect_map(summary: xr.Dataset, quantity: str = "wear_volume") -> Figure:
    """Draw a final result as a heat map over the two parameters with most values.

    There is a panel for each combination of the other parameters, of at most 6 of them. It is a
    `ValueError` when the merged study does not vary two parameters in a grid, or no point is done.
    """
    points = Points.of(summary)
    by_length = sorted(points.levels, key=lambda name: -len(points.levels[name]))
    if len(by_length) < 2 or not all(points.lines[name] for name in by_length[:2]):
        raise ValueError("A heat map needs two parameters whose values are combined.")
    # Columns, then rows, in the order of the study.
    down, across = sorted(by_length[:2], key=list(points.levels).index)
    others = [name for name in points.levels if name not in (down, across)]
    keys = list(zip(*(points.place(name).tolist() for name in others), strict=True))
    panels = list(dict.fromkeys(keys)) or [()]
    few = np.linspace(0, len(panels) - 1, min(_MOST_MAPS, len(panels))).astype(int)
    panels = [panels[place] for place in few]
    axis, shown, norm = _coloured(points, quantity)
    columns = min(3, len(panels))
    figure, grid = make_panels(2 if columns > 1 else 1, len(panels), columns, (14.0, 62.0))
    for axes, key in zip(grid, panels, strict=True):
        table = np.full((len(points.levels[down]), len(points.levels[across])), np.nan)
        inside = [row for row, each in enumerate(keys) if each == key] if others else slice(None)
        where = points.place(down)[inside], points.place(across)[inside]
        table[where] = shown[inside]
        axes.imshow(table, origin="lower", aspect="auto", norm=norm, cmap=sequential_colormap())
        is_written = np.isfinite(table) & (table.size <= _MOST_WRITTEN)
        for (row, column), value in np.ndenumerate(table):
            if is_written[row, column]:
                color, text = "white" if norm(value) > 0.35 else INK, fixed_digits(value, 3)
                axes.text(column, row, text, color=color, fontsize=5.0, ha="center", va="center")
        held = zip(others, key, strict=True)
        axes.set_title(", ".join(symbol_text(name, points.levels[name][i]) for name, i in held))
        for name, set_ticks, label in (
            (across, axes.set_xticks, axes.set_xlabel),
            (down, axes.set_yticks, axes.set_ylabel),
        ):
            texts = [value_text(name, level) for level in points.levels[name]]
            set_ticks(range(len(texts)), texts, fontsize=5.5)
            label(parameter(name).words)
        axes.tick_params(axis="x", rotation=30 if len(points.levels[across]) > 4 else 0)
    label_outer(grid, columns)
    add_scale(figure, grid, ScalarMappable(norm, sequential_colormap()), axis.label)
    return figure


@styled
def sensitivity(summary: xr.Dataset, quantities: Sequence[str] = HEADLINES) -> Figure:
    """Draw the Sobol indices of a sampled study, and how they settle with the number of points.

    Left are the indices of each parameter alone (full) and with its interactions (open) with 95 %
    intervals; right, the latter against the number of points. Results whose emulator predicts less
    than 90 % of the variance are left out. It is a `ValueError` when the points were not drawn, or
    no emulator is good enough.
    """
    if not is_sampled(summary):
        raise ValueError("Sobol indices are those of a sampled study; this one lists its values.")
    points, (unit, sizes) = Points.of(summary), unit_points(summary)
    found = result_indices(summary)
    good = {n: found[n] for n in quantities if n in found and found[n].quality >= GOOD}
    if not good:
        raise ValueError("The points are too few for Sobol indices: no emulator is good enough.")
    figure = JournalFigure(2, _HEAD + 8.0 + _ROW * len(good))
    grid = figure.subplots(len(good), 2, squeeze=False, sharex="col", width_ratios=(1.0, 1.0))
    counts = [count for count in (len(unit) // k for k in (8, 4, 2, 1)) if count >= _FEWEST]
    for (bars, curves), (name, indices) in zip(grid, good.items(), strict=True):
        _draw_bars(bars, indices)
        bars.set_title(
            points.variables[name].label + (", logarithm" * indices.of_logarithm), fontsize=6.5
        )
        values = points.results[name]
        values = np.log(values) if indices.of_logarithm else values
        settled = [sobol_indices(unit[:n], values[:n, None], sizes)[0].total for n in counts]
        for place, total in enumerate(np.transpose(settled)):
            color, mark = look(place)
            curves.plot(counts, total, marker=mark, color=color)
        curves.set_ylim(-0.03, 1.03)
        curves.set_xscale("log", base=2)
        curves.set_xticks(counts, [str(count) for count in counts])
    grid[-1, 0].set_xticks(range(len(points.levels)), [parameter(n).symbol for n in points.levels])
    grid[-1, 1].set_xlabel("number of points")
    figure.supylabel("Sobol index", fontsize=7.5)
    words = [f"{parameter(n).symbol}  {parameter(n).words}" for n in points.levels]
    looks = map(look, range(len(words)))
    handles = [Line2D([], [], color=color, marker=mark) for color, mark in looks]
    outside_key(figure, handles, words)
    return figure


def _draw_bars(axes: Axes, indices: Indices) -> None:
    for offset, values, ends, fill in (
        (-0.2, indices.first, indices.first_range, "full"),
        (0.2, indices.total, indices.total_range, "none"),
    ):
        for place, (value, low, high) in enumerate(zip(values, *ends, strict=True)):
            color, mark = look(place)
            axes.plot([place + offset] * 2, [low, high], color=color, lw=1.0)
            axes.plot(place + offset, value, mark, color=color, fillstyle=fill, markersize=4.0)
    axes.axhline(0.0, color=MUTED, lw=0.5)
    axes.set_ylim(-0.03, 1.03)
    axes.set_xlim(-0.6, len(indices.first) - 0.4)


@styled
def scatter_matrix(summary: xr.Dataset, quantity: str = "wear_volume") -> Figure:
    """Draw the points of a sampled study over every two parameters, coloured by a final result.

    The lowest row has the result itself against each parameter. It is a `ValueError` when fewer
    than two parameters are varied, or no point is done.
    """
    points = Points.of(summary)
    names = list(points.levels)
    if len(names) < 2:
        raise ValueError("A scatter matrix needs two varied parameters or more.")
    axis, shown, norm = _coloured(points, quantity)
    columns = {name: _places(points, name) for name in names}
    labels = {name: "\n".join(wrap(parameter_label(name), 18)) for name in names}
    figure = JournalFigure(2, _HEAD + 36.0 * len(names))
    grid = figure.subplots(len(names), len(names), sharex="col", sharey="row", squeeze=False)
    dots = {"s": 5.0, "c": shown, "cmap": sequential_colormap(), "norm": norm, "lw": 0}
    # The first row has the second parameter over the first, the last the result over all.
    for number, (row, name) in enumerate(zip(grid, [*names[1:], None], strict=True), 1):
        values = columns[name] if name else shown
        for axes, across in zip(row[:number], names, strict=False):
            axes.scatter(columns[across], values, **dots)
            axes.margins(0.06)
        for axes in row[number:]:
            axes.remove()
        if name:
            _scale(row[0].yaxis, values)
        else:
            row[0].set_yscale("log" if axis.is_logarithmic else "linear")
        row[0].set_ylabel(labels[name] if name else axis.wrapped_label, fontsize=6.0)
        place_label(row[0].yaxis)
    for axes, name in zip(grid[-1], names, strict=True):
        _scale(axes.xaxis, columns[name])
        axes.set_xlabel(parameter_label(name), fontsize=6.0)
    add_scale(figure, list(grid[-1]), ScalarMappable(norm, sequential_colormap()), axis.label)
    return figure


def _coloured(points: Points, quantity: str) -> tuple[ValueAxis, Array, Normalize]:
    """Return the axis of a final result, its values in the unit of that, and their colours."""
    values = points.results[quantity]
    axis = ValueAxis.of(points.variables[quantity], values[np.isfinite(values)])
    shown = axis.unit.of(values)
    return axis, shown, axis.colours(shown)


@styled
def parallel_coordinates(summary: xr.Dataset, quantity: str = "wear_volume") -> Figure:
    """Draw every point of a study as a line over its parameters, its colour the final result.

    Each parameter has an axis from its lowest to its highest value, and so has the result.
    """
    points = Points.of(summary)
    axis, shown, norm = _coloured(points, quantity)
    known = np.isfinite(shown) & (shown > 0.0 if axis.is_logarithmic else True)
    columns = [
        _scaled(points.parameters.get(n, points.place(n).astype(np.float64))) for n in points.levels
    ]
    columns.append(np.asarray(norm(shown), dtype=np.float64))
    table = np.column_stack(columns)[known]
    order = np.argsort(shown[known])
    figure = JournalFigure(2, 70.0)
    axes = figure.subplots()
    places = np.arange(table.shape[1])
    paths = [np.column_stack([places, row]) for row in table[order]]
    tints = sequential_colormap()(norm(shown[known][order]))
    axes.add_collection(LineCollection(paths, colors=tints, linewidths=0.7))
    ends = [tuple(value_text(n, v[i]) for i in (0, -1)) for n, v in points.levels.items()]
    low, *_, high = shown[known][order]
    ends.append((fixed_digits(low, 3), fixed_digits(high, 3)))
    for place, (bottom, top) in enumerate(ends):
        axes.axvline(place, color=MUTED, lw=0.6)
        axes.text(place, -0.03, bottom, ha="center", va="top", fontsize=6.0)
        axes.text(place, 1.03, top, ha="center", va="bottom", fontsize=6.0)
    axes.set(xlim=(-0.3, places[-1] + 0.3), ylim=(-0.12, 1.12))
    words = [parameter(name).words for name in points.levels]
    axes.set_xticks(places, [*words, axis.label], fontsize=6.5)
    axes.tick_params(axis="x", length=0)
    axes.set_yticks([])
    axes.spines[:].set_visible(False)
    return figure


def _scaled(values: Array) -> Array:
    """Return values from 0 to 1, evenly in the logarithm where they span much; infinite ones 1."""
    known = np.asarray(values, dtype=np.float64)
    finite = known[np.isfinite(known)]
    if finite.min() > 0.0 and finite.max() > 8.0 * finite.min():
        known, finite = np.log(known), np.log(finite)
    spread = float(finite.max() - finite.min()) or 1.0
    top = 0.9 if finite.size < known.size else 1.0
    return np.where(np.isfinite(known), top * (known - finite.min()) / spread, 1.0)
