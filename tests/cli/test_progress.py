from dataclasses import replace

import pytest

from fretwear.cli.progress import LineLog, Pace, describe
from fretwear.simulation import Step, steps
from fretwear.study.selection import select_case


class HandClock:
    """A clock that stands still until it is set."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def step(desk):
    del desk
    return next(steps(select_case("tiny.yaml", None, ["load=50 N"])))


def at(step: Step, cycle: float) -> Step:
    return replace(step, state=replace(step.state, cycle=cycle))


def test_time_left_follows_from_the_pace_of_the_last_steps(step):
    clock = HandClock()
    pace = Pace(clock)
    assert pace.seconds_left(at(step, 0.0)) is None
    for cycle in (1.0, 2.0, 3.0, 4.0, 5.0, 6.0):
        clock.now += 1.0
        assert pace.seconds_left(at(step, cycle)) == pytest.approx(200.0 - cycle)
    for cycle in (16.0, 26.0, 36.0, 46.0, 56.0):
        clock.now += 1.0
        left = pace.seconds_left(at(step, cycle))
    assert left == pytest.approx((200.0 - 56.0) / 10.0)


def test_a_line_tells_cycle_step_error_half_width_and_time_left(step):
    line = describe(at(step, 20.0), 125.4)
    assert line == "cycle 20 of 200, step 0, error 0 %, half-width 147.8 um, 2:05 left"
    assert describe(step, 7325.0).endswith("2:02:05 left")


def test_a_log_has_the_first_and_the_last_step_and_not_too_many_between(step):
    clock, lines = HandClock(), []
    log = LineLog("case", lines.append, clock)
    for cycle in range(0, 201):
        log(at(step, float(cycle)))
        clock.now += 0.1
    assert lines[0] == "case"
    assert lines[1].startswith("cycle 0 of 200")
    assert lines[-1].startswith("cycle 200 of 200")
    assert 10 <= len(lines) <= 13
