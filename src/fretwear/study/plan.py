"""The plan of a study: its points and the cost of each, before anything is run."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

from fretwear.mechanics.contact.rings import Rings
from fretwear.mechanics.contact.strips import Row, Strips
from fretwear.study.case import Case
from fretwear.study.case_warnings import case_warnings
from fretwear.study.memory import MEMORY_TO_START, memory_of, window
from fretwear.study.study import Point, Study
from fretwear.units import duration_text, size_text

# Fitted to runs: actual times are within half of these.
SECONDS_TO_START, SECONDS_PER_CASE = 1.3, 0.1
# Time of a step: on rings; of a line contact, at least; on a window, at least and per cell; with a
# matrix, per cubed cell, and over a stroke per cubed strip.
SECONDS_ON_RINGS, SECONDS_ON_STRIPS = 6e-3, 3.5e-2
SECONDS_ON_WINDOW, SECONDS_PER_CELL = 5e-3, 9e-7
SECONDS_PER_CUBED_STRIP, SECONDS_PER_CUBED_CELL = 0.9e-8, 2.5e-11
SECONDS_PER_CELL_OF_SNAPSHOT = 1.5e-6
# Columns of coated contacts: thickness over contact radius, peak pressure over the uncoated one.
_OF_COATINGS = {"h/a0": "coating_ratio", "p_max/p0": "coating_pressure_ratio"}
# Factors on the time of steps: bodies that yield, friction in two directions, and a load that
# changes within a cycle.
TIMES_YIELDING, TIMES_COUPLED, TIMES_PULSATING = 1.7, 3.0, 14.0
POWER_OF_NARROW_RINGS = 2.3
STEPS_PER_ROOT_OF_SLIP_AND_WEAR, STEPS_PER_SNAPSHOT, STEPS_PER_YIELDING_TIME = 11.0, 2.5, 1.0
# Steps on rings keep to a quarter of the tolerance.
TIGHTER_ON_RINGS = 4.0


class Estimate(NamedTuple):
    """The expected cost of a case."""

    # Cells of the largest window along x and y, computed or, on rings, written.
    cells_x: int
    cells_y: int
    steps: float
    seconds: float  # time on one core
    memory_bytes: int  # memory while it runs

    @property
    def cells(self) -> int:
        """Cells of the window at its largest."""
        return self.cells_x * self.cells_y


def estimate(case: Case) -> Estimate:
    """Estimate the cost of a case.

    The coarser run for error estimates is included. A case with a requested accuracy is expected to
    end with default cells.
    """
    usual, widths = _run(case, 1.0), [1.0]
    if case.asked_accuracy:
        widths += [case.first_width]
    elif case.error_estimate:
        widths += [case.times_coarser]
    runs = [_run(case, width) for width in widths]
    memory = sum(run.memory_bytes - MEMORY_TO_START for run in runs) + MEMORY_TO_START
    seconds = SECONDS_TO_START + SECONDS_PER_CASE + sum(run.seconds for run in runs)
    return usual._replace(seconds=seconds, memory_bytes=memory)


def _run(case: Case, width: float) -> Estimate:
    """The cost of a run on cells that are `width` times as wide as the case's."""
    geometry, stroke, cells = case.cells.geometry, case.loading.stroke, window(case, width)
    if issubclass(geometry, Rings):
        of_step = SECONDS_ON_RINGS
    elif stroke and geometry is Strips:
        sides = 2 - case.even[0]
        of_step = SECONDS_PER_CUBED_STRIP * cells.places * cells.matrix**3 / sides**2
    elif stroke:
        of_step = SECONDS_PER_CUBED_CELL * cells.places * cells.matrix**3
    elif geometry in (Strips, Row):
        of_step = SECONDS_ON_STRIPS + SECONDS_PER_CUBED_CELL * cells.matrix**3
    else:
        # The window grows with the contact, starting near its unworn size.
        mean = 0.5 * (min(cells.cells, cells.unworn) + cells.cells)
        of_step = SECONDS_ON_WINDOW + SECONDS_PER_CELL * mean
        if case.slip_model.couples:
            of_step *= TIMES_COUPLED
    if case.normal.pulsating_load < 1.0 and not stroke:
        of_step *= TIMES_PULSATING
    if case.cells.is_graded:
        of_step *= (width * case.coarseness) ** -POWER_OF_NARROW_RINGS
    steps, written = _steps(case, case.tolerance_on(width)), cells.cells * len(case.output_cycles)
    if case.cells.stick_shrinks:
        of_step *= TIMES_YIELDING
    return Estimate(
        cells.x,
        cells.y,
        steps,
        seconds=of_step * steps + SECONDS_PER_CELL_OF_SNAPSHOT * written,
        memory_bytes=memory_of(case, width),
    )


