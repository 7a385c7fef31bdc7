"""What a planned study should be warned of before it is run."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence

from fretwear.memory import available_memory, why_too_large
from fretwear.study.plan import Plan, PlannedPoint, size
from fretwear.study.quantities import LENGTH, format_quantity
from fretwear.study.yielding import yielding_ring_width

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
