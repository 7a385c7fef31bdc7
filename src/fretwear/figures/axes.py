"""Axes of cycles and of values, grids of panels, keys, and labels beside curves."""

from __future__ import annotations

import math
from collections.abc import Sequence
from textwrap import wrap
from typing import Literal

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize, to_hex
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.text import Text
from matplotlib.ticker import FixedLocator, FuncFormatter, NullFormatter
from numpy.typing import ArrayLike

from fretwear.arrays import Array
from fretwear.figures.style import MUTED, Columns, JournalFigure, root_figure, text_colour
from fretwear.study.parameters import parameter
from fretwear.units import cycle_text, power_of_ten, readable_unit
from fretwear.vocabulary import Variable

Place = Literal["outside upper left", "outside lower left"]
"""The place of a key, as matplotlib's legends name it."""

MOST_LABELLED = 6
"""Largest number of curves with a label beside each; more curves have a key."""
MOST_WITH_MINOR_TICKS = 4
"""Largest number of panels with minor ticks; more panels are too small for them."""

_ZERO_GAP = 0.7
_CYCLE_MARGIN = 1.25
_SPELT_OUT = 10_000.0
_FEW_DECADES = 100.0
_POINTS_PER_SIGN = 4.5

_LOGARITHMIC_FROM = 30.0
_DEEPEST = 1e-6
_CONSTANT = 0.03
_PLAIN = (1e-3, 1e4)

_LABEL_SIZE = 6.5
_LABEL_MARGIN = 2
_REACH = 7.0
_CLEARANCE = 15.0
_INDISTINCT = 2.0
_STEP = 1.5
_MOST_TRIED = 150


def set_cycle_axis(axes: Axes, cycles: ArrayLike) -> None:
    """Make the x axis of `axes` an axis of cycles.

    It is logarithmic from the first cycle on, with cycle 0 to the left of a break, or linear if all
    cycles lie within one decade. The last cycle is labelled, and every decade with room for its
    number; on fewer than two decades, twice and five times a power of ten are labelled too.
    """
    values = np.asarray(cycles, dtype=np.float64)
    values = values[np.isfinite(values)]
    last = float(values.max(initial=0.0))
    first = max(1.0, float(values[values > 0.0].min(initial=np.inf)))
    axes.set_xlabel("Cycle")
    if not math.isfinite(first) or last < 10.0 * first:
        axes.margins(x=0.04)
        return
    axes.set_xscale("symlog", linthresh=first, linscale=_ZERO_GAP)
    has_zero = bool((values < first).any())
    start, end = -0.06 * first if has_zero else first / _CYCLE_MARGIN, last * _CYCLE_MARGIN
    axes.set_xlim(start, end)
    decades = 10.0 ** np.arange(math.ceil(math.log10(first)), math.floor(math.log10(last)) + 1)
    ticks = sorted({*decades, last})
    across = axes.get_xaxis_transform()
    if has_zero:
        ticks.insert(0, 0.0)
        axes.spines["bottom"].set_bounds(start, end)
        (marks,) = axes.plot([0.45 * first, 0.55 * first], [0, 0], color=MUTED, transform=across)
        marks.set(marker=[(-2.0, -2.0), (0.0, 2.0)], mew=0.6, ms=5, ls="none")
        marks.set(clip_on=False, label="_break")
    # Choose the ticks whose numbers have room: from the last one back, then those between decades.
    between: list[float] = []
    if last < _FEW_DECADES * first:
        powers = 10.0 ** np.arange(math.floor(math.log10(first)), math.ceil(math.log10(last)))
        between = [n for n in np.outer([2.0, 5.0], powers).ravel().tolist() if first <= n < last]
    width = 72.0 * root_figure(axes).get_figwidth() * axes.get_position().width
    texts, taken = dict[float, str](), list[tuple[float, float]]()
    for tick in [*reversed(ticks), *between]:
        place = width * axes.transAxes.inverted().transform(across.transform((tick, 0.0)))[0]
        is_power = tick >= _SPELT_OUT and tick in decades
        text = power_of_ten(round(math.log10(tick))) if is_power else cycle_text(tick)
        half_width = 0.5 * _POINTS_PER_SIGN * len(text)
        room = half_width + _POINTS_PER_SIGN
        if all(abs(place - other) > room + half for other, half in taken):
            texts[tick] = text
            taken.append((place, half_width))
    ticks = sorted({*ticks, *between})
    # Use locators: set_xticks makes every tick at once, even in panels that show none.
    minor = np.outer(decades[0] / 10.0 * 10.0 ** np.arange(10), np.arange(2, 10))
    axes.xaxis.set_major_locator(FixedLocator(ticks))
    axes.xaxis.set_minor_locator(FixedLocator(minor[(minor > first) & (minor <= last)].tolist()))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: texts.get(value, "")))
    axes.xaxis.set_minor_formatter(NullFormatter())


