"""Laws of wear: depth worn per pressure and path of slip, constant or following the contact.

A coefficient may follow the mean pressure, the sliding, the power density and the frequency of the
motion. The integrators evaluate it in every stage, for the contact of the stage before.
"""

from __future__ import annotations

import dataclasses
import math
from functools import cached_property, partial
from typing import Annotated, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic.dataclasses import dataclass

from fretwear.arrays import Array
from fretwear.mechanics.contact.cells import Geometry
from fretwear.mechanics.surfaces.materials import Friction
from fretwear.mechanics.values import OfBodies
from fretwear.quantity import BODIES, Part, Quantity

# Least fraction of a mean that an extrapolation leaves.
_LEAST_LEFT = 0.1


class Means(NamedTuple):
    """Means over the contact and a cycle, which coefficients may follow."""

    energy_density: float = 0.0  # dissipated energy per cycle and area of contact, J/m²
    pressure: float = 0.0  # load per area of contact, Pa
    slip: float = 0.0  # amplitude, m, weighted by pressure: E_d/4µP
    half_width_x: float = 0.0  # of the contact, mean over the stroke, m
    half_width_y: float = math.inf  # the same along y; infinite in line contact

    def ahead(self, previous: Means, times: float) -> Means:
        """The means if the change since the previous ones continues, so many times as long."""
        # An infinite half-width stays infinite.
        pairs = zip(self, previous, strict=True)
        changes = ((now, now - then if now < math.inf else 0.0) for now, then in pairs)
        return Means(*(max(now + times * change, _LEAST_LEFT * now) for now, change in changes))


_PerEnergy = partial(Quantity, "Pa-1", shown_in="mm^3/J", gt=0.0, places=BODIES, record=OfBodies)
_Exponent = partial(Quantity, "1", omitted_value=0.0)
_ReferenceFrequency = Annotated[
    float,
    Quantity("s-1", "$f_r$", "reference frequency", "Hz", "1 Hz", ge=0.0, omitted_value=0.0),
]


class Coefficient(Part):
    """A coefficient that follows the conditions; its ``float`` is its value for estimates."""

    follows_contact = True  # whether it changes as the bodies wear
    needs_frequency = False  # whether it depends on the frequency of the motion
    may_be_of_one_body = False  # whether it may be one of a pair
    is_of_each = False  # whether it has a value for each body

    def __float__(self) -> float:
        raise NotImplementedError

    def under(self, means: Means, frequency: float | None) -> float | OfBodies:
        """The constant coefficient, 1/Pa, of a contact with these means, at a frequency in Hz."""
        raise NotImplementedError


@dataclass(frozen=True)
class PowerLaw(Coefficient):
    """A coefficient K (p/p_r)^n (s/s_r)^m (f/f_r)^k of mean pressure, mean slip and frequency."""

    value: Annotated[
        float, Quantity("Pa-1", "$K_r$", "wear coefficient in reference conditions", "/ Pa", gt=0.0)
    ]
    pressure_exponent: Annotated[float, _Exponent("$n$", "pressure exponent", like="0.6")] = 0.0
    reference_pressure: Annotated[
        float,
        Quantity("Pa", "$p_r$", "reference pressure", "MPa", "100 MPa", ge=0.0, omitted_value=0.0),
    ] = 0.0
    sliding_exponent: Annotated[float, _Exponent("$m$", "sliding exponent", like="0.7")] = 0.0
    reference_sliding: Annotated[
        float,
        Quantity("m", "$s_r$", "reference sliding", "um", "100 um", ge=0.0, omitted_value=0.0),
    ] = 0.0
    frequency_exponent: Annotated[float, _Exponent("$k$", "frequency exponent", like="-0.3")] = 0.0
    reference_frequency: _ReferenceFrequency = 0.0

    may_be_of_one_body = True

    @property
    def mistake(self) -> tuple[str, str] | None:
        """An exponent needs its reference."""
        for name, parameter in self.parameters().items():
            what = name.removeprefix("reference_")
            if what != name and not vars(self)[name] and vars(self)[f"{what}_exponent"]:
                remedy = f"such as {name}: {parameter.example}"
                return f"needs {name} for its {what}_exponent", remedy
        return None

    @property
    def follows_contact(self) -> bool:  # type: ignore[override]
        """Whether it follows pressure or sliding."""
        return bool(self.pressure_exponent or self.sliding_exponent)

    @property
    def needs_frequency(self) -> bool:  # type: ignore[override]
        """Whether it follows the frequency."""
        return bool(self.frequency_exponent)

    def __float__(self) -> float:
        return self.value

    def under(self, means: Means, frequency: float | None) -> float:
        """K (p/p_r)^n (s/s_r)^m (f/f_r)^k, 1/Pa."""
        coefficient = self.value
        for exponent, quantity, reference in (
            (self.pressure_exponent, means.pressure, self.reference_pressure),
            (self.sliding_exponent, means.slip, self.reference_sliding),
            (
                self.frequency_exponent,
                frequency or self.reference_frequency,
                self.reference_frequency,
            ),
        ):
            if exponent:
                coefficient *= (quantity / reference) ** exponent
        return coefficient


