"""Parts of a case declare their parameters: how each is read, printed, stored and identified.

A part is a frozen dataclass that is parameter object and physics at once.  A `Parameter` annotates
each of its fields, and is the only place that names it::

    radius: Annotated[float, Quantity("m", "$R$", "sphere radius", "mm", above=0.0), "Its radius."]

A `Quantity` is one number; `fretwear.forms` has lists and mappings.  Study files, ``--set``, the
JSON Schema, messages, the case id, dataset coordinates and labels follow by walking the fields.
"""

from __future__ import annotations

import dataclasses
import json
import math
import operator
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache, cached_property, lru_cache
from types import MappingProxyType
from typing import Any, ClassVar, Self, TypeGuard, TypeVar, get_type_hints

from fretwear.problems import Problems, in_words
from fretwear.units import (
    BY_SI_UNIT,
    LINE_CONTACT,
    NO_UNIT,
    NUMBER,
    NUMBER_PATTERN,
    ContactFrame,
    Dimension,
    Given,
    Unit,
    format_quantity,
    listed,
    nearest,
    number_text,
    parse_quantity,
    with_unit,
)
from fretwear.units import QuantityError as QuantityError

_Read = TypeVar("_Read")
_Value = TypeVar("_Value")
Schema = dict[str, object]  # a JSON Schema
Coordinates = Iterator[tuple[str, "Parameter", float | str]]  # name, parameter, SI value

# No physical value lies beyond these; powers and quotients of values within them stay finite.
_SMALLEST, _LARGEST = 1e-30, 1e30

_WHOLE_SCHEMA = {"type": "string", "pattern": rf"^\s*[+-]?{NUMBER_PATTERN}\s*$"}
_WITH_COMMAS = re.compile(r"\s*\d{1,3}(,\d{3})+\s*")
_THOUSANDS = re.compile(r"\s*(\d+(?:\.\d{1,3})?)\s*[kK]\s*")
_NUMBER_SCHEMA = {"type": "string", "pattern": rf"^\s*[+-]?{NUMBER_PATTERN}\s*%?\s*$"}
_QUANTITY_SCHEMA = {"type": "string", "pattern": rf"^\s*[+]?{NUMBER_PATTERN}\s*[A-Za-zµμ°/].*$"}
# A bound of a quantity: its words, what it asks for, its keyword in a JSON Schema.
_BOUNDS = {
    "above": ("larger than", operator.gt, "exclusiveMinimum"),
    "at_least": ("at least", operator.ge, "minimum"),
    "below": ("less than", operator.lt, "exclusiveMaximum"),
    "at_most": ("at most", operator.le, "maximum"),
}


class Parameter(ABC):
    """The declaration of a field of a part."""

    si_unit: str  # in UDUNITS notation, ``1`` for plain numbers
    symbol: str  # in mathtext
    words: str  # its name in messages, tables and long names
    unit: Unit = NO_UNIT  # unit for people
    example: str = ""  # a value, as in a study file
    description: str = ""  # a sentence for the JSON Schema and the documentation
    may_be_drawn: bool = False  # whether values may be drawn from a range
    # The coordinate of a case without this part; None: the case has no such coordinate.
    absent: float | None = None
    unsaid: float | None = None  # the value that ids and coordinates leave out

    @property
    def keys(self) -> Mapping[str, Parameter]:
        """The keys of a case that may replace this parameter."""
        return {}

    def takes(self, value: object) -> bool:  # noqa: ARG002 - whatever the value
        """Whether a value, as written or as read, has the form that this parameter takes."""
        return True

    @abstractmethod
    def read(self, value: object, units_required: bool) -> object:
        """Return the value in SI units; raise `QuantityError` if it is invalid or out of range."""

    def read_given(self, name: str, value: object, units_required: bool) -> object:
        """Return the value of a key, as `read` does; a key of a study file must have one."""
        if value is None and units_required:
            remedy = self.such_as(name)
            with suppress(QuantityError):
                self.read("none", units_required)
                remedy = f"write {name}: none if that is meant"
            raise QuantityError("has no value", remedy)
        return self.read(value, units_required)

    @abstractmethod
    def schema(self) -> Schema:
        """JSON Schema of the value in a study file."""

    def described(self) -> Schema:
        """Return the JSON Schema with a description of the parameter."""
        return {"description": self.description or f"{self.words.capitalize()}.", **self.schema()}

    def such_as(self, name: str) -> str:
        """An example for a name, "such as load: 50 N"; empty without one."""
        return f"such as {name.rpartition('.')[2]}: {self.example}" if self.example else ""

    def called(self, words: str, symbol: str = "") -> Parameter:
        """Return the parameter with other words, and another symbol if one is given."""
        changes = {"words": words, "symbol": symbol or self.symbol}
        return dataclasses.replace(self, **changes)  # type: ignore[type-var]

    def in_frame(self, frame: ContactFrame) -> Parameter:  # noqa: ARG002 - alike, but for forces
        """Return the parameter as a point or a line contact has it."""
        return self

    def suiting(self, value: object) -> Parameter:
        """Return the parameter in the frame in which a value is given."""
        per_length = self.in_frame(LINE_CONTACT)
        is_per_length = isinstance(value, Given) and value.si_unit == per_length.si_unit
        return per_length if is_per_length else self

    def coordinates(self, name: str, value: Any) -> Coordinates:
        """Yield the scalar coordinates of a value: name, parameter, SI value."""
        if value is None or value != self.unsaid:
            yield name, self.suiting(value), value

    def canonical(self, value: Any) -> object:
        """Return the value in a form that JSON can hold and `read` takes back."""
        return value

    def allows(self, value: float) -> bool:
        """Say whether a coordinate may have this value."""
        with suppress(QuantityError):
            self.read(value, False)
            return True
        return value == self.absent

    def word_for(self, value: object) -> str:
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

    symbol: str
    words: str
    description: str = field(default="", kw_only=True)


