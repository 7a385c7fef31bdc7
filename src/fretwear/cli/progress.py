"""How far a run is: a bar on a terminal, lines of text anywhere else."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from rich.console import Console

if TYPE_CHECKING:
    from rich.progress import Progress

    from fretwear.journal import Step

_RECENT_STEPS = 6
_SECONDS_BETWEEN_LINES = 2.0


class Pace:
    """Cycles done against time, and the time left by the pace of the last few steps.

    Steps grow by orders of magnitude over a run, while each takes about as long as the one
    before: the average over the whole run would foretell hours where seconds are left.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._recent: deque[tuple[float, float]] = deque(maxlen=_RECENT_STEPS)

    def seconds_left(self, step: Step) -> float | None:
        """Take note of a step; return the time left in s, None where nothing is known yet."""
        now, cycle = self._clock(), step.state.cycle
        self._recent.append((now, cycle))
        then, from_cycle = self._recent[0]
        if cycle <= from_cycle:
            return None
        return (now - then) * (step.last_cycle - cycle) / (cycle - from_cycle)


def describe(step: Step, seconds_left: float | None) -> str:
    """Say where a run is: cycle, step, error, half-width, time left."""
    parts = [f"cycle {step.state.cycle:.6g} of {step.last_cycle}", *_numbers(step)]
    if seconds_left is not None:
        parts.append(f"{_clock_time(seconds_left)} left")
    return ", ".join(parts)


def _numbers(step: Step) -> tuple[str, ...]:
    state, measures = step.state, step.measures
    return (
        f"step {state.step}",
        f"error {100.0 * state.error_estimate:.2g} %",
        f"half-width {1e6 * measures.contact_half_width_x:.4g} um",
    )


def _clock_time(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes}:{rest:02d}"


@contextmanager
def progress(title: str, cycles: int) -> Iterator[Callable[[Step], None]]:
    """Give an observer of a run that shows on the standard error stream how far it is."""
    console = Console(stderr=True, highlight=False)
    if not console.is_terminal:
        yield LineLog(title, lambda line: console.print(line, markup=False, soft_wrap=True))
        return
    with _bar(console) as bar:
        task = bar.add_task("", total=cycles, numbers="first loading", left="")
        bar.console.print(title, markup=False)
        pace = Pace()

        def observe(step: Step) -> None:
            left = pace.seconds_left(step)
            bar.update(
                task,
                completed=step.state.cycle,
                numbers=", ".join(_numbers(step)),
                left="" if left is None else f"{_clock_time(left)} left",
            )

        yield observe


class LineLog:
    """An observer that writes a line at the first and the last step and every few seconds.

    Parameters
    ----------
    title
        The first line.
    write
        Takes a line.
    clock
        Seconds, increasing.
    """

    def __init__(
        self, title: str, write: Callable[[str], None], clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._write = write
        self._clock = clock
        self._pace = Pace(clock)
        self._last: float | None = None
        write(title)

    def __call__(self, step: Step) -> None:
        """Observe a step."""
        left = self._pace.seconds_left(step)
        now = self._clock()
        is_due = self._last is None or now - self._last >= _SECONDS_BETWEEN_LINES
        if is_due or step.state.cycle >= step.last_cycle:
            self._last = now
            self._write(describe(step, left))


def _bar(console: Console) -> Progress:
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    return Progress(
        TextColumn("cycle"),
        MofNCompleteColumn(),
        BarColumn(bar_width=24),
        TextColumn("{task.fields[numbers]}"),
        TextColumn("{task.fields[left]}"),
        console=console,
    )
