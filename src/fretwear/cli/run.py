"""``fretwear run`` and ``fretwear batch``: cases of a study, each to one file."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fretwear.cli.common import (
    Assignments,
    CommandError,
    Format,
    KeepOlder,
    LogFormat,
    Quiet,
    Results,
    Status,
    StudyFile,
    begin,
    check_output,
    option,
    study_and_results,
)
from fretwear.cli.completion import case_ids

if TYPE_CHECKING:
    from fretwear.study.study import Study

_CASE = "Which case, by its id in `fretwear plan` or its beginning; needless if there is only one."
_OUTPUT = "File to write."
_POINTS = "Numbers of the points, counted from 1 as in the report."
_FINISHED = "File to write when all of the cases are done, for the workflow."
_SUPERVISE = "Run the other cases if the process is killed, as it is without memory."


def run(
    context: typer.Context,
    file: StudyFile,
    case_id: Annotated[str | None, option("--case", "ID", _CASE, complete=case_ids)] = None,
    set_: Assignments = None,
    output: Annotated[Path | None, option("-o/--output", "OUT.nc", _OUTPUT, "ID.nc")] = None,
    quiet: Quiet = False,
    log_format: Format = LogFormat.AUTO,
) -> None:
    """Simulate one case of a study and write it to one file.

    A run that was interrupted resumes from its checkpoint, which lies beside the file.
    """
    log = begin(context, log_format, quiet=quiet)

    from fretwear.study.study import select_case

    case = select_case(file, case_id, set_ or ())
    path = check_output(output or Path(f"{case.case_id}.nc"), ".nc")

    from fretwear.running.batch import simulate_to_file

    with log.case(case, path) as observe:
        outcome = simulate_to_file(
            case, path, observers=[observe], tell=log.note, command=context.obj.line
        )
    ending = ", by another process" if outcome.is_taken_over else ""
    message = f"{outcome.steps} steps in {outcome.seconds:.1f} s{ending}"
    log.result(path, message, steps=outcome.steps)


def batch(
    context: typer.Context,
    file: StudyFile,
    points: Annotated[str | None, option("--points", "FIRST-LAST", _POINTS, "all")] = None,
    results: Results = None,
    finished: Annotated[Path | None, option("--finished", "OUT.json", _FINISHED)] = None,
    keep_older: KeepOlder = False,
    supervised: Annotated[bool, typer.Option("--supervise", help=_SUPERVISE)] = False,
    quiet: Quiet = False,
    log_format: Format = LogFormat.AUTO,
) -> None:
    """Simulate several points of a study, one after the other, each to its file in cases/.

    Cases that are done already are kept, and one that fails does not stop the others.
    """
    log = begin(context, log_format, quiet=quiet)
    study, folder = study_and_results(file, results)
    first, last = _range(points, study)
    if supervised:
        from fretwear.cli.supervise import supervise

        supervise({point.id for point in study.points(first, last)}, folder)

    from fretwear.cli.progress import Log
    from fretwear.running.batch import BatchRun
    from fretwear.running.workflow import write_finished

    runs = BatchRun(study, folder, log, lambda stream: Log(stream=stream), keep_older=keep_older)
    outcome = runs.run(first, last)
    count, found = len(outcome.case_ids), len(outcome.found)
    if failed := outcome.failed:
        listed = "".join(f"\n  {case_id}: {reason}" for case_id, reason in failed.items())
        raise CommandError(f"{len(failed)} of {count} cases failed{listed}", Status.FAILED)
    if finished is not None:
        write_finished(finished, folder / "cases", outcome.case_ids)
    log.result(folder / "cases", f"{count} cases done", cases_done=count, cases_found=found)


def _range(points: str | None, study: Study) -> tuple[int, int]:
    """Return the numbers of the first and the last point."""
    count = study.size
    if points is None:
        return 1, count
    match = re.fullmatch(r"(\d{1,9})-(\d{1,9})", points.strip())
    if match is None:
        raise CommandError(
            f"--points {points}: must be the first and the last number, such as 1-12"
        )
    first, last = int(match[1]), int(match[2])
    if not 1 <= first <= last <= count:
        raise CommandError(f"--points {points}: the points of {study.file} are 1 to {count}")
    return first, last
