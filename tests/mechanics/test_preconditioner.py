"""The preconditioner on the linear problem of the free cells, as dense matrices."""

import numpy as np
import pytest

from fretwear.mechanics.halfspace import half_space
from fretwear.mechanics.preconditioner import Preconditioner
from fretwear.mechanics.window import Window

from .problems import matrix_of

MODULUS = 1.1e11
SPACING = (1e-6, 2e-6)


def wear_like(window, softness):
    """A disc in contact with holes, and a layer that grows from nothing in its middle."""
    r = np.hypot(*np.meshgrid(window.x, window.y, indexing="ij")) / window.extent[0]
    free = (r < 0.85) & (np.random.default_rng(5).random(window.shape) > 0.05)
    tangent = softness * np.clip(4.0 * (r - 0.45), 0.0, 1.0)
    return free, tangent.astype(np.float32)


def inverse_on(bodies, tangent, free):
    """The preconditioner's pressure for a residual, on some free cells."""
    inverse = Preconditioner(bodies, tangent, free).on(free.astype(np.float32))
    return lambda residual: inverse(residual)[0]


def spread(bodies, free, tangent, apply):
    """Ratio of the extreme eigenvalues of the problem under a preconditioner."""
    system = matrix_of(lambda field: bodies.single(field) + tangent * field, free, np.float32)
    inverse = matrix_of(apply, free, np.float32)
    values = np.linalg.eigvals(inverse @ system).real
    return values.max() / values.min()


@pytest.mark.parametrize("quarter", [True, False])
@pytest.mark.parametrize("softness", [0.0, 0.3, 30.0])
def test_it_is_symmetric_and_positive_on_the_free_cells(quarter, softness):
    window = Window((20, 10) if quarter else (24, 12), SPACING, quarter)
    bodies = half_space(window, MODULUS)
    free, tangent = wear_like(window, softness)
    inverse = matrix_of(inverse_on(bodies, tangent, free), free, np.float32)
    np.testing.assert_allclose(inverse, inverse.T, atol=1e-6 * np.abs(inverse).max())
    assert np.linalg.eigvalsh(inverse).min() > 0


def test_other_cells_stay_without_pressure_and_do_not_count():
    window = Window((20, 10), SPACING)
    bodies = half_space(window, MODULUS)
    free, tangent = wear_like(window, 30.0)
    precondition = inverse_on(bodies, tangent, free)
    residual = np.random.default_rng(1).standard_normal(window.shape, np.float32)
    result = precondition(residual)
    assert not result[~free].any()
    inside, inverse = free.astype(np.float32), Preconditioner(bodies, tangent, free)
    energy = inverse.on(inside)(residual)[1]
    assert energy == pytest.approx(np.vdot(residual, result), rel=1e-5)
    residual[~free] = 1e9
    np.testing.assert_array_equal(precondition(residual), result)


@pytest.mark.parametrize("softness", [5.0, 30.0, 200.0])
def test_two_layers_cope_better_with_wear_than_one(softness):
    window = Window((36, 18), SPACING)
    bodies = half_space(window, MODULUS)
    free, tangent = wear_like(window, softness)
    mean = float(tangent[free].mean())
    one = bodies.single.inverse(mean)
    single = spread(bodies, free, tangent, lambda field: free * one(field.copy()))
    double = spread(bodies, free, tangent, inverse_on(bodies, tangent, free))
    assert double < 0.8 * single
    # √spread is the number of steps that conjugate gradients need for each digit, nearly.
    assert double < 40
