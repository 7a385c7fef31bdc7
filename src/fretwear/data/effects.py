"""The effects of the parameters of a study on its results.

If values are listed, effects come from pairs of cases that differ in one parameter only; in a
sampled study, Sobol indices come from an emulator.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from fretwear.arrays import Array
from fretwear.results import (
    CASE_ID,
    CODE_DIGEST,
    CYCLE,
    POINT,
    RESULTS,
    STATUS,
    WARNINGS,
    PointStatus,
    headlines,
)
from fretwear.study.parameters import parameter, value_text
from fretwear.units import (
    NO_UNIT,
    Unit,
    axis_label,
    in_unit,
    number_text,
    readable_unit,
    with_error,
)
from fretwear.variable import Variable

if TYPE_CHECKING:
    from scipy.interpolate import RBFInterpolator

# Least number of seeds of an ensemble: the standard deviation of fewer means little.
SEED, LEAST_SEEDS = "roughness_seed", 3

BOOKKEEPING = {CASE_ID.name, POINT.name, STATUS.name, "id"}

GOOD = 0.9
"""Share of the variance that an emulator must predict for its indices to be reported."""

WRITTEN = {"normal_load": "load"}
"""Coordinates with another name in study files, tables and JSON."""

COLUMNS = (
    *("result", "parameter", "from", "to", "where", "pairs", "factor"),
    *("lowest_factor", "highest_factor", "undefined", "appears", "vanishes"),
)

# Least spread of log factors that matters; share of it that one parameter must explain.
_MATTERS, _EXPLAINED = math.log(1.05), 0.3
_FOLDS, _DRAWS, _MOST_EMULATED = 8, 1024, 1000
# Quantile of Student's t of 95 % for the groups, and the uncertainty that draws leave.
_QUANTILE, _OF_DRAWS = 2.36, 0.005


def point_dims(summary: xr.Dataset) -> tuple[str, ...]:
    """Return the dimensions of a merged study along which its points lie."""
    return tuple(map(str, summary.variables[STATUS.name].dims))


def varied_names(summary: xr.Dataset) -> list[str]:
    """Return the varied parameters of a merged study, in order."""
    dims = set(point_dims(summary))
    names = {str(name): set(summary.variables[str(name)].dims) for name in summary.coords}
    return [n for n, axes in names.items() if n not in BOOKKEEPING and axes and axes <= dims]


def point_values(summary: xr.Dataset, name: str) -> NDArray[np.generic]:
    """Return a variable of a merged study, one value per point."""
    sizes = summary.variables[STATUS.name].sizes
    wide = summary.variables[name].set_dims(dict(sizes))  # type: ignore[no-untyped-call]
    return np.asarray(wide.values).ravel()


def final_results(summary: xr.Dataset) -> dict[str, Array]:
    """Return every scalar of a merged study, errors included, after the last cycle of each point.

    Cases may end at different cycles. A result that is undefined, such as the mean stick pressure
    where nothing sticks, is NaN.
    """
    dims = (*point_dims(summary), CYCLE.name)
    names = [name for name, variable in summary.variables.items() if {*variable.dims} == {*dims}]
    tables = {str(name): summary.variables[name].transpose(*dims).values for name in names}
    # A snapshot is stored if any result is defined in it; others, such as the mean stick pressure,
    # may be NaN.
    stored = np.any([pd.notna(values) for values in tables.values()], axis=0)
    last = (stored * np.arange(stored.shape[-1])).argmax(axis=-1)[..., None]
    return {name: np.take_along_axis(values, last, -1)[..., 0] for name, values in tables.items()}


def points_table(summary: xr.Dataset) -> pd.DataFrame:
    """Return the points of a merged study as rows: id, status, parameters, final values, SI units.

    Parameters are in the order of the study, the varied ones first.
    """
    dims, varied = set(point_dims(summary)), varied_names(summary)
    per_point = [str(name) for name, array in summary.variables.items() if {*array.dims} <= dims]
    last = [name for name in (CODE_DIGEST.name, WARNINGS.name) if name in summary]
    placed = {*BOOKKEEPING, *varied, *last}
    names = [CASE_ID.name, STATUS.name, *varied, *(n for n in per_point if n not in placed)]
    columns = {name: point_values(summary, name) for name in names}
    columns[STATUS.name] = np.array([PointStatus(int(s)).word for s in columns[STATUS.name]])
    columns |= {name: values.ravel() for name, values in final_results(summary).items()}
    columns |= {name: point_values(summary, name) for name in last}
    return pd.DataFrame({name: list(values) for name, values in columns.items()})


def results_table(summary: xr.Dataset) -> str:
    """Return the points of a merged study as CSV; see `points_table`.

    Parameters are written as in ``points.csv``, results with nine digits.
    """
    table = points_table(summary).rename(columns=WRITTEN)
    if WARNINGS.name in table:
        table[WARNINGS.name] = table[WARNINGS.name].str.replace("\n", "; ")
    for name in final_results(summary):
        table[name] = [float(f"{value:.9g}") for value in table[name]]
    text: str = table.to_csv(index=False, float_format=str, lineterminator="\n")
    return text


def levels_of(
    dataset: xr.Dataset, name: str, values: NDArray[np.generic] | None = None
) -> list[float | str]:
    """Return values of a parameter as in study files; drawn ones with three digits.

    By default these are the values along its dimension.
    """
    attributes = dataset[name].attrs
    levels = (dataset[name].values if values is None else values).tolist()
    if "drawn_from" in attributes:
        levels = [float(f"{level:.3g}") for level in levels]
    return [in_unit(level, attributes.get("units", "")) for level in levels]


def plain_unit(variable: Variable, values: Array) -> Unit:
    """Return the unit in which people read values, without a power of ten."""
    unit = variable.unit or readable_unit(values, variable.si_unit)
    return readable_unit([0.0], variable.si_unit) if unit.is_power else unit


def key_results(summary: xr.Dataset) -> pd.DataFrame:
    """Return the varied values, key results with errors, status and id of every point as text."""
    final, frame = final_results(summary), {}
    for name in varied_names(summary):
        levels = levels_of(summary, name, point_values(summary, name))
        label = axis_label(parameter(name).words, NO_UNIT)
        frame[label] = [value_text(name, level) for level in levels]
    for name in headlines(final):
        if not np.isfinite(final[name]).any():
            continue
        values, error = final[name].ravel(), final.get(f"{name}_error", np.zeros(1)).ravel()
        result = RESULTS[name].in_dataset(summary)
        unit = plain_unit(result, values[np.isfinite(values)])
        frame[axis_label(result.words, unit)] = [
            "–" if math.isnan(v) else with_error(v, e) if e > 0.0 else number_text(v, 4)
            for v, e in np.broadcast(unit.of(values), unit.of(error))
        ]
    frame["Status"] = [PointStatus(s).word for s in point_values(summary, STATUS.name).tolist()]
    frame["Case"] = point_values(summary, CASE_ID.name).tolist()
    return pd.DataFrame(frame)


@dataclass(frozen=True)
class Points:
    """The n finished points of a study as rows of a table."""

    # By case id: the index of the level of each varied parameter, and every scalar after the last
    # cycle, SI units. A scalar is NaN if its estimated error is as large as its value, as at a
    # singular peak or for the dissipation after wear has ceased. The central pressure is also NaN
    # if the centre is open, as in a valley of waves.
    table: pd.DataFrame
    # The distinct values of each varied parameter: numbers increasing, text as in the study.
    levels: Mapping[str, tuple[float | str, ...]]
    variables: Mapping[str, Variable]  # of the results; in a line contact some are per length
    drawn: Mapping[str, Mapping[str, float | str]]  # the range from which a parameter was drawn

    @classmethod
    def of(cls, summary: xr.Dataset) -> Points:
        """Return the finished points of a merged study."""
        rows = points_table(summary)
        rows = rows[rows[STATUS.name] == PointStatus.DONE.word].set_index(CASE_ID.name)
        levels, drawn = dict[str, tuple[float | str, ...]](), {}
        table = pd.DataFrame(index=rows.index.rename("id"))
        for name in varied_names(summary):
            attributes = summary.variables[name].attrs
            if "drawn_from" in attributes:
                drawn[name] = attributes
            values = [in_unit(value, attributes.get("units", "")) for value in rows[name].tolist()]
            place, distinct = pd.factorize(
                np.array(values, object), sort=not any(isinstance(v, str) for v in values)
            )
            if len(distinct) > 1:
                levels[name], table[name] = tuple(distinct), place
        results = rows[[*final_results(summary)]]
        for name in results:
            error = results.get(f"{name}_error", 0.0 * results[name])
            table[name] = results[name].mask((results[name] != 0.0) & (error >= abs(results[name])))
        if "central_pressure" in table:
            table["central_pressure"] = table["central_pressure"].replace(0.0, np.nan)
        variables = {name: RESULTS[name].in_dataset(summary) for name in results if name in RESULTS}
        return cls(table, levels, variables, drawn)

    @cached_property
    def results(self) -> Mapping[str, Array]:
        """The scalars of the table by name, shape (n,)."""
        scalars = self.table.drop(columns=[*self.levels])
        return {str(name): values.to_numpy() for name, values in scalars.items()}

    def place(self, name: str) -> NDArray[np.intp]:
        """Return the index of each point's level of a parameter."""
        return np.asarray(self.table[name], np.intp)

    def values(self, name: str) -> Array:
        """Return the value of a parameter at each point, the place of its level if it is text."""
        levels = self.levels[name]
        is_text = any(isinstance(level, str) for level in levels)
        numbers = np.arange(len(levels)) if is_text else np.array(levels)
        return numbers.astype(np.float64)[self.place(name)]

    @property
    def sizes(self) -> list[int]:
        """Number of listed values from which each parameter was drawn, 0 for a range."""
        return [0 if name in self.drawn else len(levels) for name, levels in self.levels.items()]

    @cached_property
    def unit(self) -> Array:
        """The points of a sample in the unit cube, shape (n, d)."""
        columns = []
        for name, size in zip(self.levels, self.sizes, strict=True):
            if size:
                columns.append((self.place(name) + 0.5) / size)
                continue
            drawn = self.drawn[name]
            scale = np.log if drawn["drawn_on"] == "log" else np.asarray
            low, high = (scale(float(drawn[key])) for key in ("drawn_from", "drawn_to"))
            columns.append(np.clip((scale(self.values(name)) - low) / (high - low), 0.0, 1.0))
        return np.column_stack(columns)

    def rank_correlations(self, result: str) -> pd.Series[float]:
        """Return Spearman's rank correlation of each parameter with a result, by name."""
        values = pd.DataFrame({name: self.values(name) for name in self.levels})
        ranks: pd.Series[float] = values.corrwith(
            pd.Series(self.results[result]), method="spearman"
        )
        return ranks

    def ends(self, name: str) -> tuple[float | str, float | str]:
        """Return the first and the last level of a parameter, or the range it was drawn from."""
        if drawn := self.drawn.get(name):
            units = str(drawn.get("units", ""))
            low, high = (in_unit(float(drawn[f"drawn_{end}"]), units) for end in ("from", "to"))
            return low, high
        return self.levels[name][0], self.levels[name][-1]

    def good_indices(self, result: str) -> Indices | None:
        """The Sobol indices of a result; None unless the emulator predicts it."""
        found = self.indices.get(result)
        return found if found is not None and found.quality >= GOOD else None

    def shares(self) -> Iterator[dict[str, object]]:
        """Yield the shares of each headline result that the parameters of a sample explain.

        The shares of the variance, ``first`` alone and ``total`` with all interactions, have the
        ends of 95 % intervals. They are None unless the emulator predicts the result.
        """
        for result in headlines(self.results) if self.drawn else ():
            indices, ranks = self.good_indices(result), self.rank_correlations(result)
            for place, name in enumerate(self.levels):
                row: dict[str, object] = {"result": result, "parameter": name}
                row |= zip(("from", "to"), self.ends(name), strict=True)
                for kind in ("first", "total"):
                    if indices is None:
                        row |= dict.fromkeys((kind, f"{kind}_low", f"{kind}_high"))
                        continue
                    low, high = getattr(indices, f"{kind}_ends")[:, place].tolist()
                    row[kind] = float(getattr(indices, kind)[place])
                    row |= {f"{kind}_low": low, f"{kind}_high": high}
                row["rank_correlation"] = float(ranks[name])
                yield row

    @cached_property
    def indices(self) -> Mapping[str, Indices]:
        """The Sobol indices of every scalar of a sample; empty for other studies.

        They refer to the logarithm of a scalar that is positive, since results scale with powers of
        the parameters. Constant results, and results undefined at some point, are left out.
        """
        columns = {
            name: np.log(values) if values.min() > 0.0 else values
            for name, values in self.results.items()
            if name in RESULTS and np.isfinite(values).all() and np.ptp(values) > 0.0
        }
        # Seven eighths of the points must determine the quadratic part of the emulator.
        terms = math.comb(len(self.levels) + 2, 2)
        if not (self.drawn and columns) or terms > 0.8 * len(self.table):
            return {}
        fits = sobol_indices(self.unit, np.column_stack([*columns.values()]), self.sizes)
        return dict(zip(columns, fits, strict=True))


