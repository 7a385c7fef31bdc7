"""Batches: which points of a study one job takes, so that starting it costs little."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

SECONDS_PER_JOB = 180.0
"""What a job is to take: starting it, or queueing it on a cluster, costs seconds."""

LEAST_JOBS = 16
"""Into so many jobs a study falls, however little there is to do: they keep the cores busy."""

JOBS_FOR_MANY_CORES = 64
SECONDS_WORTH_A_JOB = 10.0
"""Up to so many jobs are made of a small study, where each has more to do than to start."""

MOST_JOBS = 2000
"""A workflow of so many jobs is planned in seconds; beyond, the jobs take longer instead."""


@dataclass(frozen=True)
class Task:
    """A case to run, at the first point that comes to it.

    Attributes
    ----------
    point : int
        Number of the point, counted from 1.
    case_id : str
        Id of the case.
    seconds : float
        How long it takes once its job has started, as far as the study alone can tell.
    memory_bytes : int
        Memory that it needs.
    """

    point: int
    case_id: str
    seconds: float
    memory_bytes: int


@dataclass(frozen=True)
class Batch:
    """Cases of neighbouring points that one job runs one after the other.

    Attributes
    ----------
    tasks : tuple of Task
        At least one, in the order of the points.
    """

    tasks: tuple[Task, ...]

    @property
    def first(self) -> int:
        """Number of the first point."""
        return self.tasks[0].point

    @property
    def last(self) -> int:
        """Number of the last point; points between the two may belong to cases of others."""
        return self.tasks[-1].point

    @property
    def case_ids(self) -> tuple[str, ...]:
        """Ids of the cases."""
        return tuple(task.case_id for task in self.tasks)

    @property
    def seconds(self) -> float:
        """Time for all cases on one core, once the job has started."""
        return math.fsum(task.seconds for task in self.tasks)

    @property
    def memory_bytes(self) -> int:
        """Memory of the largest case."""
        return max(task.memory_bytes for task in self.tasks)


def batches(tasks: Iterable[Task], cases_each: int | None = None) -> tuple[Batch, ...]:
    """Divide the cases of a study into batches, in the order of its points.

    The same study falls into the same batches on every machine: what a cluster node reads is
    what the machine that sent the job has read.

    Parameters
    ----------
    tasks : iterable of Task
        Every case once.
    cases_each : int or None
        Cases of a batch; None: as many as take about `SECONDS_PER_JOB`, but never so many that
        most cores would have nothing to do.
    """
    listed = list(tasks)
    parts = _even_parts(listed) if cases_each is None else _equal_parts(listed, cases_each)
    return tuple(Batch(tuple(part)) for part in parts)


def _equal_parts(tasks: list[Task], cases_each: int) -> Iterator[list[Task]]:
    for start in range(0, len(tasks), cases_each):
        yield tasks[start : start + cases_each]


def _even_parts(tasks: list[Task]) -> Iterator[list[Task]]:
    total = math.fsum(task.seconds for task in tasks)
    goal = total / _jobs(len(tasks), total)
    before, number = 0.0, 0
    part: list[Task] = []
    for task in tasks:
        # Where the middle of a case falls decides, so that no batch is the one with the rest.
        own = int((before + 0.5 * task.seconds) / goal)
        if part and own > number:
            yield part
            part = []
        number = own
        part.append(task)
        before += task.seconds
    if part:
        yield part


def _jobs(cases: int, seconds: float) -> int:
    least = min(cases, LEAST_JOBS)
    spread = min(cases, JOBS_FOR_MANY_CORES, int(seconds / SECONDS_WORTH_A_JOB))
    wanted = math.ceil(seconds / SECONDS_PER_JOB)
    return min(max(least, spread, wanted), MOST_JOBS)
