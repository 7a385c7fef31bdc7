"""Resources of a study: memory, cores, time, and its division into jobs.

Nothing heavy is imported before it is needed: `fretwear plan` and the Snakefile ask this.
"""

from __future__ import annotations

import math
import os
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from fretwear.plugins import plugins
from fretwear.study.case import Case
from fretwear.study.plan import SECONDS_TO_START, Estimate, Plan, estimate
from fretwear.study.problems import few_of
from fretwear.units import size_text

# Estimates exceed actual use by up to a quarter; within that a case may still fit.
_CERTAIN = 1.25

# A job of many small cases takes at most this time, s, and at least what makes its start, and the
# queue of a cluster, worth while; between these a study has about a number of jobs.
_LONGEST_JOB, _SHORTEST_JOB, _JOBS = 180.0, 10.0, 64

# Processor seconds of the workflow besides its jobs: Snakemake, merging, figures and report.
SECONDS_OF_SNAKEMAKE = 3.0
SECONDS_OF_MERGING = 3.0
SECONDS_PER_BYTE_MERGED = 5e-9
SECONDS_OF_FIGURES = 9.0
SECONDS_PER_CASE_DRAWN = 0.12
MOST_CASES_DRAWN = 200
SECONDS_OF_REPORT = 3.3
SECONDS_PER_CASE_REPORTED = 0.002

# Time of a forward and inverse transform on the machine on which the constants of
# `fretwear.study.plan` were measured, as `python -m benchmarks.cost --speed` prints it.
SECONDS_PER_TRANSFORM = 2.8e-4
_CELLS_TIMED, _SECONDS_TIMED, _LEAST_REPETITIONS = 128, 0.1, 20

_LISTED = 3


def available_memory(
    proc: Path = Path("/proc"), control_groups: Path = Path("/sys/fs/cgroup")
) -> int:
    """Return the memory, bytes, that this process can still allocate.

    It is the minimum of the memory available on the machine, swap space included, and the remainder
    of every Linux control group (version 2) of the process (container or cluster job).
    """
    import psutil

    machine = sys.maxsize
    # If unknown, the memory counts as large enough.
    with suppress(OSError):
        machine = psutil.virtual_memory().available + psutil.swap_memory().free
    return max(0, min([machine, *_left_to_control_groups(proc, control_groups)]))


def _left_to_control_groups(proc: Path, control_groups: Path) -> Iterator[int]:
    """The memory left to each group of version 2 that holds this process, with its file cache."""
    for line in _text(proc / "self/cgroup").splitlines():
        _, controllers, group_path = line.split(":", 2)
        if controllers:
            continue
        # In a container only the outermost folder may be visible, the group of the process then.
        inner = control_groups / group_path.lstrip("/")
        for group in (inner, *inner.parents[: len(inner.parts) - len(control_groups.parts)]):
            # The limit is "max" where there is none.
            with suppress(ValueError):
                left = int(_text(group / "memory.max")) - int(_text(group / "memory.current"))
                rows = (row.split() for row in _text(group / "memory.stat").splitlines())
                yield left + sum(int(row[1]) for row in rows if row[:1] == ["inactive_file"])


def _text(path: Path) -> str:
    with suppress(OSError):
        return path.read_text(encoding="utf-8")
    return ""


def why_too_large(expected: Estimate, available: int) -> str:
    """Return why a case certainly does not fit in the memory, bytes; empty if it may."""
    if expected.memory_bytes <= _CERTAIN * available:
        return ""
    return (
        f"needs about {size_text(expected.memory_bytes)} of memory for {expected.snapshots} "
        f"snapshots of {expected.cells_x} x {expected.cells_y} cells, but {size_text(available)} "
        "are available: choose a coarser cell or fewer output.cycles"
    )


def require_memory(case: Case) -> None:
    """Raise a `MemoryError` if a case cannot fit in the memory."""
    if problem := why_too_large(estimate(case), available_memory()):
        raise MemoryError(f"case {case.case_id} {problem}")


