"""Normal contact under a given load or at a given approach: pressure between zero and a limit.

Find the pressure p and the approach δ with

    g = K p + W(p) + h − δ,   ∬p = P,   0 ≤ p ≤ p_lim,
    g = 0 where 0 < p < p_lim,   g ≥ 0 where p = 0,   g ≤ 0 where p = p_lim

for the half-space K, a shape h and a layer W. It is the optimality condition of a convex
program. The active-set method of `fretwear.mechanics.active_set` solves it; where that stalls,
the slower projected gradient brings it on its way again.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from fretwear.mechanics.active_set import ActiveSet
from fretwear.mechanics.geometry import Array, HalfSpace, Mask, Single
from fretwear.mechanics.kernels import inner, scale_and_clip

_COARSE = 1e-2
_NEGLIGIBLE = 1e-6
# Free cells that carry less of the load than this cannot be scaled to carry what is missing.
_NOTHING = 1e-12
_LARGEST_SCALINGS = 100
_MEMORY = 10


@dataclass(frozen=True)
class Effort:
    """How many steps a contact may take: of the active set, and of the projected gradient."""

    active_set: int = 60
    gradient: int = 2000


@dataclass(frozen=True)
class Accuracy:
    """Tolerances of the contacts of a run, relative to the largest displacement.

    Attributes
    ----------
    contact
        Of the contact of a state.
    first_stage
        Of the contact of a step's first stage: its pressure enters the exponent, some parts in
        10⁵ of which are far below any error of the step.
    first_reduced
        Of the first reduced contact: an elastic run solves it once and lives on it for ever.
    reduced
        Of the reduced contact at a requested cycle.
    reduced_between
        Of the reduced contact between requested cycles: its error moves wear by less than a part
        in 10⁷.
    sweep
        Of the wear that plastic flow and the pressure of a stage settle on in turn, relative to
        the tolerance of the step.
    effort
        Steps that a contact may take.
    """

    contact: float = 1e-6
    first_stage: float = 3e-5
    first_reduced: float = 1e-8
    reduced: float = 1e-7
    reduced_between: float = 1e-6
    sweep: float = 0.005
    effort: Effort = field(default_factory=Effort)

    @classmethod
    def uniform(cls, tolerance: float) -> Accuracy:
        """Every contact to the same tolerance."""
        return cls(tolerance, tolerance, tolerance, tolerance, tolerance)


class ContactError(RuntimeError):
    """No pressure distribution satisfies the conditions of contact to the tolerance asked for.

    Attributes
    ----------
    convolutions
        Half-space convolutions spent in vain.
    """

    def __init__(self, message: str, convolutions: int = 0) -> None:
        super().__init__(message, convolutions)
        self.convolutions = convolutions

    def __str__(self) -> str:
        return str(self.args[0])


class Layer(Protocol):
    """Local compliance between the bodies: a displacement that depends on its cell's pressure.

    It grows with pressure, so the contact problem stays convex.
    """

    def displacement(self, pressure: Array) -> Array:
        """Displacement, m, under a pressure, Pa; both of the geometry's shape."""
        ...

    def add_displacement(self, pressure: Array, result: Array) -> None:
        """Add the displacement under a pressure to a field."""
        ...

    def tangent_in(self, unit: float, pressure: Array) -> Single:
        """Derivative of the displacement in some unit, m/Pa; not negative."""
        ...


