"""The keys of a case: their names, how each is read, and the parts that they make up."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Protocol, get_type_hints

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
from fretwear.units import QuantityError, nearest

_OTHER_NAMES = {
    word: meant
    for words, meant in (
        ("hardness hv hb vickers_hardness yield_stress yield_strength", "plastic_limit"),
        ("ra rq sa sq rz rms_roughness", "roughness"),
        ("stroke displacement amplitude u", "displacement_amplitude"),
        ("r diameter", "radius"),
        ("e young modulus", "youngs_modulus"),
        ("nu v", "poisson_ratio"),
        ("p force normal_load normal_force", "load"),
        ("q tangential_force", "tangential_load"),
        ("mu cof friction_coefficient", "friction"),
        ("k kw k_w archard wear_rate specific_wear_rate", "wear_coefficient"),
        ("n n_cycles number_of_cycles time duration", "cycles"),
        ("dx spacing mesh grid", "cell"),
        ("debris third_body", "debris_fraction"),
    )
    for word in words.split()
}
"""Words that users may write for a parameter."""


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


class _Block(Protocol):
    @property
    def values(self) -> tuple[tuple[str, object], ...]: ...


class Keys:
    """The keys of a dataclass with parts."""

    def __init__(self, owner: type) -> None:
        self.owner, self.members = owner, declared(owner)
        self.inline = {n: about for n, about in self.members.items() if isinstance(about, Inline)}
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
            if member not in self.inline:
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
                    if member not in self.inline:
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

    def of_kind(self, name: str, kind: str) -> Key:
        """The field of a part of a kind."""
        of_kinds = self._tables[1][name]
        return of_kinds.get(kind) or self[name]

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
        name = key.rpartition(".")[2] if key.rpartition(".")[2] in key else key
        meant = _OTHER_NAMES.get(name.casefold().replace(" ", "_"))
        hint = f"did you mean {meant!r}?" if meant else ""
        if name in self.all_names and "." in name:
            hint = f"write {name.replace('.', ': {', 1)}: ...}}"
        near = nearest(name, self.all_names)
        hint = hint or (f"did you mean {near!r}?" if near else "fretwear schema lists all keys")
        problems.add(key, given, "is not a case parameter", hint)

    def read_values(
        self,
        raw: Mapping[str, Any],
        prefix: str,
        problems: Problems,
        folder: object = None,
        left: Iterable[str] = (),
    ) -> dict[str, Any]:
        """Read keys of a case, except some; return the valid values and collect the problems."""
        values: dict[str, Any] = {}
        names = self.names
        for name, value in raw.items():
            if name in left:
                continue
            if name not in names:
                self.unknown(f"{prefix}{name}", value, problems)
                continue
            with problems.at(f"{prefix}{name}", value):
                if value is None and folder is not None:
                    raise QuantityError(
                        "has no value", f"such as {name}: {self[name].about.example}"
                    )
                values[name] = self[name].read(value, folder)
        return values

    def members_of(
        self,
        values: Mapping[str, Any],
        given: Iterable[str],
        problems: Problems,
        prefix: str = "",
    ) -> dict[str, Any]:
        """Return the members of a case by values of keys, and report what is missing or too much.

        Keys that were given, valid or not, count. Keys that all blocks give may be missing.
        """
        given, blocks = {*given}, values.get("blocks", ())
        unknown = [name for name in given if name not in self.names]
        given |= {_OTHER_NAMES.get(name.casefold(), name) for name in unknown}
        given |= {near for name in unknown if (near := nearest(name, self.names))}
        parts: dict[str, Any] = {}
        if {"cycles", "blocks"} <= given:
            problems.add(f"{prefix}cycles", None, "is redundant: each block gives its cycles")
        for member, about in self.members.items():
            open_keys = {n for kind in self._open(about).values() for n in kind.parameters()}
            keys = {name: values[name] for name in open_keys if name in values}
            if member in self.inline:
                part = self._inline(self.inline[member], keys, given, blocks, problems, prefix)
                parts |= {member: part} if part is not None else {}
            elif member in values:
                value = values[member]
                is_trivial = isinstance(value, Part) and value.is_trivial
                parts[member] = None if is_trivial else value
                for name in sorted(given & open_keys):
                    rule = f"is redundant: {member} is given too"
                    problems.add(f"{prefix}{name}", None, rule, f"write it inside {member}")
            elif keys:
                parts[member] = next(iter(self._open(about).values())).unchecked(**keys)
            elif member in required(self.owner) and not given & {member, *open_keys}:
                if member == "cycles" and "blocks" in given:
                    continue
                name = next(
                    (n for kind in self._open(about).values() for n in kind.parameters()), member
                )
                problems.add(f"{prefix}{name}", None, "is missing", self._such_as(name))
        return parts

    def _such_as(self, name: str) -> str:
        return f"such as {name}: {self[name].about.example}"

    def _inline(
        self,
        about: Inline,
        keys: dict[str, Any],
        given: set[str],
        blocks: Sequence[_Block],
        problems: Problems,
        prefix: str,
    ) -> Part | None:
        """The part of the kind that the keys decide."""
        if (kind := about.kind_of(keys)) is None and blocks:
            known = about.keys
            in_blocks = [{n: v for n, v in block.values if n in known} for block in blocks]
            kinds = [about.kind_of(keys.keys() | one.keys()) for one in in_blocks]
            if None not in kinds and kinds[0] is not None:
                # Only required values are completed: a block may lack an optional one.
                lacking = required(kinds[0]) - keys.keys()
                keys |= {name: in_blocks[0][name] for name in lacking}
                kind = kinds[0]
        if kind is not None and not given & (about.keys.keys() - keys.keys()):
            part = kind.unchecked(**keys)
            if part.problem is not None:
                problems.add(f"{prefix}{next(iter(keys))}", None, *part.problem)
            return part
        leading = about.leading
        touched = [name for name in leading if name in given]
        choices = " or ".join(f"{name}: {about.keys[name].example}" for name in leading)
        for name in touched[1:]:
            rule = f"is redundant: {touched[0]} is given too"
            problems.add(f"{prefix}{name}", keys.get(name), rule, f"give one of {choices}")
        if len(touched) == 1:
            kind = leading[touched[0]]
            for name in sorted(given & (about.keys.keys() - kind.parameters().keys())):
                rule = f"has no meaning with {touched[0]}"
                problems.add(f"{prefix}{name}", None, rule, "leave one of them out")
        if leading and not touched and not (blocks or "blocks" in given):
            first, *others = leading
            rule = f"is missing, and so {'are' if others[1:] else 'is'} {', '.join(others)}"
            problems.add(f"{prefix}{first}", None, rule, f"give one of {choices}")
        elif len(touched) <= 1:
            kind = leading[touched[0]] if touched else next(iter(about.family.kinds().values()))
            for name in kind.parameters():
                if name in required(kind) and name not in given:
                    problems.add(f"{prefix}{name}", None, "is missing", self._such_as(name))
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
