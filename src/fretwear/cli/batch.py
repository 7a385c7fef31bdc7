"""``fretwear batch``: several cases of a study in one process."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TextIO

import typer

from fretwear.cli.arguments import Format, Quiet, Results, StudyFile, results_of
from fretwear.cli.commands import open_log
from fretwear.cli.log import LogFormat
from fretwear.cli.log.lines import LinesLog
from fretwear.cli.outlive import outlive_kills
from fretwear.cli.outputs import check_folder
from fretwear.cli.status import CommandError, Status, failing_as, refuse

if TYPE_CHECKING:
    from rich.console import Console

    from fretwear.running.batch import BatchOutcome
    from fretwear.study.file import Study


def batch(
    context: typer.Context,
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
    outlive: Annotated[
        bool,
        typer.Option(
            "--outlive",
            help="Go on with the other cases if the process is killed, as it is without memory.",
        ),
    ] = False,
    quiet: Quiet = False,
    log_format: Format = LogFormat.AUTO,
) -> None:
    """Simulate several points of a study, one after the other, each to its file in cases/.

    What is done already is left as it is, and a case that fails keeps no other from running.
    """
    log = open_log(context, log_format, quiet=quiet)

    from fretwear.study.file import StudyError, load_study

    with failing_as(Status.WRONG_INPUT, StudyError):
        study = load_study(file)
    first, last = _range(points, study)
    folder = check_folder(results_of(study, results))
    if outlive:
        outlive_kills({point.id for point in study.points(first, last)}, folder)

    from fretwear.data.safe import DataFileError
    from fretwear.running.batch import BatchRun
    from fretwear.running.workflow import write_finished

    with failing_as(Status.FAILED, DataFileError):
        outcome = BatchRun(study, folder, log, _CaseLog).run(first, last)
        if outcome.failed:
            raise CommandError(_failed(outcome), Status.FAILED)
        if finished is not None:
            write_finished(finished, folder / "cases", outcome.case_ids)
    count, found = len(outcome.case_ids), len(outcome.found)
    log.result(folder / "cases", f"{count} cases done", cases_done=count, cases_found=found)


class _CaseLog(LinesLog):
    """What one case says, in a file."""

    def __init__(self, stream: TextIO) -> None:
        super().__init__()
        self._stream = stream

    def _console(self) -> Console:
        from rich.console import Console

        return Console(file=self._stream, highlight=False, color_system=None)


def _failed(outcome: BatchOutcome) -> str:
    listed = "".join(f"\n  {case_id}: {reason}" for case_id, reason in outcome.failed.items())
    return f"{len(outcome.failed)} of {len(outcome.case_ids)} cases failed{listed}"


def _range(points: str | None, study: Study) -> tuple[int, int]:
    count = study.size
    if points is None:
        return 1, count
    match = re.fullmatch(r"(\d{1,9})-(\d{1,9})", points.strip())
    if match is None:
        raise refuse(f"--points {points}: must be the first and the last number, such as 1-12")
    first, last = int(match[1]), int(match[2])
    if not 1 <= first <= last <= count:
        raise refuse(f"--points {points}: the points of {study.file} are 1 to {count}")
    return first, last
