"""Quantities against cycles, for one case or for all cases of a study."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, NullLocator

from fretwear.data.effects import LEAST_SEEDS, SEED
from fretwear.figures.axes import (
    ValueAxis,
    label_curves,
    label_outer,
    make_panels,
    outside_key,
    set_cycle_axis,
)
from fretwear.figures.datasets import check_dataset, variable_of
from fretwear.figures.lines import (
    MOST_KEYED_COLORS,
    MOST_MARKED_POINTS,
    Layout,
    Line,
    choose_layout,
    joined,
    shown_lines,
    study_lines,
)
from fretwear.figures.maps import add_scale
from fretwear.figures.style import (
    CATEGORICAL,
    INK,
    LINE_STYLES,
    MARKERS,
    Columns,
    JournalFigure,
    root_figure,
    sequential_colormap,
    sequential_colours,
    styled,
)
from fretwear.study.parameters import parameter, symbol_text
from fretwear.units import MICROMETRE, Unit
from fretwear.vocabulary import Variable

ZONES = {"contact": CATEGORICAL[0], "stick": INK}
"""The zones and their colours."""
HALF_WIDTH_LABEL = "Half-width along x (µm)"

_MOST_LABELLED_LINES = 6
_MOST_WITH_MINOR_TICKS = 4


def contact_half_width(
    dataset: xr.Dataset,
    history: xr.Dataset | None = None,
    *,
    columns: Columns = 2,
    ax: Axes | None = None,
) -> Figure:
    """Draw the contact half-width along x against the cycles.

    Parameters
    ----------
    dataset : xarray.Dataset
        A merged study or a part of it, the dataset of one case, or the history of one case.
        Points of a study that are not done (NaN) are left out.
    history : xarray.Dataset, optional
        The dense history of the study or case, from `fretwear.open_history`: curves go through
        every step, and marks are snapshots. Without it snapshots are joined by straight lines.
    columns : {1, 2}
        Journal columns that the figure spans, 90 mm or 190 mm.
    ax : matplotlib.axes.Axes, optional
        Where to draw, in a figure of your own, what takes one panel; `columns` then says nothing.

    Returns
    -------
    matplotlib.figure.Figure
        Half-width in µm over cycles; panels, colours and line styles are for what the study
        varies (`fretwear.figures.lines.choose_layout`).

    Raises
    ------
    TypeError
        When `dataset` is no dataset.
    ValueError
        When the quantity is missing, no point is done, or `ax` is given for more panels.
    """
    return draw_history(dataset, "contact_half_width_x", history, columns=columns, ax=ax)


def stick_half_width(
    dataset: xr.Dataset,
    history: xr.Dataset | None = None,
    *,
    columns: Columns = 2,
    ax: Axes | None = None,
) -> Figure:
    """Draw the stick zone's half-width along x against cycles, as `contact_half_width` does."""
    return draw_history(dataset, "stick_half_width_x", history, columns=columns, ax=ax)


def wear_volume(
    dataset: xr.Dataset,
    history: xr.Dataset | None = None,
    *,
    columns: Columns = 2,
    ax: Axes | None = None,
) -> Figure:
    """Draw the wear volume of both bodies against cycles, as `contact_half_width` does.

    Volumes that span more than a factor of 30 are on a logarithmic axis, which cycle 0, without
    wear, is not on.
    """
    return draw_history(dataset, "wear_volume", history, columns=columns, ax=ax)


def dissipated_energy(
    dataset: xr.Dataset,
    history: xr.Dataset | None = None,
    *,
    columns: Columns = 2,
    ax: Axes | None = None,
) -> Figure:
    """Draw the energy dissipated in one cycle against cycles, as `contact_half_width` does."""
    return draw_history(dataset, "dissipated_energy", history, columns=columns, ax=ax)


