"""The program ``fretwear``: its commands and help, and how errors become messages and statuses."""

from __future__ import annotations

import os
import re
import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

import fretwear
from fretwear.cli import Stopped, commands
from fretwear.cli.commands import LOG_FORMAT_VARIABLE, Call
from fretwear.cli.common import CommandError, Help, Status, add_command, say
from fretwear.cli.export import export
from fretwear.cli.show import compare, show
from fretwear.plugins import plugins
from fretwear.study.problems import StudyError

_WORKFLOW = "Steps of the workflow"


class _Commands(Help, TyperGroup):
    """The group of all commands; an error that ends one becomes a message and a status."""

    def main(self, *args: Any, **extra: Any) -> Any:
        """Run a command and leave with its exit status."""
        arguments = args[0] if args else extra.pop("args", None)
        call = Call(sys.argv[1:] if arguments is None else arguments)
        extra |= {"standalone_mode": False, "obj": call}
        # A log may take over the warnings of this call, but not of later ones.
        with warnings.catch_warnings():
            try:
                with swallowing_no_lack_of_memory():
                    status = super().main(call.arguments, **extra)
                status = status if isinstance(status, int) else Status.DONE
            except BaseException as error:
                status = _tell(error, call)
            if call.log is not None:
                call.log.end(status)
        sys.exit(status)


@contextmanager
def swallowing_no_lack_of_memory() -> Iterator[None]:
    """Raise, at the end, a lack of memory that a library swallowed: its work is incomplete."""
    lost = []

    def hear(unraisable: sys.UnraisableHookArgs) -> None:
        if isinstance(unraisable.exc_value, MemoryError):
            lost.append(unraisable.exc_value)
        else:
            sys.__unraisablehook__(unraisable)

    before, sys.unraisablehook = sys.unraisablehook, hear
    try:
        yield
    except Exception:
        if not lost:
            raise
    finally:
        sys.unraisablehook = before
    if lost:
        raise MemoryError from lost[0]


def _tell(error: BaseException, call: Call) -> int:
    """Report the error that ended a command; return its exit status."""
    if type(error).__name__ == "NoArgsIsHelpError":  # the help was printed
        return Status.WRONG_INPUT
    if not isinstance(error, Exception | Stopped):
        raise error
    from fretwear.cli.progress import Log

    # An error of parsing is reported in the format that was asked for.
    typed = re.findall(r"--log-format[= ](\S+)", " ".join(call.arguments))
    log = call.log or Log([os.environ.get(LOG_FORMAT_VARIABLE, ""), *typed][-1])
    if isinstance(error, Stopped):
        message = f"{error}; run the same command again to resume"
        log.error(message, error.exit_status, event="stopped")
        return error.exit_status
    status, message, defect = int(Status.FAILED), str(error), None
    if isinstance(error, typer.TyperException):
        status, message = Status.WRONG_INPUT, what_is_wrong(error, call.arguments)
    elif isinstance(error, CommandError | StudyError):
        status = getattr(error, "status", Status.WRONG_INPUT)
    else:
        from fretwear.run.batch import reason_of

        message, is_defect = reason_of(error)
        defect = error if is_defect else None
    log.error(message, status, defect=defect)
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
        lines.append("options follow the command, such as fretwear run --quiet")
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
add_command(app, commands.animate, "fretwear animate results/demo/cases/ID.nc -o wear.gif")
add_command(app, export, "fretwear export results/demo/cases/ID.nc --to vtk")
add_command(app, commands.schema, "fretwear schema > study.schema.json")
add_command(app, commands.coefficients, "fretwear coefficients Ti-6Al-4V")
add_command(app, commands.batch, "fretwear batch studies/demo.yaml --points 1-12", _WORKFLOW)
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
