"""The keys of a case: their names, their types, and the parts that they make up."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import dataclass
from functools import cached_property
from types import GenericAlias
from typing import Annotated, Any, Generic, Literal, Self, TypeVar, get_type_hints

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag, model_validator

from fretwear.quantity import (
    BODIES,
    Inline,
    Parameter,
    Part,
    PartOf,
    Quantity,
    declared,
    derived,
    required,
)
from fretwear.study.materials import MATERIAL, PROPERTIES, Material
from fretwear.study.mistakes import LISTED, RANGE, Mistakes
from fretwear.units import QuantityError, nearest

_Value = TypeVar("_Value")
_DRAWN = (), BODIES  # places of quantities that may be drawn from a range


class Range(BaseModel, Generic[_Value]):
    """An interval to sample, in SI units, uniformly or uniformly in the logarithm."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    low: Annotated[_Value, Field(alias="from")]
    high: Annotated[_Value, Field(alias="to")]
    scale: Literal["linear", "log"] = "linear"

    @model_validator(mode="after")
    def _check(self) -> Self:
        low, high = self.low, self.high
        if not (isinstance(low, float) and isinstance(high, float) and low < high < math.inf):
            raise QuantityError("must lead from a value to a larger one, both finite")
        if self.scale == "log" and low <= 0.0:
            raise QuantityError("must begin above 0 on a logarithmic scale")
        return self

    def at(self, fraction: float) -> float:
        """Return the value at a fraction of the way, rounded to six digits."""
        ends = float(self.low), float(self.high)  # type: ignore[arg-type]
        low, high = map(math.log, ends) if self.scale == "log" else ends
        value = low + fraction * (high - low)
        # Six digits keep the ids of cases independent of the last bit of a logarithm.
        return float(f"{math.exp(value) if self.scale == 'log' else value:.6g}")


@dataclass(frozen=True)
class Key:
    """A parameter of a case, or a part as a whole."""

    member: str  # field of the case to which it belongs
    field: str  # field of the part, or of the case
    parameter: Parameter
    hint: Any  # type of the value
    kind: type[Part] | None = None  # the part that has it; None: the case itself


def coordinate(name: str) -> str:
    """Return the name of a parameter as a dataset coordinate.

    The load is ``normal_load`` there, because ``load`` is a method of datasets.
    """
    return "normal_load" if name == "load" else name.replace(".", "_")


