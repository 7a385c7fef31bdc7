"""What the shell offers when a user presses the tab key, where typer does not know it by itself.

Where nothing is returned the shell completes names of files by itself. Shells put a space after
a word that is the only one left; where the user would have to go on without one, there are either
two candidates or none.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import typer

STUDY_FILES = (".yaml", ".yml")
"""Endings of study files."""

_STUDIES = "studies/"
_ODD_CHARACTERS = frozenset(" \t\n\"'\\$&;<>|*?[](){}!#`~")
# All ids of a large study take seconds, too long for a key that seems to do nothing.
_MOST_POINTS = 2000


def study_files(incomplete: str) -> list[str]:
    """Offer study files: those of the folder, and of ``studies/`` where no folder was typed."""
    found = _entries(incomplete, STUDY_FILES)
    if _STUDIES in found:
        inside = [name for name in _entries(_STUDIES, STUDY_FILES) if not name.endswith("/")]
        found = [name for name in found if name != _STUDIES or not inside] + inside
    return _unless_shells_do_better(found)


def case_files(incomplete: str) -> list[str]:
    """Offer case files and the folders that may hold some."""
    return _unless_shells_do_better(_entries(incomplete, (".nc",)))


def case_ids(context: typer.Context, incomplete: str) -> list[str]:
    """Offer the ids of the cases of the study that was typed before."""
    from fretwear.study.problems import StudyError
    from fretwear.study.study import load_study

    # The file is not parsed yet where the option waits for its value.
    file = context.params.get("file") or next(iter(context.args), None)
    try:
        study = load_study(file) if file is not None else None
    except StudyError:
        study = None
    points = () if study is None else study.points(1, min(study.size, _MOST_POINTS))
    ids = (point.id for point in points if point.case is not None)
    return list(dict.fromkeys(case_id for case_id in ids if case_id.startswith(incomplete)))


def assignments(incomplete: str) -> list[str]:
    """Offer names of parameters, and for the only one that is left an example of its value."""
    from fretwear.study.parameters import parameter_names, parameter_of

    names = [*parameter_names(), "output.cycles", "title"]
    found = [name for name in names if f"{name}=".startswith(incomplete)]
    if len(found) != 1:
        return [f"{name}=" for name in found]
    # A space would have to be quoted; "30N" means the same as "30 N".
    example = (parameter_of(found[0]).example or "...").replace(" ", "")
    return [f"{found[0]}=", f"{found[0]}={example}"]


def _entries(incomplete: str, endings: Sequence[str]) -> list[str]:
    """Return the files with these endings and the folders, ending in a slash, that may be meant."""
    folder, slash, name = incomplete.rpartition("/")
    try:
        entries = sorted(Path(folder + slash or ".").iterdir())
    except OSError:
        return []
    return [
        f"{folder}{slash}{entry.name}{'/' if entry.is_dir() else ''}"
        for entry in entries
        if entry.name.startswith(name)
        and entry.name.startswith(".") <= name.startswith(".")
        and (entry.is_dir() or entry.suffix in endings)
    ]


def _unless_shells_do_better(found: list[str]) -> list[str]:
    """Leave to the shell what it completes without a space or has to quote."""
    odd = any(_ODD_CHARACTERS.intersection(name) for name in found)
    return [] if odd or all(name.endswith("/") for name in found) else found
