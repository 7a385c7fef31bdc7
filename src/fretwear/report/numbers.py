"""Numbers of a column: as many digits in each."""

from __future__ import annotations

from fretwear.figures.wording import number


def significant(value: float, digits: int) -> str:
    """Return a number with a fixed count of significant digits, zeros at the end included.

    Parameters
    ----------
    value : float
        The number.
    digits : int
        How many digits; more where the whole part has more, which are then zeros.
    """
    if value == 0.0:
        return "0"
    text = f"{value:#.{digits}g}".rstrip(".").replace("-", "−")
    return number(float(f"{value:.{digits}g}")) if "e" in text else text
