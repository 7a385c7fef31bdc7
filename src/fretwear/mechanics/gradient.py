"""Spectral projected gradient: slow, but convergent from anywhere.

Birgin, Martínez and Raydan, "Nonmonotone spectral projected gradient methods on convex sets",
SIAM J. Optim. 10 (2000), for the convex program of the normal contact: the set
{0 ≤ p ≤ p_lim, ∑p = P} is convex, its projection a shift and a clipping. The contact solver
comes here when its own method stalls.
"""

from __future__ import annotations

from collections import deque

import numpy as np

from fretwear.mechanics.arrays import Array
from fretwear.mechanics.contact_problem import ContactProblem
from fretwear.mechanics.passes import inner

_LARGEST_STEPS = 2000
_MEMORY = 10


def projected_gradient(
    problem: ContactProblem, start: Array, tolerance: float, largest_steps: int = _LARGEST_STEPS
) -> Array:
    """Pressure of a normal contact by the spectral projected gradient.

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
    half_space = problem.half_space
    pressure = project(start, problem.limit, problem.total)
    displacement = half_space.displacement(pressure)
    gradient = problem.separation(pressure, displacement)
    stiffness = 1.0 / half_space.self_influence
    length = stiffness
    energies: deque[float] = deque([0.0], maxlen=_MEMORY)
    energy = 0.0
    for _ in range(largest_steps):
        move = project(pressure - stiffness * gradient, problem.limit, problem.total) - pressure
        if np.abs(move).max() <= tolerance * stiffness * displacement.max():
            break
        step = project(pressure - length * gradient, problem.limit, problem.total) - pressure
        moved = half_space.displacement(step)
        slope = inner(gradient, step)
        fraction = 1.0
        while True:
            trial = pressure + fraction * step
            new_gradient = problem.separation(trial, displacement + fraction * moved)
            # The energy itself would need the layer's potential; its change by Simpson's rule
            # from three gradients on the segment needs none.
            middle = problem.separation(
                pressure + 0.5 * fraction * step, displacement + 0.5 * fraction * moved
            )
            change = fraction * inner(step, gradient + 4.0 * middle + new_gradient) / 6.0
            if energy + change <= max(energies) + 1e-4 * fraction * slope or fraction < 1e-6:
                break
            fraction *= 0.5
        difference = new_gradient - gradient
        curvature = inner(step, difference) * fraction
        size = inner(step, step) * fraction**2
        length = stiffness * 1e3 if curvature <= 0 else min(size / curvature, stiffness * 1e3)
        pressure = trial
        displacement = displacement + fraction * moved
        gradient = new_gradient
        energy += change
        energies.append(energy)
    return pressure


def project(pressure: Array, limit: float, total: float) -> Array:
    """The nearest pressure (least squares) within 0 … limit, Pa, whose sum is ``total``, Pa."""
    low, high = -float(pressure.max()), total / pressure.size - float(pressure.min())
    if np.isfinite(limit):
        high = limit - float(pressure.min())
    shift = 0.0
    result = np.clip(pressure, 0.0, limit)
    for _ in range(200):
        missing = total - float(result.sum())
        if abs(missing) <= 1e-14 * total:
            break
        if missing > 0:
            low = shift
        else:
            high = shift
        free = np.count_nonzero((result > 0) & (result < limit))
        newton = shift + missing / free if free else np.inf
        shift = newton if low < newton < high else 0.5 * (low + high)
        result = np.clip(pressure + shift, 0.0, limit)
    return result
