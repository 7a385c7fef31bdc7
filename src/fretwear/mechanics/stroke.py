"""Contacts that slide as a whole, over a stroke that need not be small compared with them.

Each point of a body meets different points of the other in the course of a stroke, and the wear of
the indenter moves with it. So a stroke is a series of contacts, one for each of several positions ξ
of the indenter, of the shape

    h(x, ξ) = h₀(x − ξ) + w₁(x − ξ) + w₂(x),   dw₁/dN = 4sK₁ ⟨p(X + ξ, ξ)⟩,
                                                 dw₂/dN = 4sK₂ ⟨p(x, ξ)⟩,

⟨⟩ being the mean over the stroke from −s to s, 4s the path of a cycle. Both directions and both
sides are equivalent, so half of the positions suffice; the contact at each is even along y only.

A step is implicit, TR-BDF2 as in `fretwear.mechanics.integrator`, and its stages are solved as one
problem each by `fretwear.mechanics.rubbing`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import ceil, inf
from typing import Any

import numpy as np

from fretwear.mechanics.geometry import Array, Mask, Workspace
from fretwear.mechanics.geometry.line import Line
from fretwear.mechanics.rubbing import MARGIN, Contacts, Rubbing, positions
from fretwear.mechanics.slip import ReducedContact
from fretwear.mechanics.state import State, WearProblem
from fretwear.mechanics.tr_bdf2 import (
    BEYOND,
    DIAGONAL,
    DIFFERENCE,
    GAMMA,
    MAIN,
    OVERESTIMATE,
    TOLERANCE,
    WEIGHT,
    Integrator,
    assessed,
    march,
)

_GROWTH = 1.2
_FIRST_STEP = 0.1


@dataclass(frozen=True, kw_only=True)
class StrokeState(State):
    """A state of a contact that slides as a whole.

    Pressure, gap and approach are those in the middle of the stroke, and wear is that of both
    bodies there.
    """

    #: Wear depth of the flat and of the indenter, each in its own coordinates, m, on the cells of
    #: the geometry, shape (2, n, m).
    worn: Array
    rates: Array  #: wear depth of each in this one cycle, m
    sunk: Array  #: plastic depth of each, m
    #: Pressure at each position, Pa, on cells of either side along x, shape (positions, 2n, m).
    pressures: Array

    @property
    def wear_indenter(self) -> Array:
        """Wear depth of the indenter in its own coordinates, m."""
        result: Array = self.worn[1]
        return result

    @property
    def wear_flat(self) -> Array:
        """Wear depth of the flat, m."""
        result: Array = self.worn[0]
        return result

    @property
    def wear_rate(self) -> Array:
        """Wear depth of both bodies in this one cycle, m, in the middle of the stroke."""
        result: Array = self.rates[1] + self.rates[0]
        return result

    def on(self, workspace: Workspace, geometry: Any) -> StrokeState:
        """The same state on more cells; its gap is computed where it was not known."""
        old = self.geometry
        if geometry.shape == old.shape:
            return self
        ground = workspace.on(geometry)
        fields = ("pressure", "wear", "opening", "plastic", "pressure_rate", "source_rate")
        longer: dict[str, Any] = {
            name: old.resized(getattr(self, name), geometry) for name in fields
        }
        for name in ("worn", "rates", "sunk"):
            longer[name] = np.stack([old.resized(each, geometry) for each in getattr(self, name)])
        moved = ground.half_space.displacement(longer["pressure"])
        gap = moved + ground.unworn + longer["opening"] + longer["plastic"] - self.approach
        gap[geometry.where(old)] = self.gap
        more, rows = (new - was for new, was in zip(geometry.shape, old.shape, strict=True))
        slipped = np.full(geometry.shape, self.reduced.gap[0, 0])
        return replace(
            self,
            geometry=geometry,
            gap=gap,
            reduced=replace(self.reduced, pressure=np.zeros(geometry.shape), gap=slipped),
            pressures=np.pad(self.pressures, ((0, 0), (more, more), (0, rows))),
            **longer,
        )


def slide(
    problem: WearProblem,
    stops: Sequence[float],
    tolerance: float = TOLERANCE,
    start: StrokeState | None = None,
) -> Iterator[StrokeState]:
    """Integrate the wear of both bodies over the cycles; parameters as of `evolve`.

    Raises
    ------
    WearError
        If the step had to be reduced to nothing.
    """

    def begin(block: WearProblem, state: StrokeState | None, anew: bool) -> Integrator:
        return _Slider(block, tolerance, state, anew=anew)

    return march(problem, stops, start, begin)


class _Slider(Integrator):
    """Of a contact that slides as a whole; of two bodies, the flat comes first."""

    def __init__(
        self, problem: WearProblem, tolerance: float, start: StrokeState | None, *, anew: bool
    ) -> None:
        self.problem, self.tolerance, self.state = problem, tolerance, start
        self.workspace = Workspace(problem)
        # Fraction of the wear that opens the gap: all but the debris.
        self.kept = 1.0 - problem.debris_fraction
        self.shares = np.array(problem.wear_law.shares or (1.0, 0.0))[::-1]
        x, y = (0, 0) if start is None else start.geometry.shape
        if anew:
            reach = problem.extent[0] + float(positions(problem)[0][-1])
            x = max(x, ceil(reach / problem.spacing[0]) + 2 * MARGIN)
            y = max(y, ceil(problem.extent[1] / problem.spacing[1]) + 2 * MARGIN)
        self._resize(x, 1 if problem.geometry is Line else y)
        if anew:
            self._load()

    def _resize(self, x: int, y: int) -> None:
        """Take so many cells, and put the state on them."""
        self.rubbing = Rubbing(self.problem, (x, y))
        if self.state is not None:
            self.state = self.state.on(self.workspace, self.rubbing.geometry)

    def _outgrown(self, found: Contacts) -> bool:
        """Whether the contacts came near the border, and there are more cells now."""
        sides = self.rubbing.reaches_border(found.pressures)
        if any(sides):
            old = self.rubbing.geometry.shape
            self._resize(
                *(ceil(_GROWTH * n) if side else n for n, side in zip(old, sides, strict=True))
            )
        return any(sides)

    def _load(self) -> None:
        """The state at the beginning of a block of loading."""
        problem, hertz = self.problem, self.problem.hertz
        wide, high = problem.indenter.half_widths(hertz)
        while True:
            rubbing, before = self.rubbing, self.state
            x = rubbing.x[:, None] - rubbing.places[:, None, None]
            closed = (x / wide) ** 2 + (rubbing.y / high) ** 2 < 1.0
            worn, sunk = np.zeros((2, 2, *rubbing.geometry.shape))
            if before is not None:
                closed = closed | (before.pressures > 0).any(axis=0)
                worn, sunk = before.worn, before.sunk
            closed = closed.reshape(len(closed), -1)
            found = rubbing.solve(self._opening(worn, sunk), np.zeros(worn.size), closed)
            if not self._outgrown(found):
                break
        cycle, step = (0.0, 0) if before is None else (before.cycle, before.step)
        growth = self.kept * self.rates(cycle).sum() * hertz.peak_pressure
        depth = hertz.peak_pressure * float(rubbing.influence[0, 0, 0])
        first = _FIRST_STEP * depth / growth if growth > 0 else inf
        fields = self._fields(cycle, found, worn, sunk + self._by_body(found.flow), 0.0)
        self.state = StrokeState(cycle=cycle, next_step=first, step=step, **fields)

    def rates(self, cycle: float, energy_density: float = 0.0) -> Array:
        """Wear depth of both bodies per mean pressure and cycle, m/Pa, shape (2,).

        ``energy_density`` is the energy per cycle and area of contact, J/m².
        """
        coefficient = self.problem.at(cycle, energy_density).wear_coefficient
        result: Array = 4.0 * self.problem.loading.stroke * coefficient * self.shares
        return result

    def energy_density(self, cycle: float, pressures: Array) -> float:
        """Energy per cycle and area of contact, J/m², in the mean over the stroke."""
        problem, rubbing = self.problem.at(cycle), self.rubbing
        closed = (pressures > 0).reshape(len(pressures), -1).sum(axis=1)
        area = 2.0 * rubbing.area * float(rubbing.weights @ closed)
        force = problem.friction.coefficient * problem.hertz.load
        return 4.0 * force * problem.loading.stroke / area

    def _opening(self, worn: Array, sunk: Array) -> Array:
        """What is worn off both bodies or has sunk, m, shape (values,)."""
        both: Array = (self.kept * worn + sunk).ravel()
        return both

    def _by_body(self, values: Array) -> Array:
        """Values of both bodies as fields, shape (2, …)."""
        return values.reshape(2, *self.rubbing.geometry.shape)

    def attempt(
        self, step: float, end: float, *, output_step: bool
    ) -> tuple[dict[str, Any], float, bool] | None:
        """Both stages, and what they differ by from embedded formulas."""
        del output_step
        base: StrokeState = self.state
        # Inverses of earlier steps are dropped, because a resumed run does not have them.
        self.rubbing.inverses.clear()

        def stage(
            known: Array, sunk: Array, cycle: float, energy_density: float, closed: Mask
        ) -> tuple[Contacts, Array]:
            rates = self.rates(cycle, energy_density)
            softness = np.repeat(self.kept * DIAGONAL * step * rates, known[0].size)
            found = self.rubbing.solve(self._opening(known, sunk), softness, closed)
            return found, rates[:, None, None] * self._by_body(found.means)

        middle, started = base.cycle + GAMMA * step, base.rates
        # A wear coefficient that follows the power lags by one stage.
        density = self.energy_density(base.cycle, base.pressures)
        closed = (base.pressures > 0).reshape(len(base.pressures), -1)
        known = base.worn + DIAGONAL * step * started
        first, between = stage(known, base.sunk, middle, density, closed)
        reached = self.energy_density(middle, first.pressures)
        between *= (self.rates(middle, reached) / self.rates(middle, density))[:, None, None]
        sunk = base.sunk + self._by_body(first.flow)
        known = base.worn + WEIGHT * step * (started + between)
        ahead = max(0.0, reached + BEYOND * (reached - density))
        last, ended = stage(known, sunk, end, ahead, first.pressures > 0)
        if self._outgrown(last):
            return None
        worn, missed = (
            step * sum(w * rate for w, rate in zip(weights, (started, between, ended), strict=True))
            for weights in (MAIN, DIFFERENCE)
        )
        worn = base.worn + worn
        error = float(np.abs(missed).sum() / worn.sum()) / (OVERESTIMATE * self.tolerance)
        sunk = sunk + self._by_body(last.flow)
        return self._fields(end, last, worn, sunk, error * self.tolerance), *assessed(error)

    def _fields(
        self, cycle: float, found: Contacts, worn: Array, sunk: Array, error: float
    ) -> dict[str, Any]:
        """Fields of the state with the contact in the middle of the stroke."""
        problem, geometry = self.problem.at(cycle), self.rubbing.geometry
        ground = self.workspace.on(geometry)
        opening, plastic = self.kept * worn.sum(axis=0), sunk.sum(axis=0)
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
        rates = self.rates(cycle, self.energy_density(cycle, pressures))
        return {
            "geometry": geometry,
            "pressure": middle,
            "gap": np.where(middle > 0, 0.0, np.maximum(gap, 0.0)),
            "wear": worn.sum(axis=0),
            "opening": opening,
            "plastic": plastic,
            "load": problem.hertz.load,
            "approach": approach,
            "residual": float(residual),
            "reduced": reduced,
            "pressure_rate": nothing,
            "source_rate": nothing,
            "error_estimate": error,
            "worn": worn,
            "rates": rates[:, None, None] * self._by_body(found.means),
            "sunk": sunk,
            "pressures": pressures,
        }
