"""Arrays by the type of their elements, for signatures."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Single = NDArray[np.float32]
Mask = NDArray[np.bool_]
Places = NDArray[np.intp]
# Whether something is even along x and along y.
Even = tuple[bool, bool]
# The type of the elements of a field, which its result shares.
Element = TypeVar("Element", bound=np.generic)
# A field in double or single precision; the result has the precision of the argument.
Real = TypeVar("Real", Array, Single)
