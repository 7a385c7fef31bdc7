"""What each parameter of a study does: pairs of cases that differ in that parameter alone."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from fretwear.units import in_unit
from fretwear.vocabulary import (
    CASE_ID,
    CYCLE,
    POINT,
    RESULTS,
    SCALARS,
    STATUS,
    PointStatus,
    Variable,
)

Array = NDArray[np.float64]
Rows = NDArray[np.intp]
Value = Any
"""A value of a parameter: a float, or text such as a slip model's name."""

# Seeds that make an ensemble: fewer have no deviation worth the name.
SEED, LEAST_SEEDS = "roughness_seed", 3

_BOOKKEEPING = {CASE_ID.name, POINT.name, STATUS.name, "id"}
_CEASED = 1e-3
_MATTERS = math.log(1.05)
_EXPLAINED = 0.3


def point_dims(summary: xr.Dataset) -> tuple[str, ...]:
    """Return the dimensions of a merged study along which its points lie."""
    return tuple(str(dim) for dim in summary[STATUS.name].dims)


def varied_names(summary: xr.Dataset) -> list[str]:
    """Return the parameters that a merged study varies, in its order."""
    dims = set(point_dims(summary))
    names = {str(name): set(each.dims) for name, each in summary.coords.items()}
    return [n for n, along in names.items() if n not in _BOOKKEEPING and along and along <= dims]


def last_values(values: xr.DataArray) -> xr.DataArray:
    """Return the last value over the cycles that is known; cases may end at different cycles."""
    last = values.isel({CYCLE.name: -1}, drop=True)
    if not np.isnan(last.values).any():
        return last
    known = values.notnull()
    place = values.sizes[CYCLE.name] - 1 - known.isel(cycle=np.s_[::-1]).argmax(CYCLE.name)
    return values.isel({CYCLE.name: place}).drop_vars(CYCLE.name)


def final_results(summary: xr.Dataset) -> xr.Dataset:
    """Return every scalar of a merged study after the last cycle of each point, errors included."""
    dims = {*point_dims(summary), CYCLE.name}
    return xr.Dataset(
        {
            str(name): last_values(values)
            for name, values in summary.data_vars.items()
            if set(values.dims) == dims
        }
    )


def results_table(summary: xr.Dataset) -> str:
    """Return the points of a merged study as CSV: id, parameters and final values, SI units."""
    dims = point_dims(summary)
    final = final_results(summary)
    other = [n for n, each in summary.variables.items() if set(each.dims) <= set(dims)]
    parameters = [n for n in other if str(n) not in _BOOKKEEPING and n not in varied_names(summary)]
    columns = [CASE_ID.name, STATUS.name, *varied_names(summary), *parameters, *final]
    words = [PointStatus(int(status)).word for status in summary[STATUS.name].values.flat]
    whole = summary.drop_vars([CYCLE.name, "x"], errors="ignore")[list(map(str, other))]
    table = whole.reset_coords().merge(final.reset_coords(drop=True))
    if not dims:
        table = table.expand_dims(POINT.name) if POINT.name not in table else table
    frame = table.to_dataframe().reset_index().assign(status=words)
    return str(frame[list(map(str, columns))].to_csv(index=False, float_format="%.9g"))


