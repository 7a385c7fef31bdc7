"""Progress as lines of text, for log files."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from fretwear.cli.log.base import Observer
from fretwear.cli.log.text import TextLog

if TYPE_CHECKING:
    from fretwear.cli.log.pace import BatchPace, Clock
    from fretwear.running.simulate import Step
    from fretwear.study.case import Case


class LinesLog(TextLog):
    """A line at the first and the last step of a case, and every few seconds between them."""

    def __init__(self, clock: Clock = time.monotonic) -> None:
        self._clock = clock
        self._batch: BatchPace | None = None

    @contextmanager
    def batch(self, cases: Mapping[str, Case]) -> Iterator[None]:
        """Number the cases that run in the context."""
        from fretwear.cli.log.pace import BatchPace

        self._batch = BatchPace(cases, self._clock)
        try:
            yield
        finally:
            self._batch = None

    @contextmanager
    def case(self, case: Case, file: Path) -> Iterator[Observer]:
        """Tell of a case that runs in the context."""
        from fretwear.cli.log.pace import BatchPace, clock_time
        from fretwear.cli.log.throttle import Throttle
        from fretwear.cli.log.words import case_title, time_left, where_it_is

        del file
        batch = self._batch or BatchPace({case.case_id: case}, self._clock)
        pace = batch.begin(case)
        throttle = Throttle(self._clock)
        self._print(case_title(case, batch))

        def observe(step: Step) -> None:
            pace.note(step.state.cycle)
            if throttle.is_due(is_last=step.state.cycle >= step.last_cycle):
                self._print(where_it_is(step, pace.seconds_left))

        yield observe
        batch.end(case, pace)
        if self._batch is not None:
            took, left = clock_time(pace.seconds), time_left(batch.seconds_left(pace))
            self._print(f"case {batch.number} of {batch.count} done in {took}, {left}")
