import math
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fretwear.quantity import Quantity
from fretwear.study.case import Case, CaseError
from fretwear.units import (
    ANGLE,
    COMPLIANCE,
    DIMENSIONS,
    FORCE,
    LENGTH,
    NUMBER,
    PRESSURE,
    QuantityError,
    cycle_text,
    duration_text,
    exact_text,
    format_quantity,
    number_text,
    parse_quantity,
    readable_unit,
    size_text,
    with_unit,
)

from .studies import STEEL, near

PHYSICAL = (LENGTH, FORCE, PRESSURE, COMPLIANCE, ANGLE)


@pytest.mark.parametrize(
    ("texts", "dimension", "expected"),
    [
        ("50 N, 50N, 0.05 kN", FORCE, 50.0),
        ("208 GPa, 208e3 N/mm^2, 208e3 N/mm2", PRESSURE, 208e9),
        ("0.2 um, 0.2 \u00b5m, 0.2 \u03bcm, 200 nm, 2e-4mm", LENGTH, 0.2e-6),
        ("1 inch, 25.4 mm, 0.0254 metre", LENGTH, 0.0254),
        ("5.7 deg, 5.7\u00b0", ANGLE, math.radians(5.7)),
        ("100 mrad", ANGLE, 0.1),
        ("7e-13 / Pa, 7e-13 1/Pa, 7e-13 Pa^-1, 7e-13 Pa**-1, 7e-13 m^2/N", COMPLIANCE, 7e-13),
        ("7e-4 mm3/(N m), 7e-4 mm3/Nm, 7e-4 mm3/N/m, 7e-1 mm^3/(kN m)", COMPLIANCE, 7e-13),
        ("7e-4 mm3 N-1 m-1, 7e-4 mm³ N⁻¹ m⁻¹", COMPLIANCE, 7e-13),
        ("0.3, 3e-1", NUMBER, 0.3),
    ],
)
def test_values_as_people_write_them(texts, dimension, expected):
    for text in (*texts.split(", "), expected):
        assert parse_quantity(text, dimension) == pytest.approx(expected, rel=1e-15), text
    assert parse_quantity(2, dimension) == 2.0


@given(st.decimals("1e-6", "1e6", places=6), st.sampled_from(["nm", "um", "mm", "m"]))
def test_prefixes_are_exact_powers_of_ten(number, unit):
    power = {"nm": -9, "um": -6, "mm": -3, "m": 0}[unit]
    exact = float(Fraction(number) * Fraction(10) ** power)
    assert parse_quantity(f"{number:f} {unit}", LENGTH) == exact


@given(st.floats(1e-15, 1e15), st.sampled_from(PHYSICAL))
def test_exact_text_reads_back_to_the_last_bit(value, dimension):
    assert parse_quantity(exact_text(value, dimension), dimension, units_required=True) == value


@given(st.floats(1e-15, 1e15), st.sampled_from((*PHYSICAL, NUMBER)))
def test_text_for_people_reads_back_to_its_digits(value, dimension):
    text = format_quantity(value, dimension, digits=8)
    assert parse_quantity(text, dimension) == pytest.approx(value, rel=1e-7)


def test_each_unit_has_the_size_with_which_it_is_read():
    for dimension in DIMENSIONS:
        for unit in dimension.units:
            text = f"1 {unit.typed or unit.name}".replace("1 10³", "1e3").replace("1 10⁶", "1e6")
            assert parse_quantity(text, dimension) == near(unit.size, rel=1e-12)
            # Usual units need no parser, which agrees to the last bit.
            text = text.replace("1", "0.7", 1)
            assert parse_quantity(f"{text} * m / m", dimension) == parse_quantity(text, dimension)


def test_values_for_people():
    for dimension, texts in {
        LENGTH: {2e-7: "200 nm", 1.5e-6: "1.5 um", 0.9999999999e-6: "1 um"},
        PRESSURE: {4.5e9: "4.5 GPa", math.inf: "none"},
        FORCE: {50.0: "50 N"},
        ANGLE: {math.radians(5.7): "5.7 deg"},
        COMPLIANCE: {7e-13: "7e-13 / Pa"},
        NUMBER: {0.3: "0.3"},
    }.items():
        assert {value: format_quantity(value, dimension) for value in texts} == texts


