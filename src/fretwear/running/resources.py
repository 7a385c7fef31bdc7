"""What a study takes of the machine that it runs on: memory, cores and time."""

from __future__ import annotations

import math
import os
import statistics
import time
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from fretwear.study.case import Case
from fretwear.study.cost import Estimate, estimate
from fretwear.study.plan import Plan, PlannedPoint, size
from fretwear.study.quantities import LENGTH, format_quantity
from fretwear.study.yielding import yielding_ring_width

# Estimates are above what runs take, by up to a quarter: below that a case might still fit.
_CERTAIN = 1.25
_ADVISED = 0.8
_PROC = Path("/proc")
_CONTROL_GROUPS = Path("/sys/fs/cgroup")


@dataclass(frozen=True)
class _Controller:
    """Where a version of Linux control groups keeps limit and use of memory, in bytes."""

    folder: str
    limit: str
    used: str
    reclaimable: str


_VERSION_1 = _Controller(
    "memory", "memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"
)
_VERSION_2 = _Controller("", "memory.max", "memory.current", "inactive_file")


def why_too_large(expected: Estimate, available: int | None) -> str:
    """Say why a case certainly does not fit in the memory; empty where it may.

    Parameters
    ----------
    expected
        What the case is expected to take.
    available
        Memory in bytes, from `available_memory`; None where nobody knows.
    """
    if available is None or expected.memory_bytes <= _CERTAIN * available:
        return ""
    return (
        f"needs about {size(expected.memory_bytes)} of memory for {expected.cells_x} x "
        f"{expected.cells_y} cells, but {size(available)} are available"
    )


def require_memory(case: Case) -> None:
    """Let a case pass that may fit in the memory available now.

    Raises
    ------
    MemoryError
        When it certainly does not, with the estimate, what is available, and a cell that fits.
    """
    available, expected = available_memory(), estimate(case)
    if problem := why_too_large(expected, available):
        assert available is not None
        finer = math.sqrt(expected.memory_bytes / (_ADVISED * available))
        dx, dy = (_rounded_up(1e6 * finer * spacing) for spacing in case.grid_spacing)
        raise MemoryError(
            f"case {case.case_id}: {problem}. Choose a coarser grid, such as "
            f"cell: [{dx:g} um, {dy:g} um], or run the case where there is more memory"
        )


