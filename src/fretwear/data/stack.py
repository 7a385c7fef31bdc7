"""The fields of all cases of a study as one dataset, on positions that all cases share."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from contextlib import ExitStack
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from fretwear.arrays import Array
from fretwear.data.files import open_case, open_summary
from fretwear.results import (
    CASE_ID,
    CYCLE,
    FIELDS,
    STATUS,
    PointStatus,
    Variable,
    Y,
    contact_frame,
)

NOT_DONE = -1
"""Value of ``contact_state`` at missing points and cycles, where other fields are NaN."""


def common_positions(cases: Collection[Array]) -> Array:
    """Return positions, m, common to all cases, given the cell centres of each.

    They are the centres of cells of the finest spacing, up to the end of the largest window; if all
    cases have one spacing, these are the cells of the cases, and interpolation changes no value.
    """
    ends = {(float(cells[0]), float(cells[-1]), cells.size) for cells in cases}
    windows = [
        ((last - first) / (size - 1) if first < 0.0 else 2.0 * first, last)
        for first, last, size in ends
    ]
    spacing = min(step for step, _ in windows)
    length = max(last + 0.5 * step for step, last in windows)
    # The margin keeps the last bit of the division from adding a cell.
    number = math.ceil(length / spacing * (1.0 - 1e-9))
    x = (np.arange(number, dtype=np.float64) + 0.5) * spacing
    return np.concatenate([-x[::-1], x]) if any(first < 0.0 for first, *_ in ends) else x


def resampled(
    values: NDArray[Any], cells: Sequence[Array], positions: Sequence[Array], outside: float
) -> NDArray[Any]:
    """Interpolate values at cell centres to other positions, both in m, along the last axes.

    Physical quantities are interpolated linearly, and equal the value of the cell to the last bit
    at its centre; a state, which is a whole number, is taken from the nearest cell. Between the
    axis and the first cell of a one-sided array values are constant; beyond the outermost cell
    centres they are `outside`. Cells that are all positive are one side of an even contact.
    """
    for axis, (at, places) in enumerate(zip(cells, positions, strict=True), -len(cells)):
        if not np.array_equal(at, places):
            along = _along_last(np.moveaxis(values, axis, -1), at, places)
            along[..., np.abs(places) > np.abs(at).max() * (1.0 + 1e-12)] = outside
            values = np.moveaxis(along, -1, axis)
    return values


def _along_last(values: NDArray[Any], cells: Array, positions: Array) -> NDArray[Any]:
    where = np.abs(positions) if cells[0] > 0.0 else positions
    lower = np.clip(np.searchsorted(cells, where, side="right") - 1, 0, cells.size - 2)
    weight = np.clip((where - cells[lower]) / (cells[lower + 1] - cells[lower]), 0.0, 1.0)
    if values.dtype.kind != "f":
        return values[..., lower + (weight >= 0.5)]
    between = (1.0 - weight) * values[..., lower] + weight * values[..., lower + 1]
    return np.asarray(between, values.dtype)


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
    of cases needs little memory:
    ``open_study("results/demo").wear_depth.max(("x", "y")).compute()``.
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
    from dask.delayed import delayed

    folder = Path(path)
    summary = open_summary(folder / "summary.nc")
    status, ids = summary[STATUS.name], summary[CASE_ID.name].to_numpy()
    cases: NDArray[Any] = np.full(status.shape, None)
    stacked, dims = summary.copy(), contact_frame(summary.variables).dims
    with ExitStack() as opened:
        opened.callback(summary.close)
        for place in map(tuple, np.argwhere(status.to_numpy() == PointStatus.DONE)):
            cases[place] = opened.enter_context(open_case(folder / "cases" / f"{ids[place]}.nc"))
        stacked.set_close(opened.pop_all().close)
    if rows := [case[Y.name].values for case in cases.flat if case is not None and Y.name in case]:
        stacked = stacked.assign_coords({Y.name: (Y.name, common_positions(rows), Y.attributes)})
    axes = [stacked[name].to_numpy() for name in dims]
    shape = tuple(axis.size for axis in axes)
    for field in FIELDS:
        read = [
            delayed(_on_axes)(None if case is None else case.get(field.name), field, *axes)
            for case in cases.flat
        ]
        fields = [da.from_delayed(one, shape, field.dtype) for one in read]  # type: ignore[no-untyped-call]
        lazy = da.stack(fields).reshape(*cases.shape, *shape)  # type: ignore[no-untyped-call]
        stacked[field.name] = ((*status.dims, *dims), lazy, field.attributes)
    return stacked


def _on_axes(
    stored: xr.DataArray | None, field: Variable, cycles: Array, *axes: Array
) -> NDArray[Any]:
    """Return a field of one case, if it has it, at cycles and positions that all cases share."""
    shape = (cycles.size, *(axis.size for axis in axes))
    values = np.full(shape, NOT_DONE if field.flags else math.nan, dtype=field.dtype)
    if stored is not None:
        cells = [stored[name].values for name in stored.dims[1:]]
        _, rows, kept = np.intersect1d(cycles, stored[CYCLE.name], return_indices=True)
        values[rows] = resampled(stored[kept].values, cells, axes, field.outside)
    return values
