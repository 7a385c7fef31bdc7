"""The plan of a study: its points and what each will cost, before anything is run.

The cost of a case follows from a model with its constants in one place.
"""

from __future__ import annotations

import csv
import math
from bisect import bisect_left
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.rings import Rings
from fretwear.mechanics.contact.strips import Row, Strips
from fretwear.mechanics.slip.models import Cerruti
from fretwear.mechanics.wear.laws import Archard
from fretwear.study.case import Case
from fretwear.study.doubts import Doubt, doubts
from fretwear.study.parameters import value_text
from fretwear.study.problems import as_cell
from fretwear.study.spacing import (
    LEAST_COARSENESS,
    greatest_contact_radius,
    stick_shrinks,
)
from fretwear.study.study import Point, Study
from fretwear.units import duration_text, number_text, size_text, span

# Calibrated by `python -m benchmarks.cost`, which reports how well they hold.
SECONDS_TO_START = 1.3
SECONDS_PER_CASE = 0.1
SECONDS_PER_CONVOLUTION = 2.7e-4
SECONDS_PER_CELL_AND_CONVOLUTION = 9e-9
# For the work between convolutions, and for the loop of forces at a snapshot.
SECONDS_PER_CELL_AND_STEP = 7.5e-7
SECONDS_PER_CELL_OF_LOOP = 9e-7
SECONDS_PER_CONVOLUTION_OF_LINE = 2e-3
# A run with friction in two directions over one without, on whole windows and on quarters.
TIMES_COUPLED = 5.0, 4.0
# A run whose slip knows its direction over one whose slip does not.
TIMES_DIRECTED = 1.7
SECONDS_PER_SQUARED_STRIP = 2.5e-9
MEMORY_PER_SQUARED_STRIP = 72
MEMORY_OF_GRADED = 72 * 500**2
SECONDS_PER_CUBED_CELL_OF_STROKE = 1e-9
SECONDS_PER_CUBED_CELL_OF_SCAR = 1.3e-12

STEPS_PER_ROOT_OF_SLIP_AND_WEAR = 10.7
STEPS_PER_SNAPSHOT = 2.5
STEPS_ROUGH = 1.15
STEPS_PER_YIELDING_TIME = 1.3

# Contacts of a yielding step, if shear lowers the limit, over those if it does not: at least, and
# for each unit of junction growth.
CONTACTS_UNDER_SHEAR, CONTACTS_PER_JUNCTION_GROWTH = 1.8, 0.2

# For a smooth and a rough window of ten thousand cells; iterations grow slowly with the cells.
CONVOLUTIONS_PER_STEP = (17.5, 23.0)
CONVOLUTIONS_AS_YIELDING_BEGINS = (105.0, 165.0)
GROWTH_WITH_CELLS = 0.05

# Steps on rings keep to a quarter of the tolerance.
TIGHTER_ON_RINGS = 4.0
STEPS_PER_YIELDING_TIME_ON_RINGS = 0.93
SOLUTIONS_PER_STEP = 4.9
SOLUTIONS_PER_YIELDING_TIME = 4.4
SOLUTIONS_PER_NARROWNESS = 5.6
SECONDS_PER_SOLUTION = 5.3e-4
SECONDS_PER_STEP_ON_RINGS = 2.6e-3
POWER_OF_NARROW_RINGS = 2.3
# The same of a step under a load that changes within a cycle, of which contacts are solved.
TIMES_IF_PULSATING = 20.0

# Cost of a solution on a third or half of the rings or strips, relative to all of them.
DENSE_COARSER = 0.35

WINDOW_MARGIN = 1.15
MEMORY_TO_START = 110_000_000
ARRAYS_OF_PADDED_WINDOW = 18
MEMORY_PER_CELL_OF_SNAPSHOT = 110
# Means of rings over cells, and writing them.
SECONDS_PER_CELL_OF_SNAPSHOT = 1.9e-6
# Of a file: the fields of a snapshot, compressed, twice as many if friction has two directions.
BYTES_OF_FILE, BYTES_PER_CELL_OF_SNAPSHOT = 200_000, 10

USUAL_ACCURACY, USUAL_BUDGET = 0.02, 10.0
MOST_MEMORY = 2 * 1024**3
NARROWER = 2.0**0.25  # ratio of widths between which a budget decides
_WIDTHS = [1.0]
while _WIDTHS[-1] > LEAST_COARSENESS:
    _WIDTHS.append(max(_WIDTHS[-1] / NARROWER, LEAST_COARSENESS))


