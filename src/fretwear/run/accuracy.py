"""Errors estimated from runs on wider cells, and how wide cells may be for an accuracy."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from fretwear.study.case import Case
from fretwear.study.doubts import Unreached
from fretwear.study.plan import USUAL_BUDGET, affordable_width
from fretwear.study.spacing import LEAST_RATIO, WIDEST
from fretwear.vocabulary import RESULTS

# Standard deviations in an estimated error, chosen on half of the cases of the verification page.
_DEVIATIONS = 2.0
# Values below this part of the largest have just begun to grow, and do not represent the others.
_TRACE = 0.01
# Words in the names of scalars that follow from the edges of contact and stick. These lie somewhere
# in a cell, so that now and then a scalar is the same in both runs, even throughout an elastic run,
# or jumps by a row of asperities: half the upper quartile over all of these scalars is the least
# difference that counts.
_OF_EDGES, _OF_OTHERS = ("area", "half_width", "radius", "stick"), 0.5
# Words in the names of scalars that add up over steps or follow from the worn shape, and their
# standard deviation due to steps, over the tolerance: volumes and energies on rings, strips and
# grids differ from runs at a tenth of the tolerance by 0.03 to 0.14 of it.
_OF_STEPS, _STEPPING = ("wear", "plastic", "energy", "sliding"), 0.05


# Results that an accuracy is asked for, where a case has them.
ASKED = (
    "wear_volume",
    "maximum_wear_depth",
    "contact_radius",
    "stick_radius",
    "scar_half_width_x",
    "scar_half_width_y",
    "contact_area",
    "stick_area",
    "dissipated_energy",
)
# Orders of convergence lie between these: edges that fall somewhere in a cell, and smooth fields.
_LEAST_ORDER, _MOST_ORDER, _USUAL_ORDER = 0.5, 1.5, 1.0
# An error that falls by less than this from one run to the next does not fall with the cells.
_FALLING = 1.2
# Share of the accuracy that the next run aims at.
_AIM = 0.8
_MOST_RATIO = 4.0  # of the widths of two runs from which errors are estimated
# Cells along two axes, or matrices of cells, make each step dearer by at least this power. From the
# second run to the third, work has grown by up to 0.5 more than from the first to the second.
_LEAST_GROWTH, _FASTER = 2.0, 0.5


@dataclass(frozen=True)
class GridRun:
    """A finished run on cells of one width."""

    width: float  # of its cells over the default
    rows: list[dict[str, float]]  # every scalar at each snapshot
    # The largest relative error of each result that an accuracy is asked for; none if unknown.
    errors: dict[str, float]
    # Counted, so that it is the same on every machine: `RunRecord.work`; 0 for a run alongside.
    work: float = 0.0

    @property
    def error(self) -> float:
        """The largest relative error."""
        return max(self.errors.values(), default=math.inf)


def columns_of(rows: Sequence[Mapping[str, float]]) -> dict[str, NDArray[np.float64]]:
    """Return the values by name of rows that have the same names."""
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def next_width(case: Case, rounds: Sequence[GridRun]) -> float | None:
    """Return the width of cells over the default for the next run of a case; None: it is done.

    A case that asks for an accuracy begins on cells wider by `WIDEST`, and goes on with default
    ones if it has not reached the accuracy. If these do not reach it either, a last run has cells
    as narrow as the errors and the order at which they have fallen let expect. It is not begun if
    such cells would take more than the rest of the budget, or if some error beyond the accuracy
    has not fallen: the half-width of a rough contact jumps by a row of asperities.
    """
    accuracy = case.asked_accuracy
    if accuracy is None:
        return None if rounds else 1.0
    if not rounds:
        return WIDEST
    last = rounds[-1]
    if last.error <= accuracy or last.width < 1.0:
        return None
    if last.width > 1.0:
        return 1.0
    if not last.errors:
        return None
    order = measured_order(rounds)
    narrowest = max(
        (_left(case, rounds) / last.work) ** (-1.0 / _growth(rounds)),
        affordable_width(case, math.inf),
        1.0 / _MOST_RATIO,
    )
    width = 1.0 / max((last.error / (_AIM * accuracy)) ** (1.0 / order), LEAST_RATIO)
    return width if width >= narrowest and not _unfallen(rounds, accuracy) else None


def _unfallen(rounds: Sequence[GridRun], accuracy: float) -> list[str]:
    """The results whose error is beyond the accuracy and has not fallen from the run before."""
    if len(rounds) < 2:
        return []
    before, last = rounds[-2].errors, rounds[-1].errors
    missed = ((name, error) for name, error in last.items() if error > accuracy)
    return [name for name, error in missed if _FALLING * error > before.get(name, math.inf)]


def _left(case: Case, rounds: Sequence[GridRun]) -> float:
    """Work that the budget of a case leaves after the run on default cells, at least as much."""
    usual = rounds[-1].work
    return max((case.budget or USUAL_BUDGET) * usual - sum(run.work for run in rounds), usual)


def _growth(rounds: Sequence[GridRun]) -> float:
    """Power of the inverse width of cells by which work grows, from the first two runs."""
    grown, runs = _LEAST_GROWTH, [run for run in rounds if run.work]
    if len(runs) > 1:  # one, if cells wider than the default ones have failed
        wide, narrow, *_ = runs
        grown = math.log(narrow.work / wide.work) / math.log(wide.width / narrow.width)
    return max(grown, _LEAST_GROWTH) + _FASTER


def relative_errors(
    scalars: Mapping[str, NDArray[np.float64]], errors: Mapping[str, NDArray[np.float64]]
) -> dict[str, float]:
    """Return the largest relative errors of the results in `ASKED`.

    Values that have just begun to grow do not count, and the energy of a contact that wears in
    counts relative to its largest value.
    """
    relative: dict[str, float] = {}
    for name in (name for name in ASKED if name in errors):
        values, apart = (np.nan_to_num(np.abs(of[name])) for of in (scalars, errors))
        counts = values > _TRACE * values.max()
        if counts.any():
            sizes = values.max() if name == "dissipated_energy" else values[counts]
            relative[name] = float((apart[counts] / sizes).max())
    return relative


def unreached(case: Case, rounds: Sequence[GridRun]) -> Unreached | None:
    """Return what a case has reached instead of its accuracy, and what that would cost."""
    accuracy, last = case.asked_accuracy, rounds[-1]
    if accuracy is None or not last.errors or last.error <= accuracy:
        return None
    narrower = (last.error / (_AIM * accuracy)) ** (1.0 / measured_order(rounds))
    before = [run.work for run in rounds if run.width >= 1.0]
    times = (sum(before) + last.work * narrower ** _growth(rounds)) / before[-1]
    name = max(last.errors, key=lambda name: last.errors[name], default="")
    words = RESULTS[name].words if name else "no estimate"
    unfallen = [RESULTS[result].words for result in _unfallen(rounds, accuracy)]
    cell = None
    if times <= (case.budget or USUAL_BUDGET):
        # Not for want of budget: it was not begun, or was the last run of all.
        dx, dy = case.grid_spacing
        cell = last.width / narrower * dx, last.width / narrower * dy
    return Unreached(accuracy, words, last.error, times, unfallen, cell)


def on_same_tips(
    scalars: Mapping[str, NDArray[np.float64]],
    coarser: Mapping[str, NDArray[np.float64]],
    wavelengths: tuple[float, float] | None,
) -> Mapping[str, NDArray[np.float64]]:
    """Return the values of a coarser run, but no half-widths that end at another tip.

    Such half-widths differ by about a distance of tips along x or y, the ``wavelengths``, m, of a
    rough surface, and say nothing of the edge of the outermost tip: the run's own value takes their
    place. Whether that edge may jump to another tip follows from the gap of the run itself, see
    `fretwear.mechanics.wear.measures.scatter`.
    """
    if wavelengths is None:
        return coarser
    comparable = dict(coarser)
    for zone, axis in product(("contact", "stick"), (0, 1)):
        name = f"{zone}_half_width_{'xy'[axis]}"
        jumps = np.abs(scalars[name] - coarser[name]) > 0.5 * wavelengths[axis]
        comparable[name] = np.where(jumps, scalars[name], coarser[name])
    return comparable


def estimated_errors(
    scalars: Mapping[str, NDArray[np.float64]],
    coarser: Mapping[str, NDArray[np.float64]],
    times: float,
    spread: Mapping[str, NDArray[np.float64]],
    tolerance: float,
    order: float = 1.0,
    lower: Mapping[str, float] = MappingProxyType({}),
) -> dict[str, NDArray[np.float64]]:
    """Estimate how far results are from the limit of infinitely narrow cells and short steps.

    The scalars by name at the snapshots, shape (n,), belong to a run and to its twin, whose cells
    are some times wider. The estimates have the same names, shapes and units.

    Where the cells are k times wider and the tolerance is k² times larger, results differ by k − 1
    times the error of the run if errors grow with the width of a cell, and by √(k² + 1) times its
    standard deviation if they follow from where edges happen to fall in cells. √(k² − 1) lies
    between; k^order takes the place of k, where `order` holds for all results but the `lower` ones
    by name.

    The difference of two runs at one snapshot may be small by chance: the median over the
    snapshots of the difference relative to the value counts if it is larger. It is the median of
    logarithms, so that a hard snapshot beside an easy one does not count for both. A value missing
    in one of the two runs, NaN, counts as zero; if the run itself has none, there is no error.

    A falling value, such as the energy of a contact that wears in, is the rest of a larger one: its
    relative error is no smaller than before. Two runs that agree again merely cross.

    Two runs may differ by less than the uncertainty due to cells alone, above all if the edges do
    not move from one snapshot to the next: the standard deviations that edges within cells cause,
    `scatter`, are a lower bound. So is a share of the tolerance for
    values that steps add up after the first snapshot: cells and steps may err in opposite
    directions.
    """
    apart, sizes, usual = _differences(scalars, coarser)
    of_edges = [name for name in usual if any(word in name for word in _OF_EDGES)]
    typical = _OF_OTHERS * float(np.percentile([usual[name] for name in of_edges] or [0.0], 75.0))
    usual.update((name, max(usual[name], typical)) for name in of_edges)
    part = {n: _DEVIATIONS / math.sqrt(times ** (2.0 * lower.get(n, order)) - 1.0) for n in apart}
    estimates = {n: part[n] * np.maximum(apart[n], usual[n] * sizes[n]) for n in apart}
    for name, deviations in spread.items():
        estimates[name] = np.maximum(estimates[name], _DEVIATIONS * deviations)
    for name in (name for name in estimates if any(word in name for word in _OF_STEPS)):
        least = _DEVIATIONS * _STEPPING * tolerance * np.abs(scalars[name][1:])
        estimates[name][1:] = np.maximum(estimates[name][1:], least)
    for name, errors in estimates.items():
        size = np.abs(scalars[name])
        for now, falls in enumerate(size[1:] < size[:-1], start=1):
            if falls:
                errors[now] = max(errors[now], errors[now - 1] * size[now] / size[now - 1])
    return estimates


def measured_order(rounds: Sequence[GridRun]) -> float:
    """Return the order at which results of the last three runs converge.

    It is the median over the results in `ASKED`, at least 1/2 and at most 3/2, and 1 if there are
    not three runs.
    """
    of_each = _orders(rounds)
    orders = [of_each[name] for name in ASKED if name in of_each]
    return float(np.median(orders)) if orders else _USUAL_ORDER


def lower_orders(rounds: Sequence[GridRun]) -> dict[str, float]:
    """Return the orders of results that add up over steps and converge more slowly than others.

    A plastic band of a few cells widens them slowly; where edges fall in cells has no such order.
    """
    order = measured_order(rounds)
    of_steps = ((n, low) for n, low in _orders(rounds).items() if any(w in n for w in _OF_STEPS))
    return {name: low for name, low in of_steps if low < order}


def _orders(rounds: Sequence[GridRun]) -> dict[str, float]:
    """The order of each result by the differences of the last three runs; none of two.

    The median over the snapshots counts, of values that have grown beyond a trace.
    """
    if len(rounds) < 3:
        return {}
    wide, middle, narrow = rounds[-3:]
    fine = columns_of(narrow.rows)
    before, now = (
        _differences(columns_of(run.rows), columns_of(wider.rows))[0]
        for wider, run in ((wide, middle), (middle, narrow))
    )
    orders = np.linspace(_LEAST_ORDER, _MOST_ORDER, 61)
    powers = [run.width**orders for run in (wide, middle, narrow)]
    expected = (powers[0] - powers[1]) / (powers[1] - powers[2])
    measured = {}
    for name, values in fine.items():
        size = np.nan_to_num(np.abs(values))
        counts = (size > _TRACE * size.max()) & (before[name] > 0.0) & (now[name] > 0.0)
        if counts.any():
            ratio = float(np.exp(np.median(np.log(before[name][counts] / now[name][counts]))))
            measured[name] = float(np.interp(ratio, expected, orders))
    return measured


def _differences(
    scalars: Mapping[str, NDArray[np.float64]], coarser: Mapping[str, NDArray[np.float64]]
) -> tuple[dict[str, NDArray[np.float64]], dict[str, NDArray[np.float64]], dict[str, float]]:
    """Differences of two runs by name, larger values, and usual ratios of the two."""
    apart, sizes, usual = {}, {}, {}
    for name, values in scalars.items():
        fine, wide = (np.nan_to_num(np.abs(run)) for run in (values, coarser[name]))
        apart[name] = np.where(np.isnan(values), np.nan, np.abs(fine - wide))
        sizes[name] = np.maximum(fine, wide)
        counts = fine > _TRACE * fine.max()
        differs = counts & (apart[name] > 0)
        logarithms = np.log(apart[name][differs] / sizes[name][differs])
        usual[name] = float(np.exp(np.median(logarithms))) if differs.any() else 0.0
    return apart, sizes, usual
