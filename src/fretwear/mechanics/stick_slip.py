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
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretwear.arrays import Array, Mask
from fretwear.mechanics.contact import ContactError
from fretwear.mechanics.shear import ShearSpace

_LARGEST_STEPS, _LARGEST_ITERATIONS, _LARGEST_SHIFTS = 60, 40, 60
# A start is computed on cells twice as wide from so many cells along an axis on, to a residual.
_LEAST_COARSENED, _COARSE = 64, 1e-3
# Factor by which a Newton step reduces its residual, at first and once the sets of cells settle.
_ROUGHLY, _WELL = 0.2, 0.03
# Cells that change sides, over all in contact, up to which the sets count as settled.
_FEW = 0.01
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
    convolutions: (
        int  #: applications of K and of its inverse without padding, in units of the first
    )

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

    def on(self, resized: Callable[[NDArray[Any]], NDArray[Any]]) -> Sheared:
        """The same with each field resized to other cells."""
        traction, slip = (
            np.stack([resized(field) for field in fields]) for fields in (self.traction, self.slip)
        )
        return replace(self, traction=traction, slip=slip, bound=resized(self.bound))

    def under(self, bound: Array) -> Array:
        """A guess of the traction of a similar contact, Pa, by its µp, Pa.

        Wear beside a stick zone leaves p* as it is, and so the unused friction µp*.
        """
        length = np.hypot(*self.traction)
        ways = np.stack([np.ones_like(length), np.zeros_like(length)])
        np.divide(self.traction, length, out=ways, where=length > 0.0)
        return np.asarray(ways * np.maximum(bound - self.spare, 0.0))

    @property
    def amplitude(self) -> Array:
        """|s|, m."""
        return np.asarray(np.hypot(*self.slip))


