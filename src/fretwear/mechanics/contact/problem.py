"""Normal contact under a given load or at a given approach: pressure between zero and a limit.

Find the pressure p and the approach δ with

    g = K p + W(p) + h − δ,   ∬p = P,   0 ≤ p ≤ p_lim,
    g = 0 where 0 < p < p_lim,   g ≥ 0 where p = 0,   g ≤ 0 where p = p_lim

for the half-space K, a shape h and a layer W. It is the optimality condition of a convex
program. Each half-space solves it by its own method, and by the projected gradient where that
stalls.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from fretwear.arrays import Array, Mask, Places, Real, Single
from fretwear.mechanics.contact.cells import HalfSpace
from fretwear.mechanics.contact.kernels import inner

# A start that carries less than this part of the load is no guess of the pressure.
_NEGLIGIBLE = 1e-6
# Largest number of steps of the projected gradient, and number of latest energies: a step must
# undercut the largest of them.
_LARGEST_STEPS, _MEMORY = 2000, 10
# Free cells that carry less than this part of the load cannot be scaled to carry the rest.
_LEAST_MOVABLE = 1e-12
_LARGEST_SCALINGS = 100


@dataclass(frozen=True)
class Accuracy:
    """Tolerances of the contacts of a run, relative to the largest displacement."""

    contact: float = 1e-6  #: contact of a state at a requested cycle
    contact_between: float = 1e-6  #: contact of a state between requested cycles
    #: Contact of a step's first stage. Its pressure enters the exponent, where a few parts in 10⁵
    #: are far below the error of the step.
    first_stage: float = 3e-5
    first_reduced: float = 1e-8  #: first reduced contact, the only one of an elastic run
    reduced: float = 1e-7  #: reduced contact at a requested cycle
    #: Reduced contact between requested cycles: its error changes wear by less than a part in 10⁷.
    reduced_between: float = 1e-6
    #: Wear in the iteration between plastic flow and pressure of a stage, relative to the tolerance
    #: of the step.
    sweep: float = 0.005
    #: The same if the contact accounts for slip that follows its approach: the remaining error is
    #: of second order and of either sign.
    following: float = 0.02
    #: Load beyond the limits that shear lowers, relative to the load and to that tolerance.
    limit: float = 0.05

    def within(self, error: float) -> Accuracy:
        """Contacts between requested cycles as accurate as a relative error of results calls for.

        They change wear, dissipation and areas by a twentieth of that error at most; beyond 2 %
        they are as accurate as for 2 %.
        """
        error = min(error, 0.02)
        between = {
            "contact_between": max(self.contact_between, 5e-3 * error),
            "first_stage": max(self.first_stage, 5e-3 * error),
            "reduced_between": max(self.reduced_between, 1.5e-3 * error),
        }
        return replace(self, **between)


class ContactError(RuntimeError):
    """No pressure distribution was found that satisfies the contact conditions to the tolerance.

    ``convolutions`` is the number of half-space convolutions spent on it.
    """

    def __init__(self, message: str, convolutions: int = 0) -> None:
        super().__init__(message)
        self.convolutions = convolutions


class Layer(Protocol):
    """Local compliance between the bodies: a displacement that depends on its cell's pressure.

    It grows with pressure, so the contact problem stays convex.
    """

    # Approach of the bodies at which the layer holds, m; None if it does not depend on it.
    level: float | None = None

    def at(self, approach: float) -> Layer:  # noqa: ARG002 - as a rule
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

    def tangent_in(self, unit: float, pressure: Array) -> Single:
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

    def separation(self, pressure: Array, displacement: Array) -> Array:
        """K p + W(p) + h, m: the gap plus the approach."""
        result = displacement + self.shape
        if self.layer is not None:
            self.layer.add_displacement(pressure, result)
        return result

    def first_guess(self) -> Array:
        """A pressure that grows with depth, shape of the geometry.

        Under a load it acts on the lowest fifth of the surface, in an arbitrary scale; at a given
        approach on everything below it, scaled to minimal energy.
        """
        shape, given, half_space = self.shape, self.approach, self.half_space
        level = float(np.quantile(shape, 0.2)) if given is None else given
        guess: Array = np.maximum(level - shape, 0.0)
        if given is not None:
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
        """The pressure clipped to the bounds, its free cells scaled so that it carries the load.

        Scaling leaves open cells open and saturated cells saturated; a shift would free them.
        """
        limit, total, result = self.limit, self.total, np.clip(pressure, 0.0, self.limit)
        for _ in range(_LARGEST_SCALINGS if self.load is not None else 0):
            carried = float(self.weighted(result).sum())
            missing = total - carried
            if abs(missing) <= 1e-14 * total:
                break
            full: Mask = result >= limit
            movable = carried - float(self.weighted(result)[full].sum())
            if movable <= -missing:
                # Saturated cells must yield too.
                result = np.clip(result * (total / carried), 0.0, limit)
            elif movable <= _LEAST_MOVABLE * carried:
                # All loaded cells are at the limit and still do not carry the load.
                np.maximum(result, 1e-3 * limit, out=result)
            else:
                factor = np.where(full, 1.0, 1.0 + missing / movable)
                result = np.clip(result * factor, 0.0, limit)
        return result

    def projected(self, pressure: Array) -> Array:
        """The nearest pressure (least squares) within the bounds that carries the load."""
        from scipy.optimize import brentq

        if self.load is None:
            return np.clip(pressure, 0.0, self.limit)
        area = float(self.weighted(np.ones_like(pressure)).sum())
        most = min(float(np.max(self.limit)), 2.0 * self.total / area)

        def excess(shift: float) -> float:
            carried = self.weighted(np.clip(pressure + shift, 0.0, self.limit)).sum()
            return float(carried) - self.total

        shift = brentq(excess, -float(pressure.max()), most - float(pressure.min()), maxiter=200)
        result: Array = np.clip(pressure + shift, 0.0, self.limit)
        return result


@dataclass(frozen=True)
class Contact:
    """The solution of a `ContactProblem`; fields have the shape of the geometry."""

    pressure: Array  #: Pa
    #: m; where the pressure is at its limit, negative: the bodies yield there by its magnitude.
    gap: Array
    approach: float  #: δ, m
    saturated: Mask  #: cells at the pressure limit
    #: Largest violation of the conditions on the gap, relative to the largest displacement; if
    #: verified, from a separate convolution.
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
    return half_space.solve(problem, start, tolerance, verified=verified)


class Exchange:
    """Which of the cells on the wrong side change it, in a method of active sets.

    All of them do. After a number of solutions without a new minimum of such cells, only the
    outermost one does, by which no set repeats: Júdice and Pires, "A block principal pivoting
    algorithm for large-scale strictly monotone linear complementarity problems", Comput. Oper. Res.
    21 (1994).
    """

    def __init__(self, patience: int) -> None:
        self._patience = self._left = patience
        self._fewest: float = np.inf

    def of(self, wrong: Places) -> Places:
        """The cells that change sides, of those that are on the wrong one after a solution."""
        if wrong.size < self._fewest:
            self._fewest, self._left = wrong.size, self._patience
        elif self._left > 0:
            self._left -= 1
        else:
            return wrong[-1:]
        return wrong


def is_finite(values: Array) -> bool:
    """Whether all values of a field and their sum are finite."""
    return bool(np.isfinite(values.sum()))


def projected_gradient(problem: ContactProblem, start: Array, tolerance: float) -> Array:
    """Pressure of a contact by the spectral projected gradient: slow, but globally convergent.

    Birgin, Martínez and Raydan, "Nonmonotone spectral projected gradient methods on convex sets",
    SIAM J. Optim. 10 (2000), for the convex program of the normal contact: the set
    {0 ≤ p ≤ p_lim, ∑p = P} is convex, its projection a shift and a clipping. It stops when a
    gradient step of the size of one cell's own compliance changes the gap by less than the
    tolerance times the largest displacement, or after many steps; the caller judges the result, Pa,
    which lies within the bounds and carries the load, if one is given.
    """
    half_space, level = problem.half_space, problem.approach or 0.0
    pressure = problem.projected(start)
    displacement = half_space.displacement(pressure)
    gradient = problem.separation(pressure, displacement) - level
    stiffness = 1.0 / half_space.self_influence
    length = stiffness
    energies: deque[float] = deque([0.0], maxlen=_MEMORY)
    energy = 0.0
    for _ in range(_LARGEST_STEPS):
        move = problem.projected(pressure - stiffness * gradient) - pressure
        if np.abs(move).max() <= tolerance * stiffness * displacement.max():
            break
        step = problem.projected(pressure - length * gradient) - pressure
        weighted = problem.weighted(step)
        moved = half_space.displacement(step)
        slope = inner(gradient, weighted)
        fraction = 1.0
        while True:
            trial = pressure + fraction * step
            new_gradient = problem.separation(trial, displacement + fraction * moved) - level
            # The energy itself would need the layer's potential; its change by Simpson's rule
            # from three gradients on the segment needs none.
            middle = problem.separation(
                pressure + 0.5 * fraction * step, displacement + 0.5 * fraction * moved
            )
            middle -= level
            mean = (gradient + 4.0 * middle + new_gradient) / 6.0
            change = fraction * inner(weighted, mean)
            if energy + change <= max(energies) + 1e-4 * fraction * slope or fraction < 1e-6:
                break
            fraction *= 0.5
        curvature = inner(weighted, new_gradient - gradient) * fraction
        size = inner(step, weighted) * fraction**2
        length = stiffness * 1e3 if curvature <= 0 else min(size / curvature, stiffness * 1e3)
        pressure = trial
        displacement = displacement + fraction * moved
        gradient = new_gradient
        energy += change
        energies.append(energy)
    return pressure
