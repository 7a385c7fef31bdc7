"""Parts of a case declare their parameters: how each is read, printed, stored and identified.

A part is a frozen dataclass that is parameter object and physics at once.  A `Parameter` annotates
each of its fields, and is the only place that names it::

    radius: Annotated[float, Quantity("m", "$R$", "sphere radius", "mm", above=0.0), "Its radius."]

Study files, ``--set``, the JSON Schema, messages, the case id, dataset coordinates and labels
follow by walking the fields.
"""

from __future__ import annotations

import dataclasses
import math
import operator
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache
from typing import Any, ClassVar, Self, TypeGuard, cast, get_type_hints

from fretwear.units import (
    DIMENSIONS,
    FORCE_PER_LENGTH,
    NO_UNIT,
    NUMBER,
    NUMBER_PATTERN,
    Dimension,
    Force,
    PerLength,
    Unit,
    format_quantity,
    listed,
    number_text,
    parse_quantity,
    with_unit,
)
from fretwear.units import QuantityError as QuantityError

# No physical value lies beyond; powers and quotients of such numbers stay finite.
_SMALLEST, _LARGEST = 1e-30, 1e30

_NUMBER_SCHEMA = {"type": "string", "pattern": rf"^\s*[+-]?{NUMBER_PATTERN}\s*$"}
_QUANTITY_SCHEMA = {"type": "string", "pattern": rf"^\s*[+]?{NUMBER_PATTERN}\s*[A-Za-zµμ°/].*$"}
# A bound of a quantity: its words, what it asks for, its keyword in a JSON Schema.
_BOUNDS = {
    "above": ("larger than", operator.gt, "exclusiveMinimum"),
    "at_least": ("at least", operator.ge, "minimum"),
    "below": ("less than", operator.lt, "exclusiveMaximum"),
    "at_most": ("at most", operator.le, "maximum"),
}
_BY_SI_UNIT = {dimension.si_unit: dimension for dimension in (*DIMENSIONS, NUMBER)}


class Parameter(ABC):
    """What a field of a part is."""

    may_be_drawn: ClassVar[bool] = False  # whether values may be drawn from a range
    # A value of each form, from which all names of coordinates follow.
    forms: ClassVar[tuple[Any, ...]] = ((1.0, 2.0), 1.0)

    si_unit: str  # in UDUNITS notation, ``1`` for plain numbers
    symbol: str  # in mathtext
    words: str  # what it is called in messages, tables and long names
    unit: Unit  # unit for people
    description: str  # a sentence for the JSON Schema and the documentation
    must_be_written: bool = False  # whether a file has to give it although it has a default
    in_line: bool = False

    @property
    def keys(self) -> Mapping[str, Parameter]:
        """The keys of a case that may be given in its place."""
        return {}

    @property
    def example(self) -> str:
        """An example value, as in a study file."""
        return ""

    @abstractmethod
    def read(self, value: object, units_required: bool) -> Any:
        """Return the value in SI units; raise `QuantityError` if it is invalid or out of range."""

    @abstractmethod
    def schema(self) -> dict[str, Any]:
        """JSON Schema of the value in a study file."""

    def described(self) -> dict[str, Any]:
        """Return the JSON Schema with a description of the parameter."""
        return {"description": self.description or f"{self.words.capitalize()}.", **self.schema()}

    def such_as(self, name: str) -> str:
        """An example for a name, "such as load: 50 N", or nothing."""
        return f"such as {name.rpartition('.')[2]}: {self.example}" if self.example else ""

    def suiting(self, value: Any) -> Parameter:  # noqa: ARG002 - whatever the value
        """Return the parameter in the form that suits a value; by default, itself."""
        return self

    def coordinates(self, name: str, value: Any) -> Iterator[tuple[str, Parameter, float | str]]:
        """Yield the scalar coordinates of a value: name, what it is, SI value."""
        yield name, self.suiting(value), value

    def canonical(self, value: Any) -> Any:
        """Return the value in a form that JSON can hold and `read` takes back."""
        return value

    def allows(self, value: float) -> bool:
        """Say whether a coordinate may have this value."""
        with suppress(QuantityError):
            self.read(value, False)
            return True
        return value == getattr(self, "absent", math.nan)

    def word_for(self, value: Any) -> str:
        """Return the word for a special value, such as "elastic"; empty for other values."""
        return value if isinstance(value, str) else ""

    def text(self, value: Any) -> str:
        """Return a value in readable units: ``25 N``, ``5.7°``, ``elastic``."""
        unit = self.suiting(value).unit
        return self.word_for(value) or with_unit(number_text(float(value) / unit.size), unit)


