"""Normal contact under a given load: pressure between zero and a limit.

Find the pressure p and the approach δ with

    g = K p + W(p) + h − δ,   ∬p = P,   0 ≤ p ≤ p_lim,
    g = 0 where 0 < p < p_lim,   g ≥ 0 where p = 0,   g ≤ 0 where p = p_lim

for the half-space K, a shape h and a layer W. It is the optimality condition of a convex
program. The method guesses the sets of free, open and saturated cells, solves the linear
problem of the free cells by a few preconditioned conjugate-gradient steps, projects the result
onto the bounds, searches the segment to it for the least energy, and moves cells between
the sets. Along a segment K p is linear, so that search costs no convolution. Energy falls at every
step, hence no set of cells repeats; a start from which the method stalls goes to the slower
projected gradient of `fretwear.mechanics.gradient`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fretwear.mechanics.gradient import projected_gradient
from fretwear.mechanics.halfspace import Array, HalfSpace
from fretwear.mechanics.layers import Layer

Mask = NDArray[np.bool_]

_LARGEST_OUTER = 60
_LARGEST_INNER = 40
_FORCING = 0.3
_STIFFENING = 3.0
_COARSE = 1e-2


class ContactError(RuntimeError):
    """No pressure distribution satisfies the conditions of contact to the tolerance asked for."""


@dataclass(frozen=True)
class ContactProblem:
    """A normal contact.

    Parameters
    ----------
    half_space
        The elastic bodies on a window.
    shape
        Gap at zero load and zero approach, m, shape of the window.
    load
        Normal load P of the whole contact, N.
    limit
        Largest pressure, Pa; infinite when elastic.
    layer
        Local compliance, or None.
    """

    half_space: HalfSpace
    shape: Array
    load: float
    limit: float = np.inf
    layer: Layer | None = None

    @property
    def total(self) -> float:
        """Sum of the pressure over the window's cells that carries the load, Pa."""
        window = self.half_space.window
        return self.load / (window.cell_area * window.copies)

    def separation(self, pressure: Array, displacement: Array) -> Array:
        """K p + W(p) + h, m: the gap plus the approach."""
        result = displacement + self.shape
        if self.layer is not None:
            result += self.layer.displacement(pressure)
        return result


@dataclass(frozen=True)
class Contact:
    """The solution of a `ContactProblem`.

    Attributes
    ----------
    pressure, gap
        Pa and m, shape of the window. The gap is negative where the pressure is at its limit:
        there the bodies yield by its absolute value.
    approach
        δ, m.
    saturated
        Cells at the pressure limit.
    residual
        Largest violation of the conditions on the gap, relative to the largest displacement,
        from a convolution made for this purpose.
    iterations, convolutions
        Conjugate-gradient steps and half-space convolutions spent.
    """

    pressure: Array
    gap: Array
    approach: float
    saturated: Mask
    residual: float
    iterations: int
    convolutions: int

    @property
    def penetration(self) -> Array:
        """Depth by which saturated cells yield, m, zero elsewhere."""
        result: Array = np.where(self.saturated, np.maximum(-self.gap, 0.0), 0.0)
        return result


def solve_contact(
    problem: ContactProblem, start: Array | None = None, tolerance: float = 1e-6
) -> Contact:
    """Solve a normal contact.

    Parameters
    ----------
    problem
        What to solve.
    start
        A first guess of the pressure, Pa, for example the solution of a similar problem.
    tolerance
        Largest violation of the conditions on the gap, relative to the largest displacement.

    Returns
    -------
    Contact

    Raises
    ------
    ContactError
        If the limit cannot carry the load on this window, or nothing converges.
    """
    window = problem.half_space.window
    if not problem.limit * window.cell_area * window.copies * problem.shape.size > problem.load:
        raise ContactError(
            f"a pressure limit of {problem.limit:.4g} Pa cannot carry {problem.load:.4g} N on "
            f"a window of half-widths {window.extent[0]:.3g} m and {window.extent[1]:.3g} m"
        )
    spent = (0, 0)
    if start is None:
        start = _first_guess(problem.shape)
        if np.isfinite(problem.limit):
            # Both bounds at once from far away lead to wrong sets: yield from the elastic state.
            elastic = _ActiveSet(replace(problem, limit=np.inf), start)
            elastic.solve(_COARSE)
            start, spent = elastic.pressure, (elastic.iterations, elastic.convolutions)
    method = _ActiveSet(problem, start)
    if not method.solve(tolerance):
        method.restart(projected_gradient(problem, method.pressure, tolerance))
        if not method.solve(tolerance):
            raise ContactError(
                f"the normal contact did not converge: residual {method.residual():.2e} instead "
                f"of {tolerance:.0e} after {method.convolutions} convolutions"
            )
    return Contact(
        pressure=method.pressure,
        gap=method.gap,
        approach=method.approach,
        saturated=method.saturated,
        residual=method.residual(),
        iterations=method.iterations + spent[0],
        convolutions=method.convolutions + spent[1],
    )


