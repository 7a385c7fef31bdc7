"""The fields of a case, and what follows from them before its rules are checked."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Set
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Annotated, Any, Self

from fretwear.mechanics.contact.cells import Geometry
from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.rings import Rings
from fretwear.mechanics.contact.strips import Row, Strips
from fretwear.mechanics.slip.models import Auto, Cerruti, Jaeger, SlipModel
from fretwear.mechanics.surfaces.loading import Loading, SlidingDistance
from fretwear.mechanics.surfaces.setup import Setup
from fretwear.plugins import plugins
from fretwear.quantity import (
    AXES,
    Inline,
    Parameter,
    PartOf,
    Plain,
    Quantity,
    declared,
    field_names,
)
from fretwear.study.cycles import CYCLES, Block, Blocks, snapshots_of
from fretwear.study.keys import Keys
from fretwear.study.mistakes import Mistakes
from fretwear.units import LINE_CONTACT

# Packages beside the core add kinds of parts.
for _kinds in plugins("fretwear.parts").values():
    _kinds.load()

_USUAL_SLIP = Auto()
# Error of energy and wear by friction along x alone, over (1 − 1/κ)².
_OF_SLIP_MODEL = 0.125
_IN_BLOCKS = "normal", "loading", "friction_law"
# Stick zone and slip annulus, over the contact radius, up to which a grid does not resolve them.
_NARROW = 0.05
# Wear β N p_lim from which a grid takes many steps, and slip in the mean over directions costs the
# deepest wear 1 to 4 %.
_LONG = 40.0
# Wear β N p at which the elastic pressure p at the edge of stick becomes singular.
_TO_SINGULAR = 2.5
# Slip along y of an unworn sphere over its mean, less one, over κ − 1: 0.64 to 0.88 for Q/µP of 0.8
# to 0.2 (Coulomb friction as a vector). The deepest wear is too small by as much, and less later.
# Against grids, for limits of 3 to 6 p0: less than half of it is left at a wear β N p_lim of 20.
_OF_DIRECTION, _FORGOTTEN = 0.75, 20.0
CELLS_PER_YIELDING_CONTACT_RADIUS = 128
NEARLY_GROSS = 0.9999  # load ratio that stands for gross slip in a limiting state of partial slip


@dataclass(frozen=True, init=False, kw_only=True)
class FrettingContact(Setup):
    """One contact, one loading and one number of cycles; rules and default cells take it."""

    cycles: Annotated[int, CYCLES, "Number of load cycles."]
    slip_model: Annotated[
        SlipModel,
        PartOf(SlipModel, "slip model", like="cerruti"),
        "Model of slip; auto by default.",
    ] = _USUAL_SLIP
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
        "Successive blocks of loading, instead of cycles. Each has its cycles and may change load, "
        "displacement or force, and friction; base may omit parameters of the first block.",
    ] = ()
    error_estimate: Annotated[
        bool,
        Plain("", "estimate of errors", "false"),
        "Whether a run on wider cells estimates the error of every result.",
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
        "Largest relative error of wear, contact, stick zone and energy, reached by runs on ever "
        "narrower cells; none: default cells. A given cell takes precedence.",
    ] = 0.02
    budget: Annotated[
        float | None,
        Quantity("1", "budget", "budget", like="10", ge=1.0, le=1000.0),
        "Largest work to reach the accuracy, over the work on default cells; 10 by default.",
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
        values |= {n: member for n, member in assembled.items() if n in field_names(cls)}
        if blocks := values.get("blocks"):
            values["cycles"] = sum(block.cycles for block in blocks)
        estimated = values.get("error_estimate", True) or "accuracy" in assembled
        if values.get("cell") is not None or not estimated:
            values["accuracy"] = math.inf
        if cycles := values.get("cycles"):
            if isinstance(loading := values.get("loading"), SlidingDistance):
                distance = loading.sliding_distance
                values["loading"] = loading.unchecked(sliding_distance=distance, parts=cycles)
            values["output_cycles"] = snapshots_of(values.get("output_cycles"), cycles)
        # The parameters of parts whose fields are keys, by their names.
        for member, about in members().items():
            if (part := values.get(member)) is not None and is_open(about, part):
                values |= {n: v for n, v in vars(part).items() if n in part.parameters()}
        return case

    @classmethod
    def assembled(
        cls, values: Mapping[str, Any], unread: Set[str], snapshots: tuple[int, ...] | None
    ) -> tuple[FrettingContact, Mistakes]:
        """Return the case of the values of keys, and what is missing or too much.

        Its rules are not checked. It is incomplete where keys could not be read.
        """
        mistakes, keys = Mistakes(), case_keys()
        parts = {**keys.members_of(values, unread, mistakes), "output_cycles": snapshots}
        if unknown := keys.unknown(parts, unread):
            return IncompleteContact.of({**parts, "unknown": unknown}), mistakes
        return cls.of(parts), mistakes

    def changed(self, **members: object) -> Self:
        """The case with other members, not checked against each other."""
        return self.of(vars(self) | members)

    def without(self, names: Set[str]) -> FrettingContact:
        """The case without the values of some keys, as if they could not be read."""
        if not names:
            return self
        keys = case_keys()
        unknown = {name for key in names for name in (key, keys.member_of(key))}
        unknown |= vars(self).get("unknown", set())
        return IncompleteContact.of({**vars(self), "unknown": unknown})

    @cached_property
    def geometry(self) -> type[Geometry]:
        """The kind of cells: rings for rotational symmetry, which slip along one direction breaks.

        Unless a slip model along one direction is written, rings remain under a pulsating load,
        where a grid would not resolve the slip annulus, the stick zone or the ring at its edge that
        yields, and where yielding bodies wear so long that the direction hardly counts at last;
        slip is then the mean over all directions.
        """
        if self.frame is LINE_CONTACT:
            return Row if self.bulk_stress else Strips
        is_round = self.indenter.is_axisymmetric and self._is_plain and not self.bulk_stress
        if not is_round or self.slip_model.couples:
            return Grid
        if not (self.slip_varies and isinstance(self.slip_model, Auto)):
            return Grid if self.slip_varies else Rings
        is_narrow = not _NARROW < self.stick_radius / self.hertz_radius < 1.0 - _NARROW
        cell = self.hertz_radius / CELLS_PER_YIELDING_CONTACT_RADIUS
        is_narrow |= self.edge_yields and self.yielding_ring < cell
        fits = self.normal.pulsating_load == 1.0 and not (is_narrow or self.folds > _LONG)
        return Grid if fits else Rings

    @property
    def slip_varies(self) -> bool:
        """Whether slip depends on the direction from the middle of a round contact."""
        return not self.slip_model.is_isotropic and self.coupling != 1.0

    @cached_property
    def solved_slip_model(self) -> SlipModel:
        """The slip model, in whose place `auto` has one that the cells can show."""
        if not isinstance(self.slip_model, Auto):
            return self.slip_model
        has_directions = self.geometry is Grid and not self.loading.stroke
        return Cerruti() if has_directions else Jaeger()

    @cached_property
    def folds(self) -> float:
        """Wear β N p_lim: how often a contact at the plastic limit wears e-fold; 0 if elastic."""
        limit = self.slip_limit
        return 0.0 if math.isinf(limit) else self.cycles * self.wear_growth * limit

    @property
    def error_of_slip_model(self) -> float:
        """Return by which part energy and wear err because traction along y is left out.

        A traction along x alone dissipates more by the second order of 1 − 1/κ: against friction as
        a vector, by 0.12 (1 − 1/κ)² for ν of 0.15 to 0.5 and Q/µP of 0.4 and 0.8, and likewise wear
        at 300 cycles. Slip alike in all directions, as on rings, errs by twice as much.
        """
        if self.slip_model.is_isotropic or self.slip_model.couples or self.frame is LINE_CONTACT:
            return 0.0
        part = _OF_SLIP_MODEL * (2.0 if self.solved_slip_model.is_isotropic else 1.0)
        return part * (1.0 - 1.0 / self.coupling) ** 2

    def error_of_directions(self, cycle: float) -> float:
        """Return by which part the deepest wear may be too small where slip has no direction."""
        slides = self.tangential_ratio >= 1.0  # as a whole, by the same slip everywhere
        if slides or not (issubclass(self.geometry, Rings) and self.slip_varies):
            return 0.0
        worn = self.folds * cycle / self.cycles
        return _OF_DIRECTION * abs(self.coupling - 1.0) / (1.0 + worn / _FORGOTTEN)

    @cached_property
    def edge_yields(self) -> bool:
        """Whether wear brings the edge of stick of a smooth contact to the plastic limit.

        The neighbourhood of the edge has no length scale: its pressure p follows from β N p alone.
        On rings and strips it reached the limit at 2.5 (1 − p/p_lim) or up to a third later, for
        Q/µP of 0.1 to 0.9 and limits of 1.05 to 5 p0.
        """
        if math.isinf(self.plastic_limit):
            return False
        edge = float(self.hertz.pressure(self.stick_radius))
        worn = self.cycles * self.wear_growth * edge
        return worn > _TO_SINGULAR * (1.0 - edge / self.slip_limit)

    @cached_property
    def yielding_ring(self) -> float:
        """Width, m, of the ring at the stick edge that yields in the course of wear.

        Wear moves all pressure of a smooth contact into its stick zone, where it tends to
        `LimitingState.pressure`; the ring is where this exceeds the plastic limit: zero for an
        elastic case, at most the stick radius.
        """
        if math.isinf(self.plastic_limit):
            return 0.0
        ratio = min(self.tangential_ratio, NEARLY_GROSS)
        return self.indenter.limiting(self.hertz, ratio).width_above(self.slip_limit)

    @cached_property
    def is_graded(self) -> bool:
        """Whether it is computed on graded rings or strips: only written fields have the `cell`."""
        return self._is_plain and not issubclass(self.geometry, Grid)

    @cached_property
    def _is_plain(self) -> bool:
        return self.rough is None and not self.loading.stroke

    # Loading.

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


class UnknownValueError(Exception):
    """A value is asked for that could not be read."""


@dataclass(frozen=True, init=False, kw_only=True)
class IncompleteContact(FrettingContact):
    """A contact some of whose values could not be read; to ask for one raises an error."""

    unknown: Set[str] = frozenset()  # names of attributes

    def __getattribute__(self, name: str) -> Any:
        if name in super().__getattribute__("unknown"):
            raise UnknownValueError(name)
        return super().__getattribute__(name)


def members() -> Mapping[str, Parameter]:
    """Return the fields of a case, except the snapshots, with their declarations."""
    return declared(FrettingContact)


def case_keys() -> Keys:
    """Return the keys of a case with the kinds that there are."""
    families = (about.family for about in members().values() if isinstance(about, PartOf))
    return _keys(tuple(tuple(family.kinds().items()) for family in families))


@lru_cache(2)
def _keys(_: tuple[tuple[tuple[str, type], ...], ...]) -> Keys:
    return Keys(FrettingContact)


def is_open(about: Parameter, value: object) -> bool:
    """Whether the fields of a part are keys of the case."""
    if isinstance(about, Inline):
        return value is not None
    return isinstance(about, PartOf) and getattr(value, "kind", "") == about.short != ""
