"""Numbers and parameters are written as people write them."""

import math

import numpy as np
import pytest

from fretwear.figures.wording import (
    Unit,
    cycle_number,
    number,
    readable_unit,
    symbol_text,
    value_text,
    with_unit,
    words_text,
)
from fretwear.study.case import Case


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
        ("slip_model", "jaeger", "jaeger"),
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
    assert words_text("load", 50.0) == "load 50 N"
    assert symbol_text("plastic_limit", math.inf) == "elastic"
    assert words_text("roughness_amplitude", 0.0) == "smooth"


def test_every_parameter_of_a_case_has_words_of_its_own() -> None:
    case = Case(
        radius=0.01,
        youngs_modulus=(208e9, 70e9),
        poisson_ratio=(0.3, 0.33),
        load=50.0,
        tangential_ratio=0.8,
        friction=0.5,
        wear_coefficient=7e-13,
        cycles=10,
    )
    for name, (value, units, _) in case.scalar_coordinates().items():
        text = words_text(name, value)
        assert "_" not in text or isinstance(value, str)
        plain_number = units in ("", "1") or text in ("smooth", "elastic")
        assert plain_number or any(letter.isalpha() or letter == "°" for letter in text.split()[-1])


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (0.0, "0"),
        (1234567.0, "1.2346·10⁶"),
        (13871.3, "13871"),
        (-0.5, "−0.5"),
        (5.32e-6, "5.32·10⁻⁶"),
        (1e20, "1·10²⁰"),
    ],
)
def test_numbers_have_no_programmers_exponent(value: float, expected: str) -> None:
    assert number(value) == expected


@pytest.mark.parametrize(
    ("largest", "base", "name"),
    [
        (8.4e-7, "m", "nm"),
        (1.2e-6, "m", "µm"),
        (3e-13, "m", "pm"),
        (6.3e-15, "m3", "10³ µm³"),
        (4e-6, "J", "µJ"),
        (0.0, "J", "pJ"),
    ],
)
def test_a_readable_unit_makes_the_largest_value_one_to_a_thousand(
    largest: float, base: str, name: str
) -> None:
    unit = readable_unit([0.1 * largest, largest, np.nan, np.inf], base)
    assert unit.name == name


def test_powers_of_ten_in_a_unit_multiply_the_number_before() -> None:
    assert with_unit("4.1", Unit("10³ µm³", 1e-15)) == "4.1 × 10³ µm³"
    assert with_unit("4.1", Unit("µm", 1e-6)) == "4.1 µm"
    assert with_unit("4.1", Unit("", 1.0)) == "4.1"


def test_thousands_of_cycles_are_set_apart_from_ten_thousand_on() -> None:
    assert [cycle_number(n) for n in (0, 7000, 30000.0)] == ["0", "7000", "30\u2009000"]
