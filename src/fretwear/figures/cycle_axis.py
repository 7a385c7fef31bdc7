"""An axis of cycles that is logarithmic and still shows cycle 0."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator, FuncFormatter, NullFormatter
from numpy.typing import ArrayLike

from fretwear.figures.style import MUTED
from fretwear.figures.wording import cycle_number

_ZERO_GAP = 0.7
_MARGIN = 1.25
_SPELT_OUT = 10_000.0
_POINTS_PER_SIGN = 4.5


def set_cycle_axis(axes: Axes, cycles: ArrayLike, label: str = "Cycle") -> None:
    """Make the x axis of `axes` one of cycles.

    From the first cycle on the axis is logarithmic. Cycle 0 stands to the left of a break, since
    its distance from the first snapshot means nothing on such an axis. When all cycles lie within
    one decade the axis is linear. The last cycle is named, and so is every decade that leaves
    room for its number.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        The axes to change.
    cycles : array_like
        The cycles shown.
    label : str
        Label of the axis.
    """
    values = np.asarray(cycles, dtype=np.float64)
    values = values[np.isfinite(values)]
    last = float(values.max(initial=0.0))
    first = max(1.0, float(values[values > 0.0].min(initial=np.inf)))
    axes.set_xlabel(label)
    if not math.isfinite(first) or last < 10.0 * first:
        axes.margins(x=0.04)
        return
    axes.set_xscale("symlog", linthresh=first, linscale=_ZERO_GAP)
    has_zero = bool((values < first).any())
    axes.set_xlim(0.0 if has_zero else first / _MARGIN, last * _MARGIN)
    if has_zero:
        axes.spines["bottom"].set_bounds(-0.06 * first, last * _MARGIN)
        axes.set_xlim(-0.06 * first, last * _MARGIN)
        _draw_break(axes, 0.5 * first)
    _set_ticks(axes, first, last, has_zero)


def _set_ticks(axes: Axes, first: float, last: float, has_zero: bool) -> None:
    decades = 10.0 ** np.arange(math.ceil(math.log10(first)), math.floor(math.log10(last)) + 1)
    start = 10.0 ** math.floor(math.log10(first))
    minor = (start * 10.0 ** np.arange(8)[:, None] * np.arange(2, 10)).ravel()
    major = [0.0, *decades] if has_zero else list(decades)
    major = major if last in major else [*major, last]
    named = _named(axes, major)
    axes.xaxis.set_major_locator(FixedLocator(major))
    axes.xaxis.set_minor_locator(FixedLocator(minor[(minor > first) & (minor <= last)].tolist()))
    axes.xaxis.set_major_formatter(
        FuncFormatter(lambda value, _: _tick_text(value) if value in named else "")
    )
    axes.xaxis.set_minor_formatter(NullFormatter())


def _named(axes: Axes, ticks: Sequence[float]) -> set[float]:
    """Return the ticks whose numbers have room, counted from the last one back."""
    figure = axes.get_figure(root=True)
    width = 72.0 * (figure.get_figwidth() if figure else 1.0) * axes.get_position().width
    along = axes.get_xaxis_transform().transform([(tick, 0.0) for tick in ticks])
    places = width * axes.transAxes.inverted().transform(along)
    named = {ticks[-1]}
    end = float(places[-1, 0]) - _half_width(ticks[-1])
    for tick, (place, _) in reversed(list(zip(ticks, places, strict=True))[:-1]):
        if float(place) + _half_width(tick) < end - _POINTS_PER_SIGN:
            named.add(tick)
            end = float(place) - _half_width(tick)
    return named


def _half_width(tick: float) -> float:
    """Return half the width in points of a tick's number."""
    signs = 3 if _is_power(tick) else len(cycle_number(tick))
    return 0.5 * _POINTS_PER_SIGN * signs


def _is_power(value: float) -> bool:
    exponent = math.log10(value) if value > 0.0 else 0.0
    return value >= _SPELT_OUT and abs(exponent - round(exponent)) < 1e-9


def _tick_text(value: float) -> str:
    return f"$10^{{{round(math.log10(value))}}}$" if _is_power(value) else cycle_number(value)


def _draw_break(axes: Axes, position: float) -> None:
    across = axes.get_xaxis_transform()
    gap = [(-2.0, -2.0), (0.0, 2.0)]
    for offset in (-0.10, 0.10):
        axes.plot(
            [position * (1.0 + offset)],
            [0.0],
            marker=gap,
            markersize=5,
            color=MUTED,
            markeredgewidth=0.6,
            transform=across,
            clip_on=False,
            label="_break",
        )
