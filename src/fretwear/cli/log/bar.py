"""Progress on a terminal: a bar that keeps its place."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

from fretwear.cli.log.base import Observer
from fretwear.cli.log.text import TextLog

if TYPE_CHECKING:
    from rich.console import Console, RenderableType
    from rich.live import Live

    from fretwear.cli.log.pace import BatchPace, CasePace
    from fretwear.running.simulate import Step
    from fretwear.study.case import Case

_WIDEST = 100
_REFRESHES_PER_SECOND = 5


class BarLog(TextLog):
    """Two lines for the running case, a third one for a batch; they are wiped out at the end."""

    def __init__(self) -> None:
        self._kept: Console | None = None
        self._batch: BatchPace | None = None
        self._shown: Live | None = None

    @contextmanager
    def batch(self, cases: Mapping[str, Case]) -> Iterator[None]:
        """Number the cases that run in the context."""
        from fretwear.cli.log.pace import BatchPace

        self._batch = BatchPace(cases)
        try:
            with self._live() as self._shown:
                yield
        finally:
            self._batch = self._shown = None

    @contextmanager
    def case(self, case: Case, file: Path) -> Iterator[Observer]:
        """Tell of a case that runs in the context."""
        from fretwear.cli.log.pace import BatchPace, clock_time
        from fretwear.cli.log.words import case_title, where_it_is

        del file
        batch = self._batch or BatchPace({case.case_id: case})
        pace = batch.begin(case)
        self._print(case_title(case, batch))
        view = _View(batch, pace)
        with nullcontext(self._shown) if self._shown else self._live() as live:
            live.update(view)
            try:
                yield view.observe
            except BaseException:
                if view.step is not None:
                    self._print(where_it_is(view.step, pace.seconds_left))
                raise
        batch.end(case, pace)
        if self._shown is not None:
            self._print(f"  done in {clock_time(pace.seconds)}")

    def _console(self) -> Console:
        # One console, so that messages appear above the bar and not in it.
        if self._kept is None:
            self._kept = super()._console()
        return self._kept

    def _live(self) -> Live:
        from rich.live import Live

        return Live(
            console=self._console(),
            refresh_per_second=_REFRESHES_PER_SECOND,
            transient=True,
            redirect_stdout=False,
            vertical_overflow="crop",
        )


class _View:
    """What the terminal shows of a case; drawn anew some times a second."""

    def __init__(self, batch: BatchPace, pace: CasePace) -> None:
        self._batch = batch
        self._pace = pace
        self.step: Step | None = None

    def observe(self, step: Step) -> None:
        self._pace.note(step.state.cycle)
        self.step = step

    def __rich_console__(self, console: Console, options: object) -> Iterator[RenderableType]:
        from rich.progress_bar import ProgressBar
        from rich.table import Table
        from rich.text import Text

        from fretwear.cli.log.words import numbers, time_left

        del options
        width = min(console.width, _WIDEST)
        first = Table.grid(padding=(0, 1), expand=True)
        first.width = width
        first.add_column(no_wrap=True)
        first.add_column(ratio=1)
        first.add_column(no_wrap=True, justify="right")
        step = self.step
        place = "first loading" if step is None else _place(step)
        left = time_left(self._pace.seconds_left)
        first.add_row(place, ProgressBar(total=1.0, completed=self._pace.share), left)
        yield first
        if step is not None:
            yield Text(numbers(step), no_wrap=True, overflow="ellipsis")
        if self._batch.count > 1:
            whole = time_left(self._batch.seconds_left(self._pace))
            yield Text(f"all {self._batch.count} cases: {whole}", no_wrap=True, overflow="ellipsis")


def _place(step: Step) -> str:
    """Say the cycle, always equally wide: what stands beside it must not jump to and fro."""
    last = str(step.last_cycle)
    return f"cycle {round(step.state.cycle):{len(last)}d} of {last}"
