"""Resources of a study: memory, cores, time, and its division into jobs.

Heavy libraries are imported only when needed, for `fretwear plan` and the Snakefile.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from fretwear.study.case import Case
from fretwear.study.mistakes import few_of
from fretwear.study.plan import SECONDS_TO_START, Estimate, Plan, estimate
from fretwear.units import size_text

# Estimates exceed actual use by up to a quarter; a case beyond the memory by less may still fit.
_CERTAIN = 1.25

# Longest time of a job of many small cases, s; shortest time that is worth a start and the queue of
# a cluster; between these, the number of jobs of a study.
_LONGEST_JOB, _SHORTEST_JOB, _JOBS = 180.0, 7.0, 64

# Processor seconds of the workflow besides its jobs: Snakemake, merging, figures and report.
SECONDS_AFTER, SECONDS_PER_CASE_DRAWN, SECONDS_PER_CASE_MERGED = 18.0, 0.12, 0.02
MOST_CASES_DRAWN = 200

_LISTED = 3


def available_memory() -> int:
    """Return the memory, bytes, that is available on the machine, swap space included."""
    import psutil

    return int(psutil.virtual_memory().available + psutil.swap_memory().free)


def why_too_large(expected: Estimate, available: int) -> str:
    """Return the reason why a case certainly exceeds the memory, bytes; empty if it may fit."""
    if expected.memory_bytes <= _CERTAIN * available:
        return ""
    return (
        f"needs about {size_text(expected.memory_bytes)} of memory for {expected.cells_x} x "
        f"{expected.cells_y} cells and its snapshots, but {size_text(available)} "
        "are available: choose a coarser cell or fewer output.cycles"
    )


def require_memory(case: Case) -> None:
    """Raise a `MemoryError` if a case cannot fit in the memory."""
    if reason := why_too_large(estimate(case), available_memory()):
        raise MemoryError(f"case {case.case_id} {reason}")


@dataclass(frozen=True)
class Job:
    """Cases that one job of the workflow runs, one after the other."""

    case_ids: tuple[str, ...]
    seconds: float  # time for all cases on one core, the start of the job included
    memory_bytes: int  # memory of the largest case


def grouped(plan: Plan) -> list[Job]:
    """Divide the cases of a study, in order, into jobs.

    The division depends on the study alone, so a cluster node agrees with the machine that sent the
    job.
    """
    alone = {n: cost.seconds - SECONDS_TO_START for n, cost in plan.estimates.items()}
    total = math.fsum(alone.values())
    longest = min(max(total / _JOBS, _SHORTEST_JOB), _LONGEST_JOB)
    # This makes the last job as long as the others.
    longest = total / max(1, math.ceil(total / longest))
    groups, spent = dict[int, list[str]](), 0.0
    for number, (case_id, seconds) in enumerate(alone.items()):
        halfway = (spent + 0.5 * seconds) / longest
        job = int(halfway) if plan.study.batch is None else number // plan.study.batch
        groups.setdefault(job, []).append(case_id)
        spent += seconds
    return [
        Job(
            tuple(group),
            SECONDS_TO_START + math.fsum(alone[n] for n in group),
            max(plan.estimates[n].memory_bytes for n in group),
        )
        for group in groups.values()
    ]


def study_seconds(plan: Plan) -> float:
    """Return the time, s, of all jobs of a study, of merging, figures and report on one core."""
    return math.fsum(job.seconds for job in grouped(plan)) + seconds_after(plan)


def seconds_after(plan: Plan) -> float:
    """Return the time, s, of merging, figures and report of a study on one core."""
    cases = len(plan.estimates)
    drawn = SECONDS_PER_CASE_DRAWN * min(cases, MOST_CASES_DRAWN)
    return SECONDS_AFTER + drawn + SECONDS_PER_CASE_MERGED * cases


def machine_warnings(plan: Plan) -> Iterator[str]:
    """Iterate over likely failures of a study on this machine, in the memory available now."""
    available = available_memory()
    reasons = (
        (name, why_too_large(expected, available)) for name, expected in plan.estimates.items()
    )
    if too_large := [f"{case_id} {reason}" for case_id, reason in reasons if reason]:
        cases = f"{len(too_large)} case{'s' * (len(too_large) != 1)}"
        yield f"{cases} will not fit in the memory of this machine:{_listed(too_large)}"
    for what, numbers in plan.warnings.items():
        listed = [f"{case_id}: {detail}" for case_id, detail in numbers.items()]
        cases = f"{len(listed)} case{'s' * (len(listed) != 1)}"
        yield f"in {cases} the contact {what}:{_listed(listed)}"


def _listed(lines: Sequence[str]) -> str:
    return "".join(f"\n    {line}" for line in few_of(lines, _LISTED))
