"""The keys of a case: their names, how each is read, and the parts that they make up."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, get_type_hints

from fretwear.quantity import (
    Inline,
    Parameter,
    Part,
    PartOf,
    Quantity,
    Schema,
    adapter,
    declared,
    derived,
    inlined,
    required,
)
from fretwear.study.materials import MATERIAL, PROPERTIES
from fretwear.study.problems import Problems
from fretwear.units import nearest


@dataclass(frozen=True)
class Key:
    """A parameter of a case, or a part as a whole."""

    name: str  # in study files, dotted within a part: ``load``, ``roughness.amplitude``
    member: str  # field of the case to which it belongs
    field: str  # field of the part, or of the case
    about: Parameter
    hint: Any  # type of the value
    kind: type[Part] | None = None  # the part that has it; None: the case itself

    def read(self, value: object, folder: object = None) -> Any:
        """Return a value, as written or in SI units, in SI units."""
        return adapter(self.hint).validate_python(value, context=folder)


def coordinate(name: str) -> str:
    """Return the name of a parameter as a dataset coordinate.

    The load is ``normal_load`` there, because ``load`` is a method of datasets.
    """
    return "normal_load" if name == "load" else name.replace(".", "_")


_Tables = tuple[dict[str, Key], dict[str, dict[str, Key]], dict[str, Parameter]]


class Keys:
    """The keys of a dataclass with parts."""

    def __init__(self, owner: type) -> None:
        self.owner, self.members = owner, declared(owner)
        self._hints = get_type_hints(owner, include_extras=True)

    def _open(self, about: Parameter) -> Mapping[str, type[Part]]:
        """The kinds whose fields are keys of the case."""
        if not isinstance(about, PartOf):
            return {}
        kinds = about.family.kinds()
        if isinstance(about, Inline):
            return kinds
        return {about.short: kinds[about.short]} if about.short else {}

    @property
    def _tables(self) -> _Tables:
        """Keys of the case, fields of parts by dotted name and kind, and coordinates."""
        parts = [about.family for about in self.members.values() if isinstance(about, PartOf)]
        kinds = tuple(tuple(part.kinds().values()) for part in parts)
        if self._built is None or self._built[0] != kinds:  # users may define kinds
            self._built = kinds, self._build()
        return self._built[1]

    _built: tuple[object, _Tables] | None = None

    def _build(self) -> _Tables:
        keys: dict[str, Key] = {}
        dotted: dict[str, dict[str, Key]] = {}
        coordinates: dict[str, Parameter] = {}
        for member, about in self.members.items():
            if not isinstance(about, Inline):
                keys[member] = Key(member, member, member, about, self._hints[member])
            if not isinstance(about, PartOf):
                continue
            open_kinds = self._open(about)
            for name, kind in about.family.kinds().items():
                hints = get_type_hints(kind, include_extras=True)
                for field, parameter in about.named(kind.parameters()).items():
                    key = Key(field, member, field, parameter, hints[field], kind)
                    if name in open_kinds:
                        keys.setdefault(field, key)
                    if not isinstance(about, Inline):
                        of_kinds = dotted.setdefault(f"{member}.{field}", {})
                        of_kinds[name] = key
                named = about.named(derived(kind)).items()
                coordinates |= {f"{member}_{one}": quantity for one, quantity in named}
        fields = [(name, key) for name, kinds in dotted.items() for key in kinds.values()]
        for name, key in [*fields, *keys.items()]:
            coordinates |= _possible(coordinate(name), key.about)
        return keys, dotted, {**coordinates, **derived(self.owner)}

    @property
    def names(self) -> tuple[str, ...]:
        """The keys that `base` may have: parts and single parameters."""
        return (*self._tables[0],)

    @property
    def all_names(self) -> tuple[str, ...]:
        """The names that may be varied: keys of `base`, ``roughness.amplitude`` and so on."""
        keys, dotted, _ = self._tables
        return (*keys, *dotted)

    def __getitem__(self, name: str) -> Key:
        keys, dotted, _ = self._tables
        return keys[name] if name in keys else next(iter(dotted[name].values()))

    def coordinate(self, name: str) -> Parameter:
        """Return a parameter by its name in a study file or as a coordinate.

        An unknown name, such as a dimension that a user added, is taken to be a plain number.
        """
        plain = Quantity("1", name, name.replace("_", " "))
        return self._tables[2].get(coordinate(name), plain)

    def member_of(self, name: str) -> str:
        """Return the member of a case that a name belongs to or denotes."""
        return self[name].member if name in self.all_names else name

    def replaced_by(self, name: str) -> set[str]:
        """Return the names that a new value of one replaces: ``radius`` by ``indenter``."""
        if name == MATERIAL:
            return {*PROPERTIES}
        member = self.member_of(name)
        if member in ("cycles", "blocks"):
            return {"cycles", "blocks"} - {name}
        about = self.members.get(member)
        if isinstance(about, Inline):
            kind = about.leading.get(name)
            return {*about.keys} - {*kind.parameters()} if kind else set()
        keys = {n for kind in self._open(about or Parameter()).values() for n in kind.parameters()}
        return {member} if name in keys else keys

    def value_schema(self, name: str) -> Schema:
        """The JSON Schema of the value of a key."""
        key = self[name]
        return {**inlined(adapter(key.hint).json_schema()), **key.about.described}

    def unknown(self, key: str, given: object, problems: Problems) -> None:
        """Report a name that is no key of a case."""
        problems.unknown(key, given, self.all_names, "is not a case parameter")

    def read_values(
        self, raw: Mapping[str, Any], problems: Problems, folder: object = None
    ) -> dict[str, Any]:
        """Read keys of a case; return the valid values and collect the problems."""
        values: dict[str, Any] = {}
        names = self.names
        for name, value in raw.items():
            if name not in names:
                self.unknown(name, value, problems)
                continue
            with problems.at(name, value):
                values[name] = self[name].read(value, folder)
        return values

    def members_of(
        self,
        values: Mapping[str, Any],
        given: Iterable[str],
        problems: Problems,
    ) -> dict[str, Any]:
        """Return the members of a case by values of keys, and report what is missing or too much.

        Keys that were given, valid or not, count. Keys that the first block gives may be missing.
        """
        names = self.names
        given = {name if name in names else nearest(name, names) for name in given}
        needed = required(self.owner) - ({"cycles"} if "blocks" in given else set())
        parts: dict[str, Any] = {}
        if {"cycles", "blocks"} <= given:
            problems.add("cycles", None, "is redundant: each block gives its cycles")
        for member, about in self.members.items():
            kinds = self._open(about).values()
            open_keys = {name: None for kind in kinds for name in kind.parameters()}
            keys = {name: values[name] for name in open_keys if name in values}
            if isinstance(about, Inline):
                part = self._inline(about, keys, given, values.get("blocks", ()), problems)
                parts |= {member: part} if part is not None else {}
            elif member in values:
                value = values[member]
                is_trivial = isinstance(value, Part) and value.is_trivial
                parts[member] = None if is_trivial else value
                for name in given & open_keys.keys():
                    problems.add(name, None, f"is redundant: {member} is given too")
            elif keys:
                parts[member] = next(iter(kinds)).unchecked(**keys)
            elif member in needed and not given & {member, *open_keys}:
                self._missing(next(iter(open_keys), member), problems)
        return parts

    def _missing(self, name: str, problems: Problems) -> None:
        hint = f"such as {name}: {self[name].about.example}"
        problems.add(name, None, "is missing", hint)

    def _inline(
        self,
        about: Inline,
        keys: dict[str, Any],
        given: set[str],
        blocks: Sequence[Any],
        problems: Problems,
    ) -> Part | None:
        """The part of the kind that the keys decide."""
        known = about.keys
        if (kind := about.kind_of(keys)) is None and blocks:
            keys = {n: v for n, v in blocks[0].values.items() if n in known} | keys
            kind = about.kind_of(keys)
        if kind is not None and not given & (known.keys() - keys.keys()):
            part = kind.unchecked(**keys)
            if part.problem is not None:
                problems.add(next(iter(keys)), None, *part.problem)
            return part
        leading = about.leading
        first, *others = [name for name in leading if name in given] or [""]
        kind = leading[first] if first else next(iter(about.family.kinds().values()))
        if leading and not first:
            if "blocks" not in given:
                such = " or ".join(f"{name}: {known[name].example}" for name in leading)
                name = next(iter(leading))
                problems.add(name, None, "is missing", f"give one of {such}")
            return None
        for name in sorted({*others, *given & known.keys() - kind.parameters().keys()}):
            problems.add(name, None, f"is redundant: {first} is given too")
        for name in kind.parameters():
            if not others and name in required(kind) and name not in given:
                self._missing(name, problems)
        return None


def _possible(name: str, about: Parameter) -> Iterable[tuple[str, Parameter]]:
    """The coordinates that a parameter may have, by name."""
    yield name, about
    if not isinstance(about, Quantity):
        return
    for end, words in about.places:
        yield from _possible(f"{name}_{end}", about._item.renamed(f"{about.words} {words}"))
    for form in about.forms:
        fields: Mapping[str, Parameter] = MappingProxyType({})
        fields = declared(form) or fields
        for field, parameter in fields.items():
            yield from _possible(f"{name}_{field}", parameter)
        if not fields:
            yield f"{name}_over_cycles", Quantity("1", name, f"{name} over the cycles")
