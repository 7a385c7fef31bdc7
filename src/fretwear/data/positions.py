"""Positions and cycles that datasets have in common, and values brought to them."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np
from numpy.typing import NDArray


def resampled(
    values: NDArray[Any], cells: NDArray[np.float64], positions: NDArray[np.float64], axis: int
) -> NDArray[Any]:
    """Bring n values at cell centres to m other positions, both in m, along one axis.

    Physical quantities are interpolated linearly; states, which are whole numbers, are those of
    the nearest cell. At a cell centre the value is that of the cell to the last bit. Beyond the
    outermost cells, and nearer the middle than the first cell of one side, it stays that of the
    cell; cells that are all positive are one side of a contact that is even.
    """
    if np.array_equal(cells, positions):
        return values
    where = np.abs(positions) if cells[0] > 0.0 else positions
    lower = np.clip(np.searchsorted(cells, where, side="right") - 1, 0, cells.size - 2)
    weight = (where - cells[lower]) / (cells[lower + 1] - cells[lower])
    weight = np.clip(weight, 0.0, 1.0)
    along = np.moveaxis(values, axis, -1)
    if values.dtype.kind == "f":
        between = (1.0 - weight) * along[..., lower] + weight * along[..., lower + 1]
    else:
        between = along[..., lower + (weight >= 0.5)]
    return np.moveaxis(between.astype(values.dtype), -1, axis)


def positions_inside(
    cells: NDArray[np.float64], positions: NDArray[np.float64]
) -> NDArray[np.intp]:
    """Return which positions are not beyond the outermost cell centres, both in m."""
    return np.flatnonzero(np.abs(positions) <= np.abs(cells).max() * (1.0 + 1e-12))


def representative_cycles(available: Collection[int], most: int = 6) -> tuple[int, ...]:
    """Return at most `most` cycles, first and last included, whose profiles differ.

    They are evenly spread in the fourth root of the cycle: in the logarithm too many early ones
    would be among them.
    """
    ordered = sorted(available)
    if len(ordered) <= most:
        return tuple(ordered)
    position = np.asarray(ordered, dtype=np.float64) ** 0.25
    wanted = np.linspace(position[0], position[-1], most)
    nearest = {int(np.abs(position - level).argmin()) for level in wanted}
    return tuple(ordered[index] for index in sorted(nearest | {0, len(ordered) - 1}))