@dataclass(frozen=True)
class Plain(Parameter):
    """A parameter without a unit."""

    si_unit = "1"
    unit = NO_UNIT

    symbol: str
    words: str
    description: str = field(default="", kw_only=True)


@dataclass(frozen=True)
class Quantity(Parameter):
    """A physical quantity or a plain number, within a range."""

    may_be_drawn: ClassVar[bool] = True

    si_unit: str  # ``m``, ``N``, ``Pa``, ``Pa-1``, ``rad`` or ``1``
    symbol: str
    words: str
    shown_in: str = ""  # unit for people, as typed in study files (``um``); empty for plain numbers
    like: str = ""  # a sensible value; that of the kind of quantity where it is empty
    # Bounds in SI units.
    above: float | None = None
    at_least: float | None = None
    below: float | None = None
    at_most: float | None = None
    # Words for an infinite value, which study files call ``none``, and for zero.
    infinite: str = ""
    zero: str = ""
    # The coordinate of a case without this part; None: it has no such coordinate.
    absent: float | None = None
    in_line: bool = False  # whether this is a force that is one per length in a line contact
    description: str = field(default="", kw_only=True)
    must_be_written: bool = field(default=False, kw_only=True)

    @property
    def dimension(self) -> Dimension:
        """The kind of quantity, with an example of its own."""
        found = _BY_SI_UNIT[self.si_unit]
        return dataclasses.replace(found, example=self.like or found.example)

    @property
    def unit(self) -> Unit:  # type: ignore[override]
        units = {unit.typed or unit.name: unit for unit in self.dimension.units}
        return units[self.shown_in] if self.shown_in else NO_UNIT

    @property
    def example(self) -> str:
        return self.dimension.example

    def read(self, value: object, units_required: bool) -> Any:
        if self.infinite and (value == math.inf or means_none(value, units_required)):
            if value == math.inf and units_required:
                rule = f"{self.dimension.expectation}, or none"
                raise QuantityError(rule, "write none for no limit")
            return math.inf
        try:
            number = self._parsed(value, units_required)
        except QuantityError as error:
            rule = f"{error.rule}, or none" if self.infinite else error.rule
            raise QuantityError(rule, error.hint) from error
        if not all(holds(number, bound) for _, holds, _, bound in self._bounds):
            raise QuantityError(f"must be {self.range_text()}")
        if number > _LARGEST or (0.0 in (self.above, self.at_least) and 0.0 < number < _SMALLEST):
            raise QuantityError(f"must lie between {_SMALLEST:g} and {_LARGEST:g} in SI units")
        return number

    def _parsed(self, value: object, units_required: bool) -> float:
        if self.in_line and isinstance(value, PerLength | Force):
            return value
        if self.in_line and isinstance(value, str):
            with suppress(QuantityError):
                return PerLength(parse_quantity(value, FORCE_PER_LENGTH))
        number = parse_quantity(value, self.dimension, units_required=units_required)
        return Force(number) if self.in_line and isinstance(value, str) else number

    def suiting(self, value: Any) -> Quantity:
        """Return what it is in a line contact for a force per length."""
        if not (self.in_line and isinstance(value, PerLength)):
            return self
        words = f"{self.words} per length"
        return dataclasses.replace(
            self, si_unit="N m-1", shown_in="N/mm", like="18.5 N/mm", words=words
        )

    @property
    def _bounds(self) -> list[tuple[str, Callable[[float, float], bool], str, float]]:
        found = ((*each, getattr(self, name)) for name, each in _BOUNDS.items())
        return [each for each in found if each[-1] is not None]

    def range_text(self) -> str:
        """The range in words, such as "larger than -1 and at most 0.5"."""
        return " and ".join(
            f"{words} {format_quantity(bound, self.dimension) if bound else '0'}"
            for words, _, _, bound in self._bounds
        )

    def schema(self) -> dict[str, Any]:
        if self.dimension.is_plain_number:
            number = {"type": "number", **{keyword: each for _, _, keyword, each in self._bounds}}
            return {"anyOf": [number, _NUMBER_SCHEMA], "examples": [float(self.example)]}
        quantity = {**_QUANTITY_SCHEMA, "examples": [self.example]}
        return {"anyOf": [{"const": "none"}, quantity]} if self.infinite else quantity

    def canonical(self, value: Any) -> Any:
        """Return the SI number; infinity is the word ``none``."""
        return "none" if math.isinf(value) else value

    def word_for(self, value: Any) -> str:
        if not isinstance(value, str) and self.infinite and math.isinf(value):
            return self.infinite
        return self.zero if value == 0.0 else super().word_for(value)