@styled
def draw_history(
    dataset: xr.Dataset,
    quantity: Variable | str,
    history: xr.Dataset | None = None,
    *,
    columns: Columns = 2,
    ax: Axes | None = None,
) -> Figure:
    """Draw any scalar over the cycles, as `contact_half_width` does."""
    check_dataset(dataset)
    variable = variable_of(dataset, quantity) if isinstance(quantity, str) else quantity
    ensemble = Ensemble.of(dataset, variable.name)
    if ensemble is not None:
        dataset, history = ensemble.mean, None
    lines = study_lines(dataset, variable.name, history)
    if not lines:
        raise ValueError(f"No point has a value of {variable.name}: there is nothing to draw.")
    layout = choose_layout(lines)
    lines = shown_lines(lines, layout)
    contents, across = layout.panels(4 if columns == 2 else 2)
    figure, panels = _frames(len(contents), across, columns, ax)
    cycles, values = joined(lines)
    axis = ValueAxis.of(variable, values[(cycles == 0.0) | (cycles >= 1.0)])
    palette = _Palette.of(layout)
    curves: list[Line2D] = []
    for index, (panel, facet) in enumerate(zip(panels, contents, strict=True)):
        own = _matching(lines, [facet])
        drawn = _draw_panel(panel, own, layout, palette, axis.unit)
        curves += drawn
        if ensemble is not None:
            for line, curve in zip(own, drawn, strict=True):
                ensemble.draw_band(panel, line, curve, axis.unit)
        panel.set_title(", ".join(symbol_text(name, value) for name, value in facet.items()))
        axis.set_cycles(panel, cycles, values)
        if len(panels) > _MOST_WITH_MINOR_TICKS:
            panel.xaxis.set_minor_locator(NullLocator())
        row = _matching(lines, contents[index : index + across])
        if index % across == 0 and row:
            axis.set_limits(panel, *joined(row))
            if len(panels) > _MOST_WITH_MINOR_TICKS:
                panel.yaxis.set_minor_locator(NullLocator())
    label_outer(panels, across)
    if len(panels) > 1:
        figure.supylabel(axis.label, fontsize=7.5)
    else:
        panels[0].set_ylabel(axis.label)
    if ensemble is not None:
        note = f"Lines are means of {ensemble.count} seeds, bands their standard deviation."
        figure.supxlabel(note, fontsize=7.0)
    few = len(panels) == 1 and 1 < len(lines) <= _MOST_LABELLED_LINES
    if few and layout.color and not layout.style:
        texts = _key_texts(layout, lines, layout.color)
        if label_curves(panels[0], curves, [texts[layout.index(layout.color, n)] for n in lines]):
            return figure
    _add_keys(figure, panels, layout, lines, palette, inside=ax is not None)
    return figure


@dataclass(frozen=True)
class Ensemble:
    """A study in which seeds are chance: the mean over them, and how far they are from it."""

    mean: xr.Dataset
    deviation: xr.DataArray
    count: int

    @classmethod
    def of(cls, dataset: xr.Dataset, name: str) -> Ensemble | None:
        """Return the ensemble of a merged study over some seeds; None for any other dataset."""
        values = dataset.get(name)
        if values is None or SEED not in values.dims or values.sizes[SEED] < LEAST_SEEDS:
            return None
        others = [each for each, about in dataset.variables.items() if SEED in about.dims]
        mean = dataset.drop_vars(others).assign({name: values.mean(SEED, keep_attrs=True)})
        mean[name] = mean[name].drop_vars([each for each in others if each in mean[name].coords])
        return cls(mean, values.std(SEED, ddof=1), values.sizes[SEED])

    def draw_band(self, panel: Axes, line: Line, curve: Line2D, unit: Unit) -> None:
        """Shade a standard deviation on both sides of a line."""
        deviation = self.deviation.isel(line.point).interp(cycle=line.cycles).values
        low, high = (unit.of(line.quantity + sign * deviation) for sign in (-1.0, 1.0))
        panel.fill_between(
            line.cycles, low, high, color=curve.get_color(), alpha=0.2, lw=0.0, label="_band"
        )


