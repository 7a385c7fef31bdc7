"""Whether and where a folder can be written to: found out before anything is computed."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path


def why_not_writable(path: Path) -> str:
    """Say why a folder can neither be written to nor be made; empty where it can.

    Nothing is left behind: a folder that does not exist is not made, its nearest parent is tried.
    """
    existing = _nearest_existing(path)
    if not existing.is_dir():
        return f"{path}: cannot be written to, because {existing} is not a folder"
    try:
        # Rights, read-only disks and quotas have one test in common: a file can be made or not.
        with tempfile.TemporaryFile(dir=existing):
            return ""
    except OSError as error:
        reason = os.strerror(error.errno or 0)
        return f"{path}: cannot be written to: {reason}; choose another place"


def why_leading_out(folder: Path) -> str:
    """Say why results would be written outside of the folder of all results; empty if they stay.

    The folder of all results may be a link, to a larger disk for example: that is a choice for all
    studies. A link in the place of one study, or of a folder in it, could come from anywhere.

    Parameters
    ----------
    folder
        Folder of one study's results, in the folder of all results.
    """
    root = folder.parent.resolve()
    try:
        inside = [Path(entry) for entry in os.scandir(folder) if entry.is_symlink()]
    except OSError:
        inside = []
    for each in (folder, *sorted(inside)):
        target = each.resolve()
        if not target.is_relative_to(root):
            return (
                f"{each}: is a link that leads out of {folder.parent}, to {target}; remove it, "
                f"make {folder.parent} itself the link, or name the folder by --results"
            )
    return ""


def _nearest_existing(path: Path) -> Path:
    # A path below a file counts as missing, and so does one whose folder may not be looked into.
    for candidate in (path, *path.absolute().parents):
        try:
            candidate.lstat()
        except OSError:
            continue
        return candidate
    return Path("/")
