"""What is varied: the axes of a study, and the designs that combine their values."""

from __future__ import annotations

import itertools
import math
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from fretwear.mechanics.materials import Course
from fretwear.parts import Part, Quantity
from fretwear.study.case import read_value
from fretwear.study.points import Axis, Range
from fretwear.study.problems import Problem, Problems, UnreadError
from fretwear.study.tree import example_of, parameter_names, parameter_of
from fretwear.units import QuantityError, exact_text

LISTED = ("grid", "zip")
SAMPLED = ("latin_hypercube", "sobol")
KINDS = (*LISTED, *SAMPLED)
MAX_POINTS = 200_000


@dataclass(frozen=True)
class Design:
    """How the varied values are combined."""

    # ``grid``: every combination.  ``zip``: first with first, second with second.
    # ``latin_hypercube``, ``sobol``: points spread over ranges.
    kind: str = "grid"
    points: int = 0  # number of points of a sampled design; 0 for the others
    seed: int = 0  # seed of a sampled design: the same seed gives the same points

    @property
    def is_sampled(self) -> bool:
        """Whether values are drawn from ranges rather than listed."""
        return self.kind in SAMPLED

    def size(self, lengths: Sequence[int]) -> int:
        """Return the number of points for axes of these lengths."""
        if self.is_sampled:
            # Where their number cannot be read, what is fixed is checked at one.
            return self.points or 1
        if self.kind == "zip":
            return lengths[0] if lengths else 1
        return math.prod(lengths)

    def indices(self, lengths: Sequence[int]) -> Iterator[tuple[int, ...]]:
        """Iterate over the points as positions along the axes, the last axis fastest."""
        if self.kind == "grid":
            return itertools.product(*(range(length) for length in lengths))
        return ((number,) * len(lengths) for number in range(self.size(lengths)))


def sample(design: Design, axes: Sequence[Range | Sequence[Any]]) -> list[list[Any]]:
    """Draw the values of a sampled design: for each axis one per point.

    From a list each value is drawn equally often, as far as the number of points allows.
    """
    # scipy.stats takes half a second to import: only sampled designs pay for it.
    from scipy.stats import qmc

    engine = qmc.LatinHypercube if design.kind == "latin_hypercube" else qmc.Sobol
    with warnings.catch_warnings():
        # Numbers of points other than powers of two are the user's choice.
        warnings.simplefilter("ignore", UserWarning)
        unit = engine(d=len(axes), seed=design.seed).random(design.points)
    return [
        [
            axis.at(fraction)
            if isinstance(axis, Range)
            else axis[min(int(fraction * len(axis)), len(axis) - 1)]
            for fraction in column.tolist()
        ]
        for axis, column in zip(axes, unit.T, strict=True)
    ]


def read_axes(vary: Mapping[str, Any], design: Design, problems: Problems) -> tuple[Axis, ...]:
    """Read the section `vary`; return the sound axes and add what is wrong to `problems`."""
    read: dict[str, Axis | Range] = {}
    for name, raw in vary.items():
        with problems.at(f"vary.{name}", raw):
            read[name] = _read_axis(name, raw, f"vary.{name}", design, problems)
    for whole in vary:
        for part in [name for name in vary if name.startswith(f"{whole}.")][:1]:
            rule = f"varies the whole of which {part} is a part"
            problems.add(f"vary.{whole}", None, rule, "vary one or the other")
    if design.is_sampled and not vary:
        rule = "is missing: a sampled design needs something to vary"
        problems.add("vary", None, rule, "such as load: {from: 10 N, to: 100 N}")
    if design.is_sampled:
        return _sampled_axes(read, design) if design.points and read else ()
    axes = tuple(axis for axis in read.values() if isinstance(axis, Axis))
    lengths = {axis.name: len(axis.values) for axis in axes}
    with problems.at("vary", None):
        if design.kind == "zip" and len(set(lengths.values())) > 1:
            listed = ", ".join(f"{name} has {length}" for name, length in lengths.items())
            rule = f"must have lists of equal length under design: zip, but {listed}"
            raise QuantityError(rule, "design: grid takes every combination")
        if design.kind == "zip":
            _refuse_equal_rows(axes, problems)
        if (size := design.size(list(lengths.values()))) > MAX_POINTS:
            rule = f"makes {size} points, more than the limit of {MAX_POINTS}"
            raise QuantityError(rule, "split the study")
        return axes
    return ()


