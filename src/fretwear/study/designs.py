"""The varied parameters of a study, and how their values are combined into points."""

from __future__ import annotations

import dataclasses
import itertools
import math
import warnings
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from typing import Annotated, Any, ClassVar, Literal

from pydantic.dataclasses import dataclass

from fretwear.quantity import (
    Part,
    each,
    is_list,
    json_text,
    located,
    whole_number,
)
from fretwear.study.contact import case_keys
from fretwear.study.keys import coordinate
from fretwear.study.problems import Problems, in_words
from fretwear.units import BY_SI_UNIT, QuantityError, format_quantity

MAX_POINTS = 200_000


@dataclasses.dataclass(frozen=True)
class DrawnRange:
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

    points: Annotated[int, whole_number("$n$", "number of points", 1, MAX_POINTS, 64)]
    seed: Annotated[int, whole_number("seed", "seed", 0, 2**32 - 1, 1)] = 0

    engine: ClassVar[str]  # its class in `scipy.stats.qmc`

    def columns(self, axes: int) -> list[list[float]]:
        """Return numbers from 0 to 1, one list for each of some axes."""
        from scipy.stats import qmc  # takes a second to import

        with warnings.catch_warnings():
            # scipy warns of numbers of points other than powers of two, which users may choose.
            warnings.simplefilter("ignore", UserWarning)
            drawn = getattr(qmc, self.engine)(d=axes, seed=self.seed).random(self.points)
        return [*drawn.T.tolist()]


@dataclass(frozen=True)
class LatinHypercube(Sampled):
    """One point in each slice of each range."""

    kind: Literal["latin_hypercube"] = "latin_hypercube"
    engine = "LatinHypercube"


@dataclass(frozen=True)
class Sobol(Sampled):
    """A sequence that fills the ranges evenly, best if the number of points is a power of two."""

    kind: Literal["sobol"] = "sobol"
    engine = "Sobol"


@dataclasses.dataclass(frozen=True)
class Axis:
    """One varied parameter."""

    name: str  # dotted, as in the file
    values: tuple[Any, ...]  # in SI units, in the order of the file; sampled: one per point
    written: tuple[Any, ...]  # as in a study file
    drawn_from: DrawnRange | None = None  # None if the values were listed

    @property
    def key(self) -> str:
        """Key of `base` to which the parameter belongs."""
        return self.name.split(".", 1)[0]

    @property
    def coordinate(self) -> str:
        """Name as a dataset coordinate."""
        key, own = case_keys()[self.name], self.name.partition(".")[2]
        is_open = own and key.kind is not None and key.field in case_keys().names
        return key.field if is_open else coordinate(self.name)

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
            key = case_keys()[self.name]
            dimension = BY_SI_UNIT[key.about.in_frame_of(self.drawn_from.low).si_unit]
            numbers = map(self.drawn_from.at, fractions)
            written = tuple(format_quantity(number, dimension, digits=9) for number in numbers)
            values = tuple(key.read(text, True) for text in written)
        return dataclasses.replace(self, values=values, written=written)