class Keys:
    """The keys of a dataclass with parts, with the kinds registered when it is made."""

    def __init__(self, owner: type) -> None:
        self.owner, self.members = owner, declared(owner)
        self._own: dict[str, Key] = {}
        self._dotted: dict[str, Key] = {}  # fields of parts; the first one if kinds share a name
        self._coordinates: dict[str, Parameter] = {}
        # Fields of open parts, of all kinds or of the short one.
        self.open_keys = {member: _open_keys(whole) for member, whole in self.members.items()}
        hints = get_type_hints(owner, include_extras=True)
        for member, parameter in self.members.items():
            if not isinstance(parameter, Inline):
                self._own[member] = Key(member, member, parameter, hints[member])
            if isinstance(parameter, PartOf):
                for kind in parameter.family.kinds().values():
                    self._add_fields(member, parameter, kind)
        for name, key in self._own.items():
            self._coordinates |= _possible(coordinate(name), key.parameter)
        self._coordinates |= derived(owner)

    def _add_fields(self, member: str, member_parameter: PartOf, kind: type[Part]) -> None:
        hints = get_type_hints(kind, include_extras=True)
        for field, parameter in member_parameter.named(kind.parameters()).items():
            key = Key(member, field, parameter, hints[field], kind)
            if field in self.open_keys[member]:
                self._own.setdefault(field, key)
            if not isinstance(member_parameter, Inline):
                self._dotted.setdefault(f"{member}.{field}", key)
                self._coordinates |= _possible(f"{member}_{field}", parameter)
        named = member_parameter.named(derived(kind)).items()
        self._coordinates |= {f"{member}_{name}": quantity for name, quantity in named}

    @cached_property
    def types(self) -> dict[str, object]:
        """The types of the values of all keys, including a material."""
        return {**{name: _described(key) for name, key in self._own.items()}, MATERIAL: Material}

    @property
    def names(self) -> tuple[str, ...]:
        """The keys that `base` may have: parts and single parameters."""
        return (*self._own,)

    @property
    def all_names(self) -> tuple[str, ...]:
        """The names that may be varied: keys of `base`, ``roughness.amplitude`` and so on."""
        return (*self._own, *self._dotted)

    def __getitem__(self, name: str) -> Key:
        return self._own[name] if name in self._own else self._dotted[name]

    def coordinate(self, name: str) -> Parameter:
        """Return a parameter by its name in a study file or as a coordinate.

        An unknown name, such as a dimension added by a user, is taken to be a plain number.
        """
        plain = Quantity("1", name, name.replace("_", " "))
        return self._coordinates.get(coordinate(name), plain)

    def member_of(self, name: str) -> str:
        """Return the member of a case to which a name belongs, or which it names."""
        return self[name].member if name in self.all_names else name

    def replaced_by(self, name: str) -> set[str]:
        """Return the names that a new value replaces: ``radius`` replaces ``indenter``."""
        if name == MATERIAL:
            return {*PROPERTIES}
        member = self.member_of(name)
        if member in ("cycles", "blocks"):
            return {"cycles", "blocks"} - {name}
        parameter, keys = self.members.get(member), {*self.open_keys.get(member, ())}
        if isinstance(parameter, Inline):
            kind = parameter.leading.get(name)
            return keys - {*kind.parameters()} if kind else set()
        return {member} if name in keys else keys

    def members_of(
        self, values: Mapping[str, Any], unread: Set[str], mistakes: Mistakes
    ) -> dict[str, object]:
        """Return the members of a case by values of keys, and report missing and superfluous keys.

        Unread keys were given, but their values are unknown. Keys that the first block gives may be
        missing.
        """
        names = {*values, *unread}
        needed = required(self.owner) - ({"cycles"} if "blocks" in names else set())
        members: dict[str, object] = {}
        if {"cycles", "blocks"} <= names:
            mistakes.add("cycles", None, "is redundant: each block gives its cycles")
        for member, parameter in self.members.items():
            open_keys = self.open_keys[member]
            keys = {name: values[name] for name in open_keys if name in values}
            if isinstance(parameter, Inline):
                part = self._inline(parameter, keys, names, values.get("blocks", ()), mistakes)
                members |= {member: part} if part is not None else {}
            elif member in values:
                value = values[member]
                is_trivial = isinstance(value, Part) and value.is_trivial
                members[member] = None if is_trivial else value
                for name in names & open_keys.keys():
                    mistakes.add(name, None, f"is redundant: {member} is given too")
            elif keys and isinstance(parameter, PartOf):
                members[member] = parameter.family.kinds()[parameter.short].unchecked(**keys)
            elif member in needed and not names & {member, *open_keys}:
                self._missing(next(iter(open_keys), member), mistakes)
        return members

    def unread(self, names: Set[str], known: Set[str]) -> set[str]:
        """Return the keys that are given but not known.

        A misspelt name counts as the nearest key, unless that would replace a given key.
        """
        names = {*names, *(PROPERTIES if MATERIAL in names else ())} - {MATERIAL}
        near = {nearest(name, self.all_names) for name in names if name not in self._own}
        meant = {name.partition(".")[0] for name in near} - {""}
        meant = {name for name in meant if not self.replaced_by(name) & names}
        return (names & self._own.keys() | meant) - known

    def lacking(self, members: Mapping[str, object], unread: Set[str]) -> Set[str]:
        """Return the members of a case that are missing, or whose values are unknown."""
        return (required(self.owner) - members.keys()) | {self.member_of(name) for name in unread}

    def _missing(self, name: str, mistakes: Mistakes) -> None:
        mistakes.add(name, None, "is missing", f"such as {name}: {self[name].parameter.example}")

    def _inline(
        self,
        inline: Inline,
        keys: dict[str, object],
        names: set[str],
        blocks: Sequence[Any],
        mistakes: Mistakes,
    ) -> Part | None:
        """The part, of the kind that the keys determine."""
        known = inline.keys
        if (kind := inline.kind_of(keys)) is None and blocks:
            keys = {n: v for n, v in blocks[0].values.items() if n in known} | keys
            kind = inline.kind_of(keys)
        if kind is not None and not names & (known.keys() - keys.keys()):
            part = kind.unchecked(**keys)
            if part.mistake is not None:
                mistakes.add(next(iter(keys)), None, *part.mistake)
            return part
        leading = inline.leading
        first, *others = [name for name in leading if name in names] or [""]
        kind = leading[first] if first else next(iter(inline.family.kinds().values()))
        if leading and not first:
            if "blocks" not in names:
                such = " or ".join(f"{name}: {known[name].example}" for name in leading)
                name = next(iter(leading))
                mistakes.add(name, None, "is missing", f"give one of {such}")
            return None
        for name in sorted({*others, *names & known.keys() - kind.parameters().keys()}):
            mistakes.add(name, None, f"is redundant: {first} is given too")
        for name in kind.parameters():
            if not others and name in required(kind) and name not in names:
                self._missing(name, mistakes)
        return None


def _open_keys(parameter: Parameter) -> dict[str, Parameter]:
    if not isinstance(parameter, PartOf):
        return {}
    kinds = parameter.family.kinds().items()
    short = None if isinstance(parameter, Inline) else parameter.short
    chosen = (kind for name, kind in kinds if short in {None, name})
    return {name: one for kind in chosen for name, one in kind.parameters().items()}


def _described(key: Key) -> object:
    """The type of a value, annotated by the parameter with its description."""
    notes = (key.parameter if isinstance(n, Parameter) else n for n in key.hint.__metadata__)
    annotated: Any = Annotated  # a type checker takes the index of `Annotated` for a type
    return annotated[(key.hint.__origin__, *notes)]


def varied_type(key: Key) -> object:
    """The type of the values of a varied parameter: a list or, of most quantities, a range."""
    listed: Any = Annotated[GenericAlias(list, (_described(key),)), Field(min_length=1)]
    quantity = key.parameter
    if not isinstance(quantity, Quantity) or quantity.is_whole or quantity.places not in _DRAWN:
        return listed
    generic: Any = Range
    drawn: Any = generic[key.hint]

    def tag(value: object) -> str:
        is_range = isinstance(value, Mapping) and {"from", "to"} & {*value}
        return RANGE if is_range or isinstance(value, Range) else LISTED

    either = Annotated[listed, Tag(LISTED)] | Annotated[drawn, Tag(RANGE)]
    return Annotated[either, Discriminator(tag)]


def _possible(name: str, key: Parameter) -> Iterable[tuple[str, Parameter]]:
    """The coordinates that a parameter may have, by name."""
    yield name, key
    if not isinstance(key, Quantity):
        return
    for end, words in key.places:
        yield from _possible(f"{name}_{end}", key._item.renamed(f"{key.words} {words}"))
    for form in key.forms:
        for field, parameter in (fields := declared(form)).items():
            yield from _possible(f"{name}_{field}", parameter)
        if not fields:
            yield f"{name}_over_cycles", Quantity("1", name, f"{name} over the cycles")
