"""Points of a study: the cases it asks for, and the rules that they break together."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from fretwear.parts import Part, required
from fretwear.study.case import Case, assemble, with_first_and_last
from fretwear.study.problems import in_words
from fretwear.study.rules import RULES, Finding, Rule
from fretwear.study.tree import CaseTree, leaves, member_of, members


@dataclass(frozen=True)
class Axis:
    """One varied parameter.

    Attributes
    ----------
    name : str
        Dotted name as in the file.
    values : tuple
        Values in SI units, in the order of the file (sampled designs: one per point).
    written : tuple
        The values as a study file would have them.
    """

    name: str
    values: tuple[Any, ...]
    written: tuple[Any, ...]

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

    @property
    def labels(self) -> tuple[str, ...]:
        """The values in the words of the file."""
        return tuple(in_words(value) for value in self.written)


@dataclass(frozen=True)
class Point:
    """One point of a study.

    Attributes
    ----------
    index : tuple of int
        Position along each axis (under ``zip`` and sampled designs the same along all).
    values : dict
        Varied parameters by dotted name, in SI units.
    labels : dict
        The same in the words of the file.
    case : Case or None
        What to run; None where the point is invalid.
    problem : str
        Why it is invalid, or an empty string.
    """

    index: tuple[int, ...]
    values: Mapping[str, Any]
    labels: Mapping[str, str]
    case: Case | None
    problem: str = ""

    @cached_property
    def id(self) -> str:
        """Case id; empty where the point is invalid.  Points that come to one case share it."""
        return self.case.case_id if self.case is not None else ""


@dataclass(frozen=True)
class PointFinding:
    """A rule that some points break: at which positions of which axes."""

    finding: Finding
    where: tuple[tuple[Axis, int], ...]


@dataclass(frozen=True)
class Parameters:
    """Sound values of a study: fixed ones, axes, and the points as positions along the axes."""

    fixed: Mapping[str, Any]
    axes: tuple[Axis, ...]
    indices: Sequence[tuple[int, ...]]
    _made: dict[tuple[str, tuple[int, ...]], Any] = field(default_factory=dict, repr=False)

    def points(self, broken: Mapping[tuple[int, ...], str]) -> Iterator[Point]:
        """Iterate over the points; `broken` says why some of them are invalid."""
        labels = [axis.labels for axis in self.axes]
        for index in self.indices:
            problem = broken.get(index, "")
            yield Point(
                index=index,
                values={
                    axis.name: axis.values[i] for axis, i in zip(self.axes, index, strict=True)
                },
                labels={
                    axis.name: texts[i]
                    for axis, texts, i in zip(self.axes, labels, index, strict=True)
                },
                case=None if problem else self.case(index),
                problem=problem,
            )

    def case(self, index: tuple[int, ...]) -> Case:
        """Return the case of a point from values that have been read and checked one by one."""
        assembled = dict(self._fixed_members)
        for member in self._sound_members:
            axes = self._varied_members[member]
            assembled[member] = self._member(member, tuple(index[i] for i in axes))
        if "cycles" in assembled:
            snapshots = assembled.get("output_cycles", ())
            assembled["output_cycles"] = with_first_and_last(snapshots, assembled["cycles"])
        return Case.of(assembled)

    @cached_property
    def _fixed_members(self) -> dict[str, Any]:
        values = {name: value for name, value in self.fixed.items() if name != "output_cycles"}
        assembled = assemble(values)
        if "output_cycles" in self.fixed:
            assembled["output_cycles"] = self.fixed["output_cycles"]
        return {n: part for n, part in assembled.items() if n not in self._varied_members}

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
            fixed = {n: value for n, value in self.fixed.items() if _belongs(n, member)}
            base = fixed.get(member)
            if isinstance(base, Part):
                fields = {name.rpartition(".")[2]: value for name, value in drawn.items()}
                drawn = {member: type(base).unchecked(**{**vars(base), **fields})}
            self._made[key] = assemble({**fixed, **drawn})[member]
        return self._made[key]

    @cached_property
    def _sound_members(self) -> tuple[str, ...]:
        """Varied members that can be made: others that their values need may be wrong."""
        sound = []
        for member, axes in self._varied_members.items():
            with suppress(KeyError):
                self._member(member, (0,) * len(axes))
                sound.append(member)
        return tuple(sound)

    def find(self) -> Iterator[tuple[PointFinding, list[tuple[int, ...]]]]:
        """Iterate over the broken rules, each with the points that break it.

        A rule is tried once for each combination of the values it needs, and only where all
        of these are among the sound values.
        """
        defaulted = {*members(), "output_cycles"} - required(CaseTree)
        known = {*self._fixed_members, *self._sound_members, *(defaulted - {*self._varied_members})}
        trials = [
            _Trial(
                rule,
                [i for i, axis in enumerate(self.axes) if {axis.member, axis.name} & rule.needs],
            )
            for rule in RULES
            if {_member_needed(name) for name in rule.needs} <= known
        ]
        # Point by point, so that the case of a point is made once for all rules.
        for index in self.indices:
            case: Case | None = None
            for trial in trials:
                if trial.is_new(index):
                    case = self.case(index) if case is None else case
                    trial.found(index, trial.rule.find(case))
        for trial in trials:
            for positions, (finding, points) in trial.broken.items():
                where = zip((self.axes[i] for i in trial.relevant), positions, strict=True)
                yield PointFinding(finding, tuple(where)), points


def _belongs(name: str, member: str) -> bool:
    return name != "output_cycles" and member_of(name) == member


def _member_needed(name: str) -> str:
    return name if name == "output_cycles" else member_of(name)


@dataclass
class _Trial:
    """A rule tried at the points: once for each combination of the values it needs."""

    rule: Rule
    relevant: Sequence[int]
    sound: set[tuple[int, ...]] = field(default_factory=set)
    broken: dict[tuple[int, ...], tuple[Finding, list[tuple[int, ...]]]] = field(
        default_factory=dict
    )

    def is_new(self, index: tuple[int, ...]) -> bool:
        """Say whether the rule is to be tried here; keep the point where it is known to break."""
        positions = self._positions(index)
        if positions in self.broken:
            self.broken[positions][1].append(index)
        return positions not in self.sound and positions not in self.broken

    def found(self, index: tuple[int, ...], finding: Finding | None) -> None:
        """Keep what was found at a point."""
        if finding is None:
            self.sound.add(self._positions(index))
        else:
            self.broken[self._positions(index)] = (finding, [index])

    def _positions(self, index: tuple[int, ...]) -> tuple[int, ...]:
        return tuple([index[i] for i in self.relevant])