def cores() -> int:
    """Return the number of cores that this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not on Linux
        return os.cpu_count() or 1


@dataclass(frozen=True)
class Job:
    """Cases that one job of the workflow runs, one after the other."""

    case_ids: tuple[str, ...]
    seconds: float  # time for all cases on one core, the start of the job included
    memory_bytes: int  # memory of the largest case


def grouped(plan: Plan) -> list[Job]:
    """Divide the cases of a study, in order, into jobs.

    The same study gives the same jobs on every machine, so that a cluster node agrees with the
    machine that sent the job.
    """
    alone = {n: cost.seconds - SECONDS_TO_START for n, cost in plan.estimates.items()}
    longest = min(max(math.fsum(alone.values()) / _JOBS, _SHORTEST_JOB), _LONGEST_JOB)
    groups, most = list[list[str]](), plan.study.batch
    for case_id in alone:
        last = groups[-1] if groups else []
        is_full = math.fsum(alone[n] for n in last) + 0.5 * alone[case_id] > longest
        if not last or (is_full if most is None else len(last) == most):
            groups.append([])
        groups[-1].append(case_id)
    return [
        Job(
            tuple(group),
            SECONDS_TO_START + math.fsum(alone[n] for n in group),
            max(plan.estimates[n].memory_bytes for n in group),
        )
        for group in groups
    ]


def seconds_after(plan: Plan) -> float:
    """Return the time, s, to merge a study, draw its figures and write its report.

    Entry points of the group ``fretwear.plans`` tell what figures and sections added to it take.
    """
    cases = len(plan.estimates)
    # Beside more cases than are drawn, what is added to their figures is a small part.
    some = [case for point in plan.points[:MOST_CASES_DRAWN] if (case := point.case)]
    added = math.fsum(entry.load()(some) for entry in plugins("fretwear.plans").values())
    drawn = SECONDS_PER_CASE_DRAWN * min(cases, MOST_CASES_DRAWN)
    merging = SECONDS_OF_MERGING + SECONDS_PER_BYTE_MERGED * plan.file_bytes
    reporting = SECONDS_OF_REPORT + SECONDS_PER_CASE_REPORTED * cases
    return merging + SECONDS_OF_FIGURES + drawn + reporting + added


def study_seconds(plan: Plan, at_once: int = 1, speed: float = 1.0) -> float:
    """Return the time, s, of the workflow of a study on so many cores of a machine of given speed.

    Its jobs run at once, none shorter than its longest; merging, figures and report follow.
    """
    jobs = [job.seconds for job in grouped(plan)]
    simulating = max(math.fsum(jobs) / at_once, *jobs)
    return (SECONDS_OF_SNAKEMAKE + simulating + seconds_after(plan)) / speed


def machine_speed() -> float:
    """Return the speed of this machine relative to the one on which the cost model was calibrated.

    Most of a run is spent in Fourier transforms, so these are timed.
    """
    return SECONDS_PER_TRANSFORM / transform_seconds()


def transform_seconds() -> float:
    """Return the time, s, of a forward and inverse transform of a padded window.

    The shortest of many repetitions counts, which other work on the machine disturbs least. The
    window fits into the cache of a core: transforms of larger ones take up to twice as long while
    others use the memory, runs hardly longer.
    """
    # By numpy, which the library of units imports anyway: importing scipy's takes 0.2 s more.
    import numpy as np

    window = np.zeros((_CELLS_TIMED, 2 * _CELLS_TIMED))
    window[: _CELLS_TIMED // 2] = 1.0
    taken: list[float] = []
    while len(taken) < _LEAST_REPETITIONS or math.fsum(taken) < _SECONDS_TIMED:
        started = time.perf_counter()
        np.fft.irfft2(np.fft.rfft2(window), s=window.shape)
        taken.append(time.perf_counter() - started)
    return min(taken)


def machine_warnings(plan: Plan, available: int | None = None) -> Iterator[str]:
    """Iterate over likely problems of a study on this machine.

    The memory, bytes, defaults to what is available now.
    """
    yield from plan.study.remarks
    available = available_memory() if available is None else available
    reasons = (
        (name, why_too_large(expected, available)) for name, expected in plan.estimates.items()
    )
    if too_large := [f"{case_id} {problem}" for case_id, problem in reasons if problem]:
        yield (
            f"{_cases(too_large)} will not fit in the memory of this machine:{_listed(too_large)}"
        )
    elif plan.memory_bytes * min(cores(), len(grouped(plan))) > available:
        yield (
            f"jobs of up to {size_text(plan.memory_bytes)} may not fit in the "
            f"{size_text(available)} of memory available, {cores()} at once\n    to run fewer at "
            f"once, start snakemake with --resources mem_mb={available // 1_000_000}"
        )
    for what, numbers in plan.warnings.items():
        listed = [f"{case_id}: {detail}" for case_id, detail in numbers.items()]
        yield f"in {_cases(listed)} the contact {what}:{_listed(listed)}"


def _cases(lines: Sequence[str]) -> str:
    return f"{len(lines)} case{'s' * (len(lines) != 1)}"


def _listed(lines: Sequence[str]) -> str:
    return "".join(f"\n    {line}" for line in few_of(lines, _LISTED))
