"""A setup: the parts that a case declares, and the physics that follows before anything is run."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Annotated, Any, Self

import fretwear.mechanics.surfaces.measured  # noqa: F401 - its kinds
from fretwear.forms import AlongXY
from fretwear.mechanics.contact.cells import Geometry
from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.rings import Rings
from fretwear.mechanics.contact.strips import Row, Strips
from fretwear.mechanics.setup import Setup
from fretwear.mechanics.slip.loading import Loading, Normal, SlidingDistance
from fretwear.mechanics.slip.models import Cerruti, SlipModel
from fretwear.mechanics.surfaces.indenters import Indenter
from fretwear.mechanics.surfaces.materials import Bodies, Friction
from fretwear.mechanics.surfaces.roughness import Roughness
from fretwear.mechanics.wear.laws import WearLaw
from fretwear.parts import Flag, Parameter, Quantity, WholeNumber, declared
from fretwear.study.members import Block, Blocks, Inline, PartOf
from fretwear.theory import HertzContact
from fretwear.units import LENGTH, LINE_CONTACT, format_quantity

MAX_CYCLES = 10**9

_SNAPSHOTS = 8
_USUAL_SLIP = Cerruti()
PARTS_OF_A_DISTANCE = 1000
"""Default number of cycles into which a sliding distance is divided."""
IN_BLOCKS = {
    "normal": Inline(Normal),
    "loading": Inline(Loading),
    "friction_law": Inline(Friction),
}
"""Members that a block of loading may change, or that every block gives instead of the case."""


@dataclass(frozen=True, init=False, kw_only=True)
class Draft(Setup):
    """The members of a case, each valid by itself, in SI units."""

    indenter: Annotated[
        Indenter,
        PartOf(Indenter, "indenter", short="sphere", example="{kind: sphere, radius: 10 mm}"),
        "Smooth shape of the bodies; radius: 10 mm is short for a sphere.",
    ]
    bodies: Annotated[Bodies, Inline(Bodies)]
    normal: Annotated[Normal, Inline(Normal)]
    loading: Annotated[Loading, Inline(Loading)]
    friction_law: Annotated[Friction, Inline(Friction)]
    wear_law: Annotated[WearLaw, Inline(WearLaw)]
    plastic_limit: Annotated[
        float,
        Quantity(
            "Pa",
            r"$p_\mathrm{lim}$",
            "plastic limit",
            "MPa",
            like="4500 MPa",
            above=0.0,
            infinite="elastic",
        ),
        "Highest pressure, about three times the yield stress; none: elastic.",
    ] = math.inf
    junction_growth: Annotated[
        float,
        Quantity("1", "$α_q$", "junction growth", like="9", at_least=0.0),
        "Factor α in p² + αq² ≤ p_lim², by which friction lowers the plastic limit.",
    ] = 0.0
    roughness: Annotated[
        Roughness | None,
        PartOf(
            Roughness,
            "roughness",
            none="smooth",
            example="{kind: wavy, amplitude: 0.2 um, slope_x: 5.7 deg, slope_y: 1 deg}",
        ),
        "Roughness of the surfaces; none: smooth.",
    ] = None
    counterface: Annotated[
        Roughness | None,
        PartOf(
            Roughness,
            "counterface",
            none="smooth",
            example="{kind: wavy, amplitude: 0.1 um, slope_x: 2 deg, slope_y: 1 deg}",
            is_second=True,
        ),
        "Roughness of the other body's surface, where both are rough.",
    ] = None
    cycles: Annotated[
        int,
        WholeNumber(
            "$N$", "number of cycles", 1, MAX_CYCLES, 30000, description="Number of load cycles."
        ),
    ]
    cell: Annotated[
        tuple[float, float] | None,
        AlongXY(Quantity("m", "$Δ$", "grid spacing", "um", like="0.5 um", above=0.0)),
        "Grid spacing along x and y; the default resolves contact and waves.",
    ] = None
    tolerance: Annotated[
        float,
        Quantity("1", "tolerance", "tolerance", like="0.01", above=1e-6, at_most=0.1),
        "Relative error of the wear integration.",
    ] = 0.01
    slip_model: Annotated[SlipModel, PartOf(SlipModel, "slip model"), "How slip is computed."] = (
        _USUAL_SLIP
    )
    frequency: Annotated[
        float | None,
        Quantity("s-1", "$f$", "frequency", "Hz", like="5 Hz", above=0.0),
        "Frequency of the motion, on which some laws of wear depend.",
    ] = None
    debris_fraction: Annotated[
        float,
        Quantity("1", "$γ$", "debris fraction", like="0.85", at_least=0.0, at_most=1.0),
        "Part γ of the worn material that stays between the bodies and carries load.",
    ] = 0.0
    bulk_stress: Annotated[
        float,
        Quantity("Pa", "$σ_b$", "bulk stress amplitude", "MPa", "80 MPa", at_least=0.0),
        "Amplitude of a stress along x in the flat, in phase with the tangential force; it moves "
        "the stick zone, and adds to stresses below the surface.",
    ] = 0.0
    blocks: Annotated[
        tuple[Block, ...],
        Blocks(
            "blocks",
            "blocks of loading",
            tuple(IN_BLOCKS.values()),
            WholeNumber("$N$", "number of cycles", 1, MAX_CYCLES, 2000),
        ),
        "Successive blocks of loading, instead of cycles. Each gives its cycles and "
        "may change load, displacement or force, and friction; base may leave out a value that all "
        "blocks give.",
    ] = ()
    error_estimate: Annotated[
        bool,
        Flag("", "estimate of errors"),
        "Whether a run on cells twice as wide estimates the error of every result.",
    ] = True
    accuracy: Annotated[
        float,
        Quantity(
            "1",
            "accuracy",
            "accuracy",
            like="0.02",
            at_least=0.001,
            at_most=0.2,
            infinite="as on default cells",
        ),
        "Largest relative error of wear, contact and stick zone, and energy. Runs on ever narrower "
        "cells find the cell and the tolerance that it needs; none: default cells, whatever the "
        "error. A written cell overrules it.",
    ] = 0.02
    budget: Annotated[
        float | None,
        Quantity("1", "budget", "budget", like="10", at_least=1.0, at_most=1000.0),
        "How many times longer than on default cells a case may take to reach its accuracy; 10 "
        "unless given.",
    ] = None
    output_cycles: tuple[int, ...] = ()

    @classmethod
    def of(cls, assembled: Mapping[str, object]) -> Self:
        """Return the case of members already read and checked; some may be missing.

        The number of cycles follows from the blocks, and the snapshots from both.
        """
        case = object.__new__(cls)
        values = vars(case)
        # What a case has derived from its members is not one of them.
        values |= {n: member for n, member in assembled.items() if n in cls.__dataclass_fields__}
        if blocks := case.blocks:
            values["cycles"] = sum(block.cycles for block in blocks)
            values["blocks"] = blocks if len(blocks) > 1 or blocks[0].values else ()
        estimated = values.get("error_estimate", True) or "accuracy" in assembled
        if values.get("cell") is not None or not estimated:
            values["accuracy"] = math.inf
        if "cycles" in values and isinstance(loading := values.get("loading"), SlidingDistance):
            values["loading"] = loading.unchecked(
                sliding_distance=loading.sliding_distance, parts=values["cycles"]
            )
        if "cycles" in values:
            values["output_cycles"] = snapshots_of(values.get("output_cycles"), values["cycles"])
        return case

    def __getattr__(self, name: str) -> Any:
        # Called for names that are not fields: the parameters of parts whose fields are keys.
        for member, about in members().items():
            part = self.__dict__.get(member)
            may_be_open = isinstance(about, PartOf) and about.open_kinds
            if part is not None and may_be_open and name in part.__dict__:
                return part.__dict__[name]
        raise AttributeError(f"{type(self).__name__!r} has no attribute {name!r}")

    def changed(self, **members: object) -> Self:
        """The case with other members, not checked against each other."""
        return self.of(vars(self) | members)

    @cached_property
    def geometry(self) -> type[Geometry]:
        """The kind of cells: rings for rotational symmetry, which friction as a vector breaks."""
        if self.frame is LINE_CONTACT:
            return Row if self.bulk_stress else Strips
        round_and_plain = self.indenter.is_axisymmetric and self._is_plain and not self.bulk_stress
        return Rings if round_and_plain and not self.slip_model.couples else Grid

    @cached_property
    def is_graded(self) -> bool:
        """Whether it is computed on graded rings or strips: only written fields have the `cell`."""
        return self._is_plain and not issubclass(self.geometry, Grid)

    @cached_property
    def _is_plain(self) -> bool:
        return self.rough is None and not self.loading.stroke

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

    def in_blocks(self) -> Iterator[tuple[float, Self | None]]:
        """Each block as a case (None if it is not valid), with the cycle at which it ends."""
        end = 0
        for block in self.blocks or (Block(self.cycles),):
            end += block.cycles
            changed: dict[str, object] = {"blocks": ()}
            for member, about in IN_BLOCKS.items():
                keys = about.keys
                if given := {name: value for name, value in block.values if name in keys}:
                    changed[member] = about.changed(getattr(self, member), given)
            yield end, None if None in changed.values() else self.changed(**changed)


def members() -> Mapping[str, Parameter]:
    """Return the fields of a case, except the snapshots, with their declarations."""
    return declared(Draft)


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


def cell_text(cell: Sequence[float]) -> str:
    """Return a grid spacing as study files have it."""
    return f"[{', '.join(format_quantity(spacing, LENGTH) for spacing in cell)}]"
