"""The linear problem of the free cells against a dense solve in double precision."""

import numpy as np
import pytest

from fretwear.mechanics.free_cells import Preconditioner
from fretwear.mechanics.geometry.grid import Grid

from . import oracles
from .problems import EVEN, folded, matrix_of, unfolded

MODULUS = 1.1e11
SPACING = (1e-6, 2e-6)
SHAPE = (12, 8)
UNIT = -3e-9


def dense(cells: Grid) -> np.ndarray:
    """K of a quarter window in units of the influence of a cell on itself."""
    whole = Grid((2 * SHAPE[0], 2 * SHAPE[1]), SPACING, even=(False, False))
    matrix = oracles.influence_matrix(whole, MODULUS)

    def convolve(field):
        return folded((matrix @ unfolded(field).ravel()).reshape(whole.shape))

    everywhere = np.ones(SHAPE, np.bool_)
    return matrix_of(convolve, everywhere) / cells.half_space(MODULUS).self_influence


@pytest.mark.parametrize("softness", [None, 0.1, 30.0])
def test_a_step_solves_the_problem_and_carries_no_load(softness):
    cells = Grid(SHAPE, SPACING)
    bodies, random = cells.half_space(MODULUS), np.random.default_rng(4)
    free = random.random(SHAPE) < 0.6
    tangent = None if softness is None else softness * random.random(SHAPE, np.float32)
    residual = random.standard_normal(SHAPE)
    cells_of = Preconditioner(bodies, tangent, free)
    step = cells_of.on(free).solve(UNIT * residual, UNIT, tangent, 0.0, 1e-6)
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
    cells = Grid((40, 30), SPACING)
    bodies = cells.half_space(MODULUS)
    free = np.hypot(*np.meshgrid(cells.x, cells.y, indexing="ij")) < 35e-6
    residual = np.random.default_rng(6).standard_normal(cells.shape)
    problem = Preconditioner(bodies, None, free).on(free)
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


def wear_like(window, softness):
    """A disc in contact with holes, and a layer that grows from nothing in its middle."""
    r = np.hypot(*np.meshgrid(window.x, window.y, indexing="ij")) / window.extent[0]
    free = (r < 0.85) & (np.random.default_rng(5).random(window.shape) > 0.05)
    tangent = softness * np.clip(4.0 * (r - 0.45), 0.0, 1.0)
    return free, tangent.astype(np.float32)


def inverse_on(bodies, tangent, free):
    """The preconditioner's pressure for a residual, on some free cells."""
    cells = Preconditioner(bodies, tangent, free).on(free)
    return lambda residual: cells.apply_preconditioner(residual)[0]


def spread(bodies, free, tangent, apply):
    """Ratio of the extreme eigenvalues of the problem under a preconditioner."""
    system = matrix_of(lambda field: bodies.single(field) + tangent * field, free, np.float32)
    inverse = matrix_of(apply, free, np.float32)
    values = np.linalg.eigvals(inverse @ system).real
    return values.max() / values.min()


@pytest.mark.parametrize("even", EVEN)
@pytest.mark.parametrize("softness", [0.0, 0.3, 30.0])
def test_it_is_symmetric_and_positive_on_the_free_cells(even, softness):
    window = Grid((20, 10) if all(even) else (24, 12), SPACING, even)
    bodies = window.half_space(MODULUS)
    free, tangent = wear_like(window, softness)
    inverse = matrix_of(inverse_on(bodies, tangent, free), free, np.float32)
    np.testing.assert_allclose(inverse, inverse.T, atol=1e-6 * np.abs(inverse).max())
    assert np.linalg.eigvalsh(inverse).min() > 0


def test_other_cells_stay_without_pressure_and_do_not_count():
    window = Grid((20, 10), SPACING)
    bodies = window.half_space(MODULUS)
    free, tangent = wear_like(window, 30.0)
    precondition = inverse_on(bodies, tangent, free)
    residual = np.random.default_rng(1).standard_normal(window.shape, np.float32)
    result = precondition(residual)
    assert not result[~free].any()
    energy = Preconditioner(bodies, tangent, free).on(free).apply_preconditioner(residual)[1]
    assert energy == pytest.approx(np.vdot(residual, result), rel=1e-5)
    residual[~free] = 1e9
    np.testing.assert_array_equal(precondition(residual), result)


@pytest.mark.parametrize("softness", [5.0, 30.0, 200.0])
def test_two_layers_cope_better_with_wear_than_one(softness):
    window = Grid((36, 18), SPACING)
    bodies = window.half_space(MODULUS)
    free, tangent = wear_like(window, softness)
    mean = float(tangent[free].mean())
    one = bodies.single.inverse(mean)
    single = spread(bodies, free, tangent, lambda field: free * one(field.copy()))
    double = spread(bodies, free, tangent, inverse_on(bodies, tangent, free))
    assert double < 0.8 * single
    # √spread is the number of steps that conjugate gradients need for each digit, nearly.
    assert double < 40