@dataclass(frozen=True)
class Quantity(Parameter):
    """A physical quantity or a plain number, within a range."""

    may_be_drawn = True

    si_unit: str  # ``m``, ``N``, ``Pa``, ``Pa-1``, ``rad`` or ``1``
    symbol: str
    words: str
    shown_in: str = ""  # unit for people, as typed in study files (``um``); empty for plain numbers
    like: str = ""  # a sensible value; empty: the example of its dimension
    # Bounds in SI units.
    above: float | None = None
    at_least: float | None = None
    below: float | None = None
    at_most: float | None = None
    # Words for an infinite value, which study files call ``none``, and for zero.
    infinite: str = ""
    zero: str = ""
    absent: float | None = None
    unsaid: float | None = None
    description: str = field(default="", kw_only=True)

    @property
    def dimension(self) -> Dimension:
        """The kind of quantity, with an example of its own."""
        dimension = BY_SI_UNIT[self.si_unit]
        return dataclasses.replace(dimension, example=self.like or dimension.example)

    @property
    def unit(self) -> Unit:  # type: ignore[override]
        units = {unit.typed or unit.name: unit for unit in self.dimension.units}
        return units[self.shown_in] if self.shown_in else NO_UNIT

    @property
    def example(self) -> str:  # type: ignore[override]
        return self.dimension.example

    def read(self, value: object, units_required: bool) -> float:
        if self.infinite and (value == math.inf or means_none(value, units_required)):
            if value == math.inf and units_required:
                rule = f"{self.dimension.expectation}, or none"
                raise QuantityError(rule, "write none for no limit")
            return math.inf
        try:
            number = self._parsed(value, units_required)
        except QuantityError as error:
            rule, hint, expected = error.rule, error.hint, self.dimension.expectation
            if self.infinite:
                rule = rule.replace(expected, f"{expected} or none", 1)
                words = (self.infinite, "none", "no", "inf", "infinite", "infinity")
                hint = "write none for no limit" if str(value).casefold() in words else hint
            raise QuantityError(rule, hint) from error
        if not all(holds(number, bound) for _, holds, _, bound in self._bounds):
            is_percent = self.dimension.is_plain_number and number >= 1.0 and "%" not in str(value)
            share = 0.01 * number if is_percent else math.nan
            meant = all(holds(share, bound) for _, holds, _, bound in self._bounds)
            hint = f"did you mean '{number:g} %'?" if meant else ""
            if number < 0.0 and all(holds(-number, bound) for _, holds, _, bound in self._bounds):
                hint = f"did you mean '{str(value).strip(' -')}'?"
            raise QuantityError(f"must be {self.range_text()}", hint)
        if number > _LARGEST or (0.0 in (self.above, self.at_least) and 0.0 < number < _SMALLEST):
            raise QuantityError(f"must lie between {_SMALLEST:g} and {_LARGEST:g} in SI units")
        return number

    def _parsed(self, value: object, units_required: bool) -> float:
        is_zero = type(value) in (int, float) and value == 0  # nothing is nothing in any unit
        if is_zero and self.at_least == 0.0:
            return 0.0
        if is_zero and self.above == 0.0:
            raise QuantityError(f"must be {self.range_text()}")
        if value == "none" and self.at_least == 0.0 and not self.infinite:
            raise QuantityError(self.dimension.expectation, "write 0 for none")
        per_length = self.in_frame(LINE_CONTACT)
        if per_length is self:
            return parse_quantity(value, self.dimension, units_required=units_required)
        # A force tells by its unit which contact it loads, or by none.
        if isinstance(value, str):
            with suppress(QuantityError):
                number = parse_quantity(value, per_length.dimension)
                return Given(number, per_length.si_unit)
        number = parse_quantity(value, self.dimension, units_required=units_required)
        if isinstance(value, str):
            return Given(number, self.si_unit)
        return value if isinstance(value, Given) else number

    def in_frame(self, frame: ContactFrame) -> Quantity:
        """Return the parameter as a point or a line contact has it: a force may be per length."""
        if (unit := frame.unit(self.si_unit)) == self.si_unit:
            return self
        example = BY_SI_UNIT[unit].example
        return dataclasses.replace(
            self,
            si_unit=unit,
            words=frame.words(self.words, self.si_unit),
            shown_in=example.partition(" ")[2],
            like=example,
        )

    @property
    def _bounds(self) -> list[tuple[str, Callable[[float, float], bool], str, float]]:
        limits = ((*bound, vars(self)[name]) for name, bound in _BOUNDS.items())
        return [bound for bound in limits if bound[-1] is not None]

    def range_text(self) -> str:
        """The range in words, such as "larger than -1 and at most 0.5"."""
        return " and ".join(
            f"{words} {format_quantity(bound, self.dimension) if bound else '0'}"
            for words, _, _, bound in self._bounds
        )

    def schema(self) -> Schema:
        if self.dimension.is_plain_number:
            bounds = {keyword: limit for _, _, keyword, limit in self._bounds}
            number = {"type": "number", **bounds}
            kinds = [number, _NUMBER_SCHEMA, *([{"const": "none"}] if self.infinite else [])]
            return {"anyOf": kinds, "examples": [float(self.example)]}
        quantity: Schema = {**_QUANTITY_SCHEMA, "examples": [self.example]}
        if self.at_least == 0.0:
            return {"anyOf": [{"const": 0}, quantity]}
        return {"anyOf": [{"const": "none"}, quantity]} if self.infinite else quantity

    def canonical(self, value: float) -> object:
        """Return the SI number; infinity is the word ``none``."""
        return "none" if math.isinf(value) else value

    def word_for(self, value: object) -> str:
        if self.infinite and value == math.inf:
            return self.infinite
        return self.zero if value == 0.0 else super().word_for(value)


