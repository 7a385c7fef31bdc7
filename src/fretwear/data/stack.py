"""The fields of all cases of a study as one dataset, on positions that all cases share."""

from __future__ import annotations

import math
import uuid
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from fretwear.arrays import Array, Element
from fretwear.data.arrays import read_arrays
from fretwear.data.atomic import DataFileError
from fretwear.data.files import open_summary
from fretwear.results import CASE_ID, FIELDS, STATUS, SYMMETRIES, PointStatus, Y, contact_frame
from fretwear.variable import Variable

NOT_DONE = -1
"""Value of ``contact_state`` at missing points and cycles, where other fields are NaN."""


Ends: TypeAlias = tuple[float, float, int]
"""First and last cell centre of a case, m, and number of cells."""


def ends_of(cells: Array) -> Ends:
    """Return the ends of the cells of a case from their centres, m."""
    return float(cells[0]), float(cells[-1]), cells.size


def common_positions(cases: Collection[Ends]) -> Array:
    """Return positions, m, common to all cases, given the ends of each.

    These are the centres of cells of the finest spacing, up to the end of the largest window. If
    all cases have one spacing, they are the cells of the cases, and interpolation changes no value.
    """
    windows = [
        ((last - first) / (size - 1) if first < 0.0 else 2.0 * first, last)
        for first, last, size in cases
    ]
    spacing = min(step for step, _ in windows)
    length = max(last + 0.5 * step for step, last in windows)
    # The margin keeps the last bit of the division from adding a cell.
    number = math.ceil(length / spacing * (1.0 - 1e-9))
    x = (np.arange(number, dtype=np.float64) + 0.5) * spacing
    return np.concatenate([-x[::-1], x]) if any(first < 0.0 for first, *_ in cases) else x


def resampled(
    values: NDArray[Element], cells: Sequence[Array], positions: Sequence[Array], outside: float
) -> NDArray[Element]:
    """Interpolate values at cell centres to other positions, both in m, along the last axes.

    Physical quantities are interpolated linearly, and equal the value of the cell to the last bit
    at its centre; a state, a whole number, comes from the nearest cell. Between the axis
    and the first cell of a one-sided array values are constant; beyond the outermost cell centres
    they are `outside`. Cells with only positive positions are one side of an even contact.
    """
    for axis, (centres, places) in enumerate(zip(cells, positions, strict=True), -len(cells)):
        if not np.array_equal(centres, places):
            moved = _along_last(np.moveaxis(values, axis, -1), centres, places)
            moved[..., np.abs(places) > np.abs(centres).max() * (1.0 + 1e-12)] = outside
            values = np.moveaxis(moved, -1, axis)
    return values


def _along_last(values: NDArray[Element], cells: Array, positions: Array) -> NDArray[Element]:
    where = np.abs(positions) if cells[0] > 0.0 else positions
    lower = np.clip(np.searchsorted(cells, where, side="right") - 1, 0, cells.size - 2)
    weight = np.clip((where - cells[lower]) / (cells[lower + 1] - cells[lower]), 0.0, 1.0)
    if values.dtype.kind != "f":
        return values[..., lower + (weight >= 0.5)]
    numbers = values.astype(np.float64)
    interpolated = (1.0 - weight) * numbers[..., lower] + weight * numbers[..., lower + 1]
    return np.asarray(interpolated, values.dtype)


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


