"""What a case takes: cells, time and memory, from a model with constants in one place."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

from fretwear.study.case import Case

# Calibrated against the cases of studies/demo.yaml, each alone on one core.
SECONDS_PER_CELL_AND_CONVOLUTION = 4.0e-8
SECONDS_PER_CONVOLUTION = 3.0e-4
CONVOLUTIONS = 500.0
CONVOLUTIONS_ROUGH = 1400.0
CONVOLUTIONS_PER_YIELDING_STEP = 60.0
CONVOLUTIONS_PER_YIELDING_STEP_ROUGH = 95.0
SECONDS_TO_START = 2.0

WINDOW_MARGIN = 1.15
MEMORY_TO_START = 150_000_000
ARRAYS_OF_PADDED_WINDOW = 25
BYTES_PER_FIELD_CELL = 7 * 4 + 1
COMPRESSION = 0.6


@dataclass(frozen=True)
class Estimate:
    """What a case is expected to take.

    Attributes
    ----------
    cells_x, cells_y : int
        Cells of the quarter window at its largest, along x and y.
    seconds : float
        Time on one core.
    memory_bytes : int
        Memory while it runs.
    file_bytes : int
        Size of its file.
    """

    cells_x: int
    cells_y: int
    seconds: float
    memory_bytes: int
    file_bytes: int

    @property
    def cells(self) -> int:
        """Cells of the quarter window at its largest."""
        return self.cells_x * self.cells_y


def estimate(case: Case) -> Estimate:
    """Estimate what a case takes.

    The window ends a little outside of the largest contact that the run can come to: that of
    the limiting worn state (`limiting_radius_ratio`), or the one that carries the load at the
    plastic limit, whichever is larger, plus the reach of the roughness.
    """
    dx, dy = case.grid_spacing
    reach = WINDOW_MARGIN * greatest_contact_radius(case)
    cells_x, cells_y = math.ceil(reach / dx), math.ceil(reach / dy)
    cells = cells_x * cells_y
    seconds_each = SECONDS_PER_CONVOLUTION + SECONDS_PER_CELL_AND_CONVOLUTION * cells
    padded_bytes = 4 * cells * 8
    snapshots = len(case.output_cycles)
    return Estimate(
        cells_x=cells_x,
        cells_y=cells_y,
        seconds=SECONDS_TO_START + seconds_each * _convolutions(case),
        memory_bytes=MEMORY_TO_START + ARRAYS_OF_PADDED_WINDOW * padded_bytes,
        file_bytes=int(COMPRESSION * BYTES_PER_FIELD_CELL * cells * snapshots) + 100_000,
    )


def _convolutions(case: Case) -> float:
    """Expected number of half-space convolutions of a run.

    An elastic run takes few steps whatever its length.  Where the bodies yield, a step lasts no
    longer than wear takes to free a cell at the limit: 1/(β p_lim) cycles, β = 4 K_w µ κ, at the
    default tolerance, and in proportion to the root of the tolerance otherwise.
    """
    rough = case.roughness is not None
    expected = CONVOLUTIONS_ROUGH if rough else CONVOLUTIONS
    if math.isfinite(case.plastic_limit):
        growth = 4.0 * case.wear_coefficient * case.friction * case.coupling
        steps = case.cycles * growth * case.plastic_limit * math.sqrt(0.01 / case.tolerance)
        each = CONVOLUTIONS_PER_YIELDING_STEP_ROUGH if rough else CONVOLUTIONS_PER_YIELDING_STEP
        expected += each * steps
    return expected


def greatest_contact_radius(case: Case) -> float:
    """Return an upper estimate in m of the radius of contact at any time of a run."""
    worn = case.hertz_radius * limiting_radius_ratio(round(case.load_ratio, 4))
    full_plastic = math.sqrt(case.load / (math.pi * case.plastic_limit))
    rough = 0.0
    if case.roughness is not None:
        # Tips reach out to where the sphere has fallen back by the height of the waves.
        rough = 2.0 * case.radius * case.roughness.amplitude
    return math.sqrt(max(worn, full_plastic) ** 2 + rough)


@lru_cache(maxsize=4096)
def limiting_radius_ratio(load_ratio: float) -> float:
    """Return a∞/a, the contact radius after infinitely many cycles of a smooth elastic sphere.

    The worn shape outside of the stick radius c is the gap of a flat-ended punch under the whole
    load, with lengths in a and heights in a²/R,
    f∞(r) = (1/π)[r² asin(c/r) − c√(r²−c²)] + d∞[1 − (2/π) asin(c/r)],  d∞ = 2/(3c) + c²/3,
    and contact ends where f∞ = r²/2.

    >>> round(limiting_radius_ratio(0.5), 4)
    1.1361
    """
    stick = math.cbrt(max(1e-4, 1.0 - load_ratio))
    approach = 2.0 / (3.0 * stick) + stick**2 / 3.0

    def excess(radius: float) -> float:
        angle = math.asin(stick / radius)
        root = math.sqrt(radius**2 - stick**2)
        worn = (radius**2 * angle - stick * root) / math.pi
        return worn + approach * (1.0 - 2.0 * angle / math.pi) - 0.5 * radius**2

    # Near r = c the excess starts below zero; at r = 1 Hertz contact has worn, so it is above.
    inside, outside = 1.0, 10.0
    for _ in range(60):
        middle = 0.5 * (inside + outside)
        inside, outside = (middle, outside) if excess(middle) > 0.0 else (inside, middle)
    return inside
