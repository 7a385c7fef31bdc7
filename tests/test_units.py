import math
import subprocess
import sys
from decimal import Decimal
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fretwear import units
from fretwear.units import (
    ANGLE,
    COMPLIANCE,
    FORCE,
    LENGTH,
    NUMBER,
    PRESSURE,
    QuantityError,
    cycle_text,
    duration_text,
    exact_text,
    fixed_digits,
    format_quantity,
    number_text,
    parse_quantity,
    readable_unit,
    size_text,
    with_unit,
)

PHYSICAL = (LENGTH, FORCE, PRESSURE, COMPLIANCE, ANGLE)


@pytest.mark.parametrize(
    ("text", "dimension", "expected"),
    [
        ("50 N", FORCE, 50.0),
        ("50N", FORCE, 50.0),
        ("0.05 kN", FORCE, 50.0),
        ("208 GPa", PRESSURE, 208e9),
        ("4500 N/mm^2", PRESSURE, 4500e6),
        ("0.2 um", LENGTH, 0.2e-6),
        ("0.2 \u00b5m", LENGTH, 0.2e-6),
        ("0.2 \u03bcm", LENGTH, 0.2e-6),
        ("10 mm", LENGTH, 0.01),
        ("1 inch", LENGTH, 0.0254),
        ("5.7 deg", ANGLE, math.radians(5.7)),
        ("5.7\u00b0", ANGLE, math.radians(5.7)),
        ("100 mrad", ANGLE, 0.1),
        ("7e-13 / Pa", COMPLIANCE, 7e-13),
        ("7e-13 1/Pa", COMPLIANCE, 7e-13),
        ("7e-13 Pa^-1", COMPLIANCE, 7e-13),
        ("7e-13 Pa**-1", COMPLIANCE, 7e-13),
        ("7e-13 m^2/N", COMPLIANCE, 7e-13),
        ("7e-4 mm^3/(kN m)", COMPLIANCE, 7e-16),
        ("7e-4 mm3/(N m)", COMPLIANCE, 7e-13),
        ("7e-4 mm3/Nm", COMPLIANCE, 7e-13),
        ("7e-4 mm3/N/m", COMPLIANCE, 7e-13),
        ("7e-4 mm3 N-1 m-1", COMPLIANCE, 7e-13),
        ("7e-4 mm³ N⁻¹ m⁻¹", COMPLIANCE, 7e-13),
        ("4500 N/mm2", PRESSURE, 4500e6),
        ("0.3", NUMBER, 0.3),
        ("1e-3", NUMBER, 1e-3),
        (0.3, NUMBER, 0.3),
        (2, NUMBER, 2.0),
        (50, FORCE, 50.0),
    ],
)
def test_values_as_people_write_them(text, dimension, expected):
    assert parse_quantity(text, dimension) == pytest.approx(expected, rel=1e-15)


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


@pytest.mark.parametrize(
    ("value", "dimension", "expected"),
    [
        (2e-7, LENGTH, "200 nm"),
        (1.5e-6, LENGTH, "1.5 um"),
        (0.9999999999e-6, LENGTH, "1 um"),
        (4.5e9, PRESSURE, "4.5 GPa"),
        (50.0, FORCE, "50 N"),
        (math.radians(5.7), ANGLE, "5.7 deg"),
        (7e-13, COMPLIANCE, "7e-13 / Pa"),
        (math.inf, PRESSURE, "none"),
        (0.3, NUMBER, "0.3"),
    ],
)
def test_values_for_people(value, dimension, expected):
    assert format_quantity(value, dimension) == expected


