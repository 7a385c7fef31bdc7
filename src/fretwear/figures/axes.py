"""Axes of cycles, of results and of parameters; panels with letters; keys."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from textwrap import wrap
from typing import Any, Literal

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.cm import ScalarMappable
from matplotlib.colorbar import Colorbar
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.ticker import Formatter, LogLocator, NullLocator, SymmetricalLogLocator
from numpy.typing import ArrayLike

from fretwear.arrays import Array
from fretwear.figures.style import Columns, JournalFigure
from fretwear.results import Variable
from fretwear.study.parameters import parameter, value_text
from fretwear.units import cycle_text, number_text, power_of_ten, readable_unit

Place = Literal["outside upper left", "outside lower left"]
"""The place of a key, as matplotlib's legends name it."""

Value = float | str
Shared = Literal["all", "row", "none"]

_LETTER_WIDTH = 1.35  # mm, of the text of a key
_LOGARITHMIC_FROM, _WIDE = 30.0, 7.9
_CONSTANT = 0.03
_BEYOND = 0.3  # distance of a value that is infinite from the numbers, over their range
_MOST_TICKS = 8


def set_cycle_axis(axes: Axes, cycles: ArrayLike) -> None:
    """Make the x axis of `axes` an axis of cycles.

    It is linear if all cycles lie within a decade; else it is logarithmic from the first cycle on,
    and linear from cycle 0 to there.
    """
    values = np.asarray(cycles, dtype=np.float64)
    positive = values[values >= 1.0]
    axes.set_xlabel("Cycle")
    if not positive.size or positive.max() < 10.0 * positive.min():
        axes.margins(x=0.04)
        return
    first, last = 10.0 ** math.floor(math.log10(positive.min())), float(positive.max())
    if (values < first).any():
        axes.set_xscale("symlog", linthresh=first, linscale=0.5)
        axes.xaxis.set_major_locator(SymmetricalLogLocator(base=10.0, linthresh=first))
        axes.set_xlim(-0.1 * first, 1.3 * last)
    else:
        axes.set_xscale("log")
        axes.set_xlim(first / 1.1, 1.3 * last)
    axes.xaxis.set_major_formatter(DecadeFormatter())
    axes.xaxis.set_minor_locator(NullLocator())


class DecadeFormatter(Formatter):
    """Numbers of a logarithmic axis: all plain or, over a wide range, all powers of ten."""

    def __call__(self, value: float, pos: int | None = None) -> str:  # noqa: ARG002
        """Return the text of a tick."""
        ends = np.abs(self.axis.get_view_interval())
        if value == 0.0 or (ends[1] < 1e5 and (ends[0] >= 1e-3 or self.axis.get_scale() != "log")):
            return f"{value:g}" if value < 10_000.0 else cycle_text(value)
        return power_of_ten(round(math.log10(value)))


class ValueAxis:
    """The axis of a result: its unit and scale, for values in SI units.

    It is logarithmic if the result allows it and its positive values span more than a factor of 30.
    """

    def __init__(self, variable: Variable, values: Array) -> None:
        self.variable = variable
        shown = values[np.isfinite(values)]
        positive = shown[shown > 0.0]
        self.is_logarithmic = bool(
            variable.may_be_logarithmic
            and positive.size
            and positive.max() > _LOGARITHMIC_FROM * positive.min()
        )
        self.unit = variable.unit or readable_unit(shown, variable.si_unit)
        if self.is_logarithmic and self.unit.is_power and not variable.unit:
            # A logarithmic axis needs no power of ten in its unit.
            self.unit = readable_unit((), variable.si_unit)
        self._ends = [float(self.unit.of(end)) for end in (shown.min(), shown.max(), 0.0)[:2]]
        self._least = float(self.unit.of(positive.min())) if positive.size else 1.0
        self.label = f"{variable.label} ({self.unit.name})" if self.unit.name else variable.label

    def wrapped_label(self, width: int) -> str:
        """Return the label in lines of at most `width` letters, the unit unbroken."""
        unit = f"({self.unit.name})" if self.unit.name else ""
        lines = wrap(self.variable.label, width)
        if unit and len(lines[-1]) + len(unit) < width:
            lines[-1], unit = f"{lines[-1]} {unit}", ""
        return "\n".join(filter(None, [*lines, unit]))

    def apply(self, axis: Axis, deepest: float = 1e-6) -> None:
        """Set scale and limits of an axis, and its label if it has none.

        Values that hardly change are shown from zero, because an axis that fits them would show
        only noise. A logarithmic axis has values down to `deepest` times the largest.
        """
        low, high = self._ends
        set_limits = axis.axes.set_ylim if axis is axis.axes.yaxis else axis.axes.set_xlim
        if self.is_logarithmic:
            make_logarithmic(axis, is_wide=high > 100.0 * self._least)
            set_limits(max(0.6 * self._least, deepest * high), 1.7 * high)
            return
        is_constant = low >= (1.0 - _CONSTANT) * high
        if self.variable.from_zero or is_constant:
            set_limits(min(0.0, 1.06 * low), high * (1.25 if is_constant else 1.06) or 1.0)


def make_logarithmic(axis: Axis, *, is_wide: bool = True) -> None:
    """Make an axis logarithmic with a number at every decade, or at 1, 2 and 5 of a few decades."""
    options: dict[str, Any] = {"nonpositive": "mask"}
    (axis.axes.set_yscale if axis is axis.axes.yaxis else axis.axes.set_xscale)("log", **options)
    axis.set_major_locator(LogLocator(subs=(1.0,) if is_wide else (1.0, 2.0, 5.0), numticks=8))
    axis.set_major_formatter(DecadeFormatter())
    axis.set_minor_locator(NullLocator())


