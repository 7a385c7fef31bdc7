"""Files of datasets: written completely or not at all, checked before they are opened.

Every file ends with a checksum, a line after its content, which libraries for netCDF-4 and HDF5
ignore. The netCDF library does not detect incomplete files: an unfinished one opens without an
error, and one with a damaged structure can hang or crash the process that opens it. So the checksum
is compared before the library opens the file.
"""

from __future__ import annotations

import os
import shutil
import tempfile
import zlib
from collections.abc import Hashable, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import netCDF4
import numpy as np
from numpy.typing import NDArray

from fretwear.data.checks import case_problem, summary_problem, value_problem
from fretwear.data.safe import (
    CaseFileError,
    DataFileError,
    atomic_path,
    is_of_netcdf,
    uninterrupted,
)
from fretwear.version import code_digest
from fretwear.vocabulary import (
    BODY_FIELDS,
    CASE_DIMS,
    CASE_ID,
    CODE_DIGEST,
    CYCLE,
    FIELDS,
    LINE_DIMS,
    STATUS,
    STEP,
    X,
    Y,
    scalars_of,
)

if TYPE_CHECKING:
    import xarray as xr

    from fretwear.data.labels import Labelled
    from fretwear.study.case import Case

HISTORY_GROUP = "history"
LOOP_GROUP = "loop"
COMPRESSION: dict[str, Any] = {"zlib": True, "complevel": 1, "shuffle": True, "fletcher32": True}
"""How large variables are stored: each chunk with a checksum of the netCDF library's own."""

_STORED_SMALL = {field.name for field in (*FIELDS, *BODY_FIELDS)}
_MARK = b"\nfretwear crc32 "
_LENGTH = len(_MARK) + 8 + 1
_BLOCK_BYTES = 1 << 20
_COMPLETE = "complete"
_SUPERBLOCK = 52
_MEMORY = Path("/dev/shm")
_IN_MEMORY_BYTES = 64 << 20
_SIGNATURE = b"\x89HDF\r\n\x1a\n"

READS_BACK = "the file reads back differently from what was written"
_CHECK_NAME = "Check the name, or run the case"
_CHECK_FOLDER = "Check the name: case files lie in the folder cases/ of a study's results"
_CHECK_KIND = "Check the name; if it is the rest of a case file, run the case again"
_RUN_AGAIN = "Remove the file and run the case again"
_MERGE_AGAIN = "Merge the study again"


def add_checksum(path: Path) -> None:
    """Append the checksum to a file, which must not be changed afterwards."""
    with path.open("r+b") as stream:
        line = _checksum_line(stream, path.stat().st_size)
        stream.seek(0, os.SEEK_END)
        stream.write(line)


