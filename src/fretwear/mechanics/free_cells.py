"""The linear problem of the free cells, in single precision.

Find a pressure s on the free cells, zero on all others and in sum, and a number α with

    (K + diag c) s = r − α   on the free cells.

All is relative: displacements to some unit, K and the tangent c of a layer to the influence of a
cell on itself. What rounding leaves, the caller sees in the next residual.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import sqrt

import numpy as np

from fretwear.mechanics.arrays import Mask, Single, inner
from fretwear.mechanics.convolution import Convolution

_LARGEST_ITERATIONS = 40


@dataclass(frozen=True)
class Step:
    """An approximate solution.

    Attributes
    ----------
    pressure, displacement
        s and K s, shape of the window.
    missed
        Sum of s, zero but for rounding.
    iterations
        Conjugate-gradient steps, each with one convolution.
    """

    pressure: Single
    displacement: Single
    missed: float
    iterations: int


class FreeCells:
    """A set of free cells.

    Parameters
    ----------
    convolve
        K.
    precondition
        M, an approximate inverse of K + diag c on the free cells.
    free
        The set.

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
        precondition: Callable[[Single], Single],
        free: Mask,
    ) -> None:
        self._convolve = convolve
        self._precondition = precondition
        self._inside = free.astype(np.float32)
        self._count = np.count_nonzero(free)
        self.uniform = precondition(self._inside)
        self.uniform_sum = float(self.uniform.sum(dtype=np.float64))

    def solve(
        self, residual: Single, tangent: Single | None, reduction: float, enough: float
    ) -> Step:
        """Preconditioned conjugate gradients.

        Directions of zero sum keep the load: with z₁ = M 1, the residual loses the uniform part
        ∑ z₁r / ∑ z₁ before M is applied, and α is the sum of such parts.

        Parameters
        ----------
        residual
            r; what it is on other cells does not count.
        tangent
            c, or None without a layer.
        reduction, enough
            The root mean square of the residual is to become so many times smaller, or so small.
        """
        residual = residual * self._inside
        start, work = residual.copy(), np.empty_like(residual)
        pressure = np.zeros_like(residual)
        direction: Single | None = None
        alpha = target = energy = 0.0
        iterations = 0
        while True:
            shift = inner(self.uniform, residual) / self.uniform_sum
            residual -= shift
            alpha += shift
            np.multiply(residual, self._inside, out=work)
            spread = sqrt(inner(work, residual) / self._count)
            if iterations == 0:
                target = max(reduction * spread, enough)
            elif spread <= target or iterations == _LARGEST_ITERATIONS:
                break
            z = self._precondition(residual)
            previous, energy = energy, inner(residual, z)
            if not energy > 0:
                break
            if direction is None:
                direction = z
            else:
                direction *= energy / previous
                direction += z
            force = self._convolve(direction)
            iterations += 1
            if tangent is not None:
                force += np.multiply(tangent, direction, out=work)
            length = energy / inner(direction, force)
            pressure += np.multiply(direction, length, out=work)
            force *= length
            residual -= force
        # The residual on other cells tells how far the step moves the surface there.
        displacement = np.subtract(start, residual, out=residual)
        displacement -= alpha
        if tangent is not None:
            displacement -= np.multiply(tangent, pressure, out=work)
        return Step(pressure, displacement, float(pressure.sum(dtype=np.float64)), iterations)
