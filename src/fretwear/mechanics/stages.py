"""One implicit stage of a wear step.

A stage asks for the pressure whose wear gives the shape that carries it: one normal contact with
a `fretwear.mechanics.slip.WearLayer`. Where the pressure is at its limit the surface sinks by
the penetration of that contact. This changes the contact at the reduced load, which is solved
again on the stage's own shape, in turn with the contact itself, until the wear no longer changes.
"""

from __future__ import annotations

from dataclasses import replace
from math import inf
from typing import Any

import numpy as np

from fretwear.mechanics.contact import Accuracy, Contact, ContactError, Layer
from fretwear.mechanics.geometry import Array, Workspace
from fretwear.mechanics.loading import Sliding
from fretwear.mechanics.slip import WearLayer
from fretwear.mechanics.solver import solve_contact
from fretwear.mechanics.state import Stage, WearProblem

_LARGEST_SWEEPS = 12
# A cell with less than this part of the mean pressure carries none.
_IDLE = 1e-3


def load_of(problem: WearProblem, geometry: Any, contact: Contact) -> float:
    """P, N, of a contact."""
    held, _ = problem.normal.given
    load = geometry.integral(contact.pressure) if held is None else held
    return float(load)


class StageSolver:
    """Solves the implicit stages of wear steps on one geometry.

    Parameters
    ----------
    workspace
        Of the problem.
    geometry
        Where.
    tolerance
        Of the wear of a step, relative to the wear volume.
    accuracy
        Of the contacts.

    Attributes
    ----------
    convolutions
        Spent so far.
    """

    def __init__(
        self,
        workspace: Workspace,
        geometry: Any,
        tolerance: float,
        accuracy: Accuracy | None = None,
    ) -> None:
        self.problem = workspace.problem
        self.geometry = geometry
        self.tolerance = tolerance
        self.accuracy = accuracy or Accuracy()
        self.convolutions = 0
        self.ground = workspace.on(geometry)

    def solve(
        self,
        base: Stage,
        known: Array,
        rate: float,
        start: Array,
        guess: Array,
        tolerance: float,
        *,
        output_step: bool = True,
        problem: WearProblem | None = None,
    ) -> Stage:
        """One implicit stage.

        Parameters
        ----------
        base
            Where it starts.
        known, rate
            The stage's exponent is x = known + rate · p with its pressure p, Pa.
        start
            First guess of the pressure, Pa.
        guess
            First guess of the change of G by plastic flow, m.
        tolerance
            Of the contact.
        output_step
            Whether the stage ends at a requested cycle: only there the reduced contact is solved
            to the last digit, and the residual is computed by a convolution of its own.
        problem
            As it is at the end of the stage, where it changes.

        Raises
        ------
        ContactError
            If a contact does not converge, if flow and wear do not converge in turn, or if a value
            is not finite.
        """
        problem, integral = problem or self.problem, self.geometry.integral
        team = self.ground.half_space.team
        cellwise = team.cellwise
        model, moves = problem.slip_model, self.problem.slip_moves
        bodies, unworn = self.ground.half_space, self.ground.unworn
        reduced = base.reduced
        shift, response, level = None, None, 0.0
        if moves:
            # Cells that come to stick lose their gap, not more.
            shift = cellwise(lambda guess, gap: np.maximum(guess, -gap), guess, reduced.gap)
            if reduced.response is not None and problem.normal.holds_load:
                response = np.where(shift > guess, 0.0, reduced.response)
                level = _approach_of(guess, base, problem.sliding(base.load, base.approach))
        elif base.yielded:
            shift = guess
        kept = problem.debris_fraction
        opened, opens = ((1.0 - kept) * known, (1.0 - kept) * rate) if kept else (known, rate)
        relaxation, before = 1.0, inf
        for _ in range(_LARGEST_SWEEPS):
            layer = model.wear_layer(base.opening, base.reduced.gap, shift, opened, opens)
            if response is not None and isinstance(layer, WearLayer):
                layer = replace(layer, response=response, level=level)
            contact = self._contact(base.plastic, layer, start, tolerance, verified=output_step)
            start = contact.pressure
            layer = layer.at(contact.approach)
            shift = layer.shift if isinstance(layer, WearLayer) else shift
            opening = layer.displacement(start, team)
            gap = cellwise(lambda gap: np.maximum(gap, 0.0), contact.gap)
            worn = cellwise(np.subtract, opening, base.opening)
            overshoot = self._overshoot(contact, worn)
            if overshoot is not None:
                for field in (opening, worn, gap):
                    field -= overshoot
            plastic, yielded = base.plastic, False
            if contact.yields:
                plastic = cellwise(np.add, plastic, contact.penetration)
                yielded = model.follows_shape
            load = load_of(problem, self.geometry, contact)
            if yielded or moves:
                reduced = model.reduced(
                    problem,
                    bodies,
                    cellwise(lambda h, opened, sunk: h + opened + sunk, unworn, opening, plastic),
                    problem.sliding(load, contact.approach),
                    reduced,
                    self.accuracy.reduced if output_step else self.accuracy.reduced_between,
                )
                self.convolutions += reduced.convolutions
            else:
                reduced_gap = model.gap_after(base.reduced.gap, worn)
                reduced = replace(base.reduced, gap=reduced_gap)
            wear = opening
            if kept:
                wear = base.wear + all_worn(
                    kept, worn, base.reduced.gap, shift, known + rate * start
                )
            stage = Stage(
                pressure=start,
                gap=gap,
                wear=wear,
                opening=opening,
                plastic=plastic,
                load=load,
                approach=contact.approach,
                residual=contact.residual,
                reduced=reduced,
                yielded=yielded,
            )
            if not yielded and shift is None:
                break
            missing = stage.source_since(base, team)
            if shift is not None:
                missing = cellwise(np.subtract, missing, shift)
            # What the flow that is missing would have worn off, or slip that changes on the way.
            nothing, lost = np.zeros_like(opening), cellwise(np.abs, missing)
            slides = moves and not yielded
            flow = WearLayer(
                nothing,
                nothing if slides else lost,
                lost if slides else None,
                opened,
                opens,
            )
            change = integral(flow.displacement(start, team))
            enough = self.accuracy.sweep if response is None else self.accuracy.following
            if change <= enough * self.tolerance * integral(opening):
                break
            if change > 0.5 * before:
                # Flow lets wear catch up, and that stops the flow: meet in the middle.
                relaxation = max(0.5 * relaxation, 0.1)
            before = change
            if shift is None:
                shift = missing
            else:
                shift = cellwise(
                    lambda known, new, part: known + part * new, shift, missing, relaxation
                )
            if response is not None:
                response, level = reduced.response, contact.approach
        else:
            raise ContactError(
                f"slip and wear of a stage did not converge in {_LARGEST_SWEEPS} sweeps"
            )
        if not stage.is_finite:
            raise ContactError("wear of a stage leads to values that are not finite")
        return stage

    def _contact(
        self, plastic: Array, layer: Layer, start: Array, tolerance: float, *, verified: bool
    ) -> Contact:
        bodies, unworn = self.ground.half_space, self.ground.unworn
        shape = bodies.team.cellwise(np.add, unworn, plastic)
        problem = self.problem.contact(bodies, shape, layer)
        try:
            contact = solve_contact(
                problem, start, tolerance, verified=verified, effort=self.accuracy.effort
            )
        except ContactError as error:
            self.convolutions += error.convolutions
            raise
        self.convolutions += contact.convolutions
        return contact

    def _overshoot(self, contact: Contact, wear: Array) -> Array | None:
        """Wear beyond the surface of the other body, m; None if there is none.

        Wear needs pressure, so it cannot open a gap: a cell that wore in this stage touches.  A
        long step removes too much where a cell loses its pressure on the way, and a contact solved
        to a tolerance removes a little too much where hardly any is left; either would stay open
        for ever.
        """
        idle = _IDLE * np.average(contact.pressure, weights=self.geometry.weights)

        def beyond(pressure: Array, gap: Array, wear: Array) -> Array:
            outside = (gap > 0) & (wear > 0) & (pressure <= idle)
            return np.where(outside, np.minimum(gap, wear), 0.0)

        cellwise = self.ground.half_space.team.cellwise
        result: Array = cellwise(beyond, contact.pressure, contact.gap, wear)
        return result if result.any() else None


def all_worn(kept: float, opened: Array, gap: Array, shift: Array | None, exponent: Array) -> Array:
    """Wear depth of a stage, m, of which a part is kept as debris and the rest opens the gap.

    Debris that keeps all of it leaves the gap as it is, and ∫g* dx = x (g*₀ + ΔG/2).
    """
    if kept < 1.0:
        return opened / (1.0 - kept)
    return exponent * (gap if shift is None else gap + 0.5 * shift)


def _approach_of(guess: Array, base: Stage, sliding: Sliding) -> float:
    """The approach of the bodies, m, that a change of G, m, belongs to.

    Beyond the contact nothing changes G but the reduced approach: with the bodies, or with µ.
    """
    reduced = base.reduced
    assert reduced.response is not None
    ahead = float(guess[-1, 0] / reduced.response[-1, 0])
    level = reduced.approach + sliding.flexibility * reduced.load
    return base.approach + ahead + level - sliding.level
