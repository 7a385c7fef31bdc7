"""Values of several numbers: over the cycles, and of indenter and flat."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from fretwear.forms import Either, Mapped, Several
from fretwear.parts import Coordinates, Parameter, Quantity, QuantityError, WholeNumber, is_list
from fretwear.problems import Problems, in_words

_CYCLE = WholeNumber("$N$", "cycle", 0, 10**9, 500)


@dataclass(frozen=True)
class OverCycles:
    """A value that changes over the cycles: linear between its points, constant after the last.

    The first point is at cycle 0; its value is the ``float`` of the table.
    """

    cycles: tuple[float, ...]
    values: tuple[float, ...]

    def __post_init__(self) -> None:
        """Raise a `QuantityError` for an invalid table."""
        vars(self)["cycles"] = tuple(map(float, self.cycles))
        if len(self.cycles) != len(self.values):
            rule = f"has {len(self.cycles)} cycles and {len(self.values)} values"
            raise QuantityError(rule, "give a value for each cycle")
        problems = Problems()
        if self.cycles[0] != 0.0:
            hint = "list the cycles, with their values, in ascending order"
            rule, hint = "must be 0, where a table starts", hint if 0.0 in self.cycles else ""
            problems.add(".cycles[0]", f"{self.cycles[0]:g}", rule, hint)
        for position, (before, cycle) in enumerate(pairwise(self.cycles), start=1):
            if cycle <= before:
                rule = "must be larger than the cycle before"
                problems.add(f".cycles[{position}]", f"{cycle:g}", rule)
        del problems[1:]  # the others follow from the first
        problems.raise_any()

    @classmethod
    def of(cls, quantity: Quantity) -> Either:
        """Return the parameter: a quantity, or a mapping of cycles and its values there."""
        return Either(quantity, (_Table(cls, quantity),))

    def at(self, cycle: float) -> float:
        """The value at a cycle."""
        return float(np.interp(cycle, self.cycles, self.values))

    def __float__(self) -> float:
        return self.values[0]

    def __str__(self) -> str:
        """``0.2 at cycle 0, 0.6 at 500``."""
        points = (f"{v:g} at {n:g}" for n, v in zip(self.cycles, self.values, strict=True))
        return ", ".join(points).replace(" at 0", " at cycle 0", 1)


@dataclass(frozen=True)
class _Table(Mapped):
    """Cycles and values; its coordinate is a text."""

    quantity: Quantity

    def takes(self, value: object) -> bool:
        """Whether a value is a table, or a list of pairs, which is refused with the table meant."""
        return super().takes(value) or (is_list(value) and bool(value) and all(map(is_list, value)))

    @property
    def fields(self) -> Mapping[str, Parameter]:
        return {"cycles": Several(_CYCLE), "values": Several(self.quantity)}

    def read(self, value: object, units_required: bool) -> float | OverCycles:
        """Return a float if all values are equal."""
        if is_list(value):
            columns = [in_words([*column]) for column in zip(*value, strict=False)]
            meant = (
                "{{cycles: {}, values: {}}}".format(*columns) if len(columns) == 2 else "a table"
            )
            raise QuantityError(f"{self.quantity.dimension.expectation}", f"write {meant}")
        table: OverCycles = super().read(value, units_required)
        return table if len(set(table.values)) > 1 else table.values[0]

    def coordinates(self, name: str, value: OverCycles | None) -> Coordinates:
        words = f"{name} over the cycles"
        yield f"{name}_over_cycles", Quantity("1", words, words), str(value)


class OfBodies(tuple[float, float]):
    """The contributions of indenter and flat, one of which may be 0; its ``float`` is their sum."""

    __slots__ = ()

    @classmethod
    def of(
        cls, single: Parameter, *others: Parameter, together: tuple[Parameter, ...] = ()
    ) -> Either:
        """Return the parameter: one value for both bodies, [indenter, flat], or another form.

        The ``others`` are forms for both bodies or for one, the last those for both ``together``.
        """
        places = (("indenter", "of the indenter"), ("flat", "of the flat"))
        expected = "one value for both bodies together, or two: [indenter, flat]"
        item = _or_none(single)
        item = Either(item, others) if others else item
        return Either(single, (_EachBody(item, places, expected, cls), *others, *together))

    def __float__(self) -> float:
        return sum(map(float, self))

    @property
    def shares(self) -> tuple[float, float]:
        """Fractions of indenter and flat in the sum."""
        indenter, flat = map(float, self)
        return indenter / float(self), flat / float(self)


def _or_none(parameter: Parameter) -> Parameter:
    """The parameter of a positive value, which may be 0 too."""
    if isinstance(parameter, Either):
        return replace(parameter, single=_or_none(parameter.single))
    if isinstance(parameter, Quantity) and parameter.above == 0.0:
        return replace(parameter, above=None, at_least=0.0)
    return parameter


@dataclass(frozen=True)
class _EachBody(Several):
    """A value for each body, not 0 for both."""

    def read(self, value: object, units_required: bool) -> OfBodies:
        values: OfBodies = super().read(value, units_required)  # type: ignore[assignment]
        if not float(values) > 0.0:
            raise QuantityError("must be larger than 0 for one body at least")
        return values
