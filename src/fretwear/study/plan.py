"""The plan of a study: its points and what each will cost, before anything is run."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from fretwear.mechanics.materials import Archard
from fretwear.study.cost import Estimate
from fretwear.study.doubts import Doubt, doubts, dundurs_beta
from fretwear.study.parameters import coordinate
from fretwear.study.points import Point
from fretwear.study.study import Study
from fretwear.units import duration_text, number_text, size_text, span


@dataclass(frozen=True)
class Plan:
    """The points of a study in order, with estimates."""

    study: Study
    # Speed of the machine for which times are given, from `fretwear.running.resources`; the table
    # of points and the batches do not depend on it.
    speed: float = 1.0

    @property
    def points(self) -> tuple[Point, ...]:
        """The points, the last varied parameter fastest."""
        return self.study.points()

    @cached_property
    def estimates(self) -> Mapping[str, Estimate]:
        """Estimates by case id, each case once."""
        return {point.id: point.estimate for point in self.points if point.estimate is not None}

    @cached_property
    def doubts(self) -> Mapping[Doubt, Mapping[str, str]]:
        """Reasons to doubt results, with the cases of each: its details by case id."""
        found: dict[str, tuple[Doubt, dict[str, str]]] = {}
        for point in self.points:
            for doubt in doubts(point.case) if point.case is not None else ():
                _, numbers = found.setdefault(doubt.what, (doubt, {}))
                numbers[point.id] = doubt.detail
        return dict(found.values())

    @property
    def memory_bytes(self) -> int:
        """Memory of the largest case."""
        return max(found.memory_bytes for found in self.estimates.values())

    @property
    def file_bytes(self) -> int:
        """Size of all case files."""
        return sum(found.file_bytes for found in self.estimates.values())

    def derived(self) -> Iterator[tuple[str, str]]:
        """Iterate over derived quantities of the study: words and value."""
        cases = self.study.cases().values()
        # For a pair [indenter, flat], the wear of both together.
        archard = [case for case in cases if isinstance(case.wear_law, Archard)]
        if wear := [case.wear_law.coefficient(case.friction_law) for case in archard]:
            text = span(wear, lambda value: number_text(1e9 * value, 4))
            yield "wear volume per load and sliding distance", f"{text} mm³/(N m)"
        if any(betas := [dundurs_beta(case) for case in cases]):
            yield "Dundurs' β of the two materials", span(betas, lambda beta: number_text(beta, 2))

    def header(self) -> tuple[str, ...]:
        """Return the titles of the columns of `rows`."""
        names = (axis.name for axis in self.study.axes)
        return ("id", *names, "cells", "time", "memory")

    def rows(self, first: int = 0, last: int | None = None) -> Iterator[tuple[str, ...]]:
        """Iterate over a slice of the points as text, varied values in the words of the file."""
        for point in self.points[first:last]:
            labels = point.labels.values()
            if (found := point.estimate) is None:
                yield ("(invalid)", *labels, "-", "-", point.problem)
                continue
            cells = f"{found.cells_x} x {found.cells_y}"
            time = duration_text(found.seconds / self.speed)
            yield (point.id, *labels, cells, time, size_text(found.memory_bytes))


def write_points(study: Study, path: str | Path) -> None:
    """Write the points as CSV: id, every parameter in SI units, cells, estimates, problem."""
    points = [(point, _parameters(point)) for point in study.points()]
    names = dict.fromkeys(name for _, parameters in points for name in parameters)
    estimates = ("cells", "estimated_seconds", "estimated_memory_bytes")
    with Path(path).open("w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, ["id", *names, *estimates, "problem"], restval="")
        writer.writeheader()
        for point, parameters in points:
            row: dict[str, object] = {"id": point.id, "problem": point.problem, **parameters}
            if (found := point.estimate) is not None:
                values = (found.cells, f"{found.seconds:.3g}", found.memory_bytes)
                row |= zip(estimates, values, strict=True)
            writer.writerow(row)


def _parameters(point: Point) -> dict[str, float | str]:
    """Return parameters in SI units; varied ones that are not numbers as written in the file."""
    found: dict[str, float | str] = {}
    for (name, value), label in zip(point.values.items(), point.labels.values(), strict=True):
        found[coordinate(name)] = value if isinstance(value, float | int | str) else label
    if point.case is not None:
        known = point.case.scalar_coordinates()
        # A dataset holds the first value of a table as its number, which does not identify the
        # table.
        tables = {name for name in found if f"{name}_over_cycles" in known}
        found |= {name: value for name, (value, *_) in known.items() if name not in tables}
    return found
