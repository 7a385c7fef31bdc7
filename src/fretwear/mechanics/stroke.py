"""Contacts that slide as a whole, over a stroke that need not be small beside them.

Each point of a body meets different points of the other in the course of a stroke, and what is
worn stays where it was worn: of the indenter it moves with the indenter. So a stroke is a row of
contacts, one for each of some positions ξ of the indenter, of one shape

    h(x, ξ) = h₀(x − ξ) + w₁(x − ξ) + w₂(x),   dw₁/dN = 4sK₁ ⟨p(X + ξ, ξ)⟩,
                                                 dw₂/dN = 4sK₂ ⟨p(x, ξ)⟩,

⟨⟩ the mean over the stroke from −s to s, 4s the path of a cycle. A cycle is the same to and fro and
on either side, so half of the positions tell all; the contact at one of them is even along y only.

A step is implicit, TR-BDF2 as in `fretwear.mechanics.integrator`, and its stages are solved as one
problem each by `fretwear.mechanics.rubbing`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import ceil, inf
from typing import Any

import numpy as np

from fretwear.mechanics.contact import ContactError
from fretwear.mechanics.geometry import Array, Mask, Workspace
from fretwear.mechanics.geometry.line import Line
from fretwear.mechanics.integrator import WearError
from fretwear.mechanics.rubbing import MARGIN, Contacts, Rubbing, positions
from fretwear.mechanics.slip import ReducedContact
from fretwear.mechanics.state import State, WearProblem
from fretwear.mechanics.tr_bdf2 import (
    DIAGONAL,
    EMBEDDED,
    GAMMA,
    MAIN,
    OVERESTIMATE,
    SMALLEST_STEP,
    WEIGHT,
    assessed,
    step_after,
    step_towards,
)

_GROWTH = 1.2
_FIRST_STEP = 0.1
_BEYOND = (1.0 - GAMMA) / GAMMA
_OF_BODIES = (
    "wear_indenter",
    "wear_flat",
    "rate_indenter",
    "rate_flat",
    "flow_indenter",
    "flow_flat",
)


@dataclass(frozen=True, kw_only=True)
class StrokeState(State):
    """A state of a contact that slides as a whole.

    Pressure, gap and approach are those in the middle of the stroke, and wear is that of both
    bodies there.

    Attributes
    ----------
    wear_indenter, wear_flat
        Wear depth of each body in its own coordinates, m, on the cells of the geometry.
    rate_indenter, rate_flat
        Wear depth of each in this one cycle, m.
    flow_indenter, flow_flat
        Plastic depth of each, m.
    pressures
        Pressure at each position, Pa, on cells of either side along x, shape (positions, 2n, m).
    """

    wear_indenter: Array
    wear_flat: Array
    rate_indenter: Array
    rate_flat: Array
    flow_indenter: Array
    flow_flat: Array
    pressures: Array

    @property
    def wear_rate(self) -> Array:
        """Wear depth of both bodies in this one cycle, m, in the middle of the stroke."""
        return self.rate_indenter + self.rate_flat

    def on(self, workspace: Workspace, geometry: Any) -> StrokeState:
        """The same state on more cells; its gap is computed where it was not known."""
        old = self.geometry
        if geometry.shape == old.shape:
            return self
        ground = workspace.on(geometry)
        fields = ("pressure", "wear", "opening", "plastic", "pressure_rate", "source_rate")
        longer: dict[str, Any] = {
            name: old.resized(getattr(self, name), geometry) for name in (*fields, *_OF_BODIES)
        }
        moved = ground.half_space.displacement(longer["pressure"])
        gap = moved + ground.unworn + longer["opening"] + longer["plastic"] - self.approach
        gap[geometry.where(old)] = self.gap
        more, rows = (new - was for new, was in zip(geometry.shape, old.shape, strict=True))
        reduced = replace(
            self.reduced,
            pressure=np.zeros(geometry.shape),
            gap=np.full(geometry.shape, self.reduced.gap[0, 0]),
        )
        return replace(
            self,
            geometry=geometry,
            gap=gap,
            reduced=reduced,
            pressures=np.pad(self.pressures, ((0, 0), (more, more), (0, rows))),
            **longer,
        )


def slide(
    problem: WearProblem,
    stops: Sequence[float],
    tolerance: float = 0.01,
    start: StrokeState | None = None,
) -> Iterator[StrokeState]:
    """Integrate the wear of both bodies over the cycles; parameters as of `evolve`.

    Raises
    ------
    WearError
        If the step had to be cut to nothing.
    """
    begin, state = 0.0, start
    for block in problem.blocks:
        if state is None or state.cycle < block.end:
            anew = state is None or state.cycle == begin > 0.0
            slider = _Slider(block, tolerance, state, anew=anew)
            if state is None:
                yield slider.state
            kinks = {kink for kink in (*block.friction.kinks, block.end) if kink < stops[-1]}
            for stop in sorted({*stops, *kinks}):
                while begin <= slider.state.cycle < min(stop, block.end):
                    yield slider.advance(stop)
            state = slider.state
        begin = block.end


class _Slider:
    """Makes accepted states one after the other."""

    def __init__(
        self, problem: WearProblem, tolerance: float, start: StrokeState | None, *, anew: bool
    ) -> None:
        self.problem, self.tolerance = problem, tolerance
        self.workspace = Workspace(problem)
        shape = (0, 0) if start is None else start.geometry.shape
        if anew:
            shape = self._first_shape(shape)
        self.rubbing = Rubbing(problem, shape)
        if start is not None:
            self.state = start.on(self.workspace, self.rubbing.geometry)
        if anew:
            self.state = self._loaded(start and self.state)

    def _first_shape(self, least: tuple[int, int]) -> tuple[int, int]:
        problem = self.problem
        reach = problem.extent[0] + float(positions(problem)[0][-1])
        extent = [reach, problem.extent[1]]
        cells = [
            max(was, ceil(far / size) + 2 * MARGIN)
            for was, far, size in zip(least, extent, problem.spacing, strict=True)
        ]
        return cells[0], 1 if problem.geometry is Line else cells[1]

    def rates(self, cycle: float, energy_density: float = 0.0) -> Array:
        """Wear depth of indenter and flat per mean pressure and cycle, m/Pa.

        ``energy_density`` is the energy per cycle and area of contact, J/m².
        """
        shares = np.array(self.problem.wear_law.shares or (1.0, 0.0))
        coefficient = self.problem.at(cycle, energy_density).wear_coefficient
        result: Array = 4.0 * self.problem.loading.stroke * coefficient * shares
        return result

    def energy_density(self, cycle: float, pressures: Array) -> float:
        """Energy per cycle and area of contact, J/m², in the mean over the stroke."""
        problem, rubbing = self.problem.at(cycle), self.rubbing
        closed = (pressures > 0).reshape(len(pressures), -1).sum(axis=1)
        area = 2.0 * rubbing.area * float(rubbing.weights @ closed)
        force = problem.friction.coefficient * problem.hertz.load
        return 4.0 * force * problem.loading.stroke / area

    @cached_property
    def kept(self) -> float:
        """Part of the wear that opens the gap: all but the debris."""
        return 1.0 - self.problem.debris_fraction

    def _opening(self, worn: Array, flow: Array) -> Array:
        """What is worn off the flat and the indenter or has sunk, as `Rubbing` has it, m."""
        both: Array = (self.kept * worn + flow)[::-1].ravel()
        return both

    def _loaded(self, start: StrokeState | None) -> StrokeState:
        """The state at the beginning of a block of loading."""
        problem = self.problem
        cycle, step = (start.cycle, start.step) if start else (0.0, 0)
        rates = self.rates(cycle)
        growth = self.kept * rates.sum() * problem.hertz.peak_pressure
        depth = problem.hertz.peak_pressure * float(self.rubbing.influence[0, 0, 0])
        first = _FIRST_STEP * depth / growth if growth > 0 else inf
        wide, high = problem.indenter.half_widths(problem.hertz)
        while True:
            rubbing = self.rubbing
            x, y = rubbing.x[:, None] - rubbing.places[:, None, None], rubbing.y
            closed = (x / wide) ** 2 + (y / high) ** 2 < 1.0
            worn, flow = np.zeros((2, 2, *rubbing.geometry.shape))
            if start:
                closed = closed | (start.pressures > 0).any(axis=0)
                worn, flow = _worn(start), _flow(start)
            nothing = np.zeros(worn.size)
            found = rubbing.solve(
                self._opening(worn, flow), nothing, closed.reshape(len(closed), -1)
            )
            sides = rubbing.reaches_border(found.closed)
            if not any(sides):
                break
            self._grow(sides, start)
            start = start and self.state
        flow = flow + self._by_body(found.flow)
        return self._state(cycle, first, found, worn, flow, step=step, error=0.0)

    def _by_body(self, values: Array) -> Array:
        """Values of the flat and the indenter as fields of the indenter and the flat."""
        result: Array = values.reshape(2, *self.rubbing.geometry.shape)[::-1]
        return result

    def advance(self, stop: float) -> StrokeState:
        """The next accepted state, at ``stop`` or before."""
        wanted, trouble = self.state.next_step, "wear asks for shorter ones"
        while True:
            left = stop - self.state.cycle
            step = step_towards(left, wanted)
            if step < SMALLEST_STEP:
                raise WearError(
                    f"no step after cycle {self.state.cycle:.6g} is accurate: {trouble}"
                )
            try:
                last, worn, flow, error = self._stages(step)
            except (ContactError, np.linalg.LinAlgError) as problem:
                wanted, trouble = 0.5 * step, str(problem)
                continue
            if any(sides := self.rubbing.reaches_border(last.closed)):
                self._grow(sides, self.state)
                continue
            factor, accepted = assessed(error)
            if not accepted:
                wanted, trouble = step * factor, f"the error is {error:.1e} times the tolerance"
                continue
            cycle = stop if step == left else self.state.cycle + step
            self.state = self._state(
                cycle,
                step_after(step, factor, wanted),
                last,
                worn,
                flow,
                step=self.state.step + 1,
                error=error * self.tolerance,
            )
            return self.state

    def _stages(self, step: float) -> tuple[Contacts, Array, Array, float]:
        """The contacts at the end of a step, wear and flow of both bodies, the error estimate."""
        base, rubbing = self.state, self.rubbing
        # A run that resumes here has no inverses of earlier steps either.
        rubbing.inverses.clear()
        worn, flow = _worn(base), _flow(base)
        started = np.stack([base.rate_indenter, base.rate_flat])

        def stage(
            known: Array, flow: Array, cycle: float, energy_density: float, closed: Mask
        ) -> tuple[Contacts, Array]:
            rates = self.rates(cycle, energy_density)
            softness = np.repeat(self.kept * DIAGONAL * step * rates[::-1], worn[0].size)
            found = rubbing.solve(self._opening(known, flow), softness, closed)
            return found, rates[:, None, None] * self._by_body(found.means)

        closed = (base.pressures > 0).reshape(len(base.pressures), -1)
        middle, end = base.cycle + GAMMA * step, min(base.cycle + step, self.problem.end)
        # The wear coefficient of a stage, where it follows the power, lags behind by a stage.
        density = self.energy_density(base.cycle, base.pressures)
        known = worn + DIAGONAL * step * started
        first, between = stage(known, flow, middle, density, closed)
        reached = self.energy_density(middle, first.pressures)
        between *= (self.rates(middle, reached) / self.rates(middle, density))[:, None, None]
        flow = flow + self._by_body(first.flow)
        known = worn + WEIGHT * step * (started + between)
        ahead = max(0.0, reached + _BEYOND * (reached - density))
        second, ended = stage(known, flow, end, ahead, first.closed)
        flow = flow + self._by_body(second.flow)
        rates = (started, between, ended)
        worn = worn + step * sum(weight * rate for weight, rate in zip(MAIN, rates, strict=True))
        weights = [e - m for e, m in zip(EMBEDDED, MAIN, strict=True)]
        missed = step * sum(weight * rate for weight, rate in zip(weights, rates, strict=True))
        error = float(np.abs(missed).sum() / worn.sum()) / (OVERESTIMATE * self.tolerance)
        return second, worn, flow, error

    def _state(
        self,
        cycle: float,
        following: float,
        found: Contacts,
        worn: Array,
        flow: Array,
        *,
        step: int,
        error: float,
    ) -> StrokeState:
        """The state with the contact in the middle of the stroke."""
        problem, geometry = self.problem.at(cycle), self.rubbing.geometry
        ground = self.workspace.on(geometry)
        opening, plastic = self.kept * worn.sum(axis=0), flow.sum(axis=0)
        pressures = found.pressures.reshape(len(found.pressures), -1, self.rubbing.rows)
        # The middle of the stroke is the first position.
        middle = pressures[0, geometry.shape[0] :]
        separation = ground.half_space.displacement(middle) + ground.unworn + opening + plastic
        free = (middle > 0) & (middle < problem.limit)
        approach = float(separation[free].mean())
        gap = separation - approach
        residual = np.abs(np.where(free, gap, np.minimum(gap, 0.0))).max() / approach
        slip = problem.loading.stroke / (problem.friction.coefficient * problem.coupling)
        nothing = np.zeros(geometry.shape)
        reduced = ReducedContact(nothing, np.full(geometry.shape, slip), approach - slip, load=0.0)
        density = self.energy_density(cycle, pressures)
        rates = self.rates(cycle, density)[:, None, None] * self._by_body(found.means)
        return StrokeState(
            cycle=cycle,
            geometry=geometry,
            pressure=middle,
            gap=np.where(middle > 0, 0.0, np.maximum(gap, 0.0)),
            wear=worn.sum(axis=0),
            opening=opening,
            plastic=plastic,
            load=problem.hertz.load,
            approach=approach,
            residual=float(residual),
            reduced=reduced,
            next_step=following,
            pressure_rate=nothing,
            source_rate=nothing,
            step=step,
            error_estimate=error,
            wear_indenter=worn[0],
            wear_flat=worn[1],
            rate_indenter=rates[0],
            rate_flat=rates[1],
            flow_indenter=flow[0],
            flow_flat=flow[1],
            pressures=pressures,
        )

    def _grow(self, sides: tuple[bool, bool], state: StrokeState | None) -> None:
        """Take more cells along x, along y or both, and put the state on them."""
        old = self.rubbing.geometry.shape
        shape = [
            ceil(_GROWTH * count) if side else count for count, side in zip(old, sides, strict=True)
        ]
        self.rubbing = Rubbing(self.problem, (shape[0], shape[1]))
        if state is not None:
            self.state = state.on(self.workspace, self.rubbing.geometry)


def _worn(state: StrokeState) -> Array:
    """Wear depth of indenter and flat, m, shape (2, …)."""
    return np.stack([state.wear_indenter, state.wear_flat])


def _flow(state: StrokeState) -> Array:
    """Plastic depth of indenter and flat, m, shape (2, …)."""
    return np.stack([state.flow_indenter, state.flow_flat])