class ValueAxis:
    """The axis of a result: its unit and scale, for values in SI units.

    It is logarithmic if the result allows it and its values span more than a factor of 30.
    """

    def __init__(self, variable: Variable, values: Array) -> None:
        self.variable = variable
        self.is_logarithmic = variable.may_be_logarithmic and _is_wide(values)
        self.unit = variable.unit or readable_unit(values, variable.si_unit)
        if self.is_logarithmic and self.unit.is_power and not variable.unit:
            # A logarithmic axis needs no power of ten in its unit.
            self.unit = readable_unit((), variable.si_unit)
        unit = f"({self.unit.name})" if self.unit.name else ""
        self.label = f"{variable.label} {unit}".rstrip()
        self.wrapped_label = "\n".join(filter(None, [*wrap(variable.label, 18), unit]))

    def colours(self, values: Array) -> Normalize:
        """Return a scale of colours for values in the unit of the axis."""
        shown = _positive(values) if self.is_logarithmic else values[np.isfinite(values)]
        return (LogNorm if self.is_logarithmic else Normalize)(shown.min(), shown.max())

    def set_cycles(self, axes: Axes, cycles: Array, values: Array) -> None:
        """Set the x axis for all values that the y axis can show."""
        set_cycle_axis(axes, cycles[values > 0.0 if self.is_logarithmic else np.isfinite(values)])

    def set_limits(self, axes: Axes, cycles: Array, values: Array) -> None:
        """Set the limits of the y axis for the values of a row of panels.

        Values that hardly change are shown from zero, because an axis that fits them would show
        only noise.
        """
        shown = self.unit.of(values)
        lowest, highest = float(np.nanmin(shown)), float(np.nanmax(shown))
        if self.is_logarithmic and _is_wide(values):
            # Steps before cycle 1 are not on the axis of cycles.
            least = float(_positive(shown[(cycles == 0.0) | (cycles >= 1.0)]).min())
            axes.set_yscale("log", nonpositive="mask")
            axes.set_ylim(max(0.6 * least, _DEEPEST * highest), 1.7 * highest)
            first = 10.0 ** math.ceil(math.log10(axes.get_ylim()[0]))
            # Plain numbers and powers of ten do not mix on an axis.
            is_plain = _PLAIN[0] <= 1.001 * first and highest < _PLAIN[1]
            axes.yaxis.set_major_formatter(FuncFormatter(_plain_text if is_plain else _power_text))
            return
        constant = lowest >= (1.0 - _CONSTANT) * highest
        if self.variable.from_zero or constant:
            axes.set_ylim(0.0, highest * (1.25 if constant else 1.06) or 1.0)


def _plain_text(value: float, _: int | None) -> str:
    return f"{value:g}"


def _power_text(value: float, _: int | None) -> str:
    return power_of_ten(round(math.log10(value)))


def _is_wide(values: Array) -> bool:
    positive = _positive(values)
    return bool(positive.size) and positive.max() > _LOGARITHMIC_FROM * positive.min()


def _positive(values: Array) -> Array:
    return values[np.isfinite(values) & (values > 0.0)]


def parameter_label(name: str, value: float = 1.0) -> str:
    """Return the label of the axis of a parameter: words and unit, as they suit a value."""
    about = parameter(name).suiting(value)
    return f"{about.words} ({about.unit.name})" if about.unit.name else about.words


