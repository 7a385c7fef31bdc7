"""The contacts of a stroke, one for each position of the indenter, which share the wear.

The pressures of a stage are a minimum of

    Σ ω [½ (p, K p) + (h, p)] + ½ c₁ ∫⟨p⟩₁² + ½ c₂ ∫⟨p⟩₂²   under   p ≥ 0,  ∫p = P at each position:

wear that positions share couples them symmetrically and adds to a sum of positive definite forms,
so a stage is one strictly convex problem. It is solved as one: on given sets of cells in contact,
the pressures are eliminated position by position, which leaves a positive definite system for the
wear alone, and cells change sides until each has pressure or a gap. Cells at the plastic limit bear
it, and what still penetrates there is flow, half of it of each body: the most over all positions.
"""

from __future__ import annotations

from math import ceil
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fretwear.mechanics.contact import ContactError
from fretwear.mechanics.geometry import Array, Mask
from fretwear.mechanics.geometry.grid import Grid, influence_coefficients
from fretwear.mechanics.geometry.line import Line, influence_of_cell
from fretwear.mechanics.loading import SMALL_STROKE
from fretwear.mechanics.roughness import BothRough
from fretwear.mechanics.state import WearProblem
from fretwear.theory import LineContact

LEAST_POSITIONS = 8
MARGIN = 6
_POSITIONS_PER_HALF_WIDTH = 2.0
_POSITIONS_PER_WAVE = 6.0
_LARGEST_SWEEPS = 60
# More cells than this part of those in contact make a new inverse, or a displacement so far off.
_FEW = 0.25
_DIGITS = 1e-10
# Cells touch where the gap is below this part of the approach.
_CLOSED = 1e-10


def positions(problem: WearProblem) -> tuple[Array, Array]:
    """Positions of the indenter from the middle of the stroke to its end, m, and their weights.

    They are those of the trapezoidal rule over the stroke, doubled for a position and its image.
    """
    amplitude, half_width = problem.loading.stroke, problem.indenter.half_widths(problem.hertz)[0]
    wave = problem.wavelengths[0] if problem.wavelengths else 0.0
    if amplitude <= SMALL_STROKE * half_width:
        return np.zeros(1), np.full(1, 0.5)
    wanted = max(LEAST_POSITIONS / 2, _POSITIONS_PER_HALF_WIDTH * amplitude / half_width)
    if wave:
        wanted = max(wanted, _POSITIONS_PER_WAVE * amplitude / wave)
    count = ceil(wanted)
    weights = np.full(count + 1, 0.5 / count)
    weights[[0, -1]] *= 0.5
    return np.linspace(0.0, amplitude, count + 1), weights


def _unworn(problem: WearProblem, x: Any, y: Array, place: float) -> Array:
    """Gap at zero load and zero approach, m, with the indenter at a place along x.

    A single roughness is that of the flat; of two, the other moves with the indenter.
    """
    at, moved, across = x[:, None], (x - place)[:, None], y[None, :]
    gap = np.broadcast_to(problem.indenter.gap(moved, across), (x.size, y.size))
    rough = problem.roughness
    if isinstance(rough, BothRough):
        return gap + rough.first.height(at, across) + rough.second.height(moved, across)
    return gap if rough is None else gap + rough.height(at, across)


class Contacts(NamedTuple):
    """The contacts of a stage at all positions."""

    pressures: Array  # Pa, shape (positions, cells); not zero just where the bodies touch
    means: Array  # over the stroke, of each value of the flat and the indenter, Pa, (values,)
    flow: Array  # how far each of them sinks where the pressure is at the limit, m


