"""The effects of the parameters of a study on its results.

In a study of listed values they come from pairs of cases that differ in one parameter only; in a
sampled one, Sobol indices come from a polynomial emulator.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from io import StringIO
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fretwear.arrays import Array
from fretwear.study.problems import as_cell
from fretwear.units import in_unit
from fretwear.vocabulary import (
    CASE_ID,
    CODE_DIGEST,
    CYCLE,
    POINT,
    RESULTS,
    STATUS,
    PointStatus,
    Variable,
)

if TYPE_CHECKING:
    import xarray as xr

Rows = NDArray[np.intp]
Value = Any
"""A value of a parameter: a float, or text such as a slip model's name."""

# An ensemble has at least this many seeds: the standard deviation of fewer means little.
SEED, LEAST_SEEDS = "roughness_seed", 3

BOOKKEEPING = {CASE_ID.name, POINT.name, STATUS.name, "id"}
"""Coordinates of points that are not parameters."""

_MATTERS = math.log(1.05)
_EXPLAINED = 0.3

GOOD = 0.9
"""Share of the variance that an emulator must predict for its indices to be reported."""

_MOST_TERMS = 500
_POINTS_PER_TERM = 2
_NORMS = (0.5, 0.75, 1.0)
_HIGHEST = 14
_DRAWS = 400
_CERTAINTY = (2.5, 97.5)


def point_dims(summary: xr.Dataset) -> tuple[str, ...]:
    """Return the dimensions of a merged study along which its points lie."""
    return tuple(map(str, summary.variables[STATUS.name].dims))


def varied_names(summary: xr.Dataset) -> list[str]:
    """Return the varied parameters of a merged study, in order."""
    dims = set(point_dims(summary))
    names = {str(name): set(summary.variables[str(name)].dims) for name in summary.coords}
    return [n for n, along in names.items() if n not in BOOKKEEPING and along and along <= dims]


def point_values(summary: xr.Dataset, name: str) -> NDArray[np.generic]:
    """Return a variable of a merged study, one value per point."""
    shape, dims = summary.variables[STATUS.name].values.shape, point_dims(summary)
    # A coordinate lies along one of the dimensions only.
    axes = [slice(None) if dim in summary.variables[name].dims else None for dim in dims]
    return np.broadcast_to(_in_order(summary, name)[tuple(axes)], shape).ravel()


def _in_order(summary: xr.Dataset, name: str) -> NDArray[Any]:
    """Return the values of a variable along the dimensions of the points, then the cycles."""
    stored = list(summary.variables[name].dims)
    order = [stored.index(dim) for dim in (*point_dims(summary), CYCLE.name) if dim in stored]
    return np.asarray(summary.variables[name].values).transpose(order)


def final_results(summary: xr.Dataset) -> dict[str, Array]:
    """Return every scalar of a merged study, errors included, after the last cycle of each point.

    Cases may end at different cycles. A result that is undefined, such as the mean stick pressure
    where nothing sticks, is NaN.
    """
    dims = {*point_dims(summary), CYCLE.name}
    names = [str(name) for name, about in summary.variables.items() if set(about.dims) == dims]
    histories = {name: _in_order(summary, name) for name in names}
    # A snapshot is stored if any result is defined in it; some, such as the mean stick pressure,
    # may not be.
    stored = np.any([~np.isnan(values) for values in histories.values()] or [[False]], axis=0)
    last = stored.shape[-1] - 1 - np.argmax(stored[..., ::-1], axis=-1, keepdims=True)
    return {
        name: np.take_along_axis(values, last, -1)[..., 0] for name, values in histories.items()
    }


def results_table(summary: xr.Dataset) -> str:
    """Return the points of a merged study as CSV: id, parameters and final values, SI units."""
    dims, varied = set(point_dims(summary)), varied_names(summary)
    along = [str(name) for name, about in summary.variables.items() if set(about.dims) <= dims]
    placed = {*BOOKKEEPING, *varied, CODE_DIGEST.name}
    named = [*varied, *(name for name in along if name not in placed)]
    columns = {
        CASE_ID.name: point_values(summary, CASE_ID.name).tolist(),
        STATUS.name: [PointStatus(int(s)).word for s in point_values(summary, STATUS.name)],
        **{name: point_values(summary, name).tolist() for name in named},
        **{name: values.ravel().tolist() for name, values in final_results(summary).items()},
        CODE_DIGEST.name: point_values(summary, CODE_DIGEST.name).tolist(),
    }
    stream = StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow("load" if name == "normal_load" else name for name in columns)
    texts = (
        [
            as_cell(v) if not isinstance(v, float) else "" if math.isnan(v) else f"{v:.9g}"
            for v in values
        ]
        for values in columns.values()
    )
    writer.writerows(zip(*texts, strict=True))
    return stream.getvalue()


