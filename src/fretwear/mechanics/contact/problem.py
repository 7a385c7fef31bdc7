"""Normal contact under a given load or at a given approach: pressure between zero and a limit.

Find the pressure p and the approach δ with

    g = K p + W(p) + h − δ,   ∬p = P,   0 ≤ p ≤ p_lim,
    g = 0 where 0 < p < p_lim,   g ≥ 0 where p = 0,   g ≤ 0 where p = p_lim

for the half-space K, a shape h and a layer W. It is the optimality condition of a convex
program. Each half-space solves it by its own method, and by projected gradients where that stalls.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import singledispatch
from typing import Protocol

import numpy as np

from fretwear.arrays import Array, Mask, Real, Single
from fretwear.mechanics.contact.cells import HalfSpace
from fretwear.mechanics.contact.kernels import inner

# A start that carries less than this part of the load is discarded.
_NEGLIGIBLE = 1e-6
# Free cells that carry less than this part of the others cannot be scaled up to carry the rest.
_LEAST_MOVABLE = 1e-12
# Largest relative error of a force as the sum of tractions, and largest number of shifts to it.
BALANCED, _LARGEST_SHIFTS = 1e-13, 200


class ContactError(RuntimeError):
    """No pressure distribution was found that satisfies the contact conditions to the tolerance.

    ``convolutions`` is the number of half-space convolutions spent on it.
    """

    def __init__(self, message: str, convolutions: int = 0) -> None:
        super().__init__(message)
        self.convolutions = convolutions


def find_shift(
    missing: Callable[[float], tuple[float, float]], guess: float, enough: float
) -> float:
    """Find the zero of a falling function that returns its value and its fall per step.

    Newton's method within a bracket, replaced by bisection where it does not halve its steps. The
    last call is at the zero. The function is continuous, so the bracket closes up to rounding.
    """
    low, high, last = -np.inf, np.inf, 1.0
    for _ in range(_LARGEST_SHIFTS):
        left, slope = missing(guess)
        if abs(left) <= enough:
            return guess
        low, high = (guess, high) if left > 0.0 else (low, guess)
        step = left / slope if slope > 0.0 else math.copysign(math.inf, left)
        if math.isfinite(high - low):
            if not (low < guess + step < high and abs(step) <= 0.5 * last):
                step = 0.5 * (low + high) - guess
        else:
            step = min(max(step, -2.0 * last), 2.0 * last)
        if guess + step in (low, high):
            return guess
        guess, last = guess + step, abs(step)
    raise ContactError(f"no shift of the tractions carries the force: {left:.1e} lacks")


def projected(
    pressure: Array,
    limit: float | Array,
    total: float,
    compliance: Array | float = 1.0,
    weights: Array | None = None,
) -> tuple[Array, float]:
    """The nearest pressure of a weighted sum within the bounds; see `ContactProblem.projected`."""
    # The approach is found in units of the largest pressure change.
    unit = float(np.max(compliance)) * max(float(np.abs(pressure).max()), total / pressure.size)
    moves, result = unit / np.asarray(compliance), pressure
    sinks = moves if weights is None else weights * moves

    def missing(shift: float) -> tuple[float, float]:
        nonlocal result
        result = np.clip(pressure + shift * moves, 0.0, limit)
        carried = float((result if weights is None else weights * result).sum())
        free = (result > 0.0) & (result < limit)
        return 1.0 - carried / total, float((free * sinks).sum()) / total

    shift = find_shift(missing, 0.0, BALANCED)
    return result, unit * shift


class Layer(Protocol):
    """Local compliance between the bodies: a displacement that depends on the pressure of its cell.

    It grows with pressure, so the contact problem stays convex.
    """

    # Approach at which the layer holds, m; None if it does not depend on it.
    level: float | None = None

    def at(self, approach: float) -> Layer:
        """The layer at another approach, m."""
        return self

    def per_approach(self, pressure: Array) -> Array:
        """Derivative of the displacement by the approach."""
        return np.zeros_like(pressure)

    def displacement(self, pressure: Array) -> Array:
        """Displacement, m, under a pressure, Pa; both of the geometry's shape."""
        result = np.zeros_like(pressure)
        self.add_displacement(pressure, result)
        return result

    def add_displacement(self, pressure: Array, result: Array) -> None:
        """Add the displacement under a pressure to a field."""

    def scaled_tangent(self, unit: float, pressure: Array) -> Single:
        """Derivative of the displacement in some unit, m/Pa; not negative."""


