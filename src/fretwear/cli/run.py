"""``fretwear run``: one case of a study to one file."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from fretwear.cli.arguments import Assignments, StudyFile
from fretwear.cli.outputs import check_file
from fretwear.cli.status import Status, failing_as


def run(
    file: StudyFile,
    case_id: Annotated[
        str | None,
        typer.Option(
            "--case",
            metavar="ID",
            help="Which case, by its id in `fretwear plan`; needless where there is only one.",
            show_default=False,
        ),
    ] = None,
    set_: Assignments = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o", "--output", metavar="OUT.nc", help="File to write.", show_default="ID.nc"
        ),
    ] = None,
) -> None:
    """Simulate one case of a study and write it to one file.

    A run that was interrupted goes on from its checkpoint, which lies beside the file.
    """
    from fretwear.study.file import StudyError
    from fretwear.study.selection import select_case

    with failing_as(Status.WRONG_INPUT, StudyError):
        chosen = select_case(file, case_id, set_ or ())
    path = check_file(output or Path(f"{chosen.case_id}.nc"), ".nc")

    from fretwear.cli.progress import progress
    from fretwear.job import JOB_ERRORS, simulate_to_file

    with (
        failing_as(Status.FAILED, *JOB_ERRORS),
        progress(f"case {chosen.case_id}", chosen.cycles) as observe,
    ):
        outcome = simulate_to_file(
            chosen,
            path,
            observers=[observe],
            tell=_tell,
            command=_command(file, case_id, set_ or ()),
        )
    typer.echo(f"{path}: {outcome.steps} steps in {outcome.seconds:.1f} s")


def _tell(line: str) -> None:
    typer.echo(line, err=True)


def _command(file: Path, case_id: str | None, assignments: Sequence[str]) -> str:
    """Return the call that leads to the same results, for the dataset."""
    choice = () if case_id is None else ("--case", case_id)
    changes = (word for assignment in assignments for word in ("--set", assignment))
    return shlex.join(["fretwear", "run", str(file), *choice, *changes])
