"""Contacts that slide as a whole, over a stroke that need not be small compared with them.

Each point of a body meets different points of the other in the course of a stroke, and the wear of
the indenter moves with it. So a stroke is a series of contacts, one for each of several positions ξ
of the indenter, of the shape

    h(x, ξ) = h₀(x − ξ) + w₁(x − ξ) + w₂(x),   dw₁/dN = 4sK₁ ⟨p(X + ξ, ξ)⟩,
                                                 dw₂/dN = 4sK₂ ⟨p(x, ξ)⟩,

⟨⟩ being the mean over the stroke from −s to s, 4s the path of a cycle. Both directions and both
sides are equivalent, so half of the positions suffice; the contact at each is even along y only.

The pressures of an implicit stage of `fretwear.mechanics.integrator` are a minimum of

    Σ ω [½ (p, K p) + (h, p)] + ½ c₁ ∫⟨p⟩₁² + ½ c₂ ∫⟨p⟩₂²   under   p ≥ 0,  ∫p = P at each position:

wear that positions share couples them symmetrically and adds to a sum of positive definite forms,
so a stage is one strictly convex problem. It is solved as one: on given sets of cells in contact,
the pressures are eliminated position by position, which leaves a positive definite system for the
wear alone, and cells change sides until each has pressure or a gap. Cells at the plastic limit bear
it, and the penetration that is left there is flow, half of it in each body: the largest over all
positions.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import ceil, inf
from typing import NamedTuple, Self

import numpy as np

from fretwear.arrays import Array, Mask, Places
from fretwear.mechanics import integrator
from fretwear.mechanics.contact import ContactError, Exchange
from fretwear.mechanics.geometry import Geometry, Workspace
from fretwear.mechanics.geometry.grid import Grid, influence_coefficients
from fretwear.mechanics.geometry.strips import Strips, influence_of_cell
from fretwear.mechanics.integrator import TOLERANCE, TR_BDF2, Integrator
from fretwear.mechanics.slip import ReducedContact
from fretwear.mechanics.state import State, WearProblem
from fretwear.theory import LineContact

# Positions over half a stroke: the least number, and the numbers per half-width of the contact, per
# rounded edge of a line contact and per wave.
_LEAST_POSITIONS, _PER_HALF_WIDTH, _PER_EDGE, _PER_WAVE = 4, 2.0, 4.0, 6.0
_MOST_FOR_EDGE = 24
# Cells between a contact and the border, and the factor by which they grow.
_MARGIN, _GROWTH = 6, 1.2
_FIRST_STEP, _LARGEST_SWEEPS = 0.1, 200
# Sweeps without a new minimum of cells that change sides, before only one of them does.
_PATIENCE = 10
# Largest number of passes over the stroke in which bodies sink when they are loaded.
_LARGEST_PASSES = 20
# Cells touch where the gap is below this part of the approach.
_CLOSED = 1e-10


@dataclass(frozen=True, kw_only=True)
class StrokeState(State):
    """A state of a contact that slides as a whole.

    Pressure, gap and approach belong to the middle of the stroke, and wear is the sum of both
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
        return np.asarray(self.worn[1])

    @property
    def wear_flat(self) -> Array:
        """Wear depth of the flat, m."""
        return np.asarray(self.worn[0])

    def on(self, workspace: Workspace, geometry: Geometry) -> Self:
        """The same state on more cells; its gap is computed on cells that are new."""
        old = self.geometry
        if geometry.shape == old.shape:
            return self
        moved = super().on(workspace, geometry)
        zeros = np.zeros(geometry.shape)
        more, rows = np.subtract(geometry.shape, old.shape)
        return replace(
            moved,
            reduced=replace(self.reduced, pressure=zeros, gap=zeros + self.reduced.gap[0, 0]),
            pressures=np.pad(self.pressures, ((0, 0), (more, more), (0, rows))),
            convolutions=self.convolutions,
            worn=np.stack([old.resized(field, geometry) for field in self.worn]),
            rates=np.stack([old.resized(field, geometry) for field in self.rates]),
            sunk=np.stack([old.resized(field, geometry) for field in self.sunk]),
        )


