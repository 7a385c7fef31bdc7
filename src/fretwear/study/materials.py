"""Published properties of materials, and published wear coefficients, each with its source.

``material: Ti-6Al-4V`` in a study file is short for the elastic constants of the table and, where
its hardness is known, for the plastic limit.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping
from functools import cache
from importlib.resources import files

from fretwear.quantity import is_list
from fretwear.study.problems import Problems
from fretwear.units import QuantityError, did_you_mean

MATERIAL = "material"
PROPERTIES = ("youngs_modulus", "poisson_ratio")
DESCRIPTION = (
    "A material of the table, or a pair [body I, body II]: short for youngs_modulus and "
    "poisson_ratio and, where the table has a hardness, for plastic_limit, unless these are given."
)


# Names of other standards, by which people know the same steel.
_ALSO = dict.fromkeys(("100cr6", "aisi 52100", "suj2", "en31", "gcr15"), "52100")


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
    given: Mapping[str, object], problems: Problems, varied: Iterable[str] = ()
) -> dict[str, object]:
    """Return keys of a case with the properties of `material` in its place, unless given.

    An unknown name is a problem.
    """
    if MATERIAL not in given:
        return dict(given)
    value, table = given[MATERIAL], material_table()
    pair = value if is_list(value) and len(value) == 2 else ()
    names = {row.casefold(): row for row in table} | _ALSO
    rows = []
    for position, name in enumerate([*pair] or [value]):
        row = table.get(names.get(str(name).casefold(), ""))
        place = f"{MATERIAL}{f'[{position}]' if pair else ''}"
        if row is None:
            with problems.at(place, name):
                rule = "must be a material of the table, or a pair of them"
                raise QuantityError(rule, did_you_mean(name, [*table, "100Cr6"]))
        rows.append(row or next(iter(table.values())))
    columns = {name: [row[name] for row in rows] for name in PROPERTIES}
    constants: dict[str, object] = {n: v if len(v) == 2 else v[0] for n, v in columns.items()}
    if all(row["hardness"] for row in rows):
        constants["plastic_limit"] = min(
            (row["hardness"] for row in rows), key=lambda text: float(text.split()[0])
        )
    others = {name: other for name, other in given.items() if name != MATERIAL}
    return {**{n: v for n, v in constants.items() if n not in varied}, **others}
