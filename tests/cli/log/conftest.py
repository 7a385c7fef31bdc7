from dataclasses import replace

import pytest

from fretwear.running.simulate import steps
from fretwear.study.study import select_case


class HandClock:
    """A clock that stands still until it is set."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock():
    return HandClock()


@pytest.fixture
def case(desk):
    del desk
    return select_case("tiny.yaml", None, ["load=50 N"])


@pytest.fixture
def step(case):
    return next(steps(case))


@pytest.fixture
def at(step):
    """The first step of the case, moved to another cycle."""

    def moved(cycle, **changes):
        return replace(step, state=replace(step.state, cycle=float(cycle), **changes))

    return moved