class _Two(Coefficient):
    """A coefficient between two values, both of the bodies together or of each."""

    @property
    def _values(self) -> tuple[float | OfBodies, float | OfBodies]:
        first, second, *_ = (vars(self)[name] for name in self.parameters())
        return first, second

    @property
    def is_of_each(self) -> bool:  # type: ignore[override]
        """Whether it has a value for each body."""
        return isinstance(self._values[0], OfBodies)

    @property
    def _pairs(self) -> list[tuple[float, float]]:
        """Both values: a pair for each body, or one number for both."""
        first, second = self._values
        if isinstance(first, OfBodies) and isinstance(second, OfBodies):
            return [*zip(first, second, strict=True)]
        return [(float(first), float(second))]

    @property
    def mistake(self) -> tuple[str, str] | None:
        """Both values must be pairs of the bodies, or neither."""
        first, second, *_ = self.parameters()
        of_rim, of_core = self._values
        if isinstance(of_rim, OfBodies) == isinstance(of_core, OfBodies):
            return None
        pair = "[2e-4 mm^3/J, 2e-4 mm^3/J]"
        rule = f"must have pairs [indenter, flat] for {first} and {second}, or for neither"
        return rule, f"{first}: {pair}, {second}: {pair}"

    def __float__(self) -> float:
        return float(self._values[0])


@dataclass(frozen=True)
class FallingCoefficient(_Two):
    """Wear per energy that falls with the density φ of friction power: (α₀ − α₁) e^(−εφ) + α₁."""

    slow: Annotated[
        float | OfBodies,
        _PerEnergy(symbol="$α_0$", words="wear per energy at low power"),
    ]
    fast: Annotated[
        float | OfBodies,
        _PerEnergy(symbol="$α_1$", words="wear per energy at high power"),
    ]
    decay: Annotated[float, Quantity("m2 W-1", "$ε$", "decay with power", "mm^2/W", gt=0.0)]
    frequency: Annotated[
        float,
        Quantity("s-1", "$f$", "frequency", "Hz", ge=0.0, omitted_value=0.0),
        "Frequency for this law alone, instead of the frequency of the case.",
    ] = 0.0

    @property
    def needs_frequency(self) -> bool:  # type: ignore[override]
        """Whether it has no frequency of its own."""
        return not self.frequency

    def under(self, means: Means, frequency: float | None) -> float | OfBodies:
        """α, 1/Pa, at the power of the contact per area."""
        power = means.energy_density * (self.frequency or frequency or 0.0)
        fading = math.exp(-self.decay * power)
        values = [(slow - fast) * fading + fast for slow, fast in self._pairs]
        return OfBodies(values) if self.is_of_each else values[0]