class ParameterAxis:
    """The axis of a parameter: numbers at their value, words side by side.

    It is logarithmic if the numbers span a wide range and their ratios are more even than their
    distances. An infinite value, such as that of an elastic body's plastic limit, is named beyond
    the numbers.
    """

    def __init__(self, name: str, levels: Sequence[Value]) -> None:
        self.name, self.levels = name, list(dict.fromkeys(levels))
        numbers = [level for level in self.levels if not isinstance(level, str)]
        self.is_numeric = len(numbers) == len(self.levels)
        self.about = parameter(name).in_frame_of(next(iter(numbers), 1.0))
        finite = np.unique([self.about.unit.of(n) for n in numbers if math.isfinite(n)])
        self.is_logarithmic = self.is_numeric and _is_spaced_by_ratio(finite)
        if finite.size > 1 and self.is_logarithmic:
            self._infinity = float(finite[-1] * (finite[-1] / finite[0]) ** _BEYOND)
        elif finite.size:
            self._infinity = float(finite[-1] + _BEYOND * (np.ptp(finite) or finite[-1]))
        else:
            self._infinity = 1.0

    def places(self, values: Sequence[Value] | Array) -> Array:
        """Return where values stand on the axis."""
        if not self.is_numeric:
            return np.array([self.levels.index(value) for value in values], dtype=np.float64)
        numbers = np.array([self.about.unit.of(float(value)) for value in values])
        return np.where(np.isfinite(numbers), numbers, self._infinity)

    @property
    def label(self) -> str:
        """Words and unit."""
        return parameter_label(self.name, next(iter(self.levels)))

    def apply(self, axis: Axis) -> None:
        """Set scale, ticks and label of an axis."""
        if self.is_logarithmic:
            make_logarithmic(axis)
        if len(self.levels) <= _MOST_TICKS:
            texts = [
                number_text(float(self.about.unit.of(level)), 3)
                if self.is_numeric and math.isfinite(float(level))
                else value_text(self.name, level)
                for level in self.levels
            ]
            axis.set_ticks(self.places(self.levels).tolist(), texts)
            axis.set_ticks([], minor=True)
        axis.set_label_text(self.label[:1].upper() + self.label[1:])


def _is_spaced_by_ratio(numbers: Array) -> bool:
    if numbers.size < 3 or numbers[0] <= 0.0 or numbers[-1] < _WIDE * numbers[0]:
        return False
    steps, ratios = np.diff(numbers), np.diff(np.log(numbers))
    return bool(ratios.std() / ratios.mean() < steps.std() / steps.mean())


def parameter_label(name: str, value: Value = 1.0) -> str:
    """Return the label of the axis of a parameter: words and unit, as they suit a value."""
    about = parameter(name).in_frame_of(value)
    is_plain = isinstance(value, str) or not about.unit.name
    return about.words if is_plain else f"{about.words} ({about.unit.name})"


def make_panels(
    columns: Columns,
    titles: Sequence[str],
    across: int,
    heights: tuple[float, float],
    share_y: Shared = "all",
    share_x: Shared = "all",
) -> tuple[JournalFigure, list[Axes]]:
    """Return a figure with a panel for each title, in rows of `across`; several have letters.

    `heights`, mm, are the height around the rows and the height of a row. Panels that share an axis
    have its numbers and label at the edge of the figure only.
    """
    down = -(-len(titles) // across)
    figure = JournalFigure(columns, heights[0] + heights[1] * down)
    grid = figure.subplots(down, across, sharex=share_x, sharey=share_y, squeeze=False).ravel()
    for index, axes in enumerate(grid):
        if index >= len(titles):
            axes.remove()
            continue
        letter = rf"$\bf{{{chr(97 + index)}}}$  " if 1 < len(titles) <= 26 else ""
        axes.set_title(f"{letter}{titles[index]}".rstrip())
        is_lowest, is_leftmost = index + across >= len(titles), index % across == 0
        axes.tick_params(axis="x", which="both", labelbottom=is_lowest or share_x == "none")
        axes.tick_params(axis="y", which="both", labelleft=is_leftmost or share_y == "none")
        axes.xaxis.label.set_visible(is_lowest or share_x == "none")
        axes.yaxis.label.set_visible(is_leftmost or share_y == "none")
    return figure, list(grid[: len(titles)])


def outside_key(
    figure: Figure,
    handles: Sequence[Artist],
    labels: Sequence[str],
    place: Place = "outside upper left",
    title: str = "",
) -> Legend:
    """Add a key above or below the axes, with as many columns as fit into the figure."""
    letters = max(len(re.sub(r"\\[a-z]+|[${}]", "", label)) for label in labels)
    columns = int(25.4 * figure.get_figwidth() / (_LETTER_WIDTH * letters + 9.0))
    columns = min(max(1, columns), len(labels))
    columns = -(-len(labels) // -(-len(labels) // columns))  # rows of equal length
    key: Legend = figure.legend(handles, labels, loc=place, ncols=columns, title=title or None)
    key.set_alignment("left")
    return key


def add_scale(
    figure: Figure, axes: Sequence[Axes], image: ScalarMappable, label: str, aspect: float = 30.0
) -> Colorbar:
    """Add a colour bar beside axes; `aspect` is its height over its width."""
    bar = figure.colorbar(image, ax=axes, label=label, aspect=aspect, fraction=0.05, pad=0.02)
    bar.outline.set_visible(False)
    return bar
