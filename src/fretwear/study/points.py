"""Points of a study: the cases it asks for, and the rules that they break together."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from pydantic import ValidationError

from fretwear.study.case import Case, WavyRoughness, with_first_and_last
from fretwear.study.checks import CHECKS, TANGENTIAL, Check, Finding
from fretwear.study.parameters import ROUGHNESS
from fretwear.study.problems import in_words


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

    @property
    def field(self) -> str:
        """Name of the case parameter of which this is all or a part."""
        return self.name.split(".", 1)[0]

    @property
    def coordinate(self) -> str:
        """Name as a dataset coordinate."""
        return self.name.replace(".", "_")

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
        values = dict(self.fixed)
        values.update({axis.name: axis.values[i] for axis, i in zip(self.axes, index, strict=True)})
        parts = {name: values.pop(name) for name in list(values) if "." in name}
        if parts:
            values[ROUGHNESS] = WavyRoughness.model_construct(
                **{name.split(".", 1)[1]: value for name, value in parts.items()}
            )
        rough = values.get(ROUGHNESS)
        if rough is not None and rough.amplitude == 0.0:
            values[ROUGHNESS] = None
        if "cycles" in values:
            snapshots = values.get("output_cycles", ())
            values["output_cycles"] = with_first_and_last(snapshots, values["cycles"])
        return Case.model_construct(**values)

    def find(self) -> Iterator[tuple[PointFinding, list[tuple[int, ...]]]]:
        """Iterate over the broken rules, each with the points that break it.

        A rule is tried once for each combination of the values it needs, and only where all
        of these are among the sound values.
        """
        trials = [
            _Trial(check, [i for i, axis in enumerate(self.axes) if axis.field in names])
            for check in (Check(frozenset({ROUGHNESS}), _has_a_wave), *CHECKS)
            if (names := self._names(check)) is not None
        ]
        # Point by point, so that the case of a point is made once for all rules.
        for index in self.indices:
            case: Case | None = None
            for trial in trials:
                if trial.is_new(index):
                    case = self.case(index) if case is None else case
                    trial.found(index, trial.check.find(case))
        for trial in trials:
            for positions, (finding, points) in trial.broken.items():
                where = zip((self.axes[i] for i in trial.relevant), positions, strict=True)
                yield PointFinding(finding, tuple(where)), points

    def _names(self, check: Check) -> set[str] | None:
        given = {name.split(".", 1)[0] for name in self.fixed} | {axis.field for axis in self.axes}
        names = set(check.needs)
        if "tangential" in names:
            names.remove("tangential")
            tangential = given.intersection(TANGENTIAL)
            if len(tangential) != 1:
                return None
            names |= tangential
        return names if names <= given else None


@dataclass
class _Trial:
    """A rule tried at the points: once for each combination of the values it needs."""

    check: Check
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


def _has_a_wave(case: Case) -> Finding | None:
    if case.roughness is None:
        return None
    try:
        WavyRoughness(**case.roughness.model_dump())
    except ValidationError as error:
        context = error.errors()[0]["ctx"]
        return Finding(ROUGHNESS, "", context["rule"], context["hint"])
    return None
