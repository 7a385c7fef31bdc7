"""What the data of a fit leave open, in words."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from fretwear.study.case import Case
from fretwear.units import listed

if TYPE_CHECKING:
    from fretwear_fit.estimate import Unknown
    from fretwear_fit.results import Fit

_TOGETHER, _WITH_OFFSET = 0.95, 0.7
_AT_AN_END = 2e-3  # of a range
_INSENSITIVE = 0.1  # change of a scar over the change of its coefficient
_SMALL_STROKE = 0.1  # over the contact half-width
_UNLIKELY = 0.01
_WEAR = ("wear_coefficient", "energy_wear_coefficient")
_COEFFICIENTS = ("indenter", "flat", "value", "rim", "core")  # within a pair or a law
_OF_PATH = ("cycles", "sliding_amplitude", "displacement_amplitude", "sliding_distance")


def doubts_of(fit: Fit, case: Case) -> Iterator[str]:
    """Yield sentences about what the data of a fit do not determine; `case` is the best one."""
    yield from _of_ranges(fit)
    yield from _of_pairs(fit)
    yield from _of_wear(fit, case)
    for datum in fit.measurements:
        of = datum.comparison.measurement
        if of.readings is None or not of.is_profile or "shift" not in of.baseline:
            continue
        assert datum.comparison.grid is not None
        worn = datum.comparison.grid[datum.signal > 0.02 * datum.signal.max()]
        shift = datum.nuisances[datum.comparison.names.index("shift")]
        x = of.readings[0]
        if worn.size and (worn[0] + shift < x[0] or worn[-1] + shift > x[-1]):
            yield (
                f"{datum.title}: the scar reaches beyond the readings, whose base line is known on "
                "one side at most: measure further out, or write baseline: [offset] for half a scar"
            )
    if fit.p_value < _UNLIKELY:
        yield (
            f"no values within the ranges explain the data: χ² = {fit.misfit:.4g} with "
            f"{fit.degrees} degrees of freedom, p = {fit.p_value:.1g}; look at the residuals for "
            "what the model leaves out, or for an error given too small"
        )


def _of_ranges(fit: Fit) -> Iterator[str]:
    """Parameters whose range does not hold the best value, or ends the interval."""
    for place, unknown in enumerate(fit.unknowns):
        low, high = unknown.ends
        part = (float(fit.emulator.best[place]) - low) / (high - low)
        text = unknown.free.about.text
        below, above = fit.is_open(unknown.name)
        ends = fit.interval(unknown.name)
        if below and above:
            yield (
                f"the data do not determine {unknown.name}: χ² hardly changes over its range; "
                "leave it out, or measure what depends on it"
            )
        elif part < _AT_AN_END or part > 1.0 - _AT_AN_END:
            end = unknown.free.low if part < 0.5 else unknown.free.high
            yield (
                f"the best {unknown.name} lies at the end of its range, {text(end)}: widen the "
                "range if it may lie beyond"
            )
        elif above:
            least = _about(unknown, ends[0])
            yield f"{unknown.name} is bounded from below only: with 97.5 % it is at least {least}"
        elif below:
            most = _about(unknown, ends[1])
            yield f"{unknown.name} is bounded from above only: with 97.5 % it is at most {most}"


def _about(unknown: Unknown, value: float) -> str:
    return unknown.free.about.text(float(f"{value:.3g}"))


def _of_pairs(fit: Fit) -> Iterator[str]:
    """Parameters that the data determine together only, or together with the base line."""
    deviations = np.sqrt(np.diag(fit.covariance))
    for first, second in zip(*np.triu_indices(len(fit.unknowns), 1), strict=True):
        correlation = fit.correlation[first, second]
        if abs(correlation) > _TOGETHER:
            names = [fit.unknowns[place].name for place in (first, second)]
            ratio = -np.sign(correlation) * deviations[first] / deviations[second]
            logarithmic = all(fit.unknowns[place].free.logarithmic for place in (first, second))
            product = f": {names[0]} · {names[1]}^{ratio:.2g}" if logarithmic else ""
            yield (
                f"the data determine {names[0]} and {names[1]} only together{product}, with a "
                f"correlation of {correlation:.3f}; fix one, or measure what depends on one alone"
            )
    for datum in fit.measurements:
        for column, name in enumerate(datum.comparison.names):
            for place, unknown in enumerate(fit.unknowns):
                correlation = datum.correlation[place, column]
                if name in ("offset", "tilt", "shift") and abs(correlation) > _WITH_OFFSET:
                    yield (
                        f"{unknown.name} and the {name} of the base line of {datum.title} are "
                        f"correlated, {correlation:.2f}: readings further beside the scar would "
                        "separate them"
                    )


def _of_wear(fit: Fit, case: Case) -> Iterator[str]:
    """What is known of wear coefficients, debris and the bodies."""
    names = [unknown.free.name for unknown in fit.unknowns]
    of_wear = [
        name
        for name in names
        if name.partition(".")[0] in _WEAR and name.rpartition(".")[2] in (*_WEAR, *_COEFFICIENTS)
    ]
    if not of_wear:
        return
    what = listed(dict.fromkeys(of_wear))
    if not {*names} & {*_OF_PATH}:
        slip = "the slip of the contact" if case.loading.stroke else "the slip"
        yield (
            f"only the product of {what}, cycles and {slip} counts: an error in cycles or slip is "
            "an equal error of the coefficient, which its interval does not include; imposed slip "
            "exceeds the slip measured at the contact by the compliance between them"
        )
    if "debris_fraction" in names:
        yield (
            "debris that carries load and a coefficient that falls with pressure or power leave "
            "similar scars: one scar cannot distinguish them, tests of different length or "
            "frequency can"
        )
    quantities = {datum.comparison.measurement.quantity for datum in fit.measurements}
    bodies = [
        body
        for body in ("indenter", "flat")
        if any(quantity.endswith(f"_{body}") for quantity in quantities)
    ]
    both = {name.rpartition(".")[2] for name in of_wear} >= {"indenter", "flat"}
    small = case.loading.stroke < _SMALL_STROKE * case.hertz_radius
    if both and small and len(bodies) < 2:
        yield (
            "the data do not show which body wears: the stroke is below a tenth of the contact "
            "half-width, and both bodies have the same scar; measure each of them"
        )
    if case.loading.stroke:
        return
    by_u = fit.emulator.first @ np.linalg.inv(fit.emulator.directions)
    begin = 0
    for datum in fit.measurements:
        part = slice(begin, begin + datum.signal.size)
        begin += datum.signal.size
        for place, name in enumerate(names):
            change = np.linalg.norm(by_u[part, place])
            is_wear = datum.comparison.measurement.quantity.startswith("wear")
            if is_wear and name in of_wear and change < _INSENSITIVE * np.linalg.norm(datum.signal):
                yield (
                    f"{datum.title} hardly depends on {name}: in partial slip wear ends when the "
                    "slip zone carries no load, and a finished scar bounds the coefficient from "
                    "below only; shorter tests say more"
                )
