"""The parameters of a case by the names of study files and datasets, and as people write them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from typing import Any

from fretwear.parts import Parameter, Part, Quantity, derived
from fretwear.study.members import Inline, PartOf
from fretwear.study.tree import CaseTree, members


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


def replaced_by(name: str) -> set[str]:
    """Return the names that cannot stay where one is given anew: ``radius`` by ``indenter``."""
    member = member_of(name)
    about = members().get(member)
    if member in ("cycles", "blocks"):
        return {"cycles", "blocks"} - {name}
    if isinstance(about, PartOf):
        return {member} if name in about.keys else {*about.keys}
    if isinstance(about, Inline) and (kind := about.leading.get(name)):
        return {*about.parameters} - {*kind.parameters()}
    return set()


def coordinate(name: str) -> str:
    """Return the name of a parameter as a dataset coordinate."""
    return name.replace(".", "_")


def parameter(name: str) -> Parameter:
    """Return what a parameter is, by its name in a study file or as a coordinate.

    A name that no case has, such as that of a user's own dimension, is that of a plain number.
    """
    plain = Quantity("1", name, name.replace("_", " "))
    return _by_coordinate(kinds_of_parts()).get(coordinate(name), plain)


def value_text(name: str, value: Any) -> str:
    """Return the value alone, in units for people: ``25 N``, ``smooth``, ``elastic``."""
    return parameter(name).text(value)


def symbol_text(name: str, value: Any) -> str:
    """Return symbol and value in mathtext, for labels inside figures: ``$P$ = 25 N``."""
    about = parameter(name)
    return about.word_for(value) or f"{about.symbol} = {about.text(value)}"


def words_text(name: str, value: Any) -> str:
    """Return words and value, for captions: ``normal load 25 N``, ``elastic``."""
    about = parameter(name)
    return about.word_for(value) or f"{about.words} {about.text(value)}"


def html_table(caption: str, rows: Iterable[Sequence[str]]) -> str:
    """Return a table for notebooks, the first column in the type of code."""
    from html import escape

    left = "style='text-align:left'"
    lines = "".join(
        f"<tr><th {left}><code>{escape(name)}</code></th>"
        f"{''.join(f'<td {left}>{escape(each)}</td>' for each in others)}</tr>"
        for name, *others in rows
    )
    return f"<table><caption>{escape(caption)}</caption>{lines}</table>"


@cache
def _by_coordinate(_: tuple[tuple[type[Part], ...], ...]) -> Mapping[str, Parameter]:
    found: dict[str, Parameter] = {}
    for leaf in (leaf for several in leaves().values() for leaf in several):
        name = coordinate(leaf.name)
        found.setdefault(name, leaf.parameter)
        # Of two values, each has a coordinate of its own.
        for value in leaf.parameter.forms:
            with suppress(TypeError):
                found |= {n: p for n, p, _ in leaf.parameter.coordinates(name, value)}
    for member, about in members().items():
        if isinstance(about, PartOf):
            found.setdefault(member, about)
            for kind in about.kinds.values():
                following = about.derived(kind).items()
                found |= {f"{member}_{name}": each for name, each in following}
    return {**found, **derived(CaseTree)}