@dataclass(frozen=True)
class Points:
    """The n finished points of a study as rows."""

    # The distinct values of each varied parameter: numbers increasing, text as in the study.
    levels: Mapping[str, tuple[Value, ...]]
    places: Rows  # shape (n, k): index of the level of each parameter at each point
    variables: Mapping[str, Variable]  # of the results; in a line contact some are per length
    # Every scalar after the last cycle, SI units, shape (n,). It is NaN if its estimated error is
    # as large, as at a singular peak or for the dissipation after wear has ceased. The central
    # pressure is NaN too if the centre is open, as in a valley of waves.
    results: Mapping[str, Array]
    parameters: Mapping[str, Array]  # numeric ones that differ between points, shape (n,)
    ids: tuple[str, ...]  # of the cases
    drawn: Mapping[str, Mapping[str, float | str]]  # the range from which a parameter was drawn

    @classmethod
    def of(cls, summary: xr.Dataset) -> Points:
        """Return the finished points of a merged study."""
        dims = set(point_dims(summary))
        done = point_values(summary, STATUS.name) == PointStatus.DONE
        levels, places, drawn = {}, [], {}
        for name in varied_names(summary):
            about = summary.variables[name].attrs
            if "drawn_from" in about:
                drawn[name] = about
            units = about.get("units", "")
            values = [in_unit(value, units) for value in point_values(summary, name)[done].tolist()]
            distinct = list(dict.fromkeys(values))
            if len(distinct) > 1:
                has_text = any(isinstance(value, str) for value in distinct)
                levels[name] = tuple(distinct if has_text else sorted(distinct))
                place = {value: number for number, value in enumerate(levels[name])}
                places.append([place[value] for value in values])
        results = {name: last.ravel()[done] for name, last in final_results(summary).items()}
        for name in results:
            error = results.get(f"{name}_error", np.zeros(int(done.sum())))
            unknown = (results[name] != 0.0) & (error >= np.abs(results[name]))
            results[name] = np.where(unknown, np.nan, results[name])
        if "central_pressure" in results:
            central = results["central_pressure"]
            results["central_pressure"] = np.where(central == 0.0, np.nan, central)
        numbers = {
            str(name): point_values(summary, str(name))[done]
            for name, about in summary.variables.items()
            if name not in RESULTS and set(about.dims) <= dims and about.values.dtype.kind == "f"
        }
        changing = {n: values for n, values in numbers.items() if len(set(values.tolist())) > 1}
        ids = tuple(map(str, point_values(summary, CASE_ID.name)[done]))
        rows = np.reshape(np.array(places, dtype=np.intp), (len(levels), len(ids))).T
        variables = {
            name: result.in_units(summary.variables[name].attrs.get("units", result.si_unit))
            for name in results
            if (result := RESULTS.get(name))
        }
        return cls(levels, rows, variables, results, changing, ids, drawn)

    @cached_property
    def lines(self) -> Mapping[str, list[list[int]]]:
        """Rows of two or more cases that differ only in one parameter, in order of its levels."""
        by_parameter = {}
        for axis, name in enumerate(self.levels):
            lines: dict[bytes, dict[str, int]] = {}
            others = np.ascontiguousarray(np.delete(self.places, axis, axis=1))
            for row in np.argsort(self.places[:, axis], kind="stable").tolist():
                # Several points may be one case: slopes do not matter on a smooth surface.
                lines.setdefault(others[row].tobytes(), {}).setdefault(self.ids[row], row)
            by_parameter[name] = [[*line.values()] for line in lines.values() if len(line) > 1]
        return by_parameter

    def place(self, name: str) -> Rows:
        """Return the index of each point's level of a parameter."""
        return self.places[:, list(self.levels).index(name)]

    @cached_property
    def joined_lines(self) -> Mapping[str, tuple[Rows, Rows]]:
        """The rows of all lines of a parameter, one line after another, and their lines' numbers.

        A long line has far more pairs than points, so none are kept.
        """
        return {
            name: (
                np.array([row for line in lines for row in line], dtype=np.intp),
                np.repeat(np.arange(len(lines)), [len(line) for line in lines]),
            )
            for name, lines in self.lines.items()
        }

    def effect(self, parameter: str, result: str) -> Effect:
        """Return the effect of a parameter on a result, from the first point of each line on."""
        rows, lines = self.joined_lines[parameter]
        first = rows[np.searchsorted(lines, lines)]
        others = rows != first
        return Effect(self, parameter, result, first[others], rows[others])

    def importance(self, parameter: str, result: str) -> tuple[float, float]:
        """Return how much a parameter changes a result, for comparison with other parameters.

        The first number is the share of its lines in which the result is zero at some points only;
        the second is the mean, over the other lines, of the logarithm of the largest over the
        smallest result.
        """
        lines = [self.results[result][line] for line in self.lines[parameter]]
        finite = [line[np.isfinite(line)] for line in lines]
        positive = [line for line in finite if (line > 0.0).any()]
        sizes = [math.log(line.max() / line.min()) for line in positive if line.min() > 0.0]
        appearing = (len(positive) - len(sizes)) / len(lines)
        return appearing, math.fsum(sizes) / len(sizes) if sizes else 0.0

    def leading(self, result: str) -> list[str]:
        """Return the parameters by their influence on a result, the strongest first.

        In a sample they are ranked by Sobol indices or, without them, by rank correlation. Seeds,
        which have no order, are left out.
        """
        names = [name for name in self.levels if name != SEED]
        if any(self.lines[name] for name in names):
            paired = [name for name in names if self.lines[name]]
            return sorted(paired, key=lambda name: self.importance(name, result), reverse=True)
        values, columns = self.results[result], [self.levels_of(name) for name in names]
        defined = np.isfinite(values)
        if result in self.indices and len(names) == len(self.levels):
            influence = self.indices[result].total
        elif columns and defined.sum() > 2 and np.ptp(values[defined]) > 0.0:
            places = np.column_stack(columns)[defined]
            influence = np.abs(rank_correlations(places, values[defined, None])[:, 0])
        else:
            influence = np.zeros(len(names))
        return [names[place] for place in np.argsort(-np.nan_to_num(influence), kind="stable")]

    def levels_of(self, name: str) -> Array:
        """Return the value of a parameter at each point, the place of its level if it is text."""
        values = self.parameters.get(name)
        return self.place(name).astype(np.float64) if values is None else values

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
            columns.append(np.clip((scale(self.parameters[name]) - low) / (high - low), 0.0, 1.0))
        return np.column_stack(columns)

    @cached_property
    def indices(self) -> Mapping[str, Indices]:
        """The Sobol indices of every scalar of a sample, none of other studies.

        They refer to the logarithm of the scalar if an emulator of the logarithm predicts better,
        since results scale with powers of the parameters. Constant results, and results undefined
        at some point, are left out.
        """
        if not self.drawn:
            return {}
        columns = {
            (name, False): values
            for name, values in self.results.items()
            if name in RESULTS and np.isfinite(values).all() and np.ptp(values) > 0.0
        }
        columns |= {(name, True): np.log(v) for (name, _), v in columns.items() if v.min() > 0.0}
        if not columns or len(self.ids) < 2 * (len(self.levels) + 1):
            return {}
        best: dict[str, Indices] = {}
        fits = sobol_indices(self.unit, np.column_stack([*columns.values()]), self.sizes)
        for (name, of_logarithm), fit in zip(columns, fits, strict=True):
            if name not in best or fit.quality > best[name].quality:
                best[name] = replace(fit, of_logarithm=of_logarithm)
        return best


