"""What commands share: exit statuses, errors, options, and checks of the files they are given."""

from __future__ import annotations

import errno
import math
import os
import shlex
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from enum import IntEnum, StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fretwear.cli import completion
from fretwear.study.problems import few_of, nearest, printable

if TYPE_CHECKING:
    import xarray as xr

    from fretwear.cli.progress import Log
    from fretwear.study.study import Study

Completion = Callable[..., list[str]]

FIGURE_FORMATS = (".png", ".svg", ".pdf")
"""Endings of the files into which figures are drawn."""

LOG_FORMAT_OPTION, LOG_FORMAT_VARIABLE = "--log-format", "FRETWEAR_LOG_FORMAT"


class Status(IntEnum):
    """Exit status of a command that was not stopped from outside."""

    DONE = 0
    FAILED = 1
    WRONG_INPUT = 2


class CommandError(Exception):
    """What ends a command with a message and an exit status: what was wrong and what to do."""

    def __init__(self, message: str, status: Status = Status.WRONG_INPUT) -> None:
        super().__init__(message)
        self.status = status


class LogFormat(StrEnum):
    """How progress and errors are written."""

    AUTO = "auto"
    LINES = "lines"
    JSON = "json"


@dataclass
class Call:
    """One call of the command line, the object of every context."""

    arguments: Sequence[str]  # what was typed after ``fretwear``
    log: Log | None = None  # takes all messages once the command has begun

    @property
    def line(self) -> str:
        """The call as typed."""
        return shlex.join(["fretwear", *self.arguments])


def begin(context: typer.Context, log_format: LogFormat, *, quiet: bool) -> Log:
    """Open the log of the command with this context."""
    from fretwear.cli.progress import Log

    call: Call = context.obj
    call.log = Log(log_format, quiet=quiet)
    call.log.begin(str(context.info_name))
    return call.log


def argument(metavar: str, help_: str, complete: Completion) -> Any:
    """Return an argument that is an existing file."""
    return typer.Argument(metavar=metavar, help=help_, show_default=False, autocompletion=complete)


def option(
    names: str,
    metavar: str,
    help_: str,
    default: str = "",
    complete: Callable[..., Any] | None = None,
) -> Any:
    """Return an option that takes a value; `default` says what happens without it."""
    return typer.Option(
        *names.split("/"),
        metavar=metavar,
        help=help_,
        show_default=default or False,
        autocompletion=complete,
    )


StudyFile = Annotated[Path, argument("FILE", "Study file (YAML).", completion.study_files)]
CaseFile = Annotated[Path, argument("OUT.nc", "Case file (netCDF).", completion.case_files)]
_ASSIGNMENTS = "Change a parameter for this call, such as 'load=30 N'; may be repeated."
Assignments = Annotated[
    list[str] | None,
    option("--set", "NAME=VALUE", _ASSIGNMENTS, complete=completion.assignments),
]
_RESULTS = "Folder of the study's results, with its case files in cases/."
Results = Annotated[
    Path | None, option("--results", "FOLDER", _RESULTS, "results/ and the name of the study")
]
KeepOlder = Annotated[
    bool, typer.Option("--keep-older", help="Keep cases computed by other versions of the code.")
]
Threads = Annotated[
    int,
    typer.Option("--threads", metavar="NUMBER", min=1, help="Threads that share a case's work."),
]
Quiet = Annotated[
    bool, typer.Option("--quiet", "-q", help="Print errors only.", rich_help_panel="Messages")
]
Format = Annotated[
    LogFormat,
    typer.Option(
        LOG_FORMAT_OPTION,
        help="auto: a bar on a terminal, lines elsewhere; json: one JSON object per line, "
        "for programs.",
        envvar=LOG_FORMAT_VARIABLE,
        show_envvar=True,
        rich_help_panel="Messages",
    ),
]


def say(text: str) -> None:
    """Print to standard output; what comes from files sends no commands to the terminal.

    Where nothing can be written there, the command fails, without a word if nobody reads any more.
    """
    try:
        typer.echo(printable(text))
    except OSError as error:
        with suppress(OSError, ValueError):  # What is held back would fail again at the end.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if error.errno in (errno.EPIPE, errno.EIO):
            raise typer.Exit(Status.FAILED) from error
        reason = f"standard output: cannot be written: {error.strerror}"
        raise CommandError(reason, Status.FAILED) from error


