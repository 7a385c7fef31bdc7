"""A batch: several cases of a study in one process, each to a file of its own."""

from __future__ import annotations

import shlex
import time
import traceback
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from fretwear.data.casefile import is_finished_case
from fretwear.data.failures import failures, forget, log_file, record
from fretwear.job import JOB_ERRORS, simulate_to_file

if TYPE_CHECKING:
    from fretwear.simulation import Observer
    from fretwear.study.case import Case
    from fretwear.study.file import Study

Tell = Callable[[str], None]

Watch = Callable[[str, Tell], "Observer"]
"""Takes a title and what takes lines; gives an observer that writes there how far a case is."""

_NO_MEMORY = (
    "there is not enough memory for it; run it where there is more, with fewer jobs at once, "
    "or with a coarser cell"
)


@dataclass(frozen=True)
class Outcome:
    """What became of the cases of a batch.

    Attributes
    ----------
    case_ids : tuple of str
        All cases.
    failed : mapping of str to str
        Why cases failed, by id.
    """

    case_ids: tuple[str, ...]
    failed: Mapping[str, str]


def run_batch(
    study: Study, first: int, last: int, results: Path, tell: Tell, watch: Watch
) -> Outcome:
    """Run the cases of neighbouring points, those that are finished and sound excepted.

    A case that fails keeps no other from running. What each case says goes to its log, see
    `fretwear.data.failures.log_file`; why it failed is recorded beside that.

    Parameters
    ----------
    study : Study
        The study.
    first, last : int
        Numbers of the first and the last point, counted from 1.
    results : Path
        Folder of the study's results.
    tell : callable
        Takes a line for people about each case.
    watch : callable
        Makes what writes to the log of a case how far it is.
    """
    cases = {point.id: point.case for point in study.points()[first - 1 : last] if point.case}
    failed: dict[str, str] = {}
    # A case during which an earlier process vanished may take this one along: it comes last.
    vanished = failures(results).keys() & cases.keys()
    for case_id in sorted(cases, key=lambda case_id: case_id in vanished):
        path = results / "cases" / f"{case_id}.nc"
        if is_finished_case(path, cases[case_id]):
            forget(results, case_id)
            tell(f"{case_id}: done before")
            continue
        started = time.monotonic()
        reason = _run_recorded(study, cases[case_id], results, watch)
        if reason:
            failed[case_id] = reason
            tell(f"{case_id}: failed: {reason} (log: {log_file(results, case_id)})")
        else:
            tell(f"{case_id}: done in {time.monotonic() - started:.1f} s")
    return Outcome(tuple(cases), failed)


def _run_recorded(study: Study, case: Case, results: Path, watch: Watch) -> str:
    """Run a case; return why it failed, or an empty string."""
    record(results, case.case_id)
    with _logging(log_file(results, case.case_id)) as log:
        try:
            simulate_to_file(
                case,
                results / "cases" / f"{case.case_id}.nc",
                observers=[watch(f"case {case.case_id}", log)],
                tell=log,
                command=shlex.join(["fretwear", "run", str(study.file), "--case", case.case_id]),
            )
        except MemoryError as error:
            reason = str(error) or _NO_MEMORY
        except JOB_ERRORS as error:
            reason = str(error)
        except Exception as error:
            log(traceback.format_exc())
            reason = f"unexpected error: {type(error).__name__}: {error}"
        except BaseException:
            # Stopped from outside, which is no failure: the next run goes on from the checkpoint.
            forget(results, case.case_id)
            raise
        else:
            forget(results, case.case_id)
            return ""
        log(f"fretwear: error: {reason}")
    record(results, case.case_id, reason)
    return reason


@contextmanager
def _logging(path: Path) -> Iterator[Tell]:
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", encoding="utf-8", buffering=1) as stream:
        yield lambda line: print(line, file=stream)
