"""Fields on the cells of a window."""

from __future__ import annotations

from math import isfinite
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Single = NDArray[np.float32]
Spectrum = NDArray[np.complexfloating[Any, Any]]
Mask = NDArray[np.bool_]
# A field in double or in single precision; what goes in is what comes out.
Real = TypeVar("Real", Array, Single)


def is_finite(field: Array) -> bool:
    """Whether every value of a field is finite, and their sum."""
    return isfinite(float(field.sum()))


def blocks_of_rows(shape: tuple[int, ...], cells: int) -> list[slice]:
    """The rows of a field in blocks of so many cells at most, but of one row at least.

    What is done to a block, one operation after the other, stays in a core's cache.
    """
    count, length = shape
    rows = max(1, cells // length)
    return [slice(first, min(first + rows, count)) for first in range(0, count, rows)]
