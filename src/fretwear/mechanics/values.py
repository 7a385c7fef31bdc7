"""Values of several numbers: over the cycles, and of indenter and flat."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any

import numpy as np
from pydantic.dataclasses import dataclass

from fretwear.quantity import (
    Coordinates,
    Quantity,
    each,
    located,
    whole_number,
)
from fretwear.units import QuantityError

_CYCLE = whole_number("$N$", "cycle", 0, 10**9, 500)


@dataclass(frozen=True)
class OverCycles:
    """A value that changes over the cycles: linear between its points, constant after the last.

    The first point is at cycle 0; its value is the ``float`` of the table.
    """

    cycles: tuple[Annotated[float, _CYCLE], ...]
    values: tuple[Any, ...]

    def __post_init__(self) -> None:
        """Raise an error for an invalid table."""
        vars(self)["cycles"] = tuple(map(float, self.cycles))
        if len(self.cycles) != len(self.values) or not self.cycles:
            rule = f"has {len(self.cycles)} cycles and {len(self.values)} values"
            raise QuantityError(rule, "give a value for each cycle")
        if self.cycles[0] != 0.0:
            raise located("cycles", self.cycles[0], QuantityError("must begin with 0"))
        if any(later <= earlier for earlier, later in pairwise(self.cycles)):
            raise located("cycles", self.cycles, QuantityError("must ascend"))

    def read_by(self, quantity: Quantity, folder: object) -> float | OverCycles:
        """The table with its values read, in SI units; a float if all are equal."""
        values = each(self.values, lambda one: quantity.read(one, folder))
        return OverCycles(self.cycles, tuple(values)) if len(set(values)) > 1 else values[0]

    def at(self, cycle: float) -> float:
        """The value at a cycle."""
        return float(np.interp(cycle, self.cycles, self.values))

    def __float__(self) -> float:
        return float(self.values[0])

    def __str__(self) -> str:
        """``0.2 at cycle 0, 0.6 at 500``."""
        points = (f"{v:g} at {n:g}" for n, v in zip(self.cycles, self.values, strict=True))
        return ", ".join(points).replace(" at 0", " at cycle 0", 1)

    def canonical(self) -> dict[str, object]:
        """The table in a form that JSON can hold."""
        return {"cycles": [*self.cycles], "values": [*self.values]}

    def coordinates(self, name: str) -> Coordinates:
        """Yield the table as text."""
        yield f"{name}_over_cycles", str(self)


class OfBodies(tuple[Any, ...]):
    """The contributions of indenter and flat, one of which may be 0; its ``float`` is their sum."""

    __slots__ = ()

    def __float__(self) -> float:
        return float(sum(map(float, self)))

    @property
    def shares(self) -> tuple[float, float]:
        """Fractions of indenter and flat in the sum; halves where both are 0."""
        indenter, flat = map(float, self)
        total = indenter + flat
        return (indenter / total, flat / total) if total else (0.5, 0.5)
