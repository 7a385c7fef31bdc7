"""The active-set method of the normal contact.

Cells are free (0 < p < p_lim), open (p = 0) or saturated (p = p_lim). The method solves the linear
problem of the free cells by a few preconditioned conjugate-gradient steps, projects the result
onto the bounds, searches the segment to it for the least energy, and moves cells between the
sets. Along a segment K p is linear, so the search costs no convolution. Energy falls at every
step, hence no set of cells repeats.

The steps are computed in single precision, all else in double: what a step leaves, the next one
sees. So the result is as good as asked for, at two thirds of the time; see Higham,
"Accuracy and Stability of Numerical Algorithms", SIAM (2002), on iterative refinement.
"""

from __future__ import annotations

from math import inf, isfinite

import numpy as np

from fretwear.mechanics.arrays import Array, Mask, Single, inner, largest_magnitude
from fretwear.mechanics.contact_problem import ContactProblem
from fretwear.mechanics.free_cells import FreeCells
from fretwear.mechanics.preconditioner import Preconditioner

_LARGEST_OUTER = 60
# A step reduces the residual of the free cells by so much: the first one from near the solution,
# later ones and one from afar while more than a few cells changed sides, and when they are settled;
# but not below a part of the tolerance.
_NEAR = 0.02
_FIRST = 0.05
_UNSETTLED = 0.5
_SETTLED = 0.05
_FEW = 0.02
_ENOUGH = 0.07
# Descent of a clipped step where the gap and the step of each cell are opposite, as a rule, is 1.
_STEEP = 0.05
# Where the worst cell does not come closer, the mean of the others has hidden it: solve better.
_STALLED = 0.95
_MORE_CARE = 0.1
# Free cells that carry less of the load than this cannot be scaled to carry what is missing.
_NOTHING = 1e-12
# Steps are made in single precision: the error of a displacement relative to its largest value,
# and what part of the residual it may become until the displacement is computed anew.
_SINGLE = 5e-7
_TRUSTED = 0.1


class ActiveSet:
    """A feasible pressure, its displacement and the sets, on the way to the solution.

    Parameters
    ----------
    problem
        What to solve.
    start
        A first guess of the pressure, Pa, of any load.
    """

    _known_tangent: Single | None

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

    def _tangent(self) -> Single | None:
        """Tangent of the layer in units of the influence of a cell on itself.

        It is asked for twice before the first step.
        """
        layer = self.problem.layer
        if layer is not None and self._known_tangent is None:
            tangent = layer.tangent(self.pressure) / self.problem.half_space.self_influence
            self._known_tangent = tangent.astype(np.float32)
        return self._known_tangent

    def solve(self, tolerance: float, *, verified: bool = True) -> bool:
        """Iterate until the residual is below the tolerance; whether it got there.

        ``verified`` asks for a last convolution, by which the residual owes nothing to what was
        carried along.
        """
        before = inf
        for _ in range(_LARGEST_OUTER):
            self._evaluate()
            error = self.residual
            if not isfinite(error):
                return False
            if self._rounding > _TRUSTED * max(error, tolerance) * self.scale:
                self._refresh()
                before = inf
                continue
            if error > _STALLED * before and np.array_equal(self.free, self._solved):
                self._care *= _MORE_CARE
            before = error
            if error <= tolerance:
                if not (verified and self._rounding):
                    return True
                self._refresh()
                continue
            self._exchange(tolerance)
            if not self._advance(tolerance):
                return False
        return False

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
        self._rounding = 0.0

    def _evaluate(self) -> None:
        """Approach, gap and the largest violation of the conditions on it."""
        separation, free = self.separation, self.separation[self.free]
        violations = [0.0]
        if free.size:
            self.approach = float(free.mean())
            violations += [float(free.max()) - self.approach, self.approach - float(free.min())]
        saturated = separation[self.saturated]
        if saturated.size:
            if not free.size:
                # All loaded cells are saturated: the approach lies between those and the open ones.
                self.approach = float(saturated.max())
            violations.append(float(saturated.max()) - self.approach)
        unloaded = separation[~(self.free | self.saturated)]
        if unloaded.size:
            violations.append(self.approach - float(unloaded.min()))
        self.gap = separation - self.approach
        self.scale = float(self.displacement.max())
        # The largest of some numbers hides one that is not a number; their sum does not.
        worst = max(violations) if isfinite(sum(violations)) else inf
        self.residual = worst / self.scale

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
            displacement = self.problem.half_space.displacement_in_single(step)
            self.convolutions += 1
            if -inner(self.gap, step) > _STEEP * inner(np.abs(self.gap), np.abs(step)):
                self._search(step, displacement)
                return True
            # Clipping turned the direction uphill, or nearly so: a shorter step clips less.
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

        self._rounding += _SINGLE * largest_magnitude(displacement)
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
        """Step of the free cells that keeps the load, Pa, and its displacement, m."""
        reduction = self._care * self._prepare()
        # In units of the worst violation and of the influence of a cell on itself.
        unit = self.residual * self.scale
        enough = self._care * _ENOUGH * tolerance / self.residual
        cells = self._cells
        found = cells.solve(
            (self.gap / -unit).astype(np.float32), self._tangent(), reduction, enough
        )
        self.iterations += found.iterations
        self.convolutions += found.iterations
        # In double precision, the load is kept to the last digit.
        stray = found.missed / cells.uniform_sum
        pressure_unit = unit / self.problem.half_space.self_influence
        step = np.multiply(found.pressure, pressure_unit, dtype=np.float64)
        step -= np.multiply(cells.uniform, stray * pressure_unit, dtype=np.float64)
        displacement = np.multiply(found.displacement, unit, dtype=np.float64)
        displacement -= stray * unit
        return step, displacement

    def _prepare(self) -> float:
        """Invert on the free cells; by what factor to reduce the residual there.

        While many cells still change sides it does not pay to solve for them exactly; what the
        caller started from has most of them right.
        """
        before, self._solved = self._solved, self.free.copy()
        changed = np.count_nonzero(before != self.free)
        if changed:
            self._cells = FreeCells(
                self.problem.half_space.single, self._preconditioner.on(self.free), self.free
            )
        if self.iterations == 0:
            return _FIRST if self.residual < _NEAR else _UNSETTLED
        return _SETTLED if changed <= _FEW * np.count_nonzero(self.free) else _UNSETTLED


def carrying(pressure: Array, limit: float, total: float) -> Array:
    """The pressure cut to the bounds, its free cells scaled so that its sum is ``total``, Pa.

    Scaling leaves open cells open and saturated cells saturated; a shift would free them.
    """
    result = np.clip(pressure, 0.0, limit)
    for _ in range(100):
        carried = float(result.sum())
        missing = total - carried
        if abs(missing) <= 1e-14 * total:
            break
        saturated = result >= limit
        count = np.count_nonzero(saturated)
        movable = carried - limit * count if count else carried
        if movable <= -missing:
            # Saturated cells have to give way too.
            result *= total / carried
        elif movable <= _NOTHING * carried:
            # All loaded cells are at the limit and still do not carry the load.
            np.maximum(result, 1e-3 * limit, out=result)
        else:
            result *= 1.0 + missing / movable
            np.minimum(result, limit, out=result)
            np.copyto(result, limit, where=saturated)
    return result
