"""Contacts that slide as a whole, over a stroke that need not be small beside them.

Each point of a body meets different points of the other in the course of a stroke, and what is
worn stays where it was worn: of the indenter it moves with the indenter. So a stroke is a row of
contacts, one for each of some positions ξ of the indenter, of one shape

    h(x, ξ) = h₀(x − ξ) + w₁(x − ξ) + w₂(x),   dw₁/dN = 4sK₁ ⟨p(X + ξ, ξ)⟩,
                                                 dw₂/dN = 4sK₂ ⟨p(x, ξ)⟩,

⟨⟩ the mean over the stroke from −s to s, 4s the path of a cycle. A cycle is the same to and fro and
on either side, so half of the positions tell all; the contact at one of them is even along y only.

A step is implicit, TR-BDF2 as in `fretwear.mechanics.integrator`. The pressures of a stage are a
minimum of

    Σ ω [½ (p, K p) + (h, p)] + ½ c₁ ∫⟨p⟩₁² + ½ c₂ ∫⟨p⟩₂²   under   p ≥ 0,  ∫p = P at each position:

wear that positions share couples them symmetrically and adds to a sum of positive definite forms,
so a stage is one strictly convex problem. It is solved as one: on given sets of cells in contact,
the pressures are eliminated position by position, which leaves a positive definite system for the
wear alone, and cells change sides until each has pressure or a gap. Cells at the plastic limit bear
it, and what still penetrates there is flow, half of it of each body: the most over all positions.
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
from fretwear.mechanics.geometry.grid import Grid, influence_coefficients
from fretwear.mechanics.geometry.line import Line, influence_of_cell
from fretwear.mechanics.integrator import WearError
from fretwear.mechanics.loading import SMALL_STROKE
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
from fretwear.theory import LineContact

LEAST_POSITIONS = 8
_POSITIONS_PER_HALF_WIDTH = 2.0
_MARGIN = 6
_GROWTH = 1.2
_FIRST_STEP = 0.1
_LARGEST_SWEEPS = 60
_OF_BODIES = (
    "wear_indenter",
    "wear_flat",
    "rate_indenter",
    "rate_flat",
    "flow_indenter",
    "flow_flat",
)
# Cells touch where the gap is below this part of the approach.
_CLOSED = 1e-10


def positions(problem: WearProblem) -> tuple[Array, Array]:
    """Positions of the indenter from the middle of the stroke to its end, m, and their weights.

    Those of the trapezoidal rule over the stroke; the weight of one and its image is twice that.
    """
    amplitude, half_width = problem.loading.stroke, problem.indenter.half_widths(problem.hertz)[0]
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


@dataclass(frozen=True)
class _Contacts:
    """The contacts of a stage at all positions.

    Attributes
    ----------
    pressures
        Pa, shape (positions, cells).
    closed, capped
        Cells in contact, and those of them at the plastic limit.
    means
        Over the stroke, of each value of the flat and the indenter, Pa.
    flow
        How far each of them sinks where the pressure is at the limit, m.
    """

    pressures: Array
    closed: Mask
    capped: Mask
    means: Array
    flow: Array


class _Rubbing:
    """The contacts of a stroke on equal cells.

    Bodies are even along both axes, so wear has a value for each cell of the quarter, while a
    contact off the middle of the stroke needs both sides along x. Between cells, the wear of the
    indenter is linear; what it takes from the pressure is the transpose of that.

    Parameters
    ----------
    problem
        What slides.
    shape
        Cells of the quarter along x and y; one along y in a line contact.
    """

    def __init__(self, problem: WearProblem, shape: tuple[int, int]) -> None:
        from scipy.sparse import csr_matrix

        self.load, self.limit = problem.hertz.load, problem.limit
        half, self.rows = shape
        count, spacing = 2 * half, problem.spacing
        self.places, self.weights = positions(problem)
        modulus = problem.bodies.composite_modulus
        # Displacement by the distance along x, and the row of either cell.
        if problem.geometry is Line:
            hertz = problem.hertz
            assert isinstance(hertz, LineContact)
            edges = tuple(float(each) for each in np.arange(half + 1) * spacing[0])
            self.geometry: Any = Line(edges, hertz.reference)
            column = influence_of_cell(count, spacing[0], hertz.reference, modulus)
            self.influence = column[:, None, None]
            self.area, self.y = spacing[0], np.zeros(1)
        else:
            self.geometry = Grid(shape, spacing)
            love = influence_coefficients((count, 2 * self.rows), spacing, modulus)
            row = np.arange(self.rows)
            here, image = abs(row[:, None] - row), row[:, None] + row + 1
            self.influence = love[:, here] + love[:, image]
            self.area, self.y = 2.0 * spacing[0] * spacing[1], self.geometry.y
        self._transform = np.fft.rfft(
            np.concatenate([self.influence, self.influence[:1], self.influence[:0:-1]]), axis=0
        )
        self.x = (np.arange(count) - half + 0.5) * spacing[0]
        self.cells, values = count * self.rows, half * self.rows
        self.shapes = [
            np.broadcast_to(
                problem.indenter.gap((self.x - place)[:, None], self.y[None, :]),
                (count, self.rows),
            ).ravel()
            for place in self.places
        ]
        # One row a cell, one column a value of the flat's wear, then of the indenter's.
        self.worn = []
        along, row = np.divmod(np.arange(self.cells), self.rows)
        x = self.x[along]
        for place in self.places:
            at = np.abs(x - place) / spacing[0] - 0.5
            lower = np.floor(at).astype(int)
            part = at - lower
            columns = [np.floor(np.abs(x) / spacing[0]).astype(int) * self.rows + row]
            columns += [
                values + np.clip(each, 0, half - 1) * self.rows + row for each in (lower, lower + 1)
            ]
            inside = np.abs(x - place) < half * spacing[0]
            shares = np.concatenate([np.ones(x.size), (1.0 - part) * inside, part * inside])
            where = np.tile(np.arange(x.size), 3), np.concatenate(columns)
            self.worn.append(csr_matrix((shares, where), shape=(x.size, 2 * values)))
        self._inverses: dict[bytes, tuple[Array, Array]] = {}

    def displacement(self, pressure: Array) -> Array:
        """Of all cells, m, under a pressure, Pa."""
        field = pressure.reshape(-1, self.rows)
        waves = np.fft.rfft(field, self.influence.shape[0] * 2, axis=0)
        moved = np.fft.irfft(np.einsum("kij,kj->ki", self._transform, waves), axis=0)
        result: Array = moved[: field.shape[0]].ravel()
        return result

    def _matrix(self, cells: NDArray[np.intp], others: NDArray[np.intp]) -> Array:
        """Displacement of some cells under a unit pressure on others, m/Pa."""
        along, row = np.divmod(cells, self.rows)
        other_along, other_row = np.divmod(others, self.rows)
        apart = np.abs(along[:, None] - other_along)
        found: Array = self.influence[apart, row[:, None], other_row]
        return found

    def _compliance(self, cells: NDArray[np.intp]) -> tuple[Array, Array]:
        """Pressure of no load for a unit displacement of each cell, and that of unit load."""
        from scipy.linalg.lapack import dpotrf, dpotri

        # It does not depend on where along x the cells lie.
        key = (cells - cells[0] // self.rows * self.rows).tobytes()
        if key in self._inverses:
            return self._inverses[key]
        # Cholesky's factors take half the time of a general inverse.
        factor, _ = dpotrf(self._matrix(cells, cells), lower=True, overwrite_a=True)
        lower, _ = dpotri(factor, lower=True, overwrite_c=True)
        inverse = np.tril(lower) + np.tril(lower, -1).T
        flat = inverse.sum(axis=1)
        total = flat.sum()
        found = inverse - np.outer(flat, flat) / total, flat / (total * self.area)
        if len(self._inverses) > self.places.size:
            del self._inverses[next(iter(self._inverses))]
        self._inverses[key] = found
        return found

    def solve(
        self, opening: Array, compliance: Array, closed: Mask, capped: Mask | None = None
    ) -> _Contacts:
        """The contacts of all positions.

        Parameters
        ----------
        opening
            What is worn off the flat and the indenter before, or has sunk, m, shape (values,).
        compliance
            What this stage wears off for its mean pressure, m/Pa, shape (values,); not negative.
        closed, capped
            First guess of the cells in contact, and at the limit, shape (positions, cells).

        Raises
        ------
        ContactError
            If the cells in contact do not settle.
        """
        from scipy.linalg import cho_factor, cho_solve

        if capped is None:
            capped = np.zeros_like(closed)
        shapes = [
            shape + worn @ opening for shape, worn in zip(self.shapes, self.worn, strict=True)
        ]
        for _ in range(_LARGEST_SWEEPS):
            parts, touched = [], np.zeros(opening.size, np.bool_)
            for shape, worn, inside, full in zip(shapes, self.worn, closed, capped, strict=True):
                free, held = np.flatnonzero(inside & ~full), np.flatnonzero(full)
                left = self.load - self.limit * self.area * held.size if held.size else self.load
                if not free.size or left <= 0.0:
                    raise ContactError("the contact is at the plastic limit all over")
                inverse, carrying = self._compliance(free)
                height = shape[free]
                if held.size:
                    height = height + self._matrix(free, held).sum(axis=1) * self.limit
                pressure = np.where(full, self.limit, 0.0) if held.size else np.zeros(inside.size)
                pressure[free] = left * carrying - inverse @ height
                parts.append((free, inverse, worn[free], pressure))
                touched[worn[free].indices] = True
            values = np.flatnonzero(touched)
            root = np.sqrt(compliance[values])
            matrix, right = np.eye(values.size), np.zeros(values.size)
            for weight, worn, (_, inverse, own, pressure) in zip(
                self.weights, self.worn, parts, strict=True
            ):
                seen = own[:, values]
                stiff = seen.T @ (seen.T @ inverse).T
                matrix += weight * root[:, None] * stiff * root
                right += weight * root * (worn.T @ pressure)[values]
            factors = cho_factor(matrix, lower=True, overwrite_a=True, check_finite=False)
            worn_now = compliance * sum(
                weight * (worn.T @ part[-1])
                for weight, worn, part in zip(self.weights, self.worn, parts, strict=True)
            )
            worn_now[values] = root * cho_solve(factors, right, check_finite=False)
            pressures = np.zeros(closed.shape)
            now_closed, now_capped = closed.copy(), capped.copy()
            flow = np.zeros(opening.size)
            for row, (free, inverse, own, pressure) in enumerate(parts):
                pressure[free] -= inverse @ (own @ worn_now)
                pressures[row] = pressure
                gap = self.displacement(pressure) + shapes[row] + self.worn[row] @ worn_now
                approach = gap[free].mean()
                now_closed[row] = np.where(
                    closed[row], pressure > 0, gap < (1.0 - _CLOSED) * approach
                )
                sunk = approach - gap
                now_capped[row] = np.where(capped[row], sunk > 0.0, pressure > self.limit)
                if capped[row].any():
                    sinking = self.worn[row][np.flatnonzero(capped[row])].tocoo()
                    depth = sunk[capped[row]][sinking.row]
                    np.maximum.at(flow, sinking.col, 0.5 * depth * (sinking.data > 0.0))
            if np.array_equal(now_closed, closed) and np.array_equal(now_capped, capped):
                parts_of = zip(self.weights, self.worn, pressures, strict=True)
                means = np.sum([w * (worn.T @ p) for w, worn, p in parts_of], axis=0)
                return _Contacts(pressures, closed, capped, means, flow)
            closed, capped = now_closed, now_capped
        raise ContactError("the cells in contact over the stroke do not settle")

    def reaches_border(self, closed: Mask) -> tuple[bool, bool]:
        """Whether a contact comes near an end of the cells along x, and along y."""
        field = closed.reshape(len(closed), -1, self.rows)
        ends = field[:, :_MARGIN].any() or field[:, -_MARGIN:].any()
        return bool(ends), self.rows > 1 and bool(field[:, :, -_MARGIN:].any())


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
        self.rubbing = _Rubbing(problem, shape)
        if start is not None:
            self.state = start.on(self.workspace, self.rubbing.geometry)
        if anew:
            self.state = self._loaded(start and self.state)

    def _first_shape(self, least: tuple[int, int]) -> tuple[int, int]:
        problem = self.problem
        reach = problem.extent[0] + float(positions(problem)[0][-1])
        extent = [reach, problem.extent[1]]
        cells = [
            max(was, ceil(far / size) + 2 * _MARGIN)
            for was, far, size in zip(least, extent, problem.spacing, strict=True)
        ]
        return cells[0], 1 if problem.geometry is Line else cells[1]

    def rates(self, cycle: float) -> Array:
        """Wear depth of indenter and flat per mean pressure and cycle, m/Pa."""
        problem = self.problem.at(cycle)
        shares = np.array(problem.wear_law.shares or (1.0, 0.0))
        result: Array = 4.0 * problem.loading.stroke * problem.wear_coefficient * shares
        return result

    @cached_property
    def kept(self) -> float:
        """Part of the wear that opens the gap: all but the debris."""
        return 1.0 - self.problem.debris_fraction

    def _opening(self, worn: Array, flow: Array) -> Array:
        """What is worn off the flat and the indenter or has sunk, as `_Rubbing` has it, m."""
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
            except ContactError as problem:
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

    def _stages(self, step: float) -> tuple[_Contacts, Array, Array, float]:
        """The contacts at the end of a step, wear and flow of both bodies, the error estimate."""
        base, rubbing = self.state, self.rubbing
        worn, flow = _worn(base), _flow(base)
        started = np.stack([base.rate_indenter, base.rate_flat])

        def stage(
            known: Array, flow: Array, cycle: float, closed: Mask, capped: Mask | None
        ) -> tuple[_Contacts, Array]:
            rates = self.rates(min(cycle, self.problem.end))
            softness = np.repeat(self.kept * DIAGONAL * step * rates[::-1], worn[0].size)
            found = rubbing.solve(self._opening(known, flow), softness, closed, capped)
            return found, rates[:, None, None] * self._by_body(found.means)

        closed = (base.pressures > 0).reshape(len(base.pressures), -1)
        middle, end = base.cycle + GAMMA * step, base.cycle + step
        first, between = stage(worn + DIAGONAL * step * started, flow, middle, closed, None)
        flow = flow + self._by_body(first.flow)
        known = worn + WEIGHT * step * (started + between)
        second, ended = stage(known, flow, end, first.closed, None)
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
        found: _Contacts,
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
        rates = self.rates(cycle)[:, None, None] * self._by_body(found.means)
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
        self.rubbing = _Rubbing(self.problem, (shape[0], shape[1]))
        if state is not None:
            self.state = state.on(self.workspace, self.rubbing.geometry)


def _worn(state: StrokeState) -> Array:
    """Wear depth of indenter and flat, m, shape (2, …)."""
    return np.stack([state.wear_indenter, state.wear_flat])


def _flow(state: StrokeState) -> Array:
    """Plastic depth of indenter and flat, m, shape (2, …)."""
    return np.stack([state.flow_indenter, state.flow_flat])