@dataclass(frozen=True)
class Points:
    """The finished points of a study as rows.

    Attributes
    ----------
    levels : mapping of str to tuple
        The different values of each varied parameter: numbers in increasing order, text as in the
        study.
    places : array of int and shape (n, k)
        For each point and parameter the place of its value among the levels.
    variables : mapping of str to Variable
        What each of the results is: in a line contact it may be per length.
    results : mapping of str to array of shape (n,)
        Every scalar after the last cycle, SI units. A dissipated energy of which less than a
        thousandth is left is NaN: wear has ceased, and what is left is rounding.
    parameters : mapping of str to array of shape (n,)
        Every numeric parameter that is not the same at all points.
    ids : tuple of str
        Case ids.
    """

    levels: Mapping[str, tuple[Value, ...]]
    places: Rows
    variables: Mapping[str, Variable]
    results: Mapping[str, Array]
    parameters: Mapping[str, Array]
    ids: tuple[str, ...]

    @classmethod
    def of(cls, summary: xr.Dataset) -> Points:
        """Return the finished points of a merged study."""
        shape, dims = summary[STATUS.name].shape, point_dims(summary)

        def column(values: xr.DataArray) -> NDArray[Any]:
            order = [dim for dim in dims if dim in values.dims]
            values = values.transpose(*order)
            # A coordinate lies along one of the dimensions only.
            axes = [slice(None) if dim in values.dims else None for dim in dims]
            return np.broadcast_to(values.values[tuple(axes)], shape).ravel()

        done = column(summary[STATUS.name]) == PointStatus.DONE
        levels, places = {}, []
        for name in varied_names(summary):
            units = summary[name].attrs.get("units", "")
            values = [in_unit(value, units) for value in column(summary[name])[done].tolist()]
            found = list(dict.fromkeys(values))
            if len(found) > 1:
                numbers = not any(isinstance(value, str) for value in found)
                levels[name] = tuple(sorted(found) if numbers else found)
                places.append([levels[name].index(value) for value in values])
        results = {
            str(name): column(values)[done] for name, values in final_results(summary).items()
        }
        energy = "dissipated_energy"
        if energy in results:
            first = column(summary[energy].isel(cycle=0))[done]
            results[energy] = np.where(results[energy] < _CEASED * first, np.nan, results[energy])
        scalars = {scalar.name for scalar in SCALARS}
        changing = {}
        for name, each in ((str(n), summary[n]) for n in summary.variables):
            if each.dtype.kind == "f" and name not in scalars and set(each.dims) <= set(dims):
                values = column(each)[done]
                if len(set(values.tolist())) > 1:
                    changing[name] = values
        ids = tuple(map(str, column(summary[CASE_ID.name])[done]))
        rows = np.reshape(np.array(places, dtype=np.intp), (len(levels), len(ids))).T
        variables = {
            name: RESULTS[name].in_units(summary[name].attrs.get("units", RESULTS[name].si_unit))
            for name in results
            if name in RESULTS
        }
        return cls(levels, rows, variables, results, changing, ids)

    @cached_property
    def lines(self) -> Mapping[str, list[list[int]]]:
        """Rows of the points that differ in one parameter alone, by its levels; two or more."""
        found = {}
        for axis, name in enumerate(self.levels):
            lines: dict[bytes, list[int]] = {}
            others = np.ascontiguousarray(np.delete(self.places, axis, axis=1))
            for row in np.argsort(self.places[:, axis], kind="stable").tolist():
                lines.setdefault(others[row].tobytes(), []).append(row)
            found[name] = [line for line in lines.values() if len(line) > 1]
        return found

    def place(self, name: str) -> Rows:
        """Return for each point the place of its value among the levels of a parameter."""
        return self.places[:, list(self.levels).index(name)]

    def effect(self, parameter: str, result: str) -> Effect:
        """Return what a parameter does to a result."""
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
    """What a parameter does to a result, pair by pair.

    Attributes
    ----------
    points : Points
        The points of the study.
    parameter, result : str
        Which parameter, and which result.
    low, high : array of int and shape (m,)
        Rows of the points of each pair, that with the lower level first.
    line : array of int and shape (m,)
        Of which line of points each pair is: one in which nothing else differs.
    factors : array of shape (m,)
        Result at `high` over that at `low`; NaN where one of them is zero or has ceased.
    """

    points: Points
    parameter: str
    result: str
    low: Rows
    high: Rows
    line: Rows
    factors: Array

    @cached_property
    def _ends(self) -> tuple[Rows, Rows]:
        place = self.points.place(self.parameter)
        return place[self.low], place[self.high]

    def between(self, low: int, high: int) -> NDArray[np.bool_]:
        """Say which pairs go from one level to another, by their places."""
        first, second = self._ends
        is_between: NDArray[np.bool_] = (first == low) & (second == high)
        return is_between

    def where(self, parameter: str, level: int) -> NDArray[np.bool_]:
        """Say in which pairs another parameter has a level, by its place."""
        is_there: NDArray[np.bool_] = self.points.place(parameter)[self.low] == level
        return is_there

    @cached_property
    def size(self) -> float:
        """Logarithm of the factor between the largest and smallest result of a line, on average.

        It is 0 where no pair has a factor.
        """
        largest: dict[int, float] = {}
        for line, factor in zip(self.line.tolist(), self.factors.tolist(), strict=True):
            if math.isfinite(factor):
                largest[line] = max(largest.get(line, 0.0), abs(math.log(factor)))
        return math.fsum(largest.values()) / len(largest) if largest else 0.0

    @cached_property
    def divider(self) -> str:
        """The other parameter on which the factor depends most; empty where on none."""
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
    """Return the sum of squares of some values about the means of their groups."""
    _, group = np.unique(groups, return_inverse=True)
    means = np.bincount(group, values) / np.bincount(group)
    return float(((values - means[group]) ** 2).sum())