@dataclass(frozen=True)
class RimAndCore(_Two):
    """A coefficient of a rim along the edge of contact, which oxygen reaches, and one of the core.

    The width of the rim is b_rim (f/f_r)^l at the frequency f. For points of both bodies it is
    measured from the edge of the contact in the middle of the stroke.
    """

    rim: Annotated[
        float | OfBodies,
        _PerEnergy(symbol="$α_r$", words="wear per energy in the rim"),
    ]
    core: Annotated[
        float | OfBodies,
        _PerEnergy(symbol="$α_c$", words="wear per energy in the core"),
    ]
    rim_width: Annotated[
        float, Quantity("m", r"$b_\mathrm{rim}$", "width of the rim", "mm", gt=0.0)
    ]
    width_exponent: Annotated[float, _Exponent("$l$", "width exponent", like="-0.71")] = 0.0
    reference_frequency: _ReferenceFrequency = 0.0

    @property
    def mistake(self) -> tuple[str, str] | None:
        """Both coefficients must be pairs of the bodies, or neither, and both must wear."""
        if self.width_exponent and not self.reference_frequency:
            return "needs reference_frequency for its width_exponent", "such as 1 Hz"
        if super().mistake is None and any(0.0 in pair for pair in self._pairs):
            return "must be larger than 0 for each body", "rim: [2e-4 mm^3/J, 2e-4 mm^3/J]"
        return super().mistake

    @property
    def needs_frequency(self) -> bool:  # type: ignore[override]
        """Whether the width of the rim follows the frequency."""
        return bool(self.width_exponent)

    def under(self, means: Means, frequency: float | None) -> float | OfBodies:
        """α of the rim, 1/Pa; `zones` has the core."""
        return self.rim

    def zones(self, means: Means, frequency: float | None) -> RimZones:
        """Rim and core of a contact."""
        width = self.rim_width
        if self.width_exponent and frequency is not None:
            width *= (frequency / self.reference_frequency) ** self.width_exponent
        core = tuple(core / rim for rim, core in self._pairs)
        return RimZones(core, width, (means.half_width_x, means.half_width_y))


@dataclasses.dataclass(frozen=True)
class RimZones:
    """A rim along the edge of a contact, and the core inside of it."""

    core: tuple[float, ...]  # coefficient in the core over that in the rim, of indenter and flat
    width: float  # of the rim, m
    half_widths: tuple[float, float]  # of the contact along x and y, m

    def factors(self, geometry: Geometry) -> Array:
        """Coefficient on the cells over that in the rim, of flat and indenter: 1 or 2 fields.

        The distance from the edge is measured towards the centre, exact for strips and circles. A
        cell on the boundary has the mean of its parts.
        """
        x, y = geometry.x[:, None], geometry.y[None, :]
        half_x, half_y = self.half_widths
        out = np.maximum(np.hypot(x / half_x, y / half_y), 1e-12)
        distance = np.hypot(x, y * bool(math.isfinite(half_y))) * (1.0 / out - 1.0)
        inner = np.clip(0.5 + (distance - self.width) / geometry.widths, 0.0, 1.0)
        core = np.array(self.core)[::-1, None, None]
        return np.asarray(1.0 + (core - 1.0) * inner)


# Two opposite conditions, under which constant fractions are equal.
_CALM, _FIERCE = (Means(0.0, 1e6, 1e-6), 0.1), (Means(1e12, 1e9, 1e-3), 1e3)


