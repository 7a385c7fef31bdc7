"""A batch: several cases of a study in one process, each to a file of its own."""

from __future__ import annotations

import shlex
import traceback
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, TextIO

from fretwear.data.failures import failures, forget, log_file, record
from fretwear.data.files import is_finished_case
from fretwear.job import JOB_ERRORS, simulate_to_file

if TYPE_CHECKING:
    from fretwear.simulation import Observer
    from fretwear.study.case import Case
    from fretwear.study.file import Study


class Listener(Protocol):
    """Who is told what a batch does, as `fretwear.cli.log.Log` is."""

    def batch(self, cases: Mapping[str, Case]) -> AbstractContextManager[None]:
        """Hear of the cases that will run in the context."""

    def case(self, case: Case, file: Path) -> AbstractContextManager[Observer]:
        """Hear of a case that runs in the context; the observer is called at every step."""

    def note(self, message: str) -> None:
        """Hear a line for people."""


@dataclass(frozen=True)
class BatchOutcome:
    """What became of the cases of a batch.

    Attributes
    ----------
    case_ids : tuple of str
        All cases.
    found : tuple of str
        Those that were done before.
    failed : mapping of str to str
        Why cases failed, by id.
    """

    case_ids: tuple[str, ...]
    found: tuple[str, ...]
    failed: Mapping[str, str]


@dataclass(frozen=True)
class BatchRun:
    """A batch of a study on its way.

    Attributes
    ----------
    study : Study
        The study.
    results : pathlib.Path
        Folder of its results.
    listener : Listener
        Hears of the batch as a whole.
    listener_to : callable
        Takes an open file; gives one who writes there what a single case says, see
        `fretwear.data.failures.log_file`.
    """

    study: Study
    results: Path
    listener: Listener
    listener_to: Callable[[TextIO], Listener]

    def run(self, first: int, last: int) -> BatchOutcome:
        """Run the cases of neighbouring points, those excepted that are done and sound.

        A case that fails keeps no other from running; why it failed is recorded beside its log.

        Parameters
        ----------
        first, last : int
            Numbers of the first and the last point, counted from 1.
        """
        cases = {point.id: point.case for point in self.study.points(first, last) if point.case}
        found = [
            case_id for case_id in cases if is_finished_case(self._file(case_id), cases[case_id])
        ]
        for case_id in found:
            forget(self.results, case_id)
        if found:
            self.listener.note(f"{len(found)} of {len(cases)} cases were done before")
        # A case during which an earlier process vanished may take this one along: it comes last.
        vanished = failures(self.results)
        to_do = {case_id: cases[case_id] for case_id in cases if case_id not in found}
        ordered = sorted(to_do, key=lambda case_id: case_id in vanished)
        failed: dict[str, str] = {}
        with self.listener.batch(to_do):
            for case_id in ordered:
                if reason := self._run_recorded(to_do[case_id]):
                    failed[case_id] = reason
                    log = log_file(self.results, case_id)
                    self.listener.note(f"{case_id} failed: {reason} (log: {log})")
        return BatchOutcome(tuple(cases), tuple(found), failed)

    def _file(self, case_id: str) -> Path:
        return self.results / "cases" / f"{case_id}.nc"

    def _run_recorded(self, case: Case) -> str:
        """Run a case; return why it failed, or an empty text."""
        # Recorded from the beginning, because nobody else can do so when the process is killed.
        record(self.results, case.case_id)
        with _opened(log_file(self.results, case.case_id)) as stream:
            try:
                self._run(case, self.listener_to(stream))
            except JOB_ERRORS as error:
                reason = str(error) or type(error).__name__
            except Exception as error:
                traceback.print_exc(file=stream)
                reason = f"this is a defect of fretwear: {type(error).__name__}: {error}"
            except BaseException:
                # Stopped from outside is no failure: the next run goes on from the checkpoint.
                forget(self.results, case.case_id)
                raise
            else:
                forget(self.results, case.case_id)
                return ""
            print(f"fretwear: error: {reason}", file=stream)
        record(self.results, case.case_id, reason)
        return reason

    def _run(self, case: Case, own: Listener) -> None:
        file = self._file(case.case_id)
        with self.listener.case(case, file) as observe, own.case(case, file) as observe_own:
            simulate_to_file(
                case,
                file,
                observers=[observe, observe_own],
                tell=own.note,
                command=shlex.join(
                    ["fretwear", "run", str(self.study.file), "--case", case.case_id]
                ),
            )


@contextmanager
def _opened(path: Path) -> Iterator[TextIO]:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(b"")
    # A process that was left over may still write to it: each line goes to the end.
    with path.open("a", encoding="utf-8", buffering=1) as stream:
        yield stream
