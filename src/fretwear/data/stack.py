"""The fields of all cases of a study as one dataset, on positions that all cases share."""

from __future__ import annotations

import math
from collections.abc import Collection
from contextlib import AbstractContextManager, closing
from numbers import Integral
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import netCDF4
import numpy as np
from numpy.typing import NDArray

from fretwear.data.files import open_summary, opened_case
from fretwear.vocabulary import (
    CASE_ID,
    CYCLE,
    FIELDS,
    STATUS,
    PointStatus,
    Variable,
    Y,
    contact_frame,
)

if TYPE_CHECKING:
    import xarray as xr

_CHUNK_BYTES = 32 << 20

NOT_DONE = -1
"""Value of ``contact_state`` at missing points and cycles, where other fields are NaN."""

MOST_POSITIONS = 4096
"""Largest number of shared positions on either side of the middle."""


_Window = tuple[float, float, bool]
"""Spacing and extent of a case along one direction, m, and whether it has both sides."""


def window(cells: NDArray[np.float64]) -> _Window:
    """Return the window of a case with these cells along x or y."""
    is_whole = bool(cells[0] < 0.0)
    inner, outer = float(cells[0]), float(cells[-1])
    spacing = (outer - inner) / (cells.size - 1) if is_whole else 2.0 * inner
    return spacing, outer + 0.5 * spacing, is_whole


def common_positions(windows: Collection[_Window]) -> NDArray[np.float64]:
    """Return positions, m, common to all cases.

    They are the centres of cells of the finest spacing, up to the end of the largest window; if all
    cases have one spacing, these are the cells of the cases, and interpolation changes no value.
    More than `MOST_POSITIONS` on a side are replaced by that many, spaced wider.
    """
    spacings, lengths, are_whole = zip(*windows, strict=True)
    spacing, length = min(spacings), max(lengths)
    # The margin keeps the last bit of the division from adding a cell.
    number = math.ceil(length / spacing * (1.0 - 1e-9))
    if number > MOST_POSITIONS:
        number, spacing = MOST_POSITIONS, length / MOST_POSITIONS
    x = (np.arange(number, dtype=np.float64) + 0.5) * spacing
    return np.concatenate([-x[::-1], x]) if any(are_whole) else x


