"""Files of cases and of merged studies: netCDF-4, as xarray writes them.

Readers ask only for the variables that they use. So files of earlier versions, which lack some, and
of later versions, which have more, open as well.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from types import EllipsisType
from typing import TYPE_CHECKING, Any

import netCDF4
import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

import fretwear.data.dataset  # noqa: F401 - registers the accessor of datasets
from fretwear.data.atomic import DataFileError, atomic_path, read_error
from fretwear.data.groups import open_group, without_text
from fretwear.results import (
    CASE_ID,
    CODE_DIGEST,
    CONTACT_SPOTS,
    CYCLE,
    FIELDS,
    HEADLINES,
    IN_LINE_CONTACTS,
    RESULTS,
    STATUS,
    STEP,
    STICK_SPOTS,
    SYMMETRIES,
    X,
    Y,
)
from fretwear.variable import Variable

if TYPE_CHECKING:
    from fretwear.study.case import Case

HISTORY_GROUP, LOOP_GROUP = "history", "loop"

_FIELDS = {field.name: field for field in FIELDS}
MERGED_PROFILES: Mapping[str, Variable] = {
    "pressure_profile": _FIELDS["pressure"],
    "shear_profile": _FIELDS["shear_traction"],
    "gap_profile": _FIELDS["gap"],
    "wear_profile": _FIELDS["wear_depth"],
    "wear_rate_profile": _FIELDS["wear_rate"],
    "contact_state_profile": _FIELDS["contact_state"],
}
"""Fields along x on the line nearest y = 0, by their names in a merged study."""

MERGED_HISTORIES = (
    *(CYCLE.name, *HEADLINES, *IN_LINE_CONTACTS.values(), "tangential_force"),
    *(CONTACT_SPOTS.name, STICK_SPOTS.name, "exposed_area", "coating_left"),
)

_FILTERS: Mapping[str, object] = {"zlib": True, "complevel": 1, "shuffle": True}
_FIRST_CHUNKED = 256
RUN_AGAIN = "Remove the file and run the case again"
_CHECK_FOLDER = "Check the name: case files lie in the folder cases/ of a study's results"


def write_groups(
    path: str | os.PathLike[str],
    groups: Mapping[str, xr.Dataset],
    pieces: Iterable[tuple[slice | EllipsisType, Mapping[str, ArrayLike]]] = (),
    in_pieces: Collection[str] = (),
) -> None:
    """Write datasets as groups of one file, the first one as its root; the file appears complete.

    The values of the variables `in_pieces`, such as ``history/cycle``, come in `pieces`: a place on
    the first axis, and values by name. Their arrays in the datasets are not written.

    Arrays are compressed by zlib (level 1, shuffled), which every reader of files in the cloud
    knows; each chunk has a checksum. A chunk has one cycle of a field or, in a merged study, one
    value of the first parameter. Text is written as `without_text` says. `DataFileError` if the
    disk is full or the folder, created if necessary, cannot be written to.
    """
    # `to_netcdf` opens the file for each group, ends definitions for each variable and compares it
    # with each coordinate, which takes four times as long.
    with atomic_path(path) as temporary, netCDF4.Dataset(temporary, "w") as file:
        stored: dict[str, tuple[Any, Any]] = {}
        for name, labelled in groups.items():
            group = file.createGroup(name) if name else file
            defined = _defined(group, without_text(labelled))
            stored |= {f"{name}/{each}".lstrip("/"): pair for each, pair in defined}
        for values, target in (stored[name] for name in stored.keys() - {*in_pieces}):
            target[...] = values
        for place, arrays in pieces:
            for name, array in arrays.items():
                stored[name][1][place] = array


def _defined(group: netCDF4.Dataset, dataset: xr.Dataset) -> Iterator[tuple[str, tuple[Any, Any]]]:
    """Define a group; yield the name of each variable, its values, and the variable of the file."""
    group.setncatts(dataset.attrs)
    for dim, size in dataset.sizes.items():
        group.createDimension(str(dim), size)
    labels = sorted(str(name) for name in dataset.coords.keys() - {*dataset.dims})
    for name, variable in dataset.variables.items():
        values, dims, attributes = variable.data, [*map(str, variable.dims)], dict(variable.attrs)
        if values.dtype.kind in "OU":
            encoded = np.char.encode(values.astype(str), "utf-8")
            values = encoded[..., np.newaxis].view("S1")
            dims, attributes["_Encoding"] = [*dims, f"string{values.shape[-1]}"], "utf-8"
            if dims[-1] not in group.dimensions:
                group.createDimension(dims[-1], values.shape[-1])
        target: Any = group.createVariable(str(name), values.dtype, dims, **_storage(variable))
        target.set_auto_maskandscale(False)
        described = [n for n in labels if {*dataset.variables[n].dims} <= {*variable.dims}]
        if described and name not in dataset.coords:
            attributes["coordinates"] = " ".join(described)
        target.setncatts(attributes)
        yield str(name), (values, target)


def _storage(variable: xr.Variable) -> dict[str, Any]:
    """Filters, chunks and fill value of a variable."""
    fill = variable.encoding.get("_FillValue")
    if variable.size < _FIRST_CHUNKED or variable.dtype.kind in "OU":
        return {"fill_value": fill}
    chunks = variable.shape
    if variable.ndim > 1:
        chunks = (1, *variable.shape[1:])
        fill = np.nan if fill is None and variable.dtype.kind == "f" else fill
    return {**_FILTERS, "chunksizes": chunks, "fill_value": fill}


def write_case(
    dataset: xr.Dataset,
    history: xr.Dataset,
    path: str | os.PathLike[str],
    loops: xr.Dataset | None = None,
    attributes: Mapping[str, str] | None = None,
) -> None:
    """Write a case file; an earlier file is replaced only once the new one is complete.

    Dataset, history and loops come from `fretwear.data.labels`; history and loops, if any, become
    the groups ``history`` and ``loop``. `attributes` of the study are added to the dataset.
    `DataFileError` as by `write_groups`.
    """
    root = dataset.assign_attrs(attributes or {})
    loop = {} if loops is None else {LOOP_GROUP: loops}
    write_groups(path, {"": root, HISTORY_GROUP: history, **loop})


@contextmanager
def reading(path: str | os.PathLike[str]) -> Iterator[None]:
    """Turn errors of the netCDF library on a damaged file into a `DataFileError` with its name."""
    try:
        yield
    except (OSError, RuntimeError) as cause:
        if "NetCDF: " not in str(cause):
            raise
        raise read_error(Path(path), cause, RUN_AGAIN) from cause


def open_case(path: str | os.PathLike[str], full: bool = False) -> xr.Dataset:
    """Open a case file lazily: values are read when used.

    Close the dataset, or use it in a ``with`` statement, to release the file.

    Parameters
    ----------
    path : str or path-like
        The file.
    full : bool
        Mirror the stored part of a contact that is even along x, y or both, so that x and y run
        from −L to L. Scalars describe the whole contact either way.

    Returns
    -------
    xarray.Dataset
        The dataset of one case. ``symmetry`` is ``"none"`` if it holds the whole contact.

    Raises
    ------
    DataFileError
        If the file is missing, damaged, incomplete or not the file of one case, or if units or axes
        are wrong.
    """
    dataset = open_group(path)
    try:
        check_case(Path(path), dataset.attrs, dataset.variables)
        _check(Path(path), dataset)
    except DataFileError:
        dataset.close()
        raise
    if CASE_ID.name in dataset.dims:  # in files of format 2
        del dataset[CASE_ID.name]
    return dataset.fretwear.full() if full else dataset


def check_case(path: Path, attributes: Mapping[str, object], names: Collection[object]) -> None:
    """Raise a `DataFileError` unless a file has the attributes and variables of one case."""
    if CASE_ID.name not in attributes or STATUS.name in names:
        raise DataFileError(path, "it is not the file of one case", _CHECK_FOLDER)
    # Only datasets of the first format, saved by xarray, may lack the attribute.
    if attributes.get("complete", 0 if "format_version" in attributes else 1) != 1:
        raise DataFileError(path, "the run that wrote it did not finish", RUN_AGAIN)
    if lacking := [n for n in (CYCLE.name, X.name, "pressure") if n not in names]:
        raise DataFileError(path, f"it lacks {', '.join(lacking)}", RUN_AGAIN)
    if attributes.get("symmetry") not in SYMMETRIES:
        raise DataFileError(path, f"its symmetry is none of {', '.join(SYMMETRIES)}", RUN_AGAIN)


def check_axes(path: Path, arrays: Mapping[Any, ArrayLike]) -> None:
    """Raise a `DataFileError` unless all axes increase."""
    for axis in {CYCLE.name, X.name, Y.name} & arrays.keys():
        values = np.asarray(arrays[axis])
        if not (np.isfinite(values).all() and (np.diff(values) > 0).all()):
            raise DataFileError(path, f"{axis} does not increase from value to value", RUN_AGAIN)


def check_units(path: Path, attributes: Mapping[str, Mapping[str, Any]]) -> None:
    """Raise a `DataFileError` unless results are in the units of `fretwear.results`."""
    for name in RESULTS.keys() & attributes.keys():
        units = attributes[name].get("units", "")
        if units != (expected := RESULTS[name].in_units(units).si_unit):
            fault = f"{name} is in {units or 'no unit'}, not in {expected or 'any'}"
            raise DataFileError(path, fault, RUN_AGAIN)


def _check(path: Path, dataset: xr.Dataset) -> None:
    """Raise a `DataFileError` unless axes and units of a dataset that was opened are sound."""
    check_axes(path, dataset.variables)
    check_units(path, {str(name): each.attrs for name, each in dataset.variables.items()})


def finished_by(path: str | os.PathLike[str], case: Case) -> str | None:
    """Return the digest of the code that computed a case; None unless a file has its snapshots."""
    with suppress(DataFileError), open_case(path) as dataset:
        is_same = dataset.attrs[CASE_ID.name] == case.case_id
        if is_same and np.array_equal(dataset[CYCLE.name], case.output_cycles):
            return str(dataset.attrs.get(CODE_DIGEST.name, ""))
    return None


def open_history(path: str | os.PathLike[str]) -> xr.Dataset:
    """Open the history of a case file or a merged study: scalars at every accepted step.

    The coordinate ``cycle`` lies along the dimension ``step``. The history of a merged study,
    ``summary.nc``, has the varied names as dimensions too, and NaN after the last step of a case.
    Raises the errors of `open_case`.
    """
    with open_group(path) as whole:
        if STATUS.name in whole:
            history = open_group(path, HISTORY_GROUP).set_coords(CYCLE.name)
            return history.assign_coords(whole.drop_vars([CYCLE.name, X.name]).coords)
        check_case(Path(path), whole.attrs, whole.variables)
        _check(Path(path), whole)
        with suppress(DataFileError):
            return open_group(path, HISTORY_GROUP)
        # A dataset saved by xarray has no history, only snapshots.
        scalars = whole.drop_dims([X.name, Y.name, CASE_ID.name], errors="ignore").load()
    return scalars.reset_coords(drop=True).rename_dims({CYCLE.name: STEP.name})


def open_loops(path: str | os.PathLike[str]) -> xr.Dataset:
    """Open the loops of a case file: force and displacement round a cycle at each snapshot.

    Dimensions are ``cycle`` and ``phase``. `DataFileError` if there are none.
    """
    return open_group(path, LOOP_GROUP)


def open_summary(path: str | os.PathLike[str]) -> xr.Dataset:
    """Open a merged study lazily, as `open_case` opens a case; `DataFileError` if it cannot."""
    path, remedy = Path(path), "Run the study, or merge it again"
    if not path.exists():
        meant = "results" / path
        remedy = f"Did you mean {str(meant.parent)!r}?" if meant.exists() else remedy
        raise DataFileError(path, "there is no such file", remedy)
    dataset = open_group(path, remedy=remedy)
    try:
        if STATUS.name not in dataset or CYCLE.name not in dataset:
            raise DataFileError(path, "it is not a merged study", remedy)
        _check(path, dataset)
    except DataFileError:
        dataset.close()
        raise
    return dataset