@dataclass(frozen=True)
class Effect:
    """The effect of a parameter on a result in m pairs of points that differ only in it."""

    points: Points
    parameter: str
    result: str
    low: Rows  # shape (m,): of the point of each pair with the lower level
    high: Rows  # of the other point

    @cached_property
    def values(self) -> tuple[Array, Array]:
        """The result at `low` and at `high`."""
        values = self.points.results[self.result]
        return values[self.low], values[self.high]

    @cached_property
    def factors(self) -> Array:
        """Result at `high` over result at `low`; NaN where one of them is zero or undefined."""
        before, after = self.values
        factors = np.full(before.shape, np.nan)
        np.divide(after, before, out=factors, where=(before > 0.0) & (after > 0.0))
        return factors

    @cached_property
    def _ends(self) -> tuple[Rows, Rows]:
        place = self.points.place(self.parameter)
        return place[self.low], place[self.high]

    def between(self, low: int, high: int) -> Effect:
        """Return the effect from one level to another, both given by index, on all their pairs."""
        rows, lines = self.points.joined_lines[self.parameter]
        place = self.points.place(self.parameter)[rows]
        before, after = place == low, place == high
        _, i, j = np.intersect1d(lines[before], lines[after], return_indices=True)
        return replace(self, low=rows[before][i], high=rows[after][j])

    def select(self, pairs: NDArray[np.bool_]) -> Effect:
        """Return the effect in some of the pairs."""
        return replace(self, low=self.low[pairs], high=self.high[pairs])

    def where(self, parameter: str, level: int) -> NDArray[np.bool_]:
        """Return in which pairs another parameter has a level, given by index."""
        return np.isin(self.points.place(parameter)[self.low], level)

    @cached_property
    def divider(self) -> str:
        """The other parameter on which the factor depends most; empty if it depends on none.

        Seeds are chosen at random: a claim on one of them would hold for that surface only.
        """
        finite = np.isfinite(self.factors)
        logarithms, best = np.log(self.factors[finite]), ("", 0.0)
        if not logarithms.size or np.ptp(logarithms) < _MATTERS:
            return ""
        first, second = (place[finite] for place in self._ends)
        steps = first * (1 + second.max()) + second
        whole = _within(logarithms, steps)
        for name in self.points.levels:
            if name not in (self.parameter, SEED):
                level = self.points.place(name)[self.low[finite]]
                explained = whole - _within(logarithms, steps * (1 + level.max()) + level)
                best = max(best, (name, explained), key=lambda candidate: candidate[1])
        return best[0] if best[1] > _EXPLAINED * whole else ""


