"""The plan of a study: its points and what each will cost, before anything is run."""

from __future__ import annotations

import csv
import math
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
from fretwear.study.case_warnings import case_warnings
from fretwear.study.parameters import value_text
from fretwear.study.problems import as_cell
from fretwear.study.spacing import (
    LEAST_COARSENESS,
    greatest_contact_radius,
    stick_shrinks,
)
from fretwear.study.study import Point, Study
from fretwear.units import duration_text, number_text, size_text, span

# Fitted to runs: times hold within half, memory within half as much again.
SECONDS_TO_START, SECONDS_PER_CASE = 1.3, 0.1
SECONDS_PER_CONVOLUTION, SECONDS_PER_CELL_AND_CONVOLUTION = 2.7e-4, 9e-9
# For the work between convolutions, and for the loop of forces at a snapshot.
SECONDS_PER_CELL_AND_STEP, SECONDS_PER_CELL_OF_LOOP = 7.5e-7, 9e-7
SECONDS_PER_CONVOLUTION_OF_LINE, SECONDS_PER_SQUARED_STRIP = 2e-3, 2.5e-9
SECONDS_PER_CUBED_CELL_OF_STROKE, SECONDS_PER_CUBED_CELL_OF_SCAR = 1e-9, 1.3e-12
# A solution and a step on rings, and writing means of rings over cells.
SECONDS_PER_SOLUTION, SECONDS_PER_STEP_ON_RINGS = 5.3e-4, 2.6e-3
SECONDS_PER_CELL_OF_SNAPSHOT = 1.9e-6
POWER_OF_NARROW_RINGS = 2.3
# Friction in two directions, on whole windows and on quarters; slip that knows its direction; a
# load that changes within a cycle, of which contacts are solved.
TIMES_COUPLED, TIMES_DIRECTED, TIMES_IF_PULSATING = (5.0, 4.0), 1.7, 20.0
# A solution on a third or half of the rings or strips, relative to all of them.
DENSE_COARSER = 0.35

STEPS_PER_ROOT_OF_SLIP_AND_WEAR, STEPS_ROUGH = 10.7, 1.15
STEPS_PER_SNAPSHOT = 2.5
STEPS_PER_YIELDING_TIME, STEPS_PER_YIELDING_TIME_ON_RINGS = 1.3, 0.93
# Steps on rings keep to a quarter of the tolerance.
TIGHTER_ON_RINGS = 4.0
# For a smooth and a rough window of ten thousand cells; iterations grow slowly with the cells.
CONVOLUTIONS_PER_STEP = 17.5, 23.0
CONVOLUTIONS_AS_YIELDING_BEGINS = 105.0, 165.0
GROWTH_WITH_CELLS = 0.05
SOLUTIONS_PER_STEP, SOLUTIONS_PER_YIELDING_TIME, SOLUTIONS_PER_NARROWNESS = 4.9, 4.4, 5.6
# Contacts of a yielding step if shear lowers the limit: at least, and per unit of junction growth.
CONTACTS_UNDER_SHEAR, CONTACTS_PER_JUNCTION_GROWTH = 1.8, 0.2

WINDOW_MARGIN = 1.15
MEMORY_TO_START, MEMORY_OF_GRADED = 110_000_000, 72 * 500**2
MEMORY_PER_SQUARED_STRIP, MEMORY_PER_CELL_OF_SNAPSHOT = 72, 110
MEMORY_PER_CELL = 8 * 4 * 18  # arrays of a padded window
# Fields of a snapshot are compressed, and twice as many if friction has two directions.
BYTES_OF_FILE, BYTES_PER_CELL_OF_SNAPSHOT = 200_000, 10

USUAL_ACCURACY, USUAL_BUDGET = 0.02, 10.0
MOST_MEMORY = 2 * 1024**3
_WORK_BY_WIDTH = 2.5  # power of the inverse width of cells by which work grows
_WIDTHS = [LEAST_COARSENESS * 2.0 ** (n / 4.0) for n in range(13)]


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
    file_bytes: int  # size of its file
    # Least and most time, s, of a case that asks for an accuracy; empty if its cells are known.
    ends: tuple[float, ...] = ()

    @property
    def cells(self) -> int:
        """Cells of the window at its largest."""
        return self.cells_x * self.cells_y


