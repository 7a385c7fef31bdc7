"""Effects of the parameters of a study: pairs of cases, maps, Sobol indices, regimes of slip."""

from __future__ import annotations

from collections.abc import Sequence
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
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, NullLocator

from fretwear.arrays import Array
from fretwear.data.effects import SEED, Points, sobol_indices
from fretwear.figures.axes import (
    ValueAxis,
    make_panels,
    outside_key,
    parameter_label,
)
from fretwear.figures.datasets import variable_of
from fretwear.figures.encoding import Coding, rounded
from fretwear.figures.maps import add_scale
from fretwear.figures.style import (
    CATEGORICAL,
    INK,
    MUTED,
    Columns,
    JournalFigure,
    caption,
    look,
    one_panel,
    place_label,
    sequential_colormap,
    styled,
)
from fretwear.study.parameters import parameter, symbol_text, value_text
from fretwear.units import (
    fixed_digits,
    in_unit,
    listed,
    number_text,
    readable_unit,
    with_unit,
)
from fretwear.vocabulary import HEADLINES, RESULTS

_ROW, _SOBOL_ROW, _HEAD = 44.0, 25.0, 16.0
_UNCHANGED = 5e-3
_MOST_TICKS = 7
_KEY_SIGNS = 75
_MOST_WRITTEN = 72
_MOST_MAPS = 6
_FEWEST = 16
# Distance of a level that is none from the last number, beyond the distance of neighbours.
_TO_NONE = 0.5
_LOGARITHMIC_FROM = 8.0

# Varied parameters that a fretting map may have besides the load.
WAYS = ("displacement_amplitude", "displacement_ratio")
_REGIMES = {
    "partial slip": ("o", CATEGORICAL[0]),
    "mixed": ("D", CATEGORICAL[5]),
    "gross slip": ("s", CATEGORICAL[1]),
}
_LARGEST, _SMALLEST = 14.0, 2.5
_APART = 0.7
"""Widest dot over the distance of neighbours; at this ratio diamonds touch."""


@styled
def effects(
    points: Points, quantities: Sequence[str] = HEADLINES, *, columns: Columns = 2
) -> JournalFigure:
    """Draw final results of a study, each over the two parameters that change it most.

    The first is on the x axis, the colour shows the second; a line is the median over all other
    parameters, a faint band their range. The points of a sampled study are dots. Results that are
    the same in all cases, or that no case has, are left out.
    """
    names = [name for name in quantities if is_changing(points, name)]
    titles, heights = [""] * len(names), (4.0, _ROW)
    figure, panels = make_panels(columns, titles, columns, heights, "none", "none")
    ordered = [name for name in points.levels if name != SEED]
    way = "the parameter that changes it most"
    if len(ordered) == 1:
        words = parameter(ordered[0]).words
        way = words if "'s " in words else f"the {words}"
    if any(len(points.leading(name)) > 1 for name in names):
        way = "the two parameters that change it most: one along the axis, the other by colour"
    what = f"{points.variables[names[0]].label} after the last cycle" if len(names) == 1 else ""
    caption(figure, f"{what or 'Final results, each'} over {way}.")
    for axes, name in zip(panels, names, strict=True):
        _draw_effect(axes, points, name)
    same = [RESULTS[n].words for n in quantities if n in points.results and n not in names]
    if same:
        caption(figure, f"Equal in all cases, so not drawn: {listed(same)}.")
    return figure


def is_changing(points: Points, result: str) -> bool:
    """Whether a final result differs between the cases of a study."""
    values = points.results.get(result, np.array([]))
    finite = values[np.isfinite(values)]
    return bool(finite.size and np.ptp(finite) > _UNCHANGED * np.abs(finite).max())


