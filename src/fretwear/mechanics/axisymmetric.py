"""Wear of a smooth sphere in partial slip, on rings: an independent reference for the 3-D solver.

Nothing is shared with the solver on rectangular cells but the physics. Space is divided into rings
of uniform pressure, joined by a dense influence matrix from complete elliptic integrals, fine where
the stick edge passes; contact problems are solved by an active set with direct factorization. Time
is divided into small backward steps, and what is reported is extrapolated to vanishing steps.

Inside this module lengths are in Hertzian contact radii a, heights in a²/R, pressures in E* a/R and
time is τ = 4 K_w µ κ p0 N, so that only Q/µP and p_lim/p0 remain; `wear_history` is in SI units.

References
----------
K. L. Johnson (1985), Contact Mechanics, Cambridge University Press, section 3.4 (the displacement
of a uniform pressure on a disc).
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import astuple, dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import solve
from scipy.special import ellipe, ellipkm1

from fretwear.mechanics.materials import require_positive
from fretwear.mechanics.theory import CattaneoMindlin, HertzContact

__all__ = [
    "Resolution",
    "Rings",
    "SmoothWear",
    "disc_displacement",
    "solve_contact",
    "wear_history",
]

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
Layer = Callable[[FloatArray], tuple[FloatArray, FloatArray]]

UNIT_HERTZ = HertzContact(radius=1.0, load=4.0 / 3.0, composite_modulus=1.0)


def disc_displacement(r: ArrayLike, disc_radius: ArrayLike) -> FloatArray:
    """Surface displacement at ``r`` of a unit pressure on a disc, times the composite modulus.

    Parameters
    ----------
    r, disc_radius : array_like
        Distance from the axis and radius of the disc, m; broadcast against each other.

    Returns
    -------
    ndarray
        Displacement × E* / pressure, m.
    """
    distance, radius = np.broadcast_arrays(np.asarray(r, float), np.asarray(disc_radius, float))
    larger = np.maximum(distance, radius)
    ratio = np.minimum(distance, radius) / np.where(larger > 0.0, larger, 1.0)
    complement = np.maximum((1.0 - ratio) * (1.0 + ratio), np.finfo(float).tiny)
    bending = ellipe(ratio**2)
    outside = bending - complement * ellipkm1(complement)
    return np.asarray(4.0 / math.pi * larger * np.where(distance <= radius, bending, outside))


@dataclass(frozen=True, eq=False)
class Rings:
    """Concentric rings of uniform pressure.

    Parameters
    ----------
    edges : ndarray, shape (n + 1,)
        Radii of the ring edges from 0 outward, m.
    """

    edges: FloatArray

    @cached_property
    def radii(self) -> FloatArray:
        """Radii halfway between the edges, where displacements are evaluated, m; shape (n,)."""
        return np.asarray(0.5 * (self.edges[1:] + self.edges[:-1]))

    @cached_property
    def areas(self) -> FloatArray:
        """Areas of the rings, m²; shape (n,)."""
        return np.asarray(2.0 * math.pi * self.radii * np.diff(self.edges))

    @cached_property
    def influence(self) -> FloatArray:
        """Displacement × E* at ring i of a unit pressure on ring j, m; shape (n, n)."""
        return np.diff(disc_displacement(self.radii[:, None], self.edges[None, :]), axis=1)


@dataclass(frozen=True, eq=False)
class RingContact:
    """A solved contact: pressure, gap and which rings carry load or yield (shape (n,) each)."""

    pressure: FloatArray
    gap: FloatArray
    approach: float
    loaded: BoolArray
    yielding: BoolArray


def solve_contact(
    rings: Rings, layer: Layer, load: float, limit: float, start: RingContact
) -> RingContact:
    """Normal contact 0 ≤ p ≤ limit of a half-space with E* = 1 and an increasing surface layer.

    Parameters
    ----------
    rings : Rings
        The discretization.
    layer : callable
        Height of the undeformed gap and its derivative with respect to the pressure, as functions
        of the pressure; the derivative is not negative.
    load : float
        Normal load.
    limit : float
        Largest pressure; where it acts the gap is negative, by the penetration.
    start : RingContact
        First guess.

    Raises
    ------
    RuntimeError
        If the sets of loaded and yielding rings do not settle.
    """
    loaded, yielding, approach = start.loaded, start.yielding, start.approach
    pressure = start.pressure
    for _ in range(100):
        pressure = np.where(yielding, limit, np.where(loaded, pressure, 0.0))
        free = np.flatnonzero(loaded & ~yielding)
        height, slope = layer(pressure)
        matrix = np.zeros((free.size + 1, free.size + 1))
        matrix[:-1, :-1] = rings.influence[np.ix_(free, free)]
        matrix[np.arange(free.size), np.arange(free.size)] += slope[free]
        matrix[:-1, -1] = -1.0
        matrix[-1, :-1] = rings.areas[free]
        residual = approach - height[free] - rings.influence[free] @ pressure
        missing = load - rings.areas @ pressure
        change = solve(matrix, np.append(residual, missing), overwrite_a=True, check_finite=False)
        pressure[free] += change[:-1]
        approach += change[-1]
        gap = layer(pressure)[0] + rings.influence @ pressure - approach
        carries = np.where(loaded, pressure > 0.0, gap < 0.0)
        yields = np.where(yielding, gap < 0.0, loaded & (pressure > limit))
        settled = np.array_equal(carries, loaded) and np.array_equal(yields, yielding)
        if settled and np.all(np.abs(gap[free]) < 1e-11):
            return RingContact(pressure, gap, approach, loaded, yielding)
        loaded, yielding = carries, yields
    raise RuntimeError(
        f"the contact of {rings.radii.size} rings did not settle; refine the rings or the step"
    )


@dataclass(frozen=True)
class Resolution:
    """Fineness of rings and steps, in units of a and τ.

    Parameters
    ----------
    ring_width : float
        Width of the rings that the stick edge may sweep.
    narrowest : float
        Width of the rings at the first stick edge, where the elastic pressure grows without bound.
    widest : float
        Width of the rings elsewhere, at r = a; beyond a it grows in proportion to r.
    step : float
        Longest step; halved and quartered for the extrapolation.
    """

    ring_width: float = 1.0 / 160.0
    narrowest: float = 1e-5
    widest: float = 0.015
    step: float = 0.05

    def rings(self, stick_radius: float, swept_radius: float) -> Rings:
        """Rings around a stick edge that may move from ``stick_radius`` in to ``swept_radius``."""
        growth = 0.15

        def inward(distance: float) -> float:
            beyond = max(distance - (stick_radius - swept_radius), 0.0)
            widest = min(self.ring_width + growth * beyond, self.widest)
            return min(max(growth * distance, self.narrowest), widest)

        def outward(distance: float) -> float:
            widest = self.widest * max(stick_radius + distance, 1.0)
            return min(max(growth * distance, self.narrowest), widest)

        inner = stick_radius - _march(stick_radius, inward)[:0:-1]
        outer = stick_radius + _march(8.0 - stick_radius, outward)
        inner[0] = 0.0
        return Rings(np.concatenate([inner, outer]))


def _march(length: float, width: Callable[[float], float]) -> FloatArray:
    """Distances from 0 to ``length`` whose spacing follows ``width``."""
    distances = [0.0]
    while distances[-1] < length:
        distances.append(distances[-1] + width(distances[-1]))
    return np.asarray(distances) * (length / distances[-1])


@dataclass(frozen=True, eq=False)
class WearState:
    """Wear and plastic depth at one time, and the contacts under P and P*."""

    wear: FloatArray
    plastic: FloatArray
    full: RingContact
    reduced: RingContact


@dataclass(frozen=True)
class SmoothWear:
    """Wear of a smooth sphere in dimensionless form.

    Parameters
    ----------
    rings : Rings
        The discretization, in units of a.
    load_ratio : float
        X = Q / µP.
    limit_ratio : float
        Largest pressure over p0; infinite for elastic bodies.
    """

    rings: Rings
    load_ratio: float
    limit_ratio: float

    @property
    def limit(self) -> float:
        """Largest pressure."""
        return self.limit_ratio * UNIT_HERTZ.peak_pressure

    def unworn(self) -> WearState:
        """State before the first cycle."""
        r = self.rings.radii
        zero = np.zeros_like(r)
        stick = UNIT_HERTZ.with_load(UNIT_HERTZ.load * (1.0 - self.load_ratio))
        full, reduced = (
            RingContact(
                contact.pressure(r), zero, contact.approach, r < contact.contact_radius, zero > 0.0
            )
            for contact in (UNIT_HERTZ, stick)
        )
        full = self._press(zero, UNIT_HERTZ.load, self.limit, full)
        return WearState(zero, zero, full, self._reduced(zero, reduced))

    def advance(self, state: WearState, step: float) -> WearState:
        """State one backward step of τ later: first order in the step, stable for any.

        The pressure is that of the end of the step. Where it is known, dW/dτ = g* p/p0 with
        g* = W + e is solved exactly, e changing linearly from its old to its new value; e, the gap
        at P* without the wear, changes only where plastic flow moves the stick zone.
        """
        sphere = 0.5 * self.rings.radii**2
        rate = step / UNIT_HERTZ.peak_pressure
        wear, plastic, full, reduced = state.wear, state.plastic, state.full, state.reduced
        source = state.reduced.gap - state.wear
        # Left at any sweep the step stays consistent, so that the extrapolation to vanishing
        # steps needs no converged sweeps; eight are plenty at the default step.
        for _ in range(8):
            opened = (reduced.gap > 0.0) & (pressed_rings := state.full.pressure >= 0.0)
            change = np.where(opened, reduced.gap - wear - source, 0.0)

            def layer(
                pressure: FloatArray, change: FloatArray = change
            ) -> tuple[FloatArray, FloatArray]:
                x = np.clip(rate * pressure, 0.0, 200.0)
                grown = np.expm1(x)
                safe = np.where(x > 1e-4, x, 1.0)
                ramp = np.where(x > 1e-4, (grown - x) / safe, 0.5 * x)
                ramp_slope = np.where(x > 1e-4, (grown - ramp) / safe, 0.5)
                worn = state.reduced.gap * grown + change * ramp
                slope = state.reduced.gap * (grown + 1.0) + change * ramp_slope
                height = sphere + state.wear + state.plastic + np.maximum(worn, 0.0)
                return height, np.maximum(rate * slope, 0.0)

            full = solve_contact(self.rings, layer, UNIT_HERTZ.load, self.limit, full)
            wear = layer(full.pressure)[0] - sphere - state.plastic
