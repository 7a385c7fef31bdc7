"""Put a label beside each curve, where it touches nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.text import Text
from numpy.typing import NDArray
from scipy import ndimage

from fretwear.figures.style import text_colour

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_MARGIN = 2
_REACH = 7.0
_CLARITY = 5.0
_INDISTINCT = 2.0
_MARK = 3


@dataclass(frozen=True)
class Curve:
    """A curve to label.

    Parameters
    ----------
    x, y : array of shape (n,)
        The curve in data coordinates.
    label : str
        Its label.
    color : str
        Colour of the curve; that of the label is as dark as text needs.
    is_marked : bool
        Whether its points have marks, which labels must leave free too.
    """

    x: Array
    y: Array
    label: str
    color: str
    is_marked: bool = False


@dataclass(frozen=True)
class _Place:
    row: int
    column: int
    cost: float


def label_curves(axes: Axes, curves: Sequence[Curve]) -> bool:
    """Label every curve beside itself, or none of them.

    A place is taken when the text box is clear of all curves and labels, and nearer to its own
    curve than to any other. Call this last, when limits and labels of the axes are final.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Axes that show the curves.
    curves : sequence of Curve
        The curves to label.

    Returns
    -------
    bool
        Whether there was room; if not, nothing was added and a legend is called for.
    """
    figure = axes.get_figure(root=True)
    if figure is None:
        raise ValueError("The axes belong to no figure.")
    figure.draw_without_rendering()
    width, height = (int(size) for size in axes.bbox.size)
    curves, drawn = _joined(curves, [_rasterise(axes, c, (height, width)) for c in curves])
    sizes = [_text_size(axes, curve) for curve in curves]
    places = _best_order(drawn, sizes)
    if places is None:
        return False
    for curve, place in zip(curves, places, strict=True):
        position = ((place.column + 0.5) / width, (place.row + 0.5) / height)
        _add_text(axes, curve, position)
    return True


def _add_text(axes: Axes, curve: Curve, position: tuple[float, float]) -> Text:
    text = axes.text(
        *position,
        curve.label,
        color=text_colour(curve.color),
        fontsize=6.5,
        ha="center",
        va="center_baseline",
    )
    text.set_transform(axes.transAxes)
    text.set_in_layout(False)
    return text


def _text_size(axes: Axes, curve: Curve) -> tuple[int, int]:
    probe = _add_text(axes, curve, (0.5, 0.5))
    box = probe.get_window_extent()
    probe.remove()
    return int(np.ceil(box.height)) + 2 * _MARGIN, int(np.ceil(box.width)) + 2 * _MARGIN


def _rasterise(axes: Axes, curve: Curve, shape: tuple[int, int]) -> Mask:
    """Return the pixels of the axes that a curve covers, row 0 at the bottom."""
    mask = np.zeros(shape, dtype=bool)
    points = axes.transData.transform(np.column_stack([curve.x, curve.y])) - axes.bbox.p0
    for start, end in pairwise(points):
        if not (np.isfinite(start).all() and np.isfinite(end).all()):
            continue
        steps = int(min(np.abs(end - start).max(), 4.0 * max(shape))) + 2
        path = np.rint(np.linspace(start, end, steps)).astype(np.int64)
        inside = (path >= 0).all(axis=1) & (path[:, 1] < shape[0]) & (path[:, 0] < shape[1])
        mask[path[inside, 1], path[inside, 0]] = True
    if curve.is_marked:
        for column, row in np.rint(points[np.isfinite(points).all(axis=1)]).astype(np.int64):
            low_row, low_column = max(row - _MARK, 0), max(column - _MARK, 0)
            mask[low_row : row + _MARK + 1, low_column : column + _MARK + 1] = True
    return mask


def _joined(curves: Sequence[Curve], drawn: Sequence[Mask]) -> tuple[list[Curve], list[Mask]]:
    """Give successive curves that cannot be told apart one label, in the last one's colour."""
    kept: list[Curve] = []
    masks: list[Mask] = []
    for curve, mask in zip(curves, drawn, strict=True):
        if kept and _coincide(masks[-1], mask):
            curve = replace(curve, label=f"{kept.pop().label}, {curve.label}")
            mask = mask | masks.pop()
        kept.append(curve)
        masks.append(mask)
    return kept, masks


def _coincide(first: Mask, second: Mask) -> bool:
    if not (first.any() and second.any()):
        return False
    apart = max(_distance(first)[second].max(), _distance(second)[first].max())
    return bool(apart <= _INDISTINCT)


def _best_order(drawn: Sequence[Mask], sizes: Sequence[tuple[int, int]]) -> list[_Place] | None:
    """Place labels first to last and last to first; return the cheaper complete result."""
    count = len(drawn)
    distances = [_distance(mask) for mask in drawn]
    results = []
    for order in (list(range(count)), list(reversed(range(count)))):
        placed = _place_all(order, distances, sizes)
        if placed is not None:
            results.append(placed)
    return min(results, key=lambda places: sum(p.cost for p in places), default=None)


def _place_all(
    order: Sequence[int],
    distances: Sequence[Array],
    sizes: Sequence[tuple[int, int]],
) -> list[_Place] | None:
    taken = np.zeros_like(distances[0], dtype=bool)
    nowhere = np.full_like(distances[0], np.inf)
    places: dict[int, _Place] = {}
    for index in order:
        foreign = [d for other, d in enumerate(distances) if other != index] + [nowhere]
        place = _place_one(
            distances[index], np.minimum.reduce(foreign), _distance(taken), sizes[index]
        )
        if place is None:
            return None
        places[index] = place
        height, width = sizes[index]
        row, column = place.row - height // 2, place.column - width // 2
        taken[max(row, 0) : row + height, max(column, 0) : column + width] = True
    return [places[index] for index in range(len(order))]


def _place_one(own: Array, foreign: Array, labels: Array, size: tuple[int, int]) -> _Place | None:
    """Return the best centre for a box of `size` pixels, by distances of curves and labels."""
    height, width = size
    if own.shape[0] <= height or own.shape[1] <= width:
        return None
    nearest_own = ndimage.minimum_filter(own, size=size)
    nearest_foreign = ndimage.minimum_filter(foreign, size=size)
    nearest_label = ndimage.minimum_filter(labels, size=size)
    possible = (nearest_own > 0.5) & (nearest_own < _REACH) & (nearest_label > 2.0)
    possible &= nearest_foreign > np.maximum(1.5, nearest_own)
    rows, columns = height // 2 + 1, width // 2 + 1
    inside = np.zeros_like(possible)
    inside[rows:-rows, columns:-columns] = True
    possible &= inside
    if not possible.any():
        return None
    clarity = np.minimum(nearest_foreign, _CLARITY * 3.0)
    cost = nearest_own - 0.6 * clarity - 0.1 * np.minimum(nearest_label, 12.0)
    cost = np.where(possible, cost, np.inf)
    row, column = np.unravel_index(int(np.argmin(cost)), cost.shape)
    return _Place(int(row), int(column), float(cost[row, column]))


def _distance(mask: Mask) -> Array:
    """Return each pixel's distance from the nearest covered one."""
    if not mask.any():
        return np.full(mask.shape, float(max(mask.shape)))
    return np.asarray(ndimage.distance_transform_edt(~mask), dtype=np.float64)
