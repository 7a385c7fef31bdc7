"""Line contacts that slide as a whole, over a stroke that need not be small beside the contact.

Each point of a body meets different points of the other in the course of a stroke, and what is
worn stays where it was worn: of the indenter it moves with the indenter. So a stroke is a row of
contacts, one for each of some positions ξ of the indenter, of one shape

    h(x, ξ) = (x − ξ)²/2R + w₁(x − ξ) + w₂(x),   dw₁/dN = 4sK₁ ⟨p(X + ξ, ξ)⟩,
                                                 dw₂/dN = 4sK₂ ⟨p(x, ξ)⟩,

⟨⟩ the mean over the stroke from −s to s, 4s the path of a cycle. A cycle is the same to and fro and
on either side, so half of the positions tell all.

A step is implicit, TR-BDF2 as in `fretwear.mechanics.integrator`. The pressures of a stage are a
minimum of

    Σ ω [½ (p, K p) + (h, p)] + ½ c₁ ∫⟨p⟩₁² + ½ c₂ ∫⟨p⟩₂²   under   p ≥ 0,  ∫p = P at each position:

wear that positions share couples them symmetrically and adds to a sum of positive definite forms,
so a stage is one strictly convex problem. It is solved as one: on given sets of cells in contact,
the pressures are eliminated position by position, which leaves a positive definite system for the
wear alone, and cells change sides until each has pressure or a gap.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import ceil, inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretwear.mechanics.contact import ContactError
from fretwear.mechanics.geometry import Array, Mask, Workspace
from fretwear.mechanics.geometry.line import Line, influence_of_cell
from fretwear.mechanics.integrator import WearError
from fretwear.mechanics.loading import SMALL_STROKE
from fretwear.mechanics.slip import ReducedContact
from fretwear.mechanics.state import State, WearProblem
from fretwear.mechanics.tr_bdf2 import (
    DIAGONAL,
    EMBEDDED,
    MAIN,
    OVERESTIMATE,
    SMALLEST_STEP,
    WEIGHT,
    assessed,
    step_after,
    step_towards,
)

LEAST_POSITIONS = 8
_POSITIONS_PER_HALF_WIDTH = 2.0
_MARGIN = 6
_GROWTH = 1.2
_FIRST_STEP = 0.1
_LARGEST_SWEEPS = 60
_KEPT = 16
# Cells touch where the gap is below this part of the approach.
_CLOSED = 1e-10


def positions(problem: WearProblem) -> tuple[Array, Array]:
    """Positions of the indenter from the middle of the stroke to its end, m, and their weights.

    Those of the trapezoidal rule over the stroke; the weight of one and its image is twice that.
    """
    amplitude, half_width = problem.loading.stroke, problem.hertz.contact_radius
    if amplitude <= SMALL_STROKE * half_width:
        return np.zeros(1), np.full(1, 0.5)
    wanted = max(LEAST_POSITIONS / 2, _POSITIONS_PER_HALF_WIDTH * amplitude / half_width)
    count = ceil(wanted)
    weights = np.full(count + 1, 0.5 / count)
    weights[[0, -1]] *= 0.5
    return np.linspace(0.0, amplitude, count + 1), weights


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
    pressures
        Pressure at each position, Pa, on the cells of the whole line, shape (positions, 2n).
    """

    wear_indenter: Array
    wear_flat: Array
    rate_indenter: Array
    rate_flat: Array
    pressures: Array

    @property
    def wear_rate(self) -> Array:
        """Wear depth of both bodies in this one cycle, m, in the middle of the stroke."""
        return self.rate_indenter + self.rate_flat

    def on(self, workspace: Workspace, geometry: Any) -> StrokeState:
        """The same state on a longer line; its gap is computed where it was not known."""
        old, cells = self.geometry, self.geometry.shape[0]
        if geometry.shape == old.shape:
            return self
        ground = workspace.on(geometry)
        fields = ("pressure", "wear", "opening", "plastic", "pressure_rate", "source_rate")
        of_bodies = ("wear_indenter", "wear_flat", "rate_indenter", "rate_flat")
        longer: dict[str, Any] = {
            name: old.resized(getattr(self, name), geometry) for name in fields + of_bodies
        }
        moved = ground.half_space.displacement(longer["pressure"])
        gap = moved + ground.unworn + longer["opening"] - self.approach
        gap[:cells] = self.gap
        added = geometry.shape[0] - cells
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
            pressures=np.pad(self.pressures, ((0, 0), (added, added))),
            **longer,
        )


