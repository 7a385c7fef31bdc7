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
from dataclasses import dataclass, replace

import numpy as np

from fretwear.mechanics import passes
from fretwear.mechanics.arrays import Mask, Single
from fretwear.mechanics.halfspace import HalfSpace

_SOFT = 0.3
_STIFFENING = 3.0
_TURN = 2.0
_MARGIN = 4


@dataclass(frozen=True)
class _Part:
    """The bodies with a uniform layer, the first of the cells they are given on, their shares."""

    corner: tuple[int, int]
    weight: Single
    invert: Callable[[Single], Single]

    def on(self, inside: Single) -> _Part:
        """The part without the cells where ``inside`` is 0."""
        return replace(self, weight=passes.weighed(self.weight, self.corner, inside))

    def pressure(self, residual: Single) -> Single:
        """What the bodies carry for a residual, before each cell takes its share."""
        return self.invert(passes.weighed(self.weight, self.corner, residual))


@dataclass(frozen=True)
class Inverse:
    """An approximate inverse of K + diag c: symmetric, positive definite on the free cells."""

    whole: _Part
    inner: _Part | None

    def __call__(self, residual: Single) -> tuple[Single, float]:
        """The pressure for a residual gap, zero on all other cells; their inner product."""
        pressure, inner = self.whole.pressure(residual), self.inner
        if inner is None:
            return pressure, passes.blend(self.whole.weight, None, None, (0, 0), residual, pressure)
        added, corner = inner.pressure(residual), inner.corner
        return pressure, passes.blend(
            self.whole.weight, inner.weight, added, corner, residual, pressure
        )


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

    def on(self, inside: Single) -> Inverse:
        """The inverse on the free cells, where ``inside`` is 1; elsewhere it is 0."""
        return Inverse(self._whole.on(inside), self._inner and self._inner.on(inside))


def _parts(half_space: HalfSpace, tangent: Single | None, free: Mask) -> tuple[_Part, _Part | None]:
    """A part on the whole window, and one on the inner cells if they differ much."""
    invert, inside = half_space.single.inverse, free.astype(np.float32)
    count = int(np.count_nonzero(free))
    if tangent is None or not count:
        return _Part((0, 0), np.ones_like(inside), invert()), None
    mean = passes.inner(tangent, inside) / count
    if mean < _SOFT:
        # Harder than the half-space nearly everywhere: one layer scaled to each cell's own.
        uniform = count / passes.inner(1.0 / (tangent + 1.0), inside) - 1.0
        weight = np.sqrt((_STIFFENING + uniform) / (_STIFFENING + tangent))
        return _Part((0, 0), weight, invert(max(uniform, 0.0))), None
    soft, hard = passes.shares(tangent, mean, _TURN)
    inner = half_space.part(half_space.window.holding(hard > 0, _MARGIN))
    rows, columns = half_space.window.part(inner.window.shape)
    hard = np.ascontiguousarray(hard[rows, columns])
    corner = (rows.start or 0, columns.start or 0)
    return _Part((0, 0), soft, invert(mean)), _Part(corner, hard, inner.single.inverse())
