"""One case to one file: where simulation, checkpoints and files meet.

`fretwear run` does one such job, a batch does many; both do it here.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from fretwear import simulation
from fretwear.checkpoints import SECONDS_BETWEEN, Checkpoint
from fretwear.data.files import is_finished_case, open_history, write_case
from fretwear.data.safe import DataFileError, locked, uninterrupted
from fretwear.mechanics.contact import ContactError
from fretwear.mechanics.wear import WearError
from fretwear.memory import require_memory

if TYPE_CHECKING:
    from fretwear.simulation import Observer
    from fretwear.study.case import Case

# What a job may fail of without a defect of this package; each has a message for people.
JOB_ERRORS = (ContactError, WearError, DataFileError, MemoryError)


@dataclass(frozen=True)
class Outcome:
    """What a job did.

    Attributes
    ----------
    steps : int
        Accepted steps of the whole run, those before an interruption included.
    seconds : float
        Time that this job took, s.
    is_taken_over : bool
        Whether another process wrote the file while this one waited for it.
    """

    steps: int
    seconds: float
    is_taken_over: bool = False


def simulate_to_file(
    case: Case,
    path: Path,
    *,
    observers: Sequence[Observer] = (),
    tell: Callable[[str], None],
    command: str,
    interval: float = SECONDS_BETWEEN,
) -> Outcome:
    """Simulate a case and write its file; go on from the checkpoint beside it if there is one.

    Two jobs with one file do not work at once: the later one waits, and takes the file as it is
    if it then is that of the same case, with the same snapshots, by the same version.

    Parameters
    ----------
    case
        What to run.
    path
        The case file; it appears under this name only when it is whole.
    observers
        Called with each accepted step of this job.
    tell
        Takes a line for people: where the run goes on, why a checkpoint was not used, for whom
        the job waits.
    command
        The call that leads to the same results, for the dataset.
    interval
        Longest time between two checkpoints, s, but for a single step that takes longer.

    Raises
    ------
    fretwear.mechanics.contact.ContactError, fretwear.mechanics.wear.WearError
        When the solution does not converge. The checkpoint is kept.
    fretwear.data.safe.DataFileError
        When the file cannot be written, or another process has come to compute it meanwhile.
    MemoryError
        When the case does not fit in the memory; it tells so before it starts where that is
        certain.
    """
    started = time.monotonic()
    require_memory(case)
    with locked(path, tell) as lock:
        if lock.waited and is_finished_case(path, case):
            return Outcome(_steps_of(path), time.monotonic() - started, is_taken_over=True)
        with Checkpoint(path.with_suffix(".checkpoint"), case, tell, interval) as checkpoint:
            result = simulation.run(
                case, [checkpoint, *observers], journal=checkpoint.journal, command=command
            )
            lock.ensure(tell)
            with uninterrupted():
                write_case(result.dataset, result.history, path)
                checkpoint.discard()
    return Outcome(result.history.sizes["step"] - 1, time.monotonic() - started)


def _steps_of(path: Path) -> int:
    with open_history(path) as history:
        return history.sizes["step"] - 1
