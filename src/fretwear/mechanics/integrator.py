"""Archard wear over many fretting cycles: implicit, adaptive steps.

One cycle wears Δw = 4 K_w p s = β p g* with β = 4 K_w µκ, so over the cycles dW/dN = β p g*. The
equation is stiff: pressure reacts at once to wear of a fraction of a micrometer. Each step is
TR-BDF2 (`fretwear.mechanics.tr_bdf2`) for the exponent x = β∫p dN, from which wear follows in
closed form.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import sqrt
from typing import Any

import numpy as np

from fretwear.mechanics.contact import Accuracy, ContactError
from fretwear.mechanics.geometry import Array, Workspace
from fretwear.mechanics.solver import solve_contact
from fretwear.mechanics.stages import StageSolver, all_worn, load_of
from fretwear.mechanics.state import Stage, State, WearProblem
from fretwear.mechanics.tr_bdf2 import (
    ACCEPTED,
    DIAGONAL,
    EMBEDDED,
    FACTORS,
    GAMMA,
    MAIN,
    OVERESTIMATE,
    SMALLEST_STEP,
    WEIGHT,
    assessed,
    step_after,
    step_towards,
)

_BEYOND = (1.0 - GAMMA) / GAMMA

_FIRST_STEP = 0.09
_FLOW_EXPONENT = 1.0
_DEFAULT_TOLERANCE = 0.01
# Part of the tolerance for a contact that slides as a whole: nothing holds its pressure, which errs
# by twenty times what the wear does.
_GLIDING = 0.25


class WearError(RuntimeError):
    """The integration cannot go on; the last accepted state is valid."""


def evolve(
    problem: WearProblem,
    stops: Sequence[float],
    tolerance: float = _DEFAULT_TOLERANCE,
    start: State | None = None,
    accuracy: Accuracy | None = None,
) -> Iterator[State]:
    """Integrate wear over the cycles and yield each accepted state, cycle 0 included.

    Parameters
    ----------
    problem
        What to integrate.
    stops
        Increasing cycle numbers at which a step must end exactly; the last one ends the run.
    tolerance
        Error of one step's wear relative to the wear volume.
    start
        A state that `evolve` yielded before, to resume from; it is not yielded again.
    accuracy
        Of the contacts.

    Yields
    ------
    State

    Raises
    ------
    WearError
        If the step had to be cut to nothing.
    fretwear.mechanics.contact.ContactError
        If the first loading does not converge.
    """
    workspace, accuracy = Workspace(problem), accuracy or Accuracy()
    if start is None:
        start = first_loading(problem, accuracy, workspace)
        yield start
    state, begin = start, 0.0
    tolerance *= state.geometry.of_tolerance
    del start
    for block in problem.blocks:
        if state.cycle < block.end:
            if state.cycle == begin > 0.0:
                workspace = Workspace(block)
                state = first_loading(block, accuracy, workspace, state)
            integrator = _Integrator(workspace, tolerance, accuracy, state)
            # Neither a step nor its error estimate may go over a kink.
            kinks = {kink for kink in (*block.friction.kinks, block.end) if kink < stops[-1]}
            for stop in sorted({*stops, *kinks}):
                while begin <= integrator.state.cycle < min(stop, block.end):
                    yield integrator.advance(stop)
            state = integrator.state
        begin = block.end


def first_loading(
    problem: WearProblem,
    accuracy: Accuracy | None = None,
    workspace: Workspace | None = None,
    before: State | None = None,
) -> State:
    """The state from which a loading begins: yielded where it has to.

    Parameters
    ----------
    problem
        What to load.
    accuracy
        Of the contacts.
    workspace
        Of the problem, if there is one.
    before
        What an earlier loading has left; None for unworn bodies at cycle 0.

    Raises
    ------
    fretwear.mechanics.contact.ContactError
        If the contact does not converge.
    """
    workspace, accuracy = workspace or Workspace(problem), accuracy or Accuracy()
    geometry: Any = problem.geometry.first(problem) if before is None else before.geometry
    spent = 0 if before is None else before.convolutions
    while True:
        ground = workspace.on(geometry)
        nothing = np.zeros(geometry.shape)
        wear = opening = plastic = nothing
        if before is not None:
            before = before.on(workspace, geometry)
            wear, opening, plastic = before.wear, before.opening, before.plastic
        contact = solve_contact(
            problem.contact(ground.half_space, ground.unworn + opening + plastic),
            None if before is None else before.pressure,
            tolerance=accuracy.contact,
            effort=accuracy.effort,
        )
        spent += contact.convolutions
        larger = geometry.holding(workspace, contact.pressure, contact.approach)
        if larger.shape == geometry.shape:
            break
        geometry = larger
    cycle = 0.0 if before is None else before.cycle
    now, plastic = problem.at(cycle), plastic + contact.penetration
    load = load_of(now, geometry, contact)
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
        step=0 if before is None else before.step,
        convolutions=spent + reduced.convolutions,
    )


@dataclass(frozen=True)
class _Assessment:
    """Relative error of the wear of a step, what to multiply it by, whether to keep it."""

    error: float
    factor: float
    accepted: bool


class _Integrator:
    """Makes accepted states one after the other."""

    def __init__(
        self, workspace: Workspace, tolerance: float, accuracy: Accuracy, state: State
    ) -> None:
        self.problem = workspace.problem
        self.workspace = workspace
        self.tolerance = tolerance
        self.accuracy = accuracy
        self.state = state
        self._team, self._cellwise = self.problem.team, self.problem.team.cellwise
        self._rates = (0.0, 0.0, 0.0)
        self._solver = StageSolver(workspace, state.geometry, tolerance, accuracy)

    def advance(self, stop: float) -> State:
        """The next accepted state, at ``stop`` or before."""
        self._move_to(self.state.geometry.ahead_of(self.problem, self.state))
        wanted, trouble = self.state.next_step, "wear asks for shorter ones"
        while True:
            left = stop - self.state.cycle
            step = step_towards(left, wanted)
            if step < SMALLEST_STEP:
                raise WearError(
                    f"no step after cycle {self.state.cycle:.6g} is accurate, down to "
                    f"{step:.1e} cycles: {trouble}; the contact at cycle "
                    f"{self.state.cycle:.6g} has a residual of {self.state.residual:.1e}"
                )
            try:
                first, second = self._stages(step, output_step=step == left)
            except ContactError as error:
                wanted, trouble = 0.5 * step, str(error)
                continue
            fitting = self.state.geometry.holding(self.workspace, second.pressure, second.approach)
            if fitting is not self.state.geometry:
                self._move_to(fitting)
                continue
            found = self._assess(step, first, second)
            if not found.accepted:
                wanted = step * found.factor
                trouble = (
                    f"the error is estimated as {found.error:.1e} instead of {self.tolerance:.1e}"
                )
                continue
            between = (1.0 - GAMMA) * step
            self.state = State(
                **vars(second),
                cycle=stop if step == left else self.state.cycle + step,
                geometry=self.state.geometry,
                next_step=step_after(step, found.factor, wanted),
                pressure_rate=self._cellwise(
                    lambda last, middle, cycles: (last - middle) / cycles,
                    second.pressure,
                    first.pressure,
                    between,
                ),
                source_rate=self._cellwise(
                    np.divide, second.source_since(first, self._team), between
                ),
                step=self.state.step + 1,
                error_estimate=found.error,
                convolutions=self.state.convolutions + self._solver.convolutions,
            )
            self._solver.convolutions = 0
            return self.state

    def _stages(self, step: float, *, output_step: bool) -> tuple[Stage, Stage]:
        """Both stages of TR-BDF2 over a step of so many cycles; whether its end is requested."""
        base, problem = self.state, self.problem
        now, density = self._wearing(base, base.cycle)
        middle, last = base.cycle + GAMMA * step, min(base.cycle + step, problem.end)
        # The wear coefficient of a stage, where it follows the power, lags behind by a stage.
        then = problem.at(middle, density)
        p0, rate = base.pressure, now.growth_rate * step
        early, cellwise = GAMMA * step, self._cellwise
        first = self._solver.solve(
            base,
            cellwise(np.multiply, p0, rate * DIAGONAL),
            then.growth_rate * step * DIAGONAL,
            cellwise(lambda p, change: p + early * change, p0, base.pressure_rate),
            cellwise(np.multiply, base.source_rate, early),
            self.accuracy.first_stage,
            output_step=False,
            problem=then,
        )
        p1 = first.pressure
        known = cellwise(lambda p, q: rate * (WEIGHT - DIAGONAL) * (p + q), p0, p1)
        found, end = then, problem.at(last)
        if problem.changes:
            found, reached = self._wearing(first, middle)
            end = problem.at(last, max(0.0, reached + _BEYOND * (reached - density)))
            r0, lagged, r1 = (each.growth_rate * step for each in (now, then, found))
            known = WEIGHT * (r0 * p0 + r1 * p1) - DIAGONAL * (r0 * p0 + lagged * p1)
        self._rates = (now.growth_rate, found.growth_rate, end.growth_rate)
        second = self._solver.solve(
            first,
            known,
            end.growth_rate * step * DIAGONAL,
            cellwise(lambda p, q: q + _BEYOND * (q - p), p0, p1),
            cellwise(np.multiply, first.source_since(base, self._team), _BEYOND),
            self.accuracy.contact,
            output_step=output_step,
            problem=end,
        )
        return first, second

    def _wearing(self, stage: Stage, cycle: float) -> tuple[WearProblem, float]:
        """The problem as it is at a stage, and its energy per cycle and area, J/m²."""
        if not self.problem.wear_law.follows_power:
            return self.problem.at(cycle), 0.0
        density = self.problem.at(cycle).energy_per_area(stage, self.state.geometry)
        return self.problem.at(cycle, density), density

    def _assess(self, step: float, first: Stage, second: Stage) -> _Assessment:
        """Compare a step with embedded formulas of another order."""
        volume = self.state.geometry.integral(second.wear)
        if volume == 0:
            return _Assessment(0.0, FACTORS[1], True)
        error = self._exponent_error(step, first, second)
        if second.yielded or self.problem.slip_moves:
            error = max(error, self._source_error(step, first, second))
        error /= OVERESTIMATE * volume
        factor, accepted = assessed(error / self._allowed(second))
        if first.yielded or second.yielded:
            longest = self._longest_while_yielding()
            factor = min(factor, longest / step)
            accepted &= step <= ACCEPTED * longest
        return _Assessment(error, factor, accepted)

    def _allowed(self, stage: Stage) -> float:
        """Error of the wear of a step relative to the wear volume."""
        if stage.reduced.load > 0.0:
            return self.tolerance
        return min(1.0, _GLIDING / self.state.geometry.of_tolerance) * self.tolerance

    def _exponent_error(self, step: float, first: Stage, second: Stage) -> float:
        """Wear volume, m³, between the step and its embedded third-order formula."""
        weights = [e - m for e, m in zip(EMBEDDED, MAIN, strict=True)]
        difference = self._exponent(step, first, second, weights)
        opens = 1.0 - self.problem.debris_fraction

        def lost(gap: Array, difference: Array) -> Array:
            growth = np.expm1(opens * difference) / opens if opens else difference
            result: Array = np.abs(gap * growth)
            return result

        worn = self._cellwise(lost, second.reduced.gap, difference)
        return self.state.geometry.integral(worn)

    def _source_error(self, step: float, first: Stage, second: Stage) -> float:
        """Wear volume, m³, between slip that changes evenly over each stage or the whole step."""
        base, kept = self.state, self.problem.debris_fraction
        exponent = self._exponent(step, first, second, MAIN)
        shift = second.source_since(base, self._team)
        whole = self.problem.slip_model.wear_layer(
            base.opening, base.reduced.gap, shift, (1.0 - kept) * exponent, 0.0
        )
        worn = whole.displacement(second.pressure, self._team)
        if kept:
            opened = worn - base.opening
            worn = base.wear + all_worn(kept, opened, base.reduced.gap, shift, exponent)
        off = self._cellwise(lambda worn, wear: np.abs(worn - wear), worn, second.wear)
        return base.geometry.integral(off)

    def _exponent(
        self, step: float, first: Stage, second: Stage, weights: Sequence[float]
    ) -> Array:
        """Exponent x = β∫p dN over a step by weights of its three pressures."""
        start, middle, end = (
            rate * step * weight for rate, weight in zip(self._rates, weights, strict=True)
        )
        exponent: Array = self._cellwise(
            lambda p0, p1, p2: start * p0 + middle * p1 + end * p2,
            self.state.pressure,
            first.pressure,
            second.pressure,
        )
        return exponent

    def _longest_while_yielding(self) -> float:
        """Longest step, cycles, in which plastic flow is resolved.

        A cell at the limit sinks until wear, at the rate β p_lim, has freed it. A step of many
        such times sees it before and after, not the flow in between.
        """
        exponent = _FLOW_EXPONENT * sqrt(self.tolerance / _DEFAULT_TOLERANCE)
        longest: float = exponent / (max(self._rates) * self.problem.limit)
        return longest

    def _move_to(self, geometry: Any) -> None:
        """Put the state on a larger geometry."""
        if geometry is self.state.geometry:
            return
        self.state = self.state.on(self.workspace, geometry)
        spent = self._solver.convolutions
        self._solver = StageSolver(self.workspace, geometry, self.tolerance, self.accuracy)
        self._solver.convolutions = spent
        self.workspace.keep_only(geometry)
