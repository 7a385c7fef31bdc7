"""The fields of a case, and the physics that follows from them before cells are chosen."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache
from itertools import groupby
from typing import Annotated, Any, Self, get_type_hints

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    create_model,
)
from pydantic_core import core_schema

import fretwear.mechanics.surfaces.measured  # noqa: F401 - its kinds
from fretwear.mechanics.contact.cells import Geometry
from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.rings import Rings
from fretwear.mechanics.contact.strips import Row, Strips
from fretwear.mechanics.setup import Setup
from fretwear.mechanics.slip.loading import Loading, SlidingDistance
from fretwear.mechanics.slip.models import Cerruti
from fretwear.mechanics.surfaces.materials import Friction
from fretwear.mechanics.surfaces.pressing import Normal
from fretwear.quantity import (
    AXES,
    Coordinates,
    Inline,
    Parameter,
    Part,
    PartOf,
    Plain,
    Quantity,
    Schema,
    declared,
    whole_number,
)
from fretwear.study.keys import Keys
from fretwear.theory import HertzContact
from fretwear.units import LINE_CONTACT

MAX_CYCLES = 10**9
PARTS_OF_A_DISTANCE = 1000
"""Default number of cycles into which a sliding distance is divided."""
_SNAPSHOTS = 8
_SNAPSHOT = whole_number("$N$", "cycle", 0, MAX_CYCLES, 1000)
_CYCLES = whole_number("$N$", "number of cycles", 1, MAX_CYCLES, 30000)
_IN_BLOCKS = "normal", "loading", "friction_law"
_CHANGEABLE: tuple[type[Part], ...] = (Normal, Loading, Friction)
# Stick zone and slip annulus, over the contact radius, up to which a grid does not resolve them.
_NARROW = 0.05


class Automatic:
    """Annotates an optional value, which study files call ``auto`` where it is None."""

    def __init__(self, schema: Schema) -> None:
        self.schema = schema

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        return core_schema.no_info_before_validator_function(
            lambda value: None if value == "auto" else value, handler(source)
        )

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> Schema:
        described = {"description": handler(schema).get("description", "")}
        return {"default": "auto", "anyOf": [{"const": "auto"}, self.schema], **described}


Snapshots = Annotated[
    tuple[Annotated[int, _SNAPSHOT], ...] | None,
    Automatic({"type": "array", "items": {"type": ["integer", "string"]}}),
    Field(
        description="Cycles at which the fields are kept, besides 0 and the last; auto: about "
        "eight powers of ten and three times these."
    ),
]


class Block(BaseModel):
    """A number of cycles with other values of some parameters, in SI units."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    cycles: Annotated[int, _CYCLES]

    @property
    def values(self) -> dict[str, Any]:
        """The values that it changes, by the names of their keys."""
        given = self.model_fields_set - {"cycles"}
        return {name: value for name, value in vars(self).items() if name in given}


def _changeable() -> dict[str, Any]:
    """The types of the parameters that a block may change, by name."""
    kinds = (kind for family in _CHANGEABLE for kind in family.kinds().values())
    hints = ((kind, get_type_hints(kind, include_extras=True)) for kind in kinds)
    return {name: types[name] for kind, types in hints for name in kind.parameters()}


class Blocks(Plain):
    """A list of blocks."""

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        fields: dict[str, Any] = {name: (hint, None) for name, hint in _changeable().items()}
        block = create_model("Block", __base__=Block, **fields)
        return handler.generate_schema(tuple[block, ...])  # type: ignore[valid-type]

    @property
    def fields(self) -> dict[str, Parameter]:
        """The parameters that a block may have, by name."""
        return {n: about for family in _CHANGEABLE for n, about in Inline(family).keys.items()}

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
            yield name, Plain(name, self.words), self.text(value)

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


