"""How datasets go into netCDF files and come back."""

from __future__ import annotations

from os import PathLike
from typing import Any

import xarray as xr


def plain_encoding(dataset: xr.Dataset) -> dict[str, dict[str, Any]]:
    """Encode numbers as they are, without a fill value, and text as arrays of characters.

    The netCDF library crashes when a file with strings of variable length is open twice and one
    of the two is closed, so text has a fixed length.
    """
    encoding: dict[str, dict[str, Any]] = {}
    for name, variable in dataset.variables.items():
        encoding[str(name)] = {"_FillValue": None}
        if variable.dtype.kind in "OU":
            encoding[str(name)] = {"dtype": "S1", "char_dim_name": f"{name}_length"}
    return encoding


def open_lazily(path: str | PathLike[str], group: str | None = None) -> xr.Dataset:
    """Open a netCDF file or one group of it; fields are read when they are used, text at once."""
    dataset = xr.open_dataset(
        path, engine="netcdf4", group=group, decode_times=False, decode_timedelta=False
    )
    for name, coordinate in dataset.coords.items():
        if coordinate.dtype.kind == "O":
            dataset[name] = coordinate.astype(str)
    return dataset
