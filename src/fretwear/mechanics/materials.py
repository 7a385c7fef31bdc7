"""What the bodies are made of: elasticity, the friction between them, laws for their wear."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Annotated, Any, Literal, Protocol

import numpy as np

from fretwear.parts import (
    Parameter,
    Part,
    PerBody,
    Quantity,
    QuantityError,
    WholeNumber,
    declared,
    is_list,
    keys_schema,
    pair,
)
from fretwear.theory import composite_modulus, coupling_ratio


class Bodies(Part):
    """The elastic bodies, represented by one half-space."""

    composite_modulus: float  # E*, Pa
    coupling: float  # κ = E*/G*, tangential compliance relative to the normal one
    dundurs_beta = 0.0  # |β|, which couples normal and tangential directions; neglected

    def coupling_weighing(self, weight: float) -> float:  # noqa: ARG002 - where one is all there is
        """κ in a contact in which Poisson's ratio has a given weight, 1/2 for a circle."""
        return self.coupling


@dataclass(frozen=True)
class ElasticBodies(Bodies):
    """Two isotropic elastic bodies, of the same or different materials.

    The couplings between normal and tangential directions of different materials (Dundurs' β) are
    neglected: pressure drags such bodies over each other, which cycles under a constant load
    forget, and friction moves them apart.
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

    slug = ""  # materials are left out of the id

    @property
    def _constants(self) -> tuple[float, float, float, float]:
        moduli, ratios = pair(self.youngs_modulus), pair(self.poisson_ratio)
        return moduli[0], ratios[0], moduli[1], ratios[1]

    @cached_property
    def composite_modulus(self) -> float:  # type: ignore[override]
        """E* in Pa, from 1/E* = (1−ν1²)/E1 + (1−ν2²)/E2."""
        return composite_modulus(*self._constants)

    @cached_property
    def coupling(self) -> float:  # type: ignore[override]
        """κ = E*/G*, with 1/G* = (2−ν1)/(4G1) + (2−ν2)/(4G2)."""
        return coupling_ratio(*self._constants)

    def coupling_weighing(self, weight: float) -> float:
        """κ in a contact in which Poisson's ratio has a given weight, 1/2 for a circle."""
        return coupling_ratio(*self._constants, weight)

    @property
    def dundurs_beta(self) -> float:  # type: ignore[override]
        """½ |(1−2ν1)/G1 − (1−2ν2)/G2| / ((1−ν1)/G1 + (1−ν2)/G2), 0 for equal bodies."""
        modulus1, nu1, modulus2, nu2 = self._constants
        first, second = (1.0 + nu1) / modulus1, (1.0 + nu2) / modulus2
        difference = abs((1.0 - 2.0 * nu1) * first - (1.0 - 2.0 * nu2) * second)
        return 0.5 * difference / ((1.0 - nu1) * first + (1.0 - nu2) * second)


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

    def __str__(self) -> str:
        """``0.2 at cycle 0, 0.6 at 500``."""
        points = (f"{v:g} at {n:g}" for n, v in zip(self.cycles, self.values, strict=True))
        return ", ".join(points).replace(" at 0", " at cycle 0", 1)


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
        varies = isinstance(value, Course)
        yield name, self, value.values[0] if varies else value
        if varies:
            table = f"{name} over the cycles"
            yield f"{name}_over_cycles", Quantity("1", table, table), str(value)

    def text(self, value: Any) -> str:
        """Return the value, or the table, for people."""
        return str(value) if isinstance(value, Course) else super().text(value)


_CYCLE = WholeNumber("$N$", "cycle", 0, 10**9, 500)


class Friction(Part):
    """The law for the tangential traction of slipping cells."""

    coefficient: float  # coefficient of friction µ, at cycle 0 where it changes
    least: float  # smallest coefficient of all cycles


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
    def _course(self) -> Course:
        value = self.friction
        return value if isinstance(value, Course) else Course((), (value,))

    @property
    def coefficient(self) -> float:  # type: ignore[override]
        """Coefficient of friction µ, at cycle 0 where it changes."""
        return self._course.values[0]

    @property
    def least(self) -> float:  # type: ignore[override]
        """Smallest coefficient of all cycles."""
        return min(self._course.values)

    @property
    def kinks(self) -> tuple[float, ...]:
        """Cycles at which the coefficient does not change smoothly."""
        return self._course.cycles

    def at(self, cycle: float) -> Coulomb:
        """The friction of a cycle."""
        return Coulomb.unchecked(friction=self._course.at(cycle)) if self.kinks else self

    @property
    def slug(self) -> str:
        """``mu0.5``, ``mu0.2to0.6``."""
        first, *later = self._course.values
        return f"mu{first:.4g}" + (f"to{later[-1]:.4g}" if later else "")


