"""What is varied: the axes of a study, and the designs that combine their values."""

from __future__ import annotations

import itertools
import math
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from fretwear.mechanics.materials import Course
from fretwear.parts import Part, Quantity, WholeNumber
from fretwear.study.case import read_value
from fretwear.study.parameters import parameter_names, parameter_of
from fretwear.study.points import Axis, Range
from fretwear.study.problems import Problem, Problems
from fretwear.units import QuantityError, exact_text

if TYPE_CHECKING:
    from fretwear.study.sections import Sections

MAX_POINTS = 200_000


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
        """As many as there are combinations."""
        return math.prod(lengths)

    def indices(self, lengths: Sequence[int]) -> Iterator[tuple[int, ...]]:
        """Each position along each axis."""
        return itertools.product(*(range(length) for length in lengths))


@dataclass(frozen=True)
class Zip(Design):
    """First value with first, second with second."""

    kind: Literal["zip"] = "zip"

    def size(self, lengths: Sequence[int]) -> int:
        """As many as each axis has values."""
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
        """As many as are wanted."""
        return self.points

    def sample(self, axes: Sequence[Range | Sequence[Any]]) -> list[list[Any]]:
        """Draw the values: for each axis one per point.

        From a list each value is drawn equally often, as far as the number of points allows.
        """
        # scipy.stats takes half a second to import: only sampled designs pay for it.
        from scipy.stats import qmc

        with warnings.catch_warnings():
            # Numbers of points other than powers of two are the user's choice.
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


def read_axes(sections: Sections, problems: Problems) -> tuple[Axis, ...]:
    """Read what is varied; return the sound axes and add what is wrong to `problems`.

    There are none where the design could not be read.
    """
    read: dict[str, Axis | Range] = {}
    vary, design, known = sections.vary, sections.design, parameter_names()
    for name, raw in vary.items():
        if name not in known:
            rule = "is not a case parameter"
            problems.append(Problem(f"vary.{name}", raw, rule, written=name, known=known))
            continue
        with problems.at(place := sections.place(name), raw):
            read[name] = _read_axis(name, raw, design, place)
    for whole in vary:
        for part in [name for name in vary if name.startswith(f"{whole}.")][:1]:
            rule = f"varies the whole of which {part} is a part"
            problems.add(f"vary.{whole}", None, rule, "vary one or the other")
    if isinstance(design, Sampled):
        if not vary:
            rule = "is missing: a sampled design needs something to vary"
            problems.add("vary", None, rule, "such as load: {from: 10 N, to: 100 N}")
        return _sampled_axes(read, design) if read else ()
    if design is None:
        return ()
    axes = tuple(axis for axis in read.values() if isinstance(axis, Axis))
    lengths = {axis.name: len(axis.values) for axis in axes}
    with problems.at("vary", None):
        if isinstance(design, Zip):
            if len(set(lengths.values())) > 1:
                listed = ", ".join(f"{name} has {length}" for name, length in lengths.items())
                rule = f"must have lists of equal length under design: zip, but {listed}"
                raise QuantityError(rule, "design: grid takes every combination")
            _refuse_equal_rows(axes, problems)
        if (size := design.size(list(lengths.values()))) > MAX_POINTS:
            rule = f"makes {size} points, more than the limit of {MAX_POINTS}"
            raise QuantityError(rule, "split the study")
        return axes
    return ()


def _read_axis(name: str, raw: object, design: Design | None, place: str) -> Axis | Range:
    if isinstance(raw, Mapping):
        if parts := [each for each in parameter_names() if each.startswith(f"{name}.")]:
            hint = f"to vary a part of it write {parts[0]}: [{parameter_of(parts[0]).example}, ...]"
            raise QuantityError(f"must be a list of values of {name}", hint)
        return _read_range(name, raw, design)
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


def _refuse_equal_rows(axes: tuple[Axis, ...], problems: Problems) -> None:
    seen: dict[object, int] = {}
    for row, values in enumerate(zip(*(axis.values for axis in axes), strict=True)):
        first = seen.setdefault(_identity(values), row)
        if first != row:
            given = ", ".join(f"{axis.name} {axis.labels[row]}" for axis in axes)
            rule = f"make point {row + 1} the same as point {first + 1} under design: zip"
            problems.add("vary", given, rule, "leave one of them out of every list")


def _identity(value: Any) -> object:
    """Return what makes two values of an axis the same, whatever their units were."""
    if isinstance(value, float):
        return f"{value:.11e}"
    if isinstance(value, tuple):
        return tuple(_identity(item) for item in value)
    if isinstance(value, Part | Course):
        return tuple(_identity(item) for item in vars(value).values())
    return value


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


def _sampled_axes(read: Mapping[str, Axis | Range], design: Sampled) -> tuple[Axis, ...]:
    pools = [
        axis if isinstance(axis, Range) else list(zip(axis.values, axis.written, strict=True))
        for axis in read.values()
    ]
    axes = []
    for (name, source), drawn in zip(read.items(), design.sample(pools), strict=True):
        if isinstance(source, Range):
            quantity = parameter_of(name)
            assert isinstance(quantity, Quantity)
            written = tuple(exact_text(value, quantity.dimension) for value in drawn)
            axes.append(Axis(name, tuple(drawn), written, f"vary.{name}", source))
        else:
            values, texts = zip(*drawn, strict=True)
            axes.append(replace(source, values=values, written=texts))
    return tuple(axes)
