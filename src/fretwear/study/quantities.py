"""Physical values as people write them (``50 N``, ``0.2 um``) and as the computation needs them.

Text is turned into SI numbers in decimal arithmetic and rounded to a float once, so that the same
value in two spellings (``50 N``, ``0.05 kN``) gives the same float.  The units come from a small
pint registry of our own: it starts in a few milliseconds, where pint's full one takes a tenth of
a second, and it knows angles as a dimension, so that a bare number is never taken for an angle.
"""

from __future__ import annotations

import difflib
import math
import re
from dataclasses import dataclass, replace
from decimal import Decimal
from functools import lru_cache
from numbers import Real
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pint

UNIT_DEFINITIONS = """
nano- = 1e-9 = n-
micro- = 1e-6 = µ- = μ- = u-
milli- = 1e-3 = m-
centi- = 1e-2 = c-
kilo- = 1e3 = k-
mega- = 1e6 = M-
giga- = 1e9 = G-
meter = [length] = m = metre
kilogram = [mass] = kg
second = [time] = s
radian = [angle] = rad
degree = 0.0174532925199432957692369076849 * radian = deg = °
newton = kilogram * meter / second ** 2 = N
pascal = newton / meter ** 2 = Pa
joule = newton * meter = J
bar = 1e5 * pascal
inch = 0.0254 * meter
kilogram_force = 9.80665 * newton = kgf
pound_force = 4.4482216152605 * newton = lbf
psi = pound_force / inch ** 2
ksi = 1000 * psi
"""

NUMBER_PATTERN = r"(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d{1,4})?"
_QUANTITY = re.compile(rf"\s*(?P<number>[+-]?{NUMBER_PATTERN})(?P<unit>.*)", re.DOTALL)
_DECIMAL_COMMA = re.compile(r"\s*[+-]?\d+,\d")
_UNIT = re.compile(r"[^\W\d_][\w\s*/^().·⋅%°-]*|(?:°|1?\s*/)[\w\s*/^().·⋅-]*")
_LONG_OR_STACKED_POWER = re.compile(r"[0-9]{2}|(?:\^|\*\*)\s*-?\w+\s*(?:\^|\*\*)")
_MAX_LENGTH = 60


class QuantityError(ValueError):
    """A value that is not the quantity it should be.

    Attributes
    ----------
    rule : str
        What the value must be, as a sentence without its subject ("must be a force, ...").
    hint : str
        The likely correction, or an empty string.
    """

    def __init__(self, rule: str, hint: str = "") -> None:
        self.rule = rule
        self.hint = hint
        super().__init__(rule, hint)

    def __str__(self) -> str:
        return f"{self.rule}; {self.hint}" if self.hint else self.rule


@dataclass(frozen=True)
class Dimension:
    """A kind of physical quantity.

    Attributes
    ----------
    name : str
        With its article, as it stands in messages: "a force".
    si_unit : str
        SI unit in the notation of dataset attributes (UDUNITS), "1" for plain numbers.
    example : str
        A value as a study file would have it.
    scales : tuple of (float, str)
        Units for people, ascending: SI value of the unit and its symbol.
    """

    name: str
    si_unit: str
    example: str
    scales: tuple[tuple[float, str], ...] = ()

    @property
    def expectation(self) -> str:
        """What a value must be, with an example: "must be a force such as 50 N"."""
        return f"must be {self.name} such as {self.example}"

    @property
    def is_plain_number(self) -> bool:
        """Whether values have no unit at all."""
        return self.si_unit == "1"

    def like(self, example: str) -> Dimension:
        """Return the same kind of quantity with another example."""
        return replace(self, example=example)


LENGTH = Dimension(
    "a length", "m", "0.2 um", ((1e-9, "nm"), (1e-6, "um"), (1e-3, "mm"), (1.0, "m"))
)
FORCE = Dimension("a force", "N", "50 N", ((1e-3, "mN"), (1.0, "N"), (1e3, "kN")))
PRESSURE = Dimension(
    "a pressure", "Pa", "208 GPa", ((1.0, "Pa"), (1e3, "kPa"), (1e6, "MPa"), (1e9, "GPa"))
)
COMPLIANCE = Dimension("an inverse pressure", "Pa-1", "7e-13 / Pa", ((1.0, "/ Pa"),))
ANGLE = Dimension("an angle", "rad", "5.7 deg", ((math.pi / 180.0, "deg"),))
NUMBER = Dimension("a plain number", "1", "0.3")

_SI_TEXT = {"m": "m", "N": "N", "Pa": "Pa", "Pa-1": "/ Pa", "rad": "rad"}


@lru_cache(maxsize=1)
def _registry() -> pint.UnitRegistry[Any]:
    # pint costs a fifth of a second to import: only those who give units pay for it.
    import pint

    registry: pint.UnitRegistry[Any] = pint.UnitRegistry(
        None, cache_folder=None, non_int_type=Decimal
    )
    registry.load_definitions(UNIT_DEFINITIONS.strip().splitlines())
    return registry