def effects_table(points: Points) -> pd.DataFrame:
    """Return the changes of results from the first to the last level of each parameter.

    The results are the `headlines`, the columns `COLUMNS`. A row compares pairs of cases that
    differ in one parameter alone: all of them, then those at each level of the parameter on which
    the change depends most, ``where`` by its name. Factors are ratios of the result at level ``to``
    over that at ``from``, undefined where one of them is zero or undefined; ``factor`` is their
    geometric mean. A result appears in a pair where it is zero at ``from`` alone, and vanishes
    where it is zero at ``to`` alone. Seeds have no order: their levels are undefined, and their
    factors relate the result of each to the mean over the seeds.
    """
    rows = []
    for name, levels in points.levels.items():
        others = [parameter for parameter in points.levels if parameter != name]
        pairs = _seeds(points, others) if name == SEED else _pairs(points, name, others)
        change = (None, None) if name == SEED else (levels[0], levels[-1])
        for result in headlines(points.results) if len(pairs) else ():
            values = pairs[[*others, f"{result}_from", f"{result}_to"]].set_axis(
                [*others, "before", "after"], axis=1
            )
            positive = values[["before", "after"]].where(lambda value: value > 0.0)
            values["factor"] = positive["after"] / positive["before"]
            divider = "" if name == SEED else _divider(values, [n for n in others if n != SEED])
            parts: list[tuple[dict[str, object], pd.DataFrame]] = [({}, values)] + [
                ({divider: points.levels[divider][level]}, part)
                for level, part in (values.groupby(divider) if divider else ())
            ]
            rows += [(result, name, *change, where, *_change(part)) for where, part in parts]
    return pd.DataFrame(rows, columns=COLUMNS)


