"""``fretwear show`` and ``fretwear plot``: a look at one case file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fretwear.cli.arguments import CaseFile
from fretwear.cli.outputs import check_file
from fretwear.cli.status import Status, failing_as

_FORMATS = (".png", ".svg", ".pdf")


def show(file: CaseFile) -> None:
    """Print the parameters of a case and its key results beside those of smooth elastic bodies."""
    from fretwear.cli.summary import summary_lines
    from fretwear.data.errors import DataFileError
    from fretwear.data.store import open_case, open_history

    with (
        failing_as(Status.WRONG_INPUT, DataFileError),
        open_case(file) as case,
        open_history(file) as history,
    ):
        for line in summary_lines(case, history):
            typer.echo(line)


def plot(
    file: CaseFile,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FIG.png",
            help="File to write: .png, .svg or .pdf.",
            show_default="OUT.png",
        ),
    ] = None,
) -> None:
    """Draw pressure, shear, gap and wear along x, and a map of the scar."""
    path = check_file(output or file.with_suffix(".png"), *_FORMATS)

    from fretwear.data.errors import DataFileError
    from fretwear.data.store import open_case, open_history

    with (
        failing_as(Status.WRONG_INPUT, DataFileError),
        open_case(file) as case,
        open_history(file) as history,
    ):
        from fretwear.figures import overview, save_as

        figure = overview(case, history)
    with failing_as(Status.FAILED, DataFileError):
        save_as(figure, path)
    typer.echo(str(path))