class WearLaw(Part):
    """Worn depth in proportion to pressure and path of slip.

    A parameter may be a number, a pair of the bodies, or a `Coefficient` that follows the contact.
    """

    slug = ""  # the coefficient is left out of the id
    follows_friction: ClassVar[bool] = False  # whether the coefficient grows with friction
    zones: RimZones | None = None  # set by `under` if the coefficient depends on the place

    def coefficient(self, friction: Friction) -> float:
        """Worn depth of both bodies together per pressure and path of slip, 1/Pa."""
        raise NotImplementedError

    @property
    def _values(self) -> dict[str, float | OfBodies | Coefficient]:
        return {name: vars(self)[name] for name in self.parameters()}

    @cached_property
    def _following(self) -> list[Coefficient]:
        parts: list[object] = []
        for value in self._values.values():
            parts += value if isinstance(value, OfBodies) else [value]
        return [part for part in parts if isinstance(part, Coefficient)]

    @property
    def needs_frequency(self) -> bool:
        """Whether the coefficient depends on the frequency of the motion."""
        return any(part.needs_frequency for part in self._following)

    @property
    def is_in_zones(self) -> bool:
        """Whether the coefficient depends on the place."""
        return any(isinstance(part, RimAndCore) for part in self._following)

    @property
    def follows_contact(self) -> bool:
        """Whether the coefficient changes as the bodies wear."""
        return any(part.follows_contact for part in self._following)

    @property
    def is_of_each(self) -> bool:
        """Whether the wear of each body is known."""
        pairs = (isinstance(value, OfBodies) for value in self._values.values())
        return any(pairs) or any(part.is_of_each for part in self._following)

    def with_flat(self, coefficient: float) -> WearLaw:
        """The law with another constant, 1/Pa, of the flat, or of the pair if it has only one."""
        pairs = {n: isinstance(value, OfBodies) for n, value in self._values.items()}
        of_pair = {n: OfBodies((vars(self)[n][0], coefficient)) for n in pairs if pairs[n]}
        return self.unchecked(**dict.fromkeys(pairs, coefficient) | of_pair)

    def under(self, means: Means, frequency: float | None) -> WearLaw:
        """The law with the constant coefficient that it has in a contact, at a frequency in Hz."""
        if not self._following:
            return self

        def constant(value: float | OfBodies | Coefficient) -> float | OfBodies:
            if isinstance(value, OfBodies):
                return OfBodies(tuple(map(constant, value)))
            return value.under(means, frequency) if isinstance(value, Coefficient) else value

        law = self.unchecked(**{name: constant(value) for name, value in self._values.items()})
        for value in self._following:
            if isinstance(value, RimAndCore):
                vars(law)["zones"] = value.zones(means, frequency)
        return law

    @property
    def shares(self) -> tuple[float, float] | None:
        """Fractions of the wear of indenter and flat; None if they change or are unknown."""
        if not self.is_of_each:
            return None
        if not self._following:
            return next(v.shares for v in self._values.values() if isinstance(v, OfBodies))
        calm, fierce = (self.under(*conditions).shares for conditions in (_CALM, _FIERCE))
        assert calm is not None
        assert fierce is not None
        return calm if math.isclose(calm[0], fierce[0], rel_tol=1e-6) else None


@dataclass(frozen=True)
class Archard(WearLaw):
    """Archard (1953), J. Appl. Phys. 24, 981-988: the coefficient is a constant."""

    wear_coefficient: Annotated[
        float | OfBodies | PowerLaw,
        Quantity(
            "Pa-1",
            "$K_w$",
            "wear coefficient",
            "/ Pa",
            ge=0.0,
            places=BODIES,
            record=OfBodies,
            forms=(PowerLaw,),
        ),
        "Depth per pressure and slip path, of both bodies together or [indenter, flat]; or a "
        "power law.",
    ]
    kind: Literal["archard"] = "archard"

    def coefficient(self, friction: Friction) -> float:
        """K_w, 1/Pa."""
        return float(self.wear_coefficient)


@dataclass(frozen=True)
class EnergyWear(WearLaw):
    """Wear volume in proportion to the dissipated energy: K = αµ (Fouvry et al. 1996).

    Fouvry, Kapsa and Vincent, "Quantification of fretting damage", Wear 200 (1996), 186-205.
    """

    energy_wear_coefficient: Annotated[
        float | OfBodies | Coefficient,
        Quantity(
            "Pa-1",
            "$α$",
            "energy wear coefficient",
            "mm^3/J",
            like="5e-5 mm^3/J",
            ge=0.0,
            places=BODIES,
            record=OfBodies,
            forms=(PowerLaw, FallingCoefficient, RimAndCore),
        ),
        "Volume per dissipated energy, likewise; or a law of friction power, or rim and core.",
    ]
    kind: Literal["energy"] = "energy"

    follows_friction: ClassVar[bool] = True

    def coefficient(self, friction: Friction) -> float:
        """K = αµ, 1/Pa; its value at zero power if α falls with power."""
        return float(self.energy_wear_coefficient) * friction.coefficient
