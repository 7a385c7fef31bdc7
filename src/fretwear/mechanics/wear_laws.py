"""Laws for the wear by a pressure along a path of slip."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal

from fretwear.mechanics.materials import Friction
from fretwear.parts import Parameter, Part, PerBody, Quantity, QuantityError, declared, keys_schema


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

    @property
    def problem(self) -> tuple[str, str] | None:
        """The rule, if broken, that fractions of the bodies are the same at any power; a hint."""
        # Of both together the indenter has a part that no body has.
        low, high = (_shares(each) or (-1.0,) for each in (self.slow, self.fast))
        if math.isclose(low[0], high[0], rel_tol=1e-6):
            return None
        rule = "must have parts of the bodies, [indenter, flat], that are alike in slow and fast"
        return rule, "slow: [2.55e-4 mm^3/J, 2.55e-4 mm^3/J], fast: [5e-5 mm^3/J, 5e-5 mm^3/J]"


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
                raise QuantityError(
                    f"has {name} = {value[name]} that {error.rule}", error.hint
                ) from error
        found = FallingCoefficient(**read)
        if found.problem is not None:
            raise QuantityError(*found.problem)
        return found

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
        if isinstance(value, FallingCoefficient):
            yield name, self, _total(value.slow)
            for each, about in declared(FallingCoefficient).items():
                yield from about.coordinates(f"{name}_{each}", getattr(value, each))
        else:
            yield from super().coordinates(name, value)

    def text(self, value: Any) -> str:
        """Return the value in readable units."""
        return super().text(value.slow if isinstance(value, FallingCoefficient) else value)


class WearLaw(Part):
    """Worn depth in proportion to pressure and path of slip."""

    follows_power: bool = False  # whether the proportion depends on the dissipated energy
    # Fractions of indenter and flat in the wear; None if only their sum is known.
    shares: tuple[float, float] | None = None

    def coefficient(self, friction: Friction, energy_density: float = 0.0) -> float:
        """Worn depth of both bodies together per pressure and path of slip, 1/Pa.

        ``energy_density`` is the energy per cycle and area of contact, J/m².
        """
        raise NotImplementedError

    @property
    def slug(self) -> str:
        """The coefficient is left out of the id."""
        return ""


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

    def coefficient(self, *_: Any, **__: Any) -> float:
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

    @property
    def follows_power(self) -> bool:  # type: ignore[override]
        """Whether α falls with the friction power."""
        return isinstance(self.energy_wear_coefficient, FallingCoefficient)

    def coefficient(self, friction: Friction, energy_density: float = 0.0) -> float:
        """K = αµ, 1/Pa."""
        value = self.energy_wear_coefficient
        if isinstance(value, FallingCoefficient):
            value = value.at(energy_density)
        return _total(value) * friction.coefficient

    @property
    def shares(self) -> tuple[float, float] | None:  # type: ignore[override]
        """Fractions of indenter and flat in the wear."""
        value = self.energy_wear_coefficient
        return _shares(value.slow if isinstance(value, FallingCoefficient) else value)
