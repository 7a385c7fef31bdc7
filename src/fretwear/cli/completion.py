"""What the shell offers when a user presses the tab key.

Where nothing is returned the shell completes names of files by itself.  Shells put a space after
a word that is the only one left; where the user would have to go on without one, there are either
two candidates or none.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import typer

_STUDY_FILES = (".yaml", ".yml")
_CASE_FILES = (".nc",)
_STUDIES = "studies"
# All ids of a large study take seconds, too long for a key that seems to do nothing.
_MOST_POINTS = 2000
_ONLY_BY_NAME = ("output.cycles", "title")


def study_files(incomplete: str) -> list[str]:
    """Offer study files: those of the folder, and of ``studies/`` where no folder was typed."""
    found = _paths(incomplete, _STUDY_FILES)
    if "/" in incomplete or not Path(_STUDIES).is_dir():
        return found
    inside = [
        name
        for name in _entries(f"{_STUDIES}/", _STUDY_FILES)
        if name.startswith(incomplete) and not name.endswith("/")
    ]
    return [name for name in found if not (inside and name == f"{_STUDIES}/")] + inside


def case_files(incomplete: str) -> list[str]:
    """Offer case files and the folders that may hold some."""
    return _paths(incomplete, _CASE_FILES)


def case_ids(context: typer.Context, incomplete: str) -> list[str]:
    """Offer the ids of the cases of the study that was typed before."""
    from fretwear.study.problems import StudyError
    from fretwear.study.study import load_study

    # The file is not parsed yet where the option waits for its value.
    file = context.params.get("file") or next(iter(context.args), None)
    if file is None:
        return []
    try:
        study = load_study(file)
    except StudyError:
        return []
    points = study.points(1, min(study.size, _MOST_POINTS))
    ids = (point.id for point in points if point.case is not None)
    return list(dict.fromkeys(case_id for case_id in ids if case_id.startswith(incomplete)))


def assignments(incomplete: str) -> list[str]:
    """Offer names of parameters, and for the only one that is left an example of its value."""
    from fretwear.study.tree import example_of, parameter_names

    names = [*parameter_names(), *_ONLY_BY_NAME]
    found = [name for name in names if f"{name}=".startswith(incomplete)]
    if len(found) != 1:
        return [f"{name}=" for name in found]
    (name,) = found
    # A space would have to be quoted; "30N" means the same as "30 N".
    example = (example_of(name) or "...").replace(" ", "")
    return [f"{name}=", f"{name}={example}"]


def _paths(incomplete: str, endings: Sequence[str]) -> list[str]:
    found = [name for name in _entries(incomplete, endings) if name.startswith(incomplete)]
    # The shell completes a folder better, without a space; and it quotes odd characters.
    if all(name.endswith("/") for name in found) or any(_is_odd(name) for name in found):
        return []
    return found


def _entries(incomplete: str, endings: Sequence[str]) -> Iterator[str]:
    folder, slash, name = incomplete.rpartition("/")
    try:
        entries = sorted(Path(folder + slash or ".").iterdir())
    except OSError:
        return
    for entry in entries:
        if entry.name.startswith(".") and not name.startswith("."):
            continue
        if entry.is_dir():
            yield f"{folder}{slash}{entry.name}/"
        elif entry.suffix in endings:
            yield f"{folder}{slash}{entry.name}"


def _is_odd(name: str) -> bool:
    return any(character in " \t\n\"'\\$&;<>|*?[](){}!#`~" for character in name)