class Estimate(NamedTuple):
    """The expected cost of a case."""

    # Cells of the largest window along x and y, computed or, on rings, written.
    cells_x: int
    cells_y: int
    # Steps, and half-space convolutions or, on rings, solutions of all steps.
    steps: float
    convolutions: float
    seconds: float  # time on one core
    memory_bytes: int  # memory while it runs
    snapshots: int
    snapshot_bytes: int  # memory that each of them takes
    file_bytes: int  # size of its file
    # Least and most time, s, of a case that asks for an accuracy; empty if its cells are known.
    ends: tuple[float, ...] = ()

    @property
    def cells(self) -> int:
        """Cells of the window at its largest."""
        return self.cells_x * self.cells_y


def estimate(case: Case) -> Estimate:
    """Estimate the cost of a case.

    The window ends a little outside the largest contact of the run, plus the reach of the
    roughness. This contact lies on the way to the limiting worn state (`LimitingState`), widened if
    the stick zone shrinks, or carries the load at the plastic limit. The coarser run for error
    estimates is included. A case that asks for an accuracy may end with its first run, as smooth
    elastic ones do at `USUAL_ACCURACY`; others are expected to end with default cells, and none
    takes more than its budget.
    """
    runs, start = _Runs(case), SECONDS_TO_START + SECONDS_PER_CASE
    if case.asked_accuracy is not None:
        wide = case.first_width
        widths = case.times_coarser * wide, wide, 1.0
        budget = case.budget or USUAL_BUDGET
        largest = runs.on_cells(runs.affordable_width(budget))
        beside, first, default = (runs.on_cells(width).seconds - start for width in widths)
        both = first + (default if case.has_spots else beside)
        most = both if case.has_spots else both + default
        ends = both, max(budget * default, most)
        is_smooth = case.is_graded and math.isinf(case.slip_limit)
        ends_early = is_smooth and case.asked_accuracy >= USUAL_ACCURACY
        return runs.on_cells(1.0)._replace(
            seconds=start + (both if ends_early else most),
            ends=tuple(start + end for end in ends),
            memory_bytes=largest.memory_bytes,
            snapshot_bytes=largest.snapshot_bytes,
        )
    alone = runs.alone(1.0, case.coarseness)
    if not case.error_estimate:
        return alone
    times = case.times_coarser
    twin = runs.alone(times, case.coarseness_on(times))
    dense = DENSE_COARSER if case.geometry is not Grid else 1.0
    return alone._replace(
        seconds=alone.seconds + dense * (twin.seconds - start),
        memory_bytes=alone.memory_bytes + twin.memory_bytes - MEMORY_TO_START,
        snapshot_bytes=alone.snapshot_bytes + twin.snapshot_bytes,
    )


def affordable_width(case: Case, budget: float) -> float:
    """Width of the narrowest cells over the default within a budget and `MOST_MEMORY`.

    The budget is the time of a run relative to default cells, expected before any has run.
    """
    return _Runs(case).affordable_width(budget)


