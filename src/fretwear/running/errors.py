"""How far results are from those of infinitely narrow cells and short steps: estimates.

A run and its twin on cells twice as wide, to twice the tolerance, differ by as much as the run
itself is off, if errors grow with the width of a cell, and by more if they grow faster.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

# What two runs differ by at one snapshot may be small by chance: at least this part of what they
# differ by as a rule, relative to the value. `python -m benchmarks.coverage` judges both numbers.
_BY_CHANCE = 0.75
_SAFETY = 1.5


def estimated_errors(
    rows: Sequence[Mapping[str, float]], coarser: Sequence[Mapping[str, float]]
) -> dict[str, NDArray[np.float64]]:
    """Estimated errors of some scalars at the snapshots of a run, in the units of the scalars.

    Parameters
    ----------
    rows, coarser
        The scalars by name at each snapshot: of the run, and of its twin.
    """
    found = {}
    for name in rows[0]:
        values, others = (np.array([row[name] for row in each]) for each in (rows, coarser))
        apart, size = np.abs(values - others), np.maximum(np.abs(values), np.abs(others))
        relative = np.divide(apart, size, out=np.zeros(size.shape), where=size > 0)
        usual = np.sqrt(np.mean(np.square(relative)))
        found[name] = _SAFETY * np.maximum(apart, _BY_CHANCE * usual * size)
    return found
