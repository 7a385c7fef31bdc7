"""Wear of a smooth sphere in partial slip on rings: an independent reference for the integrator.

Nothing is shared with the package but closed forms. Space is divided into rings of uniform
pressure, fine where the stick edge passes, with a contact solver of its own; time into small
backward steps, and reported values are extrapolated to vanishing steps. The reduced-load problem
of Ciavarella (1998) and Jäger (1998) gives the slip, Archard's law the wear; where the pressure
reaches the plastic limit the shape sinks for good.

Lengths are in Hertzian contact radii a, heights in a²/R, pressures in E* a/R and time is
τ = 4 K_w µ κ p0 N, so that only Q/µP and p_lim/p0 remain.

References
----------
K. L. Johnson (1985), Contact Mechanics, Cambridge University Press, section 3.4 (the displacement
of a uniform pressure on a disc).
M. Ciavarella (1998), The generalized Cattaneo partial slip plane contact problem,
Int. J. Solids Struct. 35, 2349–2362.
J. Jäger (1998), A new principle in contact mechanics, J. Tribol. 120, 677–684.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import solve
from scipy.special import ellipe, ellipkm1

from fretwear.theory import HertzContact

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
Layer = Callable[[FloatArray], tuple[FloatArray, FloatArray]]

# Growth of the ring widths with the distance from the edge. The stick edge moves inward only, and
# there the rings have to stay as fine as the band that yields.
INWARD_GRADING, OUTWARD_GRADING = 0.05, 0.15


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


def graded_rings(
    edge: float,
    swept: float,
    outer: float,
    *,
    narrowest: float,
    narrow: float,
    widest: float,
) -> Rings:
    """Rings that are fine about an edge, and down to where the edge may move.

    Parameters
    ----------
    edge : float
        Radius about which the rings are finest.
    swept : float
        Radius down to which the edge may move, at most ``edge``.
    outer : float
        Radius of the last ring.
    narrowest, narrow, widest : float
        Widths at ``edge``, from there to ``swept``, and elsewhere. Beyond unit radius the widest
        rings grow in proportion to r.
    """

    def inward(distance: float) -> float:
        excess = max(distance - (edge - swept), 0.0)
        return min(
            max(INWARD_GRADING * distance, narrowest), narrow + OUTWARD_GRADING * excess, widest
        )

    def outward(distance: float) -> float:
        return min(max(OUTWARD_GRADING * distance, narrowest), widest * max(edge + distance, 1.0))

    inner = edge - _march(edge, inward)[:0:-1]
    inner[0] = 0.0
    return Rings(np.concatenate([inner, edge + _march(outer - edge, outward)]))


def _march(length: float, width: Callable[[float], float]) -> FloatArray:
    """Distances from 0 to ``length`` whose spacing follows ``width``."""
    distances = [0.0]
    while distances[-1] < length:
        distances.append(distances[-1] + width(distances[-1]))
    return np.asarray(distances) * (length / distances[-1])


@dataclass(frozen=True, eq=False)
class RingContact:
    """A solved contact: pressure, gap and which rings carry load or yield (shape (n,) each)."""

    pressure: FloatArray
    gap: FloatArray
    approach: float
    loaded: BoolArray
    yielding: BoolArray


def solve_contact(
    rings: Rings, layer: Layer, load: float, limit: float | FloatArray, start: RingContact
) -> RingContact:
    """Normal contact 0 ≤ p ≤ limit of a half-space with E* = 1 and an increasing surface layer.

    Parameters
    ----------
    rings : Rings
        The discretisation.
    layer : callable
        Height of the undeformed gap and its derivative with respect to the pressure, as functions
        of the pressure; the derivative is not negative.
    load : float
        Normal load.
    limit : float or ndarray
        Largest pressure, of all rings or of each; where it acts the gap is negative, by the
        penetration.
    start : RingContact
        First guess.

    Raises
    ------
    RuntimeError
        If the sets of loaded and yielding rings do not converge.
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
        yields = np.where(yielding, gap <= 0.0, loaded & (pressure > limit))
        unchanged = np.array_equal(carries, loaded) and np.array_equal(yields, yielding)
        if unchanged and np.all(np.abs(gap[free]) < 1e-11):
            return RingContact(pressure, gap, approach, loaded, yielding)
        loaded, yielding = carries, yields
    raise RuntimeError(
        f"the contact of {rings.radii.size} rings did not converge; refine the rings or the step"
    )


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
    growth : float
        αµ² of junction growth, p² + αq² ≤ p_lim².
    """

    rings: Rings
    load_ratio: float
    limit_ratio: float
    growth: float = 0.0

    @property
    def reduced_load(self) -> float:
        """Load P* = P (1 - X)."""
        return UNIT_HERTZ.load * (1.0 - self.load_ratio)

    @property
    def limit(self) -> float:
        """Largest pressure without shear."""
        return UNIT_HERTZ.peak_pressure * self.limit_ratio

    def lowered(self, full: RingContact, reduced: RingContact) -> float | FloatArray:
        """Largest pressure, with the shear q = µ (p − p*) of the contacts just before."""
        sheared = 1.0 - reduced.pressure / np.where(full.loaded, full.pressure, np.inf)
        return self.limit / np.sqrt(1.0 + self.growth * sheared**2) if self.growth else self.limit

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
        # convergence: the extrapolation to vanishing steps removes the rest.
        for _ in range(6):
            layer = _WearingLayer(old, state.reduced.gap, change, rate)
            limit = self.lowered(full, reduced)
            full = solve_contact(self.rings, layer, UNIT_HERTZ.load, limit, full)
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
        """Approach, central pressure, deepest wear, worn and plastic volume, radii of both edges.

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


