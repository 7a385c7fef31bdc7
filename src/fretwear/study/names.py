"""The names of a case's parameters, as study files and ``--set`` have them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

from fretwear.parts import Parameter, Part
from fretwear.study.members import Inline, PartOf
from fretwear.study.tree import members


@dataclass(frozen=True)
class Leaf:
    """One parameter of a case."""

    name: str  # in study files, dotted where it is a part's: ``load``, ``roughness.amplitude``
    member: str  # field of the case that it belongs to
    kind: type[Part] | None  # the part that has it; None: the case itself
    field: str
    parameter: Parameter


def leaves() -> Mapping[str, tuple[Leaf, ...]]:
    """Return the parameters of a case by name.

    Several kinds of a part may have a parameter of one name; the case's own come first.
    """
    return _leaves(kinds_of_parts())


def kinds_of_parts() -> tuple[tuple[type[Part], ...], ...]:
    """Return all kinds of all parts, which a new class makes more."""
    parts = (about for about in members().values() if isinstance(about, PartOf | Inline))
    return tuple(tuple(part.family.kinds().values()) for part in parts)


@cache
def _leaves(_: tuple[tuple[type[Part], ...], ...]) -> Mapping[str, tuple[Leaf, ...]]:
    found: dict[str, tuple[Leaf, ...]] = {}
    for member, about in members().items():
        if not isinstance(about, PartOf | Inline):
            found[member] = (Leaf(member, member, None, member, about),)
            continue
        for kind in about.family.kinds().values():
            known = about.parameters(kind) if isinstance(about, PartOf) else kind.parameters()
            for field, parameter in known.items():
                dotted = [] if isinstance(about, Inline) else [f"{member}.{field}"]
                stands_alone = isinstance(about, Inline) or kind.kind == about.short
                names = [*([field] if stands_alone else []), *dotted]
                leaf = Leaf(names[0], member, kind, field, parameter)
                for name in names:
                    found[name] = (*found.get(name, ()), leaf)
    return found


def base_names() -> tuple[str, ...]:
    """Return the keys that `base` may have: parts, and parameters that stand by themselves."""
    found: dict[str, list[str]] = {}
    for member, about in members().items():
        found[member] = [member] if isinstance(about, Parameter) else []
    for name, (leaf, *_) in leaves().items():
        if "." not in name and name != leaf.member:
            found[leaf.member].append(name)
    return tuple(name for names in found.values() for name in names)


def parameter_names() -> tuple[str, ...]:
    """Return the names that may be varied: keys of `base`, ``roughness.amplitude`` and so on."""
    return (*base_names(), *(name for name in leaves() if "." in name))


def member_of(name: str) -> str:
    """Return the member of a case that a name belongs to; a whole one is its own."""
    return leaves()[name][0].member if name in leaves() else name


def parameter_of(name: str) -> Parameter:
    """Return what a name is: a parameter, or a whole part."""
    about = members().get(name)
    return about if isinstance(about, Parameter) else leaves()[name][0].parameter
