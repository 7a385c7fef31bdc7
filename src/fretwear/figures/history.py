"""Quantities against cycles, for one case or for all cases of a study."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
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
    MOST_LABELLED,
    MOST_WITH_MINOR_TICKS,
    ValueAxis,
    label_curves,
    label_outer,
    make_panels,
    outside_key,
    parameter_label,
    set_cycle_axis,
)
from fretwear.figures.datasets import check_dataset, variable_of
from fretwear.figures.lines import (
    Array,
    Layout,
    Line,
    choose_layout,
    means_over,
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
    look,
    of_quantity,
    root_figure,
    sequential_colormap,
    sequential_colours,
    styled,
)
from fretwear.study.parameters import parameter, symbol_text
from fretwear.units import MICROMETRE, listed
from fretwear.vocabulary import Variable

HISTORIES = {
    "contact_half_width": "contact_half_width_x",
    "stick_half_width": "stick_half_width_x",
    "wear_volume": "wear_volume",
    "dissipated_energy": "dissipated_energy",
}
"""The results that have a figure of their own, by its name."""

ZONES = {"contact": CATEGORICAL[0], "stick": INK}
"""The zones and their colours."""
HALF_WIDTH_LABEL = "Half-width along x (µm)"

_MOST_MARKS = 12


@styled
def scalar_history(
    dataset: xr.Dataset,
    quantity: Variable | str,
    history: xr.Dataset | None = None,
    *,
    columns: Columns = 2,
    ax: Axes | None = None,
) -> Figure:
    """Draw any scalar result, such as ``wear_volume``, against the cycles.

    With `history`, the dense history of the study or case from `fretwear.open_history`, curves go
    through every step, and marks are snapshots; without it, and for results that it does not hold,
    snapshots are joined by straight lines. Points of a study that are not done (NaN) are left out.
    Values that span more than a factor of 30 are on a logarithmic axis where the result may be;
    cycle 0, without wear, is not on it. Panels, colours and line styles are for what the study
    varies; `ax` is a ValueError where that takes more panels than one.
    """
    check_dataset(dataset)
    return CyclePlot.of(dataset, quantity, history).draw(columns, ax)


contact_half_width, stick_half_width, wear_volume, dissipated_energy = (
    of_quantity(scalar_history, *each) for each in HISTORIES.items()
)


@dataclass(frozen=True)
class CyclePlot:
    """What a figure of a result over the cycles shows, drawn and told.

    `lines` are those of the study, or their means over the `seeds` of an ensemble, as far as the
    layout shows them; `cases` says in words how many there are.
    """

    variable: Variable
    lines: Sequence[Line]
    layout: Layout
    axis: ValueAxis
    seeds: int
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
        seeds = dataset[variable.name].sizes.get(SEED, 0)
        if seeds < LEAST_SEEDS:
            seeds = 0
        else:
            # Seeds are chance: their mean is shown, and how far they are from it.
            lines = means_over(SEED, lines, dataset)
        layout = choose_layout(lines)
        lines = shown_lines(lines, layout)
        cycles, known = _joined(lines)
        axis = ValueAxis.of(variable, known[(cycles == 0.0) | (cycles >= 1.0)])
        is_dense = history is not None
        return cls(variable, lines, layout, axis, seeds, cases, is_dense)

    @styled
    def draw(self, columns: Columns = 2, ax: Axes | None = None) -> Figure:
        """Draw the figure."""
        layout, axis, lines = self.layout, self.axis, self.lines
        contents, across = layout.panels(4 if columns == 2 else 2)
        if ax is None:
            row = 46.0 if len(contents) > across else 56.0
            figure, panels = make_panels(columns, len(contents), across, (16.0, row), "row")
        elif len(contents) == 1:
            figure, panels = root_figure(ax), [ax]
        else:
            raise ValueError(
                f"This study takes {len(contents)} panels, which do not fit into one axes: leave "
                "out ax, or select a part of the study first, for example with dataset.isel(...)."
            )
        cycles, values = _joined(lines)
        colors, norm = self._palette()
        curves: list[Line2D] = []
        for index, (panel, facet) in enumerate(zip(panels, contents, strict=True)):
            panel.grid(axis="y")
            for line in _matching(lines, [facet]):
                curves.append(self._draw_line(panel, line, colors, is_keyed=norm is None))
            panel.set_title(", ".join(symbol_text(name, value) for name, value in facet.items()))
            axis.set_cycles(panel, cycles, values)
            row_of_lines = _matching(lines, contents[index : index + across])
            if index % across == 0 and row_of_lines:
                axis.set_limits(panel, *_joined(row_of_lines))
            if len(panels) > MOST_WITH_MINOR_TICKS:
                panel.xaxis.set_minor_locator(NullLocator())
                panel.yaxis.set_minor_locator(NullLocator())
        label_outer(panels, across)
        if len(panels) > 1:
            figure.supylabel(axis.label, fontsize=7.5)
        else:
            panels[0].set_ylabel(axis.label)
        if self.seeds:
            note = f"Lines are means of {self.seeds} seeds, bands their standard deviation."
            figure.supxlabel(note, fontsize=7.0)
        few = len(panels) == 1 and 1 < len(lines) <= MOST_LABELLED
        if few and layout.color and not layout.style:
            texts = self._key_texts(layout.color)
            names = [texts[layout.index(layout.color, line)] for line in lines]
            if label_curves(panels[0], curves, names):
                return figure
        self._add_keys(figure, panels, colors, norm, inside=ax is not None)
        return figure

    def _palette(self) -> tuple[Sequence[Any], Normalize | None]:
        """Return the colours of the levels, and how a bar of colours is scaled if there is one."""
        levels = self.layout.levels[self.layout.color] if self.layout.color else ("",)
        if isinstance(levels[0], str):
            return [look(place)[0] for place in range(len(levels))], None
        if self.layout.is_keyed:
            return sequential_colours(len(levels)), None
        values = np.asarray(levels, dtype=np.float64)
        finite = values[np.isfinite(values)]
        low, high = float(finite.min()), float(finite.max())
        norm = (LogNorm if low > 0.0 and high > 20.0 * low else Normalize)(low, high)
        return [*sequential_colormap()(norm(values))], norm

    def _draw_line(
        self, panel: Axes, line: Line, colors: Sequence[Any], *, is_keyed: bool
    ) -> Line2D:
        place, style = (
            self.layout.index(name, line) for name in (self.layout.color, self.layout.style)
        )
        color = {"color": colors[place]}
        marks: dict[str, Any] = {
            "marker": MARKERS[place % len(MARKERS) if is_keyed else 0],
            "markerfacecolor": "white" if style else colors[place],
            "markeredgewidth": 0.8,
        }
        # A logarithmic axis leaves a single snapshot of a run without steps, which is no line.
        has_marks = _has_marks(line) and (is_keyed or _is_point(line))
        at_steps = has_marks and np.array_equal(line.marks[0], line.cycles)
        options = color | (marks if at_steps else {})
        values, unit = line.quantity, self.axis.unit
        dashes = LINE_STYLES[style % len(LINE_STYLES)]
        (curve,) = panel.plot(line.cycles, unit.of(values), linestyle=dashes, **options)
        if has_marks and not at_steps:
            heights = unit.of(line.marks[1])
            panel.plot(line.marks[0], heights, ls="none", label="_snapshots", **color, **marks)
        if line.deviation is not None:
            low, high = unit.of(values - line.deviation), unit.of(values + line.deviation)
            panel.fill_between(line.cycles, low, high, alpha=0.2, lw=0.0, label="_band", **color)
        return curve

    def _add_keys(
        self,
        figure: Figure,
        panels: Sequence[Axes],
        colors: Sequence[Any],
        norm: Normalize | None,
        *,
        inside: bool,
    ) -> None:
        color_texts, style_texts = map(self._key_texts, (self.layout.color, self.layout.style))
        if norm is not None and self.layout.color:
            color_texts, unit = [], parameter(self.layout.color).unit
            numbers = FuncFormatter(lambda value, _: f"{unit.of(value):g}")
            options = {"aspect": 40, "fraction": 0.04, "format": numbers}
            scale = ScalarMappable(norm, sequential_colormap())
            add_scale(figure, panels, scale, parameter_label(self.layout.color), **options)
        marks = zip(colors, cycle(MARKERS), color_texts, strict=False)
        styles = zip(cycle(LINE_STYLES), style_texts, strict=False)
        handles = [
            *(Line2D([], [], color=color, marker=mark, label=text) for color, mark, text in marks),
            *(Line2D([], [], color="#555555", ls=style, label=text) for style, text in styles),
        ]
        if handles and inside:
            panels[0].legend(handles=handles)
        elif handles:
            outside_key(figure, handles, color_texts + style_texts)

    def _key_texts(self, name: str | None) -> list[str]:
        """Return the key of a name's values, with those of the names that it tells."""
        if name is None:
            return []
        names = (name, *self.layout.paired) if name == self.layout.color else (name,)
        texts = []
        for value in self.layout.levels[name]:
            line = next(line for line in self.lines if line.values[name] == value)
            texts.append(", ".join(symbol_text(each, line.values[each]) for each in names))
        return texts

    @property
    def caption(self) -> str:
        """What the figure shows, in words."""
        return " ".join(self._sentences())

    def _sentences(self) -> Iterator[str]:
        layout = self.layout
        yield f"{self.variable.label} against the number of cycles, {self.cases}."
        if self.seeds:
            yield f"Mean and standard deviation over {self.seeds} seeds."
        if layout.rows or layout.across:
            yield f"Panels: {_names([*layout.rows, *layout.across])}."
        if layout.color:
            together = f", with {_names(layout.paired)}" if layout.paired else ""
            yield f"Colour: {parameter(layout.color).words}{together if layout.is_keyed else ''}."
            if layout.paired and not layout.is_keyed:
                verb = "changes" if len(layout.paired) == 1 else "change"
                yield f"From line to line, {_names(layout.paired)} {verb} too."
        if layout.style:
            yield f"Line and filling of marks: {parameter(layout.style).words}."
        for name, total in layout.thinned.items():
            shown = len(layout.levels[name])
            yield f"Of {total} values of {parameter(name).words}, {shown} are shown."
        is_marked = layout.is_keyed and any(map(_has_marks, self.lines))
        is_marked = is_marked or any(map(_is_point, self.lines))
        if self.is_dense:
            yield f"Lines go through every step{'; marks are snapshots' if is_marked else ''}."
        elif is_marked:
            yield "Marks are snapshots, joined by straight lines."
        cycles, values = _joined(self.lines)
        positive = cycles[((cycles == 0.0) | (cycles >= 1.0)) & (values > 0.0)]
        is_wide = cycles.max() >= 10.0 * positive[positive > 0.0].min(initial=math.inf)
        if not self.axis.is_logarithmic:
            broken = "The axis of cycles is logarithmic to the right of the break."
            yield broken if is_wide else "The axes are linear."
        elif not is_wide:
            yield "The vertical axis is logarithmic."
        else:
            broken = ", that of cycles to the right of the break" if 0.0 in positive else ""
            yield f"Both axes are logarithmic{broken}."


