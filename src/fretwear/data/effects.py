"""The effect of each parameter of a study: pairs of cases that differ only in that parameter."""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from io import StringIO
from itertools import combinations
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from fretwear.units import in_unit
from fretwear.vocabulary import (
    CASE_ID,
    CODE_DIGEST,
    CYCLE,
    POINT,
    RESULTS,
    SCALARS,
    STATUS,
    PointStatus,
    Variable,
)

if TYPE_CHECKING:
    import xarray as xr

    from fretwear.data.labels import Labelled

    Merged: TypeAlias = xr.Dataset | Labelled

Array = NDArray[np.float64]
Rows = NDArray[np.intp]
Value = Any
"""A value of a parameter: a float, or text such as a slip model's name."""

# Seeds that make an ensemble: the standard deviation of fewer means little.
SEED, LEAST_SEEDS = "roughness_seed", 3

_BOOKKEEPING = {CASE_ID.name, POINT.name, STATUS.name, "id"}
_CEASED = 1e-3
_MATTERS = math.log(1.05)
_EXPLAINED = 0.3


def point_dims(summary: Merged) -> tuple[str, ...]:
    """Return the dimensions of a merged study along which its points lie."""
    return tuple(map(str, summary.variables[STATUS.name].dims))


def varied_names(summary: Merged) -> list[str]:
    """Return the varied parameters of a merged study, in order."""
    dims = set(point_dims(summary))
    names = {str(name): set(summary.variables[str(name)].dims) for name in summary.coords}
    return [n for n, along in names.items() if n not in _BOOKKEEPING and along and along <= dims]


def point_values(summary: Merged, name: str) -> NDArray[Any]:
    """Return a variable of a merged study, one value per point."""
    shape, dims = summary.variables[STATUS.name].values.shape, point_dims(summary)
    # A coordinate lies along one of the dimensions only.
    axes = [slice(None) if dim in summary.variables[name].dims else None for dim in dims]
    return np.broadcast_to(_in_order(summary, name)[tuple(axes)], shape).ravel()


def _in_order(summary: Merged, name: str) -> NDArray[Any]:
    """Return the values of a variable along the dimensions of the points, then the cycles."""
    known = list(summary.variables[name].dims)
    order = [known.index(dim) for dim in (*point_dims(summary), CYCLE.name) if dim in known]
    return np.asarray(summary.variables[name].values).transpose(order)


def final_results(summary: Merged) -> dict[str, Array]:
    """Return every scalar of a merged study, errors included, after the last cycle of each point.

    Cases may end at different cycles.
    """
    dims = {*point_dims(summary), CYCLE.name}
    names = [str(name) for name, each in summary.variables.items() if set(each.dims) == dims]
    found = {}
    for name in names:
        values = _in_order(summary, name)
        if np.isnan(last := values[..., -1]).any():
            place = values.shape[-1] - 1 - (~np.isnan(values))[..., ::-1].argmax(axis=-1)
            last = np.take_along_axis(values, place[..., None], axis=-1)[..., 0]
        found[name] = last
    return found


def results_table(summary: Merged) -> str:
    """Return the points of a merged study as CSV: id, parameters and final values, SI units."""
    dims, varied = set(point_dims(summary)), varied_names(summary)
    along = [str(name) for name, each in summary.variables.items() if set(each.dims) <= dims]
    told = {*_BOOKKEEPING, *varied, CODE_DIGEST.name}
    named = [*varied, *(name for name in along if name not in told)]
    columns = {
        CASE_ID.name: point_values(summary, CASE_ID.name).tolist(),
        STATUS.name: [PointStatus(int(s)).word for s in point_values(summary, STATUS.name)],
        **{name: point_values(summary, name).tolist() for name in named},
        **{name: values.ravel().tolist() for name, values in final_results(summary).items()},
        CODE_DIGEST.name: point_values(summary, CODE_DIGEST.name).tolist(),
    }
    stream = StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(columns)
    texts = ([_cell(value) for value in each] for each in columns.values())
    writer.writerows(zip(*texts, strict=True))
    return stream.getvalue()


def _cell(value: Any) -> Any:
    if not isinstance(value, float):
        return value
    return "" if math.isnan(value) else f"{value:.9g}"


