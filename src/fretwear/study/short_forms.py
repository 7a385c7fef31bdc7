"""Keys that stand for others: a material, a sliding distance, varied fields of parts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from fretwear.quantity import is_list
from fretwear.study.materials import MATERIAL, PROPERTIES, row_of

PARTS_OF_A_DISTANCE = 1000


def long_form(base: Mapping[str, object], vary: Mapping[str, object]) -> dict[str, object]:
    """Return the plain keys of `base`, completed by the keys that short forms stand for.

    Keys given or varied are not replaced. A part with varied fields has their first values.
    """
    full = _with_constants({**base}, vary)
    names = {*full, *vary}
    if "sliding_distance" in names and not names & {"cycles", "blocks"}:
        full["cycles"] = PARTS_OF_A_DISTANCE
    for name, values in vary.items():
        whole, _, field = name.partition(".")
        if field and whole not in vary:
            written = full.get(whole, {})
            part = {"kind": written} if isinstance(written, str) else written
            ends = values.get("from") if isinstance(values, Mapping) else values
            first = ends[0] if is_list(ends) and ends else ends
            full[whole] = {**part, field: first} if isinstance(part, Mapping) else written
    return full


def _with_constants(base: dict[str, object], vary: Iterable[str]) -> dict[str, object]:
    """The keys with the elastic constants of a known material and, if known, its hardness."""
    material = base.get(MATERIAL)
    rows = [row_of(name) for name in (material if is_list(material) else [material])]
    known = [row for row in rows if row is not None]
    if len(known) < len(rows):
        return base
    columns = {name: [row[name] for row in known] for name in PROPERTIES}
    constants: dict[str, object] = {n: v if len(v) == 2 else v[0] for n, v in columns.items()}
    if all(row["hardness"] for row in known):
        softest = min(known, key=lambda row: float(row["hardness"].split()[0]))
        constants["plastic_limit"] = softest["hardness"]
    return {**{name: value for name, value in constants.items() if name not in vary}, **base}
