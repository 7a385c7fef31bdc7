"""Arithmetic on the cells between two transforms, where going over them once pays.

Each function is here in NumPy. The same functions, compiled from ``kernels.cpp`` when the package
is installed where there is a C++ compiler, go over their fields once, where NumPy goes over them
once for each operation; they take the place of these.

Fields are contiguous and of the same shape unless stated otherwise. A function changes only its
last argument or a field named in its first line, and keeps no reference. The first argument of a
call is the `Team` whose threads share the rows.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, ParamSpec, TypeVar

import numpy as np

from fretwear.mechanics.geometry import Array, Mask, Real, Single
from fretwear.mechanics.team import Team, blocks_of_rows, library

_Given = ParamSpec("_Given")
_Result = TypeVar("_Result")

_LARGEST_EXPONENT = 200.0
_LARGEST_SLOPE = 1e30
_TINY = 1e-12
_SMALL = 3e-5
_BLOCK = 2**14


class Pass(Generic[_Given, _Result]):
    """A function that goes over fields: the compiled one in parts, for the threads of a team.

    Attributes
    ----------
    in_numpy, compiled
        What defines it, and what takes its place, if anything.
    together
        What makes one result of those of the parts: of each of a tuple's, if it is one.
    """

    def __init__(self, in_numpy: Callable[_Given, _Result], *together: Callable[..., Any]) -> None:
        self.in_numpy, self.together = in_numpy, together
        self.compiled: Callable[..., Any] | None = getattr(library, in_numpy.__name__, None)
        self.__doc__ = in_numpy.__doc__

    def __call__(self, team: Team, *given: _Given.args, **_: _Given.kwargs) -> _Result:
        """The result does not depend on the number of threads, to the last bit."""
        if self.compiled is None:
            return self.in_numpy(*given)  # type: ignore[call-arg]
        results: Any = self.compiled(team.threads, *given)
        if len(self.together) > 1:
            columns = zip(*results, strict=True)
            results = tuple(f(each) for f, each in zip(self.together, columns, strict=True))
        else:
            results = self.together[0](results) if self.together else None
        return results  # type: ignore[no-any-return]


def _shared(
    *together: Callable[..., Any],
) -> Callable[[Callable[_Given, _Result]], Pass[_Given, _Result]]:
    return lambda in_numpy: Pass(in_numpy, *together)


@_shared(sum)
def inner(a: Real, b: Real) -> float:
    """Sum of the products of two fields.

    Without BLAS, whose threads gain nothing here, hinder cases that run in parallel, and make the
    last bits depend on their number.
    """
    return float(np.einsum("ij,ij->", a, b))


@_shared(sum)
def total(field: Single) -> float:
    """Sum of a field, in double precision."""
    return float(field.sum(dtype=np.float64))


def product(left: Array, right: Array) -> Array:
    """The product of two matrices, by the thread that calls; without BLAS as `inner`."""
    by_numpy = library is None
    result: Array = (
        np.einsum("ik,kj->ij", left, right) if by_numpy else library.product(left, right)
    )
    return result


def scaled(team: Team, field: Array) -> tuple[Single, float]:
    """A field in units of its largest magnitude, and the unit; 1 for a field of zeros."""
    unit = largest(team, field)
    unit = unit if unit >= np.finfo(np.float64).tiny else 1.0
    return in_single(team, field, unit), unit


def in_single(team: Team, field: Array, unit: float) -> Single:
    """A field in some unit, in single precision."""
    result = np.empty(field.shape, np.float32)
    times(team, field, 1.0 / unit, result)
    return result


@_shared(max)
def largest(field: Array | Single) -> float:
    """Largest magnitude in a field."""
    return max(float(field.max()), -float(field.min()))


@_shared()
def times(field: Array | Single, factor: Single | float, result: Single) -> None:
    """Multiply a field by another one or by a number."""
    np.multiply(field, factor, out=result, casting="same_kind")


# Conjugate gradients.


@_shared(sum)
def project_mean(shift: float, inside: Single, residual: Single) -> float:
    """Subtract ``shift`` from a residual; return the sum of its squares where ``inside`` is 1."""
    residual -= np.float32(shift)
    return inner.in_numpy(residual * inside, residual)


@_shared(sum)
def add_layer(tangent: Single | None, direction: Single, force: Single) -> float:
    """Add tangent times direction to a force; return the inner product of direction and force."""
    if tangent is not None:
        force += tangent * direction
    return inner.in_numpy(direction, force)


@_shared(sum)
def advance(
    length: float,
    direction: Single,
    force: Single,
    weight: Single,
    pressure: Single,
    residual: Single,
) -> float:
    """Add a direction to a pressure, take its force from a residual; weight times residual."""
    pressure += np.float32(length) * direction
    residual -= np.float32(length) * force
    return inner.in_numpy(weight, residual)


@_shared(sum)
def weigh(weight: Single, residual: Single, field: Single) -> float:
    """Multiply a field by a weight; return its inner product with a residual."""
    field *= weight
    return inner.in_numpy(residual, field)


@_shared()
def update_direction(factor: float, field: Single, direction: Single) -> None:
    """Form the next direction: ``field`` plus a multiple of the last one."""
    direction *= np.float32(factor)
    direction += field


@_shared(max)
def recover_displacement(
    start: Single, tangent: Single | None, pressure: Single, shift: float, residual: Single
) -> float:
    """Replace a residual by the half-space displacement of the pressure that led to it.

    The displacement is ``start``, the residual before, minus the residual, a shift and the part of
    the tangent. Returned is the largest magnitude of the displacement.
    """
    np.subtract(start, residual, out=residual)
    residual -= np.float32(shift)
    if tangent is not None:
        residual -= tangent * pressure
    return max(float(residual.max()), -float(residual.min()))


# The active set.


@_shared(sum, sum)
def scale_and_clip(
    factor: float, limit: float, rigid: float, weights: Array | None, pressure: Array
) -> tuple[float, float]:
    """Scale a pressure and clip it to 0 … ``limit``, except on cells at ``rigid`` or above.

    Returned are the weighted sums of the pressure and of the cells at the limit.
    """
    fixed = pressure >= rigid
    np.copyto(pressure, np.clip(pressure * factor, 0.0, limit), where=~fixed)
    saturated = pressure >= limit
    if weights is None:
        return float(pressure.sum()), float(np.count_nonzero(saturated))
    return inner.in_numpy(weights, pressure), float(weights.sum(where=saturated))


@_shared(sum, sum, max)
def level(
    limit: float, separation: Array, displacement: Array, pressure: Array
) -> tuple[float, float, float]:
    """Sum of separations and count of cells with 0 < p < ``limit``; largest displacement of all."""
    free = (pressure > 0) & (pressure < limit)
    count = float(np.count_nonzero(free))
    return float(separation.sum(where=free)), count, float(displacement.max())


@_shared(max, sum)
def evaluate(
    separation: Array,
    pressure: Array,
    limit: float,
    approach: float,
    slack: float,
    gap: Array,
    free: Mask,
) -> tuple[float, float]:
    """Gap of a pressure, its violation of the conditions, and the cells to free.

    Those are the cells between the bounds, those at zero that interpenetrate, and those at the
    limit that separate, both by more than a margin. Returned are the largest violation of g = 0
    between the bounds, of g ≥ 0 where p = 0 and of g ≤ 0 at the limit, and the sum of all gaps,
    which tells of values that are not numbers.
    """
    open_, saturated = pressure <= 0, pressure >= limit
    np.logical_or(open_, saturated, out=free)
    np.logical_not(free, out=free)
    np.subtract(separation, approach, out=gap)
    violation = np.abs(gap)
    np.copyto(violation, gap, where=saturated)
    np.negative(gap, out=violation, where=open_)
    free |= (open_ & (gap < -slack)) | (saturated & (gap > slack))
    return max(float(violation.max()), 0.0), float(gap.sum())


@_shared(min, max, sum)
def scale_step(
    pressure: Array,
    gap: Array,
    found: Single,
    unit: float,
    uniform: Single,
    share: float,
    step: Array,
) -> tuple[float, float, float]:
    """The step ``found`` times a unit minus a fraction of a uniform one.

    Returned are the lowest and highest pressure that it leads to and its product with the gap.
    """
    np.multiply(found, unit, out=step, dtype=np.float64)
    step -= np.multiply(uniform, share, dtype=np.float64)
    target = pressure + step
    return float(target.min()), float(target.max()), inner.in_numpy(step, gap)


@_shared(sum, sum)
def descent(gap: Array, step: Array) -> tuple[float, float]:
    """Inner products of gap and step, and of their magnitudes."""
    product = gap * step
    return float(product.sum()), float(np.abs(product).sum())


@_shared()
def move(
    fraction: float,
    step: Array,
    limit: float,
    moved: Single,
    unit: float,
    offset: float,
    shape: Array,
    pressure: Array,
    displacement: Array,
    separation: Array,
) -> None:
    """Add a fraction of a step to a pressure, and its displacement to the displacement.

    That is ``moved`` in some unit, plus an offset. Rounding never leads beyond 0 and ``limit``. The
    separation becomes displacement plus shape.
    """
    pressure += fraction * step
    np.clip(pressure, 0.0, limit, out=pressure)
    displacement += np.multiply(moved, fraction * unit, dtype=np.float64)
    displacement += fraction * offset
    np.add(displacement, shape, out=separation)


# The wear of a stage, see `fretwear.mechanics.slip.WearLayer`; by blocks of rows, which stay in a
# core's cache from one operation to the next.


@_shared()
def wear(
    pressure: Array,
    rate: float,
    known: Array,
    start: Array,
    reduced_gap: Array,
    shift: Array | None,
    result: Array,
) -> None:
    """Add the wear depth: W₀ plus (eˣ − 1) g*₀ + ΔG (φ(x) − 1), if not negative."""
    for rows in blocks_of_rows(pressure.shape, _BLOCK):
        x = _exponent(pressure[rows], rate, known[rows])
        growth = np.expm1(x)
        worn = growth * reduced_gap[rows]
        if shift is not None:
            # φ − 1 = (eˣ − 1 − x)/x, and zero at zero.
            growth -= x
            np.maximum(x, _TINY, out=x)
            growth /= x
            growth *= shift[rows]
            worn += growth
            np.maximum(worn, 0.0, out=worn)
        worn += start[rows]
        result[rows] += worn


@_shared()
def wear_slope(
    pressure: Array,
    rate: float,
    known: Array,
    reduced_gap: Array,
    shift: Array | None,
    factor: float,
    result: Single,
) -> None:
    """The derivative of `wear` by the exponent, times a factor, not negative."""
    for rows in blocks_of_rows(pressure.shape, _BLOCK):
        x = _exponent(pressure[rows], rate, known[rows])
        if shift is None:
            np.exp(x, out=x)
            slope = x * reduced_gap[rows]
        else:
            # φ' = (eˣ − φ)/x loses its digits near zero, where it is a line of slope 1/3.
            below = np.minimum(x, _SMALL)
            below -= _SMALL
            np.maximum(x, _SMALL, out=x)
            growth = np.expm1(x)
            slope = growth + 1.0
            slope *= reduced_gap[rows]
            phi_slope = x - growth
            phi_slope /= x
            phi_slope += growth
            phi_slope /= x
            below /= 3.0
            phi_slope += below
            phi_slope *= shift[rows]
            slope += phi_slope
            np.maximum(slope, 0.0, out=slope)
        slope *= factor
        result[rows] = np.minimum(slope, _LARGEST_SLOPE, out=slope)


def _exponent(pressure: Array, rate: float, known: Array) -> Array:
    x = rate * pressure
    x += known
    return np.minimum(x, _LARGEST_EXPONENT, out=x)