@dataclass(frozen=True)
class ContactProblem:
    """A normal contact of elastic bodies and a shape, under a load or at an approach."""

    half_space: HalfSpace  #: the elastic bodies on a geometry
    shape: Array  #: gap at zero load and zero approach, m, shape of the geometry
    load: float | None  #: normal load P of the whole contact, N; None if the approach is given
    #: Largest pressure, Pa, of all cells or of each; infinite when elastic.
    limit: float | Array = np.inf
    layer: Layer | None = None  #: local compliance
    approach: float | None = None  #: δ, m, if given instead of a load

    def __post_init__(self) -> None:
        if (self.load is None) == (self.approach is None):
            raise ValueError("a contact problem is given either a load or an approach")
        # A transposed map of heights is not in C order.
        object.__setattr__(self, "shape", np.ascontiguousarray(self.shape, np.float64))

    @property
    def total(self) -> float:
        """Weighted sum of the pressure over the cells that carries the load, Pa."""
        return (self.load or 0.0) / self.half_space.geometry.unit_area

    @property
    def is_elastic(self) -> bool:
        """Whether no cell has a limit."""
        return not isinstance(self.limit, np.ndarray) and self.limit == np.inf

    def separation(self, pressure: Array, displacement: Array) -> Array:
        """K p + W(p) + h, m: the gap plus the approach."""
        result = displacement + self.shape
        if self.layer is not None:
            self.layer.add_displacement(pressure, result)
        return result

    def first_guess(self) -> Array:
        """A first pressure that grows with the depth of the surface, shape of the geometry.

        Under a load it acts on the lowest fifth of the surface, in an arbitrary scale. At a given
        approach it acts on everything below that approach, scaled to minimal energy.
        """
        shape, approach, half_space = self.shape, self.approach, self.half_space
        level = float(np.quantile(shape, 0.2)) if approach is None else approach
        guess: Array = np.maximum(level - shape, 0.0)
        if approach is not None:
            moved = half_space.displacement(guess)
            stiff = inner(guess, self.weighted(moved))
            work = inner(guess, self.weighted(guess))
            return guess * (work / stiff) if stiff > 0 else guess
        # A flat surface has no lowest fifth.
        return guess if guess.any() else np.ones_like(shape)

    def weighted(self, values: Real) -> Real:
        """A field times the weights of the cells."""
        weights = self.half_space.geometry.weights
        return values if weights is None else np.multiply(weights, values, dtype=values.dtype)

    def clip_to_load(self, pressure: Array) -> Array:
        """The pressure clipped to the bounds, with its free cells scaled to carry the load.

        Scaling keeps open cells open and saturated cells saturated; a shift would free them. Each
        pass saturates one more cell or is the last, so the loop ends.
        """
        limit, result = self.limit, np.clip(pressure, 0.0, self.limit)
        if self.load is not None and self.is_elastic and result.any():
            return np.asarray(result * (self.total / float(self.weighted(result).sum())))
        while self.load is not None:
            full = result >= limit
            weighted = self.weighted(result)
            held, movable = (inner(weighted, part.astype(np.float64)) for part in (full, ~full))
            if self.total <= held:
                # Saturated cells must yield too.
                return np.asarray(result * (self.total / (held + movable)))
            if movable <= _LEAST_MOVABLE * held:
                # All loaded cells are at the limit and carry less than the load.
                return self.projected(result)[0]
            factor = (self.total - held) / movable
            result = np.clip(np.where(full, result, factor * result), 0.0, limit)
            if factor <= 1.0 or np.array_equal(full, result >= limit):
                break
        return result

    def projected(
        self, pressure: Array, compliance: Array | float = 1.0
    ) -> tuple[Array, Array | float]:
        """The nearest pressure within the bounds that carries the load, and the approach it takes.

        It minimises Σ c (p − p₀)² for the compliances c of the cells, m/Pa: p₀ + δ/c, clipped to
        the bounds. Without a given load the approach δ, m, is zero.
        """
        if self.load is None:
            return np.clip(pressure, 0.0, self.limit), 0.0
        weights = self.half_space.geometry.weights
        return projected(pressure, self.limit, self.total, compliance, weights)


