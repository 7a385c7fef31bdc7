"""Numbers and parameters are written as people write them."""

import math

import pytest

from fretwear.study.parameters import symbol_text, value_text, words_text


@pytest.mark.parametrize(
    ("text", "name", "value", "expected"),
    [
        (value_text, "load", 50.0, "50 N"),
        (value_text, "youngs_modulus", 208e9, "208 GPa"),
        (value_text, "plastic_limit", 4.5e9, "4500 MPa"),
        (value_text, "plastic_limit", math.inf, "elastic"),
        (value_text, "roughness_amplitude", 2e-7, "0.2 µm"),
        (value_text, "roughness_amplitude", 0.0, "smooth"),
        (value_text, "roughness_slope_x", math.radians(5.7), "5.7°"),
        (value_text, "friction", 0.3, "0.3"),
        (value_text, "wear_coefficient", 7e-13, "7·10⁻¹³ Pa⁻¹"),
        (value_text, "slip_model", "jaeger", "slip of the worn shape"),
        (value_text, "roughness", "none", "smooth"),
        (
            value_text,
            "roughness",
            "{kind: wavy, amplitude: 0.3 um, slope_x: 5.7 deg, slope_y...",
            "A = 0.3 µm, θx = 5.7°",
        ),
        (value_text, "cycles", 30000.0, "30000"),
        # Symbols and words name the parameter unless the value does.
        (symbol_text, "load", 50.0, "$P$ = 50 N"),
        (words_text, "load", 50.0, "normal load 50 N"),
        (symbol_text, "plastic_limit", math.inf, "elastic"),
        (words_text, "roughness_amplitude", 0.0, "smooth"),
        # A name that no case has is that of a plain number or word.
        (symbol_text, "run_number", 3.0, "run_number = 3"),
        (words_text, "run_number", 3.0, "run number 3"),
        (words_text, "laboratory", "north", "north"),
    ],
)
def test_values_symbols_and_words_are_written_for_people(text, name, value, expected):
    assert text(name, value) == expected
