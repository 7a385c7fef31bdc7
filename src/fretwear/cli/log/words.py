"""How far a case is, in words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from fretwear.cli.log.pace import BatchPace, clock_time

if TYPE_CHECKING:
    from fretwear.running.simulate import Step
    from fretwear.study.case import Case


def case_title(case: Case, batch: BatchPace) -> str:
    """Return the id of a case, with its number where there are several."""
    which = f" {batch.number} of {batch.count}" if batch.count > 1 else ""
    return f"case{which}: {case.case_id}" if which else f"case {case.case_id}"


def where_it_is(step: Step, seconds_left: float) -> str:
    """Say where a run is: cycle, step, error, half-width, time left."""
    cycle = f"cycle {step.state.cycle:.6g} of {step.last_cycle}"
    return f"{cycle}, {numbers(step)}, {time_left(seconds_left)}"


def time_left(seconds: float) -> str:
    """Say how long something takes; nothing takes no time at all before it is over."""
    return f"{clock_time(math.ceil(seconds))} left"


def numbers(step: Step) -> str:
    """Say step, error and half-width."""
    return (
        f"step {step.state.step}, error {100.0 * step.state.error_estimate:.2g} %, "
        f"half-width {1e6 * step.measures.contact_half_width_x:.4g} um"
    )