def _draw_effect(axes: Axes, points: Points, name: str) -> None:
    axis, shown, _ = _coloured(points, name)
    first, second = [*points.leading(name), None][:2]
    assert first is not None
    if second and np.isinf(_numbers(points, first)).any():
        # A line needs numbers.
        first, second = second, first
    is_paired = bool(points.lines[first])
    levels = points.levels[second] if second else ("",)
    coding = Coding(second, levels)
    group = points.place(second) if second else np.zeros(len(shown), dtype=int)
    x, seen = _places(points, first), list[int]()
    # A limit that is none is no number, to which a line could rise from the largest.
    is_none = np.isinf(_numbers(points, first))
    for place in range(len(levels)):
        here = (group == place) & np.isfinite(shown)
        if not here.any():
            continue
        seen.append(place)
        color, mark = coding.colors[place], coding.mark(place)
        if not is_paired:
            axes.plot(x[here], shown[here], mark, ms=2.5, color=color, label="_points")
            continue
        rows = [here & (points.place(first) == level) for level in range(len(is_none))]
        kept = [level for level, row in enumerate(rows) if row.any()]
        at = _level_places(points, first)
        table = np.array([np.percentile(shown[rows[level]], (0, 50, 100)) for level in kept])
        for part in (False, True):
            inside = [row for row, level in enumerate(kept) if is_none[level] == part]
            where, (low, middle, high) = at[kept][inside], table[inside].T
            axes.plot(where, middle, color=color, marker=mark, ms=3.0, lw=1.0, label="_median")
            if (high > low).any():
                edge = 2.0 if len(inside) == 1 else 0.0
                band = axes.fill_between(where, low, high, color=color, alpha=0.15, lw=edge)
                band.set_label("_band")
                others = points.levels.keys() - {first, second}
                over = "the seeds" if others == {SEED} else "all other parameters"
                caption(axes, f"Lines: median over {over}; bands: their range.")
    axis.set_limits(axes, np.ones(len(points.ids)), points.results[name])
    axes.set_title(axis.label, fontsize=7.0, pad=13.0 if second else 4.0)
    axes.yaxis.set_minor_locator(NullLocator())
    if is_none.any() and is_paired:
        caption(axes, "The level “none” stands apart.")
    if is_paired:
        texts = [value_text(first, level) for level in points.levels[first]]
        at = _level_places(points, first)
        few = np.unique(np.linspace(0, len(at) - 1, min(_MOST_TICKS, len(at))).round()).astype(int)
        axes.set_xticks(at[few], [texts[place] for place in few], fontsize=6.0)
        axes.set_xlim(-0.25, at[-1] + 0.25)
        axes.set_xlabel(parameter(first).words)
    else:
        axes.set_xlabel(parameter_label(first))
        axes.margins(x=0.04)
        _scale(axes.xaxis, x)
    if second:
        handles, texts = coding.key(seen)
        if sum(len(text) + 4 for text in texts) > _KEY_SIGNS:
            # The ramp of colours says the rest.
            handles, texts = handles[:: len(handles) - 1], texts[:: len(texts) - 1]
            caption(axes, "Keys of many values show only the first and the last.")
        for handle in handles if not is_paired else ():
            handle.set_linestyle("none")
        options: dict[str, float] = {"columnspacing": 0.9, "handlelength": 1.2, "fontsize": 6.0}
        key = axes.legend(handles, texts, ncols=len(texts), loc="lower left", **options)
        key.set_bbox_to_anchor((-0.02, 0.97))


def _places(points: Points, varied: str) -> Array:
    """Return the positions of the points on the axis of a parameter: its values or levels."""
    if points.lines[varied] or varied not in points.parameters:
        return _level_places(points, varied)[points.place(varied)]
    return np.asarray(parameter(varied).unit.of(points.parameters[varied]))


def _level_places(points: Points, varied: str) -> Array:
    """Return where the levels of a parameter stand, evenly; none is farther off."""
    return np.arange(len(points.levels[varied])) + _TO_NONE * np.isinf(_numbers(points, varied))


def _numbers(points: Points, varied: str) -> Array:
    """Return the levels of a parameter, zero where they are no numbers."""
    levels = points.levels[varied]
    return np.array([0.0 if isinstance(level, str) else float(level) for level in levels])


def _scale(axis: Axis, values: Array) -> None:
    """Make an axis logarithmic if its values span a wide range."""
    if values.min() > 0.0 and values.max() > _LOGARITHMIC_FROM * values.min():
        (axis.axes.set_xscale if axis is axis.axes.xaxis else axis.axes.set_yscale)("log")
        wide = values.max() > _LOGARITHMIC_FROM**3 * values.min()
        axis.set_major_locator(LogLocator(subs=(1.0,) if wide else (1.0, 2.0, 5.0)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: number_text(value, 2)))
        axis.set_minor_formatter(NullFormatter())