@contextmanager
def new_netcdf(path: Path, size: int) -> Iterator[netCDF4.Dataset]:
    """Write a netCDF file with a checksum, given the bytes of its values before compression.

    HDF5 crashes the process if its last write is refused. So it writes into memory, unless the file
    is large or there is no memory to be used as a folder, and Python copies that to the disk.
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
                Path(image.name).unlink()  # it goes with its process, however that ends
        with file:
            yield file
            file.sync()
        if image is not None:
            with path.open("wb") as copy:
                shutil.copyfileobj(image, copy)
    add_checksum(path)


def damage(path: Path, kind: str) -> str:
    """Return what is wrong with a file that ends with a checksum; empty if it is intact."""
    if not path.exists():
        return "there is no such file"
    if not path.is_file():
        return "it is not a file"
    try:
        with path.open("rb") as stream:
            content = path.stat().st_size - _LENGTH
            stream.seek(max(content, 0))
            found = stream.read()
            if not found.startswith(_MARK):
                why = "unfinished, cut short or changed by another program"
                return f"it is not a complete {kind}: {why}"
            stream.seek(0)
            is_whole = found == _checksum_line(stream, content)
    except OSError as cause:
        return f"it cannot be read ({cause.strerror or cause})"
    return "" if is_whole else "it is damaged: its checksum does not match"


def _checksum_line(stream: BinaryIO, content: int) -> bytes:
    checksum = 0
    while content > 0 and (block := stream.read(min(content, _BLOCK_BYTES))):
        checksum = zlib.crc32(block, checksum)
        content -= len(block)
    return _MARK + f"{checksum:08x}\n".encode()


def open_lazily(path: str | PathLike[str], group: str | None = None) -> xr.Dataset:
    """Open a netCDF file or one of its groups; fields are read when used, text at once."""
    import xarray as xr

    # Registers the accessor of datasets.
    import fretwear.data.dataset  # noqa: F401

    try:
        dataset = xr.open_dataset(
            path, engine="netcdf4", group=group, decode_times=False, decode_timedelta=False
        )
    except (OSError, RuntimeError, ValueError, TypeError, LookupError, AttributeError) as cause:
        raise DataFileError(Path(path), f"it cannot be read ({cause})", _CHECK_KIND) from cause
    # Of what is not there the netCDF library says nothing where memory is short.
    if not (dataset.variables and (dataset.attrs or group)):
        raise DataFileError(Path(path), "it cannot be read (nothing was found in it)", _CHECK_KIND)
    for name, coordinate in dataset.coords.items():
        if coordinate.dtype.kind == "O":
            # xarray's own `astype` would import dask.
            dataset[name] = coordinate.copy(data=coordinate.to_numpy().astype(str))
    return dataset


@dataclass(frozen=True)
class CaseFile:
    """An open, intact case file."""

    path: Path
    file: netCDF4.Dataset

    def attribute(self, name: str) -> str:
        """A global attribute; empty if there is none."""
        return str(self.file.getncattr(name)) if name in self.file.ncattrs() else ""

    def read(self, name: str, index: Any = np.s_[...]) -> NDArray[Any]:
        """Read a variable or a part of it."""
        return np.asarray(self.file[name][index])

    @property
    def is_line(self) -> bool:
        """Whether it holds a line contact, whose fields have no y."""
        return Y.name not in self.file.variables

    def unusable(self, problem: str) -> CaseFileError:
        """Return an error that says why the file cannot be used."""
        return CaseFileError(self.path, problem, _RUN_AGAIN)

    def check_values(self) -> None:
        """Refuse scalars and parameters that no run could have left; fields are not checked."""
        if problem := value_problem(self.file):
            raise self.unusable(problem)


@contextmanager
def _opened(path: Path) -> Iterator[netCDF4.Dataset]:
    try:
        file = netCDF4.Dataset(path, "r")
    except (OSError, RuntimeError, LookupError, AttributeError) as cause:
        raise CaseFileError(path, f"it is not a netCDF file ({cause})", _RUN_AGAIN) from cause
    try:
        with file:
            file.set_auto_maskandscale(False)
            yield file
    except (RuntimeError, LookupError, AttributeError) as cause:
        # As the library tells of a structure that is damaged below the checksum of the file.
        if not is_of_netcdf(cause):
            raise
        raise CaseFileError(path, f"it cannot be read ({cause})", _RUN_AGAIN) from cause


@contextmanager
def opened_case(path: str | PathLike[str], *, own: bool = True) -> Iterator[CaseFile]:
    """Open a case file after checking it, which reads it once.

    Unless it must be our `own`, a dataset saved by xarray is accepted, which has neither checksum
    nor history. `CaseFileError` if it is missing, unfinished, truncated, damaged or not a case
    file.
    """
    path = Path(path)
    problem = damage(path, "case file")
    is_ours = not problem
    if problem and ((error := _not_saved(path, problem)) or own):
        raise error or CaseFileError(path, problem, _RUN_AGAIN)
    with _opened(path) as file:
        case_file = CaseFile(path, file)
        if "case_id" not in file.ncattrs():
            raise CaseFileError(path, "it is not the file of one case", _CHECK_FOLDER)
        if is_ours and (_COMPLETE not in file.ncattrs() or file.getncattr(_COMPLETE) != 1):
            raise case_file.unusable("the run that wrote it did not finish")
        lacking = _lacking({name: v.dimensions for name, v in file.variables.items()})
        lacking += [HISTORY_GROUP] if is_ours and HISTORY_GROUP not in file.groups else []
        if lacking:
            raise case_file.unusable(f"it lacks {', '.join(lacking)}")
        if problem := case_problem(file, path.stat().st_size, own=is_ours):
            raise case_file.unusable(problem)
        yield case_file


def _not_saved(path: Path, problem: str) -> CaseFileError | None:
    """Return why a file without our checksum is no case; None where xarray has left it whole.

    The superblock of an HDF5 file says where the file ends. One of ours that was cut short ends
    before that, and one that was damaged still has its checksum, which does not fit.
    """
    if not path.is_file():  # a pipe would be waited for
        return CaseFileError(path, problem, _CHECK_NAME)
    try:
        with path.open("rb") as stream:
            head = stream.read(_SUPERBLOCK).ljust(_SUPERBLOCK, b"\0")
            size = stream.seek(0, os.SEEK_END)
            stream.seek(max(0, size - _LENGTH))
            is_ours = _MARK.strip() in stream.read()
    except OSError:
        return CaseFileError(path, problem, _CHECK_NAME)
    if not head.startswith(_SIGNATURE):
        # It may be precious, a study file for example, so nobody is told to remove it.
        return CaseFileError(path, "it is not a netCDF-4 file, which case files are", _CHECK_KIND)
    end = {0: 40, 1: 44}.get(head[len(_SIGNATURE)], 28)
    is_whole = int.from_bytes(head[end : end + 8], "little") == size and not is_ours
    return None if is_whole else CaseFileError(path, problem, _RUN_AGAIN)


def _lacking(dims: Mapping[Hashable, tuple[Hashable, ...]]) -> list[str]:
    """Return the variables of a case that are missing or have wrong dimensions."""
    of_case = CASE_DIMS if Y.name in dims else LINE_DIMS
    expected = {
        **{name: (name,) for name in of_case},
        **{scalar.name: of_case[:1] for scalar in scalars_of(of_case)},
        **{field.name: of_case for field in FIELDS},
    }
    return [name for name, right in expected.items() if dims.get(name) != right]


def finished_by(path: str | PathLike[str], case: Case) -> str | None:
    """Return the digest of the code that computed a case; None without its file.

    The file is read once to compare its checksum. It must hold the same case with the same
    snapshots.
    """
    try:
        with opened_case(path) as file:
            same = file.attribute("case_id") == case.case_id
            cycles = file.read(CYCLE.name)
            digest = file.attribute(CODE_DIGEST.name)
    except CaseFileError:
        return None
    return digest if same and np.array_equal(cycles, case.output_cycles) else None


def is_finished_case(path: str | PathLike[str], case: Case) -> bool:
    """Return whether the file is the one that this code would write for this case."""
    return finished_by(path, case) == code_digest()


def write_case(
    dataset: xr.Dataset | Labelled,
    history: xr.Dataset | Labelled,
    path: str | PathLike[str],
    loops: xr.Dataset | Labelled | None = None,
) -> None:
    """Write a case file; it appears under its name only when it is whole, and replaces another.

    The dataset is that of `fretwear.data.labels.labelled_case`; what `labelled_history` and
    `labelled_loops` return become the groups ``history`` and ``loop``. Fields are compressed by
    zlib (level 1, shuffled), one cycle to a chunk, each chunk with the checksum of the netCDF
    library for those who read the file without fretwear. A checksum of the whole file ends it, and
    all of it is read back before it gets its name.

    It is a ValueError if the dataset lacks variables of a case, a `DataFileError` if the disk is
    full or the folder, which is made if necessary, cannot be written to.
    """
    if lacking := _lacking({name: v.dims for name, v in dataset.variables.items()}):
        raise ValueError(f"{path} would not be complete: the dataset lacks {', '.join(lacking)}.")
    groups = {HISTORY_GROUP: history, **({} if loops is None else {LOOP_GROUP: loops})}
    contents = (dataset, *groups.values())
    size = sum(np.asarray(v.values).nbytes for each in contents for v in each.variables.values())
    with uninterrupted(), atomic_path(Path(path)) as temporary:
        with new_netcdf(temporary, size) as file:
            write_group(file, dataset)
            file.setncattr(_COMPLETE, np.int32(1))
            for name, content in groups.items():
                write_group(file.createGroup(name), content)
        try:
            with opened_case(temporary) as case_file:
                check_group(case_file.file, dataset)
                for name, content in groups.items():
                    check_group(case_file.file[name], content)
        except CaseFileError as cause:
            raise RuntimeError(READS_BACK) from cause


def write_group(group: Any, content: xr.Dataset | Labelled) -> None:
    """Write variables and attributes into a group of an open file, as xarray reads them."""
    group.setncatts(content.attrs)
    around = group.parent.dimensions if group.parent is not None else {}
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
        target[...] = values


def check_group(group: Any, content: xr.Dataset | Labelled) -> None:
    """Refuse, by a RuntimeError, what reads back differently from what `write_group` was given.

    Where memory is short the netCDF library may leave out an attribute, and say nothing.
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
    """Refuse, by a RuntimeError, a variable or a group that lacks attributes."""
    kept = set(owner.ncattrs())
    if not all(n in kept and np.array_equal(owner.getncattr(n), given[n]) for n in given):
        raise RuntimeError(READS_BACK)


