"""Case files: written atomically, checked when they are opened, mirrored on request."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import xarray as xr

from fretwear.data.atomic import atomic_path
from fretwear.data.casefile import COMPLETE, HISTORY_GROUP, missing_variables, opened_case
from fretwear.data.errors import CaseFileError
from fretwear.data.netcdf import open_lazily, plain_encoding
from fretwear.data.seal import seal
from fretwear.data.uninterrupted import uninterrupted
from fretwear.data.variables import FIELDS, X, Y


def write_case(dataset: xr.Dataset, history: xr.Dataset, path: str | PathLike[str]) -> None:
    """Write a case file; it appears under its name only when it is whole.

    Fields are compressed by zlib (level 1, shuffled), one cycle to a chunk, each chunk with the
    checksum of the netCDF library for those who read the file without fretwear. The attribute
    ``complete`` is set after everything else, a checksum of the whole file ends it, and the file
    is read back before it gets its name.

    Parameters
    ----------
    dataset : xarray.Dataset
        From `fretwear.data.schema.case_dataset`.
    history : xarray.Dataset
        From `fretwear.data.schema.history_dataset`; becomes the group ``history``.
    path : str or path-like
        The file; its folder is made if need be, a file of that name is replaced.

    Raises
    ------
    ValueError
        When the dataset lacks variables of a case.
    DataFileError
        When the disk is full or the folder cannot be written to.
    """
    if lacking := missing_variables({name: v.dims for name, v in dataset.variables.items()}):
        raise ValueError(f"{path} would not be whole: the dataset lacks {', '.join(lacking)}.")
    root = dataset.drop_encoding()
    root.attrs = {name: value for name, value in root.attrs.items() if name != COMPLETE}
    group = history.drop_encoding()
    with uninterrupted(), atomic_path(Path(path)) as temporary:
        root.to_netcdf(temporary, mode="w", engine="netcdf4", encoding=_encoding(root))
        group.to_netcdf(
            temporary, mode="a", group=HISTORY_GROUP, engine="netcdf4", encoding=_encoding(group)
        )
        with netCDF4.Dataset(temporary, "a") as file:
            file.setncattr(COMPLETE, np.int32(1))
        seal(temporary)
        _read_back(temporary)


def open_case(path: str | PathLike[str], full: bool = False) -> xr.Dataset:
    """Open a case file lazily: values are read when they are used.

    The file is read once to compare it with its checksum, at a few GB/s.
    Close the dataset, or use it in a ``with`` statement, to release the file.

    Parameters
    ----------
    path : str or path-like
        The file.
    full : bool
        Mirror a stored quarter to the whole contact, x and y from −L to L. Every field is even
        in x and y; the scalars are those of the whole contact in either form.

    Returns
    -------
    xarray.Dataset
        The dataset of one case. ``symmetry`` is ``"none"`` when the whole contact is there.

    Raises
    ------
    CaseFileError
        When the file is missing, unfinished, cut short or damaged.
    """
    with opened_case(path):
        pass
    dataset = open_lazily(path)
    return mirrored(dataset) if full else dataset


def open_history(path: str | PathLike[str]) -> xr.Dataset:
    """Open the dense history of a case file: the scalars at every accepted step.

    Parameters
    ----------
    path : str or path-like
        The case file.

    Returns
    -------
    xarray.Dataset
        Dimension ``step``, with the coordinate ``cycle`` along it.

    Raises
    ------
    CaseFileError
        When the file is missing, unfinished, cut short or damaged.
    """
    with opened_case(path):
        pass
    return open_lazily(path, group=HISTORY_GROUP)


def is_complete(path: str | PathLike[str]) -> bool:
    """Tell whether a case file is there, whole and fit to be opened."""
    try:
        with opened_case(path):
            return True
    except CaseFileError:
        return False


def mirrored(dataset: xr.Dataset) -> xr.Dataset:
    """Mirror the quarter of a contact that is even in x and y to the whole contact.

    Lazily opened data stay lazy; a dataset of the whole contact is returned as it is.

    Parameters
    ----------
    dataset : xarray.Dataset
        nx × ny cells with x > 0 and y > 0, attribute ``symmetry``.

    Returns
    -------
    xarray.Dataset
        2 nx × 2 ny cells, ``symmetry = "none"``.
    """
    if dataset.attrs["symmetry"] == "none":
        return dataset
    inward_then_outward = {
        name: np.r_[np.arange(dataset.sizes[name])[::-1], np.arange(dataset.sizes[name])]
        for name in (X.name, Y.name)
    }
    positions = {
        name: xr.Variable(
            (name,), np.r_[-dataset[name].values[::-1], dataset[name].values], dataset[name].attrs
        )
        for name in (X.name, Y.name)
    }
    whole = dataset.isel(inward_then_outward).assign_coords(positions)
    whole = whole.assign_attrs(symmetry="none")
    # A derived dataset does not close the file that it reads from.
    whole.set_close(dataset.close)
    return whole


def _read_back(path: Path) -> None:
    try:
        with opened_case(path):
            return
    except CaseFileError as cause:
        raise RuntimeError("what was written reads back otherwise") from cause


def _encoding(dataset: xr.Dataset) -> dict[str, dict[str, Any]]:
    encoding = plain_encoding(dataset)
    for name in (field.name for field in FIELDS if field.name in dataset.variables):
        encoding[name] = {
            "zlib": True,
            "complevel": 1,
            "shuffle": True,
            "fletcher32": True,
            "chunksizes": (1, *dataset[name].shape[1:]),
        }
    return encoding