def _coloured(points: Points, quantity: str) -> tuple[ValueAxis, Array, Normalize]:
    """Return the axis of a final result, its values in the unit of the axis, and their colours."""
    values = points.results[quantity]
    axis = ValueAxis(points.variables[quantity], values[np.isfinite(values)])
    shown = axis.unit.of(values)
    return axis, shown, axis.colours(shown)


@styled
def effect_map(points: Points) -> Figure:
    """Draw the final wear volume of a grid as a heat map over the two parameters with most values.

    Each combination of the other parameters, up to 6 of them, has a panel.
    """
    names = sorted(points.levels, key=lambda name: -len(points.levels[name]))[:2]
    # Rows, then columns, in the order of the study.
    down, across = sorted(names, key=list(points.levels).index)
    others = [name for name in points.levels if name not in names]
    keys = np.stack([points.place(name) for name in others] or [0 * points.place(down)], axis=1)
    panels = list(dict.fromkeys(map(tuple, keys.tolist())))
    few = np.linspace(0, len(panels) - 1, min(_MOST_MAPS, len(panels))).astype(int)
    titles = {
        panels[at]: ", ".join(
            symbol_text(name, points.levels[name][i])
            for name, i in zip(others, panels[at], strict=False)
        )
        for at in few
    }
    axis, shown, norm = _coloured(points, "wear_volume")
    columns = min(3, len(few))
    figure, grid = make_panels(2 if columns > 1 else 1, [*titles.values()], columns, (14.0, 62.0))
    label = points.variables["wear_volume"].label
    caption(figure, f"{label} after the last cycle over the two parameters with most values.")
    for axes, key in zip(grid, titles, strict=True):
        inside = (keys == key).all(axis=1)
        table = np.full([len(points.levels[name]) for name in (down, across)], np.nan)
        table[points.place(down)[inside], points.place(across)[inside]] = shown[inside]
        axes.imshow(table, origin="lower", aspect="auto", norm=norm, cmap=sequential_colormap())
        for (row, column), value in np.ndenumerate(table):
            if np.isfinite(value) and table.size <= _MOST_WRITTEN:
                color, text = "white" if norm(value) > 0.35 else INK, fixed_digits(value, 3)
                axes.text(column, row, text, color=color, fontsize=5.0, ha="center", va="center")
        for name, axis_of in ((across, axes.xaxis), (down, axes.yaxis)):
            texts = [value_text(name, level) for level in points.levels[name]]
            axis_of.set_label_text(parameter(name).words)
            axis_of.set_ticks(range(len(texts)), texts, fontsize=5.5)
        axes.tick_params(axis="x", rotation=30 if len(points.levels[across]) > 4 else 0)
    add_scale(figure, grid, ScalarMappable(norm, sequential_colormap()), axis.label)
    return figure


