"""What is wrong with a call that cannot be parsed, and how it should be."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from typing import Any

import typer
from typer.core import TyperGroup

_TOO_MANY = "Got unexpected extra argument(s)"
_QUOTES = "put a value with a space in quotes, such as --set 'load=30 N'"


def what_is_wrong(error: typer.TyperException, arguments: Sequence[str]) -> str:
    """Say what is wrong with a call and where to read how it should be; or nothing.

    Parameters
    ----------
    error
        What typer has raised.
    arguments
        The call, without the name of the program.
    """
    if type(error).__name__ == "NoArgsIsHelpError":
        return ""  # the help was printed
    context = getattr(error, "ctx", None)
    message = error.format_message().rstrip(".").replace("Value error, ", "")
    option = getattr(error, "option_name", "")
    if near := difflib.get_close_matches(option, getattr(error, "possibilities", None) or [], n=1):
        message = f"{error.message.rstrip('.')}; did you mean {near[0]}?"
    hints = [f"'{_command_path(context, arguments)} --help' tells how to call it"]
    if message.startswith(_TOO_MANY):
        message = f"unexpected: {message.removeprefix(_TOO_MANY).strip(' ()')}"
        hints = [_QUOTES, *hints] if "--set" in arguments else hints
    if belongs := _where_it_belongs(option, context):
        hints = [belongs]
    return "\n    ".join([f"{message[:1].lower()}{message[1:]}", *hints])


def _command_path(context: Any, arguments: Sequence[str]) -> str:
    """Name the command that was called, as far as the call is understood."""
    if context is not None:
        return str(context.command_path)
    return f"fretwear {next((word for word in arguments if word[0] != '-'), '')}".rstrip()


def _where_it_belongs(option: str, context: Any) -> str:
    """Say after which command an option goes that stands before all of them; or nothing."""
    if context is None or not isinstance(context.command, TyperGroup):
        return ""
    for name, command in context.command.commands.items():
        if any(option in param.opts for param in command.params):
            return f"options follow the command: fretwear {name} {option} ..."
    return ""
