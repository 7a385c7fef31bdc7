"""Shared by commands: exit statuses, options, completions for shells, checks of given files."""

from __future__ import annotations

import inspect
import json
import re
import shlex
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from enum import IntEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperCommand

from fretwear.study.problems import StudyError, few_of
from fretwear.units import listed, nearest

if TYPE_CHECKING:
    import xarray as xr

    from fretwear.study.study import Study

    _Base = TyperCommand
else:
    _Base = object

FIGURE_FORMATS = (".png", ".svg", ".pdf")
"""Endings of the files into which figures are drawn."""

# Listing all ids of a large study takes seconds, too long for a key press.
_MOST_POINTS = 2000


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


class Help(_Base):
    """Help without types of flags and without braces."""

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        """Return the words of the usage line, without braces, which users might type."""
        return [piece.strip("{}") for piece in super().collect_usage_pieces(ctx)]

    def get_params(self, ctx: Any) -> list[Any]:
        """Return all parameters, ``--help`` included."""
        params = super().get_params(ctx)
        for param in params:
            if getattr(param, "is_flag", False):
                param.metavar = ""
        return params


class _Command(Help, TyperCommand):
    pass


def add_command(
    app: typer.Typer, function: Callable[..., None], example: str, panel: str | None = None
) -> None:
    """Add a command under its name in the example; its help is wrapped where it is shown."""
    name, epilog = example.split()[1], f"[dim]Example:[/dim] {example}"
    words = re.sub(r"(?<!\n)\n(?!\n)", " ", inspect.getdoc(function) or "")
    add = app.command(name, cls=_Command, help=words, rich_help_panel=panel, epilog=epilog)
    add(function)


# Completions that the shell offers at the tab key besides commands, options and files.


def case_ids(context: typer.Context, incomplete: str) -> list[str]:
    """Offer the ids of the cases of the study that was typed before."""
    from fretwear.study.reading import load_study

    # The file may not be parsed yet while the option waits for its value.
    file = context.params.get("file") or next(iter(context.args), None)
    if file is None:
        return []
    with suppress(StudyError):
        study = load_study(file)
        points = study.points()[:_MOST_POINTS]
        ids = dict.fromkeys(point.id for point in points if point.case is not None)
        return [case_id for case_id in ids if case_id.startswith(incomplete)]
    return []


def assignments(incomplete: str) -> list[str]:
    """Offer names of parameters, and an example value once only one is left."""
    from fretwear.study.case import case_keys

    others = ["output.cycles", "title"]
    valid = [*case_keys().all_names, *others]
    names = [name for name in valid if f"{name}=".startswith(incomplete)]
    if len(names) != 1 or names[0] in others:
        return [f"{name}=" for name in names]
    # A space would need quotes; "30N" means the same as "30 N".
    example = (case_keys()[names[0]].about.example or "...").replace(" ", "")
    return [f"{names[0]}=", f"{names[0]}={example}"]


def argument(metavar: str, help_: str) -> object:
    """Return an argument that is an existing file."""
    return typer.Argument(metavar=metavar, help=help_, show_default=False)


def option(
    names: str,
    metavar: str,
    help_: str,
    default: str = "",
    complete: Callable[..., list[str]] | None = None,
) -> object:
    """Return an option that takes a value; `default` describes the default."""
    return typer.Option(
        *names.split("/"),
        metavar=metavar,
        help=help_,
        show_default=default or False,
        autocompletion=complete,
    )


StudyFile = Annotated[Path, argument("FILE", "Study file (YAML).")]
CaseFile = Annotated[Path, argument("OUT.nc", "Case file (netCDF).")]
_ASSIGNMENTS = "Change a parameter for this call, such as 'load=30 N'; may be repeated."
Assignments = Annotated[
    list[str] | None, option("--set", "NAME=VALUE", _ASSIGNMENTS, complete=assignments)
]
_RESULTS = "Folder of the study's results, with its case files in cases/."
Results = Annotated[Path | None, option("--results", "FOLDER", _RESULTS, "results/STUDY")]
KeepOlder = Annotated[
    bool, typer.Option("--keep-older", help="Keep cases computed by other versions of the code.")
]
Processes = Annotated[
    int, typer.Option("--processes", metavar="NUMBER", min=1, help="Processes that run at once.")
]


def say(text: str) -> None:
    """Print to standard output."""
    typer.echo(text)


def note(text: str) -> None:
    """Print a message to standard error; no run ends because nobody can read it."""
    with suppress(OSError, ValueError):
        typer.echo(f"fretwear: {text}", err=True)


def typed(context: typer.Context) -> str:
    """Return the call of the program as it was typed."""
    return shlex.join(["fretwear", *context.obj])


def finite(value: object) -> object:
    """Return a value for JSON, with null for numbers that are not finite."""
    return json.loads(json.dumps(value), parse_constant=lambda _: None)


def study_and_results(file: Path, results: Path | None) -> tuple[Study, Path]:
    """Return a study and the folder of its results; `CommandError` if it cannot be written to."""
    from fretwear.study.reading import load_study

    study = load_study(file)
    folder = results or Path("results", study.name)
    check_writable(folder)
    return study, folder


def check_writable(folder: Path) -> None:
    """Raise a `CommandError` if a folder, or the one in which it will be, cannot be written to."""
    from fretwear.data.atomic import why_not_writable

    if problem := why_not_writable(folder):
        raise CommandError(problem)


def check_output(path: Path, *endings: str) -> Path:
    """Return a path, checked to be writable before anything is computed.

    `CommandError` if it is a folder, has another ending, or cannot be written to.
    """
    if path.is_dir():
        problem = f"{path}: is a folder; name a file in it, such as {path}/x{endings[0]}"
    elif path.suffix.lower() not in endings:
        example = path.with_suffix(endings[0])
        problem = f"{path}: must end in {listed(endings, 'or')}, such as {example}"
    elif not path.parent.exists():
        problem = f"{path}: there is no folder {path.parent}\n    mkdir -p {path.parent} makes it"
    else:
        check_writable(path.parent)
        return path
    raise CommandError(problem)


@contextmanager
def opened(file: Path) -> Iterator[tuple[xr.Dataset, xr.Dataset]]:
    """Open the dataset and the history of a case file; `CommandError` if it is not valid."""
    check_results(file)

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


def check_results(file: Path) -> None:
    """Refuse missing files, folders and study files before a large library is imported."""
    if file.is_dir():
        present = sorted([*file.glob("*.nc"), *file.glob("cases/*.nc")])
        names = "".join(f"\n    {name}" for name in few_of(present))
        hint = f"; name one of its files, such as{names}" if present else " without results"
        raise CommandError(f"{file}: is a folder{hint}")
    if not file.exists():
        beside = [path.name for path in file.parent.iterdir()] if file.parent.is_dir() else []
        hint = "the cases of a study are in results/STUDY/cases/; fretwear run computes one"
        if near := nearest(file.name, beside, cutoff=0.7):
            hint = f"did you mean {str(file.with_name(near))!r}?"
        raise CommandError(f"{file}: there is no such file\n    {hint}")
    if file.suffix in (".yaml", ".yml"):
        raise CommandError(
            f"{file}: is a study file, not a file of results\n"
            f"    fretwear plan {file} lists its cases, fretwear run computes them"
        )


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
