"""The fields of all cases of a study as one dataset, read piece by piece when they are used."""

from __future__ import annotations

from functools import reduce
from os import PathLike
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import xarray as xr
from numpy.typing import NDArray
from xarray.backends import BackendArray
from xarray.backends.netCDF4_ import NETCDF4_PYTHON_LOCK
from xarray.core import indexing

from fretwear.data.casefile import opened_case
from fretwear.data.layout import CASE_ID
from fretwear.data.merge import Status, open_summary
from fretwear.data.profiles import Reach
from fretwear.data.resampling import Resampling
from fretwear.data.variables import CYCLE, FIELDS, Field, X, Y

NOT_DONE = -1
"""What ``contact_state`` is at points and cycles that are not there; other fields are NaN."""

_CHUNK_BYTES = 32 << 20


def open_study(path: str | PathLike[str]) -> xr.Dataset:
    """Open the merged study together with the fields of all its cases.

    Fields are dask arrays that read one case at a time, so a reduction over any number of cases
    needs little memory: ``open_study("results/demo").wear_depth.max(("x", "y")).compute()``.
    They are brought to the cells of the finest case, in the largest window, by interpolation
    (none where all cases have one grid spacing; ``contact_state`` is that of the nearest cell).
    Outside the window of a case nothing touches and the gap is NaN.

    Parameters
    ----------
    path : str or path-like
        Folder of the results of a study, with ``summary.nc`` and the folder ``cases``.

    Returns
    -------
    xarray.Dataset
        The merged study and every field, dimensions (…, ``cycle``, ``x``, ``y``). Fields are NaN
        (``contact_state`` is `NOT_DONE`) where a point is not done or has no such snapshot.

    Raises
    ------
    DataFileError
        When the merged study or one of its case files is missing or damaged.
    """
    folder = Path(path)
    summary = open_summary(folder / "summary.nc")
    files = np.full(summary["status"].shape, None)
    done = summary["status"].to_numpy() == Status.DONE
    for position in zip(*np.nonzero(done), strict=True) if files.ndim else ((),):
        files[position] = folder / "cases" / f"{summary[CASE_ID.name].to_numpy()[position]}.nc"
    x = summary[X.name].to_numpy()
    y = _common_y([file for file in files.ravel() if file is not None])
    dims = (*summary["status"].dims, CYCLE.name, X.name, Y.name)
    stacked = summary.assign_coords({Y.name: xr.Variable((Y.name,), y, Y.attributes)})
    for field in FIELDS:
        array = StackedField(files, field, summary[CYCLE.name].to_numpy(), x, y)
        lazy = xr.Variable(dims, indexing.LazilyIndexedArray(array), field.attributes)
        stacked[field.name] = lazy.chunk(dict(zip(dims, array.chunks, strict=True)))
    stacked.set_close(summary.close)
    return stacked


class StackedField(BackendArray):
    """One field of all cases as one array; every access reads from the case files.

    Parameters
    ----------
    files : numpy.ndarray of pathlib.Path or None
        Case files, laid out as the points of the study; None where a point is not done.
    field : Field
        The field.
    cycles, x, y : numpy.ndarray
        Cycles, and positions in m, that all cases share.
    """

    def __init__(
        self,
        files: NDArray[Any],
        field: Field,
        cycles: NDArray[np.float64],
        x: NDArray[np.float64],
        y: NDArray[np.float64],
    ) -> None:
        self.files = files
        self.field = field
        self.cycles = cycles
        self.x = x
        self.y = y
        self.shape = (*files.shape, cycles.size, x.size, y.size)
        self.dtype = np.dtype(field.dtype)

    @property
    def chunks(self) -> tuple[int, ...]:
        """Sizes of pieces: one case, and as many cycles of it as make a reasonable piece."""
        cycle_bytes = self.x.size * self.y.size * self.dtype.itemsize
        cycles = min(self.cycles.size, max(1, _CHUNK_BYTES // cycle_bytes))
        return (*(1 for _ in self.files.shape), cycles, self.x.size, self.y.size)

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        """Read a part, as xarray asks for it."""
        return indexing.explicit_indexing_adapter(
            key, self.shape, indexing.IndexingSupport.BASIC, self._read
        )

    def _read(self, key: tuple[int | slice, ...]) -> NDArray[Any]:
        points = self.files.ndim
        files = np.asarray(self.files[key[:points]], dtype=object)
        cycles = np.atleast_1d(self.cycles[key[points]])
        missing = NOT_DONE if self.field.flags else np.nan
        shape = (*files.shape, cycles.size, self.x.size, self.y.size)
        values = np.full(shape, missing, dtype=self.dtype)
        for position in np.ndindex(files.shape):
            if files.item(position) is not None:
                self._read_case(files.item(position), cycles, values[position])
        cycle_key = 0 if isinstance(key[points], int | np.integer) else slice(None)
        return values[(*(slice(None) for _ in files.shape), cycle_key, *key[points + 1 :])]

    def _read_case(self, path: Path, cycles: NDArray[np.float64], into: NDArray[Any]) -> None:
        # The netCDF library must not be used by two threads, opening included.
        with NETCDF4_PYTHON_LOCK, netCDF4.Dataset(path) as file:
            file.set_auto_mask(False)
            stored = file[CYCLE.name][:]
            snapshots = {
                place: file[self.field.name][int(np.searchsorted(stored, cycle))]
                for place, cycle in enumerate(cycles)
                if cycle in stored
            }
            along_x = Resampling(file[X.name][:], self.x)
            along_y = Resampling(file[Y.name][:], self.y)
        for place, values in snapshots.items():
            into[place] = self._resampled(values, along_x, along_y)

    def _resampled(
        self, values: NDArray[Any], along_x: Resampling, along_y: Resampling
    ) -> NDArray[Any]:
        if self.field.flags:
            resampled = along_y.nearest(along_x.nearest(values, 0), 1)
        else:
            resampled = along_y.linear(along_x.linear(values, 0), 1)
        outside = np.logical_or.outer(along_x.is_outside, along_y.is_outside)
        resampled[outside] = self.field.outside
        return resampled


def _common_y(files: list[Path]) -> NDArray[np.float64]:
    reaches = []
    for file in files:
        with opened_case(file) as case_file:
            is_whole = case_file.attribute("symmetry") == "none"
            reaches.append(Reach.of_case(case_file.read(Y.name), is_whole))
    return reduce(Reach.joined, reaches).positions()