@dataclass(frozen=True)
class _Contacts:
    """Pressures of a stage at all positions, the cells in contact, and means over the stroke."""

    pressures: Array
    closed: Mask
    indenter: Array
    flat: Array


class _Rubbing:
    """The contacts of a stroke on the cells of a line.

    Bodies are even, so wear has a value for each cell of the half x > 0, while a contact off the
    middle of the stroke covers the whole line. Between cells, the wear of the indenter is linear;
    what it takes from the pressure is the transpose of that.
    """

    def __init__(self, problem: WearProblem, half: int, spacing: float) -> None:
        from scipy.linalg import toeplitz
        from scipy.sparse import csr_matrix

        self.half, self.spacing, self.load = half, spacing, problem.hertz.load
        self.geometry = _line(half, spacing, problem.hertz.radius)
        cells = 2 * half
        x = (np.arange(cells) - half + 0.5) * spacing
        modulus = problem.bodies.composite_modulus
        self.influence = toeplitz(influence_of_cell(cells, spacing, problem.hertz.radius, modulus))
        self.places, self.weights = positions(problem)
        self.shapes = [problem.indenter.gap(x - place, np.zeros(1)) for place in self.places]
        # One row a cell, one column a value of the flat's wear, then of the indenter's.
        self.worn = []
        for place in self.places:
            at = np.abs(x - place) / spacing - 0.5
            lower = np.floor(at).astype(int)
            part = at - lower
            columns = [np.floor(np.abs(x) / spacing).astype(int)]
            columns += [half + np.clip(each, 0, half - 1) for each in (lower, lower + 1)]
            inside = np.abs(x - place) < half * spacing
            values = np.concatenate([np.ones(cells), (1.0 - part) * inside, part * inside])
            where = np.tile(np.arange(cells), 3), np.concatenate(columns)
            self.worn.append(csr_matrix((values, where), shape=(cells, 2 * half)))
        self._inverses: dict[int, tuple[Array, Array]] = {}

    def _compliance(self, cells: NDArray[np.intp]) -> tuple[Array, Array]:
        """Pressure of no load for a unit displacement of each cell, and that of unit load."""
        count = cells.size
        whole = cells[-1] - cells[0] + 1 == count
        if whole and count in self._inverses:
            return self._inverses[count]
        matrix = self.influence[:count, :count] if whole else self.influence[np.ix_(cells, cells)]
        inverse = np.linalg.inv(matrix)
        flat = inverse.sum(axis=1)
        total = flat.sum()
        found = inverse - np.outer(flat, flat) / total, flat / (total * self.spacing)
        if whole:
            if len(self._inverses) >= _KEPT:
                del self._inverses[next(iter(self._inverses))]
            self._inverses[count] = found
        return found

    def solve(self, opening: Array, compliance: Array, closed: Mask) -> _Contacts:
        """The contacts of all positions.

        Parameters
        ----------
        opening
            What is worn off the flat and the indenter before, m, shape (2 half,).
        compliance
            What this stage wears off for its mean pressure, m/Pa, shape (2 half,); not negative.
        closed
            First guess of the cells in contact, shape (positions, 2 half).

        Raises
        ------
        ContactError
            If the cells in contact do not settle.
        """
        from scipy.linalg import cho_factor, cho_solve

        shapes = [
            shape + worn @ opening for shape, worn in zip(self.shapes, self.worn, strict=True)
        ]
        root = np.sqrt(compliance)
        for _ in range(_LARGEST_SWEEPS):
            matrix, right, parts = np.eye(root.size), np.zeros(root.size), []
            of_positions = zip(shapes, self.worn, self.weights, closed, strict=True)
            for shape, worn, weight, inside in of_positions:
                cells = np.flatnonzero(inside)
                inverse, carrying = self._compliance(cells)
                own = worn[cells]
                pressure = self.load * carrying - inverse @ shape[cells]
                stiff = own.T @ (own.T @ inverse).T
                matrix += weight * root[:, None] * stiff * root
                right += weight * root * (own.T @ pressure)
                parts.append((cells, inverse, own, pressure))
            factors = cho_factor(matrix, lower=True, overwrite_a=True, check_finite=False)
            worn_now = root * cho_solve(factors, right, check_finite=False)
            pressures, following = np.zeros(closed.shape), closed.copy()
            for row, (cells, inverse, own, pressure) in enumerate(parts):
                pressures[row, cells] = pressure - inverse @ (own @ worn_now)
                gap = self.influence @ pressures[row] + shapes[row] + self.worn[row] @ worn_now
                approach = gap[cells].mean()
                following[row] = np.where(
                    closed[row], pressures[row] > 0, gap < (1.0 - _CLOSED) * approach
                )
            if np.array_equal(following, closed):
                parts_of = zip(self.weights, self.worn, pressures, strict=True)
                means = np.sum([w * (worn.T @ p) for w, worn, p in parts_of], axis=0)
                return _Contacts(pressures, closed, means[self.half :], means[: self.half])
            closed = following
        raise ContactError("the cells in contact over the stroke do not settle")

    def reaches_border(self, closed: Mask) -> bool:
        """Whether a contact comes near an end of the line."""
        return bool(closed[:, :_MARGIN].any() or closed[:, -_MARGIN:].any())