class _Runs:
    """Runs of a case without their coarser runs; what is the same on all cells is found once."""

    def __init__(self, case: Case) -> None:
        self.case, self._by_width = case, dict[float, Estimate]()
        self._on_rings = issubclass(case.geometry, Rings)
        self._dx, self._dy = case.grid_spacing
        reach = WINDOW_MARGIN * greatest_contact_radius(case) / case.hertz_radius
        wide, high = case.indenter.half_widths(case.hertz)
        self._reach_x, self._reach_y = wide * reach, high * reach
        self._sides_x, self._sides_y = (2 - is_even for is_even in case.even)
        self._snapshots = len(case.output_cycles)
        self._contacts = 1.0
        if case.slip_limit < case.plastic_limit:
            growth = CONTACTS_PER_JUNCTION_GROWTH * case.junction_growth
            self._contacts = CONTACTS_UNDER_SHEAR + growth
        worn, ratio = case.cycles * case.wear_growth, case.tangential_ratio
        root = math.sqrt(math.log2(1.0 + worn * case.hertz_pressure) * min(ratio, 1.0))
        self._wearing = STEPS_PER_ROOT_OF_SLIP_AND_WEAR * root
        if case.rough is not None:
            self._wearing *= STEPS_ROUGH
        between = max(self._snapshots - 2, 0)
        self._at_snapshots = STEPS_PER_SNAPSHOT * min(root, 1.0) * between
        self._yielding_times = worn * case.slip_limit if stick_shrinks(case) else 0.0
        # The narrower the slip annulus, the more often flow and wear settle in turn.
        self._narrow = SOLUTIONS_PER_NARROWNESS / math.sqrt(ratio)

    def on_cells(self, width: float) -> Estimate:
        """The cost of a run on cells of a width over the default."""
        if (cost := self._by_width.get(width)) is None:
            case = self.case
            cost = self.alone(width, width * case.coarseness if case.is_graded else 1.0)
            self._by_width[width] = cost
        return cost

    def affordable_width(self, budget: float) -> float:
        """Width of the narrowest cells over the default, as for `affordable_width`."""
        usual = self.on_cells(1.0)
        start, most = SECONDS_TO_START + SECONDS_PER_CASE, max(MOST_MEMORY, usual.memory_bytes)
        allowed = start + budget * (usual.seconds - start)

        def is_beyond(width: float) -> bool:
            expected = self.on_cells(width)
            return expected.seconds > allowed or expected.memory_bytes > most

        # Narrower cells never take less.
        return _WIDTHS[bisect_left(_WIDTHS, True, lo=1, key=is_beyond) - 1]

    def alone(self, width: float, coarseness: float) -> Estimate:
        """The cost of a run on cells that are `width` times as wide as the case's.

        Graded rings and strips have a `coarseness` of their own.
        """
        case, sides_x, sides_y = self.case, self._sides_x, self._sides_y
        stroke, geometry = case.loading.stroke, case.geometry
        wider = case.times_written(width)
        dx, dy = wider * self._dx, wider * self._dy
        cells_x = sides_x * math.ceil(self._reach_x / dx)
        cells_y = 1 if geometry in (Strips, Row) else sides_y * math.ceil(self._reach_y / dy)
        steps, convolutions = self._work(cells_x * cells_y, case.tolerance_on(width))
        if stroke and geometry is Grid:
            cells_y = math.ceil(WINDOW_MARGIN * case.scar_half_width / dy)
        cells = cells_x * cells_y
        arrays, per_step = 8 * 4 * ARRAYS_OF_PADDED_WINDOW * cells, 0.0
        if self._on_rings:
            per_convolution, arrays = SECONDS_PER_SOLUTION, 0
            per_step = SECONDS_PER_STEP_ON_RINGS
        elif stroke:
            places = 1.0
            if case.loading.travel > case.small_stroke:
                places += sides_x * max(4.0, 2.0 * stroke / case.hertz_radius)
            if geometry is Strips:
                cubed = sides_x * (cells_x / sides_x) ** 3
                per_convolution = SECONDS_PER_CUBED_CELL_OF_STROKE * places * cubed
            else:
                closed = 0.5 * math.pi * case.scar_half_width**2 / (dx * dy)
                per_convolution = SECONDS_PER_CUBED_CELL_OF_SCAR * places * closed**3
                arrays = 8 * int(places * closed**2 + 6 * cells * cells_y)
        elif geometry in (Strips, Row):
            # Rough and uneven contacts have matrices, for strips of equal width.
            squared = cells_x**2 if case.rough is not None or geometry is Row else 0
            per_convolution = max(
                SECONDS_PER_CONVOLUTION_OF_LINE, SECONDS_PER_SQUARED_STRIP * squared
            )
            arrays += MEMORY_PER_SQUARED_STRIP * squared
        else:
            # The window grows with the contact, starting near its unworn size.
            unworn = sides_x * sides_y * (WINDOW_MARGIN * case.hertz_radius) ** 2 / (dx * dy)
            mean = 0.5 * (min(cells, unworn) + cells)
            per_convolution = SECONDS_PER_CONVOLUTION + SECONDS_PER_CELL_AND_CONVOLUTION * mean
            per_step = SECONDS_PER_CELL_AND_STEP * mean
            if case.slip_model.couples:
                per_convolution *= TIMES_COUPLED[all(case.even)]
            elif isinstance(case.slip_model, Cerruti) and case.coupling != 1.0:
                per_convolution *= TIMES_DIRECTED
        if case.normal.pulsating_load < 1.0 and not stroke:
            per_convolution *= TIMES_IF_PULSATING
        if coarseness != 1.0:  # a finer cell narrows rings and strips
            per_convolution *= coarseness**-POWER_OF_NARROW_RINGS
            arrays += int((coarseness**-2 - 1.0) * MEMORY_OF_GRADED)
        kept, per_cell = cells * self._snapshots, 0.0
        if self._on_rings:
            per_cell = SECONDS_PER_CELL_OF_SNAPSHOT
        elif geometry is Grid and case.slip_model.follows_shape:
            per_cell = SECONDS_PER_CELL_OF_LOOP
        working = per_convolution * convolutions + per_step * steps + per_cell * kept
        return Estimate(
            cells_x=cells_x,
            cells_y=cells_y,
            steps=steps,
            convolutions=convolutions,
            seconds=SECONDS_TO_START + SECONDS_PER_CASE + working,
            memory_bytes=MEMORY_TO_START + arrays + MEMORY_PER_CELL_OF_SNAPSHOT * kept,
            snapshots=self._snapshots,
            snapshot_bytes=MEMORY_PER_CELL_OF_SNAPSHOT * cells,
            file_bytes=BYTES_OF_FILE
            + BYTES_PER_CELL_OF_SNAPSHOT * kept * (1 + case.slip_model.couples),
        )

    def _work(self, cells: int, tolerance: float) -> tuple[float, float]:
        """Expected numbers of steps, and of half-space convolutions or solutions on rings.

        The steps of an elastic run grow with the wear and the slip: the pressure p0 wears a cell
        e-fold in 1/(β p0) cycles, β = 4 K_w µ κ, and from fold to fold the steps may be longer. A
        step ends at each snapshot, and the next ones are short while the contact wears. If the
        bodies yield and slip follows the worn shape, a step lasts no longer than wear takes to free
        a cell at the limit p, 1/(β p) cycles at the default tolerance.
        """
        times = self._yielding_times
        finer = (TIGHTER_ON_RINGS if self._on_rings else 1.0) * 0.01 / tolerance
        elastic = self._wearing * finer**0.18 + self._at_snapshots
        elastic = max(elastic, self._snapshots - 1)
        if self._on_rings:
            convolutions = SOLUTIONS_PER_STEP * elastic
            if times == 0.0:
                return elastic, convolutions
            yielding = STEPS_PER_YIELDING_TIME_ON_RINGS * times * finer**0.5
            flowing = (self._narrow + SOLUTIONS_PER_YIELDING_TIME) * times * finer**0.28
        else:
            is_rough = self.case.rough is not None
            larger = (cells / 1e4) ** GROWTH_WITH_CELLS
            convolutions = CONVOLUTIONS_PER_STEP[is_rough] * elastic * larger
            if times == 0.0:
                return elastic, convolutions
            yielding = STEPS_PER_YIELDING_TIME * times * finer**0.5
            # Later and shorter steps change less and take fewer iterations.
            flowing = CONVOLUTIONS_AS_YIELDING_BEGINS[is_rough] * times**0.7 * finer**0.2
        # The shorter of both kinds of step is taken.
        return math.hypot(elastic, yielding), convolutions + self._contacts * flowing


