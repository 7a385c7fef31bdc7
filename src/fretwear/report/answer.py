"""The answer of a study: claims in numbers, and the sentences rendered from them.

A claim compares the final results of cases that differ in one parameter alone, at two of its
levels. Its factors are ratios of the result at the last level to the result at the first.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fretwear.arrays import Array
from fretwear.data.effects import (
    GOOD,
    SEED,
    Effect,
    Indices,
    Points,
    Value,
    rank_correlations,
)
from fretwear.study.parameters import parameter, value_text
from fretwear.units import fixed_digits, listed, number_text, readable_unit, span, with_unit
from fretwear.vocabulary import HEADLINES, RESULTS, Variable

if TYPE_CHECKING:
    import xarray as xr

_UNCHANGED = 5e-3
_EXACT = 1e-6
_DIGITS = 3
_MOST_RUNS, _MOST_PARTS = 4, 3

_STICK = "stick"  # in the names of results of the stick zone, which may not exist


@dataclass(frozen=True)
class Claim:
    """The change of a result between two levels of a parameter, in m pairs of cases."""

    effect: Effect  # the parameter, the result and the m pairs, all between the same two levels
    where: Mapping[str, Value] = field(default_factory=dict)  # other levels that limit the claim

    @property
    def ends(self) -> tuple[Value, Value]:
        """The levels of the parameter that are compared."""
        place = self.effect.points.place(self.effect.parameter)
        levels = self.effect.points.levels[self.effect.parameter]
        return levels[place[self.effect.low[0]]], levels[place[self.effect.high[0]]]

    @property
    def factors(self) -> Array:
        """The factors of the pairs in which it is defined."""
        return _finite(self.effect.factors)

    @property
    def is_one_way(self) -> bool:
        """Whether the result grows, falls or stays in all pairs alike, as far as it is defined."""
        return (
            len({way for pair in zip(*self.effect.values, strict=True) for way in _steps(pair)}) < 2
        )

    @property
    def between(self) -> str:
        """Words on pairs in which the result goes another way between the levels; may be empty."""
        points, name = self.effect.points, self.effect.parameter
        place = points.place(name)
        values = points.results[self.effect.result]
        ways = set(_ways(self.factors).tolist())
        if len(ways) != 1 or not all(map(_is_number, self.ends)):
            return ""
        (way,), count, defined = ways, 0, np.isfinite(self.effect.factors)
        ends = dict(zip(self.effect.low[defined], place[self.effect.high[defined]], strict=True))
        for line in points.lines[name]:
            here = [row for row in line if row in ends]
            inside = [row for row in line for low in here if place[low] <= place[row] <= ends[low]]
            count += any(step * way < 0 if way else step for step in _steps(values[inside]))
        among = "" if count == len(ends) else f" in {count} of these {len(ends)} pairs"
        verb = {1: "falls", -1: "grows", 0: "varies by more"}[way]
        return f", end to end; in between it {verb}{among}" if count else ""

    def content(self) -> dict[str, object]:
        """Return the claim as ``answer.json`` has it."""
        before, after = self.effect.values
        factors = self.factors
        return {
            "result": self.effect.result,
            "parameter": self.effect.parameter,
            "from": _plain(self.ends[0]),
            "to": _plain(self.ends[1]),
            "where": {name: _plain(value) for name, value in self.where.items()},
            "pairs": len(before),
            "lowest_factor": float(factors.min()) if factors.size else None,
            "highest_factor": float(factors.max()) if factors.size else None,
            "undefined": len(before) - factors.size,
            "appears": int(((before == 0.0) & (after > 0.0)).sum()),
            "vanishes": int(((before > 0.0) & (after == 0.0)).sum()),
            "text": self.text,
        }

    @property
    def text(self) -> str:
        """The claim in words; the subject is the result ("it") or the stick zone."""
        where = [_where(name, value) for name, value in self.where.items()]
        start = f"where {listed(where)}, " if where else ""
        change = _change(self.effect.parameter, *self.ends)
        verbs, zone = [*self._verbs()], [*self._of_zone()]
        first, *others = [f"it {verbs[0]}", *verbs[1:], *zone] if verbs else zone
        others = [phrase.replace(f" of {len(self.effect.low)} pairs", "") for phrase in others]
        return f"{start}from {change} {listed([first, *others])}{self.between}"

    def _verbs(self) -> Iterator[str]:
        """Yield the changes of the result, each with the pairs in which it occurs."""
        before, after = self.effect.values
        ways = _ways(self.factors)
        for way in (1, -1, 0):
            if (here := ways == way).any():
                yield f"{_by(self.factors[here])}{self._among(here)}"
        if not self.is_of_stick:
            appears, vanishes = (before == 0.0) & (after > 0.0), (before > 0.0) & (after == 0.0)
            if appears.any():
                yield f"rises from zero to {self._size(after[appears])}{self._among(appears)}"
            if vanishes.any():
                yield f"falls from {self._size(before[vanishes])} to zero{self._among(vanishes)}"
            if (both_zero := (before == 0.0) & (after == 0.0)).any():
                yield f"is zero{self._among(both_zero)}"
        unknown = np.isnan(before) | np.isnan(after)
        if unknown.any():
            slides = np.logical_or(*self._slides)[unknown]
            why = ", where a case slides as a whole" if self.is_of_stick and slides.all() else ""
            yield f"is undefined{self._among(unknown)}{why}"

    def _of_zone(self) -> Iterator[str]:
        """Yield in how many pairs a stick zone appears, vanishes or does not exist."""
        before, after = self.effect.values
        if not self.is_of_stick:
            return
        slid, slides = self._slides
        if (appears := (before == 0.0) & (after > 0.0)).any():
            regime = ", as gross slip becomes partial slip"
            regime *= bool((slid & ~slides)[appears].all())
            size = self._size(after[appears])
            yield f"a stick zone appears{self._among(appears)} ({size}){regime}"
        if (vanishes := (before > 0.0) & (after == 0.0)).any():
            regime = ", as partial slip becomes gross slip"
            regime *= bool((slides & ~slid)[vanishes].all())
            size = self._size(before[vanishes])
            yield f"the stick zone ({size}) vanishes{self._among(vanishes)}{regime}"
        if (both_zero := (before == 0.0) & (after == 0.0)).any():
            yield f"nothing sticks{self._among(both_zero)}"

    @property
    def is_of_stick(self) -> bool:
        """Whether the result belongs to the stick zone, which may not exist."""
        return _STICK in self.effect.result

    @property
    def _slides(self) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Which cases at the first and at the last level slide as a whole."""
        points = self.effect.points
        regime = points.results.get("regime", np.full(len(points.ids), np.nan))
        return regime[self.effect.low] == 1.0, regime[self.effect.high] == 1.0

    def _size(self, values: Array) -> str:
        points, name = self.effect.points, self.effect.result
        return _range(points.variables.get(name, RESULTS[name]), values)

    def _among(self, pairs: NDArray[np.bool_]) -> str:
        count, all_pairs = int(pairs.sum()), len(self.effect.low)
        if count < all_pairs:
            return f" in {count} of {all_pairs} pairs"
        return {1: "", 2: " in both pairs"}.get(count, f" in all {count} pairs")


