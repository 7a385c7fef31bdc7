"""The command ``fretwear`` and what it consists of."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any

import typer

import fretwear
from fretwear.cli.animate import animate
from fretwear.cli.batch import batch
from fretwear.cli.commands import Command, Commands
from fretwear.cli.compare import compare
from fretwear.cli.look import plot, show
from fretwear.cli.plan import plan, schema
from fretwear.cli.run import run
from fretwear.cli.signals import stopping
from fretwear.cli.steps import figures, merge, report

_SUMMARY = "Simulate fretting wear of rough, yielding bodies in partial slip."
_WORKFLOW = "Steps of the workflow"

app = typer.Typer(
    name="fretwear",
    cls=Commands,
    help=_SUMMARY,
    epilog="[dim]Example:[/dim] fretwear plan studies/demo.yaml\n\n"
    "[dim]Whole studies:[/dim] snakemake --cores 2 --config study=demo\n\n"
    "[dim]Exit status:[/dim] 0 done, 1 failed, 2 wrong input, 130 Ctrl-C, 143 SIGTERM",
    no_args_is_help=True,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _add(function: Callable[..., Any], example: str, panel: str | None = None) -> None:
    app.command(cls=Command, rich_help_panel=panel, epilog=f"[dim]Example:[/dim] {example}")(
        function
    )


_add(plan, "fretwear plan studies/demo.yaml")
_add(run, "fretwear run studies/demo.yaml --case ID --set 'load=30 N'")
_add(show, "fretwear show results/demo/cases/ID.nc")
_add(plot, "fretwear plot results/demo/cases/ID.nc -o overview.svg")
_add(compare, "fretwear compare A.nc B.nc -o comparison.png")
_add(animate, "fretwear animate results/demo/cases/ID.nc -o wear.gif")
_add(schema, "fretwear schema > study.schema.json")
_add(batch, "fretwear batch studies/demo.yaml --points 1-12", _WORKFLOW)
_add(merge, "fretwear merge studies/demo.yaml", _WORKFLOW)
_add(figures, "fretwear figures studies/demo.yaml", _WORKFLOW)
_add(report, "fretwear report studies/demo.yaml", _WORKFLOW)


def main() -> None:
    """Run the command line and leave with its exit status."""
    with stopping():
        app()


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