def read_axes(
    vary: Mapping[str, object], design: Design, folder: object, problems: Problems
) -> tuple[Axis, ...]:
    """Read the varied parameters; return the valid axes and collect the problems of the others."""
    axes = list[Axis]()
    for name, raw in vary.items():
        if name not in case_keys().all_names:
            case_keys().unknown(f"vary.{name}", raw, problems)
            continue
        with problems.at(f"vary.{name}", raw):
            axes.append(_read_axis(name, raw, design, folder))
        if whole := [other for other in vary if name.startswith(f"{other}.")]:
            rule = f"varies as a whole, but {name} varies a part of it"
            problems.add(f"vary.{whole[0]}", None, rule, "vary one or the other")
    if len(axes) < len(vary):
        return ()
    lengths = [len(axis.values) for axis in axes]
    size = max(lengths, default=1)
    if isinstance(design, Sampled):
        size = design.points
        if not axes:
            rule = "is missing: a sampled design needs something to vary"
            problems.add("vary", None, rule, "such as load: {from: 10 N, to: 100 N}")
        elif all(axis.drawn_from is None for axis in axes) and math.prod(lengths) < size:
            rule = f"has only {math.prod(lengths)} combinations of values for {size} points"
            problems.add("vary", None, rule, "write ranges, or design: grid")
        columns = design.columns(len(axes)) if axes else []
        axes = [axis.at(column) for axis, column in zip(axes, columns, strict=True)]
    elif isinstance(design, Zip):
        if len(set(lengths)) > 1:
            given = ", ".join(f"{axis.name} has {len(axis.values)}" for axis in axes)
            problems.add("vary", None, f"needs lists of equal lengths under design: zip: {given}")
            return ()
    elif isinstance(design, Combinations):
        size = math.prod(lengths)
    if size > MAX_POINTS:
        rule = f"makes {size} points, more than the limit of {MAX_POINTS}"
        problems.add("vary", None, rule, "split the study")
        return ()
    return tuple(axes)


def _read_axis(name: str, raw: object, design: Design, folder: object) -> Axis:
    """Read a list, or the range from which values will be drawn."""
    key = case_keys()[name]
    if isinstance(raw, Mapping) and {"from", "to"} & raw.keys():
        return Axis(name, (), (), _read_range(name, raw, design, folder))
    if not is_list(raw) or not raw:
        hint = f"such as {name}: [{key.about.example}]"
        if isinstance(design, Sampled):
            hint = "or a range such as {from: 10 N, to: 100 N, scale: log}"
        raise QuantityError("must be a list of values", hint)
    values = each(raw, lambda one: key.read(one, folder))
    seen: dict[object, int] = {}
    for position, value in enumerate(values):
        first = seen.setdefault(_identity(value), position)
        # Paired lists may repeat a value: only equal rows make the same point.
        if first != position and not isinstance(design, Zip):
            rule = f"is the same value as vary.{name}[{first}], {raw[first]}"
            raise located(position, raw[position], QuantityError(rule, "leave one of them out"))
    return Axis(name, tuple(values), tuple(raw))


def _identity(value: object) -> object:
    """Return a key that equal values of an axis share, whatever their units."""
    if isinstance(value, Part):
        return json_text(value.canonical())
    if isinstance(value, tuple):
        return tuple(map(_identity, value))
    if isinstance(value, float):
        return f"{value:.11e}"
    return str(value) if dataclasses.is_dataclass(value) else value


def _read_range(name: str, raw: Mapping[str, object], design: Design, folder: object) -> DrawnRange:
    key = case_keys()[name]
    if not isinstance(design, Sampled):
        hint = "write a list, or design: {kind: latin_hypercube, points: 64, seed: 1}"
        raise QuantityError(f"is a range, which design: {design.kind} cannot take", hint)
    if not key.about.may_be_drawn:
        raise QuantityError("cannot be drawn from a range", "write a list: its values are drawn")
    for unknown in raw.keys() - {"from", "to", "scale"}:
        raise located(unknown, raw[unknown], QuantityError("is not from, to or scale"))
    low, high = each([raw.get("from"), raw.get("to")], lambda one: key.read(one, folder))
    scale = raw.get("scale", "linear")
    if scale not in ("linear", "log"):
        raise located("scale", scale, QuantityError("must be linear or log"))
    if not isinstance(low, float) or not isinstance(high, float) or not low < high < math.inf:
        rule = f"must be more than vary.{name}.from = {raw.get('from')}, and finite"
        raise located("to", raw.get("to"), QuantityError(rule))
    if scale == "log" and low <= 0.0:
        rule = "must be larger than 0 on a logarithmic scale"
        raise located("from", raw["from"], QuantityError(rule))
    return DrawnRange(low, high, logarithmic=scale == "log")
