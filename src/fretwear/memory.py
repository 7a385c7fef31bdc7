"""Whether a case fits in the memory: found out before anything is computed.

No numpy here: `fretwear plan` asks this of every case.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from fretwear.study.case import Case
from fretwear.study.cost import Estimate, estimate
from fretwear.study.plan import size

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
