"""Errors of results: one rule for a run and its twin on wider cells, margins for each kind.

Where the cells of the twin are k times wider and its tolerance is k² times larger, results differ
by k − 1 times the error of the run if errors grow with the width of a cell, and by √(k² + 1) times
its standard deviation if they follow from where edges happen to cut cells: √(k² − 1) is between.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from fretwear.results import RESULTS
from fretwear.study.case import Case
from fretwear.variable import ErrorKind

ScalarValues: TypeAlias = dict[str, NDArray[np.float64]]
"""Values at the snapshots by name, each of shape (n,)."""


class Margins(NamedTuple):
    """Parts of an estimated error, which add as squares; the last three relative to the value."""

    apart: float  # over the difference of both runs and √(k² − 1)
    usual: float  # likewise, for their root mean square difference over all snapshots
    cells: float = 0.0  # over h/a or 4 h/λ: an edge may cut the same part of a cell in both runs
    steps: float = 0.0  # over the tolerance: cells and steps may err in opposite directions
    worn: float = 0.0  # over √(h/a) (1 − 1/f)² ln f; see `wear_in_errors`


MARGINS: dict[ErrorKind, Margins] = {
    "whole": Margins(0.9, 0.7, steps=0.02, worn=0.015),
    "edge": Margins(1.15, 2.15, cells=0.04, steps=0.05),
    "stick": Margins(1.35, 0.85, cells=0.06, worn=0.16),
    "local": Margins(1.1, 0.2, cells=0.02, steps=0.03),
    "plastic": Margins(2.0, 2.0, cells=0.15, steps=0.05),
    "volume": Margins(1.6, 0.4, worn=0.055),
    "depth": Margins(0.75, 0.9, cells=0.03, steps=0.06, worn=0.1),
    "cycle": Margins(1.5, 0.3, steps=0.02, worn=0.6),
    "life": Margins(1.3, 1.3, steps=0.2),
    "peak": Margins(2.0, 0.0, cells=0.02),
}
"""Chosen by `coverage` of `benchmarks.verification`: 95 % of the true errors are smaller."""

_LEAST_LOAD = 1e-3  # outside the stick zone, over the whole load
# Margin for steps, at least, where friction follows slip or a coating wears through: both runs take
# the same steps, in which the edge of stick passes cells whose friction has changed, and places
# become bare.
_PLACE_BY_PLACE = 0.06


def columns_of(rows: Sequence[Mapping[str, float]]) -> ScalarValues:
    """Return the values by name of rows that have the same names."""
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def cell_errors(
    case: Case,
    scalars: ScalarValues,
    twin: ScalarValues,
    times: float,
    unresolved: NDArray[np.float64],
) -> ScalarValues:
    """Estimate how far scalars are from the limit of narrow cells and short steps.

    They belong to a run and to its twin, whose cells are some times wider. The true peak may exceed
    that of the cells by the part ``unresolved``, shape (n,). The estimates have the same names,
    shapes and units.

    Two runs may agree by chance at one snapshot. What they differ by over all snapshots, as root
    mean squares and relative to the value, therefore counts too. Wear adds up dissipated energy, so
    that it usually errs as this does. A value missing in one of the two runs, NaN, counts as zero;
    if the run itself has none, there is no error.
    """
    errors: ScalarValues = {}
    waves = (4.0 * min(each.finest) / each.cells for each in case.surfaces.values())
    cell = case.width_at_edges / min(case.hertz_radius, *waves)
    least = _PLACE_BY_PLACE * (case.friction_law.follows_slip or case.changes_below)
    for name, values in scalars.items():
        kind = RESULTS[name].error_kind
        margins = MARGINS[kind]
        steps = max(margins.steps, least)
        source = "dissipated_energy" if kind in ("volume", "depth") else name
        usual = _usual(scalars[source], twin[source])
        if case.changes_below:
            # The same energy wears another volume where the substrate is bare.
            usual = max(usual, _usual(values, twin[name]))
        apart, size = _apart(values, twin[name])
        parts = [
            np.hypot(margins.apart * apart, margins.usual * usual * size) / math.sqrt(times**2 - 1),
            margins.cells * cell * np.abs(values),
            steps * case.tolerance * np.abs(values) * (np.arange(values.size) > 0),
        ]
        if kind == "peak":
            # The cell with the peak changes, and tells nothing of the others.
            parts.append(unresolved * np.abs(values))
        errors[name] = np.linalg.norm(parts, axis=0)
    if "coating_left" in errors:
        # However little is left, it errs by as much as the depth that is worn.
        left = scalars["coating_left"] > 0.0
        errors["coating_left"] = np.where(left, errors["maximum_wear_depth"], 0.0)
    return errors


def _usual(values: NDArray[np.float64], twin: NDArray[np.float64]) -> float:
    """Root mean square difference of two runs over all snapshots, relative to the size."""
    apart, size = np.linalg.norm(_apart(values, twin), axis=1)
    return float(apart / (size or 1.0))


def _apart(values: NDArray[np.float64], twin: NDArray[np.float64]) -> NDArray[np.float64]:
    """Difference and size of two runs, shape (2, n)."""
    own, wider = (np.nan_to_num(np.abs(run)) for run in (values, twin))
    return np.array([np.abs(own - wider), np.maximum(own, wider)])


def wear_in_errors(case: Case, scalars: ScalarValues, errors: ScalarValues) -> ScalarValues:
    """Return errors with those of results that follow the wear beside the stick edge.

    While a contact wears in, the load outside the stick zone falls by a factor f with time as
    e^(-N/T), and wear moves to the stick edge. There the pressure of elastic bodies rises with the
    inverse root of the distance, so that cells of a width h resolve it to the order √(h/a), which
    narrower cells reduce slowly. T errs alike, and ln f with it: at first only in a small part of
    the load and of the wear, hence (1 − 1/f)². Where forces or friction change too, the load says
    nothing of the wear.
    """
    if not case.force_is_held or case.friction_law.least < case.friction_law.coefficient:
        return dict(errors)
    slipping = np.maximum(1.0 - np.nan_to_num(scalars["stick_load_share"]), _LEAST_LOAD)
    left = slipping / np.maximum.accumulate(slipping)
    worn = math.sqrt(case.width_at_edges / case.hertz_radius) * (1.0 - left) ** 2 * -np.log(left)
    return {
        name: np.hypot(error, MARGINS[RESULTS[name].error_kind].worn * worn * np.abs(scalars[name]))
        for name, error in errors.items()
    }


def model_errors(case: Case, scalars: ScalarValues) -> ScalarValues:
    """Return the errors of the slip model, which narrower cells do not reduce."""
    directions = np.array([case.cells.error_of_directions(cycle) for cycle in case.output_cycles])
    of_all = case.cells.error_of_slip_model
    of_kind = {"volume": of_all, "cycle": of_all, "depth": of_all + directions}
    return {
        name: of_kind.get(RESULTS[name].error_kind, 0.0) * np.abs(values)
        for name, values in scalars.items()
    }