@dataclass(frozen=True)
class Contact:
    """The solution of a `ContactProblem`; fields have the shape of the geometry."""

    pressure: Array  #: Pa
    #: g, m; at the pressure limit, negative: the depth by which the bodies yield there.
    gap: Array
    approach: float  #: δ, m
    saturated: Mask  #: cells at the pressure limit
    #: Largest violation of the conditions on the gap over the largest displacement; if verified,
    #: from a convolution of its own.
    residual: float
    convolutions: int  #: half-space convolutions spent
    stiffness: Array | None = None  #: pressure per approach, Pa/m, where it is known

    @property
    def yields(self) -> bool:
        """Whether any cell yields."""
        return bool(self.gap.min(where=self.saturated, initial=0.0) < 0)

    @property
    def penetration(self) -> Array:
        """Depth by which saturated cells yield, m; zero elsewhere."""
        result: Array = np.where(self.saturated, np.maximum(-self.gap, 0.0), 0.0)
        return result


@dataclass(frozen=True)
class Accuracy:
    """Tolerances of the contacts of a run, relative to the largest displacement."""

    contact: float = 1e-6  #: contact at a requested cycle
    contact_between: float = 1e-6  #: contact between requested cycles
    #: Contact of a step's first stage. Its pressure enters the exponent, where a few parts in 10⁵
    #: are far below the error of the step.
    first_stage: float = 3e-5
    first_reduced: float = 1e-8  #: first reduced contact, the only one of an elastic run
    reduced: float = 1e-7  #: reduced contact at a requested cycle
    #: Reduced contact between requested cycles; its error changes wear by less than a part in 10⁷.
    reduced_between: float = 1e-6
    #: Tolerance of the wear when plastic flow and pressure of a stage are iterated, over that of
    #: the step.
    sweep: float = 0.005
    #: The same if the slip follows the approach of the contact: the remaining error is of second
    #: order and of either sign.
    following: float = 0.02
    #: Load beyond the limits that shear lowers, over the load and over that tolerance.
    limit: float = 0.05

    def loosened(self, error: float) -> Accuracy:
        """Tolerances of contacts between requested cycles for a relative error of the results.

        These contacts change wear, dissipation and areas by a twentieth of that error at most.
        Errors above 2 % are treated as 2 %.
        """
        error = min(error, 0.02)
        loosened = {
            "contact_between": max(self.contact_between, 5e-3 * error),
            "first_stage": max(self.first_stage, 5e-3 * error),
            "reduced_between": max(self.reduced_between, 1.5e-3 * error),
        }
        return replace(self, **loosened)

    @property
    def for_errors(self) -> Accuracy:
        """Tolerances of a run whose results only tell the errors of another run."""
        reduced = self.reduced_between
        return replace(self, contact=self.contact_between, first_reduced=reduced, reduced=reduced)


@singledispatch
def solve_on(
    half_space: HalfSpace,
    problem: ContactProblem,
    start: Array | None,
    tolerance: float,
    *,
    verified: bool,
) -> Contact:
    """Solve a normal contact by the method of its bodies; see `solve_contact`.

    ``start`` is a first guess of the pressure, or None.
    """
    raise NotImplementedError(f"no method solves contacts of a {type(half_space).__name__}")


def solve_contact(
    problem: ContactProblem,
    start: Array | None = None,
    tolerance: float = 1e-6,
    *,
    verified: bool = True,
) -> Contact:
    """Solve a normal contact.

    Parameters
    ----------
    problem
        The contact to solve.
    start
        A first guess of the pressure, Pa, such as the solution of a similar problem.
    tolerance
        Largest violation of the conditions on the gap, relative to the largest displacement.
    verified
        Whether to recompute the displacement of the result by a convolution. The displacement that
        is updated from step to step is accurate to a tenth of the tolerance.

    Raises
    ------
    ContactError
        If the limit cannot carry the load on this geometry, or no method converges.
    ValueError
        If the shape or the start is not finite.
    """
    half_space = problem.half_space
    if not (is_finite(problem.shape) and (start is None or is_finite(start))):
        raise ValueError("the shape and the start of a contact problem must be finite everywhere")
    geometry = half_space.geometry
    if problem.load is not None:
        highest = float(np.max(problem.limit))
        if not geometry.integral(np.broadcast_to(problem.limit, geometry.shape)) > problem.load:
            raise ContactError(
                f"a pressure limit of {highest:.4g} Pa cannot carry {problem.load:.4g} N on "
                f"a window of half-widths {geometry.extent[0]:.3g} m and {geometry.extent[1]:.3g} m"
            )
    if start is not None and float(start.max()) * start.size <= _NEGLIGIBLE * problem.total:
        start = None
    return solve_on(half_space, problem, start, tolerance, verified=verified)


def is_finite(values: Array) -> bool:
    """Whether all values of a field and their sum are finite."""
    return bool(np.isfinite(values.sum()))
