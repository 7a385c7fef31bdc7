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
from fretwear.figures.datasets import check_dataset
from fretwear.figures.direct_labels import Curve, label_curves
from fretwear.figures.grouping import (
    MOST_KEYED_COLORS,
    Layout,
    Line,
    choose_layout,
    shown_lines,
    study_lines,
)
from fretwear.figures.history_kinds import (
    DISSIPATED_ENERGY,
    HALF_WIDTH,
    STICK_HALF_WIDTH,
    WEAR_VOLUME,
    HistoryKind,
)
from fretwear.figures.keys import outside_key
from fretwear.figures.panels import label_outer, make_panels
from fretwear.figures.style import (
    CATEGORICAL,
    LINE_STYLES,
    MARKERS,
    Columns,
    JournalFigure,
    root_figure,
    sequential_colormap,
    sequential_colours,
    styled,
)
from fretwear.figures.value_axis import (
    is_wide,
    set_linear_axis,
    set_logarithmic_axis,
    unit_of_axis,
)
from fretwear.figures.wording import Unit, parameter, symbol_text

_MOST_MARKED_POINTS = 12
_MOST_LABELLED_LINES = 6


def contact_half_width(
    dataset: xr.Dataset, *, columns: Columns = 2, axes: Axes | None = None
) -> Figure:
    """Draw the contact half-width along x against the cycles.

    Parameters
    ----------
    dataset : xarray.Dataset
        A merged study or a part of it, the dataset of one case, or the history of one case.
        Points of a study that are not done (NaN) are left out.
    columns : {1, 2}
        Journal columns that the figure spans, 90 mm or 190 mm.
    axes : matplotlib.axes.Axes, optional
        Where to draw, in a figure of your own, what takes one panel; `columns` then says nothing.

    Returns
    -------
    matplotlib.figure.Figure
        Half-width in µm over cycles; panels, colours and line styles follow from what the study
        varies (`fretwear.figures.grouping.choose_layout`).

    Raises
    ------
    TypeError
        When `dataset` is no dataset.
    ValueError
        When the quantity is missing, no point is done, or `axes` are given for more panels.
    """
    return history(dataset, HALF_WIDTH, columns=columns, axes=axes)


def stick_half_width(
    dataset: xr.Dataset, *, columns: Columns = 2, axes: Axes | None = None
) -> Figure:
    """Draw the stick zone's half-width along x against cycles, as `contact_half_width` does."""
    return history(dataset, STICK_HALF_WIDTH, columns=columns, axes=axes)


def wear_volume(dataset: xr.Dataset, *, columns: Columns = 2, axes: Axes | None = None) -> Figure:
    """Draw the wear volume of both bodies against cycles, as `contact_half_width` does.

    Volumes that span more than a factor of 30 are on a logarithmic axis, which cycle 0, without
    wear, is not on.
    """
    return history(dataset, WEAR_VOLUME, columns=columns, axes=axes)


def dissipated_energy(
    dataset: xr.Dataset, *, columns: Columns = 2, axes: Axes | None = None
) -> Figure:
    """Draw the energy dissipated in one cycle against cycles, as `contact_half_width` does."""
    return history(dataset, DISSIPATED_ENERGY, columns=columns, axes=axes)


@styled
def history(
    dataset: xr.Dataset, kind: HistoryKind, *, columns: Columns = 2, axes: Axes | None = None
) -> Figure:
    """Draw one kind of quantity against cycles; see `contact_half_width`."""
    check_dataset(dataset)
    lines = study_lines(dataset, kind.variable)
    if not lines:
        raise ValueError(f"No point has a value of {kind.variable}: there is nothing to draw.")
    layout = choose_layout(lines)
    lines = shown_lines(lines, layout)
    contents, across = _panels(layout, columns)
    figure, panels = _frames(contents, across, columns, axes)
    logarithmic = kind.is_logarithmic(lines)
    values = np.concatenate([line.quantity for line in lines])
    unit = kind.unit or unit_of_axis(values, kind.base, logarithmic)
    palette = _Palette.of(layout)
    for panel, facet in zip(panels, contents, strict=True):
        _draw_panel(panel, _matching(lines, [facet]), layout, palette, unit)
        panel.set_title(", ".join(symbol_text(name, value) for name, value in facet.items()))
        set_cycle_axis(panel, _drawn_cycles(lines, logarithmic))
    for start in range(0, len(contents), across):
        row = _matching(lines, contents[start : start + across])
        if row:
            shown = unit.of(np.concatenate([line.quantity for line in row]))
            if logarithmic and is_wide(shown):
                set_logarithmic_axis(panels[start], shown)
            else:
                set_linear_axis(panels[start], shown, kind.from_zero)
    label_outer(panels, across)
    _label_values(figure, panels, f"{kind.label} ({unit.name})")
    if not (len(panels) == 1 and _label_lines(panels[0], layout, lines, palette, unit)):
        _add_keys(figure, panels, layout, lines, palette, inside=axes is not None)
    return figure


