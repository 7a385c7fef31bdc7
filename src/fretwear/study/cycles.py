"""The cycles of a case: blocks of loading, sliding distances, and snapshots of the fields."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Annotated, Any, get_type_hints

from pydantic import BaseModel, ConfigDict, Field, GetCoreSchemaHandler, create_model
from pydantic_core import core_schema

from fretwear.mechanics.surfaces.loading import Loading
from fretwear.mechanics.surfaces.materials import Friction
from fretwear.mechanics.surfaces.pressing import Normal
from fretwear.quantity import (
    AUTO,
    Coordinates,
    Inline,
    Parameter,
    Part,
    Plain,
    auto_or,
    whole_number,
)

MAX_CYCLES = 10**9
_SNAPSHOTS = 8
_SNAPSHOT = whole_number("$N$", "cycle", 0, MAX_CYCLES, 1000)
CYCLES = whole_number("$N$", "number of cycles", 1, MAX_CYCLES, 30000)
_CHANGEABLE: tuple[type[Part], ...] = (Normal, Loading, Friction)

Snapshots = Annotated[
    tuple[Annotated[int, _SNAPSHOT], ...] | None,
    AUTO,
    auto_or({"type": "array", "items": {"type": ["integer", "string"]}}),
    Field(
        json_schema_extra={"default": "auto"},
        description="Cycles of the fields, besides 0 and the last; auto: about eight, evenly "
        "spaced in the logarithm.",
    ),
]


class Block(BaseModel):
    """A number of cycles with other values of some parameters, in SI units."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    cycles: Annotated[int, CYCLES]

    @property
    def values(self) -> dict[str, object]:
        """The values that the block changes, by the names of their keys."""
        changed = self.model_fields_set - {"cycles"}
        return {name: value for name, value in vars(self).items() if name in changed}


class Blocks(Plain):
    """A list of blocks."""

    def __get_pydantic_core_schema__(
        self, source: object, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        kinds = [kind for family in _CHANGEABLE for kind in family.kinds().values()]
        hints = ((kind, get_type_hints(kind, include_extras=True)) for kind in kinds)
        fields: dict[str, Any] = {
            name: (types[name], None) for kind, types in hints for name in kind.parameters()
        }
        block = create_model("Block", __base__=Block, **fields)
        return handler.generate_schema(tuple[block, ...])  # type: ignore[valid-type]

    @property
    def fields(self) -> dict[str, Parameter]:
        """The parameters that a block may have, by name."""
        return {n: key for family in _CHANGEABLE for n, key in Inline(family).keys.items()}

    def canonical(self, value: Sequence[Block]) -> object:
        """Return a list of mappings."""
        fields = self.fields
        return [
            {"cycles": block.cycles, **{n: fields[n].canonical(v) for n, v in block.values.items()}}
            for block in value
        ]

    def coordinates(self, name: str, value: Sequence[Block]) -> Coordinates:
        """Yield the blocks as text, if there are any."""
        if value:
            yield name, self.text(value)

    def text(self, value: Sequence[Block] | str) -> str:
        """Return the blocks in words."""
        if isinstance(value, str) or not value:
            return str(value or "none")
        fields = self.fields
        return ", then ".join(
            f"{block.cycles} cycles"
            + "".join(
                f", {fields[n].symbol} = {fields[n].text(v)}" for n, v in block.values.items()
            )
            for block in value
        ).replace("$", "")


@lru_cache(64)
def snapshots_of(asked: tuple[int, ...] | None, cycles: int) -> tuple[int, ...]:
    """Return the snapshots in order, each once, with cycle 0 and the last among them.

    By default these are the powers of ten and, up to eight in all, the largest of three times them.
    """
    if asked is None:
        powers = [10**n for n in range(len(str(cycles))) if 10**n < cycles]
        intermediate = [3 * power for power in reversed(powers) if 3 * power < cycles]
        asked = (*powers, *intermediate[: max(0, _SNAPSHOTS - 2 - len(powers))])
    return tuple(sorted({0, cycles, *asked}))
