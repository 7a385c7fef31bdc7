"""The linear problem of the free cells against a dense solve in double precision."""

import numpy as np
import pytest

from fretwear.mechanics.free_cells import FreeCells
from fretwear.mechanics.halfspace import half_space
from fretwear.mechanics.preconditioner import Preconditioner
from fretwear.mechanics.window import Window

from . import oracles
from .problems import folded, matrix_of, unfolded

MODULUS = 1.1e11
SPACING = (1e-6, 2e-6)
SHAPE = (12, 8)
UNIT = -3e-9


def dense(cells: Window) -> np.ndarray:
    """K of a quarter window in units of the influence of a cell on itself."""
    whole = Window((2 * SHAPE[0], 2 * SHAPE[1]), SPACING, quarter=False)
    matrix = oracles.influence_matrix(whole, MODULUS)

    def convolve(field):
        return folded((matrix @ unfolded(field).ravel()).reshape(whole.shape))

    everywhere = np.ones(SHAPE, np.bool_)
    return matrix_of(convolve, everywhere) / half_space(cells, MODULUS).self_influence


@pytest.mark.parametrize("softness", [None, 0.1, 30.0])
def test_a_step_solves_the_problem_and_carries_no_load(softness):
    cells = Window(SHAPE, SPACING)
    bodies, random = half_space(cells, MODULUS), np.random.default_rng(4)
    free = random.random(SHAPE) < 0.6
    tangent = None if softness is None else softness * random.random(SHAPE, np.float32)
    residual = random.standard_normal(SHAPE)
    preconditioner = Preconditioner(bodies, tangent, free)
    step = FreeCells(bodies.single, preconditioner, free).solve(
        UNIT * residual, UNIT, tangent, 0.0, 1e-6
    )
    matrix, inside = dense(cells), free.ravel()
    count = np.count_nonzero(free)
    # (K + diag c) s + α = r on the free cells, ∑ s = 0.
    system = np.ones((count + 1, count + 1))
    system[:-1, :-1] = matrix[np.ix_(inside, inside)]
    if tangent is not None:
        system[:-1, :-1] += np.diag(tangent.ravel()[inside])
    system[-1, -1] = 0.0
    *expected, _ = np.linalg.solve(system, np.append(residual[free], 0.0))
    scale = np.abs(expected).max()
    np.testing.assert_allclose(step.pressure[free], expected, atol=2e-5 * scale)
    assert not step.pressure[~free].any()
    assert abs(step.missed) <= 1e-5 * np.abs(expected).sum()
    # What the step does to the surface is known on all cells, by no further convolution.
    moved = (matrix @ step.pressure.ravel()).reshape(SHAPE)
    np.testing.assert_allclose(step.displacement, moved, atol=1e-5 * np.abs(residual).max())
    assert step.largest == np.abs(step.displacement).max()


def test_a_step_goes_no_further_than_asked():
    cells = Window((40, 30), SPACING)
    bodies = half_space(cells, MODULUS)
    free = np.hypot(*np.meshgrid(cells.x, cells.y, indexing="ij")) < 35e-6
    residual = np.random.default_rng(6).standard_normal(cells.shape)
    problem = FreeCells(bodies.single, Preconditioner(bodies, None, free), free)
    iterations = []
    for reduction in (0.5, 0.05, 1e-4):
        step = problem.solve(residual, 1.0, None, reduction, 0.0)
        left = (residual - step.displacement)[free]
        start = residual[free]
        ratio = left.std() / start.std()
        assert ratio <= 1.05 * reduction
        iterations.append(step.iterations)
    assert iterations[0] < iterations[1] < iterations[2]
    enough = 0.05 * float(residual[free].std())
    assert problem.solve(residual, 1.0, None, 0.0, enough).iterations == iterations[1]
