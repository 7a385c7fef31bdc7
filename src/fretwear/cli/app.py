"""The command ``fretwear`` and what it consists of."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

import fretwear
from fretwear.cli.look import plot, show
from fretwear.cli.plan import plan, schema
from fretwear.cli.run import run
from fretwear.cli.signals import Stopped, stopping
from fretwear.cli.status import complain
from fretwear.cli.steps import figures, merge, report

_EXAMPLE = "[dim]Example:[/dim] "
_WORKFLOW = "Steps of the workflow"

app = typer.Typer(
    name="fretwear",
    help="Simulate fretting wear of rough, yielding bodies in partial slip.",
    epilog="Exit status: 0 done, 1 the simulation failed, 2 the input is wrong, "
    "130 or 143 stopped by Ctrl-C or by SIGTERM.",
    no_args_is_help=True,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

app.command(epilog=f"{_EXAMPLE}fretwear run studies/demo.yaml --case ID --set 'load=30 N'")(run)
app.command(epilog=f"{_EXAMPLE}fretwear plan studies/demo.yaml")(plan)
app.command(epilog=f"{_EXAMPLE}fretwear show results/demo/cases/ID.nc")(show)
app.command(epilog=f"{_EXAMPLE}fretwear plot results/demo/cases/ID.nc -o overview.svg")(plot)
app.command(epilog=f"{_EXAMPLE}fretwear schema > study.schema.json")(schema)
app.command(rich_help_panel=_WORKFLOW, epilog=f"{_EXAMPLE}fretwear merge studies/demo.yaml")(merge)
app.command(rich_help_panel=_WORKFLOW, epilog=f"{_EXAMPLE}fretwear figures studies/demo.yaml")(
    figures
)
app.command(rich_help_panel=_WORKFLOW, epilog=f"{_EXAMPLE}fretwear report studies/demo.yaml")(
    report
)


def main() -> None:
    """Run the command line and leave with its exit status."""
    try:
        with stopping():
            app()
    except Stopped as stopped:
        complain(f"{stopped}; no unfinished file was left behind", label="stopped")
        sys.exit(stopped.exit_status)


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"fretwear {fretwear.__version__}")
        raise typer.Exit


@app.callback()
def _fretwear(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version and leave."
        ),
    ] = False,
) -> None:
    """Simulate fretting wear of rough, yielding bodies in partial slip."""