def slide(
    problem: WearProblem,
    stops: Sequence[float],
    tolerance: float = TOLERANCE,
    start: StrokeState | None = None,
) -> Iterator[StrokeState]:
    """Integrate the wear of both bodies over the cycles; parameters and errors as for `evolve`."""
    return integrator.march(problem, stops, start, partial(_Slider, tolerance=tolerance))


class _Slider(Integrator[StrokeState]):
    """The steps of a contact that slides as a whole; of two bodies, the flat comes first."""

    def __init__(self, problem: WearProblem, state: StrokeState | None, tolerance: float) -> None:
        super().__init__(problem, state, tolerance)
        # Fraction of the wear that opens the gap: all but the debris.
        self.opens = 1.0 - problem.debris_fraction
        self.shares = np.array(problem.wear_law.shares or (1.0, 0.0))[::-1, None, None]
        if state is not None:
            self._resize(*state.geometry.shape)

    def _resize(self, x: int, y: int) -> None:
        """Use so many cells, and move the state to them."""
        self.rubbing = Rubbing(self.problem, (x, y))
        if self.before is not None:
            self.state = self.state.on(self.workspace, self.rubbing.geometry)

    def _outgrown(self, contacts: Contacts) -> bool:
        """Add cells if the contacts come near the border; return whether they did."""
        touched, (x, y) = contacts.pressures > 0, self.rubbing.geometry.shape
        wider = bool(touched[:, :_MARGIN].any() or touched[:, -_MARGIN:].any())
        higher = y > 1 and bool(touched[:, :, -_MARGIN:].any())
        if wider or higher:
            self._resize(ceil(_GROWTH * x) if wider else x, ceil(_GROWTH * y) if higher else y)
        return wider or higher

    def load(self) -> None:
        """Load the bodies anew."""
        problem, hertz = self.problem, self.problem.hertz
        x, y = (0, 0) if self.before is None else self.before.geometry.shape
        reach = problem.extent[0] + float(positions(problem)[0][-1])
        x = max(x, ceil(reach / problem.spacing[0]) + 2 * _MARGIN)
        y = max(y, ceil(problem.extent[1] / problem.spacing[1]) + 2 * _MARGIN)
        self._resize(x, 1 if problem.geometry.plane_strain else y)
        wide, high = problem.indenter.half_widths(hertz)
        while True:
            rubbing, before = self.rubbing, self.before
            at = rubbing.x[:, None] - rubbing.places[:, None, None]
            inside = (at / wide) ** 2 + (rubbing.y / high) ** 2 < 1.0
            start = inside.astype(np.float64)
            worn, sunk = np.zeros((2, 2, *rubbing.geometry.shape))
            if before is not None:
                start = np.maximum(start, (before.pressures > 0).any(axis=0))
                worn, sunk = before.worn, before.sunk
            rigid, change = np.zeros((2, 1, 1)), inf
            contacts = rubbing.solve(self.opens * worn + sunk, rigid, start)
            # Cells that sink at one position carry less at others, where more sink next time.
            for left in reversed(range(_LARGEST_PASSES)):
                settled = change <= self.tolerance or not contacts.flow.any() or not left
                if self._outgrown(contacts) or settled:
                    break
                sunk, means, start = sunk + contacts.flow, contacts.means, contacts.pressures
                contacts = rubbing.solve(self.opens * worn + sunk, rigid, start)
                change = float(np.abs(contacts.means - means).sum() / means.sum())
            if rubbing is self.rubbing:
                break
        cycle, step = (0.0, 0) if before is None else (before.cycle, before.step)
        growth = self.opens * self.rates(cycle).sum() * hertz.peak_pressure
        depth = hertz.peak_pressure * float(rubbing.influence[0, 0, 0])
        first = _FIRST_STEP * depth / growth if growth > 0 else inf
        state = self._state(cycle, step, contacts, worn, sunk + contacts.flow)
        self.state = replace(state, next_step=first)

    def rates(self, cycle: float, driver: float = 0.0) -> Array:
        """Wear depth of both bodies per mean pressure and cycle, m/Pa, shape (2, 1, 1)."""
        problem = self.problem.at(cycle).driven(driver)
        return np.asarray(
            4.0 * problem.loading.stroke * problem.combined_wear_coefficient * self.shares
        )

    def driver(self, cycle: float, pressures: Array) -> float:
        """The driver of the wear coefficient, from the contacts at all positions."""
        problem = self.problem.at(cycle)
        return problem.wear_law.driver(StrokeMeans(problem, self.rubbing, pressures))

    def attempt(
        self, step: float, end: float, *, output_step: bool
    ) -> integrator.Attempt[StrokeState]:
        """Take both stages, and compare them with the embedded formulas."""
        del output_step
        base = self.state

        def stage(explicit: Array, sunk: Array, rates: Array, start: Array) -> Contacts:
            compliance = self.opens * TR_BDF2.implicit * step * rates
            return self.rubbing.solve(self.opens * explicit + sunk, compliance, start)

        middle, started = base.cycle + TR_BDF2.middle * step, base.rates
        # The driver of the wear coefficient lags by one stage.
        driver = self.driver(base.cycle, base.pressures)
        explicit = base.worn + TR_BDF2.implicit * step * started
        first = stage(explicit, base.sunk, self.rates(middle, driver), base.pressures)
        reached = self.driver(middle, first.pressures)
        between = self.rates(middle, reached) * first.means
        sunk = base.sunk + first.flow
        explicit = base.worn + TR_BDF2.explicit * step * (started + between)
        ahead = max(0.0, reached + TR_BDF2.beyond * (reached - driver))
        rates = self.rates(end, ahead)
        last = stage(explicit, sunk, rates, first.pressures)
        if self._outgrown(last):
            return None
        ended = rates * last.means
        worn, missed = (
            step * sum(w * rate for w, rate in zip(weights, (started, between, ended), strict=True))
            for weights in (TR_BDF2.weights, TR_BDF2.difference)
        )
        worn, allowed = base.worn + worn, integrator.OVERESTIMATE * self.tolerance
        error = float(np.abs(missed).sum() / worn.sum()) / allowed
        state = self._state(end, base.step + 1, last, worn, sunk + last.flow)
        return replace(state, error_estimate=error * self.tolerance), *integrator.assessed(error)

    def _state(
        self, cycle: float, step: int, contacts: Contacts, worn: Array, sunk: Array
    ) -> StrokeState:
        """The state with the contact in the middle of the stroke."""
        problem, geometry = self.problem.at(cycle), self.rubbing.geometry
        bodies = self.workspace.on(geometry)
        opening, plastic = self.opens * worn.sum(axis=0), sunk.sum(axis=0)
        # The middle of the stroke is the first position.
        middle = contacts.pressures[0, geometry.shape[0] :]
        separation = bodies.half_space.displacement(middle) + bodies.unworn + opening + plastic
        free = (middle > 0) & (middle < problem.plastic_limit)
        approach = float(separation[free].mean())
        gap = separation - approach
        residual = np.abs(np.where(free, gap, np.minimum(gap, 0.0))).max() / approach
        slip = problem.loading.stroke / (problem.friction_law.coefficient * problem.coupling)
        zeros = np.zeros(geometry.shape)
        reduced = ReducedContact(zeros, np.full(geometry.shape, slip), approach - slip, load=0.0)
        rates = self.rates(cycle, self.driver(cycle, contacts.pressures))
        return StrokeState(
            cycle=cycle,
            next_step=0.0,
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
            pressure_rate=zeros,
            source_rate=zeros,
            step=step,
            worn=worn,
            rates=rates * contacts.means,
            sunk=sunk,
            pressures=contacts.pressures,
        )


