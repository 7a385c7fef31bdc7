"""Values at cell centres of a case brought to positions that several cases share."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray


class Resampling:
    """From the cells of one case to other positions, along one direction.

    Parameters
    ----------
    nodes : numpy.ndarray, shape (n,)
        Cell centres in m, increasing; all positive for the quarter of a contact that is even.
    positions : numpy.ndarray, shape (m,)
        Where values are wanted, m.
    """

    def __init__(self, nodes: NDArray[np.float64], positions: NDArray[np.float64]) -> None:
        self._nodes = nodes
        self._positions = positions

    @property
    def is_outside(self) -> NDArray[np.bool_]:
        """Where a position lies beyond the last cell centre, shape (m,)."""
        outermost = float(np.abs(self._nodes).max())
        return np.asarray(np.abs(self._positions) > outermost * (1.0 + 1e-12))

    def linear(self, values: NDArray[Any], axis: int) -> NDArray[Any]:
        """Interpolate linearly; beyond the outermost cells the values there go on.

        Where a position is a cell centre, the value is that of the cell to the last bit. A
        quarter is even, so that nearer the middle than its first cell the value there goes on.

        Parameters
        ----------
        values : numpy.ndarray
            n values along `axis`.
        axis : int
            Which one.

        Returns
        -------
        numpy.ndarray
            m values along `axis`, type as given.
        """
        lower, weight = self._places
        upper = np.minimum(lower + 1, self._nodes.size - 1)
        weight = weight.reshape([-1 if i == axis else 1 for i in range(values.ndim)])
        below, above = np.take(values, lower, axis), np.take(values, upper, axis)
        return np.asarray((1.0 - weight) * below + weight * above).astype(values.dtype)

    def nearest(self, values: NDArray[Any], axis: int) -> NDArray[Any]:
        """Take the value of the nearest cell; arguments as for `linear`."""
        lower, weight = self._places
        return np.take(values, lower + (weight >= 0.5), axis)

    @cached_property
    def _places(self) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
        """Cell below each position, and how far the position is on the way to the next."""
        nodes = self._nodes
        where = np.abs(self._positions) if nodes[0] > 0.0 else self._positions
        lower = np.clip(np.searchsorted(nodes, where, side="right") - 1, 0, nodes.size - 2)
        weight = (where - nodes[lower]) / (nodes[lower + 1] - nodes[lower])
        return lower, np.clip(weight, 0.0, 1.0)
