"""Methods for any normal contact: which cells change sides, and accelerated projected gradients."""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

import numpy as np

from fretwear.arrays import Array, Places
from fretwear.mechanics.contact.kernels import inner
from fretwear.mechanics.contact.problem import Contact, ContactError, ContactProblem, Layer
from fretwear.theory import find_root

# Largest number of convolutions of projected gradients.
_LARGEST_STEPS = 20000


class Exchange:
    """Choose which of the wrong cells change sides, in a method of active sets.

    All of them do, until a number of solutions have brought no new minimum of their count. Then
    only the outermost one does, so that no set repeats: Júdice and Pires, "A block principal
    pivoting algorithm for large-scale strictly monotone linear complementarity problems", Comput.
    Oper. Res. 21 (1994).
    """

    def __init__(self, patience: int) -> None:
        self._patience = self._left = patience
        self._fewest: float = np.inf

    def of(self, wrong: Places) -> Places:
        """The cells that change sides, among those on the wrong side after a solution."""
        if wrong.size < self._fewest:
            self._fewest, self._left = wrong.size, self._patience
        elif self._left > 0:
            self._left -= 1
        else:
            return wrong[-1:]
        return wrong


def projected_gradients(problem: ContactProblem, start: Array, tolerance: float) -> Contact:
    """Solve a contact by accelerated projected gradients: slowly, but from any start.

    The energy is convex. Its gradient, the separation less the approach, is projected on the
    pressures within the bounds that carry the load: Beck and Teboulle, SIAM J. Imaging Sci. 2
    (2009), restarted as by O'Donoghue and Candès, Found. Comput. Math. 15 (2015). Each cell is
    weighted by its own compliance; after a step that is too long this is raised until the next
    restart. Errors as of `solve_contact`.

    A layer that follows the approach gets thinner as the approach grows. The approach of the
    contact therefore falls as that of the layer grows, and a bracket finds where both agree.
    """
    layer, spent = problem.layer, 0
    if layer is None or layer.level is None:
        return descend(problem, problem.half_space, start, tolerance)
    if problem.approach is not None:
        problem = replace(problem, layer=layer.at(problem.approach))
        return descend(problem, problem.half_space, start, tolerance)
    followed, contact = layer, None

    def rises(level: float) -> float:
        nonlocal contact, spent
        guess = start if contact is None else contact.pressure
        now = replace(problem, layer=followed.at(level))
        contact = descend(now, now.half_space, guess, tolerance)
        spent += contact.convolutions
        rise = contact.approach - level
        return 0.0 if abs(rise) <= tolerance * abs(level) else rise

    ends = layer.level, layer.level + rises(layer.level)
    if ends[0] != ends[1]:
        rises(find_root(rises, min(ends), max(ends)))
    assert contact is not None
    return replace(contact, convolutions=spent)


class CompliantBodies(Protocol):
    """Displacements of a pressure, linear and positive definite, as of a `HalfSpace`."""

    self_influence: float

    def displacement(self, pressure: Array) -> Array:
        """Displacement, m, under a pressure, Pa."""


class PressureProblem(Protocol):
    """Pressures within bounds that carry loads, as of a `ContactProblem`."""

    @property
    def shape(self) -> Array:
        """Gap without pressure and approach, m."""

    @property
    def limit(self) -> float | Array:
        """Largest pressure, Pa."""

    @property
    def layer(self) -> Layer | None:
        """Local compliance."""

    @property
    def approach(self) -> float | None:
        """Approach, m, if it is given."""

    def weighted(self, values: Array) -> Array:
        """A field times the weights of the cells."""

    def projected(self, pressure: Array, compliance: Array) -> tuple[Array, Array | float]:
        """See `ContactProblem.projected`."""


def descend(
    problem: PressureProblem, half_space: CompliantBodies, start: Array, tolerance: float
) -> Contact:
    """Solve a contact under a layer that does not follow the approach; see `projected_gradients`.

    Several contacts may be solved as one, each with its own approach; the result has their mean.
    """
    layer, unit, limit = problem.layer, half_space.self_influence, problem.limit
    approach: Array | float = problem.approach or 0.0
    compliance, growth, momentum, error, convolutions = np.zeros_like(start), 1.0, 1.0, np.inf, 1

    def separated(pressure: Array, moved: Array) -> Array:
        # Beyond the bounds, where a layer is not defined, it continues as a convex function.
        result = moved + problem.shape
        if layer is not None:
            layer.add_displacement(np.clip(pressure, 0.0, limit), result)
        return result

    def softened(pressure: Array) -> Array:
        """The compliance of each cell, with the tangent of the layer."""
        own = np.full_like(pressure, unit)
        if layer is not None:
            own += unit * layer.scaled_tangent(unit, np.clip(pressure, 0.0, limit))
        return np.maximum(compliance, own)

    def violated(pressure: Array, gap: Array, displacement: Array) -> float:
        """The largest of g at positive pressure and of −g below the limit, as in `Contact`."""
        excess = gap[pressure > 0.0].max(initial=0.0), -gap[pressure < limit].min(initial=0.0)
        return float(max(excess)) / max(float(np.abs(displacement).max()), np.finfo(float).tiny)

    pressure = ahead = problem.projected(start, np.ones_like(start))[0]
    moved = ahead_moved = half_space.displacement(pressure)
    while convolutions < _LARGEST_STEPS:
        separation, compliance = separated(ahead, ahead_moved), softened(ahead)
        noise = 4.0 * np.finfo(float).eps * float(np.abs(separation).max())
        while True:
            metric = growth * compliance
            target, shift = problem.projected(ahead - (separation - approach) / metric, metric)
            step = target - ahead
            moved_by, weighted = half_space.displacement(step), problem.weighted(step)
            convolutions += 1
            target_gap = separated(target, ahead_moved + moved_by)
            square, work = inner(metric * step, weighted), inner(moved_by, weighted)
            # Twice the energy that the curvature of a layer adds is a bound.
            lost = inner(target_gap - separation - moved_by, weighted)
            work += 2.0 * max(lost - noise * float(np.abs(weighted).sum()), 0.0)
            if work <= square or convolutions >= _LARGEST_STEPS:
                break
            softer = softened(target)
            if (softer > 1.1 * compliance).any():
                compliance = softer
            else:
                growth *= max(1.1 * work / square, 1.1)
        approach = approach + shift
        displacement = ahead_moved + moved_by
        error = violated(target, target_gap - approach, displacement)
        if error <= tolerance:
            # Displacements are updated from step to step, so the last one is computed anew.
            displacement = half_space.displacement(target)
            convolutions += 1
            gap = separated(target, displacement) - approach
            error = violated(target, gap, displacement)
            if error <= tolerance:
                return Contact(
                    pressure=target,
                    gap=gap,
                    approach=float(np.mean(approach)),
                    saturated=target >= limit,
                    residual=error,
                    convolutions=convolutions,
                )
            target, moved, pressure, momentum = target, displacement, target, 1.0
        change = target - pressure
        previous = momentum
        if inner(metric * step, problem.weighted(change)) < 0.0:
            previous, compliance = 1.0, np.zeros_like(start)
        momentum = 0.5 + np.sqrt(0.25 + previous**2)
        part = (previous - 1.0) / momentum
        ahead, ahead_moved = target + part * change, displacement + part * (displacement - moved)
        pressure, moved = target, displacement
    raise ContactError(
        f"the normal contact did not converge: residual {error:.2e} instead of {tolerance:.0e} "
        f"after {convolutions} convolutions",
        convolutions,
    )
