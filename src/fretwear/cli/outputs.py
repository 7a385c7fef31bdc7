"""Where a command writes to: found out before anything is computed."""

from __future__ import annotations

from pathlib import Path

from fretwear.cli.status import refuse
from fretwear.data.safe import why_not_writable

FIGURE_FORMATS = (".png", ".svg", ".pdf")
"""Endings of the files into which figures are drawn."""


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
        raise refuse(f"{path}: is to end in {expected}, such as {path.with_suffix(endings[0])}")
    check_folder(path.parent)
    return path


def check_folder(path: Path) -> Path:
    """Return a folder that can be written to or made, or leave with a message and status 2."""
    if problem := why_not_writable(path):
        raise refuse(problem)
    return path
