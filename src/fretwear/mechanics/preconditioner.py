"""Preconditioner of the linear problem of the free cells.

The problem is (K + diag c) p = r on the free cells: the half-space and the tangent c of a layer,
both in units of the half-space's influence of a cell on itself.
Where c is uniform, the spectrum of the half-space inverts it nearly. The layer of a wear step is
not uniform: nothing wears in the stick zone, while in the slip zone the layer is softer than the
half-space under waves of a cell's length and stiffer under those of the contact's. So two uniform
layers are inverted, none and the mean one, and each cell takes from both in parts that depend on
its own c: an additive Schwarz method whose parts overlap (Smith, Bjørstad and Gropp, "Domain
Decomposition", Cambridge University Press, 1996).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from fretwear.mechanics.arrays import Mask, Single
from fretwear.mechanics.halfspace import HalfSpace

_SOFT = 0.3
_STIFFENING = 3.0
_TURN = 2.0
_MARGIN = 4


@dataclass(frozen=True)
class _Part:
    """The bodies with a uniform layer, the cells they are given on, and the share of each."""

    cells: tuple[slice, slice]
    weight: Single
    invert: Callable[[Single], Single]

    def on(self, free: Mask) -> _Part:
        """The part without the cells that are not free."""
        return _Part(self.cells, self.weight * free[self.cells], self.invert)

    def __call__(self, residual: Single) -> Single:
        pressure = self.invert(self.weight * residual[self.cells])
        pressure *= self.weight
        return pressure


class Preconditioner:
    """Approximate inverses of K + diag c on sets of free cells.

    Parameters
    ----------
    half_space
        The bodies, K.
    tangent
        c in units of the influence of a cell on itself, shape of the window; None without a layer.
    free
        The free cells, or nearly: by their tangents the uniform layers are chosen.
    """

    def __init__(self, half_space: HalfSpace, tangent: Single | None, free: Mask) -> None:
        self._whole, self._inner = _parts(half_space, tangent, free)

    def on(self, free: Mask) -> Callable[[Single], Single]:
        """The inverse on some free cells: symmetric, positive definite there.

        Returns
        -------
        A function from a residual gap to a pressure, zero on all other cells.
        """
        whole = self._whole.on(free)
        return whole if self._inner is None else partial(_sum, whole, self._inner.on(free))


def _sum(whole: _Part, inner: _Part, residual: Single) -> Single:
    result = whole(residual)
    result[inner.cells] += inner(residual)
    return result


def _parts(half_space: HalfSpace, tangent: Single | None, free: Mask) -> tuple[_Part, _Part | None]:
    """A part on the whole window, and one on the inner cells if they differ much."""
    invert, shape = half_space.single.inverse, half_space.window.shape
    everywhere = (slice(None), slice(None))
    if tangent is None or not free.any():
        return _Part(everywhere, np.ones(shape, np.float32), invert()), None
    tangents = tangent[free]
    mean = float(tangents.mean(dtype=np.float64))
    if mean < _SOFT:
        # Harder than the half-space nearly everywhere: one layer scaled to each cell's own.
        uniform = 1.0 / float(np.mean(1.0 / (tangents + 1.0), dtype=np.float64)) - 1.0
        weight = np.sqrt((_STIFFENING + uniform) / (_STIFFENING + tangent))
        return _Part(everywhere, weight, invert(max(uniform, 0.0))), None
    share = tangent / (tangent + _TURN)
    share *= (mean + _TURN) / mean
    np.minimum(share, 1.0, out=share)
    inner = half_space.part(half_space.window.holding(share < 1.0, _MARGIN))
    cells = half_space.window.part(inner.window.shape)
    hard = _Part(cells, np.sqrt(1.0 - share[cells]), inner.single.inverse())
    share *= np.minimum((mean + 1.0) / (tangent + 1.0), 1.0)
    return _Part(everywhere, np.sqrt(share, out=share), invert(mean)), hard
