"""Annotated fields of parts: each annotation tells how a field is read, printed and stored.

A part of a case is a frozen pydantic dataclass: parameter object and physics at once. Each of its
fields is annotated by a `Parameter`, and only there::

    radius: Annotated[float, Quantity("m", "$R$", "sphere radius", "mm", gt=0.0), "Its radius."]

pydantic validates the fields. Its context is the folder of a study file, in which numbers need
units, or None elsewhere, where they are in SI units. JSON Schema, case ids, coordinates of datasets
and labels follow from the fields.
"""

from __future__ import annotations

import dataclasses
import json
import math
import operator
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache, cached_property
from pathlib import Path
from typing import (
    Annotated,
    Any,
    ClassVar,
    Self,
    TypeGuard,
    TypeVar,
    cast,
    get_args,
    get_type_hints,
)

from pydantic import (
    BeforeValidator,
    ConfigDict,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    PlainValidator,
    TypeAdapter,
    WithJsonSchema,
)
from pydantic.fields import FieldInfo
from pydantic_core import InitErrorDetails, ValidationError, core_schema

from fretwear.units import (
    BY_SI_UNIT,
    LINE_CONTACT,
    NO_UNIT,
    NUMBER_PATTERN,
    ContactFrame,
    Dimension,
    FloatWithUnit,
    QuantityError,
    Unit,
    did_you_mean,
    format_quantity,
    number_text,
    parse_quantity,
    with_unit,
)

_Function = TypeVar("_Function", bound=Callable[..., object])
Value = TypeVar("Value")
Schema = dict[str, Any]  # a JSON Schema
Coordinates = Iterator[tuple[str, Any]]  # names and SI values
Endings = tuple[tuple[str, str], ...]  # suffixes of names of coordinates, and of their words

MATERIALS: Endings = (("1", "of body I"), ("2", "of body II"))
AXES: Endings = (("x", "along x"), ("y", "along y"))
BODIES: Endings = (("indenter", "of the indenter"), ("flat", "of the flat"))

LONGEST = 10.0
"""Longest length, m, that a parameter may have; a path of sliding may be longer."""
# No physical value lies beyond these; powers and quotients of values within them stay finite.
_SMALLEST, _LARGEST = 1e-30, 1e30
# A bound of a quantity: its words, its test, its keyword in a JSON Schema.
_BOUNDS: dict[str, tuple[str, Callable[[float, float], bool], str]] = {
    "gt": ("larger than", operator.gt, "exclusiveMinimum"),
    "ge": ("at least", operator.ge, "minimum"),
    "lt": ("less than", operator.lt, "exclusiveMaximum"),
    "le": ("at most", operator.le, "maximum"),
}
_NUMBER_SCHEMA = {"type": "string", "pattern": rf"^\s*[+-]?{NUMBER_PATTERN}\s*%?\s*$"}
_QUANTITY_SCHEMA = {"type": "string", "pattern": rf"^\s*[+]?{NUMBER_PATTERN}\s*[A-Za-zµμ°/].*$"}
# Context of a part with values already read, which may break a rule.
_AS_READ = object()


def _remembered(function: _Function) -> _Function:
    """Keep the results of a function of a class."""
    return cast("_Function", cache(function))