@pytest.mark.parametrize(
    ("value", "dimension", "parts"),
    [
        ("50 GPa", FORCE, ["must be a force such as 50 N", "'GPa' is a pressure"]),
        ("5 m^2", LENGTH, ["a length", "'m^2' is an area"]),
        ("50", FORCE, ["needs a unit", "did you mean '50 N'"]),
        ("7e-4 mm3/N m", COMPLIANCE, ["is another quantity"]),
        ("5.7", ANGLE, ["needs a unit", "'5.7 deg'"]),
        ("7e-4", COMPLIANCE, ["needs a unit", "7e-4 mm^3/(N m)", "dimensionless k"]),
        ("50 gpa", PRESSURE, ["unknown unit 'gpa'", "did you mean 'GPa'"]),
        ("0.2 um1", LENGTH, ["unknown unit 'um1'", "did you mean 'um'"]),
        ("50 g", FORCE, ["unknown unit 'g'", "did you mean '50 gf', 490.3 mN?"]),
        ("300 HV", PRESSURE, ["unknown unit 'HV'", "did you mean '300 kgf/mm^2', 2.942 GPa?"]),
        ("0.3 N", NUMBER, ["a plain number", "without a unit"]),
        (50, FORCE, ["needs a unit"]),  # where units are required
        (True, NUMBER, ["a plain number"]),
        *((none, FORCE, ["a force such as 50 N"]) for none in ("fifty N", "", "nan N", None, [50])),
        *((endless, FORCE, ["finite"]) for endless in (math.nan, math.inf, "1e999 N")),
        *((f"1 {odd}", LENGTH, ["cannot be read"]) for odd in ("5 m", "m^99", "m**9**9**9")),
        ("1 __import__('os')", LENGTH, ["cannot be read"]),
    ],
)
def test_what_is_no_such_quantity_is_refused_with_the_reason(value, dimension, parts):
    required = value == 50
    with pytest.raises(QuantityError) as caught:
        parse_quantity(value, dimension, units_required=required)
    for part in parts:
        assert part in str(caught.value)


@pytest.mark.parametrize(
    ("write", "texts"),
    [
        # No programmer's exponent, a minus sign instead of a hyphen.
        (number_text, {0.0: "0", 1234567.0: "1.2346·10⁶", 13871.3: "13871", -0.5: "−0.5"}),
        (number_text, {5.32e-6: "5.32·10⁻⁶", 1e20: "1·10²⁰"}),
        (cycle_text, {7000: "7000", 30000.0: "30\u2009000"}),
        (duration_text, {59.6: "60 s", 125.4: "2 min", 9000.0: "2.5 h"}),
        (size_text, {2e5: "200 kB", 1.5e9: "1.5 GB"}),
    ],
)
def test_numbers_as_people_read_them(write, texts):
    assert {value: write(value) for value in texts} == texts


@pytest.mark.parametrize(
    ("largest", "si_unit", "text"),
    [
        (8.4e-7, "m", "840 nm"),
        (1.2e-6, "m", "1.2 µm"),
        (3e-13, "m", "0.3 pm"),
        (6.3e-15, "m3", "6.3 × 10³ µm³"),
        (4e-6, "J", "4 µJ"),
        (0.0, "J", "0 µJ"),
    ],
)
def test_a_readable_unit_makes_the_largest_value_one_to_a_thousand(largest, si_unit, text):
    unit = readable_unit([0.1 * largest, -largest, math.nan, math.inf], si_unit)
    assert with_unit(number_text(largest / unit.size), unit) == text


def test_a_quantity_of_an_unknown_unit_and_a_length_beyond_ten_metres_are_refused():
    with pytest.raises(ValueError, match="strange: 'J m-5' is not among the SI units"):
        Quantity("J m-5", "$x$", "strange")
    with pytest.raises(CaseError, match="radius = 11 m: must be at most 10 m"):
        Case(**STEEL | {"radius": "11 m"})
