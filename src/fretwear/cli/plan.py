"""``fretwear plan`` and ``fretwear schema``: what a study is and may be, nothing is run."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import typer

from fretwear.cli.arguments import Assignments, StudyFile
from fretwear.cli.status import Status, failing_as

if TYPE_CHECKING:
    from fretwear.study.plan import Plan


def plan(file: StudyFile, set_: Assignments = None) -> None:
    """Print the points of a study with the time and memory each will take; run nothing."""
    from fretwear.study.file import StudyError, load_study
    from fretwear.study.plan import plan_study

    with failing_as(Status.WRONG_INPUT, StudyError):
        planned = plan_study(load_study(file, set_ or ()))
    for line in _aligned([planned.header(), *planned.rows()]):
        typer.echo(line)
    typer.echo(f"\n{_total(planned)}")


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


def _total(planned: Plan) -> str:
    from fretwear.study.plan import duration, size

    points, cases = len(planned.points), len(planned.estimates)
    return (
        f"{points} point{'s' * (points != 1)}, {cases} case{'s' * (cases != 1)}: "
        f"about {duration(planned.seconds)} on one core, "
        f"up to {size(planned.memory_bytes)} of memory for a case, "
        f"about {size(planned.file_bytes)} of files."
    )
