"""Files of datasets: written completely or not at all, checked before they are opened.

Every file ends with a checksum, a line after its content that libraries for netCDF-4 and HDF5
ignore; in case files it follows an excerpt for merging. It is compared before the netCDF library
opens the file: the library opens unfinished files without an error, and a damaged structure can
hang or crash the process.

A checksum does not tell who wrote the file: what it holds is checked as well, before its arrays are
read (`fretwear.data.contents`).
"""

from __future__ import annotations

import math
import os
import shutil
import tempfile
import zlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import netCDF4
import numpy as np
from numpy.typing import NDArray

from fretwear.data.contents import (
    COMPLETE,
    HISTORY_GROUP,
    case_problems,
    lacking_variables,
    size_problems,
    summary_problems,
)
from fretwear.data.excerpts import Excerpt, ExcerptError
from fretwear.data.safe import (
    DataFileError,
    atomic_path,
    is_of_netcdf,
    uninterrupted,
)
from fretwear.vocabulary import (
    BODY_FIELDS,
    CASE_ID,
    CODE_DIGEST,
    CYCLE,
    FIELDS,
    STEP,
    VECTOR_FIELDS,
    X,
    Y,
)

if TYPE_CHECKING:
    import xarray as xr

    from fretwear.data.labels import Labelled
    from fretwear.study.case import Case

LOOP_GROUP = "loop"
COMPRESSION: dict[str, Any] = {"zlib": True, "complevel": 1, "shuffle": True, "fletcher32": True}
"""Storage of large variables; the netCDF library adds a checksum to each chunk."""

_NO_CHECKSUM = "unfinished, cut short or changed by another program"
READS_BACK = "the file reads back differently from what was written"

_STORED_SMALL = {field.name for field in (*FIELDS, *BODY_FIELDS, *VECTOR_FIELDS)}
_MARK = b"\nfretwear crc32 "
_EXCERPT_MARK = b"\nfretwear excerpt "
_EXCERPT_LENGTH = len(_EXCERPT_MARK) + 10
_LENGTH = len(_MARK) + 8 + 1
_BLOCK_BYTES = 1 << 20
_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_SUPERBLOCK_LENGTH = 64
_MOST_OF_A_FIELD = 1e20  # in Pa, m or 1
_MEMORY = Path("/dev/shm")
_IN_MEMORY_BYTES = 64 << 20

_CHECK_NAME = "Check the name, or run the case"
_CHECK_FOLDER = "Check the name: case files lie in the folder cases/ of a study's results"
_CHECK_KIND = "Check the name; if it is the rest of a case file, run the case again"
_RUN_AGAIN = "Remove the file and run the case again"
_MERGE_AGAIN = "Merge the study again"
_RUN_STUDY = "Run the study first: snakemake --cores 2 --config study="


def add_checksum(path: Path) -> None:
    """Append the checksum to a file, which must not be changed afterwards."""
    with path.open("r+b") as stream:
        checksum = _checksum(stream, path.stat().st_size)
        stream.seek(0, os.SEEK_END)
        stream.write(_checksum_line(checksum))


def _insert_before_checksum(path: Path, addition: bytes) -> None:
    """Append bytes to the content of a file with a checksum, which then covers them as well."""
    with path.open("r+b") as stream:
        end = stream.seek(-_LENGTH, os.SEEK_END)
        checksum = int(stream.read().removeprefix(_MARK), 16)
        stream.seek(end)
        stream.write(addition + _checksum_line(zlib.crc32(addition, checksum)))


def damage(path: Path, kind: str) -> str:
    """Return the problem of a file that should end with its checksum; empty if it is intact."""
    if not path.is_file():
        return "it is not a file" if path.exists() else "there is no such file"
    try:
        with path.open("rb") as stream:
            content = path.stat().st_size - _LENGTH
            stream.seek(max(content, 0))
            last_line = stream.read()
            if not last_line.startswith(_MARK):
                return f"it is not a complete {kind}: {_NO_CHECKSUM}"
            stream.seek(0)
            is_whole = last_line == _checksum_line(_checksum(stream, content))
    except OSError as cause:
        return f"it cannot be read ({cause.strerror or cause})"
    return "" if is_whole else "it is damaged: its checksum does not match"