def _joined(lines: Sequence[Line]) -> tuple[Array, Array]:
    cycles, values = zip(*((line.cycles, line.quantity) for line in lines), strict=True)
    return np.concatenate(cycles), np.concatenate(values)


def _names(names: Sequence[str]) -> str:
    return listed(parameter(name).words for name in names)


def _has_marks(line: Line) -> bool:
    return bool(0 < line.marks.shape[1] <= _MOST_MARKS)


def _is_point(line: Line) -> bool:
    return int(np.count_nonzero(line.quantity > 0.0)) < 2


def _matching(lines: Sequence[Line], panels: Sequence[Mapping[str, Any]]) -> list[Line]:
    """Return the lines that belong to any of the panels."""
    return [line for line in lines if any(each.items() <= line.values.items() for each in panels)]


def draw_zone_widths(axes: Axes, history: xr.Dataset) -> list[Line2D]:
    """Draw the half-widths of both zones of a case, or of its history; return their curves."""
    cycles = np.atleast_1d(history["cycle"].values).astype(np.float64)
    curves, highest = [], 0.0
    for zone, color in ZONES.items():
        widths = MICROMETRE.of(np.atleast_1d(history[f"{zone}_half_width_x"].values))
        curves += axes.plot(cycles, widths, color=color, label=zone)
        highest = max(highest, float(np.nanmax(widths)))
    axes.set_ylim(0.0, 1.15 * highest)
    axes.set_ylabel(HALF_WIDTH_LABEL)
    set_cycle_axis(axes, cycles)
    return curves
