"""Arrays of many case files for a merged study, read by HDF5 itself."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import closing, contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import h5py
import netCDF4
import numpy as np
from numpy.typing import NDArray

from fretwear.data.atomic import read_error
from fretwear.data.files import (
    HISTORY_GROUP,
    LOOP_GROUP,
    MERGED_HISTORIES,
    MERGED_PROFILES,
    RUN_AGAIN,
    check_axes,
    check_case,
    check_units,
    reading,
)
from fretwear.results import CASE_ID, CODE_DIGEST, CYCLE, WARNINGS, X, Y

_GROUPS = {HISTORY_GROUP, LOOP_GROUP}
# Parts of a case in a merged study: arrays by their names in its file, and attributes.
_PROFILES = {field.name for field in MERGED_PROFILES.values()}
_HISTORIES = {f"{HISTORY_GROUP}/{name}" for name in MERGED_HISTORIES}
_MERGED = {CASE_ID.name, CODE_DIGEST.name, WARNINGS.name, "source", "symmetry"}
_MERGED |= {"complete", "format_version"}
_OF_ENCODING = {"coordinates", "_FillValue"}  # attributes that xarray writes


class Header(NamedTuple):
    """Dimensions, type and attributes of a variable of a file."""

    dims: tuple[str, ...]
    dtype: np.dtype[np.generic]
    attributes: Mapping[str, object]


Headers: TypeAlias = dict[str, dict[str, Header]]
"""Headers by the digest of the code that wrote the file, or its path, and by name."""


def survey(
    path: str | os.PathLike[str], headers: Headers
) -> tuple[dict[str, Any], dict[str, NDArray[Any]], int]:
    """Check a case file; return its attributes, its axes and the number of accepted steps.

    Files of the same code share `headers`, which this function completes: reading them takes ten
    times as long as the arrays. Raises the errors of `open_case`.
    """
    with _hdf5(path) as file:
        found = (name for name in _MERGED if h5py.h5a.exists(file, name.encode()))
        attributes = {name: _attribute(file, name) for name in found}
        names = [name for name in _names(file) if name not in _GROUPS]
        steps = 0
        if HISTORY_GROUP.encode() in file:
            inner = _names(h5py.h5g.open(file, HISTORY_GROUP.encode()))
            names += _HISTORIES & {f"{HISTORY_GROUP}/{name}" for name in inner}
            (steps,) = h5py.h5d.open(file, f"{HISTORY_GROUP}/{CYCLE.name}".encode()).shape
        check_case(Path(path), attributes, names)
        known = headers.setdefault(attributes.setdefault(CODE_DIGEST.name, "") or str(path), {})
        if not known.keys() >= {*names}:
            known.update(_read_headers(path))
        axes = {CYCLE.name, X.name, Y.name} & {*names}
        arrays = {name: _array(file, name, known[name], {}) for name in axes}
    check_axes(Path(path), arrays)
    return attributes, arrays, steps


def read_case(path: str | os.PathLike[str], code: str, headers: Headers) -> dict[str, NDArray[Any]]:
    """Read the arrays of a case in a merged study, by name; `headers` are those of its `survey`.

    These are the axes, scalars, the fields of `MERGED_PROFILES` on the line of cells nearest y = 0,
    and the `MERGED_HISTORIES`, named ``history/cycle``. `DataFileError` if the file is damaged.
    """
    kept, of_axes = _HISTORIES | _PROFILES, {(CYCLE.name,), (X.name,), (Y.name,)}
    arrays, spaces = dict[str, NDArray[Any]](), dict[tuple[str, ...], h5py.h5s.SpaceID]()
    with _hdf5(path) as file:
        for name, header in headers[code or str(path)].items():
            if name in kept or header.dims in of_axes:
                with suppress(KeyError):  # another file of the same code has it
                    arrays[name] = _array(file, name, header, spaces)
    if Y.name in arrays:
        middle = int(np.abs(arrays[Y.name]).argmin())
        for name in _PROFILES & arrays.keys():
            arrays[name] = arrays[name][..., middle].copy()
    return arrays


# Below, calls of HDF5 replace ``file[name][()]``, ``file.attrs[name]`` and ``[*file]``, which take
# three times as long.
def _array(
    file: h5py.h5f.FileID, name: str, header: Header, spaces: dict[tuple[str, ...], Any]
) -> NDArray[np.generic]:
    """Read an array; one of another size than the first with its dimensions raises OSError."""
    stored = h5py.h5d.open(file, name.encode())
    if header.dims not in spaces:
        spaces[header.dims] = h5py.h5s.create_simple(stored.shape)
    space = spaces[header.dims]
    values = np.empty(space.shape, header.dtype)
    stored.read(space, h5py.h5s.ALL, values, _memory_type(header.dtype))
    return values


_memory_type = cache(h5py.h5t.py_create)


@cache
def _access() -> h5py.h5p.PropFAID:
    access = h5py.h5p.create(h5py.h5p.FILE_ACCESS)
    access.set_fclose_degree(h5py.h5f.CLOSE_STRONG)  # also after an error
    return access


def _attribute(file: h5py.h5f.FileID, name: str) -> Any:
    stored = h5py.h5a.open(file, name.encode())
    values = np.zeros(stored.shape or (), stored.dtype)  # an empty text has no shape
    stored.read(values)
    value = values.ravel()[0]
    return value.decode() if isinstance(value, bytes) else value


def _names(group: h5py.h5g.GroupID) -> list[str]:
    names: list[bytes] = []
    group.links.iterate(names.append)
    return [name.decode() for name in names]


def _read_headers(path: str | os.PathLike[str]) -> Iterator[tuple[str, Header]]:
    with reading(path), netCDF4.Dataset(path) as file:
        check_units(Path(path), {name: vars(v) for name, v in file.variables.items()})
        groups = {name: file[name] for name in {HISTORY_GROUP} & file.groups.keys()}
        for group, place in ((file, ""), *((group, f"{name}/") for name, group in groups.items())):
            for name, stored in group.variables.items():
                attributes = {n: v for n, v in vars(stored).items() if n not in _OF_ENCODING}
                yield f"{place}{name}", Header(stored.dimensions, stored.dtype, attributes)


@contextmanager
def _hdf5(path: str | os.PathLike[str]) -> Iterator[h5py.h5f.FileID]:
    """Open a file by HDF5, in a hundredth of the time that the netCDF library takes."""
    try:
        with closing(h5py.h5f.open(os.fsencode(path), h5py.h5f.ACC_RDONLY, _access())) as file:
            yield file
    except (OSError, RuntimeError) as cause:
        raise read_error(Path(path), cause, RUN_AGAIN) from cause


def read_arrays(
    path: str | os.PathLike[str], names: Iterable[str], rows: slice = slice(None)
) -> dict[str, NDArray[np.generic]]:
    """Read some rows of arrays of a case file; missing arrays are left out.

    `DataFileError` if the file is missing or damaged.
    """
    with _hdf5(path) as opened:
        file = h5py.File(opened)
        return {name: file[name][rows] for name in names if name in file}
