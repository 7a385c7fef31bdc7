"""The linear problem of the free cells, in single precision.

Find a pressure s on the free cells, zero on all others and in sum, and a number α with

    (K + diag c) s = r − α   on the free cells.

All is relative: displacements to some unit, K and the tangent c of a layer to the influence of a
cell on itself. What rounding leaves, the caller sees in the next residual.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

import numpy as np

from fretwear.mechanics import passes
from fretwear.mechanics.arrays import Array, Mask, Single
from fretwear.mechanics.convolution import Convolution
from fretwear.mechanics.preconditioner import Preconditioner

_LARGEST_ITERATIONS = 40


@dataclass(frozen=True)
class Step:
    """An approximate solution.

    Attributes
    ----------
    pressure, displacement
        s and K s, shape of the window.
    largest
        Largest magnitude of the displacement.
    missed
        Sum of s, zero but for rounding.
    iterations
        Conjugate-gradient steps, each with one convolution.
    """

    pressure: Single
    displacement: Single
    largest: float
    missed: float
    iterations: int


class FreeCells:
    """A set of free cells.

    Parameters
    ----------
    convolve
        K.
    preconditioner
        Of K + diag c: M, an approximate inverse on the free cells.
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
        preconditioner: Preconditioner,
        free: Mask,
    ) -> None:
        self._convolve = convolve
        self._inside = free.astype(np.float32)
        self._precondition = preconditioner.on(self._inside)
        self._count = np.count_nonzero(free)
        self.uniform, self.uniform_sum = self._precondition(self._inside)

    def solve(
        self, residual: Array, unit: float, tangent: Single | None, reduction: float, enough: float
    ) -> Step:
        """Preconditioned conjugate gradients.

        Directions of zero sum keep the load: with z₁ = M 1, the residual loses the uniform part
        ∑ z₁r / ∑ z₁ before M is applied, and α is the sum of such parts.

        Parameters
        ----------
        residual, unit
            r, and in what unit; what it is on other cells does not count.
        tangent
            c, or None without a layer.
        reduction, enough
            The root mean square of the residual is to become so many times smaller, or so small.
        """
        start = passes.relative(residual, unit, self._inside)
        left, pressure = start.copy(), np.zeros_like(start)
        direction: Single | None = None
        alpha = target = energy = 0.0
        uniform = passes.inner(self.uniform, left)
        iterations = 0
        while True:
            shift = uniform / self.uniform_sum
            alpha += shift
            spread = sqrt(passes.lower(shift, self._inside, left) / self._count)
            if iterations == 0:
                target = max(reduction * spread, enough)
            elif spread <= target or iterations == _LARGEST_ITERATIONS:
                break
            previous = energy
            z, energy = self._precondition(left)
            if not energy > 0:
                break
            if direction is None:
                direction = z
            else:
                passes.turn(energy / previous, z, direction)
            force = self._convolve(direction)
            iterations += 1
            length = energy / passes.respond(tangent, direction, force)
            uniform = passes.follow(length, direction, force, self.uniform, pressure, left)
        # What is left on other cells tells how far the step moves the surface there.
        largest = passes.settle(start, tangent, pressure, alpha, left)
        return Step(pressure, left, largest, passes.total(pressure), iterations)
