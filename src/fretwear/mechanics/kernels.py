"""Arithmetic on the cells between two transforms, where going over them once pays.

Each function is here in NumPy. The same functions, compiled from ``kernels.cpp`` when the package
is installed where there is a C++ compiler, go over their fields once, where NumPy goes over them
once for each operation; they take the place of these. `COMPILED` tells whether they do, `IN_NUMPY`
keeps these.

Fields are contiguous and of one shape unless said otherwise. A field that a function changes is
its last argument or named in its first line; no function keeps a field.
"""

from __future__ import annotations

from importlib import import_module

import numpy as np

from fretwear.mechanics.geometry import Array, Mask, Real, Single

_LARGEST_EXPONENT = 200.0
_LARGEST_SLOPE = 1e30
_TINY = 1e-12
_SMALL = 3e-5
_BLOCK = 2**14


def inner(a: Real, b: Real) -> float:
    """Sum of the products of two fields.

    Not by BLAS: its threads gain nothing here, stand in the way of cases that run side by side,
    and make the last bits depend on their number.
    """
    return float(np.einsum("ij,ij->", a, b))


def total(field: Single) -> float:
    """Sum of a field, in double precision."""
    return float(field.sum(dtype=np.float64))


def blocks_of_rows(shape: tuple[int, ...], cells: int) -> list[slice]:
    """The rows of a field in blocks of so many cells at most, but of one row at least.

    What is done to a block, one operation after the other, stays in a core's cache.
    """
    count, length = shape
    rows = max(1, cells // length)
    return [slice(first, min(first + rows, count)) for first in range(0, count, rows)]


def scaled(field: Array) -> tuple[Single, float]:
    """A field in units of its largest magnitude, and the unit; 1 for a field of zeros."""
    unit = max(float(field.max()), -float(field.min()))
    unit = unit if unit >= np.finfo(np.float64).tiny else 1.0
    return in_single(field, unit), unit


def in_single(field: Array, unit: float) -> Single:
    """A field in some unit, in single precision."""
    return np.multiply(field, 1.0 / unit, dtype=np.float64).astype(np.float32)


# Conjugate gradients.


def project_mean(shift: float, inside: Single, residual: Single) -> float:
    """Take ``shift`` from a residual; the sum of its squares where ``inside`` is 1."""
    residual -= np.float32(shift)
    return inner(residual * inside, residual)


def add_layer(tangent: Single | None, direction: Single, force: Single) -> float:
    """Add tangent times direction to a force; the inner product of direction and force."""
    if tangent is not None:
        force += tangent * direction
    return inner(direction, force)


def advance(
    length: float,
    direction: Single,
    force: Single,
    weight: Single,
    pressure: Single,
    residual: Single,
) -> float:
    """Go along a direction: add to a pressure, take the force from a residual.

    Returns
    -------
    The inner product of ``weight`` and the residual.
    """
    pressure += np.float32(length) * direction
    residual -= np.float32(length) * force
    return inner(weight, residual)


def blend(
    weight: Single,
    inner_weight: Single | None,
    inner_field: Single | None,
    corner: tuple[int, int],
    residual: Single,
    field: Single,
) -> float:
    """Multiply a field by a weight and add another with its own; its inner product with a residual.

    The other field and its weight are those of a part of the cells, which begins at ``corner``.
    """
    field *= weight
    if inner_field is not None and inner_weight is not None:
        (x, y), (nx, ny) = corner, inner_field.shape
        field[x : x + nx, y : y + ny] += inner_weight * inner_field
    return inner(residual, field)


def update_direction(factor: float, field: Single, direction: Single) -> None:
    """The next direction: ``field`` plus a multiple of the last one."""
    direction *= np.float32(factor)
    direction += field


def recover_displacement(
    start: Single, tangent: Single | None, pressure: Single, shift: float, residual: Single
) -> float:
    """Put the half-space's displacement of a pressure in the place of the residual it leaves.

    Of ``start``, the residual before, the half-space took all but the residual, a shift and the
    tangent's part.

    Returns
    -------
    The largest magnitude of the displacement.
    """
    np.subtract(start, residual, out=residual)
    residual -= np.float32(shift)
    if tangent is not None:
        residual -= tangent * pressure
    return max(float(residual.max()), -float(residual.min()))


# The active set.


def scale_and_clip(
    factor: float, limit: float, rigid: float, weights: Array | None, pressure: Array
) -> tuple[float, float]:
    """Scale a pressure and cut it to 0 … ``limit``, except on cells at ``rigid`` or above.

    Returns
    -------
    The weighted sums of the pressure and of the cells at the limit.
    """
    fixed = pressure >= rigid
    np.copyto(pressure, np.clip(pressure * factor, 0.0, limit), where=~fixed)
    saturated = pressure >= limit
    if weights is None:
        return float(pressure.sum()), float(np.count_nonzero(saturated))
    return inner(weights, pressure), float(weights.sum(where=saturated))


def evaluate(
    separation: Array,
    displacement: Array,
    pressure: Array,
    limit: float,
    approach: float,
    margin: float,
    gap: Array,
    free: Mask,
) -> tuple[float, float, float, float]:
    """Approach and gap of a pressure, what they violate, and which cells are to be free.

    Those are the cells between the bounds, the ones at zero that interpenetrate and the ones at
    the limit that part, both by more than ``margin`` times the largest displacement.

    Returns
    -------
    Approach: as given, or if that is not a number, the separation of the cells with
    0 < p < ``limit`` in the mean, or if there are none the largest of those at the limit; the
    largest violation of g = 0 there, of g ≥ 0 where p = 0 and of g ≤ 0 at the limit; the largest
    displacement; the sum of all gaps, which tells of values that are not numbers.
    """
    open_, saturated = pressure <= 0, pressure >= limit
    np.logical_or(open_, saturated, out=free)
    np.logical_not(free, out=free)
    if np.isnan(approach):
        level = np.mean(separation, where=free) if free.any() else separation[saturated].max()
        approach = float(level)
    np.subtract(separation, approach, out=gap)
    violation = np.abs(gap)
    np.copyto(violation, gap, where=saturated)
    np.negative(gap, out=violation, where=open_)
    worst, scale = max(float(violation.max()), 0.0), float(displacement.max())
    free |= (open_ & (gap < -margin * scale)) | (saturated & (gap > margin * scale))
    return approach, worst, scale, float(gap.sum())


def scale_step(
    pressure: Array,
    gap: Array,
    found: Single,
    unit: float,
    uniform: Single,
    share: float,
    step: Array,
) -> tuple[float, float, float]:
    """The step ``found`` times a unit minus a share of a uniform one.

    Returns
    -------
    The lowest and the highest pressure that it leads to, and its inner product with the gap.
    """
    np.multiply(found, unit, out=step, dtype=np.float64)
    step -= np.multiply(uniform, share, dtype=np.float64)
    target = pressure + step
    return float(target.min()), float(target.max()), inner(step, gap)


def descent(gap: Array, step: Array) -> tuple[float, float]:
    """Inner products of gap and step, and of their magnitudes."""
    product = gap * step
    return float(product.sum()), float(np.abs(product).sum())


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
    """Add a fraction of a step to a pressure, and what it moves to the displacement.

    That is ``moved`` in some unit, plus an offset. Rounding does not lead beyond 0 and ``limit``.
    The separation becomes displacement plus shape.
    """
    pressure += fraction * step
    np.clip(pressure, 0.0, limit, out=pressure)
    displacement += np.multiply(moved, fraction * unit, dtype=np.float64)
    displacement += fraction * offset
    np.add(displacement, shape, out=separation)


# The wear of a stage, see `fretwear.mechanics.slip.WearLayer`; by blocks of rows, which stay in a
# core's cache from one operation to the next.


def wear(
    pressure: Array,
    rate: float,
    known: Array,
    start: Array,
    reduced_gap: Array,
    shift: Array | None,
    result: Array,
) -> None:
    """Add the wear depth: W₀ and what wears off, (eˣ − 1) g*₀ + ΔG (φ(x) − 1), not negative."""
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


IN_NUMPY = {
    each.__name__: each
    for each in (
        inner, total, project_mean, blend, update_direction, add_layer, advance,
        recover_displacement, scale_and_clip, evaluate, scale_step, descent, move, wear, wear_slope,
    )
}  # fmt: skip
try:
    _compiled = import_module("fretwear.mechanics.compiled_kernels")
    COMPILED = True
except ImportError:
    COMPILED = False
else:
    globals().update({name: getattr(_compiled, name) for name in IN_NUMPY})
