"""Numbers that stand below each other have as many digits."""

import pytest

from fretwear.report.numbers import significant


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1.7, "1.70"),
        (15.82, "15.8"),
        (0.8291, "0.829"),
        (100.2, "100"),
        (38384.0, "38400"),
        (-0.5, "−0.500"),
        (0.0, "0"),
        (2.5e-7, "2.5·10⁻⁷"),
    ],
)
def test_three_digits_are_three_digits(value: float, text: str) -> None:
    assert significant(value, 3) == text
