"""Points of a study: the varied values, and how they are combined."""

from __future__ import annotations

import dataclasses
import itertools
import math
import re
import warnings
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Any, Literal

import numpy as np

from fretwear.parts import Choice, Part, WholeNumber, read_fields
from fretwear.problems import Problem, Problems, in_words
from fretwear.study.parameters import (
    coordinate,
    leaves,
    member_of,
    other_name,
    parameter_names,
    parameter_of,
)
from fretwear.units import BY_SI_UNIT, QuantityError, exact_text, in_unit

MAX_POINTS = 200_000

_FEW_SEEDS = 16
_MEANT = re.compile("did you mean '(.*)'\\?")
_ENDS = re.compile(r"\s*(\d.*?)\s*(?:to|\.\.+|–|:)\s*(\d.*?)\s*")


@dataclass(frozen=True)
class Range:
    """An interval to sample, in SI units, uniformly or uniformly in the logarithm."""

    low: float
    high: float
    logarithmic: bool = False

    def at(self, fraction: float) -> float:
        """Return the value at a fraction of the way, rounded to six digits."""
        ends = self.low, self.high
        low, high = map(math.log, ends) if self.logarithmic else ends
        value = low + fraction * (high - low)
        # Six digits keep the ids of cases independent of the last bit of a logarithm.
        return float(f"{math.exp(value) if self.logarithmic else value:.6g}")


class Design(Part):
    """How the varied values are combined: value by value unless a kind says otherwise."""

    def indices(self, lengths: Sequence[int]) -> Iterable[tuple[int, ...]]:
        """Iterate over the points as positions along axes of these lengths, the last fastest."""
        return ((number,) * len(lengths) for number in range(max(lengths, default=1)))


@dataclass(frozen=True)
class Combinations(Design):
    """Every combination of the values."""

    kind: Literal["grid"] = "grid"

    def indices(self, lengths: Sequence[int]) -> Iterable[tuple[int, ...]]:
        """Iterate over each position along each axis."""
        return itertools.product(*map(range, lengths))


@dataclass(frozen=True)
class Zip(Design):
    """First value with first, second with second."""

    kind: Literal["zip"] = "zip"


@dataclass(frozen=True)
class Sampled(Design):
    """Points spread over ranges; the same seed gives the same points."""

    points: Annotated[
        int, WholeNumber("$n$", "number of points", 1, MAX_POINTS, 64, description="How many.")
    ]
    seed: Annotated[
        int,
        WholeNumber(
            "seed", "seed", 0, 2**32 - 1, 1, description="The same seed gives the same points."
        ),
    ] = 0

    def drawn(self, axes: Sequence[Axis]) -> list[Axis]:
        """Return axes with one value per point; listed values occur as equally as counts allow."""
        columns = self.columns(len(axes))
        return [axis.at(column) for axis, column in zip(axes, columns, strict=True)]

    def columns(self, axes: int) -> list[list[float]]:
        """Return numbers from 0 to 1, one list for each of some axes."""
        raise NotImplementedError


@dataclass(frozen=True)
class LatinHypercube(Sampled):
    """One point in each slice of each range."""

    kind: Literal["latin_hypercube"] = "latin_hypercube"

    def columns(self, axes: int) -> list[list[float]]:
        """Draw as `scipy.stats.qmc.LatinHypercube` does, which takes a second to import."""
        random, numbers = np.random.default_rng(self.seed), np.arange(1, self.points + 1)
        inside = random.uniform(size=(self.points, axes)).T
        slices = [random.permutation(numbers) for _ in range(axes)]
        return [*((np.array(slices) - inside) / self.points).tolist()]


@dataclass(frozen=True)
class Sobol(Sampled):
    """A sequence that fills the ranges evenly, best if the number of points is a power of two."""

    kind: Literal["sobol"] = "sobol"

    def columns(self, axes: int) -> list[list[float]]:
        """Draw the scrambled sequence."""
        # It takes a second to import.
        from scipy.stats import qmc

        with warnings.catch_warnings():
            # scipy warns of numbers of points other than powers of two, which users may choose.
            warnings.simplefilter("ignore", UserWarning)
            columns: list[list[float]] = (
                qmc.Sobol(d=axes, seed=self.seed).random(self.points).T.tolist()
            )
        return columns


