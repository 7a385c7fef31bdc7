"""``fretwear batch``: several cases of a study in one process."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fretwear.cli.arguments import Results, StudyFile, results_of
from fretwear.cli.outputs import check_folder
from fretwear.cli.status import Status, complain, failing_as, refuse

if TYPE_CHECKING:
    from fretwear.study.file import Study


def batch(
    file: StudyFile,
    points: Annotated[
        str | None,
        typer.Option(
            "--points",
            metavar="FIRST-LAST",
            help="Numbers of the points, counted from 1 as in the report.",
            show_default="all",
        ),
    ] = None,
    results: Results = None,
    finished: Annotated[
        Path | None,
        typer.Option(
            "--finished",
            metavar="OUT.json",
            help="File to write when all of the cases are done, for the workflow.",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Simulate several points of a study, one after the other, each to its file in cases/.

    What is done already is left as it is, and a case that fails keeps no other from running.
    """
    from fretwear.study.file import StudyError, load_study

    with failing_as(Status.WRONG_INPUT, StudyError):
        study = load_study(file)
    first, last = _range(points, study)
    folder = check_folder(results_of(study, results))

    from fretwear.batch import run_batch
    from fretwear.cli.progress import LineLog
    from fretwear.data.errors import DataFileError
    from fretwear.finished import write_finished

    with failing_as(Status.FAILED, DataFileError):
        done = run_batch(study, first, last, folder, typer.echo, LineLog)
        if not done.failed and finished is not None:
            write_finished(finished, folder / "cases", done.case_ids)
    if done.failed:
        listed = "".join(f"\n  {case_id}: {why}" for case_id, why in done.failed.items())
        complain(f"{len(done.failed)} of {len(done.case_ids)} cases failed{listed}")
        raise typer.Exit(Status.FAILED)


def _range(points: str | None, study: Study) -> tuple[int, int]:
    count = len(study.points())
    if points is None:
        return 1, count
    match = re.fullmatch(r"(\d{1,9})-(\d{1,9})", points.strip())
    if match is None:
        raise refuse(f"--points {points}: must be the first and the last number, such as 1-12")
    first, last = int(match[1]), int(match[2])
    if not 1 <= first <= last <= count:
        raise refuse(f"--points {points}: the points of {study.file} are 1 to {count}")
    return first, last
