"""Published properties of materials, and published wear coefficients, each with its source.

``material: Ti-6Al-4V`` in a study file is short for the elastic constants of the table and, where
its hardness is known, for the plastic limit.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping
from functools import cache
from importlib.resources import files

from fretwear.parts import is_list
from fretwear.problems import Problems
from fretwear.units import listed

MATERIAL = "material"
PROPERTIES = ("youngs_modulus", "poisson_ratio")
DESCRIPTION = (
    "A material of the table, or a pair [body I, body II]: short for youngs_modulus and "
    "poisson_ratio and, where the table has a hardness, for plastic_limit, unless these are given."
)


@cache
def read_table(name: str) -> tuple[Mapping[str, str], ...]:
    """The rows of a table of the package, ``materials`` or ``coefficients``, by column."""
    text = files("fretwear.study").joinpath(f"{name}.csv").read_text(encoding="utf-8")
    return tuple(csv.DictReader(text.splitlines()))


@cache
def material_table() -> Mapping[str, Mapping[str, str]]:
    """The rows of the table of materials by their names."""
    return {row[MATERIAL]: row for row in read_table("materials")}


def with_materials(
    given: Mapping[str, object], problems: Problems, prefix: str = "", varied: Iterable[str] = ()
) -> dict[str, object]:
    """Return keys of a case with the properties of `material` in its place, unless given.

    An unknown name is a problem, and so is a material all of whose properties are given too.
    """
    if MATERIAL not in given:
        return dict(given)
    value, table = given[MATERIAL], material_table()
    pair = value if is_list(value) and len(value) == 2 else ()
    names = [*pair] or [value]
    rows = []
    for position, name in enumerate(names):
        listed_as = {row.casefold(): row for row in table}.get(str(name).casefold())
        rows.append(table[listed_as or next(iter(table))])
        if listed_as is None:
            rule = "must be a material of the table, or a pair of them"
            remedy = "give youngs_modulus and poisson_ratio"
            place = f"{prefix}{MATERIAL}{f'[{position}]' if pair else ''}"
            rule = "is not in the table of materials" if pair else rule
            problems.add(place, name, rule, remedy, valid_words=(*table,), written=str(name))
    columns = {name: [row[name] for row in rows] for name in PROPERTIES}
    constants: dict[str, object] = {n: v if len(v) == 2 else v[0] for n, v in columns.items()}
    if all(row["hardness"] for row in rows):
        constants["plastic_limit"] = min(
            (row["hardness"] for row in rows), key=lambda text: float(text.split()[0])
        )
    others = {name: other for name, other in given.items() if name != MATERIAL}
    if constants.keys() <= {*others, *varied}:
        rule = f"has no effect: {listed([*constants])} are given too"
        problems.add(
            f"{prefix}{MATERIAL}", value, rule, "leave out material, or what it stands for"
        )
    return {**{n: v for n, v in constants.items() if n not in varied}, **others}
