"""Axes of cycles and of values, grids of panels, keys, and labels beside curves."""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from textwrap import wrap
from typing import Literal

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.text import Text
from matplotlib.ticker import FixedLocator, FuncFormatter, NullFormatter
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

from fretwear.figures.style import MUTED, root_figure, text_colour
from fretwear.units import Unit, cycle_text, readable_unit, smallest_unit
from fretwear.vocabulary import Variable

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Place = Literal["outside upper left", "outside lower left"]
"""Where a key stands, as matplotlib's legends name it."""

_ZERO_GAP = 0.7
_CYCLE_MARGIN = 1.25
_SPELT_OUT = 10_000.0
_POINTS_PER_SIGN = 4.5

_LOGARITHMIC_FROM = 30.0
_DEEPEST = 1e-6
_CONSTANT = 0.03
_PLAIN = (1e-3, 1e4)

_MOST_LABELLED = 6
_LABEL_SIZE = 6.5
_LABEL_MARGIN = 2
_REACH = 7.0
_CLEARANCE = 15.0
_INDISTINCT = 2.0


def set_cycle_axis(axes: Axes, cycles: ArrayLike) -> None:
    """Make the x axis of `axes` one of cycles.

    From the first cycle on the axis is logarithmic. Cycle 0 stands to the left of a break, since
    its distance from the first snapshot means nothing on such an axis. When all cycles lie within
    one decade the axis is linear. The last cycle is named, and so is every decade that leaves
    room for its number.
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
    if has_zero:
        axes.spines["bottom"].set_bounds(start, end)
        _draw_break(axes, 0.5 * first)
    decades = 10.0 ** np.arange(math.ceil(math.log10(first)), math.floor(math.log10(last)) + 1)
    major = sorted({0.0, *decades, last} if has_zero else {*decades, last})
    minor = (decades[0] / 10.0) * 10.0 ** np.arange(10)[:, None] * np.arange(2, 10)
    named = _ticks_with_room(axes, major)
    axes.xaxis.set_major_locator(FixedLocator(major))
    axes.xaxis.set_minor_locator(FixedLocator(minor[(minor > first) & (minor <= last)].tolist()))
    axes.xaxis.set_major_formatter(
        FuncFormatter(lambda value, _: _cycle_tick(value) if value in named else "")
    )
    axes.xaxis.set_minor_formatter(NullFormatter())


def _ticks_with_room(axes: Axes, ticks: Sequence[float]) -> set[float]:
    """Return the ticks whose numbers have room, counted from the last one back."""
    width = 72.0 * root_figure(axes).get_figwidth() * axes.get_position().width
    along = axes.get_xaxis_transform().transform([(tick, 0.0) for tick in ticks])
    places = width * axes.transAxes.inverted().transform(along)[:, 0]
    named, end = set(), math.inf
    for tick, place in zip(reversed(ticks), reversed(places), strict=True):
        signs = 3 if _is_power(tick) else len(cycle_text(tick))
        half_width = 0.5 * _POINTS_PER_SIGN * signs
        if float(place) + half_width < end - _POINTS_PER_SIGN:
            named.add(tick)
            end = float(place) - half_width
    return named


def _is_power(value: float) -> bool:
    exponent = math.log10(value) if value > 0.0 else 0.0
    return value >= _SPELT_OUT and abs(exponent - round(exponent)) < 1e-9


def _cycle_tick(value: float) -> str:
    return f"$10^{{{round(math.log10(value))}}}$" if _is_power(value) else cycle_text(value)


def _draw_break(axes: Axes, position: float) -> None:
    axes.plot(
        [0.9 * position, 1.1 * position],
        [0.0, 0.0],
        linestyle="none",
        marker=[(-2.0, -2.0), (0.0, 2.0)],
        markersize=5,
        color=MUTED,
        markeredgewidth=0.6,
        transform=axes.get_xaxis_transform(),
        clip_on=False,
        label="_break",
    )


@dataclass(frozen=True)
class ValueAxis:
    """The y axis of a result over the cycles: its unit, and whether it is logarithmic.

    It is where the result may be and its values span more than a factor of 30.
    """

    variable: Variable
    unit: Unit
    is_logarithmic: bool

    @classmethod
    def of(cls, variable: Variable, values: Array) -> ValueAxis:
        """Return the axis for values in SI units."""
        logarithmic = variable.may_be_logarithmic and _is_wide(values)
        unit = variable.unit or unit_of_axis(values, variable.si_unit, logarithmic)
        return cls(variable, unit, logarithmic)

    @property
    def label(self) -> str:
        """What the axis says."""
        return f"{self.variable.label} ({self.unit.name})"

    @property
    def wrapped_label(self) -> str:
        """What the axis says, on lines of a few words, for low panels."""
        lines = wrap(self.variable.label, 18)
        return "\n".join([*lines, f"({self.unit.name})"])

    def set_cycles(self, axes: Axes, cycles: Array, values: Array) -> None:
        """Set the x axis for all values; on a logarithmic y axis those of zero have no place."""
        set_cycle_axis(axes, cycles[values > 0.0 if self.is_logarithmic else np.isfinite(values)])

    def set_limits(self, axes: Axes, cycles: Array, values: Array) -> None:
        """Set limits that show some of the values, those of a row of panels.

        Values that hardly change are shown from zero: what is left of them on an axis of their
        own is nothing but noise.
        """
        shown = self.unit.of(values)
        lowest, highest = float(np.nanmin(shown)), float(np.nanmax(shown))
        if self.is_logarithmic and _is_wide(values):
            # Steps before cycle 1 are not on the axis of cycles.
            least = float(_positive(shown[(cycles == 0.0) | (cycles >= 1.0)]).min())
            axes.set_yscale("log", nonpositive="mask")
            axes.set_ylim(max(0.6 * least, _DEEPEST * highest), 1.7 * highest)
            axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: _value_tick(value)))
            return
        constant = lowest > (1.0 - _CONSTANT) * highest
        if self.variable.from_zero or constant:
            axes.set_ylim(0.0, highest * (1.25 if constant else 1.06) or 1.0)


def unit_of_axis(values: Array, si_unit: str, logarithmic: bool) -> Unit:
    """Return the unit for an axis; a logarithmic one needs no power of ten in it."""
    unit = readable_unit(values, si_unit)
    return smallest_unit(si_unit) if logarithmic and unit.is_power else unit


def _value_tick(value: float) -> str:
    plain = _PLAIN[0] <= value < _PLAIN[1]
    return f"{value:g}" if plain else f"$10^{{{round(math.log10(value))}}}$"


def _is_wide(values: Array) -> bool:
    positive = _positive(values)
    return bool(positive.size) and positive.max() > _LOGARITHMIC_FROM * positive.min()


def _positive(values: Array) -> Array:
    return values[np.isfinite(values) & (values > 0.0)]


def make_panels(
    figure: Figure,
    count: int,
    across: int,
    share_y: Literal["row", "all"],
    share_x: Literal["row", "all"] = "all",
) -> list[Axes]:
    """Return `count` axes in rows of `across`, the last row perhaps shorter."""
    grid = figure.subplots(
        -(-count // across), across, sharex=share_x, sharey=share_y, squeeze=False
    )
    for axes in grid.flat[count:]:
        axes.remove()
    return list(grid.flat[:count])


def label_outer(panels: Sequence[Axes], across: int, *, every_x: bool = False) -> None:
    """Keep labels and numbers only at the left end of a row and the lower end of each column.

    With `every_x` every row has an x axis of its own, and keeps its numbers.
    """
    for index, axes in enumerate(panels):
        lowest = index + across >= len(panels)
        axes.tick_params(axis="x", which="both", labelbottom=lowest or every_x)
        if not lowest:
            axes.set_xlabel("")
        axes.tick_params(axis="y", which="both", labelleft=index % across == 0)
        if index % across:
            axes.set_ylabel("")


def outside_key(
    figure: Figure,
    handles: Sequence[Artist],
    labels: Sequence[str],
    place: Place = "outside upper left",
    handlelength: float = 2.4,
) -> Legend:
    """Add a key above or below the axes, in as many columns as the width of the figure holds.

    The figure has a constrained layout; `handlelength` is in font sizes.
    """
    key: Legend
    for columns in range(len(labels), 0, -1):
        key = figure.legend(
            handles, labels, loc=place, ncols=columns, handlelength=handlelength, columnspacing=1.0
        )
        width = key.get_window_extent().width
        if width <= figure.bbox.width or columns == 1:
            break
        key.remove()
    return key


def label_or_key(
    figure: Figure, axes: Axes, curves: Sequence[Line2D], labels: Sequence[str], *, outside: bool
) -> None:
    """Label curves beside themselves where they are few and have room; else add a key."""
    if len(curves) <= _MOST_LABELLED and label_curves(axes, curves, labels):
        return
    if outside:
        outside_key(figure, curves, labels)
    else:
        axes.legend(curves, labels)


def label_curves(axes: Axes, curves: Sequence[Line2D], labels: Sequence[str]) -> bool:
    """Label every curve beside itself, or none of them.

    A place is taken when the text box is clear of all curves and labels, and nearer to its own
    curve than to any other. Successive curves that cannot be told apart have one label, in the
    last one's colour. Call this last, when limits and labels of the axes are final. Where there is
    no room, the result is False: nothing was added, and a legend is called for.
    """
    root_figure(axes).draw_without_rendering()
    texts: list[Text] = []
    masks: list[Mask] = []
    for curve, label in zip(curves, labels, strict=True):
        mask = _covered(axes, curve)
        if masks and _coincide(masks[-1], mask):
            before = texts.pop()
            before.remove()
            label, mask = f"{before.get_text()}, {label}", mask | masks.pop()
        texts.append(_add_text(axes, label, to_hex(curve.get_color())))
        masks.append(mask)
    boxes = [text.get_window_extent() for text in texts]
    margin = 2 * _LABEL_MARGIN
    sizes = [(math.ceil(box.height) + margin, math.ceil(box.width) + margin) for box in boxes]
    distances = [_distance(mask) for mask in masks]
    there = list(range(len(texts)))
    found = [_placed(order, distances, sizes) for order in (there, there[::-1])]
    cheapest = min((each for each in found if each), key=lambda each: each[0], default=None)
    if cheapest is None:
        for text in texts:
            text.remove()
        return False
    height, width = masks[0].shape
    for text, (row, column) in zip(texts, cheapest[1], strict=True):
        text.set_position(((column + 0.5) / width, (row + 0.5) / height))
    return True


def _add_text(axes: Axes, label: str, color: str) -> Text:
    text = axes.text(
        0.5,
        0.5,
        label,
        color=text_colour(color),
        fontsize=_LABEL_SIZE,
        ha="center",
        va="center_baseline",
        transform=axes.transAxes,
    )
    text.set_in_layout(False)
    return text


def _covered(axes: Axes, curve: Line2D) -> Mask:
    """Return the pixels of the axes that a curve and its marks cover."""
    figure = root_figure(axes)
    width, height = figure.bbox.size
    renderer = RendererAgg(width, height, figure.dpi)  # type: ignore[no-untyped-call]
    drawn = copy(curve)
    if drawn.get_marker() != "None":
        # Marks of one shape: a corner that juts out from another curve's mark tells no curve.
        drawn.set_marker("s")
    drawn.draw(renderer)
    opaque = np.asarray(renderer.buffer_rgba())[..., 3] > 127  # type: ignore[no-untyped-call]
    left, bottom, right, top = (round(edge) for edge in axes.bbox.extents)
    return opaque[::-1][bottom:top, left:right]


def _coincide(first: Mask, second: Mask) -> bool:
    if not (first.any() and second.any()):
        return False
    apart = max(_distance(first)[second].max(), _distance(second)[first].max())
    return bool(apart <= _INDISTINCT)


def _distance(mask: Mask) -> Array:
    """Return each pixel's distance from the nearest covered one."""
    if not mask.any():
        return np.full(mask.shape, float(max(mask.shape)))
    return np.asarray(ndimage.distance_transform_edt(~mask), dtype=np.float64)