def _within(values: Array, groups: Rows) -> float:
    """Return the sum of squares of values about the means of their groups."""
    _, group = np.unique(groups, return_inverse=True)
    means = np.bincount(group, values) / np.bincount(group)
    return float(((values - means[group]) ** 2).sum())


@dataclass(frozen=True)
class Indices:
    """The share of the variance of a result that each of d parameters explains."""

    first: Array  # shape (d,): each parameter alone
    total: Array  # each parameter with all its interactions
    # 95 % intervals, shape (2, d), from the covariance of the coefficients of the emulator.
    first_range: Array
    total_range: Array
    quality: float  # share of the variance predicted at points left out of the fit, 1 at best
    of_logarithm: bool = False  # whether the indices refer to the logarithm of the result


def sobol_indices(unit: Array, values: Array, sizes: Sequence[int] = ()) -> list[Indices]:
    """Return the Sobol indices of functions, given their values at points that fill the unit cube.

    The emulator is a polynomial chaos expansion: least squares over products of orthonormal
    polynomials, whose squared coefficients are the parts of the variance (Sudret 2008). Its terms
    form the hyperbolic cross whose degree and norm minimise the error at points left out (Blatman
    and Sudret 2011).

    Parameters
    ----------
    unit : array of shape (n, d)
        Points of a Sobol sequence or a Latin hypercube.
    values : array of shape (n, k)
        Values of k functions at these points.
    sizes : sequence of d int
        Number of listed values from which each coordinate was drawn, 0 for a range (the default).

    Returns
    -------
    list of Indices
        One for each function.
    """
    count, dimensions = unit.shape
    sizes = sizes or (0,) * dimensions
    scale = values.std(axis=0)
    scaled = (values - values.mean(axis=0)) / np.where(scale > 0.0, scale, 1.0)
    lines = [_polynomials(u, size) for u, size in zip(unit.T, sizes, strict=True)]
    best: list[tuple[float, Any]] = [(math.inf, None)] * values.shape[1]
    for terms in _candidates(count, [line.shape[1] - 1 for line in lines]):
        basis = np.ones((count, len(terms)))
        for degrees, line in zip(terms.T, lines, strict=True):
            basis *= line[:, degrees]
        q, r = np.linalg.qr(basis)
        coefficients = q.T @ scaled
        leverage = np.minimum((q**2).sum(axis=1), 1.0 - 1e-9)
        missed = (scaled - q @ coefficients) / (1.0 - leverage)[:, None]
        for index, error in enumerate((missed**2).mean(axis=0)):
            if error < best[index][0]:
                best[index] = float(error), (terms, r, coefficients[:, index])
    return [_of_expansion(fit, error) for error, fit in best]


