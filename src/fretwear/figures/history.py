"""Quantities against cycles, for one case or for all cases of a study."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import cycle
from typing import Any, Protocol

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
    MOST_LABELLED,
    ValueAxis,
    label_curves,
    label_outer,
    make_panels,
    outside_key,
    set_cycle_axis,
)
from fretwear.figures.datasets import check_dataset, variable_of
from fretwear.figures.lines import Array, Layout, Line, choose_layout, shown_lines, study_lines
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

_MOST_MARKS = 12
_MOST_WITH_MINOR_TICKS = 4


@styled
def scalar_history(
    dataset: xr.Dataset,
    quantity: Variable | str,
    history: xr.Dataset | None = None,
    *,
    columns: Columns = 2,
    ax: Axes | None = None,
) -> Figure:
    """Draw any scalar result against the cycles.

    Parameters
    ----------
    dataset : xarray.Dataset
        A merged study or a part of it, the dataset of one case, or the history of one case.
        Points of a study that are not done (NaN) are left out.
    quantity : str
        The result, such as ``wear_volume``. Values that span more than a factor of 30 are on a
        logarithmic axis where the result may be; cycle 0, without wear, is not on it.
    history : xarray.Dataset, optional
        The dense history of the study or case, from `fretwear.open_history`: curves go through
        every step, and marks are snapshots. Without it, and for results that it does not hold,
        snapshots are joined by straight lines.
    columns : {1, 2}
        Journal columns that the figure spans, 90 mm or 190 mm.
    ax : matplotlib.axes.Axes, optional
        Where to draw, in a figure of your own, what takes one panel; `columns` then says nothing.

    Returns
    -------
    matplotlib.figure.Figure
        Panels, colours and line styles are for what the study varies
        (`fretwear.figures.lines.choose_layout`).

    Raises
    ------
    TypeError
        When `dataset` is no dataset.
    ValueError
        When the quantity is missing, no point is done, or `ax` is given for more panels.
    """
    check_dataset(dataset)
    return CyclePlot.of(dataset, quantity, history).draw(columns, ax)


class CycleFigure(Protocol):
    """Draws one result against the cycles, as `scalar_history` does."""

    def __call__(
        self,
        dataset: xr.Dataset,
        history: xr.Dataset | None = None,
        *,
        columns: Columns = 2,
        ax: Axes | None = None,
    ) -> Figure:
        """Return the figure."""


def _history_of(name: str, quantity: str, words: str) -> CycleFigure:
    def draw(
        dataset: xr.Dataset,
        history: xr.Dataset | None = None,
        *,
        columns: Columns = 2,
        ax: Axes | None = None,
    ) -> Figure:
        return scalar_history(dataset, quantity, history, columns=columns, ax=ax)

    draw.__name__ = draw.__qualname__ = name
    draw.__doc__ = f"Draw {words} against the cycles; parameters are those of `scalar_history`."
    return draw


contact_half_width = _history_of(
    "contact_half_width", "contact_half_width_x", "the contact half-width along x"
)
stick_half_width = _history_of(
    "stick_half_width", "stick_half_width_x", "the stick zone's half-width along x"
)
wear_volume = _history_of("wear_volume", "wear_volume", "the wear volume of both bodies")
dissipated_energy = _history_of(
    "dissipated_energy", "dissipated_energy", "the energy dissipated in one cycle"
)


@dataclass(frozen=True)
class CyclePlot:
    """What a figure of a result over the cycles shows, drawn and told.

    `lines` are those of the study, or their means over the seeds of an `ensemble`, as far as the
    layout shows them; `cases` says in words how many there are.
    """

    variable: Variable
    lines: Sequence[Line]
    layout: Layout
    axis: ValueAxis
    ensemble: Ensemble | None
    cases: str
    is_dense: bool

    @classmethod
    def of(
        cls, dataset: xr.Dataset, quantity: Variable | str, history: xr.Dataset | None = None
    ) -> CyclePlot:
        """Return the plot; a `ValueError` says that no point has a value of the quantity."""
        variable = variable_of(dataset, quantity) if isinstance(quantity, str) else quantity
        lines = study_lines(dataset, variable.name, history)
        if not lines:
            raise ValueError(f"No point has a value of {variable.name}: there is nothing to draw.")
        points = dataset["status"].size if "status" in dataset else len(lines)
        cases = f"{len(lines)} of {points} cases, those done"
        if points == len(lines):
            cases = "one case" if points == 1 else f"all {points} cases"
        ensemble = Ensemble.of(dataset, variable.name)
        if ensemble is not None:
            history, lines = None, study_lines(ensemble.mean, variable.name)
        layout = choose_layout(lines)
        lines = shown_lines(lines, layout)
        cycles, values = _joined(lines)
        axis = ValueAxis.of(variable, values[(cycles == 0.0) | (cycles >= 1.0)])
        return cls(variable, lines, layout, axis, ensemble, cases, history is not None)

    @styled
    def draw(self, columns: Columns = 2, ax: Axes | None = None) -> Figure:
        """Draw the figure."""
        layout, axis, lines = self.layout, self.axis, self.lines
        contents, across = layout.panels(4 if columns == 2 else 2)
        figure, panels = _frames(len(contents), across, columns, ax)
        many = len(panels) > _MOST_WITH_MINOR_TICKS
        cycles, values = _joined(lines)
        palette = _Palette.of(layout)
        curves: list[Line2D] = []
        for index, (panel, facet) in enumerate(zip(panels, contents, strict=True)):
            panel.grid(axis="y")
            for line in _matching(lines, [facet]):
                curves.append(_draw_line(panel, line, layout, palette, axis.unit))
                if self.ensemble is not None:
                    self.ensemble.draw_band(panel, line, curves[-1], axis.unit)
            panel.set_title(", ".join(symbol_text(name, value) for name, value in facet.items()))
            axis.set_cycles(panel, cycles, values)
            row = _matching(lines, contents[index : index + across])
            if index % across == 0 and row:
                axis.set_limits(panel, *_joined(row))
            if many:
                panel.xaxis.set_minor_locator(NullLocator())
                panel.yaxis.set_minor_locator(NullLocator())
        label_outer(panels, across)
        if len(panels) > 1:
            figure.supylabel(axis.label, fontsize=7.5)
        else:
            panels[0].set_ylabel(axis.label)
        if self.ensemble is not None:
            note = (
                f"Lines are means of {self.ensemble.count} seeds, bands their standard deviation."
            )
            figure.supxlabel(note, fontsize=7.0)
        few = len(panels) == 1 and 1 < len(lines) <= MOST_LABELLED
        if few and layout.color and not layout.style:
            texts = _key_texts(layout, lines, layout.color)
            names = [texts[layout.index(layout.color, line)] for line in lines]
            if label_curves(panels[0], curves, names):
                return figure
        _add_keys(figure, panels, layout, lines, palette, inside=ax is not None)
        return figure

    @property
    def caption(self) -> str:
        """What the figure shows, in words."""
        return " ".join(
            [
                f"{self.variable.label} against the number of cycles, {self.cases}.",
                *self._encoding(),
                *self._drawn(),
                f"{self._axes_words()}.",
            ]
        )

    def _encoding(self) -> Iterator[str]:
        layout = self.layout
        if self.ensemble is not None:
            yield f"Mean and standard deviation over {self.ensemble.count} seeds."
        if layout.rows or layout.across:
            yield f"Panels: {_names([*layout.rows, *layout.across])}."
        if layout.color:
            together = f", with {_names(layout.paired)}" if layout.paired else ""
            yield f"Colour: {parameter(layout.color).words}{together if layout.is_keyed else ''}."
            if layout.paired and not layout.is_keyed:
                yield f"From line to line, {_names(layout.paired)} changes too."
        if layout.style:
            yield f"Line and filling of marks: {parameter(layout.style).words}."
        for name, total in layout.thinned.items():
            shown = len(layout.levels[name])
            yield f"Of {total} values of {parameter(name).words}, {shown} are shown."

    def _drawn(self) -> Iterator[str]:
        is_marked = self.layout.is_keyed and any(map(_has_marks, self.lines))
        is_marked = is_marked or any(map(_is_point, self.lines))
        if self.is_dense:
            yield f"Lines go through every step{'; marks are snapshots' if is_marked else ''}."
        elif is_marked:
            yield "Marks are snapshots, joined by straight lines."

    def _axes_words(self) -> str:
        cycles, values = _joined(self.lines)
        positive = cycles[((cycles == 0.0) | (cycles >= 1.0)) & (values > 0.0)]
        is_wide = cycles.max() >= 10.0 * positive[positive > 0.0].min(initial=math.inf)
        if not self.axis.is_logarithmic:
            broken = "The axis of cycles is logarithmic to the right of the break"
            return broken if is_wide else "The axes are linear"
        if not is_wide:
            return "The vertical axis is logarithmic"
        both = "Both axes are logarithmic"
        return f"{both}, that of cycles to the right of the break" if 0.0 in positive else both


@dataclass(frozen=True)
class Ensemble:
    """A study in which seeds are chance: the mean over them, and how far they are from it."""

    mean: xr.Dataset
    deviation: xr.DataArray
    count: int

    @classmethod
    def of(cls, dataset: xr.Dataset, name: str) -> Ensemble | None:
        """Return the ensemble of a merged study over some seeds; None for any other dataset."""
        values = dataset[name]
        if SEED not in values.dims or values.sizes[SEED] < LEAST_SEEDS:
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


def _joined(lines: Sequence[Line]) -> tuple[Array, Array]:
    cycles, values = zip(*((line.cycles, line.quantity) for line in lines), strict=True)
    return np.concatenate(cycles), np.concatenate(values)


def _names(names: Sequence[str]) -> str:
    *before, last = (parameter(name).words for name in names)
    return f"{', '.join(before)} and {last}" if before else last


def _has_marks(line: Line) -> bool:
    return bool(0 < line.marks.shape[1] <= _MOST_MARKS)


def _is_point(line: Line) -> bool:
    return int(np.count_nonzero(line.quantity > 0.0)) < 2


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
            f"This study takes {count} panels, which do not fit into one axes: leave out ax, "
            "or select a part of the study first, for example with dataset.isel(...)."
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
        if layout.is_keyed:
            return cls(tuple(sequential_colours(len(levels))))
        values = np.asarray(levels, dtype=np.float64)
        finite = values[np.isfinite(values)]
        low, high = float(finite.min()), float(finite.max())
        norm = LogNorm(low, high) if low > 0.0 and high > 20.0 * low else Normalize(low, high)
        return cls(tuple(sequential_colormap()(norm(values))), norm)


def _matching(lines: Sequence[Line], panels: Sequence[Mapping[str, Any]]) -> list[Line]:
    """Return the lines that belong to any of the panels."""
    return [line for line in lines if any(each.items() <= line.values.items() for each in panels)]


def _draw_line(axes: Axes, line: Line, layout: Layout, palette: _Palette, unit: Unit) -> Line2D:
    color, style = layout.index(layout.color, line), layout.index(layout.style, line)
    look: dict[str, Any] = {"color": palette.colors[color]}
    marks: dict[str, Any] = {
        "marker": MARKERS[color % len(MARKERS)],
        "markerfacecolor": "white" if style else palette.colors[color],
        "markeredgewidth": 0.8,
    }
    if palette.norm is not None:
        marks["marker"] = MARKERS[0]
    # A logarithmic axis leaves a single snapshot of a run without steps, which is no line.
    is_marked = _has_marks(line) and (palette.norm is None or _is_point(line))
    at_steps = is_marked and np.array_equal(line.marks[0], line.cycles)
    dashes = LINE_STYLES[style % len(LINE_STYLES)]
    (curve,) = axes.plot(
        line.cycles,
        unit.of(line.quantity),
        linestyle=dashes,
        **look,
        **(marks if at_steps else {}),
    )
    if is_marked and not at_steps:
        heights = unit.of(line.marks[1])
        axes.plot(line.marks[0], heights, linestyle="none", label="_snapshots", **look, **marks)
    return curve


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