class Parameter:
    """The description of a field of a part: words, symbol and unit."""

    si_unit: str = "1"  # in UDUNITS notation, ``1`` for plain numbers
    symbol: str = ""  # in mathtext
    words: str = ""  # its name in messages, tables and long names
    like: str = ""  # a value, as in a study file
    description: str = ""  # a sentence for the JSON Schema and the documentation
    unit: Unit = NO_UNIT  # unit for people
    absent: float | None = None  # value of the coordinate in a case without this part
    omitted_value: float | None = None  # value that is left out of the coordinates

    @property
    def example(self) -> str:
        """A value, as in a study file."""
        return self.like

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> Schema:
        return {**(self._schema or handler(schema)), **self.described}

    @property
    def _schema(self) -> Schema:
        return {}  # as pydantic describes the type

    @property
    def described(self) -> Schema:
        """The description of a JSON Schema."""
        return {"description": self.description or f"{self.words.capitalize()}."}

    def renamed(self, words: str) -> Self:
        """Return the parameter with other words."""
        return dataclasses.replace(self, words=words)  # type: ignore[type-var]

    def in_frame(self, frame: ContactFrame) -> Parameter:
        """Return the parameter as a point or a line contact has it."""
        return self

    def in_frame_of(self, value: object) -> Parameter:
        """Return the parameter in the frame in which a value is given."""
        per_length = self.in_frame(LINE_CONTACT)
        is_per_length = isinstance(value, FloatWithUnit) and value.si_unit == per_length.si_unit
        return per_length if is_per_length else self

    def coordinates(self, name: str, value: Any) -> Coordinates:
        """Yield the scalar coordinates of a value: name, SI value."""
        if self.omitted_value is None or value != self.omitted_value:
            yield name, value if isinstance(value, float | int) else str(value)

    def canonical(self, value: Any) -> object:
        """Return the value in a form that JSON can hold and a case takes back."""
        return value

    def word_for(self, value: object) -> str:
        """Return the word for a special value, such as "elastic"; empty for other values."""
        return value if isinstance(value, str) else ""

    def text(self, value: Any) -> str:
        """Return a value in readable units: ``25 N``, ``5.7°``, ``elastic``."""
        return self.word_for(value) or str(value)


@dataclass(frozen=True)
class Plain(Parameter):
    """A parameter without a unit, which pydantic reads by its type."""

    symbol: str
    words: str
    like: str = ""
    description: str = field(default="", kw_only=True)

    def text(self, value: Any) -> str:
        """Return a value as in a study file, true or false if datasets have it as a number."""
        return value if isinstance(value, str) else str(bool(value)).lower()


