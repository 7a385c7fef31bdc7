"""A case: everything that one simulation needs to know, validated, frozen, in SI units."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, field_validator, model_validator
from pydantic_core import PydanticCustomError

from fretwear.study import identity
from fretwear.study.checks import findings
from fretwear.study.fields import PerBody, Quantity, Spacing, WholeNumber, means_none
from fretwear.study.problems import suggestion
from fretwear.study.quantities import COMPLIANCE, FORCE, LENGTH, NUMBER, PRESSURE
from fretwear.study.roughness import WavyRoughness
from fretwear.study.spacing import default_spacing

__all__ = ["MAX_CYCLES", "OPTIONAL_IN_FILES", "Case", "WavyRoughness", "with_first_and_last"]

MAX_CYCLES = 10**9

OPTIONAL_IN_FILES = frozenset({"cell", "tolerance", "slip_model"})
"""Case keys that a study file may leave out (of the two tangential ones it gives one)."""

SlipModel = Literal["jaeger", "cattaneo_mindlin"]


def _roughness_or_none(value: object, info: Any) -> object:
    return None if means_none(value, bool((info.context or {}).get("units_required"))) else value


def with_first_and_last(snapshots: Iterable[int], cycles: int) -> tuple[int, ...]:
    """Return the snapshots in order, each once, with cycle 0 and the last among them."""
    return tuple(sorted({0, cycles, *snapshots}))


class Case(BaseModel):
    """One sphere on a flat, one load, one number of cycles: what `simulate` takes.

    Values are SI numbers or text with a unit (``load="50 N"``); attributes are SI floats.

    The model is that of equal bodies or of bodies whose composite moduli E* and G* stand for
    both.  For two different materials the coupling of normal pressure and tangential
    displacement (Dundurs' β) is neglected.

    Attributes
    ----------
    radius : float
        Sphere radius R in m.
    youngs_modulus, poisson_ratio : float or (float, float)
        One value in Pa (or plain) for both bodies, or a pair (body I, body II).
    load : float
        Normal load P in N, constant.
    tangential_ratio, tangential_load : float or None
        Amplitude of the tangential load as Q/(µP), or Q in N; exactly one of the two is given.
    friction : float
        Coefficient of friction µ.
    wear_coefficient : float
        Archard's K_w in 1/Pa: worn depth per pressure and path of slip.
    plastic_limit : float
        Highest pressure in Pa, about the hardness; inf (written ``"none"``) is elastic.
    roughness : WavyRoughness or None
        Roughness of the sphere; None is smooth, and so is one of zero amplitude.
    cycles : int
        Number of cycles.
    cell : (float, float) or None
        Grid spacing along x and y in m; None: the default, see `grid_spacing`.
    tolerance : float
        Relative error allowed to the integration of wear.
    slip_model : str
        ``"jaeger"`` (from the current shape) or ``"cattaneo_mindlin"`` (of the smooth sphere).
    output_cycles : tuple of int
        Cycles whose fields are kept; 0 and the last are always among them.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    radius: Annotated[
        float,
        Quantity(LENGTH.like("10 mm"), above=0.0),
        Field(description="Radius R of the sphere."),
    ]
    youngs_modulus: Annotated[
        float | tuple[float, float],
        PerBody(Quantity(PRESSURE, above=0.0)),
        Field(description="Young's modulus E, or a pair [body I, body II]."),
    ]
    poisson_ratio: Annotated[
        float | tuple[float, float],
        PerBody(Quantity(NUMBER, above=-1.0, at_most=0.5)),
        Field(description="Poisson's ratio, or a pair [body I, body II]."),
    ]
    load: Annotated[float, Quantity(FORCE, above=0.0), Field(description="Constant normal load P.")]
    tangential_ratio: Annotated[
        Annotated[float, Quantity(NUMBER.like("0.8"), above=0.0)] | None,
        Field(description="Tangential load as Q/(µP), less than 1. Or give tangential_load."),
    ] = None
    tangential_load: Annotated[
        Annotated[float, Quantity(FORCE.like("20 N"), above=0.0)] | None,
        Field(description="Tangential load Q, less than µP. Or give tangential_ratio."),
    ] = None
    friction: Annotated[
        float,
        Quantity(NUMBER.like("0.5"), above=0.0),
        Field(description="Coefficient of friction µ."),
    ]
    wear_coefficient: Annotated[
        float,
        Quantity(COMPLIANCE, above=0.0),
        Field(description="Archard's wear coefficient K_w: depth per pressure and path of slip."),
    ]
    plastic_limit: Annotated[
        float,
        Quantity(PRESSURE.like("4500 MPa"), above=0.0, none_is_infinite=True),
        Field(description="Highest pressure, about three times the yield stress; none: elastic."),
    ] = math.inf
    roughness: Annotated[
        WavyRoughness | None,
        BeforeValidator(_roughness_or_none),
        Field(description="Roughness of the sphere; none: smooth."),
    ] = None
    cycles: Annotated[
        int, WholeNumber(1, MAX_CYCLES, 30000), Field(description="Number of load cycles.")
    ]
    cell: Annotated[
        tuple[float, float] | None,
        Spacing(Quantity(LENGTH.like("0.5 um"), above=0.0)),
        Field(description="Grid spacing along x and y; the default resolves contact and waves."),
    ] = None
    tolerance: Annotated[
        float,
        Quantity(NUMBER.like("0.01"), above=1e-6, at_most=0.1),
        Field(description="Relative error of the wear integration."),
    ] = 0.01
    slip_model: Annotated[SlipModel, Field(description="How slip is computed.")] = "jaeger"
    output_cycles: tuple[Annotated[int, WholeNumber(0, MAX_CYCLES, 1000)], ...] = Field(
        default=(),
        description="Cycles at which the fields are kept.",
        validate_default=True,
    )

    @model_validator(mode="before")
    @classmethod
    def _only_known_names(cls, values: Any) -> Any:
        unknown = [name for name in values if name not in cls.model_fields]
        if unknown:
            known = list(cls.model_fields)
            told = (
                f"{name!r} is no parameter of a case; {suggestion(name, known)}" for name in unknown
            )
            text = ". ".join(each.rstrip("; ") for each in told)
            raise PydanticCustomError("fretwear_case", "{text}", {"text": text})
        return values

    @field_validator("roughness")
    @classmethod
    def _smooth_is_none(cls, value: WavyRoughness | None) -> WavyRoughness | None:
        return None if value is None or value.amplitude == 0.0 else value

    @field_validator("output_cycles")
    @classmethod
    def _first_and_last(cls, value: tuple[int, ...], info: Any) -> tuple[int, ...]:
        return with_first_and_last(value, info.data["cycles"]) if "cycles" in info.data else value

    @model_validator(mode="after")
    def _parameters_fit_together(self) -> Self:
        found = findings(self)
        if found:
            text = "; ".join(finding.sentence() for finding in found)
            raise PydanticCustomError("fretwear_case", "{text}", {"text": text})
        return self

    @property
    def youngs_modulus_pair(self) -> tuple[float, float]:
        """(E1, E2) in Pa."""
        return _pair(self.youngs_modulus)

    @property
    def poisson_ratio_pair(self) -> tuple[float, float]:
        """(ν1, ν2)."""
        return _pair(self.poisson_ratio)

    @property
    def composite_modulus(self) -> float:
        """E* in Pa, from 1/E* = (1−ν1²)/E1 + (1−ν2²)/E2."""
        bodies = zip(self.youngs_modulus_pair, self.poisson_ratio_pair, strict=True)
        return 1.0 / sum((1.0 - nu**2) / modulus for modulus, nu in bodies)

    @property
    def composite_shear_modulus(self) -> float:
        """G* in Pa, from 1/G* = (2−ν1)/(4G1) + (2−ν2)/(4G2) with G = E/(2(1+ν))."""
        bodies = zip(self.youngs_modulus_pair, self.poisson_ratio_pair, strict=True)
        return 1.0 / sum((2.0 - nu) * (1.0 + nu) / (2.0 * modulus) for modulus, nu in bodies)

    @property
    def coupling(self) -> float:
        """κ = E*/G*, tangential compliance relative to the normal one."""
        return self.composite_modulus / self.composite_shear_modulus

    @property
    def hertz_radius(self) -> float:
        """Contact radius a of the smooth elastic sphere in m: a³ = 3PR/(4E*)."""
        return math.cbrt(0.75 * self.load * self.radius / self.composite_modulus)

    @property
    def hertz_pressure(self) -> float:
        """Peak pressure p0 of the smooth elastic sphere in Pa: 3P/(2πa²)."""
        return 1.5 * self.load / (math.pi * self.hertz_radius**2)

    @property
    def hertz_approach(self) -> float:
        """Approach of the smooth elastic sphere in m: a²/R."""
        return self.hertz_radius**2 / self.radius

    @property
    def tangential_force(self) -> float:
        """Amplitude Q of the tangential load in N, whichever way it was given."""
        if self.tangential_load is not None:
            return self.tangential_load
        assert self.tangential_ratio is not None
        return self.tangential_ratio * self.friction * self.load

    @property
    def load_ratio(self) -> float:
        """X = Q/(µP), between 0 and 1."""
        if self.tangential_ratio is not None:
            return self.tangential_ratio
        return self.tangential_force / (self.friction * self.load)

    @property
    def stick_load(self) -> float:
        """P* = P − Q/µ in N, the load whose contact is the stick zone."""
        return self.load * (1.0 - self.load_ratio)

    @property
    def stick_radius(self) -> float:
        """Stick radius c of the smooth elastic sphere in m: a (1 − X)^(1/3)."""
        return self.hertz_radius * math.cbrt(max(0.0, 1.0 - self.load_ratio))

    @property
    def grid_spacing(self) -> tuple[float, float]:
        """(dx, dy) in m: `cell`, or where it is None the default of `default_spacing`."""
        return default_spacing(self) if self.cell is None else self.cell

    @property
    def case_id(self) -> str:
        """Readable slug of the main parameters and a short hash of all; see `identity`."""
        return identity.case_id(self)

    def canonical_parameters(self) -> dict[str, Any]:
        """Every parameter but the snapshots, in SI, ready for JSON; `Case(**...)` takes it back."""
        return identity.canonical_parameters(self)

    def scalar_coordinates(self) -> dict[str, tuple[float | str, str, str]]:
        """Every parameter as a dataset coordinate: name → (value, units, long name)."""
        return identity.scalar_coordinates(self)


def _pair(value: float | tuple[float, float]) -> tuple[float, float]:
    return value if isinstance(value, tuple) else (value, value)