class Chance(NamedTuple):
    """The scatter of a result over seeds, none of which is better than another."""

    effect: Effect

    def content(self) -> dict[str, object]:
        """Return the claim as ``answer.json`` has it, with factors relative to the mean over seeds.

        Levels are null, since the order of seeds has no meaning.
        """
        ensembles, seeds = self._ensembles(), self.effect.points.lines[SEED]
        shares = np.concatenate([line / line.mean() for line in ensembles] or [[]])
        pairs, known = (sum(math.comb(len(of), 2) for of in lines) for lines in (seeds, ensembles))
        return {
            "result": self.effect.result,
            "parameter": SEED,
            "from": None,
            "to": None,
            "where": {},
            "pairs": pairs,
            "lowest_factor": float(shares.min()) if shares.size else None,
            "highest_factor": float(shares.max()) if shares.size else None,
            "undefined": pairs - known,
            "appears": 0,
            "vanishes": 0,
            "text": self.text,
        }

    @property
    def text(self) -> str:
        """The scatter in words: the quadratic mean of the deviations in the ensembles."""
        squares = [line.var(ddof=1) / line.mean() ** 2 for line in self._ensembles()]
        if not squares:
            return "it is undefined or zero for all seeds but one"
        deviation = _percent(math.sqrt(math.fsum(squares) / len(squares)))
        return f"it varies by chance, with a standard deviation of {deviation}\u00a0%"

    def _ensembles(self) -> list[Array]:
        """Return the results of each ensemble, without zero and undefined ones."""
        points = self.effect.points
        lines = [points.results[self.effect.result][line] for line in points.lines[SEED]]
        return [line[line > 0.0] for line in lines if np.count_nonzero(line > 0.0) > 1]


