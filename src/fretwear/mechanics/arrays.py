"""Fields on the cells of a window."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Spectrum = NDArray[np.complex128]
Mask = NDArray[np.bool_]


def inner(a: Array, b: Array) -> float:
    """Sum of the products of two fields.

    Not by BLAS: its threads gain nothing here, stand in the way of cases that run side by side,
    and make the last bits depend on their number.
    """
    return float(np.einsum("ij,ij->", a, b))
