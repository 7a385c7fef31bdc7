"""Blocks of loading one after the other, as a parameter of a case."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from fretwear.parts import Parameter, Plain, Quantity, WholeNumber, is_list
from fretwear.units import QuantityError

_CYCLES = "cycles"


@dataclass(frozen=True)
class Block:
    """So many cycles with other values of some parameters, in SI units."""

    cycles: int
    values: tuple[tuple[str, Any], ...] = ()


@dataclass(frozen=True)
class Blocks(Plain):
    """A list of blocks; blocks of the same values that follow each other are one."""

    known: Callable[[], Mapping[str, Parameter]]  # what a block may change, by name
    number: WholeNumber  # of cycles

    @property
    def example(self) -> str:
        """A sensible value as a study file would have it."""
        return "[{cycles: 2000, tangential_ratio: 0.5}, {cycles: 5000, tangential_ratio: 0.9}]"

    def read(self, value: object, units_required: bool) -> tuple[Block, ...]:
        """Return the blocks."""
        if not is_list(value) or not value:
            raise QuantityError("must be a list of blocks", self.example)
        found: list[Block] = []
        for position, each in enumerate(value, start=1):
            block = each if isinstance(each, Block) else self._block(each, position, units_required)
            if found and found[-1].values == block.values:
                block = Block(found.pop().cycles + block.cycles, block.values)
            found.append(block)
        return tuple(found)

    def _block(self, raw: object, position: int, units_required: bool) -> Block:
        if not isinstance(raw, Mapping) or _CYCLES not in raw:
            raise QuantityError(f"has a block number {position} without cycles", self.example)
        known, read = {_CYCLES: self.number, **self.known()}, {}
        for name, value in raw.items():
            if name not in known:
                rule = f"has {name} in block {position}, which a block cannot change"
                raise QuantityError(rule, f"a block may have {', '.join(known)}")
            try:
                read[name] = known[name].read(value, units_required)
            except QuantityError as error:
                rule = f"has {name} = {value} in block {position}, which {error.rule}"
                raise QuantityError(rule, error.hint) from error
        return Block(read.pop(_CYCLES), tuple(sorted(read.items())))

    def schema(self) -> dict[str, Any]:
        """JSON Schema of the value in a study file."""
        known = {_CYCLES: self.number, **self.known()}
        block = {
            "type": "object",
            "additionalProperties": False,
            "required": [_CYCLES],
            "properties": {name: about.schema() for name, about in known.items()},
        }
        return {"type": "array", "minItems": 1, "items": block}

    def canonical(self, value: Any) -> Any:
        """Return a list of mappings."""
        known = self.known()
        return [
            {_CYCLES: each.cycles, **{name: known[name].canonical(v) for name, v in each.values}}
            for each in value
        ]

    def coordinates(self, name: str, value: Any) -> Iterator[tuple[str, Parameter, float | str]]:
        """Yield the blocks as text, if there are any."""
        if not (isinstance(value, tuple) and all(isinstance(each, Block) for each in value)):
            raise TypeError("not blocks")
        if value:
            yield name, Quantity("1", name, self.words), self.text(value)

    def text(self, value: Any) -> str:
        """Return the blocks for people."""
        if isinstance(value, str):
            return value
        known = self.known()
        return ", then ".join(
            f"{block.cycles} cycles"
            + "".join(f", {known[name].symbol} = {known[name].text(v)}" for name, v in block.values)
            for block in value
        ).replace("$", "")
