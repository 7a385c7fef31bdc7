"""What the numbers of a study say, in sentences and as effects of its parameters."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from fretwear.figures.wording import number, with_unit
from fretwear.report.numbers import significant
from fretwear.report.results import QUANTITY, PointResult, display_unit, labels_of
from fretwear.study.plan import Plan

_UNCHANGED = 5e-3
_SPENT = 1e-3
_ROUND_OFF = 5e-4
_DIGITS = 3
EFFECT_QUANTITIES = ("volume", "depth", "half_width", "stick", "energy")


@dataclass(frozen=True)
class KeyNumber:
    """A number for the head of the report: value with unit, and what it is."""

    value: str
    meaning: str


@dataclass(frozen=True)
class Effect:
    """What changing one parameter does, all others kept.

    Parameters
    ----------
    name : str
        The parameter's name in the study file.
    change : str
        From which value to which.
    factors : tuple of str
        For each of `EFFECT_QUANTITIES`, the geometric mean of the factors by which it changes.
    pairs : int
        Number of pairs of cases compared.
    """

    name: str
    change: str
    factors: tuple[str, ...]
    pairs: int


def key_numbers(results: Sequence[PointResult], cycles: str) -> list[KeyNumber]:
    """Return the four numbers that tell most about a study."""
    done = [result for result in results if result.done]
    if not done:
        return []
    growth = [result.values["half_width"] / result.values["half_width_first"] for result in done]
    return [
        KeyNumber(str(len(done)), "case simulated" if len(done) == 1 else "cases simulated"),
        KeyNumber(cycles, "cycles each"),
        KeyNumber(_span(done, "volume"), "wear volume at the end"),
        KeyNumber(_percent_span([g - 1.0 for g in growth]), "growth of the contact half-width"),
    ]


def summary_sentences(results: Sequence[PointResult]) -> Iterator[str]:
    """Yield what the study found, one statement each, with its numbers."""
    done = [result for result in results if result.done]
    if not done:
        yield "No point of this study has results."
        return
    yield _wear_sentence(done)
    yield _contact_sentence(done)
    yield from _stick_sentences(done)
    yield from _pressure_sentences(done)
    yield _energy_sentence(done)


def effects(plan: Plan, results: Sequence[PointResult]) -> list[Effect]:
    """Return the effect of every varied parameter between its first and its last value.

    Only a grid has pairs of cases that differ in one parameter alone; other designs give no
    effects.
    """
    if plan.study.design.kind != "grid":
        return []
    by_index = {
        planned.point.index: result
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
            factors = tuple(_factor(pairs, name) for name in EFFECT_QUANTITIES)
            ends = [labels_of(axis)[place] for place in (0, last)]
            change = f"{ends[0]} → {ends[1]}"
            found.append(Effect(axis.coordinate, change, factors, len(pairs)))
    return found


def _factor(pairs: Sequence[tuple[PointResult, PointResult]], name: str) -> str:
    ratios = [
        after.values[name] / before.values[name]
        for before, after in pairs
        if before.values[name] > 0.0
        and after.values[name] > 0.0
        # Where wear has come to its end, what is left of the energy is rounding.
        and not (name == "energy" and (_worn_in(before) or _worn_in(after)))
    ]
    if not ratios:
        return "–"
    mean = math.exp(math.fsum(math.log(ratio) for ratio in ratios) / len(ratios))
    return f"× {significant(mean, _DIGITS)}"


def _worn_in(result: PointResult) -> bool:
    """Whether next to nothing is dissipated any more: the worn shape slips without load."""
    return result.values["energy"] < _SPENT * result.values["energy_first"]


def _wear_sentence(done: Sequence[PointResult]) -> str:
    least = min(done, key=lambda result: result.values["volume"])
    most = max(done, key=lambda result: result.values["volume"])
    deepest = max(done, key=lambda result: result.values["depth"])
    depth = _text(done, "depth", deepest.values["depth"])
    if len(done) == 1:
        return f"The wear volume is {_span(done, 'volume')} and the scar is {depth} deep."
    return (
        f"The wear volume after the last cycle lies between "
        f"{_text(done, 'volume', least.values['volume'])} ({least.title}) and "
        f"{_text(done, 'volume', most.values['volume'])} ({most.title}); "
        f"the deepest scar, {depth}, is that of {deepest.title}."
    )


def _contact_sentence(done: Sequence[PointResult]) -> str:
    growth = [r.values["half_width"] / r.values["half_width_first"] - 1.0 for r in done]
    return (
        f"The contact half-width along the direction of slip {_change(growth)}, "
        f"to {_span(done, 'half_width')}."
    )


def _stick_sentences(done: Sequence[PointResult]) -> Iterator[str]:
    for capped, words in ((False, "without a plastic limit"), (True, "with a plastic limit")):
        group = [result for result in done if result.capped is capped]
        changes = [
            result.values["stick"] / result.values["stick_first"] - 1.0
            for result in group
            if result.values["stick_first"] > 0.0
        ]
        if not changes:
            continue
        cases = f"{len(changes)} case{'s' if len(changes) > 1 else ''} {words}"
        largest = max(map(abs, changes))
        if largest < _UNCHANGED:
            within = f" within {100.0 * largest:.1f} %" if largest >= _ROUND_OFF else ""
            yield f"In the {cases} the stick zone keeps its half-width{within}."
        else:
            yield f"In the {cases} the stick half-width {_change(changes)}."


def _pressure_sentences(done: Sequence[PointResult]) -> Iterator[str]:
    """Speak of smooth surfaces only: the middle of a rough one may be a valley."""
    smooth = [result for result in done if result.smooth and result.values["central_first"] > 0.0]
    if smooth:
        ratios = [r.values["central"] / r.values["central_first"] for r in smooth]
        yield (
            f"On smooth surfaces the pressure in the middle of the contact becomes "
            f"{_ratio_span(ratios)} times its first value, {_span(smooth, 'central')} at the end."
        )


def _energy_sentence(done: Sequence[PointResult]) -> str:
    first = f"The energy dissipated in a cycle, {_span(done, 'energy_first')} at first,"
    ratios = [r.values["energy"] / r.values["energy_first"] for r in done if not _worn_in(r)]
    ended = len(done) - len(ratios)
    if not ratios:
        return f"{first} vanishes: wear has come to its end."
    text = f"{first} becomes {_ratio_span(ratios)} times that"
    if ended:
        text += f"; in {ended} case{'s' if ended > 1 else ''} it vanishes, wear has come to its end"
    return f"{text}."


def _text(done: Sequence[PointResult], name: str, value: float) -> str:
    unit = display_unit(QUANTITY[name], done)
    return with_unit(_rounded(value / unit.size), unit)


def _span(done: Sequence[PointResult], name: str) -> str:
    unit = display_unit(QUANTITY[name], done)
    values = [result.values[name] / unit.size for result in done]
    text = _range(_rounded(min(values)), _rounded(max(values)))
    return with_unit(f"({text})" if " to " in text and unit.is_power else text, unit)


def _change(fractions: Sequence[float]) -> str:
    low, high = 100.0 * min(fractions), 100.0 * max(fractions)
    if low >= -_ROUND_OFF:
        low = max(0.0, low)
        return f"grows by {_range(f'{low:.1f}', f'{high:.1f}')} %"
    if high <= _ROUND_OFF:
        high = min(0.0, high)
        return f"shrinks by {_range(f'{abs(high):.1f}', f'{abs(low):.1f}')} %"
    return f"changes by {_percent_span(fractions)}"


def _percent_span(fractions: Sequence[float]) -> str:
    low, high = 100.0 * min(fractions), 100.0 * max(fractions)
    return f"{_range(_signed(low), _signed(high))} %"


def _ratio_span(ratios: Sequence[float]) -> str:
    return _range(significant(min(ratios), _DIGITS), significant(max(ratios), _DIGITS))


def _rounded(value: float) -> str:
    return number(float(f"{value:.{_DIGITS}g}"))


def _range(low: str, high: str) -> str:
    return low if low == high else f"{low} to {high}"


def _signed(value: float) -> str:
    text = f"{value:+.1f}".replace("-", "−")
    return "0.0" if text in ("+0.0", "−0.0") else text
