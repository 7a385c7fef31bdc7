"""The contacts of two bodies in gross sliding, at several positions over a stroke at once.

The indenter is at several positions, of the weights ω. The pressures p of an implicit stage of
`fretwear.mechanics.wear.stroke` at all positions minimise

    Σ ω [½ (p, K p) + (h, p)] + ½ c₁ ∫⟨p⟩₁² + ½ c₂ ∫⟨p⟩₂²   under   p ≥ 0,  ∫p = P at each position,

where ⟨p⟩ are the means of flat and indenter. Positions share their wear, which couples the
pressures symmetrically and adds to a sum of positive definite forms, so a stage is one strictly
convex problem. For given sets of cells in contact, the pressures are eliminated position by
position. That leaves a positive definite system for the wear, and cells change sides until each has
a pressure or a gap. Cells at the plastic limit keep it; the remaining penetration is flow, half of
it in each body: the largest over all positions.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, floor, inf
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from fretwear.arrays import Array, Mask, Places
from fretwear.mechanics.contact.cells import Geometry
from fretwear.mechanics.contact.gradients import Exchange, descend
from fretwear.mechanics.contact.grid import Grid, influence_coefficients
from fretwear.mechanics.contact.problem import ContactError, projected
from fretwear.mechanics.contact.strips import Row, Strips, influence_of_cell
from fretwear.mechanics.wear.state import WearProblem
from fretwear.theory import LineContact
from fretwear.units import LINE_CONTACT, POINT_CONTACT

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

# Positions over half a stroke: the least number, and the numbers per half-width of the contact, per
# rounded edge of a line contact and per wave.
_LEAST_POSITIONS, _PER_HALF_WIDTH, _PER_EDGE, _PER_WAVE = 4, 2.0, 4.0, 6.0
_MOST_FOR_EDGE = {POINT_CONTACT: 0, LINE_CONTACT: 24}
# Contacts end at other places of the indenter at each position: so many per cell and half a stroke.
_ENDS_PER_CELL, _MOST_FOR_ENDS = 3.0, {POINT_CONTACT: 0, LINE_CONTACT: 36}
# Points per cell on the path between two positions.
_PER_CELL = 2.0
_LARGEST_SWEEPS = 200
# Sweeps without a new minimum of wrong cells, after which only one of them changes sides.
_PATIENCE = 10
# Cells touch where the gap is below this part of the approach.
_CLOSED = 1e-10


def positions(problem: WearProblem) -> tuple[Array, Array]:
    """Positions of the indenter from the middle of a stroke to its end, m, and their weights.

    The weights follow the trapezoidal rule over the stroke, doubled for a position and its image.
    If possible, positions are a whole number of cells apart. Under a load that changes with the
    position they begin at the other end, and leave out positions without contact.
    """
    amplitude, half_width = problem.loading.travel, problem.indenter.half_widths(problem.hertz)[0]
    wave = problem.wavelengths[0] if problem.wavelengths else 0.0
    if amplitude <= problem.small_stroke and not problem.wears_unevenly:
        return np.zeros(1), np.full(1, 0.5)
    of_waves = _PER_WAVE * amplitude / wave if wave else 0.0
    # A pressure peak at an edge wears at each position.
    of_edge = _PER_EDGE * amplitude / problem.indenter.edge(problem.hertz)
    cells = amplitude / problem.spacing[0]
    of_ends = min(_ENDS_PER_CELL * cells, _MOST_FOR_ENDS[problem.frame])
    least = max(_LEAST_POSITIONS, min(of_edge, _MOST_FOR_EDGE[problem.frame]), of_waves, of_ends)
    count = max(least, _PER_HALF_WIDTH * amplitude / half_width)
    if count <= cells * (1.0 + 1e-9):
        # Contacts on the same cells of the indenter share a matrix.
        step = floor(cells / count * (1.0 + 1e-9)) * problem.spacing[0]
        places = np.append(np.arange(0.0, amplitude - 0.25 * step, step), amplitude)
    else:
        places = np.linspace(0.0, amplitude, ceil(count) + 1)
    steps = np.diff(places, prepend=0.0, append=amplitude)
    weights = 0.25 * (steps[:-1] + steps[1:]) / amplitude
    if problem.wears_unevenly:
        places = np.concatenate([-places[:0:-1], places])
        weights = np.concatenate([weights[:0:-1], 2.0 * weights[:1], weights[1:]])
        first = 0 if problem.load_at(-1.0) > 0.0 else 1
        return places[first:], weights[first:]
    return places, weights


def _paths(places: Array, size: float, is_even: bool) -> list[tuple[Array, Array]]:
    """Paths over which the pressures of each position move with the indenter, m, and shares.

    Between positions, the pressures on the indenter are interpolated linearly, so each acts on the
    flat over the path to the neighbouring positions.
    """
    if places.size == 1:
        return [(np.zeros(1), np.ones(1))]
    paths, ends = [], (-places[1:2] if is_even else places[:1], places[-1:])
    lowers, uppers = np.append(ends[0], places[:-1]), np.append(places[1:], ends[1])
    for lower, place, upper in zip(lowers, places, uppers, strict=True):
        count = max(ceil(_PER_CELL * max(upper - place, place - lower) / size), 1)
        part = (np.arange(count) + 0.5) / count
        ways = np.concatenate([part * (lower - place), part * (upper - place)])
        shares = np.concatenate([(1.0 - part) * (place - lower), (1.0 - part) * (upper - place)])
        paths.append((ways, shares / shares.sum()))
    return paths


class Contacts(NamedTuple):
    """The contacts of a stage at all positions, on 2n by m cells."""

    pressures: Array  # Pa, shape (positions, nx, m); non-zero exactly where the bodies touch
    means: Array  # means over the stroke at each point of flat and indenter, Pa, shape (2, n, m)
    flow: Array  # depth by which each of these points sinks at the pressure limit, m


class BetweenBounds(NamedTuple):
    """Some cells at a position."""

    cells: Places
    inverse: Array  # their pressure by displacement, without load, Pa/m
    uniform: Array  # their pressure for a unit displacement of all of them, Pa/m
    worn: csr_matrix  # their fraction of the wear at each value of flat and indenter


class Response(NamedTuple):
    """The contact at a position on given cells, as a function of the wear of the stage."""

    patch: BetweenBounds  # cells between the bounds
    pressure: Array  # pressure of all cells if nothing wears, Pa


class Rubbing:
    """The contacts of a stroke on equal cells.

    Bodies are even along both axes, so wear has a value for each cell of the quarter, of the flat
    and then of the indenter. A contact off the middle of the stroke needs both sides along x; so
    does the wear under a load that changes over the stroke. Between cells, the wear of the indenter
    is interpolated linearly; pressure acts on it by the transpose. The wear of a body has the
    ``shape``, with one cell along y in a line contact.
    """

    def __init__(self, problem: WearProblem, shape: tuple[int, int]) -> None:
        #: Largest pressure, Pa, for the present friction.
        self.limit = problem.slip_limit
        is_even, _ = problem.even
        # Number of sides of the middle of the stroke with positions.
        self.sides = 1.0 if is_even else 2.0
        along_x, self.rows = shape
        half = along_x if is_even else along_x // 2
        count, (size, _) = 2 * half, problem.spacing
        self.places, self.weights = positions(problem)
        reach = problem.loading.travel
        self.loads = [problem.load_at(place / reach if reach else 0.0) for place in self.places]
        modulus, film = problem.composite_modulus, problem.film
        # Displacement by the distance along x and the rows of both cells.
        if problem.geometry.plane_strain:
            assert isinstance(problem.hertz, LineContact)
            edges, reference = np.arange(half + 1) * size, problem.hertz.reference
            self.geometry: Geometry = Strips(tuple(edges.tolist()), reference)
            if not is_even:
                self.geometry = Row(shape, problem.spacing, (False, True), reference)
            self.influence = influence_of_cell(count, size, reference, modulus, film)[:, None, None]
            self.area, self.y = size, np.zeros(1)
        else:
            self.geometry = Grid(shape, problem.spacing, problem.even)
            shape = count, 2 * self.rows
            love = influence_coefficients(shape, problem.spacing, modulus, film=film)
            row = np.arange(self.rows)
            self.influence = love[:, abs(row[:, None] - row)] + love[:, row[:, None] + row + 1]
            self.area, self.y = 2.0 * size * problem.spacing[1], self.geometry.y
        #: Displacement of a cell under a pressure on it alone, m/Pa.
        self.self_influence = float(self.influence[0, 0, 0])
        self._transform = np.fft.rfft(
            np.concatenate([self.influence, self.influence[:1], self.influence[:0:-1]]), axis=0
        )
        self.x = (np.arange(count) - half + 0.5) * size
        self.cells, values = count * self.rows, along_x * self.rows
        # A single roughness belongs to the flat; the second of two moves with the indenter.
        both = problem.roughness, problem.counterface
        if None in both:
            both = problem.rough, None
        from scipy.sparse import csr_matrix, hstack, vstack  # takes half a second

        # One row for each position and cell; one column for each value of the wear of the flat,
        # then of the indenter.
        shapes, worn = [], []
        position, across = self.x[:, None], self.y[None, :]
        column, row = np.divmod(np.arange(self.cells), self.rows)
        x = np.asarray(self.x[column], np.float64)

        def places_of(x: Array) -> Array:
            """Distances from the first edge of the wear of a body, in cells."""
            return np.abs(x) / size if is_even else x / size + half

        def interpolated(x: Array) -> csr_matrix:
            """Linear interpolation of the wear of a body at places, m; zero beyond its cells."""
            lower, part = np.divmod(places_of(x) - 0.5, 1.0)
            columns = [
                np.clip(lower.astype(int) + step, 0, along_x - 1) * self.rows + row
                for step in (0, 1)
            ]
            in_range = np.abs(x) < half * size
            shares = np.concatenate([(1.0 - part) * in_range, part * in_range])
            where = np.tile(np.arange(x.size), 2), np.concatenate(columns)
            return csr_matrix((shares, where), shape=(x.size, values))

        for place, paths in zip(self.places, _paths(self.places, size, is_even), strict=True):
            gap: Array = np.broadcast_to(
                problem.indenter.gap(position - place, across), (count, self.rows)
            )
            for surface, moved in zip(both, (position, position - place), strict=True):
                gap = gap if surface is None else gap + surface.height(moved, across)
            shapes.append(gap.ravel())
            of_flat = sum(
                share * interpolated(x + path) for path, share in zip(*paths, strict=True)
            )
            worn.append(hstack([of_flat, interpolated(x - place)], format="csr"))
        #: Gap of the unworn bodies at each position and cell, m, and the gap that wear adds.
        self.shapes, self.worn = np.stack(shapes), vstack(worn, format="csr")
        self._of_bodies = self.worn.T
        self._patches: dict[int, BetweenBounds] = {}

    def half_widths(self, pressures: Array) -> tuple[float, float]:
        """Half-widths along x and y, m, mean over the positions; infinite along y in line contact.

        The pressure of the outermost cell continues the fall from the cell before to zero.
        """
        wide, high, size = 0.0, 0.0, self.x[1] - self.x[0]
        for weight, pressure in zip(self.weights / self.sides, pressures, strict=True):
            extent = _outermost(pressure[:, 0]) + _outermost(pressure[::-1, 0]) + 1 - self.x.size
            wide += weight * size * extent
            if self.rows > 1:
                middle = pressure[int(np.argmax(pressure[:, 0]))]
                high += weight * 2.0 * (self.y[1] - self.y[0]) * (_outermost(middle) + 0.5)
        return float(wide), float(high) if self.rows > 1 else inf

    def displacement(self, pressure: Array) -> Array:
        """Displacement of all cells, m, under a pressure, Pa; cells are the last axis."""
        field = pressure.reshape(*pressure.shape[:-1], -1, self.rows)
        waves = np.fft.rfft(field, self.influence.shape[0] * 2, axis=-2)
        moved = np.fft.irfft(np.einsum("kij,...kj->...ki", self._transform, waves), axis=-2)
        return np.asarray(moved[..., : field.shape[-2], :].reshape(pressure.shape))

    def _matrix(self, cells: Places, others: Places) -> Array:
        """Displacement of some cells under a unit pressure on others, m/Pa."""
        column, row = np.divmod(cells[:, None], self.rows)
        other_along, other_row = np.divmod(others, self.rows)
        return np.asarray(self.influence[np.abs(column - other_along), row, other_row])

    def _patch(self, place: int, cells: Places) -> BetweenBounds:
        """Some cells at a position; the last ones of each position are kept.

        The influence matrix of the cells is the same at other places along x.
        """
        from scipy.linalg.lapack import dpotrf, dpotri

        kept = self._patches.get(place)
        if kept is not None and np.array_equal(kept.cells, cells):
            return kept
        moved = cells - cells[0] // self.rows * self.rows
        same = (
            patch
            for patch in self._patches.values()
            if patch.cells.size == cells.size
            and np.array_equal(patch.cells - patch.cells[0] // self.rows * self.rows, moved)
        )
        if alike := next(same, None):
            _, inverse, uniform, _ = alike
        else:
            inverse, _ = dpotri(dpotrf(self._matrix(cells, cells), lower=1)[0], lower=1)
            upper = np.triu_indices(cells.size, 1)
            inverse[upper] = inverse.T[upper]
            uniform = inverse.sum(axis=1)
            inverse -= np.outer(uniform, uniform / uniform.sum())
        self._patches[place] = BetweenBounds(
            cells, inverse, uniform, self.worn[place * self.cells + cells]
        )
        return self._patches[place]

    def _capped(self, full: Mask, shape: Array, load: float) -> tuple[Places, Places, float]:
        """Cells at the limit and the one between the bounds, if a contact yields as a whole.

        The cells at the limit carry the load, N, less a remainder on the cell beside them. They lie
        where a shape, m, is lowest under the limit on the cells that were at it before.
        """
        carried = self.limit * self.area
        count = ceil(load / carried) - 1
        if count >= shape.size:
            raise ContactError("the plastic limit cannot carry the load on the cells of the stroke")
        sunk = self.displacement(np.where(full, self.limit, 0.0))
        order = np.argsort(shape + sunk, kind="stable")
        return np.sort(order[:count]), order[count : count + 1], load - count * carried

    def solve(self, opening: Array, compliance: Array, start: Array) -> Contacts:
        """The contacts of all positions; by projected gradients if their cells do not settle.

        ``opening`` is the earlier wear and plastic depth of flat and indenter, m, shape (2, n, m),
        and ``compliance`` the wear of either in this stage per mean pressure, m/Pa, shape (2, 1,
        1), not negative. ``start`` is a first guess of the pressures, Pa, shape (positions, nx, m);
        only its sets of cells in contact and at the limit matter.

        From a distant start both bounds at once lead to wrong sets of cells. So if no cell of the
        start is at the limit, the contacts without a limit are solved first.
        """
        shape_of_cells, shape_of_bodies = start.shape, opening.shape
        compliance = np.broadcast_to(compliance, opening.shape).ravel()
        opening, start = opening.ravel(), start.reshape(len(start), -1)
        closed, capped = start > 0, start >= self.limit
        limit = self.limit if capped.any() else inf
        shapes = self.shapes + self._gaps(opening)
        worn, exchange = np.zeros_like(opening), Exchange(_PATIENCE)
        for _ in range(_LARGEST_SWEEPS):
            responses = [
                self._response(place, shapes[place], worn, closed[place], capped[place])
                for place in range(len(shapes))
            ]
            worn = self._worn(responses, compliance)
            pressures, now_closed, now_capped, flow = self._sides(
                responses, shapes, worn, closed, capped, limit
            )
            settled = np.array_equal(now_closed, closed) and np.array_equal(now_capped, capped)
            if settled and limit > self.limit and (pressures > self.limit).any():
                limit, exchange = self.limit, Exchange(_PATIENCE)
                capped = pressures > limit
                continue
            if settled:
                means = self._mean(pressures)
                return Contacts(
                    pressures.reshape(shape_of_cells),
                    *(field.reshape(shape_of_bodies) for field in (means, flow)),
                )
            changed = np.flatnonzero((now_closed != closed) | (now_capped != capped))
            changed = exchange.of(changed)
            for sets, now in ((closed, now_closed), (capped, now_capped)):
                sets.flat[changed] = now.flat[changed]
        stage = _Stage(self, shapes, compliance)
        contact = descend(stage, stage, start, _CLOSED)
        flow = np.zeros_like(worn)
        self._sink(flow, contact.saturated, -contact.gap)
        return Contacts(
            contact.pressure.reshape(shape_of_cells),
            self._mean(contact.pressure).reshape(shape_of_bodies),
            flow.reshape(shape_of_bodies),
        )

    def _response(
        self, place: int, shape: Array, worn: Array, touching: Mask, full: Mask
    ) -> Response:
        """The contact at a position on given cells, of which some are at the limit.

        If these carry the whole load, the sets of cells are chosen anew, in place.
        """
        free, held = np.flatnonzero(touching & ~full), np.flatnonzero(full)
        load = self.loads[place]
        left = load - self.limit * self.area * held.size if held.size else load
        if not free.size or left <= 0.0:
            held, free, left = self._capped(full, shape + self._gaps(worn)[place], load)
            full[:], touching[:] = False, False
            full[held], touching[held], touching[free] = True, True, True
        patch = self._patch(place, free)
        height = shape[free]
        if held.size:
            height = height + self._matrix(free, held).sum(axis=1) * self.limit
        pressure = np.where(full, self.limit, 0.0)
        pressure[free] = left / (patch.uniform.sum() * self.area) * patch.uniform
        pressure[free] -= patch.inverse @ height
        return Response(patch, pressure)

    def _gaps(self, worn: Array) -> Array:
        """Gap that the wear of flat and indenter adds at each position and cell, m."""
        return np.asarray((self.worn @ worn).reshape(self.shapes.shape))

    def means_of_flat(self, pressures: Array, shape: tuple[int, ...]) -> Array:
        """Means over the stroke at the points of the flat, Pa, of a shape."""
        return np.asarray(self._mean(pressures.reshape(len(pressures), -1)).reshape(shape)[0])

    def _mean(self, pressures: Array) -> Array:
        """Means over the stroke at each value of flat and indenter, Pa."""
        return np.asarray(self._of_bodies @ (self.weights[:, None] * pressures).ravel())

    def _worn(self, responses: Sequence[Response], compliance: Array) -> Array:
        """Wear of the stage at each value of flat and indenter, m, consistent with the contacts."""
        from scipy.linalg import cho_factor, cho_solve
        from scipy.sparse import csc_matrix

        touched = np.zeros(compliance.size, np.bool_)
        for response in responses:
            touched[response.patch.worn.indices] = True
        values = np.flatnonzero(touched)
        root = np.sqrt(compliance[values])
        unworn, number = (
            self._mean(np.stack([r.pressure for r in responses])),
            np.cumsum(touched) - 1,
        )
        matrix = np.zeros((values.size, values.size))
        for weight, (patch, _) in zip(self.weights, responses, strict=True):
            indices, pointers = number[patch.worn.indices], patch.worn.indptr
            seen = csc_matrix((patch.worn.data, indices, pointers), (values.size, patch.cells.size))
            matrix += seen @ (seen @ (weight * patch.inverse)).T
        matrix *= np.outer(root, root)
        matrix[np.diag_indices(values.size)] += 1.0
        factors = cho_factor(matrix, lower=True, overwrite_a=True, check_finite=False)
        worn = compliance * unworn
        worn[values] = root * cho_solve(factors, root * unworn[values], check_finite=False)
        return np.asarray(worn)

    def _sides(
        self,
        responses: Sequence[Response],
        shapes: Array,
        worn: Array,
        closed: Mask,
        capped: Mask,
        limit: float,
    ) -> tuple[Array, Mask, Mask, Array]:
        """Pressures, Pa, under the wear of a stage, m, and the sets of cells that they imply.

        These cells touch or are at the limit. The last result is the flow of `Contacts`.
        """
        pressures, flow = (
            np.stack([response.pressure for response in responses]),
            np.zeros_like(worn),
        )
        for pressure, (patch, _) in zip(pressures, responses, strict=True):
            pressure[patch.cells] -= patch.inverse @ (patch.worn @ worn)
        gaps = self.displacement(pressures) + shapes + self._gaps(worn)
        free = [gap[patch.cells].mean() for gap, (patch, _) in zip(gaps, responses, strict=True)]
        approach = np.array(free)[:, None]
        now_closed = np.where(closed, pressures > 0, gaps < (1.0 - _CLOSED) * approach)
        sunk, yields = approach - gaps, pressures > (1.0 + _CLOSED) * limit
        now_capped = np.where(capped, sunk > -_CLOSED * approach, yields)
        if capped.any():
            self._sink(flow, capped, sunk)
        return pressures, now_closed, now_capped, flow

    def _sink(self, flow: Array, full: Mask, sunk: Array) -> None:
        """Raise the flow of both bodies to half the depth that cells at the limit have sunk, m."""
        sinking = self.worn[np.flatnonzero(full)].tocoo()
        depth = np.maximum(sunk[full], 0.0)[sinking.row]
        np.maximum.at(flow, sinking.col, 0.5 * depth * (sinking.data > 0.0))


class _Stage:
    """The contacts of a stage as one problem, with the bodies that they wear.

    Fields have shape (positions, cells), and ``compliance`` is as in `Rubbing.solve`.
    """

    layer, approach = None, None

    def __init__(self, rubbing: Rubbing, shape: Array, compliance: Array) -> None:
        self._rubbing, self.shape, self._compliance = rubbing, shape, compliance
        self.limit, self.self_influence = rubbing.limit, rubbing.self_influence

    def displacement(self, pressure: Array) -> Array:
        """Displacement and wear of all positions, m."""
        rubbing = self._rubbing
        wear = self._compliance * rubbing._mean(pressure)
        return rubbing.displacement(pressure) + rubbing._gaps(wear)

    def weighted(self, values: Array) -> Array:
        """A field times the weights of the positions."""
        return np.asarray(self._rubbing.weights[:, None] * values)

    def projected(self, pressure: Array, compliance: Array) -> tuple[Array, Array | float]:
        """The nearest pressure within the bounds that carries each load, and the approaches, m."""
        totals = np.array(self._rubbing.loads) / self._rubbing.area
        each = [
            projected(p, self.limit, float(total), c)
            for p, c, total in zip(pressure, compliance, totals, strict=True)
        ]
        return np.stack([result for result, _ in each]), np.array([[shift] for _, shift in each])


def _outermost(pressure: Array) -> float:
    """Position in cells, from the first one, at which the pressure falls to zero."""
    last = int(np.flatnonzero(pressure)[-1])
    falls = float(pressure[last - 1] - pressure[last]) if last else 0.0
    return last + (min(float(pressure[last]) / falls, 1.0) if falls > 0.0 else 1.0)