def _polynomials(u: Array, size: int) -> Array:
    """Return orthonormal polynomials of degree 0, 1, … at points of [0, 1], one to a column."""
    if not size:
        degrees = np.arange(_HIGHEST + 1)
        legendre = np.polynomial.legendre.legvander(2.0 * u - 1.0, _HIGHEST)
        return np.asarray(legendre * np.sqrt(2.0 * degrees + 1.0))
    levels = (np.arange(size) + 0.5) / size
    q, _ = np.linalg.qr(np.vander(levels, size, increasing=True))
    values: Array = q[np.minimum((u * size).astype(int), size - 1)] * math.sqrt(size)
    return values


def _candidates(count: int, highest: Sequence[int]) -> Iterator[NDArray[np.intp]]:
    """Yield sets of terms, each of shape (terms, d), that `count` points can resolve."""
    most = max(1, min(_MOST_TERMS, count // _POINTS_PER_TERM))
    for norm in _NORMS:
        for degree in range(1, _HIGHEST + 1):
            terms = _terms(degree, norm, highest)
            if len(terms) > most:
                break
            yield np.array(terms, dtype=np.intp)


def _terms(degree: int, norm: float, highest: Sequence[int]) -> list[tuple[int, ...]]:
    """Return the degrees of all products whose norm is at most `degree`."""
    terms: list[tuple[tuple[int, ...], float]] = [((), 0.0)]
    for most in highest:
        terms = [
            ((*term, power), used + power**norm)
            for term, used in terms
            for power in range(min(most, degree) + 1)
            if used + power**norm <= degree**norm * (1.0 + 1e-12)
        ]
        if len(terms) > _MOST_TERMS:
            return [((0,) * len(highest))] * (_MOST_TERMS + 1)
    return [term for term, _ in terms]


def _of_expansion(fit: tuple[NDArray[np.intp], Array, Array], error: float) -> Indices:
    terms, r, projected = fit
    inverse = np.linalg.inv(r)
    coefficients = inverse @ projected
    # The residual of the expansion is treated as noise of the values.
    spread = math.sqrt(error) * inverse
    noise = (spread**2).sum(axis=1)
    drawn = np.random.default_rng(0).standard_normal((len(r), _DRAWS))
    involved = terms > 0
    alone = involved & (involved.sum(axis=1) == 1)[:, None]

    # The square of a noisy coefficient is too large by its variance, a squared draw by twice that.
    draws = (coefficients[:, None] + spread @ drawn) ** 2 - 2.0 * noise[:, None]
    squares = np.column_stack([coefficients**2 - noise, draws])
    whole = np.maximum(squares[1:].sum(axis=0), 1e-12)
    shares = [np.clip(g.T.astype(float) @ squares / whole, 0.0, 1.0) for g in (alone, involved)]
    ranges = [np.percentile(share[:, 1:], _CERTAINTY, axis=1) for share in shares]
    return Indices(shares[0][:, 0], shares[1][:, 0], ranges[0], ranges[1], 1.0 - error)


def rank_correlations(unit: Array, values: Array) -> Array:
    """Return Spearman's rank correlation of each coordinate with each function, shape (d, k)."""
    ranks = []
    for column in (*unit.T, *values.T):
        _, place, counts = np.unique(column, return_inverse=True, return_counts=True)
        # Ties share their mean rank.
        ranks.append((np.cumsum(counts) - 0.5 * (counts - 1))[place])
    d = unit.shape[1]
    return np.asarray(np.corrcoef(ranks))[:d, d:]
