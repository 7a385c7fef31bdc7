"""Physical values as text for people, and as SI floats for computation.

Text becomes a number in decimal arithmetic and is rounded to a float once, so that the same value
in two spellings (``50 N``, ``0.05 kN``) gives the same float. pint reads the units by a small
registry of our own, in which the angle is a dimension: a bare number is never taken for an angle.
"""

from __future__ import annotations

import difflib
import math
import re
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from functools import cache, cached_property, lru_cache
from numbers import Real
from typing import TYPE_CHECKING, Any, Self, TypeVar

if TYPE_CHECKING:
    import pint
    from numpy.typing import ArrayLike

_Value = TypeVar("_Value")

_GRAVITY = 9.80665
_DEGREE = "0.0174532925199432957692369076849"
_DEFINITIONS = f"""
pico- = 1e-12 = p-, nano- = 1e-9 = n-, micro- = 1e-6 = µ- = μ- = u-, milli- = 1e-3 = m-
centi- = 1e-2 = c-, kilo- = 1e3 = k-, mega- = 1e6 = M-, giga- = 1e9 = G-
meter = [length] = m = metre, kilogram = [mass] = kg, second = [time] = s, hertz = 1 / second = Hz
minute = 60 * second = min, hour = 3600 * second = h, volt = [voltage] = V
kelvin = [temperature] = K, radian = [angle] = rad, degree = {_DEGREE} * radian = deg = °
newton = kilogram * meter / second ** 2 = N, pascal = newton / meter ** 2 = Pa
joule = newton * meter = J = Nm, watt = joule / second = W, bar = 1e5 * pascal
micron = 1e-6 * meter = microns, inch = 0.0254 * meter = in
pound_force = 4.4482216152605 * newton = lbf
psi = pound_force / inch ** 2
ksi = 1000 * psi, kilogram_force = {_GRAVITY} * newton = kgf
gram_force = {_GRAVITY} * millinewton = gf
"""

NUMBER_PATTERN = r"(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d{1,4})?"
_QUANTITY = re.compile(rf"\s*(?P<number>[+-]?{NUMBER_PATTERN})(?P<unit>[^,]*)", re.ASCII)
_UNIT = re.compile(r"[^\W\d_][\w\s*/^().·⋅%°⁻-]*|(?:°|1?\s*/)[\w\s*/^().·⋅⁻-]*")
# Units as tribologists type them: mm3/Nm, mm3 N-1 m-1.
_POWER = re.compile(r"([A-Za-zµμ])(-[1-3]|[23])(?!\d)")
_STACKED_POWER = re.compile(r"[0-9]{2}|(?:\^|\*\*)\s*-?\w+\s*(?:\^|\*\*)")


class QuantityError(ValueError):
    """A value that breaks a rule: the rule, as a sentence without its subject, and a remedy."""

    def __init__(self, rule: str, hint: str = "") -> None:
        self.rule, self.hint = rule, hint
        super().__init__(rule, hint)

    def __str__(self) -> str:
        return f"{self.rule}; {self.hint}" if self.hint else self.rule


@dataclass(frozen=True)
class Unit:
    """A unit in which values are shown."""

    name: str  # as printed: ``µm``, ``10³ µm³``; empty for plain numbers
    size: float = 1.0  # its value in SI units
    typed: str = ""  # as typed in a study file where that differs from the name: ``um``

    @property
    def is_power(self) -> bool:
        """Whether the name begins with a power of ten."""
        return self.name.startswith("10")

    def of(self, values: Any) -> Any:
        """Return SI values, a number or an array, in this unit."""
        return values / self.size


class FloatWithUnit(float):
    """A value that keeps its unit, if a quantity may be of two kinds."""

    __slots__ = ("si_unit",)
    si_unit: str

    def __new__(cls, value: float, si_unit: str = "") -> Self:
        """Return the SI value, with the SI unit of its kind."""
        quantity = super().__new__(cls, value)
        quantity.si_unit = si_unit
        return quantity


@dataclass(frozen=True)
class ContactFrame:
    """Differences between a point and a line contact: axes, words and units."""

    name: str
    axes: tuple[str, ...]  # along which the fields of a contact vary
    extent: str  # the term for half the width of a contact
    has_depth: bool  # whether the approach counts from far away, not from an arbitrary reference
    # SI units of integrals over the contact that differ from a point contact's.
    units: Mapping[str, str] = field(default_factory=dict, compare=False)

    @property
    def dims(self) -> tuple[str, ...]:
        """The dimensions of fields over the cycles."""
        return "cycle", *self.axes

    def unit(self, si_unit: str) -> str:
        """Return the SI unit here of a quantity that has this one in a point contact."""
        return self.units.get(si_unit, si_unit)

    def words(self, words: str, si_unit: str) -> str:
        """Return the words for a quantity that has this SI unit in a point contact."""
        return f"{words} per length" if si_unit in self.units else words


