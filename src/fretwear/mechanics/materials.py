"""The bodies and the friction between them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Annotated, Any, Literal

import numpy as np

from fretwear.parts import (
    Parameter,
    Part,
    PerBody,
    Quantity,
    QuantityError,
    WholeNumber,
    is_list,
    keys_schema,
    pair,
)
from fretwear.theory import composite_modulus, coupling_ratio


class Bodies(Part):
    """The elastic bodies, represented by one half-space."""

    @property
    def composite_modulus(self) -> float:
        """E* in Pa."""
        raise NotImplementedError

    @property
    def coupling(self) -> float:
        """κ = E*/G*, tangential compliance relative to the normal one."""
        raise NotImplementedError

    def coupling_weighing(self, weight: float) -> float:  # noqa: ARG002 - where one is all there is
        """κ in a contact in which Poisson's ratio has a given weight, 1/2 for a circle."""
        return self.coupling


@dataclass(frozen=True)
class ElasticBodies(Bodies):
    """Two isotropic elastic bodies, of the same or different materials.

    The coupling of normal pressure and tangential displacement between different materials
    (Dundurs' β) is neglected.
    """

    youngs_modulus: Annotated[
        float | tuple[float, float],
        PerBody("Pa", "$E$", "Young's modulus", "GPa", above=0.0),
        "Young's modulus E, or a pair [body I, body II].",
    ]
    poisson_ratio: Annotated[
        float | tuple[float, float],
        PerBody("1", "$ν$", "Poisson's ratio", above=-1.0, at_most=0.5),
        "Poisson's ratio, or a pair [body I, body II].",
    ]
    kind: Literal["elastic"] = "elastic"

    @property
    def _constants(self) -> tuple[float, float, float, float]:
        moduli, ratios = pair(self.youngs_modulus), pair(self.poisson_ratio)
        return moduli[0], ratios[0], moduli[1], ratios[1]

    @cached_property
    def composite_modulus(self) -> float:
        """E* in Pa, from 1/E* = (1−ν1²)/E1 + (1−ν2²)/E2."""
        return composite_modulus(*self._constants)

    @cached_property
    def coupling(self) -> float:
        """κ = E*/G*, with 1/G* = (2−ν1)/(4G1) + (2−ν2)/(4G2)."""
        return coupling_ratio(*self._constants)

    def coupling_weighing(self, weight: float) -> float:
        """κ in a contact in which Poisson's ratio has a given weight, 1/2 for a circle."""
        return coupling_ratio(*self._constants, weight)

    @property
    def slug(self) -> str:
        """Materials are left out of the id."""
        return ""


@dataclass(frozen=True)
class Course:
    """A value that changes over the cycles: linear between its points, constant after the last.

    The first point is at cycle 0.
    """

    cycles: tuple[float, ...]
    values: tuple[float, ...]

    def at(self, cycle: float) -> float:
        """The value at a cycle."""
        return float(np.interp(cycle, self.cycles, self.values))


