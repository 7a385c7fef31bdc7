import math

import pytest

from fretwear.running.simulate import steps
from fretwear.study.cost import estimate, greatest_contact_radius
from fretwear.theory import HertzContact, LimitingState

from ..studies import steel

WAVES = {"amplitude": 2e-7, "slope_x": 0.035, "slope_y": 0.017}


def test_contact_reaches_out_with_wear_plastic_flow_and_roughness():
    smooth = steel()
    assert greatest_contact_radius(smooth) > smooth.hertz_radius
    soft = steel(plastic_limit=50e6)
    assert greatest_contact_radius(soft) == pytest.approx(math.sqrt(50 / (math.pi * 50e6)))
    rough = steel(roughness={"amplitude": 2e-7, "slope_x": 0.1, "slope_y": 0.02})
    assert greatest_contact_radius(rough) > greatest_contact_radius(smooth)
    short = greatest_contact_radius(steel(cycles=10))
    long = greatest_contact_radius(steel(cycles=10**6))
    hertz = steel().hertz_radius
    assert short == pytest.approx(hertz, rel=0.01)
    limiting = LimitingState(HertzContact(1.0, 4 / 3, 1.0), 0.8)
    assert long == pytest.approx(limiting.contact_radius * hertz, rel=1e-6)


def test_cells_and_snapshots_cost_what_they_take():
    coarse = estimate(steel(cell=2e-6, roughness=WAVES))
    fine = estimate(steel(cell=1e-6, roughness=WAVES))
    assert fine.cells == pytest.approx(4 * coarse.cells, rel=0.02)
    assert fine.seconds > coarse.seconds
    assert fine.memory_bytes > coarse.memory_bytes
    assert fine.file_bytes > coarse.file_bytes
    few, many = steel(output_cycles=()), steel(output_cycles=range(0, 1000, 100))
    assert estimate(many).file_bytes > 4 * estimate(few).file_bytes
    assert estimate(many).seconds == estimate(few).seconds


def test_a_contact_that_yields_widens_without_end_where_slip_follows_the_worn_shape():
    worn, yielding = steel(cycles=30000), steel(cycles=30000, plastic_limit=4.5e9)
    assert greatest_contact_radius(yielding) > 1.5 * greatest_contact_radius(worn)
    held = yielding.replace(slip_model="cattaneo_mindlin")
    assert greatest_contact_radius(held) == greatest_contact_radius(worn)
    assert estimate(held).convolutions < 0.2 * estimate(yielding).convolutions


def test_more_cycles_and_a_tighter_tolerance_take_more_steps():
    few, many = (estimate(steel(cycles=n, roughness=WAVES)) for n in (100, 100_000))
    assert few.steps < many.steps < 10 * few.steps
    for changes in ({}, {"roughness": WAVES}):
        assert (
            estimate(steel(**changes, tolerance=1e-3)).steps
            > 1.5 * estimate(steel(**changes)).steps
        )
    tight = estimate(steel(tolerance=0.001))
    assert tight.seconds > estimate(steel()).seconds


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes",
    [
        {"cycles": 7000},
        {"cycles": 7000, "plastic_limit": 4.5e9},
        {"cycles": 7000, "roughness": WAVES, "cell": 2e-6},
        {"cycles": 1000, "roughness": WAVES, "plastic_limit": 4.5e9, "cell": 2e-6},
        {"cycles": 7000, "plastic_limit": 4.5e9, "slip_model": "cattaneo_mindlin", "cell": 3e-6},
    ],
)
def test_the_convolutions_of_a_run_are_those_expected_within_a_factor_of_two(changes):
    case = steel(**changes)
    *_, last = steps(case)
    expected = estimate(case)
    assert 0.5 < expected.convolutions / last.state.convolutions < 2.0
    cells = last.state.geometry.plane(case.grid_spacing).shape
    assert 0.5 < expected.cells / math.prod(cells) < 2.0
