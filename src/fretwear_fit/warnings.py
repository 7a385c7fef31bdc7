"""What the data of a fit leave open: its warnings."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from fretwear.study.case import Case
from fretwear_fit.request import BASELINE

if TYPE_CHECKING:
    from fretwear_fit.results import Fit

_TOGETHER, _WITH_BASELINE = 0.95, 0.7  # correlations
_AT_AN_END = 2e-3  # of a range
_INSENSITIVE = 0.1  # change of a scar over the change of its coefficient
_SMALL_STROKE = 0.1  # over the contact half-width
_UNLIKELY = 0.01
_OF_PATH = {"cycles", "sliding_amplitude", "displacement_amplitude", "sliding_distance"}


def warnings_of(fit: Fit, case: Case) -> Iterator[str]:
    """Yield what the data of a fit do not determine; `case` is the best one."""
    if fit.p_value < _UNLIKELY:
        yield (
            f"the model does not explain the data within their errors: χ² = {fit.misfit:.4g} with "
            f"{fit.degrees} degrees of freedom, p = {fit.p_value:.1g}"
        )
    for place, unknown in enumerate(fit.unknowns):
        low, high = unknown.ends
        part = (float(fit.emulator.best[place]) - low) / (high - low)
        if not _AT_AN_END < part < 1.0 - _AT_AN_END:
            yield f"the best {unknown.name} lies at the end of its range"
        match fit.is_open(unknown.name):
            case (True, True):
                yield f"the data do not determine {unknown.name}"
            case (True, False):
                yield f"{unknown.name} has an upper bound only"
            case (False, True):
                yield f"{unknown.name} has a lower bound only"
    yield from _of_correlations(fit)
    yield from _of_wear(fit, case)


def _of_correlations(fit: Fit) -> Iterator[str]:
    """Parameters that the data determine together only, or together with the base line."""
    names, deviations = fit.names, np.sqrt(np.diag(fit.covariance))
    for i, j in zip(*np.triu_indices(len(names), 1), strict=True):
        if abs(correlation := fit.correlation[i, j]) > _TOGETHER:
            product = ""
            if all(fit.unknowns[place].free.logarithmic for place in (i, j)):
                ratio = -np.sign(correlation) * deviations[i] / deviations[j]
                product = f": {names[i]} · {names[j]}^{ratio:.2g}"
            yield f"the data determine {names[i]} and {names[j]} together only{product}"
    for datum in fit.measurements:
        for column, name in enumerate(datum.comparison.names):
            for place, unknown in enumerate(names):
                correlation = datum.correlation[place, column]
                if name in BASELINE and abs(correlation) > _WITH_BASELINE:
                    yield (
                        f"{unknown} and the {name} of the base line of {datum.title} have the "
                        f"correlation {correlation:.2f}"
                    )


def _of_wear(fit: Fit, case: Case) -> Iterator[str]:
    """What is known of wear coefficients and of the bodies."""
    names = [unknown.free.name for unknown in fit.unknowns]
    of_wear = {unknown.free.name for unknown in fit.unknowns if unknown.free.is_of_wear}
    if of_wear and not _OF_PATH & {*names}:
        yield (
            "only the product of wear coefficient, cycles and slip counts: relative errors of "
            "cycles and slip add to that of the coefficient"
        )
    quantities = {datum.comparison.measurement.quantity for datum in fit.measurements}
    measured = [b for b in ("indenter", "flat") if any(q.endswith(f"_{b}") for q in quantities)]
    both = {name.rpartition(".")[2] for name in of_wear} >= {"indenter", "flat"}
    if both and case.loading.stroke < _SMALL_STROKE * case.hertz_radius and len(measured) < 2:
        yield "both bodies have the same scar: the data do not show which body wears"
    if case.loading.stroke:
        return
    begin = 0
    for datum in fit.measurements:
        part = slice(begin, begin := begin + datum.signal.size)
        for place, name in enumerate(names):
            change = np.linalg.norm(fit.derivatives[part, place])
            is_wear = datum.comparison.measurement.quantity.startswith("wear")
            if is_wear and name in of_wear and change < _INSENSITIVE * np.linalg.norm(datum.signal):
                yield f"the scar is finished: {datum.title} hardly depends on {name}"