@dataclass(frozen=True, init=False, kw_only=True)
class FrettingContact(Setup):
    """One contact, one loading and one number of cycles, in SI units."""

    cycles: Annotated[int, _CYCLES, "Number of load cycles."]
    cell: Annotated[
        tuple[float, float] | None,
        Quantity("m", "$Δ$", "grid spacing", "um", like="0.5 um", gt=0.0, places=AXES),
        "Grid spacing along x and y; the default resolves contact and waves.",
    ] = None
    tolerance: Annotated[
        float,
        Quantity("1", "tolerance", "tolerance", like="0.01", gt=1e-6, le=0.1),
        "Relative error of the wear integration.",
    ] = 0.01
    blocks: Annotated[
        tuple[Block, ...],
        Blocks(
            "blocks",
            "blocks of loading",
            "[{cycles: 2000, tangential_ratio: 0.5}, {cycles: 5000, tangential_ratio: 0.9}]",
        ),
        "Successive blocks of loading, instead of cycles. Each gives its cycles and "
        "may change load, displacement or force, and friction; base may leave out a value that all "
        "blocks give.",
    ] = ()
    error_estimate: Annotated[
        bool,
        Plain("", "estimate of errors", "false"),
        "Whether a run on cells twice as wide estimates the error of every result.",
    ] = True
    accuracy: Annotated[
        float,
        Quantity(
            "1",
            "accuracy",
            "accuracy",
            like="0.02",
            ge=0.001,
            le=0.2,
            infinite="as on default cells",
        ),
        "Largest relative error of wear, contact and stick zone, and energy. Runs on ever narrower "
        "cells find the cell and the tolerance that it needs; none: default cells, whatever the "
        "error. A written cell overrules it.",
    ] = 0.02
    budget: Annotated[
        float | None,
        Quantity("1", "budget", "budget", like="10", ge=1.0, le=1000.0),
        "How many times longer than on default cells a case may take to reach its accuracy; 10 "
        "unless given.",
    ] = None
    output_cycles: tuple[int, ...] = ()

    @classmethod
    def of(cls, assembled: Mapping[str, object]) -> Self:
        """Return the case of members already read, whose rules are not checked.

        The number of cycles follows from the blocks, and the snapshots from both.
        """
        case = object.__new__(cls)
        values = vars(case)
        # What a case has derived from its members is not one of them.
        values |= {n: member for n, member in assembled.items() if n in cls.__dataclass_fields__}
        if blocks := case.blocks:
            alike = [[*same] for _, same in groupby(blocks, lambda block: block.values)]
            cycles = [sum(block.cycles for block in same) for same in alike]
            merged = [
                same[0].model_copy(update={"cycles": number})
                for same, number in zip(alike, cycles, strict=True)
            ]
            values["cycles"] = sum(cycles)
            values["blocks"] = tuple(merged) if merged[1:] or merged[0].values else ()
        estimated = values.get("error_estimate", True) or "accuracy" in assembled
        if values.get("cell") is not None or not estimated:
            values["accuracy"] = math.inf
        if isinstance(loading := values["loading"], SlidingDistance):
            distance = loading.sliding_distance
            values["loading"] = loading.unchecked(sliding_distance=distance, parts=values["cycles"])
        values["output_cycles"] = snapshots_of(values.get("output_cycles"), values["cycles"])
        # The parameters of parts whose fields are keys, by their names.
        for member, about in members().items():
            if (part := values.get(member)) is not None and is_open(about, part):
                values |= {n: v for n, v in vars(part).items() if n in part.parameters()}
        return case

    def changed(self, **members: object) -> Self:
        """The case with other members, not checked against each other."""
        fields = {n: value for n, value in vars(self).items() if n in self.__dataclass_fields__}
        return self.of(fields | members)

    @cached_property
    def geometry(self) -> type[Geometry]:
        """The kind of cells: rings for rotational symmetry, which slip along one direction breaks.

        Rings remain where a grid would not resolve the edge of the stick zone: where bodies yield,
        under a pulsating load, and where the slip annulus or the stick zone is narrow; slip is then
        the mean over all directions.
        """
        if self.frame is LINE_CONTACT:
            return Row if self.bulk_stress else Strips
        is_round = self.indenter.is_axisymmetric and self._is_plain and not self.bulk_stress
        if not is_round or self.slip_model.couples:
            return Grid
        is_narrow = not _NARROW < self.stick_radius / self.hertz_radius < 1.0 - _NARROW
        fits = math.isinf(self.plastic_limit) and self.normal.pulsating_load == 1.0
        varies = isinstance(self.slip_model, Cerruti) and self.coupling != 1.0
        return Grid if varies and fits and not is_narrow else Rings

    @cached_property
    def is_graded(self) -> bool:
        """Whether it is computed on graded rings or strips: only written fields have the `cell`."""
        return self._is_plain and not issubclass(self.geometry, Grid)

    @cached_property
    def _is_plain(self) -> bool:
        return self.rough is None and not self.loading.stroke

    # Physics that follows before anything is run.

    @property
    def tangential_ratio(
        self,
    ) -> Annotated[float, Quantity("1", "$Q/µP$", "tangential load ratio")]:
        """X = Q/(µP); for the unworn smooth contact if a displacement is imposed."""
        return self.loading.ratio(*self._unworn)

    @property
    def tangential_load(
        self,
    ) -> Annotated[float, Quantity("N", "$Q$", "tangential load amplitude", "N")]:
        """Amplitude Q of the tangential load in N, as for `tangential_ratio`."""
        return self.loading.amplitude(*self._unworn)

    @property
    def displacement_amplitude(
        self,
    ) -> Annotated[float, Quantity("m", "$U$", "displacement amplitude", "um")]:
        """Amplitude U of the imposed displacement, m, however it was given."""
        return self.loading.displacement(*self._unworn)

    @property
    def displacement_ratio(
        self,
    ) -> Annotated[float, Quantity("1", "$U/U_t$", "displacement ratio")]:
        """U over that at which the unworn smooth contact begins to slide as a whole."""
        return self.displacement_amplitude / self.loading.transition(*self._unworn)

    @property
    def _unworn(self) -> tuple[float, float, HertzContact]:
        return self.friction_law.coefficient, self.coupling, self.hertz

    @cached_property
    def plain_loading(self) -> Loading:
        """The loading along x in SI units, however it was given."""
        if self.blocks or (self.loading.is_force and not self.force_is_held):
            return self.loading
        return self.loading.plain(*self._unworn)

    @cached_property
    def force_is_held(self) -> bool:
        """Whether P and Q stay as they are, and Q/(µP) with them."""
        constant = self.at(self.cycles) is self and not self.blocks
        return constant and self.normal.holds_load and self.loading.is_force

    @property
    def hertz_radius(self) -> Annotated[float, Quantity("m", "$a$", "Hertz contact radius", "um")]:
        """Contact radius a of the smooth elastic bodies, or half-width of the cylinder, in m.

        For an elliptical contact, it is the radius of a circle of the same area. It also sets the
        scale of contacts outside Hertz's theory, but is not among their coordinates.
        """
        return self.hertz.contact_radius

    @property
    def hertz_pressure(self) -> Annotated[float, Quantity("Pa", "$p_0$", "Hertz pressure", "MPa")]:
        """Peak pressure p0 of the smooth elastic contact in Pa."""
        return self.hertz.peak_pressure

    @property
    def scar_half_width(self) -> float:
        """Half-width, m, of the contact at the end of a run with strokes, from the worn volume."""
        path = 4.0 * self.loading.stroke * self.cycles * (1.0 - self.debris_fraction)
        volume = self.combined_wear_coefficient * path * self.load_at(0.0)
        width = self.hertz.scar_half_width(volume, self.indenter.curvature_radius)
        return min(width, self.indenter.end)

    # Blocks of loading.

    def in_blocks(self) -> Iterator[tuple[float, Self | None]]:
        """Each block as a case (None if it is not valid), with the cycle at which it ends."""
        end = 0
        for block in self.blocks or (Block(cycles=self.cycles),):
            end += block.cycles
            changed: dict[str, object] = {"blocks": ()}
            for member in _IN_BLOCKS:
                about = members()[member]
                assert isinstance(about, Inline)
                keys = about.keys
                if given := {name: value for name, value in block.values.items() if name in keys}:
                    changed[member] = about.changed(getattr(self, member), given)
            yield end, None if None in changed.values() else self.changed(**changed)


