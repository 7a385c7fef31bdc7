"""One step of the wear of a smooth sphere on rings, elastic or elastic–perfectly plastic.

Lengths are in Hertzian contact radii a, heights in a²/R, pressures in E* a/R and time is
τ = 4 K_w µ κ p0 N, so that only Q/µP and p_lim/p0 remain. The reduced-load problem of Ciavarella
(1998) and Jäger (1998) gives the slip, Archard's law the wear; where the pressure reaches the
plastic limit the shape sinks for good.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fretwear.mechanics.rings import RingContact, Rings, solve_contact
from fretwear.theory import HertzContact

__all__ = ["UNIT_HERTZ", "SmoothWear", "WearState"]

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

UNIT_HERTZ = HertzContact(radius=1.0, load=4.0 / 3.0, composite_modulus=1.0)


@dataclass(frozen=True, eq=False)
class WearState:
    """Wear and plastic depth at one time, and the contacts under P and under P*."""

    wear: FloatArray
    plastic: FloatArray
    full: RingContact
    reduced: RingContact


@dataclass(frozen=True, eq=False)
class _WearingLayer:
    """Height of the gap at the end of a step, and its derivative, for a pressure at that time.

    The wear of the step solves dW/dx = g*, x running from 0 to rate · p, exactly for g* = W + e
    where e goes from its old value to the new one linearly.

    Parameters
    ----------
    height : ndarray
        Height at the start of the step.
    gap : ndarray
        g* at the start of the step.
    change : ndarray
        Change of e over the step.
    rate : float
        Step of τ over p0.
    """

    height: FloatArray
    gap: FloatArray
    change: FloatArray
    rate: float

    def __call__(self, pressure: FloatArray) -> tuple[FloatArray, FloatArray]:
        # far beyond any pressure that is a solution, Newton's first guesses must not overflow
        x = np.clip(self.rate * pressure, 0.0, 200.0)
        divisor = np.maximum(x, 1e-4)
        grown = np.expm1(x)
        ramp = np.where(x < 1e-4, 0.5 * x, (grown - x) / divisor)
        ramp_slope = np.where(x < 1e-4, 0.5, (grown - ramp) / divisor)
        worn = self.gap * grown + self.change * ramp
        slope = self.gap * (grown + 1.0) + self.change * ramp_slope
        return self.height + np.maximum(worn, 0.0), np.maximum(self.rate * slope, 0.0)


@dataclass(frozen=True)
class SmoothWear:
    """Dimensionless wear of a smooth sphere.

    Parameters
    ----------
    rings : Rings
        The discretisation.
    load_ratio : float
        X = Q / µP.
    limit_ratio : float
        Largest pressure over p0; infinite for elastic bodies.
    """

    rings: Rings
    load_ratio: float
    limit_ratio: float

    @property
    def reduced_load(self) -> float:
        """Load P* = P (1 - X)."""
        return UNIT_HERTZ.load * (1.0 - self.load_ratio)

    @property
    def limit(self) -> float:
        """Largest pressure."""
        return UNIT_HERTZ.peak_pressure * self.limit_ratio

    def unworn(self) -> WearState:
        """State before the first cycle."""
        r = self.rings.radii
        none = np.zeros_like(r)
        contacts = (UNIT_HERTZ, UNIT_HERTZ.with_load(self.reduced_load))
        full, reduced = (
            RingContact(h.pressure(r), h.gap(r), h.approach, r < h.contact_radius, r < 0.0)
            for h in contacts
        )
        start = WearState(none, none, full, self._press_reduced(0.5 * r**2, reduced))
        return self.advance(start, 0.0)

    def advance(self, state: WearState, step: float) -> WearState:
        """State one backward step of τ later: first order in the step, stable for any."""
        sphere = 0.5 * self.rings.radii**2
        old = sphere + state.wear + state.plastic
        rate = step / UNIT_HERTZ.peak_pressure
        full, reduced = state.full, state.reduced
        change = np.zeros_like(sphere)
        # Any number of sweeps makes a consistent step, so unlike the pressure they need no full
        # convergence: the extrapolation to vanishing steps removes what is left.
        for _ in range(6):
            layer = _WearingLayer(old, state.reduced.gap, change, rate)
            full = solve_contact(self.rings, layer, UNIT_HERTZ.load, self.limit, full)
            worn = layer(full.pressure)[0] - old
            sunk = np.where(full.yielding, -full.gap, 0.0)
            if not full.yielding.any():
                # wear outside the stick zone changes nothing under P* but the gap
                reduced = replace(state.reduced, gap=state.reduced.gap + worn)
                break
            previous = reduced.gap
            reduced = self._press_reduced(old + worn + sunk, reduced)
            change = np.where(reduced.gap > 0.0, reduced.gap - worn - state.reduced.gap, 0.0)
            if np.max(np.abs(reduced.gap - previous)) < 1e-10:
                break
        return WearState(state.wear + worn, state.plastic + sunk, full, reduced)

    def _press_reduced(self, shape: FloatArray, start: RingContact) -> RingContact:
        """Contact of a shape under P*, its gap exactly zero where it sticks."""
        rigid = np.zeros_like(shape)
        contact = solve_contact(
            self.rings, lambda _: (shape, rigid), self.reduced_load, math.inf, start
        )
        return replace(contact, gap=np.where(contact.loaded, 0.0, contact.gap))

    def measure(self, state: WearState) -> FloatArray:
        """The values of `WearHistory` after the cycles, in its order, dimensionless.

        The stick zone ends where p*² vanishes, and so does an unworn contact. A growing contact
        ends where the wear does: there the pressure keeps its height up to the last ring.
        """
        r, full = self.rings.radii, state.full
        bend = (full.pressure[1] - full.pressure[0]) / (r[1] ** 2 - r[0] ** 2)
        values = (
            full.approach,
            full.pressure[0] - bend * r[0] ** 2,
            _vertex(r, state.wear),
            self.rings.areas @ state.wear,
            self.rings.areas @ state.plastic,
            _edge(self.rings, full.loaded, state.wear if state.wear.any() else full.pressure**2),
            _edge(self.rings, state.reduced.loaded, state.reduced.pressure**2),
        )
        return np.array(values)


def _vertex(r: FloatArray, depth: FloatArray) -> float:
    """Maximum of the parabola through the three rings about the deepest one."""
    top = int(np.clip(np.argmax(depth), 1, depth.size - 2))
    bend, slope, height = np.polyfit(r[top - 1 : top + 2] - r[top], depth[top - 1 : top + 2], 2)
    return float(height - (slope**2 / (4.0 * bend) if bend < 0.0 else 0.0))


def _edge(rings: Rings, loaded: BoolArray, falling: FloatArray) -> float:
    """Radius at which a quantity, falling linearly over the last two loaded rings, vanishes."""
    last = int(np.flatnonzero(loaded)[-1])
    if last + 1 == rings.radii.size:
        raise RuntimeError("the contact has grown beyond the outermost ring")
    near, far, open_ring = rings.radii[last - 1 : last + 2]
    higher, lower = falling[last - 1 : last + 1]
    if higher <= lower:
        return float(rings.edges[last + 1])
    return float(np.clip(far + lower * (far - near) / (higher - lower), far, open_ring))