class _ActiveSet:
    """State of the active-set method: a feasible pressure, its displacement, the sets."""

    def __init__(self, problem: ContactProblem, start: Array) -> None:
        self.problem = problem
        self.iterations = 0
        self.convolutions = 0
        self.restart(start)

    def restart(self, start: Array) -> None:
        """Take a pressure as the current one, scaled to the load and cut to the bounds."""
        self._set(carrying(start, self.problem.limit, self.problem.total))
        self._refresh()

    def solve(self, tolerance: float) -> bool:
        """Iterate until the residual is below the tolerance; whether it got there."""
        for _ in range(_LARGEST_OUTER):
            self._evaluate()
            error = self.residual()
            if not np.isfinite(error):
                return False
            if error <= tolerance:
                if self.exact:
                    return True
                self._refresh()
                continue
            self._exchange(tolerance)
            if not self._advance(tolerance):
                return False
        return False

    def residual(self) -> float:
        """Largest violation of the gap conditions relative to the largest displacement."""
        free, saturated = self.gap[self.free], self.gap[self.saturated]
        worst = max(
            float(np.abs(free).max(initial=0.0)),
            float(saturated.max(initial=0.0)),
            -float(self.gap[~(self.free | self.saturated)].min(initial=0.0)),
        )
        return worst / self.scale

    def _set(self, pressure: Array) -> None:
        self.pressure = pressure
        self.saturated: Mask = pressure >= self.problem.limit
        self.free: Mask = (pressure > 0) & ~self.saturated

    def _refresh(self) -> None:
        """Recompute K p, which is otherwise carried along."""
        self.displacement = self.problem.half_space.displacement(self.pressure)
        self.convolutions += 1
        self.exact = True

    def _evaluate(self) -> None:
        separation = self.problem.separation(self.pressure, self.displacement)
        if self.free.any():
            self.approach = float(separation[self.free].mean())
        else:
            # Every loaded cell is saturated: the approach lies between those and the open cells.
            self.approach = float(separation[self.saturated].max())
        self.gap = separation - self.approach
        self.scale = float(self.displacement.max())

    def _exchange(self, tolerance: float) -> None:
        """Free the open cells that interpenetrate and the saturated ones that separate."""
        slack = 0.3 * tolerance * self.scale
        self.free |= ~(self.free | self.saturated) & (self.gap < -slack)
        self.free |= self.saturated & (self.gap > slack)
        self.saturated &= ~self.free

    def _advance(self, tolerance: float) -> bool:
        """One projected Newton step; False when no descent is left."""
        step, displacement = self._newton_step(tolerance)
        target = self.pressure + step
        inside = target[self.free]
        if inside.min(initial=0.0) >= 0 and inside.max(initial=0.0) <= self.problem.limit:
            self._search(step, displacement)
            return True
        for _ in range(8):
            step = carrying(target, self.problem.limit, self.problem.total) - self.pressure
            displacement = self.problem.half_space.displacement(step)
            self.convolutions += 1
            if float(np.vdot(self.gap, step)) < 0:
                self._search(step, displacement)
                return True
            # Clipping turned the direction uphill: a shorter step clips less.
            target = 0.7 * self.pressure + 0.3 * target
        return False

    def _search(self, step: Array, displacement: Array) -> None:
        """Go along a feasible segment, all the way or to its lowest energy."""
        fraction = self._lowest(step, displacement)
        self._set(self.pressure + fraction * step)
        self.displacement = self.displacement + fraction * displacement
        self.exact = False

    def _lowest(self, step: Array, displacement: Array) -> float:
        """Fraction of the segment at which the energy is lowest: 1 unless it overshoots."""

        def slope(fraction: float) -> float:
            pressure = self.pressure + fraction * step
            moved = self.displacement + fraction * displacement
            return float(np.vdot(step, self.problem.separation(pressure, moved)))

        first, last = float(np.vdot(step, self.gap)), slope(1.0)
        if last <= 0.1 * abs(first):
            return 1.0
        low, high = 0.0, 1.0
        for _ in range(20):
            fraction = low + (high - low) * max(0.05, min(0.95, first / (first - last)))
            middle = slope(fraction)
            if abs(middle) <= 0.1 * abs(float(np.vdot(step, self.gap))):
                break
            if middle < 0:
                low, first = fraction, middle
            else:
                high, last = fraction, middle
        return fraction

    def _newton_step(self, tolerance: float) -> tuple[Array, Array]:
        """Step of the free cells and its displacement by preconditioned conjugate gradients.

        The load is kept by directions of zero sum: with z₁ = M 1, the preconditioned residual
        z becomes z − z₁ (∑z/∑z₁). M inverts the half-space with a uniform layer; a scaling of
        both its sides turns that into the layer's own tangent where this dominates.
        """
        half_space = self.problem.half_space
        layer = self.problem.layer
        free = self.free.astype(float)
        count = free.sum()
        tangent = None if layer is None else layer.tangent(self.pressure)
        weight, uniform = free, 0.0
        if tangent is not None:
            own = half_space.self_influence
            uniform = float(1.0 / np.mean(1.0 / (tangent[self.free] + own))) - own
            weight = free * np.sqrt((_STIFFENING * own + uniform) / (_STIFFENING * own + tangent))
        ones = weight * half_space.precondition(weight, uniform)
        ones_sum = float(ones.sum())
        residual = -self.gap * free
        residual -= free * (residual.sum() / count)
        target = max(_FORCING * float(np.abs(residual).max()), 0.3 * tolerance * self.scale)
        step = np.zeros_like(residual)
        moved = np.zeros_like(residual)
        direction = step
        energy = 0.0
        for _ in range(_LARGEST_INNER):
            z = weight * half_space.precondition(weight * residual, uniform)
            z -= ones * (float(z.sum()) / ones_sum)
            previous, energy = energy, float(np.vdot(residual, z))
            if not energy > 0:
                break
            direction = z if previous == 0 else z + direction * (energy / previous)
            image = half_space.displacement(direction)
            self.convolutions += 1
            self.iterations += 1
            force = image if tangent is None else image + tangent * direction
            length = energy / float(np.vdot(direction, force))
            step += length * direction
            moved += length * image
            residual -= length * free * force
            residual -= free * (residual.sum() / count)
            if float(np.abs(residual).max()) <= target:
                break
        return step, moved


def carrying(pressure: Array, limit: float, total: float) -> Array:
    """The pressure cut to the bounds, its free cells scaled so that its sum is ``total``, Pa.

    Scaling leaves open cells open and saturated cells saturated; a shift would free them.
    """
    result = np.clip(pressure, 0.0, limit)
    for _ in range(100):
        free = (result > 0) & (result < limit)
        missing = total - float(result.sum())
        if abs(missing) <= 1e-14 * total:
            break
        movable = free if (missing > 0 or result[free].sum() > -missing) else result > 0
        if not movable.any():
            # All loaded cells are at the limit and still do not carry the load.
            result[result == 0] = 1e-3 * limit
            continue
        result[movable] *= 1.0 + missing / float(result[movable].sum())
        np.minimum(result, limit, out=result)
    return result


def _first_guess(shape: Array) -> Array:
    """A pressure on the lowest fifth of the surface, growing with depth (arbitrary scale)."""
    level = float(np.quantile(shape, 0.2))
    result: Array = np.maximum(level - shape, 0.0)
    return result
