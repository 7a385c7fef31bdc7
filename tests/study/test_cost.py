import math

import pytest

from fretwear.study.case import Case
from fretwear.study.cost import estimate, greatest_contact_radius, limiting_radius_ratio

STEEL = {
    "radius": 0.01,
    "youngs_modulus": 208e9,
    "poisson_ratio": 0.3,
    "load": 50.0,
    "tangential_ratio": 0.8,
    "friction": 0.5,
    "wear_coefficient": 7e-13,
    "cycles": 1000,
}


@pytest.mark.parametrize(("ratio", "radius"), [(0.2, 1.0395), (0.5, 1.1361), (0.9, 1.5710)])
def test_the_limiting_radius_is_that_of_the_reference_table(ratio, radius):
    assert limiting_radius_ratio(ratio) == pytest.approx(radius, abs=6e-5)


def test_contact_reaches_out_with_wear_plastic_flow_and_roughness():
    smooth = Case(**STEEL)
    assert greatest_contact_radius(smooth) > smooth.hertz_radius
    soft = Case(**STEEL, plastic_limit=50e6)
    assert greatest_contact_radius(soft) == pytest.approx(math.sqrt(50 / (math.pi * 50e6)))
    rough = Case(**STEEL, roughness={"amplitude": 2e-7, "slope_x": 0.1, "slope_y": 0.02})
    assert greatest_contact_radius(rough) > greatest_contact_radius(smooth)


def test_half_the_spacing_takes_four_times_the_cells():
    coarse = estimate(Case(**STEEL, cell=2e-6))
    fine = estimate(Case(**STEEL, cell=1e-6))
    assert fine.cells == pytest.approx(4 * coarse.cells, rel=0.02)
    assert fine.seconds > coarse.seconds
    assert fine.memory_bytes > coarse.memory_bytes
    assert fine.file_bytes > coarse.file_bytes


def test_more_snapshots_make_a_larger_file_and_no_longer_run():
    few, many = Case(**STEEL), Case(**STEEL, output_cycles=range(0, 1000, 100))
    assert estimate(many).file_bytes > 4 * estimate(few).file_bytes
    assert estimate(many).seconds == estimate(few).seconds
