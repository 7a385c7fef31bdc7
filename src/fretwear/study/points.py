"""Points of a study: how varied values are combined, the cases, and the rules they break."""

from __future__ import annotations

import itertools
import math
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated, Any, ClassVar, Literal

from fretwear.parts import Part, WholeNumber, required
from fretwear.study.case import Case
from fretwear.study.cost import Estimate, estimate
from fretwear.study.parameters import by_member, leaves, make_member, member_of
from fretwear.study.problems import Problem, in_words
from fretwear.study.rules import RULES, Rule
from fretwear.study.tree import CaseTree, members

MAX_POINTS = 200_000

_SAMPLE_DIGITS = 6


@dataclass(frozen=True)
class Range:
    """An interval to sample, in SI units, uniformly or uniformly in the logarithm."""

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
        # Few digits, so that the ids of cases do not depend on the last bit of a logarithm.
        return float(f"{value:.{_SAMPLE_DIGITS}g}")


class Design(Part):
    """How the varied values are combined."""

    is_sampled: ClassVar[bool] = False  # whether values are drawn from ranges rather than listed

    def size(self, lengths: Sequence[int]) -> int:
        """Return the number of points for axes of these lengths."""
        raise NotImplementedError

    def indices(self, lengths: Sequence[int]) -> Iterator[tuple[int, ...]]:
        """Iterate over the points as positions along the axes, the last axis fastest."""
        return ((number,) * len(lengths) for number in range(self.size(lengths)))


@dataclass(frozen=True)
class Grid(Design):
    """Every combination of the values."""

    kind: Literal["grid"] = "grid"

    def size(self, lengths: Sequence[int]) -> int:
        """The number of combinations."""
        return math.prod(lengths)

    def indices(self, lengths: Sequence[int]) -> Iterator[tuple[int, ...]]:
        """Each position along each axis."""
        return itertools.product(*(range(length) for length in lengths))


@dataclass(frozen=True)
class Zip(Design):
    """First value with first, second with second."""

    kind: Literal["zip"] = "zip"

    def size(self, lengths: Sequence[int]) -> int:
        """The common length of the axes."""
        return lengths[0] if lengths else 1


@dataclass(frozen=True)
class Sampled(Design):
    """Points spread over ranges; the same seed gives the same points."""

    points: Annotated[
        int, WholeNumber("$n$", "number of points", 1, MAX_POINTS, 64, description="How many.")
    ]
    seed: Annotated[
        int, WholeNumber("seed", "seed", 0, 2**32 - 1, 1, description="The same: the same points.")
    ] = 0

    is_sampled = True
    engine: ClassVar[str]  # of `scipy.stats.qmc`

    def size(self, lengths: Sequence[int]) -> int:  # noqa: ARG002 - as many as wanted
        """The number of points asked for."""
        return self.points

    def sample(self, axes: Sequence[Range | Sequence[Any]]) -> list[list[Any]]:
        """Draw one value per point for each axis.

        The values of a list are drawn equally often, as far as the number of points allows.
        """
        # scipy.stats takes half a second to import: only sampled designs pay for it.
        from scipy.stats import qmc

        with warnings.catch_warnings():
            # scipy warns of numbers of points other than powers of two; they are the user's choice.
            warnings.simplefilter("ignore", UserWarning)
            unit = getattr(qmc, self.engine)(d=len(axes), seed=self.seed).random(self.points)
        return [
            [
                axis.at(fraction)
                if isinstance(axis, Range)
                else axis[min(int(fraction * len(axis)), len(axis) - 1)]
                for fraction in column.tolist()
            ]
            for axis, column in zip(axes, unit.T, strict=True)
        ]


@dataclass(frozen=True)
class LatinHypercube(Sampled):
    """One point in each slice of each range."""

    kind: Literal["latin_hypercube"] = "latin_hypercube"
    engine = "LatinHypercube"


@dataclass(frozen=True)
class Sobol(Sampled):
    """A sequence that fills the ranges evenly, best with powers of two."""

    kind: Literal["sobol"] = "sobol"
    engine = "Sobol"


