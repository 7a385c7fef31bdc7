"""One implicit stage of a wear step.

A stage requires the pressure whose wear gives the shape that carries it: one normal contact with
a `fretwear.mechanics.slip.WearLayer`. Where the pressure is at its limit the surface sinks by
the penetration of that contact. This changes the contact at the reduced load, which is solved
again on the stage's own shape, in turn with the contact itself, until the wear no longer changes.
"""

from __future__ import annotations

from dataclasses import replace
from math import inf
from typing import Any

import numpy as np

from fretwear.mechanics.contact import Accuracy, ContactError
from fretwear.mechanics.geometry import Array, Workspace
from fretwear.mechanics.slip import WearLayer
from fretwear.mechanics.solver import solve_contact
from fretwear.mechanics.state import Stage, WearProblem

_LARGEST_SWEEPS = 12
# A cell with less than this fraction of the mean pressure counts as unloaded.
_IDLE = 1e-3


class StageSolver:
    """Solves the implicit stages of wear steps on one geometry, and counts its convolutions.

    ``tolerance`` is that of the wear of a step, relative to the wear volume.
    """

    def __init__(
        self,
        workspace: Workspace,
        geometry: Any,
        tolerance: float,
        accuracy: Accuracy | None = None,
    ) -> None:
        self.problem, self.geometry, self.tolerance = workspace.problem, geometry, tolerance
        self.accuracy, self.convolutions = accuracy or Accuracy(), 0
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
        """One implicit stage from a base on: its exponent is x = known + rate · p, p its pressure.

        Parameters
        ----------
        start, guess
            First guesses of the pressure, Pa, and of the change of G by plastic flow, m.
        tolerance
            Of the contact.
        output_step
            Whether the stage ends at a requested cycle: only then the reduced contact is solved to
            full accuracy, and the residual computed by a separate convolution.
        problem
            The problem at the end of the stage, if it changes.

        Raises
        ------
        ContactError
            If a contact or the iteration between flow and wear does not converge, or a value is not
            finite.
        """
        problem, accuracy, integral = problem or self.problem, self.accuracy, self.geometry.integral
        bodies, unworn = self.ground.half_space, self.ground.unworn
        team, cellwise = bodies.team, bodies.team.cellwise
        model, moves, kept = problem.slip_model, self.problem.slip_moves, problem.debris_fraction
        reduced = base.reduced
        shift = guess if base.yielded else None
        response, level = None, None
        if moves:
            # Cells that begin to stick lose their gap, not more.
            shift = cellwise(lambda guess, gap: np.maximum(guess, -gap), guess, reduced.gap)
            if reduced.response is not None and problem.normal.holds_load:
                response = np.where(shift > guess, 0.0, reduced.response)
                # Beyond the contact nothing changes G but d*: with the bodies, or with µ.
                ahead = float(guess[-1, 0] / reduced.response[-1, 0])
                sliding = problem.sliding(base.load, base.approach)
                held = reduced.approach + sliding.flexibility * reduced.load
                level = base.approach + ahead + held - sliding.level
        opened, opens = ((1.0 - kept) * known, (1.0 - kept) * rate) if kept else (known, rate)
        sunk = cellwise(np.add, unworn, base.plastic)
        relaxation, before = 1.0, inf
        for _ in range(_LARGEST_SWEEPS):
            layer = model.wear_layer(base.opening, base.reduced.gap, shift, opened, opens)
            if response is not None and isinstance(layer, WearLayer):
                layer = replace(layer, response=response, level=level)
            try:
                contact = solve_contact(
                    self.problem.contact(bodies, sunk, layer),
                    start,
                    tolerance,
                    verified=output_step,
                    effort=accuracy.effort,
                )
            except ContactError as error:
                self.convolutions += error.convolutions
                raise
            self.convolutions += contact.convolutions
            start = contact.pressure
            layer = layer.at(contact.approach)
            shift = layer.shift if isinstance(layer, WearLayer) else shift
            opening = layer.displacement(start, team)
            gap = cellwise(lambda gap: np.maximum(gap, 0.0), contact.gap)
            worn = cellwise(np.subtract, opening, base.opening)
            # Wear needs pressure, so it cannot open a gap: a cell that wore in this stage touches.
            # A long step removes too much where a cell loses its pressure on the way, and a contact
            # solved to a tolerance a little too much where hardly any is left; either would stay
            # open for ever.
            idle = _IDLE * np.average(start, weights=self.geometry.weights)
            beyond = cellwise(
                lambda p, gap, worn, idle: np.where(
                    (gap > 0) & (worn > 0) & (p <= idle), np.minimum(gap, worn), 0.0
                ),
                *(start, contact.gap, worn, idle),
            )
            if beyond.any():
                for field in (opening, worn, gap):
                    field -= beyond
            plastic, yielded = base.plastic, False
            if contact.yields:
                plastic = cellwise(np.add, plastic, contact.penetration)
                yielded = model.follows_shape
            load = problem.load_of(self.geometry, contact)
            if yielded or moves:
                reduced = model.reduced(
                    problem,
                    bodies,
                    cellwise(lambda h, opened, sunk: h + opened + sunk, unworn, opening, plastic),
                    problem.sliding(load, contact.approach),
                    reduced,
                    accuracy.reduced if output_step else accuracy.reduced_between,
                )
                self.convolutions += reduced.convolutions
            else:
                reduced = replace(base.reduced, gap=model.gap_after(base.reduced.gap, worn))
            wear = opening
            if kept:
                exponent = known + rate * start
                wear = base.wear + all_worn(kept, worn, base.reduced.gap, shift, exponent)
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
            # The wear due to the missing flow, or to slip that changes midway.
            nothing, lost = np.zeros_like(opening), cellwise(np.abs, missing)
            flow = WearLayer(nothing, lost, None, opened, opens)
            if moves and not yielded:
                flow = replace(flow, reduced_gap=nothing, shift=lost)
            change = integral(flow.displacement(start, team))
            enough = accuracy.sweep if response is None else accuracy.following
            if change <= enough * self.tolerance * integral(opening):
                break
            if change > 0.5 * before:
                # Flow lets wear catch up, which stops the flow: average the two.
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


def all_worn(kept: float, opened: Array, gap: Array, shift: Array | None, exponent: Array) -> Array:
    """Wear depth of a stage, m, part of which is kept as debris; the rest opens the gap.

    If all of it is kept the gap does not change, and ∫g* dx = x (g*₀ + ΔG/2).
    """
    if kept < 1.0:
        return opened / (1.0 - kept)
    return exponent * (gap if shift is None else gap + 0.5 * shift)
