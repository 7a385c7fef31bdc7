"""The program ``fretwear``: its commands and help, and how errors become messages and statuses."""

from __future__ import annotations

from typing import Annotated, Any

import typer
from typer.core import TyperGroup

import fretwear
from fretwear.cli import commands
from fretwear.cli.common import CommandError, Status, add_command, note, say
from fretwear.cli.export import export
from fretwear.cli.show import compare, show
from fretwear.plugins import plugins

_WORKFLOW = "Steps of the workflow"


class _Commands(TyperGroup):
    """The group of all commands; an error that ends one becomes a message and a status."""

    def invoke(self, ctx: Any) -> object:
        """Run a command; typer itself answers calls that it cannot parse."""
        try:
            return super().invoke(ctx)
        except BaseException as error:
            if isinstance(error, OSError) and isinstance(error.__context__, SystemExit):
                error = error.__context__  # the terminal was closed, and its bar cannot be removed
            if isinstance(error, KeyboardInterrupt | SystemExit):
                note("stopped; the same command resumes a run from its checkpoint")
            elif (status := _status(error)) is not None:
                note(f"error: {str(error) or 'there is not enough memory'}")
                raise typer.Exit(status) from error
            raise error


def _status(error: BaseException) -> Status | None:
    """Return the exit status of an error whose message says all; None if it is a defect."""
    if isinstance(error, CommandError):
        return error.status
    if isinstance(error, BrokenPipeError | typer.Exit | typer.TyperException):
        return None

    from fretwear.run.case_files import EXPECTED
    from fretwear.study.mistakes import StudyError

    if isinstance(error, StudyError):
        return Status.WRONG_INPUT
    return Status.FAILED if isinstance(error, EXPECTED) else None


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
add_command(app, compare, "fretwear compare A.nc B.nc")
add_command(app, export, "fretwear export results/demo/cases/ID.nc --to vtk")
add_command(app, commands.schema, "fretwear schema > study.schema.json")
add_command(app, commands.coefficients, "fretwear coefficients")
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
