import math

import pytest

from fretwear.mechanics.surfaces import Sphere
from fretwear.running.simulate import DoubtfulResultWarning, simulate
from fretwear.study.doubts import doubts, yielding_ring_width
from fretwear.theory import HertzContact, LimitingState

from ..studies import steel

RIDGES = {"amplitude": 1e-7, "slope_x": 0.25, "slope_y": 0.0}
LONG = {"amplitude": 1e-7, "slope_x": 1e-3, "slope_y": 1e-3}


def kinds(**changes):
    """The first words of each doubt."""
    told = [doubt.what for doubt in doubts(steel(**changes))]
    return [" ".join(what.split()[:4]) for what in told]


@pytest.mark.parametrize("ratio", [0.1, 0.5, 0.8, 0.95])
@pytest.mark.parametrize("limit", [1.1e9, 2e9, 4.5e9, 9e9])
def test_the_ring_is_as_wide_as_the_limiting_state_says(ratio, limit):
    case = steel(tangential_ratio=ratio, plastic_limit=limit)
    hertz = HertzContact(case.radius, case.load, case.composite_modulus)
    expected = LimitingState(hertz, ratio).width_above(limit)
    assert yielding_ring_width(case) == expected


def test_a_contact_above_the_limit_everywhere_yields_as_a_whole_and_an_elastic_one_nowhere():
    case = steel(tangential_ratio=0.8, plastic_limit=0.5e9)
    assert yielding_ring_width(case) == case.stick_radius
    case = steel(tangential_ratio=0.8)
    assert math.isinf(case.plastic_limit)
    assert yielding_ring_width(case) == 0.0
    assert not doubts(case)


@pytest.mark.parametrize(("ratio", "unseen"), [(0.8, False), (0.2, True)])
def test_the_default_grid_sees_the_ring_of_large_ratios_only(ratio, unseen, monkeypatch):
    assert not kinds(tangential_ratio=ratio, plastic_limit=4.5e9), "on rings"
    monkeypatch.setattr(Sphere, "is_axisymmetric", False)
    told = kinds(tangential_ratio=ratio, plastic_limit=4.5e9)
    assert told == (["yields in a ring"] if unseen else [])


@pytest.mark.parametrize(("ratio", "unseen"), [(0.9, False), (0.2, True)])
def test_cells_that_tips_need_and_do_not_get_are_told(ratio, unseen):
    waves = {"amplitude": 2e-7, "slope_x": 0.05, "slope_y": 0.02}
    capped = {"tangential_ratio": ratio, "plastic_limit": 4.5e9, "roughness": waves}
    assert kinds(**capped) == (["touches on asperities whose"] if unseen else [])
    (doubt,) = doubts(steel(**{**capped, "plastic_limit": math.inf}, cell=[1e-6, 2e-6]))
    assert "contact of a tip" in doubt.detail


def test_waves_that_are_pressed_flat_are_computed_on_the_cells_of_a_smooth_contact():
    flat = {"amplitude": 1e-8, "slope_x": 4e-5, "slope_y": 4e-5}
    capped = steel(tangential_ratio=0.5, plastic_limit=4.5e9, roughness=flat)
    smooth = steel(tangential_ratio=0.5, plastic_limit=4.5e9)
    assert capped.grid_spacing == smooth.grid_spacing
    assert [doubt.what.split()[3] for doubt in doubts(capped)] == ["ring"]


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"youngs_modulus": (208e9, 3e9), "poisson_ratio": (0.3, 0.4), "friction": 0.1}, "unlike"),
        ({"plastic_limit": 0.7e9}, "yields all over"),
        ({"cell": 18e-6, "roughness": LONG}, "zone of few cells"),
        ({"roughness": RIDGES, "cell": [5e-8, 2e-6]}, "slopes"),
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
    first, *after = dataset.attrs["warnings"].splitlines()
    assert [first] == [str(doubt) for doubt in doubts(case)]
    assert "errors come to more than 5 %" in after[0]
    assert "write cell: [" in after[0]
    fine = simulate(steel(cycles=1))
    assert fine.attrs["warnings"] == ""
