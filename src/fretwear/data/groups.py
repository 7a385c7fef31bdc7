"""Groups of netCDF files, opened lazily, and the numbers that replace text in them."""

from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np
import xarray as xr

from fretwear.data.atomic import read_error
from fretwear.results import CASE_ID
from fretwear.variable import Variable

# Attributes: names of the attributes that are text coordinates in memory; texts of a coordinate of
# flags.
_TEXTS, LEVELS = "text_parameters", "levels"
_OF_FLAGS = {LEVELS, "flag_values", "flag_meanings"}
_WORD = re.compile(r"[^\w.+@-]+")  # characters not allowed in flag_meanings


def without_text(dataset: xr.Dataset) -> xr.Dataset:
    """Return a dataset whose coordinates are numbers, which every program reads.

    A single text is an attribute. Text along a dimension is a flag variable: its attribute
    ``levels`` has the texts, one a line, and ``flag_meanings`` has them as words. Case ids and text
    that is no coordinate are arrays of characters; no variable of numbers depends on them.
    """
    texts = {str(n): v for n, v in dataset.coords.items() if v.dtype.kind in "OU"}
    single = {name: str(text.item()) for name, text in texts.items() if not text.dims}
    flags = {}
    for name, text in texts.items():
        if text.dims and name != CASE_ID.name:
            levels, first, numbers = np.unique(
                text.values.astype(str), return_index=True, return_inverse=True
            )
            # Flags follow the order of the study, so that numbers along a dimension rise.
            order = np.argsort(first)
            meanings = {
                "flag_values": np.arange(levels.size, dtype=np.int32),
                "flag_meanings": " ".join(_WORD.sub("_", level) for level in levels[order]),
                LEVELS: "\n".join(levels[order]),
            }
            numbers = np.argsort(order)[numbers].reshape(text.shape).astype(np.int32)
            flags[name] = xr.Variable(text.dims, numbers, {**text.attrs, **meanings})
    labelled = {_TEXTS: " ".join(single), **single} if single else {}
    stored = dataset.drop_vars([*single]).assign_coords(flags).assign_attrs(labelled)
    return stored.reset_coords({CASE_ID.name} & stored.coords.keys())


def with_text(dataset: xr.Dataset) -> xr.Dataset:
    """Return a dataset read from a file with the text coordinates that `without_text` replaced."""
    from fretwear.study.case import case_keys

    attributes, texts = dict(dataset.attrs), dict[str, xr.Variable]()
    for name in attributes.pop(_TEXTS, "").split():
        own_attributes = Variable(name, "", words=case_keys().coordinate(name).words).attributes
        texts[name] = xr.Variable((), attributes.pop(name), own_attributes)
    for name, variable in dataset.variables.items():
        if LEVELS in variable.attrs:
            levels = np.array(variable.attrs[LEVELS].split("\n"))
            own_attributes = {n: v for n, v in variable.attrs.items() if n not in _OF_FLAGS}
            texts[str(name)] = xr.Variable(variable.dims, levels[variable.values], own_attributes)
        elif variable.dtype.kind == "O":
            texts[str(name)] = variable.copy(data=variable.values.astype(str))
    labels = {n: texts.pop(n) for n in [*texts] if n not in dataset.data_vars or n == CASE_ID.name}
    read = dataset.assign(texts).assign_coords(labels)
    read.attrs = attributes
    return read


def open_group(
    path: str | os.PathLike[str],
    group: str | None = None,
    remedy: str = "If it is the file of a case, remove it and run the case again",
) -> xr.Dataset:
    """Open a netCDF file or one of its groups; fields are read when used, text at once.

    `DataFileError` if there is no such file or group, or the file is damaged or foreign.
    """
    try:
        dataset = xr.open_dataset(
            path, engine="netcdf4", group=group, decode_times=False, decode_timedelta=False
        )
        close = dataset.close
        dataset = with_text(dataset)
    except (OSError, RuntimeError, ValueError) as cause:
        raise read_error(Path(path), cause, remedy) from cause
    # The first format called the normal load by the name of a method of datasets.
    if "load" in {*dataset.variables, *dataset.dims}:
        dataset = dataset.rename(load="normal_load")
    dataset.set_close(close)
    return dataset
