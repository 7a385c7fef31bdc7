"""What the numbers of a study say, in sentences and as effects of its parameters."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from fretwear.report.results import (
    FIRST,
    LAST,
    PointResult,
    display_units,
    levels_of,
    span,
    variable_of,
)
from fretwear.study.plan import Plan
from fretwear.units import Unit, fixed_digits, number_text, with_unit
from fretwear.vocabulary import RESULTS

VOLUME, DEPTH = "wear_volume", "maximum_wear_depth"
CONTACT, STICK = "contact_half_width_x", "stick_half_width_x"
CENTRAL, ENERGY = "central_pressure", "dissipated_energy"
EFFECTS_ON = (VOLUME, DEPTH, CONTACT, STICK, ENERGY)

_UNCHANGED = 5e-3
_NOTICEABLE = 5e-4
_CEASED = 1e-3
_ROUND_OFF = 5e-6
_DIGITS = 3


@dataclass(frozen=True)
class Effect:
    """The effect of one parameter while the other varied ones are kept.

    Attributes
    ----------
    name : str
        Name of the parameter.
    change : str
        From which value to which.
    factors : tuple of str
        For each of `EFFECTS_ON`, the geometric mean of the factors by which it changes.
    pairs : int
        Number of pairs of cases compared.
    """

    name: str
    change: str
    factors: tuple[str, ...]
    pairs: int


def key_numbers(results: Sequence[PointResult], cycles: str) -> dict[str, str]:
    """Return the numbers that tell most about a study, by what they are; `cycles` is one."""
    done = [result for result in results if result.done]
    if not done:
        return {}
    growth = [result.ratio(CONTACT) - 1.0 for result in done]
    return {
        "case simulated" if len(done) == 1 else "cases simulated": str(len(done)),
        "cycles each": cycles,
        f"{variable_of(VOLUME, done).words} at the end": _told(
            VOLUME, LAST, done, display_units(done)
        ),
        f"growth of the {RESULTS[CONTACT].words}": _growth(growth),
    }


def summary_sentences(results: Sequence[PointResult]) -> Iterator[str]:
    """Yield what the study found, one statement each, with its numbers."""
    done = [result for result in results if result.done]
    if not done:
        yield "No point of this study has results."
        return
    units = display_units(done)
    yield _on_wear(done, units)
    growth = _change([result.ratio(CONTACT) - 1.0 for result in done])
    yield f"The {RESULTS[CONTACT].words} {growth}, to {_told(CONTACT, LAST, done, units)}."
    yield from _on_sticking(done)
    # Smooth surfaces only: the centre of a rough one may be a valley.
    smooth = [result for result in done if result.smooth and result.first(CENTRAL) > 0.0]
    if smooth:
        ratios = _factors([result.ratio(CENTRAL) for result in smooth])
        yield (
            f"On smooth surfaces the final {RESULTS[CENTRAL].words} is {ratios} times the initial "
            f"one, {_told(CENTRAL, LAST, smooth, units)}."
        )
    yield _on_energy(done, units)


def _on_wear(done: Sequence[PointResult], units: Mapping[str, Unit]) -> str:
    volume, depth = variable_of(VOLUME, done).words, RESULTS[DEPTH].words
    deepest = max(done, key=lambda result: result.last(DEPTH))
    if len(done) == 1:
        one, other = _told(VOLUME, LAST, done, units), _told(DEPTH, LAST, done, units)
        return f"The {volume} after the last cycle is {one}, the {depth} {other}."
    least, *_, most = sorted(done, key=lambda result: result.last(VOLUME))
    return (
        f"The {volume} after the last cycle lies between {_told(VOLUME, LAST, [least], units)} "
        f"({least.title}) and {_told(VOLUME, LAST, [most], units)} ({most.title}); "
        f"the {depth} reaches {_told(DEPTH, LAST, [deepest], units)} ({deepest.title})."
    )


def _on_sticking(done: Sequence[PointResult]) -> Iterator[str]:
    words = RESULTS[STICK].words
    for capped, limit in ((False, "without a plastic limit"), (True, "with a plastic limit")):
        changes = [
            result.ratio(STICK) - 1.0
            for result in done
            if result.capped is capped and result.first(STICK) > 0.0
        ]
        if not changes:
            continue
        largest = max(map(abs, changes))
        if largest >= _UNCHANGED:
            change = _change(changes)
        else:
            within = f", within {_percent(largest)}\u00a0%" if largest >= _NOTICEABLE else ""
            change = f"does not change{within}"
        yield f"In the {_cases(len(changes))} {limit} the {words} {change}."


def _on_energy(done: Sequence[PointResult], units: Mapping[str, Unit]) -> str:
    words = variable_of(ENERGY, done).words
    text = f"The {words} is initially {_told(ENERGY, FIRST, done, units)} and"
    ratios = [result.ratio(ENERGY) for result in done if not _has_ceased(result)]
    ceased = len(done) - len(ratios)
    if not ratios:
        return f"{text} finally vanishes: wear has ceased."
    text += f" finally {_factors(ratios)} times that"
    if ceased:
        text += f"; in {_cases(ceased)} it vanishes, as wear has ceased"
    return f"{text}."


def effects(plan: Plan, results: Sequence[PointResult]) -> list[Effect]:
    """Return the effect of every varied parameter between its first and its last value.

    Only a grid has pairs of cases that differ in one parameter alone; other designs give no
    effects.
    """
    if plan.study.design.kind != "grid":
        return []
    by_index = {
        planned.index: result
        for planned, result in zip(plan.points, results, strict=True)
        if result.done
    }
    found = []
    for position, axis in enumerate(plan.study.axes):
        last = len(axis.values) - 1
        pairs = [
            (result, by_index[end])
            for index, result in by_index.items()
            if index[position] == 0
            and last > 0
            and (end := (*index[:position], last, *index[position + 1 :])) in by_index
        ]
        if pairs:
            factors = tuple(_mean_factor(pairs, name) for name in EFFECTS_ON)
            levels = levels_of(axis)
            change = f"{levels[0].label} → {levels[last].label}"
            found.append(Effect(axis.coordinate, change, factors, len(pairs)))
    return found


def _mean_factor(pairs: Sequence[tuple[PointResult, PointResult]], name: str) -> str:
    logarithms = [
        math.log(after.last(name) / before.last(name))
        for before, after in pairs
        if before.last(name) > 0.0
        and after.last(name) > 0.0
        # Where wear has ceased, what is left of the energy is rounding.
        and not (name == ENERGY and (_has_ceased(before) or _has_ceased(after)))
    ]
    if not logarithms:
        return "–"
    return f"× {fixed_digits(math.exp(math.fsum(logarithms) / len(logarithms)), _DIGITS)}"


def _has_ceased(result: PointResult) -> bool:
    """Whether next to nothing is dissipated any more: no pressure is left where surfaces slip."""
    return result.last(ENERGY) < _CEASED * result.first(ENERGY)


def _told(name: str, cycle: str, among: Sequence[PointResult], units: Mapping[str, Unit]) -> str:
    """Return a key result of some points, or its range, with the unit."""
    unit = units[name]
    values = [unit.of(result.values[name, cycle]) for result in among]
    text = span(values, lambda value: number_text(value, _DIGITS))
    return with_unit(f"({text})" if " to " in text and unit.is_power else text, unit)


def _cases(count: int) -> str:
    return f"{count} case{'s' if count > 1 else ''}"


def _change(fractions: Sequence[float]) -> str:
    if min(fractions) >= -_ROUND_OFF:
        return f"grows by {span([max(0.0, f) for f in fractions], _percent)}\u00a0%"
    if max(fractions) <= _ROUND_OFF:
        return f"shrinks by {span([max(0.0, -f) for f in fractions], _percent)}\u00a0%"
    return f"changes by {_growth(fractions)}"


def _growth(fractions: Sequence[float]) -> str:
    return f"{span(fractions, lambda f: '+' * (f > 0.0) + _percent(f))}\u00a0%"


def _percent(fraction: float) -> str:
    return f"{100.0 * fraction:.1f}".replace("-", "−")


def _factors(ratios: Sequence[float]) -> str:
    return span(ratios, lambda ratio: fixed_digits(ratio, _DIGITS))
