"""Results over the cycles: the points of a study as lines, their panels, colours and captions."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, NullLocator

from fretwear.arrays import Array
from fretwear.data.effects import BOOKKEEPING, LEAST_SEEDS, SEED, Value, rank_correlations
from fretwear.figures.axes import (
    MOST_LABELLED,
    MOST_WITH_MINOR_TICKS,
    ValueAxis,
    label_curves,
    make_panels,
    outside_key,
    parameter_label,
)
from fretwear.figures.datasets import check_dataset, require, variable_of, with_cycles
from fretwear.figures.encoding import MOST_KEYED, Coding, rounded
from fretwear.figures.maps import add_scale
from fretwear.figures.style import (
    LINE_STYLES,
    Columns,
    caption,
    root_figure,
    styled,
)
from fretwear.study.parameters import parameter, symbol_text, words_text
from fretwear.units import in_unit, listed
from fretwear.vocabulary import RESULTS, Variable

Levels = Mapping[str, tuple[Value, ...]]
"""The different values of each varied name, in the order of the study."""

_MOST_ROWS, _MOST_PANELS_ACROSS, _MOST_STYLES, _MOST_COLORS = 3, 3, 4, 60
_PREFERRED_STYLE = ("plastic_limit", "slip_model")
_PREFERRED_COLOR = ("roughness_amplitude", "roughness")
_MOST_CONTRASTS = 2
_MOST_NAMED = 8
_MOST_MARKS = 12
_CONSTANT = 1e-3
# A result that every contact has at every cycle.
_ALWAYS = "contact_half_width_x"
# This model neglects the worn shape and serves for comparison; another model is shown if possible.
_SIMPLIFIED = ("slip_model", "cattaneo_mindlin")


@dataclass(frozen=True)
class Curve:
    """One point of a study, or the mean of points that differ in their seed, over the cycles."""

    point: Mapping[str, int]  # its place along each dimension
    values: Mapping[str, Value]  # of the varied parameters
    cycles: Array  # of every step if there is a history, else of the snapshots
    quantity: Array
    marks: Array  # cycles and values at the snapshots, shape (2, k); k = 0 for a history alone
    deviation: Array | None = None  # standard deviation of a mean

    @property
    def has_marks(self) -> bool:
        """Whether the snapshots are few enough to be marked."""
        return bool(0 < self.marks.shape[1] <= _MOST_MARKS)

    @property
    def is_point(self) -> bool:
        """Whether a logarithmic axis leaves fewer than two values, which make no line."""
        return int(np.count_nonzero(self.quantity > 0.0)) < 2


def study_curves(
    summary: xr.Dataset, variable: str, history: xr.Dataset | None = None
) -> list[Curve]:
    """Return one line per finished point of a study for a quantity such as ``wear_volume``.

    The dataset is a merged study (varied names, then ``cycle``; or ``point``, ``cycle``), one case,
    or the history of either (…, ``step``, with ``cycle`` a variable). With its `history`, lines go
    through every step. Raises a `ValueError` if the dataset lacks the quantity.
    """
    require(summary, variable)
    summary = with_cycles(summary)
    dims = [str(dim) for dim in summary[variable].dims if dim not in ("cycle", "step")]
    steps = summary if history is None or variable not in history else history
    # A result undefined over some cycles, as without a stick zone, leaves a gap in its line.
    may_lack = variable in RESULTS and RESULTS[variable].may_lack
    (cycles, quantities, _), (dense_cycles, dense, there) = (
        [
            array.transpose(*dims, ...).values.astype(np.float64)
            for array in xr.broadcast(
                dataset["cycle"],
                dataset[variable],
                dataset[_ALWAYS if may_lack and _ALWAYS in dataset else variable],
            )
        ]
        for dataset in (summary, steps)
    )
    columns: dict[str, tuple[str, list[Value]]] = {}
    for name, coordinate in summary.coords.items():
        if name not in BOOKKEEPING and coordinate.ndim == 1 and coordinate.dims[0] in dims:
            units = coordinate.attrs.get("units", "")
            column = [in_unit(value, units) for value in coordinate.values.tolist()]
            columns[str(name)] = str(coordinate.dims[0]), column
    lines = []
    for at in map(tuple, np.argwhere(np.isfinite(quantities).any(axis=-1)).tolist()):
        point = dict(zip(dims, at, strict=True))
        values = {name: column[point[dim]] for name, (dim, column) in columns.items()}
        marks = np.stack([cycles[at], quantities[at]])[:, np.isfinite(quantities[at])]
        marks = marks if "cycle" in summary.dims else marks[:, :0]
        stored = np.isfinite(there[at])
        lines.append(Curve(point, values, dense_cycles[at][stored], dense[at][stored], marks))
    return lines


def _means(lines: Sequence[Curve], summary: xr.Dataset) -> list[Curve]:
    """Return the means of lines that differ in their seed alone, at every cycle of any of them."""
    groups: dict[tuple[int, ...], list[Curve]] = {}
    for line in lines:
        groups.setdefault(tuple(i for n, i in line.point.items() if n != SEED), []).append(line)
    means = []
    for group in groups.values():
        point = {name: i for name, i in group[0].point.items() if name != SEED}
        values = {n: v for n, v in group[0].values.items() if SEED not in summary[n].dims}
        cycles = np.unique(np.concatenate([line.cycles for line in group]))
        marked = np.unique(np.concatenate([line.marks[0] for line in group]))
        table = np.stack([np.interp(cycles, line.cycles, line.quantity) for line in group])
        mean, deviation = table.mean(axis=0), table.std(axis=0, ddof=1) if len(group) > 1 else None
        marks = np.stack([marked, np.interp(marked, cycles, mean)])
        means.append(Curve(point, values, cycles, mean, marks, deviation))
    return means


def _levels(lines: Sequence[Curve]) -> Levels:
    names = lines[0].values if lines else ()
    return {name: tuple(dict.fromkeys(line.values[name] for line in lines)) for name in names}


def _telling(levels: Levels, lines: Sequence[Curve]) -> str | None:
    """Return the drawn parameter of highest rank correlation; None with fewer than two drawn."""
    drawn = [
        name
        for name, values in levels.items()
        if len(values) > max(MOST_KEYED, 0.9 * len(lines))
        and not any(isinstance(value, str) for value in values)
    ]
    if len(drawn) < 2:
        return None
    last = np.array([[line.quantity[-1]] for line in lines])
    values = np.array([[line.values[name] for name in drawn] for line in lines], dtype=float)
    correlations = np.abs(rank_correlations(values, last))[:, 0]
    return drawn[int(np.argmax(np.nan_to_num(correlations)))]


def _independent(levels: Levels, lines: Sequence[Curve]) -> tuple[list[str], dict[str, str]]:
    """Return the independent varied names, and for the others a name that determines each."""
    kept: list[str] = []
    leaders: dict[str, str] = {}
    for name in (name for name, values in levels.items() if len(values) > 1):
        for other in kept:
            pairs = {(line.values[other], line.values[name]) for line in lines}
            # A colour bar does not help to read a few values.
            readable = len(levels[other]) <= MOST_KEYED or len(levels[name]) > _MOST_STYLES
            if readable and len(pairs) == len(levels[other]):
                leaders[name] = other
                break
        else:
            kept.append(name)
    return kept, leaders


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
    through every step, and marks are snapshots; without it, and for results that it lacks, straight
    lines join the snapshots. Points of a study that are not done (NaN) are left out. Values that
    span more than a factor of 30 have a logarithmic axis if the result allows one; cycle 0, without
    wear, is not on it. Panels, colours and line styles stand for the varied parameters; `ax` raises
    a ValueError if they take more than one panel.
    """
    check_dataset(dataset)
    return CyclePlot(dataset, quantity, history).draw(columns, ax)