@dataclass(frozen=True)
class WholeNumber(Plain):
    """A whole number within a range (bounds included)."""

    at_least: int
    at_most: int
    usual: int

    @property
    def example(self) -> str:  # type: ignore[override]
        return str(self.usual)

    def read(self, value: object, units_required: bool) -> int:
        """Return an int; ``1e4``, which YAML may read as text, is accepted."""
        number, hint = math.nan, ""
        try:
            number = parse_quantity(value, NUMBER, units_required=units_required)
        except QuantityError as error:
            hint = error.hint
        if isinstance(value, str) and _WITH_COMMAS.fullmatch(value):
            hint = f"write {value.replace(',', '')}, without separators"
        if isinstance(value, str) and (thousands := _THOUSANDS.fullmatch(value)):
            hint = f"write {1000.0 * float(thousands[1]):.0f}"
        if not number.is_integer() or (isinstance(value, str) and "%" in value):
            raise QuantityError(f"must be a whole number such as {self.example}", hint)
        if not self.at_least <= number <= self.at_most:
            raise QuantityError(f"must be at least {self.at_least} and at most {self.at_most}")
        return int(number)

    def schema(self) -> Schema:
        number = {"type": "integer", "minimum": self.at_least, "maximum": self.at_most}
        return {"anyOf": [number, _WHOLE_SCHEMA], "examples": [self.usual]}


@dataclass(frozen=True)
class Flag(Plain):
    """Yes or no: ``true`` or ``false``."""

    example = "false"  # flags are true by default

    def read(self, value: object, units_required: bool) -> bool:
        """Return a bool; the number stored as a coordinate is accepted as well."""
        if value in (0, 1) and (isinstance(value, bool) or not units_required):
            return bool(value)
        meant = {"yes": "true", "on": "true", "no": "false", "off": "false", "none": "false"}
        hint = f"write {meant[value]}" if isinstance(value, str) and value in meant else ""
        raise QuantityError("must be true or false", hint)

    def schema(self) -> Schema:
        return {"type": "boolean"}

    def word_for(self, value: object) -> str:
        return "yes" if value else "no"