@dataclass(frozen=True)
class Resolution:
    """Fineness of the rings, in units of a, and of the steps, in units of τ.

    Parameters
    ----------
    swept_width : float
        Width of the rings that the stick edge may sweep.
    edge_width : float
        Width of the rings at the first stick edge, where the elastic pressure grows without bound.
    widest : float
        Width of the rings elsewhere up to r = a; beyond, it grows in proportion to r.
    step : float
        Longest step; it is halved and quartered for the extrapolation.

    Notes
    -----
    What yields is a band at the stick edge, about as wide as `LimitingState.width_above` says for
    the plastic limit. Rings wider than half of it there see too little yielding or none.
    """

    swept_width: float = 1.0 / 320.0
    edge_width: float = 1e-4
    widest: float = 0.015
    step: float = 0.05


def dimensionless_history(
    load_ratio: float,
    limit_ratio: float,
    times: Sequence[float],
    resolution: Resolution,
    growth: float = 0.0,
) -> tuple[FloatArray, FloatArray]:
    """Values of `SmoothWear.measure` at the times τ, and the error left by the steps.

    Parameters
    ----------
    load_ratio, limit_ratio : float
        Q / µP, and the largest pressure over p0.
    growth : float
        αµ² of junction growth.
    times : sequence of float
        Times τ, not negative and increasing.
    resolution : Resolution
        Fineness of rings and steps.

    Returns
    -------
    values, errors : ndarray, shape (7, times)
        Extrapolated from halved and quartered steps; how far that is from the extrapolation from
        whole and halved ones.
    """
    problem = _resolved(load_ratio, limit_ratio, resolution, growth)
    whole, halved, quartered = (
        _march_in_time(problem, times, resolution.step, parts) for parts in (1, 2, 4)
    )
    values = 2.0 * quartered - halved
    return values, np.abs(values - (2.0 * halved - whole))


def worn_rings(load_ratio: float, time: float, resolution: Resolution) -> tuple[FloatArray, ...]:
    """Radii and wear depths of an elastic sphere at the time τ, in units of a and a²/R.

    The depths are extrapolated from whole and halved steps.
    """
    problem = _resolved(load_ratio, math.inf, resolution, 0.0)
    steps = math.ceil(time / resolution.step)
    whole, halved = (_worn(problem, time, count) for count in (steps, 2 * steps))
    return problem.rings.radii, 2.0 * halved - whole


def _worn(problem: SmoothWear, time: float, steps: int) -> FloatArray:
    state = problem.unworn()
    for _ in range(steps):
        state = problem.advance(state, time / steps)
    return state.wear


def _resolved(
    load_ratio: float, limit_ratio: float, resolution: Resolution, growth: float
) -> SmoothWear:
    """The problem on rings as fine as asked where its stick edge passes."""
    edge = math.cbrt(1.0 - load_ratio)
    # the pressure under P* cannot exceed the limit, so the stick disc cannot be smaller than this
    swept = min(edge, math.sqrt(2.0 / 3.0 * (1.0 - load_ratio) / limit_ratio))
    rings = graded_rings(
        edge,
        swept,
        outer=8.0,
        narrowest=resolution.edge_width,
        narrow=resolution.swept_width,
        widest=resolution.widest,
    )
    return SmoothWear(rings, load_ratio, limit_ratio, growth)


def _march_in_time(
    problem: SmoothWear, times: Sequence[float], longest: float, parts: int
) -> FloatArray:
    """Values at each time, the same steps divided into ``parts``."""
    state, now, values = problem.unworn(), 0.0, []
    for time in times:
        steps = parts * math.ceil((time - now) / longest)
        for _ in range(steps):
            state = problem.advance(state, (time - now) / steps)
        now = time
        values.append(problem.measure(state))
    return np.array(values).T
