"""Forms of values that are more than one number: lists, mappings, one for each body or axis.

They are built on a `Quantity`: ``PerBody(Quantity(...))``, ``Either(Quantity(...),
(Mapped(Law),))``.  Each form says which values it takes, and how they are read and stored.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar, SupportsFloat

from fretwear.parts import (
    Coordinates,
    Parameter,
    Plain,
    Quantity,
    Schema,
    declared,
    is_list,
    keys_schema,
    means_none,
    read_fields,
    required,
)
from fretwear.problems import Problems, in_words
from fretwear.units import QuantityError


@dataclass(frozen=True)
class Several(Parameter):
    """A list with one value for each place, or of any length if no places are given.

    A place has two endings: one for the names of coordinates, one for their words.
    """

    item: Parameter
    places: tuple[tuple[str, str], ...] = ()  # such as ("x", "along x")
    expected: str = "a list of values"
    record: type[tuple[object, ...]] = tuple  # the type of the list when read

    def takes(self, value: object) -> bool:
        return is_list(value)

    def read(self, value: object, units_required: bool) -> tuple[Any, ...]:
        if not is_list(value) or len(value) != (len(self.places) or len(value) or 1):
            count = f", but is a list of {len(value)}" if is_list(value) else ""
            raise QuantityError(f"must be {self.expected}{count}")
        problems, values = Problems(), []
        for position, item in enumerate(value):
            with problems.at(f"[{position}]", item):
                values.append(self.item.read(item, units_required))
        problems.raise_any()
        return self.record(values)

    def schema(self) -> Schema:
        most = {"maxItems": len(self.places)} if self.places else {}
        items = {"type": "array", "items": self.item.schema()}
        return {**items, "minItems": len(self.places) or 1, **most}

    def canonical(self, value: Sequence[object]) -> object:
        return [self.item.canonical(item) for item in value]

    def coordinates(self, name: str, value: Any) -> Coordinates:
        for (end, words), item in zip(self.places, value or [None] * len(self.places), strict=True):
            # Longer endings do not fit a symbol, which may have an index already.
            symbol = f"${self.item.symbol.strip('$')}_{end}$" if len(end) == 1 else ""
            about = self.item.called(f"{self.item.words} {words}", symbol)
            yield from about.coordinates(f"{name}_{end}", item)


@dataclass(frozen=True)
class Mapped(Parameter):
    """A mapping with the declared fields of a dataclass, such as a part without kinds."""

    record: type[object]

    @property
    def fields(self) -> Mapping[str, Parameter]:
        """The parameters by key."""
        return declared(self.record)

    def takes(self, value: object) -> bool:
        return isinstance(value, Mapping | self.record)

    def read(self, value: object, units_required: bool) -> Any:
        if not isinstance(value, Mapping):
            return value
        needed = required(self.record)
        return self.record(**read_fields(value, self.fields, needed, units_required))

    def schema(self) -> Schema:
        fields = {name: about.schema() for name, about in self.fields.items()}
        return keys_schema(fields, [name for name in fields if name in required(self.record)])

    def canonical(self, value: object) -> object:
        values = ((name, about, vars(value)[name]) for name, about in self.fields.items())
        return {n: about.canonical(v) for n, about, v in values if v != about.unsaid}

    def coordinates(self, name: str, value: Any) -> Coordinates:
        for key, about in self.fields.items():
            yield from about.coordinates(f"{name}_{key}", value and vars(value)[key])


@dataclass(frozen=True)
class Either(Parameter):
    """A single value, which names the parameter, or another form, recognised by how it is written.

    A value of another form that converts to a float has that float as a coordinate too.
    """

    single: Parameter
    others: tuple[Parameter, ...] = ()
    description: str = field(default="", kw_only=True)
    may_be_drawn = True
    # For a class whose values may be a list: its places, and the expectation in messages.
    places: ClassVar[tuple[tuple[str, str], ...]] = ()
    expected: ClassVar[str] = ""

    def __post_init__(self) -> None:
        """Take over the names and units of the single value."""
        names = "si_unit", "symbol", "words", "unit", "example"
        vars(self).update({name: getattr(self.single, name) for name in names})

    @cached_property
    def forms(self) -> tuple[Parameter, ...]:
        """All forms, the single value last."""
        lists = [Several(self.single, self.places, self.expected)] if self.places else []
        return *lists, *self.others, self.single

    def _form_of(self, value: object) -> Parameter:
        """The form that takes a value; of several mappings, the one with the most of its keys."""
        if isinstance(value, float):  # as most are
            return self.single
        forms = [form for form in self.forms if form.takes(value)]
        if isinstance(value, Mapping):
            forms.sort(key=lambda form: -len(getattr(form, "fields", {}).keys() & value.keys()))
        return forms[0]

    def read(self, value: object, units_required: bool) -> Any:
        return self._form_of(value).read(value, units_required)

    def schema(self) -> Schema:
        *others, single = (form.schema() for form in self.forms)
        return {"anyOf": [single, *others]}

    def called(self, words: str, symbol: str = "") -> Parameter:
        return dataclasses.replace(self, single=self.single.called(words, symbol))

    def coordinates(self, name: str, value: object) -> Coordinates:
        """Yield the coordinates of a value; for None, every coordinate that a value may have."""
        if value is None:
            for form in self.forms:
                yield from form.coordinates(name, None)
            yield name, self, math.nan
            return
        form = self._form_of(value)
        if form is not self.single and isinstance(value, SupportsFloat):
            yield name, self.single, float(value)
        yield from form.coordinates(name, value)

    def canonical(self, value: object) -> object:
        return self._form_of(value).canonical(value)

    def word_for(self, value: object) -> str:
        return self.single.word_for(value)

    def text(self, value: object) -> str:
        return self.single.text(value) if isinstance(value, float | str) else str(value)


@dataclass(frozen=True)
class PerBody(Either):
    """One value for both bodies, or a pair [body I, body II]."""

    may_be_drawn = False
    places = ("1", "of body I"), ("2", "of body II")
    expected = "one value, or two for two bodies"

    def read(self, value: object, units_required: bool) -> Any:
        if isinstance(value, Mapping):
            of_bodies = in_words([*value.values()]) if len(value) == 2 else "[body I, body II]"
            raise QuantityError(f"must be {self.expected}", f"two are a list: {of_bodies}")
        return super().read(value, units_required)

    def coordinates(self, name: str, value: Any) -> Coordinates:
        """Yield one coordinate if both bodies are alike, else two."""
        first, second = pair(value)
        yield from super().coordinates(name, first if first == second else (first, second))

    def canonical(self, value: Any) -> object:
        return super().canonical(pair(value))


@dataclass(frozen=True)
class AlongXY(Either):
    """A value along x and one along y; a single value is used for both."""

    may_be_drawn = False
    places = ("x", "along x"), ("y", "along y")
    expected = "one value, or one along x and one along y"

    def read(self, value: object, units_required: bool) -> tuple[object, object]:
        return pair(super().read(value, units_required))


@dataclass(frozen=True)
class Patch(Plain):
    """A rectangle: corner x, y, width and height; None for the whole map."""

    example = "[0 mm, 0 mm, 0.5 mm, 0.5 mm]"
    _lengths: ClassVar = Several(
        Quantity("m", "", "", "mm", like="0.5 mm", at_least=0.0),
        (("x", ""), ("y", ""), ("width", ""), ("height", "")),
        "[x, y, width, height]",
    )

    def read(self, value: object, units_required: bool) -> tuple[float, ...] | None:
        """Return four lengths, or None."""
        if means_none(value, units_required):
            return None
        lengths = self._lengths.read(value, units_required)
        if 0.0 in lengths[2:]:
            raise QuantityError("must have a width and a height larger than 0")
        return lengths

    def canonical(self, value: Sequence[float] | None) -> object:
        return "none" if value is None else [*value]

    def coordinates(self, name: str, value: Sequence[float] | None) -> Coordinates:
        """Yield the rectangle as one text, in m."""
        yield name, self, str(self.canonical(value))

    def schema(self) -> Schema:
        return {"anyOf": [{"const": "none"}, self._lengths.schema()]}


def pair(value: float | tuple[float, float]) -> tuple[float, float]:
    """Return two values, equal where one was given."""
    return value if isinstance(value, tuple) else (value, value)