def _pairs(points: Points, name: str, others: list[str]) -> pd.DataFrame:
    """Return the cases at the first and the last level of a parameter that otherwise agree."""
    table, last = points.table.reset_index(), len(points.levels[name]) - 1
    first, second = (table[table[name] == level].drop(columns=name) for level in (0, last))
    how: dict[str, object] = {"on": others} if others else {"how": "cross"}
    pairs = first.merge(second, suffixes=("_from", "_to"), **how)
    # Several points may share a case: slopes do not matter on a smooth surface.
    return pairs[pairs["id_from"] != pairs["id_to"]].drop_duplicates(["id_from", "id_to"])


def _seeds(points: Points, others: list[str]) -> pd.DataFrame:
    """Return the results of every seed beside their mean over the seeds."""
    table = points.table.drop(columns=SEED)
    results = [*points.results]
    means = table.groupby(others)[results].transform("mean") if others else table.mean()
    start = table[results].mul(0.0).add(means).add_suffix("_from")
    return pd.concat([table[others], start, table[results].add_suffix("_to")], axis=1)


def _change(values: pd.DataFrame) -> tuple[float, ...]:
    """Return the columns of a row from ``pairs`` on."""
    start, end, factor = (values[name] for name in ("before", "after", "factor"))
    factors = np.exp(np.log(factor).mean()), factor.min(), factor.max()
    appears, vanishes = (start == 0.0) & (end > 0.0), (start > 0.0) & (end == 0.0)
    counts = factor.isna().sum(), appears.sum(), vanishes.sum()
    return len(values), *map(float, factors), *map(int, counts)