class Influence(NamedTuple):
    """The influence of one parameter on one result."""

    parameter: str
    claims: Sequence[Claim | Chance]  # in order; together they cover all levels
    details: Sequence[Claim] = ()  # the claims at each level of the parameter that divides them

    @property
    def name(self) -> str:
        """The parameter in words, as a sentence begins."""
        words = parameter(self.parameter).words
        return words[:1].upper() + words[1:]

    @property
    def text(self) -> str:
        """All claims in one sentence."""
        return "; ".join(claim.text for claim in self.claims)


class Answer(NamedTuple):
    """The answer of a study for one result."""

    name: str
    label: str
    values: str  # its range after the last cycle
    lines: tuple[Influence, ...]  # one for each parameter, the most important first
    headline: str = ""  # in a sampled study, the parameter that matters most
    rest: str = ""  # details that a narrow screen leaves out


def answers(summary: xr.Dataset) -> Iterator[Answer]:
    """Yield the answers of a merged study for the `HEADLINES`.

    A result that no case has, or that is zero in all cases, as without a stick zone, is left out.
    """
    points = Points.of(summary)
    _, cases = np.unique(points.ids, return_index=True)
    indices = points.indices if points.drawn and points.ids else {}
    for name in HEADLINES if points.ids else ():
        results = points.results.get(name, np.array([np.nan]))
        if not np.nan_to_num(results).any():
            continue
        varied = [] if points.drawn else [key for key in points.levels if points.lines[key]]
        varied.sort(key=lambda key: points.importance(key, name), reverse=True)
        effects = [points.effect(key, name) for key in varied]
        # An exact proportion follows from imposed quantities and is not a finding.
        imposed = {effect.parameter: word for effect in effects if (word := _proportion(effect))}
        lines = tuple(_line(effect) for effect in effects if effect.parameter not in imposed)
        proportions = [f"{word} to the {parameter(key).words}" for key, word in imposed.items()]
        headline = rest = ""
        if proportions:
            rest = f"Imposed quantities make it {listed(proportions)}."
        if points.drawn and name in indices and indices[name].quality >= GOOD:
            headline, rest = _by_indices(points, indices[name])
        elif points.drawn:
            headline = _by_ranks(points, results)
        variable = points.variables.get(name, RESULTS[name])
        there = ~np.isnan(results[cases]) & ((results[cases] > 0.0) | (_STICK not in name))
        values = _range(variable, results[cases][there])
        if not there.all():
            values += f", in {there.sum()} of {cases.size} cases"
        yield Answer(name, variable.label, values, lines, headline, rest)


