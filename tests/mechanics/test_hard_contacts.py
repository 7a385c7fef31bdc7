"""No solver stalls on contacts on which one has, at any load ratio: one may pass by chance."""

import numpy as np
import pytest

from fretwear.mechanics.contact.problem import solve_contact
from fretwear.mechanics.slip.coupled import shear
from fretwear.mechanics.slip.models import contact_under
from fretwear.mechanics.slip.shear import shear_space

from .hard_contacts import RATIOS, hard_contact

# At some ratios, Newton's method without a fallback has stalled on the first four.
SEEDS = [1, 1000, 1001, 1002, 2, 3, 4, 5]


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_friction_as_a_vector_converges_at_every_ratio(seed):
    problem, pressure, coupling = hard_contact(seed)
    bodies, bound = shear_space(problem.half_space.geometry, 1.0, coupling), 0.3 * pressure
    for ratio in RATIOS:
        result = shear(bodies, bound, 0.3 * ratio, tolerance=1e-8)
        assert result.residual <= 1e-8
        assert np.all(np.hypot(*result.traction) <= bound + 1e-12 * bound.max())


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_normal_and_reduced_contacts_converge_at_every_load(seed):
    problem, pressure, coupling = hard_contact(seed)
    along = problem.half_space.along_x(coupling, 1.0)
    shape = problem.separation(pressure, problem.half_space.displacement(pressure))
    shape = shape - along.displacement(pressure)
    for ratio in RATIOS[::6]:
        assert solve_contact(problem, ratio * pressure, 1e-8).residual <= 1e-8
        reduced = contact_under(along, shape, 1.0 - ratio, None, pressure, 1e-8)
        assert along.geometry.integral(reduced.pressure) == pytest.approx(1.0 - ratio, rel=1e-9)