@dataclass(frozen=True)
class OverCycles(Quantity):
    """A quantity, or a mapping of cycles and its values there."""

    def read(self, value: object, units_required: bool) -> Any:
        """Return a float, or a `Course` if values differ."""
        if isinstance(value, Course):
            return value
        if not isinstance(value, Mapping):
            return super().read(value, units_required)
        example = f"{{cycles: [0, 500], values: [{self.example}, {self.example}]}}"
        lists = [value.get(name) for name in ("cycles", "values")]
        if len(value) != 2 or not all(is_list(each) and each for each in lists):
            raise QuantityError("must be a value, or a mapping of cycles and values", example)
        cycles, values = ([*each] for each in lists if is_list(each))
        if len(cycles) != len(values):
            rule = f"has {len(cycles)} cycles and {len(values)} values"
            raise QuantityError(rule, "give a value for each cycle")
        numbers = [_CYCLE.read(each, units_required) for each in cycles]
        if numbers[0] != 0:
            raise QuantityError(f"starts at cycle {cycles[0]}", "the first cycle must be 0")
        if any(later <= earlier for earlier, later in pairwise(numbers)):
            raise QuantityError("has cycles that do not increase", example)
        read = tuple(float(super(OverCycles, self).read(each, units_required)) for each in values)
        return read[0] if len(set(read)) == 1 else Course(tuple(map(float, numbers)), read)

    def schema(self) -> dict[str, Any]:
        """JSON Schema of the value in a study file."""
        each = {"cycles": _CYCLE.schema(), "values": (one := super().schema())}
        lists = {n: {"type": "array", "minItems": 1, "items": items} for n, items in each.items()}
        return {"anyOf": [one, keys_schema(lists, [*lists])]}

    def canonical(self, value: Any) -> Any:
        """Return the value, or the mapping."""
        if isinstance(value, Course):
            return {"cycles": list(value.cycles), "values": list(value.values)}
        return super().canonical(value)

    def coordinates(self, name: str, value: Any) -> Iterator[tuple[str, Parameter, float | str]]:
        """Yield the value, or that at cycle 0 and the table as text."""
        if not isinstance(value, Course):
            yield name, self, value
            return
        yield name, self, value.values[0]
        table = f"{name} over the cycles"
        yield f"{name}_over_cycles", Quantity("1", table, table), course_text(value)

    def text(self, value: Any) -> str:
        """Return the value, or the table, for people."""
        return course_text(value) if isinstance(value, Course) else super().text(value)


_CYCLE = WholeNumber("$N$", "cycle", 0, 10**9, 500)


def course_text(course: Course) -> str:
    """``0.2 at cycle 0, 0.6 at 500``."""
    points = [f"{value:g} at {n:g}" for n, value in zip(course.cycles, course.values, strict=True)]
    return ", ".join(points).replace(" at 0", " at cycle 0", 1)


class Friction(Part):
    """The law for the tangential traction of slipping cells."""

    @property
    def coefficient(self) -> float:
        """Coefficient of friction µ, at cycle 0 where it changes."""
        raise NotImplementedError

    @property
    def least(self) -> float:
        """Smallest coefficient of all cycles."""
        return self.coefficient

    def at(self, cycle: float) -> Friction:  # noqa: ARG002 - constant unless a kind says otherwise
        """The friction of a cycle."""
        return self

    @property
    def kinks(self) -> tuple[float, ...]:
        """Cycles at which the coefficient does not change smoothly."""
        return ()


@dataclass(frozen=True)
class Coulomb(Friction):
    """A coefficient of friction, constant or given over the cycles."""

    friction: Annotated[
        float | Course,
        OverCycles("1", "$µ$", "coefficient of friction", like="0.5", above=0.0),
        "Coefficient of friction µ; or {cycles: [0, 500], values: [0.2, 0.6]}, "
        "linear between these cycles.",
    ]
    kind: Literal["coulomb"] = "coulomb"

    @property
    def _values(self) -> tuple[float, ...]:
        return self.friction.values if isinstance(self.friction, Course) else (self.friction,)

    @property
    def coefficient(self) -> float:
        """Coefficient of friction µ, at cycle 0 where it changes."""
        return self._values[0]

    @property
    def least(self) -> float:
        """Smallest coefficient of all cycles."""
        return min(self._values)

    @property
    def kinks(self) -> tuple[float, ...]:
        """Cycles at which the coefficient does not change smoothly."""
        return self.friction.cycles if isinstance(self.friction, Course) else ()

    def at(self, cycle: float) -> Friction:
        """The friction of a cycle."""
        if not isinstance(self.friction, Course):
            return self
        return Coulomb.unchecked(friction=self.friction.at(cycle))

    @property
    def slug(self) -> str:
        """``mu0.5``, ``mu0.2to0.6``."""
        first, *later = self._values
        return f"mu{first:.4g}" + (f"to{later[-1]:.4g}" if later else "")
