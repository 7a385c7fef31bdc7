"""``fretwear show`` and ``fretwear plot``: a look at one file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from fretwear.cli.arguments import CaseFile
from fretwear.cli.completion import case_files
from fretwear.cli.inputs import check_results
from fretwear.cli.outputs import FIGURE_FORMATS, check_file
from fretwear.cli.status import Status, failing_as


def show(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="OUT.nc",
            help="Case file, or summary.nc of a study.",
            show_default=False,
            autocompletion=case_files,
        ),
    ],
    as_json: Annotated[
        bool, typer.Option("--json", help="Print JSON in SI units, for scripts.")
    ] = False,
) -> None:
    """Print the parameters of a case and its key results beside those of smooth elastic bodies.

    Of a merged study, print the key results of every point.
    """
    check_results(file)

    from fretwear.cli.glance import glance_at
    from fretwear.data.safe import DataFileError

    with failing_as(Status.WRONG_INPUT, DataFileError), glance_at(file) as seen:
        if as_json:
            typer.echo(json.dumps(seen.content(), indent=2, ensure_ascii=False, allow_nan=False))
        else:
            for line in seen.lines():
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
    check_results(file)
    path = check_file(output or file.with_suffix(".png"), *FIGURE_FORMATS)

    from fretwear.data.files import open_case, open_history
    from fretwear.data.safe import DataFileError

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
