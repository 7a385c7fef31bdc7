"""The contact after a number of cycles, and the problem that it belongs to."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, isfinite
from typing import Any

import numpy as np

from fretwear.mechanics.contact import Contact, ContactProblem, HalfSpace, Layer, is_finite
from fretwear.mechanics.geometry import Array, Even, Mask, Workspace
from fretwear.mechanics.geometry.dense import Line
from fretwear.mechanics.geometry.grid import Grid
from fretwear.mechanics.geometry.rings import Rings
from fretwear.mechanics.loading import Loading, Normal, Sliding
from fretwear.mechanics.materials import Archard, Bodies, Friction, WearLaw
from fretwear.mechanics.roughness import Roughness
from fretwear.mechanics.slip import ReducedContact, SlipModel
from fretwear.mechanics.surfaces import Indenter
from fretwear.mechanics.team import ALONE, Team
from fretwear.theory import HertzContact, find_root

Geometry = Grid | Rings | Line

CONTACT_GAP = 1e-5
"""Largest gap of a cell in contact, relative to the approach.

Where worn surfaces conform, pressure and gap vanish together: a contact read off p > 0 would
collapse to the stick zone after many cycles.
"""

# Fields of a state that other cells take over as they are.
FIELDS = ("pressure", "wear", "opening", "plastic", "pressure_rate", "source_rate")
# Columns of cells whose heights are computed at a time.
_COLUMNS = 64


@dataclass(frozen=True)
class WearProblem:
    """Two bodies pressed together that slip back and forth."""

    indenter: Indenter  #: the smooth part of the unworn gap
    roughness: Roughness | None  #: the rest of it; None where smooth
    bodies: Bodies  #: what deforms
    normal: Normal  #: what presses the bodies together, in SI units
    loading: Loading  #: what is imposed along x, in SI units
    friction: Friction  #: what resists slip
    wear_law: WearLaw  #: what is worn
    slip_model: SlipModel  #: how slip follows from the contact
    limit: float  #: largest pressure, Pa; infinite when elastic
    spacing: tuple[float, float]  #: cell size along x and y, m
    extent: tuple[float, float]  #: half-widths along x and y, m, of the first window
    team: Team = ALONE  #: threads that share the work on fields
    geometry: type[Geometry] = Grid  #: what cells to compute on
    debris_fraction: float = 0.0  #: part γ of the wear that stays between the bodies, bearing load
    #: How many times wider than usual rings and strips are; fields and peaks are still those of
    #: cells as large as the spacing.
    coarseness: float = 1.0
    end: float = inf  #: the cycle up to which this holds
    following: WearProblem | None = None  #: the problem that follows then, of the same bodies

    def sliding(self, load: float, approach: float) -> Sliding:
        """The condition on the reduced contact of a contact with a load, N, and an approach, m."""
        friction, series = self.friction.coefficient, self.flexibility
        return self.loading.sliding(friction, self.coupling, load, approach, series)

    @property
    def flexibility(self) -> float:
        """Flexibility in series with the contact, m/N."""
        return self.loading.flexibility(self.hertz)

    @property
    def unworn_sliding(self) -> Sliding:
        """The condition on the reduced contact of the unworn smooth contact."""
        return self.sliding(self.hertz.load, self.hertz.approach)

    @property
    def stick_load(self) -> float:
        """Reduced load P*, N, of the unworn smooth contact: P − Q/µ."""
        return self.unworn_sliding.of_smooth(self.hertz)[0]

    @property
    def changes(self) -> bool:
        """Whether friction or the wear coefficient change in the course of a run."""
        return bool(self.friction.kinks) or self.wear_law.follows_power

    def at(self, cycle: float, energy_density: float = 0.0) -> WearProblem:
        """The problem at a cycle, with its friction and wear coefficient.

        ``energy_density`` is the energy per cycle and area of contact, J/m².
        """
        if cycle > self.end and self.following is not None:
            return self.following.at(cycle, energy_density)
        if not self.changes:
            return self
        friction = self.friction.at(cycle)
        law = self.wear_law
        if law.follows_power:
            worn, shares = law.coefficient(friction, energy_density), law.shares
            law = Archard(worn if shares is None else (shares[0] * worn, shares[1] * worn))
        return replace(self, friction=friction, wear_law=law)

    @property
    def slip_moves(self) -> bool:
        """Whether the reduced contact changes although nothing yields.

        Wear outside the stick zone does not change the contact under a reduced load. The contact at
        a reduced approach follows the approach of the bodies, and a load that is not held falls.
        """
        steady = self.loading.is_ratio or not self.friction.kinks
        fixed = self.loading.is_force and self.normal.holds_load and steady
        return self.slip_model.follows_shape and not fixed

    def contact(
        self, half_space: HalfSpace, shape: Array, layer: Layer | None = None
    ) -> ContactProblem:
        """The normal contact of a shape, m."""
        load, approach = self.normal.given
        return ContactProblem(half_space, shape, load, self.limit, layer, approach)

    def load_of(self, geometry: Any, contact: Contact) -> float:
        """P, N, of a contact: that is held, or what it carries."""
        held = self.normal.holds_load
        return float(self.normal.given[0] if held else geometry.integral(contact.pressure))

    @property
    def wear_coefficient(self) -> float:
        """Worn depth per pressure and sliding distance K, 1/Pa."""
        return self.wear_law.coefficient(self.friction)

    @property
    def growth_rate(self) -> float:
        """β = 4 K µκ, 1/Pa per cycle: relative growth of g* per unit pressure."""
        return 4.0 * self.wear_coefficient * self.friction.coefficient * self.coupling

    @property
    def coupling(self) -> float:
        """κ, tangential compliance of the bodies relative to the normal one."""
        return self.indenter.coupling(self.bodies)

    @property
    def hertz(self) -> HertzContact:
        """The unworn smooth contact."""
        return self.indenter.hertz(self.normal, self.bodies.composite_modulus)

    @property
    def even(self) -> Even:
        """The axes along which the unworn gap is even, so that only one side is computed."""
        x, y = self.indenter.even
        rough = (True, True) if self.roughness is None else self.roughness.even
        return x and rough[0], y and rough[1]

    def half_space(self, geometry: Any, parts: dict[Any, Any] | None = None) -> Any:
        """The elastic bodies on the cells of a geometry."""
        return geometry.half_space(self.bodies.composite_modulus, self.team, parts)

    def unworn(self, geometry: Any) -> Array:
        """Gap at zero load and zero approach, m, on the cells of a geometry."""
        x, y = geometry.x, geometry.y
        cell = geometry.spacing if isinstance(geometry, Grid) else None

        def gap(first: int) -> Array:
            columns = y[first : first + _COLUMNS]
            smooth = self.indenter.gap(x[:, None], columns[None, :])
            rough = self.roughness
            return smooth if rough is None else smooth + rough.mean_height(x, columns, cell)

        return np.concatenate(self.team.each(gap, range(0, y.size, _COLUMNS)), axis=1)

    @property
    def wavelengths(self) -> tuple[float, float] | None:
        """Distance to the next asperity tip along x and y, m; None if smooth."""
        if self.roughness is None:
            return None
        x, y = (each if isfinite(each) else 0.0 for each in self.roughness.wavelengths)
        return x, y

    def reach(self, approach: float) -> tuple[float, float]:
        """Distance along x and y beyond which the unworn surface lies above an approach, m."""
        height = approach + (0.0 if self.roughness is None else self.roughness.highest)
        found = []
        for axis, high in zip(np.eye(2), self.extent, strict=True):

            def below(distance: float, axis: Array = axis) -> float:
                return height - float(self.indenter.gap(*(distance * axis)))

            while below(high) > 0.0:
                high *= 2.0
            found.append(find_root(below, 0.0, high))
        return found[0], found[1]

    def shear_traction(self, pressure: Array, reduced: ReducedContact) -> Array:
        """Traction along x at +Q, Pa: µ p in the slip zone, µ (p − p*) in the stick zone."""
        return self.friction.coefficient * (pressure - reduced.pressure)

    def slip(self, reduced: ReducedContact) -> Array:
        """Slip amplitude from 0 to Q, m: s = µκ g*; a whole cycle travels 4 s."""
        return self.friction.coefficient * self.coupling * reduced.gap

    def tangential_displacement(self, approach: float, reduced: ReducedContact) -> float:
        """Relative displacement of distant points along x at +Q, m: µκ (δ − δ*).

        Where slip is that of another contact than the given one, the unworn, so is δ.
        """
        if not (self.slip_model.follows_shape or self.loading.stroke):
            approach = self.hertz.approach
        return self.friction.coefficient * self.coupling * (approach - reduced.approach)

    def of(self, state: State) -> WearProblem:
        """The problem at the cycle of a state."""
        return self.worn_by(state, state.cycle, state.geometry)[0]

    def worn_by(self, stage: Stage, cycle: float, geometry: Geometry) -> tuple[WearProblem, float]:
        """The problem at a cycle, with the wear coefficient of a contact, and its energy density.

        The energy per cycle and area of contact, J/m², is 0 unless wear follows the power.
        """
        now = self.at(cycle)
        if not self.wear_law.follows_power:
            return now, 0.0
        area = geometry.integral(in_contact(stage).astype(float))
        density = now.dissipated_energy(stage, geometry) / area
        return self.at(cycle, density), density

    def dissipated_energy(self, stage: Stage, geometry: Geometry) -> float:
        """Energy dissipated in a cycle, D = ∬ 4 µ p s dA, J."""
        slip = self.slip(stage.reduced)
        return 4.0 * self.friction.coefficient * geometry.integral(stage.pressure * slip)

    def tangential_force(self, load: float, reduced: ReducedContact) -> float:
        """Amplitude Q of the tangential force, N: µ (P − P*)."""
        return self.friction.coefficient * (load - reduced.load)


def in_contact(stage: Stage) -> Mask:
    """Cells under pressure, and those whose gap is at most `CONTACT_GAP` of the approach.

    The approach counts from the smooth sphere: bodies that touch in deep valleys of roughness
    only have a negative one.
    """
    return np.asarray((stage.pressure > 0) | (stage.gap <= CONTACT_GAP * abs(stage.approach)))


@dataclass(frozen=True, kw_only=True)
class Stage:
    """A self-consistent contact: that of a state, or at the end of a stage."""

    pressure: Array  #: p, Pa, shape of the geometry as for all fields
    gap: Array  #: m
    wear: Array  #: wear depth of both bodies, m
    opening: Array  #: what wear has added to the gap at no load, m: all but what stayed as debris
    plastic: Array  #: plastic depth, m
    load: float  #: P, N
    approach: float  #: δ, m
    residual: float  #: largest violation of the gap conditions over the largest displacement
    reduced: ReducedContact  #: the contact at the reduced load, from which slip follows
    yielded: bool = False  #: whether plastic flow in the last stage changed the reduced contact

    def source_since(self, base: Stage, team: Team = ALONE) -> Any:
        """Change of G since another stage, m: of g* minus the gap opened by wear.

        It changes only with the reduced contact.
        """
        return team.cellwise(
            lambda gap, opened, gap_then, opened_then: (gap - opened) - (gap_then - opened_then),
            *(self.reduced.gap, self.opening, base.reduced.gap, base.opening),
        )

    @property
    def is_finite(self) -> bool:
        """Whether every field is finite everywhere."""
        fields = (self.pressure, self.gap, self.wear, self.plastic, self.reduced.gap)
        return all(map(is_finite, fields))


@dataclass(frozen=True, kw_only=True)
class State(Stage):
    """The contact after a number of cycles, with everything that a later step needs."""

    cycle: float  #: number of cycles N; between the requested ones not an integer
    geometry: Geometry  #: where the fields are given; outside, nothing has touched yet
    next_step: float  #: number of cycles that the next step should try
    pressure_rate: Array  #: how p, Pa, changed per cycle in the last step: a guess for the next one
    source_rate: Array  #: the same of G of `source_since`, m
    step: int = 0  #: how many steps were accepted so far
    error_estimate: float = 0.0  #: error of the last step's wear relative to the wear volume
    convolutions: int = 0  #: of the half-space, spent so far, rejected steps included

    def on(self, workspace: Workspace, geometry: Any) -> State:
        """The same state on other cells; gaps are computed where they were not known."""
        old = self.geometry
        if geometry == old:
            return self
        ground, problem = workspace.on(geometry), workspace.problem
        fields: dict[str, Any] = {
            name: old.resized(getattr(self, name), geometry) for name in FIELDS
        }
        if self.opening is self.wear:
            fields["opening"] = fields["wear"]
        fields["pressure"] = np.clip(fields["pressure"], 0.0, problem.limit)
        shape = ground.unworn + fields["opening"] + fields["plastic"]
        here, there = geometry.where(old), old.where(geometry)

        def gap(pressure: Array, approach: float, known: Array) -> Array:
            moved = ground.half_space.displacement(pressure)
            found = np.where(pressure > 0, 0.0, np.maximum(moved + shape - approach, 0.0))
            found[here] = known[there]
            return found

        reduced, spent = self.reduced, 2
        stuck = old.resized(reduced.pressure, geometry)
        if self.wear[there].shape == self.wear.shape and problem.slip_model.follows_shape:
            response = reduced.response
            if response is not None:
                farther = np.full(geometry.shape, response[-1])
                farther[here], response = response[there], farther
            open_by = gap(stuck, reduced.approach, reduced.gap)
            reduced = replace(reduced, pressure=stuck, gap=open_by, response=response)
        else:
            start = replace(reduced, pressure=np.maximum(stuck, 0.0))
            now = problem.at(self.cycle)
            sliding = now.sliding(self.load, self.approach)
            reduced = now.slip_model.reduced(now, ground.half_space, shape, sliding, start)
            spent += reduced.convolutions
        return replace(
            self,
            geometry=geometry,
            gap=gap(fields["pressure"], self.approach, self.gap),
            reduced=reduced,
            convolutions=self.convolutions + spent,
            **fields,
        )
