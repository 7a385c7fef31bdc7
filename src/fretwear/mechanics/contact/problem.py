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

import numpy as np

from fretwear.arrays import Array, Places
from fretwear.mechanics.contact.cells import Contact, ContactError, ContactProblem
from fretwear.mechanics.contact.kernels import inner

# A start that carries less than this part of the load is no guess of the pressure.
_NEGLIGIBLE = 1e-6
# Largest number of steps of the projected gradient, and number of latest energies: a step must
# undercut the largest of them.
_LARGEST_STEPS, _MEMORY = 2000, 10


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
