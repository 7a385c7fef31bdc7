"""Errors of results: one rule for a run and its twin on wider cells, one margin for each kind.

Where the cells of the twin are k times wider and its tolerance is k² times larger, results differ
by k − 1 times the error of the run if errors grow with the width of a cell, and by √(k² + 1) times
its standard deviation if they follow from where edges happen to cut cells: √(k² − 1) is between.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from fretwear.results import RESULTS
from fretwear.study.case import Case
from fretwear.variable import ErrorKind

ScalarValues: TypeAlias = dict[str, NDArray[np.float64]]
"""Values at the snapshots by name, each of shape (n,)."""

MARGINS: dict[ErrorKind, float] = {
    "whole": 1.8, "edge": 2.2, "volume": 1.0, "depth": 1.4, "cycle": 1.0, "life": 1.8,
    "peak": 2.0
}  # fmt: skip
"""Printed errors over the difference of both runs and √(k² − 1). Chosen by `coverage` of
`benchmarks.verification`, so that 95 % of the true errors are smaller."""

EDGE = 0.1
"""Least error of an edge, in cells: it may cut the same part of a cell in both runs."""

STEPS = 0.06
"""Least error of what steps add up or move, over the tolerance: cells and steps may err in opposite
directions."""

LIFE = 0.4
"""Least error of the cycle at which a depth is reached, over the tolerance: steps err alike."""

WEAR_IN = 0.85
"""Error of the time in which a contact wears in, over √(h/a)."""


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

    Two runs may agree by chance at one snapshot. Their difference therefore counts as no smaller a
    part of a value than over all snapshots, as root mean squares. A value missing in one of the two
    runs, NaN, counts as zero; if the run itself has none, there is no error.
    """
    errors: ScalarValues = {}
    for name, values in scalars.items():
        kind = RESULTS[name].error_kind
        own, wider = (np.nan_to_num(np.abs(run)) for run in (values, twin[name]))
        apart, size = np.abs(own - wider), np.maximum(own, wider)
        usual = size * (np.linalg.norm(apart) / (np.linalg.norm(size) or 1.0))
        part = MARGINS[kind] / math.sqrt(times**2 - 1.0)
        error = part * np.maximum(apart, usual)
        if kind == "edge":
            error = np.maximum(error, EDGE * case.width_at_edges / case.hertz_radius * own)
        if kind in ("edge", "volume", "depth", "cycle"):
            error[1:] = np.maximum(error[1:], STEPS * case.tolerance * own[1:])
        elif kind == "life":
            error = np.maximum(error, LIFE * case.tolerance * own)
        elif kind == "peak":
            # The cell with the peak changes, and tells nothing of the others.
            error = np.hypot(part * apart, unresolved * own)
        errors[name] = np.where(np.isnan(values), np.nan, error)
    return errors


def wear_in_errors(case: Case, scalars: ScalarValues, errors: ScalarValues) -> ScalarValues:
    """Return errors with the least ones of results that fade while a contact wears in.

    Two runs may agree by chance while both miss the time T of e^(-N/T). The last wear is beside the
    stick edge, where the pressure of elastic bodies rises with the inverse root of the distance, so
    cells of a width h resolve it to the order √(h/a), which narrower cells reduce slowly. A result
    that has fallen by a factor f errs by about √(h/a) ln f, unless it falls with friction, or from
    block to block of a loading.
    """
    complete = dict(errors)
    falls_otherwise = case.blocks or case.friction_law.least < case.friction_law.coefficient
    of_time = WEAR_IN * math.sqrt(case.width_at_edges / case.hertz_radius)
    for name in () if falls_otherwise else errors:
        if RESULTS[name].error_kind == "cycle":
            size = np.abs(scalars[name])
            highest = np.maximum.accumulate(np.maximum(size, np.finfo(np.float64).tiny))
            fallen = np.log(highest / np.where(size > 0.0, size, highest))
            complete[name] = np.maximum(errors[name], of_time * fallen * size)
    return complete


def summed_errors(scalars: ScalarValues, errors: ScalarValues) -> ScalarValues:
    """Return the least errors of wear that follow from those of the dissipated energy.

    Wear adds up this energy with its errors: those between two snapshots contribute in proportion
    to the wear between them. Two runs may differ by less, since both err in one direction while
    wear slowly continues beside the stick edge.
    """
    at_ends = (np.nan_to_num(np.abs(table["dissipated_energy"])) for table in (scalars, errors))
    energy, apart = (end + np.concatenate([end[:1], end[:-1]]) for end in at_ends)
    share = np.divide(apart, energy, out=np.zeros_like(apart), where=energy > 0.0)
    return {
        name: np.cumsum(share * np.diff(np.abs(scalars[name]), prepend=0.0))
        for name in errors
        if RESULTS[name].error_kind in ("volume", "depth")
    }


def model_errors(case: Case, scalars: ScalarValues, errors: ScalarValues) -> ScalarValues:
    """Return errors with those of the slip model, which narrower cells do not reduce."""
    directions = np.array([case.cells.error_of_directions(cycle) for cycle in case.output_cycles])
    complete = dict(errors)
    for name in errors:
        kind, size = RESULTS[name].error_kind, np.abs(scalars[name])
        if kind in ("volume", "depth", "cycle"):
            complete[name] = np.hypot(errors[name], case.cells.error_of_slip_model * size)
        if kind == "depth":
            complete[name] = complete[name] + directions * size
    return complete
