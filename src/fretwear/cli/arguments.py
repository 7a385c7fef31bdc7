"""Arguments and options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fretwear.cli import completion
from fretwear.cli.log.choose import FORMAT_OPTION, FORMAT_VARIABLE, LogFormat
from fretwear.cli.status import refuse
from fretwear.data.safe import why_leading_out

if TYPE_CHECKING:
    from fretwear.study.file import Study

_MESSAGES = "Messages"

StudyFile = Annotated[
    Path,
    typer.Argument(
        metavar="FILE",
        help="Study file (YAML).",
        show_default=False,
        autocompletion=completion.study_files,
    ),
]

Assignments = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="NAME=VALUE",
        help="Change a parameter for this call, such as 'load=30 N'; may be repeated.",
        autocompletion=completion.assignments,
        show_default=False,
    ),
]

CaseFile = Annotated[
    Path,
    typer.Argument(
        metavar="OUT.nc",
        help="Case file (netCDF).",
        show_default=False,
        autocompletion=completion.case_files,
    ),
]

Results = Annotated[
    Path | None,
    typer.Option(
        "--results",
        metavar="FOLDER",
        help="Folder of the study's results, with its case files in cases/.",
        show_default="results/ and the name of the study",
    ),
]

Quiet = Annotated[
    bool,
    typer.Option("--quiet", "-q", help="Print errors only.", rich_help_panel=_MESSAGES),
]

Format = Annotated[
    LogFormat,
    typer.Option(
        FORMAT_OPTION,
        help="auto: a bar on a terminal, lines elsewhere; json: one JSON object a line, "
        "for programs.",
        envvar=FORMAT_VARIABLE,
        show_envvar=True,
        rich_help_panel=_MESSAGES,
    ),
]


def results_of(study: Study, results: Path | None) -> Path:
    """Return the folder of a study's results; leave with status 2 where it is a link elsewhere."""
    if results is not None:
        return results
    folder = Path("results", study.name)
    if problem := why_leading_out(folder):
        raise refuse(problem)
    return folder