POINT_CONTACT = ContactFrame("point", ("x", "y"), "radius", has_depth=True)
_PER_LENGTH = {"N": "N m-1", "J": "J m-1", "m3": "m2", "m2": "m"}
LINE_CONTACT = ContactFrame("line", ("x",), "half-width", has_depth=False, units=_PER_LENGTH)
"""A line contact in plane strain."""


NO_UNIT = Unit("")
NANOMETRE = Unit("nm", 1e-9)
MICROMETRE = Unit("µm", 1e-6, "um")
MEGAPASCAL = Unit("MPa", 1e6)
PERCENT = Unit("%", 0.01)


@dataclass(frozen=True)
class Dimension:
    """A kind of physical quantity."""

    name: str  # with its article, as it stands in messages: "a force"
    si_unit: str  # SI unit in the notation of dataset attributes (UDUNITS), "1" for plain numbers
    typed: str  # the SI unit as typed in a study file
    example: str  # a value as a study file would have it
    units: tuple[Unit, ...] = ()  # units for people, ascending

    @property
    def expectation(self) -> str:
        """The rule for values of this kind: "must be a force such as 50 N"."""
        return f"must be {self.name} such as {self.example}"

    @property
    def is_plain_number(self) -> bool:
        """Whether values have no unit at all."""
        return self.si_unit == "1"

    @cached_property
    def sizes(self) -> dict[str, Decimal]:
        """SI values of the units that people usually type, which need no parser."""
        sizes = {self.typed: "1"}
        for unit in self.units:
            if not unit.is_power:
                size = _DEGREE if unit.typed == "deg" else repr(unit.size)
                sizes[unit.typed or unit.name] = size
        return {typed: Decimal(size) for typed, size in sizes.items()}


_PREFIXES = {"p": 1e-12, "n": 1e-9, "µ": 1e-6, "m": 1e-3, "": 1.0, "k": 1e3, "M": 1e6, "G": 1e9}


def _prefixed(unit: str, *prefixes: str) -> tuple[Unit, ...]:
    names = {f"{prefix}{unit}": _PREFIXES[prefix] for prefix in prefixes}
    return tuple(
        Unit(name, size, name.replace("µ", "u") if "µ" in name else "")
        for name, size in names.items()
    )


_SMALL = "p", "n", "µ", "m", ""
_AREAS = (Unit("µm²", 1e-12, "um^2"), Unit("10³ µm²", 1e-9), Unit("mm²", 1e-6, "mm^2"))
_VOLUMES = (
    *(Unit("µm³", 1e-18, "um^3"), Unit("10³ µm³", 1e-15), Unit("10⁶ µm³", 1e-12)),
    Unit("mm³", 1e-9, "mm^3"),
)
_WEAR = (
    Unit("Pa⁻¹", 1.0, "/ Pa"),
    Unit("µm mm/N", 1e-9, "um/(N/mm)"),
    Unit("mm³/J", 1e-9, "mm^3/J"),
)
_LINE = (Unit("N/m"), Unit("N/mm", 1e3), Unit("N/µm", 1e6, "N/um"))
_ENERGIES_PER_AREA = (
    Unit("J/m²", 1.0, "J/m^2"),
    Unit("mJ/mm²", 1e3, "mJ/mm^2"),
    Unit("J/mm²", 1e6, "J/mm^2"),
)
_AREAS_PER_POWER = (Unit("mm²/W", 1e-6, "mm^2/W"), Unit("m²/W", 1.0, "m^2/W"))

LENGTH = Dimension("a length", "m", "m", "0.2 um", _prefixed("m", *_SMALL))
FORCE = Dimension("a force", "N", "N", "50 N", _prefixed("N", "m", "", "k"))
PRESSURE = Dimension("a pressure", "Pa", "Pa", "208 GPa", _prefixed("Pa", "", "k", "M", "G"))
COMPLIANCE = Dimension("an inverse pressure", "Pa-1", "/ Pa", "7e-13 / Pa", _WEAR)
FORCE_PER_LENGTH = Dimension("a force per length", "N m-1", "N/m", "18.5 N/mm", _LINE)
ANGLE = Dimension("an angle", "rad", "rad", "5.7 deg", (Unit("°", float(_DEGREE), "deg"),))
NUMBER = Dimension("a plain number", "1", "", "0.3")

