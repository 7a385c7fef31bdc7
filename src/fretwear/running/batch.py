"""One case to one file, and a batch of cases each to a file of its own."""

from __future__ import annotations

import shlex
import time
import traceback
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from fretwear.data.files import finished_by, open_history, write_case
from fretwear.data.safe import (
    DataFileError,
    Lock,
    Unfailing,
    is_of_memory,
    is_of_netcdf,
    open_log,
    reason_of,
    unexpected,
    uninterrupted,
)
from fretwear.mechanics.contact import ContactError
from fretwear.mechanics.integrator import WearError
from fretwear.running.checkpoint import SECONDS_BETWEEN, Checkpoint
from fretwear.running.resources import require_memory
from fretwear.running.simulate import run
from fretwear.running.workflow import failures, forget, log_file, record
from fretwear.study.doubts import doubts
from fretwear.version import code_digest

if TYPE_CHECKING:
    from fretwear.running.simulate import Observer
    from fretwear.study.case import Case
    from fretwear.study.study import Study


def may_happen(error: Exception) -> bool:
    """Say whether an error may end a command without a defect of this package or a library."""
    kinds = (ContactError, WearError, DataFileError, OSError)
    return isinstance(error, kinds) or is_of_memory(error) or is_of_netcdf(error)


@dataclass(frozen=True)
class Outcome:
    """The outcome of a job."""

    steps: int  # accepted steps of the whole run, those before an interruption included
    seconds: float  # time that this job took
    # Whether another process wrote the file while this one waited for it.
    is_taken_over: bool = False


def simulate_to_file(
    case: Case,
    path: Path,
    *,
    observers: Sequence[Observer] = (),
    tell: Callable[[str], None],
    command: str,
    interval: float = SECONDS_BETWEEN,
    threads: int = 1,
) -> Outcome:
    """Simulate a case and write its file; resume from the checkpoint beside it if any.

    Two jobs never compute the same file at once: the later one waits, and keeps the file if it then
    holds the same case, with the same snapshots, from the same version.

    Observers are called with each accepted step of this job. `tell` takes a line for people: where
    the run resumes, why a checkpoint was not used, for whom the job waits. The command is the call
    that leads to the same results, the interval that of `Checkpoint`.

    A ContactError or a WearError leaves the checkpoint; it is a DataFileError if the file cannot be
    written or another process has come to compute it, a MemoryError if there is no room for it.
    """
    started = time.monotonic()
    require_memory(case)
    before = doubts(case)
    for doubt in before:
        tell(f"warning: {doubt}")
    with Lock(path, tell) as lock:
        if lock.waited and finished_by(path, case) == code_digest():
            with open_history(path) as known:
                steps = known.sizes["step"] - 1
            return Outcome(steps, time.monotonic() - started, is_taken_over=True)
        with Checkpoint(checkpoint_of(path), case, tell, interval) as checkpoint:
            result = run(
                case,
                [checkpoint, *observers],
                record=checkpoint.record,
                threads=threads,
                command=command,
            )
            lock.ensure()
            with uninterrupted():
                dataset, history, loops = result.labelled
                write_case(dataset, history, path, loops)
                checkpoint.discard()
    for found in dataset.attrs["warnings"].splitlines()[len(before) :]:
        tell(f"warning: {found}")
    return Outcome(int(history.coords["step"].values[-1]), time.monotonic() - started)


def checkpoint_of(path: Path) -> Path:
    """Return the checkpoint that belongs to a case file."""
    return path.with_suffix(".checkpoint")


class Listener(Protocol):
    """Receives the messages of a batch, as `fretwear.cli.progress.Log` does."""

    def batch(self, cases: Mapping[str, Case]) -> AbstractContextManager[None]:
        """Announce the cases that will run in the context."""

    def case(self, case: Case, file: Path) -> AbstractContextManager[Observer]:
        """Announce a case that runs in the context; the observer is called at every step."""

    def note(self, message: str) -> None:
        """Receive a message."""


@dataclass(frozen=True)
class BatchOutcome:
    """The outcome of a batch."""

    # The numbers of all cases and of those done before.
    case_ids: tuple[str, ...]
    found: tuple[str, ...]
    failed: Mapping[str, str]  # why cases failed, by id


@dataclass(frozen=True)
class BatchRun:
    """A running batch of a study."""

    # The study, and the folder of its results.
    study: Study
    results: Path
    listener: Listener  # receives messages on the batch as a whole
    # Makes a listener that writes to the open log of a case.
    listener_to: Callable[[Unfailing], Listener]
    # Whether cases finished by other code are kept rather than run again.
    keep_older: bool = False
    threads: int = 1  # per case

    def run(self, first: int, last: int) -> BatchOutcome:
        """Run the cases of neighbouring points, counted from 1, except finished ones.

        A case that fails does not stop the others; the reason is recorded beside its log.
        """
        cases = {point.id: point.case for point in self.study.points(first, last) if point.case}
        digests = {each: finished_by(self._file(each), cases[each]) for each in cases}
        older = [each for each, digest in digests.items() if digest not in (None, code_digest())]
        found = [each for each, digest in digests.items() if digest is not None]
        if not self.keep_older:
            found = [each for each in found if each not in older]
        for case_id in found:
            forget(self.results, case_id)
            # Left by a disk that failed after the file had got its name.
            with suppress(OSError):
                checkpoint_of(self._file(case_id)).unlink(missing_ok=True)
            Lock(self._file(case_id)).remove_if_abandoned()
        if found:
            self.listener.note(f"{len(found)} of {len(cases)} cases were done before")
        if older:
            what = "kept" if self.keep_older else "computed again"
            self.listener.note(f"{len(older)} of them by another version of the code: {what}")
        # A case during which an earlier process vanished may end this one too, so it comes last.
        vanished = failures(self.results)
        to_do = {case_id: cases[case_id] for case_id in cases if case_id not in found}
        ordered = sorted(to_do, key=lambda case_id: case_id in vanished)
        failed: dict[str, str] = {}
        with self.listener.batch(to_do):
            for case_id in ordered:
                if reason := self._run(to_do[case_id]):
                    failed[case_id] = reason
                    log = log_file(self.results, case_id)
                    self.listener.note(f"{case_id} failed: {reason} (log: {log})")
        return BatchOutcome(tuple(cases), tuple(found), failed)

    def _file(self, case_id: str) -> Path:
        return self.results / "cases" / f"{case_id}.nc"

    def _run(self, case: Case) -> str:
        """Run a case; return the reason if it failed, else an empty text."""
        # Recorded at the start, because a process that is killed cannot do so.
        record(self.results, case.case_id)
        command = ["fretwear", "run", str(self.study.file), "--case", case.case_id]
        file = self._file(case.case_id)
        log = log_file(self.results, case.case_id)
        with open_log(log) as stream:
            own = self.listener_to(stream)
            try:
                with self.listener.case(case, file) as observe, own.case(case, file) as observe_own:
                    simulate_to_file(
                        case,
                        file,
                        observers=[observe, observe_own],
                        tell=own.note,
                        command=shlex.join(command),
                        threads=self.threads,
                    )
            except Exception as error:
                reason = reason_of(error) if may_happen(error) else unexpected(error)
                if not may_happen(error):
                    traceback.print_exc(file=stream)
            except BaseException:
                # Being stopped is not a failure: the next run resumes from the checkpoint.
                forget(self.results, case.case_id)
                raise
            else:
                forget(self.results, case.case_id)
                return ""
            print(f"fretwear: error: {reason}", file=stream)
        record(self.results, case.case_id, reason)
        return reason
