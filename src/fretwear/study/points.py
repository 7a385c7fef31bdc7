"""Points of a study: the cases it asks for, and the rules that they break together."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from fretwear.parts import Part, required
from fretwear.study.case import Case, by_member, make_member
from fretwear.study.cost import Estimate, estimate
from fretwear.study.parameters import leaves, member_of
from fretwear.study.problems import Problem, in_words
from fretwear.study.rules import RULES, Rule
from fretwear.study.tree import CaseTree, members

_SAMPLE_DIGITS = 6


@dataclass(frozen=True)
class Range:
    """An interval to sample, in SI units, evenly or evenly in the logarithm."""

    low: float
    high: float
    logarithmic: bool = False

    def at(self, fraction: float) -> float:
        """Return the value at a fraction of the way, rounded to six digits."""
        if self.logarithmic:
            value = math.exp(
                math.log(self.low) + fraction * (math.log(self.high) - math.log(self.low))
            )
        else:
            value = self.low + fraction * (self.high - self.low)
        # Few digits: the ids of the cases must not hang on the last bit of a logarithm.
        return float(f"{value:.{_SAMPLE_DIGITS}g}")


@dataclass(frozen=True)
class Axis:
    """One varied parameter."""

    name: str  # dotted, as in the file
    values: tuple[Any, ...]  # in SI units, in the order of the file; sampled designs: one a point
    written: tuple[Any, ...]  # as a study file would have them
    place: str  # where they stand in the file: ``vary.load``
    drawn_from: Range | None = None  # None where the values were listed

    @cached_property
    def member(self) -> str:
        """Member of the case of which this is all or a part."""
        return member_of(self.name)

    @property
    def key(self) -> str:
        """Key of `base` of which this is all or a part."""
        return self.name.split(".", 1)[0]

    @property
    def coordinate(self) -> str:
        """Name as a dataset coordinate."""
        names = [leaf.name for leaf in leaves().get(self.name, ())]
        return (names[0] if names else self.name).replace(".", "_")

    @cached_property
    def labels(self) -> tuple[str, ...]:
        """The values in the words of the file."""
        return tuple(in_words(value) for value in self.written)


@dataclass(frozen=True)
class Point:
    """One point of a study."""

    axes: tuple[Axis, ...] = field(repr=False)
    index: tuple[int, ...]  # position along each axis (zip and sampled designs: the same along all)
    case: Case | None  # what to run; None where the point is invalid
    problem: str = ""  # why it is invalid

    @cached_property
    def id(self) -> str:
        """Case id; empty where the point is invalid.  Points that come to one case share it."""
        return self.case.case_id if self.case is not None else ""

    @cached_property
    def estimate(self) -> Estimate | None:
        """What the case is expected to take; None where the point is invalid."""
        return estimate(self.case) if self.case is not None else None

    @property
    def values(self) -> dict[str, Any]:
        """Varied parameters by dotted name, in SI units."""
        return {a.name: a.values[i] for a, i in zip(self.axes, self.index, strict=True)}

    @property
    def labels(self) -> dict[str, str]:
        """Varied parameters by dotted name, in the words of the file."""
        return {a.name: a.labels[i] for a, i in zip(self.axes, self.index, strict=True)}


@dataclass(frozen=True)
class BrokenRule:
    """A rule that some points break: at which positions of which axes."""

    problem: Problem
    where: tuple[tuple[Axis, int], ...]
    points: Sequence[tuple[int, ...]]


@dataclass(frozen=True)
class Parameters:
    """Sound values of a study: fixed ones, axes, and the points as positions along the axes."""

    fixed: Mapping[str, Any]
    axes: tuple[Axis, ...]
    indices: Sequence[tuple[int, ...]]
    _made: dict[tuple[str, tuple[int, ...]], Any] = field(default_factory=dict, repr=False)

    def points(self, broken: Mapping[tuple[int, ...], str]) -> Iterator[Point]:
        """Iterate over the points; `broken` says why some of them are invalid."""
        for index in self.indices:
            problem = broken.get(index, "")
            yield Point(self.axes, index, None if problem else self.case(index), problem)

    def case(self, index: tuple[int, ...]) -> Case:
        """Return the case of a point from values that have been read and checked one by one."""
        return Case.of({**self._constant, **{n: self._member(n, index) for n in self._varied}})

    @cached_property
    def _axes_of(self) -> dict[str, list[int]]:
        """Positions of the axes that vary a member or a part of it, by member."""
        found: dict[str, list[int]] = {}
        for position, axis in enumerate(self.axes):
            found.setdefault(axis.member, []).append(position)
        return found

    @cached_property
    def _valid(self) -> tuple[str, ...]:
        """Members that can be made: others that their values need may be wrong."""
        valid = []
        for member in {**self._own, **self._axes_of}:
            with suppress(KeyError):
                self._member(member, (0,) * len(self.axes))
                valid.append(member)
        return tuple(valid)

    @cached_property
    def _own(self) -> dict[str, dict[str, Any]]:
        return by_member(self.fixed)

    @cached_property
    def _varied(self) -> tuple[str, ...]:
        return tuple(name for name in self._valid if name in self._axes_of)

    @cached_property
    def _constant(self) -> dict[str, Any]:
        return {name: self._member(name, ()) for name in self._valid if name not in self._axes_of}

    def _member(self, member: str, index: tuple[int, ...]) -> Any:
        # Points share parts: each combination of the values of one is made once.
        axes = self._axes_of.get(member, ())
        key = member, tuple([index[i] for i in axes])
        if key not in self._made:
            fixed = self._own.get(member, {})
            drawn = {self.axes[i].name: self.axes[i].values[index[i]] for i in axes}
            base = fixed.get(member)
            if drawn and isinstance(base, Part):
                fields = {name.rpartition(".")[2]: value for name, value in drawn.items()}
                drawn = {member: type(base).unchecked(**{**vars(base), **fields})}
            self._made[key] = make_member(member, {**fixed, **drawn})
        return self._made[key]

    def find(self) -> Iterator[BrokenRule]:
        """Iterate over the broken rules.

        A rule is tried once for each combination of the values it needs, and only where all
        of these are among the valid values.
        """
        defaulted = {*members(), "output_cycles"} - required(CaseTree) - {*self._axes_of}
        known = {*self._valid, *defaulted, *(("cycles",) if "blocks" in self._valid else ())}
        trials: list[tuple[Rule, list[int], dict[Any, Problem | None], dict[Any, list[Any]]]] = []
        for rule in RULES:
            if {member_of(name) for name in rule.needs} <= known:
                # Blocks have cycles of their own.
                needs = rule.needs | ({"blocks"} if "cycles" in rule.needs else set())
                axes = enumerate(self.axes)
                relevant = [i for i, axis in axes if {axis.member, axis.name} & needs]
                trials.append((rule, relevant, {}, {}))
        # Point by point, so that the case of a point is made once for all rules.
        for index in self.indices:
            case: Case | None = None
            for rule, relevant, tried, broken in trials:
                positions = tuple([index[i] for i in relevant])
                if positions not in tried:
                    case = case or self.case(index)
                    tried[positions] = rule.find(case)
                if tried[positions] is not None:
                    broken.setdefault(positions, []).append(index)
        for _, relevant, tried, broken in trials:
            for positions, points in broken.items():
                where = zip((self.axes[i] for i in relevant), positions, strict=True)
                if (problem := tried[positions]) is not None:
                    yield BrokenRule(problem, tuple(where), points)
