"""Published properties of materials, and published wear coefficients, each with its source.

``material: Ti-6Al-4V`` in a study file stands for the elastic constants of the table and, if its
hardness is known, for the plastic limit.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import Annotated

from pydantic import PlainValidator, WithJsonSchema

from fretwear.quantity import Schema, each, is_list
from fretwear.units import QuantityError, did_you_mean, listed

MATERIAL = "material"
PROPERTIES = ("youngs_modulus", "poisson_ratio")
# Names of the same steel in other standards.
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


def row_of(name: object) -> Mapping[str, str] | None:
    """The row of a material by its name in any standard; None if there is none.

    Capitals tell TiN from tin: where they do, only the first one is free.
    """
    alike = _alike(name)
    if len(alike) > 1:
        alike = [row for row in alike if str(name) in (row, row[0].upper() + row[1:])]
    found = alike[0] if alike else _ALSO.get(str(name).casefold(), "")
    return material_table().get(found)


def _alike(name: object) -> list[str]:
    """The materials whose names differ from a name in capitals at most."""
    return [row for row in material_table() if row.casefold() == str(name).casefold()]


def _known(name: object) -> object:
    if row_of(name) is None:
        rule = "must be a material of the table, or a pair of them"
        asked, table = str(name).casefold(), material_table()
        alike = _alike(name) or [row for row in table if asked in row.casefold()]
        hint = did_you_mean(name, [*table, "100Cr6"]) or "fretwear schema lists them"
        if alike:
            hint = f"did you mean {listed(map(repr, alike), 'or')}?"
        raise QuantityError(rule, hint)
    return name


def _read(value: object) -> object:
    return each(value, _known) if is_list(value) and len(value) == 2 else _known(value)


def _schema() -> Schema:
    name = {"enum": [*material_table(), *(int(n) for n in material_table() if n.isdigit())]}
    return {
        "description": "A material of the table, or a pair [body I, body II]: short for "
        "youngs_modulus and poisson_ratio and, where the table has a hardness, for plastic_limit, "
        "unless these are given.",
        "anyOf": [name, {"type": "array", "items": name, "minItems": 2, "maxItems": 2}],
    }


Material = Annotated[object, PlainValidator(_read), WithJsonSchema(_schema())]