def _checksum(stream: BinaryIO, content: int) -> int:
    checksum = 0
    while content > 0 and (block := stream.read(min(content, _BLOCK_BYTES))):
        checksum = zlib.crc32(block, checksum)
        content -= len(block)
    return checksum


def _checksum_line(checksum: int) -> bytes:
    return _MARK + f"{checksum:08x}\n".encode()


@contextmanager
def new_netcdf(path: Path, size: int) -> Iterator[netCDF4.Dataset]:
    """Write a netCDF file with a checksum, given the bytes of its values before compression.

    HDF5 crashes the process if its last write is refused. It therefore writes into a folder in
    memory, from which Python copies the file to the disk, unless the file is large or there is no
    such folder.
    """
    with ExitStack() as stack:
        image = None
        with suppress(OSError):
            if size < min(_IN_MEMORY_BYTES, shutil.disk_usage(_MEMORY).free / 2):
                image = stack.enter_context(tempfile.NamedTemporaryFile(dir=_MEMORY, delete=False))
        try:
            file = netCDF4.Dataset(path if image is None else image.name, "w")
        finally:
            if image is not None:
                Path(image.name).unlink()  # the file vanishes with the process, however that ends
        with file:
            yield file
            file.sync()
        if image is not None:
            with path.open("wb") as copy:
                shutil.copyfileobj(image, copy)
    add_checksum(path)


def write_group(group: netCDF4.Dataset, content: xr.Dataset | Labelled) -> None:
    """Write variables and attributes into a group of an open file, as xarray reads them."""
    group.setncatts(content.attrs)
    around = group.parent.dimensions if group.parent is not None else {}
    # The library writes what it knows of all variables whenever values follow a definition.
    defined = list[tuple[Any, NDArray[Any]]]()
    for name, values, dims, attributes in _stored(content):
        options: dict[str, Any] = {}
        if name in _STORED_SMALL:
            options = {**COMPRESSION, "chunksizes": (1, *values.shape[1:])}
            options |= {"fill_value": np.nan} if values.dtype.kind == "f" else {}
        for dim, size in zip(dims, values.shape, strict=True):
            if dim not in group.dimensions and dim not in around:
                group.createDimension(dim, size)
        target = group.createVariable(name, values.dtype, dims, **options)
        target.setncatts(attributes)
        defined.append((target, values))
    for target, values in defined:
        target[...] = values


def check_group(group: netCDF4.Dataset, content: xr.Dataset | Labelled) -> None:
    """Raise a RuntimeError if a group reads back differently from the content written into it.

    When memory is short, the netCDF library may silently omit an attribute.
    """
    group.set_auto_chartostring(False)
    check_attributes(group, content.attrs)
    for name, values, dims, attributes in _stored(content):
        kept = group.variables.get(name)
        if kept is None or kept.dimensions != dims or kept.dtype != values.dtype:
            raise RuntimeError(READS_BACK)
        check_attributes(kept, attributes)
        for part in np.ndindex(values.shape[:1] if values.ndim > 2 else ()):
            if kept[part or ...].tobytes() != values[part].tobytes():
                raise RuntimeError(READS_BACK)


def check_attributes(owner: Any, given: Mapping[Any, Any]) -> None:
    """Raise a RuntimeError if a variable or a group lacks attributes or has different ones."""
    kept = set(owner.ncattrs())
    if not all(n in kept and np.array_equal(owner.getncattr(n), given[n]) for n in given):
        raise RuntimeError(READS_BACK)