@dataclass(frozen=True)
class _Pair(Quantity):
    """Two values of one quantity in a list; a single value is used for both."""

    may_be_drawn: ClassVar[bool] = False
    meaning: ClassVar[str]
    suffixes: ClassVar[tuple[tuple[str, str], ...]]

    def schema(self) -> dict[str, Any]:
        one = super().schema()
        return {"anyOf": [one, {"type": "array", "items": one, "minItems": 2, "maxItems": 2}]}

    def canonical(self, value: Any) -> Any:
        return list(pair(value))

    def coordinates(self, name: str, value: Any) -> Iterator[tuple[str, Parameter, float | str]]:
        for (suffix, words), each in zip(self.suffixes, value, strict=True):
            symbol = f"${self.symbol.strip('$')}_{suffix}$"
            about = dataclasses.replace(self, symbol=symbol, words=f"{self.words} {words}")
            yield f"{name}_{suffix}", about, each

    def read(self, value: object, units_required: bool) -> Any:
        """Return a float, or a pair of floats where two are given."""
        if not is_list(value):
            return super().read(value, units_required)
        if len(value) != 2:
            raise QuantityError(f"must be {self.meaning}, but is a list of {len(value)}")
        read = []
        for position, each in enumerate(value, start=1):
            try:
                read.append(super().read(each, units_required))
            except QuantityError as error:
                rule = f"has a value number {position}, {each!r}, that {error.rule}"
                raise QuantityError(rule, error.hint) from error
        return tuple(read)


@dataclass(frozen=True)
class PerBody(_Pair):
    """One value for both bodies, or a pair [body I, body II]."""

    meaning = "one value, or two for two bodies"
    suffixes = (("1", "of body I"), ("2", "of body II"))

    def coordinates(self, name: str, value: Any) -> Iterator[tuple[str, Parameter, float | str]]:
        """Yield one coordinate where both bodies are alike, else two."""
        first, second = both = pair(value)
        yield from [(name, self, first)] if first == second else super().coordinates(name, both)


@dataclass(frozen=True)
class AlongXY(_Pair):
    """A length along x and one along y; a single value is used for both."""

    meaning = "the spacing along x and along y"
    suffixes = (("x", "along x"), ("y", "along y"))

    def read(self, value: object, units_required: bool) -> Any:
        return pair(super().read(value, units_required))


