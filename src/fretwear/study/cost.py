"""What a case costs: cells, time and memory, from a model with its constants in one place."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

from fretwear.mechanics.surfaces import Indenter
from fretwear.study.case import Case

# Calibrated with `python -m benchmarks.cost`, which reports how well they hold.
SECONDS_TO_START = 1.3
SECONDS_PER_CASE = 0.1
SECONDS_PER_CONVOLUTION = 1.6e-4
SECONDS_PER_CELL_AND_CONVOLUTION = 2.7e-8
SECONDS_PER_CONVOLUTION_OF_LINE = 2e-3
SECONDS_PER_CUBED_CELL_OF_STROKE = 1e-9
SECONDS_PER_CUBED_CELL_OF_SCAR = 1.3e-12

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

# On rings, whose steps are held to a quarter of the tolerance.
TIGHTER_ON_RINGS = 4.0
STEPS_PER_YIELDING_TIME_ON_RINGS = 0.9
SOLUTIONS_PER_STEP = 8.0
SOLUTIONS_PER_YIELDING_STEP = 5.0
SOLUTIONS_PER_NARROWNESS = 6.5
SECONDS_PER_SOLUTION = 2.5e-4

# A solution on a third or half of the rings or strips, relative to one on all.
DENSE_COARSER = 0.35

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
    """The expected cost of a case."""

    # Cells of the largest window along x and y: those computed or, on rings, those written.
    cells_x: int
    cells_y: int
    # Steps, and half-space convolutions or solutions on rings in all of them.
    steps: float
    convolutions: float
    seconds: float  # time on one core
    memory_bytes: int  # memory while it runs
    file_bytes: int  # size of its file

    @property
    def cells(self) -> int:
        """Cells of the window at its largest."""
        return self.cells_x * self.cells_y


def estimate(case: Case) -> Estimate:
    """Estimate the cost of a case.

    The window ends a little outside the largest contact of the run: that on the way to the limiting
    worn state (`LimitingState`), widened if the stick zone shrinks, or the one that carries the
    load at the plastic limit, plus the reach of the roughness. The coarser run for error estimates
    is included.
    """
    alone = _alone(case)
    if not case.error_estimate:
        return alone
    twin = _alone(case.coarser)
    dense = DENSE_COARSER if case.is_on_rings or case.indenter.is_line else 1.0
    beside = twin.seconds - SECONDS_TO_START - SECONDS_PER_CASE
    return replace(
        alone,
        seconds=alone.seconds + dense * beside,
        memory_bytes=alone.memory_bytes + twin.memory_bytes - MEMORY_TO_START,
    )


def _alone(case: Case) -> Estimate:
    """The cost of a case without the coarser run."""
    dx, dy = case.grid_spacing
    reach = WINDOW_MARGIN * greatest_contact_radius(case)
    sides_x, sides_y = (2 - is_even for is_even in case.even)
    wide, high = (
        each / case.hertz_radius * reach for each in case.indenter.half_widths(case.hertz)
    )
    cells_x, cells_y = sides_x * math.ceil(wide / dx), sides_y * math.ceil(high / dy)
    if case.indenter.is_line:
        cells_y = 1
    cells = cells_x * cells_y
    # The window grows with the contact, from about the unworn one.
    unworn = sides_x * sides_y * (WINDOW_MARGIN * case.hertz_radius) ** 2
    first = min(cells, unworn / (dx * dy))
    seconds_each = SECONDS_PER_CONVOLUTION + SECONDS_PER_CELL_AND_CONVOLUTION * 0.5 * (
        first + cells
    )
    if case.indenter.is_line:
        seconds_each = SECONDS_PER_CONVOLUTION_OF_LINE
    work, padded_bytes = _work(case, cells), 4 * cells * 8
    if case.loading.stroke:
        places = 1.0 + max(4.0, 2.0 * case.loading.stroke / case.hertz_radius)
        seconds_each = SECONDS_PER_CUBED_CELL_OF_STROKE * places * cells_x**3
        if not case.indenter.is_line:
            cells_y = math.ceil(WINDOW_MARGIN * case.scar_half_width / dy)
            cells = cells_x * cells_y
            closed = 0.5 * math.pi * case.scar_half_width**2 / (dx * dy)
            seconds_each = SECONDS_PER_CUBED_CELL_OF_SCAR * places * closed**3
            padded_bytes = int((places * closed**2 + 6 * cells * cells_y) * 8) // (
                ARRAYS_OF_PADDED_WINDOW
            )
    if case.is_on_rings:
        work, seconds_each, padded_bytes = _work_on_rings(case), SECONDS_PER_SOLUTION, 0
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
    """Expected numbers of steps and of half-space convolutions.

    The steps of an elastic run grow with the wear: the pressure p0 wears a cell e-fold in
    1/(β p0) cycles, β = 4 K_w µ κ, and from fold to fold the steps may be longer. Where the bodies
    yield a step lasts no longer than wear takes to free a cell at the limit, 1/(β p_lim) cycles at
    the default tolerance, unless slip does not follow the worn shape.
    """
    rough = case.rough is not None
    growth = case.wear_growth
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


def _work_on_rings(case: Case) -> _Work:
    """As `_work`; the narrower the slip annulus, the more flow and wear have to settle in turn."""
    finer = TIGHTER_ON_RINGS * 0.01 / case.tolerance
    folds = math.log2(1.0 + case.cycles * case.wear_growth * case.hertz_pressure)
    elastic = STEPS_TO_BEGIN + STEPS_PER_FOLD_OF_WEAR * folds * finer ** (1.0 / 3.0)
    if not _stick_shrinks(case):
        return _Work(elastic, SOLUTIONS_PER_STEP * elastic)
    times = case.cycles * case.wear_growth * case.plastic_limit
    yielding = STEPS_PER_YIELDING_TIME_ON_RINGS * times * finer**0.5
    each = SOLUTIONS_PER_NARROWNESS / math.sqrt(case.tangential_ratio)
    each += SOLUTIONS_PER_YIELDING_STEP
    return _Work(elastic + yielding, SOLUTIONS_PER_STEP * elastic + each * yielding)


def greatest_contact_radius(case: Case) -> float:
    """Return an upper bound, m, of the contact radius during a run."""
    if case.loading.stroke:
        return case.scar_half_width + case.loading.stroke
    kind = type(case.indenter)
    # Where a displacement is imposed the tangential load falls as the contact wears.
    ratio = case.tangential_ratio if case.force_is_held else min(case.tangential_ratio, 0.95)
    limiting = _limiting_radius_ratio(kind, round(ratio, 4))  # type: ignore[arg-type]
    folds = case.cycles * case.wear_growth * case.hertz_pressure
    worn = 1.0 + (limiting - 1.0) * -math.expm1(-folds / FOLDS_TO_LIMITING_STATE)
    if _stick_shrinks(case):
        yielding = case.cycles * case.wear_growth * case.plastic_limit
        worn *= (1.0 + yielding / YIELDING_TIMES_TO_WIDEN) ** WIDENING
    full_plastic = case.hertz.spread_radius(case.plastic_limit)
    rough = 0.0
    if case.rough is not None:
        # Tips can touch as far out as the sphere has receded by the height of the waves.
        rough = 2.0 * case.indenter.curvature_radius * case.rough.tips
    return math.sqrt(max(case.hertz_radius * worn, full_plastic) ** 2 + rough)


def _stick_shrinks(case: Case) -> bool:
    """Whether the stick edge yields and slip follows it: then the contact widens without bound."""
    return math.isfinite(case.plastic_limit) and case.slip_model.follows_shape


@lru_cache(maxsize=4096)
def _limiting_radius_ratio(indenter: type[Indenter], load_ratio: float) -> float:
    """Return a∞/a, the relative contact radius of smooth elastic bodies in the limit of wear."""
    unworn = indenter.smooth(radius=1.0, load=1.0, composite_modulus=1.0)
    limiting = indenter.limiting(unworn, min(load_ratio, 0.9999))
    return limiting.contact_radius / unworn.contact_radius