def positions(problem: WearProblem) -> tuple[Array, Array]:
    """Positions of the indenter from the middle of the stroke to its end, m, and their weights.

    They follow from the trapezoidal rule over the stroke, doubled for a position and its image.
    """
    amplitude, half_width = problem.loading.stroke, problem.indenter.half_widths(problem.hertz)[0]
    wave = problem.wavelengths[0] if problem.wavelengths else 0.0
    if amplitude <= problem.small_stroke:
        return np.zeros(1), np.full(1, 0.5)
    of_waves = _PER_WAVE * amplitude / wave if wave else 0.0
    # A peak of pressure at an edge wears at each position.
    of_edge = _PER_EDGE * amplitude / problem.indenter.edge(problem.hertz)
    of_edge = min(of_edge, _MOST_FOR_EDGE) if problem.indenter.is_line else 0.0
    least = max(_LEAST_POSITIONS, of_edge, of_waves)
    count = ceil(max(least, _PER_HALF_WIDTH * amplitude / half_width))
    weights = np.full(count + 1, 0.5 / count)
    weights[[0, -1]] *= 0.5
    return np.linspace(0.0, amplitude, count + 1), weights


class Contacts(NamedTuple):
    """The contacts of a stage at all positions, on 2n by m cells."""

    pressures: Array  # Pa, shape (positions, 2n, m); non-zero exactly where the bodies touch
    means: Array  # means over the stroke at each point of flat and indenter, Pa, shape (2, n, m)
    flow: Array  # depth by which each of them sinks where the pressure is at its limit, m


