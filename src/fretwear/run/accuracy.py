"""Widths of cells for a requested accuracy."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fretwear.results import HEADLINES, RESULTS
from fretwear.run.errors import ScalarValues
from fretwear.study.case import Case
from fretwear.study.case_warnings import CaseWarning
from fretwear.study.memory import affordable_width

# Results to which a requested accuracy applies, if a case has them.
ASKED = (*(n for n in HEADLINES if not RESULTS[n].may_lack),)
# The error of an energy that falls by wear is relative to this fraction of its largest value.
_OF_LARGEST = "dissipated_energy"
# Values below this part of the largest have just begun to grow.
_TRACE = 0.01
USUAL_BUDGET = 10.0  # work of all runs over the work on default cells
# Share of the accuracy that the next run aims at.
_AIM = 0.8
_MOST_RATIO = 4.0  # of the widths of two runs from which errors are estimated
# Exponent of the work in the inverse width of cells: its least value, with cells along two axes or
# matrices of cells, and its largest rise between pairs of runs.
_LEAST_GROWTH, _FASTER = 2.0, 0.5


@dataclass(frozen=True)
class GridRun:
    """A finished run on cells of one width."""

    width: float  # width of its cells over the default
    rows: list[dict[str, float]]  # every scalar at each snapshot
    # Relative errors at the snapshots of each result to which the accuracy applies; empty if
    # unknown.
    errors: ScalarValues
    # `RunRecord.work`, a count and so the same on every machine.
    work: float = 0.0

    @property
    def error(self) -> float:
        """The largest relative error."""
        return max((float(each.max()) for each in self.errors.values()), default=math.inf)


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


def relative_errors(scalars: ScalarValues, errors: ScalarValues) -> ScalarValues:
    """Return the relative errors of the results in `ASKED` at the snapshots, shape (n,).

    Values that have just begun to grow do not count. The error of the energy of a contact that
    wears in is relative to its largest value.
    """
    relative: ScalarValues = {}
    for name in (name for name in ASKED if name in errors):
        values, apart = (np.nan_to_num(np.abs(table[name])) for table in (scalars, errors))
        counts = values > _TRACE * values.max()
        sizes = np.full_like(values, values.max()) if name == _OF_LARGEST else values
        relative[name] = np.divide(apart, sizes, out=np.zeros_like(apart), where=counts)
    return relative


def unreached(case: Case, rounds: Sequence[GridRun]) -> CaseWarning | None:
    """Return which results of a case miss its accuracy, by how much, and what to do."""
    accuracy, last = case.accuracy, rounds[-1]
    if not last.errors or last.error <= accuracy:
        return None
    missed = []
    for name, errors in last.errors.items():
        cycle = case.output_cycles[int(errors.argmax())]
        when = " of its largest value" if name == _OF_LARGEST else ""
        when += f" at cycle {cycle}" if cycle < case.output_cycles[-1] else ""
        if (error := float(errors.max())) > accuracy:
            missed.append((error, RESULTS[name].words, when))
    remedy = "set a narrower `cell`"
    if case.asked_accuracy is None:
        remedy += ", or none"
    elif _narrower(case, accuracy, rounds, math.inf) is not None:
        remedy = "raise `budget`"
    return CaseWarning.inaccurate(accuracy, missed, remedy)
