"""``fretwear plan`` and ``fretwear schema``: what a study is and may be, nothing is run."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated

import typer

from fretwear.cli.arguments import Assignments, StudyFile
from fretwear.cli.status import Status, failing_as

if TYPE_CHECKING:
    from fretwear.study.plan import Plan


_MOST_ROWS = 200
_ROWS_AT_AN_END = 20


def plan(
    file: StudyFile,
    set_: Assignments = None,
    every: Annotated[
        bool, typer.Option("--all", help=f"Print all points, also if they are over {_MOST_ROWS}.")
    ] = False,
) -> None:
    """Print the points of a study with the time and memory each will take; run nothing.

    Times are those of this machine, whose speed is measured in a moment.
    """
    from fretwear.running.resources import machine_speed, machine_warnings
    from fretwear.study.file import StudyError, load_study
    from fretwear.study.plan import plan_study

    with failing_as(Status.WRONG_INPUT, StudyError):
        planned = plan_study(load_study(file, set_ or ()))
    planned = replace(planned, speed=machine_speed(planned.estimates.values()))
    for line in _table(planned, every):
        typer.echo(line)
    typer.echo(f"\n{_total(planned)}")
    for warning in machine_warnings(planned):
        typer.echo(f"\nfretwear: warning: {warning}", err=True)


def schema() -> None:
    """Print the JSON Schema of the study file, for editors that complete and check it."""
    import json

    from fretwear.study.schema import study_schema

    typer.echo(json.dumps(study_schema(), indent=2, ensure_ascii=False))


def _aligned(rows: Sequence[tuple[str, ...]]) -> Iterable[str]:
    """Align the columns of a table; long lines stay whole for those who search or cut them."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        cells = (cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        yield "  ".join(cells).rstrip()


def _table(planned: Plan, every: bool) -> Iterator[str]:
    count = len(planned.points)
    if every or count <= _MOST_ROWS:
        yield from _aligned([planned.header(), *planned.rows()])
        return
    first, last = planned.rows(0, _ROWS_AT_AN_END), planned.rows(count - _ROWS_AT_AN_END)
    lines = list(_aligned([planned.header(), *first, *last]))
    yield from lines[: 1 + _ROWS_AT_AN_END]
    yield f"... {count - 2 * _ROWS_AT_AN_END} more points, which --all prints ..."
    yield from lines[1 + _ROWS_AT_AN_END :]


def _total(planned: Plan) -> str:
    from fretwear.running.resources import batches, core_seconds, cores
    from fretwear.study.plan import duration, size

    jobs = batches(planned)
    seconds, at_once = core_seconds(jobs, planned.speed), min(cores(), len(jobs))
    counts = (
        _count(len(planned.points), "point"),
        f"{_count(len(planned.estimates), 'case')} in {_count(len(jobs), 'job')}",
    )
    shared = f", {duration(seconds / at_once)} on {at_once} cores" if at_once > 1 else ""
    return (
        f"{', '.join(counts)}: about {duration(seconds)} on one core{shared}, "
        f"up to {size(planned.memory_bytes)} of memory for a job, "
        f"about {size(planned.file_bytes)} of files."
    )


def _count(number: int, thing: str) -> str:
    return f"{number} {thing}{'s' * (number != 1)}"
