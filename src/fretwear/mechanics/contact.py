"""Normal contact under a given load: pressure between zero and a limit.

Find the pressure p and the approach δ with

    g = K p + W(p) + h − δ,   ∬p = P,   0 ≤ p ≤ p_lim,
    g = 0 where 0 < p < p_lim,   g ≥ 0 where p = 0,   g ≤ 0 where p = p_lim

for the half-space K, a shape h and a layer W. It is the optimality condition of a convex
program. The active-set method of `fretwear.mechanics.active_set` solves it; where that stalls,
the slower projected gradient of `fretwear.mechanics.gradient` brings it on its way again.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fretwear.mechanics.active_set import ActiveSet
from fretwear.mechanics.arrays import Array, Mask, is_finite
from fretwear.mechanics.contact_problem import ContactProblem
from fretwear.mechanics.gradient import projected_gradient

_COARSE = 1e-2
_NEGLIGIBLE = 1e-6


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


@dataclass(frozen=True)
class Contact:
    """The solution of a `ContactProblem`.

    Attributes
    ----------
    pressure, gap
        Pa and m, shape of the window. The gap is negative where the pressure is at its limit:
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

    Returns
    -------
    Contact

    Raises
    ------
    ContactError
        If the limit cannot carry the load on this window, or nothing converges.
    ValueError
        If the shape or the start is not finite.
    """
    if not (is_finite(problem.shape) and (start is None or is_finite(start))):
        raise ValueError("the shape and the start of a contact problem must be finite everywhere")
    window = problem.half_space.window
    if not problem.limit * window.cell_area * window.copies * problem.shape.size > problem.load:
        raise ContactError(
            f"a pressure limit of {problem.limit:.4g} Pa cannot carry {problem.load:.4g} N on "
            f"a window of half-widths {window.extent[0]:.3g} m and {window.extent[1]:.3g} m"
        )
    spent = (0, 0)
    if start is None or float(start.max()) * start.size < _NEGLIGIBLE * problem.total:
        start = _first_guess(problem.shape)
        if np.isfinite(problem.limit):
            # Both bounds at once from far away lead to wrong sets: yield from the elastic state.
            elastic = ActiveSet(replace(problem, limit=np.inf), start)
            elastic.solve(_COARSE, verified=False)
            start, spent = elastic.pressure, (elastic.iterations, elastic.convolutions)
    method = ActiveSet(problem, start)
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
        saturated=method.saturated,
        residual=method.residual,
        iterations=method.iterations + spent[0],
        convolutions=method.convolutions + spent[1],
    )


def _first_guess(shape: Array) -> Array:
    """A pressure on the lowest fifth of the surface, growing with depth (arbitrary scale)."""
    level = float(np.quantile(shape, 0.2))
    guess: Array = np.maximum(level - shape, 0.0)
    # A flat surface has no lowest fifth.
    return guess if guess.any() else np.ones_like(shape)
