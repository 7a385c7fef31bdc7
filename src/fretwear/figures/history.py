"""Quantities against cycles, for one case or for all cases of a study."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fretwear.figures.cycle_axis import set_cycle_axis
from fretwear.figures.grouping import Layout, Line, choose_layout, shown_lines, study_lines
from fretwear.figures.panels import label_outer, make_panels
from fretwear.figures.style import (
    CATEGORICAL,
    LINE_STYLES,
    MARKERS,
    Columns,
    JournalFigure,
    sequential_colormap,
    sequential_colours,
    styled,
)
from fretwear.figures.wording import (
    MICROMETRE,
    Unit,
    parameter,
    readable_unit,
    symbol_text,
)

_MOST_KEYED_COLORS = 8
_LOGARITHMIC_FROM = 30.0
_DEEPEST = 1e-6
_MOST_MARKED_POINTS = 12


@dataclass(frozen=True)
class HistoryKind:
    """What a figure over the cycles shows.

    Parameters
    ----------
    variable : str
        Name of the quantity.
    label : str
        What the y axis says, without the unit.
    base : str
        SI unit of the quantity.
    unit : Unit or None
        Unit of the y axis; None chooses one by the size of the values.
    from_zero : bool
        Whether the y axis begins at zero.
    may_be_logarithmic : bool
        Whether a wide range of values is shown on a logarithmic axis.
    """

    variable: str
    label: str
    base: str
    unit: Unit | None = None
    from_zero: bool = True
    may_be_logarithmic: bool = False


HALF_WIDTH = HistoryKind(
    "contact_half_width_x", "Contact half-width along x", "m", MICROMETRE, from_zero=False
)
STICK_HALF_WIDTH = HistoryKind(
    "stick_half_width_x", "Stick half-width along x", "m", MICROMETRE, from_zero=False
)
WEAR_VOLUME = HistoryKind("wear_volume", "Wear volume", "m3")
DISSIPATED_ENERGY = HistoryKind(
    "dissipated_energy", "Dissipated energy per cycle", "J", may_be_logarithmic=True
)

HISTORY_KINDS = {
    "contact_half_width": HALF_WIDTH,
    "stick_half_width": STICK_HALF_WIDTH,
    "wear_volume": WEAR_VOLUME,
    "dissipated_energy": DISSIPATED_ENERGY,
}


def contact_half_width(summary: xr.Dataset, *, columns: Columns = 2) -> Figure:
    """Draw the contact half-width along x against the cycles.

    Parameters
    ----------
    summary : xarray.Dataset
        A merged study, the dataset of one case, or the history of one case. Points of a study
        that are not done (NaN) are left out.
    columns : {1, 2}
        Journal columns that the figure spans.

    Returns
    -------
    matplotlib.figure.Figure
        Half-width in µm over cycles; panels, colours and line styles follow from what the study
        varies (`fretwear.figures.grouping.choose_layout`).

    Raises
    ------
    ValueError
        When the quantity is missing or no point is done.
    """
    return history(summary, HALF_WIDTH, columns=columns)


def stick_half_width(summary: xr.Dataset, *, columns: Columns = 2) -> Figure:
    """Draw the stick zone's half-width along x against cycles, as `contact_half_width` does."""
    return history(summary, STICK_HALF_WIDTH, columns=columns)


def wear_volume(summary: xr.Dataset, *, columns: Columns = 2) -> Figure:
    """Draw the wear volume of both bodies against cycles, as `contact_half_width` does."""
    return history(summary, WEAR_VOLUME, columns=columns)


def dissipated_energy(summary: xr.Dataset, *, columns: Columns = 2) -> Figure:
    """Draw the energy dissipated in one cycle against cycles, as `contact_half_width` does."""
    return history(summary, DISSIPATED_ENERGY, columns=columns)


