"""Coulomb friction as a vector: the shear tractions of a contact in partial slip.

Under the tangential force Q along x, or the displacement U of distant points, the traction q is the
minimum of ½ ∬ q·Kq over |q| ≤ µp with ∬ q = (Q, 0), a convex program. Its multiplier is the
displacement δ of distant points; the slip s = δ − Kq vanishes where |q| < µp and has the direction
of q elsewhere. That is the end of a loading in one step; a cycle between it and its opposite
travels 4 |s|, and the area of the loop of force and displacement is ∬ 4 µp |s| dA.

The solver is Newton's method on sets of cells, within a descent of the energy. Where a cell sticks
both components of q are unknown. Where it slips with traction of the direction d, q = µp d turns
by w along t ⊥ d, and so does the slip, which stays parallel: s·t = |s·d| w/µp. So a step solves

    P (K + |s·d|/µp) P v = P (δ − K q),    P = 1 in stick, t tᵀ in slip,

by conjugate gradients, preconditioned by the inverse symbol. Projected on the discs it never
raises the energy: the step ends at its minimum on the way, and a projected gradient takes the place
of a step that does not descend.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fretwear.arrays import Array, Element, Mask, Places, Single
from fretwear.mechanics.contact.cells import ContactError
from fretwear.mechanics.contact.solver import halved
from fretwear.mechanics.slip.shear import GridShear

_LARGEST_STEPS, _LARGEST_ITERATIONS, _LARGEST_SHIFTS = 60, 40, 60
# Residual to which a start is computed on wider cells.
_COARSE = 1e-3
# Factor by which a Newton step reduces its residual, at first and once the sets of cells settle.
_ROUGHLY, _WELL = 0.2, 0.03
# Cells that change sides, over all in contact, up to which the sets count as settled.
_FEW = 0.01
# Force that a guess may lack, over all that friction bears.
_BALANCED = 1e-12
# A cell whose traction is shorter by less than this part of the bound is at it.
_AT_BOUND = 1e-9
# Part of the tolerance down to which a linear problem is solved.
_ENOUGH = 0.1
# Residual below which changes of the energy are lost in rounding.
_ROUNDED = 1e-6
# Least descent, over the stiffness of a step, that is taken in full; it falls from a half on.
_ENOUGH_DESCENT = 0.6


@dataclass(frozen=True, eq=False)
class Sheared:
    """Tractions and slip at the end of a loading along x; vectors have shape (2, nx, ny)."""

    traction: Array  #: q, Pa
    #: s, m, exactly zero in stick; beside the contact, by how much surfaces pass each other.
    slip: Array
    displacement: float  #: δ of distant points along x, m
    force: float  #: Q of the whole contact, N
    energy: float  #: ½ ∬ q·Kq dA, J
    residual: float  #: largest change of traction by a projected gradient, over the largest bound
    #: Applications of K and of its inverse without padding, in units of the first.
    convolutions: int
    bound: Array  #: µp, Pa, shape (nx, ny)

    @property
    def stick(self) -> Mask:
        """Cells that stick, shape (nx, ny)."""
        return np.asarray((self.bound > 0.0) & (self.slip == 0.0).all(axis=0))

    @property
    def spare(self) -> Array:
        """µp − |q|, Pa, the unused friction; zero where nothing sticks."""
        spare: Array = np.where(self.stick, self.bound - np.hypot(*self.traction), 0.0)
        return np.maximum(spare, 0.0)

    @property
    def ways(self) -> Array:
        """Directions of slip, zero where nothing slips."""
        return np.asarray(self.slip / np.maximum(self.amplitude, np.finfo(float).tiny))

    def on(self, resized: Callable[[Array], Array]) -> Sheared:
        """The same with each field resized to other cells."""

        def moved(fields: Array) -> Array:
            return np.stack([resized(field) for field in fields])

        traction, slip = moved(self.traction), moved(self.slip)
        return replace(self, traction=traction, slip=slip, bound=resized(self.bound))

    @property
    def _way(self) -> NDArray[np.complex128]:
        """The direction, as a complex number, of traction or, where there is none, of slip."""
        x, y = np.where(self.bound > 0.0, self.traction, self.slip)
        length = np.hypot(x, y)
        way = np.where(length > 0.0, x + 1j * y, 1.0) / np.where(length > 0.0, length, 1.0)
        return np.asarray(way, np.complex128)

    def under(self, bound: Array) -> Array:
        """A guess of the traction of a similar contact, Pa, by its µp, Pa: as much is unused."""
        ways = self._way * (bound - np.minimum(self.spare, bound))
        return np.stack([ways.real, ways.imag])

    @property
    def amplitude(self) -> Array:
        """|s|, m."""
        return np.asarray(np.hypot(*self.slip))


def shear(
    bodies: GridShear[Array],
    bound: Array,
    force: float | None = None,
    displacement: float = 0.0,
    flexibility: float = 0.0,
    start: Array | None = None,
    tolerance: float = 1e-6,
    offset: Array | None = None,
) -> Sheared:
    """Solve for the tractions under a force or a displacement.

    Parameters
    ----------
    bodies
        The elastic bodies.
    bound
        µp, Pa, shape (nx, ny), not negative.
    force, displacement, flexibility
        Q, N, less than ∬ µp; or else U = δ + F Q, m, and the flexibility F in series, m/N.
    start
        A first guess of the traction, Pa, shape (2, nx, ny).
    tolerance
        Largest residual, see `Sheared`.
    offset
        What is added to δ − Kq, m, shape (2, nx, ny). An increment of loading from the traction q₀,
        during which pressure drags the surfaces by d, has K q₀ − d, and slip and δ of its own.

    Raises
    ------
    ContactError
        If the force slides the contact as a whole, or the residual stays above the tolerance.
    """
    if force is not None and not force < bodies.geometry.integral(bound):
        raise ContactError(f"a tangential force of {force:.4g} N slides the contact as a whole")
    spent = 0
    coarser = bodies.coarser if start is None and offset is None else None
    if coarser is not None:
        means = halved(bound)
        coarse = shear(coarser, means, force, displacement, flexibility, None, _COARSE)
        parts = np.divide(coarse.traction, means, out=0.0 * coarse.traction, where=means > 0.0)
        start, spent = parts.repeat(2, axis=1).repeat(2, axis=2) * bound, coarse.convolutions // 4
    method = _Descent(bodies, bound, force, displacement, flexibility, start, offset)
    result = method.solve(tolerance)
    return replace(result, convolutions=result.convolutions + spent)


class _Descent:
    """The current traction within the bounds that carries the force, and its displacement.

    Tractions are in units of the largest bound, displacements in units of what it moves its own
    cell by, and fields have shape (2, n) for the n cells that touch.
    """

    def __init__(
        self,
        bodies: GridShear[Array],
        bound: Array,
        force: float | None,
        displacement: float,
        flexibility: float,
        start: Array | None,
        offset: Array | None,
    ) -> None:
        self.bodies, self.largest = bodies, float(bound.max())
        self.moves = self.largest * bodies.self_influence
        self.cells: Places = np.flatnonzero(bound)
        self.shape, self.bound = bound.shape, bound.ravel()[self.cells] / self.largest
        self.area = bodies.geometry.unit_area
        self.total = None if force is None else force / (self.area * self.largest)
        self.given = displacement / self.moves
        self.series = flexibility * self.area / bodies.self_influence
        # Forces along axes in which q is even must balance; elsewhere they do by symmetry.
        self.balances_y = force is not None and not bodies.is_even
        self.single, self.spent = bodies.single, 0.0
        # The first step from a guess corrects its force, and leaves cells that slip at the bound.
        self.guessed = start is not None
        if start is None:
            self.traction = self.projected(np.zeros((2, self.cells.size)))
        else:
            self.traction = self.clipped(self.at_cells(start) / self.largest)[0]
        missing = 0.0 if self.total is None else self.total - self.traction[0].sum()
        self.balanced = abs(missing) <= _BALANCED * self.bound.sum()
        self.moved = self.displaced(self.traction)  # on all cells, shape (2, nx, ny)
        self.offset = np.zeros((2, 1, 1)) if offset is None else offset / self.moves
        self.moved -= self.offset

    def at_cells(self, field: NDArray[Element]) -> NDArray[Element]:
        """A field of the window, shape (2, nx, ny), on the cells that touch."""
        return np.asarray(field.reshape(2, -1)[:, self.cells])

    def everywhere(self, field: Array) -> Array:
        """A field of the cells that touch on the window, zero elsewhere."""
        result = np.zeros((2, self.shape[0] * self.shape[1]))
        result[:, self.cells] = field
        return result.reshape(2, *self.shape)

    def displaced(self, traction: Array) -> Array:
        self.spent += 1.0
        return self.bodies.displacement(self.everywhere(traction / self.bodies.self_influence))

    def clipped(self, traction: Array) -> tuple[Array, Array]:
        """The nearest traction within the discs, and µp/|q| of each cell beyond, else 1."""
        length = np.sqrt(traction[0] ** 2 + traction[1] ** 2)
        factor = self.bound / np.maximum(length, self.bound)
        return traction * factor, factor

    def projected(self, traction: Array) -> Array:
        """The nearest traction within the discs that carries the force, if one is given.

        It belongs to the traction shifted evenly, by Newton's method for the shift.
        """
        result, factor = self.clipped(traction)
        if self.total is None:
            return result
        shift, axes = np.zeros(2), [0, 1] if self.balances_y else [0]
        total = np.array([self.total, 0.0])[axes]
        low, high = -np.inf, np.inf
        for _ in range(_LARGEST_SHIFTS):
            missing = total - result[axes].sum(axis=1)
            if np.abs(missing).max() <= 1e-13 * max(abs(self.total), 1.0):
                break
            # Within the disc a cell follows the shift; beyond it, traction turns.
            moved = traction + shift[:, None]
            length = np.maximum(np.sqrt((moved**2).sum(axis=0)), np.finfo(float).tiny)
            ways = (moved / length * (factor < 1.0))[axes]
            slope = np.diag(np.full(len(axes), float(factor.sum()))) - (factor * ways) @ ways.T
            if missing[0] > 0.0:
                low = shift[0]
            else:
                high = shift[0]
            slope += 1e-12 * self.cells.size * np.eye(len(axes))
            shift[axes] += np.clip(np.linalg.solve(slope, missing), -4.0, 4.0)
            if not self.balances_y and not low < shift[0] < high:
                shift[0] = 0.5 * (low + high)
            result, factor = self.clipped(traction + shift[:, None])
        return result

    def rigid(self, moved: Array) -> Array:
        """Displacement of distant points along x and y, from how far cells that stick have moved.

        Cells count by their spare friction, as cells that slip may be hardly below the bound.
        """
        if self.total is None:
            return np.array([self.given - self.series * self.traction[0].sum(), 0.0])
        spare = np.maximum(self.bound - np.hypot(*self.traction), 0.0)
        spare = spare if spare.any() else self.bound
        x, y = (spare * moved).sum(axis=1) / spare.sum()
        return np.array([x, y * self.balances_y])

    def solve(self, tolerance: float) -> Sheared:
        """Iterate until the residual is below the tolerance."""
        length, stuck = 1.0, np.zeros(self.cells.size, dtype=np.bool_)
        for _ in range(_LARGEST_STEPS):
            moved = self.at_cells(self.moved)
            at_bound = np.hypot(*self.traction) >= (1.0 - _AT_BOUND) * self.bound
            far = self.rigid(moved)
            slip = far[:, None] - moved
            tried, factor = self.clipped(self.traction + slip)
            error = float(np.abs(tried - self.traction).max())
            # A guess may be in equilibrium with another force.
            if error <= tolerance and (self.balanced or not self.guessed):
                return self._result(far, factor < 1.0, error)
            # A cell at the bound that slips against its traction sticks again.
            slips = at_bound & ((slip * self.traction).sum(axis=0) > 0.0)
            settled = self.guessed or np.count_nonzero(stuck == slips) <= _FEW * self.cells.size
            stuck = ~slips
            target = self._newton(slip, slips, _WELL if settled else _ROUGHLY, _ENOUGH * tolerance)
            trusted, self.guessed = self.guessed or error < _ROUNDED, False
            if not self._search(self.projected(target), slip, trusted=trusted):
                # Barzilai and Borwein's step of a projected gradient.
                before = self.traction
                self._search(self.projected(self.traction + length * slip), slip)
                change, by = self.traction - before, self.at_cells(self.moved) - moved
                work, square = float((change * by).sum()), float((change**2).sum())
                length = square / work if work > 0.0 else 1.0
        raise ContactError(
            f"the shear tractions did not converge: residual {error:.1e} instead of {tolerance:.0e}"
        )

    def _search(self, target: Array, slip: Array, *, trusted: bool = False) -> bool:
        """Move to a traction, or to the least energy on the way; False if it leads uphill.

        A trusted step is taken in full: it changes the energy by less than rounding does.
        """
        step = target - self.traction
        # The force is the same, so that displacements of distant points do no work.
        descent = float((step * slip).sum())
        if not (descent > 0.0 or trusted):
            return False
        moved = self.displaced(step)
        stiffness = float((step * self.at_cells(moved)).sum())
        if self.total is None:
            stiffness += self.series * float(step[0].sum()) ** 2
        # Beyond half the way to the least energy on the line it still falls; in full, cells stay at
        # the bound.
        part = 1.0 if trusted or descent > _ENOUGH_DESCENT * stiffness else descent / stiffness
        self.traction = target if part == 1.0 else self.traction + part * step
        self.moved += part * moved
        return True

    def _newton(self, slip: Array, slips: Mask, reduction: float, enough: float) -> Array:
        """The traction of the linear problem of the current sets of cells, in single precision.

        Its unknowns are both components of cells that stick, and the turn w of those that slip.
        """
        cells, count = self.cells, self.shape[0] * self.shape[1]
        stuck, slipping = np.flatnonzero(~slips), np.flatnonzero(slips)
        way = self.traction[:, slipping] / self.bound[slipping]
        turn = np.stack([-way[1], way[0]]).astype(np.float32)
        of_stuck = np.concatenate([cells[stuck], cells[stuck] + count])
        of_slipping, ends = cells[slipping] + [[0], [count]], of_stuck.size
        layer = ((slip[:, slipping] * way).sum(axis=0) / self.bound[slipping]).astype(np.float32)
        weight = np.ones(ends + slipping.size, np.float32)
        weight[ends:] /= np.sqrt(1.0 + layer)
        on_window = np.zeros((2, *self.shape), np.float32)

        def spread(unknowns: Single) -> Single:
            """The traction of some unknowns on the window."""
            flat = on_window.reshape(-1)
            flat[of_stuck] = unknowns[:ends]
            flat[of_slipping] = turn * unknowns[ends:]
            return on_window

        def within(stuck: NDArray[Element], slipping: NDArray[Element]) -> Single:
            """Components of a field by unknowns, from its values in cells that stick and slip."""
            result = np.empty_like(weight)
            result[:ends], result[ends:] = stuck, turn[0] * slipping[0] + turn[1] * slipping[1]
            return result

        def gathered(field: Single) -> Single:
            flat = field.reshape(-1)
            return within(flat[of_stuck], flat[of_slipping])

        def condition(unknowns: Single) -> Single:
            self.spent += 0.25
            return weight * gathered(self.single.inverse(spread(weight * unknowns)))

        def stiffened(unknowns: Single) -> Single:
            self.spent += 1.0
            result = gathered(self.single.displacement(spread(unknowns)))
            result[ends:] += layer * unknowns[ends:]
            if self.total is None and self.series:
                result += np.float32(self.series * float(unknowns @ ones[0])) * ones[0]
            return result

        def compressed(field: Array) -> Single:
            return within(field[:, stuck].ravel(), field[:, slipping])

        axes = [0, 1] if self.balances_y else [0]
        ones = [compressed(np.eye(2)[axis][:, None] * np.ones(cells.size)) for axis in axes]
        held = _Held([] if self.total is None else ones, condition)
        change, ahead = np.zeros_like(weight), compressed(slip)
        if held.fields and self.guessed:
            missing = np.array([self.total, 0.0]) - self.traction.sum(axis=1)
            change = held.of_products(missing[: len(held.fields)])
            ahead -= stiffened(change)
        change = change + _solve(ahead, stiffened, condition, held, reduction, enough)
        target = self.traction.copy()
        target[:, stuck] += change[:ends].reshape(2, -1)
        target[:, slipping] += turn * change[ends:]
        return target

    def _result(self, far: Array, slips: Mask, error: float) -> Sheared:
        traction = self.everywhere(self.traction * self.largest)
        slip = (far[:, None, None] - self.moved) * self.moves
        slip.reshape(2, -1)[:, self.cells[~slips]] = 0.0
        moved = (self.moved + self.offset) * self.moves
        return Sheared(
            traction,
            slip,
            float(far[0]) * self.moves,
            float(self.traction[0].sum()) * self.largest * self.area,
            0.5 * sum(map(self.bodies.geometry.integral, traction * moved)),
            error,
            round(self.spent),
            self.everywhere(self.bound * self.largest)[0],
        )


class _Held:
    """Fields whose products with a step must vanish for the force to stay."""

    def __init__(self, fields: list[Single], condition: Callable[[Single], Single]) -> None:
        self.fields = fields
        self._conditioned = [condition(field) for field in fields]
        products = [[float(a @ b) for b in self._conditioned] for a in fields]
        self._gram = np.array(products)

    def of_products(self, values: Array) -> Single:
        """A smooth field of given products with them."""
        parts = np.linalg.solve(self._gram, values).astype(np.float32)
        return np.asarray(sum(part * z for part, z in zip(parts, self._conditioned, strict=True)))

    def free(self, residual: Single) -> Single:
        """The residual without the parts that distant points take up."""
        if not self.fields:
            return residual
        products = [float(z @ residual) for z in self._conditioned]
        parts = np.linalg.solve(self._gram, products).astype(np.float32)
        for part, one in zip(parts, self.fields, strict=True):
            residual = residual - part * one
        return residual


def _solve(
    residual: Single,
    operator: Callable[[Single], Single],
    condition: Callable[[Single], Single],
    held: _Held,
    reduction: float,
    enough: float,
) -> Single:
    """Conjugate gradients, projected so that products of the solution with held fields vanish."""
    left = held.free(residual)
    result = np.zeros_like(left)
    target = max(reduction**2 * float(left @ left), enough**2 * left.size)
    direction, energy = np.zeros_like(left), 1.0
    for _ in range(_LARGEST_ITERATIONS):
        if float(left @ left) <= target:
            break
        preconditioned = condition(left)
        previous, energy = energy, float(left @ preconditioned)
        if not energy > 0.0:
            break
        direction *= np.float32(energy / previous)
        direction += preconditioned
        force = operator(direction)
        length = np.float32(energy / float(direction @ force))
        result += length * direction
        force *= length
        left -= force
        left = held.free(left)
    return result
