"""Preconditioner of the linear problem of the free cells.

The problem is (K + diag c) p = r on the free cells: the half-space and the tangent c of a layer.
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

from fretwear.mechanics.arrays import Array, Mask
from fretwear.mechanics.halfspace import HalfSpace

_SOFT = 0.3
_STIFFENING = 3.0
_TURN = 2.0
_MARGIN = 4


@dataclass(frozen=True)
class _Part:
    """The bodies with a uniform layer, the cells they are given on, and the share of each."""

    cells: tuple[slice, slice]
    weight: Array
    invert: Callable[[Array], Array]

    def on(self, free: Mask) -> _Part:
        """The part without the cells that are not free."""
        return _Part(self.cells, self.weight * free[self.cells], self.invert)

    def __call__(self, residual: Array) -> Array:
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
        c, m/Pa, shape of the window; None without a layer.
    free
        The free cells, or nearly: by their tangents the uniform layers are chosen.
    """

    def __init__(self, half_space: HalfSpace, tangent: Array | None, free: Mask) -> None:
        self._whole, self._inner = _parts(half_space, tangent, free)

    def on(self, free: Mask) -> Callable[[Array], Array]:
        """The inverse on some free cells: symmetric, positive definite there.

        Returns
        -------
        A function from a residual gap, m, to a pressure, Pa, zero on all other cells.
        """
        whole = self._whole.on(free)
        return whole if self._inner is None else partial(_sum, whole, self._inner.on(free))


def _sum(whole: _Part, inner: _Part, residual: Array) -> Array:
    result = whole(residual)
    result[inner.cells] += inner(residual)
    return result


def _parts(half_space: HalfSpace, tangent: Array | None, free: Mask) -> tuple[_Part, _Part | None]:
    """A part on the whole window, and one on the inner cells if they differ much."""
    own, shape = half_space.self_influence, half_space.window.shape
    everywhere = (slice(None), slice(None))
    if tangent is None or not free.any():
        return _Part(everywhere, np.ones(shape), half_space.inverse()), None
    tangents = tangent[free]
    mean = float(tangents.mean())
    if mean < _SOFT * own:
        # Harder than the half-space nearly everywhere: one layer scaled to each cell's own.
        uniform = float(1.0 / np.mean(1.0 / (tangents + own))) - own
        weight = np.sqrt((_STIFFENING * own + uniform) / (_STIFFENING * own + tangent))
        return _Part(everywhere, weight, half_space.inverse(uniform)), None
    share = tangent / (tangent + _TURN * own)
    share *= (mean + _TURN * own) / mean
    np.minimum(share, 1.0, out=share)
    inner = half_space.part(half_space.window.holding(share < 1.0, _MARGIN))
    cells = half_space.window.part(inner.window.shape)
    hard = _Part(cells, np.sqrt(1.0 - share[cells]), inner.inverse())
    share *= np.minimum((mean + own) / (tangent + own), 1.0)
    return _Part(everywhere, np.sqrt(share, out=share), half_space.inverse(mean)), hard