DIMENSIONS = (
    *(LENGTH, FORCE, FORCE_PER_LENGTH, PRESSURE, COMPLIANCE, ANGLE),
    Dimension("an area per power", "m2 W-1", "m^2/W", "11 mm^2/W", _AREAS_PER_POWER),
    Dimension("a frequency", "s-1", "Hz", "10 Hz", (Unit("Hz"),)),
    Dimension("a temperature", "K", "K", "300 K", (Unit("K"),)),
    Dimension("an area", "m2", "m^2", "0.5 mm^2", _AREAS),
    Dimension("a volume", "m3", "m^3", "1.2e-3 mm^3", _VOLUMES),
    Dimension("an energy", "J", "J", "2 mJ", _prefixed("J", *_SMALL)),
    Dimension("an energy per length", "J m-1", "J/m", "0.5 J/m", _prefixed("J/m", *_SMALL)),
    Dimension("an energy per area", "J m-2", "J/m^2", "2 mJ/mm^2", _ENERGIES_PER_AREA),
)
"""Every kind of quantity that a parameter or a measured value may be, except plain numbers."""

BY_SI_UNIT = {dimension.si_unit: dimension for dimension in (*DIMENSIONS, NUMBER)}


@cache
def _registry() -> Any:
    """Return pint's reader of units."""
    if not sys.modules.get("pint"):  # not imported yet, or hidden from xarray
        sys.modules.pop("pint", None)
    import pint  # takes a fifth of a second, too much for some commands

    registry: pint.UnitRegistry[Any] = pint.UnitRegistry(
        None, cache_folder=None, non_int_type=Decimal
    )
    registry.load_definitions(re.split(", |\n", _DEFINITIONS.strip()))
    return registry


@lru_cache(maxsize=1024)
def _unit(text: str) -> tuple[Decimal, object]:
    """Return the SI value of a unit and its dimensionality."""
    if not _UNIT.fullmatch(text) or _STACKED_POWER.search(text):
        raise QuantityError(f"has a unit that cannot be read: {text!r}")
    registry = _registry()
    try:
        units = registry.parse_units(_POWER.sub(r"\1^\2", f"1{text}" if text[0] == "/" else text))
        in_si = registry.Quantity(Decimal(1), units).to_root_units()
    except Exception as error:  # pint passes on errors of tokenizer, arithmetic and attributes
        raise QuantityError(f"has an unknown unit {text!r}") from error
    return Decimal(in_si.magnitude), units.dimensionality


def nearest(name: object, valid: Iterable[str], cutoff: float = 0.6) -> str:
    """Return the valid word nearest to a misspelt one, or an empty text."""
    by_fold = {word.casefold(): word for word in valid}
    folded = name.casefold() if isinstance(name, str) else ""
    near = difflib.get_close_matches(folded, by_fold, n=1, cutoff=cutoff)
    return by_fold[near[0]] if near else ""


def did_you_mean(name: object, valid: Iterable[str], cutoff: float = 0.6) -> str:
    """Return "did you mean" with the nearest valid word; empty if none is near."""
    near = nearest(name, valid, cutoff)
    return f"did you mean {near!r}?" if near else ""


def in_unit(value: _Value, si_unit: str) -> _Value | FloatWithUnit:
    """Return an SI value, with its unit if a quantity may be of two kinds."""
    return FloatWithUnit(value, si_unit) if isinstance(value, float) else value


# Units of workshops, with units of physics in their place.
_IN_PHYSICS = {
    **dict.fromkeys(("HV", "HB", "HBW", "HK"), "kgf/mm^2"),
    "kg": "kgf",
    "g": "gf",
    "rpm": "/ min",
}
_SEPARATED = re.compile(r"[+-]?\d+(?:[ ,_']\d+)+")
_FAR = 1.5  # decades


def _physical(written: str, unit: str, dimension: Dimension) -> str:
    """Return a hint at the value in a unit of physics, for a unit of workshops."""
    meant = _IN_PHYSICS.get(unit)
    if meant is None or _unit(meant)[1] != _unit(dimension.typed)[1]:
        return "convert it to HV, whose unit is kgf/mm^2" if unit.startswith("HR") else ""
    number = float(Decimal(written) * _unit(meant)[0])
    return f"did you mean '{written} {meant}', {format_quantity(number, dimension, 4)}?"


