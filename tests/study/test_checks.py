import math

import pytest

from fretwear.study.case import Case, CaseError
from fretwear.study.rules import GREATEST_CONTACT

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
WAVES = {"amplitude": 0.2e-6, "slope_x": math.radians(5.7), "slope_y": math.radians(1.0)}


def refusal(**changes):
    with pytest.raises(CaseError) as caught:
        Case(**{**STEEL, **changes})
    return str(caught.value)


@pytest.mark.parametrize("ratio", [1.0, 1.2])
def test_gross_sliding_is_refused(ratio):
    message = refusal(tangential_ratio=ratio)
    assert "gross sliding" in message
    assert f"tangential_ratio = {ratio:g}" in message
    message = refusal(tangential_ratio=None, tangential_load=25.0 * ratio)
    assert "gross sliding" in message
    assert "µP = 25 N" in message


def test_just_below_gross_sliding_is_accepted():
    assert Case(**{**STEEL, "tangential_ratio": 0.999}).stick_load > 0.0


def test_exactly_one_tangential_parameter_is_given():
    message = refusal(tangential_load=10.0)
    assert "tangential_load: is one too many" in message
    assert "exactly one" in message
    message = refusal(tangential_ratio=None)
    assert "tangential_ratio: is missing, and so is tangential_load" in message
    assert "exactly one" in message


def test_a_plastic_limit_must_carry_the_load_within_half_space_theory():
    least = STEEL["load"] / (math.pi * (GREATEST_CONTACT * STEEL["radius"]) ** 2)
    assert Case(**{**STEEL, "plastic_limit": 1.001 * least}).plastic_limit < math.inf
    message = refusal(plastic_limit=0.999 * least)
    assert "plastic_limit" in message
    assert "too low to carry the load 50 N" in message


def test_the_plastic_limit_that_the_message_offers_is_accepted():
    message = refusal(plastic_limit=1e5)
    offered = message.split("at least ")[1].split(";")[0]
    assert Case(**{**STEEL, "plastic_limit": offered}).plastic_limit > 1e5


def test_a_load_beyond_half_space_theory_is_refused_with_one_that_would_do():
    message = refusal(load=1e6)
    assert "half-space theory" in message
    offered = message.split("up to ")[1].split(" would")[0]
    assert Case(**{**STEEL, "load": offered}).hertz_radius <= GREATEST_CONTACT * 0.01


def test_a_cell_too_coarse_for_the_waves_is_refused_with_one_that_would_do():
    message = refusal(roughness=WAVES, cell=(2e-6, 4e-6))
    assert "cell = [2 um, 4 um]" in message
    assert "along x is 8.01 um long" in message
    assert "along y" not in message
    offered = message.split("\n    [")[1].split("]")[0].split(", ")
    assert Case(**{**STEEL, "roughness": WAVES, "cell": offered}).cell == (1e-6, 4e-6)


def test_a_cell_too_coarse_for_the_contact_is_refused_with_one_that_would_do():
    message = refusal(cell="50 um")
    assert "too coarse for the contact" in message
    offered = message.split("\n    [")[1].split("]")[0].split(", ")
    case = Case(**{**STEEL, "cell": offered})
    assert max(case.cell) <= case.hertz_radius / 8


def test_a_slip_annulus_narrower_than_a_cell_is_refused():
    case = Case(**{**STEEL, "tangential_ratio": 0.05})
    annulus = case.hertz_radius - case.stick_radius
    assert "too coarse" in refusal(tangential_ratio=0.05, cell=1.5 * annulus)


def test_a_snapshot_beyond_the_last_cycle_is_refused():
    message = refusal(output_cycles=[10, 1001, 5000])
    assert "1001, 5000" in message
    assert "beyond the last cycle, 1000" in message


def test_everything_wrong_between_parameters_is_said_at_once():
    message = refusal(
        tangential_ratio=1.5, plastic_limit=1.0, roughness=WAVES, cell=5e-6, output_cycles=[2000]
    )
    for part in ("gross sliding", "too low to carry", "too coarse", "beyond the last cycle"):
        assert part in message