def _frames(
    count: int, across: int, columns: Columns, ax: Axes | None
) -> tuple[Figure, list[Axes]]:
    """Return the figure and its panels, or those that the caller gave."""
    if ax is None:
        down = -(-count // across)
        figure = JournalFigure(columns, 16.0 + (46.0 if down > 1 else 56.0) * down)
        return figure, make_panels(figure, count, across, "row")
    if count > 1:
        raise ValueError(
            f"This study takes {count} panels, which one axes does not hold: leave ax "
            "out, or select a part of the study first, for example with dataset.isel(...)."
        )
    return root_figure(ax), [ax]


@dataclass(frozen=True)
class _Palette:
    """The colours of a layout's levels, and how a bar of colours is scaled where there is one."""

    colors: tuple[Any, ...]
    norm: Normalize | None = None

    @classmethod
    def of(cls, layout: Layout) -> _Palette:
        levels = layout.levels[layout.color] if layout.color else ("",)
        if isinstance(levels[0], str):
            return cls(tuple(CATEGORICAL[i % len(CATEGORICAL)] for i in range(len(levels))))
        if len(levels) <= MOST_KEYED_COLORS:
            return cls(tuple(sequential_colours(len(levels))))
        values = np.asarray(levels, dtype=np.float64)
        finite = values[np.isfinite(values)]
        low, high = float(finite.min()), float(finite.max())
        norm = LogNorm(low, high) if low > 0.0 and high > 20.0 * low else Normalize(low, high)
        return cls(tuple(sequential_colormap()(norm(values))), norm)


def _matching(lines: Sequence[Line], panels: Sequence[dict[str, Any]]) -> list[Line]:
    """Return the lines that belong to any of the panels."""
    return [line for line in lines if any(panel.items() <= line.values.items() for panel in panels)]


def _draw_panel(
    axes: Axes, lines: Sequence[Line], layout: Layout, palette: _Palette, unit: Unit
) -> list[Line2D]:
    axes.grid(axis="y")
    curves = []
    for line in lines:
        color = layout.index(layout.color, line)
        style = layout.index(layout.style, line)
        marked = 0 < line.marks.shape[1] <= MOST_MARKED_POINTS and palette.norm is None
        look: dict[str, Any] = {"color": palette.colors[color]}
        marks: dict[str, Any] = {
            "marker": MARKERS[color % len(MARKERS)],
            "markerfacecolor": "white" if style else palette.colors[color],
            "markeredgewidth": 0.8,
        }
        dashes = LINE_STYLES[style % len(LINE_STYLES)]
        values = unit.of(line.quantity)
        if marked and np.array_equal(line.marks[0], line.cycles):
            curves += axes.plot(line.cycles, values, linestyle=dashes, **look, **marks)
            continue
        curves += axes.plot(line.cycles, values, linestyle=dashes, **look)
        if marked:
            heights = unit.of(line.marks[1])
            axes.plot(line.marks[0], heights, linestyle="none", label="_snapshots", **look, **marks)
    return curves


def _add_keys(
    figure: Figure,
    panels: Sequence[Axes],
    layout: Layout,
    lines: Sequence[Line],
    palette: _Palette,
    *,
    inside: bool,
) -> None:
    color_texts, style_texts = (_key_texts(layout, lines, n) for n in (layout.color, layout.style))
    if palette.norm is not None and layout.color:
        color_texts = []
        shown = parameter(layout.color)
        label = f"{shown.words} ({shown.unit.name})" if shown.unit.name else shown.words
        colours = ScalarMappable(palette.norm, sequential_colormap())
        numbers = FuncFormatter(lambda value, _: f"{shown.unit.of(value):g}")
        add_scale(figure, panels, colours, label, aspect=40, fraction=0.04, format=numbers)
    marks = zip(palette.colors, cycle(MARKERS), color_texts, strict=False)
    styles = zip(cycle(LINE_STYLES), style_texts, strict=False)
    handles = [
        *(Line2D([], [], color=color, marker=mark, label=text) for color, mark, text in marks),
        *(Line2D([], [], color="#555555", linestyle=style, label=text) for style, text in styles),
    ]
    if handles and inside:
        panels[0].legend(handles=handles)
    elif handles:
        outside_key(figure, handles, color_texts + style_texts)


def _key_texts(layout: Layout, lines: Sequence[Line], name: str | None) -> list[str]:
    """Return the key of a name's values, with those of the names that it tells."""
    if name is None:
        return []
    told = layout.paired if name == layout.color else ()
    texts = []
    for value in layout.levels[name]:
        line = next(line for line in lines if line.values[name] == value)
        texts.append(", ".join(symbol_text(n, line.values[n]) for n in (name, *told)))
    return texts


def draw_zone_widths(axes: Axes, history: xr.Dataset) -> list[Line2D]:
    """Draw the half-widths of both zones of a case, or of its history; return their curves."""
    cycles = np.atleast_1d(history["cycle"].values).astype(np.float64)
    curves = []
    for zone, color in ZONES.items():
        widths = MICROMETRE.of(np.atleast_1d(history[f"{zone}_half_width_x"].values))
        curves += axes.plot(cycles, widths, color=color, label=zone)
    highest = max(float(np.nanmax(np.asarray(curve.get_ydata()))) for curve in curves)
    axes.set_ylim(0.0, 1.15 * highest)
    axes.set_ylabel(HALF_WIDTH_LABEL)
    set_cycle_axis(axes, cycles)
    return curves