class CyclePlot:
    """A figure of a result over the cycles; a `ValueError` if no point has a value."""

    def __init__(
        self, dataset: xr.Dataset, quantity: Variable | str, history: xr.Dataset | None = None
    ) -> None:
        variable = variable_of(dataset, quantity) if isinstance(quantity, str) else quantity
        lines = study_curves(dataset, variable.name, history)
        if not lines:
            raise ValueError(f"No point has a value of {variable.name}: there is nothing to draw.")
        points = dataset["status"].size if "status" in dataset else len(lines)
        self._cases = f"the {len(lines)} of {points} cases that are done"
        if points == len(lines):
            self._cases = "one case" if points == 1 else f"all {points} cases"
        seeds = dataset[variable.name].sizes.get(SEED, 0)
        self._seeds = seeds if seeds >= LEAST_SEEDS else 0
        if self._seeds:
            # Seeds differ by chance, so their mean and deviation are shown.
            lines = _means(lines, dataset)
        self._choose_places(lines)
        self._coding = Coding(self.color, self.levels[self.color] if self.color else ("",))
        self.lines = [
            line for line in lines if all(line.values[n] in self.levels[n] for n in self.thinned)
        ]
        cycles, values = _joined(self.lines)
        self._axis = ValueAxis(variable, values[(cycles == 0.0) | (cycles >= 1.0)])
        self._is_dense = history is not None and variable.name in history

    def _choose_places(self, lines: Sequence[Curve]) -> None:
        """Choose panels, colours and line styles for the names that the lines vary.

        Colour stands for the roughness amplitude or, if that is fixed, the name with most values;
        line style for the plastic limit or another name with few values, unless many lines crowd a
        panel; panels for the remaining names. If a name has more values than can be shown, evenly
        spaced ones remain.
        """
        levels = _levels(lines)
        names, leaders = _independent(levels, lines)
        self.style = None
        if len(names) > 1 and all(len(levels[name]) <= MOST_KEYED for name in names):
            few = [name for name in names if len(levels[name]) <= _MOST_STYLES]
            others = [name for name in few if name not in _PREFERRED_COLOR]
            preferred = [name for name in _PREFERRED_STYLE if name in few]
            self.style = min(preferred[:1] or others, key=lambda n: len(levels[n]), default=None)
        rest = [name for name in names if name != self.style]
        preferred = [name for name in _PREFERRED_COLOR if name in rest]
        finest = max(preferred[:1] or rest, key=lambda name: len(levels[name]), default=None)
        self.color = _telling(levels, lines) or finest
        if self.color not in rest and self.color is not None:  # it determines all others
            rest, self.style = [self.color], None
        facets = [name for name in rest if name != self.color]
        self.rows, facets = (facets[:1], facets[1:]) if len(facets) > 1 else ([], facets)
        self.across, held = facets[:1], facets[1:]
        most: dict[str | None, int] = {self.color: _MOST_COLORS}
        most |= dict.fromkeys(self.rows, _MOST_ROWS)
        most |= dict.fromkeys(self.across, _MOST_PANELS_ACROSS * (1 if self.rows else _MOST_ROWS))
        self.levels = dict(levels)  # the levels that are shown
        for name, values in levels.items():
            if len(values) > most.get(name, math.inf):
                picks = np.linspace(0, len(values) - 1, most[name]).round().astype(int)
                self.levels[name] = tuple(values[index] for index in np.unique(picks))
        # In paired lists few lines have the last level of every name that is held, or none.
        kept = [e for e in lines if all(e.values[n] in self.levels[n] for n in levels)]
        kept = kept or [*lines[-1:]]
        alike = Counter(tuple(line.values[name] for name in held) for line in reversed(kept))
        of_most = alike.most_common(1)[0][0]
        kept = [line for line in kept if tuple(line.values[name] for name in held) == of_most]
        for name, values in levels.items():
            seen = {line.values[name] for line in kept}
            self.levels[name] = tuple(value for value in values if value in seen)
        # Numbers of levels of the names of which only some levels are shown.
        self.thinned = {n: len(levels[n]) for n in levels if len(self.levels[n]) < len(levels[n])}
        # Names whose values follow from the colour, as in paired lists.
        self.paired = [name for name, leader in leaders.items() if leader == self.color]

    @property
    def is_constant(self) -> bool:
        """Whether all lines are horizontal."""
        values = [line.quantity for line in self.lines]
        return all(np.ptp(curve) <= _CONSTANT * np.abs(curve).max() for curve in values)

    @styled
    def draw(self, columns: Columns = 2, ax: Axes | None = None) -> Figure:
        """Draw the figure."""
        axis, lines, names = self._axis, self.lines, (*self.rows, *self.across)
        # The values that each panel stands for, row by row.
        combinations = product(*(self.levels[name] for name in names))
        contents = [dict(zip(names, values, strict=True)) for values in combinations]
        across = math.prod(len(self.levels[name]) for name in self.across)
        across = across if self.rows else min(across, 2 * columns)
        figure: Figure
        if ax is None:
            titles = [", ".join(symbol_text(n, v) for n, v in facet.items()) for facet in contents]
            row = 46.0 if len(contents) > across else 56.0
            figure, panels = make_panels(columns, titles, across, (16.0, row), "row")
        elif len(contents) == 1:
            figure, panels = root_figure(ax), [ax]
        else:
            raise ValueError(
                f"This study takes {len(contents)} panels, which do not fit into one axes: leave "
                "out ax, or select a part of the study first, for example with dataset.isel(...)."
            )
        caption(figure, self.caption)
        every = _joined(lines)
        curves: list[Line2D] = []
        for index, (panel, facet) in enumerate(zip(panels, contents, strict=True)):
            panel.grid(axis="y")
            for line in _matching(lines, [facet]):
                curves.append(self._draw_line(panel, line))
            axis.set_cycles(panel, *every)
            row_of_lines = _matching(lines, contents[index : index + across])
            if index % across == 0 and row_of_lines:
                axis.set_limits(panel, *_joined(row_of_lines))
            if len(panels) > MOST_WITH_MINOR_TICKS:
                panel.xaxis.set_minor_locator(NullLocator())
                panel.yaxis.set_minor_locator(NullLocator())
        if len(panels) > 1:
            figure.supylabel(axis.label, fontsize=7.5)
        else:
            panels[0].set_ylabel(axis.label)
        if self._seeds:
            note = f"Lines are means of {self._seeds} seeds, bands their standard deviation."
            figure.supxlabel(note, fontsize=7.0)
        texts = self._key_texts(self.color)
        if len(panels) == 1 and 1 < len(lines) <= MOST_LABELLED and texts and not self.style:
            labels = [texts[self._level(self.color, line)] for line in lines]
            if label_curves(panels[0], curves, labels):
                return figure
        coding, key = self._coding, list[Line2D]()
        if coding.is_keyed:
            key, _ = coding.key(range(len(texts)))
        elif self.color:
            texts, label = [], parameter_label(self.color)
            bar = add_scale(figure, panels, coding.scale(), label, aspect=40.0)
            bar.ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: coding.number(value)))
        for dashes, text in zip(LINE_STYLES, self._key_texts(self.style), strict=False):
            key.append(Line2D([], [], color="#555555", ls=dashes))
            texts.append(text)
        if key and ax is not None:
            ax.legend(key, texts)
        elif key:
            outside_key(figure, key, texts)
        return figure

    def _level(self, name: str | None, line: Curve) -> int:
        """Return the place of a line's value among the levels shown of `name`, 0 for no name."""
        return 0 if name is None else self.levels[name].index(line.values[name])

    def _draw_line(self, panel: Axes, line: Curve) -> Line2D:
        unit, values = self._axis.unit, line.quantity
        place, style = (self._level(name, line) for name in (self.color, self.style))
        color, dashes = self._coding.colors[place], LINE_STYLES[style % len(LINE_STYLES)]
        (curve,) = panel.plot(line.cycles, unit.of(values), color=color, ls=dashes)
        if line.has_marks and (self._coding.is_keyed or line.is_point):
            marked = curve
            if not np.array_equal(line.marks[0], line.cycles):
                (marked,) = panel.plot(
                    line.marks[0], unit.of(line.marks[1]), color=color, ls="none"
                )
                marked.set_label("_snapshots")
            marked.set_marker(self._coding.mark(place))
            marked.set(markerfacecolor="white" if style else color, markeredgewidth=0.8)
        if line.deviation is not None:
            low, high = unit.of(values - line.deviation), unit.of(values + line.deviation)
            band = panel.fill_between(line.cycles, low, high, color=color, alpha=0.2, lw=0.0)
            band.set_label("_band")
        return curve

    def _key_texts(self, name: str | None) -> list[str]:
        """Return texts of a name's values, with the values of the names that follow from it."""
        if name is None:
            return []
        names = (name, *self.paired) if name == self.color else (name,)
        texts = []
        for value in self.levels[name]:
            line = next(line for line in self.lines if line.values[name] == value)
            texts.append(", ".join(symbol_text(paired, line.values[paired]) for paired in names))
        return texts

    @property
    def caption(self) -> str:
        """The caption of the figure."""
        axis, is_keyed = self._axis, self._coding.is_keyed
        sentences = [f"{axis.variable.label} against the number of cycles, {self._cases}."]
        if self._seeds:
            sentences.append(f"Mean and standard deviation over {self._seeds} seeds.")
        if self.rows or self.across:
            sentences.append(f"Panels: {_names([*self.rows, *self.across])}.")
        if self.color:
            with_it = f", with {_names(self.paired)}" if self.paired and is_keyed else ""
            sentences.append(f"Colour: {parameter(self.color).words}{with_it}.")
        if self.paired and not is_keyed:
            verb = "changes" if len(self.paired) == 1 else "change"
            sentences.append(f"From line to line, {_names(self.paired)} {verb} too.")
        if self.style:
            sentences.append(f"Line style and filling of marks: {parameter(self.style).words}.")
        for name, total in self.thinned.items():
            words, shown = parameter(name).words, len(self.levels[name])
            sentences.append(f"The figure shows {shown} of {total} values of {words}.")
        is_marked = is_keyed and any(line.has_marks for line in self.lines)
        is_marked = is_marked or any(line.is_point for line in self.lines)
        if self._is_dense:
            marks = "; marks are snapshots" if is_marked else ""
            sentences.append(f"Lines go through every step{marks}.")
        elif is_marked:
            sentences.append("Marks are snapshots, joined by straight lines.")
        cycles, values = _joined(self.lines)
        positive = cycles[((cycles == 0.0) | (cycles >= 1.0)) & (values > 0.0)]
        is_wide = cycles.max() >= 10.0 * positive[positive > 0.0].min(initial=math.inf)
        if not axis.is_logarithmic:
            broken = "The axis of cycles is logarithmic to the right of the break."
            sentences.append(broken if is_wide else "The axes are linear.")
        elif not is_wide:
            sentences.append("The vertical axis is logarithmic.")
        else:
            broken = ", the axis of cycles to the right of the break" if 0.0 in positive else ""
            sentences.append(f"Both axes are logarithmic{broken}.")
        return " ".join(sentences)


