"""Exponents of growth."""

from collections.abc import Sequence

import numpy as np


def exponent(size: Sequence[float], amount: Sequence[float], last: int | None = None) -> float:
    """Power with which an amount grows with a size: slope of the logarithms, least squares.

    ``last`` takes only so many of the largest sizes, where constant costs no longer count.
    """
    first = 0 if last is None else max(0, len(size) - last)
    if len(size) - first < 2:
        return float("nan")
    slope, _ = np.polyfit(np.log(size[first:]), np.log(amount[first:]), 1)
    return float(slope)