def _read_axis(
    name: str, raw: object, key: str, design: Design, problems: Problems
) -> Axis | Range:
    if name not in parameter_names():
        rule, known = "is not a case parameter", parameter_names()
        problems.append(Problem(key, raw, rule, written=name, known=known))
        raise UnreadError
    if isinstance(raw, Mapping):
        if parts := [each for each in parameter_names() if each.startswith(f"{name}.")]:
            hint = f"to vary a part of it write {parts[0]}: [{example_of(parts[0])}, ...]"
            raise QuantityError(f"must be a list of values of {name}", hint)
        return _read_range(name, raw, key, design, problems)
    if not isinstance(raw, list):
        hint = f"write [{raw}]" if isinstance(raw, str | float) else ""
        if design.is_sampled:
            hint = "or a range such as {from: 10 N, to: 100 N, scale: log}"
        raise QuantityError("must be a list of values", hint)
    if not raw:
        raise QuantityError("is an empty list", "list at least one value, or leave it out")
    values: list[Any] = []
    seen: dict[object, int] = {}
    for position, item in enumerate(raw):
        with problems.at(place := f"{key}[{position}]", item):
            values.append(value := read_value(name, item, place, problems))
            first = seen.setdefault(_identity(value), position)
            # Paired lists may repeat a value: only a whole row makes the same point.
            if first != position and design.kind != "zip":
                rule = f"is the same value as {key}[{first}], {raw[first]}"
                raise QuantityError(rule, "leave one of them out")
    if len(values) < len(raw):
        raise UnreadError
    return Axis(name, tuple(values), tuple(raw))


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


def _read_range(
    name: str, raw: Mapping[str, Any], key: str, design: Design, problems: Problems
) -> Range:
    if not design.is_sampled:
        hint = "write a list, or design: {kind: latin_hypercube, points: 64, seed: 1}"
        raise QuantityError(f"is a range, which design: {design.kind} cannot take", hint)
    quantity, before = parameter_of(name), len(problems)
    no_number = QuantityError(
        "has values that are no single quantity and cannot be drawn from a range",
        "write a list: its values are drawn",
    )
    if not (isinstance(quantity, Quantity) and quantity.may_be_drawn):
        raise no_number
    problems.unknown(key, raw, ("from", "to", "scale"))
    scale, scales = raw.get("scale", "linear"), ("linear", "log")
    if scale not in scales:
        problems.add(f"{key}.scale", scale, "must be linear or log", known=scales)
    ends = []
    for part in ("from", "to"):
        with problems.at(place := f"{key}.{part}", raw.get(part)):
            if part not in raw:
                raise QuantityError("is missing", f"such as {part}: {quantity.example}")
            ends.append(read_value(name, raw[part], place, problems))
    if len(problems) > before:
        raise UnreadError
    if not all(isinstance(end, float) for end in ends):
        raise no_number
    low, high = ends
    with problems.at(f"{key}.to", raw["to"]):
        if not low < high < math.inf:
            raise QuantityError(f"must be more than {key}.from = {raw['from']}, and finite")
        with problems.at(f"{key}.from", raw["from"]):
            if scale == "log" and low <= 0.0:
                raise QuantityError("must be larger than 0 on a logarithmic scale")
            return Range(low, high, logarithmic=scale == "log")
    raise UnreadError


def _sampled_axes(read: Mapping[str, Axis | Range], design: Design) -> tuple[Axis, ...]:
    pools = [
        axis if isinstance(axis, Range) else list(zip(axis.values, axis.written, strict=True))
        for axis in read.values()
    ]
    axes = []
    for (name, source), drawn in zip(read.items(), sample(design, pools), strict=True):
        if isinstance(source, Range):
            quantity = parameter_of(name)
            assert isinstance(quantity, Quantity)
            written = tuple(exact_text(value, quantity.dimension) for value in drawn)
            axes.append(Axis(name, tuple(drawn), written, source))
        else:
            values, texts = zip(*drawn, strict=True)
            axes.append(Axis(name, values, texts))
    return tuple(axes)
