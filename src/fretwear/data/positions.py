"""Positions and cycles common to datasets, and interpolation to them."""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from fretwear.data.files import CaseFile


MOST_POSITIONS = 4096
"""Most positions on either side of the middle that cases share."""


class Window(NamedTuple):
    """Resolution and extent of a case along one direction, m, and on which sides."""

    spacing: float
    length: float
    is_whole: bool

    @classmethod
    def of(cls, file: CaseFile, name: str) -> Window:
        """Return the window of a case along x or y."""
        cells = file.read(name)
        is_whole = bool(cells[0] < 0.0)
        inner, outer = float(cells[0]), float(cells[-1])
        spacing = (outer - inner) / (cells.size - 1) if is_whole else 2.0 * inner
        return cls(spacing, outer + 0.5 * spacing, is_whole)


def common_positions(windows: Collection[Window]) -> NDArray[np.float64]:
    """Return positions, m, common to all cases.

    They are centres of cells as fine as the finest case's, to the end of the largest window:
    where all cases have one spacing, these are their own cells and nothing is interpolated.
    Above `MOST_POSITIONS` on a side the spacing is as fine as that many allow.
    """
    spacing = min(window.spacing for window in windows)
    length = max(window.length for window in windows)
    # The margin keeps a division's last bit from adding a cell.
    number = math.ceil(length / spacing * (1.0 - 1e-9))
    if number > MOST_POSITIONS:
        number, spacing = MOST_POSITIONS, length / MOST_POSITIONS
    x = (np.arange(number, dtype=np.float64) + 0.5) * spacing
    return np.concatenate([-x[::-1], x]) if any(window.is_whole for window in windows) else x


def resampled(
    values: NDArray[Any], cells: NDArray[np.float64], positions: NDArray[np.float64], axis: int
) -> NDArray[Any]:
    """Interpolate n values at cell centres to m other positions, both in m, along one axis.

    Physical quantities are interpolated linearly; states, which are whole numbers, are those of the
    nearest cell. At a cell centre the value is that of the cell to the last bit. Beyond the
    outermost cells, and between the axis and the first cell of a one-sided array, it is constant;
    positive positions alone are one side of an even contact.
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

    They are evenly spaced in the fourth root of the cycle; the logarithm would select too many
    early ones.
    """
    ordered = sorted(available)
    if len(ordered) <= most:
        return tuple(ordered)
    position = np.asarray(ordered, dtype=np.float64) ** 0.25
    wanted = np.linspace(position[0], position[-1], most)
    nearest = {int(np.abs(position - level).argmin()) for level in wanted}
    return tuple(ordered[index] for index in sorted(nearest | {0, len(ordered) - 1}))
