"""The section ``fit`` of a study: what is sought, and what was measured."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    model_validator,
)
from pydantic.dataclasses import dataclass
from pydantic_core import InitErrorDetails

from fretwear.arrays import Array
from fretwear.quantity import (
    Parameter,
    Part,
    Plain,
    Quantity,
    adapter,
    declared,
    is_list,
    whole_number,
)
from fretwear.results import LOOP, OPTIONAL_SCALARS, SCALARS, Y
from fretwear.study.case import Case, case_keys
from fretwear.study.cycles import MAX_CYCLES
from fretwear.study.mistakes import Mistakes, nearest_key
from fretwear.study.sections import StudySection
from fretwear.study.study import as_mapping
from fretwear.units import (
    BY_SI_UNIT,
    LINE_CONTACT,
    FloatWithUnit,
    QuantityError,
    exact_text,
    format_quantity,
    parse_quantity,
)
from fretwear.variable import Variable
from fretwear_fit.loops import last_loop, recording_of
from fretwear_fit.readings import profile_of
from fretwear_measured.files import Source, SourceFile
from fretwear_measured.tables import Layout

MEASURED_FIELDS = ("wear_depth", "wear_depth_indenter", "wear_depth_flat")
"""Fields that are measured along a line."""
BASELINE = ("offset", "tilt", "shift")
"""What is free of the base line of a profile: height and slope, and its place along the line."""
_LOOPS = "loop"
_NUMBERS = {result.name: result for result in (*SCALARS, *OPTIONAL_SCALARS)}
_QUANTITIES = (*MEASURED_FIELDS, *_NUMBERS, _LOOPS)
_OF_READINGS = ("file", "noise", "correlation_length", "line", "force_noise")
_BODIES = ("indenter", "flat")
_WEAR = ("wear_coefficient", "energy_wear_coefficient")
_PARTS_OF_WEAR = ("", *_BODIES, "value", "rim", "core")

_UNITS = Path()  # numbers of a file need them
_LEAST_FRACTION = 1e-3
_TEXT: dict[str, object] = {"type": "string"}


@dataclasses.dataclass(frozen=True)
class Unknown:
    """A parameter that is sought within a range, in SI units, of all tests or of one."""

    parameter: str  # as in a study file, dotted within a part, a pair or a law
    low: float
    high: float
    quantity: Quantity  # its unit, words and symbol
    logarithmic: bool  # whether it is sought on its logarithm
    each: bool = False  # whether every test has its own value
    path: tuple[str | int, ...] = ()  # keys of parts and places of pairs below its key of `base`
    test: int | None = None  # None: of all tests

    @property
    def name(self) -> str:
        """Its name, with the number of its test if it has one."""
        return self.parameter + ("" if self.test is None else f"[{self.test}]")

    @property
    def key(self) -> str:
        """Its key of `base`, which may hold more."""
        return self.parameter.partition(".")[0]

    @property
    def is_of_wear(self) -> bool:
        """Whether it is a wear coefficient, also of one body or within a law."""
        _, _, part = self.parameter.partition(".")
        return self.key in _WEAR and part.rpartition(".")[2] in _PARTS_OF_WEAR

    @property
    def middle(self) -> float:
        """The middle of its range."""
        return float(self.value(float(np.mean(self.ends))))

    @property
    def is_fraction(self) -> bool:
        """Whether it is a part of a whole, sought on the logarithm of x/(1 − x)."""
        return (self.quantity.ge, self.quantity.le) == (0.0, 1.0) and not self.logarithmic

    def inner(self, value: float) -> float:
        """The coordinate in which it is sought: a logarithm, or the part of its range."""
        if self.is_fraction:
            inside = min(max(value, _LEAST_FRACTION), 1.0 - _LEAST_FRACTION)
            return float(np.log(inside / (1.0 - inside)))
        part = (value - self.low) / (self.high - self.low)
        return float(np.log(value)) if self.logarithmic else part

    def value(self, inner: float | Array) -> Array:
        """The value, in SI units, from the coordinate in which it is sought."""
        if self.is_fraction:
            return np.asarray(1.0 / (1.0 + np.exp(-np.asarray(inner))))
        inside = self.low + np.asarray(inner) * (self.high - self.low)
        return np.asarray(np.exp(inner) if self.logarithmic else inside)

    @property
    def ends(self) -> tuple[float, float]:
        """The range, in the coordinate in which it is sought."""
        return self.inner(self.low), self.inner(self.high)

    def text(self, value: float) -> str:
        """The value as study files have it."""
        unit = self.low.si_unit if isinstance(self.low, FloatWithUnit) else self.quantity.si_unit
        return exact_text(value, BY_SI_UNIT[unit])

    def given_in(self, base: Mapping[str, object]) -> float | None:
        """Its value in the plain keys of `base`, or None if they do not have it."""
        value = base.get(self.key)
        with suppress(QuantityError):
            if not self.path and is_list(value):
                return float(sum(self.quantity.read(number, _UNITS) for number in value))
            for step in self.path:
                if isinstance(step, str):
                    value = as_mapping(value).get(step)
                elif is_list(value):
                    value = value[step]
            return float(self.quantity.read(value, _UNITS))
        return None

    def placed(self, base: Mapping[str, object], sought: float) -> tuple[str, object]:
        """The key of `base` that has it, and the value of that key with another value in its place.

        Where `base` has a pair, the value is the sum of both, whose shares stay.
        """
        text, whole = self.text(sought), base.get(self.key)
        if not self.path and is_list(whole):
            parts = [self.quantity.read(number, _UNITS) for number in whole]
            return self.key, [self.text(sought * part / sum(parts)) for part in parts]

        def put(value: object, path: Sequence[str | int]) -> object:
            if not path:
                return text
            step, *further = path
            if isinstance(step, str):
                inner = as_mapping(value)
                return {**inner, step: put(inner.get(step), further)}
            values = [*value] if is_list(value) else [value or text] * 2
            values[step] = put(values[step], further)
            return values

        return self.key, put(whole, self.path)


class SoughtRange(BaseModel):
    """The range of a parameter that is sought: ``[low, high]``, or with further keys."""

    model_config = ConfigDict(extra="forbid")

    low: Annotated[object, Field(alias="from", json_schema_extra={"type": ["string", "number"]})]
    high: Annotated[object, Field(alias="to", json_schema_extra={"type": ["string", "number"]})]
    each: bool = False
    scale: Literal["linear", "log"] | None = None

    @model_validator(mode="before")
    @classmethod
    def _of_pair(cls, value: object) -> object:
        if is_list(value) and len(value) == 2:
            return dict(zip(("from", "to"), value, strict=True))
        if not isinstance(value, Mapping):
            raise QuantityError("must be a range of two values", "such as [0.2, 0.9]")
        return value

    def of(self, name: str) -> Unknown:
        """The parameter with this range."""
        parameter, path = _parameter_at(name)
        if parameter is None:
            raise QuantityError("is not a case parameter", nearest_key(name, case_keys().all_names))
        if not isinstance(parameter, Quantity):
            raise QuantityError("cannot be sought within a range")
        low, high = (parameter.read(end, _UNITS) for end in (self.low, self.high))
        if not low < high < np.inf:
            raise QuantityError("must have a lower end below its upper end, both finite")
        if self.scale == "log" and low <= 0.0:
            raise QuantityError("must begin above 0 on a logarithmic scale")
        scale = self.scale or ("log" if low > 0.0 else "linear")
        return Unknown(name, low, high, parameter, scale == "log", self.each, path)


def _checked(ranges: dict[str, SoughtRange]) -> dict[str, SoughtRange]:
    wrong = []
    for name, ends in ranges.items():
        try:
            ends.of(name)
        except QuantityError as error:
            wrong.append((name, [ends.low, ends.high], error))
    _raise(wrong)
    return ranges


Ranges = Annotated[
    dict[str, SoughtRange],
    AfterValidator(_checked),
    Field(description="What is sought, each with a range: [low, high].", min_length=1),
]


def _raise(wrong: Sequence[tuple[str, object, QuantityError]]) -> None:
    """Raise mistakes of keys as one error, if there are any."""
    details = [
        InitErrorDetails(type="value_error", loc=(key,), input=value, ctx={"error": error})
        for key, value, error in wrong
    ]
    if details:
        raise ValidationError.from_exception_data("fit", details)


def _as_tuple(value: object) -> object:
    return tuple(value) if is_list(value) else () if value == "none" else (value,)


@dataclass(frozen=True)
class Measurement(Part):
    """One measured profile, loop or number of a test, in SI units."""

    quantity: Annotated[
        Literal[_QUANTITIES],  # type: ignore[valid-type]
        Plain("", "measured quantity", "wear_depth_flat"),
        "A field along a line, a scalar, or loop: force against displacement.",
    ]
    file: Annotated[
        Source | None,
        SourceFile("", "file", "scar.csv"),
        "Its profile or loop: a text with columns and their units above them, or a line scan or "
        "map of an instrument.",
    ] = None
    cycle: Annotated[
        int | None,
        whole_number("$N$", "cycle", 0, MAX_CYCLES, 18000),
        "When it was measured; by default at the last cycle.",
    ] = None
    test: Annotated[
        int,
        whole_number("", "test", 1, 1000, 1),
        "Number of the point of the study that it belongs to.",
    ] = 1
    along: Annotated[Literal["x", "y"], Plain("", "direction", "x"), "Direction of the line."] = "x"
    line: Annotated[
        float | None,
        Quantity("m", "", "place of the line", "um", "120 um", ge=0.0),
        "Where the line lies in a map, from its edge; by default in the middle.",
    ] = None
    noise: Annotated[
        float | None,
        Quantity("m", "$σ$", "noise", "um", "50 nm", gt=0.0),
        "Standard deviation of the readings; by default as measured beside the scar.",
    ] = None
    correlation_length: Annotated[
        float | None,
        Quantity("m", "", "correlation length", "um", "10 um", ge=0.0),
        "Distance over which the noise is correlated; by default as measured beside the scar.",
    ] = None
    force_noise: Annotated[
        FloatWithUnit | None,
        Quantity("N", "", "noise of forces", "N", "0.2 N", gt=0.0),
        "Standard deviation of the forces of a loop.",
    ] = None
    baseline: Annotated[
        tuple[Literal[BASELINE], ...],  # type: ignore[valid-type]
        BeforeValidator(_as_tuple),
        Field(description="Free parts of the base line."),
    ] = BASELINE
    value: Annotated[Any, Field(description="A measured number.", json_schema_extra=_TEXT)] = None
    error: Annotated[
        Any, Field(description="Its standard deviation, or in %.", json_schema_extra=_TEXT)
    ] = None
    columns: Annotated[
        tuple[int | str, ...] | None,
        Field(description="Columns by number from 0 or by name: [0, 2].", min_length=1),
    ] = None
    units: Annotated[
        tuple[str, ...] | None,
        BeforeValidator(_as_tuple),
        Field(description="Their units, if the file lacks them: [mm, um]."),
    ] = None
    scale: Annotated[
        tuple[str, ...] | None,
        BeforeValidator(lambda value: value if value is None else (*map(str, _as_tuple(value)),)),
        Field(description="Factors of the columns, such as [20 um/V, -1]."),
    ] = None
    skip: Annotated[
        int, Field(description="Lines before the names of the columns.", ge=0, le=10**6)
    ] = 0
    decimal: Annotated[Literal[".", ","] | None, Field(description="Sign before the decimals.")] = (
        None
    )
    encoding: Annotated[str | None, Field(description="Encoding of the text, such as latin-1.")] = (
        None
    )
    unit: Annotated[str | None, Field(description="Unit of lengths, if the file lacks it.")] = None

    def checked(self) -> Self:
        """Read the file or the number, which depend on each other's keys."""
        scalar, keys = _NUMBERS.get(self.quantity), vars(self)
        needed = ("value", "error") if scalar else ("file", "force_noise")[: 1 + self.is_loop]
        foreign = _OF_READINGS if scalar else ("value", "error")
        wrong = [(n, None, QuantityError("is missing")) for n in needed if keys[n] is None]
        rule = f"does not apply to {self.quantity}"
        wrong += [(n, None, QuantityError(rule)) for n in foreign if keys[n] is not None]
        _raise(wrong)
        try:
            if scalar and not isinstance(self.value, FloatWithUnit):  # read already
                value, error = _read_number(self.value, self.error, scalar)
                object.__setattr__(self, "value", value)
                object.__setattr__(self, "error", error)
            elif not scalar:
                len(self.readings)  # reads the file
        except QuantityError as cause:
            _raise([("value" if scalar else "file", self.value or self.file, cause)])
        return self

    @property
    def readings(self) -> tuple[Array, Array]:
        """Positions and depths of a profile, displacements and forces of a loop; 0 and a number."""
        return self._read[:2]

    @property
    def origin(self) -> str:
        """What the readings were taken from, such as columns, and how many are missing."""
        return self._read[2]

    @property
    def file_summary(self) -> str:
        """Number and range of the readings of a file, and what they were taken from."""
        assert self.file is not None
        unit = BY_SI_UNIT[self.force_noise.si_unit if self.force_noise else "m"]
        ends = zip(self.readings, (BY_SI_UNIT["m"], unit), strict=True)
        x, values = (
            f"{format_quantity(one.min(), kind, 4)} to {format_quantity(one.max(), kind, 4)}"
            for one, kind in ends
        )
        size = self.readings[0].size
        return f"{self.file.name}: {size} readings, {values} over {x}; {self.origin}"

    @cached_property
    def _read(self) -> tuple[Array, Array, str]:
        if self.file is None:
            return np.zeros(1), np.array([self.value]), ""
        layout = Layout(
            self.columns, self.units, self.skip, self.decimal, self.encoding, self.scale
        )
        if self.is_loop:
            assert self.force_noise is not None
            recording = recording_of(Path(self.file.path), layout, self.force_noise.si_unit)
            return *last_loop(recording), recording.origin
        x, depth, origin = profile_of(self.file, layout, self.unit, self.along, self.line)
        if not np.ptp(depth) and self.noise is None:
            rule = "is flat: it shows no wear"
            raise QuantityError(rule, "give its noise, such as noise: 50 nm, for an upper limit")
        return x, depth, origin

    @property
    def is_profile(self) -> bool:
        """Whether it is measured along a line."""
        return self.quantity in MEASURED_FIELDS

    @property
    def is_loop(self) -> bool:
        """Whether it is force against displacement."""
        return bool(self.quantity == _LOOPS)