def members() -> Mapping[str, Parameter]:
    """Return the fields of a case, except the snapshots, with their declarations."""
    return declared(FrettingContact)


@cache
def case_keys() -> Keys:
    """Return the keys of a case."""
    return Keys(FrettingContact)


def is_open(about: Parameter, value: object) -> bool:
    """Whether the fields of a part are keys of the case."""
    if isinstance(about, Inline):
        return value is not None
    return isinstance(about, PartOf) and getattr(value, "kind", "") == about.short != ""


def with_parts_of_distance(given: Mapping[str, Any], varied: Iterable[str] = ()) -> dict[str, Any]:
    """Keys of a case with the cycles into which a sliding distance is divided, unless given."""
    names = {*given, *varied}
    divided = "sliding_distance" in names and not names & {"cycles", "blocks"}
    return {**given, "cycles": PARTS_OF_A_DISTANCE} if divided else dict(given)


@lru_cache(64)
def snapshots_of(asked: tuple[int, ...] | None, cycles: int) -> tuple[int, ...]:
    """Return the snapshots in order, each once, with cycle 0 and the last among them.

    By default they are the powers of ten and, up to eight in all, the largest of three times these.
    """
    if asked is None:
        powers = [10**n for n in range(len(str(cycles))) if 10**n < cycles]
        between = [3 * power for power in reversed(powers) if 3 * power < cycles]
        asked = (*powers, *between[: max(0, _SNAPSHOTS - 2 - len(powers))])
    return tuple(sorted({0, cycles, *asked}))
