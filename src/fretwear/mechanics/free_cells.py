"""The linear problem of the free cells of a grid, in single precision.

Conjugate gradients solve it; what rounding leaves, the caller sees in the next residual.

The preconditioner inverts K + diag c nearly. Where c is uniform, the spectrum of the half-space
does that. The layer of a wear step is not uniform: nothing wears in the stick zone, while in the
slip zone the layer is softer than the half-space under waves of a cell's length and stiffer under
those of the contact's. So two uniform layers are inverted, none and the mean one, and combined in
each cell with weights that depend on its own c: an additive Schwarz method whose parts overlap
(Smith, Bjørstad and Gropp, "Domain Decomposition", Cambridge University Press, 1996).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import sqrt

import numpy as np

from fretwear.mechanics.convolution import Convolution
from fretwear.mechanics.geometry import Array, Index, Mask, Single
from fretwear.mechanics.geometry.grid import GridHalfSpace
from fretwear.mechanics.team import kernels

_LARGEST_ITERATIONS = 40
# Below the first mean tangent a single layer, stiffer by the second for its scaling, does; above,
# shares grow with the tangent around the third.
_SOFT = 0.3
_STIFFENING = 3.0
_HALF_SHARE = 2.0


@dataclass(frozen=True)
class Step:
    """An approximate solution of the problem of `FreeCells`.

    Attributes
    ----------
    pressure, displacement
        s and K s.
    largest
        Largest magnitude of the displacement.
    missed
        Sum of s, zero under a given load but for rounding.
    iterations
        Conjugate-gradient steps, each with one convolution.
    """

    pressure: Single
    displacement: Single
    largest: float
    missed: float
    iterations: int


@dataclass(frozen=True)
class Part:
    """The bodies with a uniform layer, their cells, and the weights of these."""

    cells: Index
    share: Single
    invert: Callable[[Single], Single]


def preconditioner(half_space: GridHalfSpace, tangent: Single | None, free: Mask) -> list[Part]:
    """Approximate inverses of K + diag c: on the whole window, and on inner cells that differ much.

    Parameters
    ----------
    half_space
        The bodies, K.
    tangent
        c in units of the influence of a cell on itself, shape of the window; None without a layer.
    free
        The free cells, approximately; their tangents determine the uniform layers.
    """
    invert, grid, team = half_space.single.inverse, half_space.geometry, half_space.team
    everywhere, inside = grid.where(grid), team.cellwise(np.float32, free, dtype=np.float32)
    count = int(np.count_nonzero(free))
    if tangent is None or not count:
        return [Part(everywhere, np.ones_like(inside), invert())]
    of_tangent = partial(team.cellwise, dtype=np.float32)
    mean = kernels.inner(team, tangent, inside) / count
    if mean < _SOFT:
        # Stiffer than the half-space nearly everywhere: one layer, scaled to each cell's own.
        softness = of_tangent(lambda c: 1.0 / (c + 1.0), tangent)
        uniform = count / kernels.inner(team, softness, inside) - 1.0
        share = of_tangent(lambda c: np.sqrt((_STIFFENING + uniform) / (_STIFFENING + c)), tangent)
        return [Part(everywhere, share, invert(max(uniform, 0.0)))]
    # The square of the layer's share grows with the tangent from none to all at the mean and falls
    # again above; the other one is what lacks to one, none above.
    scale, above = np.float32((mean + _HALF_SHARE) / mean), np.float32(mean) + np.float32(1.0)

    def of_layer(c: Single) -> Single:
        return np.minimum(c / (c + np.float32(_HALF_SHARE)) * scale, 1.0)

    hard = of_tangent(lambda c: np.sqrt(1.0 - of_layer(c)), tangent)
    soft = of_tangent(lambda c: np.sqrt(of_layer(c) * np.minimum(above / (c + 1.0), 1.0)), tangent)
    inner = half_space.around(hard > 0)
    cells = grid.where(inner.geometry)
    hard = np.ascontiguousarray(hard[cells])
    return [Part(everywhere, soft, invert(mean)), Part(cells, hard, inner.single.inverse())]


class FreeCells:
    """The linear problem of some free cells, in units of the self-influence.

    Find a pressure s on the free cells, zero on all others, and a number α with

        (K + diag c) s = r − α   on the free cells,

    of no load in sum, or with α = 0 at a given approach. M is the `preconditioner`.

    Attributes
    ----------
    uniform
        M 1: the pressure under which the free cells sink alike, nearly.
    uniform_sum
        Its sum.
    """

    def __init__(
        self,
        convolve: Convolution[Single],
        parts: list[Part],
        free: Mask,
        *,
        under_load: bool = True,
    ) -> None:
        self._convolve, self._team = convolve, convolve.team
        self._inside = self._team.cellwise(np.float32, free, dtype=np.float32)
        self._count = np.count_nonzero(free)
        # Cells that are not free have no weight.
        self._shares = [
            self._team.cellwise(np.multiply, part.share, self._inside[part.cells], dtype=np.float32)
            for part in parts
        ]
        self._parts = parts
        self.uniform, self.uniform_sum = self.apply_preconditioner(self._inside)
        if not under_load:
            self.uniform, self.uniform_sum = np.zeros_like(self._inside), np.inf

    def apply_preconditioner(self, residual: Single) -> tuple[Single, float]:
        """The pressure for a residual gap, zero on all other cells, and their inner product."""
        energy, sum_of_parts = 0.0, None
        for part, share in zip(self._parts, self._shares, strict=True):
            left, pressure = np.ascontiguousarray(residual[part.cells]), np.empty_like(share)
            kernels.times(self._team, left, share, pressure)
            pressure = part.invert(pressure)
            energy += kernels.weigh(self._team, share, left, pressure)
            if sum_of_parts is None:
                sum_of_parts = pressure
            else:
                sum_of_parts[part.cells] += pressure
        assert sum_of_parts is not None
        return sum_of_parts, energy

    def solve(
        self, residual: Array, unit: float, tangent: Single | None, reduction: float, enough: float
    ) -> Step:
        """Preconditioned conjugate gradients.

        Directions of zero sum keep the load: with z₁ = M 1, the residual loses the uniform part
        ∑ z₁r / ∑ z₁ before M is applied, and α is the sum of such parts.

        Parameters
        ----------
        residual, unit
            r and its unit; its values on other cells are ignored.
        tangent
            c, or None without a layer.
        reduction, enough
            Factor by which to reduce the root mean square of the residual, or a value that
            suffices.
        """
        team = self._team
        start = team.in_single(residual, unit)
        kernels.times(team, start, self._inside, start)
        left, pressure = np.empty_like(start), np.zeros_like(start)
        kernels.times(team, start, self._inside, left)
        direction: Single | None = None
        alpha = target = energy = 0.0
        uniform = kernels.inner(team, self.uniform, left)
        iterations = 0
        while True:
            shift = uniform / self.uniform_sum
            alpha += shift
            spread = sqrt(kernels.project_mean(team, shift, self._inside, left) / self._count)
            if iterations == 0:
                target = max(reduction * spread, enough)
            elif spread <= target or iterations == _LARGEST_ITERATIONS:
                break
            previous = energy
            preconditioned, energy = self.apply_preconditioner(left)
            if not energy > 0:
                break
            if direction is None:
                direction = preconditioned
            else:
                kernels.update_direction(team, energy / previous, preconditioned, direction)
            force = self._convolve(direction)
            iterations += 1
            length = energy / kernels.add_layer(team, tangent, direction, force)
            uniform = kernels.advance(team, length, direction, force, self.uniform, pressure, left)
        # The remainder on other cells is the displacement of the surface there.
        largest = kernels.recover_displacement(team, start, tangent, pressure, alpha, left)
        return Step(pressure, left, largest, kernels.total(team, pressure), iterations)
