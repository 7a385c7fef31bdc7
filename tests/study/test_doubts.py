import math

import pytest

from fretwear.mechanics.surfaces import Sphere
from fretwear.running.simulate import DoubtfulResultWarning, simulate
from fretwear.study.rules import doubts, yielding_ring_width
from fretwear.theory import HertzContact, LimitingState

from ..studies import steel

LONG = {"amplitude": 1e-7, "slope_x": 1e-3, "slope_y": 1e-3}


def kinds(**changes):
    """The first words of each doubt."""
    told = [doubt.what for doubt in doubts(steel(**changes))]
    return [" ".join(what.split()[:5]) for what in told]


@pytest.mark.parametrize("ratio", [0.1, 0.5, 0.8, 0.95])
@pytest.mark.parametrize("limit", [1.1e9, 2e9, 4.5e9, 9e9])
def test_the_ring_is_as_wide_as_the_limiting_state_says(ratio, limit):
    case = steel(tangential_ratio=ratio, plastic_limit=limit)
    hertz = HertzContact(case.radius, case.load, case.composite_modulus)
    expected = LimitingState(hertz, ratio).width_above(limit)
    assert yielding_ring_width(case) == expected


def test_a_contact_above_the_limit_everywhere_yields_as_a_whole():
    case = steel(tangential_ratio=0.8, plastic_limit=0.5e9)
    assert yielding_ring_width(case) == case.stick_radius


def test_an_elastic_contact_has_no_ring():
    case = steel(tangential_ratio=0.8)
    assert math.isinf(case.plastic_limit)
    assert yielding_ring_width(case) == 0.0
    assert not doubts(case)


@pytest.mark.parametrize(("ratio", "unseen"), [(0.8, False), (0.2, True)])
def test_the_default_grid_sees_the_ring_of_large_ratios_only(ratio, unseen, monkeypatch):
    assert not kinds(tangential_ratio=ratio, plastic_limit=4.5e9), "on rings"
    monkeypatch.setattr(Sphere, "is_axisymmetric", False)
    told = kinds(tangential_ratio=ratio, plastic_limit=4.5e9)
    assert told == (["will yield in a ring"] if unseen else [])


def test_a_rough_contact_yields_on_every_tip_which_the_grid_sees():
    waves = {"amplitude": 2e-7, "slope_x": 0.05, "slope_y": 0.02}
    assert not kinds(tangential_ratio=0.2, plastic_limit=4.5e9, roughness=waves)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"youngs_modulus": (208e9, 3e9), "poisson_ratio": (0.3, 0.4), "friction": 0.1}, "unlike"),
        ({"plastic_limit": 0.7e9}, "yield all over"),
        ({"cell": 18e-6, "roughness": LONG}, "zone of few cells"),
        ({"roughness": {"amplitude": 1e-7, "slope_x": 0.25, "slope_y": 0.0}}, "slopes"),
    ],
)
def test_what_makes_results_doubtful_is_told_with_its_numbers(changes, told):
    (doubt,) = doubts(steel(**changes))
    assert told in doubt.what
    assert any(digit.isdigit() for digit in doubt.detail)
    assert doubt.remedy


def test_dundurs_constant_is_that_of_the_closed_form():
    """Steel on a rigid body: β = (1 − 2ν)/(2 (1 − ν)); alike or incompressible bodies have none."""
    rigid = {"youngs_modulus": (208e9, 208e18)}
    (doubt,) = doubts(steel(**rigid))
    assert f"β = {(1 - 2 * 0.3) / (2 * (1 - 0.3)):.2g}," in doubt.detail
    assert not doubts(steel(**rigid, poisson_ratio=(0.5, 0.3)))


def test_a_simulation_warns_and_its_dataset_remembers():
    case = steel(cycles=1, cell=18e-6, roughness=LONG)
    with pytest.warns(DoubtfulResultWarning, match="zone of few cells"):
        dataset = simulate(case)
    assert dataset.attrs["warnings"] == "\n".join(map(str, doubts(case)))
    fine = simulate(steel(cycles=1))
    assert fine.attrs["warnings"] == ""
