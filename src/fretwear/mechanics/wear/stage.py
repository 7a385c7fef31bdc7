"""One implicit stage: the pressure whose wear gives the shape that carries it.

A stage has three parts. Its normal contact has the wear as a layer between the bodies, a
`WearLayer`. Its flow follows from that contact: at the pressure limit the surface sinks by the
penetration. Flow, or a condition of sliding that changes, moves the reduced contact, which is
solved again on the stage's own shape. Both are repeated in turn until the wear due to the change of
slip settles. Friction that follows slip changes with the energy that the stage itself dissipates.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from math import inf
from typing import NamedTuple

import numpy as np

from fretwear.arrays import Array
from fretwear.mechanics.contact.problem import Accuracy, Contact, ContactError, Layer, solve_contact
from fretwear.mechanics.slip.models import Pressed, ReducedContact, WearLayer
from fretwear.mechanics.wear.state import Stage, UnwornBodies, WearProblem, YieldLimit

_LARGEST_SWEEPS = 12
# Largest exposure of a cell in a stage under a contact that follows the pressure.
_EXPOSED = 3.0
# A cell below this fraction of the mean pressure counts as unloaded.
_IDLE = 1e-3
# Tolerance of a reduced contact over that of a coarse normal contact; slip is a small part of the
# displacement.
_OF_REDUCED = 0.1


class Exposure(NamedTuple):
    """The exponent x = unloaded + rate · p of a stage as a function of its pressure p.

    A threshold of wear withholds a depth from it.
    """

    unloaded: Array  # under no pressure, shape of the geometry
    rate: float | Array  # 1/Pa, of all cells or of each
    withheld: float | Array = 0.0  # m, of all cells or of each

    def limited(self, x: Array) -> Exposure:
        """The exposure, reduced where the exponent x of a guess of the pressure is large.

        Cells beside a stick edge bear a high pressure until they slip and wear. In one long stage
        this would oscillate; with less exposure it takes a few stages.
        """
        if not (x > _EXPOSED).any():
            return self
        part = _EXPOSED / np.maximum(x, _EXPOSED)
        return Exposure(self.unloaded * part, self.rate * part, self.withheld * part)

    def opening(self, kept: float) -> Exposure:
        """The part of the exposure that opens the gap, if a fraction of the debris is kept."""
        open_part = 1.0 - kept
        return Exposure(open_part * self.unloaded, open_part * self.rate, open_part * self.withheld)

    def under(self, pressure: Array) -> Array:
        """The exponent under a pressure, Pa."""
        return np.asarray(self.unloaded + self.rate * pressure)


class Dissipation(NamedTuple):
    """The energy per area that friction follows, at the end of a stage: known + cycles · rate."""

    known: Array  # by earlier rates, J/m², shape of the geometry
    cycles: float  # weight of the rate at the end of the stage
    energy: Array  # J/m²; a guess at first


@dataclass(frozen=True)
class Drift:
    """The assumed change of G, the part of slip that is not due to wear, over a stage."""

    shift: Array | None = None  # m; None if G does not change
    response: Array | None = None  # its derivative by the approach of the bodies, if it has one
    level: float | None = None  # approach, m, at which the shift holds

    def on(self, layer: Layer) -> Layer:
        """A layer of wear whose slip follows the approach."""
        if self.response is None or not isinstance(layer, WearLayer):
            return layer
        return replace(layer, response=self.response, level=self.level)

    def corrected(self, missing: Array, stage: Stage, part: float) -> Drift:
        """The drift after a sweep that missed it by a depth, m, corrected by a part of it."""
        shift = missing
        if self.shift is not None:
            shift = self.shift + part * missing
        if self.response is None:
            return Drift(shift)
        return Drift(shift, stage.reduced.response, stage.approach)


@dataclass
class ImplicitStage:
    """A stage from a base to the time at which a problem holds."""

    base: Stage
    problem: WearProblem
    bodies: UnwornBodies
    accuracy: Accuracy
    tolerance: float  #: error of the wear of the step
    #: Whether the stage ends at a requested cycle: then the reduced contact is solved to full
    #: accuracy, and the residual follows from a separate convolution.
    output_step: bool
    dissipation: Dissipation | None = None  #: None if friction does not follow slip
    convolutions: int = 0  #: convolutions spent

    @cached_property
    def _moves(self) -> bool:
        """Whether the reduced contact changes even if nothing flows."""
        holds = self.problem.slip_model.still_holds(self.base.reduced, self.problem, self.base.load)
        return not holds

    def solve(self, exposure: Exposure, pressure: Array, change: Array, tolerance: float) -> Stage:
        """The stage, from first guesses of its pressure, Pa, and of the change of G, m.

        ``tolerance`` applies to the normal contact. A ContactError says that the iteration between
        flow and wear does not converge, or that a value is not finite. The iteration has no
        fallback: its terms are proportional to the step, which the caller halves.
        """
        drift, reduced, geometry = self._expected(change), self.base.reduced, self.bodies.geometry
        problem = self.problem
        base = self.base
        limited = problem.pressure_limit(base.pressure, reduced, base.wear)
        limit = YieldLimit(problem, geometry, base.wear, limited)
        if reduced.follows_pressure:
            highest = np.maximum(pressure, base.pressure)
            exposure = exposure.limited(self._exponent(exposure, drift, highest))
        relaxation, previous, usual = 1.0, inf, exposure
        for _ in range(_LARGEST_SWEEPS):
            contact, layer = self._normal_contact(exposure, drift, limit.value, pressure, tolerance)
            if isinstance(layer, WearLayer):
                drift = replace(drift, shift=layer.shift)
            stage = self._flow(exposure, contact, layer, reduced, tolerance)
            pressure, reduced = stage.pressure, stage.reduced
            allowed = self.accuracy.limit * self.tolerance * stage.load
            settled = limit.suits(contact, reduced, stage.wear, allowed) & self._rubs_alike(stage)
            exposure = self._rubbed(usual, problem)
            if not stage.yielded and drift.shift is None:
                if settled:
                    break
                continue
            missing, lost = self._missing(exposure, drift, stage)
            enough = self.accuracy.sweep if drift.response is None else self.accuracy.following
            if settled and lost <= enough * self.tolerance * geometry.integral(stage.opening):
                break
            if settled and lost > 0.5 * previous:
                # Flow lets wear catch up, which stops the flow: average both.
                relaxation = max(0.5 * relaxation, 0.1)
            previous = lost
            drift = drift.corrected(missing, stage, relaxation)
        else:
            raise ContactError(
                f"slip and wear of a stage did not converge in {_LARGEST_SWEEPS} sweeps"
            )
        if not stage.is_finite:
            raise ContactError("wear of a stage leads to values that are not finite")
        if self.dissipation is not None:
            stage = replace(stage, friction_energy=self.dissipation.energy)
        return stage

    def _rubs_alike(self, stage: Stage) -> bool:
        """Whether friction suits the energy that a stage dissipates; else friction is changed."""
        if self.dissipation is None:
            return True
        known, cycles, _ = self.dissipation
        energy = known + cycles * self.problem.energy_rate(stage)
        law, integral = self.problem.friction_law, self.bodies.geometry.integral
        ratio = law.slipped(energy).ratio
        changed = integral(np.abs(ratio - law.ratio) * stage.pressure)
        slipping = integral(np.where(stage.reduced.stick, 0.0, ratio * stage.pressure))
        if changed <= self.accuracy.sweep * self.tolerance * slipping:
            return True
        self.problem, self.dissipation = (
            self.problem.slipped(energy),
            self.dissipation._replace(energy=energy),
        )
        return False

    def _rubbed(self, exposure: Exposure, expected: WearProblem) -> Exposure:
        """The exposure under the present friction, from the exposure under the expected one."""
        if self.dissipation is None:
            return exposure
        unloaded, rate, withheld = exposure
        # Both scale with the friction at the end of the stage.
        rate = rate * (self.problem.local_wear_growth / expected.local_wear_growth)
        more = self.problem.withheld_depth - expected.withheld_depth
        return Exposure(unloaded, rate, withheld + self.dissipation.cycles * more)

    def _expected(self, change: Array) -> Drift:
        """The drift of a stage with a probable change of G, m."""
        base, problem, reduced = self.base, self.problem, self.base.reduced
        if not self._moves:
            return Drift(change if base.yielded else None)
        if reduced.follows_pressure:
            return Drift(_bounded(change, reduced.gap))
        # Cells that begin to stick lose their gap and no more.
        shift = np.maximum(change, -reduced.gap)
        if reduced.response is None or not problem.normal.holds_load:
            return Drift(shift)
        # Outside the contact G changes only by d*, which follows δ or µ.
        ahead = float(change[-1, 0] / reduced.response[-1, 0])
        sliding = problem.reduced_condition(base.load, base.approach)
        held = reduced.approach + sliding.flexibility * reduced.load
        level = base.approach + ahead + held - sliding.level
        return Drift(shift, np.where(shift > change, 0.0, reduced.response), level)

    def _normal_contact(
        self,
        exposure: Exposure,
        drift: Drift,
        limit: float | Array,
        pressure: Array,
        tolerance: float,
    ) -> tuple[Contact, Layer]:
        """The contact of the shape at the start of the stage, with its wear as a layer."""
        base, problem = self.base, self.problem
        layer = self._wear_layer(exposure, drift)
        sunk = self.bodies.unworn + base.plastic
        contact_problem = problem.contact(self.bodies.half_space, sunk, drift.on(layer), limit)
        try:
            contact = solve_contact(contact_problem, pressure, tolerance, verified=self.output_step)
        except ContactError as error:
            self.convolutions += error.convolutions
            raise
        self.convolutions += contact.convolutions
        return contact, drift.on(layer).at(contact.approach)

    def _wear_layer(self, exposure: Exposure, drift: Drift) -> Layer:
        """The wear of the stage as a layer between the bodies."""
        base, problem = self.base, self.problem
        opens = exposure.opening(problem.debris_fraction)
        layer = problem.slip_model.wear_layer(base.opening, base.reduced.gap, drift.shift, *opens)
        return problem.over_substrate(layer)

    def _exponent(self, exposure: Exposure, drift: Drift, pressure: Array) -> Array:
        """The exponent under a pressure, Pa, with the part that passes below an interface."""
        layer = self._wear_layer(exposure, drift)
        if not (self.problem.changes_below and isinstance(layer, WearLayer)):
            return exposure.under(pressure)
        return layer.exponent_under(pressure) / (1.0 - self.problem.debris_fraction)

    def _flow(
        self,
        exposure: Exposure,
        contact: Contact,
        layer: Layer,
        reduced: ReducedContact,
        tolerance: float,
    ) -> Stage:
        """Wear, plastic flow and reduced contact of a normal contact solved to a tolerance.

        ``reduced`` is a first guess of the latter.
        """
        base, problem = self.base, self.problem
        model, kept, pressure = problem.slip_model, problem.debris_fraction, contact.pressure
        opening = layer.displacement(pressure)
        # Gap of the displacement, slightly different from zero in the contact.
        gap, plastic = contact.gap.copy(), base.plastic
        worn = opening - base.opening
        self._close(contact, opening, worn, gap)
        yielded = contact.yields and model.follows_shape
        if contact.yields:
            plastic, gap = plastic + contact.penetration, gap + contact.penetration
        load = problem.load_of(self.bodies.geometry, contact)
        if yielded or self._moves:
            accuracy = max(self.accuracy.reduced_between, _OF_REDUCED * tolerance)
            pressed = Pressed(
                self.bodies.half_space,
                self.bodies.unworn + opening + plastic,
                pressure,
                gap,
                contact.approach,
                problem.reduced_condition(load, contact.approach),
                self.accuracy.reduced if self.output_step else accuracy,
            )
            reduced = model.reduced(problem, pressed, reduced)
            self.convolutions += reduced.convolutions
        else:
            reduced = replace(base.reduced, gap=model.gap_after(base.reduced.gap, worn))
        wear = opening
        if kept:
            exponent = exposure.under(pressure)
            gaps = base.reduced.gap, reduced.gap
            wear = base.wear + all_worn(kept, worn, *gaps, exponent, exposure.withheld)
        return Stage(
            pressure=pressure,
            gap=np.maximum(gap, 0.0),
            wear=wear,
            opening=opening,
            plastic=plastic,
            load=load,
            approach=contact.approach,
            residual=contact.residual,
            reduced=reduced,
            yielded=yielded,
        )

    def _close(self, contact: Contact, *fields: Array) -> None:
        """Subtract from opening, worn depth and gap, m, any gap that wear opened without pressure.

        Wear needs pressure, so it cannot open a gap: a cell that wore in this stage touches. A long
        step removes too much where a cell loses its pressure on the way, and a contact solved to a
        tolerance removes slightly too much where hardly any pressure is left. Both would stay.
        """
        pressure, worn = contact.pressure, fields[1]
        idle = _IDLE * np.average(pressure, weights=self.bodies.geometry.weights)
        opened = (contact.gap > 0) & (worn > 0) & (pressure <= idle)
        excess = np.where(opened, np.minimum(contact.gap, worn), 0.0)
        if excess.any():
            for field in fields:
                field -= excess

    def _missing(self, exposure: Exposure, drift: Drift, stage: Stage) -> tuple[Array, float]:
        """Change of G in a stage less the assumed one, m, and the volume that it wears, m³."""
        problem = self.problem
        missing = stage.source_since(self.base, problem.slip_model)
        if self.base.reduced.follows_pressure:
            missing = _bounded(missing, self.base.reduced.gap)
        if drift.shift is not None:
            missing = missing - drift.shift
        zeros, lost = np.zeros_like(stage.opening), np.abs(missing)
        # The wear due to the missing flow, or to slip that changes within the stage.
        opens = exposure.opening(problem.debris_fraction)
        flow = WearLayer(zeros, lost, None, opens.unloaded, opens.rate)
        if problem.changes_below:
            x = self._exponent(exposure, drift, stage.pressure)
            flow = replace(flow, exponent=(1.0 - problem.debris_fraction) * x, rate=0.0)
        if self._moves and not stage.yielded:
            flow = replace(flow, reduced_gap=zeros, shift=lost)
        depth = flow.displacement(stage.pressure)
        if np.any(opens.withheld):
            # Below the threshold, more slip wears nothing.
            shift = lost if drift.shift is None else drift.shift + lost
            whole = replace(flow, reduced_gap=self.base.reduced.gap, shift=shift)
            worn = replace(whole, withheld=opens.withheld).displacement(stage.pressure)
            depth = np.minimum(depth, worn)
        return missing, self.bodies.geometry.integral(depth)


def _bounded(change: Array, gap: Array) -> Array:
    """A change of G, m, by which g* at most doubles or vanishes over a stage.

    Beside a stick edge, where slip begins under a high pressure, a cell wears until the pressure
    has left it, whatever the change.
    """
    return np.asarray(np.clip(change, -gap, gap))


def all_worn(
    kept: float,
    opened: Array,
    first_gap: Array,
    last_gap: Array,
    exponent: Array,
    withheld: float | Array = 0.0,
) -> Array:
    """Wear depth of a stage, m, part of which is kept as debris; the rest opens the gap.

    If all debris is kept, the contact does not depend on slip, and the reduced gap changes from
    ``first_gap`` to ``last_gap`` linearly in x: ∫g* dx is x times their mean.
    """
    if kept < 1.0:
        return opened / (1.0 - kept)
    return np.maximum(0.5 * exponent * (first_gap + last_gap) - withheld, 0.0)
