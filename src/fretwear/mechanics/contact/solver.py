"""The solver of the normal contact: usually fast, always convergent.

Cells are free (0 < p < p_lim), open (p = 0) or saturated (p = p_lim). The active-set method solves
the linear problem of the free cells approximately, projects the result onto the bounds, searches
the segment to it for the least energy, and moves cells between the sets. K p is linear along a
segment, so the search costs no convolution. The energy falls at every step, hence no set of cells
repeats. If the method stalls, the slower projected gradient takes over. For a few hundred cells a
factorization solves the linear problem.

Steps are computed in single precision, everything else in double: each step corrects the error of
the one before. The result has the requested accuracy in two thirds of the time; see Higham,
"Accuracy and Stability of Numerical Algorithms", SIAM (2002), on iterative refinement.

The preconditioner approximates the inverse of K + diag c. If c is uniform, the spectrum of the
half-space suffices. The layer of a wear step is not uniform: nothing wears in the stick zone, while
in the slip zone the layer is softer than the half-space under waves of a cell's length and stiffer
under waves of the contact's. So the half-space is inverted without a layer and with the mean one,
and each cell weights both by its own c: an additive Schwarz method whose parts overlap (Smith,
Bjørstad and Gropp, "Domain Decomposition", Cambridge University Press, 1996).
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from dataclasses import replace
from math import asinh, inf, isfinite, pi, sqrt

import numpy as np

from fretwear.arrays import Array, Mask, Real, Single
from fretwear.mechanics.contact.cells import HalfSpace, Index
from fretwear.mechanics.contact.convolution import Convolution
from fretwear.mechanics.contact.gradients import projected_gradients
from fretwear.mechanics.contact.kernels import in_single, inner, scaled
from fretwear.mechanics.contact.problem import Contact, ContactProblem, solve_on

# Cells, their weights, and the inverse of the bodies with a uniform layer on these cells.
Inverse = tuple[Index, Single, Callable[[Single], Single]]

# Tolerances of the elastic state from which yielding starts, and of the contact on wider cells.
_COARSE, _OF_WIDER = 1e-2, 1e-4
# On many cells, a start with a larger residual may be farther from the solution than one from wider
# cells; factor for what they lose of its pressure.
_MANY, _NEAR, _FARTHER = 2**15, 1e-3, 10.0
_ACTIVE_SET_STEPS = 60
# Factors by which a step reduces the residual of the free cells: `_WHILE_CHANGING` while more than
# a fraction `_FEW` of them change sides, else, and at first, `_PRECISELY`; down to a part of the
# tolerance.
_WHILE_CHANGING = 0.5
_PRECISELY = 0.1
_FEW = 0.02
_ENOUGH = 0.14
# Least descent of a clipped step; it is 1 if gap and step are opposite in every cell.
_STEEP = 0.05
# CG stops by the mean residual, which can hide one bad cell: if the maximum stalls, tighten CG.
_STALLED = 0.95
_MORE_CARE = 0.1
# Single precision of the steps: error of a displacement over its largest value, and the part of the
# residual that it may reach before the displacement is computed anew.
_SINGLE = 1e-6
_TRUSTED = 0.1
# Accuracy of the energy minimum along a step, as a fraction of it, if slopes do not suffice.
_CLOSED = 1e-12
# Cells change sides if their gap exceeds this part of the tolerance.
_MARGIN = 0.3
_LARGEST_ITERATIONS = 40
# 4 h / 3E* of a square cell over its influence on itself, (4 arsinh 1 / π) h / E*.
_EDGE = pi / (3.0 * asinh(1.0))
# Up to the first mean tangent a single layer, stiffer by the second number, suffices. Above it,
# shares grow with the tangent around the third number.
_SOFT = 0.3
_STIFFENING = 3.0
_HALF_SHARE = 2.0


class ConvolvedBodies(HalfSpace):
    """Elastic bodies whose displacement is a convolution on a window of equal cells."""

    @property
    @abstractmethod
    def single(self) -> Convolution[Single]:
        """Displacement in units of `self_influence`, and its inverse, in single precision."""

    @abstractmethod
    def cropped(self, cells: Mask) -> ConvolvedBodies:
        """The bodies on the smallest window that holds some cells and a margin."""

    @property
    @abstractmethod
    def coarser(self) -> ConvolvedBodies | None:
        """The bodies on cells twice as wide; None if the cells are few."""


@solve_on.register
def solve_by_active_sets(
    bodies: ConvolvedBodies,
    problem: ContactProblem,
    start: Array | None,
    tolerance: float,
    *,
    verified: bool,
) -> Contact:
    """Solve a normal contact on a grid; parameters and errors as of `solve_contact`."""
    method, spent = None if start is None else ActiveSet(problem, bodies, start), 0
    if method is None or method.is_far(tolerance):
        start, spent = _first_start(bodies, problem)
        spent += 0 if method is None else method.convolutions
        method = ActiveSet(problem, bodies, start)
    if not method.solve(tolerance, verified=verified):
        spent += method.convolutions
        contact = projected_gradients(problem, method.pressure, tolerance)
        return replace(contact, convolutions=contact.convolutions + spent)
    return Contact(
        pressure=method.pressure,
        gap=method.gap,
        approach=method.approach,
        saturated=method.pressure >= problem.limit,
        residual=method.residual,
        convolutions=method.convolutions + spent,
    )


def _first_start(bodies: ConvolvedBodies, problem: ContactProblem) -> tuple[Array, int]:
    """A first pressure, Pa, and the convolutions spent on it; from wider cells if there are any."""
    limit = problem.limit
    if problem.layer is None and (coarser := bodies.coarser) is not None:
        if isinstance(limit, np.ndarray):
            limit = halved(limit)
        wider = replace(problem, half_space=coarser, shape=halved(problem.shape), limit=limit)
        contact = solve_by_active_sets(coarser, wider, None, _OF_WIDER, verified=False)
        pressure = refined(contact.pressure, contact.gap, coarser.self_influence)
        return pressure, contact.convolutions // 4
    start = problem.first_guess()
    if not np.isfinite(limit).all():
        return start, 0
    # From a distant start both bounds at once lead to wrong sets. So yielding starts from the
    # elastic state, which need not be accurate.
    elastic = ActiveSet(replace(problem, limit=inf), bodies, start)
    elastic.solve(_COARSE, verified=False)
    return elastic.pressure, elastic.convolutions


def halved(field: Real) -> Real:
    """Means of a field over blocks of two by two cells."""
    nx, ny = field.shape
    means: Real = field.reshape(nx // 2, 2, ny // 2, 2).mean(axis=(1, 3))
    return means


def refined(wider: Array, gap: Array, self_influence: float) -> Array:
    """A pressure, Pa, on cells half as wide, with the same means; of a contact with its gap, m.

    At a distance s inside an edge the pressure is A √s; at s outside, the gap is 4 A √s³ / 3E*. So
    A² s, which is p² inside and follows from the gap outside, is interpolated through the edge.
    """
    pressure, unit = scaled(wider)
    squared = np.square(pressure)
    # A² times the width of a cell: p² rises to one to two of these within two cells.
    rise = squared / np.float32(1.5)
    for field in (rise, rise.T) * 2:
        np.maximum(field[1:], field[:-1], out=field[1:])
        np.maximum(field[:-1], field[1:], out=field[:-1])
    opened = in_single(gap, unit * self_influence)
    outside = np.cbrt(np.square(rise * opened / np.float32(_EDGE)))
    squared = np.where(pressure > 0, squared, -outside)
    finer = np.sqrt(np.maximum(_halfway(_halfway(squared.T).T), 0.0))
    means = halved(finer)
    scale = np.divide(pressure, means, out=np.zeros_like(means), where=means > 0)
    scale *= np.float32(unit)
    return np.multiply(finer, scale.repeat(2, axis=0).repeat(2, axis=1), dtype=float)


def _halfway(field: Single) -> Single:
    """Linear interpolation along x to cells half as wide."""
    padded = np.concatenate([field[:1], field, field[-1:]])
    result = np.repeat(np.float32(0.75) * field, 2, axis=0)
    result[::2] += np.float32(0.25) * padded[:-2]
    result[1::2] += np.float32(0.25) * padded[2:]
    return result


class ActiveSet:
    """The current feasible pressure, Pa, its displacement, m, and the sets of cells."""

    _cells: FreeCells

    def __init__(self, problem: ContactProblem, bodies: ConvolvedBodies, start: Array) -> None:
        self.problem, self._bodies = problem, bodies
        self.convolutions = 0
        # The start is scaled to the load and clipped to the bounds.
        self.pressure = problem.clip_to_load(np.ascontiguousarray(start, np.float64))
        moved, unit = bodies.relative_displacement(self.pressure)
        self._place(np.multiply(moved, unit, dtype=float), _SINGLE)
        self.free = self._between_bounds()
        self._care = 1.0
        self._solved: Mask = ~self.free
        self._inverses = preconditioner(self._bodies, self._tangent(), self.free)

    def is_far(self, tolerance: float) -> bool:
        """Whether a start from wider cells, if there are any, is closer to the solution.

        It misses about what wider cells lose of the present pressure.
        """
        problem, bodies = self.problem, self._bodies
        if problem.layer is not None or not problem.is_elastic or self.pressure.size < _MANY:
            return False
        self._evaluate(tolerance)
        if self.residual <= _NEAR or (coarser := bodies.coarser) is None:
            return False
        wider = halved(self.pressure), halved(np.maximum(self.gap, 0.0))
        lost = np.abs(refined(*wider, coarser.self_influence) - self.pressure)
        return self.residual * self.scale > _FARTHER * bodies.self_influence * float(lost.max())

    def _between_bounds(self) -> Mask:
        return (self.pressure > 0) & (self.pressure < self.problem.limit)

    def _tangent(self) -> Single | None:
        """Tangent of the layer in units of the influence of a cell on itself."""
        layer, unit = self.problem.layer, self._bodies.self_influence
        return None if layer is None else layer.scaled_tangent(unit, self.pressure)

    def solve(self, tolerance: float, *, verified: bool = True) -> bool:
        """Iterate until the residual is below the tolerance; return whether it is.

        ``verified`` asks for a final convolution, so that the residual does not rest on updated
        values.
        """
        previous = inf
        for _ in range(_ACTIVE_SET_STEPS):
            self._evaluate(tolerance)
            error = self.residual
            if not isfinite(error):
                return False
            if self._rounding > _TRUSTED * max(error, tolerance) * self.scale:
                self._refresh()
                previous = inf
                continue
            if error > _STALLED * previous and np.array_equal(self._between_bounds(), self._solved):
                self._care *= _MORE_CARE
            previous = error
            if error <= tolerance:
                if not (verified and self._rounding):
                    return True
                self._refresh()
                continue
            if not self._advance(tolerance):
                return False
        return False

    def _refresh(self) -> None:
        """Recompute K p, which is otherwise updated, in double precision."""
        self._place(self._bodies.displacement(self.pressure), 0.0)

    def _place(self, displacement: Array, error: float) -> None:
        """Set K p, m, from a convolution of some relative error."""
        self.displacement = displacement
        self.separation = self.problem.separation(self.pressure, displacement)
        self.convolutions += 1
        self._rounding = error * float(displacement.max())

    def _evaluate(self, tolerance: float) -> None:
        """Approach, gap, the largest violation of the conditions on it, and the free cells."""
        pressure, limit, approach = self.pressure, self.problem.limit, self.problem.approach
        loaded = pressure > 0
        full: Mask | np.bool_ = np.False_ if self.problem.is_elastic else pressure >= limit
        partly = loaded & ~full
        count = int(np.count_nonzero(partly))
        self.scale = float(self.displacement.max())
        if approach is not None:
            self.approach = approach
        elif count:
            self.approach = inner(self.separation, partly.astype(np.float64)) / count
        else:
            self.approach = float(self.separation[full].max())
        self.gap = gap = self.separation - self.approach
        margin = _MARGIN * tolerance * self.scale
        self.free = partly | (~loaded & (gap < -margin)) | (full & (gap > margin))
        # The largest of g at positive pressure and of −g below the limit.
        worst = max(float((gap * loaded).max()), -float((gap * ~full).min()))
        self.residual = (worst if isfinite(worst) else inf) / self.scale

    def _advance(self, tolerance: float) -> bool:
        """One projected Newton step; False when none descends, and projected gradients must."""
        problem, bodies = self.problem, self._bodies
        previous, self._solved = self._solved, self.free
        changed = np.count_nonzero(previous != self.free)
        if changed:
            self._cells = FreeCells(
                bodies.single, self._inverses, self.free, problem.approach is None
            )
        # While many cells still change sides an exact solution does not pay; the start of the
        # caller has most of them right.
        few = changed <= _FEW * np.count_nonzero(self.free)
        reduction = _PRECISELY if few or self.convolutions <= 1 else _WHILE_CHANGING
        enough = self._care * _ENOUGH * tolerance / self.residual
        # In units of the worst violation and of the influence of a cell on itself.
        unit, cells = self.residual * self.scale, self._cells
        pressure_unit = unit / bodies.self_influence
        pressure, moved, missed, iterations = cells.solve(
            self.gap, -unit, self._tangent(), self._care * reduction, enough
        )
        self.convolutions += iterations
        gap, step = problem.weighted(self.gap), np.multiply(pressure, pressure_unit, dtype=float)
        if problem.approach is None:
            # In double precision, the load is kept to the last digit.
            step -= missed * pressure_unit * self.free
        target = self.pressure + step
        if target.min() >= 0 and (target - problem.limit).max() <= 0:
            self._search(step, inner(step, gap), moved, unit)
            return True
        for _ in range(8):
            step = problem.clip_to_load(target) - self.pressure
            moved, unit = bodies.relative_displacement(step)
            self.convolutions += 1
            products = gap * step
            slope = float(products.sum())
            if -slope > _STEEP * float(np.abs(products).sum()):
                self._search(step, slope, moved, unit)
                return True
            # Clipping made the direction lead uphill, or nearly so; a shorter step clips less.
            target = 0.7 * self.pressure + 0.3 * target
        return False

    def _search(self, step: Array, first: float, moved: Single, unit: float) -> None:
        """Move along a feasible step, Pa: to its end, or to the energy minimum before it.

        ``first`` is the slope of the energy at the start of the step. The displacement of the step
        is ``moved`` in some unit, m.
        """
        problem, reached = self.problem, 0.0
        limit, shape, layer = problem.limit, problem.shape, problem.layer
        weighted = problem.weighted(step)
        # A step keeps a load only up to the last digits of the highest pressure, which may exceed
        # the lowest by ten orders of magnitude; so the approach counts under a load, too.
        uniform = self.approach * float(weighted.sum())
        opening = np.multiply(moved, unit, dtype=float)

        def slope(fraction: float) -> float:
            nonlocal reached
            part = fraction - reached
            # Rounding must not lead beyond the bounds.
            self.pressure += part * step
            np.clip(self.pressure, 0.0, limit, out=self.pressure)
            self.displacement += part * opening
            np.add(self.displacement, shape, out=self.separation)
            if layer is not None:
                layer.add_displacement(self.pressure, self.separation)
            reached = fraction
            return inner(weighted, self.separation) - uniform

        self._rounding += _SINGLE * float(np.abs(moved).max()) * unit
        low, high, is_halved = 0.0, 1.0, True
        enough = 0.1 * abs(first)
        last = slope(1.0)
        # The slope rises continuously, so that it vanishes where the bracket closes.
        while last > enough and high - low > _CLOSED:
            part = max(0.05, min(0.95, first / (first - last))) if is_halved else 0.5
            width, fraction = high - low, low + (high - low) * part
            middle = slope(fraction)
            if abs(middle) <= enough:
                break
            if middle < 0:
                low, first = fraction, middle
            else:
                high, last = fraction, middle
            is_halved = high - low <= 0.5 * width


def preconditioner(
    half_space: ConvolvedBodies, tangent: Single | None, free: Mask
) -> list[Inverse]:
    """Approximate inverses of K + diag c: on the whole window, and on inner cells that differ much.

    The tangent c is in units of the influence of a cell on itself, None without a layer. Its values
    on the cells that are probably free determine the uniform layers.
    """
    invert, grid, free_cells = (
        half_space.single.inverse,
        half_space.geometry,
        free.astype(np.float32),
    )
    everywhere, count = grid.where(grid), int(np.count_nonzero(free))
    if tangent is None or not count:
        return [(everywhere, np.ones_like(free_cells), invert())]
    mean = inner(tangent, free_cells) / count
    if mean < _SOFT:
        # Stiffer than the half-space nearly everywhere: one layer, scaled to each cell.
        uniform = count / inner(1.0 / (tangent + 1.0), free_cells) - 1.0
        share = np.sqrt(np.float32(_STIFFENING + uniform) / (tangent + np.float32(_STIFFENING)))
        return [(everywhere, share, invert(max(uniform, 0.0)))]
    # The squared share of the layer grows with the tangent from zero to one at the mean, and falls
    # again above. The share without a layer complements it to one, and is zero above the mean.
    scale, softest = np.float32((mean + _HALF_SHARE) / mean), np.float32(mean) + np.float32(1.0)
    of_layer = np.minimum(tangent / (tangent + np.float32(_HALF_SHARE)) * scale, 1.0)
    hard = np.sqrt(1.0 - of_layer)
    soft = np.sqrt(of_layer * np.minimum(softest / (tangent + 1.0), 1.0))
    part = half_space.cropped(hard > 0)
    cells = grid.where(part.geometry)
    hard = np.ascontiguousarray(hard[cells])
    return [(everywhere, soft, invert(mean)), (cells, hard, part.single.inverse())]


class FreeCells:
    """The linear problem of some free cells, in units of the self-influence.

    Find a pressure s on the free cells, zero on all others, and a number α with

        (K + diag c) s = r − α   on the free cells,

    where s carries no load in sum, or α = 0 at a given approach. M is the `preconditioner`.
    """

    def __init__(
        self, convolve: Convolution[Single], parts: list[Inverse], free: Mask, under_load: bool
    ) -> None:
        self._convolve, self._inside = convolve, free.astype(np.float32)
        self._count = np.count_nonzero(free)
        # Cells that are not free have no weight.
        self._parts: list[Inverse] = [
            (cells, share * self._inside[cells], invert) for cells, share, invert in parts
        ]
        self._under_load = under_load

    def _mean(self, field: Single) -> np.float32:
        """The mean of a field on the free cells under a load, else 0."""
        return np.float32(inner(field, self._inside) / self._count if self._under_load else 0.0)

    def _preconditioned(self, residual: Single) -> tuple[Single, float]:
        """The pressure for a residual gap, zero on all other cells, and their inner product."""
        result, energy = np.empty(0, np.float32), 0.0
        for cells, share, invert in self._parts:
            left = residual[cells]
            pressure = invert(left * share)
            pressure *= share
            energy += inner(pressure, left)
            # The first part is on all cells.
            if not result.size:
                result = pressure
            else:
                result[cells] += pressure
        result -= self._mean(result) * self._inside
        return result, energy

    def solve(
        self, residual: Array, unit: float, tangent: Single | None, reduction: float, enough: float
    ) -> tuple[Single, Single, float, int]:
        """Preconditioned conjugate gradients, which may stop early: each step lowers the energy.

        It returns s, its displacement K s, the mean of s on the free cells, which vanishes under a
        given load up to rounding, and the number of steps, of one convolution each.

        Directions of zero sum keep the load: the residual loses its mean on the free cells before M
        is applied, the result loses its own, and α is the sum of the means of the residuals.

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
        start = in_single(residual, unit)
        start *= self._inside
        left, pressure, scratch = start.copy(), np.zeros_like(start), np.empty_like(start)
        direction: Single | None = None
        alpha = target = energy = 0.0
        iterations = 0
        while True:
            shift = self._mean(left)
            alpha += float(shift)
            left -= shift
            np.multiply(left, self._inside, out=scratch)
            spread = sqrt(inner(scratch, scratch) / self._count)
            if iterations == 0:
                target = max(reduction * spread, enough)
            elif spread <= target or iterations == _LARGEST_ITERATIONS:
                break
            previous = energy
            preconditioned, energy = self._preconditioned(left)
            if not energy > 0:
                break
            if direction is None:
                direction = preconditioned
            else:
                direction *= np.float32(energy / previous)
                direction += preconditioned
            force = self._convolve(direction)
            iterations += 1
            if tangent is not None:
                force += np.multiply(tangent, direction, out=scratch)
            length = np.float32(energy / inner(direction, force))
            pressure += np.multiply(direction, length, out=scratch)
            left -= np.multiply(force, length, out=force)
        # On other cells the remainder is the displacement of the surface.
        np.subtract(start, left, out=left)
        left -= np.float32(alpha)
        if tangent is not None:
            left -= np.multiply(tangent, pressure, out=scratch)
        return pressure, left, float(pressure.sum(dtype=float) / self._count), iterations
