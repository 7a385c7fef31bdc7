"""Where a command writes to: found out before anything is computed."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from fretwear.cli.status import refuse


def check_file(path: Path, *endings: str) -> Path:
    """Return a path to which a file can be written, or leave with a message and status 2.

    Parameters
    ----------
    path
        Where to write.
    endings
        What the name may end in, such as ``.nc``. A folder named by mistake ends in none.
    """
    if path.is_dir():
        raise refuse(f"{path}: is a folder; give a file in it, such as {path / f'x{endings[0]}'}")
    if path.suffix.lower() not in endings:
        *others, last = endings
        expected = f"{', '.join(others)} or {last}" if others else last
        raise refuse(f"{path}: is to end in {expected}")
    check_folder(path.parent)
    return path


def check_folder(path: Path) -> Path:
    """Return a folder that can be written to or made, or leave with a message and status 2.

    Nothing is left behind: a folder that does not exist is not made, its nearest parent is tried.
    """
    existing = _nearest_existing(path)
    if not existing.is_dir():
        raise refuse(f"{path}: cannot be written to, because {existing} is not a folder")
    try:
        # Rights, read-only disks and quotas have one test in common: a file can be made or not.
        with tempfile.TemporaryFile(dir=existing):
            return path
    except OSError as error:
        raise refuse(
            f"{path}: cannot be written to: {os.strerror(error.errno or 0)}; choose another place"
        ) from error


def _nearest_existing(path: Path) -> Path:
    # A path below a file counts as missing, and so does one whose folder may not be looked into.
    for candidate in (path, *path.absolute().parents):
        try:
            candidate.lstat()
        except OSError:
            continue
        return candidate
    return Path("/")