def answer_text(all_answers: Iterable[Answer]) -> str:
    """Return every claim of the answers as JSON, for ``answer.json``."""
    contents = [
        claim.content()
        for answer in all_answers
        for line in answer.lines
        for claim in (*line.claims, *line.details)
    ]
    return json.dumps(contents, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def regimes(summary: xr.Dataset) -> str:
    """Return the regimes of slip after the last cycle in words; empty if all slip partially."""
    points = Points.of(summary)
    _, cases = np.unique(points.ids, return_index=True)
    empty = np.full(len(points.ids), np.nan)
    regime = points.results.get("regime", empty)[cases]
    stick = points.results.get("stick_half_width_x", empty)[cases]
    gross, partial = int((regime == 1.0).sum()), int((regime == 0.0).sum())
    if gross and partial:
        return (
            f"After the last cycle {partial} of {regime.size} cases "
            f"{'are' if partial > 1 else 'is'} in partial slip and {gross} in gross slip."
        )
    if not stick.size or np.isnan(stick).all() or stick.any():
        return ""
    which = "Nothing sticks" if stick.size == 1 else "In no case does anything stick"
    why = f": {'all are' if stick.size > 1 else 'it is'} in gross slip" if gross else ""
    return f"{which} after the last cycle{why}."


def _line(effect: Effect) -> Influence:
    """Return the influence of a parameter on a result."""
    if effect.parameter == SEED:
        return Influence(SEED, [Chance(effect)])
    on_effect = [*claims(effect)]
    details = [part for claim in on_effect if not claim.where for part in _divided(claim)]
    return Influence(effect.parameter, on_effect, details)


def claims(effect: Effect) -> Iterator[Claim]:
    """Yield claims on an effect, as few as show which way it goes.

    Levels that are not numbers, such as "no limit", are compared with the last number alone.
    """
    levels = effect.points.levels[effect.parameter]
    numbers = [place for place, level in enumerate(levels) if _is_number(level)]
    runs = [*_runs(effect, len(numbers))] if numbers else []
    others = [place for place in range(len(levels)) if place not in numbers]
    first = numbers[-1] if numbers else others.pop(0)
    for low, high in [*runs, *((first, other) for other in others)]:
        yield from _of_levels(effect, low, high)


def _of_levels(effect: Effect, low: int, high: int) -> Iterator[Claim]:
    """Yield the claims on a change from one level to another, usually one."""
    points, name = effect.points, effect.parameter
    numeric = [_is_number(level) for level in points.levels[name]]
    # If cases are missing, some lines begin or end at a level between the two.
    ends: set[tuple[int, int]] = set()
    for line in (points.place(name)[line].tolist() for line in points.lines[name]):
        if numeric[high]:
            inside = [place for place in line if low <= place <= high]
        else:
            inside = [place for place in line if numeric[place]][-1:] if numeric[low] else line[:1]
            inside += [place for place in line if place == high]
        if inside and inside[0] != inside[-1]:
            ends.add((inside[0], inside[-1]))
    for first, last in sorted(ends):
        claim = Claim(effect.between(first, last))
        parts = [] if claim.is_one_way else [*_divided(claim)]
        is_clear = 0 < len(parts) <= _MOST_PARTS and all(part.is_one_way for part in parts)
        yield from parts if is_clear else [claim]


def _runs(effect: Effect, count: int) -> Iterator[tuple[int, int]]:
    """Yield ranges of the first `count` levels in which a result is monotonic, or one if many."""
    place = effect.points.place(effect.parameter)
    values = effect.points.results[effect.result]
    steps: list[set[int]] = [set() for _ in range(count - 1)]
    for line in effect.points.lines[effect.parameter]:
        rows = [row for row in line if place[row] < count and not np.isnan(values[row])]
        for (low, high), way in zip(pairwise(rows), _steps(values[rows]), strict=True):
            for ways in steps[place[low] : place[high]]:
                ways.add(way)
    runs, start, now = [], 0, {0}
    for number, ways in enumerate(steps):
        if ways - {0} and now - {0} and ways - {0} != now - {0}:
            runs.append((start, number))
            start, now = number, {0}
        now |= ways
    if count > 1:
        runs.append((start, count - 1))
    # If the case at a turn is missing, both sides of the turn belong to one pair.
    lines = [place[line] for line in effect.points.lines[effect.parameter]]
    turns = [turn for turn, _ in runs[1:]]
    is_broken = any(t not in line and line[0] < t < line[-1] for t in turns for line in lines)
    yield from [(0, count - 1)] if is_broken or len(runs) > _MOST_RUNS else runs


def _divided(claim: Claim) -> Iterator[Claim]:
    """Yield a claim for each level of the parameter on which the factor depends most."""
    effect, name = claim.effect, claim.effect.divider
    for level, value in enumerate(effect.points.levels.get(name, ())):
        if (pairs := effect.where(name, level)).any():
            yield Claim(effect.select(pairs), {**claim.where, name: value})


def _by_indices(points: Points, indices: Indices) -> tuple[str, str]:
    names = [parameter(name).words for name in points.levels]
    order = np.argsort(-indices.total)
    # Parameters with overlapping intervals are not ranked.
    low, high = indices.total_range
    leading = [i for i in order if high[i] >= low[order[0]]]
    of = "the result's logarithm" if indices.of_logarithm else "the result"
    if len(leading) > 1:
        several = " and the ".join(names[i] for i in leading)
        text = f"The {several} matter most, and their order is uncertain. Alone they explain "
    else:
        text = f"The {names[order[0]]} matters most: alone it explains "
    first, low, high = (100.0 * share for share in (indices.first, *indices.first_range))
    shares = [f"{first[i]:.0f} ({low[i]:.0f} to {high[i]:.0f})\u00a0%" for i in leading]
    others = [f"{names[i]} {100.0 * indices.total[i]:.0f}\u00a0%" for i in order]
    rest = f"With interactions: {', '.join(others)}."
    return f"{text}{' and '.join(shares)} of the variance of {of} (95\u00a0% intervals).", rest


def _by_ranks(points: Points, results: Array) -> str:
    defined = np.isfinite(results)
    if defined.sum() < len(points.levels) + 2 or np.ptp(results[defined]) == 0.0:
        return "There are too few points to compare, or they are all the same."
    lacking = int((~defined).sum())
    why = f"it is undefined at {lacking} of" if lacking else "no emulator is good enough with"
    correlations = rank_correlations(points.unit[defined], results[defined, None])[:, 0]
    names = [parameter(name).words for name in points.levels]
    order = np.argsort(-np.abs(correlations))
    ranks = [f"{names[i]} {number_text(round(float(correlations[i]), 2))}" for i in order]
    return (
        f"The {names[order[0]]} matters most by Spearman's rank correlation: {', '.join(ranks)}. "
        f"There are no Sobol indices, because {why} its {defined.size} points."
    )


def _proportion(effect: Effect) -> str:
    """Return how a result is exactly proportional to the parameter in all lines; else empty.

    Imposed quantities make it so: no integral over many steps is so exact by chance.
    """
    levels = effect.points.levels[effect.parameter]
    if effect.parameter == SEED or not all(_is_number(v) and v > 0.0 for v in levels):
        return ""
    place = effect.points.place(effect.parameter)
    values = np.array(levels, dtype=np.float64)
    ratios = values[place[effect.high]] / values[place[effect.low]]
    kinds = {"proportional": ratios, "inversely proportional": 1.0 / ratios}
    exact = (word for word, f in kinds.items() if (np.abs(effect.factors / f - 1) < _EXACT).all())
    return next(exact, "")


def _ways(factors: Array) -> NDArray[np.int_]:
    """Return 1 where a result grows, −1 where it falls, 0 where it stays."""
    return (factors > 1.0 + _UNCHANGED).astype(int) - (factors < 1.0 - _UNCHANGED)


def _steps(values: Sequence[float] | Array) -> list[int]:
    """Return the ways, as `_ways`, from each defined value of a result to the next."""
    defined = np.asarray(values)
    defined = defined[~np.isnan(defined)]
    before, after = defined[:-1], defined[1:]
    factors = np.divide(after, before, out=1.0 + np.sign(after), where=before > 0.0)
    return _ways(factors).tolist()  # type: ignore[no-any-return]


def _change(name: str, first: Value, last: Value) -> str:
    texts = [value_text(name, value) for value in (first, last)]
    numbers, units = zip(*(text.partition(" ")[::2] for text in texts), strict=True)
    is_shared = units[0] == units[1] and not any(parameter(name).word_for(v) for v in (first, last))
    low = numbers[0] if is_shared else texts[0]
    return f"{low} to {texts[1]}".replace(" ", "\u00a0").replace("\u00a0to\u00a0", " to ")


def _where(name: str, value: Value) -> str:
    about, text = parameter(name), value_text(name, value).replace(" ", "\u00a0")
    article = "" if "'s " in about.words else "the "  # Poisson's ratio
    return text if about.word_for(value) else f"{article}{about.words} is {text}"


def _by(factors: Array) -> str:
    """Return by how much results grow or fall, or that they stay; all go one way."""
    low, high = float(factors.min()), float(factors.max())
    if not _ways(factors).any():
        is_same = max(high - 1.0, 1.0 - low) < _EXACT
        return (
            "stays the same" if is_same else f"changes by less than {100.0 * _UNCHANGED:g}\u00a0%"
        )
    if high >= 2.0:
        return f"grows by a factor of {_span(low, high, _factor)}"
    if low < 0.1:
        return f"falls by a factor of {_span(1.0 / high, 1.0 / low, _factor)}"
    if low > 1.0:
        return f"grows by {_span(low - 1.0, high - 1.0, _percent)}\u00a0%"
    return f"falls by {_span(1.0 - high, 1.0 - low, _percent)}\u00a0%"


def _span(low: float, high: float, text: Callable[[float], str]) -> str:
    return span([low, high], text)


def _factor(value: float) -> str:
    return fixed_digits(value, _DIGITS)


def _percent(share: float) -> str:
    return f"{100.0 * share:.{1 if share < 0.0995 else 0}f}"


def _is_number(value: Value) -> bool:
    return not isinstance(value, str) and math.isfinite(value)


def _plain(value: Value) -> float | str:
    """Return a level as in JSON and study files."""
    return value if isinstance(value, str) else "none" if math.isinf(value) else float(value)


def _finite(values: Array) -> Array:
    return values[np.isfinite(values)]


def _range(variable: Variable, values: Array) -> str:
    finite = _finite(values)
    unit = variable.unit or readable_unit(finite, variable.si_unit)
    text = span(unit.of(finite).tolist(), lambda value: number_text(value, _DIGITS))
    return with_unit(f"({text})" if " to " in text and unit.is_power else text, unit)
