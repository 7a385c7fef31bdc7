"""Archard wear over many fretting cycles: implicit, adaptive steps.

One cycle wears Δw = 4 K_w p s = β p g* with β = 4 K_w µκ, so over the cycles dW/dN = β p g*. The
equation is stiff: pressure reacts at once to wear of a fraction of a micrometer. Each step is
TR-BDF2 (`fretwear.mechanics.tr_bdf2`) for the exponent x = β∫p dN, from which wear follows in
closed form.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import sqrt
from typing import Any

import numpy as np

from fretwear.mechanics.contact import Accuracy
from fretwear.mechanics.geometry import Array, Workspace
from fretwear.mechanics.solver import solve_contact
from fretwear.mechanics.stages import StageSolver, all_worn
from fretwear.mechanics.state import Stage, State, WearProblem
from fretwear.mechanics.tr_bdf2 import (
    ACCEPTED,
    BEYOND,
    DIAGONAL,
    DIFFERENCE,
    GAMMA,
    LARGEST_FACTOR,
    MAIN,
    OVERESTIMATE,
    TOLERANCE,
    WEIGHT,
    Integrator,
    WearError,
    assessed,
    march,
)

__all__ = ["WearError", "evolve", "first_loading"]

_FIRST_STEP = 0.09
# Fraction of the tolerance for a contact that slides as a whole, whose pressure has twenty times
# the error of the wear.
_GLIDING = 0.25


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

    def begin(block: WearProblem, state: State | None, anew: bool) -> Integrator:
        return _Evolution(block, tolerance, accuracy or Accuracy(), state, anew=anew)

    return march(problem, stops, start, begin)


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


class _Evolution(Integrator):
    """Of a contact whose bodies are not seen to move."""

    state: State

    def __init__(
        self,
        problem: WearProblem,
        tolerance: float,
        accuracy: Accuracy,
        start: State | None,
        *,
        anew: bool,
    ) -> None:
        self.problem, self.accuracy, self.workspace = problem, accuracy, Workspace(problem)
        if anew or start is None:
            start = first_loading(problem, accuracy, self.workspace, start)
        self.state, self.tolerance = start, tolerance * start.geometry.of_tolerance
        self._team, self._cellwise = problem.team, problem.team.cellwise
        self._rates = (0.0, 0.0, 0.0)
        self._solver = StageSolver(self.workspace, start.geometry, self.tolerance, accuracy)

    def advance(self, stop: float) -> State:
        """The next accepted state, on cells that suit it."""
        self._move_to(self.state.geometry.ahead_of(self.problem, self.state))
        found: State = super().advance(stop)
        return found

    def attempt(
        self, step: float, end: float, *, output_step: bool
    ) -> tuple[dict[str, Any], float, bool] | None:
        """Both stages, and what they differ by from embedded formulas."""
        base, geometry = self.state, self.state.geometry
        first, second = self._stages(step, end, output_step=output_step)
        fitting: Any = geometry.holding(self.workspace, second.pressure, second.approach)
        if fitting is not geometry:
            self._move_to(fitting)
            return None
        error, factor, accepted = self._assess(step, first, second)
        between = (1.0 - GAMMA) * step
        change, moved = second.source_since(first, self._team), self._cellwise
        fields = {
            **vars(second),
            "geometry": geometry,
            "pressure_rate": moved(
                lambda last, middle, cycles: (last - middle) / cycles,
                *(second.pressure, first.pressure, between),
            ),
            "source_rate": moved(np.divide, change, between),
            "error_estimate": error,
            "convolutions": base.convolutions + self._solver.convolutions,
        }
        if accepted:
            self._solver.convolutions = 0
        return fields, factor, accepted

    def _stages(self, step: float, last: float, *, output_step: bool) -> tuple[Stage, Stage]:
        """Both stages of TR-BDF2 over a step of so many cycles to one that may be requested."""
        base, problem = self.state, self.problem
        now, density = self._wearing(base, base.cycle)
        middle = base.cycle + GAMMA * step
        # A wear coefficient that follows the power lags by one stage.
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
            end = problem.at(last, max(0.0, reached + BEYOND * (reached - density)))
            r0, lagged, r1 = (each.growth_rate * step for each in (now, then, found))
            known = WEIGHT * (r0 * p0 + r1 * p1) - DIAGONAL * (r0 * p0 + lagged * p1)
        self._rates = (now.growth_rate, found.growth_rate, end.growth_rate)
        second = self._solver.solve(
            first,
            known,
            end.growth_rate * step * DIAGONAL,
            cellwise(lambda p, q: q + BEYOND * (q - p), p0, p1),
            cellwise(np.multiply, first.source_since(base, self._team), BEYOND),
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

    def _assess(self, step: float, first: Stage, second: Stage) -> tuple[float, float, bool]:
        """Relative error of the wear of a step, factor for the next one, whether to accept it."""
        geometry, opens = self.state.geometry, 1.0 - self.problem.debris_fraction
        volume = geometry.integral(second.wear)
        if volume == 0:
            return 0.0, LARGEST_FACTOR, True

        def lost(gap: Array, difference: Array) -> Array:
            growth = np.expm1(opens * difference) / opens if opens else difference
            result: Array = np.abs(gap * growth)
            return result

        difference = self._exponent(step, first, second, DIFFERENCE)
        error = geometry.integral(self._cellwise(lost, second.reduced.gap, difference))
        if second.yielded or self.problem.slip_moves:
            error = max(error, self._source_error(step, first, second))
        error, allowed = error / (OVERESTIMATE * volume), self.tolerance
        if not second.reduced.load > 0.0:
            allowed *= min(1.0, _GLIDING / geometry.of_tolerance)
        factor, accepted = assessed(error / allowed)
        if first.yielded or second.yielded:
            # A cell at the limit sinks until wear, at the rate β p_lim, has freed it. A much longer
            # step would miss the flow in between.
            exponent = sqrt(self.tolerance / TOLERANCE)
            longest = exponent / (max(self._rates) * self.problem.limit)
            factor = min(factor, longest / step)
            accepted &= step <= ACCEPTED * longest
        return error, factor, accepted

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
            *(self.state.pressure, first.pressure, second.pressure),
        )
        return exponent

    def _move_to(self, geometry: Any) -> None:
        """Transfer the state to a larger geometry."""
        if geometry is not self.state.geometry:
            self.state = self.state.on(self.workspace, geometry)
            spent = self._solver.convolutions
            self._solver = StageSolver(self.workspace, geometry, self.tolerance, self.accuracy)
            self._solver.convolutions = spent
            self.workspace.keep_only(geometry)
