"""What packages beside the core add to it, found by entry points of these groups.

fretwear.doors
    Functions that are names of the package, such as ``fretwear.fit``.
fretwear.commands
    Typer applications whose commands join the program.
fretwear.study_sections
    Subclasses of `StudySection`, named by the place of the section in a study file.
fretwear.figures, fretwear.sections
    Functions of a merged study and its folder of case files: more figures, sections of the report.
fretwear.plots
    Functions of a file: names and figures of ``fretwear plot``; none if it is of another kind.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fretwear.arrays import Array
    from fretwear.results import Variable
    from fretwear.study.case import Case
    from fretwear.study.problems import Problems


@cache
def plugins(group: str) -> dict[str, EntryPoint]:
    """The entry points of a group by name."""
    return {entry.name: entry for entry in entry_points(group=group)}


def study_sections() -> Iterator[tuple[str, type[StudySection]]]:
    """The sections that study files may have beside those of the core, with their places."""
    for place, entry in plugins("fretwear.study_sections").items():
        yield place, entry.load()


def added(group: str, *arguments: Any) -> Iterator[Any]:
    """Yield everything that the functions of a group return for these arguments."""
    for entry in plugins(group).values():
        yield from entry.load()(*arguments)


class StudySection:
    """A section of a study file: a pydantic dataclass of a package beside the core."""

    cycles: tuple[int, ...] | None = None
    """Snapshots that the section needs, which every case then keeps."""

    @property
    def files(self) -> Sequence[Path]:
        """Files that the section names."""
        return ()

    @classmethod
    def complete_base(
        cls,
        given: object,  # noqa: ARG003
        base: Mapping[str, object],
        vary: Mapping[str, object],  # noqa: ARG003
        problems: Problems,  # noqa: ARG003
    ) -> Mapping[str, object]:
        """The plain keys of `base` with those that this section makes superfluous."""
        return base

    def check(self, cases: Sequence[Case | None], problems: Problems) -> None:
        """Add the problems of the section with the cases of the points of the study."""

    def seconds(self, case: Case, cells: float) -> float:  # noqa: ARG002
        """The processor time that it adds to a case with so many cells, s."""
        return 0.0

    def after_case(self, case: Path) -> None:
        """Compute what the section adds to a case that has just been finished."""

    def extra_results(
        self,
        case: Path,  # noqa: ARG002
        cycles: Array,  # noqa: ARG002
        tell: Callable[[str], None],  # noqa: ARG002
    ) -> Mapping[Variable, Array]:
        """More results of a case file over cycles, for the merged study."""
        return {}
