"""The active-set method of the normal contact.

Cells are free (0 < p < p_lim), open (p = 0) or saturated (p = p_lim). The method solves the linear
problem of the free cells by a few preconditioned conjugate-gradient steps, projects the result
onto the bounds, searches the segment to it for the least energy, and moves cells between the
sets. Along a segment K p is linear, so the search costs no convolution. Energy falls at every
step, hence no set of cells repeats.
"""

from __future__ import annotations

import numpy as np

from fretwear.mechanics.arrays import Array, Mask, inner
from fretwear.mechanics.contact_problem import ContactProblem

_LARGEST_OUTER = 60
_LARGEST_INNER = 40
_FORCING = 0.3
_STIFFENING = 3.0


class ActiveSet:
    """A feasible pressure, its displacement and the sets, on the way to the solution.

    Parameters
    ----------
    problem
        What to solve.
    start
        A first guess of the pressure, Pa, of any load.
    """

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
            if inner(self.gap, step) < 0:
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
            return inner(step, self.problem.separation(pressure, moved))

        first, last = inner(step, self.gap), slope(1.0)
        if last <= 0.1 * abs(first):
            return 1.0
        low, high = 0.0, 1.0
        for _ in range(20):
            fraction = low + (high - low) * max(0.05, min(0.95, first / (first - last)))
            middle = slope(fraction)
            if abs(middle) <= 0.1 * abs(inner(step, self.gap)):
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
        tangent = None if layer is None else layer.tangent(self.pressure)
        weight, uniform = free, 0.0
        if tangent is not None:
            own = half_space.self_influence
            uniform = float(1.0 / np.mean(1.0 / (tangent[self.free] + own))) - own
            weight = free * np.sqrt((_STIFFENING * own + uniform) / (_STIFFENING * own + tangent))
        ones = half_space.precondition(weight, uniform)
        ones *= weight
        ones_sum = float(ones.sum())
        residual = -self.gap * free
        step, moved, direction = (np.zeros_like(residual) for _ in range(3))
        count = np.count_nonzero(self.free)
        residual -= free * (residual.sum() / count)
        target = max(_FORCING * _largest(residual), 0.3 * tolerance * self.scale)
        energy = 0.0
        for _ in range(_LARGEST_INNER):
            z = half_space.precondition(weight * residual, uniform)
            z *= weight
            z -= ones * (float(z.sum()) / ones_sum)
            previous, energy = energy, inner(residual, z)
            if not energy > 0:
                break
            if previous > 0:
                direction *= energy / previous
            direction += z
            image = half_space.displacement(direction)
            self.convolutions += 1
            self.iterations += 1
            force = image if tangent is None else image + tangent * direction
            length = energy / inner(direction, force)
            step += length * direction
            moved += length * image
            force *= free
            force *= length
            residual -= force
            residual -= free * (residual.sum() / count)
            if _largest(residual) <= target:
                break
        return step, moved


def _largest(field: Array) -> float:
    """Largest absolute value, without the copy that np.abs would make."""
    return max(float(field.max()), -float(field.min()))


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