def _line(half: int, spacing: float, reference: float) -> Line:
    return Line(tuple(float(each) for each in np.arange(half + 1) * spacing), reference)


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
        If the step had to be cut to nothing, or if another block follows.
    """
    if problem.following is not None:
        raise WearError("blocks do not go with a sliding amplitude, which is the same all along")
    slider = _Slider(problem, tolerance, start)
    if start is None:
        yield slider.state
    for stop in stops:
        while slider.state.cycle < stop:
            yield slider.advance(stop)


class _Slider:
    """Makes accepted states one after the other."""

    def __init__(self, problem: WearProblem, tolerance: float, start: StrokeState | None) -> None:
        self.problem, self.tolerance = problem, tolerance
        self.workspace = Workspace(problem)
        spacing = problem.spacing[0]
        shares = np.array(problem.wear_law.shares or (1.0, 0.0))
        # Of indenter and flat: wear depth per mean pressure and cycle.
        self.rates = 4.0 * problem.loading.stroke * problem.wear_coefficient * shares
        if start is not None:
            self.rubbing = _Rubbing(problem, start.geometry.shape[0], spacing)
            self.state = start
            return
        reach = problem.extent[0] + float(positions(problem)[0][-1])
        self.rubbing = _Rubbing(problem, ceil(reach / spacing) + 2 * _MARGIN, spacing)
        self.state = self._first()

    @cached_property
    def kept(self) -> float:
        """Part of the wear that opens the gap: all but the debris."""
        return 1.0 - self.problem.debris_fraction

    def _first(self) -> StrokeState:
        rubbing, a = self.rubbing, self.problem.hertz.contact_radius
        x = (np.arange(2 * rubbing.half) - rubbing.half + 0.5) * rubbing.spacing
        closed = np.abs(x - rubbing.places[:, None]) < a
        nothing = np.zeros(2 * rubbing.half)
        found = rubbing.solve(nothing, nothing, closed)
        worn = np.zeros((2, rubbing.half))
        growth = self.kept * self.rates.sum() * self.problem.hertz.peak_pressure
        depth = self.problem.hertz.peak_pressure * float(rubbing.influence[0, 0])
        first = _FIRST_STEP * depth / growth if growth > 0 else inf
        return self._state(0.0, first, found, worn, step=0, error=0.0)

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
                last, worn, error = self._stages(step)
            except ContactError as problem:
                wanted, trouble = 0.5 * step, str(problem)
                continue
            if self.rubbing.reaches_border(last.closed):
                self._grow()
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
                step=self.state.step + 1,
                error=error * self.tolerance,
            )
            return self.state

    def _stages(self, step: float) -> tuple[_Contacts, Array, float]:
        """The contacts at the end of a step, the wear of both bodies, and the error estimate."""
        base, rubbing = self.state, self.rubbing
        worn = np.stack([base.wear_indenter[:, 0], base.wear_flat[:, 0]])
        started = np.stack([base.rate_indenter[:, 0], base.rate_flat[:, 0]])
        compliance = self.kept * DIAGONAL * step * self.rates
        softness = np.repeat(compliance[::-1], rubbing.half)

        def stage(known: Array, closed: Mask) -> tuple[_Contacts, Array]:
            opening = self.kept * np.concatenate([known[1], known[0]])
            found = rubbing.solve(opening, softness, closed)
            return found, self.rates[:, None] * np.stack([found.indenter, found.flat])

        closed = base.pressures > 0
        first, between = stage(worn + DIAGONAL * step * started, closed)
        second, ended = stage(worn + WEIGHT * step * (started + between), first.closed)
        rates = (started, between, ended)
        worn = worn + step * sum(weight * rate for weight, rate in zip(MAIN, rates, strict=True))
        weights = [e - m for e, m in zip(EMBEDDED, MAIN, strict=True)]
        missed = step * sum(weight * rate for weight, rate in zip(weights, rates, strict=True))
        error = float(np.abs(missed).sum() / worn.sum()) / (OVERESTIMATE * self.tolerance)
        return second, worn, error

    def _state(
        self,
        cycle: float,
        following: float,
        found: _Contacts,
        worn: Array,
        *,
        step: int,
        error: float,
    ) -> StrokeState:
        """The state with the contact in the middle of the stroke."""
        problem, geometry = self.problem, self.rubbing.geometry
        ground = self.workspace.on(geometry)
        indenter, flat = worn[0][:, None], worn[1][:, None]
        opening = self.kept * (indenter + flat)
        half = self.rubbing.half
        # The middle of the stroke is the first position.
        middle = found.pressures[0, half:, None]
        separation = ground.half_space.displacement(middle) + ground.unworn + opening
        approach = float(separation[middle > 0].mean())
        gap = separation - approach
        residual = np.abs(np.where(middle > 0, gap, np.minimum(gap, 0.0))).max() / approach
        slip = problem.loading.stroke / (problem.friction.coefficient * problem.coupling)
        nothing = np.zeros(geometry.shape)
        reduced = ReducedContact(nothing, np.full(geometry.shape, slip), approach - slip, load=0.0)
        return StrokeState(
            cycle=cycle,
            geometry=geometry,
            pressure=middle,
            gap=np.where(middle > 0, 0.0, np.maximum(gap, 0.0)),
            wear=indenter + flat,
            opening=opening,
            plastic=nothing,
            load=problem.hertz.load,
            approach=approach,
            residual=float(residual),
            reduced=reduced,
            next_step=following,
            pressure_rate=nothing,
            source_rate=nothing,
            step=step,
            error_estimate=error,
            wear_indenter=indenter,
            wear_flat=flat,
            rate_indenter=self.rates[0] * found.indenter[:, None],
            rate_flat=self.rates[1] * found.flat[:, None],
            pressures=found.pressures,
        )

    def _grow(self) -> None:
        """Put the state on a longer line."""
        half = ceil(_GROWTH * self.rubbing.half)
        self.rubbing = _Rubbing(self.problem, half, self.rubbing.spacing)
        self.state = self.state.on(self.workspace, self.rubbing.geometry)
