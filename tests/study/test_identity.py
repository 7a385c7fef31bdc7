"""What names a case: its id, its coordinates, and its values as people write them."""

import math
import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fretwear.study.parameters import symbol_text, value_text, words_text

from ..studies import near, steel, study_case


def test_the_id_of_a_case_says_its_main_parameters_and_stays_what_it_is():
    assert study_case().case_id == "P50N-Q20N-mu0.5-A0.2um-Y4500MPa-N30000-1e271b0a"
    plain = study_case(roughness=None, plastic_limit="none", cycles=7000)
    assert plain.case_id.startswith("P50N-Q20N-mu0.5-smooth-elastic-N7000-")


def test_the_same_case_said_otherwise_has_the_same_id():
    keys = {"radius": "1 cm", "youngs_modulus": 208e9, "load": "0.05 kN"}
    keys |= {"wear_coefficient": "7e-13 m^2/N", "plastic_limit": "4.5 GPa"}
    waves = {"slope_x": math.radians(5.7), "slope_y": f"{math.radians(1.0)} rad"}
    keys |= {"roughness": {"amplitude": "200 nm", **waves}, "cell": [5e-7, "0.002 mm"]}
    assert study_case(**keys).case_id == study_case(output_cycles=[10, 100]).case_id
    assert study_case(**keys).case_id == study_case().case_id
    # 0.8·0.5·50 is not 20 to the last bit in every order of multiplication.
    for load in (20, 30, 50, 70):
        by_ratio = study_case(load=load, tangential_load=None, tangential_ratio=0.7)
        assert by_ratio.case_id == study_case(load=load, tangential_load=0.35 * load).case_id
    flat = {"amplitude": 0, "slope_x": "1 deg", "slope_y": "1 deg"}
    assert study_case(roughness=flat).case_id == study_case(roughness=None).case_id
    by_default = study_case(cell=None, accuracy="none")
    assert study_case(cell=by_default.grid_spacing).case_id == by_default.case_id
    zeros = {steel(poisson_ratio=zero).case_id for zero in (0, 0.0, -0.0)}
    assert len(zeros) == 1


@settings(max_examples=settings.default.max_examples // 4)
@given(
    st.floats(1e-3, 100.0),
    st.floats(0.01, 2.0),
    st.floats(0.01, 0.99),
    st.one_of(st.just(math.inf), st.floats(1e8, 1e12)),
)
def test_ids_are_safe_in_paths_and_shells(load, friction, ratio, limit):
    keys = {"load": load, "friction": friction, "tangential_ratio": ratio}
    case = study_case(**keys, tangential_load=None, plastic_limit=limit, cell=None)
    assert re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_.-]{1,100}", case.case_id)


def test_coordinates_are_in_si_units_and_complete():
    coordinates = study_case().scalar_coordinates()
    assert coordinates["normal_load"] == (50.0, "N", "normal load")
    assert coordinates["slip_model"] == ("cerruti", "", "slip model")
    for name, value, unit in (
        ("plastic_limit", 4.5e9, "Pa"),
        ("roughness_amplitude", 2e-7, "m"),
        ("roughness_slope_x", math.radians(5.7), "rad"),
        ("tangential_load", 20.0, "N"),
        ("tangential_ratio", 0.8, "1"),
        ("cell_x", 5e-7, "m"),
        ("cell_y", 2e-6, "m"),
        ("hertz_radius", study_case().hertz_radius, "m"),
    ):
        assert coordinates[name][:2] == (near(value), unit)
    smooth = study_case(roughness=None, plastic_limit="none").scalar_coordinates()
    names = ("roughness_amplitude", "roughness_slope_x", "roughness_slope_y")
    assert [smooth[name][0] for name in ("plastic_limit", *names)] == [math.inf, 0.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("text", "name", "value", "expected"),
    [
        (value_text, "load", 50.0, "50 N"),
        (value_text, "plastic_limit", math.inf, "elastic"),
        (value_text, "roughness_amplitude", 2e-7, "0.2 µm"),
        (value_text, "roughness_amplitude", 0.0, "smooth"),
        (value_text, "wear_coefficient", 7e-13, "7·10⁻¹³ Pa⁻¹"),
        (value_text, "slip_model", "jaeger", "slip of the worn shape"),
        (value_text, "cycles", 30000.0, "30000"),
        # Symbols and words name the parameter unless the value does.
        (symbol_text, "load", 50.0, "$P$ = 50 N"),
        (words_text, "load", 50.0, "normal load 50 N"),
        (words_text, "roughness_amplitude", 0.0, "smooth"),
        # A name that no case has is that of a plain number or word.
        (words_text, "run_number", 3.0, "run number 3"),
    ],
)
def test_values_symbols_and_words_are_written_for_people(text, name, value, expected):
    assert text(name, value) == expected
