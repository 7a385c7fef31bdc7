"""What a case takes: cells, time and memory, from a model with constants in one place."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

from fretwear.study.case import Case

# Calibrated with `python -m benchmarks.cost`, which says how well they hold.
SECONDS_TO_START = 1.3
SECONDS_PER_CASE = 0.1
SECONDS_PER_CONVOLUTION = 1.6e-4
SECONDS_PER_CELL_AND_CONVOLUTION = 2.7e-8

STEPS_TO_BEGIN = 2.0
STEPS_PER_FOLD_OF_WEAR = 2.4
STEPS_ROUGH = 1.6
STEPS_PER_YIELDING_TIME = 0.7

# Of a window of ten thousand cells; iterations grow slowly with their number.
CONVOLUTIONS_PER_STEP = 17.5
CONVOLUTIONS_PER_STEP_ROUGH = 27.0
CONVOLUTIONS_AS_YIELDING_BEGINS = 135.0
CONVOLUTIONS_AS_YIELDING_BEGINS_ROUGH = 210.0
GROWTH_WITH_CELLS = 0.2

WINDOW_MARGIN = 1.15
FOLDS_TO_LIMITING_STATE = 8.0
YIELDING_TIMES_TO_WIDEN = 50.0
WIDENING = 0.36
MEMORY_TO_START = 165_000_000
ARRAYS_OF_PADDED_WINDOW = 18
MEMORY_PER_CELL_OF_SNAPSHOT = 110
BYTES_PER_FIELD_CELL = 7 * 4 + 1
COMPRESSION = 0.6


@dataclass(frozen=True)
class Estimate:
    """What a case is expected to take.

    Attributes
    ----------
    cells_x, cells_y : int
        Cells of the quarter window at its largest, along x and y.
    steps, convolutions : float
        Steps over the cycles, and half-space convolutions of all of them.
    seconds : float
        Time on one core.
    memory_bytes : int
        Memory while it runs.
    file_bytes : int
        Size of its file.
    """

    cells_x: int
    cells_y: int
    steps: float
    convolutions: float
    seconds: float
    memory_bytes: int
    file_bytes: int

    @property
    def cells(self) -> int:
        """Cells of the quarter window at its largest."""
        return self.cells_x * self.cells_y


def estimate(case: Case) -> Estimate:
    """Estimate what a case takes.

    The window ends a little outside of the largest contact that the run comes to: on its way to
    the limiting worn state (`limiting_radius_ratio`), widened where the stick zone shrinks, or the
    one that carries the load at the plastic limit, plus the reach of the roughness.
    """
    dx, dy = case.grid_spacing
    reach = WINDOW_MARGIN * greatest_contact_radius(case)
    cells_x, cells_y = math.ceil(reach / dx), math.ceil(reach / dy)
    cells = cells_x * cells_y
    # The window grows with the contact, from about the unworn one.
    first = min(cells, (WINDOW_MARGIN * case.hertz_radius) ** 2 / (dx * dy))
    seconds_each = SECONDS_PER_CONVOLUTION + SECONDS_PER_CELL_AND_CONVOLUTION * 0.5 * (
        first + cells
    )
    work = _work(case, cells)
    padded_bytes = 4 * cells * 8
    snapshots = len(case.output_cycles)
    return Estimate(
        cells_x=cells_x,
        cells_y=cells_y,
        steps=work.steps,
        convolutions=work.convolutions,
        seconds=SECONDS_TO_START + SECONDS_PER_CASE + seconds_each * work.convolutions,
        memory_bytes=MEMORY_TO_START
        + ARRAYS_OF_PADDED_WINDOW * padded_bytes
        + MEMORY_PER_CELL_OF_SNAPSHOT * cells * snapshots,
        file_bytes=int(COMPRESSION * BYTES_PER_FIELD_CELL * cells * snapshots) + 100_000,
    )


@dataclass(frozen=True)
class _Work:
    steps: float
    convolutions: float


def _work(case: Case, cells: int) -> _Work:
    """Expected steps over the cycles and half-space convolutions of all of them.

    The steps of an elastic run grow with the wear: the pressure p0 wears a cell e-fold in
    1/(β p0) cycles, β = 4 K_w µ κ, and from fold to fold the steps may be longer. Where the bodies
    yield a step lasts no longer than wear takes to free a cell at the limit, 1/(β p_lim) cycles at
    the default tolerance, unless slip does not follow the worn shape.
    """
    rough = case.roughness is not None
    growth = _wear_growth(case)
    folds = math.log2(1.0 + case.cycles * growth * case.hertz_pressure)
    finer = 0.01 / case.tolerance
    elastic = STEPS_TO_BEGIN + STEPS_PER_FOLD_OF_WEAR * folds * finer ** (1.0 / 3.0)
    elastic *= STEPS_ROUGH if rough else 1.0
    larger = (cells / 1e4) ** GROWTH_WITH_CELLS
    each = CONVOLUTIONS_PER_STEP_ROUGH if rough else CONVOLUTIONS_PER_STEP
    if not _stick_shrinks(case):
        return _Work(elastic, each * larger * elastic)
    yielding = STEPS_PER_YIELDING_TIME * case.cycles * growth * case.plastic_limit
    first = CONVOLUTIONS_AS_YIELDING_BEGINS_ROUGH
    if not rough:
        first = CONVOLUTIONS_AS_YIELDING_BEGINS
    # The later a step, and the shorter, the less changes in it and the fewer iterations it takes.
    flowing = first * yielding**0.7 * finer**0.2
    return _Work(elastic + yielding * finer**0.5, larger * each * elastic + flowing)


def greatest_contact_radius(case: Case) -> float:
    """Return an upper estimate in m of the radius of contact at any time of a run."""
    limiting = limiting_radius_ratio(round(case.load_ratio, 4))
    folds = case.cycles * _wear_growth(case) * case.hertz_pressure
    worn = 1.0 + (limiting - 1.0) * -math.expm1(-folds / FOLDS_TO_LIMITING_STATE)
    if _stick_shrinks(case):
        yielding = case.cycles * _wear_growth(case) * case.plastic_limit
        worn *= (1.0 + yielding / YIELDING_TIMES_TO_WIDEN) ** WIDENING
    full_plastic = math.sqrt(case.load / (math.pi * case.plastic_limit))
    rough = 0.0
    if case.roughness is not None:
        # Tips reach out to where the sphere has fallen back by the height of the waves.
        rough = 2.0 * case.radius * case.roughness.amplitude
    return math.sqrt(max(case.hertz_radius * worn, full_plastic) ** 2 + rough)


def _wear_growth(case: Case) -> float:
    """Return β = 4 K_w µ κ: a pressure p wears e-fold in 1/(β p) cycles."""
    return 4.0 * case.wear_coefficient * case.friction * case.coupling


def _stick_shrinks(case: Case) -> bool:
    """Whether the edge of stick yields and slip follows: then the contact widens without end."""
    return math.isfinite(case.plastic_limit) and case.slip_model == "jaeger"


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