@dataclass(frozen=True)
class WholeNumber(Plain):
    """A whole number within a range (bounds included)."""

    at_least: int
    at_most: int
    usual: int

    @property
    def example(self) -> str:
        return str(self.usual)

    def read(self, value: object, units_required: bool) -> int:
        """Return an int; ``1e4``, which YAML may read as text, is accepted."""
        number = math.nan
        with suppress(QuantityError):
            number = parse_quantity(value, NUMBER, units_required=units_required)
        if not number.is_integer():
            raise QuantityError(f"must be a whole number such as {self.example}")
        if not self.at_least <= number <= self.at_most:
            raise QuantityError(f"must be at least {self.at_least} and at most {self.at_most}")
        return int(number)

    def schema(self) -> dict[str, Any]:
        number = {"type": "integer", "minimum": self.at_least, "maximum": self.at_most}
        return {"anyOf": [number, _NUMBER_SCHEMA], "examples": [self.usual]}


@dataclass(frozen=True)
class Flag(Plain):
    """Yes or no: ``true`` or ``false``."""

    example = "false"  # what turns off what is on as a rule

    def read(self, value: object, units_required: bool) -> bool:
        """Return a bool; the number stored as a coordinate is accepted as well."""
        if value in (0, 1) and (isinstance(value, bool) or not units_required):
            return bool(value)
        raise QuantityError("must be true or false")

    def schema(self) -> dict[str, Any]:
        return {"type": "boolean"}

    def word_for(self, value: Any) -> str:
        return "yes" if value else "no"


@dataclass(frozen=True)
class Choice(Plain):
    """One of some words."""

    options: tuple[str, ...]

    @property
    def example(self) -> str:
        return self.options[0]

    def read(self, value: object, units_required: bool) -> str:  # noqa: ARG002 - a word has none
        if value in self.options:
            return str(value)
        raise QuantityError(f"must be {listed(self.options, 'or')}")

    def schema(self) -> dict[str, Any]:
        return {"enum": [*self.options]}


@dataclass(frozen=True)
class Patch(Plain):
    """A rectangle: corner x, y, width and height; None for the whole map."""

    _side: ClassVar[Quantity] = Quantity("m", "", "", "mm", like="0.5 mm", at_least=0.0)
    example = "[0 mm, 0 mm, 0.5 mm, 0.5 mm]"

    def read(self, value: object, units_required: bool) -> Any:
        """Return four lengths, or None."""
        if (value is None and not units_required) or value == "none":
            return None
        if not is_list(value) or len(value) != 4:
            raise QuantityError("must be [x, y, width, height]", f"such as {self.example}")
        lengths = tuple(self._side.read(each, units_required) for each in value)
        if 0.0 in lengths[2:]:
            raise QuantityError("must have a width and a height larger than 0")
        return lengths

    def canonical(self, value: Any) -> Any:
        return "none" if value is None else list(value)

    def coordinates(self, name: str, value: Any) -> Iterator[tuple[str, Parameter, float | str]]:
        """Yield one text, in m."""
        yield name, self, str(self.canonical(value))

    def schema(self) -> dict[str, Any]:
        four = {"type": "array", "items": self._side.schema(), "minItems": 4, "maxItems": 4}
        return {"anyOf": [{"const": "none"}, four]}


def pair(value: float | tuple[float, float]) -> tuple[float, float]:
    """Return two values, equal where one was given."""
    return value if isinstance(value, tuple) else (value, value)


def means_none(value: object, units_required: bool) -> bool:
    """Whether a value is the word ``none`` (or Python's None, outside of files)."""
    is_word = isinstance(value, str) and value.strip() == "none"
    return is_word or (value is None and not units_required)


def keys_schema(properties: Mapping[str, Any], needed: Sequence[str] = ()) -> dict[str, Any]:
    """Return the JSON Schema of a mapping that may have these keys and no others."""
    keys = {"type": "object", "additionalProperties": False, "properties": properties}
    return {**keys, "required": [*needed]} if needed else keys


def is_list(value: object) -> TypeGuard[Sequence[Any]]:
    """Whether a value is a list of values, not text."""
    return isinstance(value, Sequence) and not isinstance(value, str | bytes)


