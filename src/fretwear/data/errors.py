"""Errors about files: what is wrong with which file and what to do about it."""

from __future__ import annotations

import errno
import shutil
from collections.abc import Sequence
from pathlib import Path

_FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}
_FORBIDDEN = {errno.EACCES, errno.EPERM, errno.EROFS}
_NO_FOLDER = {errno.ENOENT, errno.ENOTDIR, errno.EEXIST}
_NEARLY_FULL = 1 << 20


class DataFileError(Exception):
    """A file that cannot be read or written as a whole.

    Attributes
    ----------
    path : pathlib.Path
        The file.
    problem : str
        What is wrong with it.
    remedy : str
        What to do.
    """

    def __init__(self, path: Path, problem: str, remedy: str) -> None:
        super().__init__(path, problem, remedy)
        self.path = path
        self.problem = problem
        self.remedy = remedy

    def __str__(self) -> str:
        return f"{self.path}: {self.problem}. {self.remedy}"


class CaseFileError(DataFileError):
    """A case file that is missing, unfinished, damaged or of another case."""


class CaseFilesError(CaseFileError):
    """Several case files that cannot be used, each with what is wrong and what to do.

    Attributes
    ----------
    errors : tuple of CaseFileError
        One for each file; `path`, `problem` and `remedy` are those of the first.
    """

    def __init__(self, errors: Sequence[CaseFileError]) -> None:
        super().__init__(errors[0].path, errors[0].problem, errors[0].remedy)
        self.errors = tuple(errors)
        # Exceptions are copied by calling their class with `args`.
        self.args = (self.errors,)

    def __str__(self) -> str:
        return "\n".join(str(error) for error in self.errors)


def write_error(path: Path, cause: OSError | RuntimeError) -> DataFileError:
    """Say why a file could not be written and what to do.

    Parameters
    ----------
    path : pathlib.Path
        The file that was to be written.
    cause : OSError or RuntimeError
        What was raised; the netCDF library raises a RuntimeError without a number when a disk is
        full, so the free space of the folder is looked at too.

    Returns
    -------
    DataFileError
        To be raised from `cause`.
    """
    number = cause.errno if isinstance(cause, OSError) else None
    if number in _FULL or _is_full(path.parent):
        return DataFileError(
            path,
            "not written, because the disk (or the quota on it) is full",
            "Free some space or choose another folder, then run the same command again; "
            "what was there before is unchanged",
        )
    if number in _FORBIDDEN:
        return DataFileError(
            path,
            f"not written, because the folder {path.parent} may not be written to",
            "Choose another folder or ask for the right to write there",
        )
    if number in _NO_FOLDER:
        return DataFileError(
            path,
            f"not written, because {path.parent} is not a folder and cannot be made one",
            "Choose another folder",
        )
    return DataFileError(
        path,
        f"not written: {cause}",
        "Check the free space, the quota and the disk of the folder, then run the same command "
        "again",
    )


def _is_full(folder: Path) -> bool:
    try:
        usage = shutil.disk_usage(folder)
    except OSError:
        return False
    return usage.total > 0 and usage.free < _NEARLY_FULL