def estimate(case: Case) -> Estimate:
    """Estimate the cost of a case.

    The coarser run for error estimates is included. A case that asks for an accuracy may end with
    its first run, as smooth elastic ones do at `USUAL_ACCURACY`; others are expected to end with
    default cells, and none takes more than its budget.
    """
    start = SECONDS_TO_START + SECONDS_PER_CASE
    if case.asked_accuracy is None:
        alone = _alone(case, 1.0, case.coarseness)
        if not case.error_estimate:
            return alone
        times = case.times_coarser
        twin = _alone(case, times, case.coarseness_on(times))
        dense = DENSE_COARSER if case.geometry is not Grid else 1.0
        return alone._replace(
            seconds=alone.seconds + dense * (twin.seconds - start),
            memory_bytes=alone.memory_bytes + twin.memory_bytes - MEMORY_TO_START,
        )
    budget = case.budget or USUAL_BUDGET
    usual, wide = _on_cells(case, 1.0), case.first_width
    default = usual.seconds - start
    # Equal cells are compared with default cells, others with wider ones beside the first run.
    beside = 1.0 if case.has_equal_cells else case.times_coarser * wide
    first = sum(_on_cells(case, width).seconds - start for width in (wide, beside))
    all_runs = first if case.has_equal_cells else first + default
    is_smooth = case.is_graded and math.isinf(case.slip_limit)
    ends_early = is_smooth and case.asked_accuracy >= USUAL_ACCURACY
    narrowest = max(affordable_width(case), budget ** (-1.0 / _WORK_BY_WIDTH))
    return usual._replace(
        seconds=start + (first if ends_early else all_runs),
        ends=(start + first, start + max(budget * default, all_runs)),
        memory_bytes=_on_cells(case, narrowest).memory_bytes,
    )


def affordable_width(case: Case) -> float:
    """Width of the narrowest cells over the default that fit into `MOST_MEMORY`."""
    memory = ((width, _on_cells(case, width).memory_bytes) for width in _WIDTHS)
    return next((width for width, needed in memory if needed <= MOST_MEMORY), 1.0)


def _on_cells(case: Case, width: float) -> Estimate:
    """The cost of a run on cells of a width over the default."""
    return _alone(case, width, width * case.coarseness if case.is_graded else 1.0)


def _alone(case: Case, width: float, coarseness: float) -> Estimate:
    """The cost of a run alone on cells that are `width` times as wide as the case's.

    The window ends a little outside the largest contact of the run, plus the reach of the
    roughness. Graded rings and strips have a `coarseness` of their own.
    """
    geometry, stroke = case.geometry, case.loading.stroke
    dx, dy = (case.times_written(width) * spacing for spacing in case.grid_spacing)
    sides_x, sides_y = (2 - is_even for is_even in case.even)
    wider = WINDOW_MARGIN * greatest_contact_radius(case) / case.hertz_radius
    reach_x, reach_y = (wider * half for half in case.indenter.half_widths(case.hertz))
    cells_x = sides_x * math.ceil(reach_x / dx)
    cells_y = 1 if geometry in (Strips, Row) else sides_y * math.ceil(reach_y / dy)
    steps, solutions = _work(case, cells_x * cells_y, case.tolerance_on(width))
    if stroke and geometry is Grid:
        cells_y = math.ceil(WINDOW_MARGIN * case.scar_half_width / dy)
    cells, snapshots = cells_x * cells_y, len(case.output_cycles)
    memory, per_step, per_written = MEMORY_PER_CELL * cells, 0.0, 0.0
    if issubclass(geometry, Rings):
        each, memory, per_step = SECONDS_PER_SOLUTION, 0, SECONDS_PER_STEP_ON_RINGS
        per_written = SECONDS_PER_CELL_OF_SNAPSHOT
    elif stroke:
        places = 1.0
        if case.loading.travel > case.small_stroke:
            places += sides_x * max(4.0, 2.0 * stroke / case.hertz_radius)
        if geometry is Strips:
            each = SECONDS_PER_CUBED_CELL_OF_STROKE * places * cells_x**3 / sides_x**2
        else:
            closed = 0.5 * math.pi * case.scar_half_width**2 / (dx * dy)
            each = SECONDS_PER_CUBED_CELL_OF_SCAR * places * closed**3
            memory = 8 * int(places * closed**2 + 6 * cells * cells_y)
    elif geometry in (Strips, Row):
        # Rough and uneven contacts have matrices, for strips of equal width.
        squared = cells_x**2 if case.rough is not None or geometry is Row else 0
        each = max(SECONDS_PER_CONVOLUTION_OF_LINE, SECONDS_PER_SQUARED_STRIP * squared)
        memory += MEMORY_PER_SQUARED_STRIP * squared
    else:
        # The window grows with the contact, starting near its unworn size.
        unworn = sides_x * sides_y * (WINDOW_MARGIN * case.hertz_radius) ** 2 / (dx * dy)
        mean = 0.5 * (min(cells, unworn) + cells)
        each = SECONDS_PER_CONVOLUTION + SECONDS_PER_CELL_AND_CONVOLUTION * mean
        per_step = SECONDS_PER_CELL_AND_STEP * mean
        if case.slip_model.couples:
            each *= TIMES_COUPLED[all(case.even)]
        elif isinstance(case.slip_model, Cerruti) and case.coupling != 1.0:
            each *= TIMES_DIRECTED
    if geometry is Grid and case.slip_model.follows_shape:
        per_written = SECONDS_PER_CELL_OF_LOOP
    if case.normal.pulsating_load < 1.0 and not stroke:
        each *= TIMES_IF_PULSATING
    if coarseness != 1.0:  # a finer cell narrows rings and strips
        each *= coarseness**-POWER_OF_NARROW_RINGS
        memory += int((coarseness**-2 - 1.0) * MEMORY_OF_GRADED)
    written = cells * snapshots
    working = each * solutions + per_step * steps + per_written * written
    of_file = BYTES_PER_CELL_OF_SNAPSHOT * written * (1 + case.slip_model.couples)
    return Estimate(
        cells_x,
        cells_y,
        steps,
        solutions,
        seconds=SECONDS_TO_START + SECONDS_PER_CASE + working,
        memory_bytes=MEMORY_TO_START + memory + MEMORY_PER_CELL_OF_SNAPSHOT * written,
        snapshots=snapshots,
        file_bytes=BYTES_OF_FILE + of_file,
    )


