"""What to try instead of a study file that is not there, or that is something else."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from itertools import chain
from pathlib import Path

STUDIES = Path("studies")
ENDINGS = (".yaml", ".yml")
_LISTED = 5


def instead_of(file: Path) -> str:
    """Say which study may be meant by the name of a file that does not exist.

    The name of a study without its folder or ending is understood, and so is a misspelt one; where
    nothing is like it, the studies are listed that there are.
    """
    if near := _same_name(file) or _similar(file):
        return f"did you mean {str(near)!r}?"
    if present := studies_in(file.parent) or studies_in(STUDIES):
        return listed("there are", present)
    folder = file.parent.absolute()
    if not folder.is_dir():
        return (
            f"there is no folder {folder} either: give another path, or change to the right folder"
        )
    return f"no study lies in {folder}: give a path to one, or change to the folder with studies/"


def studies_in(folder: Path) -> list[Path]:
    """Return the study files of a folder; none where it cannot be read."""
    try:
        return sorted(path for path in folder.iterdir() if path.suffix in ENDINGS)
    except OSError:
        return []


def listed(words: str, files: Iterable[Path]) -> str:
    """List a few files in a sentence."""
    names = [str(file) for file in files]
    more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    return f"{words} {', '.join(names[:_LISTED])}{more}"


def _same_name(file: Path) -> Path | None:
    names = [file.name, *(f"{file.name}{ending}" for ending in ENDINGS)]
    candidates = (folder / name for folder in (file.parent, STUDIES) for name in names)
    return next((path for path in candidates if path.suffix in ENDINGS and path.is_file()), None)


def _similar(file: Path) -> Path | None:
    present = {path.name: path for path in chain(studies_in(STUDIES), studies_in(file.parent))}
    near = difflib.get_close_matches(file.name, present, n=1, cutoff=0.75)
    return present[near[0]] if near else None
