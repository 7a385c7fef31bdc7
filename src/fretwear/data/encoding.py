"""How variables that are neither large nor fields go into a netCDF file."""

from __future__ import annotations

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
