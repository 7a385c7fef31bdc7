"""Files that appear under their name only when they are whole."""

from __future__ import annotations

import os
import re
import secrets
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from fretwear.data.errors import write_error

_FOREIGN_LIFETIME = 7 * 24 * 3600.0
_TEMPORARY = re.compile(r"\.(?P<name>.+)\.(?P<host>[^.]+)\.(?P<pid>\d+)\.[0-9a-f]{8}\.tmp")


@contextmanager
def atomic_path(path: Path) -> Iterator[Path]:
    """Give a temporary name in the same folder; the file gets its own name on a clean exit.

    The temporary name is unique, so two processes that write the same file never mix. File and
    folder are flushed to the disk before and after the renaming. Whatever goes wrong in the
    ``with`` block, an interrupt included, the temporary file is removed and a file that was there
    before stays as it was. Only a process that is killed outright leaves its temporary file; the
    next one that writes the same file removes it.

    Parameters
    ----------
    path : pathlib.Path
        The file to write; its folder is made if need be.

    Yields
    ------
    pathlib.Path
        Where to write: an empty file.

    Raises
    ------
    DataFileError
        When the folder cannot be made or written to or the disk is full.
    """
    temporary = path.with_name(f".{path.name}.{_host()}.{os.getpid()}.{secrets.token_hex(4)}.tmp")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        remove_stale_temporaries(path)
        # The netCDF library calls every failure to make a file a lack of permission.
        temporary.touch(exist_ok=False)
    except OSError as cause:
        raise write_error(path, cause) from cause
    try:
        yield temporary
        _flush(temporary)
        temporary.replace(path)
        _flush(path.parent)
    except (OSError, RuntimeError) as cause:
        # Removing the file gives the space back that says whether the disk was full.
        error = write_error(path, cause)
        _remove(temporary)
        raise error from cause
    except BaseException:
        _remove(temporary)
        raise


def write_text(path: Path, text: str) -> None:
    """Write a text file (UTF-8, line ends as given) as `atomic_path` does."""
    with atomic_path(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="")


def remove_stale_temporaries(path: Path) -> list[Path]:
    """Remove what killed processes have left of a file.

    A temporary file of this machine is stale when its process is gone; one of another machine
    (a shared folder) when nothing has been written to it for a week.

    Parameters
    ----------
    path : pathlib.Path
        The file under its final name.

    Returns
    -------
    list of pathlib.Path
        The temporary files that were removed.
    """
    with os.scandir(path.parent) as entries:
        names = [entry.name for entry in entries if entry.name.startswith(f".{path.name}.")]
    removed = []
    for candidate in (path.with_name(name) for name in names):
        match = _TEMPORARY.fullmatch(candidate.name)
        if match and match["name"] == path.name and _is_stale(candidate, match):
            _remove(candidate)
            removed.append(candidate)
    return removed


def _is_stale(temporary: Path, name: re.Match[str]) -> bool:
    if name["host"] == _host():
        return not _is_alive(int(name["pid"]))
    try:
        return time.time() - temporary.stat().st_mtime > _FOREIGN_LIFETIME
    except OSError:
        return False


def _is_alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True


def _host() -> str:
    return re.sub(r"[^A-Za-z0-9-]", "-", socket.gethostname())[:32] or "host"


def _flush(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _remove(path: Path) -> None:
    # After a failure HDF5 keeps the file open until the process ends, which would hold the space
    # of a file that is removed but not emptied.
    with suppress(OSError):
        os.truncate(path, 0)
    with suppress(OSError):
        path.unlink()