def _likely_unit(written: str, dimension: Dimension) -> str:
    """Return the unit of the example, or one that brings a number much nearer to the example."""
    number, _, usual = dimension.example.partition(" ")
    sizes = {usual: _unit(usual)[0], **dimension.sizes}
    typical = Decimal(number) * sizes[usual]

    def distance(unit: str) -> float:
        return abs(math.log10(abs(Decimal(written) * sizes[unit] / typical) or 1.0))

    best = min(sizes, key=distance)
    return best if distance(usual) - distance(best) > _FAR else usual


def parse_quantity(value: object, dimension: Dimension, *, units_required: bool = False) -> float:
    """Turn a value as written into an SI number.

    The value is text with a unit (``"0.2 um"``) or a number, which counts as SI unless
    `units_required`, as in study files.  A plain number may also be text, because YAML reads
    ``1e-3`` as text.  Raises `QuantityError` if the value is not a finite number, or if its unit
    is missing, unknown or of another dimension.
    """
    is_separated = isinstance(value, str) and _SEPARATED.match(value.strip())
    separators = "numbers have a decimal point and no other separators" if is_separated else ""
    if isinstance(value, Real) and not isinstance(value, bool):
        try:
            number = _finite(float(value), dimension)
        except OverflowError:  # a whole number may be larger than any float
            number = _finite(math.inf, dimension)
        if dimension.is_plain_number or not units_required:
            return number
        written, unit = f"{number:.12g}", ""
    else:
        match = _QUANTITY.fullmatch(value) if isinstance(value, str) else None
        if match is None:
            hint = "several values belong into vary of a study" if isinstance(value, list) else ""
            raise QuantityError(dimension.expectation, hint or separators)
        written, unit = match["number"], match["unit"].strip()
    if dimension.is_plain_number:
        if unit not in ("", PERCENT.name):
            raise QuantityError(f"{dimension.expectation}, without a unit", separators)
        return _finite(float(Decimal(written) / 100 if unit else written), dimension)
    if not unit:
        rule = f"needs a unit: it is {dimension.name} such as {dimension.example}"
        hint = f"did you mean '{written} {_likely_unit(written, dimension)}'?"
        if dimension.si_unit == COMPLIANCE.si_unit:
            hint = (
                f"write '{written} mm^3/(N m)' if that is meant; the dimensionless k of Archard's "
                "law is divided by the hardness H: write k/H, such as 2e-13 / Pa"
            )
        raise QuantityError(rule, hint)
    if unit in dimension.sizes:
        return _finite(float(Decimal(written) * dimension.sizes[unit]), dimension)
    try:
        factor, dimensionality = _unit(unit)
    except QuantityError as error:
        valid = [dimension.typed, *(usual.typed or usual.name for usual in dimension.units)]
        hint = _physical(written, unit, dimension) or did_you_mean(unit, valid, cutoff=0.5)
        raise QuantityError(f"{dimension.expectation}, but {error.rule}", hint) from error
    if dimensionality != _unit(dimension.typed)[1]:
        kinds = (kind.name for kind in DIMENSIONS if _unit(kind.typed)[1] == dimensionality)
        hint = _physical(written, unit, dimension)
        raise QuantityError(
            f"{dimension.expectation}, but {unit!r} is {next(kinds, 'another quantity')}", hint
        )
    return _finite(float(Decimal(written) * factor), dimension)


def _finite(number: float, dimension: Dimension) -> float:
    if not math.isfinite(number):
        raise QuantityError(f"{dimension.expectation}, and finite")
    # Minus zero is zero: two spellings of one value must not make two cases.
    return number + 0.0


def format_quantity(value: float, dimension: Dimension, digits: int = 6) -> str:
    """Write an SI number as in a study file, in the unit that is easiest to read.

    >>> format_quantity(2e-7, LENGTH), format_quantity(4.5e9, PRESSURE)
    ('200 nm', '4.5 GPa')
    """
    if math.isinf(value) and value > 0.0:
        return "none"
    # Rounding first keeps 999.9999 nm from being written as 1000 nm.
    rounded = abs(float(f"{value:.{digits}g}"))
    units = [unit for unit in dimension.units if not unit.is_power] or [NO_UNIT]
    chosen = _fitting(units, rounded * (1.0 + 1e-9))
    return f"{value / chosen.size:.{digits}g} {chosen.typed or chosen.name}".rstrip()


def exact_text(value: float, dimension: Dimension) -> str:
    """Write an SI number so that `parse_quantity` gives back the same float."""
    return repr(value) if dimension.is_plain_number else f"{value!r} {dimension.typed}"