@lru_cache(maxsize=1)
def _dimensionalities() -> dict[Any, Dimension]:
    parse = _registry().parse_units
    return {
        parse(_expression(_SI_TEXT[dimension.si_unit])).dimensionality: dimension
        for dimension in (LENGTH, FORCE, PRESSURE, COMPLIANCE, ANGLE)
    }


def _expression(unit: str) -> str:
    return f"1{unit}" if unit.startswith("/") else unit


@lru_cache(maxsize=1024)
def _unit(text: str) -> tuple[Decimal, Dimension | None]:
    """Return the SI value of a unit and its kind (None: a kind that no parameter has)."""
    readable = _UNIT.fullmatch(text) and not _LONG_OR_STACKED_POWER.search(text)
    if not readable or len(text) > _MAX_LENGTH:
        raise QuantityError(f"has a unit that cannot be read: {text!r}")
    try:
        units = _registry().parse_units(_expression(text))
        in_si = _registry().Quantity(Decimal(1), units).to_root_units()
    except Exception as error:  # pint lets tokenizer, arithmetic and attribute errors through
        raise QuantityError(f"has an unknown unit {text!r}") from error
    return Decimal(in_si.magnitude), _dimensionalities().get(units.dimensionality)


def _spelling(unit: str, dimension: Dimension) -> str:
    known = [_SI_TEXT[dimension.si_unit], *(symbol for _, symbol in dimension.scales)]
    by_fold = {name.casefold(): name for name in known}
    near = difflib.get_close_matches(unit.casefold(), by_fold, n=1, cutoff=0.5)
    return f"did you mean {by_fold[near[0]]!r}?" if near else ""


def parse_quantity(value: object, dimension: Dimension, *, units_required: bool = False) -> float:
    """Turn a value as written into an SI number.

    Parameters
    ----------
    value : str or number
        Text with a unit (``"0.2 um"``), or a number, which counts as SI.
    dimension : Dimension
        What the value must be.  For `NUMBER` text without a unit is accepted as well, because
        YAML reads ``1e-3`` as text.
    units_required : bool
        Refuse numbers without a unit (study files do, for everything but `NUMBER`).

    Returns
    -------
    float
        Finite, in the SI unit of the dimension.

    Raises
    ------
    QuantityError
        Not a number, not finite, no unit, an unknown unit or one of another dimension.
    """
    if isinstance(value, Real) and not isinstance(value, bool):
        number = _finite(_as_float(value), dimension)
        if units_required and not dimension.is_plain_number:
            raise _no_unit(f"{number:.12g}", dimension)
        return number
    if not isinstance(value, str) or len(value) > _MAX_LENGTH:
        raise QuantityError(dimension.expectation)
    if _DECIMAL_COMMA.match(value):
        raise QuantityError(dimension.expectation, "write a decimal point, not a comma")
    match = _QUANTITY.fullmatch(value)
    if match is None:
        raise QuantityError(dimension.expectation)
    unit = match["unit"].strip()
    if not unit:
        if not dimension.is_plain_number:
            raise _no_unit(match["number"], dimension)
        return _finite(float(match["number"]), dimension)
    if dimension.is_plain_number:
        raise QuantityError(f"{dimension.expectation}, without a unit")
    try:
        factor, found = _unit(unit)
    except QuantityError as error:
        rule = f"{dimension.expectation}, but {error.rule}"
        raise QuantityError(rule, _spelling(unit, dimension)) from error
    if found is None or found.si_unit != dimension.si_unit:
        kind = "another quantity" if found is None else found.name
        raise QuantityError(f"{dimension.expectation}, but {unit!r} is {kind}")
    return _finite(float(Decimal(match["number"]) * factor), dimension)


def _as_float(value: Real) -> float:
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _no_unit(number: str, dimension: Dimension) -> QuantityError:
    unit = dimension.example.split(" ", 1)[1]
    return QuantityError(
        f"needs a unit: it is {dimension.name} such as {dimension.example}",
        f"did you mean '{number} {unit}'?",
    )


def _finite(number: float, dimension: Dimension) -> float:
    if not math.isfinite(number):
        raise QuantityError(f"{dimension.expectation}, and finite")
    return number


def format_quantity(value: float, dimension: Dimension, digits: int = 6) -> str:
    """Write an SI number for people, with the unit that makes it easiest to read.

    >>> format_quantity(2e-7, LENGTH), format_quantity(4.5e9, PRESSURE)
    ('200 nm', '4.5 GPa')
    """
    if math.isinf(value) and value > 0.0:
        return "none"
    # Rounding first keeps 999.9999 nm from being written as 1000 nm.
    rounded = float(f"{value:.{digits}g}")
    scale, symbol = 1.0, ""
    for index, (candidate, name) in enumerate(dimension.scales):
        if index == 0 or abs(rounded) >= candidate * (1.0 - 1e-9):
            scale, symbol = candidate, name
    return f"{value / scale:.{digits}g} {symbol}".rstrip()


def exact_text(value: float, dimension: Dimension) -> str:
    """Write an SI number so that `parse_quantity` gives back the same float."""
    return repr(value) if dimension.is_plain_number else f"{value!r} {_SI_TEXT[dimension.si_unit]}"
