"""Times of a job by two clocks."""

import time
from dataclasses import dataclass
from statistics import median


@dataclass
class Spent:
    """Time of a job, s: of the processor in this process, and by the clock on the wall."""

    cpu: float = 0.0
    wall: float = 0.0


class Stopwatch:
    """Both clocks since it was made or read."""

    def __init__(self) -> None:
        self._cpu, self._wall = time.process_time(), time.perf_counter()

    def read(self) -> Spent:
        """Time since the last reading."""
        cpu, wall = time.process_time(), time.perf_counter()
        spent = Spent(cpu - self._cpu, wall - self._wall)
        self._cpu, self._wall = cpu, wall
        return spent


def middle(times: list[Spent]) -> Spent:
    """Median of each clock."""
    return Spent(median(t.cpu for t in times), median(t.wall for t in times))