@dataclass(frozen=True)
class Points:
    """The n finished points of a study as rows."""

    # The distinct values of each varied parameter: numbers increasing, text as in the study.
    levels: Mapping[str, tuple[Value, ...]]
    places: Rows  # shape (n, k): index of the level of each parameter at each point
    variables: Mapping[str, Variable]  # of the results, in a line contact some are per length
    # Every scalar after the last cycle, SI units, shape (n,). A dissipated energy below a
    # thousandth of its first value is NaN: wear has ceased, and the rest is rounding.
    results: Mapping[str, Array]
    parameters: Mapping[str, Array]  # numeric ones that differ between points, shape (n,)
    ids: tuple[str, ...]  # of the cases

    @classmethod
    def of(cls, summary: Merged) -> Points:
        """Return the finished points of a merged study."""
        dims = set(point_dims(summary))
        done = point_values(summary, STATUS.name) == PointStatus.DONE
        levels, places = {}, []
        for name in varied_names(summary):
            units = summary.variables[name].attrs.get("units", "")
            values = [in_unit(value, units) for value in point_values(summary, name)[done].tolist()]
            found = list(dict.fromkeys(values))
            if len(found) > 1:
                numbers = not any(isinstance(value, str) for value in found)
                levels[name] = tuple(sorted(found) if numbers else found)
                place = {value: number for number, value in enumerate(levels[name])}
                places.append([place[value] for value in values])
        results = {name: last.ravel()[done] for name, last in final_results(summary).items()}
        energy = "dissipated_energy"
        if energy in results:
            first = _in_order(summary, energy)[..., 0].ravel()[done]
            results[energy] = np.where(results[energy] < _CEASED * first, np.nan, results[energy])
        scalars = {scalar.name for scalar in SCALARS}
        changing = {}
        for name, each in ((str(n), each) for n, each in summary.variables.items()):
            if name not in scalars and set(each.dims) <= dims and each.values.dtype.kind == "f":
                values = point_values(summary, name)[done]
                if len(set(values.tolist())) > 1:
                    changing[name] = values
        ids = tuple(map(str, point_values(summary, CASE_ID.name)[done]))
        rows = np.reshape(np.array(places, dtype=np.intp), (len(levels), len(ids))).T
        variables = {
            name: about.in_units(summary.variables[name].attrs.get("units", about.si_unit))
            for name in results
            if (about := RESULTS.get(name))
        }
        return cls(levels, rows, variables, results, changing, ids)

    @cached_property
    def lines(self) -> Mapping[str, list[list[int]]]:
        """Rows of two or more points that differ only in one parameter, in order of its levels."""
        found = {}
        for axis, name in enumerate(self.levels):
            lines: dict[bytes, list[int]] = {}
            others = np.ascontiguousarray(np.delete(self.places, axis, axis=1))
            for row in np.argsort(self.places[:, axis], kind="stable").tolist():
                lines.setdefault(others[row].tobytes(), []).append(row)
            found[name] = [line for line in lines.values() if len(line) > 1]
        return found

    def place(self, name: str) -> Rows:
        """Return the index of each point's level of a parameter."""
        return self.places[:, list(self.levels).index(name)]

    def effect(self, parameter: str, result: str) -> Effect:
        """Return the effect of a parameter on a result."""
        pairs = [
            (*pair, number)
            for number, line in enumerate(self.lines[parameter])
            for pair in combinations(line, 2)
        ]
        low, high, line = np.array(pairs, dtype=np.intp).reshape(-1, 3).T
        values = self.results[result]
        with np.errstate(divide="ignore", invalid="ignore"):
            factors = values[high] / values[low]
        factors[~(np.isfinite(factors) & (factors > 0.0))] = np.nan
        return Effect(self, parameter, result, low, high, line, factors)

    def effects(self, result: str) -> list[Effect]:
        """Return the effects on a result, the largest first."""
        found = [self.effect(name, result) for name in self.levels]
        return sorted((each for each in found if each.low.size), key=lambda e: -e.size)


@dataclass(frozen=True)
class Effect:
    """The effect of a parameter on a result, for each of m pairs of points."""

    points: Points
    parameter: str
    result: str
    low: Rows  # of the point of each pair that has the lower level
    high: Rows  # of the other
    line: Rows  # number of the line of points, in which nothing else differs, of each pair
    factors: Array  # result at `high` over that at `low`; NaN where one is zero or has ceased

    @cached_property
    def _ends(self) -> tuple[Rows, Rows]:
        place = self.points.place(self.parameter)
        return place[self.low], place[self.high]

    def between(self, low: int, high: int) -> NDArray[np.bool_]:
        """Return which pairs go from one level to another, by index."""
        first, second = self._ends
        is_between: NDArray[np.bool_] = (first == low) & (second == high)
        return is_between

    def where(self, parameter: str, level: int) -> NDArray[np.bool_]:
        """Return in which pairs another parameter has a given level, by index."""
        is_there: NDArray[np.bool_] = self.points.place(parameter)[self.low] == level
        return is_there

    @cached_property
    def size(self) -> float:
        """Mean over the lines of the logarithm of the factor between largest and smallest result.

        It is 0 if no pair has a factor.
        """
        largest: dict[int, float] = {}
        for line, factor in zip(self.line.tolist(), self.factors.tolist(), strict=True):
            if math.isfinite(factor):
                largest[line] = max(largest.get(line, 0.0), abs(math.log(factor)))
        return math.fsum(largest.values()) / len(largest) if largest else 0.0

    @cached_property
    def divider(self) -> str:
        """The other parameter on which the factor depends most; empty if on none."""
        known = np.isfinite(self.factors)
        logarithms, best = np.log(self.factors[known]), ("", 0.0)
        if not logarithms.size or np.ptp(logarithms) < _MATTERS:
            return ""
        first, second = (place[known] for place in self._ends)
        steps = first * (1 + second.max()) + second
        whole = _within(logarithms, steps)
        for name in self.points.levels:
            if name != self.parameter:
                level = self.points.place(name)[self.low[known]]
                explained = whole - _within(logarithms, steps * (1 + level.max()) + level)
                best = max(best, (name, explained), key=lambda each: each[1])
        return best[0] if best[1] > _EXPLAINED * whole else ""


def _within(values: Array, groups: Rows) -> float:
    """Return the sum of squares of values about the means of their groups."""
    _, group = np.unique(groups, return_inverse=True)
    means = np.bincount(group, values) / np.bincount(group)
    return float(((values - means[group]) ** 2).sum())