@dataclass
class PlannedCases:
    """Estimates, doubts with their details, wear coefficients and Dundurs' β of all cases."""

    estimates: dict[str, Estimate] = field(default_factory=dict)
    doubts: dict[str, tuple[Doubt, dict[str, str]]] = field(default_factory=dict)
    wear: set[float] = field(default_factory=set)
    betas: set[float] = field(default_factory=set)

    def add(self, point: Point) -> None:
        """Plan the case of a point, unless another point shares it."""
        if (case := point.case) is None or (case_id := point.id) in self.estimates:
            return
        cost = estimate(case)
        added = sum(part.seconds(case, cost.cells) for part in point.study.added.values())
        cost = cost._replace(seconds=cost.seconds + added)
        self.estimates[case_id] = cost
        for doubt in doubts(case):
            _, details = self.doubts.setdefault(doubt.what, (doubt, {}))
            details[case_id] = doubt.detail
        if isinstance(case.wear_law, Archard):
            self.wear.add(case.wear_law.coefficient(case.friction_law))
        self.betas.add(case.bodies.dundurs_beta)


@dataclass(frozen=True)
class Plan:
    """The points of a study in order, with estimates."""

    study: Study
    #: Its cases, if they were planned while the study was read.
    planned: PlannedCases | None = None

    @property
    def points(self) -> tuple[Point, ...]:
        """The points, the last varied parameter fastest."""
        return self.study.points()

    @property
    def estimates(self) -> Mapping[str, Estimate]:
        """Estimates by case id, each case once."""
        return self._of_cases.estimates

    @property
    def doubts(self) -> Mapping[Doubt, Mapping[str, str]]:
        """Reasons to doubt results, with the cases of each: details by case id."""
        return dict(self._of_cases.doubts.values())

    @cached_property
    def _of_cases(self) -> PlannedCases:
        """What is planned of all cases; each is made once and not kept, for it takes kilobytes."""
        if self.planned is not None:
            return self.planned
        planned = PlannedCases()
        for point in self.points:
            planned.add(point)
        return planned

    @property
    def memory_bytes(self) -> int:
        """Memory of the largest case."""
        return max(cost.memory_bytes for cost in self.estimates.values())

    @property
    def file_bytes(self) -> int:
        """Size of all case files."""
        return sum(cost.file_bytes for cost in self.estimates.values())

    def derived(self) -> Iterator[tuple[str, str]]:
        """Iterate over what the study leaves out, and derived quantities: words and value."""
        given = {*self.study.fixed, *(axis.key for axis in self.study.axes)}
        left = [n for n in ("roughness", "plastic_limit") if n not in given]
        if left:
            words = (f"{name} ({value_text(name, getattr(Case, name) or 'none')})" for name in left)
            yield "not given", ", ".join(words)
        # A pair [indenter, flat] counts as the wear of both together.
        if wear := self._of_cases.wear:
            text = span(wear, lambda value: number_text(1e9 * value, 4))
            yield "wear volume per load and sliding distance", f"{text} mm³/(N m)"
        if any(betas := self._of_cases.betas):
            yield "Dundurs' β of the two materials", span(betas, lambda beta: number_text(beta, 2))

    def header(self) -> tuple[str, ...]:
        """Return the titles of the columns of `rows`."""
        names = (axis.name for axis in self.study.axes)
        return ("id", *names, "cells", "time", "memory")

    def rows(
        self, first: int = 0, last: int | None = None, speed: float = 1.0
    ) -> Iterator[tuple[str, ...]]:
        """Iterate over a slice of the points as text, varied values in the words of the file.

        Times are for a machine of some speed, from `fretwear.run.resources`.
        """
        for point in self.points[first:last]:
            labels = point.labels.values()
            if point.case is None:
                yield ("(invalid)", *labels, "-", "-", point.problem)
                continue
            cost = self.estimates[point.id]
            cells = f"{cost.cells_x} x {cost.cells_y}"
            time = span((end / speed for end in cost.ends or (cost.seconds,)), duration_text)
            yield (point.id, *labels, cells, time, size_text(cost.memory_bytes))


