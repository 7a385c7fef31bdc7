"""What the model neglects, and by how much: numbers of the documentation and of warnings."""

import numpy as np
import pytest
from scipy.special import ellipk

from ..studies import near
from .neglected import UnlikeCylinder, VectorFriction

FRICTION = 0.3


@pytest.mark.parametrize("ratio", [0.6, 1.0, 1.4])
def test_normal_loading_of_unlike_cylinders_slips_outside_a_closed_form(ratio):
    # Where tractions do not lift the surfaces, K(√(1 − c²/a²)) / K(c/a) = β/µ (Spence 1973;
    # Johnson 1985, section 5.4), whatever the load.
    bodies = UnlikeCylinder(ratio * FRICTION, FRICTION, lifts=False)
    pressure, traction = bodies.loaded(60)
    assert np.allclose(traction, -traction[::-1], atol=1e-12)
    sticks = (pressure > 0) & (np.abs(traction) < FRICTION * pressure * (1 - 1e-9))
    edge = np.abs(bodies.x[sticks]).max() + np.array([-1.0, 1.0]) * bodies.width
    (wider, narrower) = ellipk(1 - edge**2) / ellipk(edge**2)
    assert narrower <= ratio <= wider


@pytest.mark.parametrize(("ratio", "force"), [(0.39, 0.3), (1.0, 0.9)])
def test_cycles_forget_how_the_normal_load_dragged_unlike_bodies(ratio, force):
    """Slip, wear and energy are as for β = 0 from the second cycle on; mean tractions stay."""
    alike, unlike = (
        UnlikeCylinder(beta, FRICTION, lifts=False).cycles(force, 3)
        for beta in (0.0, ratio * FRICTION)
    )
    assert unlike[0].energy > 1.01 * alike[0].energy
    for cycle, same in zip(unlike[1:], alike[1:], strict=True):
        assert np.abs(cycle.path - same.path).max() <= 1e-12 * same.path.max()
        assert np.abs(cycle.wear - same.wear).max() <= 1e-12 * same.wear.max()
        assert cycle.energy == near(same.energy, rel=1e-12)
    assert np.abs(alike[-1].mean_traction).max() < 1e-12
    # p0 = 1/2: the traction that the normal load left where it sticks
    assert np.abs(unlike[-1].mean_traction).max() > 0.1 * ratio * FRICTION / 2


@pytest.mark.slow
@pytest.mark.parametrize(("beta", "friction"), [(0.1, 0.1), (0.09, 0.9)])
def test_friction_lifts_unlike_bodies_by_the_estimates_of_the_warning(beta, friction):
    """Energy falls by up to 2β², and wear changes locally by up to β(µ + 2β)."""
    alike, unlike = (
        UnlikeCylinder(each, friction, lifts=True, strips=64).cycles(0.6, 2, 8, loading=16)[-1]
        for each in (0.0, beta)
    )
    assert 0.7 * beta**2 < 1 - unlike.energy / alike.energy < 2 * beta**2
    change = np.abs(unlike.wear - alike.wear).sum() / alike.wear.sum()
    estimate = beta * (friction + 2 * beta)
    assert estimate / 3 < change < estimate


def both(ratio, cells, poisson_ratio=0.3):
    return [VectorFriction(poisson_ratio, ratio, cells, directions) for directions in (1, 2)]


@pytest.mark.parametrize(
    ("poisson_ratio", "energy", "x", "y"),
    [(0.3, -0.0036, 0.854, 1.137), (0.45, -0.01, 0.754, 1.222)],
)
def test_friction_in_two_directions_slips_less_on_the_x_axis_and_more_on_the_y_axis(
    poisson_ratio, energy, x, y
):
    """The numbers hold for 16 cells on the radius, with a slip zone 7 cells wide."""
    single, vector = (VectorFriction(poisson_ratio, 0.8, 12, number) for number in (1, 2))
    pressure = single.pressed()
    slips = [sphere.slip(pressure)[0] for sphere in (single, vector)]
    assert (pressure @ slips[1]) / (pressure @ slips[0]) - 1 == near(energy, rel=0.1)
    middle = np.abs(np.hypot(*single.places) - 0.8) < 0.1
    for axis, expected in enumerate((x, y)):
        alone, here = (single.along(np.where(middle, slip, 0.0))[axis].sum() for slip in slips)
        assert here / alone == pytest.approx(expected, abs=0.01)


@pytest.mark.slow
def test_wear_of_a_single_direction_has_the_volume_of_two_but_not_their_depth():
    single, vector = (VectorFriction(0.3, 0.8, 8, number) for number in (1, 2))
    (before,), (wear,) = (sphere.worn([0.1]) for sphere in (single, vector))
    assert wear.sum() / before.sum() - 1 == pytest.approx(-0.0036, abs=0.0005)
    along = zip(vector.along(wear), single.along(before), strict=True)
    x, y = (there.max() / here.max() for there, here in along)
    # 24 cells, τ = 0.05: 0.864 and 1.13
    assert (x, y) == pytest.approx((0.864, 1.13), abs=0.01)