@dataclass(frozen=True)
class ContactProblem:
    """A normal contact.

    Parameters
    ----------
    half_space
        The elastic bodies on a geometry.
    shape
        Gap at zero load and zero approach, m, shape of the geometry.
    load
        Normal load P of the whole contact, N; None where the approach is given.
    limit
        Largest pressure, Pa; infinite when elastic.
    layer
        Local compliance, or None.
    approach
        δ, m, if given instead of a load.
    """

    half_space: HalfSpace
    shape: Array
    load: float | None
    limit: float = np.inf
    layer: Layer | None = None
    approach: float | None = None

    def __post_init__(self) -> None:
        if (self.load is None) == (self.approach is None):
            raise ValueError("a contact problem is given either a load or an approach")

    @property
    def total(self) -> float:
        """Weighted sum of the pressure over the cells that carries the load, Pa."""
        area: float = self.half_space.geometry.unit_area
        return (self.load or 0.0) / area

    def separation(self, pressure: Array, displacement: Array) -> Array:
        """K p + W(p) + h, m: the gap plus the approach."""
        result = displacement + self.shape
        if self.layer is not None:
            self.layer.add_displacement(pressure, result)
        return result

    def weighted(self, values: NDArray[Any]) -> NDArray[Any]:
        """A field times the weights of the cells."""
        weights: Array | None = self.half_space.geometry.weights
        return values if weights is None else weights * values

    def clip_to_load(self, pressure: Array) -> Array:
        """The pressure cut to the bounds, its free cells scaled so that it carries the load.

        Scaling leaves open cells open and saturated cells saturated; a shift would free them.
        """
        limit, total = self.limit, self.total
        weights: Array | None = self.half_space.geometry.weights
        result = pressure.copy()
        carried, saturated = scale_and_clip(1.0, limit, np.inf, weights, result)
        for _ in range(_LARGEST_SCALINGS if self.load is not None else 0):
            missing = total - carried
            if abs(missing) <= 1e-14 * total:
                break
            movable = carried - limit * saturated if saturated else carried
            factor, rigid = 1.0, np.inf
            if movable <= -missing:
                # Saturated cells have to give way too.
                factor = total / carried
            elif movable <= _NOTHING * carried:
                # All loaded cells are at the limit and still do not carry the load.
                np.maximum(result, 1e-3 * limit, out=result)
            else:
                factor, rigid = 1.0 + missing / movable, limit
            carried, saturated = scale_and_clip(factor, limit, rigid, weights, result)
        return result


@dataclass(frozen=True)
class Contact:
    """The solution of a `ContactProblem`.

    Attributes
    ----------
    pressure, gap
        Pa and m, shape of the geometry. The gap is negative where the pressure is at its limit:
        there the bodies yield by its absolute value.
    approach
        δ, m.
    saturated
        Cells at the pressure limit.
    residual
        Largest violation of the conditions on the gap, relative to the largest displacement; if
        verified, from a convolution made for this purpose.
    iterations, convolutions
        Conjugate-gradient steps and half-space convolutions spent.
    """

    pressure: Array
    gap: Array
    approach: float
    saturated: Mask
    residual: float
    iterations: int
    convolutions: int

    @property
    def yields(self) -> bool:
        """Whether any cell yields."""
        return bool(self.gap.min(where=self.saturated, initial=0.0) < 0)

    @property
    def penetration(self) -> Array:
        """Depth by which saturated cells yield, m, zero elsewhere."""
        result: Array = np.where(self.saturated, np.maximum(-self.gap, 0.0), 0.0)
        return result


def solve_contact(
    problem: ContactProblem,
    start: Array | None = None,
    tolerance: float = 1e-6,
    *,
    verified: bool = True,
    effort: Effort | None = None,
) -> Contact:
    """Solve a normal contact.

    Parameters
    ----------
    problem
        What to solve.
    start
        A first guess of the pressure, Pa, for example the solution of a similar problem.
    tolerance
        Largest violation of the conditions on the gap, relative to the largest displacement.
    verified
        Whether to compute the displacement of the result once more by a convolution. The one that
        was carried along from step to step is good to a tenth of the tolerance.
    effort
        Steps that it may take.

    Returns
    -------
    Contact

    Raises
    ------
    ContactError
        If the limit cannot carry the load on this geometry, or nothing converges.
    ValueError
        If the shape or the start is not finite.
    """
    effort = effort or Effort()
    if not (is_finite(problem.shape) and (start is None or is_finite(start))):
        raise ValueError("the shape and the start of a contact problem must be finite everywhere")
    geometry = problem.half_space.geometry
    if problem.load is not None:
        capacity = geometry.integral(np.ones_like(problem.shape))
        if not problem.limit * capacity > problem.load:
            raise ContactError(
                f"a pressure limit of {problem.limit:.4g} Pa cannot carry {problem.load:.4g} N on "
                f"a window of half-widths {geometry.extent[0]:.3g} m and {geometry.extent[1]:.3g} m"
            )
    spent = (0, 0)
    if start is None or float(start.max()) * start.size <= _NEGLIGIBLE * problem.total:
        start = _first_guess(problem)
        if np.isfinite(problem.limit):
            # Both bounds at once from far away lead to wrong sets: yield from the elastic state.
            elastic = ActiveSet(replace(problem, limit=np.inf), start)
            elastic.solve(_COARSE, effort.active_set, verified=False)
            start, spent = elastic.pressure, (elastic.iterations, elastic.convolutions)
    method = ActiveSet(problem, start)
    if not method.solve(tolerance, effort.active_set, verified=verified):
        method.restart(projected_gradient(problem, method.pressure, tolerance, effort.gradient))
        if not method.solve(tolerance, effort.active_set, verified=verified):
            raise ContactError(
                f"the normal contact did not converge: residual {method.residual:.2e} instead "
                f"of {tolerance:.0e} after {method.convolutions} convolutions",
                method.convolutions,
            )
    return Contact(
        pressure=method.pressure,
        gap=method.gap,
        approach=method.approach,
        saturated=method.saturated,
        residual=method.residual,
        iterations=method.iterations + spent[0],
        convolutions=method.convolutions + spent[1],
    )


