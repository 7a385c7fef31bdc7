"""The group of commands: one form for all errors, and help that shows no types of flags."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Sequence
from typing import Any

import typer
from typer.core import TyperCommand, TyperGroup

from fretwear.cli.log import Log, LogFormat, chosen_log
from fretwear.cli.log.choose import format_in_call
from fretwear.cli.signals import Stopped
from fretwear.cli.status import CommandError, Status
from fretwear.cli.wrong_call import what_is_wrong


class Call:
    """One call of the command line: what the context of every command carries.

    Attributes
    ----------
    arguments : sequence of str
        What was typed after ``fretwear``.
    log : Log
        Takes all messages; until a command opens its own, one that suits the arguments as they are.
    """

    def __init__(self, arguments: Sequence[str]) -> None:
        self.arguments = arguments
        self._log: Log | None = None

    @property
    def log(self) -> Log:
        """The log that the command has opened, or one for errors only."""
        if self._log is None:
            log_format = format_in_call(self.arguments, os.environ)
            self._log = chosen_log(log_format, quiet=False)
        return self._log

    def open_log(self, command: str, log_format: LogFormat, *, quiet: bool) -> Log:
        """Open the log of a command that begins to work."""
        self._log = chosen_log(log_format, quiet=quiet)
        self._log.begin(command)
        return self._log


def open_log(context: typer.Context, log_format: LogFormat, *, quiet: bool) -> Log:
    """Open the log of the command with this context."""
    call: Call = context.obj
    return call.open_log(str(context.info_name), log_format, quiet=quiet)


class Command(TyperCommand):
    """A command whose flags are listed without a type, and its arguments without braces."""

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        """Return the words of the usage line; nobody is to type a brace."""
        return [piece.strip("{}") for piece in super().collect_usage_pieces(ctx)]

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Print the help."""
        _colour_terminals_only()
        super().format_help(ctx, formatter)

    def get_params(self, ctx: Any) -> list[Any]:
        """Return all parameters, ``--help`` included."""
        return _without_types_of_flags(super().get_params(ctx))


class Commands(TyperGroup):
    """All commands; whatever ends one of them with an error becomes a message and a status."""

    def get_params(self, ctx: Any) -> list[Any]:
        """Return all parameters, ``--help`` included."""
        return _without_types_of_flags(super().get_params(ctx))

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Print the help."""
        _colour_terminals_only()
        super().format_help(ctx, formatter)

    def main(
        self,
        args: Sequence[str] | None = None,
        prog_name: str | None = None,
        complete_var: str | None = None,
        standalone_mode: bool = True,
        windows_expand_args: bool = True,
        **extra: Any,
    ) -> Any:
        """Run a command; leave with its exit status, except where that is not wanted."""
        call = Call(sys.argv[1:] if args is None else args)

        def run() -> Any:
            return super(Commands, self).main(
                args,
                prog_name,
                complete_var,
                standalone_mode=False,
                windows_expand_args=windows_expand_args,
                obj=call,
                **extra,
            )

        if not standalone_mode:
            return run()
        # A log may take the warnings of this call, and of no later one.
        with warnings.catch_warnings():
            status = _status(run, call)
            call.log.end(status)
        sys.exit(status)


def _status(run: Any, call: Call) -> int:
    """Run a command; turn every error into a message, and return the exit status."""
    try:
        status = run()
    except CommandError as error:
        call.log.error(error.message, error.status)
        return error.status
    except typer.TyperException as error:
        if message := what_is_wrong(error, call.arguments):
            call.log.error(message, Status.WRONG_INPUT)
        return Status.WRONG_INPUT
    except Stopped as stopped:
        call.log.stopped(f"{stopped}; the same command goes on from here", stopped.exit_status)
        return stopped.exit_status
    except Exception as error:
        call.log.defect(error)
        return Status.FAILED
    return status if isinstance(status, int) else Status.DONE


def _colour_terminals_only() -> None:
    """Keep typer from colouring what is no terminal, as it does where GitHub runs it."""
    from typer import rich_utils

    rich_utils.FORCE_TERMINAL = True if os.environ.get("FORCE_COLOR") else None


def _without_types_of_flags(params: list[Any]) -> list[Any]:
    for param in params:
        if getattr(param, "is_flag", False):
            param.metavar = ""
    return params
