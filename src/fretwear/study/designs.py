"""The varied parameters of a study, and how their values are combined into points."""

from __future__ import annotations

import dataclasses
import itertools
import math
import warnings
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic.dataclasses import dataclass

from fretwear.quantity import Part, adapter, whole_number
from fretwear.study.case import case_keys
from fretwear.study.keys import Range, coordinate
from fretwear.study.mistakes import Mistakes, in_words
from fretwear.units import BY_SI_UNIT, format_quantity

MAX_POINTS = 200_000


class Design(Part):
    """The combination of the varied values; value by value unless a kind says otherwise."""

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
class Sobol(Design):
    """A Sobol sequence, which fills ranges evenly; the same seed gives the same points."""

    points: Annotated[int, whole_number("$n$", "number of points", 1, MAX_POINTS, 64)]
    seed: Annotated[int, whole_number("seed", "seed", 0, 2**32 - 1, 1)] = 0
    kind: Literal["sobol"] = "sobol"

    def columns(self, axes: int) -> list[list[float]]:
        """Return numbers from 0 to 1, one list for each of some axes."""
        from scipy.stats import qmc  # takes a second to import

        with warnings.catch_warnings():
            # scipy warns of numbers of points that are not powers of two, which users may choose.
            warnings.simplefilter("ignore", UserWarning)
            drawn = qmc.Sobol(d=axes, seed=self.seed).random(self.points)
        return [*drawn.T.tolist()]


@dataclasses.dataclass(frozen=True)
class Axis:
    """One varied parameter."""

    name: str  # dotted, as in the file
    values: tuple[object, ...]  # SI units; of a grid: numbers rising, words as in the file
    written: tuple[object, ...]  # as in a study file
    drawn_from: Range[float] | None = None  # None if the values were listed

    @property
    def coordinate(self) -> str:
        """Name as a dataset coordinate."""
        key = case_keys()[self.name]
        is_open = "." in self.name and key.field in case_keys().open_keys[key.member]
        return key.field if is_open else coordinate(self.name)

    @cached_property
    def labels(self) -> tuple[str, ...]:
        """The values as written in the file."""
        return tuple(in_words(value) for value in self.written)

    @cached_property
    def plain(self) -> tuple[float, ...] | tuple[str, ...]:
        """The values as numbers if all of them are numbers, otherwise as written in the file."""
        numbers = [float(value) for value in self.values if isinstance(value, int | float)]
        return tuple(numbers) if len(numbers) == len(self.values) else self.labels

    def at(self, fractions: Iterable[float]) -> Axis:
        """Return the axis with the values at fractions of its range, or of its list."""
        if self.drawn_from is None:
            count = len(self.values)
            chosen = [min(int(fraction * count), count - 1) for fraction in fractions]
            values, written = (tuple(row[i] for i in chosen) for row in (self.values, self.written))
        else:
            key = case_keys()[self.name]
            dimension = BY_SI_UNIT[key.parameter.in_frame_of(self.drawn_from.low).si_unit]
            numbers = map(self.drawn_from.at, fractions)
            written = tuple(format_quantity(number, dimension, digits=9) for number in numbers)
            values = tuple(
                adapter(key.hint).validate_python(one, context=Path()) for one in written
            )
        return dataclasses.replace(self, values=values, written=written)


def axes_of(
    vary: Mapping[str, object], written: Mapping[str, object], design: Design, mistakes: Mistakes
) -> tuple[Axis, ...]:
    """Return the varied parameters from their values and the written text, and check the design.

    The result is empty if the design cannot combine them.
    """
    found = len(mistakes)
    names = [name for name in written if name in vary]
    axes = [_axis(name, vary[name], written[name], design, mistakes) for name in names]
    for name in names:
        if whole := [outer for outer in names if name.startswith(f"{outer}.")]:
            rule = f"varies as a whole, but {name} varies a part of it"
            mistakes.add(f"vary.{whole[0]}", None, rule, "vary one or the other")
    lengths = [len(axis.values) for axis in axes]
    size = max(lengths, default=1)
    if isinstance(design, Sobol):
        size = design.points
        if not written:
            rule = "is missing: a sampled design needs something to vary"
            mistakes.add("vary", None, rule, "such as load: {from: 10 N, to: 100 N}")
        columns = design.columns(len(axes)) if axes else []
        axes = [axis.at(column) for axis, column in zip(axes, columns, strict=True)]
    elif isinstance(design, Zip) and len(set(lengths)) > 1:
        sizes = ", ".join(f"{axis.name} has {len(axis.values)}" for axis in axes)
        mistakes.add("vary", None, f"needs lists of equal lengths under design: zip: {sizes}")
    elif isinstance(design, Combinations):
        size = math.prod(lengths)
    if size > MAX_POINTS:
        rule = f"makes {size} points, more than the limit of {MAX_POINTS}"
        mistakes.add("vary", None, rule, "split the study")
    return () if len(mistakes) > found else tuple(axes)


def _axis(name: str, value: Any, written: Any, design: Design, mistakes: Mistakes) -> Axis:
    """The axis of a list, or of a range to draw from."""
    place = f"vary.{name}"
    if isinstance(value, Range):
        if not isinstance(design, Sobol):
            hint = "write a list, or design: {kind: sobol, points: 64, seed: 1}"
            rule = f"is a range, which design: {design.kind} cannot take"
            mistakes.add(place, written, rule, hint)
        return Axis(name, (), (), value)
    # Paired lists may repeat a value: only equal rows make the same point.
    for position, one in enumerate([] if isinstance(design, Zip) else value):
        if one in value[:position]:
            rule = "is the same value as one before it"
            mistakes.add(f"{place}[{position}]", written[position], rule, "leave one of them out")
    order = [*range(len(value))]
    # Programs that read a dataset expect rising levels. Paired lists have an order of their own.
    if isinstance(design, Combinations) and all(isinstance(one, int | float) for one in value):
        order.sort(key=lambda position: value[position])
    return Axis(name, tuple(value[i] for i in order), tuple(written[i] for i in order))
