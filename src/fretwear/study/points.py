"""Points of a study: the varied values, and how they are combined."""

from __future__ import annotations

import itertools
import math
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Annotated, Any, ClassVar, Literal

from fretwear.mechanics.materials import Course
from fretwear.parts import Part, Quantity, WholeNumber
from fretwear.study.case import Case
from fretwear.study.cost import Estimate, estimate
from fretwear.study.parameters import leaves, member_of, parameter_names, parameter_of, read_value
from fretwear.study.problems import Problems, in_words
from fretwear.units import QuantityError, exact_text

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
            low, high = math.log(self.low), math.log(self.high)
            value = math.exp(low + fraction * (high - low))
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


def read_axes(
    vary: Mapping[str, Any], places: Mapping[str, str], design: Design | None, problems: Problems
) -> tuple[Axis, ...]:
    """Read the varied parameters; return the valid axes and add the rest to `problems`.

    Nothing is returned if the design could not be read. `places` says where the values are that
    are not under `vary`.
    """
    axes: list[Axis] = []
    known = parameter_names()
    for name, raw in vary.items():
        place = places.get(name, f"vary.{name}")
        if name not in known:
            problems.add(place, raw, "is not a case parameter", known=known, written=name)
            continue
        with problems.at(place, raw):
            axes.append(_read_axis(name, raw, design, place))
    for whole in vary:
        for part in [name for name in vary if name.startswith(f"{whole}.")][:1]:
            rule = f"varies the whole of which {part} is a part"
            problems.add(f"vary.{whole}", None, rule, "vary one or the other")
    if isinstance(design, Sampled):
        if not vary:
            rule = "is missing: a sampled design needs something to vary"
            problems.add("vary", None, rule, "such as load: {from: 10 N, to: 100 N}")
        pools = [axis.drawn_from or range(len(axis.values)) for axis in axes]
        drawn = design.sample(pools) if axes else []
        return tuple(itertools.starmap(_drawn, zip(axes, drawn, strict=True)))
    lengths = {axis.name: len(axis.values) for axis in axes}
    if isinstance(design, Zip):
        if len(set(lengths.values())) > 1:
            listed = ", ".join(f"{name} has {length}" for name, length in lengths.items())
            rule = f"must have lists of equal length under design: zip, but {listed}"
            problems.add("vary", None, rule, "design: grid takes every combination")
            return ()
        seen: dict[object, int] = {}
        for row, values in enumerate(zip(*(axis.values for axis in axes), strict=True)):
            if (first := seen.setdefault(_identity(values), row)) != row:
                given = ", ".join(f"{axis.name} {axis.labels[row]}" for axis in axes)
                rule = f"make point {row + 1} the same as point {first + 1} under design: zip"
                problems.add("vary", given, rule, "leave one of them out of every list")
    if design is None:
        return ()
    if (size := design.size([*lengths.values()])) > MAX_POINTS:
        rule = f"makes {size} points, more than the limit of {MAX_POINTS}"
        problems.add("vary", None, rule, "split the study")
        return ()
    return tuple(axes)


def _drawn(axis: Axis, drawn: Sequence[Any]) -> Axis:
    """Return an axis with the values drawn from its range, or at positions in its list."""
    if axis.drawn_from is None:
        values, written = (tuple(each[i] for i in drawn) for each in (axis.values, axis.written))
        return replace(axis, values=values, written=written)
    quantity = parameter_of(axis.name)
    assert isinstance(quantity, Quantity)
    written = tuple(exact_text(value, quantity.dimension) for value in drawn)
    return replace(axis, values=tuple(drawn), written=written)


def _read_axis(name: str, raw: object, design: Design | None, place: str) -> Axis:
    """Read a list, or the range from which values will be drawn."""
    if isinstance(raw, Mapping):
        if parts := [each for each in parameter_names() if each.startswith(f"{name}.")]:
            hint = f"to vary a part of it write {parts[0]}: [{parameter_of(parts[0]).example}, ...]"
            raise QuantityError(f"must be a list of values of {name}", hint)
        return Axis(name, (), (), place, _read_range(name, raw, design))
    if not isinstance(raw, list):
        hint = f"write [{raw}]" if isinstance(raw, str | float) else ""
        if isinstance(design, Sampled):
            hint = "or a range such as {from: 10 N, to: 100 N, scale: log}"
        raise QuantityError("must be a list of values", hint)
    if not raw:
        raise QuantityError("is an empty list", "list at least one value, or leave it out")
    values: list[Any] = []
    seen: dict[object, int] = {}
    problems = Problems()
    for position, item in enumerate(raw):
        with problems.at(f"[{position}]", item):
            values.append(value := read_value(name, item))
            first = seen.setdefault(_identity(value), position)
            # Paired lists may repeat a value: only a whole row makes the same point.
            if first != position and not isinstance(design, Zip):
                rule = f"is the same value as {place}[{first}], {raw[first]}"
                raise QuantityError(rule, "leave one of them out")
    problems.raise_any()
    return Axis(name, tuple(values), tuple(raw), place)


def _identity(value: Any) -> object:
    """Return a key that equal values of an axis share, whatever their units."""
    if isinstance(value, float):
        return f"{value:.11e}"
    if isinstance(value, Part | Course):
        value = tuple(vars(value).values())
    return tuple(map(_identity, value)) if isinstance(value, tuple) else value


def _read_range(name: str, raw: Mapping[str, Any], design: Design | None) -> Range:
    if design is not None and not design.is_sampled:
        hint = "write a list, or design: {kind: latin_hypercube, points: 64, seed: 1}"
        raise QuantityError(f"is a range, which design: {design.kind} cannot take", hint)
    quantity, problems = parameter_of(name), Problems()
    no_number = QuantityError(
        "has values that are no single quantity and cannot be drawn from a range",
        "write a list: its values are drawn",
    )
    if not quantity.may_be_drawn:
        raise no_number
    problems.unknown("", raw, ("from", "to", "scale"))
    scale, scales = raw.get("scale", "linear"), ("linear", "log")
    if scale not in scales:
        problems.add(".scale", scale, "must be linear or log", known=scales)
    ends = []
    for part in ("from", "to"):
        with problems.at(f".{part}", raw.get(part)):
            if part not in raw:
                raise QuantityError("is missing", quantity.such_as(part))
            ends.append(read_value(name, raw[part]))
    problems.raise_any()
    if not all(isinstance(end, float) for end in ends):
        raise no_number
    low, high = ends
    if not low < high < math.inf:
        rule = f"must be more than vary.{name}.from = {raw['from']}, and finite"
        problems.add(".to", raw["to"], rule)
    elif scale == "log" and low <= 0.0:
        problems.add(".from", raw["from"], "must be larger than 0 on a logarithmic scale")
    problems.raise_any()
    return Range(low, high, logarithmic=scale == "log")
