"""Axes of cycles and of results; panels with letters; keys and colour bars."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from textwrap import fill
from typing import Literal

import numpy as np
import xarray as xr
from matplotlib import ticker
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.cm import ScalarMappable
from matplotlib.colorbar import Colorbar
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from fretwear.arrays import Array
from fretwear.figures.style import COLUMN_WIDTH, Columns, JournalFigure
from fretwear.study.parameters import parameter
from fretwear.units import axis_label, in_unit, readable_unit
from fretwear.variable import Variable

Place = Literal["outside upper left", "outside lower left"]

Shared = Literal["all", "row", "none"]

_LETTER_WIDTH = 1.35  # mm, of the text of a key
_AROUND_PANEL = 22.0  # mm, of the axis and the letter of a panel
_LOGARITHMIC_FROM = 30.0
_MANY_DECADES = 100.0  # over which only decades have numbers
_CONSTANT = 0.03
_DEEPEST = 1e-6  # least value on a logarithmic axis, over the largest


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
        axes.xaxis.set_major_locator(ticker.SymmetricalLogLocator(base=10.0, linthresh=first))
        axes.set_xlim(-0.1 * first, 1.3 * last)
    else:
        axes.set_xscale("log")
        axes.set_xlim(first / 1.1, 1.3 * last)
    axes.xaxis.set_minor_locator(ticker.NullLocator())


def _set_log_ticks(axis: Axis, low: float, high: float) -> None:
    """Number decades of a logarithmic axis, and 2 and 5 within them if there are few."""
    subs = (1.0,) if high > _MANY_DECADES * low else (1.0, 2.0, 5.0)
    axis.set_major_locator(ticker.LogLocator(subs=subs, numticks=8))
    every = ticker.LogFormatterSciNotation(minor_thresholds=(math.inf, math.inf))
    axis.set_major_formatter(every)
    axis.set_minor_locator(ticker.NullLocator())


class ValueAxis:
    """The y axis of a result: its unit and scale, for values in SI units.

    It is logarithmic if the result allows it and its positive values span more than a factor of 30.
    """

    def __init__(self, variable: Variable, values: Array) -> None:
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
        ends = (shown.min(), shown.max()) if shown.size else (0.0, 0.0)
        self._low, self._high = (float(self.unit.of(end)) for end in ends)
        self._least = float(self.unit.of(positive.min())) if positive.size else 1.0
        self._is_constant = self._low >= (1.0 - _CONSTANT) * self._high
        self._from_zero = variable.from_zero or self._is_constant
        self.label = axis_label(variable.words, self.unit)

    def wrapped_label(self, width: int) -> str:
        """Return the label in lines of at most `width` letters, the unit unbroken."""
        words, bracket, unit = self.label.partition(" (")
        return fill(words + bracket + unit.replace(" ", "\N{NO-BREAK SPACE}"), width)

    def apply(self, axes: Axes) -> None:
        """Set scale and limits; values that hardly change are shown from zero, without noise."""
        if self.is_logarithmic:
            axes.set_yscale("log", nonpositive="mask")
            _set_log_ticks(axes.yaxis, self._least, self._high)
            axes.set_ylim(max(0.6 * self._least, _DEEPEST * self._high), 1.7 * self._high)
        elif self._from_zero:
            room = 1.25 if self._is_constant else 1.06
            axes.set_ylim(min(0.0, 1.06 * self._low), room * self._high or 1.0)


def parameter_values(dataset: xr.Dataset, name: str) -> tuple[Array, str]:
    """Return the values of a numeric parameter in a readable unit, and the label of their axis."""
    values = dataset[name].values.astype(np.float64)
    first = in_unit(float(values.flat[0]), dataset[name].attrs.get("units", ""))
    declared = parameter(name).in_frame_of(first)
    return declared.unit.of(values), axis_label(declared.words, declared.unit)


def make_panels(
    columns: Columns,
    titles: Sequence[str],
    across: int,
    heights: tuple[float, float],
    share_y: Shared = "all",
) -> tuple[JournalFigure, list[Axes]]:
    """Return a figure with a panel for each title, in rows of `across`; several have letters.

    `heights`, mm, are the height around the rows and the height of a row. Panels share the x axis,
    and have numbers and label of a shared axis at the edge of the figure only.
    """
    down = -(-len(titles) // across)
    figure = JournalFigure(columns, heights[0] + heights[1] * down)
    grid = figure.subplots(down, across, sharex="all", sharey=share_y, squeeze=False).ravel()
    for unused in grid[len(titles) :]:
        unused.remove()
    panels: list[Axes] = [*grid[: len(titles)]]
    for index, (axes, title) in enumerate(zip(panels, titles, strict=True)):
        letter = rf"$\bf{{{chr(97 + index)}}}$  " if 1 < len(titles) <= 26 else ""
        axes.set_title(f"{letter}{_in_lines(title, COLUMN_WIDTH[columns] / across)}".rstrip())
        is_lowest = index + across >= len(titles)
        is_outer = index % across == 0 or share_y == "none"
        axes.tick_params(axis="x", which="both", labelbottom=is_lowest)
        axes.tick_params(axis="y", which="both", labelleft=is_outer)
        axes.xaxis.label.set_visible(is_lowest)
        axes.yaxis.label.set_visible(is_outer)
    return figure, panels


def _letters(text: str) -> int:
    """Return the number of letters of a text, without its marks of mathematics."""
    return len(re.sub(r"\\[a-z]+|[${}]", "", text))


def _in_lines(title: str, width: float) -> str:
    """Return a title in two lines if it is wider than a panel, in mm."""
    parts = title.split(", ")
    if len(parts) == 1 or _LETTER_WIDTH * _letters(title) < width - _AROUND_PANEL:
        return title
    middle = -(-len(parts) // 2)
    return ",\n".join(", ".join(line) for line in (parts[:middle], parts[middle:]))


def add_key(
    canvas: Figure | Axes,
    handles: Sequence[Artist],
    labels: Sequence[str],
    place: Place = "outside upper left",
) -> None:
    """Add a key into axes, or beside those of a figure, with as many columns as fit into it."""
    if isinstance(canvas, Axes):
        canvas.legend(handles, labels)
        return
    letters = max(map(_letters, labels))
    fitting = max(1, int(25.4 * canvas.get_figwidth() / (_LETTER_WIDTH * letters + 9.0)))
    rows = -(-len(labels) // fitting)
    key = canvas.legend(handles, labels, loc=place, ncols=-(-len(labels) // rows))
    key.set_alignment("left")


def add_scale(
    figure: Figure, axes: Sequence[Axes], image: ScalarMappable, label: str, aspect: float = 30.0
) -> Colorbar:
    """Add a colour bar beside axes; `aspect` is its height over its width."""
    bar = figure.colorbar(image, ax=axes, label=label, aspect=aspect, fraction=0.05, pad=0.02)
    bar.outline.set_visible(False)
    if isinstance(image.norm, LogNorm):
        _set_log_ticks(bar.ax.yaxis, *image.get_clim())
    return bar
