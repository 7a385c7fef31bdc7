"""The solver of the normal contact: usually fast, always convergent.

Cells are free (0 < p < p_lim), open (p = 0) or saturated (p = p_lim). The active-set method solves
the linear problem of the free cells approximately, projects the result onto the bounds, searches
the segment to it for the least energy, and moves cells between the sets. Along a segment K p is
linear, so the search costs no convolution. Energy falls at every step, hence no set of cells
repeats. If it stalls, the slower projected gradient takes over. For a few hundred cells a
factorization solves the linear problem.

The steps are computed in single precision, all else in double: the next step corrects the error of
the last one. The result has the accuracy asked for, in two thirds of the time; see Higham,
"Accuracy and Stability of Numerical Algorithms", SIAM (2002), on iterative refinement.

The preconditioner inverts K + diag c nearly. Where c is uniform, the spectrum of the half-space
does that. The layer of a wear step is not uniform: nothing wears in the stick zone, while in the
slip zone the layer is softer than the half-space under waves of a cell's length and stiffer under
waves of the contact's. So two uniform layers are inverted, none and the mean one, and combined in
each cell with weights that depend on its own c: an additive Schwarz method whose parts overlap
(Smith, Bjørstad and Gropp, "Domain Decomposition", Cambridge University Press, 1996).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import inf, isfinite, sqrt
from typing import TYPE_CHECKING

import numpy as np

from fretwear.arrays import Array, Mask, Single
from fretwear.mechanics.contact import (
    Contact,
    ContactError,
    ContactProblem,
    projected_gradient,
)
from fretwear.mechanics.convolution import Convolution
from fretwear.mechanics.geometry import Index
from fretwear.mechanics.team import kernels

if TYPE_CHECKING:
    from fretwear.mechanics.geometry.grid import GridHalfSpace

# Cells, their weights, and an inverse of the bodies with a uniform layer there.
Inverse = tuple[Index, Single, Callable[[Single], Single]]

_COARSE = 1e-2
_ACTIVE_SET_STEPS = 60
# Factors by which a step reduces the residual of the free cells: `_FIRST` for the first step if the
# residual at the start is below `_NEAR`, `_WHILE_CHANGING` while more than a part `_FEW` of cells
# change sides, `_AT_LAST` with nearly the final sets; but not below a part of the tolerance.
_NEAR = 0.02
_FIRST = 0.05
_WHILE_CHANGING = 0.5
_AT_LAST = 0.05
_FEW = 0.02
_ENOUGH = 0.07
# Least descent of a clipped step; it is 1 if gap and step are opposite in every cell.
_STEEP = 0.05
# If the worst cell does not improve, the mean of the others has hidden it: solve more accurately.
_STALLED = 0.95
_MORE_CARE = 0.1
# Steps are made in single precision: the error of a displacement relative to its largest value, and
# the part of the residual that it may reach before the displacement is computed anew.
_SINGLE = 5e-7
_TRUSTED = 0.1
# Cells change sides where the gap is beyond this part of the tolerance.
_MARGIN = 0.3
_LARGEST_ITERATIONS = 40
# Below the first mean tangent a single layer suffices, stiffer by the second for its scaling. Above
# it, shares grow with the tangent around the third.
_SOFT = 0.3
_STIFFENING = 3.0
_HALF_SHARE = 2.0


def solve_by_active_sets(
    bodies: GridHalfSpace,
    problem: ContactProblem,
    start: Array | None,
    tolerance: float,
    *,
    verified: bool,
) -> Contact:
    """Solve a normal contact on a grid; parameters and errors as of `solve_contact`."""
    spent = 0
    if start is None:
        start = problem.first_guess()
        if np.isfinite(problem.limit).all():
            # Both bounds at once from a distant start lead to wrong sets, so yielding starts from
            # the elastic state.
            elastic = ActiveSet(replace(problem, limit=inf), bodies, start)
            elastic.solve(_COARSE, verified=False)
            start, spent = elastic.pressure, elastic.convolutions
    method = ActiveSet(problem, bodies, start)
    if not method.solve(tolerance, verified=verified):
        method.restart(projected_gradient(problem, method.pressure, tolerance))
        if not method.solve(tolerance, verified=verified):
            raise ContactError(
                f"the normal contact did not converge: residual {method.residual:.2e} instead "
                f"of {tolerance:.0e} after {method.convolutions} convolutions",
                method.convolutions,
            )
    return Contact(
        pressure=method.pressure,
        gap=method.gap,
        approach=method.approach,
        saturated=method.pressure >= problem.limit,
        residual=method.residual,
        convolutions=method.convolutions + spent,
    )


class ActiveSet:
    """The current feasible pressure, Pa, its displacement, m, and the sets of cells."""

    _cells: FreeCells

    def __init__(self, problem: ContactProblem, bodies: GridHalfSpace, start: Array) -> None:
        self.problem, self._bodies, self._team = problem, bodies, bodies.team
        self.convolutions = 0
        self.restart(start)

    def restart(self, start: Array) -> None:
        """Restart from a pressure, scaled to the load and clipped to the bounds."""
        self.pressure = self.problem.clip_to_load(np.ascontiguousarray(start, np.float64))
        self._refresh()
        self.gap = np.empty_like(self.pressure)
        self.free = self._between_bounds()
        self._care = 1.0
        self._solved: Mask = ~self.free
        self._inverses = preconditioner(self._bodies, self._tangent(), self.free)

    def _between_bounds(self) -> Mask:
        limit = self.problem.limit
        result: Mask = self._team.cellwise(
            lambda pressure, limit: (pressure > 0) & (pressure < limit),
            *(self.pressure, limit),
            dtype=np.bool_,
        )
        return result

    def _tangent(self) -> Single | None:
        """Tangent of the layer in units of the influence of a cell on itself."""
        layer, unit = self.problem.layer, self._bodies.self_influence
        return None if layer is None else layer.tangent_in(unit, self.pressure, self._team)

    def solve(self, tolerance: float, *, verified: bool = True) -> bool:
        """Iterate until the residual is below the tolerance; return whether it is.

        ``verified`` asks for a final convolution, so that the residual does not rest on updated
        values.
        """
        before = inf
        for _ in range(_ACTIVE_SET_STEPS):
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
        self.displacement = self._bodies.displacement(self.pressure)
        self.separation = self.problem.separation(self.pressure, self.displacement)
        self.convolutions += 1
        self._rounding = 0.0

    def _evaluate(self, tolerance: float) -> None:
        """Approach, gap, the largest violation of the conditions on it, and the free cells."""
        # A new field, because the last solution is compared with it.
        self.free = np.empty_like(self.free)
        team, limit, given = self._team, self.problem.limit, self.problem.approach
        free, count, self.scale = kernels.level(
            team, limit, self.separation, self.displacement, self.pressure
        )
        if given is not None:
            self.approach = given
        elif count:
            self.approach = free / count
        else:
            self.approach = float(self.separation[self.pressure >= limit].max())
        margin = _MARGIN * tolerance * self.scale
        worst, gaps = kernels.evaluate(
            team, self.separation, self.pressure, limit, self.approach, margin, self.gap, self.free
        )
        # The maximum hides NaN; the sum does not.
        self.residual = (worst if isfinite(gaps) else inf) / self.scale

    def _advance(self, tolerance: float) -> bool:
        """One projected Newton step; False when no descent is left."""
        problem, team, bodies = self.problem, self._team, self._bodies
        before, self._solved = self._solved, self.free
        changed = np.count_nonzero(before != self.free)
        if changed:
            self._cells = FreeCells(
                bodies.single, self._inverses, self.free, problem.approach is None
            )
        # While many cells still change sides it does not pay to solve for them exactly; the start
        # of the caller has most of them right.
        if self.convolutions > 1:
            few = changed <= _FEW * np.count_nonzero(self.free)
            reduction = _AT_LAST if few else _WHILE_CHANGING
        else:
            reduction = _FIRST if self.residual < _NEAR else _WHILE_CHANGING
        enough = self._care * _ENOUGH * tolerance / self.residual
        # In units of the worst violation and of the influence of a cell on itself.
        unit, cells = self.residual * self.scale, self._cells
        pressure_unit = unit / bodies.self_influence
        pressure, moved, missed, iterations = cells.solve(
            self.gap, -unit, self._tangent(), self._care * reduction, enough
        )
        self.convolutions += iterations
        # In double precision, the load is kept to the last digit.
        stray = missed / cells.uniform_sum
        step, gap = np.empty_like(self.pressure), problem.weighted(self.gap)
        share = stray * pressure_unit
        fields = self.pressure, gap, pressure, pressure_unit, cells.uniform, share
        lowest, above, slope = kernels.scale_step(team, *fields, problem.limit, step)
        if lowest >= 0 and above <= 0:
            self._search(step, slope, moved, unit, -stray * unit)
            return True
        target = team.cellwise(np.add, self.pressure, step)
        for _ in range(8):
            step = team.cellwise(np.subtract, problem.clip_to_load(target), self.pressure)
            moved, unit = bodies.relative_displacement(step)
            self.convolutions += 1
            products = team.cellwise(np.multiply, gap, step)
            slope = kernels.inner(team, np.ones_like(step), products)
            if -slope > _STEEP * kernels.inner(team, np.sign(products), products):
                self._search(step, slope, moved, unit, 0.0)
                return True
            # Clipping made the direction lead uphill, or nearly so; a shorter step clips less.
            target = team.cellwise(lambda p, t: 0.7 * p + 0.3 * t, self.pressure, target)
        return False

    def _search(self, step: Array, first: float, moved: Single, unit: float, offset: float) -> None:
        """Move along a feasible step, Pa: to its end, or to the energy minimum before it.

        The energy has the slope ``first`` at its start. Its displacement is ``moved`` in some unit,
        m, plus an offset, m.
        """
        problem, team, reached = self.problem, self._team, 0.0
        limit, shape, layer, level = problem.limit, problem.shape, problem.layer, self.approach
        weighted = problem.weighted(step)
        # A step keeps a load only up to the last digits of the highest pressure, which may exceed
        # the lowest by ten orders of magnitude; so the approach counts whether it is given or not.
        uniform = level * float(weighted.sum())
        fields = self.pressure, self.displacement, self.separation

        def slope(fraction: float) -> float:
            nonlocal reached
            kernels.move(team, fraction - reached, step, limit, moved, unit, offset, shape, *fields)
            if layer is not None:
                layer.add_displacement(self.pressure, self.separation, team)
            reached = fraction
            result: float = kernels.inner(team, weighted, self.separation)
            return result - uniform

        self._rounding += _SINGLE * (kernels.largest(team, moved) * unit + abs(offset))
        low, high = 0.0, 1.0
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


def preconditioner(half_space: GridHalfSpace, tangent: Single | None, free: Mask) -> list[Inverse]:
    """Approximate inverses of K + diag c: on the whole window, and on inner cells that differ much.

    The tangent c is in units of the influence of a cell on itself, None without a layer. Its values
    on the free cells, which are known approximately, determine the uniform layers.
    """
    invert, grid, team = half_space.single.inverse, half_space.geometry, half_space.team
    everywhere, inside = grid.where(grid), team.cellwise(np.float32, free, dtype=np.float32)
    count = int(np.count_nonzero(free))
    if tangent is None or not count:
        return [(everywhere, np.ones_like(inside), invert())]

    def of_tangent(function: Callable[[Single], Single], c: Single) -> Single:
        return team.cellwise(function, c, dtype=np.float32)

    mean = kernels.inner(team, tangent, inside) / count
    if mean < _SOFT:
        # Stiffer than the half-space nearly everywhere: one layer, scaled to each cell's own.
        softness = of_tangent(lambda c: 1.0 / (c + 1.0), tangent)
        uniform = count / kernels.inner(team, softness, inside) - 1.0
        share = of_tangent(lambda c: np.sqrt((_STIFFENING + uniform) / (_STIFFENING + c)), tangent)
        return [(everywhere, share, invert(max(uniform, 0.0)))]
    # The square of the layer's share grows with the tangent from zero to one at the mean and falls
    # again above; the square of the other share complements it to one, and is zero above.
    scale, above = np.float32((mean + _HALF_SHARE) / mean), np.float32(mean) + np.float32(1.0)

    def of_layer(c: Single) -> Single:
        return np.minimum(c / (c + np.float32(_HALF_SHARE)) * scale, 1.0)

    hard = of_tangent(lambda c: np.sqrt(1.0 - of_layer(c)), tangent)
    soft = of_tangent(lambda c: np.sqrt(of_layer(c) * np.minimum(above / (c + 1.0), 1.0)), tangent)
    inner = half_space.around(hard > 0)
    cells = grid.where(inner.geometry)
    hard = np.ascontiguousarray(hard[cells])
    return [(everywhere, soft, invert(mean)), (cells, hard, inner.single.inverse())]


class FreeCells:
    """The linear problem of some free cells, in units of the self-influence.

    Find a pressure s on the free cells, zero on all others, and a number α with

        (K + diag c) s = r − α   on the free cells,

    where s has no load in sum, or α = 0 at a given approach. M is the `preconditioner`; M 1, the
    ``uniform`` pressure, nearly lets the free cells sink alike.
    """

    def __init__(
        self, convolve: Convolution[Single], parts: list[Inverse], free: Mask, under_load: bool
    ) -> None:
        self._convolve, self._team = convolve, convolve.team
        self._inside = self._team.cellwise(np.float32, free, dtype=np.float32)
        self._count = np.count_nonzero(free)
        # Cells that are not free have no weight.
        self._parts: list[Inverse] = []
        for cells, share, invert in parts:
            inside = self._inside[cells]
            weights = self._team.cellwise(np.multiply, share, inside, dtype=np.float32)
            self._parts.append((cells, weights, invert))
        self.uniform, self.uniform_sum = np.zeros_like(self._inside), np.inf
        if under_load:
            self.uniform, self.uniform_sum = self.apply_preconditioner(self._inside)

    def apply_preconditioner(self, residual: Single) -> tuple[Single, float]:
        """The pressure for a residual gap, zero on all other cells, and their inner product."""
        result, energy = np.empty(0, np.float32), 0.0
        for cells, share, invert in self._parts:
            left, pressure = np.ascontiguousarray(residual[cells]), np.empty_like(share)
            kernels.times(self._team, left, share, pressure)
            pressure = invert(pressure)
            energy += kernels.weigh(self._team, share, left, pressure)
            # The first part is on all cells.
            if not result.size:
                result = pressure
            else:
                result[cells] += pressure
        return result, energy

    def solve(
        self, residual: Array, unit: float, tangent: Single | None, reduction: float, enough: float
    ) -> tuple[Single, Single, float, int]:
        """Preconditioned conjugate gradients.

        It returns s, its displacement K s, the sum of s, which vanishes under a given load up to
        rounding, and the number of steps, of one convolution each.

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
        left, pressure = start.copy(), np.zeros_like(start)
        direction: Single | None = None
        alpha = target = energy = 0.0
        iterations, uniform = 0, kernels.inner(team, self.uniform, left)
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
        missed = kernels.recover_displacement(team, start, tangent, pressure, alpha, left)
        return pressure, left, missed, iterations
