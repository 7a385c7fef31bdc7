"""Files of cases and of merged studies: netCDF-4 written by xarray, read as far as they go.

A reader asks for the variables that it uses. Files of earlier versions, which lack a variable, and
of later ones, which have more, therefore open as well.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, TypeAlias

import h5py
import netCDF4
import numpy as np
import xarray as xr
from numpy.typing import NDArray
from xarray.backends import NetCDF4DataStore

import fretwear.data.dataset  # noqa: F401 - registers the accessor of datasets
from fretwear.data.atomic import DataFileError, atomic_path
from fretwear.results import (
    CASE_ID,
    CODE_DIGEST,
    CYCLE,
    FIELDS,
    HEADLINES,
    IN_LINE_CONTACTS,
    RESULTS,
    STATUS,
    STEP,
    SYMMETRIES,
    Variable,
    X,
    Y,
)

if TYPE_CHECKING:
    from fretwear.study.case import Case

Variables: TypeAlias = dict[str, xr.Variable]

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

MERGED_HISTORIES = (CYCLE.name, *HEADLINES, *IN_LINE_CONTACTS.values(), "tangential_force")
"""Histories in a merged study."""

_FILTERS: Mapping[str, Any] = {"zlib": True, "complevel": 1, "shuffle": True}
_FIRST_CHUNKED = 256
# Attributes: names of the attributes that are text coordinates in memory, and, of a coordinate of
# flags, its text.
_TEXTS, _LEVELS = "text_parameters", "levels"
_OF_FLAGS = {_LEVELS, "flag_values", "flag_meanings"}
_WORD = re.compile(r"[^\w.+@-]+")  # what flag_meanings may not have
_OF_ENCODING = {"coordinates", "_FillValue"}  # attributes that xarray writes
RUN_AGAIN = "Remove the file and run the case again"
_CHECK_FOLDER = "Check the name: case files lie in the folder cases/ of a study's results"


def write_groups(path: str | os.PathLike[str], groups: Mapping[str, xr.Dataset]) -> None:
    """Write datasets as groups of one file, the first one as its root; the file appears complete.

    Arrays are compressed by zlib (level 1, shuffled), whose checksum each chunk has; programs that
    read files in the cloud have no other filter. A chunk has one cycle of a field or, in a merged
    study, one value of the first parameter. Text is written as `_without_text` says.
    `DataFileError` if the disk is full or the folder, created if necessary, cannot be written to.
    """
    values: list[tuple[Any, Any]] = []
    writer = SimpleNamespace(add=lambda source, target: values.append((source, target)))
    # `to_netcdf` would open the file for each group, and end definitions for each variable, which
    # takes three times as long. `dump_to_store` is not documented: a test has what replaces it.
    with atomic_path(path) as temporary, netCDF4.Dataset(temporary, "w") as file:
        for name, labelled in groups.items():
            content = _without_text(labelled)
            store = NetCDF4DataStore(file.createGroup(name) if name else file)  # type: ignore[no-untyped-call]
            encoding = {str(n): _encoding(v) for n, v in content.variables.items()}
            content.drop_encoding().dump_to_store(store, encoding=encoding, writer=writer)
        for source, target in values:
            target[...] = source


def _without_text(dataset: xr.Dataset) -> xr.Dataset:
    """Return a dataset whose coordinates are numbers, which every program reads.

    One text is an attribute; text along a dimension is a flag variable, whose attribute ``levels``
    has the texts, one a line, and ``flag_meanings`` has them as words. Case ids and text that is no
    coordinate are arrays of characters, of which no variable of numbers depends.
    """
    texts = {str(n): v for n, v in dataset.coords.items() if v.dtype.kind in "OU"}
    single = {name: str(text.item()) for name, text in texts.items() if not text.dims}
    flags = {}
    for name, text in texts.items():
        if text.dims and name != CASE_ID.name:
            levels, first, numbers = np.unique(
                text.values.astype(str), return_index=True, return_inverse=True
            )
            # In the order of the study, so that numbers along a dimension rise.
            order = np.argsort(first)
            about = {
                "flag_values": np.arange(levels.size, dtype=np.int32),
                "flag_meanings": " ".join(_WORD.sub("_", level) for level in levels[order]),
                _LEVELS: "\n".join(levels[order]),
            }
            numbers = np.argsort(order)[numbers].reshape(text.shape).astype(np.int32)
            flags[name] = xr.Variable(text.dims, numbers, {**text.attrs, **about})
    labelled = {_TEXTS: " ".join(single), **single} if single else {}
    stored = dataset.drop_vars([*single]).assign_coords(flags).assign_attrs(labelled)
    return stored.reset_coords({CASE_ID.name} & stored.coords.keys())


def _with_text(dataset: xr.Dataset) -> xr.Dataset:
    """Return a dataset that was read with the text coordinates that `_without_text` replaced."""
    from fretwear.study.contact import case_keys

    attributes, texts = dict(dataset.attrs), dict[str, xr.Variable]()
    for name in attributes.pop(_TEXTS, "").split():
        about = Variable(name, "", words=case_keys().coordinate(name).words).attributes
        texts[name] = xr.Variable((), attributes.pop(name), about)
    for name, variable in dataset.variables.items():
        if _LEVELS in variable.attrs:
            levels = np.array(variable.attrs[_LEVELS].split("\n"))
            about = {n: v for n, v in variable.attrs.items() if n not in _OF_FLAGS}
            texts[str(name)] = xr.Variable(variable.dims, levels[variable.values], about)
        elif variable.dtype.kind == "O":
            texts[str(name)] = variable.copy(data=variable.values.astype(str))
    labels = {n: texts.pop(n) for n in [*texts] if n not in dataset.data_vars or n == CASE_ID.name}
    read = dataset.assign(texts).assign_coords(labels)
    read.attrs = attributes
    return read


def _encoding(variable: xr.Variable) -> dict[str, Any]:
    if variable.dtype.kind in "OU":
        return {"dtype": "S1"}
    fill = variable.encoding.get("_FillValue")
    if variable.size < _FIRST_CHUNKED:
        return {"_FillValue": fill}
    chunks = variable.shape
    if variable.ndim > 1:
        chunks = (1, *variable.shape[1:])
        fill = np.nan if fill is None and variable.dtype.kind == "f" else fill
    return {**_FILTERS, "chunksizes": chunks, "_FillValue": fill}


def write_case(
    dataset: xr.Dataset,
    history: xr.Dataset,
    path: str | os.PathLike[str],
    loops: xr.Dataset | None = None,
    attributes: Mapping[str, str] | None = None,
) -> None:
    """Write a case file; it replaces an earlier file, only when it is complete.

    Dataset, history and loops come from `fretwear.data.labels`; history and loops, if any, become
    the groups ``history`` and ``loop``. `attributes` of the study are added to the dataset.
    `DataFileError` as by `write_groups`.
    """
    root = dataset.assign_attrs(attributes or {})
    loop = {} if loops is None else {LOOP_GROUP: loops}
    write_groups(path, {"": root, HISTORY_GROUP: history, **loop})


@contextmanager
def reading(path: str | os.PathLike[str], remedy: str = RUN_AGAIN) -> Iterator[None]:
    """Turn errors of the netCDF library on a damaged file into a `DataFileError` with its name."""
    try:
        yield
    except (OSError, RuntimeError) as cause:
        if "NetCDF: " not in str(cause):
            raise
        raise DataFileError(Path(path), f"it is damaged ({cause})", remedy) from cause


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
        dataset = _with_text(dataset)
    except (OSError, RuntimeError, ValueError) as cause:
        problem = "it is damaged, or not a netCDF-4 file of fretwear"
        if not Path(path).is_file():
            problem, remedy = "there is no such file", "Check the name"
        raise DataFileError(Path(path), f"{problem} ({cause})", remedy) from cause
    # The first format called the normal load by the name of a method of datasets.
    if "load" in {*dataset.variables, *dataset.dims}:
        dataset = dataset.rename(load="normal_load")
    dataset.set_close(close)
    return dataset


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
        _check_case(Path(path), dataset.attrs, dataset.variables)
    except DataFileError:
        dataset.close()
        raise
    if CASE_ID.name in dataset.dims:  # in files of format 2
        del dataset[CASE_ID.name]
    return dataset.fretwear.full() if full else dataset


def _check_case(
    path: Path, attributes: Mapping[Any, Any], variables: Mapping[Any, xr.Variable]
) -> None:
    """Raise a `DataFileError` unless these are the contents of a file of one case."""
    if CASE_ID.name not in attributes or STATUS.name in variables:
        raise DataFileError(path, "it is not the file of one case", _CHECK_FOLDER)
    # Only datasets of the first format, saved by xarray, may lack the attribute.
    if attributes.get("complete", 0 if "format_version" in attributes else 1) != 1:
        raise DataFileError(path, "the run that wrote it did not finish", RUN_AGAIN)
    if lacking := [n for n in (CYCLE.name, X.name, "pressure") if n not in variables]:
        raise DataFileError(path, f"it lacks {', '.join(lacking)}", RUN_AGAIN)
    if attributes.get("symmetry") not in SYMMETRIES:
        raise DataFileError(path, f"its symmetry is none of {', '.join(SYMMETRIES)}", RUN_AGAIN)
    _check_axes_and_units(path, variables)


def _check_axes_and_units(path: Path, variables: Mapping[Any, xr.Variable]) -> None:
    for axis in {CYCLE.name, X.name, Y.name} & variables.keys():
        values = variables[axis].values
        if not (np.isfinite(values).all() and (np.diff(values) > 0).all()):
            raise DataFileError(path, f"{axis} does not increase from value to value", RUN_AGAIN)
    for name in RESULTS.keys() & variables.keys():
        units = variables[name].attrs.get("units", "")
        if units != (expected := RESULTS[name].in_units(units).si_unit):
            problem = f"{name} is in {units or 'no unit'}, not in {expected or 'any'}"
            raise DataFileError(path, problem, RUN_AGAIN)


def read_case(path: str | os.PathLike[str]) -> tuple[dict[str, Any], Variables, Variables]:
    """Read what a merged study has of a case: attributes, results, and the history.

    Results are scalars and the fields of `MERGED_PROFILES` on the line of cells nearest y = 0.
    Most of the time goes into opening the file. Raises the errors of `open_case`.
    """
    profiles = {field.name for field in MERGED_PROFILES.values()}
    with reading(path), netCDF4.Dataset(path) as file:
        file.set_auto_maskandscale(False)
        middle = int(np.abs(file[Y.name][:]).argmin()) if Y.name in file.dimensions else 0
        attributes, results, history = vars(file), {}, {}
        for name, stored in file.variables.items():
            if name in profiles or stored.dimensions in ((CYCLE.name,), (X.name,)):
                results[name] = _read(stored, middle)
        for name, stored in file[HISTORY_GROUP].variables.items():
            if name in MERGED_HISTORIES:
                history[name] = _read(stored)
    _check_case(Path(path), attributes, results)
    return attributes, results, history


def _read(stored: netCDF4.Variable[Any], middle: int = 0) -> xr.Variable:
    """Read a variable, at one place of the axis y."""
    dims = [dim for dim in stored.dimensions if dim != Y.name]
    values = stored[tuple(middle if dim == Y.name else slice(None) for dim in stored.dimensions)]
    about = {name: value for name, value in vars(stored).items() if name not in _OF_ENCODING}
    return xr.Variable(dims, values, about)


def read_arrays(
    path: str | os.PathLike[str], names: Iterable[str], rows: slice = slice(None)
) -> dict[str, NDArray[Any]]:
    """Read some rows of arrays of a case file; those that it lacks are left out.

    The library h5py opens a file in a fiftieth of the time that the netCDF library takes.
    `DataFileError` if the file is missing or damaged.
    """
    try:
        with h5py.File(path) as file:
            return {name: file[name][rows] for name in names if name in file}
    except OSError as cause:
        problem = "it is damaged" if Path(path).is_file() else "there is no such file"
        raise DataFileError(Path(path), f"{problem} ({cause})", RUN_AGAIN) from cause


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
        _check_case(Path(path), whole.attrs, whole.variables)
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
    dataset = open_group(path, remedy=remedy)
    try:
        if STATUS.name not in dataset or CYCLE.name not in dataset:
            raise DataFileError(path, "it is not a merged study", remedy)
        _check_axes_and_units(path, dataset.variables)
    except DataFileError:
        dataset.close()
        raise
    return dataset
