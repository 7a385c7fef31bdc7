"""Commands for a whole study: plan, schema, and what follows the simulations."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
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
    aligned,
    begin,
    say,
    study_and_results,
)

if TYPE_CHECKING:
    from fretwear.study.plan import Plan

_MOST_ROWS = 200
_ROWS_AT_AN_END = 20


def plan(
    file: StudyFile,
    set_: Assignments = None,
    every: Annotated[
        bool, typer.Option("--all", help=f"Print all points, even if more than {_MOST_ROWS}.")
    ] = False,
) -> None:
    """Print the points of a study with the time and memory each will take; run nothing.

    Times are those of this machine, whose speed is measured in a moment.
    """
    from fretwear.running.resources import machine_speed, machine_warnings
    from fretwear.study.plan import plan_study
    from fretwear.study.study import load_study

    planned = plan_study(load_study(file, set_ or ()))
    planned = replace(planned, speed=machine_speed(planned.estimates.values()))
    for line in _table(planned, every):
        say(line)
    say(f"\n{_total(planned)}")
    for warning in machine_warnings(planned):
        typer.echo(f"\nfretwear: warning: {warning}", err=True)


def schema() -> None:
    """Print the JSON Schema of the study file, for editors that complete and check it."""
    from fretwear.study.sections import study_schema

    say(json.dumps(study_schema(), indent=2, ensure_ascii=False))


def merge(
    context: typer.Context,
    file: StudyFile,
    results: Results = None,
    keep_older: KeepOlder = False,
    quiet: Quiet = False,
    log_format: Format = LogFormat.AUTO,
) -> None:
    """Merge the cases of a study that are done into summary.nc, and list all in points.csv."""
    log = begin(context, log_format, quiet=quiet)
    study, folder = study_and_results(file, results)

    from fretwear.data.merge import merge_study
    from fretwear.data.safe import atomic_path
    from fretwear.study.plan import write_points

    summary = folder / "summary.nc"
    tally = merge_study(
        study, folder / "cases", summary, command=context.obj.line, keep_older=keep_older
    )
    if tally.older:
        log.note(tally.older)
    with atomic_path(folder / "points.csv") as temporary:
        write_points(study, temporary)
    log.result(
        summary,
        f"{tally.done} points done, {tally.failed} failed, {tally.invalid} invalid",
        points_done=tally.done,
        points_failed=tally.failed,
        points_invalid=tally.invalid,
    )


def figures(
    context: typer.Context,
    file: StudyFile,
    results: Results = None,
    quiet: Quiet = False,
    log_format: Format = LogFormat.AUTO,
) -> None:
    """Draw the figures of a merged study, as SVG and PNG, into figures/."""
    log = begin(context, log_format, quiet=quiet)
    _, folder = study_and_results(file, results)

    from fretwear.data.files import open_summary
    from fretwear.figures.study import write_study_figures
    from fretwear.source_study import source_figures

    cases, drawn = folder / "cases", folder / "figures"
    with open_summary(folder / "summary.nc") as summary:
        entries = write_study_figures(summary, cases, drawn, extra=source_figures(summary, cases))
    log.result(drawn, f"{len(entries)} figures", figures=len(entries))


def report(
    context: typer.Context,
    file: StudyFile,
    results: Results = None,
    quiet: Quiet = False,
    log_format: Format = LogFormat.AUTO,
) -> None:
    """Write the report of a merged study and its figures to report.html."""
    log = begin(context, log_format, quiet=quiet)
    study, folder = study_and_results(file, results)

    from fretwear.data.files import open_summary
    from fretwear.data.safe import write_text
    from fretwear.figures.study import INDEX_NAME
    from fretwear.report import build_report
    from fretwear.source_study import source_sections
    from fretwear.study.plan import plan_study

    with open_summary(folder / "summary.nc") as summary:
        index = folder / "figures" / INDEX_NAME
        if not index.is_file():
            rule = "there is no such file; draw the figures before the report:"
            raise CommandError(f"{index}: {rule}\n    fretwear figures {file}", Status.FAILED)
        sections = source_sections(summary, folder / "cases")
        page = build_report(plan_study(study), summary, folder, sections=sections)
        write_text(folder / "report.html", page)
    log.result(folder / "report.html", f"{len(page) / 1e6:.1f} MB")


def _table(planned: Plan, every: bool) -> Iterator[str]:
    """Yield the lines of all points, or of the first and the last ones of very many."""
    count = len(planned.points)
    if every or count <= _MOST_ROWS:
        yield from aligned([planned.header(), *planned.rows()], str.ljust, indent="")
        return
    first, last = planned.rows(0, _ROWS_AT_AN_END), planned.rows(count - _ROWS_AT_AN_END)
    lines = list(aligned([planned.header(), *first, *last], str.ljust, indent=""))
    yield from lines[: 1 + _ROWS_AT_AN_END]
    yield f"... {count - 2 * _ROWS_AT_AN_END} more points, which --all prints ..."
    yield from lines[1 + _ROWS_AT_AN_END :]


def _total(planned: Plan) -> str:
    from fretwear.running.resources import batches, core_seconds, cores
    from fretwear.units import duration_text, size_text

    jobs = batches(planned)
    seconds, at_once = core_seconds(jobs, planned.speed), min(cores(), len(jobs))
    shared = f", {duration_text(seconds / at_once)} on {at_once} cores"
    return (
        f"{_count(len(planned.points), 'point')}, "
        f"{_count(len(planned.estimates), 'case')} in {_count(len(jobs), 'job')}: "
        f"about {duration_text(seconds)} on one core{shared if at_once > 1 else ''}, "
        f"up to {size_text(planned.memory_bytes)} of memory per job, "
        f"about {size_text(planned.file_bytes)} of files."
    )


def _count(number: int, thing: str) -> str:
    return f"{number} {thing}{'s' * (number != 1)}"