@dataclass(frozen=True)
class Axis:
    """One varied parameter."""

    name: str  # dotted, as in the file
    values: tuple[Any, ...]  # in SI units, in the order of the file; sampled: one per point
    written: tuple[object, ...]  # as in a study file
    drawn_from: Range | None = None  # None if the values were listed

    @cached_property
    def member(self) -> str:
        """Member of the case to which the parameter belongs."""
        return member_of(self.name)

    @property
    def key(self) -> str:
        """Key of `base` to which the parameter belongs."""
        return self.name.split(".", 1)[0]

    @property
    def coordinate(self) -> str:
        """Name as a dataset coordinate."""
        return coordinate(leaves()[self.name][0].name)

    @cached_property
    def labels(self) -> tuple[str, ...]:
        """The values as written in the file."""
        return tuple(in_words(value) for value in self.written)

    def at(self, fractions: Iterable[float]) -> Axis:
        """Return the axis with the values at fractions of its range, or of its list."""
        if self.drawn_from is None:
            count = len(self.values)
            chosen = [min(int(fraction * count), count - 1) for fraction in fractions]
            values, written = (tuple(of[i] for i in chosen) for of in (self.values, self.written))
        else:
            unit = parameter_of(self.name).suiting(self.drawn_from.low).si_unit
            numbers = [self.drawn_from.at(fraction) for fraction in fractions]
            values = tuple(in_unit(number, unit) for number in numbers)
            written = tuple(exact_text(number, BY_SI_UNIT[unit]) for number in numbers)
        return replace(self, values=values, written=written)


def read_axes(
    vary: Mapping[str, object], design: Design | None, problems: Problems
) -> tuple[Axis, ...]:
    """Read the varied parameters; return the valid axes and collect the problems of the others.

    A design of None is one that could not be read.
    """
    axes: list[Axis] = []
    valid = parameter_names()
    for name, raw in vary.items():
        if name not in valid:
            rule = "is not a case parameter"
            words, valid_words = other_name(name), valid
            if words:
                words, valid_words = f"write {words}", ()
            problems.add(f"vary.{name}", raw, rule, words, valid_words=valid_words, written=name)
            continue
        with problems.at(f"vary.{name}", raw):
            axes.append(_read_axis(name, raw, design))
    for whole in vary:
        for part in [name for name in vary if name.startswith(f"{whole}.")][:1]:
            rule = f"varies as a whole, but {part} varies a part of it"
            problems.add(f"vary.{whole}", None, rule, "vary one or the other")
    if isinstance(design, Sampled):
        if not vary:
            rule = "is missing: a sampled design needs something to vary"
            problems.add("vary", None, rule, "such as load: {from: 10 N, to: 100 N}")
        from_lists = [axis for axis in axes if axis.drawn_from is None]
        combinations = math.prod(len(axis.values) for axis in from_lists)
        if vary and axes == from_lists and len(axes) == len(vary) and combinations < design.points:
            several = f"only {combinations} combination{'s' * (combinations != 1)} of values"
            rule = f"has {several} for the {design.points} points of design: {design.kind}"
            remedy = "design: grid runs each combination"
            for axis in [axis for axis in axes if parameter_of(axis.name).may_be_drawn][:1]:
                ends = f"{{from: {axis.labels[0]}, to: {axis.labels[-1]}}}"
                remedy = f"a range is written {axis.name}: {ends}; {remedy}"
            problems.add("vary", None, rule, remedy)
        return tuple(design.drawn(axes) if axes else ())
    if design is None:
        return ()
    lengths = [len(axis.values) for axis in axes]
    if isinstance(design, Zip):
        if len(set(lengths)) > 1:
            listed = ", ".join(f"{axis.name} has {len(axis.values)}" for axis in axes)
            rule = f"must have lists of equal length under design: zip, but {listed}"
            problems.add("vary", None, rule, "design: grid takes every combination")
            return ()
        seen: dict[object, int] = {}
        for row, values in enumerate(zip(*(axis.values for axis in axes), strict=True)):
            if (first := seen.setdefault(_identity(values), row)) != row:
                given = ", ".join(f"{axis.name} {axis.labels[row]}" for axis in axes)
                rule = f"make point {row + 1} the same as point {first + 1} under design: zip"
                problems.add("vary", given, rule, "leave one of them out of every list")
    size = math.prod(lengths) if isinstance(design, Combinations) else max(lengths, default=1)
    if size > MAX_POINTS:
        rule = f"makes {size} points, more than the limit of {MAX_POINTS}"
        problems.add("vary", None, rule, "split the study")
    return tuple(axes) if size <= MAX_POINTS else ()


