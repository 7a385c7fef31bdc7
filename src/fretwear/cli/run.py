"""``fretwear run``: one case of a study to one file."""

from __future__ import annotations

import os
import shlex
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from fretwear.cli.arguments import Assignments, StudyFile
from fretwear.cli.outputs import check_file
from fretwear.cli.status import Status, failing_as

_THREAD_SETTINGS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


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
    """Simulate one case of a study and write it to one file."""
    from fretwear.study.file import StudyError
    from fretwear.study.selection import select_case

    with failing_as(Status.WRONG_INPUT, StudyError):
        chosen = select_case(file, case_id, set_ or ())
    path = check_file(output or Path(f"{chosen.case_id}.nc"))
    _use_one_thread()

    from fretwear import simulation
    from fretwear.cli.progress import progress
    from fretwear.data.errors import DataFileError
    from fretwear.data.store import write_case
    from fretwear.mechanics.contact import ContactError
    from fretwear.mechanics.wear import WearError

    started = time.monotonic()
    with failing_as(Status.FAILED, ContactError, WearError, DataFileError, MemoryError):
        with progress(f"case {chosen.case_id}", chosen.cycles) as observe:
            result = simulation.run(chosen, [observe], command=_command(file, case_id, set_ or ()))
        write_case(result.dataset, result.history, path)
    steps = result.history.sizes["step"] - 1
    typer.echo(f"{path}: {steps} steps in {time.monotonic() - started:.1f} s")


def _use_one_thread() -> None:
    """Keep the linear algebra under numpy to one thread, unless the user has set a number.

    Its share of the work is too small to gain from more, cases that run side by side would get
    into each other's way, and sums over one thread are the same bits in every run.
    """
    for name in _THREAD_SETTINGS:
        os.environ.setdefault(name, "1")


def _command(file: Path, case_id: str | None, assignments: Sequence[str]) -> str:
    """Return the call that leads to the same results, for the dataset."""
    choice = () if case_id is None else ("--case", case_id)
    changes = (word for assignment in assignments for word in ("--set", assignment))
    return shlex.join(["fretwear", "run", str(file), *choice, *changes])
