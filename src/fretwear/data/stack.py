"""The fields of all cases of a study as one dataset, read when they are used."""

from __future__ import annotations

import math
from contextlib import AbstractContextManager, closing
from numbers import Integral
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import netCDF4
import numpy as np
from numpy.typing import NDArray

from fretwear.data.files import open_summary, opened_case
from fretwear.data.layout import missing
from fretwear.data.positions import Window, common_positions, positions_inside, resampled
from fretwear.vocabulary import (
    CASE_DIMS,
    CASE_ID,
    CYCLE,
    FIELDS,
    LINE_DIMS,
    STATUS,
    Field,
    PointStatus,
    Y,
)

if TYPE_CHECKING:
    import xarray as xr

_CHUNK_BYTES = 32 << 20


def open_study(path: str | PathLike[str]) -> xr.Dataset:
    """Open the merged study together with the fields of all its cases.

    Fields are dask arrays that read one case at a time, so a reduction over any number of cases
    needs little memory: ``open_study("results/demo").wear_depth.max(("x", "y")).compute()``.
    They are interpolated to the cells of the finest case in the largest window (unless all cases
    have the same grid spacing; ``contact_state`` is that of the nearest cell). Outside the window
    of a case nothing touches and the gap is NaN; so are all fields (``contact_state`` is
    `NOT_DONE`) where a point is not done or lacks the snapshot.

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
    # Only this function needs dask, which takes a while to import.
    import dask.array as da
    import xarray as xr

    folder = Path(path)
    summary = open_summary(folder / "summary.nc")
    status, ids = summary[STATUS.name], summary[CASE_ID.name].to_numpy()
    files = np.full(status.shape, None)
    windows = set()
    dims: tuple[str, ...] = CASE_DIMS
    for position, state in np.ndenumerate(status.to_numpy()):
        if state == PointStatus.DONE:
            files[position] = file = folder / "cases" / f"{ids[position]}.nc"
            with opened_case(file) as case_file:
                if case_file.is_line:
                    dims = LINE_DIMS
                else:
                    windows.add(Window.of(case_file, Y.name))
    opened = xr.backends.NetCDF4DataStore.open(folder / "summary.nc")  # type: ignore[no-untyped-call]
    with closing(opened) as store:
        # The lock that xarray uses for the netCDF library, which is not thread-safe.
        lock = store.lock
    stacked = summary.copy()
    if dims == CASE_DIMS:
        y = common_positions(windows)
        stacked = summary.assign_coords({Y.name: ((Y.name,), y, Y.attributes)})
    axes = tuple(stacked[name].to_numpy() for name in dims)
    for field in FIELDS:
        array = _StackedField(files, field, axes, lock)
        cycle_bytes = math.prod(axis.size for axis in axes[1:]) * array.dtype.itemsize
        cycles = min(axes[0].size, max(1, _CHUNK_BYTES // cycle_bytes))
        chunks = (*(1 for _ in files.shape), cycles, *(axis.size for axis in axes[1:]))
        lazy = da.from_array(array, chunks, name=False)  # type: ignore[no-untyped-call]
        stacked[field.name] = ((*status.dims, *dims), lazy, field.attributes)
    stacked.set_close(summary.close)
    return stacked


class _StackedField:
    """One field of all cases as one array; indexing reads the case files.

    The case files are arranged like the points of the study, None where a point is not done; the
    axes are the common cycles and positions along x and y, m. The lock guards the netCDF library.
    """

    def __init__(
        self,
        files: NDArray[Any],
        field: Field,
        axes: tuple[NDArray[np.float64], ...],
        lock: AbstractContextManager[Any],
    ) -> None:
        self.files, self.field, self.axes, self.lock = files, field, axes, lock
        self.shape = (*files.shape, *(axis.size for axis in axes))
        self.ndim = len(self.shape)
        self.dtype = np.dtype(field.dtype)

    def __getitem__(self, key: tuple[int | slice, ...]) -> NDArray[Any]:
        """Read a part, along every dimension a slice or an index."""
        at, within = key[: self.files.ndim], key[self.files.ndim :]
        files = np.asarray(self.files[at], dtype=object)
        axes = [np.atleast_1d(axis[part]) for axis, part in zip(self.axes, within, strict=True)]
        shape = (*files.shape, *map(len, axes))
        values = np.full(shape, missing(self.field), dtype=self.dtype)
        cycles, *places = axes
        for position, path in np.ndenumerate(files):
            if path is None:
                continue
            # Opening a file uses the library too.
            with self.lock, netCDF4.Dataset(path) as file:
                file.set_auto_mask(False)
                stored = file[CYCLE.name][:]
                snapshots = {
                    place: file[self.field.name][int(np.searchsorted(stored, cycle))]
                    for place, cycle in enumerate(cycles)
                    if cycle in stored
                }
                cells = [file[name][:] for name in CASE_DIMS[1 : 1 + len(places)]]
            pairs = list(zip(cells, places, strict=True))
            inside = [positions_inside(own, wanted) for own, wanted in pairs]
            for place, found in snapshots.items():
                for axis, (own, wanted) in enumerate(pairs):
                    found = resampled(found, own, wanted[inside[axis]], axis=axis)
                into = values[position][place]
                into[...] = self.field.outside
                into[np.ix_(*inside)] = found
        single: list[Any] = [0 if isinstance(part, Integral) else np.s_[:] for part in within]
        return np.asarray(values[(..., *single)])