@dataclass(frozen=True)
class Axis:
    """One varied parameter."""

    name: str  # dotted, as in the file
    values: tuple[Any, ...]  # in SI units, in the order of the file; sampled: one per point
    written: tuple[Any, ...]  # as in a study file
    place: str  # their place in the file: ``vary.load``
    drawn_from: Range | None = None  # None where the values were listed

    @cached_property
    def member(self) -> str:
        """Member of the case to which this belongs."""
        return member_of(self.name)

    @property
    def key(self) -> str:
        """Key of `base` to which this belongs."""
        return self.name.split(".", 1)[0]

    @property
    def coordinate(self) -> str:
        """Name as a dataset coordinate."""
        names = [leaf.name for leaf in leaves().get(self.name, ())]
        return (names[0] if names else self.name).replace(".", "_")

    @cached_property
    def labels(self) -> tuple[str, ...]:
        """The values as written in the file."""
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
        """Case id, empty if the point is invalid. Points may share a case."""
        return self.case.case_id if self.case is not None else ""

    @cached_property
    def estimate(self) -> Estimate | None:
        """Expected cost of the case; None if the point is invalid."""
        return estimate(self.case) if self.case is not None else None

    @property
    def values(self) -> dict[str, Any]:
        """Varied parameters by dotted name, in SI units."""
        return {a.name: a.values[i] for a, i in zip(self.axes, self.index, strict=True)}

    @property
    def labels(self) -> dict[str, str]:
        """Varied parameters by dotted name, as written in the file."""
        return {a.name: a.labels[i] for a, i in zip(self.axes, self.index, strict=True)}


@dataclass(frozen=True)
class BrokenRule:
    """A rule that some points break, with the positions along the axes."""

    problem: Problem
    where: tuple[tuple[Axis, int], ...]
    points: Sequence[tuple[int, ...]]


class Parameters:
    """Valid values of a study: fixed ones, axes, and the points as positions along the axes."""

    def __init__(
        self, fixed: Mapping[str, Any], axes: tuple[Axis, ...], indices: Sequence[tuple[int, ...]]
    ) -> None:
        self.axes, self.indices = axes, indices
        # Positions of the axes that vary a member or a part of it, by member.
        self._axes_of: dict[str, list[int]] = {}
        for position, axis in enumerate(axes):
            self._axes_of.setdefault(axis.member, []).append(position)
        self._fixed = by_member(fixed)
        self._made: dict[tuple[str, tuple[int, ...]], Any] = {}
        self._constant: dict[str, Any] = {}
        self._varied: list[str] = []
        for member in {**self._fixed, **self._axes_of}:
            with suppress(KeyError):  # Others that its values need may be wrong.
                made = self._member(member, (0,) * len(axes))
                if member in self._axes_of:
                    self._varied.append(member)
                else:
                    self._constant[member] = made

    def points(
        self, broken: Mapping[tuple[int, ...], str], which: slice = slice(None)
    ) -> Iterator[Point]:
        """Iterate over some points; `broken` says why some of them are invalid."""
        for index in self.indices[which]:
            problem = broken.get(index, "")
            yield Point(self.axes, index, None if problem else self.case(index), problem)

    def case(self, index: tuple[int, ...]) -> Case:
        """Return the case of a point from values already read and checked."""
        return Case.of({**self._constant, **{n: self._member(n, index) for n in self._varied}})

    def _member(self, member: str, index: tuple[int, ...]) -> Any:
        # Points share parts, so each combination of a part's values is made once.
        axes = self._axes_of.get(member, ())
        key = member, tuple([index[i] for i in axes])
        if key not in self._made:
            fixed = self._fixed.get(member, {})
            drawn = {self.axes[i].name: self.axes[i].values[index[i]] for i in axes}
            base = fixed.get(member)
            if drawn and isinstance(base, Part):
                fields = {name.rpartition(".")[2]: value for name, value in drawn.items()}
                drawn = {member: type(base).unchecked(**{**vars(base), **fields})}
            self._made[key] = make_member(member, {**fixed, **drawn})
        return self._made[key]

    def find(self) -> Iterator[BrokenRule]:
        """Iterate over the broken rules, each tried once for each combination of valid values."""
        valid = {*self._constant, *self._varied}
        defaulted = {*members(), "output_cycles"} - required(CaseTree) - {*self._axes_of}
        known = {*valid, *defaulted, *(("cycles",) if "blocks" in valid else ())}
        trials: list[tuple[Rule, list[int], dict[Any, tuple[Problem | None, list[Any]]]]] = []
        for rule in RULES:
            if {member_of(name) for name in rule.needs} <= known:
                # Blocks have cycles of their own.
                needs = rule.needs | ({"blocks"} if "cycles" in rule.needs else set())
                axes = enumerate(self.axes)
                relevant = [i for i, axis in axes if {axis.member, axis.name} & needs]
                trials.append((rule, relevant, {}))
        # Point by point, so that each case is made once for all rules.
        for index in self.indices:
            case: Case | None = None
            for rule, relevant, tried in trials:
                positions = tuple([index[i] for i in relevant])
                if positions not in tried:
                    case = case or self.case(index)
                    tried[positions] = rule.find(case), []
                problem, points = tried[positions]
                if problem is not None:
                    points.append(index)
        for _, relevant, tried in trials:
            for positions, (problem, points) in tried.items():
                if problem is not None:
                    where = zip((self.axes[i] for i in relevant), positions, strict=True)
                    yield BrokenRule(problem, tuple(where), points)
