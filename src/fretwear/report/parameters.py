"""The parameters of a study as a table for people."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from fretwear.figures.wording import parameter, value_text
from fretwear.report.results import labels_of
from fretwear.study.case import Case
from fretwear.study.plan import Plan
from fretwear.study.points import Axis

_NOT_SHOWN = {"cell_x", "cell_y", "tolerance", "slip_model"}
_DERIVED = ("hertz_radius", "hertz_pressure")
_MOST_LISTED = 8


@dataclass(frozen=True)
class ParameterRow:
    """One parameter: name in the study file, words, values, and whether the study varies it."""

    name: str
    words: str
    values: str
    varied: bool = False


def parameter_rows(plan: Plan) -> list[ParameterRow]:
    """Return the varied parameters in the order of the study, then the fixed ones."""
    cases = _distinct_cases(plan)
    varied = [
        ParameterRow(axis.coordinate, parameter(axis.coordinate).words, _listed(axis), varied=True)
        for axis in plan.study.axes
    ]
    fixed = [name for name in cases[0].scalar_coordinates() if name not in _NOT_SHOWN]
    names = {row.name for row in varied}
    followed = [_row(name, cases) for name in fixed if name not in names and name not in _DERIVED]
    return varied + [row for row in followed if row is not None]


def derived_rows(plan: Plan) -> list[ParameterRow]:
    """Return what follows from the parameters before any cycle."""
    cases = _distinct_cases(plan)
    rows = [_row(name, cases) for name in _DERIVED]
    stick = [case.stick_radius for case in cases]
    text = _spread("hertz_radius", stick)
    return [row for row in rows if row] + [
        ParameterRow("", "stick radius of the smooth elastic sphere", text)
    ]


def _distinct_cases(plan: Plan) -> list[Case]:
    return list(plan.study.cases().values())


def _row(name: str, cases: Sequence[Case]) -> ParameterRow | None:
    if name.startswith("roughness_slope"):
        cases = [case for case in cases if case.roughness is not None]
    values = [
        coordinates[name][0]
        for coordinates in (case.scalar_coordinates() for case in cases)
        if name in coordinates
    ]
    if not values:
        return None
    return ParameterRow(name, parameter(name).words, _spread(name, values))


def _spread(name: str, values: Sequence[float | str]) -> str:
    """Return the distinct values in order, or their range when there are many."""
    distinct = list(dict.fromkeys(value_text(name, value) for value in values))
    if len(distinct) <= _MOST_LISTED:
        return ", ".join(distinct)
    numbers = [value for value in values if not isinstance(value, str) and math.isfinite(value)]
    return f"{value_text(name, min(numbers))} to {value_text(name, max(numbers))}"


def _listed(axis: Axis) -> str:
    """Return the values in the order of the study, or their range when there are many."""
    distinct = list(dict.fromkeys(labels_of(axis)))
    if len(distinct) <= 2 * _MOST_LISTED:
        return ", ".join(distinct)
    if all(isinstance(value, float | int) for value in axis.values):
        ends = (value_text(axis.coordinate, end(axis.values)) for end in (min, max))
        return f"{' to '.join(ends)} ({len(distinct)} values)"
    return f"{distinct[0]}, {distinct[1]}, … {distinct[-1]} ({len(distinct)} values)"
