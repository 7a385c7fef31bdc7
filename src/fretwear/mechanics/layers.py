"""Local compliance between the bodies: a displacement that depends on the pressure of its cell.

The contact solver adds such a layer to the half-space. A Winkler layer is linear; the wear of
one implicit step is a layer too, because more pressure on a cell means a deeper cell.
Every layer's displacement grows with pressure, so the contact problem stays convex.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fretwear.mechanics import passes
from fretwear.mechanics.arrays import Array, Real, Single


class Layer(Protocol):
    """What the contact solver needs to know of a layer."""

    def displacement(self, pressure: Array) -> Array:
        """Displacement, m, under a pressure, Pa; both of the window's shape."""
        ...

    def add_displacement(self, pressure: Array, result: Array) -> None:
        """Add the displacement under a pressure to a field."""
        ...

    def tangent_in(self, unit: float, pressure: Array) -> Single:
        """Derivative of the displacement in some unit, m/Pa; not negative."""
        ...


@dataclass(frozen=True)
class WinklerLayer:
    """A linear layer: displacement ``offset + compliance · p``.

    Parameters
    ----------
    compliance
        m/Pa, shape of the window, not negative.
    offset
        Displacement without pressure, m, same shape.
    """

    compliance: Array
    offset: Array

    def displacement(self, pressure: Array) -> Array:
        """Displacement, m, under a pressure, Pa."""
        return self.offset + self.compliance * pressure

    def add_displacement(self, pressure: Array, result: Array) -> None:
        """Add the displacement, m, under a pressure, Pa, to a field."""
        result += self.displacement(pressure)

    def tangent_in(self, unit: float, pressure: Array) -> Single:  # noqa: ARG002 - a line's
        """Derivative of the displacement in some unit, m/Pa."""
        return (self.compliance / unit).astype(np.float32)


@dataclass(frozen=True)
class WearLayer:
    """Wear depth at the end of an implicit stage as a function of the pressure there.

    With the gap g* of the reduced-load problem, dW/dN = β p g* and dg*/dN = β p g* + dG/dN,
    where G = g* − W changes by plastic flow only. For x = β∫p dN over the stage and G linear
    in x, both integrate in closed form::

        g* = eˣ g*₀ + ΔG φ(x),   W = W₀ + (eˣ − 1) g*₀ + ΔG (φ(x) − 1),   φ(x) = (eˣ − 1)/x

    and x = x₀ + τ p with the stage's pressure p. Written for g* alone, an implicit step
    diverges where τp > 1; written for x it is a convex problem for every step.

    Parameters
    ----------
    wear
        Wear depth W₀ at the start of the stage, m.
    reduced_gap
        g*₀ at the start of the stage, m, not negative.
    shift
        ΔG over the stage, m.
    exponent
        x₀, the part of the exponent that is already known.
    rate
        τ, 1/Pa.
    """

    wear: Array
    reduced_gap: Array
    shift: Array | None
    exponent: Array
    rate: float

    def displacement(self, pressure: Array) -> Array:
        """Wear depth, m, under a pressure, Pa; never less than at the start of the stage."""
        result = np.zeros_like(pressure)
        self.add_displacement(pressure, result)
        return result

    def add_displacement(self, pressure: Array, result: Array) -> None:
        """Add the wear depth, m, under a pressure, Pa, to a field."""
        passes.wear(
            pressure,
            self.rate,
            self.exponent,
            self.wear,
            self.reduced_gap,
            self.shift,
            result,
        )

    def tangent(self, pressure: Array) -> Array:
        """Derivative of the wear depth, m/Pa; not negative."""
        return self._put_tangent(pressure, 1.0, np.empty_like(pressure))

    def tangent_in(self, unit: float, pressure: Array) -> Single:
        """Derivative of the wear depth in some unit, m/Pa; not negative."""
        return self._put_tangent(pressure, unit, np.empty(pressure.shape, np.float32))

    def _put_tangent(self, pressure: Array, unit: float, result: Real) -> Real:
        factor, gap = self.rate / unit, self.reduced_gap
        passes.wear_slope(pressure, self.rate, self.exponent, gap, self.shift, factor, result)
        return result
