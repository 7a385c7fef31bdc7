"""Archard wear over many fretting cycles: implicit, adaptive steps.

One cycle wears Δw = 4 K_w p s = β p g* with β = 4 K_w µκ, so over the cycles dW/dN = β p g*. The
equation is stiff: pressure reacts at once to wear of a fraction of a micrometer. Each step is
TR-BDF2 (`fretwear.mechanics.tr_bdf2`) for the exponent x = β∫p dN, from which wear follows in
closed form.

A stage requires the pressure whose wear gives the shape that carries it: one normal contact with
a `fretwear.mechanics.slip.WearLayer`. Where the pressure is at its limit the surface sinks by
the penetration of that contact. This changes the contact at the reduced load, which is solved
again on the stage's own shape, in turn with the contact itself, until the wear no longer changes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import inf, sqrt
from typing import Any

import numpy as np

from fretwear.mechanics import tr_bdf2
from fretwear.mechanics.contact import Accuracy, ContactError
from fretwear.mechanics.geometry import Array, Workspace
from fretwear.mechanics.slip import WearLayer
from fretwear.mechanics.solver import solve_contact
from fretwear.mechanics.state import Stage, State, WearProblem
from fretwear.mechanics.tr_bdf2 import BEYOND, DIAGONAL, GAMMA, TOLERANCE, WEIGHT, WearError

__all__ = ["Evolution", "WearError", "evolve", "first_loading"]

_FIRST_STEP = 0.09
# Fraction of the tolerance for a contact that slides as a whole, whose pressure has twenty times
# the error of the wear.
_GLIDING = 0.25
_LARGEST_SWEEPS = 12
# A cell with less than this fraction of the mean pressure counts as unloaded.
_IDLE = 1e-3


def evolve(
    problem: WearProblem,
    stops: Sequence[float],
    tolerance: float = TOLERANCE,
    start: State | None = None,
    accuracy: Accuracy | None = None,
) -> Iterator[State]:
    """Integrate wear over the cycles and yield each accepted state, cycle 0 included.

    Parameters
    ----------
    problem
        The problem to integrate.
    stops
        Increasing cycle numbers at which a step must end exactly; the last one ends the run.
    tolerance
        Error of one step's wear relative to the wear volume.
    start
        A state that `evolve` yielded before, to resume from; it is not yielded again.
    accuracy
        Tolerances of the contacts.

    Yields
    ------
    State

    Raises
    ------
    WearError
        If the step had to be reduced to nothing.
    fretwear.mechanics.contact.ContactError
        If the first loading does not converge.
    """

    def begin(block: WearProblem, state: State | None, anew: bool) -> Evolution:
        return Evolution(block, tolerance, state, accuracy, anew=anew)

    return tr_bdf2.march(problem, stops, start, begin)


def first_loading(
    problem: WearProblem,
    accuracy: Accuracy | None = None,
    workspace: Workspace | None = None,
    before: State | None = None,
) -> State:
    """The state with which a loading begins, yielded where the plastic limit requires it.

    ``before`` is what an earlier loading has left; None for unworn bodies at cycle 0. A
    `fretwear.mechanics.contact.ContactError` says that the contact does not converge.
    """
    workspace, accuracy = workspace or Workspace(problem), accuracy or Accuracy()
    geometry: Any = problem.geometry.first(problem) if before is None else before.geometry
    cycle, step, spent = 0.0, 0, 0
    if before is not None:
        cycle, step, spent = before.cycle, before.step, before.convolutions
    while True:
        ground = workspace.on(geometry)
        nothing = np.zeros(geometry.shape)
        wear, opening, plastic, pressure = nothing, nothing, nothing, None
        if before is not None:
            before = before.on(workspace, geometry)
            wear, opening, plastic = before.wear, before.opening, before.plastic
            pressure = before.pressure
        contact = solve_contact(
            problem.contact(ground.half_space, ground.unworn + opening + plastic),
            pressure,
            tolerance=accuracy.contact,
            effort=accuracy.effort,
        )
        spent += contact.convolutions
        larger = geometry.holding(workspace, contact.pressure, contact.approach)
        if larger.shape == geometry.shape:
            break
        geometry = larger
    now, plastic = problem.at(cycle), plastic + contact.penetration
    load = now.load_of(geometry, contact)
    reduced = now.slip_model.reduced(
        now,
        ground.half_space,
        ground.unworn + plastic + opening,
        now.sliding(load, contact.approach),
        tolerance=accuracy.first_reduced,
    )
    return State(
        cycle=cycle,
        geometry=geometry,
        pressure=contact.pressure,
        gap=np.maximum(contact.gap, 0.0),
        wear=wear,
        opening=opening,
        plastic=plastic,
        load=load,
        approach=contact.approach,
        residual=contact.residual,
        reduced=reduced,
        next_step=_FIRST_STEP / (now.growth_rate * float(contact.pressure.max())),
        pressure_rate=nothing,
        source_rate=nothing,
        step=step,
        convolutions=spent + reduced.convolutions,
    )


class Evolution(tr_bdf2.Integrator):
    """The steps of a contact whose bodies are not seen to move, within a block of loading.

    It starts from a state, or ``anew`` with what the state has left of the bodies; by default they
    are unworn.
    """

    state: State

    def __init__(
        self,
        problem: WearProblem,
        tolerance: float,
        start: State | None = None,
        accuracy: Accuracy | None = None,
        *,
        anew: bool = False,
    ) -> None:
        self.problem, self.workspace = problem, Workspace(problem)
        self.accuracy = accuracy or Accuracy()
        if anew or start is None:
            start = first_loading(problem, self.accuracy, self.workspace, start)
        self.state, self.tolerance = start, tolerance * start.geometry.of_tolerance
        self._cellwise = problem.team.cellwise
        self._convolutions = 0  # since the state

    def advance(self, stop: float) -> State:
        """The next accepted state, on cells that suit it."""
        self._move_to(self.state.geometry.ahead_of(self.problem, self.state))
        found: State = super().advance(stop)
        return found

    def _move_to(self, geometry: Any) -> None:
        if geometry is not self.state.geometry:
            self.state = self.state.on(self.workspace, geometry)
            self.workspace.keep_only(geometry)

    def attempt(
        self, step: float, end: float, *, output_step: bool
    ) -> tuple[State, float, bool] | None:
        """Both stages, and what they differ by from embedded formulas."""
        base, problem, cellwise = self.state, self.problem, self._cellwise
        geometry, accuracy = base.geometry, self.accuracy
        now, density = problem.worn_by(base, base.cycle, geometry)
        early, middle = GAMMA * step, base.cycle + GAMMA * step
        # A wear coefficient that follows the power lags by one stage.
        then = problem.at(middle, density)
        p0, rate = base.pressure, now.growth_rate * step
        first = self.stage(
            base,
            cellwise(np.multiply, p0, rate * DIAGONAL),
            then.growth_rate * step * DIAGONAL,
            cellwise(lambda p, change: p + early * change, p0, base.pressure_rate),
            cellwise(np.multiply, base.source_rate, early),
            accuracy.first_stage,
            problem=then,
        )
        p1 = first.pressure
        known = cellwise(lambda p, q: rate * (WEIGHT - DIAGONAL) * (p + q), p0, p1)
        found, last = then, problem.at(end)
        if problem.changes:
            found, reached = problem.worn_by(first, middle, geometry)
            last = problem.at(end, max(0.0, reached + BEYOND * (reached - density)))
            r0, lagged, r1 = (each.growth_rate * step for each in (now, then, found))
            known = WEIGHT * (r0 * p0 + r1 * p1) - DIAGONAL * (r0 * p0 + lagged * p1)
        second = self.stage(
            first,
            known,
            last.growth_rate * step * DIAGONAL,
            cellwise(lambda p, q: q + BEYOND * (q - p), p0, p1),
            cellwise(np.multiply, first.source_since(base, problem.team), BEYOND),
            accuracy.contact,
            problem=last,
            output_step=output_step,
        )
        fitting: Any = geometry.holding(self.workspace, second.pressure, second.approach)
        if fitting is not geometry:
            self._move_to(fitting)
            return None
        rates = [each.growth_rate for each in (now, found, last)]
        error, factor, accepted = self._assess(step, rates, first, second)
        between = (1.0 - GAMMA) * step
        state = State(
            **vars(second),
            cycle=end,
            geometry=geometry,
            next_step=step,
            pressure_rate=cellwise(lambda p, q: (q - p) / between, p1, second.pressure),
            source_rate=cellwise(np.divide, second.source_since(first, problem.team), between),
            step=base.step + 1,
            error_estimate=error,
            convolutions=base.convolutions + self._convolutions,
        )
        if accepted:
            self._convolutions = 0
        return state, factor, accepted

    def _assess(
        self, step: float, rates: Sequence[float], first: Stage, second: Stage
    ) -> tuple[float, float, bool]:
        """Relative error of the wear of a step, factor for the next one, whether to accept it.

        ``rates`` are β at the start and at the end of both stages, 1/Pa per cycle.
        """
        base, integral, cellwise = self.state, self.state.geometry.integral, self._cellwise
        kept = self.problem.debris_fraction
        opens, volume = 1.0 - kept, integral(second.wear)
        if volume == 0:
            return 0.0, tr_bdf2.LARGEST_FACTOR, True

        def exponent(weights: Sequence[float]) -> Array:
            """X = β∫p dN over the step by weights of its three pressures."""
            start, middle, end = (b * step * w for b, w in zip(rates, weights, strict=True))
            result: Array = cellwise(
                lambda p0, p1, p2: start * p0 + middle * p1 + end * p2,
                *(base.pressure, first.pressure, second.pressure),
            )
            return result

        def lost(gap: Array, difference: Array) -> Array:
            growth = np.expm1(opens * difference) / opens if opens else difference
            result: Array = np.abs(gap * growth)
            return result

        error = integral(cellwise(lost, second.reduced.gap, exponent(tr_bdf2.DIFFERENCE)))
        if second.yielded or self.problem.slip_moves:
            # Slip that changes evenly over the whole step rather than over each stage.
            x, shift = exponent(tr_bdf2.MAIN), second.source_since(base, self.problem.team)
            layer = self.problem.slip_model.wear_layer(
                base.opening, base.reduced.gap, shift, opens * x, 0.0
            )
            worn = layer.displacement(second.pressure, self.problem.team)
            if kept:
                worn = base.wear + _all_worn(kept, worn - base.opening, base.reduced.gap, shift, x)
            off = cellwise(lambda worn, wear: np.abs(worn - wear), worn, second.wear)
            error = max(error, integral(off))
        error, allowed = error / (tr_bdf2.OVERESTIMATE * volume), self.tolerance
        if not second.reduced.load > 0.0:
            allowed *= min(1.0, _GLIDING / base.geometry.of_tolerance)
        factor, accepted = tr_bdf2.assessed(error / allowed)
        if first.yielded or second.yielded:
            # A cell at the limit sinks until wear, at the rate β p_lim, has freed it. A much longer
            # step would miss the flow in between.
            longest = sqrt(self.tolerance / TOLERANCE) / (max(rates) * self.problem.limit)
            factor = min(factor, longest / step)
            accepted &= step <= tr_bdf2.ACCEPTED * longest
        return error, factor, accepted

    def stage(
        self,
        base: Stage,
        known: Array,
        rate: float,
        start: Array,
        guess: Array,
        tolerance: float,
        *,
        problem: WearProblem | None = None,
        output_step: bool = False,
    ) -> Stage:
        """One implicit stage from a base on: its exponent is x = known + rate · p, p its pressure.

        Parameters
        ----------
        start, guess
            First guesses of the pressure, Pa, and of the change of G by plastic flow, m.
        tolerance
            Of the contact.
        problem
            The problem at the end of the stage, if it changes.
        output_step
            Whether the stage ends at a requested cycle: only then the reduced contact is solved to
            full accuracy, and the residual computed by a separate convolution.

        Raises
        ------
        ContactError
            If a contact or the iteration between flow and wear does not converge, or a value is not
            finite.
        """
        problem, accuracy, geometry = problem or self.problem, self.accuracy, self.state.geometry
        ground, cellwise = self.workspace.on(geometry), self._cellwise
        bodies, unworn, team = ground.half_space, ground.unworn, problem.team
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
                self._convolutions += error.convolutions
                raise
            self._convolutions += contact.convolutions
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
            idle = _IDLE * np.average(start, weights=geometry.weights)
            beyond = cellwise(
                lambda p, gap, worn, idle: np.where(
                    (gap > 0) & (worn > 0) & (p <= idle), np.minimum(gap, worn), 0.0
                ),
                *(start, contact.gap, worn, idle),
            )
            if beyond.any():
                for field in (opening, worn, gap):
                    field -= beyond
            plastic, yielded = base.plastic, contact.yields and model.follows_shape
            if contact.yields:
                plastic = cellwise(np.add, plastic, contact.penetration)
            load = problem.load_of(geometry, contact)
            if yielded or moves:
                reduced = model.reduced(
                    problem,
                    bodies,
                    cellwise(lambda h, opened, sunk: h + opened + sunk, unworn, opening, plastic),
                    problem.sliding(load, contact.approach),
                    reduced,
                    accuracy.reduced if output_step else accuracy.reduced_between,
                )
                self._convolutions += reduced.convolutions
            else:
                reduced = replace(base.reduced, gap=model.gap_after(base.reduced.gap, worn))
            wear = opening
            if kept:
                exponent = known + rate * start
                wear = base.wear + _all_worn(kept, worn, base.reduced.gap, shift, exponent)
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
            change = geometry.integral(flow.displacement(start, team))
            enough = accuracy.sweep if response is None else accuracy.following
            if change <= enough * self.tolerance * geometry.integral(opening):
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


def _all_worn(
    kept: float, opened: Array, gap: Array, shift: Array | None, exponent: Array
) -> Array:
    """Wear depth of a stage, m, part of which is kept as debris; the rest opens the gap.

    If all of it is kept the gap does not change, and ∫g* dx = x (g*₀ + ΔG/2).
    """
    if kept < 1.0:
        return opened / (1.0 - kept)
    return exponent * (gap if shift is None else gap + 0.5 * shift)