def _joined(lines: Sequence[Curve]) -> tuple[Array, Array]:
    cycles, values = zip(*((line.cycles, line.quantity) for line in lines), strict=True)
    return np.concatenate(cycles), np.concatenate(values)


def _names(names: Sequence[str]) -> str:
    return listed(parameter(name).words for name in names)


def _matching(lines: Sequence[Curve], panels: Sequence[Mapping[str, Value]]) -> list[Curve]:
    """Return the lines that belong to any of the panels."""
    return [line for line in lines if any(p.items() <= line.values.items() for p in panels)]


@dataclass(frozen=True)
class RepresentativeCases:
    """Cases that differ in some names and agree, where possible, in the others."""

    contrasts: tuple[str, ...]  # the names in which they differ
    ids: dict[str, str]  # by title, such as ``smooth, elastic``; empty for a single case
    common: str  # other values, shared by all, in words
    left_out: str  # words on values that are not shown; may be empty


def representative_cases(summary: xr.Dataset) -> RepresentativeCases:
    """Return up to four finished cases of a merged study that has some, reproducibly.

    They span the extremes of roughness amplitude and plastic limit, or else of the first two other
    names. All other names have the last values with which most of these cases are done, preferably
    with a slip model that follows the worn shape. If points were drawn at random, no two agree in
    the other names, and the cases of least and most wear are taken.
    """
    lines = study_curves(summary, "wear_volume")
    levels = _levels(lines)
    varied = [name for name, values in levels.items() if len(values) > 1]
    preferred = [n for n in (*_PREFERRED_COLOR, *_PREFERRED_STYLE) if n in varied]
    contrasts = tuple(dict.fromkeys([*preferred, *varied]))[:_MOST_CONTRASTS]
    others = [name for name in varied if name not in contrasts]
    extremes: dict[str, tuple[Value, Value]] = {}
    for name in contrasts:
        is_text = any(isinstance(value, str) for value in levels[name])
        ordered = levels[name] if is_text else sorted(levels[name])
        extremes[name] = ordered[0], ordered[-1]
    groups: dict[tuple[Value, ...], list[Curve]] = {}
    for line in lines:
        if all(line.values[name] in extremes[name] for name in contrasts):
            groups.setdefault(tuple(line.values[name] for name in others), []).append(line)
    slip, simplified = _SIMPLIFIED
    best = max(
        reversed(list(groups.values())),
        key=lambda group: (len(group), group[0].values.get(slip) != simplified),
        default=[],
    )
    if was_drawn := not best or len(best) == 1 < len(lines):
        by_wear = sorted(lines, key=lambda line: float(np.nanmax(line.quantity)))
        best = [by_wear[0], by_wear[-1]]
    shorter = rounded if was_drawn else lambda value: value
    titles = (
        ", ".join(symbol_text(n, shorter(line.values[n])) for n in contrasts) for line in best
    )
    ids = (str(summary["case_id"].isel(line.point).item()) for line in best)
    shown = _levels(best)
    common = ", ".join(words_text(n, shown[n][0]) for n in others if len(shown[n]) == 1)
    missed = [words_text(n, v) for n in contrasts for v in levels[n] if v not in shown[n]]
    left_out = f"not shown: {', '.join(missed)}" if missed else ""
    if len(missed) > _MOST_NAMED:
        left_out = f"{len(best)} of {len(lines)} cases"
    return RepresentativeCases(contrasts, dict(zip(titles, ids, strict=True)), common, left_out)
