"""The y axis of quantities over the cycles: linear or logarithmic, and from where to where."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter
from numpy.typing import ArrayLike, NDArray

from fretwear.figures.wording import Unit, plain_unit, readable_unit

Array = NDArray[np.float64]

_LOGARITHMIC_FROM = 30.0
_DEEPEST = 1e-6
_CONSTANT = 0.03
_PLAIN = (1e-3, 1e4)


def is_wide(values: ArrayLike) -> bool:
    """Tell whether positive values span so much that a logarithmic axis shows them better."""
    positive = _positive(values)
    return bool(positive.size) and positive.max() > _LOGARITHMIC_FROM * positive.min()


def unit_of_axis(values: ArrayLike, base: str, logarithmic: bool) -> Unit:
    """Return the unit for an axis; a logarithmic one needs no power of ten in it."""
    unit = readable_unit(values, base)
    return plain_unit(base) if logarithmic and unit.is_power else unit


def set_linear_axis(axes: Axes, values: ArrayLike, from_zero: bool) -> None:
    """Set the limits of a linear y axis.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        The axes, everything drawn.
    values : array_like
        The values shown, in the unit of the axis.
    from_zero : bool
        Whether the axis begins at zero. Values that hardly change are always shown so: what is
        left of them on an axis of their own is nothing but noise.
    """
    shown = np.asarray(values, dtype=np.float64)
    highest = float(np.nanmax(shown))
    constant = float(np.nanmin(shown)) > (1.0 - _CONSTANT) * highest
    if from_zero or constant:
        axes.set_ylim(0.0, highest * (1.25 if constant else 1.06) or 1.0)


def set_logarithmic_axis(axes: Axes, values: ArrayLike) -> None:
    """Make the y axis logarithmic; `values` are those shown, in the unit of the axis."""
    positive = _positive(values)
    highest = float(positive.max())
    axes.set_yscale("log", nonpositive="mask")
    axes.set_ylim(max(0.6 * float(positive.min()), _DEEPEST * highest), 1.7 * highest)
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: _tick_text(value)))


def _tick_text(value: float) -> str:
    if _PLAIN[0] <= value < _PLAIN[1]:
        return f"{value:g}"
    return f"$10^{{{round(math.log10(value))}}}$"


def _positive(values: ArrayLike) -> Array:
    array = np.asarray(values, dtype=np.float64)
    return array[np.isfinite(array) & (array > 0.0)]