def finite(value: Any) -> Any:
    """Return a value for JSON, which knows no number that is not finite: there it has null."""
    if isinstance(value, dict):
        return {name: finite(each) for name, each in value.items()}
    if isinstance(value, list):
        return [finite(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def study_and_results(file: Path, results: Path | None) -> tuple[Study, Path]:
    """Return a study and the folder of its results, a `CommandError` if it is not to be written."""
    from fretwear.data.safe import why_leading_out
    from fretwear.study.study import load_study

    study = load_study(file)
    folder = results or Path("results", study.name)
    if problem := why_leading_out(folder, None if results else folder.parent):
        raise CommandError(problem)
    _check_folder(folder)
    return study, folder


def check_output(path: Path, *endings: str) -> Path:
    """Return a path to which a file can be written, found out before anything is computed.

    `CommandError` where it is a folder, ends in none of the endings, or cannot be written to.
    """
    if path.is_dir():
        raise CommandError(f"{path}: is a folder; name a file in it, such as {path}/x{endings[0]}")
    if path.suffix.lower() not in endings:
        expected = " or ".join(filter(None, (", ".join(endings[:-1]), endings[-1])))
        example = path.with_suffix(endings[0])
        raise CommandError(f"{path}: must end in {expected}, such as {example}")
    _check_folder(path.parent)
    return path


@contextmanager
def opened(file: Path) -> Iterator[tuple[xr.Dataset, xr.Dataset]]:
    """Open a case file: dataset and history of the case, a `CommandError` if it is not valid."""
    check_results(file)

    from fretwear.data.files import open_case, open_history
    from fretwear.data.safe import DataFileError, is_of_netcdf

    with ExitStack() as stack:
        try:
            case = stack.enter_context(open_case(file))
            history = stack.enter_context(open_history(file))
        except DataFileError as error:
            raise CommandError(str(error)) from error
        try:
            yield case, history
        except RuntimeError as error:
            # Fields are read when they are used, and the netCDF library finds damage only then.
            if not is_of_netcdf(error):
                raise
            raise CommandError(f"{file}: cannot be read ({error})") from error


def check_results(file: Path) -> None:
    """Refuse what is missing, a folder or a study file, before anything heavy is imported."""
    if file.is_dir():
        found = sorted([*file.glob("*.nc"), *file.glob("cases/*.nc")])
        names = "".join(f"\n    {name}" for name in few_of(found))
        hint = f"; name one of its files, such as{names}" if found else " without results"
        raise CommandError(f"{file}: is a folder{hint}")
    if not file.exists():
        present = [path.name for path in file.parent.iterdir()] if file.parent.is_dir() else []
        hint = "the cases of a study are in results/STUDY/cases/; fretwear run computes one"
        if near := nearest(file.name, present, cutoff=0.7):
            hint = f"did you mean {str(file.with_name(near))!r}?"
        raise CommandError(f"{file}: there is no such file\n    {hint}")
    if file.suffix in completion.STUDY_FILES:
        raise CommandError(
            f"{file}: is a study file, not a file of results\n"
            f"    fretwear plan {file} lists its cases, fretwear run computes them"
        )


def _check_folder(path: Path) -> None:
    from fretwear.data.safe import why_not_writable

    if problem := why_not_writable(path):
        raise CommandError(problem)


def aligned(
    rows: Sequence[Sequence[str]],
    justify: Callable[[str, int], str] = str.rjust,
    indent: str = "  ",
) -> Iterator[str]:
    """Yield rows as lines in columns: the first one to the left, the others as `justify` does.

    Lines are not wrapped, so that they can be searched and cut.
    """
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for first, *others in rows:
        cells = [justify(text, width) for text, width in zip(others, widths[1:], strict=True)]
        yield "  ".join([f"{indent}{first.ljust(widths[0])}", *cells]).rstrip()
