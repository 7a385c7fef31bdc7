"""``fretwear compare``: two case files side by side."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fretwear.cli import completion
from fretwear.cli.inputs import check_results
from fretwear.cli.outputs import FIGURE_FORMATS, check_file
from fretwear.cli.status import Status, failing_as

if TYPE_CHECKING:
    import xarray as xr

_DIGITS = 3


def compare(
    first: Annotated[
        Path,
        typer.Argument(
            metavar="A.nc",
            help="Case file (netCDF).",
            show_default=False,
            autocompletion=completion.case_files,
        ),
    ],
    second: Annotated[
        Path,
        typer.Argument(
            metavar="B.nc",
            help="Case file to compare it with.",
            show_default=False,
            autocompletion=completion.case_files,
        ),
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FIG.png",
            help="Draw both over each other, to this file: .png, .svg or .pdf.",
            show_default="no figure",
        ),
    ] = None,
) -> None:
    """Print the parameters in which two cases differ, and their key results with the ratios."""
    for file in (first, second):
        check_results(file)
    path = None if output is None else check_file(output, *FIGURE_FORMATS)

    from fretwear.data.files import open_case, open_history
    from fretwear.data.safe import DataFileError

    with (
        failing_as(Status.WRONG_INPUT, DataFileError),
        open_case(first) as a,
        open_case(second) as b,
        open_history(first) as history_a,
        open_history(second) as history_b,
    ):
        for line in comparison_lines(a, b, first, second):
            typer.echo(line)
        if path is None:
            return
        from fretwear.figures import compare_cases, save_as

        figure = compare_cases({"A": a, "B": b}, {"A": history_a, "B": history_b})
    with failing_as(Status.FAILED, DataFileError):
        save_as(figure, path)
    typer.echo("")
    typer.echo(str(path))


def comparison_lines(
    a: xr.Dataset, b: xr.Dataset, first: Path | str, second: Path | str
) -> Iterator[str]:
    """Yield the lines that compare two cases.

    Parameters
    ----------
    a, b : xarray.Dataset
        The cases.
    first, second : path or str
        What they are called.
    """
    from fretwear.cli.tables import aligned
    from fretwear.data.dataset import different_parameters

    yield f"A  {first}"
    yield f"B  {second}"
    yield ""
    names = different_parameters(a, b)
    if names:
        yield "Parameters that differ"
        yield from aligned([("", "A", "B"), *(_parameter(a, b, name) for name in names)])
    else:
        yield "All parameters are the same."
    yield ""
    yield "Results"
    yield from aligned(list(_results(a, b)))


def _parameter(a: xr.Dataset, b: xr.Dataset, name: str) -> tuple[str, str, str]:
    from fretwear.cli.tables import name_of, text_of

    words = name_of(a[name] if name in a.coords else b[name])
    mine, other = (text_of(case[name]) if name in case.coords else "-" for case in (a, b))
    return words, mine, other


def _results(a: xr.Dataset, b: xr.Dataset) -> Iterator[tuple[str, ...]]:
    from fretwear.cli.tables import quantity_text
    from fretwear.data.dataset import compared_cycles, compared_results

    at = [f"cycle {cycle}" for cycle in compared_cycles(a, b)]
    yield ("", f"A, {at[0]}", f"B, {at[1]}", "B/A")
    for result in compared_results(a, b):
        values = (
            quantity_text(value, result.variable.si_unit) for value in (result.first, result.second)
        )
        ratio = f"{result.ratio:.{_DIGITS}g}" if result.first else "-"
        yield (result.variable.words, *values, ratio)
