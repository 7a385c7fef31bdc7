import math
from dataclasses import FrozenInstanceError

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fretwear.mechanics.surfaces import WavyRoughness
from fretwear.study.case import Case, CaseError

STEEL = {
    "radius": "10 mm",
    "youngs_modulus": "208 GPa",
    "poisson_ratio": 0.3,
    "load": "50 N",
    "tangential_load": "20 N",
    "friction": 0.5,
    "wear_coefficient": "7e-13 / Pa",
    "cycles": 30000,
}
WAVES = {"amplitude": "0.2 um", "slope_x": "5.7 deg", "slope_y": "1 deg"}


def steel(**changes):
    return Case(**{**STEEL, **changes})


def refusal(**changes):
    with pytest.raises(CaseError) as caught:
        steel(**changes)
    return str(caught.value)


def test_text_with_units_and_si_numbers_make_the_same_case():
    numbers = Case(
        radius=0.01,
        youngs_modulus=208e9,
        poisson_ratio=0.3,
        load=50,
        tangential_load=np.float32(20.0),
        friction=np.float64(0.5),
        wear_coefficient=7e-13,
        cycles=np.int64(30000),
    )
    assert numbers == steel()
    assert isinstance(numbers.load, float)
    assert isinstance(numbers.cycles, int)


def test_hertz_values_of_the_reference_contact():
    case = steel()
    assert case.composite_modulus == pytest.approx(208e9 / (2 * (1 - 0.09)))
    assert case.hertz_radius == pytest.approx(148.6e-6, rel=1e-4, abs=0)
    assert case.hertz_pressure == pytest.approx(1081e6, rel=1e-3, abs=0)
    assert case.hertz.approach == pytest.approx(2.208e-6, rel=1e-3, abs=0)


def test_coupling_of_equal_bodies_depends_on_poissons_ratio_alone():
    assert steel().coupling == pytest.approx((2 - 0.3) / (2 * (1 - 0.3)))
    assert steel(youngs_modulus="70 GPa", poisson_ratio=0.5).coupling == pytest.approx(1.5)


def test_composite_moduli_of_two_materials():
    case = steel(youngs_modulus=["208 GPa", "70 GPa"], poisson_ratio=[0.3, 0.33])
    compliance = (1 - 0.3**2) / 208e9 + (1 - 0.33**2) / 70e9
    shear = (2 - 0.3) / (4 * 208e9 / 2.6) + (2 - 0.33) / (4 * 70e9 / 2.66)
    assert case.composite_modulus == pytest.approx(1 / compliance)
    assert case.composite_modulus / case.coupling == pytest.approx(1 / shear)


def test_a_pair_of_equal_materials_is_one_material():
    pair = steel(youngs_modulus=["208 GPa", "208 GPa"], poisson_ratio=[0.3, 0.3])
    assert pair.composite_modulus == steel().composite_modulus
    assert pair.case_id == steel().case_id


def test_tangential_load_and_ratio_are_two_names_for_one_thing():
    by_ratio = steel(tangential_load=None, tangential_ratio=0.8)
    assert by_ratio.tangential_load == pytest.approx(steel().tangential_load)
    assert by_ratio.tangential_ratio == pytest.approx(steel().tangential_ratio)
    assert by_ratio.stick_load == pytest.approx(50 - 20 / 0.5)
    assert by_ratio.stick_radius / by_ratio.hertz_radius == pytest.approx(0.2 ** (1 / 3))


def test_waves_have_the_lengths_of_the_study():
    rough = WavyRoughness(**WAVES)
    assert rough.wavelength_x == pytest.approx(4 * 0.2e-6 / math.tan(math.radians(5.7)))
    assert rough.wavelength_x == pytest.approx(8.0e-6, rel=0.01, abs=0)
    assert rough.wavelength_y == pytest.approx(45.8e-6, rel=0.01, abs=0)
    assert rough.wavenumber_x * rough.wavelength_x == pytest.approx(2 * math.pi)


def test_no_slope_is_no_wave_in_that_direction():
    rough = WavyRoughness(**{**WAVES, "slope_y": 0.0})
    assert rough.wavenumber_y == 0.0
    assert rough.wavelength_y == math.inf
    with pytest.raises(ValueError, match="slope larger than zero"):
        WavyRoughness(amplitude=1e-7, slope_x=0.0, slope_y=0.0)