@dataclass(frozen=True)
class StrokeMeans:
    """Means over the positions of contacts over a stroke, which a wear law may read."""

    problem: WearProblem
    rubbing: Rubbing
    pressures: Array  # Pa, shape (positions, 2n, m)

    @property
    def frequency(self) -> float:
        """Frequency of the motion, Hz."""
        assert self.problem.frequency is not None
        return self.problem.frequency

    @property
    def energy_density(self) -> float:
        """Dissipated energy per cycle and area of contact, J/m²."""
        problem, rubbing = self.problem, self.rubbing
        area = 2.0 * rubbing.area * float(rubbing.weights @ (self.pressures > 0).sum(axis=(1, 2)))
        force = problem.friction_law.coefficient * problem.hertz.load
        return 4.0 * force * problem.loading.stroke / area


class Rubbing:
    """The contacts of a stroke on equal cells.

    Bodies are even along both axes, so wear has a value for each cell of the quarter, of the flat
    and then of the indenter, while a contact off the middle of the stroke needs both sides along x.
    Between cells, the wear of the indenter is interpolated linearly; pressure acts on it by the
    transpose. ``shape`` is the shape of the quarter, with one cell along y in a line contact.
    """

    def __init__(self, problem: WearProblem, shape: tuple[int, int]) -> None:
        from scipy.sparse import csr_matrix

        self.load, self.limit = problem.hertz.load, problem.plastic_limit
        half, self.rows = shape
        count, (size, _) = 2 * half, problem.spacing
        self.places, self.weights = positions(problem)
        modulus = problem.composite_modulus
        # Displacement by the distance along x, and by the rows of both cells.
        if problem.geometry.plane_strain:
            assert isinstance(problem.hertz, LineContact)
            edges, reference = np.arange(half + 1) * size, problem.hertz.reference
            self.geometry: Geometry = Strips(tuple(edges.tolist()), reference)
            self.influence = influence_of_cell(count, size, reference, modulus)[:, None, None]
            self.area, self.y = size, np.zeros(1)
        else:
            self.geometry = Grid(shape, problem.spacing)
            love = influence_coefficients((count, 2 * self.rows), problem.spacing, modulus)
            row = np.arange(self.rows)
            self.influence = love[:, abs(row[:, None] - row)] + love[:, row[:, None] + row + 1]
            self.area, self.y = 2.0 * size * problem.spacing[1], self.geometry.y
        self._transform = np.fft.rfft(
            np.concatenate([self.influence, self.influence[:1], self.influence[:0:-1]]), axis=0
        )
        self.x = (np.arange(count) - half + 0.5) * size
        self.cells, values = count * self.rows, half * self.rows
        # A single roughness belongs to the flat; the second of two moves with the indenter.
        both = problem.roughness, problem.counterface
        if None in both:
            both = problem.rough, None
        # One row for each cell; one column for each value of the flat's wear, then the indenter's.
        self.shapes, self.worn = [], []
        at, across = self.x[:, None], self.y[None, :]
        along, row = np.divmod(np.arange(self.cells), self.rows)
        x = self.x[along]
        of_flat = np.floor(np.abs(x) / size).astype(int) * self.rows + row
        for place in self.places:
            gap: Array = np.broadcast_to(
                problem.indenter.gap(at - place, across), (count, self.rows)
            )
            for surface, moved in zip(both, (at, at - place), strict=True):
                gap = gap if surface is None else gap + surface.height(moved, across)
            self.shapes.append(gap.ravel())
            distance = np.abs(x - place)
            lower, part = np.divmod(distance / size - 0.5, 1.0)
            near, far = (
                values + np.clip(lower.astype(int) + step, 0, half - 1) * self.rows + row
                for step in (0, 1)
            )
            inside = distance < half * size
            shares = np.concatenate([np.ones(x.size), (1.0 - part) * inside, part * inside])
            where = np.tile(np.arange(x.size), 3), np.concatenate([of_flat, near, far])
            self.worn.append(csr_matrix((shares, where), shape=(x.size, 2 * values)))
        self._inverses: dict[int, tuple[Places, Array]] = {}

    def displacement(self, pressure: Array) -> Array:
        """Displacement of all cells, m, under a pressure, Pa."""
        field = pressure.reshape(-1, self.rows)
        waves = np.fft.rfft(field, self.influence.shape[0] * 2, axis=0)
        moved = np.fft.irfft(np.einsum("kij,kj->ki", self._transform, waves), axis=0)
        return np.ravel(moved[: field.shape[0]])

    def _matrix(self, cells: Places, others: Places) -> Array:
        """Displacement of some cells under a unit pressure on others, m/Pa."""
        along, row = np.divmod(cells[:, None], self.rows)
        other_along, other_row = np.divmod(others, self.rows)
        return np.asarray(self.influence[np.abs(along - other_along), row, other_row])

    def _inverse(self, place: int, cells: Places) -> Array:
        """Inverse of the influence of some cells on each other; each position keeps its last."""
        from scipy.linalg.lapack import dpotrf, dpotri

        inverted, inverse = self._inverses.get(place, (cells[:0], np.empty((0, 0))))
        if not np.array_equal(inverted, cells):
            inverse, _ = dpotri(dpotrf(self._matrix(cells, cells), lower=1)[0], lower=1)
            above = np.triu_indices(cells.size, 1)
            inverse[above] = inverse.T[above]
            self._inverses[place] = cells, inverse
        return inverse

    def _capped(self, full: Mask, shape: Array) -> tuple[Places, Places, float]:
        """Cells at the limit and the one between the bounds, if a contact yields all over.

        The cells at the limit carry the load P less the remainder, N, on the one beside them: the
        area P/p_lim that is lowest in a shape, m, under the limit on the cells that were at it.
        """
        carried = self.limit * self.area
        count = ceil(self.load / carried) - 1
        if count >= shape.size:
            raise ContactError("the plastic limit cannot carry the load on the cells of the stroke")
        sunk = self.displacement(np.where(full, self.limit, 0.0))
        order = np.argsort(shape + sunk, kind="stable")
        return np.sort(order[:count]), order[count : count + 1], self.load - count * carried

    def solve(self, opening: Array, compliance: Array, start: Array) -> Contacts:
        """The contacts of all positions; a ContactError if the cells in contact do not settle.

        ``opening`` is the earlier wear and plastic depth of flat and indenter, m, shape (2, n, m),
        and ``compliance`` the wear of either in this stage per mean pressure, m/Pa, shape
        (2, 1, 1), not negative; ``start`` is a first guess of the pressures, Pa, shape
        (positions, 2n, m), of which only the cells in contact and those at the limit matter.

        Both bounds at once from a distant start lead to wrong sets of cells. So if no cell of the
        start is at the limit, the contacts without a limit are solved first.
        """
        from scipy.linalg import cho_factor, cho_solve

        shape_of_cells, shape_of_bodies = start.shape, opening.shape
        compliance = np.broadcast_to(compliance, opening.shape).ravel()
        opening, start = opening.ravel(), start.reshape(len(start), -1)
        closed, capped = start > 0, start >= self.limit
        limit = self.limit if capped.any() else inf
        shapes = [
            shape + worn @ opening for shape, worn in zip(self.shapes, self.worn, strict=True)
        ]
        worn_now, exchange = np.zeros_like(opening), Exchange(_PATIENCE)
        for _ in range(_LARGEST_SWEEPS):
            parts, touched = [], np.zeros(opening.size, np.bool_)
            places = zip(self.weights, shapes, self.worn, closed, capped, strict=True)
            for place, (weight, shape, worn, inside, full) in enumerate(places):
                free, held = np.flatnonzero(inside & ~full), np.flatnonzero(full)
                left = self.load - self.limit * self.area * held.size if held.size else self.load
                if not free.size or left <= 0.0:
                    held, free, left = self._capped(full, shape + worn @ worn_now)
                    full[:], inside[:] = False, False
                    full[held], inside[held], inside[free] = True, True, True
                # Pressure of no load for a unit displacement of each cell, and one of the load.
                inverse = self._inverse(place, free)
                uniform = inverse.sum(axis=1)
                total = uniform.sum()
                inverse = inverse - np.outer(uniform, uniform) / total
                height = shape[free]
                if held.size:
                    height = height + self._matrix(free, held).sum(axis=1) * self.limit
                pressure = np.where(full, self.limit, 0.0)
                pressure[free] = left * (uniform / (total * self.area)) - inverse @ height
                parts.append((weight, worn, free, inverse, worn[free], pressure))
                touched[worn[free].indices] = True
            values = np.flatnonzero(touched)
            root = np.sqrt(compliance[values])
            matrix, right = np.eye(values.size), np.zeros(values.size)
            for weight, worn, _, inverse, worn_free, pressure in parts:
                seen = worn_free[:, values]
                matrix += weight * root[:, None] * (seen.T @ (seen.T @ inverse).T) * root
                right += weight * root * (worn.T @ pressure)[values]
            factors = cho_factor(matrix, lower=True, overwrite_a=True, check_finite=False)
            worn_now = compliance * sum(
                weight * (worn.T @ pressure) for weight, worn, *_, pressure in parts
            )
            worn_now[values] = root * cho_solve(factors, right, check_finite=False)
            pressures, flow = np.zeros(closed.shape), np.zeros(opening.size)
            now_closed, now_capped = closed.copy(), capped.copy()
            for place, (_, worn, free, inverse, worn_free, pressure) in enumerate(parts):
                pressure[free] -= inverse @ (worn_free @ worn_now)
                pressures[place] = pressure
                gap = self.displacement(pressure) + shapes[place] + worn @ worn_now
                approach = gap[free].mean()
                touches = gap < (1.0 - _CLOSED) * approach
                now_closed[place] = np.where(closed[place], pressure > 0, touches)
                full, sunk = capped[place], approach - gap
                held, yields = sunk > -_CLOSED * approach, pressure > (1.0 + _CLOSED) * limit
                now_capped[place] = np.where(full, held, yields)
                if full.any():
                    sinking = worn[np.flatnonzero(full)].tocoo()
                    depth = np.maximum(sunk[full], 0.0)[sinking.row]
                    np.maximum.at(flow, sinking.col, 0.5 * depth * (sinking.data > 0.0))
            settled = np.array_equal(now_closed, closed) and np.array_equal(now_capped, capped)
            if settled and limit > self.limit and (pressures > self.limit).any():
                limit, exchange = self.limit, Exchange(_PATIENCE)
                capped = pressures > limit
                continue
            if settled:
                means = np.sum([weight * (worn.T @ p) for weight, worn, *_, p in parts], axis=0)
                return Contacts(
                    pressures.reshape(shape_of_cells),
                    *(field.reshape(shape_of_bodies) for field in (means, flow)),
                )
            changed = np.flatnonzero((now_closed != closed) | (now_capped != capped))
            changed = exchange.of(changed)
            for sets, now in ((closed, now_closed), (capped, now_capped)):
                sets.flat[changed] = now.flat[changed]
        raise ContactError("the cells in contact over the stroke do not settle")