def _steps(case: Case, tolerance: float) -> float:
    """Expected number of steps.

    The steps of an elastic run grow with the wear and the slip: the pressure p0 wears a cell e-fold
    in 1/(β p0) cycles, β = 4 K_w µ κ, and steps may grow longer from fold to fold. A step ends at
    each snapshot, and the steps after it are short while the contact wears. If the bodies yield and
    slip follows the worn shape, a step is no longer than the time in which wear frees a cell at the
    limit p, 1/(β p) cycles at the default tolerance.
    """
    worn, snapshots = case.cycles * case.largest_wear_growth, len(case.output_cycles)
    root = math.sqrt(math.log2(1.0 + worn * case.hertz_pressure) * min(case.tangential_ratio, 1.0))
    finer = (TIGHTER_ON_RINGS if issubclass(case.cells.geometry, Rings) else 1.0) * 0.01 / tolerance
    elastic = STEPS_PER_ROOT_OF_SLIP_AND_WEAR * root * finer**0.18
    elastic += STEPS_PER_SNAPSHOT * min(root, 1.0) * max(snapshots - 2, 0)
    times = worn * case.slip_limit if case.cells.stick_shrinks else 0.0
    # The shorter of both kinds of step is taken.
    yielding = STEPS_PER_YIELDING_TIME * times * finer**0.5
    return math.hypot(max(elastic, snapshots - 1), yielding)


@dataclass(frozen=True)
class Plan:
    """The points of a study in order, with estimates."""

    study: Study

    @property
    def points(self) -> tuple[Point, ...]:
        """The points, the last varied parameter fastest."""
        return self.study.points()

    @cached_property
    def estimates(self) -> Mapping[str, Estimate]:
        """Estimates by case id, each case once."""
        estimates = {}
        for case_id, case in self.study.cases().items():
            cost = estimate(case)
            added = sum(part.seconds(case, cost.cells) for part in self.study.added.values())
            estimates[case_id] = cost._replace(seconds=cost.seconds + added)
        return estimates

    @cached_property
    def warnings(self) -> Mapping[str, Mapping[str, str]]:
        """Lacks of accuracy and limits of the model, with the numbers of each case by id."""
        warnings: dict[str, dict[str, str]] = {}
        for case_id, case in self.study.cases().items():
            for warning in case_warnings(case):
                warnings.setdefault(warning.what, {})[case_id] = warning.detail
        return warnings

    @property
    def files(self) -> Mapping[str, None]:
        """Descriptions of the files of cases and of sections, each once."""
        parts = (
            part
            for case in self.study.cases().values()
            for part in (case.indenter, case.roughness, case.counterface)
        )
        texts = [getattr(part, "file_summary", "") for part in parts]
        texts += [text for part in self.study.added.values() for text in part.file_summaries]
        return dict.fromkeys(filter(None, texts))

    @property
    def memory_bytes(self) -> int:
        """Memory of the largest case."""
        return max(cost.memory_bytes for cost in self.estimates.values())

    def header(self) -> tuple[str, ...]:
        """Return the titles of the columns of `rows`."""
        names = (axis.name for axis in self.study.axes)
        return ("id", *names, *(title for title, _ in self._of_coatings), "cells", "time", "memory")

    @cached_property
    def _of_coatings(self) -> list[tuple[str, str]]:
        """The columns of coated contacts, if there are any: title and attribute of a case."""
        is_coated = any(case.coating is not None for case in self.study.cases().values())
        return list(_OF_COATINGS.items()) if is_coated else []

    def rows(self) -> Iterator[tuple[str, ...]]:
        """Iterate over the points as text, varied values in the words of the file."""
        for point in self.points:
            labels = point.labels.values()
            if point.case is None:
                unknown = ["-"] * (len(self._of_coatings) + 2)
                yield "(invalid)", *labels, *unknown, point.mistake
                continue
            cost = self.estimates[point.id]
            ratios = (getattr(point.case, name) for _, name in self._of_coatings)
            texts = ("-" if math.isnan(ratio) else f"{ratio:.3g}" for ratio in ratios)
            cells = f"{cost.cells_x} x {cost.cells_y}"
            time, memory = duration_text(cost.seconds), size_text(cost.memory_bytes)
            yield (point.id, *labels, *texts, cells, time, memory)


def write_points(study: Study, path: str | Path) -> None:
    """Write the points as CSV: case id, every parameter in SI units, cells, estimates, mistake."""
    import pandas as pd

    rows, estimates = list[dict[str, object]](), Plan(study).estimates
    last = ("cells", "estimated_seconds", "estimated_memory_bytes", "mistake")
    for point in study.points():
        row: dict[str, object] = {"case_id": point.id, "mistake": point.mistake}
        # Parameters in SI units; varied ones that are not all numbers as written in the file.
        varied = zip(study.axes, point.index, strict=True)
        values = {axis.coordinate: axis.plain[place] for axis, place in varied}
        stored = point.scalar_coordinates().items()
        row |= values | {name: value for name, (value, *_) in stored if name not in values}
        if point.case is not None:
            cost = estimates[point.id]
            row |= zip(last, (cost.cells, f"{cost.seconds:.3g}", cost.memory_bytes), strict=False)
        rows.append(row)
    table = pd.DataFrame(rows, dtype=object).rename(columns={"normal_load": "load"})
    first = [name for name in table if name not in last]
    table[[*first, *last]].to_csv(path, index=False, lineterminator="\n")
