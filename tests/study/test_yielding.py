import math

import pytest

from fretwear.study.case import Case
from fretwear.study.plan import is_ring_unseen, yielding_ring_width
from fretwear.theory import HertzContact, LimitingState

STEEL = {
    "radius": 0.01,
    "youngs_modulus": 208e9,
    "poisson_ratio": 0.3,
    "load": 50.0,
    "friction": 0.5,
    "wear_coefficient": 7e-13,
    "cycles": 1000,
}


@pytest.mark.parametrize("ratio", [0.1, 0.5, 0.8, 0.95])
@pytest.mark.parametrize("limit", [1.1e9, 2e9, 4.5e9, 9e9])
def test_the_ring_is_as_wide_as_the_limiting_state_says(ratio, limit):
    case = Case(**STEEL, tangential_ratio=ratio, plastic_limit=limit)
    hertz = HertzContact(case.radius, case.load, case.composite_modulus)
    expected = LimitingState(hertz, ratio).width_above(limit)
    # Not exact: the tiny approach of the punch at small ratios is a difference of large numbers.
    assert yielding_ring_width(case) == pytest.approx(expected, rel=1e-9)


def test_a_contact_above_the_limit_everywhere_yields_as_a_whole():
    case = Case(**STEEL, tangential_ratio=0.8, plastic_limit=0.5e9)
    assert yielding_ring_width(case) == case.stick_radius


def test_an_elastic_contact_has_no_ring():
    case = Case(**STEEL, tangential_ratio=0.8)
    assert math.isinf(case.plastic_limit)
    assert yielding_ring_width(case) == 0.0
    assert not is_ring_unseen(case)


@pytest.mark.parametrize(("ratio", "unseen"), [(0.8, False), (0.2, True)])
def test_the_default_grid_sees_the_ring_of_large_ratios_only(ratio, unseen):
    assert is_ring_unseen(Case(**STEEL, tangential_ratio=ratio, plastic_limit=4.5e9)) is unseen


def test_a_rough_contact_yields_on_every_tip_which_the_grid_sees():
    waves = {"amplitude": 2e-7, "slope_x": 0.05, "slope_y": 0.02}
    assert not is_ring_unseen(
        Case(**STEEL, tangential_ratio=0.2, plastic_limit=4.5e9, roughness=waves)
    )
