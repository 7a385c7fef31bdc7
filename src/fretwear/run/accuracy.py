"""Errors estimated from runs on wider cells, and widths of cells for a requested accuracy."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from fretwear.mechanics.wear.measures import Described, NextTips
from fretwear.results import HEADLINES, RESULTS
from fretwear.study.case import Case
from fretwear.study.case_warnings import CaseWarning
from fretwear.study.memory import affordable_width

_Columns: TypeAlias = dict[str, NDArray[np.float64]]

# Number of standard deviations in an estimated error.
_DEVIATIONS = 2.0
# Values below this fraction of the largest have just begun to grow; their errors are left out.
_TRACE = 0.01
# Words in the names of scalars that depend on the edges of contact and stick. Edges lie anywhere in
# a cell, so that sometimes a scalar is the same in both runs, even throughout an elastic run, or
# jumps by a row of asperities. The median over the scalars of a zone is the least difference that
# counts.
_ZONES = ("contact", "stick", "scar")
# Share of a difference at one snapshot that counts at the neighbouring ones.
_BESIDE = 0.6
# Words in the names of scalars that add up over steps or depend on the worn shape.
_OF_STEPS = ("wear", "plastic", "energy", "sliding")
# Integrals: error over the difference of two runs, smaller than for edges and maxima.
_STEADY, _OF_STEADY = ("wear_volume", "dissipated_energy", "sliding"), 0.65
# Wear is the sum of the energy that friction dissipates in each cycle.
_SUMS, _SUMMED = ("wear_volume", "maximum_wear_depth"), "dissipated_energy"
# Results that fall while a contact wears in; relative error of the time this takes, over √(h/a).
_FALLING, _OF_TIME = ("dissipated_energy", "sliding"), 0.9


# Results to which a requested accuracy applies, if a case has them.
ASKED = (*(n for n in HEADLINES if not RESULTS[n].may_lack),)
# The error of an energy that falls by wear is relative to this fraction of its largest value.
_OF_LARGEST = "dissipated_energy"
USUAL_BUDGET = 10.0  # work of all runs over the work on default cells
# Share of the accuracy that the next run aims at.
_AIM = 0.8
_MOST_RATIO = 4.0  # of the widths of two runs from which errors are estimated
# Exponent of the work in the inverse width of cells: its least value, with cells along two axes or
# matrices of cells, and its largest rise between pairs of runs.
_LEAST_GROWTH, _FASTER = 2.0, 0.5


class Margins(NamedTuple):
    """Margins for chance agreement of two runs, from 60 cases of `benchmarks.verification`."""

    of_cells: float  # factor on errors estimated from their difference
    of_steps: float  # least error due to steps over the tolerance

    @classmethod
    def of(cls, case: Case) -> Margins:
        """The margins of a case.

        Tips of rough surfaces lose contact one after another, at times that differ between runs.
        """
        return cls(1.0, 0.06) if case.roughness is None else cls(1.1, 0.15)


@dataclass(frozen=True)
class GridRun:
    """A finished run on cells of one width."""

    width: float  # width of its cells over the default
    rows: list[dict[str, float]]  # every scalar at each snapshot
    tips: list[NextTips]  # at each snapshot
    # Relative errors at the snapshots of each result to which the accuracy applies; empty if
    # unknown.
    errors: dict[str, NDArray[np.float64]]
    # `RunRecord.work`, a count and so the same on every machine; 0 for a run alongside.
    work: float = 0.0

    @classmethod
    def of(cls, width: float, snapshots: Iterable[Described], work: float = 0.0) -> GridRun:
        """A run whose errors are not known yet."""
        rows, tips = zip(*snapshots, strict=True)
        return cls(width, [*rows], [*tips], {}, work)

    @property
    def error(self) -> float:
        """The largest relative error."""
        return max((float(each.max()) for each in self.errors.values()), default=math.inf)


def columns_of(rows: Sequence[Mapping[str, float]]) -> dict[str, NDArray[np.float64]]:
    """Return the values of rows with the same names, by name."""
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def next_width(case: Case, rounds: Sequence[GridRun]) -> float | None:
    """Return the width of cells over the default for the next run of a case; None if none follows.

    A case with a requested accuracy begins on cells of its `first_width` and continues with default
    ones if it misses the accuracy. If these miss it too, further runs have cells as narrow as the
    fall of errors with the width requires, or as the budget allows.
    """
    if case.asked_accuracy is None:
        return None if rounds else 1.0
    if not rounds:
        return case.first_width
    if rounds[-1].error <= case.asked_accuracy:
        return None
    if rounds[-1].width > 1.0:
        return 1.0
    return _narrower(case, case.asked_accuracy, rounds, case.budget or USUAL_BUDGET)


def _narrower(
    case: Case, accuracy: float, rounds: Sequence[GridRun], budget: float
) -> float | None:
    """Width of the next cells after the default ones within budget and memory, if they help.

    The budget leaves at least as much work as the run on default cells took.
    """
    last = rounds[-1]
    if not last.errors:
        return None
    usual = next(run.work for run in rounds if run.width <= 1.0)
    left = budget * usual - sum(run.work for run in rounds)
    left = max(left, usual) if last.width == 1.0 else left
    aimed = last.width * min(_AIM * accuracy / last.error, 1.0 / case.times_coarser)
    of_work = math.inf
    if left > 0.0:
        of_work = last.width * (left / last.work) ** (-1.0 / _growth(rounds))
    width = max(aimed, of_work, affordable_width(case), last.width / _MOST_RATIO)
    # Two runs on nearly the same cells say little about errors.
    return width if width <= last.width / case.times_coarser * (1.0 + 1e-9) else None


def _growth(rounds: Sequence[GridRun]) -> float:
    """Exponent of the work in the inverse width of cells, from the last two runs."""
    grown, runs = _LEAST_GROWTH, [run for run in rounds if run.work]
    if len(runs) > 1:  # one, if cells wider than the default ones have failed
        *_, wide, narrow = runs
        grown = math.log(narrow.work / wide.work) / math.log(wide.width / narrow.width)
    return max(grown, _LEAST_GROWTH) + _FASTER


def relative_errors(
    scalars: Mapping[str, NDArray[np.float64]], errors: Mapping[str, NDArray[np.float64]]
) -> dict[str, NDArray[np.float64]]:
    """Return the relative errors of the results in `ASKED` at the snapshots, shape (n,).

    Values that have just begun to grow do not count. The error of the energy of a contact that
    wears in is relative to its largest value.
    """
    relative: dict[str, NDArray[np.float64]] = {}
    for name in (name for name in ASKED if name in errors):
        values, apart = (np.nan_to_num(np.abs(table[name])) for table in (scalars, errors))
        counts = values > _TRACE * values.max()
        sizes = np.full_like(values, values.max()) if name == _OF_LARGEST else values
        relative[name] = np.divide(apart, sizes, out=np.zeros_like(apart), where=counts)
    return relative


def unreached(case: Case, rounds: Sequence[GridRun]) -> CaseWarning | None:
    """Return which results of a case miss its accuracy, by how much, and what to do."""
    accuracy, last = case.asked_accuracy, rounds[-1]
    if accuracy is None or not last.errors or last.error <= accuracy:
        return None
    missed = []
    for name, errors in last.errors.items():
        cycle = case.output_cycles[int(errors.argmax())]
        when = " of its largest value" if name == _OF_LARGEST else ""
        when += f" at cycle {cycle}" if cycle < case.output_cycles[-1] else ""
        if (error := float(errors.max())) > accuracy:
            missed.append((error, RESULTS[name].words, when))
    is_bound = _narrower(case, accuracy, rounds, math.inf) is not None
    remedy = "raise `budget`" if is_bound else "set a narrower `cell`"
    return CaseWarning.inaccurate(accuracy, missed, remedy)


def without_jumps(
    finer: GridRun, coarser: GridRun, wavelengths: tuple[float, float] | None
) -> tuple[_Columns, _Columns]:
    """Return the values of the coarser of two runs without jumps to other tips, and the jumps, m.

    Half-widths that differ by more than half the distance of tips along x or y, the
    ``wavelengths``, m, of a rough surface, end at different tips; the finer value replaces the
    coarser one. Whether a tip touches depends on the gap at its top. This is uncertain if both runs
    differ, or if the gaps differ so much that they may close on narrower cells.
    """
    values, comparable = (columns_of(run.rows) for run in (finer, coarser))
    jumps: _Columns = {}
    if wavelengths is None:
        return comparable, jumps
    for name in finer.tips[0]:
        (jump, gap), (to_same, wider) = (
            np.array([tips[name] for tips in run.tips]).T for run in (finer, coarser)
        )
        half = 0.5 * wavelengths[name.endswith("y")]
        apart = np.abs(values[name] - comparable[name])
        jumped = apart > half
        may_touch = np.abs(gap) < _part(coarser.width / finer.width) * np.abs(gap - wider)
        may_touch &= np.abs(jump - to_same) < half
        jumps[name] = np.where(jumped, apart, np.where(may_touch, jump, 0.0))
        comparable[name] = np.where(jumped, values[name], comparable[name])
    return comparable, jumps


def _part(times: float) -> float:
    """Error over the difference from a run on cells some times wider, two standard deviations."""
    return _DEVIATIONS / math.sqrt(times**2 - 1.0)


def estimated_errors(
    scalars: Mapping[str, NDArray[np.float64]],
    coarser: Mapping[str, NDArray[np.float64]],
    times: float,
    spread: Mapping[str, NDArray[np.float64]],
    tolerance: float,
    margins: Margins,
) -> dict[str, NDArray[np.float64]]:
    """Estimate the errors of results against infinitely narrow cells and short steps.

    The scalars by name at the snapshots, shape (n,), belong to a run and to its twin, whose cells
    are some times wider. The estimates have the same names, shapes and units.

    With cells k times wider and a tolerance k² times larger, results differ by k − 1 times the
    error of the run if errors grow with the width of a cell, and by √(k² + 1) times its standard
    deviation if they depend on where edges happen to cut cells. √(k² − 1) lies between.

    The difference of two runs at one snapshot may be small by chance. The estimate takes the
    largest of the difference itself, its median over the snapshots relative to the value, and a
    share of it at the neighbouring snapshots; the first snapshot stands alone. The median is that
    of logarithms, so that it lies between a hard snapshot and an easy one. A value missing in one
    of the two runs, NaN, counts as zero; if the run itself has none, there is no error.

    A falling value, such as the energy of a contact that wears in, is the rest of a larger one: its
    relative error never decreases. Two runs that agree again merely cross.

    Two runs may differ by less than the uncertainty due to cells alone, especially if the edges do
    not move between snapshots. So the standard deviations due to edges within cells, `scatter`, are
    a lower bound. Another is a share of the tolerance for values that add up over steps after the
    first snapshot: errors of cells and of steps may have opposite signs.
    """
    apart, sizes, usual = _differences(scalars, coarser)
    for zone in _ZONES:
        of_edges = [name for name in usual if zone in name]
        typical = float(np.median([usual[name] for name in of_edges] or [0.0]))
        usual.update((name, max(usual[name], typical)) for name in of_edges)
    part = margins.of_cells * _part(times)
    estimates = {n: part * np.maximum(apart[n], usual[n] * sizes[n]) for n in apart}
    for name in (name for name in estimates if name.startswith(_STEADY)):
        estimates[name] *= _OF_STEADY
    for name, deviations in spread.items():
        estimates[name] = np.maximum(estimates[name], _DEVIATIONS * deviations)
    for name in (name for name in estimates if any(word in name for word in _OF_STEPS)):
        least = margins.of_steps * tolerance * np.abs(scalars[name][1:])
        estimates[name][1:] = np.maximum(estimates[name][1:], least)
    for name, errors in estimates.items():
        size = np.abs(scalars[name])
        for now, falls in enumerate(size[1:] < size[:-1], start=1):
            if falls:
                errors[now] = max(errors[now], errors[now - 1] * size[now] / size[now - 1])
    return estimates


def errors_of_wear_in(
    case: Case, scalars: Mapping[str, NDArray[np.float64]]
) -> dict[str, NDArray[np.float64]]:
    """Return the least errors of results that fall while a contact wears in, finally as e^(-N/T).

    Two runs may agree by chance while both miss the time T. The last wear is beside the stick edge,
    where the pressure of elastic bodies rises with the inverse root of the distance, so cells of a
    width h resolve it to the order √(h/a). A result that has fallen by a factor f then errs by
    about √(h/a) ln f. Narrower cells reduce this too slowly to be requested. Results that fall with
    friction, or from block to block of a loading, have no such errors.
    """
    errors: dict[str, NDArray[np.float64]] = {}
    if case.blocks or case.friction_law.least < case.friction_law.coefficient:
        return errors
    of_time = _OF_TIME * math.sqrt(case.width_at_edges / case.hertz_radius)
    for name in (name for name in scalars if name.startswith(_FALLING)):
        size = np.abs(scalars[name])
        highest = np.maximum.accumulate(np.maximum(size, np.finfo(np.float64).tiny))
        errors[name] = of_time * np.log(highest / np.where(size > 0.0, size, highest)) * size
    return errors


def errors_of_sums(
    scalars: Mapping[str, NDArray[np.float64]], errors: Mapping[str, NDArray[np.float64]]
) -> dict[str, NDArray[np.float64]]:
    """Return the least errors of wear that follow from those of the dissipated energy.

    Wear adds up this energy with its errors: those between two snapshots contribute in proportion
    to the wear between them. Two runs may differ by less, since both err in one direction while
    wear slowly continues beside the stick edge.
    """
    at_ends = (np.nan_to_num(np.abs(table[_SUMMED])) for table in (scalars, errors))
    energy, apart = (end + np.concatenate([end[:1], end[:-1]]) for end in at_ends)
    share = np.divide(apart, energy, out=np.zeros_like(apart), where=energy > 0.0)
    return {
        name: np.cumsum(share * np.diff(np.abs(scalars[name]), prepend=0.0))
        for name in errors
        if name.startswith(_SUMS)
    }


def _differences(
    scalars: Mapping[str, NDArray[np.float64]], coarser: Mapping[str, NDArray[np.float64]]
) -> tuple[dict[str, NDArray[np.float64]], dict[str, NDArray[np.float64]], dict[str, float]]:
    """Differences of two runs by name with shares of neighbours; largest values; usual ratios."""
    apart, sizes, usual = {}, {}, {}
    for name, values in scalars.items():
        fine, wide = (np.nan_to_num(np.abs(run)) for run in (values, coarser[name]))
        missed = np.abs(fine - wide)
        apart[name] = np.where(np.isnan(values), np.nan, missed)
        sizes[name] = np.maximum(fine, wide)
        counts = fine > _TRACE * fine.max()
        relative = np.zeros_like(fine)
        np.divide(missed, sizes[name], out=relative, where=counts & (sizes[name] > 0))
        differs = relative[relative > 0.0]
        usual[name] = float(np.exp(np.median(np.log(differs)))) if differs.size else 0.0
        neighbours = np.zeros_like(fine)
        neighbours[2:] = relative[1:-1]
        # The loss or growth of a later value says nothing about the one before.
        now, later = sizes[name][1:-1], sizes[name][2:]
        alike = np.minimum(now, later) / np.maximum(np.maximum(now, later), np.finfo(float).tiny)
        neighbours[1:-1] = np.maximum(neighbours[1:-1], alike * relative[2:])
        apart[name] = np.maximum(apart[name], _BESIDE * neighbours * sizes[name])
    return apart, sizes, usual
