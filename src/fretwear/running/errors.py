"""How far results are from those of infinitely narrow cells and short steps: estimates.

A run and its twin on cells twice as wide, to four times the tolerance, differ by as much as the run
itself is off, if errors grow with the width of a cell, and by more if they grow faster.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

# Beyond what two runs differ by, on half of the cases of the page of verification.
_SAFETY = 1.2
# Words in the names of what follows from the place of the edges of contact and stick. These lie
# somewhere in a cell, so that one of the scalars is the same in both runs now and then, and stays
# so for a whole elastic run, or jumps by a row of asperities: the median of all of them says how
# well the edges are known.
_OF_EDGES = ("area", "half_width", "stick")


def estimated_errors(
    rows: Sequence[Mapping[str, float]], coarser: Sequence[Mapping[str, float]]
) -> dict[str, NDArray[np.float64]]:
    """Estimated errors of some scalars at the snapshots of a run, in the units of the scalars.

    What two runs differ by at one snapshot may be small by chance: what they differ by as a rule,
    relative to the value, counts if it is more.

    Parameters
    ----------
    rows, coarser
        The scalars by name at each snapshot: of the run, and of its twin.
    """
    apart, sizes, usual = {}, {}, {}
    for name in rows[0]:
        values, others = (np.array([row[name] for row in each]) for each in (rows, coarser))
        apart[name] = np.abs(values - others)
        sizes[name] = size = np.maximum(np.abs(values), np.abs(others))
        relative = np.divide(apart[name], size, out=np.zeros(size.shape), where=size > 0)
        usual[name] = float(np.sqrt(np.mean(np.square(relative))))
    of_edges = [name for name in usual if any(word in name for word in _OF_EDGES)]
    known = float(np.median([usual[name] for name in of_edges] or [0.0]))
    usual.update((name, max(usual[name], known)) for name in of_edges)
    return {name: _SAFETY * np.maximum(apart[name], usual[name] * sizes[name]) for name in apart}
