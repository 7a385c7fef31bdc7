"""The plan of a study: its points with what each will take, before anything is run."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import IO

from fretwear.study.case import Case
from fretwear.study.cost import Estimate, estimate
from fretwear.study.points import Point
from fretwear.study.rules import Doubt, doubts
from fretwear.study.study import Study
from fretwear.units import duration_text, size_text


@dataclass(frozen=True)
class PlannedPoint:
    """A point of a study with what it is expected to take (None where it is invalid)."""

    point: Point
    estimate: Estimate | None

    @property
    def id(self) -> str:
        """Case id; empty where the point is invalid."""
        return self.point.id

    @property
    def case(self) -> Case | None:
        """What to run; None where the point is invalid."""
        return self.point.case


@dataclass(frozen=True)
class Plan:
    """The points of a study in order, with estimates.

    Attributes
    ----------
    study : Study
        The study planned.
    points : tuple of PlannedPoint
        One for each point, the last varied parameter fastest.
    speed : float
        How fast the machine is that times are told for, from `machine_speed` of
        `fretwear.running.resources`; the table of points and the batches are the same everywhere.
    """

    study: Study
    points: tuple[PlannedPoint, ...]
    speed: float = 1.0

    @cached_property
    def estimates(self) -> Mapping[str, Estimate]:
        """Estimates by case id, each case once."""
        return {point.id: point.estimate for point in self.points if point.estimate is not None}

    @cached_property
    def doubts(self) -> Mapping[Doubt, Mapping[str, str]]:
        """What makes results doubtful: numbers by case id, for a first case of each kind."""
        found: dict[str, tuple[Doubt, dict[str, str]]] = {}
        for planned in self.points:
            for doubt in doubts(planned.case) if planned.case is not None else ():
                _, numbers = found.setdefault(doubt.what, (doubt, {}))
                numbers[planned.id] = doubt.detail
        return dict(found.values())

    @property
    def memory_bytes(self) -> int:
        """Memory of the largest case."""
        return max(found.memory_bytes for found in self.estimates.values())

    @property
    def file_bytes(self) -> int:
        """Size of all case files."""
        return sum(found.file_bytes for found in self.estimates.values())

    def header(self) -> tuple[str, ...]:
        """Return the titles of the columns of `rows`."""
        names = (axis.name for axis in self.study.axes)
        return ("id", *names, "cells", "time", "memory")

    def rows(self, first: int = 0, last: int | None = None) -> Iterator[tuple[str, ...]]:
        """Iterate over the points as text for people, varied values in the words of the file.

        Parameters
        ----------
        first, last : int
            Part of the points, as for a slice.
        """
        for planned in self.points[first:last]:
            labels = planned.point.labels.values()
            if planned.estimate is None:
                yield ("(invalid)", *labels, "-", "-", planned.point.problem)
                continue
            found = planned.estimate
            cells = f"{found.cells_x} x {found.cells_y}"
            time = duration_text(found.seconds / self.speed)
            yield (planned.id, *labels, cells, time, size_text(found.memory_bytes))

    def write_csv(self, stream: IO[str]) -> None:
        """Write the table of points: id, every parameter in SI units, cells, estimates.

        The stream should be opened with ``newline=""``.  Cells of the table are empty where a
        point is invalid; the column `problem` says why.
        """
        names: dict[str, None] = {}
        for planned in self.points:
            names.update(dict.fromkeys(_parameters(planned)))
        estimates = ("cells", "estimated_seconds", "estimated_memory_bytes")
        writer = csv.DictWriter(stream, ["id", *names, *estimates, "problem"], restval="")
        writer.writeheader()
        for planned in self.points:
            row: dict[str, object] = {"id": planned.id, "problem": planned.point.problem}
            row.update(_parameters(planned))
            if planned.estimate is not None:
                found = planned.estimate
                values = (found.cells, f"{found.seconds:.3g}", found.memory_bytes)
                row.update(zip(estimates, values, strict=True))
            writer.writerow(row)


def plan_study(study: Study) -> Plan:
    """Return the plan of a study; nothing is run."""
    return Plan(
        study,
        tuple(
            PlannedPoint(point, estimate(point.case) if point.case is not None else None)
            for point in study.points()
        ),
    )


def write_points(study: Study, path: str | Path) -> None:
    """Write the table of points of a study as CSV."""
    with Path(path).open("w", newline="", encoding="utf-8") as stream:
        plan_study(study).write_csv(stream)


def _parameters(planned: PlannedPoint) -> dict[str, float | str]:
    """Return parameters in SI units; varied ones that are no single number as the file has them."""
    varied = {
        name.replace(".", "_"): value if isinstance(value, float | int | str) else label
        for (name, value), label in zip(
            planned.point.values.items(), planned.point.labels.values(), strict=True
        )
    }
    if planned.case is None:
        return varied
    coordinates = planned.case.scalar_coordinates()
    return {**varied, **{name: value for name, (value, _, _) in coordinates.items()}}
