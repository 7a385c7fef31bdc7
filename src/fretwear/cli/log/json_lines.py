"""Progress as JSON lines, for programs: one event a line on the standard error stream.

Every event has ``event`` and ``time`` (UTC, ISO 8601).  Lengths are in m and times in s; numbers
that are not finite are null.  Fields may be added, none changes its meaning.
"""

from __future__ import annotations

import json
import math
import sys
import time
import traceback
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

import fretwear
from fretwear.cli.log.base import Log, Observer, describe_defect

if TYPE_CHECKING:
    from fretwear.cli.log.pace import BatchPace
    from fretwear.running.simulate import Step
    from fretwear.study.case import Case

_STATUS = {0: "done", 1: "failed", 2: "wrong_input"}


class JsonLog(Log):
    """Writes ``start`` first and ``end`` last, and what happens between them."""

    def __init__(self) -> None:
        self._started: float | None = None
        self._command = ""
        self._file: str | None = None
        self._batch: BatchPace | None = None

    def begin(self, command: str) -> None:
        """Write ``start``; from here on warnings are events too."""
        self._started = time.monotonic()
        self._command = command
        warnings.showwarning = self._warn
        self._write("start", command=command, version=fretwear.__version__)

    def end(self, exit_status: int) -> None:
        """Write ``end``, if there was a ``start``."""
        if self._started is None:
            return
        self._write(
            "end",
            command=self._command,
            status=_STATUS.get(exit_status, "stopped"),
            exit_status=exit_status,
            seconds=time.monotonic() - self._started,
            file=self._file,
        )

    def error(self, message: str, exit_status: int) -> None:
        """Write ``error``."""
        self._write("error", message=message, exit_status=exit_status)

    def defect(self, error: Exception) -> None:
        """Write ``error`` with the traceback."""
        lines = "".join(traceback.format_exception(error))
        self._write("error", message=describe_defect(error), exit_status=1, traceback=lines)

    def stopped(self, message: str, exit_status: int) -> None:
        """Write ``stopped``."""
        self._write("stopped", message=message, exit_status=exit_status)

    def note(self, message: str) -> None:
        """Write ``note``."""
        self._write("note", message=message)

    def result(self, file: Path, message: str, **numbers: float) -> None:
        """Write ``result``."""
        self._file = str(file)
        self._write("result", file=str(file), message=message, **numbers)

    @contextmanager
    def batch(self, cases: Mapping[str, Case]) -> Iterator[None]:
        """Number the cases that run in the context."""
        from fretwear.cli.log.pace import BatchPace

        self._batch = BatchPace(cases)
        try:
            yield
        finally:
            self._batch = None

    @contextmanager
    def case(self, case: Case, file: Path) -> Iterator[Observer]:
        """Write ``case_start``, a ``step`` every few seconds, and ``case_end``."""
        from fretwear.cli.log.pace import BatchPace
        from fretwear.cli.log.throttle import Throttle

        batch = self._batch or BatchPace({case.case_id: case})
        pace = batch.begin(case)
        throttle = Throttle()
        which = {"case_id": case.case_id, "case_number": batch.number, "case_count": batch.count}
        self._write("case_start", **which, cycles=case.cycles, file=str(file))
        last: Step | None = None

        def observe(step: Step) -> None:
            nonlocal last
            last = step
            pace.note(step.state.cycle)
            if throttle.is_due(is_last=step.state.cycle >= step.last_cycle):
                self._write(
                    "step",
                    **which,
                    **_numbers(step),
                    seconds=pace.seconds,
                    seconds_left=pace.seconds_left,
                    batch_seconds_left=batch.seconds_left(pace),
                )

        status = "failed"
        try:
            yield observe
            status = "done"
            batch.end(case, pace)
        except Exception:
            raise
        except BaseException:
            status = "stopped"
            raise
        finally:
            place = {} if last is None else {"cycle": last.state.cycle, "step": last.state.step}
            self._write(
                "case_end", **which, status=status, **place, seconds=pace.seconds, file=str(file)
            )

    def _warn(
        self,
        message: Warning | str,
        category: type[Warning],
        filename: str,
        lineno: int,
        file: TextIO | None = None,
        line: str | None = None,
    ) -> None:
        del file, line
        where = f"{filename}:{lineno}"
        self._write("warning", message=str(message), category=category.__name__, where=where)

    def _write(self, event: str, **fields: Any) -> None:
        now = datetime.now(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
        finite = {name: _or_null(value) for name, value in fields.items()}
        line = json.dumps({"event": event, "time": now, **finite}, allow_nan=False)
        sys.stderr.write(line + "\n")
        sys.stderr.flush()


def _numbers(step: Step) -> dict[str, float]:
    """The numbers of a step under the names that they have in the datasets."""
    return {
        "cycle": step.state.cycle,
        "cycles": step.last_cycle,
        "step": step.state.step,
        "error_estimate": step.state.error_estimate,
        "contact_half_width_x": step.measures.contact_half_width_x,
        "contact_half_width_y": step.measures.contact_half_width_y,
        "stick_half_width_x": step.measures.stick_half_width_x,
        "peak_pressure": step.measures.peak_pressure,
        "wear_volume": step.measures.wear_volume,
    }


def _or_null(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value