def readable_unit(values: ArrayLike, si_unit: str) -> Unit:
    """Return the unit in which the largest of some values, in SI units, is from 1 to 1000.

    NaN and infinite values do not count. Zero, or no finite value, has a unit that people type.
    """
    import numpy as np

    magnitudes = np.abs(np.asarray(values, dtype=np.float64))
    largest = magnitudes.max(initial=0.0, where=np.isfinite(magnitudes))
    return _fitting(BY_SI_UNIT[si_unit].units or [PERCENT], largest)


def _fitting(units: Sequence[Unit], value: float) -> Unit:
    """Return the largest unit that does not exceed a value, else the smallest unit."""
    if value == 0.0:
        typed = [unit for unit in units if unit.typed]
        return typed[0] if typed else min(units, key=lambda unit: abs(math.log(unit.size)))
    return [units[0], *(unit for unit in units if unit.size <= value)][-1]


def number_text(value: float, digits: int = 5) -> str:
    """Return a number with at most `digits` significant digits, as people write it.

    >>> number_text(1234567.0), number_text(-0.5)
    ('1.2346·10⁶', '−0.5')
    """
    text = f"{value:.{digits}g}"
    if value == 0.0 or 1e-4 <= abs(float(text)) < 1e6:
        text = f"{float(text):.10g}"
    mantissa, _, exponent = text.partition("e")
    raised = str(int(exponent or 0)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return mantissa.replace("-", "−") + (f"·10{raised}" if exponent else "")


def with_error(value: float, error: float, digits: int = 5) -> str:
    """Return a number with its error, both rounded to the leading digit of the error.

    An error that would hardly change the last digit is left out. A NaN value is a dash.

    >>> with_error(0.08471, 0.00034), with_error(1234.0, 170.0), with_error(2.5, 1e-9)
    ('0.0847 ± 0.0003', '1230 ± 170', '2.5')
    >>> with_error(1234.0, math.inf), with_error(math.nan, 0.0)
    ('1234 ± ∞', '–')
    """
    if math.isnan(value):
        return "–"
    if error == math.inf:
        return f"{number_text(value, digits)} ± ∞"
    if not error > 0.0 or error < 0.5 * abs(value) * 10.0 ** (1 - digits):
        return number_text(value, digits)
    first = math.floor(math.log10(error))
    # One digit is too coarse for a leading 1: 1.7 would become 2.
    place = first - 1 if error < 2.0 * 10.0**first else first
    if not 1e-4 <= abs(value) < 1e6:
        return f"{number_text(value, digits)} ± {number_text(error, first - place + 1)}"
    value, error = round(value, -place), round(error, -place)
    return f"{value:.{max(-place, 0)}f} ± {error:.{max(-place, 0)}f}".replace("-", "−")


def axis_label(words: str, unit: Unit) -> str:
    """Return words with their unit as the label of an axis: ``Wear volume (µm³)``."""
    label = words[:1].upper() + words[1:]
    return f"{label} ({unit.name})" if unit.name else label


def with_unit(text: str, unit: Unit) -> str:
    """Return a number with its unit for running text: ``4.1 µm``, ``4.1 × 10³ µm³``, ``5.7°``."""
    if unit.is_power:
        return f"{text} × {unit.name}"
    return f"{text}{unit.name}" if unit.name in ("", "°") else f"{text} {unit.name}"


def cycle_text(cycle: float) -> str:
    """Return a number of cycles with a thin space between thousands, from 10 000 on."""
    rounded = round(float(cycle))
    return f"{rounded:,}".replace(",", "\u2009") if rounded >= 10_000 else str(rounded)


def duration_text(seconds: float) -> str:
    """Write a time for people: ``12 s``, ``3 min``, ``2.5 h``."""
    if seconds < 120.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 7200.0 else f"{seconds / 3600.0:.1f} h"


def size_text(number: float) -> str:
    """Write a number of bytes for people: ``200 kB``, ``20 MB``, ``1.5 GB``."""
    if number < 1e6:
        return f"{number / 1e3:.0f} kB"
    return f"{number / 1e6:.0f} MB" if number < 1e9 else f"{number / 1e9:.1f} GB"


def listed(words: Iterable[str], last: str = "and") -> str:
    """Join words as a sentence does: ``a, b and c``; there is at least one."""
    *others, end = words
    return f"{', '.join(others)} {last} {end}" if others else end


def span(values: Iterable[float], text: Callable[[float], str]) -> str:
    """Return the range of some values as text, or a single value if both ends read the same."""
    numbers = list(values)
    low, high = text(min(numbers)), text(max(numbers))
    return low if low == high else f"{low} to {high}"
