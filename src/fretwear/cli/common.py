"""Shared by commands: exit statuses, options, checks of given files."""

from __future__ import annotations

import inspect
import os
import re
import shlex
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from enum import IntEnum
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fretwear.units import listed

if TYPE_CHECKING:
    import xarray as xr

    from fretwear.study.study import Study

FIGURE_FORMATS = (".png", ".svg", ".pdf")


class Status(IntEnum):
    """Exit status of a command that was not stopped by a signal."""

    DONE = 0
    FAILED = 1
    WRONG_INPUT = 2


class CommandError(Exception):
    """An error that ends a command with a message, a remedy and an exit status."""

    def __init__(self, message: str, status: Status = Status.WRONG_INPUT) -> None:
        super().__init__(message)
        self.status = status


def add_command(
    app: typer.Typer, function: Callable[..., None], example: str, panel: str | None = None
) -> None:
    """Add a command under its name in the example; its help is wrapped where it is shown."""
    name, epilog = example.split()[1], f"[dim]Example:[/dim] {example}"
    words = re.sub(r"(?<!\n)\n(?!\n)", " ", inspect.getdoc(function) or "")

    @wraps(function)
    def command(**arguments: object) -> None:
        # xarray would import these (half a second) to recognise arrays that none of these commands
        # has. They stay for a program that has imported xarray, and for commands of plug-ins.
        if "xarray" not in sys.modules:
            sys.modules.update(dict.fromkeys({"dask", "pint"} - sys.modules.keys()))  # type: ignore
        function(**arguments)

    add = app.command(name, help=words, rich_help_panel=panel, epilog=epilog)
    add(command)


def argument(metavar: str, help_: str) -> object:
    """Return an argument that is an existing file."""
    return typer.Argument(metavar=metavar, help=help_, show_default=False)


def option(names: str, metavar: str, help_: str, default: str = "") -> object:
    """Return an option that takes a value; `default` describes the default."""
    return typer.Option(
        *names.split("/"), metavar=metavar, help=help_, show_default=default or False
    )


StudyFile = Annotated[Path, argument("FILE", "Study file (YAML).")]
CaseFile = Annotated[Path, argument("OUT.nc", "Case file (netCDF).")]
_ASSIGNMENTS = "Change a parameter for this call, such as 'load=30 N'; may be repeated."
Assignments = Annotated[list[str] | None, option("--set", "NAME=VALUE", _ASSIGNMENTS)]
_RESULTS = "Folder of the study's results, with its case files in cases/."
Results = Annotated[Path | None, option("--results", "FOLDER", _RESULTS, "results/STUDY")]
KeepOlder = Annotated[
    bool, typer.Option("--keep-older", help="Keep cases computed by other versions of the code.")
]
Processes = Annotated[
    int, typer.Option("--processes", metavar="NUMBER", min=1, help="Processes that run at once.")
]


say = typer.echo  # to standard output


def note(text: str) -> None:
    """Print a message to standard error; no run ends because nobody can read it."""
    with suppress(OSError, ValueError):
        typer.echo(f"fretwear: {text}", err=True)


def progress(text: str) -> None:
    """Print a line of progress to standard output, on the same terms."""
    with suppress(OSError, ValueError):
        typer.echo(text)


def typed() -> str:
    """Return the call of the program as it was typed."""
    return shlex.join(["fretwear", *sys.argv[1:]])


def study_and_results(file: Path, results: Path | None) -> tuple[Study, Path]:
    """Return a study and the folder of its results; `CommandError` if it cannot be written to."""
    from fretwear.study.reading import load_study

    study = load_study(file)
    folder = results or Path("results", study.name)
    check_writable(folder)
    return study, folder


def check_writable(folder: Path) -> None:
    """Raise a `CommandError` if a folder, or the one in which it will be, cannot be written to."""
    existing = next(parent for parent in (folder, *folder.absolute().parents) if parent.exists())
    if not (existing.is_dir() and os.access(existing, os.W_OK)):
        raise CommandError(f"{folder}: cannot be written to; choose another place")


def check_output(path: Path, *endings: str) -> Path:
    """Return a path, checked to be writable before anything is computed.

    `CommandError` if it is a folder, has another ending, or cannot be written to.
    """
    if path.is_dir():
        mistake = f"{path}: is a folder; name a file in it, such as {path}/x{endings[0]}"
    elif path.suffix.lower() not in endings:
        example = path.with_suffix(endings[0])
        mistake = f"{path}: must end in {listed(endings, 'or')}, such as {example}"
    else:
        check_writable(path.parent)
        return path
    raise CommandError(mistake)


@contextmanager
def open_checked(file: Path) -> Iterator[tuple[xr.Dataset, xr.Dataset]]:
    """Open the dataset and the history of a case file; `CommandError` if it is not valid."""
    from fretwear.data.atomic import DataFileError
    from fretwear.data.files import open_case, open_history, reading

    with ExitStack() as stack:
        try:
            case = stack.enter_context(open_case(file))
            history = stack.enter_context(open_history(file))
        except DataFileError as error:
            raise CommandError(str(error)) from error
        stack.enter_context(reading(file))
        yield case, history


def aligned(
    rows: Sequence[Sequence[str]],
    justify: Callable[[str, int], str] = str.rjust,
    indent: str = "  ",
) -> Iterator[str]:
    """Yield rows as lines in columns, the first column to the left, the others as `justify` does.

    Lines are not wrapped, so that they can be searched and cut.
    """
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for first, *others in rows:
        cells = [justify(text, width) for text, width in zip(others, widths[1:], strict=True)]
        yield "  ".join([f"{indent}{first.ljust(widths[0])}", *cells]).rstrip()
