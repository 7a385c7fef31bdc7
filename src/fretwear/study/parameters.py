"""How the parameters of a case are written for people, by the names of files and datasets."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from typing import Any

from fretwear.parts import Parameter, Part, Quantity, derived, kind_name
from fretwear.study.tree import (
    CaseTree,
    Member,
    coordinate,
    derived_of,
    kinds,
    leaves,
    leaves_of,
    members,
)


def parameter(name: str) -> Parameter:
    """Return what a parameter is, by its name in a study file or as a coordinate.

    A name that no case has, such as that of a user's own dimension, is that of a plain number.
    """
    families = tuple(kinds(m) for m, a in members().items() if isinstance(a, Member))
    plain = Quantity("1", name, name.replace("_", " "))
    return _by_coordinate(families).get(coordinate(name), plain)


def value_text(name: str, value: Any) -> str:
    """Return the value alone, in units for people: ``25 N``, ``smooth``, ``elastic``."""
    return _part_text(name, value) or parameter(name).text(value)


def symbol_text(name: str, value: Any) -> str:
    """Return symbol and value in mathtext, for labels inside figures: ``$P$ = 25 N``."""
    return _told(name, value) or f"{parameter(name).symbol} = {parameter(name).text(value)}"


def words_text(name: str, value: Any) -> str:
    """Return words and value, for captions: ``normal load 25 N``, ``elastic``."""
    return _told(name, value) or f"{parameter(name).words} {parameter(name).text(value)}"


def _told(name: str, value: Any) -> str:
    """Return what stands for a value by itself: a part in short, ``elastic``; else nothing."""
    return _part_text(name, value) or parameter(name).word_for(value)


@cache
def _by_coordinate(of_kinds: tuple[tuple[type[Part], ...], ...]) -> Mapping[str, Parameter]:
    del of_kinds
    found: dict[str, Parameter] = {}
    for several in leaves().values():
        for leaf in several:
            found.setdefault(coordinate(leaf.name), leaf.parameter)
            # Of two values, each has a coordinate of its own.
            for value in ((1.0, 2.0), 1.0):
                try:
                    found |= {
                        n: p for n, p, _ in leaf.parameter.coordinates(coordinate(leaf.name), value)
                    }
                except TypeError:
                    continue
    for member, about in members().items():
        if isinstance(about, Member) and not about.inline:
            found.setdefault(member, kind_name(member, kinds(member)))
            for kind in kinds(member):
                own = derived_of(member, kind).items()
                found |= {f"{member}_{name}": each for name, each in own}
    return {**found, **derived(CaseTree)}


def _part_text(name: str, value: Any) -> str:
    """Return a whole part in short that is given as text: ``{kind: wavy, amplitude: 0.3 um}``."""
    about = members().get(name)
    if not isinstance(about, Member) or not isinstance(value, str):
        return ""
    if value == "none":
        return about.none
    parts = [
        f"{leaf.parameter.symbol.replace('$', '').replace('_', '')} = {match[1]}"
        for kind in kinds(name)
        for leaf in leaves_of(kind)
        if leaf.member == name and (match := re.search(rf"\b{leaf.field}: ([^,}}]+)", value))
    ]
    text = ", ".join(dict.fromkeys(parts))
    return re.sub(r"\bum\b", "µm", text.replace(" deg", "°"))