def _frames(
    contents: Sequence[Any], across: int, columns: Columns, axes: Axes | None
) -> tuple[Figure, list[Axes]]:
    """Return the figure and its panels, or those that the caller gave."""
    if axes is None:
        down = -(-len(contents) // across)
        figure = JournalFigure(columns, 16.0 + (46.0 if down > 1 else 56.0) * down)
        return figure, make_panels(figure, len(contents), across, "row")
    if len(contents) > 1:
        raise ValueError(
            f"This study takes {len(contents)} panels, which one axes does not hold: leave axes "
            "out, or select a part of the study first, for example with dataset.isel(...)."
        )
    return root_figure(axes), [axes]


def _drawn_cycles(lines: Sequence[Line], logarithmic: bool) -> np.ndarray[Any, Any]:
    """Return the cycles of all points that are on the axes; a logarithmic one has no zero."""
    cycles = np.concatenate([line.cycles for line in lines])
    values = np.concatenate([line.quantity for line in lines])
    return cycles[values > 0.0] if logarithmic else cycles[np.isfinite(values)]


def _label_values(figure: Figure, panels: Sequence[Axes], label: str) -> None:
    if len(panels) == 1:
        panels[0].set_ylabel(label)
    else:
        figure.supylabel(label, fontsize=7.5)


@dataclass(frozen=True)
class _Palette:
    colors: tuple[str, ...]
    is_continuous: bool

    @classmethod
    def of(cls, layout: Layout) -> _Palette:
        levels = layout.levels[layout.color] if layout.color else ("",)
        if isinstance(levels[0], str):
            return cls(tuple(CATEGORICAL[i % len(CATEGORICAL)] for i in range(len(levels))), False)
        if len(levels) <= MOST_KEYED_COLORS:
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


def _label_lines(
    axes: Axes, layout: Layout, lines: Sequence[Line], palette: _Palette, unit: Unit
) -> bool:
    """Label a few lines that colour alone tells apart, where there is room."""
    if not layout.color or layout.style or not 1 < len(lines) <= _MOST_LABELLED_LINES:
        return False
    texts = _key_texts(layout, lines, layout.color)
    curves = []
    for line in lines:
        level = layout.index(layout.color, line)
        known = np.isfinite(line.quantity)
        values = unit.of(line.quantity[known])
        curves.append(Curve(line.cycles[known], values, texts[level], palette.colors[level], True))
    return label_curves(axes, curves)


def _add_keys(
    figure: Figure,
    panels: Sequence[Axes],
    layout: Layout,
    lines: Sequence[Line],
    palette: _Palette,
    *,
    inside: bool,
) -> None:
    handles: list[Line2D] = []
    if layout.color and palette.is_continuous:
        mappable = ScalarMappable(_norm(layout.levels[layout.color]), sequential_colormap())
        size = parameter(layout.color).unit.size
        bar = figure.colorbar(
            mappable, ax=panels, aspect=40, fraction=0.04, format=lambda v, _: f"{v / size:g}"
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
    if handles and inside:
        panels[0].legend(handles=handles)
    elif handles:
        outside_key(figure, handles, [str(handle.get_label()) for handle in handles])


def _key_texts(layout: Layout, lines: Sequence[Line], name: str) -> list[str]:
    """Return the key of a name's values, with those of the names that follow it."""
    told = layout.followers if name == layout.color else ()
    texts = []
    for value in layout.levels[name]:
        line = next(line for line in lines if line.values[name] == value)
        texts.append(", ".join(symbol_text(n, line.values[n]) for n in (name, *told)))
    return texts
