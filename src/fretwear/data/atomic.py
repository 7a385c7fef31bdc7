"""Files that are complete or absent, and the error that names one."""

from __future__ import annotations

import os
import platform
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

_CREATE = os.O_WRONLY | os.O_CREAT | os.O_TRUNC | getattr(os, "O_NOFOLLOW", 0)
_NEARLY_FULL_BYTES = 1 << 20


class DataFileError(Exception):
    """A file that cannot be read or written: its path, the fault, the remedy."""

    def __init__(self, path: Path, fault: str, remedy: str = "") -> None:
        super().__init__(path, fault, remedy)
        self.path, self.fault, self.remedy = path, fault, remedy

    def __str__(self) -> str:
        return f"{self.path}: {self.fault}. {self.remedy}".removesuffix(". ")


@contextmanager
def atomic_path(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary file in the same folder, which gets the name `path` on a clean exit.

    The temporary name contains machine and process, so processes that write the same file never mix
    their output; the last one prevails. On any error, interrupts included, the temporary file is
    removed and an existing file is kept. `DataFileError` if the disk is full or the folder cannot
    be created or written to.
    """
    path = Path(path)
    temporary = path.with_name(f".{path.name}.{platform.node()}.{os.getpid()}.tmp")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        # The netCDF library reports every failure to create a file as a lack of permission.
        os.close(os.open(temporary, _CREATE, 0o666))
        yield temporary
        temporary.replace(path)
    except (OSError, RuntimeError) as cause:
        fault, remedy = getattr(cause, "strerror", None) or cause, "Choose another folder"
        with suppress(OSError):
            # The netCDF library does not report a full disk.
            if shutil.disk_usage(path.parent).free < _NEARLY_FULL_BYTES:
                fault, remedy = "the disk is full", "Free some space"
        raise DataFileError(path, f"not written: {fault}", remedy) from cause
    finally:
        with suppress(OSError):
            temporary.unlink()


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write a text file (UTF-8, line ends as given) as `atomic_path` does."""
    with atomic_path(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="")


def read_error(path: Path, cause: Exception, remedy: str) -> DataFileError:
    """Say why a netCDF file could not be read; the remedy is for a damaged one."""
    fault = f"it is damaged, or not a netCDF-4 file of fretwear ({cause})"
    if path.is_dir():
        fault, remedy = "it is a folder", "Give a file in it, such as cases/ID.nc of results"
    elif not path.is_file():
        fault, remedy = "there is no such file", "Check the name"
    elif path.suffix in (".yaml", ".yml"):
        fault, remedy = "it is a study file", "Give the file of a case: fretwear run writes one"
    elif path.suffix in (".csv", ".html", ".json", ".svg", ".png", ".txt"):
        fault, remedy = "it is not a netCDF file", "Give the file of a case, such as cases/ID.nc"
    return DataFileError(path, fault, remedy)
