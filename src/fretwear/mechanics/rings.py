"""Axisymmetric contact of an elastic half-space, discretised by rings of uniform pressure.

Small dense systems solved directly: a reference to check faster solvers against.

References
----------
K. L. Johnson (1985), Contact Mechanics, Cambridge University Press, section 3.4 (the displacement
of a uniform pressure on a disc).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import solve
from scipy.special import ellipe, ellipkm1

__all__ = ["RingContact", "Rings", "disc_displacement", "graded_rings", "solve_contact"]

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
        beyond = max(distance - (edge - swept), 0.0)
        return min(
            max(INWARD_GRADING * distance, narrowest), narrow + OUTWARD_GRADING * beyond, widest
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
    rings: Rings, layer: Layer, load: float, limit: float, start: RingContact
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
        yields = np.where(yielding, gap <= 0.0, loaded & (pressure > limit))
        settled = np.array_equal(carries, loaded) and np.array_equal(yields, yielding)
        if settled and np.all(np.abs(gap[free]) < 1e-11):
            return RingContact(pressure, gap, approach, loaded, yielding)
        loaded, yielding = carries, yields
    raise RuntimeError(
        f"the contact of {rings.radii.size} rings did not settle; refine the rings or the step"
    )
