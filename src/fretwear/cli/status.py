"""How a command ends: exit statuses, and messages for people instead of tracebacks."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from enum import IntEnum

import typer


class Status(IntEnum):
    """Exit status of a command that was not stopped from outside."""

    DONE = 0
    FAILED = 1
    WRONG_INPUT = 2


@contextmanager
def failing_as(status: Status, *errors: type[Exception]) -> Iterator[None]:
    """Turn errors of the given kinds into a message and an exit status."""
    try:
        yield
    except errors as error:
        complain(str(error) or type(error).__name__)
        raise typer.Exit(status) from error


def refuse(message: str) -> typer.Exit:
    """Say what is wrong with the input; the result is to be raised."""
    complain(message)
    return typer.Exit(Status.WRONG_INPUT)


def complain(message: str, label: str = "error") -> None:
    """Print a message to the standard error stream after a label, which a terminal shows in red.

    The message is printed as it is: names of files and values are no markup, and no line of it is
    broken, so that logs can be searched.
    """
    from rich.console import Console
    from rich.text import Text

    text = Text.assemble((f"fretwear: {label}: ", "bold red"), message)
    Console(stderr=True, highlight=False).print(text, soft_wrap=True)
