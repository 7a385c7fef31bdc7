"""Points of a study: the cases it asks for, and the rules that they break together."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from fretwear.parts import Part, required
from fretwear.study.case import Case, assemble
from fretwear.study.cost import Estimate, estimate
from fretwear.study.names import leaves, member_of
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
        assembled = dict(self._fixed_members)
        for member in self._sound_members:
            axes = self._varied_members[member]
            assembled[member] = self._member(member, tuple(index[i] for i in axes))
        return Case.of(assembled)

    @cached_property
    def _fixed_members(self) -> dict[str, Any]:
        made = assemble(self.fixed)
        return {name: part for name, part in made.items() if name not in self._varied_members}

    @cached_property
    def _varied_members(self) -> dict[str, list[int]]:
        """Positions of the axes that vary a member or a part of it, by member."""
        found: dict[str, list[int]] = {}
        for position, axis in enumerate(self.axes):
            found.setdefault(axis.member, []).append(position)
        return found

    def _member(self, member: str, positions: tuple[int, ...]) -> Any:
        # Points share parts: each combination of the values of one is made once.
        key = member, positions
        if key not in self._made:
            axes = [self.axes[i] for i in self._varied_members[member]]
            drawn = {axis.name: axis.values[i] for axis, i in zip(axes, positions, strict=True)}
            fixed = {n: each for n, each in self.fixed.items() if member_of(n) == member}
            base = fixed.get(member)
            if isinstance(base, Part):
                fields = {name.rpartition(".")[2]: value for name, value in drawn.items()}
                drawn = {member: type(base).unchecked(**{**vars(base), **fields})}
            self._made[key] = assemble({**fixed, **drawn})[member]
        return self._made[key]

    @cached_property
    def _sound_members(self) -> tuple[str, ...]:
        """Varied members that can be made: others that their values need may be wrong."""
        valid = []
        for member, axes in self._varied_members.items():
            with suppress(KeyError):
                self._member(member, (0,) * len(axes))
                valid.append(member)
        return tuple(valid)

    def find(self) -> Iterator[BrokenRule]:
        """Iterate over the broken rules.

        A rule is tried once for each combination of the values it needs, and only where all
        of these are among the valid values.
        """
        defaulted = {*members(), "output_cycles"} - required(CaseTree) - {*self._varied_members}
        known = {*self._fixed_members, *self._sound_members, *defaulted}
        trials: list[tuple[Rule, list[int], dict[Any, Problem | None], dict[Any, list[Any]]]] = []
        for rule in RULES:
            if {member_of(name) for name in rule.needs} <= known:
                axes = enumerate(self.axes)
                relevant = [i for i, axis in axes if {axis.member, axis.name} & rule.needs]
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