def _placed(
    order: Sequence[int], distances: Sequence[Array], sizes: Sequence[tuple[int, int]]
) -> tuple[float, list[tuple[int, int]]] | None:
    """Place labels one after the other; return cost and centres, None when one has no room."""
    taken = np.zeros(distances[0].shape, dtype=bool)
    places: dict[int, tuple[int, int]] = {}
    total = 0.0
    for index in order:
        others = [each for other, each in enumerate(distances) if other != index]
        foreign = np.minimum.reduce([*others, np.full(taken.shape, np.inf)])
        cost = _cost(distances[index], foreign, _distance(taken), sizes[index])
        row, column = (int(place) for place in np.unravel_index(np.argmin(cost), cost.shape))
        if not np.isfinite(cost[row, column]):
            return None
        total += float(cost[row, column])
        places[index] = row, column
        height, width = sizes[index]
        bottom, left = row - height // 2, column - width // 2
        taken[max(bottom, 0) : bottom + height, max(left, 0) : left + width] = True
    return total, [places[index] for index in range(len(distances))]


def _cost(own: Array, foreign: Array, labels: Array, size: tuple[int, int]) -> Array:
    """Return the cost of a box of `size` pixels about each pixel, infinite where it has no room.

    `own`, `foreign` and `labels` are the distances from the label's curve, from the other curves
    and from the labels that have a place.
    """
    nearest_own, nearest_foreign, nearest_label = (
        ndimage.minimum_filter(distance, size=size) for distance in (own, foreign, labels)
    )
    possible = (nearest_own > 0.5) & (nearest_own < _REACH) & (nearest_label > 2.0)
    possible &= nearest_foreign > np.maximum(_INDISTINCT, nearest_own) + 0.5
    rows, columns = size[0] // 2 + 1, size[1] // 2 + 1
    inside = np.zeros_like(possible)
    inside[rows:-rows, columns:-columns] = True
    cost = nearest_own - 0.6 * np.minimum(nearest_foreign, _CLEARANCE)
    cost -= 0.1 * np.minimum(nearest_label, 12.0)
    return np.where(possible & inside, cost, np.inf)
