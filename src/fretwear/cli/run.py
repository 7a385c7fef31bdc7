"""``fretwear run``: one case of a study to one file."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from fretwear.cli.arguments import Assignments, Format, Quiet, StudyFile
from fretwear.cli.commands import open_log
from fretwear.cli.completion import case_ids
from fretwear.cli.log import LogFormat
from fretwear.cli.outputs import check_file
from fretwear.cli.status import Status, failing_as


def run(
    context: typer.Context,
    file: StudyFile,
    case_id: Annotated[
        str | None,
        typer.Option(
            "--case",
            metavar="ID",
            help="Which case, by its id in `fretwear plan`; needless where there is only one.",
            show_default=False,
            autocompletion=case_ids,
        ),
    ] = None,
    set_: Assignments = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o", "--output", metavar="OUT.nc", help="File to write.", show_default="ID.nc"
        ),
    ] = None,
    quiet: Quiet = False,
    log_format: Format = LogFormat.AUTO,
) -> None:
    """Simulate one case of a study and write it to one file.

    A run that was interrupted goes on from its checkpoint, which lies beside the file.
    """
    log = open_log(context, log_format, quiet=quiet)

    from fretwear.study.file import StudyError
    from fretwear.study.selection import select_case

    with failing_as(Status.WRONG_INPUT, StudyError):
        chosen = select_case(file, case_id, set_ or ())
    path = check_file(output or Path(f"{chosen.case_id}.nc"), ".nc")

    from fretwear.running.batch import JOB_ERRORS, simulate_to_file

    with (
        failing_as(Status.FAILED, *JOB_ERRORS),
        log.case(chosen, path) as observe,
    ):
        outcome = simulate_to_file(
            chosen,
            path,
            observers=[observe],
            tell=log.note,
            command=_command(file, case_id, set_ or (), output),
        )
    ending = ", by another process" if outcome.is_taken_over else ""
    log.result(
        path, f"{outcome.steps} steps in {outcome.seconds:.1f} s{ending}", steps=outcome.steps
    )


def _command(
    file: Path, case_id: str | None, assignments: Sequence[str], output: Path | None
) -> str:
    """Return the call that leads to the same results, for the dataset."""
    choice = () if case_id is None else ("--case", case_id)
    changes = (word for assignment in assignments for word in ("--set", assignment))
    target = () if output is None else ("--output", str(output))
    return shlex.join(["fretwear", "run", str(file), *choice, *changes, *target])
