"""Blocks of loading one after the other, as a parameter of a case."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from fretwear.parts import Parameter, Plain, Quantity, WholeNumber, is_list
from fretwear.study.problems import Problems, read_fields
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
        problems, found = Problems(), list[Block]()
        for position, each in enumerate(value):
            with problems.at(f"[{position}]", each):
                block = each if isinstance(each, Block) else self._block(each, units_required)
                if found and found[-1].values == block.values:
                    block = Block(found.pop().cycles + block.cycles, block.values)
                found.append(block)
        problems.raise_any()
        return tuple(found)

    def _block(self, raw: object, units_required: bool) -> Block:
        if not isinstance(raw, Mapping):
            raise QuantityError("must be a block", self.example)
        rule = "is a key which a block cannot change"
        read = read_fields(raw, self._fields, (_CYCLES,), units_required, rule)
        return Block(read.pop(_CYCLES), tuple(sorted(read.items())))

    @property
    def _fields(self) -> Mapping[str, Parameter]:
        return {_CYCLES: self.number, **self.known()}

    def schema(self) -> dict[str, Any]:
        """JSON Schema of the value in a study file."""
        block = {
            "type": "object",
            "additionalProperties": False,
            "required": [_CYCLES],
            "properties": {name: about.schema() for name, about in self._fields.items()},
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
        if isinstance(value, str) or not value:
            return value or "none"
        known = self.known()
        return ", then ".join(
            f"{block.cycles} cycles"
            + "".join(f", {known[name].symbol} = {known[name].text(v)}" for name, v in block.values)
            for block in value
        ).replace("$", "")
