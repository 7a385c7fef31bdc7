"""What a study found, in sentences whose numbers hold for every pair of cases they speak of."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fretwear.data.effects import (
    GOOD,
    SEED,
    Array,
    Effect,
    Indices,
    Points,
    rank_correlations,
)
from fretwear.study.parameters import parameter, value_text
from fretwear.units import fixed_digits, listed, number_text, readable_unit, span, with_unit
from fretwear.vocabulary import HEADLINES, RESULTS, Variable

if TYPE_CHECKING:
    from fretwear.data.effects import Merged

_UNCHANGED = 5e-3
_ROUND_OFF = 5e-4
_DIGITS = 3
_MOST_STEPS = 12
_ONLY_PAIR = " in the one pair"
_NUMERICS = ("hertz_", "cell_", "tolerance")


@dataclass(frozen=True)
class Claim:
    """What some pairs of cases say of a parameter, and which pairs these are."""

    effect: Effect  # the parameter, the result and the factors of all m pairs
    pairs: NDArray[np.bool_]  # shape (m,): of which pairs it is said
    low: int  # from which level of the parameter, by its place among them
    high: int  # to which
    where: str = ""  # in which of the cases, in words; empty: in all

    @classmethod
    def whole(cls, effect: Effect) -> Claim:
        """Return what all pairs of an effect say."""
        highest = len(effect.points.levels[effect.parameter]) - 1
        return cls(effect, np.ones(effect.low.shape, dtype=bool), 0, highest)

    @property
    def factors(self) -> Array:
        """The factors of the pairs between its two levels that have one."""
        return _known(self.effect.factors[self.pairs & self.effect.between(self.low, self.high)])

    @property
    def way(self) -> str:
        """How the result goes in every pair: ``stays``, ``grows``, ``falls``; empty if it differs.

        That is in all pairs, also those with a level between the two.
        """
        changes = _known(self.effect.factors[self.pairs]) - 1.0
        if (np.abs(changes) <= _UNCHANGED).all():
            return "stays"
        if (changes >= -_ROUND_OFF).all():
            return "grows"
        return "falls" if (changes <= _ROUND_OFF).all() else ""

    @property
    def text(self) -> str:
        """What is claimed: ``grows by 13 to 48 % in all 6 pairs where elastic``."""
        factors, where = self.factors, f" {self.where}" if self.where else ""
        if not factors.size:
            return f"vanishes at one end{where}"
        pairs = f"{factors.size} pair{'s' * (factors.size != 1)}"
        few = {1: "" if where else _ONLY_PAIR, 2: " in both pairs"}
        among = few.get(factors.size, f" in all {pairs}") + where
        ends = self.pairs & self.effect.between(self.low, self.high)
        without = int(ends.sum()) - factors.size
        rest = f" (in {without} more it vanishes at one end)" if without else ""
        if self.way == "stays":
            most = 100.0 * float(np.abs(factors - 1.0).max())
            within = f" within {_digits(most)}\u00a0%" if most >= 0.05 else ""
            return f"stays the same{within}{among}{rest}"
        grows, falls = factors[factors > 1.0], factors[factors <= 1.0]
        if self.way or not grows.size or not falls.size:
            # Between its levels it may go the other way somewhere.
            return f"{_by(factors)}{among}{rest}{'' if self.way else ', though not in every step'}"
        grown, fallen = f"{_by(grows)} in {grows.size}", f"{_by(falls)} in {falls.size}"
        return f"{grown} and {fallen} of {pairs}{where}{rest}"


@dataclass(frozen=True)
class Finding:
    """What one parameter does to one result: claims that together cover all pairs."""

    effect: Effect
    claims: tuple[Claim, ...]

    @property
    def name(self) -> str:
        """The parameter in words."""
        return parameter(self.effect.parameter).words

    @property
    def chance(self) -> str:
        """By how much a seed, one value of which is as good as another, changes the result.

        It is empty for other parameters; else in the quadratic mean over all ensembles.
        """
        if self.effect.parameter != SEED:
            return ""
        points = self.effect.points
        ensembles = [points.results[self.effect.result][line] for line in points.lines[SEED]]
        squares = [np.nanvar(e, ddof=1) / np.nanmean(e) ** 2 for e in ensembles if np.nansum(e)]
        deviation = _digits(100.0 * math.sqrt(np.nanmean(squares)))
        return f"chance, with a standard deviation of {deviation}\u00a0%"

    @property
    def text(self) -> str:
        """All claims in one sentence, without its subject."""
        steps: dict[tuple[int, int], list[Claim]] = {}
        for claim in self.claims:
            steps.setdefault((claim.low, claim.high), []).append(claim)
        parts = []
        for ends, told in steps.items():
            known = [claim.text for claim in told if claim.factors.size]
            if len(known) < len(told):
                known.append(f"vanishes {'elsewhere' if known else 'at one end or both'}")
            parts.append(f"from {_change(self.effect, *ends)} it {listed(known)}")
        return self.chance or "; ".join(parts)


class Answer(NamedTuple):
    """What a study says of one result."""

    name: str
    label: str
    values: str  # its range after the last cycle
    # Which parameter matters most; empty where no two cases differ in one parameter alone.
    headline: str
    rest: str = ""  # more about it, which a narrow screen leaves out
    # What every parameter does, the most important first; none for a sampled study.
    findings: tuple[Finding, ...] = ()


def answers(summary: Merged) -> Iterator[Answer]:
    """Yield what a merged study says of each of `HEADLINES`.

    A result that no case has, or that is zero in all, such as a stick zone in gross slip, is left
    out.
    """
    points = Points.of(summary)
    indices = points.indices if points.drawn and points.ids else {}
    for name in HEADLINES if points.ids else ():
        results = points.results.get(name, np.array([np.nan]))
        if not np.nan_to_num(results).any():
            continue
        findings = () if points.drawn else points.effects(name)
        found = tuple(Finding(effect, tuple(claims(effect))) for effect in findings)
        if not points.drawn:
            headline, rest = _headline(found), ""
        elif name in indices and indices[name].quality >= GOOD:
            headline, rest = _by_indices(points, indices[name])
        else:
            headline, rest = _by_ranks(points, results), ""
        variable = points.variables.get(name, RESULTS[name])
        yield Answer(name, variable.label, _range(variable, results), headline, rest, found)


def claims(effect: Effect) -> Iterator[Claim]:
    """Yield claims that cover all pairs of an effect, as few as say in which way each goes."""
    whole = Claim.whole(effect)
    divided = [] if whole.way == "stays" else list(_divided(whole))
    is_told = all(claim.way for claim in divided) if divided else whole.way
    # It rises and falls: each step from a level to the next by itself, unless they are many, or
    # the change is of many steps and hardly seen in any.
    places = range(whole.high) if not is_told and 1 < whole.high <= _MOST_STEPS else ()
    steps = [Claim(effect, effect.between(low, low + 1), low, low + 1) for low in places]
    steps = [step for step in steps if step.pairs.any()]
    if all(step.way == "stays" for step in steps):
        yield from divided or [whole]
        return
    for step in steps:
        yield from ([] if step.way else list(_divided(step))) or [step]


def _divided(claim: Claim) -> Iterator[Claim]:
    """Yield a claim for each level of the parameter on which the factor depends most."""
    effect, name = claim.effect, claim.effect.divider
    for level, value in enumerate(effect.points.levels.get(name, ())):
        pairs = claim.pairs & effect.where(name, level)
        if pairs.any():
            about, text = parameter(name), value_text(name, value)
            told = text if about.word_for(value) else f"the {about.words} is {text}"
            yield Claim(effect, pairs, claim.low, claim.high, f"where {told}")


def _headline(findings: Sequence[Finding]) -> str:
    if not findings:
        return ""
    changing = [f for f in findings if Claim.whole(f.effect).way != "stays"]
    if not changing:
        what = "No parameter" if len(findings) > 1 else f"The {findings[0].name}"
        verb = "changes" if len(findings) > 1 else "does not change"
        return f"{what} {verb} it by more than {100.0 * _UNCHANGED:g}\u00a0%."
    first = changing[0]
    effect, whole = first.effect, Claim.whole(first.effect)
    told = f"from {_change(effect, whole.low, whole.high)} it {whole.text}"
    if len(findings) == 1:
        if first.chance:
            return f"It varies with the {first.name} by {first.chance}."
        return f"With the {first.name} {told.replace(_ONLY_PAIR, '')}."
    results = effect.points.results[effect.result]
    gone = int(np.count_nonzero(~(results > 0.0)))
    others = f"It vanishes in {gone} of {results.size} cases. In the others the" if gone else "The"
    average = fixed_digits(math.exp(effect.size), _DIGITS)
    told = f" on average by a factor of {average}: {told}"
    told = f" and that is {first.chance}" if first.chance else told
    return f"{others} {first.name} matters most,{told}."


def _by_indices(points: Points, indices: Indices) -> tuple[str, str]:
    names = [parameter(name).words for name in points.levels]
    order = np.argsort(-indices.total)
    # What the intervals do not tell apart is not ranked.
    low, high = indices.total_range
    leading = [i for i in order if high[i] >= low[order[0]]]
    of = "the variance of its logarithm" if indices.of_logarithm else "its variance"
    if len(leading) > 1:
        told = " and the ".join(names[i] for i in leading)
        text = f"The {told} matter most, and their order is uncertain. Alone they explain "
    else:
        text = f"The {names[order[0]]} matters most: alone it explains "
    first, low, high = (100.0 * each for each in (indices.first, *indices.first_range))
    shares = [f"{first[i]:.0f} ({low[i]:.0f} to {high[i]:.0f})\u00a0%" for i in leading]
    others = [f"{names[i]} {100.0 * indices.total[i]:.0f}\u00a0%" for i in order]
    rest = f"With interactions: {', '.join(others)}."
    return f"{text}{' and '.join(shares)} of {of} (95\u00a0% intervals).", rest


def _by_ranks(points: Points, results: Array) -> str:
    known = np.isfinite(results)
    if known.sum() < len(points.levels) + 2 or np.ptp(results[known]) == 0.0:
        return "There are too few points to compare, or they are all the same."
    lacking = int((~known).sum())
    why = f"it has vanished at {lacking}" if lacking else "no emulator is good enough with"
    correlations = rank_correlations(points.unit[known], results[known, None])[:, 0]
    names = [parameter(name).words for name in points.levels]
    order = np.argsort(-np.abs(correlations))
    listed = [f"{names[i]} {number_text(round(float(correlations[i]), 2))}" for i in order]
    return (
        f"The {names[order[0]]} matters most by Spearman's rank correlation: {', '.join(listed)}. "
        f"There are no Sobol indices, because {why} {'of ' * bool(lacking)}its {known.size} points."
    )


def companions(points: Points) -> str:
    """Say which parameters that were not varied change with those that were, or nothing."""
    found: dict[str, list[str]] = {}
    for name in points.levels:
        for other in points.parameters:
            if other in points.levels or other.startswith(_NUMERICS) or not points.lines[name]:
                continue
            low, high = np.array([(line[0], line[-1]) for line in points.lines[name]]).T
            with np.errstate(divide="ignore", invalid="ignore"):
                factors = points.parameters[other][high] / points.parameters[other][low]
            if np.isfinite(factors).all() and (np.abs(factors - 1.0) > _UNCHANGED).all():
                told = f"{_by(factors)} with the {parameter(name).words}"
                found.setdefault(other, []).append(told)
    return " ".join(
        f"The {parameter(other).words} is not held constant: it {listed(told)}. The effects "
        f"of {'these' if len(told) > 1 else 'this'} include that of the {parameter(other).words}."
        for other, told in found.items()
    )


def _change(effect: Effect, low: int, high: int) -> str:
    levels = effect.points.levels[effect.parameter]
    texts = [value_text(effect.parameter, levels[place]) for place in (low, high)]
    return " to ".join(text.replace(" ", "\u00a0") for text in texts)


def _by(factors: Array) -> str:
    """Say by how much results grow or fall, all of them one way."""
    low, high = float(factors.min()), float(factors.max())
    if low >= 1.0 - _ROUND_OFF and high >= 2.0:
        return f"grows by a factor of {span([low, high], lambda f: fixed_digits(f, _DIGITS))}"
    verb, ends = ("grows", (low, high)) if low >= 1.0 - _ROUND_OFF else ("falls", (high, low))
    least, most = (_digits(100.0 * abs(end - 1.0)) for end in ends)
    text = most if least == most else f"{least} to {most}" if float(least) else f"up to {most}"
    return f"{verb} by {text}\u00a0%"


def _digits(percent: float) -> str:
    return f"{percent:.1f}" if percent < 9.95 or percent > 99.0 else f"{percent:.0f}"


def _known(values: Array) -> Array:
    return values[np.isfinite(values)]


def _range(variable: Variable, values: Array) -> str:
    known = _known(values)
    unit = variable.unit or readable_unit(known, variable.si_unit)
    text = span(unit.of(known).tolist(), lambda value: number_text(value, _DIGITS))
    return with_unit(f"({text})" if " to " in text and unit.is_power else text, unit)