@styled
def sensitivity(points: Points, quantities: Sequence[str]) -> Figure:
    """Draw the Sobol indices of results of a sample, and how they settle with more points.

    On the left are the indices of each parameter alone (full) and with its interactions (open),
    with 95 % intervals; on the right, if there are enough points, the indices with interactions
    against the number of points.
    """
    counts = [n for n in (len(points.ids) // k for k in (8, 4, 2, 1)) if n >= _FEWEST]
    settles = len(counts) > 1
    figure = JournalFigure(2, _HEAD + 8.0 + _SOBOL_ROW * len(quantities))
    caption(
        figure,
        "Sobol indices of final results: each parameter alone (full marks) and with its "
        "interactions (open), with 95 % intervals from the covariance of the emulator's "
        "coefficients.",
    )
    if settles:
        caption(figure, "Right: the indices with interactions against the number of points.")
    grid = figure.subplots(len(quantities), 1 + settles, squeeze=False, sharex="col")
    about = [parameter(name) for name in points.levels]
    looks = [look(place) for place in range(len(about))]
    for (bars, *others), name in zip(grid, quantities, strict=True):
        indices, values = points.indices[name], points.results[name][:, None]
        values = np.log(values) if indices.of_logarithm else values
        settled = [sobol_indices(points.unit[:n], values[:n], points.sizes)[0] for n in counts]
        for place, (color, mark) in enumerate(looks):
            for at, middle, (low, high), fill in (
                (place - 0.2, indices.first, indices.first_range, "full"),
                (place + 0.2, indices.total, indices.total_range, "none"),
            ):
                bars.plot([at] * 2, [low[place], high[place]], color=color, lw=1.0)
                bars.plot(at, middle[place], mark, color=color, fillstyle=fill, markersize=4.0)
            for curves in others:
                curves.plot(counts, [fit.total[place] for fit in settled], marker=mark, color=color)
        bars.axhline(0.0, color=MUTED, lw=0.5)
        title = points.variables[name].label + ", logarithm" * indices.of_logarithm
        bars.set_title(title, fontsize=6.5)
        bars.set(xlim=(-0.6, len(looks) - 0.4), ylim=(-0.03, 1.03))
        for curves in others:
            curves.set(ylim=(-0.03, 1.03))
            curves.set_xscale("log", base=2)
            curves.set_xticks(counts, [str(count) for count in counts])
    grid[-1, 0].set_xticks(range(len(about)), [varied.symbol for varied in about])
    if settles:
        grid[-1, 1].set_xlabel("number of points")
    figure.supylabel("Sobol index", fontsize=7.5)
    handles = [Line2D([], [], color=color, marker=mark) for color, mark in looks]
    outside_key(figure, handles, [f"{varied.symbol}  {varied.words}" for varied in about])
    return figure


@styled
def scatter_matrix(points: Points) -> Figure:
    """Draw the points of a sample over every two parameters, coloured by the final wear volume.

    The lowest row has the wear volume itself against each parameter.
    """
    axis, shown, norm = _coloured(points, "wear_volume")
    columns = {name: _places(points, name) for name in points.levels}
    # The first row has the second parameter over the first, the last row the result over all.
    rows = [(place, "\n".join(wrap(parameter_label(name), 18))) for name, place in columns.items()]
    rows = [*rows[1:], (shown, axis.wrapped_label)]
    figure, words = JournalFigure(2, _HEAD + 36.0 * len(rows)), axis.variable.words
    caption(figure, "All points over each pair of parameters; last row: the result against each.")
    caption(figure, f"Colours show the final {words}.")
    grid = figure.subplots(len(rows), len(rows), sharex="col", sharey="row", squeeze=False)
    dots = {"s": 5.0, "c": shown, "cmap": sequential_colormap(), "norm": norm, "lw": 0}
    for number, (panels, (values, label)) in enumerate(zip(grid, rows, strict=True), 1):
        for axes, across in zip(panels[:number], columns.values(), strict=False):
            axes.scatter(across, values, **dots)
            axes.margins(0.06)
        for axes in panels[number:]:
            axes.remove()
        if values is not shown:
            _scale(panels[0].yaxis, values)
        elif axis.is_logarithmic:
            panels[0].set_yscale("log")
        panels[0].set_ylabel(label, fontsize=6.0)
        place_label(panels[0].yaxis)
    for axes, (name, values) in zip(grid[-1], columns.items(), strict=True):
        _scale(axes.xaxis, values)
        axes.set_xlabel(parameter_label(name), fontsize=6.0)
    add_scale(figure, list(grid[-1]), ScalarMappable(norm, sequential_colormap()), axis.label)
    return figure


@styled
def parallel_coordinates(points: Points) -> Figure:
    """Draw every point of a study as a line over its parameters, coloured by the final wear volume.

    Each parameter, and the wear volume, has an axis from its lowest to its highest value.
    """
    axis, shown, norm = _coloured(points, "wear_volume")
    rows = np.argsort(shown)
    rows = rows[np.isfinite(shown[rows]) & (shown[rows] > 0.0 if axis.is_logarithmic else True)]
    columns = [
        _scaled(points.parameters.get(n, points.place(n).astype(np.float64))) for n in points.levels
    ]
    figure, result = JournalFigure(2, 70.0), axis.variable.words
    caption(figure, f"Every point as a line over its parameters; its colour is the final {result}.")
    axes = figure.subplots()
    places = range(len(columns) + 1)
    table = np.column_stack([*columns, norm(shown)])[rows]
    paths = [np.column_stack([places, row]) for row in table]
    tints = sequential_colormap()(norm(shown[rows]))
    axes.add_collection(LineCollection(paths, colors=tints, linewidths=0.7))
    ends = [tuple(value_text(n, rounded(v[i])) for i in (0, -1)) for n, v in points.levels.items()]
    ends.append(tuple(fixed_digits(shown[rows[i]], 3) for i in (0, -1)))
    for place, (bottom, top) in enumerate(ends):
        axes.axvline(place, color=MUTED, lw=0.6)
        axes.text(place, -0.03, bottom, ha="center", va="top", fontsize=6.0)
        axes.text(place, 1.03, top, ha="center", va="bottom", fontsize=6.0)
    axes.set(xlim=(-0.3, places[-1] + 0.3), ylim=(-0.12, 1.12), yticks=[])
    words = [parameter(name).words for name in points.levels]
    axes.set_xticks(places, [*words, axis.label], fontsize=6.5)
    axes.tick_params(axis="x", length=0)
    axes.spines[:].set_visible(False)
    return figure


def _scaled(values: Array) -> Array:
    """Return values scaled to 0 to 1, by their logarithm if the range is wide; infinite ones 1."""
    finite = values[np.isfinite(values)]
    if finite.min() > 0.0 and finite.max() > _LOGARITHMIC_FROM * finite.min():
        values, finite = np.log(values), np.log(finite)
    spread = float(np.ptp(finite)) or 1.0
    top = 0.9 if finite.size < values.size else 1.0
    return np.where(np.isfinite(values), top * (values - finite.min()) / spread, 1.0)


@styled
def fretting_map(summary: xr.Dataset, *, ax: Axes | None = None) -> Figure:
    """Draw the regime of sliding over load and displacement; dots grow with the wear volume.

    `summary` is a merged study that varies the load and the displacement amplitude or ratio; other
    varied parameters are shown at their first value. Slip that is partial in some snapshots and
    gross in others is mixed. The width of a dot is proportional to the cube root of the wear
    volume.
    """
    across = next(name for name in WAYS if name in summary["status"].dims)
    rest = {n: 0 for n in summary["status"].dims if n not in ("normal_load", across)}
    shown = summary.isel(rest).transpose("normal_load", across, ...)
    gross = shown["regime"].mean("cycle", skipna=True).values
    volume = shown["wear_volume"].max("cycle").values
    force = in_unit(1.0, shown["normal_load"].attrs.get("units", ""))
    figure, axes = one_panel(1, 66.0, ax)
    caption(figure, "Fretting map: the regime of slip over load and displacement.")
    caption(figure, "Dots grow with the wear volume.")
    axes.set(xscale="log", yscale="log")
    places = []
    for name, axis, like in (
        (across, axes.xaxis, 1.0),
        ("normal_load", axes.yaxis, force),
    ):
        places.append(parameter(name).suiting(like).unit.of(shown[name].values))
        axis.set_ticks(places[-1], [f"{value:g}" for value in places[-1]])
        axis.set_ticks([], minor=True)
        label = parameter_label(name, like)
        axis.set_label_text(label[:1].upper() + label[1:])
    way, load = np.meshgrid(*places)
    kinds = np.where(gross == 0.0, "partial slip", np.where(gross == 1.0, "gross slip", "mixed"))
    dots = []
    for regime, (marker, color) in _REGIMES.items():
        here = (kinds == regime) & np.isfinite(gross)
        if here.any():
            drawn = axes.scatter(way[here], load[here], color=color, marker=marker, linewidths=0.0)
            drawn.set_label(regime)
            dots.append((drawn, here))
            if regime == "mixed":
                caption(figure, "Mixed slip is partial in some snapshots and gross in others.")
    axes.margins(0.12)
    key = axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), title="Regime")
    for handle in key.legend_handles:
        handle.set_sizes([30.0])  # type: ignore[union-attr]
    worn, greatest = variable_of(shown, "wear_volume"), float(np.nanmax(volume))
    unit = readable_unit(volume, worn.si_unit)
    largest = with_unit(f"{unit.of(greatest):.3g}", unit)
    note = f"width of dots: cube root of {worn.words}, largest {largest}"
    axes.set_title(note, fontsize="small", loc="left")
    # The distance of neighbours follows once the axes are laid out.
    figure.draw_without_rendering()
    pixels = axes.transData.transform(np.column_stack([way.ravel(), load.ravel()]))
    x, y = (along.reshape(way.shape) * 72.0 / figure.dpi for along in pixels.T)
    steps = np.abs([*np.diff(x[0]), *np.diff(y[:, 0])])
    widest = min(_LARGEST, _APART * float(steps.min(initial=np.inf)))
    widths = np.maximum(widest * np.cbrt(volume / greatest), _SMALLEST)
    for collection, here in dots:
        collection.set_sizes(widths[here] ** 2)
    return figure
