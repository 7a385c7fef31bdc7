"""How far results are from those of infinitely narrow cells and short steps: estimates.

A run and its twin on k times wider cells, to k² times the tolerance, differ by k − 1 times the
error of the run if errors grow with the width of a cell, and by √(k² + 1) times its standard
deviation if they follow from where edges happen to fall in cells. √(k² − 1) lies between.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

# Standard deviations in an estimate, on half of the cases of the page of verification.
_DEVIATIONS = 2.0
# Values below this part of the largest have just begun, and say nothing of the others.
_TRACE = 0.01
# Words in the names of what follows from the place of the edges of contact and stick. These lie
# somewhere in a cell, so that one of the scalars is the same in both runs now and then, and stays
# so for a whole elastic run, or jumps by a row of asperities: the upper quartile of all of them
# says how well the edges are known.
_OF_EDGES = ("area", "half_width", "stick")


def estimated_errors(
    rows: Sequence[Mapping[str, float]], coarser: Sequence[Mapping[str, float]], times: float
) -> dict[str, NDArray[np.float64]]:
    """Estimated errors of some scalars at the snapshots of a run, in the units of the scalars.

    What two runs differ by at one snapshot may be small by chance: what they differ by in the
    median snapshot, relative to the value, counts if it is more. It is that of the logarithms, so
    that a hard snapshot beside an easy one does not count for both.

    Parameters
    ----------
    rows, coarser
        The scalars by name at each snapshot: of the run, and of its twin.
    times
        How many times wider the cells of the twin are.
    """
    apart, sizes, usual = {}, {}, {}
    for name in rows[0]:
        values, others = (np.array([row[name] for row in each]) for each in (rows, coarser))
        apart[name] = np.abs(values - others)
        sizes[name] = np.maximum(np.abs(values), np.abs(others))
        counts = np.abs(values) > _TRACE * np.abs(values).max()
        differs = counts & (apart[name] > 0)
        logarithms = np.log(apart[name][differs] / sizes[name][differs])
        usual[name] = float(np.exp(np.median(logarithms))) if differs.any() else 0.0
    of_edges = [name for name in usual if any(word in name for word in _OF_EDGES)]
    known = float(np.percentile([usual[name] for name in of_edges] or [0.0], 75.0))
    usual.update((name, max(usual[name], known)) for name in of_edges)
    part = _DEVIATIONS / math.sqrt(times**2 - 1.0)
    return {name: part * np.maximum(apart[name], usual[name] * sizes[name]) for name in apart}