def _stored(
    content: xr.Dataset | Labelled,
) -> Iterator[tuple[str, NDArray[Any], tuple[str, ...], dict[str, object]]]:
    """Yield name, values, dimensions and attributes of variables as they are stored.

    Text has a fixed length: strings of variable length crash the netCDF library when one of two
    handles on a file is closed.
    """
    variables: Mapping[Any, Any] = content.variables
    coords: Iterable[Any] = content.coords
    beside = sorted(name for name in coords if name not in variables[name].dims)
    for name, variable in variables.items():
        values, dims, attributes = np.asarray(variable.values), variable.dims, {**variable.attrs}
        if values.dtype.kind in "OU":
            if not all(isinstance(value, str) for value in values.flat):
                raise TypeError(f"{name} holds neither numbers nor text")
            text = np.char.encode(values.astype(str), "utf-8")
            length = max(1, text.dtype.itemsize)
            values = text.astype(f"S{length}").reshape(*values.shape, 1).view("S1")
            dims, attributes["_Encoding"] = (*dims, f"{name}_length"), "utf-8"
        if beside and name not in content.coords:
            attributes["coordinates"] = " ".join(beside)
        yield name, values, dims, attributes


def write_case(
    dataset: xr.Dataset | Labelled,
    history: xr.Dataset | Labelled,
    path: str | PathLike[str],
    loops: xr.Dataset | Labelled | None = None,
) -> None:
    """Write a case file; it gets its name, and replaces an earlier file, only when complete.

    The dataset comes from `fretwear.data.labels.labelled_case`; history and loops, if any, become
    the groups ``history`` and ``loop``. Fields are compressed by zlib (level 1, shuffled), one
    cycle to a chunk, each chunk with the checksum of the netCDF library. The file ends with a
    checksum of the whole, and all of it is read back before it gets its name.

    ValueError if the dataset lacks variables of a case; `DataFileError` if the disk is full, or the
    folder, created if necessary, cannot be written to.
    """
    if lacking := lacking_variables({name: v.dims for name, v in dataset.variables.items()}):
        raise ValueError(f"{path} would not be complete: the dataset lacks {', '.join(lacking)}.")
    groups = {HISTORY_GROUP: history, **({} if loops is None else {LOOP_GROUP: loops})}
    variables = (v for content in (dataset, *groups.values()) for v in content.variables.values())
    size = sum(np.asarray(variable.values).nbytes for variable in variables)
    with uninterrupted(), atomic_path(Path(path)) as temporary:
        with new_netcdf(temporary, size) as file:
            write_group(file, dataset)
            file.setncattr(COMPLETE, np.int32(1))
            for name, content in groups.items():
                write_group(file.createGroup(name), content)
        try:
            with opened_case(temporary) as file:
                check_group(file, dataset)
                for name, content in groups.items():
                    check_group(file[name], content)
                excerpt = Excerpt.of(file, file[HISTORY_GROUP]).to_bytes()
        except DataFileError as cause:
            raise RuntimeError(READS_BACK) from cause
        ending = _EXCERPT_MARK + f"{len(excerpt):010d}".encode()
        _insert_before_checksum(temporary, excerpt + ending)


def read_excerpt(path: str | PathLike[str]) -> Excerpt:
    """Return the excerpt of a case file, which is opened if none stands at its end.

    Raises a `DataFileError` if the file was not written by fretwear, is damaged or unusable.
    """
    path = Path(path)
    if problem := damage(path, "case file"):
        raise unusable(path, problem)
    with suppress(OSError, ExcerptError), path.open("rb") as stream:
        before = stream.seek(-min(path.stat().st_size, _LENGTH + _EXCERPT_LENGTH), os.SEEK_END)
        mark, digits = (line := stream.read(_EXCERPT_LENGTH))[:-10], line[-10:]
        if mark == _EXCERPT_MARK and digits.isdigit() and int(digits) <= before:
            stream.seek(before - int(digits))
            return Excerpt.from_bytes(stream.read(int(digits)))
    with opened_case(path) as file:
        return Excerpt.of(file, file[HISTORY_GROUP])


def unusable(path: Path, problem: str) -> DataFileError:
    """Return an error that says why a case file cannot be used."""
    return DataFileError(path, problem, _RUN_AGAIN)


