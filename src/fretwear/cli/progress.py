"""Progress of a run on the standard error stream: a bar on a terminal, lines elsewhere."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from fretwear.cli.common import note
from fretwear.units import LENGTH, duration_text, number_text, readable_unit, with_unit

if TYPE_CHECKING:
    from fretwear.run.simulate import Observer, Step
    from fretwear.study.case import Case

_SECONDS_BETWEEN_LINES = 10.0


@contextmanager
def progress(case: Case, clock: Callable[[], float] = time.monotonic) -> Iterator[Observer]:
    """Show the accepted steps of a run: cycle, step, error, half-width and time left."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn

    console, begun = Console(stderr=True), clock()
    first, told = math.nan, -math.inf
    columns = TextColumn("{task.description}", markup=False), BarColumn()
    hidden = not console.is_terminal
    with Progress(*columns, console=console, transient=True, disable=hidden) as bar:
        task = bar.add_task(f"case {case.case_id}", total=1.0)

        def show(step: Step) -> None:
            nonlocal first, told
            share, now = _share(step), clock()
            first = share if math.isnan(first) else first
            left = (now - begun) * (1.0 - share) / (share - first) if share > first else math.nan
            text = step_text(step, left)
            if not hidden:
                bar.update(task, completed=share, description=text)
            elif share == 1.0 or now - told >= _SECONDS_BETWEEN_LINES:
                note(f"{case.case_id}: {text}")
                told = now

        yield show


def _share(step: Step) -> float:
    """Share of the time of a run that has passed, 0 to 1.

    Steps grow over a run, yet more slowly than in proportion to the cycle that is reached: the
    share lies between that of the cycles and that of their logarithm.
    """
    cycle, last = step.state.cycle, step.last_cycle
    return math.sqrt(cycle / last * math.log1p(cycle) / math.log1p(last))


def step_text(step: Step, seconds_left: float) -> str:
    """Return the progress of a run in words; without the time left, s, where it is NaN."""
    half_width = step.measures.contact_half_width_x
    unit = readable_unit(half_width, LENGTH.si_unit)
    width = with_unit(number_text(unit.of(half_width), 4), unit)
    error = number_text(100.0 * step.state.error_estimate, 2)
    left = "" if math.isnan(seconds_left) else f", {duration_text(math.ceil(seconds_left))} left"
    return (
        f"cycle {step.state.cycle:.6g} of {step.last_cycle}, step {step.state.step}, "
        f"step error {error} %, half-width {width}{left}"
    )
