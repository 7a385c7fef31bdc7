"""Coulomb friction as a vector: the shear tractions of a contact in partial slip.

Under the tangential force Q along x, or the displacement U of distant points, the traction q
minimises ½ ∬ q·Kq over |q| ≤ µp with ∬ q = (Q, 0), a convex program. The multiplier of the
constraint is the displacement δ of distant points. The slip s = δ − Kq vanishes where |q| < µp and
has the direction of q elsewhere. This is the end of a loading in one step; a cycle between it and
its opposite travels 4 |s|, and the loop of force and displacement has the area ∬ 4 µp |s| dA.

The solver is a semi-smooth Newton method on q = P(q + s), where P projects on the discs with the
force, and its even shift is δ. With z = q + s, cells slip where |z| > µp, in the direction d of z.
Where a cell sticks, both components of q are unknown. Where it slips, q becomes µp d and turns by w
along t ⊥ d; the slip turns with it to stay parallel: s·t = |s| w/µp. So a step v solves

    T (K + |s|/µp) T v = T (s − K (µp d − q)),    T = 1 in stick, t tᵀ in slip,

by conjugate gradients, preconditioned by the inverse symbol. The step is projected on the discs
and taken if it halves the residual. Otherwise accelerated projected gradients follow, which
converge from any start: Beck and Teboulle, SIAM J. Imaging Sci. 2 (2009), restarted as by
O'Donoghue and Candès, Found. Comput. Math. 15 (2015).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fretwear.arrays import Array, Element, Mask, Places, Single
from fretwear.mechanics.contact.problem import BALANCED, ContactError, find_shift
from fretwear.mechanics.contact.solver import halved
from fretwear.mechanics.slip.shear import GridShear

# Iterations of conjugate gradients, and of all projected gradients.
_LARGEST_ITERATIONS, _LARGEST_GRADIENTS = 40, 20000
# Projected gradients in a row at first, and the residual of a start above which they come first.
_GRADIENTS, _FAR = 5, 0.05
# Residual to which a start is computed on wider cells.
_COARSE = 1e-3
# Factors by which a linear problem is solved: proportional to the residual, within bounds.
_IN_PROPORTION, _WELL, _ROUGHLY = 4.0, 0.03, 0.3
# Part of the tolerance that suffices there, and part of the residual that is neglected.
_ENOUGH, _NEGLIGIBLE = 0.4, 1e-3


@dataclass(frozen=True, eq=False)
class Sheared:
    """Tractions and slip at the end of a loading along x; vectors have shape (2, nx, ny)."""

    traction: Array  #: q, Pa
    #: s, m, exactly zero in stick; outside the contact, relative displacement of the surfaces.
    slip: Array
    displacement: float  #: δ of distant points along x, m
    force: float  #: Q of the whole contact, N
    energy: float  #: ½ ∬ q·Kq dA, J
    residual: float  #: largest change of a projected gradient step over the largest bound
    #: Applications of K, and of its inverse without padding in units of the former.
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
        """A first guess of the traction, Pa, under another bound µp, Pa: same unused friction."""
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
    method = _Descent(bodies, bound, force, displacement, flexibility, offset)
    result = method.solve(start, tolerance)
    return replace(result, convolutions=result.convolutions + spent)


class _State(NamedTuple):
    """A traction q and the projection of its gradient step; fields as in `_Descent`."""

    traction: Array
    moved: Array  # K q less the offset, on all cells, shape (2, nx, ny)
    far: Array  # displacement of distant points along x and y
    pushed: Array  # z = q + s
    error: float  # largest change of traction by that step


class _Descent:
    """Steps of a traction within the bounds.

    Tractions are in units of the largest bound, displacements in units of what that bound on one
    cell moves this cell by, and fields have shape (2, n) for the n cells that touch. A flexibility
    in series adds to K, so that either the force or the displacement of its end is given.
    """

    def __init__(
        self,
        bodies: GridShear[Array],
        bound: Array,
        force: float | None,
        displacement: float,
        flexibility: float,
        offset: Array | None,
    ) -> None:
        self.bodies, self.largest = bodies, float(bound.max())
        self.moves = self.largest * bodies.self_influence
        self.cells: Places = np.flatnonzero(bound)
        self.shape, self.bound = bound.shape, bound.ravel()[self.cells] / self.largest
        self.area = bodies.geometry.unit_area
        self.given = np.array([displacement / self.moves, 0.0])
        self.series = flexibility * self.area / bodies.self_influence if force is None else 0.0
        # Forces balance by symmetry, except along axes in which q is even.
        self.axes = 0 if force is None else 1 if bodies.is_even else 2
        self.total = np.zeros(2) if force is None else np.array([force, 0.0])
        self.total /= self.area * self.largest
        self.single, self.spent, self.gradients, self.stiffest = bodies.single, 0.0, 0, 1.0
        self.offset = np.zeros((2, 1, 1)) if offset is None else offset / self.moves

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
        moved = self.bodies.displacement(self.everywhere(traction / self.bodies.self_influence))
        moved[0] += self.series * float(traction[0].sum())
        return moved

    def projected(self, traction: Array, shift: Array) -> tuple[Array, Array]:
        """The nearest traction within the discs that carries the force, and an even shift.

        It is the projection of a shifted traction, see `find_shift`: the force along x grows with
        the shift along x; the force along y grows with the shift along y while the force along x is
        kept. Without a given force the shift is kept.
        """
        shift, enough, result = shift.copy(), BALANCED * float(self.bound.sum()), traction

        def clip() -> tuple[Array, Array]:
            nonlocal result
            moved = traction + shift[:, None]
            length = np.sqrt(moved[0] ** 2 + moved[1] ** 2)
            factor = self.bound / np.maximum(length, self.bound)
            result = moved * factor
            # Within its disc the traction of a cell follows the shift; on the edge it turns.
            return factor, np.where(factor < 1.0, moved / np.maximum(length, self.bound), 0.0)

        def lacking(value: float, axis: int) -> tuple[float, float]:
            """Missing force along an axis at a shift, and its fall per shift."""
            shift[axis] = value
            if axis:
                find_shift(lambda trial: lacking(trial, 0), shift[0], enough)
            factor, way = clip()
            x, slope = ((factor * (1.0 - way[place] ** 2)).sum() for place in (0, axis))
            if axis:
                slope -= (factor * way[0] * way[1]).sum() ** 2 / max(x, enough)
            return float(self.total[axis] - result[axis].sum()), float(slope)

        if self.axes:
            find_shift(lambda value: lacking(value, self.axes - 1), shift[self.axes - 1], enough)
        else:
            clip()
        return result, shift

    def at(self, traction: Array, moved: Array, far: Array) -> _State:
        """The state of a traction, from a guess of the displacement of distant points."""
        pushed = traction - self.at_cells(moved)
        projected, far = self.projected(pushed, far)
        error = float(np.abs(projected - traction).max())
        return _State(traction, moved, far, pushed + far[:, None], error)

    def solve(self, start: Array | None, tolerance: float) -> Sheared:
        """Iterate until the residual is below the tolerance.

        Whenever a Newton step does not halve the residual, projected gradients take its place,
        twice as many each time, so that it ends.
        """
        if start is None:
            traction = self.projected(np.zeros((2, self.cells.size)), self.given)[0]
        else:
            traction = self.at_cells(start) / self.largest
            traction *= self.bound / np.maximum(np.hypot(*traction), self.bound)
        # The guess may balance another force.
        lacks = np.abs(self.total - traction.sum(axis=1))[: self.axes]
        guessed = bool((lacks > 10.0 * BALANCED * self.bound.sum()).any())
        state = self.at(traction, self.displaced(traction) - self.offset, self.given)
        count, is_far = _GRADIENTS, state.error > _FAR and not guessed
        while guessed or state.error > tolerance:
            if self.gradients > _LARGEST_GRADIENTS:
                reached = f"residual {state.error:.1e} instead of {tolerance:.0e}"
                raise ContactError(f"the shear tractions did not converge: {reached}")
            following = None if is_far else self._newton(state, tolerance)
            if following is None or not (guessed or following.error <= 0.5 * state.error):
                following = self._descend(state, count, tolerance)
                count *= 2
            state, guessed, is_far = following, False, False
        return self._result(state)

    def _newton(self, state: _State, tolerance: float) -> _State:
        """The state after a step. The first step from a guess corrects its force."""
        target = self.projected(state.traction + self._step(state, tolerance), 0.0 * state.far)[0]
        moved = state.moved + self.displaced(target - state.traction)
        return self.at(target, moved, state.far)

    def _descend(self, state: _State, count: int, tolerance: float) -> _State:
        """The state after some accelerated projected gradients."""
        traction, moved = ahead, ahead_moved = state.traction, state.moved
        momentum, far = 1.0, state.far / self.stiffest
        for _ in range(count):
            while True:
                pushed = ahead - self.at_cells(ahead_moved) / self.stiffest
                target, far = self.projected(pushed, far)
                step = target - ahead
                displacement = self.displaced(step)
                self.gradients += 1
                square = float((step**2).sum())
                work = float((step * self.at_cells(displacement)).sum())
                if work <= self.stiffest * square:
                    break
                far *= self.stiffest * square / (1.1 * work)
                self.stiffest = 1.1 * work / square
            next_moved, change = ahead_moved + displacement, target - traction
            previous = 1.0 if float((step * change).sum()) < 0.0 else momentum
            momentum = 0.5 + np.sqrt(0.25 + previous**2)
            part = (previous - 1.0) / momentum
            ahead, ahead_moved = target + part * change, next_moved + part * (next_moved - moved)
            traction, moved = target, next_moved
            if self.stiffest * float(np.abs(step).max()) <= _ENOUGH * tolerance:
                break
        return self.at(traction, moved, self.stiffest * far)

    def _step(self, state: _State, tolerance: float) -> Array:
        """A Newton step, in single precision.

        Its unknowns are both components where cells stick, and the turn w where they slip.
        """
        cells, count = self.cells, self.shape[0] * self.shape[1]
        slip = state.pushed - state.traction
        length = np.hypot(*state.pushed)
        slips = length > self.bound
        stuck, slipping = np.flatnonzero(~slips), np.flatnonzero(slips)
        way = state.pushed[:, slipping] / length[slipping]
        turn = np.stack([-way[1], way[0]]).astype(np.float32)
        of_stuck = np.concatenate([cells[stuck], cells[stuck] + count])
        of_slipping, ends = cells[slipping] + [[0], [count]], of_stuck.size
        layer = np.zeros(ends + slipping.size, np.float32)
        layer[ends:] = length[slipping] / self.bound[slipping] - 1.0
        weight, on_window = 1.0 / np.sqrt(1.0 + layer), np.zeros((2, *self.shape), np.float32)

        def spread(unknowns: Single) -> Single:
            """The traction of some unknowns on the window."""
            flat = on_window.reshape(-1)
            flat[of_stuck], flat[of_slipping] = unknowns[:ends], turn * unknowns[ends:]
            return on_window

        def gathered(field: NDArray[Element]) -> Single:
            """Components by unknowns of a field on the window."""
            flat = field.reshape(-1)
            of_turn = (turn * flat[of_slipping]).sum(axis=0)
            return np.concatenate([flat[of_stuck], of_turn]).astype(np.float32)

        pulled = gathered(np.stack([np.ones(self.shape), np.zeros(self.shape)]))
        eased, gain = np.zeros_like(pulled), 0.0

        def condition(unknowns: Single) -> Single:
            self.spent += 0.25
            result = weight * gathered(self.single.inverse(spread(weight * unknowns)))
            return np.asarray(result - np.float32(gain * float(eased @ unknowns)) * eased)

        if self.series:
            # The inverse with a flexibility in series, by Sherman and Morrison.
            eased = condition(pulled)
            gain = self.series / (1.0 + self.series * float(pulled @ eased))

        def moved(traction: Single) -> Single:
            self.spent += 1.0
            result = self.single.displacement(traction)
            result[0] += np.float32(self.series * float(traction[0].sum()))
            return gathered(result)

        # The step needs only those products with the forces that its start has.
        axes = np.eye(2)[: self.axes, :, None, None] * np.ones(self.shape)
        forces = np.reshape([gathered(axis) for axis in axes], (self.axes, layer.size))
        smooth = np.reshape([condition(force) for force in forces], forces.shape)
        # If all cells slip alike no turn changes the force.
        gram = np.linalg.pinv(forces @ smooth.T, 1e-6)

        def free(residual: Single) -> Single:
            """The residual without its part along the displacements of distant points."""
            return np.asarray(residual - (gram @ (smooth @ residual)) @ forces, np.float32)

        # Cells that slip go to the bound, and the missing force is spread over all others.
        first = np.zeros_like(slip)
        first[:, slipping] = self.bound[slipping] * way - state.traction[:, slipping]
        lacks = (self.total - (state.traction + first).sum(axis=1))[: self.axes]
        change = (gram @ lacks.astype(np.float32)) @ smooth
        first += self.at_cells(spread(change))
        left = gathered(self.everywhere(slip))
        if float(np.abs(first).max()) > _NEGLIGIBLE * state.error:
            left -= moved(self.everywhere(first).astype(np.float32)) + layer * change
        left, result, energy = free(left), np.zeros_like(layer), 1.0
        direction: Single = np.zeros_like(layer)
        reduction = min(max(_IN_PROPORTION * state.error, _WELL), _ROUGHLY)
        target = reduction**2 * float(left @ left)
        for _ in range(_LARGEST_ITERATIONS):
            # A mean below the tolerance may hide a cell above it for ever.
            if float(left @ left) <= target or np.abs(left).max() <= _ENOUGH * tolerance:
                break
            preconditioned = condition(left)
            previous, energy = energy, float(left @ preconditioned)
            if not energy > 0.0:
                break
            direction = preconditioned + np.float32(energy / previous) * direction
            force: Single = moved(spread(direction)) + layer * direction
            part = np.float32(energy / float(direction @ force))
            result += part * direction
            left = free(np.subtract(left, part * force, dtype=np.float32))
        return first + self.at_cells(spread(result))

    def _result(self, state: _State) -> Sheared:
        traction = self.everywhere(state.traction * self.largest)
        slip = (state.far[:, None, None] - state.moved) * self.moves
        sticks = np.hypot(*state.pushed) <= self.bound
        slip.reshape(2, -1)[:, self.cells[sticks]] = 0.0
        force = float(state.traction[0].sum())
        moved = (state.moved + self.offset) * self.moves
        moved[0] -= self.series * force * self.moves
        return Sheared(
            traction,
            slip,
            float(state.far[0] - self.series * force) * self.moves,
            force * self.largest * self.area,
            0.5 * sum(map(self.bodies.geometry.integral, traction * moved)),
            state.error,
            round(self.spent),
            self.everywhere(self.bound * self.largest)[0],
        )
