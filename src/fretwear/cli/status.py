"""How a command ends: exit statuses, and errors that become messages instead of tracebacks."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from enum import IntEnum


class Status(IntEnum):
    """Exit status of a command that was not stopped from outside."""

    DONE = 0
    FAILED = 1
    WRONG_INPUT = 2


class CommandError(Exception):
    """What ends a command with a message; the group of commands prints it.

    Attributes
    ----------
    message : str
        What was wrong and what to do.
    status : Status
        Exit status.
    """

    def __init__(self, message: str, status: Status) -> None:
        super().__init__(message, status)
        self.message = message
        self.status = status

    def __str__(self) -> str:
        return self.message


@contextmanager
def failing_as(status: Status, *errors: type[Exception]) -> Iterator[None]:
    """Turn errors of the given kinds into a message and an exit status."""
    try:
        yield
    except errors as error:
        raise CommandError(str(error) or type(error).__name__, status) from error


def refuse(message: str) -> CommandError:
    """Return the error that says what is wrong with the input; it is to be raised."""
    return CommandError(message, Status.WRONG_INPUT)
