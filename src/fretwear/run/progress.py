"""The steps of a run as observers see them; a bar on a terminal, lines elsewhere."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from fretwear.mechanics.wear.measures import Measures
from fretwear.mechanics.wear.state import State
from fretwear.study.case import Case
from fretwear.units import LENGTH, duration_text, number_text, readable_unit, with_unit

SECONDS_BETWEEN_LINES, _HOUR = 10.0, 3600.0


@dataclass(frozen=True)
class Step:
    """One accepted step of a run, as passed to observers."""

    state: State  # fields and numbers of the contact
    measures: Measures  # scalars of the whole contact, by name
    last_cycle: int  # where the run ends


Observer = Callable[[Step], None]


@contextmanager
def progress_bar(case: Case, tell: Callable[[str], None] | None = None) -> Iterator[Observer]:
    """Show the accepted steps of a run: cycle, step, error, half-width and time left.

    Where there is no terminal, and no notebook, `tell` takes a line every ten seconds.
    """
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn

    console, told = Console(stderr=True), -math.inf
    hidden = not (console.is_terminal or console.is_jupyter)
    with Progress(
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        console=console,
        transient=True,
        disable=hidden,
        speed_estimate_period=_HOUR,
    ) as bar:
        task = bar.add_task(f"case {case.case_id}", total=1.0)

        def show(step: Step) -> None:
            nonlocal told
            share, now = _share(step), time.monotonic()
            bar.update(task, completed=share)
            text = step_text(step, bar.tasks[0].time_remaining)
            bar.update(task, description=text)
            if hidden and tell and (share == 1.0 or now - told >= SECONDS_BETWEEN_LINES):
                tell(f"{case.case_id}: {text}")
                told = now

        yield show


def _share(step: Step) -> float:
    """Fraction of the time of a run that has passed, 0 to 1.

    Steps grow over a run, but more slowly than the cycle: the fraction lies between that of the
    cycles and that of their logarithms.
    """
    cycle, last = step.state.cycle, step.last_cycle
    return math.sqrt(cycle / last * math.log1p(cycle) / math.log1p(last))


def step_text(step: Step, seconds_left: float | None) -> str:
    """Return the progress of a run in words, with the time left, s, if it is known."""
    half_width = step.measures.contact_half_width_x
    unit = readable_unit(half_width, LENGTH.si_unit)
    width = with_unit(number_text(unit.of(half_width), 4), unit)
    error = number_text(100.0 * step.state.error_estimate, 2)
    left = f", {duration_text(math.ceil(seconds_left))} left" if seconds_left else ""
    return (
        f"cycle {step.state.cycle:.6g} of {step.last_cycle}, step {step.state.step}, "
        f"step error {error} %, half-width {width}{left}"
    )
