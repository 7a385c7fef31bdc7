"""What every log can be told, whatever it makes of it."""

from __future__ import annotations

import traceback
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from fretwear.running.simulate import Step
    from fretwear.study.case import Case

Observer = Callable[["Step"], None]


class Log(ABC):
    """The one who is told what a command does.

    Errors and progress go to the standard error stream; what a command has led to goes to the
    standard output, if people are to read it.
    """

    def begin(self, command: str) -> None:
        """Say that a command begins to work; people know what they have called."""
        del command

    def end(self, exit_status: int) -> None:
        """Say that the command ends; people see that it does."""
        del exit_status

    @abstractmethod
    def error(self, message: str, exit_status: int) -> None:
        """Say what went wrong and what to do."""

    def defect(self, error: Exception) -> None:
        """Say that something happened that never should."""
        lines = "".join(traceback.format_exception(error))
        self.error(f"{describe_defect(error)}\n{lines.rstrip()}", 1)

    @abstractmethod
    def stopped(self, message: str, exit_status: int) -> None:
        """Say that the command was stopped from outside, and by what."""

    @abstractmethod
    def note(self, message: str) -> None:
        """Say something that is worth knowing and neither an error nor a result."""

    @abstractmethod
    def result(self, file: Path, message: str, **numbers: float) -> None:
        """Say what the command has led to.

        Parameters
        ----------
        file
            The file or folder that was written.
        message
            More for people, such as how long it took; may be empty.
        numbers
            More for programs, such as how many points are done.
        """

    @abstractmethod
    def case(self, case: Case, file: Path) -> AbstractContextManager[Observer]:
        """Tell of a case that runs in the context; the observer is to be called at every step."""

    def batch(self, cases: Mapping[str, Case]) -> AbstractContextManager[None]:
        """Tell of several cases that run in the context one after the other, each by `case`.

        Parameters
        ----------
        cases
            Those that will run, by id: not those that are done already.
        """
        del cases
        return nullcontext()


class QuietLog(Log):
    """Passes nothing but errors on to another log."""

    def __init__(self, log: Log) -> None:
        self._log = log

    def error(self, message: str, exit_status: int) -> None:
        """Say what went wrong and what to do."""
        self._log.error(message, exit_status)

    def defect(self, error: Exception) -> None:
        """Say that something happened that never should."""
        self._log.defect(error)

    def stopped(self, message: str, exit_status: int) -> None:
        """Say that the command was stopped from outside, and by what."""
        self._log.stopped(message, exit_status)

    def note(self, message: str) -> None:
        """Say nothing."""

    def result(self, file: Path, message: str, **numbers: float) -> None:
        """Say nothing."""

    @contextmanager
    def case(self, case: Case, file: Path) -> Iterator[Observer]:
        """Say nothing."""
        del case, file

        def observe(step: Step) -> None:
            del step

        yield observe


def describe_defect(error: Exception) -> str:
    """Say in a line that an error is not the user's fault."""
    name = type(error).__name__
    return f"this is a defect of fretwear, please report it: {name}: {error}".rstrip(": ")
