"""Numbers and parameters are written as people write them."""

import math

import pytest

from fretwear.study.parameters import symbol_text, value_text, words_text


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("load", 50.0, "50 N"),
        ("youngs_modulus", 208e9, "208 GPa"),
        ("plastic_limit", 4.5e9, "4500 MPa"),
        ("plastic_limit", math.inf, "elastic"),
        ("roughness_amplitude", 2e-7, "0.2 µm"),
        ("roughness_amplitude", 0.0, "smooth"),
        ("roughness_slope_x", math.radians(5.7), "5.7°"),
        ("friction", 0.3, "0.3"),
        ("wear_coefficient", 7e-13, "7·10⁻¹³ Pa⁻¹"),
        ("slip_model", "jaeger", "slip of the worn shape"),
        ("roughness", "none", "smooth"),
        (
            "roughness",
            "{kind: wavy, amplitude: 0.3 um, slope_x: 5.7 deg, slope_y...",
            "A = 0.3 µm, θx = 5.7°",
        ),
        ("cycles", 30000.0, "30000"),
    ],
)
def test_values_come_in_units_for_people(name: str, value: object, expected: str) -> None:
    assert value_text(name, value) == expected


def test_symbols_and_words_name_the_parameter_unless_the_value_does() -> None:
    assert symbol_text("load", 50.0) == "$P$ = 50 N"
    assert words_text("load", 50.0) == "normal load 50 N"
    assert symbol_text("plastic_limit", math.inf) == "elastic"
    assert words_text("roughness_amplitude", 0.0) == "smooth"


def test_a_name_that_no_case_has_is_that_of_a_plain_number_or_word() -> None:
    assert symbol_text("run_number", 3.0) == "run_number = 3"
    assert words_text("run_number", 3.0) == "run number 3"
    assert words_text("laboratory", "north") == "north"