class Readable(Parameter):
    """A parameter that reads its values, given the folder of the study file or None elsewhere."""

    def read(self, value: object, folder: Any = None) -> Any:
        """Return the value, or raise a `QuantityError`."""
        raise NotImplementedError

    def __get_pydantic_core_schema__(
        self, source: object, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        is_optional = type(None) in get_args(source)

        def validated(value: object, info: core_schema.ValidationInfo[object]) -> object:
            is_read = info.context is _AS_READ or (value is None and is_optional)
            return value if is_read else self.read(value, info.context)

        return core_schema.with_info_plain_validator_function(validated)


@dataclass(frozen=True)
class Quantity(Readable):
    """A physical quantity or a plain number within a range, with bounds in SI units.

    With `places` it may be a list of values, and with `forms` a mapping: a dataclass of these.
    """

    si_unit: str  # ``m``, ``N``, ``Pa``, ``Pa-1``, ``rad`` or ``1``
    symbol: str
    words: str
    shown_in: str = ""  # unit for people, as typed in study files (``um``); empty: plain numbers
    like: str = ""  # a sensible value; empty: the example of its dimension
    gt: float | None = None
    ge: float | None = None
    lt: float | None = None
    le: float | None = None
    infinite: str = ""  # the word for an infinite value, which study files call ``none``
    zero: str = ""  # the word for zero
    absent: float | None = None  # value of the coordinate in a case without its part
    omitted_value: float | None = None  # left out of coordinates
    places: Endings = ()
    record: type[tuple[object, ...]] = tuple  # the type of a list of values
    forms: tuple[type, ...] = ()
    is_whole: bool = False
    description: str = field(default="", kw_only=True)

    def __post_init__(self) -> None:
        """Check the unit."""
        if self.si_unit not in BY_SI_UNIT:
            known = ", ".join(BY_SI_UNIT)
            raise ValueError(f"{self.words}: {self.si_unit!r} is not among the SI units {known}.")

    @cached_property
    def dimension(self) -> Dimension:
        """The kind of quantity, with an example of its own."""
        dimension = BY_SI_UNIT[self.si_unit]
        return dataclasses.replace(dimension, example=self.like or dimension.example)

    @cached_property
    def unit(self) -> Unit:  # type: ignore[override]
        """Unit for people."""
        units = {unit.typed or unit.name: unit for unit in self.dimension.units}
        return units[self.shown_in] if self.shown_in else NO_UNIT

    @property
    def example(self) -> str:
        """A value, as in a study file."""
        return self.dimension.example

    def read(self, value: object, folder: object = None) -> Any:
        """Return a value in SI units; numbers need their unit if there is a `folder`."""
        if self.record is not tuple and isinstance(value, self.record):
            return value
        if self.forms and isinstance(value, (Mapping, *self.forms)):
            return self._read_form(value, folder)
        of_places = ", ".join(words.removeprefix("of ") for _, words in self.places)
        if of_places and isinstance(value, Mapping):
            raise QuantityError(self.dimension.expectation, f"two values are a list: [{of_places}]")
        if of_places and is_list(value):
            if len(value) != len(self.places):
                rule = f"must be one value, or {len(self.places)}: [{of_places}]"
                raise QuantityError(f"{rule}, but is a list of {len(value)}")
            item = self._item
            return self.record(each(value, lambda one: item.read(one, folder)))
        number = self._read_number(value, folder is not None)
        return (number, number) if self.places is AXES else number

    @property
    def single(self) -> Quantity:
        """The quantity of a single value."""
        return dataclasses.replace(self, places=(), record=tuple, forms=())

    @cached_property
    def _item(self) -> Quantity:
        """One of several values; one of two bodies may have no wear at all."""
        changes: dict[str, Any] = {"gt": None, "ge": 0.0} if self.places is BODIES else {}
        forms = tuple(form for form in self.forms if getattr(form, "may_be_of_one_body", False))
        return dataclasses.replace(self, places=(), record=tuple, forms=forms, **changes)

    def _read_form(self, value: object, folder: object) -> object:
        forms = self.forms
        if isinstance(value, Mapping):
            keys = value.keys()
            form = max(forms, key=lambda one: len(field_names(one) & keys))
            value = adapter(form).validate_python(value, context=folder)
        read_by = getattr(value, "read_by", None)  # of a table of values
        return value if read_by is None else read_by(self._item, folder)

    def _read_number(self, value: object, units_required: bool) -> float:
        none = self.infinite and (means_none(value) or (value is None and not units_required))
        if none or (self.infinite and value == math.inf and not units_required):
            return math.inf
        if self.is_whole:
            number, hint = math.nan, ""
            try:
                number = parse_quantity(value, self.dimension)
            except QuantityError as error:
                hint = error.hint
            if not number.is_integer():
                raise QuantityError(f"must be a whole number such as {self.example}", hint)
            number = int(number)
        else:
            number = self._parsed(value, units_required)
        if not all(holds(number, bound) for _, holds, _, bound in self._bounds):
            most = self.le if self.si_unit == "1" and self.le is not None else math.inf
            is_percent = most <= 10.0 and 1.0 <= number <= 100.0 * min(most, 1.0)
            hint = f"did you mean '{number:g} %'?" if is_percent else ""
            raise QuantityError(f"must be {self.range_text()}", hint)
        if self.si_unit == "m" and abs(number) > LONGEST and self.words != "sliding distance":
            raise QuantityError(f"must be at most {LONGEST:g} m")
        if number > _LARGEST or (0.0 in (self.gt, self.ge) and 0.0 < number < _SMALLEST):
            raise QuantityError(f"must lie between {_SMALLEST:g} and {_LARGEST:g} in SI units")
        return number

    def _parsed(self, value: object, units_required: bool) -> float:
        if type(value) in (int, float) and value == 0 and 0.0 in (self.gt, self.ge):
            return 0.0  # zero needs no unit
        if isinstance(value, FloatWithUnit):
            return value
        lines = self.in_frame(LINE_CONTACT)
        if lines is self or not isinstance(value, str):
            return parse_quantity(value, self.dimension, units_required=units_required)
        # The unit of a force tells its kind of contact; other units do not.
        try:
            return FloatWithUnit(parse_quantity(value, self.dimension), self.si_unit)
        except QuantityError:
            with suppress(QuantityError):
                return FloatWithUnit(parse_quantity(value, lines.dimension), lines.si_unit)
            raise

    def in_frame(self, frame: ContactFrame) -> Quantity:
        """Return the parameter as a point or a line contact has it: a force may be per length."""
        if (unit := frame.unit(self.si_unit)) == self.si_unit or self.si_unit not in ("N", "J"):
            return self
        example = BY_SI_UNIT[unit].example
        return dataclasses.replace(
            self,
            si_unit=unit,
            words=frame.words(self.words, self.si_unit),
            shown_in=example.partition(" ")[2],
            like=example,
        )

    @cached_property
    def _bounds(self) -> list[tuple[str, Callable[[float, float], bool], str, float]]:
        limits = ((*bound, getattr(self, name)) for name, bound in _BOUNDS.items())
        return [bound for bound in limits if bound[-1] is not None]

    def range_text(self) -> str:
        """The range in words, such as "larger than -1 and at most 0.5"."""
        return " and ".join(
            f"{words} {format_quantity(bound, self.dimension) if bound else '0'}"
            for words, _, _, bound in self._bounds
        )

    def coordinates(self, name: str, value: Any) -> Coordinates:
        """Yield the scalar coordinates of a value; of a pair, one for each place."""
        if self.places is MATERIALS:
            first, second = pair(value)
            value = first if first == second else (first, second)
        if isinstance(value, tuple):
            if self.record is not tuple:
                yield name, float(value)  # type: ignore[arg-type]
            for (end, _), item in zip(self.places, value, strict=True):
                yield from self._item.coordinates(f"{name}_{end}", item)
        elif hasattr(value, "coordinates"):
            yield name, float(value)
            yield from value.coordinates(name)
        elif value is None or value != self.omitted_value:
            yield name, value

    def canonical(self, value: object) -> object:
        """Return the SI numbers in a form that JSON can hold; infinity is the word ``none``."""
        if self.places in (MATERIALS, AXES) and value is not None:
            value = pair(value)
        if isinstance(value, tuple):
            return [self._item.canonical(item) for item in value]
        if hasattr(value, "canonical"):
            return {n: one for n, one in value.canonical().items() if n != "kind"}
        return "none" if isinstance(value, float) and math.isinf(value) else value

    def word_for(self, value: object) -> str:
        """Return the word for a special value, such as "elastic"; empty for other values."""
        if self.infinite and value == math.inf:
            return self.infinite
        return self.zero if value == 0.0 else super().word_for(value)

    def text(self, value: object) -> str:
        """Return a value in readable units: ``25 N``, ``5.7°``, ``elastic``."""
        if not isinstance(value, float | int | str):
            return str(value)
        unit = self.in_frame_of(value).unit
        return self.word_for(value) or with_unit(number_text(float(value) / unit.size), unit)

    @property
    def _schema(self) -> Schema:
        single: list[Schema] = [{**_QUANTITY_SCHEMA, "examples": [self.example]}]
        if self.dimension.is_plain_number:
            bounds = {keyword: limit for _, _, keyword, limit in self._bounds}
            single = [{"type": "integer" if self.is_whole else "number", **bounds}, _NUMBER_SCHEMA]
        elif self.ge == 0.0:
            single.append({"const": 0})
        single += [{"const": "none"}] if self.infinite else []
        if self.places:
            ends = {"minItems": len(self.places), "maxItems": len(self.places)}
            single.append({"type": "array", "items": self._item._schema, **ends})
        single += [inlined(adapter(form).json_schema()) for form in self.forms]
        return {"anyOf": single}


def whole_number(symbol: str, words: str, ge: int, le: int, usual: int) -> Quantity:
    """A whole number within a range, bounds included; ``1e4``, which YAML reads as text, counts."""
    return Quantity("1", symbol, words, like=str(usual), ge=ge, le=le, is_whole=True)


AUTO = BeforeValidator(lambda value: None if value == "auto" else value)
"""Reads an optional value, which study files call ``auto`` where it is None."""


def auto_or(schema: Schema) -> WithJsonSchema:
    """Describe a value that may be ``auto``, its default."""
    return WithJsonSchema({"anyOf": [{"const": "auto"}, schema]})


@dataclass(frozen=True)
class MappingOf:
    """Annotates a mapping with these keys and no others: their types by name."""

    types: Mapping[str, object]

    def __get_pydantic_core_schema__(
        self, source: object, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        fields = {
            name: core_schema.typed_dict_field(handler.generate_schema(type_), required=False)
            for name, type_ in self.types.items()
        }
        return core_schema.typed_dict_schema(fields, extra_behavior="forbid")


@dataclass(frozen=True)
class PartOf(Parameter):
    """A part under its own key: a mapping ``{kind: ..., ...}``, or the name of a kind."""

    family: type[Part]
    words: str = ""
    short: str = ""  # the kind whose fields may be given as keys of the case instead
    none: str = ""  # the word for a case without the part, such as "smooth"
    like: str = ""
    is_second: bool = False  # second part of its family, whose name its parameters bear
    description: str = field(default="", kw_only=True)

    def __get_pydantic_core_schema__(
        self, source: object, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        return core_schema.no_info_before_validator_function(
            lambda value: None if self.none and means_none(value) else value, handler(source)
        )

    @property
    def _schema(self) -> Schema:
        kinds = self.family.kinds()
        choices: list[Schema] = [{"const": "none"}] if self.none else []
        if bare := [name for name, kind in kinds.items() if not required(kind)]:
            choices.append({"enum": bare})
        for kind in kinds.values():
            # Varied fields may be missing.
            whole = inlined(adapter(kind).json_schema())
            choices.append({key: item for key, item in whole.items() if key != "required"})
        return {"anyOf": choices}

    def named(self, parameters: Mapping[str, Parameter]) -> dict[str, Parameter]:
        """Parameters of a kind by name; for the second part of a family, words and names say so."""
        if not self.is_second:
            return dict(parameters)
        words = f"of the {self.words}"
        return {n: key.renamed(f"{key.words} {words}") for n, key in parameters.items()}

    def canonical(self, value: Any) -> object:
        """Return the mapping, or the name of a kind without fields; None without a part."""
        content = None if value is None else value.canonical()
        return content["kind"] if content and len(content) == 1 else content

    def coordinates(self, name: str, value: Part | None) -> Coordinates:
        """Yield the coordinates of the fields; zero without a part."""
        kind = next(iter(self.family.kinds().values())) if value is None else type(value)
        parameters = kind.parameters()
        if value is not None:
            if not parameters:
                yield name, value.kind
            for part_field, parameter in derived(kind).items():
                yield from parameter.coordinates(f"{name}_{part_field}", getattr(value, part_field))
        for part_field, parameter in parameters.items():
            number = parameter.absent if value is None else vars(value)[part_field]
            if number is not None:
                key = part_field if kind.kind == self.short else f"{name}_{part_field}"
                yield from parameter.coordinates(key, number)

    def word_for(self, value: object) -> str:
        """Return the word for no part, or for a kind without fields."""
        if value == "none":
            return self.none
        kinds = self.family.kinds()
        if isinstance(value, str) and value in kinds:
            return kinds[value].caption or value
        return str(value)


class Inline(PartOf):
    """A part whose fields are keys of the case; the given keys decide its kind."""

    @property
    def keys(self) -> dict[str, Parameter]:
        """The parameters of all kinds by name."""
        kinds = self.family.kinds().values()
        return {name: parameter for kind in kinds for name, parameter in kind.parameters().items()}

    @property
    def leading(self) -> dict[str, type[Part]]:
        """The kinds by their leading key, the first required one that not all kinds have."""
        kinds = self.family.kinds().values()
        common = set.intersection(*({*kind.parameters()} for kind in kinds))
        leading: dict[str, type[Part]] = {}
        for kind in kinds:
            keys = [n for n in kind.parameters() if n in required(kind) and n not in common]
            leading |= {name: kind for name in keys[:1] if name not in leading}
        return leading

    def kind_of(self, keys: Collection[str], kinds: Sequence[type[Part]] = ()) -> type[Part] | None:
        """Return the first kind that has all of the keys and requires no others."""
        for kind in kinds or self.family.kinds().values():
            if required(kind) <= {*keys} <= kind.parameters().keys():
                return kind
        return None

    def changed(self, part: Part, values: Mapping[str, object]) -> Part | None:
        """Return the part with other values of some fields, of another kind if these need it."""
        for kind in (type(part), *self.family.kinds().values()):
            common = kind.parameters().keys() & vars(part).keys()
            fields = {**{name: vars(part)[name] for name in common}, **values}
            if self.kind_of(fields, [kind]):
                return kind.unchecked(**fields)
        return None


class Part:
    """A part of a case: a frozen pydantic dataclass whose fields are annotated by a `Parameter`.

    A class that derives from `Part` directly is a family, such as `Roughness`; the dataclasses
    that derive from a family are its kinds. Writing the class adds a kind.
    """

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="forbid")

    kind: str = ""  # name in study files: ``{kind: wavy, ...}``
    caption: ClassVar[str] = ""  # name in a caption, where `kind` alone is unclear
    synonyms: ClassVar[tuple[str, ...]] = ()  # words for the kind elsewhere, known to messages

    def __init_subclass__(cls, **options: object) -> None:
        super().__init_subclass__(**options)
        Part.kinds.cache_clear()

    def checked(self) -> Self:
        """The part as it is read; `QuantityError` if it breaks a rule between its fields."""
        if self.mistake is not None:
            raise QuantityError(*self.mistake)
        return self

    @classmethod
    def __get_pydantic_core_schema__(
        cls, source: object, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        def checked(
            value: object,
            read: core_schema.ValidatorFunctionWrapHandler,
            info: core_schema.ValidationInfo[object],
        ) -> Part:
            part: Part = read(value)
            return part if part is value or info.context is _AS_READ else part.checked()

        if dataclasses.is_dataclass(cls):
            return core_schema.with_info_wrap_validator_function(checked, handler(source))

        def kind_of(value: object, info: core_schema.ValidationInfo[object]) -> object:
            return value if info.context is _AS_READ else cls.read(value, info.context)

        return core_schema.with_info_plain_validator_function(kind_of)

    @classmethod
    def read(cls, value: object, folder: object = None) -> Self:
        """Return a part of the kind that a mapping names, or of the usual one."""
        if isinstance(value, cls):
            return value
        kinds = cls.kinds()
        if isinstance(value, str) and value in kinds:
            value = {"kind": value}
        if not isinstance(value, Mapping):
            rule = f"must be one of {', '.join(kinds)}"
            is_file = Path(str(value)).suffix[1:2].isalpha()
            of_file = (
                f"write {{kind: {n}, file: {value}}}" for n in kinds if "file" in required(kinds[n])
            )
            usual = next((f"write {{kind: {n}, …}}" for n in kinds if required(kinds[n])), "")
            hint = next(of_file, usual) if is_file else usual
            raise QuantityError(rule, did_you_mean(value, kinds) or hint)
        name = value.get("kind", next(iter(kinds)))
        if name not in [*kinds]:
            rule = f"must be one of {', '.join(kinds)}"
            meant = [n for n, kind in kinds.items() if str(name).lower() in kind.synonyms]
            hint = f"did you mean {meant[0]!r}?" if meant else did_you_mean(name, kinds)
            raise located("kind", name, QuantityError(rule, hint))
        content = {**value, "kind": name}
        part: Self = adapter(kinds[name]).validate_python(content, context=folder)
        return part

    @classmethod
    def unchecked(cls, **values: object) -> Self:
        """Make a part of values already read; a broken rule shows in `mistake`."""
        # Values derived from the fields by another part do not count.
        fields = {name: value for name, value in values.items() if name in field_names(cls)}
        part: Self = adapter(cls).validate_python(fields, context=_AS_READ)
        return part

    @classmethod
    @cache
    def kinds(cls) -> Mapping[str, type[Self]]:
        """The kinds of a family by name, in the order in which they were defined."""
        # A class derived from a kind is the same kind unless it names its own.
        kinds = {cls.kind: cls} if cls.__dict__.get("kind") else {}
        for heir in cls.__subclasses__():
            kinds |= heir.kinds()
        return kinds

    @classmethod
    def parameters(cls) -> Mapping[str, Parameter]:
        """The parameters of a kind by name, without ``kind``."""
        return declared(cls)

    @property
    def mistake(self) -> tuple[str, str] | None:
        """The broken rule between the part's parameters, with a remedy; None if all hold."""
        return None

    def at(self, cycle: float) -> Self:
        """The part at a cycle; the same object if it does not change."""
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
    def checksum(self) -> str:
        """The checksum of heights that the part has read from a file; empty without a file."""
        return ""

    @property
    def slug(self) -> str:
        """The part in the id of a case: letters, digits, ``.``, ``-`` and ``_``."""
        return self.kind

    def canonical(self) -> dict[str, object]:
        """Return kind and parameters, but not those at their default, in a form for JSON."""
        defaults = _defaults(type(self))
        fields = {
            name: parameter.canonical(vars(self)[name])
            for name, parameter in self.parameters().items()
            if vars(self)[name] != defaults[name]
        }
        return {"kind": self.kind, **fields}

    def coordinates(self, name: str) -> Coordinates:
        """Yield the coordinates of the fields of a part without kinds."""
        for key, parameter in self.parameters().items():
            yield from parameter.coordinates(f"{name}_{key}", vars(self)[key])


def located(place: str | int, value: object, error: ValueError) -> ValidationError:
    """An error at a key or an item of the value that is read, as pydantic reports it."""
    details = InitErrorDetails(type="value_error", loc=(place,), input=value, ctx={"error": error})
    return ValidationError.from_exception_data("value", [details])


def each(values: Sequence[object], read: Callable[[object], Value]) -> list[Value]:
    """Read the items of a list; the error lists all that are wrong."""
    items: TypeAdapter[list[Value]] = TypeAdapter(list[Annotated[Value, PlainValidator(read)]])
    return items.validate_python([*values])


def means_none(value: object) -> bool:
    """Whether a value is the word ``none``."""
    return isinstance(value, str) and value.strip().lower() == "none"


def is_list(value: object) -> TypeGuard[Sequence[object]]:
    """Whether a value is a list of values, not text."""
    return isinstance(value, Sequence) and not isinstance(value, str | bytes)


def pair(value: object) -> tuple[Any, Any]:
    """Return two values, equal where one was given."""
    return value if isinstance(value, tuple) else (value, value)


def json_text(value: object) -> str:
    """Return a value as JSON with sorted keys and numbers to twelve digits.

    >>> json_text({"cell": [2 / 3]})
    '{"cell":[0.666666666667]}'
    """

    def rounded(one: object) -> object:
        if isinstance(one, float):
            return float(f"{one:.11e}")
        if isinstance(one, dict):
            return {name: rounded(inner) for name, inner in one.items()}
        return [*map(rounded, one)] if isinstance(one, list | tuple) else one

    return json.dumps(rounded(value), sort_keys=True, separators=(",", ":"))


def inlined(schema: Schema) -> Schema:
    """A JSON Schema with its definitions inserted."""
    definitions = schema.get("$defs", {})

    def put(value: Any) -> Any:
        if isinstance(value, dict):
            if "$ref" in value:
                return put(definitions[value["$ref"].rpartition("/")[2]])
            return {
                key: put(item)
                for key, item in value.items()
                if key != "$defs" and not (key == "title" and isinstance(item, str))
            }
        return [put(item) for item in value] if isinstance(value, list) else value

    result: Schema = put(schema)
    return result


@_remembered
def adapter(kind: Any) -> TypeAdapter[Any]:
    """The pydantic form that reads values of a type."""
    return TypeAdapter(kind)


@_remembered
def _defaults(cls: type) -> dict[str, object]:
    fields = {one.name: one.default for one in dataclasses.fields(cls)}
    return {n: one.default if isinstance(one, FieldInfo) else one for n, one in fields.items()}


@_remembered
def declared(cls: type) -> Mapping[str, Parameter]:
    """Return the fields of a class that are annotated by a `Parameter`, bases first."""
    hints = get_type_hints(cls, include_extras=True)
    return {name: parameter for name, hint in hints.items() for parameter in _annotations(hint)}


@_remembered
def derived(cls: type) -> Mapping[str, Parameter]:
    """Return the properties of a class whose return type is annotated by a `Parameter`."""
    hints = {
        name: get_type_hints(member.fget, include_extras=True).get("return")
        for base in reversed(cls.__mro__)
        for name, member in vars(base).items()
        if isinstance(member, property)
    }
    return {name: parameter for name, hint in hints.items() for parameter in _annotations(hint)}


def _annotations(hint: object) -> Iterator[Parameter]:
    """Yield the parameters that annotate a type, described by the text beside them if any."""
    metadata = getattr(hint, "__metadata__", ())
    description = "".join(note for note in metadata if isinstance(note, str))
    changes = {"description": description} if description else {}
    for note in metadata:
        if isinstance(note, Parameter):
            yield dataclasses.replace(note, **changes)  # type: ignore[type-var]


@_remembered
def field_names(cls: type) -> frozenset[str]:
    """Return the names of the fields of a dataclass."""
    return frozenset(field.name for field in dataclasses.fields(cls))


@_remembered
def required(cls: type) -> frozenset[str]:
    """Return the fields of a dataclass without a default."""
    fields = dataclasses.fields(cls)
    return frozenset(
        f.name for f in fields if f.default is f.default_factory is dataclasses.MISSING
    )
