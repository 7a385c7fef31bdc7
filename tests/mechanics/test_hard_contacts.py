"""No solver stalls on contacts on which one has, at any load ratio: one may pass by chance."""

from types import SimpleNamespace

import numpy as np
import pytest

from fretwear.mechanics.contact.problem import solve_contact
from fretwear.mechanics.slip.coupled import shear
from fretwear.mechanics.slip.models import Cerruti, Pressed, contact_under
from fretwear.mechanics.slip.shear import shear_space
from fretwear.mechanics.surfaces.loading import Sliding

from .hard_contacts import RATIOS, SEEDS, hard_contact


@pytest.mark.parametrize("seed", SEEDS)
def test_friction_as_a_vector_converges_at_every_ratio(seed):
    problem, pressure = hard_contact(seed)
    bodies, bound = shear_space(problem.half_space.geometry, 1.0, 1.0), 0.3 * pressure
    for ratio in RATIOS:
        result = shear(bodies, bound, 0.3 * ratio * problem.load, tolerance=1e-8)
        assert result.residual <= 1e-8
        assert np.all(np.hypot(*result.traction) <= bound + 1e-12 * bound.max())


@pytest.mark.parametrize("seed", SEEDS)
def test_reduced_contacts_along_x_converge_at_every_ratio(seed):
    problem, pressure = hard_contact(seed)
    contact = solve_contact(problem, pressure, 1e-8)
    setup = SimpleNamespace(
        bodies=SimpleNamespace(coupling=1.0 + seed / 1000.0),
        coupling=1.0,
        friction_law=SimpleNamespace(ratio=1.0, follows_slip=False),
        tilt=0.0,
    )
    pressed = Pressed(
        problem.half_space,
        problem.shape,
        contact.pressure,
        contact.gap,
        contact.approach,
        Sliding(problem.load),
        1e-8,
    )
    bodies, shape = Cerruti().family(setup, pressed)
    for ratio in RATIOS:
        load = (1.0 - ratio) * problem.load
        reduced = contact_under(bodies, shape, load, None, contact.pressure, 1e-8)
        assert bodies.geometry.integral(reduced.pressure) == pytest.approx(load, rel=1e-9)
        separation = bodies.displacement(reduced.pressure) + shape
        spread = np.ptp(separation[reduced.stick])
        assert spread <= 3e-8 * np.abs(bodies.displacement(reduced.pressure)).max()
