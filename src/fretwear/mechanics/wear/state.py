"""The contact after a number of cycles, and the problem that it belongs to."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from math import inf, nan
from typing import Any, Self

import numpy as np

from fretwear.arrays import Array, Mask
from fretwear.mechanics.contact.cells import Geometry, HalfSpace
from fretwear.mechanics.contact.dense import interpolated
from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.problem import Contact, ContactProblem, Layer, is_finite
from fretwear.mechanics.slip.models import Pressed, ReducedContact, SlipModel, WearLayer
from fretwear.mechanics.surfaces.coating import Interface
from fretwear.mechanics.surfaces.laws import Means
from fretwear.mechanics.surfaces.setup import Setup, block_at
from fretwear.theory import find_root

CONTACT_GAP = 1e-5
"""Largest gap of a cell in contact, relative to the approach.

Where worn surfaces conform, pressure and gap vanish together: a contact read off p > 0 would
collapse to the stick zone after many cycles.
"""

# Fields of a state that move to other cells unchanged.
_RESIZED = ("pressure", "wear", "opening", "plastic", "pressure_rate", "source_rate")
# Smallest fraction by which the pressure limit is relaxed.
_LEAST_PART = 0.2
# Columns of cells whose heights are computed at a time.
_COLUMNS = 64


@dataclass(frozen=True, kw_only=True)
class WearProblem(Setup):
    """A setup on cells, in blocks of loading that follow each other."""

    slip_model: SlipModel  #: how slip follows from the contact
    spacing: tuple[float, float]  #: cell size along x and y, m
    extent: tuple[float, float]  #: half-widths along x and y, m, of the first window
    geometry: type[Geometry] = Grid  #: kind of cells to compute on
    #: Factor on the usual width of rings and strips; fields and peaks are still means over cells of
    #: the spacing.
    coarseness: float = 1.0
    #: The setups, this one first, each with the cycle up to which it holds; empty if there is only
    #: this one.
    blocks: tuple[tuple[float, Setup], ...] = ()

    def with_setup(self, setup: Setup) -> WearProblem:
        """Another setup of the same bodies on the same cells, from now on."""
        return replace(self, **vars(setup.setup), blocks=())

    def at(self, cycle: float) -> WearProblem:
        """The problem at a cycle: in its block, with each part as it is then."""
        if not self.blocks:
            return super().at(cycle)
        return self.with_setup(block_at(self.blocks, cycle)).at(cycle)

    def contact(
        self,
        half_space: HalfSpace,
        shape: Array,
        layer: Layer | None = None,
        limit: float | Array = inf,
    ) -> ContactProblem:
        """The normal contact of a shape, m, under a pressure limit, Pa."""
        load, approach = self.normal.held
        return ContactProblem(half_space, shape, load, limit, layer, approach)

    def over_substrate(self, layer: Layer) -> Layer:
        """A layer of wear with the interface below which the wear coefficient differs."""
        if self.interface is None or not (self.changes_below and isinstance(layer, WearLayer)):
            return layer
        return replace(layer, interface=self.interface.opened(1.0 - self.debris_fraction))

    def load_of(self, geometry: Geometry, contact: Contact) -> float:
        """P, N, of a contact: the held load, or else the load that it carries."""
        load, _ = self.normal.held
        return geometry.integral(contact.pressure) if load is None else float(load)

    def half_space(self, geometry: Geometry) -> HalfSpace:
        """The elastic bodies on the cells of a geometry."""
        return geometry.half_space(self.composite_modulus, self.film)

    def unworn(self, geometry: Geometry) -> Array:
        """Gap at zero load and zero approach, m, on the cells of a geometry."""
        x, y, rough = geometry.x, geometry.y, self.rough
        cell = geometry.spacing if isinstance(geometry, Grid) else None

        def gap(first: int) -> Array:
            columns = y[first : first + _COLUMNS]
            smooth = self.indenter.gap(x[:, None], columns[None, :])
            return smooth if rough is None else smooth + rough.mean_height(x, columns, cell)

        return np.concatenate([gap(first) for first in range(0, y.size, _COLUMNS)], axis=1)

    def reach(self, approach: float) -> tuple[float, float]:
        """Distance along x and y beyond which the unworn surface lies above an approach, m."""
        height = approach + (0.0 if self.rough is None else self.rough.highest)
        distances = []
        for axis, high in zip(np.eye(2), self.extent, strict=True):

            def height_below(distance: float, axis: Array = axis) -> float:
                return height - float(self.indenter.gap(*(distance * axis)))

            while height_below(high) > 0.0:
                high *= 2.0
            distances.append(find_root(height_below, 0.0, high))
        return distances[0], distances[1]

    # Tractions and slip of a reduced contact.

    def shear_traction(self, pressure: Array, reduced: ReducedContact) -> Array:
        """Traction along x at +Q, Pa: µ p in the slip zone, µ (p − p*) in the stick zone.

        If friction follows slip, the pressure is ψp, and µ is the coefficient. The result is
        clipped to ±µ p. That matters only for slip models whose p* belongs to another surface and
        may exceed 2p; otherwise p* never exceeds p.
        """
        if reduced.sheared is not None:
            return np.asarray(reduced.sheared.traction[0])
        friction = self.friction_law.coefficient
        most = friction * pressure
        return np.clip(friction * (pressure - reduced.pressure), -most, most)

    def limit_without_shear(self, wear: Array) -> float | Array:
        """Plastic limit, Pa, of all cells or of each at a wear depth, m."""
        above, below = self.plastic_limits
        if above == below or self.interface is None:
            return above
        return np.where(self.interface.reached(wear), below, above)

    def pressure_limit(
        self, pressure: Array, reduced: ReducedContact, wear: Array
    ) -> float | Array:
        """Largest pressure, Pa, of all cells or of each, under the shear traction of a contact."""
        highest = self.limit_without_shear(wear)
        if not self.junction_growth:
            return highest
        if not reduced.pressure.any():
            return self.shear_on_limit * highest
        growth = self.junction_growth * self.friction_law.coefficient**2
        return self.slip_model.limit(highest, growth, pressure, reduced)

    def slip(self, reduced: ReducedContact) -> Array:
        """Slip amplitude from 0 to Q, m: s = µκ g*; a whole cycle travels 4 s."""
        return self.friction_law.coefficient * self.coupling * reduced.gap

    def tangential_displacement(self, approach: float, reduced: ReducedContact) -> float:
        """Relative displacement of distant points along x at +Q, m: µκ (δ − δ*).

        If slip follows from the unworn contact, so does δ.
        """
        if not (self.slip_model.follows_shape or self.loading.stroke):
            approach = self.hertz.approach
        return self.friction_law.coefficient * self.coupling * (approach - reduced.approach)

    def tangential_force(self, load: float, reduced: ReducedContact) -> float:
        """Amplitude Q of the tangential force, N: µ (P − P*) with the mean P of a cycle."""
        return self.friction_law.coefficient * (load - self.load_amplitude(load) - reduced.load)

    # What changes as the contact wears.

    def of(self, state: State) -> WearProblem:
        """The problem at the cycle of a state."""
        return self.worn_by(state, state.cycle, state.geometry)[0]

    def worn_by(self, stage: Stage, cycle: float, geometry: Geometry) -> tuple[WearProblem, Means]:
        """The problem at a cycle, with the wear coefficient of a contact, and its means."""
        now, means = self.at(cycle).slipped(stage.friction_energy), Means()
        if now.wear_law.follows_contact:
            means = now.means(stage, geometry)
        return now.under(means), means

    def means(self, stage: Stage, geometry: Geometry) -> Means:
        """Means of a contact, on which coefficients of wear may depend."""
        energy, friction = self.dissipated_energy(stage, geometry), self.friction_law.coefficient
        area = geometry.integral(stage.in_contact.astype(float))
        slip = energy / (4.0 * friction * self.slipping_load(stage, geometry))
        return Means(energy / area, stage.load / area, slip)

    def slipping_load(self, stage: Stage, geometry: Geometry) -> float:
        """∬ψp, N: the force that slides a contact as a whole, over the coefficient of friction."""
        law = self.friction_law
        return geometry.integral(law.ratio * stage.pressure) if law.follows_slip else stage.load

    def energy_rate(self, stage: Stage) -> Array:
        """Energy dissipated per area and cycle, 4µps, J/m²."""
        slip, law = self.slip(stage.reduced), self.friction_law
        return np.asarray(4.0 * law.coefficient * law.ratio * stage.pressure * slip)

    def dissipated_energy(self, stage: Stage, geometry: Geometry) -> float:
        """Energy dissipated in a cycle, D = ∬ 4 µ p s dA, J."""
        if stage.pulse is not None:
            return self.friction_law.coefficient * geometry.integral(stage.pulse.path)
        slip, law = self.slip(stage.reduced), self.friction_law
        return 4.0 * law.coefficient * geometry.integral(law.ratio * stage.pressure * slip)


class UnwornBodies:
    """The unworn bodies of a problem on one geometry, computed when needed."""

    def __init__(self, problem: WearProblem, geometry: Geometry) -> None:
        self._problem, self.geometry = problem, geometry

    @cached_property
    def half_space(self) -> HalfSpace:
        """The elastic bodies."""
        return self._problem.half_space(self.geometry)

    @cached_property
    def unworn(self) -> Array:
        """Gap at zero load and zero approach, m."""
        return self._problem.unworn(self.geometry)


class Workspace:
    """The workspace of a run: the unworn bodies on the two geometries used last."""

    def __init__(self, problem: WearProblem) -> None:
        self.problem = problem
        #: Contacts between the ends of the last loop and their cells, from which the next starts.
        self.of_loop: list[tuple[Geometry, ReducedContact]] = []
        self._bodies: dict[Geometry, UnwornBodies] = {}

    def on(self, geometry: Geometry) -> UnwornBodies:
        """The unworn bodies on a geometry."""
        bodies = self._bodies.pop(geometry, None) or UnwornBodies(self.problem, geometry)
        self._bodies[geometry] = bodies
        if len(self._bodies) > 2:
            del self._bodies[next(iter(self._bodies))]
        return bodies

    def keep_only(self, geometry: Geometry) -> None:
        """Drop the bodies on all geometries but one."""
        self._bodies = {geometry: self.on(geometry)}


class YieldLimit:
    """The pressure limit, iterated with the contact that depends on it.

    Shear lowers the limit, and a coating that is worn through changes it; a cell that an iterate
    has worn through keeps the limit of the substrate.

    If more cells yield under a lower limit, others bear more, which reduces the shear in the stick
    zone and raises the limit there. So the limits of successive contacts alternate, mostly in a
    single mode. Aitken's method relaxes them: Irons and Tuck, "A version of the Aitken accelerator
    for computer iteration", Int. J. Numer. Meth. Engng 1 (1969).
    """

    def __init__(
        self, problem: WearProblem, geometry: Geometry, wear: Array, value: float | Array
    ) -> None:
        self._problem, self._geometry, self._wear = problem, geometry, wear
        self.value = value  #: Pa, of all cells or of each
        self._part, self._before = 1.0, np.zeros(())

    def suits(self, contact: Contact, reduced: ReducedContact, wear: Array, enough: float) -> bool:
        """Whether a contact keeps the limit that follows from it; otherwise the limit is changed.

        The tolerance is a load, N: the excess over the new limit, plus the load missing on cells at
        the former limit.
        """
        problem, integral = self._problem, self._geometry.integral
        self._wear = np.maximum(self._wear, wear)
        pressure = contact.pressure
        limit = problem.pressure_limit(pressure, reduced, self._wear)
        if not problem.junction_growth and np.array_equal(limit, self.value):
            return True
        matters = contact.saturated | (pressure > limit)
        if integral(np.where(matters, np.abs(pressure - limit), 0.0)) <= enough:
            return True
        change = np.where(matters, limit - self.value, 0.0)
        if problem.junction_growth and self._before.any():
            turned = self._before - change
            part = self._part * integral(self._before * turned) / integral(turned * turned)
            self._part = min(max(part, _LEAST_PART), 1.0)
        self._before = change
        if isinstance(limit, np.ndarray):
            limit = self.value + self._part * (limit - self.value)
        self.value = limit
        return False


@dataclass(frozen=True)
class Pulse:
    """One cycle of a load in phase with a force, between the largest P₂ and the least P₁."""

    path: Array  #: ∫p ds over this one cycle, Pa m, shape of the geometry as for all fields
    share: Array  #: fraction of the slip of a point during which it is in contact
    least: Array  #: pressure under P₁, Pa
    least_load: float  #: P₁, N
    loads: Array  #: some loads from P₀, at which the stick zone touches, to P₂, N
    approaches: Array  #: approaches under these loads, m
    power: float  #: of the load; approaches change linearly in this power

    def approach(self, load: Array | float) -> Array:
        """The approach under a load, N, from P₀ to P₂, m."""
        power = self.power
        places = np.atleast_1d(load).astype(np.float64) ** power
        approach = interpolated(self.loads**power, self.approaches, places)
        return np.reshape(approach, np.shape(load))

    def on(self, old: Geometry, new: Geometry) -> Pulse:
        """The same on other cells."""
        fields = (self.path, self.share, self.least)
        path, share, least = (old.resized(field, new) for field in fields)
        return replace(self, path=path, share=share, least=least)


@dataclass(frozen=True, kw_only=True)
class Stage:
    """A self-consistent contact, of a state or at the end of a stage."""

    pressure: Array  #: p, Pa, shape of the geometry as for all fields
    gap: Array  #: m
    wear: Array  #: wear depth of both bodies, m
    opening: Array  #: gap opened by wear at no load, m: the wear less the debris that stays
    plastic: Array  #: plastic depth, m
    load: float  #: P, N
    approach: float  #: δ, m
    residual: float  #: largest violation of the gap conditions over the largest displacement
    reduced: ReducedContact  #: the contact at the reduced load, from which slip follows
    yielded: bool = False  #: whether plastic flow in the last stage changed the reduced contact
    pulse: Pulse | None = None  #: the cycle of a load that changes in phase with a force
    #: Energy dissipated per area since cycle 0, J/m²; None if friction does not follow it.
    friction_energy: Array | None = None

    def source_since(self, base: Stage, model: SlipModel) -> Array:
        """Change of G, the part of slip that is not due to wear, since another stage, m.

        G changes only with the reduced contact.
        """
        if not model.follows_shape:
            return self.reduced.gap - base.reduced.gap
        return (self.reduced.gap - self.opening) - (base.reduced.gap - base.opening)

    @property
    def in_contact(self) -> Mask:
        """Cells under pressure, and those whose gap is at most `CONTACT_GAP` of the approach.

        The approach counts from the smooth sphere, so bodies that touch only in deep valleys of
        roughness have a negative one.
        """
        return np.asarray((self.pressure > 0) | (self.gap <= CONTACT_GAP * abs(self.approach)))

    @property
    def mean_approach(self) -> float:
        """δ, m, averaged over the largest and the least load of a cycle."""
        if self.pulse is None:
            return self.approach
        return 0.5 * (self.approach + float(self.pulse.approach(self.pulse.least_load)))

    @property
    def is_finite(self) -> bool:
        """Whether every field is finite everywhere."""
        fields = (self.pressure, self.gap, self.wear, self.plastic, self.reduced.gap)
        return all(map(is_finite, fields))


@dataclass(frozen=True, kw_only=True)
class State(Stage):
    """The contact after a number of cycles, with everything that a later step needs."""

    cycle: float  #: number of cycles N; not an integer between requested ones
    geometry: Geometry  #: cells of the fields; outside, the bodies have not touched yet
    next_step: float  #: number of cycles that the next step should try
    #: Change of p, Pa, per cycle in the last step of usual length: a guess for the next one.
    pressure_rate: Array
    source_rate: Array  #: the same for G of `source_since`, m
    step: int = 0  #: number of accepted steps
    error_estimate: float = 0.0  #: error of the last step's wear relative to the wear volume
    worn_through: float = nan  #: cycle at which a coating was first worn through; NaN if it was not
    convolutions: int = 0  #: half-space convolutions spent so far, rejected steps included

    def wear_of_each(self, setup: Setup) -> dict[str, Array]:
        """Wear depth of indenter and flat, m, if the wear law of a setup knows them."""
        law, interface = setup.wear_law, setup.interface
        if interface is not None and setup.changes_below and law.is_of_each:
            flat = interface.of_flat(self.wear)
            return {"indenter": self.wear - flat, "flat": flat}
        return dict(
            zip(("indenter", "flat"), (part * self.wear for part in law.shares or ()), strict=False)
        )

    def flat_wear(self, interface: Interface) -> Array:
        """Wear depth of a coated flat, m."""
        return interface.of_flat(self.wear)

    def on(self, workspace: Workspace, geometry: Geometry) -> Self:
        """The same state on other cells; gaps are computed on cells that are new."""
        old = self.geometry
        if geometry == old:
            return self
        bodies, problem = workspace.on(geometry), workspace.problem
        fields: dict[str, Any] = {
            name: old.resized(getattr(self, name), geometry) for name in _RESIZED
        }
        if problem.interface is not None and not problem.interface.ratio:
            # Interpolation overshoots where wear has stopped.
            for name, part in (("wear", 1.0), ("opening", 1.0 - problem.debris_fraction)):
                fields[name] = np.minimum(fields[name], part * problem.interface.depth)
        if self.opening is self.wear:
            fields["opening"] = fields["wear"]
        if self.pulse is not None:
            fields["pulse"] = self.pulse.on(old, geometry)
        if self.friction_energy is not None:
            fields["friction_energy"] = old.resized(self.friction_energy, geometry)
        limit = problem.limit_without_shear(fields["wear"])
        fields["pressure"] = np.clip(fields["pressure"], 0.0, limit)
        shape = bodies.unworn + fields["opening"] + fields["plastic"]
        here, there = geometry.where(old), old.where(geometry)

        def gap(pressure: Array, approach: float, old_gap: Array) -> Array:
            moved = bodies.half_space.displacement(pressure)
            result = np.where(pressure > 0, 0.0, np.maximum(moved + shape - approach, 0.0))
            result[here] = old_gap[there]
            return result

        opened = gap(fields["pressure"], self.approach, self.gap)
        reduced, spent = self.reduced, 2
        stuck = old.resized(reduced.pressure, geometry)
        keeps_all = self.wear[there].shape == self.wear.shape
        if keeps_all and problem.slip_model.follows_shape and not reduced.follows_pressure:
            response = reduced.response
            if response is not None:
                farther = np.full(geometry.shape, response[-1])
                farther[here], response = response[there], farther
            open_by = gap(stuck, reduced.approach, reduced.gap)
            reduced = replace(reduced, pressure=stuck, gap=open_by, response=response)
        else:
            sheared = reduced.sheared
            if sheared is not None:
                sheared = sheared.on(lambda field: old.resized(field, geometry))
            start = replace(reduced, pressure=np.maximum(stuck, 0.0), sheared=sheared)
            now = problem.at(self.cycle).slipped(fields.get("friction_energy"))
            sliding, pressure = now.reduced_condition(self.load, self.approach), fields["pressure"]
            pressed = Pressed(bodies.half_space, shape, pressure, opened, self.approach, sliding)
            reduced = now.slip_model.reduced(now, pressed, start)
            spent += reduced.convolutions
        return replace(
            self,
            geometry=geometry,
            gap=opened,
            reduced=reduced,
            convolutions=self.convolutions + spent,
            **fields,
        )