def _stored(
    content: xr.Dataset | Labelled,
) -> Iterator[tuple[str, NDArray[Any], tuple[str, ...], dict[str, Any]]]:
    """Yield name, values, dimensions and attributes of variables as they are stored.

    Text has a fixed length: strings of variable length crash the netCDF library when a file is open
    twice and one of the two is closed.
    """
    variables: Mapping[Any, Any] = content.variables
    coords: Iterable[Any] = content.coords
    beside = sorted(name for name in coords if name not in variables[name].dims)
    for name, variable in variables.items():
        values, dims, attributes = np.asarray(variable.values), variable.dims, {**variable.attrs}
        if values.dtype.kind in "OU":
            if not all(isinstance(each, str) for each in values.flat):
                raise TypeError(f"{name} holds neither numbers nor text")
            text = np.char.encode(values.astype(str), "utf-8")
            length = max(1, text.dtype.itemsize)
            values = text.astype(f"S{length}").reshape(*values.shape, 1).view("S1")
            dims, attributes["_Encoding"] = (*dims, f"{name}_length"), "utf-8"
        if beside and name not in content.coords:
            attributes["coordinates"] = " ".join(beside)
        yield name, values, dims, attributes


def open_case(path: str | PathLike[str], full: bool = False) -> xr.Dataset:
    """Open a case file lazily: values are read when used.

    The file is read once to compare its checksum, at a few GB/s. Close the dataset, or use it in a
    ``with`` statement, to release the file.

    Parameters
    ----------
    path : str or path-like
        The file.
    full : bool
        Mirror the stored part of a contact that is even along x, y or both, so that x and y run
        from −L to L. Scalars are those of the whole contact either way.

    Returns
    -------
    xarray.Dataset
        The dataset of one case. ``symmetry`` is ``"none"`` if it holds the whole contact.

    Raises
    ------
    CaseFileError
        If the file is missing, unfinished, truncated or damaged.
    """
    with opened_case(path, own=False) as file:
        file.check_values()
    dataset = open_lazily(path)
    return dataset.fretwear.full() if full else dataset