def write_points(study: Study, path: str | Path) -> None:
    """Write the points as CSV: id, every parameter in SI units, cells, estimates, problem."""
    rows, estimates = list[dict[str, object]](), Plan(study).estimates
    last = ("cells", "estimated_seconds", "estimated_memory_bytes", "problem")
    for point in study.points():
        row: dict[str, object] = {"id": point.id}
        # Parameters in SI units; varied ones that are not numbers as written in the file.
        for (name, value), label in zip(point.values.items(), point.labels.values(), strict=True):
            row[name.replace(".", "_")] = value if isinstance(value, float | int | str) else label
        if point.case is not None:
            coordinates = point.case.scalar_coordinates()
            for name, (value, *_) in coordinates.items():
                name = "load" if name == "normal_load" else name
                # A dataset has the first value of a table as a number, which does not identify the
                # table.
                if name not in row or f"{name}_over_cycles" not in coordinates:
                    row[name] = value
            cost = estimates[point.id]
            costs = (cost.cells, f"{cost.seconds:.3g}", cost.memory_bytes)
            row |= zip(last[:-1], costs, strict=True)
        row["problem"] = point.problem
        rows.append({name: as_cell(value) for name, value in row.items()})
    names = dict.fromkeys(name for row in rows for name in row if name not in last)
    with Path(path).open("w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, [*names, *last], restval="")
        writer.writeheader()
        writer.writerows(rows)
