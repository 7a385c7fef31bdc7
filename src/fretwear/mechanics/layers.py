"""Local compliance between the bodies: a displacement that depends on the pressure of its cell.

The contact solver adds such a layer to the half-space. A Winkler layer is linear; the wear of
one implicit step is a layer too, because more pressure on a cell means a deeper cell.
Every layer's displacement grows with pressure, so the contact problem stays convex.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fretwear.mechanics.arrays import Array, blocks_of_rows

_LARGEST_EXPONENT = 200.0
_TINY = 1e-12
_SMALL = 3e-5
_BLOCK = 2**14


class Layer(Protocol):
    """What the contact solver needs to know of a layer."""

    def displacement(self, pressure: Array) -> Array:
        """Displacement, m, under a pressure, Pa; both of the window's shape."""
        ...

    def tangent(self, pressure: Array) -> Array:
        """Derivative of the displacement, m/Pa; not negative."""
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

    def tangent(self, pressure: Array) -> Array:  # noqa: ARG002 - the tangent of a line
        """Derivative of the displacement, m/Pa."""
        return self.compliance


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
        return _by_rows(self._displace, pressure)

    def _displace(self, rows: slice, pressure: Array, result: Array) -> None:
        """Put the wear depth into some rows of the result."""
        x = self.exponent_at(pressure, rows)
        growth, worn = np.expm1(x), result[rows]
        np.multiply(growth, self.reduced_gap[rows], out=worn)
        if self.shift is not None:
            # φ − 1 = (eˣ − 1 − x)/x, and zero at zero.
            growth -= x
            np.maximum(x, _TINY, out=x)
            growth /= x
            growth *= self.shift[rows]
            worn += growth
            np.maximum(worn, 0.0, out=worn)
        worn += self.wear[rows]

    def tangent(self, pressure: Array) -> Array:
        """Derivative of the wear depth, m/Pa; not negative."""
        return _by_rows(self._differentiate, pressure)

    def _differentiate(self, rows: slice, pressure: Array, result: Array) -> None:
        """Put the tangent into some rows of the result."""
        x, slope = self.exponent_at(pressure, rows), result[rows]
        if self.shift is None:
            np.exp(x, out=x)
            np.multiply(x, self.reduced_gap[rows], out=slope)
        else:
            # φ' = (eˣ − φ)/x loses its digits near zero, where it is a line of slope 1/3.
            below = np.minimum(x, _SMALL)
            below -= _SMALL
            np.maximum(x, _SMALL, out=x)
            growth = np.expm1(x)
            np.add(growth, 1.0, out=slope)
            slope *= self.reduced_gap[rows]
            phi_slope = x - growth
            phi_slope /= x
            phi_slope += growth
            phi_slope /= x
            below /= 3.0
            phi_slope += below
            phi_slope *= self.shift[rows]
            slope += phi_slope
            np.maximum(slope, 0.0, out=slope)
        slope *= self.rate

    def exponent_at(self, pressure: Array, rows: slice) -> Array:
        """Exponent x at a pressure, Pa, on some rows."""
        x = self.rate * pressure[rows]
        x += self.exponent[rows]
        return np.minimum(x, _LARGEST_EXPONENT, out=x)


def _by_rows(put: Callable[[slice, Array, Array], None], pressure: Array) -> Array:
    """A field that a function of rows, pressure and the field puts together by blocks of rows."""
    result = np.empty_like(pressure)
    for rows in blocks_of_rows(pressure.shape, _BLOCK):
        put(rows, pressure, result)
    return result
