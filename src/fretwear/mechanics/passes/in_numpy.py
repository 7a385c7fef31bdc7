"""The passes in NumPy: what the compiled ones are to compute.

Fields are contiguous and, unless said otherwise, of one shape. A field that a pass changes is its
last argument or named in its first line; no pass keeps a field.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fretwear.mechanics.arrays import Array, Mask, Real, Single, blocks_of_rows

__all__ = [
    "blend",
    "carrying",
    "descent",
    "follow",
    "inner",
    "judge",
    "lower",
    "move",
    "propose",
    "relative",
    "respond",
    "scaled",
    "settle",
    "shares",
    "to_free",
    "total",
    "turn",
    "wear",
    "wear_slope",
    "weighed",
]

_LARGEST_EXPONENT = 200.0
_LARGEST_SLOPE = 1e30
_TINY = 1e-12
_SMALL = 3e-5
_BLOCK = 2**14
# Free cells that carry less of the load than this cannot be scaled to carry what is missing.
_NOTHING = 1e-12
_LARGEST_SCALINGS = 100


# Conjugate gradients.


def inner(a: Real, b: Real) -> float:
    """Sum of the products of two fields.

    Not by BLAS: its threads gain nothing here, stand in the way of cases that run side by side,
    and make the last bits depend on their number.
    """
    return float(np.einsum("ij,ij->", a, b))


def total(field: Single) -> float:
    """Sum of a field, in double precision."""
    return float(field.sum(dtype=np.float64))


def relative(field: Array, unit: float, inside: Single) -> Single:
    """A field in some unit on the cells where ``inside`` is 1, zero where it is 0."""
    result = (field / unit).astype(np.float32)
    result *= inside
    return result


def scaled(field: Array) -> tuple[Single, float]:
    """A field in units of its largest magnitude, and the unit; 1 for a field of zeros."""
    unit = max(float(field.max()), -float(field.min())) or 1.0
    return (field / unit).astype(np.float32), unit


def lower(shift: float, inside: Single, residual: Single) -> float:
    """Take ``shift`` from a residual; the sum of its squares where ``inside`` is 1."""
    residual -= np.float32(shift)
    return inner(residual * inside, residual)


def weighed(weight: Single, corner: tuple[int, int], field: Single) -> Single:
    """Product of a weight and the part of a field of its shape that begins at ``corner``."""
    (x, y), (nx, ny) = corner, weight.shape
    result: Single = weight * field[x : x + nx, y : y + ny]
    return result


def shares(tangent: Single, mean: float, turn: float) -> tuple[Single, Single]:
    """Weights of a mean layer and of none where the tangent of the layer is given.

    The square of the layer's grows with the tangent from none to all at the mean, the sooner the
    smaller ``turn`` is, and falls again above; the other one is what lacks to one, none above.
    """
    share = tangent / (tangent + np.float32(turn))
    share *= np.float32((mean + turn) / mean)
    np.minimum(share, 1.0, out=share)
    hard = np.sqrt(1.0 - share)
    share *= np.minimum(np.float32(mean + 1.0) / (tangent + 1.0), 1.0)
    return np.sqrt(share, out=share), hard


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


def turn(factor: float, field: Single, direction: Single) -> None:
    """The next direction: ``field`` plus a multiple of the last one."""
    direction *= np.float32(factor)
    direction += field


def respond(tangent: Single | None, direction: Single, force: Single) -> float:
    """Add tangent times direction to a force; the inner product of direction and force."""
    if tangent is not None:
        force += tangent * direction
    return inner(direction, force)


def follow(
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


def settle(
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


def judge(
    separation: Array, displacement: Array, pressure: Array, limit: float, gap: Array
) -> tuple[float, float, float, float]:
    """Approach and gap of a pressure and what they violate.

    Returns
    -------
    Approach, the separation of the cells with 0 < p < ``limit`` in the mean, or if there are none
    the largest of those at the limit; the largest violation of g = 0 there, of g ≥ 0 where p = 0
    and of g ≤ 0 at the limit; the largest displacement; the sum of all gaps, which tells of values
    that are not numbers.
    """
    open_, saturated = pressure <= 0, pressure >= limit
    free = ~(open_ | saturated)
    approach = np.mean(separation, where=free) if free.any() else separation[saturated].max()
    np.subtract(separation, approach, out=gap)
    violation = np.abs(gap)
    np.copyto(violation, gap, where=saturated)
    np.negative(gap, out=violation, where=open_)
    worst = max(float(violation.max()), 0.0)
    return float(approach), worst, float(displacement.max()), float(gap.sum())


def to_free(pressure: Array, limit: float, gap: Array, slack: float) -> Mask:
    """Cells between the bounds, those at zero that interpenetrate, those at the limit that part.

    Both by more than ``slack``.
    """
    free: Mask = np.where(
        pressure <= 0, gap < -slack, np.where(pressure >= limit, gap > slack, True)
    )
    return free


def propose(
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


def carrying(pressure: Array, limit: float, total: float) -> Array:
    """The pressure cut to the bounds, its free cells scaled so that its sum is ``total``, Pa.

    Scaling leaves open cells open and saturated cells saturated; a shift would free them.
    """
    result = np.clip(pressure, 0.0, limit)
    for _ in range(_LARGEST_SCALINGS):
        carried = float(result.sum())
        missing = total - carried
        if abs(missing) <= 1e-14 * total:
            break
        saturated = result >= limit
        count = np.count_nonzero(saturated)
        movable = carried - limit * count if count else carried
        if movable <= -missing:
            # Saturated cells have to give way too.
            result *= total / carried
        elif movable <= _NOTHING * carried:
            # All loaded cells are at the limit and still do not carry the load.
            np.maximum(result, 1e-3 * limit, out=result)
        else:
            result *= 1.0 + missing / movable
            np.minimum(result, limit, out=result)
            np.copyto(result, limit, where=saturated)
    return result


# The wear of a stage, see `fretwear.mechanics.layers.WearLayer`; by blocks of rows, which stay in
# a core's cache from one operation to the next.


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
    for rows in _blocks(pressure):
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
    result: Real,
) -> None:
    """The derivative of `wear` by the exponent, times a factor, not negative; any precision."""
    for rows in _blocks(pressure):
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


def _blocks(field: Array) -> Iterator[slice]:
    yield from blocks_of_rows(field.shape, _BLOCK)
