"""The key results of every point of a study, as numbers and as people read them."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from statistics import mean, stdev
from typing import TYPE_CHECKING, NamedTuple

from fretwear.data.effects import LEAST_SEEDS, SEED, final_results
from fretwear.data.merge import StudyLayout
from fretwear.data.safe import DataFileError
from fretwear.study.parameters import value_text, words_text
from fretwear.study.plan import Plan
from fretwear.study.points import Axis
from fretwear.units import Unit, readable_unit
from fretwear.vocabulary import HEADLINES, RESULTS, PointStatus, Variable

if TYPE_CHECKING:
    from fretwear.data.effects import Merged

_RUN_AGAIN = "Run and merge the study again"
_LARGEST = sys.float_info.max
_UNKNOWN_REASON = "The simulation failed; its log says why."


class Level(NamedTuple):
    """A value of a varied parameter: alone, in words, and as a number that sorts the values."""

    label: str
    words: str
    sort_key: float


class Ensemble(NamedTuple):
    """Random surfaces of one spectrum: their parameters but the seed, and how many there are.

    Mean and standard deviation by the name of the key result.
    """

    levels: Mapping[str, Level]
    seeds: int
    spread: Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class PointResult:
    """What became of one point of a study."""

    number: int  # place in the study, from 1
    id: str  # of the case, empty when invalid
    status: PointStatus
    reason: str  # why it is not done
    levels: Mapping[str, Level]  # varied values by the name of their parameter
    # The `HEADLINES` after the last cycle in SI units; empty when not done.
    values: Mapping[str, float] = field(default_factory=dict)
    # Estimated errors of these, relative to them, as far as they are known.
    errors: Mapping[str, float] = field(default_factory=dict)
    in_line: bool = False  # a line contact, whose volumes and energies are per length

    @property
    def done(self) -> bool:
        """Whether there are results."""
        return self.status == PointStatus.DONE

    @property
    def title(self) -> str:
        """The varied values in one line."""
        return ", ".join(level.words for level in self.levels.values()) or self.id


def point_results(plan: Plan, summary: Merged, failures: Mapping[str, str]) -> list[PointResult]:
    """Return the key results of every point, in the order of the study.

    `failures` are reasons by case id. It is a `DataFileError` when the summary is not that of the
    plan's study as it is now.
    """
    layout = StudyLayout(plan.study)
    _check_points(plan, layout, summary)
    final = final_results(summary)
    columns = {name: final[name] for name in HEADLINES}
    apart = {
        name: final[error] for name in HEADLINES if (error := RESULTS[name].error.name) in final
    }
    status = summary.variables["status"].values
    levels = {axis.coordinate: levels_of(axis) for axis in plan.study.axes}
    results = []
    for number, (planned, (place, point)) in enumerate(
        zip(plan.points, layout.points(), strict=True), 1
    ):
        case = point.case
        result = PointResult(
            number=number,
            id=planned.id,
            status=PointStatus.INVALID if case is None else PointStatus(int(status[place])),
            reason=point.problem,
            levels={name: levels[name][i] for name, i in zip(levels, point.index, strict=True)},
        )
        if case is None:
            results.append(result)
        elif not result.done:
            results.append(replace(result, reason=failures.get(result.id, _UNKNOWN_REASON)))
        else:
            values = {name: float(column[place]) for name, column in columns.items()}
            in_line = case.indenter.is_line
            errors = {
                name: float(column[place]) / abs(values[name])
                for name, column in apart.items()
                if values[name] and not math.isnan(column[place])
            }
            results.append(replace(result, values=values, errors=errors, in_line=in_line))
    return results


def over_seeds(results: Sequence[PointResult]) -> list[Ensemble]:
    """Return the key results over the seeds, for each combination of the other parameters."""
    groups: dict[tuple[str, ...], list[PointResult]] = {}
    for result in results:
        if result.done and SEED in result.levels:
            others = tuple(level.label for name, level in result.levels.items() if name != SEED)
            groups.setdefault(others, []).append(result)
    ensembles = []
    for group in groups.values():
        if len(group) >= LEAST_SEEDS:
            levels = {name: level for name, level in group[0].levels.items() if name != SEED}
            columns = {name: [each.values[name] for each in group] for name in group[0].values}
            spread = {name: (mean(values), stdev(values)) for name, values in columns.items()}
            ensembles.append(Ensemble(levels, len(group), spread))
    return ensembles


def levels_of(axis: Axis) -> list[Level]:
    """Return the values of a varied parameter for people, in the order of the study."""
    levels = []
    for place, (value, written) in enumerate(zip(axis.values, axis.labels, strict=True)):
        # What is no single number stays as the study file has it.
        is_number = isinstance(value, float | int) and not isinstance(value, bool)
        shown = value if is_number else written
        texts = value_text(axis.coordinate, shown), words_text(axis.coordinate, shown)
        # JavaScript does not read inf.
        levels.append(Level(*texts, min(float(value if is_number else place), _LARGEST)))
    return levels


def display_units(results: Sequence[PointResult]) -> dict[str, Unit]:
    """Return the unit in which each key result is shown, the same for all points."""
    done = [result for result in results if result.done]
    return {
        name: variable_of(name, done).unit
        or readable_unit([r.values[name] for r in done], variable_of(name, done).si_unit)
        for name in HEADLINES
    }


def variable_of(name: str, results: Sequence[PointResult]) -> Variable:
    """Return what a key result is: in a line contact it may be per length."""
    in_line = any(result.in_line for result in results)
    return RESULTS[name].per_length if in_line else RESULTS[name]


def _check_points(plan: Plan, layout: StudyLayout, summary: Merged) -> None:
    file, status = Path("summary.nc"), summary.variables["status"]
    sizes = dict(zip(status.dims, status.values.shape, strict=True))
    if tuple(sizes.items()) != tuple(zip(layout.dims, layout.shape, strict=True)):
        problem = f"its points are {sizes}, those of the study {plan.study.name!r} {layout.shape}"
        raise DataFileError(file, problem, _RUN_AGAIN)
    ids = summary.variables["case_id"].values
    for planned, (place, _) in zip(plan.points, layout.points(), strict=True):
        if str(ids[place]) != planned.id:
            now = planned.id or "an invalid point"
            problem = f"it has case {ids[place]} where the study {plan.study.name!r} has {now}"
            raise DataFileError(file, problem, _RUN_AGAIN)