@dataclass(frozen=True)
class Choice(Plain):
    """One of some words."""

    options: tuple[str, ...]

    @property
    def example(self) -> str:  # type: ignore[override]
        return self.options[0]

    def read(self, value: object, units_required: bool) -> str:  # noqa: ARG002 - a word has none
        if value in self.options:
            return str(value)
        short = [option for option in self.options if in_words(value).casefold().startswith(option)]
        hint = f"did you mean {short[0]!r}?" if short else ""
        raise QuantityError(f"must be {listed(self.options, 'or')}", hint, self.options)

    def schema(self) -> Schema:
        return {"enum": [*self.options]}


def means_none(value: object, units_required: bool) -> bool:
    """Whether a value is the word ``none`` (or Python's None, outside of files)."""
    is_word = isinstance(value, str) and value.strip() == "none"
    return is_word or (value is None and not units_required)


def is_list(value: object) -> TypeGuard[Sequence[object]]:
    """Whether a value is a list of values, not text."""
    return isinstance(value, Sequence) and not isinstance(value, str | bytes)


def keys_schema(properties: Mapping[str, object], needed: Sequence[str] = ()) -> Schema:
    """Return the JSON Schema of a mapping that may have these keys and no others."""
    keys = {"type": "object", "additionalProperties": False, "properties": properties}
    return {**keys, "required": [*needed]} if needed else keys


def read_fields(
    raw: Mapping[str, object],
    fields: Mapping[str, Parameter],
    needed: Collection[str],
    units_required: bool,
    rule: str = "is not known",
) -> dict[str, Any]:
    """Read the values of a mapping by name; one `QuantityError` lists all problems.

    `rule` is the message for unknown names.
    """
    problems, values = Problems(), dict[str, object]()
    unknown = [name for name in raw if name not in fields]
    missing = [name for name in fields if name in needed and name not in raw]
    # A key that is not known and one that is missing are one mistake.
    for name in unknown[:]:
        if meant := nearest(name, missing) or (missing[0] if len(unknown) == len(missing) else ""):
            problems.add(f".{name}", raw[name], rule, f"write {meant} for it")
            missing.remove(meant)
            unknown.remove(name)
    if unknown and missing:
        such = ", ".join(filter(None, (f"{n}: {fields[n].example}".rstrip(": ") for n in missing)))
        lacking = f"{listed(missing)} {'are' if missing[1:] else 'is'} missing, such as {such}"
        problems.add(f".{unknown[0]}", raw[unknown.pop(0)], rule, lacking)
        missing.clear()
    for name, form in fields.items():
        with problems.at(f".{name}", raw.get(name)):
            if name in raw:
                values[name] = form.read_given(name, raw[name], units_required)
            elif name in missing:
                raise QuantityError("is missing", form.such_as(name))
    problems.unknown("", {name: raw[name] for name in unknown}, [*fields], rule)
    problems.raise_any()
    return values