def _read_axis(name: str, raw: object, design: Design | None) -> Axis:
    """Read a list, or the range from which values will be drawn."""
    if isinstance(raw, Mapping):
        if parts := [part for part in parameter_names() if part.startswith(f"{name}.")]:
            hint = f"to vary a part of it write {parts[0]}: [{parameter_of(parts[0]).example}, ...]"
            raise QuantityError(f"must be a list of values of {name}", hint)
        return Axis(name, (), (), _read_range(name, raw, design))
    if not isinstance(raw, list):
        hint = f"such as [{parameter_of(name).example}]"
        with suppress(QuantityError):
            for item in map(str.strip, raw.split(",")) if isinstance(raw, str) else [raw]:
                parameter_of(name).read_given(name, item, True)
            hint = f"write [{in_words(raw)}]"
            if name.endswith(".seed") and type(raw) is int and 1 < raw <= _FEW_SEEDS:
                numbers = [*range(1, raw + 1)]
                hint += f", or {numbers} for {raw} surfaces"
        if _ENDS.fullmatch(in_words(raw)):
            hint = "list the values; a sampled design takes {from: 10 N, to: 100 N}"
        elif isinstance(design, Sampled):
            hint = "or a range such as {from: 10 N, to: 100 N, scale: log}"
        raise QuantityError("must be a list of values", hint)
    if not raw:
        raise QuantityError("is an empty list", "list at least one value, or leave it out")
    values: list[object] = []
    seen: dict[object, int] = {}
    problems = Problems()
    for position, item in enumerate(raw):
        with problems.at(f"[{position}]", item):
            values.append(value := _read_item(name, item))
            first = seen.setdefault(_identity(value), position)
            # Paired lists may repeat a value: only equal rows make the same point.
            if first != position and not isinstance(design, Zip):
                rule = f"is the same value as vary.{name}[{first}], {raw[first]}"
                raise QuantityError(rule, "leave one of them out")
    if len(problems) == len(raw) > 1 and len({problem.rule for problem in problems}) == 1:
        meant = [_MEANT.fullmatch(problem.hint) for problem in problems]
        if all(meant):  # such as a unit, which all lack
            hint = f"did you mean [{', '.join(match[1] for match in meant if match)}]?"
            raise QuantityError(problems[0].rule, hint)
    problems.raise_any()
    return Axis(name, tuple(values), tuple(raw))


def _read_item(name: str, item: object) -> object:
    """Read one of the values in a list."""
    try:
        return parameter_of(name).read_given(name, item, True)
    except QuantityError as wrong:
        if not isinstance(item, list) or wrong.hint or wrong.inside:
            raise
        raise QuantityError(wrong.rule, "write one list of values, without inner ones") from wrong


def _identity(value: object) -> object:
    """Return a key that equal values of an axis share, whatever their units."""
    if isinstance(value, float):
        return f"{value:.11e}"
    if dataclasses.is_dataclass(value):
        value = tuple(vars(value)[declared.name] for declared in dataclasses.fields(value))
    return tuple(map(_identity, value)) if isinstance(value, tuple) else value


def _read_range(name: str, raw: Mapping[str, object], design: Design | None) -> Range:
    if not isinstance(design, Sampled | None):
        hint = "write a list, or design: {kind: latin_hypercube, points: 64, seed: 1}"
        raise QuantityError(f"is a range, which design: {design.kind} cannot take", hint)
    quantity, scales = parameter_of(name), Choice("", "", ("linear", "log"))
    keys = {"from": quantity, "to": quantity, "scale": scales}
    if not {"from", "to"} & raw.keys():
        hint = f"such as {name}: {{from: {quantity.example}, to: ...}}"
        raise QuantityError("must be a list, or a range with from and to", hint)
    read = read_fields(raw, keys, ("from", "to"), True) if quantity.may_be_drawn else {}
    low, high, scale = read.get("from"), read.get("to"), read.get("scale")
    if not isinstance(low, float) or not isinstance(high, float):
        raise QuantityError(
            "has values that are not a single quantity and cannot be drawn from a range",
            "write a list: its values are drawn",
        )
    if not low < high < math.inf:
        rule = f"must be more than vary.{name}.from = {raw['from']}, and finite"
        raise QuantityError(rule, inside=[Problem(".to", raw["to"], rule)])
    if scale == "log" and low <= 0.0:
        rule = "must be larger than 0 on a logarithmic scale"
        raise QuantityError(rule, inside=[Problem(".from", raw["from"], rule)])
    return Range(low, high, logarithmic=scale == "log")