def resampled(
    values: NDArray[Any], cells: NDArray[np.float64], positions: NDArray[np.float64], axis: int
) -> NDArray[np.generic]:
    """Interpolate n values at cell centres to m other positions, both in m, along one axis.

    Physical quantities are interpolated linearly, and equal the value of the cell to the last bit
    at its centre; a state, which is a whole number, is taken from the nearest cell. Values are
    constant beyond the outermost cells, and between the axis and the first cell of a one-sided
    array. Cells that are all positive are one side of an even contact.
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
    """Return at most `most` cycles, first and last included, evenly spaced in their fourth root.

    Profiles at these cycles differ visibly; a logarithmic spacing would select too many early ones.
    """
    ordered = sorted(available)
    if len(ordered) > most:
        position = np.asarray(ordered, dtype=np.float64) ** 0.25
        levels = np.linspace(position[0], position[-1], most)
        nearest = {int(np.abs(position - level).argmin()) for level in levels}
        ordered = [ordered[index] for index in sorted(nearest)]
    return tuple(ordered)


def empty_value(field: Variable) -> float:
    """Return the value of a field at missing points and cycles."""
    return NOT_DONE if field.flags else math.nan


def open_study(path: str | PathLike[str]) -> xr.Dataset:
    """Open the merged study together with the fields of all its cases.

    Fields are dask arrays that read one case at a time, so a reduction over any number of cases
    needs little memory: ``open_study("results/demo").wear_depth.max(("x", "y")).compute()``.
    Unless all cases have the same grid spacing, fields are interpolated to the cells of the finest
    case in the largest window; ``contact_state`` is taken from the nearest cell. Outside the window
    of a case the surfaces do not touch and the gap is NaN. Where a point is not done or lacks the
    snapshot, all fields are NaN and ``contact_state`` is `NOT_DONE`.

    Parameters
    ----------
    path : str or path-like
        Folder of the results of a study, with ``summary.nc`` and the folder ``cases``.

    Returns
    -------
    xarray.Dataset
        The merged study and every field, dimensions (…, ``cycle``, ``x``, ``y``), in line contacts
        (…, ``cycle``, ``x``).

    Raises
    ------
    DataFileError
        If the merged study or one of its case files is missing or damaged.
    """
    # dask takes a while to import, and only this function needs it.
    import dask.array as da
    import xarray as xr

    folder = Path(path)
    summary = open_summary(folder / "summary.nc")
    status, ids = summary[STATUS.name], summary[CASE_ID.name].to_numpy()
    files, windows = np.full(status.shape, None), set()
    for position in map(tuple, np.argwhere(status.to_numpy() == PointStatus.DONE)):
        files[position] = folder / "cases" / f"{ids[position]}.nc"
        with opened_case(files[position]) as file:
            if Y.name in file.variables:
                windows.add(window(file[Y.name][:]))
    # The lock that xarray uses for the netCDF library, which is not thread-safe.
    with closing(xr.backends.NetCDF4DataStore.open(folder / "summary.nc")) as store:  # type: ignore[no-untyped-call]
        lock = store.lock
    stacked, dims = summary.copy(), contact_frame(summary.variables).dims
    if windows:
        stacked = stacked.assign_coords({Y.name: (Y.name, common_positions(windows), Y.attributes)})
    axes = tuple(stacked[name].to_numpy() for name in dims)
    for field in FIELDS:
        array = _StackedField(files, field, axes, lock)
        cycle_bytes = math.prod(array.shape[files.ndim + 1 :]) * array.dtype.itemsize
        cycles = min(axes[0].size, max(1, _CHUNK_BYTES // cycle_bytes))
        chunks = (*(1 for _ in files.shape), cycles, *(axis.size for axis in axes[1:]))
        lazy = da.from_array(array, chunks, name=False)  # type: ignore[no-untyped-call]
        stacked[field.name] = ((*status.dims, *dims), lazy, field.attributes)
    stacked.set_close(summary.close)
    return stacked


class _StackedField:
    """One field of all cases as one array; indexing reads the case files.

    The files are arranged like the points of the study, None where a point is not done; the axes
    are the common cycles and positions along x and y, m. The lock guards the netCDF library.
    """

    def __init__(
        self,
        files: NDArray[np.generic],
        field: Variable,
        axes: tuple[NDArray[np.float64], ...],
        lock: AbstractContextManager[object],
    ) -> None:
        self.files, self.field, self.axes, self.lock = files, field, axes, lock
        self.shape = (*files.shape, *(axis.size for axis in axes))
        self.ndim = len(self.shape)
        self.dtype = np.dtype(field.dtype)

    def __getitem__(self, key: tuple[int | slice, ...]) -> NDArray[np.generic]:
        """Read a part, given by a slice or an index along every dimension."""
        at, within = key[: self.files.ndim], key[self.files.ndim :]
        files = np.asarray(self.files[at], dtype=object)
        cycles, *places = (
            np.atleast_1d(axis[part]) for axis, part in zip(self.axes, within, strict=True)
        )
        shape = (*files.shape, cycles.size, *map(len, places))
        values = np.full(shape, empty_value(self.field), dtype=self.dtype)
        for position, path in np.ndenumerate(files):
            if path is None:
                continue
            # Opening a file needs the lock too.
            with self.lock, netCDF4.Dataset(path) as file:
                file.set_auto_mask(False)
                stored = file[CYCLE.name][:].tolist()
                snapshots = {
                    place: file[self.field.name][stored.index(cycle)]
                    for place, cycle in enumerate(cycles)
                    if cycle in stored
                }
                cells = [file[name][:] for name in contact_frame(file.variables).axes]
            inside = [*map(positions_inside, cells, places)]
            for place, snapshot in snapshots.items():
                for axis, (centres, common) in enumerate(zip(cells, places, strict=True)):
                    snapshot = resampled(snapshot, centres, common[inside[axis]], axis=axis)
                values[position][place] = self.field.outside
                values[position][place][np.ix_(*inside)] = snapshot
        single: list[int | slice] = [
            0 if isinstance(part, Integral) else np.s_[:] for part in within
        ]
        return np.asarray(values[(..., *single)])
