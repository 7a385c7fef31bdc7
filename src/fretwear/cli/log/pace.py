"""How much time a run still takes, said early and honestly.

Steps grow by orders of magnitude over a run, each takes about as long as the one before, and
where the bodies yield they stop growing.  The pace in cycles per second of the last steps
therefore foretells far too much at first, and their growth, carried on, too little: their geometric
mean counts, and beside it the estimate of the plan, the less of it the more cycles are done.
"""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Mapping
from itertools import pairwise
from typing import TYPE_CHECKING

from fretwear.study.cost import SECONDS_TO_START, estimate

if TYPE_CHECKING:
    from fretwear.study.case import Case

Clock = Callable[[], float]

_RECENT_STEPS = 6
_FASTEST_GROWTH = 2.0
# The plan's estimate still weighs a half when a tenth of the cycles is done.
_TRUST_IN_STEPS = 0.3
_LEAST_SHARE = 0.1


class CasePace:
    """The time left of one case.

    Parameters
    ----------
    cycles : int
        Where the case ends.
    expected_seconds : float
        What it should take, from its plan.
    clock : callable
        Seconds, increasing.

    Attributes
    ----------
    share : float
        Part of the time that is over, from 0 to 1; never falls.
    """

    def __init__(self, cycles: int, expected_seconds: float, clock: Clock = time.monotonic) -> None:
        self._cycles = cycles
        self._expected = max(expected_seconds, 1e-3)
        self._clock = clock
        self._started = clock()
        self._first_cycle = 0.0
        self._recent: deque[tuple[float, float]] = deque(maxlen=_RECENT_STEPS)
        self._left = self._expected
        self._noted = self._started
        self.share = 0.0

    @property
    def seconds(self) -> float:
        """Time since the case began, s."""
        return self._clock() - self._started

    @property
    def seconds_left(self) -> float:
        """Time until the case ends, s: as foretold at the last step, less the time since."""
        return max(0.0, self._left - (self._clock() - self._noted))

    def note(self, cycle: float) -> None:
        """Take note of a step that has come to a cycle."""
        now = self._clock()
        if not self._recent:
            # A run that goes on from a checkpoint has less to do than its plan says.
            self._first_cycle = cycle
        self._recent.append((now, cycle))
        self._noted = now
        self._left = self._foretold(now, cycle)
        if self._left == 0.0:
            self.share = 1.0
        elif now > self._started:
            self.share = max(self.share, self.seconds / (self.seconds + self._left))

    def _foretold(self, now: float, cycle: float) -> float:
        to_do = self._cycles - cycle
        if to_do <= 0.0:
            return 0.0
        part = (self._cycles - self._first_cycle) / self._cycles
        planned = part * self._expected
        taken = now - self._started
        by_plan = max(planned - taken, _LEAST_SHARE * max(planned, taken))
        by_steps = self._by_steps(to_do)
        if by_steps is None:
            return by_plan
        trust = (cycle / self._cycles) ** _TRUST_IN_STEPS
        return math.exp(trust * math.log(by_steps) + (1.0 - trust) * math.log(by_plan))

    def _by_steps(self, to_do: float) -> float | None:
        """Time left by the last steps, None where they say nothing."""
        times, cycles = zip(*self._recent, strict=True)
        sizes = [after - before for before, after in pairwise(cycles)]
        taken = times[-1] - times[0]
        if not sizes or taken <= 0.0:
            return None
        at_this_pace = taken * to_do / sum(sizes)
        growth = (sizes[-1] / sizes[0]) ** (1.0 / max(1, len(sizes) - 1))
        steps = _steps(to_do, max(sizes[-2:]), min(growth, _FASTEST_GROWTH))
        return math.sqrt(at_this_pace * steps * taken / len(sizes))


def _steps(to_do: float, size: float, growth: float) -> float:
    """How many steps cover what is to do when each is larger than the one before by a factor."""
    if growth < 1.001:
        return to_do / size
    return math.log1p(to_do * (growth - 1.0) / (size * growth)) / math.log(growth)


class BatchPace:
    """The time left of cases that run one after the other.

    Parameters
    ----------
    cases : mapping
        The cases that will run, by id.
    clock : callable
        Seconds, increasing.
    """

    def __init__(self, cases: Mapping[str, Case], clock: Clock = time.monotonic) -> None:
        self._clock = clock
        self._planned = {case_id: planned_seconds(case) for case_id, case in cases.items()}
        self._ahead = dict(self._planned)
        self.count = len(cases)
        self._planned_done = 0.0
        self._taken = 0.0

    @property
    def number(self) -> int:
        """How many cases have begun."""
        return self.count - len(self._ahead)

    def begin(self, case: Case) -> CasePace:
        """Begin a case; its pace knows how the plan fared so far on this machine."""
        self._ahead.pop(case.case_id, None)
        return CasePace(case.cycles, self._factor * planned_seconds(case), self._clock)

    def end(self, case: Case, pace: CasePace) -> None:
        """Take note of what a case that came to its end has taken."""
        self._planned_done += planned_seconds(case)
        self._taken += pace.seconds

    def seconds_left(self, pace: CasePace) -> float:
        """Time until the last case ends, s, while the one with this pace runs."""
        return pace.seconds_left + self._factor * sum(self._ahead.values())

    @property
    def _factor(self) -> float:
        return self._taken / self._planned_done if self._planned_done else 1.0


def planned_seconds(case: Case) -> float:
    """What a case takes by its plan once Python has started, s."""
    return estimate(case).seconds - SECONDS_TO_START


def clock_time(seconds: float) -> str:
    """Write a time as minutes and seconds, with hours or days where there are any."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    days, hours = divmod(hours, 24)
    if days:
        return f"{days} d {hours}:{minutes:02d}:{rest:02d}"
    return f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes}:{rest:02d}"
