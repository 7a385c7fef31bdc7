"""Messages for people, as text."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from fretwear.cli.log.base import Log

if TYPE_CHECKING:
    from rich.console import Console


class TextLog(Log):
    """Says everything but the progress of cases, which others add."""

    def error(self, message: str, exit_status: int) -> None:
        """Say what went wrong and what to do."""
        del exit_status
        self._labelled("error", message)

    def stopped(self, message: str, exit_status: int) -> None:
        """Say that the command was stopped from outside, and by what."""
        del exit_status
        self._labelled("stopped", message)

    def note(self, message: str) -> None:
        """Say something that is worth knowing and neither an error nor a result."""
        self._print(message)

    def result(self, file: Path, message: str, **numbers: float) -> None:
        """Say what the command has led to, on the standard output."""
        del numbers
        typer.echo(f"{file}: {message}" if message else str(file))

    def _console(self) -> Console:
        from rich.console import Console

        return Console(stderr=True, highlight=False)

    def _print(self, message: str) -> None:
        # Names of files are no markup, and lines stay whole for those who search a log.
        self._console().print(message, markup=False, emoji=False, soft_wrap=True)

    def _labelled(self, label: str, message: str) -> None:
        from rich.text import Text

        text = Text.assemble((f"fretwear: {label}: ", "bold red"), message)
        self._console().print(text, soft_wrap=True)