def available_memory(proc: Path = _PROC, control_groups: Path = _CONTROL_GROUPS) -> int | None:
    """Return the memory in bytes that this process can still get; None where nobody knows.

    On Linux the least of what the machine has available, swap space included, and what every
    control group that the process is in (of a container, of a cluster's job) has left. Elsewhere
    the memory that the machine has.

    Parameters
    ----------
    proc, control_groups
        Where Linux tells of processes and control groups.
    """
    amounts = [*_of_machine(proc), *_of_control_groups(proc, control_groups)]
    if not amounts:
        with suppress(OSError, ValueError, AttributeError):
            amounts.append(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    return max(0, min(amounts)) if amounts else None


def _of_machine(proc: Path) -> Iterator[int]:
    numbers = _numbers(proc / "meminfo")
    if "MemAvailable" in numbers:
        yield 1024 * (numbers["MemAvailable"] + numbers.get("SwapFree", 0))


def _of_control_groups(proc: Path, control_groups: Path) -> Iterator[int]:
    for line in _text(proc / "self/cgroup").splitlines():
        _, controllers, own = line.split(":", 2)
        if controllers and "memory" not in controllers.split(","):
            continue
        controller = _VERSION_1 if controllers else _VERSION_2
        root = control_groups / controller.folder
        # Limits of the groups around the own one hold as well; inside of a container none but
        # the outermost folder may be seen, which then is the own group.
        inner = root / own.lstrip("/")
        for group in (inner, *inner.parents[: len(inner.parts) - len(root.parts)]):
            yield from _left(group, controller)


def _left(group: Path, controller: _Controller) -> Iterator[int]:
    # Version 2 says "max" where there is no limit, version 1 gives a number beyond any memory.
    with suppress(ValueError):
        limit, used = (int(_text(group / name)) for name in (controller.limit, controller.used))
        yield limit - used + _numbers(group / "memory.stat").get(controller.reclaimable, 0)


def _numbers(path: Path) -> dict[str, int]:
    """Read lines of a name and a number."""
    fields = (line.replace(":", " ").split() for line in _text(path).splitlines())
    return {each[0]: int(each[1]) for each in fields if len(each) > 1 and each[1].isdigit()}


def _text(path: Path) -> str:
    with suppress(OSError):
        return path.read_text(encoding="utf-8")
    return ""


def _rounded_up(value: float) -> float:
    """Round up to two digits."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return math.ceil(value / unit) * unit


# Processor time of one transform there and back on the machine that the constants of
# `fretwear.study.cost` were measured on: what `python -m benchmarks.cost --speed` prints.
SECONDS_PER_TRANSFORM = 2.0e-5
SECONDS_PER_CELL_AND_TRANSFORM = 2.2e-8

# Smaller windows fit into the fastest memory, which the rest of a run does not; larger ones would
# take long to time, and no longer a cell.
_SIZES = (128, 192, 256, 384, 512)
_SIZES_TIMED = 2
_SECONDS_EACH = 0.03
_LEAST_REPETITIONS = 3
_FREED = 4_000_000


def machine_speed(estimates: Iterable[Estimate]) -> float:
    """Return how fast this machine transforms, 1 being the one of the cost model's constants.

    Most of a run goes into Fourier transforms, so these are timed: for the sizes in which the
    cases spend most of their time, on one thread, in processor time, which other work on the
    machine disturbs less than the clock.

    Parameters
    ----------
    estimates : iterable of Estimate
        What the cases are expected to take.
    """
    spent: defaultdict[int, float] = defaultdict(float)
    for expected in estimates:
        width = math.sqrt(expected.cells)
        spent[min(_SIZES, key=lambda size: abs(math.log(size / width)))] += expected.seconds
    nominal = measured = 0.0
    for timed in sorted(spent, key=lambda size: spent[size])[-_SIZES_TIMED:]:
        usual = SECONDS_PER_TRANSFORM + SECONDS_PER_CELL_AND_TRANSFORM * timed**2
        nominal += spent[timed]
        measured += spent[timed] * transform_seconds(timed, timed) / usual
    return nominal / measured if measured else 1.0


def transform_seconds(cells_x: int, cells_y: int) -> float:
    """Return the processor time in s of one transform of a padded window there and back."""
    # numpy, which the library of units imports anyway: scipy's transforms start in 0.2 s more.
    import numpy as np

    # The C library hands large arrays back to the system at once, whose price is not that of
    # transforms, until an even larger one was freed.
    np.empty(_FREED)
    window = np.zeros((cells_x, 2 * cells_y))
    window[: cells_x // 2] = 1.0
    taken: list[float] = []
    began = time.process_time()
    while len(taken) < _LEAST_REPETITIONS or time.process_time() - began < _SECONDS_EACH:
        started = time.process_time()
        np.fft.irfft2(np.fft.rfft2(window), s=window.shape)
        taken.append(time.process_time() - started)
    return statistics.median(taken)


_LISTED = 3


def cores() -> int:
    """Return how many cores this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not on Linux
        return os.cpu_count() or 1


def warnings(plan: Plan, available: int | None) -> Iterator[str]:
    """Iterate over what is likely to go wrong with a study, each with what to do.

    Parameters
    ----------
    plan : Plan
        The study.
    available : int or None
        Memory of the machine in bytes; None where nobody knows.
    """
    yield from _of_memory(plan, available)
    yield from _of_rings(plan)


def machine_warnings(plan: Plan) -> Iterator[str]:
    """Iterate over the warnings for the machine as it is now."""
    return warnings(plan, available_memory())


def _of_memory(plan: Plan, available: int | None) -> Iterator[str]:
    too_large = [
        f"{case_id} {problem}"
        for case_id, expected in plan.estimates.items()
        if (problem := why_too_large(expected, available))
    ]
    if too_large:
        yield (
            f"{_cases(len(too_large))} will not fit in the memory of this machine:"
            f"{_listed(too_large)}\n    choose a coarser cell, or run the study where there is more"
        )
    elif available is not None and plan.memory_bytes * min(cores(), len(plan.batches)) > available:
        yield (
            f"jobs of up to {size(plan.memory_bytes)} may not fit in the {size(available)} of "
            f"memory that are available, {cores()} at once\n    run snakemake with "
            f"--resources mem_mb={available // 1_000_000}, which lets fewer run at once"
        )


def _of_rings(plan: Plan) -> Iterator[str]:
    unseen = plan.unseen_rings
    if unseen:
        yield (
            f"{_cases(len(unseen))} will yield in a ring around the stick zone that is narrower "
            f"than a cell of the grid, which therefore gets its wear wrong:"
            f"{_listed([_ring(each) for each in unseen])}\n    choose a cell below the width of "
            "the ring where that is practical, or a larger tangential load or a lower plastic limit"
        )


def _ring(planned: PlannedPoint) -> str:
    assert planned.case is not None
    ring, cell = yielding_ring_width(planned.case), max(planned.case.grid_spacing)
    return (
        f"{planned.id}: ring {format_quantity(ring, LENGTH, 3)}, "
        f"cell {format_quantity(cell, LENGTH, 3)}"
    )


def _cases(count: int) -> str:
    return f"{count} case{'s' * (count != 1)}"


def _listed(lines: Sequence[str]) -> str:
    more = len(lines) - _LISTED
    shown = [*lines[:_LISTED], *([f"and {more} more"] if more > 0 else [])]
    return "".join(f"\n    {line}" for line in shown)