class Rubbing:
    """The contacts of a stroke on equal cells.

    Bodies are even along both axes, so wear has a value for each cell of the quarter, of the flat
    and then of the indenter, while a contact off the middle of the stroke needs both sides along x.
    Between cells, the wear of the indenter is linear; what it takes from the pressure is the
    transpose of that. ``shape`` is that of the quarter, with one cell along y in a line contact.
    """

    def __init__(self, problem: WearProblem, shape: tuple[int, int]) -> None:
        from scipy.sparse import csr_matrix

        self.load, self.limit = problem.hertz.load, problem.limit
        half, self.rows = shape
        count, (size, _) = 2 * half, problem.spacing
        self.places, self.weights = positions(problem)
        modulus = problem.bodies.composite_modulus
        # Displacement by the distance along x, and the row of either cell.
        if problem.geometry is Line:
            assert isinstance(problem.hertz, LineContact)
            edges, reference = np.arange(half + 1) * size, problem.hertz.reference
            self.geometry: Any = Line(tuple(edges.tolist()), reference)
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
        self.shapes = [_unworn(problem, self.x, self.y, place).ravel() for place in self.places]
        # One row a cell, one column a value of the flat's wear, then of the indenter's.
        self.worn = []
        along, row = np.divmod(np.arange(self.cells), self.rows)
        x = self.x[along]
        of_flat = np.floor(np.abs(x) / size).astype(int) * self.rows + row
        for place in self.places:
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
        self.inverses: dict[int, tuple[NDArray[np.intp], Array]] = {}

    def displacement(self, pressure: Array) -> Array:
        """Of all cells, m, under a pressure, Pa."""
        field = pressure.reshape(-1, self.rows)
        waves = np.fft.rfft(field, self.influence.shape[0] * 2, axis=0)
        moved = np.fft.irfft(np.einsum("kij,kj->ki", self._transform, waves), axis=0)
        result: Array = moved[: field.shape[0]].ravel()
        return result

    def _matrix(self, cells: NDArray[np.intp], others: NDArray[np.intp]) -> Array:
        """Displacement of some cells under a unit pressure on others, m/Pa."""
        (along, row), (other_along, other_row) = (
            np.divmod(each, self.rows) for each in (cells[:, None], others)
        )
        found: Array = self.influence[np.abs(along - other_along), row, other_row]
        return found

    def _inverse(self, place: int, cells: NDArray[np.intp]) -> Array:
        """The inverse of the influence of some cells on each other at a position.

        Few cells change sets between solutions, so the last inverse is corrected by an update of
        low rank, as long as its accuracy suffices.
        """
        known, inverse = self.inverses.get(place, (cells[:0], np.zeros((0, 0))))
        stays = np.isin(known, cells)
        kept, gone = np.flatnonzero(stays), np.flatnonzero(~stays)
        new = np.setdiff1d(cells, known[kept], assume_unique=True)
        missed = np.inf
        if gone.size + new.size <= _FEW * cells.size:
            lost, within = inverse[np.ix_(kept, gone)], inverse[np.ix_(gone, gone)]
            inverse = inverse[np.ix_(kept, kept)] - lost @ np.linalg.solve(within, lost.T)
            across = self._matrix(known[kept], new)
            moved = inverse @ across
            own = np.linalg.inv(self._matrix(new, new) - across.T @ moved)
            corner = moved @ own
            whole = np.block([[inverse + corner @ moved.T, -corner], [-corner.T, own]])
            order = np.argsort(np.concatenate([known[kept], new]))
            inverse = whole[np.ix_(order, order)]
            sinking = np.zeros(self.cells)
            sinking[cells] = inverse.sum(axis=1)
            missed = np.abs(self.displacement(sinking)[cells] - 1.0).max()
        if missed > _DIGITS:
            inverse = np.asarray(np.linalg.inv(self._matrix(cells, cells)), dtype=np.float64)
        self.inverses[place] = cells, inverse
        return inverse

    def solve(self, opening: Array, compliance: Array, closed: Mask) -> Contacts:
        """The contacts of all positions.

        Parameters
        ----------
        opening
            Earlier wear and plastic depth of flat and indenter, m, shape (values,).
        compliance
            Wear of this stage per mean pressure, m/Pa, shape (values,); not negative.
        closed
            First guess of the cells in contact, shape (positions, cells).

        Raises
        ------
        ContactError
            If the set of cells in contact does not settle.
        """
        from scipy.linalg import cho_factor, cho_solve

        capped = np.zeros_like(closed)
        shapes = [
            shape + worn @ opening for shape, worn in zip(self.shapes, self.worn, strict=True)
        ]
        for _ in range(_LARGEST_SWEEPS):
            parts, touched = [], np.zeros(opening.size, np.bool_)
            places = zip(self.weights, shapes, self.worn, closed, capped, strict=True)
            for place, (weight, shape, worn, inside, full) in enumerate(places):
                free, held = np.flatnonzero(inside & ~full), np.flatnonzero(full)
                left = self.load - self.limit * self.area * held.size if held.size else self.load
                if not free.size or left <= 0.0:
                    raise ContactError("the contact is at the plastic limit all over")
                # Pressure of no load for a unit displacement of each cell, and that of the load.
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
            for weight, worn, _, inverse, own, pressure in parts:
                seen = own[:, values]
                matrix += weight * root[:, None] * (seen.T @ (seen.T @ inverse).T) * root
                right += weight * root * (worn.T @ pressure)[values]
            factors = cho_factor(matrix, lower=True, overwrite_a=True, check_finite=False)
            worn_now = compliance * sum(
                weight * (worn.T @ pressure) for weight, worn, *_, pressure in parts
            )
            worn_now[values] = root * cho_solve(factors, right, check_finite=False)
            pressures, flow = np.zeros(closed.shape), np.zeros(opening.size)
            now_closed, now_capped = closed.copy(), capped.copy()
            for place, (_, worn, free, inverse, own, pressure) in enumerate(parts):
                pressure[free] -= inverse @ (own @ worn_now)
                pressures[place] = pressure
                gap = self.displacement(pressure) + shapes[place] + worn @ worn_now
                approach = gap[free].mean()
                touches = gap < (1.0 - _CLOSED) * approach
                now_closed[place] = np.where(closed[place], pressure > 0, touches)
                full, sunk = capped[place], approach - gap
                now_capped[place] = np.where(full, sunk > 0.0, pressure > self.limit)
                if full.any():
                    sinking = worn[np.flatnonzero(full)].tocoo()
                    depth = sunk[full][sinking.row]
                    np.maximum.at(flow, sinking.col, 0.5 * depth * (sinking.data > 0.0))
            if np.array_equal(now_closed, closed) and np.array_equal(now_capped, capped):
                means = np.sum([weight * (worn.T @ p) for weight, worn, *_, p in parts], axis=0)
                return Contacts(pressures, means, flow)
            closed, capped = now_closed, now_capped
        raise ContactError("the cells in contact over the stroke do not settle")

    def reaches_border(self, pressures: Array) -> tuple[bool, bool]:
        """Whether a contact comes near an end of the cells along x, and along y."""
        field = (pressures > 0).reshape(len(pressures), -1, self.rows)
        ends = field[:, :MARGIN].any() or field[:, -MARGIN:].any()
        return bool(ends), self.rows > 1 and bool(field[:, :, -MARGIN:].any())
