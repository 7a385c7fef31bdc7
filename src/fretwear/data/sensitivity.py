"""Sobol indices of sampled studies, from a polynomial emulator."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fretwear.data.effects import Array, Points, varied_names
from fretwear.vocabulary import RESULTS

if TYPE_CHECKING:
    from fretwear.data.effects import Merged

GOOD = 0.9
"""Share of the variance that an emulator has to predict for its indices to be told."""

_MOST_TERMS = 500
_POINTS_PER_TERM = 2
_NORMS = (0.5, 0.75, 1.0)
_HIGHEST = 14
_DRAWS = 400
_CERTAINTY = (2.5, 97.5)


@dataclass(frozen=True)
class Indices:
    """The share of the variance of a result that each of d parameters explains."""

    first: Array  # shape (d,): each parameter alone
    total: Array  # with all its interactions
    # 95 % intervals, shape (2, d), from the covariance of the coefficients of the emulator.
    first_range: Array
    total_range: Array
    quality: float  # share of the variance predicted at points left out of the emulator, 1 at best
    of_logarithm: bool = False  # whether they refer to the logarithm of the result


def unit_points(summary: Merged) -> tuple[Array, tuple[int, ...]]:
    """Return the finished points of a sampled study in the unit cube, shape (n, d).

    With it comes for each parameter the number of listed values it was drawn from, 0 for a range.
    """
    points = Points.of(summary)
    columns, sizes = [], []
    for name in points.levels:
        attributes = summary.variables[name].attrs
        if "drawn_from" in attributes:
            values = points.parameters[name]
            low, high = (float(attributes[key]) for key in ("drawn_from", "drawn_to"))
            if attributes["drawn_on"] == "log":
                values, low, high = np.log(values), math.log(low), math.log(high)
            columns.append(np.clip((values - low) / (high - low), 0.0, 1.0))
            sizes.append(0)
        else:
            count = len(points.levels[name])
            columns.append((points.place(name) + 0.5) / count)
            sizes.append(count)
    return np.column_stack(columns), tuple(sizes)


def is_sampled(summary: Merged) -> bool:
    """Return whether the points of a merged study were drawn from ranges."""
    return any("drawn_from" in summary.variables[name].attrs for name in varied_names(summary))


def result_indices(summary: Merged) -> dict[str, Indices]:
    """Return the Sobol indices of every scalar of a sampled study.

    They refer to its logarithm if an emulator of that predicts better, since results scale with
    powers of the parameters. Results that vanish somewhere or are constant are left out.
    """
    points, (unit, sizes) = Points.of(summary), unit_points(summary)
    if len(points.ids) < 2 * (len(points.levels) + 1):
        return {}
    columns = {
        name: values
        for name, values in points.results.items()
        if name in RESULTS and np.isfinite(values).all() and np.ptp(values) > 0.0
    }
    positive = [name for name, values in columns.items() if values.min() > 0.0]
    table = [*columns.values(), *(np.log(columns[name]) for name in positive)]
    if not table:
        return {}
    found = sobol_indices(unit, np.column_stack(table), sizes)
    plain, logarithmic = found[: len(columns)], found[len(columns) :]
    best = dict(zip(columns, plain, strict=True))
    for name, each in zip(positive, logarithmic, strict=True):
        if each.quality > best[name].quality:
            best[name] = replace(each, of_logarithm=True)
    return best


def sobol_indices(unit: Array, values: Array, sizes: Sequence[int] = ()) -> list[Indices]:
    """Return the Sobol indices of functions known at points that fill the unit cube.

    The emulator is a polynomial chaos expansion: least squares over products of orthonormal
    polynomials, whose squared coefficients are the parts of the variance (Sudret 2008). Its terms
    are those of a hyperbolic cross whose degree and norm leave the smallest error at points left
    out (Blatman and Sudret 2011).

    Parameters
    ----------
    unit : array of shape (n, d)
        Points of a Sobol sequence or a Latin hypercube.
    values : array of shape (n, k)
        Values of k functions at these points.
    sizes : sequence of d int
        Number of listed values each coordinate was drawn from, 0 for a range; default: all ranges.

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
    known = set()
    for norm in _NORMS:
        for degree in range(1, _HIGHEST + 1):
            terms = [t for t in _terms(degree, norm, highest) if len(t) == len(highest)]
            if len(terms) > most:
                break
            if tuple(terms) not in known:
                known.add(tuple(terms))
                yield np.array(terms, dtype=np.intp)


def _terms(degree: int, norm: float, highest: Sequence[int]) -> list[tuple[int, ...]]:
    """Return the degrees of all products whose norm is at most `degree`."""
    found: list[tuple[tuple[int, ...], float]] = [((), 0.0)]
    for most in highest:
        found = [
            ((*term, each), used + each**norm)
            for term, used in found
            for each in range(min(most, degree) + 1)
            if used + each**norm <= degree**norm * (1.0 + 1e-12)
        ]
        if len(found) > _MOST_TERMS:
            return [((0,) * len(highest))] * (_MOST_TERMS + 1)
    return [term for term, _ in found]


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

    def shares(squares: Array) -> tuple[Array, Array]:
        whole = np.maximum(squares[1:].sum(axis=0), 1e-12)
        parts = (group.T.astype(float) @ squares / whole for group in (alone, involved))
        first, total = (np.clip(part, 0.0, 1.0) for part in parts)
        return first, total

    # The square of a noisy coefficient is too large by its variance, that of a draw by twice that.
    first, total = shares((coefficients**2 - noise)[:, None])
    draws = shares((coefficients[:, None] + spread @ drawn) ** 2 - 2.0 * noise[:, None])
    of_first, of_total = (np.percentile(each, _CERTAINTY, axis=1) for each in draws)
    return Indices(first[:, 0], total[:, 0], of_first, of_total, 1.0 - error)


def rank_correlations(unit: Array, values: Array) -> Array:
    """Return Spearman's rank correlation of each coordinate with each function, shape (d, k)."""
    ranks = [np.column_stack([_ranks(column) for column in each.T]) for each in (unit, values)]
    d = unit.shape[1]
    return np.asarray(np.corrcoef(np.column_stack(ranks), rowvar=False))[:d, d:]


def _ranks(values: Array) -> Array:
    """Return the ranks of some values; ties share their mean rank."""
    _, place, counts = np.unique(values, return_inverse=True, return_counts=True)
    return np.asarray((np.cumsum(counts) - 0.5 * (counts - 1))[place])
