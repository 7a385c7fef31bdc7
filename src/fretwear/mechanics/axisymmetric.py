"""Wear of a smooth sphere in partial slip, on rings: an independent reference for the 3-D solver.

Nothing is shared with the solver on rectangular cells but the physics. Space is divided into rings,
fine where the stick edge passes; time into small backward steps, and what is reported is
extrapolated to vanishing steps. The reduced-load problem of Ciavarella (1998) and Jäger (1998)
gives the slip, Archard's law the wear; where the pressure reaches the plastic limit the shape sinks
for good.

`wear_history` is in SI units, `dimensionless_history` in those of `smooth_wear`.

References
----------
M. Ciavarella (1998), The generalized Cattaneo partial slip plane contact problem,
Int. J. Solids Struct. 35, 2349–2362.
J. Jäger (1998), A new principle in contact mechanics, J. Tribol. 120, 677–684.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fretwear.mechanics.rings import graded_rings
from fretwear.mechanics.smooth_wear import UNIT_HERTZ, SmoothWear, WearState
from fretwear.theory import CattaneoMindlin, require_positive

__all__ = [
    "UNIT_HERTZ",
    "Resolution",
    "SmoothWear",
    "WearHistory",
    "WearState",
    "dimensionless_history",
    "wear_history",
]

FloatArray = NDArray[np.float64]


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


@dataclass(frozen=True, eq=False)
class WearHistory:
    """A smooth sphere over the cycles; every array has the shape (cycles,).

    Parameters
    ----------
    cycles : ndarray
        Numbers of cycles.
    approach, central_pressure, deepest_wear : ndarray
        Approach in m, pressure on the axis in Pa, largest wear of both bodies together in m.
    wear_volume, plastic_volume : ndarray
        Volumes worn off both bodies and of the plastic sinking, m³.
    contact_radius, stick_radius : ndarray
        Radii, m.
    """

    cycles: FloatArray
    approach: FloatArray
    central_pressure: FloatArray
    deepest_wear: FloatArray
    wear_volume: FloatArray
    plastic_volume: FloatArray
    contact_radius: FloatArray
    stick_radius: FloatArray


def dimensionless_history(
    load_ratio: float, limit_ratio: float, times: Sequence[float], resolution: Resolution
) -> tuple[FloatArray, FloatArray]:
    """Values of `WearHistory` after the cycles at the times τ, and the error left by the steps.

    Parameters
    ----------
    load_ratio, limit_ratio : float
        Q / µP, and the largest pressure over p0.
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
    problem = SmoothWear(rings, load_ratio, limit_ratio)
    whole, halved, quartered = (
        _march_in_time(problem, times, resolution.step, parts) for parts in (1, 2, 4)
    )
    values = 2.0 * quartered - halved
    return values, np.abs(values - (2.0 * halved - whole))


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


def wear_history(
    slip: CattaneoMindlin,
    wear_coefficient: float,
    plastic_limit: float,
    cycles: Sequence[float],
    resolution: Resolution | None = None,
) -> tuple[WearHistory, WearHistory]:
    """Wear of a smooth sphere over the cycles, elastic or elastic–perfectly plastic.

    Parameters
    ----------
    slip : CattaneoMindlin
        The unworn contact in partial slip.
    wear_coefficient : float
        Archard's wear coefficient K_w of both bodies together, 1/Pa.
    plastic_limit : float
        Largest pressure, Pa; infinite for elastic bodies.
    cycles : sequence of float
        Numbers of cycles to report, not negative and increasing.
    resolution : Resolution, optional
        Fineness of rings and steps.

    Returns
    -------
    history, error : WearHistory
        The history, and the part of its error that comes from the steps, in the same units. The
        rings' part shows when they are made finer.

    Raises
    ------
    ValueError
        If the wear coefficient or the limit is not positive, or the cycles do not increase.
    """
    require_positive(wear_coefficient=wear_coefficient)
    if not plastic_limit > 0.0:
        raise ValueError(f"plastic_limit is {plastic_limit!r} Pa, but must be positive or inf")
    count = np.asarray(cycles, dtype=float)
    if count.size == 0 or count[0] < 0.0 or np.any(np.diff(count) <= 0.0):
        raise ValueError(f"cycles are {cycles!r}, but must increase from 0 or more")
    hertz = slip.hertz
    p0, a, depth = hertz.peak_pressure, hertz.contact_radius, hertz.approach
    per_cycle = 4.0 * wear_coefficient * slip.friction * slip.coupling * p0
    values, errors = dimensionless_history(
        slip.load_ratio,
        plastic_limit / p0,
        [float(n) for n in per_cycle * count],
        resolution or Resolution(),
    )
    stress = p0 / UNIT_HERTZ.peak_pressure
    units = np.array([depth, stress, depth, a * a * depth, a * a * depth, a, a])[:, None]
    return WearHistory(count, *(units * values)), WearHistory(count, *(units * errors))