def _divider(values: pd.DataFrame, others: list[str]) -> str:
    """Return the other parameter on which the factor depends most; empty if it depends on none."""
    logs = np.log(values["factor"].dropna())
    if not others or len(logs) < 2 or np.ptp(logs) < _MATTERS:
        return ""
    means = {name: logs.groupby(values[name]).transform("mean") for name in others}
    parts = {name: float(((logs - mean) ** 2).sum()) for name, mean in means.items()}
    best = min(parts, key=lambda name: parts[name])
    whole = float(((logs - logs.mean()) ** 2).sum())
    return best if parts[best] < (1.0 - _EXPLAINED) * whole else ""


@dataclass(frozen=True)
class Indices:
    """The share of the variance of a result that each of d parameters explains."""

    first: Array  # shape (d,): each parameter alone
    total: Array  # each parameter with all its interactions
    first_ends: Array  # shape (2, d): ends of the 95 % interval of each
    total_ends: Array
    quality: float  # share of the variance predicted at omitted points, 1 at best


def sobol_indices(unit: Array, values: Array, sizes: Sequence[int] = ()) -> list[Indices]:
    """Return the Sobol indices of each function, given `values` (n, k) of k functions at n points.

    The points, `unit` (n, d), fill the unit cube; `sizes` are the numbers of listed values from
    which their coordinates were drawn, 0 for a range (the default). An emulator of quintic radial
    functions interpolates the values, and `scipy.stats.sobol_indices` integrates it. Emulators that
    each omit one eighth of the points measure its quality. Of more than 1000 points, the first 1000
    are used.
    """
    # Importing this takes longer than a merge.
    from scipy.interpolate import RBFInterpolator

    unit, values = unit[:_MOST_EMULATED], values[:_MOST_EMULATED]
    count, dimensions = unit.shape
    listed = np.array(sizes or (0,) * dimensions)
    spread = np.where(np.ptp(values, axis=0), values.std(axis=0), 1)
    scaled = (values - values.mean(axis=0)) / spread
    fold = np.random.default_rng(0).permutation(count) % min(_FOLDS, count)

    def emulator(kept: NDArray[np.bool_]) -> RBFInterpolator:
        return RBFInterpolator(unit[kept], scaled[kept], kernel="quintic", degree=2)

    groups = [fold == k for k in range(fold.max() + 1)]
    partial = [emulator(~group) for group in groups]
    missed = [each(unit[g]) - scaled[g] for each, g in zip(partial, groups, strict=True)]
    quality = 1.0 - (np.concatenate(missed) ** 2).mean(axis=0)
    shares = np.clip(_shares(emulator(fold >= 0), listed), 0.0, 1.0)
    # Jackknife by groups: the effect of omitting an eighth of the points gives the error of all.
    partial_shares = np.stack([_shares(each, listed) for each in partial])
    half = _QUANTILE * partial_shares.std(axis=0) * math.sqrt(len(groups) - 1) + _OF_DRAWS
    ends = np.clip(np.stack([shares - half, shares + half], axis=2), 0.0, 1.0)
    return [Indices(*each) for each in zip(*shares, *ends, quality.tolist(), strict=True)]


def _shares(emulator: RBFInterpolator, listed: NDArray[np.intp]) -> Array:
    """Return first and total indices, shape (2, functions, parameters)."""
    from scipy import stats

    def function(x: Array) -> Array:
        # Listed values lie in the middle of equal parts of the unit interval.
        centres = (np.floor(x.T * listed) + 0.5) / np.where(listed > 0, listed, 1)
        return np.asarray(emulator(np.where(listed > 0, centres, x.T)).T)

    uniform = [stats.uniform()] * listed.size
    found = stats.sobol_indices(func=function, n=_DRAWS, dists=uniform, rng=0)
    both = [np.atleast_2d(found.first_order), np.atleast_2d(found.total_order)]
    return np.asarray(np.nan_to_num(both), np.float64)
