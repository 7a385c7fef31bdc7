"""The program ``fretwear``: its commands and help, and how errors become messages and statuses."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Sequence
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

import fretwear
from fretwear.cli import commands
from fretwear.cli.common import CommandError, Help, Status, add_command, note, say
from fretwear.cli.export import export
from fretwear.cli.show import compare, show
from fretwear.plugins import plugins
from fretwear.study.problems import StudyError

_WORKFLOW = "Steps of the workflow"
_STOPPED = "stopped; the same command resumes a run from its checkpoint"


class _Commands(Help, TyperGroup):
    """The group of all commands; an error that ends one becomes a message and a status."""

    def main(self, *args: Any, **extra: Any) -> Any:
        """Run a command and leave with its exit status."""
        given = args[0] if args else extra.pop("args", None)
        arguments = sys.argv[1:] if given is None else list(given)
        extra |= {"standalone_mode": False, "obj": arguments}
        try:
            status = super().main(arguments, **extra)
        except BaseException as error:
            status = _told(error, arguments)
            if status is None:
                raise
        if status == 128 + signal.SIGINT:  # typer turns Ctrl-C into a status
            note(_STOPPED)
        sys.exit(status if isinstance(status, int) else Status.DONE)


def _told(error: BaseException, arguments: Sequence[str]) -> int | None:
    """Print what ended a command and return its exit status; None if it is a defect."""
    if type(error).__name__ == "NoArgsIsHelpError":  # the help was printed
        return Status.WRONG_INPUT
    if isinstance(error, OSError) and isinstance(error.__context__, SystemExit):
        error = error.__context__  # the terminal was closed, and its bar cannot be removed
    if isinstance(error, SystemExit):
        status = int(error.code or 0)
        if status > 128:
            note(_STOPPED)
        return status
    if isinstance(error, BrokenPipeError):
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115, PTH123 - flushed at exit
        return Status.FAILED
    if isinstance(error, typer.TyperException):
        status, message = Status.WRONG_INPUT, what_is_wrong(error, arguments)
    elif isinstance(error, CommandError | StudyError):
        status, message = getattr(error, "status", Status.WRONG_INPUT), str(error)
    else:
        from fretwear.run.cases import EXPECTED

        if not isinstance(error, EXPECTED):
            return None
        status, message = Status.FAILED, str(error) or "there is not enough memory"
    note(f"error: {message}")
    return status


def what_is_wrong(error: typer.TyperException, arguments: Sequence[str]) -> str:
    """Return the problem of a call that cannot be parsed, and where to read its correct form."""
    path = getattr(getattr(error, "ctx", None), "command_path", "fretwear")
    if path == "fretwear" and error.__class__.__name__ == "BadOptionUsage":  # has no context
        path = " ".join(["fretwear", *(a for a in arguments[:1] if not a.startswith("-"))])
    message = error.format_message().rstrip(".,").replace("Value error, ", "")
    message = " ".join(message.replace("Input should be", "must be").split())
    lines = [f"{message[:1].lower()}{message[1:]}"]
    if "unexpected extra" in message and "--set" in arguments:
        lines.append("put a value with a space in quotes, such as --set 'load=30 N'")
    if path == "fretwear" and lines[0].startswith("no such option"):
        lines.append("options follow the command, such as fretwear plan FILE --all")
    return "\n    ".join([*lines, f"see '{path} --help'"])


app = typer.Typer(
    name="fretwear",
    cls=_Commands,
    epilog="[dim]Example:[/dim] fretwear plan studies/demo.yaml\n\n"
    "[dim]Whole studies:[/dim] snakemake --cores 2 --config study=demo\n\n"
    "[dim]Exit status:[/dim] 0 done, 1 failed, 2 wrong input, 129 closed terminal, "
    "130 Ctrl-C, 143 SIGTERM",
    no_args_is_help=True,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


add_command(app, commands.init, "fretwear init my-study")
add_command(app, commands.plan, "fretwear plan studies/demo.yaml")
add_command(app, commands.run_case, "fretwear run studies/demo.yaml --case ID --set 'load=30 N'")
add_command(app, show, "fretwear show results/demo/cases/ID.nc")
add_command(app, commands.plot, "fretwear plot results/demo/cases/ID.nc -o overview.svg")
add_command(app, compare, "fretwear compare A.nc B.nc -o comparison.png")
add_command(app, export, "fretwear export results/demo/cases/ID.nc --to vtk")
add_command(app, commands.schema, "fretwear schema > study.schema.json")
add_command(app, commands.coefficients, "fretwear coefficients Ti-6Al-4V")
add_command(app, commands.merge, "fretwear merge studies/demo.yaml", _WORKFLOW)
add_command(app, commands.figures, "fretwear figures studies/demo.yaml", _WORKFLOW)
add_command(app, commands.report, "fretwear report studies/demo.yaml", _WORKFLOW)


# A package that extends fretwear names a typer application with commands of its own.
for _entry in plugins("fretwear.commands").values():
    app.add_typer(_entry.load())


def _print_version(asked: bool) -> None:
    if asked:
        say(f"fretwear {fretwear.__version__}")
        raise typer.Exit


_VERSION = typer.Option(
    "--version", callback=_print_version, is_eager=True, help="Print the version and exit."
)


@app.callback()
def _fretwear(version: Annotated[bool, _VERSION] = False) -> None:
    """Simulate fretting wear of rough, yielding bodies in partial slip."""
