"""The solver of the normal contact: usually fast, always convergent.

The active-set method of `fretwear.mechanics.active_set` solves a contact, or a factorization for a
few hundred cells; if that stalls, the slower projected gradient takes over.
"""

from __future__ import annotations

from collections import deque
from dataclasses import replace

import numpy as np

from fretwear.mechanics.active_set import ActiveSet
from fretwear.mechanics.contact import Contact, ContactError, ContactProblem, Effort, is_finite
from fretwear.mechanics.geometry import Array
from fretwear.mechanics.team import kernels

_COARSE = 1e-2
_NEGLIGIBLE = 1e-6
_DIRECT_STEPS = 30
# Plastic flow of a step may be less deep than the tolerance of a contact; a factorization is more
# accurate.
_DIRECTLY = 1e-3
_MEMORY = 10


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
        A first guess of the pressure, Pa, such as the solution of a similar problem.
    tolerance
        Largest violation of the conditions on the gap, relative to the largest displacement.
    verified
        Whether to recompute the displacement of the result by a convolution. The one updated from
        step to step is accurate to a tenth of the tolerance.
    effort
        Limits on the steps.

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
    effort, half_space = effort or Effort(), problem.half_space
    if not (is_finite(problem.shape) and (start is None or is_finite(start))):
        raise ValueError("the shape and the start of a contact problem must be finite everywhere")
    geometry = half_space.geometry
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
        if np.isfinite(problem.limit) and half_space.matrix is None:
            # Both bounds at once from a distant start lead to wrong sets, so yielding starts from
            # the elastic state.
            elastic = ActiveSet(replace(problem, limit=np.inf), start)
            elastic.solve(_COARSE, effort.active_set, verified=False)
            start, spent = elastic.pressure, (elastic.iterations, elastic.convolutions)
    if half_space.matrix is not None:
        found = _directly(problem, start, tolerance)
        if found is None:
            start = projected_gradient(problem, start, tolerance, effort.gradient)
            found = _directly(problem, start, tolerance)
        if found is None:
            raise ContactError(f"the normal contact did not converge in {_DIRECT_STEPS} solutions")
        return found
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


def _directly(problem: ContactProblem, start: Array, tolerance: float) -> Contact | None:
    """Solution by factors of the matrix of the free cells, if there is one; None if it cycles.

    Semismooth Newton: Hintermüller, Ito and Kunisch, "The primal-dual active set strategy as a
    semismooth Newton method", SIAM J. Optim. 13 (2002). Cells leave a bound by the sign of their
    gap, and the free ones by their pressure.
    """
    tolerance *= _DIRECTLY
    half_space, limit, layer = problem.half_space, problem.limit, problem.layer
    matrix = half_space.matrix
    assert matrix is not None
    weights = problem.weighted(np.ones_like(start))[:, 0]
    unit = half_space.self_influence
    pressure = problem.clip_to_load(start)[:, 0]
    free = (pressure > 0.0) & (pressure < limit)
    displacement = half_space.displacement(pressure[:, None])
    approach, follows = problem.approach or 0.0, False
    if layer is not None and layer.level is not None:
        approach, follows = layer.level, True
    for step in range(1, _DIRECT_STEPS + 1):
        cells = np.flatnonzero(free)
        if not cells.size:
            return None
        separation = problem.separation(pressure[:, None], displacement)[:, 0]
        block = matrix[np.ix_(cells, cells)]
        if layer is not None:
            tangent = layer.tangent_in(unit, pressure[:, None], half_space.team)[:, 0]
            block[np.diag_indices(cells.size)] += weights[cells] * tangent[cells]
        right = np.stack([-separation[cells] / unit, np.ones(cells.size)], axis=1)
        if layer is not None and follows:
            slope = layer.per_approach(pressure[:, None])[cells, 0]
            right += np.stack([approach / unit * slope, -slope], axis=1)
        moved, uniform = np.linalg.solve(block, weights[cells, None] * right).T
        level = approach / unit
        if problem.load is not None:
            missing = problem.total - weights @ pressure
            level = (missing - weights[cells] @ moved) / (weights[cells] @ uniform)
        if layer is not None and follows:
            approach = float(level * unit)
            layer = layer.at(approach)
            problem = replace(problem, layer=layer)
        change = np.zeros_like(pressure)
        change[cells] = moved + level * uniform
        wanted = pressure + change
        displacement = half_space.displacement(wanted[:, None])
        gap = problem.shape[:, 0] + displacement[:, 0] - level * unit
        if layer is not None:
            bounded = np.clip(wanted, 0.0, limit)
            gap += layer.displacement(bounded[:, None])[:, 0]
        scale = float(np.abs(displacement).max())
        worst = float(np.abs(gap[cells]).max())
        margin = 0.3 * tolerance * scale
        low, high = wanted <= 0.0, wanted >= limit
        stays = free & ~low & ~high
        now = stays | (~free & low & (gap < -margin)) | (~free & high & (gap > margin))
        pressure = np.clip(wanted, 0.0, limit)
        if (now == free).all() and worst <= tolerance * scale:
            beyond = -float(gap[low].min(initial=0.0)), float(gap[high].max(initial=0.0))
            residual = max(worst, *beyond) / scale
            gap[cells] = 0.0
            stiffness = np.zeros_like(pressure)
            stiffness[cells] = uniform / unit
            return Contact(
                pressure[:, None],
                gap[:, None],
                float(level * unit),
                high[:, None],
                residual,
                iterations=step,
                convolutions=step,
                stiffness=stiffness[:, None],
            )
        if not (stays == free).all():
            displacement = half_space.displacement(pressure[:, None])
        free = now
    return None


def _first_guess(problem: ContactProblem) -> Array:
    """A pressure that grows with depth.

    Under a load it acts on the lowest fifth of the surface, in an arbitrary scale; at a given
    approach on everything below it, scaled to minimal energy.
    """
    shape = problem.shape
    level = problem.approach
    if level is None:
        level = float(np.quantile(shape, 0.2))
    guess: Array = np.maximum(level - shape, 0.0)
    if problem.approach is not None:
        team = problem.half_space.team
        moved = problem.half_space.displacement(guess)
        stiff = kernels.inner(team, guess, problem.weighted(moved))
        work = kernels.inner(team, guess, problem.weighted(guess))
        return guess * (work / stiff) if stiff > 0 else guess
    # A flat surface has no lowest fifth.
    return guess if guess.any() else np.ones_like(shape)


def projected_gradient(
    problem: ContactProblem, start: Array, tolerance: float, largest_steps: int
) -> Array:
    """Pressure of a contact by the spectral projected gradient: slow, but globally convergent.

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
        Stops when a gradient step of the size of one cell's own compliance changes the gap by less
        than this fraction of the largest displacement.
    largest_steps
        Limit on the number of steps; the caller judges the result.

    Returns
    -------
    Array, Pa, within the bounds and of the right sum.
    """
    half_space, level = problem.half_space, problem.approach or 0.0
    team = half_space.team
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
        slope = kernels.inner(team, gradient, weighted)
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
            change = fraction * kernels.inner(team, weighted, mean)
            if energy + change <= max(energies) + 1e-4 * fraction * slope or fraction < 1e-6:
                break
            fraction *= 0.5
        curvature = kernels.inner(team, weighted, new_gradient - gradient) * fraction
        size = kernels.inner(team, step, weighted) * fraction**2
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