def test_zero_amplitude_is_smooth():
    smooth = steel(roughness={**WAVES, "amplitude": 0.0})
    assert smooth.roughness is None
    assert smooth == steel(roughness=None) == steel(roughness="none")
    assert WavyRoughness(**{**WAVES, "amplitude": "0 um"}).wavelength_x == math.inf


def test_no_plastic_limit_is_infinite():
    assert steel().plastic_limit == math.inf
    assert steel(plastic_limit="none") == steel(plastic_limit=math.inf) == steel()


def test_snapshots_are_sorted_and_hold_the_first_and_last_cycle():
    assert steel().output_cycles == (0, 30000)
    assert steel(output_cycles=[7000, 1000, 7000]).output_cycles == (0, 1000, 7000, 30000)


def test_a_case_is_frozen():
    with pytest.raises(FrozenInstanceError):
        steel().load = 3.0


@pytest.mark.parametrize(
    ("changes", "parts"),
    [
        ({"load": "50 GPa"}, ["load", "must be a force", "50 GPa"]),
        ({"load": 0}, ["load", "larger than 0"]),
        ({"radius": "-1 mm"}, ["radius", "larger than 0", "-1 mm"]),
        ({"youngs_modulus": 0.0}, ["youngs_modulus", "larger than 0"]),
        ({"youngs_modulus": [208e9, -1.0]}, ["youngs_modulus", "number 2", "larger than 0"]),
        ({"youngs_modulus": [208e9]}, ["youngs_modulus", "a list of 1"]),
        ({"poisson_ratio": -1.0}, ["poisson_ratio", "larger than -1 and at most 0.5"]),
        ({"poisson_ratio": 0.51}, ["poisson_ratio", "larger than -1 and at most 0.5"]),
        ({"friction": 0.0}, ["friction", "larger than 0"]),
        ({"friction": True}, ["friction", "plain number"]),
        ({"wear_coefficient": 0.0}, ["wear_coefficient", "larger than 0"]),
        ({"plastic_limit": 0.0}, ["plastic_limit", "larger than 0"]),
        ({"plastic_limit": math.nan}, ["plastic_limit", "finite"]),
        ({"cycles": 0}, ["cycles", "at least 1"]),
        ({"cycles": 1.5}, ["cycles", "whole number"]),
        ({"cycles": True}, ["cycles", "whole number"]),
        ({"tolerance": 0.0}, ["tolerance", "larger than 1e-06 and at most 0.1"]),
        ({"tolerance": 0.2}, ["tolerance", "larger than 1e-06 and at most 0.1"]),
        ({"slip_model": "other"}, ["slip_model", "jaeger"]),
        ({"cell": (0.0, 1e-6)}, ["cell", "larger than 0"]),
        ({"output_cycles": [-1]}, ["output_cycles", "at least 0"]),
        ({"lod": 50.0}, ["lod", "did you mean 'load'"]),
        ({"roughness": {**WAVES, "slope_x": "50 deg"}}, ["slope_x", "less than 45 deg"]),
        ({"roughness": {**WAVES, "amplitude": -1e-7}}, ["amplitude", "at least 0"]),
        ({"roughness": "rough"}, ["roughness"]),
    ],
)
def test_a_wrong_value_is_refused_by_name_and_rule(changes, parts):
    message = refusal(**changes)
    for part in parts:
        assert part in message


def test_every_missing_parameter_is_named():
    with pytest.raises(CaseError) as caught:
        Case(load=50.0)
    for name in ("radius", "youngs_modulus", "poisson_ratio", "friction", "cycles"):
        assert name in str(caught.value)


positive = st.floats(1e-3, 1e3)


@given(positive, positive, st.floats(0.01, 0.99))
def test_hertz_values_scale_as_dimensional_analysis_says(load_scale, length_scale, ratio):
    changes = {"tangential_load": None, "tangential_ratio": ratio}
    case = steel(load=1.0, radius=1.0, **changes)
    # Equal pressures: lengths by s, loads by s².
    other = steel(load=length_scale**2, radius=length_scale, **changes)
    assert other.hertz_pressure == pytest.approx(case.hertz_pressure)
    assert other.hertz_radius == pytest.approx(length_scale * case.hertz_radius)
    # Equal shapes: loads and moduli by the same factor.
    stiffer = steel(load=load_scale, youngs_modulus=208e9 * load_scale, radius=1.0, **changes)
    assert stiffer.hertz_radius == pytest.approx(case.hertz_radius)
    assert stiffer.hertz_pressure == pytest.approx(load_scale * case.hertz_pressure)