@pytest.mark.parametrize(
    ("value", "dimension", "parts"),
    [
        ("50 GPa", FORCE, ["must be a force such as 50 N", "'GPa' is a pressure"]),
        ("5 m^2", LENGTH, ["a length", "'m^2' is another quantity"]),
        ("50", FORCE, ["needs a unit", "did you mean '50 N'"]),
        ("7e-4 mm3/N m", COMPLIANCE, ["is another quantity", "mean '7e-4 mm3/(N m)'?"]),
        ("5.7", ANGLE, ["needs a unit", "'5.7 deg'"]),
        ("7e-13", COMPLIANCE, ["needs a unit", "'7e-13 / Pa'"]),
        ("50 gpa", PRESSURE, ["unknown unit 'gpa'", "did you mean 'GPa'"]),
        ("0.2 um1", LENGTH, ["unknown unit 'um1'", "did you mean 'um'"]),
        ("0.3 N", NUMBER, ["a plain number", "without a unit"]),
        ("fifty N", FORCE, ["a force such as 50 N"]),
        ("", FORCE, ["a force"]),
        (50, FORCE, ["needs a unit"]),  # where units are required
        (True, NUMBER, ["a plain number"]),
        (None, FORCE, ["a force"]),
        ([50], FORCE, ["a force"]),
        (math.nan, NUMBER, ["finite"]),
        (math.inf, FORCE, ["finite"]),
        ("1e999 N", FORCE, ["finite"]),
        ("nan N", FORCE, ["a force"]),
        ("5 5 N", FORCE, ["cannot be read"]),
        ("1 m**9**9**9", LENGTH, ["cannot be read"]),
        ("1 m^99", LENGTH, ["cannot be read"]),
        ("1 __import__('os')", LENGTH, ["cannot be read"]),
        ("1 m" + " m" * 500, LENGTH, ["a length"]),
    ],
)
def test_what_is_no_such_quantity_is_refused_with_the_reason(value, dimension, parts):
    required = value == 50
    with pytest.raises(QuantityError) as caught:
        parse_quantity(value, dimension, units_required=required)
    for part in parts:
        assert part in str(caught.value)


unit_like = st.from_regex(r"\A[0-9.]{1,3} ?[ mkuNPadgr/*^().0-9-]{0,20}\Z")


@given(st.text(max_size=30) | unit_like, st.sampled_from((*PHYSICAL, NUMBER)))
def test_any_text_is_a_finite_number_or_a_quantity_error(text, dimension):
    try:
        value = parse_quantity(text, dimension)
    except QuantityError:
        return
    assert math.isfinite(value)


def test_usual_units_are_what_pint_makes_of_them_and_read_without_it():
    registry, dimensions = units._registry()
    for text, (factor, dimension) in units._PLAIN_UNITS.items():
        found = registry.parse_units(units._expression(text.replace("⁻¹", "^-1")))
        in_si = registry.Quantity(Decimal(1), found).to_root_units().magnitude
        assert float(in_si) == float(factor)
        assert dimensions[found.dimensionality] == dimension
    code = (
        "import sys; from fretwear.units import LENGTH, parse_quantity; "
        "parse_quantity('0.2 um', LENGTH); assert 'pint' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def three_digits(value):
    return fixed_digits(value, 3)


@pytest.mark.parametrize(
    ("write", "value", "text"),
    [
        # No programmer's exponent, a minus sign instead of a hyphen.
        (number_text, 0.0, "0"),
        (number_text, 1234567.0, "1.2346·10⁶"),
        (number_text, 13871.3, "13871"),
        (number_text, -0.5, "−0.5"),
        (number_text, 5.32e-6, "5.32·10⁻⁶"),
        (number_text, 1e20, "1·10²⁰"),
        # Numbers that stand below each other have as many digits.
        (three_digits, 1.7, "1.70"),
        (three_digits, 15.82, "15.8"),
        (three_digits, 0.8291, "0.829"),
        (three_digits, 100.2, "100"),
        (three_digits, 38384.0, "38400"),
        (three_digits, -0.5, "−0.500"),
        (three_digits, 0.0, "0"),
        (three_digits, 2.5e-7, "2.5·10⁻⁷"),
        (cycle_text, 7000, "7000"),
        (cycle_text, 30000.0, "30\u2009000"),
        (duration_text, 59.6, "60 s"),
        (duration_text, 125.4, "2 min"),
        (duration_text, 9000.0, "2.5 h"),
        (size_text, 2e5, "200 kB"),
        (size_text, 1.5e9, "1.5 GB"),
    ],
)
def test_numbers_as_people_read_them(write, value, text):
    assert write(value) == text


@pytest.mark.parametrize(
    ("largest", "si_unit", "text"),
    [
        (8.4e-7, "m", "840 nm"),
        (1.2e-6, "m", "1.2 µm"),
        (3e-13, "m", "0.3 pm"),
        (6.3e-15, "m3", "6.3 × 10³ µm³"),
        (4e-6, "J", "4 µJ"),
        (0.0, "J", "0 pJ"),
    ],
)
def test_a_readable_unit_makes_the_largest_value_one_to_a_thousand(largest, si_unit, text):
    unit = readable_unit([0.1 * largest, -largest, math.nan, math.inf], si_unit)
    assert with_unit(number_text(largest / unit.size), unit) == text