def shear(
    bodies: ShearSpace,
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
    spent, shape = 0, bound.shape
    if (
        start is None
        and offset is None
        and min(shape) >= _LEAST_COARSENED
        and not any(n % 4 for n in shape)
    ):
        means = bound.reshape(shape[0] // 2, 2, shape[1] // 2, 2).mean(axis=(1, 3))
        coarse = shear(bodies.coarser, means, force, displacement, flexibility, None, _COARSE)
        parts = np.divide(coarse.traction, means, out=0.0 * coarse.traction, where=means > 0.0)
        start, spent = parts.repeat(2, axis=1).repeat(2, axis=2) * bound, coarse.convolutions // 4
    method = _Descent(bodies, bound, force, displacement, flexibility, start, offset)
    result = method.solve(tolerance)
    return replace(result, convolutions=result.convolutions + spent)


class _Descent:
    """The current traction within the bounds that carries the force, and its displacement."""

    def __init__(
        self,
        bodies: ShearSpace,
        bound: Array,
        force: float | None,
        displacement: float,
        flexibility: float,
        start: Array | None,
        offset: Array | None,
    ) -> None:
        self.bodies, self.bound = bodies, bound
        self.offset = 0.0 if offset is None else offset
        self.touching: Mask = bound > 0.0
        self.area = bodies.geometry.unit_area
        self.total = None if force is None else force / self.area
        self.given, self.series = displacement, flexibility * self.area
        # Forces along axes in which q is even must balance; elsewhere they do by symmetry.
        self.balances_y = force is not None and not any(bodies.geometry.even)
        self.unit = 1.0 / bodies.self_influence
        self.inverse, self.spent = bodies.inverse(), 0.0
        # The first step from a guess corrects its force, and leaves cells that slip at the bound.
        self.guessed = start is not None
        none = np.zeros((2, *bound.shape))
        self.traction = self.projected(none) if start is None else self.clipped(start)[0]
        self.moved = self.displaced(self.traction) - self.offset

    def displaced(self, traction: Array) -> Array:
        self.spent += 1.0
        return self.bodies.displacement(traction)

    def clipped(self, traction: Array) -> tuple[Array, Array]:
        """The nearest traction within the discs, and µp/|q| of each cell beyond, else 1."""
        length = np.sqrt(traction[0] ** 2 + traction[1] ** 2)
        with np.errstate(divide="ignore", invalid="ignore"):
            factor = np.where(length > self.bound, self.bound / length, 1.0)
        return traction * factor, factor

    def projected(self, traction: Array) -> Array:
        """The nearest traction within the discs that carries the force, if one is given.

        It belongs to the traction shifted evenly, by Newton's method for the shift.
        """
        result, factor = self.clipped(traction)
        if self.total is None:
            return result
        scale, shift = self.bound.max(), np.zeros(2)
        axes = [0, 1] if self.balances_y else [0]
        wanted = np.array([self.total, 0.0])[axes]
        low, high = -np.inf, np.inf
        for _ in range(_LARGEST_SHIFTS):
            missing = wanted - result[axes].sum(axis=(1, 2))
            if np.abs(missing).max() <= 1e-13 * max(abs(self.total), scale):
                break
            # Within the disc a cell follows the shift; beyond it turns.
            moved = traction + shift[:, None, None]
            length = np.maximum(np.sqrt((moved**2).sum(axis=0)), np.finfo(float).tiny)
            ways = moved / length * (factor < 1.0)
            slope = np.diag(np.full(len(axes), float((self.touching * factor).sum())))
            slope -= np.einsum("imn,jmn,mn->ij", ways[axes], ways[axes], factor)
            if missing[0] > 0.0:
                low = shift[0]
            else:
                high = shift[0]
            slope += 1e-12 * self.touching.sum() * np.eye(len(axes))
            step = np.linalg.solve(slope, missing)
            shift[axes] += np.clip(step, -4.0 * scale, 4.0 * scale)
            if not self.balances_y and not low < shift[0] < high:
                shift[0] = 0.5 * (low + high)
            result, factor = self.clipped(traction + shift[:, None, None])
        return result

    def _at_bound(self) -> Mask:
        """Cells whose traction is as large as friction allows."""
        length = np.sqrt(self.traction[0] ** 2 + self.traction[1] ** 2)
        return np.asarray(self.touching & (length >= (1.0 - _AT_BOUND) * self.bound))

    def rigid(self, at_bound: Mask) -> Array:
        """Displacement of distant points along x and y, m, from the cells below the bound."""
        if self.total is None:
            return np.array([self.given - self.series * self.traction[0].sum(), 0.0])
        inside = self.touching & ~at_bound
        if not inside.any():
            inside = self.touching
        x, y = (field[inside].mean() for field in self.moved)
        return np.array([x, y * self.balances_y])

    def solve(self, tolerance: float) -> Sheared:
        """Iterate until the residual is below the tolerance."""
        largest, length = float(self.bound.max()), self.unit
        sticks_before = np.zeros_like(self.touching)
        for _ in range(_LARGEST_STEPS):
            at_bound = self._at_bound()
            far = self.rigid(at_bound)
            passed = far[:, None, None] - self.moved
            slip = passed * self.touching
            tried, factor = self.clipped(self.traction + self.unit * slip)
            error = float(np.abs(tried - self.traction).max()) / largest
            # A guess may be in equilibrium with another force.
            if error <= tolerance and not self.guessed:
                return self._result(passed, factor < 1.0, float(far[0]), error)
            # A cell at the bound that slips against its traction sticks again.
            slips = at_bound & ((slip * self.traction).sum(axis=0) > 0.0)
            changed = np.count_nonzero((self.touching & ~slips) != sticks_before)
            settled = self.guessed or changed <= _FEW * np.count_nonzero(self.touching)
            sticks_before = self.touching & ~slips
            enough = _ENOUGH * tolerance * largest / self.unit
            target = self._newton(slip, slips, _WELL if settled else _ROUGHLY, enough)
            trusted, self.guessed = self.guessed or error < _ROUNDED, False
            if not self._search(self.projected(target), slip, trusted=trusted):
                # Barzilai and Borwein's step of a projected gradient.
                before, moved = self.traction, self.moved
                self._search(self.projected(self.traction + length * slip), slip)
                change, by = self.traction - before, self.moved - moved
                work = float((change * by).sum())
                length = float((change**2).sum()) / work if work > 0.0 else self.unit
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
        stiffness = float((step * moved).sum())
        if self.total is None:
            stiffness += self.series * float(step[0].sum()) ** 2
        # Beyond half the way to the least energy on the line it still falls; in full, cells stay at
        # the bound.
        part = 1.0 if trusted or descent > _ENOUGH_DESCENT * stiffness else descent / stiffness
        self.traction = target if part == 1.0 else self.traction + part * step
        self.moved = self.moved + part * moved
        return True

    def _newton(self, slip: Array, slips: Mask, reduction: float, enough: float) -> Array:
        """The traction of the linear problem of the current sets of cells."""
        sticks, bound = self.touching & ~slips, np.where(slips, self.bound, 1.0)
        way = np.where(slips, self.traction / bound, 0.0)
        turn = np.stack([-way[1], way[0]])  # t, zero where nothing slips
        layer = (slip * way).sum(axis=0) / bound
        weight, inside = 1.0 / np.sqrt(1.0 + layer * self.unit), sticks.astype(np.float64)

        def within(field: Array) -> Array:
            """P v."""
            turned = turn[0] * field[0]
            turned += turn[1] * field[1]
            result = inside * field
            result += turn * turned
            return np.asarray(result)

        def condition(field: Array) -> Array:
            self.spent += 0.25
            return within(weight * self.inverse(weight * field))

        def stiffened(field: Array) -> Array:
            result = self.displaced(field)
            if self.total is None and self.series:
                result[0] += self.series * field[0].sum()
            return within(result + layer * field)

        held = _Held([within(field) for field in self._ones()], condition)
        change, ahead = np.zeros_like(slip), slip
        if held.fields and self.guessed:
            missing = [self.total, 0.0] - self.traction.sum(axis=(1, 2))
            change = held.of_products(missing[: len(held.fields)])
            ahead = slip - self.displaced(change)
        change += _solve(within(ahead), stiffened, condition, held, reduction, enough)
        return self.traction + change

    def _ones(self) -> list[Array]:
        """Even fields along the axes along which the force is given."""
        axes = [] if self.total is None else [0, 1] if self.balances_y else [0]
        ones = np.zeros((len(axes), *self.traction.shape))
        for axis in axes:
            ones[axis, axis] = 1.0
        return [*ones]

    def _result(self, slip: Array, slips: Mask, far: float, error: float) -> Sheared:
        sticks = self.touching & ~slips
        energy = 0.5 * float((self.traction * (self.moved + self.offset)).sum()) * self.area
        force = float(self.traction[0].sum()) * self.area
        return Sheared(
            self.traction,
            np.where(sticks, 0.0, slip),
            far,
            force,
            energy,
            error,
            round(self.spent),
            self.bound,
        )


class _Held:
    """Fields whose products with a step must vanish for the force to stay."""

    def __init__(self, fields: list[Array], condition: Callable[[Array], Array]) -> None:
        self.fields = fields
        self._conditioned = [condition(field) for field in fields]
        products = [[float((a * b).sum()) for b in self._conditioned] for a in fields]
        self._gram = np.array(products)

    def of_products(self, values: Array) -> Array:
        """A smooth field of given products with them."""
        parts = np.linalg.solve(self._gram, values)
        return np.asarray(sum(part * z for part, z in zip(parts, self._conditioned, strict=True)))

    def free(self, residual: Array) -> Array:
        """The residual without the parts that distant points take up."""
        if not self.fields:
            return residual
        products = [float(np.vdot(z, residual)) for z in self._conditioned]
        for part, one in zip(np.linalg.solve(self._gram, products), self.fields, strict=True):
            residual = residual - part * one
        return residual


def _solve(
    residual: Array,
    operator: Callable[[Array], Array],
    condition: Callable[[Array], Array],
    held: _Held,
    reduction: float,
    enough: float,
) -> Array:
    """Conjugate gradients, projected so that products of the solution with held fields vanish."""
    left = held.free(residual)
    result = np.zeros_like(left)
    target = max(reduction**2 * float(np.vdot(left, left)), enough**2 * left.size)
    direction, energy = np.zeros_like(left), 1.0
    for _ in range(_LARGEST_ITERATIONS):
        if np.vdot(left, left) <= target:
            break
        preconditioned = condition(left)
        previous, energy = energy, float(np.vdot(left, preconditioned))
        if not energy > 0.0:
            break
        direction *= energy / previous
        direction += preconditioned
        force = operator(direction)
        length = energy / float(np.vdot(direction, force))
        result += length * direction
        force *= length
        left -= force
        left = held.free(left)
    return result
