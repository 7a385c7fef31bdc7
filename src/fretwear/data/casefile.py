"""Case files as the netCDF library reads them; whole ones told from damaged ones."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Hashable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any, TypeVar

import netCDF4
import numpy as np
from numpy.typing import NDArray

from fretwear.data.errors import CaseFileError
from fretwear.data.variables import CASE_DIMS, FIELDS, ContactState

HISTORY_GROUP = "history"
SEALS = ("complete", "digest")

_DIGESTED_ATTRIBUTES = ("case_id", "parameters", "symmetry")
_FIELD_NAMES = frozenset(field.name for field in FIELDS)
_RUN_AGAIN = "Remove the file and run the case again"
_T = TypeVar("_T")


@dataclass(frozen=True)
class CaseFile:
    """A case file that is open and, but for the values of its fields, known to be whole.

    Attributes
    ----------
    path : pathlib.Path
        The file.
    file : netCDF4.Dataset
        The open file.
    """

    path: Path
    file: netCDF4.Dataset

    def attribute(self, name: str) -> str:
        """A global attribute."""
        return str(self.file.getncattr(name))

    def read(self, name: str, index: Any = np.s_[...]) -> NDArray[Any]:
        """Read a variable or a part of it.

        Parameters
        ----------
        name : str
            Name of the variable.
        index : slice, int or tuple of these
            The part, along the dimensions of the variable.

        Raises
        ------
        CaseFileError
            When the part is damaged: a checksum does not fit or a chunk got lost.
        """
        values = _guarded(self.path, lambda: np.asarray(self.file[name][index]))
        # A chunk whose place in the file got lost reads as the fill value, without an error.
        lost = values < ContactState.OPEN if values.dtype == np.int8 else values != values
        if name in _FIELD_NAMES and lost.any():
            raise _damaged(self.path)
        return values


def seal(path: Path) -> None:
    """Mark a case file as whole, once everything else has been written.

    Two attributes are set: ``digest``, a hash of all values but those of the fields (whose chunks
    carry checksums of their own), then ``complete = 1``.
    """
    with netCDF4.Dataset(path, "a") as file:
        file.set_auto_mask(False)
        file.setncattr("digest", _digest(file))
        file.setncattr("complete", np.int32(1))


@contextmanager
def checked_case(path: str | PathLike[str]) -> Iterator[CaseFile]:
    """Open a case file after checking that it is whole.

    Everything but the values of the fields is checked: that the file was finished, that every
    variable is there with its dimensions, and that the values are those that were written.

    Raises
    ------
    CaseFileError
        When the file is missing, unfinished, cut short or damaged.
    """
    path = Path(path)
    file = _opened(path)
    with file:
        _guarded(path, lambda: _check(path, file))
        yield CaseFile(path, file)


def missing_variables(dims: Mapping[Hashable, tuple[Hashable, ...]]) -> list[str]:
    """Name the variables of a case that are not there with the right dimensions.

    Parameters
    ----------
    dims : mapping
        Name and dimensions of the variables that are there.
    """
    return [name for name, expected in CASE_DIMS.items() if dims.get(name) != expected]


def _opened(path: Path) -> netCDF4.Dataset:
    if not path.exists():
        raise CaseFileError(path, "there is no such file", "Check the name, or run the case")
    if not path.is_file():
        raise CaseFileError(path, "it is not a file", "Give the name of a case file")
    if path.stat().st_size == 0:
        raise CaseFileError(path, "it is empty", _RUN_AGAIN)
    try:
        return netCDF4.Dataset(path, "r")
    except PermissionError as cause:
        raise CaseFileError(path, "it may not be read", "Ask for the right to read it") from cause
    except (OSError, RuntimeError) as cause:
        raise CaseFileError(
            path, f"it is cut short, damaged or no netCDF file ({cause})", _RUN_AGAIN
        ) from cause


def _check(path: Path, file: netCDF4.Dataset) -> None:
    file.set_auto_mask(False)
    attributes = set(file.ncattrs())
    if "complete" not in attributes or file.getncattr("complete") != 1:
        raise CaseFileError(path, "the run that wrote it did not finish", _RUN_AGAIN)
    lacking = missing_variables({name: v.dimensions for name, v in file.variables.items()})
    lacking += [HISTORY_GROUP] if HISTORY_GROUP not in file.groups else []
    if lacking:
        raise CaseFileError(path, f"it lacks {', '.join(lacking)}", _RUN_AGAIN)
    if "digest" not in attributes or file.getncattr("digest") != _digest(file):
        raise _damaged(path)


def _digest(file: netCDF4.Dataset) -> str:
    digest = hashlib.blake2b(digest_size=16)
    for name in _DIGESTED_ATTRIBUTES:
        digest.update(str(file.getncattr(name)).encode())
    for group in (file, file.groups[HISTORY_GROUP]):
        for name in sorted(group.variables.keys() - _FIELD_NAMES):
            values = np.asarray(group[name][...])
            digest.update(f"{group.path}/{name} {values.shape}".encode())
            digest.update(str(values).encode() if values.dtype.kind in "OU" else values.tobytes())
    return digest.hexdigest()


def _guarded(path: Path, read: Callable[[], _T]) -> _T:
    try:
        return read()
    except (OSError, RuntimeError, ValueError, AttributeError, LookupError) as cause:
        raise _damaged(path) from cause


def _damaged(path: Path) -> CaseFileError:
    return CaseFileError(path, "it is damaged, or was changed after the run", _RUN_AGAIN)