@dataclass(frozen=True, config=ConfigDict(extra="forbid"))
class FitRequest(StudySection):
    """Free parameters, and the measurements that they are fitted to."""

    free: Ranges
    data: Annotated[tuple[Measurement, ...], Field(description="What was measured.", min_length=1)]
    runs: Annotated[int, Field(description="Most runs of each test.", ge=10)] = 40

    @property
    def sought(self) -> tuple[Unknown, ...]:
        """The parameters with their ranges."""
        return tuple(ends.of(name) for name, ends in self.free.items())

    @property
    def files(self) -> list[Path]:
        """The files with what was measured, without the study if it has numbers only."""
        return [*dict.fromkeys(Path(datum.file.path) for datum in self.data if datum.file)]

    @property
    def file_summaries(self) -> list[str]:
        """What these files hold, for people."""
        return [datum.file_summary for datum in self.data if datum.file]

    @classmethod
    def complete_base(
        cls,
        section: object,
        base: Mapping[str, object],
        vary: Mapping[str, object],
        mistakes: Mistakes,
    ) -> dict[str, object]:
        """`base` with a value within its range for each sought parameter that it lacks."""
        filled = dict(base)
        for name, range_ in as_mapping(as_mapping(section).get("free")).items():
            try:
                parameter = adapter(SoughtRange).validate_python(range_).of(name)
            except (QuantityError, ValidationError):  # told when the section is read
                continue
            whole, further = parameter.key, parameter.name.partition(".")[2]
            ends, is_pair = _places(case_keys()[whole].parameter), is_list(filled.get(whole))
            if whole in vary or parameter.name in vary:
                rule = "is varied too: every test has its own value already"
                remedy = "leave it out of vary and write each: true beside its range"
                mistakes.add(f"fit.free.{parameter.name}", None, rule, remedy)
            elif whole in filled and (
                (is_pair and ends != _BODIES) if not further else further in ends and not is_pair
            ):
                rule = f"base has {'two values' if is_pair else 'one value for both together'}"
                remedy = f"write {whole}: [{', '.join(ends)}] under base for {whole}.{ends[0]}"
                mistakes.add(f"fit.free.{parameter.name}", None, rule, remedy)
            elif parameter.given_in(filled) is None and parameter.name not in filled:
                key, value = parameter.placed(filled, parameter.middle)
                filled[key] = value
        return filled

    def check(self, cases: Sequence[Case | None], mistakes: Mistakes) -> None:
        """Add the mistakes of the measurements with the cases of the points of the study."""
        for number, datum in enumerate(self.data):
            place = f"fit.data[{number}]"
            case = cases[datum.test - 1] if datum.test <= len(cases) else None
            if case is None:
                rule = f"is none of the valid points among the {len(cases)} of the study"
                mistakes.add(f"{place}.test", datum.test, rule, "fretwear plan numbers them")
                continue
            if datum.cycle is not None and datum.cycle > case.cycles:
                rule = f"is beyond the {case.cycles} cycles of its test"
                mistakes.add(f"{place}.cycle", datum.cycle, rule)
            has_bodies = case.wear_law.shares is not None
            if datum.quantity.endswith(("_indenter", "_flat")) and not has_bodies:
                rule = "is of one body, but the wear coefficient is one for both together"
                remedy = "write wear_coefficient: [indenter, flat] under base"
                mistakes.add(f"{place}.quantity", datum.quantity, rule, remedy)
            result = _NUMBERS.get(datum.quantity, LOOP[0])
            unit = result.in_frame(case.frame).si_unit
            for key in ("value", "force_noise"):
                value = getattr(datum, key)
                if value is not None and value.si_unit != unit:
                    rule = f"must have the unit of a {case.frame.name} contact"
                    mistakes.add(f"{place}.{key}", value, rule, f"in SI {unit}")
            if (datum.along == Y.name or result.across) and Y.name not in case.frame.axes:
                mistakes.add(place, None, "lies along y, which a line contact lacks")