def is_finite(values: Array) -> bool:
    """Whether every value of a field is finite, and their sum."""
    return bool(np.isfinite(values.sum()))


def _first_guess(problem: ContactProblem) -> Array:
    """A pressure that grows with depth.

    Under a load it lies on the lowest fifth of the surface, in an arbitrary scale; at a given
    approach on all that lies below it, as large as makes the least energy.
    """
    shape = problem.shape
    level = problem.approach
    if level is None:
        level = float(np.quantile(shape, 0.2))
    guess: Array = np.maximum(level - shape, 0.0)
    if problem.approach is not None:
        stiff = inner(guess, problem.weighted(problem.half_space.displacement(guess)))
        return guess * (inner(guess, problem.weighted(guess)) / stiff) if stiff > 0 else guess
    # A flat surface has no lowest fifth.
    return guess if guess.any() else np.ones_like(shape)


def projected_gradient(
    problem: ContactProblem, start: Array, tolerance: float, largest_steps: int
) -> Array:
    """Pressure of a normal contact by the spectral projected gradient: slow, but from anywhere.

    Birgin, Martínez and Raydan, "Nonmonotone spectral projected gradient methods on convex sets",
    SIAM J. Optim. 10 (2000), for the convex program of the normal contact: the set
    {0 ≤ p ≤ p_lim, ∑p = P} is convex, its projection a shift and a clipping.

    Parameters
    ----------
    problem
        What to solve.
    start
        A first guess of the pressure, Pa.
    tolerance
        Stops when a gradient step of the size of one cell's own compliance changes the gap by
        less than this part of the largest displacement.
    largest_steps
        Stops after so many steps in any case; the caller judges the result.

    Returns
    -------
    Array, Pa, within the bounds and of the right sum.
    """
    half_space, level = problem.half_space, problem.approach or 0.0
    pressure = project(problem, start)
    displacement = half_space.displacement(pressure)
    gradient = problem.separation(pressure, displacement) - level
    stiffness = 1.0 / half_space.self_influence
    length = stiffness
    energies: deque[float] = deque([0.0], maxlen=_MEMORY)
    energy = 0.0
    for _ in range(largest_steps):
        move = project(problem, pressure - stiffness * gradient) - pressure
        if np.abs(move).max() <= tolerance * stiffness * displacement.max():
            break
        step = project(problem, pressure - length * gradient) - pressure
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
            change = fraction * inner(weighted, gradient + 4.0 * middle + new_gradient) / 6.0
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


def project(problem: ContactProblem, pressure: Array) -> Array:
    """The nearest pressure (least squares) within the bounds that carries the load."""
    limit, total = problem.limit, problem.total
    result: Array = np.clip(pressure, 0.0, limit)
    if problem.load is None:
        return result
    area = float(problem.weighted(np.ones_like(pressure)).sum())
    low, high = -float(pressure.max()), total / area - float(pressure.min())
    if np.isfinite(limit):
        high = limit - float(pressure.min())
    shift = 0.0
    for _ in range(200):
        missing = total - float(problem.weighted(result).sum())
        if abs(missing) <= 1e-14 * total:
            break
        if missing > 0:
            low = shift
        else:
            high = shift
        free = float(problem.weighted((result > 0) & (result < limit)).sum())
        newton = shift + missing / free if free else np.inf
        shift = newton if low < newton < high else 0.5 * (low + high)
        result = np.clip(pressure + shift, 0.0, limit)
    return result