@dataclass(frozen=True)
class OfBodies(PerBody):
    """One value for the wear of both bodies together, or a pair [indenter, flat]."""

    may_be_drawn = True
    meaning = "one value for both bodies together, or two: [indenter, flat]"
    suffixes = (("indenter", "of the indenter"), ("flat", "of the flat"))

    def canonical(self, value: Any) -> Any:
        """Return the value, or both."""
        return list(value) if isinstance(value, tuple) else value

    def coordinates(self, name: str, value: Any) -> Iterator[tuple[str, Parameter, float | str]]:
        """Yield the value for both together, and those of each body if known."""
        yield name, self, _total(value)
        if isinstance(value, tuple):
            for (suffix, words), each in zip(self.suffixes, value, strict=True):
                yield f"{name}_{suffix}", replace(self, words=f"{self.words} {words}"), each


def _total(value: float | tuple[float, float]) -> float:
    return sum(value) if isinstance(value, tuple) else value


def _shares(value: float | tuple[float, float]) -> tuple[float, float] | None:
    return (value[0] / sum(value), value[1] / sum(value)) if isinstance(value, tuple) else None


@dataclass(frozen=True)
class FallingCoefficient:
    """Wear per energy that falls with the density φ of friction power: (α₀ − α₁) e^(−εφ) + α₁."""

    slow: Annotated[
        float | tuple[float, float],
        OfBodies("Pa-1", "$α_0$", "wear per energy at low power", "mm^3/J", above=0.0),
    ]
    fast: Annotated[
        float | tuple[float, float],
        OfBodies("Pa-1", "$α_1$", "wear per energy at high power", "mm^3/J", above=0.0),
    ]
    decay: Annotated[float, Quantity("m2 W-1", "$ε$", "decay with power", "mm^2/W", above=0.0)]
    frequency: Annotated[float, Quantity("s-1", "$f$", "frequency", "Hz", above=0.0)]

    def at(self, energy_density: float) -> float:
        """α, 1/Pa, of both bodies at an energy per cycle and contact area, J/m²."""
        fading = math.exp(-self.decay * self.frequency * energy_density)
        slow, fast = _total(self.slow), _total(self.fast)
        return (slow - fast) * fading + fast


@dataclass(frozen=True)
class PerEnergy(OfBodies):
    """Wear per energy: a value, a pair [indenter, flat], or a mapping if it falls with power."""

    forms = (FallingCoefficient((1.0, 1.0), (1.0, 1.0), 1.0, 1.0), *Parameter.forms)

    def read(self, value: object, units_required: bool) -> Any:
        """Return a float, a pair of floats or a `FallingCoefficient`."""
        if isinstance(value, FallingCoefficient):
            return value
        if not isinstance(value, Mapping):
            return super().read(value, units_required)
        known = declared(FallingCoefficient)
        if set(value) != set(known):
            raise QuantityError(
                f"must be one value, two, or a mapping of {', '.join(known)}",
                "{slow: 5.1e-4 mm^3/J, fast: 1e-4 mm^3/J, decay: 11 mm^2/W, frequency: 10 Hz}",
            )
        read = {}
        for name, about in known.items():
            try:
                read[name] = about.read(value[name], units_required)
            except QuantityError as error:
                rule = f"has {name} = {value[name]} that {error.rule}"
                raise QuantityError(rule, error.hint) from error
        # Of both together the indenter has a part that no body has.
        low, high = (_shares(read[name]) or (-1.0,) for name in ("slow", "fast"))
        if not math.isclose(low[0], high[0], rel_tol=1e-6):
            raise QuantityError(
                "must have parts of the bodies, [indenter, flat], that are alike in slow and fast",
                "slow: [2.55e-4 mm^3/J, 2.55e-4 mm^3/J], fast: [5e-5 mm^3/J, 5e-5 mm^3/J]",
            )
        return FallingCoefficient(**read)

    def schema(self) -> dict[str, Any]:
        """JSON Schema of the value in a study file."""
        known = {name: about.schema() for name, about in declared(FallingCoefficient).items()}
        return {"anyOf": [*super().schema()["anyOf"], keys_schema(known, [*known])]}

    def canonical(self, value: Any) -> Any:
        """Return the value, both, or the mapping."""
        if not isinstance(value, FallingCoefficient):
            return super().canonical(value)
        known = declared(FallingCoefficient).items()
        return {name: about.canonical(getattr(value, name)) for name, about in known}

    def coordinates(self, name: str, value: Any) -> Iterator[tuple[str, Parameter, float | str]]:
        """Yield what `OfBodies` does, or each value of the mapping."""
        if not isinstance(value, FallingCoefficient):
            yield from super().coordinates(name, value)
            return
        yield name, self, _total(value.slow)
        for each, about in declared(FallingCoefficient).items():
            yield from about.coordinates(f"{name}_{each}", getattr(value, each))

    def text(self, value: Any) -> str:
        """Return the value in readable units."""
        return super().text(value.slow if isinstance(value, FallingCoefficient) else value)