def make_panels(
    columns: Columns,
    titles: Sequence[str],
    across: int,
    heights: tuple[float, float],
    share_y: Literal["all", "row", "none"] = "all",
    share_x: Literal["all", "row", "none"] = "all",
) -> tuple[JournalFigure, list[Axes]]:
    """Return a figure with a panel for each title, in rows of `across` panels.

    `heights`, mm, are the height around the rows and the height of a row. Only the outer axes have
    labels and numbers, and any that share none.
    """
    down = -(-len(titles) // across)
    figure = JournalFigure(columns, heights[0] + heights[1] * down)
    grid = figure.subplots(down, across, sharex=share_x, sharey=share_y, squeeze=False).ravel()
    for index, axes in enumerate(grid):
        if index >= len(titles):
            axes.remove()
            continue
        lowest, leftmost = index + across >= len(titles), index % across == 0
        axes.set_title(titles[index])
        axes.tick_params(axis="x", which="both", labelbottom=lowest or share_x != "all")
        axes.tick_params(axis="y", which="both", labelleft=leftmost or share_y == "none")
        axes.xaxis.label.set_visible(lowest or share_x == "none")
        axes.yaxis.label.set_visible(leftmost or share_y == "none")
    return figure, list(grid[: len(titles)])


def outside_key(
    figure: Figure,
    handles: Sequence[Artist],
    labels: Sequence[str],
    place: Place = "outside upper left",
    handlelength: float = 2.4,
) -> Legend:
    """Add a key above or below the axes, with as many columns as fit into the figure."""
    options: dict[str, float] = {"handlelength": handlelength, "columnspacing": 1.0}
    for columns in range(len(labels), 0, -1):
        key: Legend = figure.legend(handles, labels, loc=place, ncols=columns, **options)
        if key.get_window_extent().width <= figure.bbox.width or columns == 1:
            break
        key.remove()
    return key


def label_or_key(
    axes: Axes, curves: Sequence[Line2D], labels: Sequence[str], ax: Axes | None
) -> None:
    """Label a few curves directly if there is room; else add a key, within `ax` if it is given."""
    if len(curves) > MOST_LABELLED or not label_curves(axes, curves, labels):
        if ax is None:
            outside_key(root_figure(axes), curves, labels)
        else:
            axes.legend(curves, labels)


def label_curves(axes: Axes, curves: Sequence[Line2D], labels: Sequence[str]) -> bool:
    """Label every curve directly, or label none and return False if a legend is needed.

    The box of a label must be clear of all curves and labels, and nearer to its curve than to any
    other. Successive curves that are indistinguishable share a label, in the colour of the last.
    Call this last, when limits and labels of the axes are final.
    """
    root_figure(axes).draw_without_rendering()
    between = "; " if any("," in label for label in labels) else ", "
    texts: list[Text] = []
    drawn: list[Array] = []
    for curve, label in zip(curves, labels, strict=True):
        points = _pixels(axes, curve)
        if drawn and len(drawn[-1]) and len(points):
            apart = np.hypot(*(drawn[-1][:, None] - points).transpose(2, 0, 1))
            if max(apart.min(axis=0).max(), apart.min(axis=1).max()) <= _INDISTINCT:
                before = texts.pop()
                before.remove()
                label = f"{before.get_text()}{between}{label}"
                points = np.concatenate([drawn.pop(), points])
        color = text_colour(to_hex(curve.get_color()))
        text = axes.text(0.5, 0.5, label, ha="center", va="center_baseline", fontsize=_LABEL_SIZE)
        text.set(transform=axes.transAxes, color=color)
        texts.append(text)
        texts[-1].set_in_layout(False)
        drawn.append(points)
    sizes = [np.ceil(text.get_window_extent().size) + 2 * _LABEL_MARGIN for text in texts]
    there = range(len(texts))
    places = _places(axes, there, drawn, sizes) or _places(axes, there[::-1], drawn, sizes)
    for index, text in enumerate(texts):
        if places:
            text.set_position(tuple(axes.transAxes.inverted().transform(places[index])))
        else:
            text.remove()
    return bool(places)


def _pixels(axes: Axes, curve: Line2D) -> Array:
    """Return pixels along a curve and around its marks, within the axes."""
    figure, transform = root_figure(axes), curve.get_transform()
    step, half = _STEP * max(1.0, figure.dpi / 100.0), curve.get_markersize() * figure.dpi / 144.0
    pixels = [np.empty((0, 2))]
    # Values that a logarithmic axis cannot show are not finite in pixels, and break the line.
    points = transform.transform(curve.get_xydata())
    shown = np.isfinite(points).all(axis=1)
    for line in np.split(points, np.flatnonzero(np.diff(shown)) + 1):
        line = line[np.isfinite(line).all(axis=1)]
        if not len(line):
            continue
        along = np.cumsum(np.hypot(*np.diff(line, axis=0, prepend=line[:1]).T))
        places = np.arange(0.0, along[-1] + step, step)
        pixels.append(np.column_stack([np.interp(places, along, part) for part in line.T]))
    if curve.get_marker() != "None":
        # A square stands for marks of any shape: protruding corners do not identify a curve.
        marks = transform.transform(curve.get_xydata())
        pixels += [marks + half * np.array([i, j]) for i in (-1, 0, 1) for j in (-1, 0, 1)]
    drawn = np.concatenate(pixels)
    return drawn[((drawn >= axes.bbox.min) & (drawn <= axes.bbox.max)).all(axis=1)]


def _places(
    axes: Axes, order: Sequence[int], curves: Sequence[Array], sizes: Sequence[Array]
) -> dict[int, Array]:
    """Place boxes of some sizes beside curves in turn; return their centres, none if one fails."""
    (low, high), taken, places = axes.bbox.get_points(), np.empty((0, 2)), {}
    around = np.array([(i, j) for i in range(-4, 5) for j in range(-4, 5)]) / 8.0
    sides = np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j])
    for index in order:
        size, curve = sizes[index], curves[index]
        centres = curve[:: 1 + len(curve) // _MOST_TRIED, None] + sides * (0.5 * size + 1.0)
        inside = np.abs(centres - 0.5 * (low + high)) < 0.5 * (high - low - size)
        centres = centres[inside.all(axis=-1)]
        others = [taken[:0], *(other for i, other in enumerate(curves) if i != index)]
        # Distance of boxes from the nearest pixel of the curve, of other curves and of labels.
        near, foreign, label = (
            np.linalg.norm(
                np.maximum(np.abs(centres[:, None] - pixels) - 0.5 * size, 0.0), axis=2
            ).min(axis=1, initial=np.inf)
            for pixels in (curve, np.concatenate(others), taken)
        )
        cost = near - 0.6 * np.minimum(foreign, _CLEARANCE) - 0.1 * np.minimum(label, 12.0)
        possible = (near > 0.5) & (near < _REACH) & (label > 2.0)
        possible &= foreign > np.maximum(_INDISTINCT, near) + 0.5
        if not possible.any():
            return {}
        places[index] = centres[np.argmin(np.where(possible, cost, np.inf))]
        taken = np.concatenate([taken, places[index] + size * around])
    return places