def open_history(path: str | PathLike[str]) -> xr.Dataset:
    """Open the history of a case file or a merged study: scalars at every accepted step.

    Of a case file, or of ``summary.nc`` of a study, which has the varied names beside ``step`` and
    NaN after the last step of a case; ``cycle`` lies along the steps. Errors are those of
    `open_case`.
    """
    with suppress(DataFileError):
        return MergedStudy.checked(path).history()
    with opened_case(path, own=False) as file:
        file.check_values()
        if HISTORY_GROUP in file.file.groups:
            return open_lazily(path, group=HISTORY_GROUP)
    # Saved by xarray, without a history: only the snapshots are available.
    dataset = open_lazily(path).drop_dims([X.name, Y.name], errors="ignore")
    return dataset.reset_coords(drop=True).rename_dims({CYCLE.name: STEP.name})


def open_loops(path: str | PathLike[str]) -> xr.Dataset:
    """Open the loops of a case file: force and displacement round a cycle at each snapshot.

    Dimensions are ``cycle`` and ``phase``, errors those of `open_case`, or that there are no loops.
    """
    with opened_case(path) as file:
        if LOOP_GROUP not in file.file.groups:
            raise file.unusable("it holds no loops of force and displacement")
    return open_lazily(path, group=LOOP_GROUP)


