"""Fields on the cells of a window."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Single = NDArray[np.float32]
Spectrum = NDArray[np.complexfloating[Any, Any]]
Mask = NDArray[np.bool_]
# A field in double or in single precision; what goes in is what comes out.
Real = TypeVar("Real", Array, Single)


def inner(a: Real, b: Real) -> float:
    """Sum of the products of two fields.

    Not by BLAS: its threads gain nothing here, stand in the way of cases that run side by side,
    and make the last bits depend on their number.
    """
    return float(np.einsum("ij,ij->", a, b))