def _places(parameter: Parameter | None) -> tuple[str, ...]:
    """The names of the values of a pair, such as indenter and flat."""
    return tuple(end for end, _ in parameter.places) if isinstance(parameter, Quantity) else ()


def _parameter_at(name: str) -> tuple[Parameter | None, tuple[str | int, ...]]:
    """The single quantity of a name, and its path through parts, laws and pairs."""
    whole, *steps = name.split(".")
    path: list[str | int] = [*steps]
    parameter: Parameter | None = None
    if name in case_keys().all_names:
        parameter = case_keys()[name].parameter
    elif whole in case_keys().names:
        parameter = case_keys()[whole].parameter
        for place, step in enumerate(steps):
            if step in (places := _places(parameter)):
                path[place] = places.index(step)
            else:
                forms = parameter.forms if isinstance(parameter, Quantity) else ()
                parameter = next((declared(f)[step] for f in forms if step in declared(f)), None)
    return (parameter.single if isinstance(parameter, Quantity) else parameter), (*path,)


def _read_number(text: object, error: object, scalar: Variable) -> tuple[FloatWithUnit, float]:
    """A measured value and its standard deviation, which may be in percent."""
    dimension = BY_SI_UNIT[LINE_CONTACT.unit(scalar.si_unit)]
    try:
        value = parse_quantity(text, dimension, units_required=True)
    except QuantityError:
        dimension = BY_SI_UNIT[scalar.si_unit]
        value = parse_quantity(text, dimension, units_required=True)
    share = re.fullmatch(r"\s*([\d.eE+-]+)\s*%\s*", error) if isinstance(error, str) else None
    if share:
        deviation = abs(value) * float(share[1]) / 100.0
    else:
        deviation = parse_quantity(error, dimension, units_required=True)
    if not deviation > 0.0:
        raise QuantityError(f"has the error {error}, which must be larger than 0", "such as 5 %")
    return FloatWithUnit(value, dimension.si_unit), deviation