@contextmanager
def opened_summary(path: Path) -> Iterator[netCDF4.Dataset]:
    """Open a merged study with the netCDF library; `DataFileError` if it is missing or damaged."""
    if problem := damage(path, "merged study"):
        raise DataFileError(path, problem, _MERGE_AGAIN)
    with _opened(path) as file:
        if problem := summary_problem(file, path.stat().st_size):
            raise DataFileError(path, problem, _MERGE_AGAIN)
        yield file


@dataclass(frozen=True)
class MergedStudy:
    """A merged study whose file has been checked once, and the ways to read it."""

    path: Path

    @classmethod
    def checked(cls, path: str | PathLike[str]) -> MergedStudy:
        """Return the merged study of a file; `DataFileError` if that is missing or damaged."""
        with opened_summary(Path(path)):
            return cls(Path(path))

    def dataset(self) -> xr.Dataset:
        """Open it lazily."""
        return open_lazily(self.path)

    def history(self) -> xr.Dataset:
        """Open the histories of its cases lazily."""
        history = open_lazily(self.path, group=HISTORY_GROUP)
        with self.dataset() as summary:
            coordinates = summary.drop_vars([CYCLE.name, X.name]).coords
            return history.set_coords(CYCLE.name).assign_coords(coordinates)

    def results(self) -> Labelled:
        """Read all of it but profiles and histories, without importing xarray."""
        with _opened(self.path) as file:
            if not {STATUS.name, CASE_ID.name} <= file.variables.keys():
                problem = "not all of its variables can be read; is memory short?"
                raise DataFileError(self.path, problem, _MERGE_AGAIN)
            return _results(file)


def _results(file: netCDF4.Dataset) -> Labelled:
    from fretwear.data.labels import Column, Labelled

    columns: dict[str, Column] = {}
    coordinates = set(file.dimensions)
    for name, variable in file.variables.items():
        attributes = {key: variable.getncattr(key) for key in variable.ncattrs()}
        coordinates |= {*attributes.pop("coordinates", "").split()}
        if X.name in variable.dimensions[1:]:
            continue
        is_text = variable.dtype.kind == "S"
        dims = variable.dimensions[:-1] if is_text else variable.dimensions
        values = np.asarray(variable[...])
        if is_text:
            values = np.char.decode(values, "utf-8") if values.dtype.kind == "S" else values
            attributes.pop("_Encoding", None)
        columns[name] = Column(dims, values, attributes)
    attrs = {key: file.getncattr(key) for key in file.ncattrs()}
    coordinates |= {*attrs.pop("coordinates", "").split()}
    beside = {name: column for name, column in columns.items() if name in coordinates}
    return Labelled({n: c for n, c in columns.items() if n not in beside}, beside, attrs)


def open_summary(path: str | PathLike[str]) -> xr.Dataset:
    """Open a merged study lazily, as `open_case` opens a case; errors are `DataFileError`."""
    return MergedStudy.checked(path).dataset()
