"""Dense contact of rectangular cells, normal and tangential, for grids small enough to factorize.

Both problems by active sets with direct solves, on the influence coefficients of `oracles`. The
tangential problem is solved for what it is, |q| ≤ µp and no slip below the bound, and knows nothing
of a reduced normal load.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def normal_contact(
    influence: FloatArray, shape: FloatArray, cell: float, load: float
) -> tuple[FloatArray, FloatArray, float]:
    """Pressure (Pa), gap (m) and approach (m) of a rigid shape (m) on the half-space.

    All cells start in contact; cells leave while their pressure pulls, and come back while they
    penetrate. ``cell`` is the area of a cell, m².
    """
    loaded = np.ones(shape.size, dtype=bool)
    for _ in range(100):
        inside = np.flatnonzero(loaded)
        pressure, approach = _solve_with_total(
            influence[np.ix_(inside, inside)], -shape[inside], load / cell
        )
        full = np.zeros_like(shape)
        full[inside] = pressure
        gap = shape + influence @ full - approach
        wanted = np.where(loaded, full > 0.0, gap < 0.0)
        if np.array_equal(wanted, loaded):
            return full, np.where(loaded, 0.0, gap), approach
        loaded = wanted
    raise RuntimeError("the contact set did not settle")


@dataclass(frozen=True, eq=False)
class TangentialStep:
    """Traction at the end of a step (Pa), relative displacement during it (m) and rigid shift."""

    traction: FloatArray
    slip: FloatArray
    displacement: float


def tangential_step(
    influence: FloatArray,
    bound: FloatArray,
    before: FloatArray,
    cell: float,
    force: float | None = None,
    displacement: float = 0.0,
) -> TangentialStep:
    """Bring the tangential force to ``force``, or shift distant points by ``displacement``.

    It starts from a state with the traction ``before``, which need not be that of the same
    pressure. ``influence`` is the tangential one, m/Pa; ``bound`` is µp in Pa, shape (n,). The
    relative displacement of the surfaces in the step is v = δ - K (q - q_before): zero where
    |q| < µp, positive where q = µp, negative where q = -µp.
    """
    touching = bound > 0.0
    # a step that barely moves leaves slipping cells on both bounds at once, up to rounding
    outside = bound + 1e-12 * bound.max()
    upper, lower = np.zeros_like(touching), np.zeros_like(touching)
    for _ in range(200):
        traction = np.where(upper, bound, np.where(lower, -bound, 0.0))
        stick = np.flatnonzero(touching & ~upper & ~lower)
        matrix, forced = influence[np.ix_(stick, stick)], influence[stick] @ (traction - before)
        if force is None:
            traction[stick] = np.linalg.solve(matrix, displacement - forced)
        else:
            total = force / cell - traction.sum()
            traction[stick], displacement = _solve_with_total(matrix, -forced, total)
        slip = displacement - influence @ (traction - before)
        above = np.where(upper, slip >= 0.0, ~lower & touching & (traction > outside))
        below = np.where(lower, slip <= 0.0, ~upper & touching & (traction < -outside))
        if np.array_equal(above, upper) and np.array_equal(below, lower):
            slip[stick] = 0.0
            return TangentialStep(traction, slip, displacement)
        upper, lower = above, below
    raise RuntimeError("the slip zones did not settle")


def _solve_with_total(
    matrix: FloatArray, right: FloatArray, total: float
) -> tuple[FloatArray, float]:
    """Solve K z - λ = right with Σz = total for z and λ."""
    size = right.size
    system = np.zeros((size + 1, size + 1))
    # K in units of its own diagonal, so that both kinds of rows weigh alike
    scale = matrix[0, 0]
    system[:size, :size] = matrix / scale
    system[:size, size] = -1.0
    system[size, :size] = 1.0
    solution = np.linalg.solve(system, np.append(right / scale, total))
    return solution[:size], float(solution[size] * scale)
