"""``fretwear show`` and ``fretwear plot``: a look at one file."""

from __future__ import annotations

import difflib
import json
from pathlib import Path
from typing import Annotated

import typer

from fretwear.cli.arguments import CaseFile
from fretwear.cli.completion import case_files
from fretwear.cli.outputs import check_file
from fretwear.cli.status import Status, failing_as, refuse

_FORMATS = (".png", ".svg", ".pdf")
_STUDY_FILES = (".yaml", ".yml")
_LISTED = 5
_WHERE = "the cases of a study lie in results/STUDY/cases/; fretwear run computes one"


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
    _check_kind(file)

    from fretwear.cli.glance import glance_at
    from fretwear.data.errors import DataFileError

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
    _check_kind(file)
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


def _check_kind(file: Path) -> None:
    """Leave with a hint where a file is not there or is something else than results."""
    if file.is_dir():
        found = sorted([*file.glob("*.nc"), *file.glob("cases/*.nc")])
        more = f" and {len(found) - _LISTED} more" if len(found) > _LISTED else ""
        names = "".join(f"\n    {name}" for name in found[:_LISTED])
        hint = f"; give one of its files, such as{names}{more}" if found else " without results"
        raise refuse(f"{file}: is a folder{hint}")
    if file.suffix in _STUDY_FILES and file.exists():
        raise refuse(
            f"{file}: is a study file, and no results\n"
            f"    fretwear plan {file} lists its cases, fretwear run computes them"
        )
    if not file.exists():
        near = difflib.get_close_matches(file.name, _names(file.parent), n=1, cutoff=0.7)
        hint = f"did you mean {str(file.with_name(near[0]))!r}?" if near else ""
        raise refuse(f"{file}: there is no such file\n    {hint or _WHERE}")


def _names(folder: Path) -> list[str]:
    try:
        return [path.name for path in folder.iterdir()]
    except OSError:
        return []
