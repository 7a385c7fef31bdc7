"""From cases to files: each file appears complete, and a failure leaves its reason."""

from __future__ import annotations

import math
import os
import time
import traceback
from collections.abc import Callable, Collection, Mapping
from pathlib import Path

from fretwear.data.atomic import DataFileError
from fretwear.data.files import finished_by, write_case
from fretwear.mechanics.contact.problem import ContactError
from fretwear.mechanics.wear.integrator import WearError
from fretwear.run.checkpoint import Checkpoint
from fretwear.run.progress import SECONDS_BETWEEN_LINES, progress_bar
from fretwear.run.resources import require_memory
from fretwear.run.simulate import run
from fretwear.study.case import Case
from fretwear.version import case_digest

ENDED = "the process that ran it was killed, or ran out of memory or time"
EXPECTED = (ContactError, WearError, DataFileError, OSError, MemoryError)
"""Errors that end a run and are no defect: their message says all."""

_FAILED = ".failed"


def simulate_to_file(
    case: Case,
    path: Path,
    *,
    tell: Callable[[str], None],
    command: str,
    attributes: Mapping[str, str] | None = None,
) -> int:
    """Simulate a case, write its file, and return the number of steps.

    The run resumes from the checkpoint beside the file, and an interrupted run leaves one. `tell`
    takes messages, such as progress where there is no terminal. The command is a call that gives
    the same results; `attributes` of the study go into the file. Raises a ContactError or a
    WearError if the solution does not converge, a DataFileError if the file cannot be written and a
    MemoryError if the case does not fit in memory.
    """
    require_memory(case)
    checkpoint = Checkpoint(path.with_suffix(".checkpoint"), case, tell)
    with checkpoint, progress_bar(case, tell) as show:
        result = run(
            case,
            [checkpoint, show],
            record=checkpoint.record,
            command=command,
            warn=lambda warning: tell(f"warning: {warning}"),
        )
        write_case(result.dataset, result.history, path, result.loops, attributes)
    checkpoint.path.unlink(missing_ok=True)
    return len(checkpoint.record.history) - 1


def simulate_to_folder(
    cases: Mapping[str, Case],
    folder: Path,
    *,
    tell: Callable[[str], None],
    command: str,
    keep_older: bool = False,
    attributes: Mapping[str, str] | None = None,
    count: Callable[[str], None] = lambda _: None,
    study: Collection[str] = (),
) -> dict[str, str]:
    """Simulate cases one after the other, each to its file ``<case id>.nc`` in a folder.

    Finished cases are kept; those computed by other code only with `keep_older`. A case that fails
    does not stop the others. `count` takes a line with the number of finished cases among all of a
    `study`, by their ids: after the first case, every ten seconds, and after the last. Returns the
    reasons of failures, by id.
    """
    failed, counted = dict[str, str](), -math.inf
    for number, (case_id, case) in enumerate(cases.items()):
        if number and time.monotonic() - counted >= SECONDS_BETWEEN_LINES:
            count(_count(folder, study or cases))
            counted = time.monotonic()
        path = folder / f"{case_id}.nc"
        code = finished_by(path, case)
        if code == case_digest(case) or (code is not None and keep_older):
            path.with_suffix(_FAILED).unlink(missing_ok=True)
            continue
        folder.mkdir(parents=True, exist_ok=True)
        path.with_suffix(_FAILED).write_text(ENDED, encoding="utf-8")
        try:
            typed = f"{command} {case_id}"
            simulate_to_file(case, path, tell=tell, command=typed, attributes=attributes)
        except Exception as error:
            failed[case_id] = str(error) or type(error).__name__
            path.with_suffix(_FAILED).write_text(failed[case_id], encoding="utf-8")
            tell(f"{case_id} failed: {failed[case_id]}")
            if not isinstance(error, EXPECTED):
                tell(traceback.format_exc())
        except BaseException:
            path.with_suffix(_FAILED).unlink(missing_ok=True)  # stopped, not failed
            raise
        else:
            path.with_suffix(_FAILED).unlink(missing_ok=True)
    count(_count(folder, study or cases))
    return failed


def _count(folder: Path, study: Collection[str]) -> str:
    done = sum((folder / f"{case_id}.nc").exists() for case_id in study)
    return f"{os.path.normpath(folder)}: {done} of {len(study)} cases done"


def failures(folder: Path) -> dict[str, str]:
    """Return the reasons why cases that were begun have no file in a folder, by case id."""
    return {
        file.stem: file.read_text(encoding="utf-8", errors="replace")
        for file in sorted(folder.glob(f"*{_FAILED}"))
    }
