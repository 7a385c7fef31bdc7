"""The active-set method of the normal contact.

Cells are free (0 < p < p_lim), open (p = 0) or saturated (p = p_lim). The method solves the linear
problem of the free cells by a few preconditioned conjugate-gradient steps, projects the result
onto the bounds, searches the segment to it for the least energy, and moves cells between the
sets. Along a segment K p is linear, so the search costs no convolution. Energy falls at every
step, hence no set of cells repeats.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from fretwear.mechanics.arrays import Array, Mask, inner
from fretwear.mechanics.contact_problem import ContactProblem
from fretwear.mechanics.preconditioner import Preconditioner

_LARGEST_OUTER = 60
_LARGEST_INNER = 40
_UNSETTLED = 0.5
_SETTLED = 0.1
_FEW = 0.02
_ENOUGH = 0.1
# Where the worst cell does not come closer, the mean of the others has hidden it: solve better.
_STALLED = 0.95
_MORE_CARE = 0.1


class ActiveSet:
    """A feasible pressure, its displacement and the sets, on the way to the solution.

    Parameters
    ----------
    problem
        What to solve.
    start
        A first guess of the pressure, Pa, of any load.
    """

    _known_tangent: Array | None

    def __init__(self, problem: ContactProblem, start: Array) -> None:
        self.problem = problem
        self.iterations = 0
        self.convolutions = 0
        self.restart(start)

    def restart(self, start: Array) -> None:
        """Take a pressure as the current one, scaled to the load and cut to the bounds."""
        self._set(carrying(start, self.problem.limit, self.problem.total))
        self._refresh()
        self._care = 1.0
        self._solved: Mask = ~self.free
        self._preconditioner = Preconditioner(self.problem.half_space, self._tangent(), self.free)

    def _tangent(self) -> Array | None:
        """Tangent of the layer at the pressure, which is asked for twice before the first step."""
        layer = self.problem.layer
        if layer is not None and self._known_tangent is None:
            self._known_tangent = layer.tangent(self.pressure)
        return self._known_tangent

    def solve(self, tolerance: float) -> bool:
        """Iterate until the residual is below the tolerance; whether it got there."""
        before = np.inf
        for _ in range(_LARGEST_OUTER):
            self._evaluate()
            error = self.residual()
            if not np.isfinite(error):
                return False
            if error > _STALLED * before and np.array_equal(self.free, self._solved):
                self._care *= _MORE_CARE
            before = error
            if error <= tolerance:
                if self.exact:
                    return True
                self._refresh()
                continue
            self._exchange(tolerance)
            if not self._advance(tolerance):
                return False
        return False

    def residual(self) -> float:
        """Largest violation of the gap conditions relative to the largest displacement."""
        free, saturated = self.gap[self.free], self.gap[self.saturated]
        worst = max(
            float(np.abs(free).max(initial=0.0)),
            float(saturated.max(initial=0.0)),
            -float(self.gap[~(self.free | self.saturated)].min(initial=0.0)),
        )
        return worst / self.scale

    def _set(self, pressure: Array) -> None:
        self.pressure = pressure
        self._known_tangent = None
        self.saturated: Mask = pressure >= self.problem.limit
        self.free: Mask = (pressure > 0) & ~self.saturated

    def _refresh(self) -> None:
        """Recompute K p, which is otherwise carried along."""
        self.displacement = self.problem.half_space.displacement(self.pressure)
        self.separation = self.problem.separation(self.pressure, self.displacement)
        self.convolutions += 1
        self.exact = True

    def _evaluate(self) -> None:
        separation = self.separation
        if self.free.any():
            self.approach = float(separation[self.free].mean())
        else:
            # Every loaded cell is saturated: the approach lies between those and the open cells.
            self.approach = float(separation[self.saturated].max())
        self.gap = separation - self.approach
        self.scale = float(self.displacement.max())

    def _exchange(self, tolerance: float) -> None:
        """Free the open cells that interpenetrate and the saturated ones that separate."""
        slack = 0.3 * tolerance * self.scale
        self.free |= ~(self.free | self.saturated) & (self.gap < -slack)
        self.free |= self.saturated & (self.gap > slack)
        self.saturated &= ~self.free

    def _advance(self, tolerance: float) -> bool:
        """One projected Newton step; False when no descent is left."""
        step, displacement = self._newton_step(tolerance)
        target = self.pressure + step
        inside = target[self.free]
        if inside.min(initial=0.0) >= 0 and inside.max(initial=0.0) <= self.problem.limit:
            self._search(step, displacement)
            return True
        for _ in range(8):
            step = carrying(target, self.problem.limit, self.problem.total) - self.pressure
            displacement = self.problem.half_space.displacement(step)
            self.convolutions += 1
            if inner(self.gap, step) < 0:
                self._search(step, displacement)
                return True
            # Clipping turned the direction uphill: a shorter step clips less.
            target = 0.7 * self.pressure + 0.3 * target
        return False

    def _search(self, step: Array, displacement: Array) -> None:
        """Go along a feasible segment: all the way, or to its lowest energy if that overshoots."""
        before = self.pressure, self.displacement
        first = inner(step, self.gap)

        def slope(fraction: float) -> float:
            self.pressure = before[0] + fraction * step
            self.displacement = before[1] + fraction * displacement
            self.separation = self.problem.separation(self.pressure, self.displacement)
            return inner(step, self.separation)

        self.exact = False
        low, high, enough = 0.0, 1.0, 0.1 * abs(first)
        last = slope(1.0)
        if last > enough:
            for _ in range(20):
                fraction = low + (high - low) * max(0.05, min(0.95, first / (first - last)))
                middle = slope(fraction)
                if abs(middle) <= enough:
                    break
                if middle < 0:
                    low, first = fraction, middle
                else:
                    high, last = fraction, middle
        self._set(self.pressure)

    def _newton_step(self, tolerance: float) -> tuple[Array, Array]:
        """Step of the free cells and its displacement by preconditioned conjugate gradients.

        The load is kept by directions of zero sum: with z₁ = M 1, the preconditioned residual
        z becomes z − z₁ (∑z/∑z₁). What is uniform in the residual drops out then, and what it is
        on other cells never counts; there it tells how far the step moves the surface.
        """
        half_space, tangent = self.problem.half_space, self._tangent()
        settled = self._prepare()
        precondition, inside, ones = self._inverse
        count = float(inside.sum())
        ones_sum = float(ones.sum())
        residual = -self.gap
        step, direction = np.zeros_like(residual), np.zeros_like(residual)
        reduction = _SETTLED if settled else _UNSETTLED
        spread = _deviation(residual, inside, count)
        target = max(reduction * spread, _ENOUGH * tolerance * self.scale)
        target *= self._care
        energy = 0.0
        for _ in range(_LARGEST_INNER):
            z = precondition(residual)
            z -= ones * (float(z.sum()) / ones_sum)
            previous, energy = energy, inner(residual, z)
            if not energy > 0:
                break
            if previous > 0:
                direction *= energy / previous
            direction += z
            force = half_space.displacement(direction)
            self.convolutions += 1
            self.iterations += 1
            if tangent is not None:
                force += tangent * direction
            length = energy / inner(direction, force)
            step += length * direction
            force *= length
            residual -= force
            if _deviation(residual, inside, count) <= target:
                break
        residual += self.gap
        moved = np.negative(residual, out=residual)
        if tangent is not None:
            moved -= tangent * step
        return step, moved

    def _prepare(self) -> bool:
        """Invert on the free cells; whether they are nearly those of the step before.

        While many cells still change sides it does not pay to solve for them exactly.
        """
        before, self._solved = self._solved, self.free.copy()
        changed = np.count_nonzero(before != self.free)
        if changed:
            precondition = self._preconditioner.on(self.free)
            inside = self.free.astype(np.float64)
            self._inverse = precondition, inside, precondition(inside)
        return bool(changed <= _FEW * np.count_nonzero(self.free))


def _deviation(field: Array, inside: Array, count: float) -> float:
    """Standard deviation of a field over the cells inside, so many."""
    part = field * inside
    mean = float(part.sum()) / count
    return sqrt(max(inner(part, part) / count - mean * mean, 0.0))


def carrying(pressure: Array, limit: float, total: float) -> Array:
    """The pressure cut to the bounds, its free cells scaled so that its sum is ``total``, Pa.

    Scaling leaves open cells open and saturated cells saturated; a shift would free them.
    """
    result = np.clip(pressure, 0.0, limit)
    for _ in range(100):
        free = (result > 0) & (result < limit)
        missing = total - float(result.sum())
        if abs(missing) <= 1e-14 * total:
            break
        movable = free if (missing > 0 or result[free].sum() > -missing) else result > 0
        if not movable.any():
            # All loaded cells are at the limit and still do not carry the load.
            result[result == 0] = 1e-3 * limit
            continue
        result[movable] *= 1.0 + missing / float(result[movable].sum())
        np.minimum(result, limit, out=result)
    return result