class Means(Protocol):
    """What a wear law may read of the contact of the moment: means over its area and a cycle."""

    @property
    def energy_density(self) -> float:
        """Dissipated energy per cycle and area of contact, J/m²."""


class WearLaw(Part):
    """Worn depth in proportion to pressure and path of slip."""

    slug = ""  # the coefficient is left out of the id
    # Fractions of indenter and flat in the wear; None if only their sum is known.
    shares: tuple[float, float] | None = None

    def coefficient(self, friction: Friction) -> float:
        """Worn depth of both bodies together per pressure and path of slip, 1/Pa."""
        raise NotImplementedError

    def driver(self, contact: Means) -> float:  # noqa: ARG002 - a constant has none
        """What the coefficient follows in the course of wear, read off a contact."""
        return 0.0

    def driven(self, driver: float) -> WearLaw:  # noqa: ARG002
        """The law with the coefficient that it has at a value of its driver."""
        return self


@dataclass(frozen=True)
class Archard(WearLaw):
    """Archard (1953), J. Appl. Phys. 24, 981-988: the coefficient is a constant."""

    wear_coefficient: Annotated[
        float | tuple[float, float],
        OfBodies("Pa-1", "$K_w$", "wear coefficient", "/ Pa", above=0.0),
        "Archard's wear coefficient K_w: depth per pressure and path of slip, of "
        "both bodies together or [indenter, flat]. Or give energy_wear_coefficient.",
    ]
    kind: Literal["archard"] = "archard"

    def coefficient(self, friction: Friction) -> float:  # noqa: ARG002 - of any friction
        """K_w, 1/Pa."""
        return _total(self.wear_coefficient)

    @property
    def shares(self) -> tuple[float, float] | None:  # type: ignore[override]
        """Fractions of indenter and flat in the wear."""
        return _shares(self.wear_coefficient)


@dataclass(frozen=True)
class EnergyWear(WearLaw):
    """Wear volume in proportion to the dissipated energy: K = αµ (Fouvry et al. 1996).

    Fouvry, Kapsa and Vincent, "Quantification of fretting damage", Wear 200 (1996), 186-205.
    """

    energy_wear_coefficient: Annotated[
        float | tuple[float, float] | FallingCoefficient,
        PerEnergy(
            "Pa-1", "$α$", "energy wear coefficient", "mm^3/J", like="5e-5 mm^3/J", above=0.0
        ),
        "Wear volume per dissipated energy α, of both bodies together or "
        "[indenter, flat]; or a mapping of slow, fast, decay and frequency where it falls "
        "with the mean density of friction power. Or give wear_coefficient.",
    ]
    kind: Literal["energy"] = "energy"

    def coefficient(self, friction: Friction) -> float:
        """K = αµ, 1/Pa; without power where α falls with it."""
        value = self.energy_wear_coefficient
        if isinstance(value, FallingCoefficient):
            value = value.at(0.0)
        return _total(value) * friction.coefficient

    def driver(self, contact: Means) -> float:
        """Energy per cycle and area of contact, J/m², where α falls with it."""
        falls = isinstance(self.energy_wear_coefficient, FallingCoefficient)
        return contact.energy_density if falls else 0.0

    def driven(self, driver: float) -> EnergyWear:
        """The law with the constant α of an energy density, J/m²."""
        value = self.energy_wear_coefficient
        if not isinstance(value, FallingCoefficient):
            return self
        total, shares = value.at(driver), self.shares
        constant = total if shares is None else (shares[0] * total, shares[1] * total)
        return EnergyWear.unchecked(energy_wear_coefficient=constant)

    @property
    def shares(self) -> tuple[float, float] | None:  # type: ignore[override]
        """Fractions of indenter and flat in the wear."""
        value = self.energy_wear_coefficient
        return _shares(value.slow if isinstance(value, FallingCoefficient) else value)
