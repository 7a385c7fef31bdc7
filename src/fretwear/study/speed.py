"""How fast this machine is, measured in a fraction of a second."""

from __future__ import annotations

import math
import statistics
import time
from collections import defaultdict
from collections.abc import Iterable

from fretwear.study.cost import Estimate

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