@contextmanager
def opened_case(
    path: str | PathLike[str], *, by_us: bool = True, values: bool = False
) -> Iterator[netCDF4.Dataset]:
    """Open a case file after checking it, which reads it once; `DataFileError` if it is unusable.

    Unless the file must be written `by_us`, a dataset saved by xarray, without checksum and
    history, is accepted. With `values`, the values of scalars and parameters are checked too;
    values of fields never are.
    """
    path = Path(path)
    problem = damage(path, "case file")
    if problem:
        _refuse_unsaved(path, problem, by_us=by_us)
    with _opened(path, _RUN_AGAIN, problem) as file:
        if CASE_ID.name not in file.ncattrs():
            raise DataFileError(path, "it is not the file of one case", _CHECK_FOLDER)
        size = path.stat().st_size
        for obstacle in case_problems(file, size, by_us=not problem, values=values):
            raise unusable(path, obstacle)
        yield file


@contextmanager
def opened_summary(path: str | PathLike[str]) -> Iterator[netCDF4.Dataset]:
    """Open a merged study with the netCDF library; `DataFileError` if it is missing or damaged."""
    path = Path(path)
    if not path.exists():
        *_, above, study = ("", "", *path.resolve().parent.parts)
        name = study if above == "results" else "NAME"
        raise DataFileError(path, "there is no such file", f"{_RUN_STUDY}{name}")
    with opened_parts(path, "merged study", _MERGE_AGAIN) as file:
        for obstacle in summary_problems(file):
            raise DataFileError(path, obstacle, _MERGE_AGAIN)
        yield file


@contextmanager
def opened_parts(path: Path, kind: str, remedy: str) -> Iterator[netCDF4.Dataset]:
    """Open a file that ends with our checksum; its arrays are no larger than it can hold."""
    if problem := damage(path, kind):
        raise DataFileError(path, problem, remedy)
    with _opened(path, remedy) as file:
        for obstacle in size_problems((file, *file.groups.values()), path.stat().st_size):
            raise DataFileError(path, obstacle, remedy)
        yield file


@contextmanager
def _opened(path: Path, remedy: str, problem: str = "") -> Iterator[netCDF4.Dataset]:
    try:
        file = netCDF4.Dataset(path)
    except (OSError, RuntimeError, LookupError, AttributeError) as cause:
        why = problem or f"it is not a netCDF file ({cause})"
        raise DataFileError(path, why, remedy) from cause
    try:
        with file:
            file.set_auto_maskandscale(False)
            yield file
    except (RuntimeError, LookupError, AttributeError) as cause:
        # The library raises these if the structure is damaged although the checksum matches.
        if not is_of_netcdf(cause):
            raise
        raise DataFileError(path, f"it cannot be read ({cause})", remedy) from cause


def _refuse_unsaved(path: Path, problem: str, *, by_us: bool) -> None:
    """Refuse a file without our checksum, unless xarray saved it and it need not be `by_us`.

    A damaged file of ours goes on after the content of HDF5, and the HDF5 library opens none of
    which content was cut off.
    """
    head, size = None, 0
    with suppress(OSError):
        if path.is_file():  # reading a pipe would wait
            with path.open("rb") as stream:
                head = stream.read(_SUPERBLOCK_LENGTH)
                size = stream.seek(0, os.SEEK_END)
    if head is None:
        raise DataFileError(path, problem, _CHECK_NAME)
    if not head.startswith(_SIGNATURE):
        # The file may be precious, such as a study file, so the remedy is not to remove it.
        raise DataFileError(path, "it is not a netCDF-4 file, which case files are", _CHECK_KIND)
    if by_us or size > _end_of_hdf5(head):
        raise DataFileError(path, problem, _RUN_AGAIN)


def _end_of_hdf5(superblock: bytes) -> float:
    """Return where the content of an HDF5 file ends, from its first bytes; inf if unknown.

    The address is in the superblock: HDF5 File Format Specification, version 3.0, section II.A.
    """
    version, at = superblock[len(_SIGNATURE) :][:1], {0: 40, 1: 44, 2: 28, 3: 28}
    address = at.get(version[0] if version else -1)
    return math.inf if address is None else int.from_bytes(superblock[address:][:8], "little")