@styled
def history(summary: xr.Dataset, kind: HistoryKind, *, columns: Columns = 2) -> Figure:
    """Draw one kind of quantity against cycles; see `contact_half_width`."""
    lines = study_lines(summary, kind.variable)
    if not lines:
        raise ValueError(f"No point has a value of {kind.variable}: there is nothing to draw.")
    layout = choose_layout(lines)
    lines = shown_lines(lines, layout)
    contents, across = _panels(layout, columns)
    down = -(-len(contents) // across)
    figure = JournalFigure(columns, 16.0 + (46.0 if down > 1 else 56.0) * down)
    panels = make_panels(figure, len(contents), across, "row")
    unit = kind.unit or readable_unit(np.concatenate([line.quantity for line in lines]), kind.base)
    palette = _Palette.of(layout)
    for axes, values in zip(panels, contents, strict=True):
        _draw_panel(axes, _matching(lines, [values]), layout, palette, unit)
        axes.set_title(", ".join(symbol_text(name, value) for name, value in values.items()))
        set_cycle_axis(axes, np.concatenate([line.cycles for line in lines]))
    for start in range(0, len(contents), across):
        row = _matching(lines, contents[start : start + across])
        _set_y_axis(panels[start], row, kind, unit)
    label_outer(panels, across)
    figure.supylabel(f"{kind.label} ({unit.name})", fontsize=7.5)
    _add_keys(figure, layout, lines, palette)
    return figure


@dataclass(frozen=True)
class _Palette:
    colors: tuple[str, ...]
    is_continuous: bool

    @classmethod
    def of(cls, layout: Layout) -> _Palette:
        levels = layout.levels[layout.color] if layout.color else ("",)
        if isinstance(levels[0], str):
            return cls(tuple(CATEGORICAL[i % len(CATEGORICAL)] for i in range(len(levels))), False)
        if len(levels) <= _MOST_KEYED_COLORS:
            return cls(tuple(sequential_colours(len(levels))), False)
        shades = sequential_colormap()(_norm(levels)(np.asarray(levels)))
        return cls(tuple(shades), True)


def _norm(levels: Sequence[float]) -> Normalize:
    values = np.asarray(levels, dtype=np.float64)
    values = values[np.isfinite(values)]
    low, high = float(values.min()), float(values.max())
    return LogNorm(low, high) if low > 0.0 and high > 20.0 * low else Normalize(low, high)


def _panels(layout: Layout, columns: Columns) -> tuple[list[dict[str, Any]], int]:
    """Return the values that each panel stands for, row by row, and the panels in a row."""
    rows, across = layout.row_values(), layout.across_values()
    most = len(across) if layout.rows else min(len(across), 4 if columns == 2 else 2)
    return [{**row, **column} for row in rows for column in across], most


def _matching(lines: Sequence[Line], panels: Sequence[dict[str, Any]]) -> list[Line]:
    """Return the lines that belong to any of the panels."""
    return [
        line
        for line in lines
        if any(all(line.values[n] == value for n, value in panel.items()) for panel in panels)
    ]


def _draw_panel(
    axes: Axes, lines: Sequence[Line], layout: Layout, palette: _Palette, unit: Unit
) -> None:
    axes.grid(axis="y")
    for line in lines:
        color = layout.index(layout.color, line)
        style = layout.index(layout.style, line)
        known = np.isfinite(line.quantity)
        few = known.sum() <= _MOST_MARKED_POINTS and not palette.is_continuous
        axes.plot(
            line.cycles[known],
            unit.of(line.quantity[known]),
            color=palette.colors[color],
            linestyle=LINE_STYLES[style % len(LINE_STYLES)],
            marker=MARKERS[color % len(MARKERS)] if few else None,
            markerfacecolor="white" if style else palette.colors[color],
            markeredgewidth=0.8,
        )


def _set_y_axis(axes: Axes, lines: Sequence[Line], kind: HistoryKind, unit: Unit) -> None:
    if not lines:
        return
    values = unit.of(np.concatenate([line.quantity for line in lines]))
    positive = values[np.isfinite(values) & (values > 0.0)]
    spread = positive.max() / positive.min() if positive.size else 1.0
    if kind.may_be_logarithmic and spread > _LOGARITHMIC_FROM:
        axes.set_yscale("log")
        axes.set_ylim(max(0.5 * positive.min(), _DEEPEST * positive.max()), 2.0 * positive.max())
    elif kind.from_zero:
        axes.set_ylim(0.0, float(np.nanmax(values)) * 1.06 or 1.0)


def _add_keys(figure: Figure, layout: Layout, lines: Sequence[Line], palette: _Palette) -> None:
    handles: list[Line2D] = []
    if layout.color and palette.is_continuous:
        mappable = ScalarMappable(_norm(layout.levels[layout.color]), sequential_colormap())
        size = parameter(layout.color).unit.size
        bar = figure.colorbar(
            mappable, ax=figure.axes, aspect=40, fraction=0.04, format=lambda v, _: f"{v / size:g}"
        )
        shown = parameter(layout.color)
        bar.set_label(f"{shown.words} ({shown.unit.name})" if shown.unit.name else shown.words)
        bar.outline.set_visible(False)
    elif layout.color:
        handles += [
            Line2D([], [], color=color, marker=MARKERS[i % len(MARKERS)], label=text)
            for i, (color, text) in enumerate(
                zip(palette.colors, _key_texts(layout, lines, layout.color), strict=True)
            )
        ]
    if layout.style:
        gray = "#555555"
        handles += [
            Line2D([], [], color=gray, linestyle=LINE_STYLES[i % len(LINE_STYLES)], label=text)
            for i, text in enumerate(_key_texts(layout, lines, layout.style))
        ]
    if handles:
        across = len(handles) if figure.get_figwidth() > 5.0 else 3
        figure.legend(handles=handles, loc="outside upper left", ncols=across, handlelength=2.4)


def _key_texts(layout: Layout, lines: Sequence[Line], name: str) -> list[str]:
    """Return the key of a name's values, with those of the names that follow it."""
    told = layout.followers if name == layout.color else ()
    texts = []
    for value in layout.levels[name]:
        line = next(line for line in lines if line.values[name] == value)
        texts.append(", ".join(symbol_text(n, line.values[n]) for n in (name, *told)))
    return texts
