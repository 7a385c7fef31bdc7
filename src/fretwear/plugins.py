"""Extensions of the core by other packages, found by entry points of these groups.

fretwear.doors
    Functions that are names of the package, such as ``fretwear.fit``.
fretwear.commands
    Typer applications whose commands join the program.
fretwear.parts
    Modules that define more kinds of parts of a case.
fretwear.study_sections
    Subclasses of `StudySection`, named by the place of the section in a study file.
fretwear.figures, fretwear.sections
    Functions of a merged study and its folder of case files: more figures, sections of the report.
fretwear.plots
    Functions of a file: names and figures of ``fretwear plot``; none if it is of another kind.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any


@cache
def plugins(group: str) -> dict[str, EntryPoint]:
    """The entry points of a group by name."""
    return {entry.name: entry for entry in entry_points(group=group)}


def added(group: str, *arguments: object) -> Iterator[Any]:
    """Yield everything that the functions of a group return for these arguments."""
    for entry in plugins(group).values():
        yield from entry.load()(*arguments)
