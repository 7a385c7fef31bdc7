"""Pieces that the figures share."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from fretwear.figures.style import CATEGORICAL, MARKERS, MUTED


def points(
    axes: Axes, x: Sequence[float], y: Sequence[float], index: int, label: str, **options: Any
) -> None:
    """Points of one series joined by a line, in the series' color and marker."""
    axes.plot(
        x,
        y,
        marker=MARKERS[index % len(MARKERS)],
        color=CATEGORICAL[index % len(CATEGORICAL)],
        label=label,
        **options,
    )


def slope_guide(axes: Axes, x: Sequence[float], start: float, order: float, label: str) -> None:
    """A thin line that grows like x to a power through (x[0], start)."""
    first, last = x[0], x[-1]
    end = start * (last / first) ** order
    axes.plot([first, last], [start, end], color=MUTED, lw=0.7, ls=(0, (4, 2)))
    axes.annotate(label, (last, end), color=MUTED, fontsize=6.5, ha="left", va="center")


def allowed(axes: Axes, deviation: float, label: str) -> None:
    """Shade the deviations that are allowed."""
    axes.axhspan(-deviation, deviation, color="#eaf3ea", lw=0, zorder=0)
    axes.annotate(
        label, (1.0, deviation), xycoords=("axes fraction", "data"), fontsize=6.5, color=MUTED,
        ha="right", va="bottom", xytext=(-2, 1), textcoords="offset points",
    )  # fmt: skip


def order_of(spacing: Sequence[float], error: Sequence[float]) -> float:
    """Order of convergence: the slope of log |error| against log spacing, least squares."""
    return float(np.polyfit(np.log(spacing), np.log(np.abs(error)), 1)[0])