def _work(case: Case, cells: int, tolerance: float) -> tuple[float, float]:
    """Expected numbers of steps, and of half-space convolutions or solutions on rings.

    The steps of an elastic run grow with the wear and the slip: the pressure p0 wears a cell
    e-fold in 1/(β p0) cycles, β = 4 K_w µ κ, and from fold to fold the steps may be longer. A
    step ends at each snapshot, and the next ones are short while the contact wears. If the
    bodies yield and slip follows the worn shape, a step lasts no longer than wear takes to free
    a cell at the limit p, 1/(β p) cycles at the default tolerance.
    """
    is_rough, on_rings = case.rough is not None, issubclass(case.geometry, Rings)
    worn, snapshots = case.cycles * case.wear_growth, len(case.output_cycles)
    root = math.sqrt(math.log2(1.0 + worn * case.hertz_pressure) * min(case.tangential_ratio, 1.0))
    finer = (TIGHTER_ON_RINGS if on_rings else 1.0) * 0.01 / tolerance
    elastic = STEPS_PER_ROOT_OF_SLIP_AND_WEAR * root * finer**0.18
    elastic *= STEPS_ROUGH if is_rough else 1.0
    elastic += STEPS_PER_SNAPSHOT * min(root, 1.0) * max(snapshots - 2, 0)
    elastic = max(elastic, snapshots - 1)
    times = worn * case.slip_limit if stick_shrinks(case) else 0.0
    if on_rings:
        # The narrower the slip annulus, the more often flow and wear settle in turn.
        narrow = SOLUTIONS_PER_NARROWNESS / math.sqrt(case.tangential_ratio)
        solutions, yielding = SOLUTIONS_PER_STEP * elastic, STEPS_PER_YIELDING_TIME_ON_RINGS
        flowing = (narrow + SOLUTIONS_PER_YIELDING_TIME) * times * finer**0.28
    else:
        larger = (cells / 1e4) ** GROWTH_WITH_CELLS
        solutions, yielding = (
            CONVOLUTIONS_PER_STEP[is_rough] * elastic * larger,
            STEPS_PER_YIELDING_TIME,
        )
        # Later and shorter steps change less and take fewer iterations.
        flowing = CONVOLUTIONS_AS_YIELDING_BEGINS[is_rough] * times**0.7 * finer**0.2
    if case.slip_limit < case.plastic_limit:
        flowing *= CONTACTS_UNDER_SHEAR + CONTACTS_PER_JUNCTION_GROWTH * case.junction_growth
    # The shorter of both kinds of step is taken.
    return math.hypot(elastic, yielding * times * finer**0.5), solutions + flowing


@dataclass
class PlannedCases:
    """Estimates, warnings with their details, wear coefficients and Dundurs' β of all cases."""

    estimates: dict[str, Estimate] = field(default_factory=dict)
    warnings: dict[str, dict[str, str]] = field(default_factory=dict)
    wear: set[float] = field(default_factory=set)
    betas: set[float] = field(default_factory=set)

    def add(self, point: Point) -> None:
        """Plan the case of a point, unless another point shares it."""
        if (case := point.case) is None or (case_id := point.id) in self.estimates:
            return
        cost = estimate(case)
        added = sum(part.seconds(case, cost.cells) for part in point.study.added.values())
        self.estimates[case_id] = cost._replace(seconds=cost.seconds + added)
        for warning in case_warnings(case):
            self.warnings.setdefault(warning.what, {})[case_id] = warning.detail
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
    def warnings(self) -> Mapping[str, Mapping[str, str]]:
        """What makes results doubtful, with the numbers of each case by id."""
        return self._of_cases.warnings

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