def open_study(path: str | PathLike[str]) -> xr.Dataset:
    """Open the merged study together with the fields of all its cases.

    Fields are dask arrays that read one field of one case at a time, so a reduction over any number
    of cases needs little memory, and its file is open for that time only:
    ``open_study("results/demo").wear_depth.max(("x", "y")).compute()``.
    Unless all cases have the same grid spacing, fields are interpolated to the cells of the finest
    case in the largest window; ``contact_state`` is taken from the nearest cell. Outside the window
    of a case the surfaces do not touch and the gap is NaN. Where a point is not done or lacks the
    snapshot, all fields are NaN and ``contact_state`` is `NOT_DONE`.

    Parameters
    ----------
    path : str or path-like
        Folder of the results of a study, with the folder ``cases``, or its ``summary.nc``.

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

    folder = Path(path)
    folder = folder.parent if folder.suffix == ".nc" else folder
    if folder.suffix in (".yaml", ".yml"):
        raise DataFileError(folder, "is a study file", "Give the folder of its results")
    summary = open_summary(folder / "summary.nc")
    status, ids = summary[STATUS.name], summary[CASE_ID.name].to_numpy()
    dims = contact_frame(summary.variables).dims
    cases: NDArray[Any] = np.full(status.shape, None)
    try:
        for place in map(tuple, np.argwhere(status.to_numpy() == PointStatus.DONE)):
            file = folder / "cases" / f"{ids[place]}.nc"
            cases[place] = file, [*read_arrays(file, dims).values()]
    except DataFileError:
        summary.close()
        raise
    done = filter(None, cases.flat)
    stacked, rows = summary, {ends_of(axes[2]) for _, axes in done if len(axes) == 3}
    if rows:
        stacked = stacked.assign_coords({Y.name: (Y.name, common_positions(rows), Y.attributes)})
    axes = [stacked[name].to_numpy() for name in dims]
    chunks = (*(1 for _ in cases.shape), *(axis.size for axis in axes))
    for field in FIELDS:
        # Without a name dask would look for one in the contents of all cases.
        name = f"{field.name}-{uuid.uuid4()}"
        lazy = da.from_array(_Stack(cases, field, axes), chunks, name)  # type: ignore[no-untyped-call]
        stacked[field.name] = ((*status.dims, *dims), lazy, field.attributes)
    # Code that mirrors or draws a case needs this.
    even = (bool(axes[1][0] > 0.0), len(dims) > 2 and bool(axes[2][0] > 0.0))
    stacked.attrs["symmetry"] = next(n for n, sides in SYMMETRIES.items() if sides == even)
    if stacked is not summary:  # closing a derived dataset would not close its file
        stacked.set_close(summary.close)
    return stacked


@dataclass(frozen=True)
class _Stack:
    """A field of all cases, read by indexing; a file is open for as long as it is read."""

    cases: NDArray[np.object_]  # file of each case with its cycles and positions; None if not done
    field: Variable
    axes: Sequence[Array]  # cycles and positions that all cases share

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers of cases, of cycles and of positions."""
        return (*self.cases.shape, *(axis.size for axis in self.axes))

    @property
    def ndim(self) -> int:
        """Number of dimensions."""
        return len(self.shape)

    @property
    def dtype(self) -> np.dtype[np.generic]:
        """Type of the field."""
        return np.dtype(self.field.dtype)

    def __getitem__(self, index: tuple[Any, ...]) -> NDArray[np.generic]:
        """Return values at an index of cases, of cycles, and of positions."""
        outer, (cycle, *inner) = index[: self.cases.ndim], index[self.cases.ndim :]
        places = np.arange(self.cases.size).reshape(self.cases.shape)[outer]
        cycles = np.atleast_1d(self.axes[0][cycle])
        read = [self._of_case(self.cases.flat[place], cycles) for place in np.ravel(places)]
        values = np.reshape(read, (*np.shape(places), *read[0].shape))
        keeps = slice(None) if isinstance(cycle, slice) or np.ndim(cycle) else 0
        return np.asarray(values[..., keeps, *inner])

    def _of_case(self, case: tuple[Path, list[Array]] | None, cycles: Array) -> NDArray[np.generic]:
        """Return the field of one case, if it has it, at some cycles."""
        field, positions = self.field, self.axes[1:]
        shape = (cycles.size, *(axis.size for axis in positions))
        values = np.full(shape, NOT_DONE if field.flags else math.nan, self.dtype)
        if case is not None:
            file, (snapshots, *cells) = case
            _, rows, kept = np.intersect1d(cycles, snapshots, return_indices=True)
            some = slice(kept.min(initial=snapshots.size), kept.max(initial=-1) + 1)
            for stored in read_arrays(file, [field.name], some).values():
                indices = kept - some.start
                values[rows] = resampled(stored[indices], cells, positions, field.outside)
        return values