def check_fields(path: str | PathLike[str]) -> None:
    """Read the fields of a case file; `DataFileError` if values are none that a contact has."""
    with opened_case(path, by_us=False) as file:
        for name in (field.name for field in FIELDS):
            for snapshot in range(file.dimensions[CYCLE.name].size):
                largest = float(np.abs(file[name][snapshot]).max())
                if not largest < _MOST_OF_A_FIELD:
                    raise unusable(Path(path), f"{name} holds {largest:g}, which no contact has")


def finished_by(path: str | PathLike[str], case: Case) -> str | None:
    """Return the digest of the code that computed a case; None unless a file has its snapshots."""
    with suppress(DataFileError), opened_case(path) as file:
        is_same = file.getncattr(CASE_ID.name) == case.case_id
        if is_same and np.array_equal(file[CYCLE.name][:], case.output_cycles):
            return str(file.__dict__.get(CODE_DIGEST.name, ""))
    return None


def open_lazily(
    path: str | PathLike[str], group: str | None = None, remedy: str = _CHECK_KIND
) -> xr.Dataset:
    """Open a netCDF file or one of its groups; fields are read when used, text at once."""
    import xarray as xr

    # Registers the accessor of datasets.
    import fretwear.data.dataset  # noqa: F401

    try:
        dataset = xr.open_dataset(
            path, engine="netcdf4", group=group, decode_times=False, decode_timedelta=False
        )
    except (OSError, RuntimeError, ValueError, TypeError, LookupError, AttributeError) as cause:
        raise DataFileError(Path(path), f"it cannot be read ({cause})", remedy) from cause
    # When memory is short, the netCDF library silently omits variables.
    if not (dataset.variables and (dataset.attrs or group)):
        raise DataFileError(Path(path), "it cannot be read (it appears empty)", remedy)
    for name, coordinate in dataset.coords.items():
        if coordinate.dtype.kind == "O":
            # xarray's own `astype` would import dask.
            dataset[name] = coordinate.copy(data=coordinate.to_numpy().astype(str))
    return dataset


def open_case(path: str | PathLike[str], full: bool = False) -> xr.Dataset:
    """Open a case file lazily: values are read when used.

    Opening reads the whole file once, at a few GB/s, to compare its checksum. Close the dataset, or
    use it in a ``with`` statement, to release the file.

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
        If the file is missing, unfinished, truncated or damaged.
    """
    with opened_case(path, by_us=False, values=True):
        pass
    dataset = open_lazily(path)
    return dataset.fretwear.full() if full else dataset


def open_history(path: str | PathLike[str]) -> xr.Dataset:
    """Open the history of a case file or a merged study: scalars at every accepted step.

    The coordinate ``cycle`` lies along the dimension ``step``. The history of a merged study,
    ``summary.nc``, has the varied names as dimensions too, and NaN after the last step of a case.
    Raises the errors of `open_case`.
    """
    with suppress(DataFileError), open_summary(path) as summary:
        coordinates = summary.drop_vars([CYCLE.name, X.name]).coords
        history = open_lazily(path, group=HISTORY_GROUP)
        return history.set_coords(CYCLE.name).assign_coords(coordinates)
    with opened_case(path, by_us=False, values=True) as file:
        if HISTORY_GROUP in file.groups:
            return open_lazily(path, group=HISTORY_GROUP)
    # A file saved by xarray has no history, only snapshots.
    dataset = open_lazily(path).drop_dims([X.name, Y.name], errors="ignore")
    return dataset.reset_coords(drop=True).rename_dims({CYCLE.name: STEP.name})


def open_loops(path: str | PathLike[str]) -> xr.Dataset:
    """Open the loops of a case file: force and displacement round a cycle at each snapshot.

    Dimensions are ``cycle`` and ``phase``. Raises the errors of `open_case`, and a `DataFileError`
    if there are no loops.
    """
    with opened_case(path) as file:
        if LOOP_GROUP not in file.groups:
            raise unusable(Path(path), "it holds no loops of force and displacement")
    return open_lazily(path, group=LOOP_GROUP)


def open_summary(path: str | PathLike[str]) -> xr.Dataset:
    """Open a merged study lazily, as `open_case` opens a case; `DataFileError` if it cannot."""
    with opened_summary(path):
        pass
    return open_lazily(path)