class Part:
    """A part of a case: a frozen dataclass whose fields are annotated by a `Parameter`.

    A class that derives from `Part` directly is a family, such as `Roughness`; the dataclasses
    that derive from a family are its kinds. Writing the class adds a kind.
    """

    kind: str = ""  # name in study files: ``{kind: wavy, ...}``
    # What a caption calls the kind where the name alone is unclear; empty: the name.
    told_as: ClassVar[str] = ""

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        Part.kinds.cache_clear()

    def __post_init__(self) -> None:
        """Read every field as its `Parameter` says, including text with units; check rules."""
        for name, parameter in self.parameters().items():
            value = getattr(self, name)
            try:
                object.__setattr__(self, name, parameter.read(value, False))
            except QuantityError as error:
                raise ValueError(f"{name} = {value!r} {error}") from error
        if self.problem is not None:
            raise QuantityError(*self.problem)

    @classmethod
    def unchecked(cls, **values: Any) -> Self:
        """Make a part from values that have been read; broken rules show in `problem`."""
        part = object.__new__(cls)
        defaults = {each.name: each.default for each in dataclasses.fields(cls)}  # type: ignore[arg-type]
        part.__dict__.update(defaults | values)
        return part

    @classmethod
    @cache
    def kinds(cls) -> Mapping[str, type[Self]]:
        """The kinds of a family by name, in the order in which they were defined."""
        found: dict[str, type[Self]] = {}
        for heir in cls.__subclasses__():
            # A class derived from a kind is the same kind unless it has its own name.
            found |= {heir.kind: heir} if heir.__dict__.get("kind") else {}
            found |= heir.kinds()
        return found

    @classmethod
    def parameters(cls) -> Mapping[str, Parameter]:
        """The parameters of a kind by name, without ``kind``."""
        return declared(cast("Any", cls))

    @property
    def problem(self) -> tuple[str, str] | None:
        """The rule between the part's own parameters that is broken, and a remedy."""
        return None

    def at(self, cycle: float) -> Self:  # noqa: ARG002 - constant unless a kind says otherwise
        """The part at a cycle; itself if nothing about it changes."""
        return self

    @property
    def kinks(self) -> tuple[float, ...]:
        """Cycles at which the part does not change smoothly."""
        return ()

    @property
    def is_trivial(self) -> bool:
        """Whether the part has no effect, such as a roughness without height."""
        return False

    @property
    def slug(self) -> str:
        """What stands for the part in the id of a case: letters, digits, ``.``, ``-`` and ``_``."""
        return self.kind

    def canonical(self) -> dict[str, Any]:
        """Return kind and parameters in a form that JSON can hold."""
        values = {n: p.canonical(getattr(self, n)) for n, p in self.parameters().items()}
        return {"kind": self.kind, **values}


@cache
def declared(cls: Any) -> Mapping[str, Parameter]:
    """Return the fields of a class that are annotated by a `Parameter`, bases first."""
    hints = get_type_hints(cls, include_extras=True)
    return {name: found for name, hint in hints.items() for found in _annotations(hint)}


@cache
def derived(cls: Any) -> Mapping[str, Parameter]:
    """Return the properties of a class whose return type is annotated by a `Parameter`."""
    properties = {
        name: get_type_hints(each.fget, include_extras=True).get("return")
        for base in reversed(cls.__mro__)
        for name, each in vars(base).items()
        if isinstance(each, property)
    }
    return {name: found for name, hint in properties.items() for found in _annotations(hint)}


def _annotations(hint: Any) -> Iterator[Any]:
    """Yield what annotates a type, described by the text beside it if there is one."""
    metadata = getattr(hint, "__metadata__", ())
    said = "".join(each for each in metadata if isinstance(each, str))
    for found in metadata:
        if isinstance(found, Parameter):
            yield dataclasses.replace(found, description=said) if said else found  # type: ignore[type-var]


def required(cls: type) -> frozenset[str]:
    """Return the fields of a dataclass without a default."""
    fields = dataclasses.fields(cls)
    return frozenset(
        f.name for f in fields if f.default is f.default_factory is dataclasses.MISSING
    )
