"""The active-set method of the normal contact.

Cells are free (0 < p < p_lim), open (p = 0) or saturated (p = p_lim). The method solves the linear
problem of the free cells approximately, projects the result onto the bounds, searches the segment
to it for the least energy, and moves cells between the sets. Along a segment K p is linear, so the
search costs no convolution. Energy falls at every step, hence no set of cells repeats.

The steps are computed in single precision, all else in double: the next step corrects the error of
the last one. The result has the accuracy asked for, in two thirds of the time; see Higham,
"Accuracy and Stability of Numerical Algorithms", SIAM (2002), on iterative refinement.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isfinite, nan
from typing import cast

import numpy as np

from fretwear.mechanics.contact import ContactProblem
from fretwear.mechanics.free_cells import FreeCells, preconditioner
from fretwear.mechanics.geometry import Array, Mask, Single
from fretwear.mechanics.geometry.grid import GridHalfSpace
from fretwear.mechanics.team import kernels

# A step reduces the residual of the free cells by so much: the first one from near the solution,
# later ones and one from afar while more than a few cells changed sides, and when the sets are the
# final ones nearly; but not below a part of the tolerance.
_NEAR = 0.02
_FIRST = 0.05
_WHILE_CHANGING = 0.5
_AT_LAST = 0.05
_FEW = 0.02
_ENOUGH = 0.07
# Descent of a clipped step where the gap and the step of each cell are opposite, as a rule, is 1.
_STEEP = 0.05
# If the worst cell does not improve, the mean of the others has hidden it: solve more accurately.
_STALLED = 0.95
_MORE_CARE = 0.1
# Steps are made in single precision: the error of a displacement relative to its largest value,
# and what part of the residual it may become until the displacement is computed anew.
_SINGLE = 5e-7
_TRUSTED = 0.1
# Cells change sides where the gap is beyond this part of the tolerance.
_MARGIN = 0.3


@dataclass(frozen=True)
class _Segment:
    """A step of the pressure, Pa, the slope of the energy at its start, and its displacement.

    That is ``moved`` in some unit, m, plus an offset, m; at most ``largest``, m.
    """

    step: Array
    slope: float
    moved: Single
    unit: float
    offset: float
    largest: float


class ActiveSet:
    """The current feasible pressure, its displacement and the sets of cells.

    Parameters
    ----------
    problem
        What to solve.
    start
        A first guess of the pressure, Pa, of any load.
    """

    _known_tangent: Single | None
    _cells: FreeCells

    def __init__(self, problem: ContactProblem, start: Array) -> None:
        self.problem = problem
        self._team = problem.half_space.team
        self.iterations = 0
        self.convolutions = 0
        self.restart(start)

    def restart(self, start: Array) -> None:
        """Restart from a pressure, scaled to the load and clipped to the bounds."""
        self.pressure = self.problem.clip_to_load(start)
        self._known_tangent = None
        self._refresh()
        self.gap = np.empty_like(self.pressure)
        self.free = self._between_bounds()
        self._care = 1.0
        self._solved: Mask = ~self.free
        self._bodies = cast("GridHalfSpace", self.problem.half_space)
        self._inverses = preconditioner(self._bodies, self._tangent(), self.free)

    @property
    def saturated(self) -> Mask:
        """Cells at the pressure limit."""
        result: Mask = self.pressure >= self.problem.limit
        return result

    def _between_bounds(self) -> Mask:
        limit = self.problem.limit
        result: Mask = self._team.cellwise(
            lambda pressure: (pressure > 0) & (pressure < limit), self.pressure, dtype=np.bool_
        )
        return result

    def _tangent(self) -> Single | None:
        """Tangent of the layer in units of the influence of a cell on itself."""
        layer = self.problem.layer
        if layer is not None and self._known_tangent is None:
            unit = self.problem.half_space.self_influence
            self._known_tangent = layer.tangent_in(unit, self.pressure, self._team)
        return self._known_tangent

    def solve(self, tolerance: float, largest_steps: int, *, verified: bool = True) -> bool:
        """Iterate until the residual is below the tolerance; return whether it is.

        ``verified`` asks for a final convolution, so that the residual does not rest on updated
        values.
        """
        before = inf
        for _ in range(largest_steps):
            self._evaluate(tolerance)
            error = self.residual
            if not isfinite(error):
                return False
            if self._rounding > _TRUSTED * max(error, tolerance) * self.scale:
                self._refresh()
                before = inf
                continue
            if error > _STALLED * before and np.array_equal(self._between_bounds(), self._solved):
                self._care *= _MORE_CARE
            before = error
            if error <= tolerance:
                if not (verified and self._rounding):
                    return True
                self._refresh()
                continue
            if not self._advance(tolerance):
                return False
        return False

    def _refresh(self) -> None:
        """Recompute K p, which is otherwise updated."""
        self.displacement = self.problem.half_space.displacement(self.pressure)
        self.separation = self.problem.separation(self.pressure, self.displacement)
        self.convolutions += 1
        self._rounding = 0.0

    def _evaluate(self, tolerance: float) -> None:
        """Approach, gap, the largest violation of the conditions on it, and the free cells."""
        given = self.problem.approach
        # A new field, because the last solution is compared with it.
        self.free = np.empty_like(self.free)
        problem = self.problem
        free, count, self.scale = kernels.level(
            self._team, problem.limit, self.separation, self.displacement, self.pressure
        )
        self.approach = nan if given is None else given
        if given is None:
            self.approach = free / count if count else float(self.separation[self.saturated].max())
        worst, gaps = kernels.evaluate(
            self._team,
            self.separation,
            self.pressure,
            problem.limit,
            self.approach,
            _MARGIN * tolerance * self.scale,
            self.gap,
            self.free,
        )
        # The maximum hides NaN; the sum does not.
        self.residual = (worst if isfinite(gaps) else inf) / self.scale

    def _advance(self, tolerance: float) -> bool:
        """One projected Newton step; False when no descent is left."""
        newton, feasible = self._newton_step(tolerance)
        if feasible:
            self._search(newton)
            return True
        target = self._team.cellwise(np.add, self.pressure, newton.step)
        for _ in range(8):
            clipped, steep = self._clipped_step(target)
            if steep:
                self._search(clipped)
                return True
            # Clipping made the direction lead uphill, or nearly so; a shorter step clips less.
            target = self._team.cellwise(lambda p, t: 0.7 * p + 0.3 * t, self.pressure, target)
        return False

    def _newton_step(self, tolerance: float) -> tuple[_Segment, bool]:
        """The step of the free cells at constant load, and whether it stays within the bounds.

        While many cells still change sides it does not pay to solve for them exactly; what the
        caller started from has most of them right.
        """
        before, self._solved = self._solved, self.free
        changed = np.count_nonzero(before != self.free)
        if changed:
            under_load = self.problem.approach is None
            self._cells = FreeCells(
                self._bodies.single, self._inverses, self.free, under_load=under_load
            )
        if self.iterations:
            few = changed <= _FEW * np.count_nonzero(self.free)
            reduction = _AT_LAST if few else _WHILE_CHANGING
        else:
            reduction = _FIRST if self.residual < _NEAR else _WHILE_CHANGING
        enough = self._care * _ENOUGH * tolerance / self.residual
        # In units of the worst violation and of the influence of a cell on itself.
        unit, cells = self.residual * self.scale, self._cells
        pressure_unit = unit / self.problem.half_space.self_influence
        found = cells.solve(self.gap, -unit, self._tangent(), self._care * reduction, enough)
        self.iterations += found.iterations
        self.convolutions += found.iterations
        # In double precision, the load is kept to the last digit.
        stray = found.missed / cells.uniform_sum
        step = np.empty_like(self.pressure)
        lowest, highest, slope = kernels.scale_step(
            self._team,
            self.pressure,
            self.problem.weighted(self.gap),
            found.pressure,
            pressure_unit,
            cells.uniform,
            stray * pressure_unit,
            step,
        )
        largest = (found.largest + abs(stray)) * unit
        segment = _Segment(step, slope, found.displacement, unit, -stray * unit, largest)
        return segment, lowest >= 0 and highest <= self.problem.limit

    def _clipped_step(self, target: Array) -> tuple[_Segment, bool]:
        """The step to a pressure clipped to bounds and load, and whether it lowers the energy."""
        clipped = self.problem.clip_to_load(target)
        step = self._team.cellwise(np.subtract, clipped, self.pressure)
        moved, unit = self.problem.half_space.relative_displacement(step)
        self.convolutions += 1
        products = self._team.cellwise(np.multiply, self.problem.weighted(self.gap), step)
        slope = kernels.inner(self._team, np.ones_like(step), products)
        magnitudes = kernels.inner(self._team, np.sign(products), products)
        largest = kernels.largest(self._team, moved) * unit
        return _Segment(step, slope, moved, unit, 0.0, largest), -slope > _STEEP * magnitudes

    def _search(self, segment: _Segment) -> None:
        """Move along a feasible segment: to its end, or to the energy minimum before it."""
        problem, reached = self.problem, 0.0
        weighted, level = problem.weighted(segment.step), problem.approach

        def slope(fraction: float) -> float:
            nonlocal reached
            kernels.move(
                self._team,
                fraction - reached,
                segment.step,
                problem.limit,
                segment.moved,
                segment.unit,
                segment.offset,
                problem.shape,
                self.pressure,
                self.displacement,
                self.separation,
            )
            if problem.layer is not None:
                problem.layer.add_displacement(self.pressure, self.separation, self._team)
            reached = fraction
            result: float = kernels.inner(self._team, weighted, self.separation)
            return result if level is None else result - level * float(weighted.sum())

        self._rounding += _SINGLE * segment.largest
        low, high, first = 0.0, 1.0, segment.slope
        enough = 0.1 * abs(first)
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
        self._known_tangent = None
