"""How the parameters of a case are written for people, by the names of files and datasets."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from functools import cache
from typing import Any

from fretwear.parts import Parameter, Part, Quantity, derived
from fretwear.study.members import PartOf
from fretwear.study.names import kinds_of_parts, leaves
from fretwear.study.tree import CaseTree, members


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
        for value in ((1.0, 2.0), 1.0):
            with suppress(TypeError):
                found |= {n: p for n, p, _ in leaf.parameter.coordinates(name, value)}
    for member, about in members().items():
        if isinstance(about, PartOf):
            found.setdefault(member, about)
            for kind in about.kinds.values():
                following = about.derived(kind).items()
                found |= {f"{member}_{name}": each for name, each in following}
    return {**found, **derived(CaseTree)}