class Part:
    """A part of a case: a frozen dataclass whose fields are annotated by a `Parameter`.

    A class that derives from `Part` directly is a family, such as `Roughness`; the dataclasses
    that derive from a family are its kinds. Writing the class adds a kind.
    """

    kind: str = ""  # name in study files: ``{kind: wavy, ...}``
    # The name of the kind in a caption, where `kind` alone is unclear; empty: `kind`.
    caption: ClassVar[str] = ""

    def __init_subclass__(cls, **options: object) -> None:
        super().__init_subclass__(**options)
        Part.kinds.cache_clear()

    def __post_init__(self) -> None:
        """Read every field by its `Parameter`, text with units included, and check the rules."""
        problems, fields = Problems(), vars(self)
        for name, parameter in self.parameters().items():
            with problems.at(name, fields[name]):
                fields[name] = parameter.read(fields[name], False)
        if problems:
            raise ValueError("\n".join(problem.sentence for problem in problems))
        if self.problem is not None:
            raise QuantityError(*self.problem)

    @classmethod
    def unchecked(cls, **values: object) -> Self:
        """Make a part of values already read; a broken rule shows in `problem`."""
        part = object.__new__(cls)
        # Values that another part has derived from its fields do not count.
        fields = _defaults(cls).items()
        part.__dict__.update({name: values.get(name, default) for name, default in fields})
        return part

    @classmethod
    @cache
    def kinds(cls) -> Mapping[str, type[Self]]:
        """The kinds of a family by name, in the order in which they were defined."""
        kinds: dict[str, type[Self]] = {}
        for heir in cls.__subclasses__():
            # A class derived from a kind is the same kind unless it names its own.
            kinds |= {heir.kind: heir} if heir.__dict__.get("kind") else {}
            kinds |= heir.kinds()
        return kinds

    @classmethod
    def parameters(cls) -> Mapping[str, Parameter]:
        """The parameters of a kind by name, without ``kind``."""
        return declared(cls)

    @classmethod
    def such(
        cls, names: Collection[str], given: Mapping[str, object] = MappingProxyType({})
    ) -> str:
        """A mapping of this kind with some parameters, as in a study file: given, or examples."""
        examples = {name: about.example for name, about in cls.parameters().items()}
        fields = (f", {n}: {in_words(given.get(n, examples[n]))}" for n in examples if n in names)
        return f"{{kind: {cls.kind}{''.join(fields)}}}"

    @property
    def problem(self) -> tuple[str, str] | None:
        """The broken rule between the part's parameters, with a remedy; None if all hold."""
        return None

    def at(self, cycle: float) -> Self:  # noqa: ARG002 - constant unless a kind says otherwise
        """The part at a cycle; the same object if nothing about it changes."""
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
        """The part in the id of a case: letters, digits, ``.``, ``-`` and ``_``."""
        return self.kind

    def canonical(self) -> dict[str, object]:
        """Return kind and parameters in a form that JSON can hold."""
        values = ((name, about, vars(self)[name]) for name, about in self.parameters().items())
        said = {n: about.canonical(v) for n, about, v in values if v is None or v != about.unsaid}
        return {"kind": self.kind, **said}

    @cached_property
    def entries(self) -> Mapping[str, str]:
        """The parameters as entries of a JSON object, by name, in the ids of cases."""
        values = self.canonical().items()
        return {name: entry_text(name, value) for name, value in values if name != "kind"}

    @property
    def under_key(self) -> object:
        """What stands under the key of a part: a mapping, or the name of a kind without fields."""
        content = self.canonical()
        return content if len(content) > 1 else content["kind"]

    @cached_property
    def text_under_key(self) -> str:
        """The same as JSON, in the ids of cases."""
        return _text(self.under_key)


_MOST_TEXTS = 4096
_LISTS = list, tuple  # a union of types would be made anew for every value


def entry_text(name: str, value: object) -> str:
    """Return an entry of a JSON object, in which twelve digits of a number count.

    >>> entry_text("cell", [2 / 3])
    '"cell":[0.666666666667]'
    """
    return f"{_scalar_text(name)}:{_text(value)}"


def _text(value: object) -> str:
    if isinstance(value, float):
        number = float(f"{value:.11e}")
        return repr(number) if math.isfinite(number) else _scalar_text(number)
    if isinstance(value, _LISTS):
        return f"[{','.join(map(_text, value))}]"
    if isinstance(value, dict):
        return f"{{{','.join(entry_text(name, value[name]) for name in sorted(value))}}}"
    return _scalar_text(value)


@lru_cache(_MOST_TEXTS, typed=True)
def _scalar_text(value: float | str | None) -> str:
    return json.dumps(value)


def _read_once(function: Callable[[type], _Read]) -> Callable[[type], _Read]:
    return cache(function)


@_read_once
def _defaults(cls: type) -> dict[str, object]:
    fields = dataclasses.fields(cls)
    return {declared_field.name: declared_field.default for declared_field in fields}


@_read_once
def declared(cls: type) -> Mapping[str, Parameter]:
    """Return the fields of a class that are annotated by a `Parameter`, bases first."""
    hints = get_type_hints(cls, include_extras=True)
    return {name: about for name, hint in hints.items() for about in _annotations(hint)}


@_read_once
def derived(cls: type) -> Mapping[str, Parameter]:
    """Return the properties of a class whose return type is annotated by a `Parameter`."""
    hints = {
        name: get_type_hints(member.fget, include_extras=True).get("return")
        for base in reversed(cls.__mro__)
        for name, member in vars(base).items()
        if isinstance(member, property)
    }
    return {name: about for name, hint in hints.items() for about in _annotations(hint)}


def _annotations(hint: object) -> Iterator[Parameter]:
    """Yield the parameters that annotate a type, described by the text beside them if any."""
    metadata = getattr(hint, "__metadata__", ())
    description = "".join(note for note in metadata if isinstance(note, str))
    changes = {"description": description} if description else {}
    for note in metadata:
        if isinstance(note, Parameter):
            yield dataclasses.replace(note, **changes)  # type: ignore[type-var]


@_read_once
def required(cls: type) -> frozenset[str]:
    """Return the fields of a dataclass without a default."""
    fields = dataclasses.fields(cls)
    return frozenset(
        f.name for f in fields if f.default is f.default_factory is dataclasses.MISSING
    )
