"""The section ``fit`` of a study: what is sought, and what was measured."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, get_type_hints

import numpy as np

from fretwear.arrays import Array
from fretwear.mechanics.surfaces.files import Source, SourceFile
from fretwear.plugins import StudySection
from fretwear.quantity import (
    Parameter,
    Part,
    Plain,
    Quantity,
    Schema,
    adapter,
    declared,
    inlined,
    is_list,
    whole_number,
)
from fretwear.study.case import Case
from fretwear.study.contact import MAX_CYCLES
from fretwear.study.parameters import base_names, parameter_names, parameter_of
from fretwear.study.problems import NestedError, Problems
from fretwear.study.study import as_mapping
from fretwear.tables import Layout
from fretwear.units import (
    BY_SI_UNIT,
    LINE_CONTACT,
    ContactFrame,
    Dimension,
    FloatWithUnit,
    QuantityError,
    Unit,
    did_you_mean,
    exact_text,
    listed,
    parse_quantity,
)
from fretwear.vocabulary import BODY_SCALARS, SCALARS, Variable, Y
from fretwear_fit.readings import readings_of

MEASURED_FIELDS = ("wear_depth", "wear_depth_indenter", "wear_depth_flat")
"""Fields that are measured along a line."""
BASELINE = ("offset", "tilt", "shift")
"""What is free of the base line of a profile: height and slope, and its place along the line."""
_LOOPS = "loop"
_NUMBERS = {result.name: result for result in (*SCALARS, *BODY_SCALARS)}
_QUANTITIES = (*MEASURED_FIELDS, *_NUMBERS, _LOOPS)
_SAMPLERS = ("ensemble", "none")
_BODIES = ("indenter", "flat")
_LAYOUT = {
    "columns": [0, 2],
    "units": ["mm", "um"],
    "skip": 12,
    "decimal": ",",
    "encoding": "latin-1",
}
_LAYOUT_WORDS = {
    "columns": "Columns to use, by number from 0 or by name: [0, 2].",
    "units": "Their units, where the file does not say them: [mm, um].",
    "skip": "Lines before the names of the columns.",
    "decimal": "Sign before the decimals, '.' or ','.",
    "encoding": "Encoding of the text, such as latin-1.",
    "unit": "Unit of lengths in the file of an instrument that does not say it.",
}
_EXAMPLE = "{file: scar.csv, quantity: wear_depth_flat, cycle: 18000}"
_FREE_EXAMPLE = "free: {wear_coefficient: [1e-14 / Pa, 1e-12 / Pa]}"
_FORCE = BY_SI_UNIT["N"]
# pint does not tell an energy per length from a force.
_ENERGY_PER_LENGTH = Dimension("an energy per length", "N", "J/m", "0.5 J/m", (Unit("J/m"),))

_UNITS = Path()  # numbers of a file need them


@dataclass(frozen=True)
class FreeParameter:
    """A parameter that is sought within a range, in SI units."""

    name: str  # as in a study file, dotted within a part, a pair or a law
    low: float
    high: float
    about: Quantity  # its unit, words and symbol
    logarithmic: bool  # whether it is sought on its logarithm
    each: bool = False  # whether every test has its own value

    @property
    def middle(self) -> float:
        """The middle of its range."""
        ends = self.low, self.high
        return float(np.sqrt(np.prod(ends)) if self.logarithmic else np.mean(ends))

    def text(self, value: float) -> str:
        """The value as study files have it."""
        unit = self.low.si_unit if isinstance(self.low, FloatWithUnit) else self.about.si_unit
        return exact_text(value, BY_SI_UNIT[unit])

    def given_in(self, base: Mapping[str, object]) -> float | None:
        """Its value in the plain keys of `base`, or None if they do not have it."""
        whole, *path = self.name.split(".")
        value: object = base.get(whole)
        if not path and is_list(value):
            with suppress(QuantityError):
                return sum(self.about.read(number, _UNITS) for number in value)
            return None
        for step in path:
            if isinstance(value, Mapping):
                value = value.get(step)
            elif is_list(value) and step in (places := _places(parameter_of(whole))):
                value = value[places.index(step)]
            elif step not in _places(parameter_of(whole)):
                return None
        with suppress(QuantityError):
            return self.about.read(value, _UNITS)
        return None

    def placed(self, base: Mapping[str, object], sought: float) -> tuple[str, object]:
        """The key of `base` that has it, and the value of that key with another value in its place.

        Where `base` has a pair, the value is the sum of both, whose shares stay.
        """
        whole, *path = self.name.split(".")
        text, given = self.text(sought), base.get(whole)
        if not path and is_list(given):
            parts = [self.about.read(number, _UNITS) for number in given]
            return whole, [self.text(sought * part / sum(parts)) for part in parts]

        def put(value: object, about: Parameter, path: Sequence[str]) -> object:
            if not path:
                return text
            step, *further = path
            if step in (places := _places(about)):
                values = [*value] if is_list(value) else [value or text] * len(places)
                at = places.index(step)
                values[at] = put(values[at], about, further)
                return values
            inner = as_mapping(value)
            below = _below(about, step) or about
            return {**inner, step: put(inner.get(step), below, further)}

        return whole, put(given, parameter_of(whole), path)


@dataclass(frozen=True)
class Measurement(Part):
    """One measured profile, loop or number of a test, in SI units."""

    quantity: Annotated[
        str,
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
    #: what a text does not say: columns, units, lines to skip, decimal sign, encoding
    layout: Layout = Layout()  # noqa: RUF009 - frozen
    unit: str | None = None  #: of lengths in the file of an instrument that does not say it
    #: what is free of the base line of a profile
    baseline: tuple[str, ...] = BASELINE
    #: readings: positions and depths of a profile, displacements and forces of a loop
    readings: tuple[Array, Array] | None = None
    value: FloatWithUnit | None = None  #: of a number, with its unit
    error: float | None = None  #: standard deviation of the value

    @property
    def is_profile(self) -> bool:
        """Whether it is measured along a line."""
        return self.quantity in MEASURED_FIELDS

    @property
    def is_loop(self) -> bool:
        """Whether it is force against displacement."""
        return self.quantity == _LOOPS

    def variable(self, frame: ContactFrame) -> Variable:
        """The scalar that it is, in a point or a line contact."""
        return _NUMBERS[self.quantity].in_frame(frame)


@dataclass(frozen=True)
class FitRequest(StudySection):
    """The section ``fit``: free parameters and measurements."""

    free: tuple[FreeParameter, ...]
    data: tuple[Measurement, ...]
    sampler: str | None = None  #: ensemble or none; by default an ensemble where it is needed

    @property
    def files(self) -> list[Path]:
        """The files with what was measured, without the study if it has numbers only."""
        return [*dict.fromkeys(Path(datum.file.path) for datum in self.data if datum.file)]

    @classmethod
    def complete_base(
        cls,
        given: object,
        base: Mapping[str, object],
        vary: Mapping[str, object],
        problems: Problems,
    ) -> dict[str, object]:
        """`base` with a value within its range for each sought parameter that it lacks."""
        # What can be read is filled in even if there are problems elsewhere in the section.
        free = read_free(as_mapping(given).get("free"), Problems())
        return with_sought(free, base, vary, problems)

    @classmethod
    def read(cls, given: object, folder: Path = _UNITS) -> FitRequest:
        """Read the section; one `QuantityError` lists all problems."""
        if not isinstance(given, Mapping):
            raise QuantityError("must have free and data", _FREE_EXAMPLE)
        problems = Problems()
        for name in given.keys() - {"free", "data", "sampler"}:
            problems.unknown(f".{name}", given[name], ("free", "data", "sampler"))
        free = read_free(given.get("free"), problems)
        listed_data = given.get("data")
        if not is_list(listed_data) or not listed_data:
            problems.add(".data", listed_data, "must be a list of measurements", f"- {_EXAMPLE}")
            listed_data = ()
        data = []
        for number, content in enumerate(listed_data):
            with problems.at(f".data[{number}]", content):
                data.append(_read_measurement(content, folder))
        sampler = given.get("sampler")
        if sampler not in (None, *_SAMPLERS):
            rule = f"must be {listed(_SAMPLERS, 'or')}"
            problems.add(".sampler", sampler, rule, did_you_mean(str(sampler), _SAMPLERS))
        _raise(problems)
        return cls(free, (*data,), sampler)

    def check(self, cases: Sequence[Case | None], problems: Problems) -> None:
        """Add the problems of the measurements with the cases of the points of the study."""
        for number, datum in enumerate(self.data):
            place = f"fit.data[{number}]"
            if datum.test > len(cases):
                rule = f"is none of the {len(cases)} points of the study"
                problems.add(f"{place}.test", datum.test, rule, "fretwear plan numbers them")
                continue
            if (case := cases[datum.test - 1]) is None:
                problems.add(f"{place}.test", datum.test, "is an invalid point of the study")
                continue
            if datum.cycle is not None and datum.cycle > case.cycles:
                rule = f"is beyond the {case.cycles} cycles of its test"
                problems.add(f"{place}.cycle", datum.cycle, rule)
            has_bodies = case.wear_law.shares is not None
            if datum.quantity.endswith(("_indenter", "_flat")) and not has_bodies:
                rule = "is of one body, but the wear coefficient is one for both together"
                remedy = "write wear_coefficient: [indenter, flat] under base"
                problems.add(f"{place}.quantity", datum.quantity, rule, remedy)
            if (
                datum.value is not None
                and datum.value.si_unit != datum.variable(case.frame).si_unit
            ):
                rule = f"must have the unit of a {case.frame.name} contact"
                remedy = f"in SI {datum.variable(case.frame).si_unit}"
                problems.add(f"{place}.value", datum.value, rule, remedy)
            force = case.frame.unit(_FORCE.si_unit)
            if datum.force_noise is not None and datum.force_noise.si_unit != force:
                rule = f"must have the unit of a {case.frame.name} contact"
                problems.add(f"{place}.force_noise", datum.force_noise, rule, f"in SI {force}")
            lacks = datum.quantity in _NUMBERS and _NUMBERS[datum.quantity].across
            if (datum.along == Y.name or lacks) and Y.name not in case.frame.axes:
                problems.add(place, None, "lies along y, which a line contact lacks")

    @classmethod
    def section_schema(cls) -> Schema:
        """The JSON Schema of the section."""
        anything: Schema = {"type": ["string", "number"]}
        ends = {"from": anything, "to": anything, "each": {"type": "boolean"}}
        ends["scale"] = {"enum": ["linear", "log"]}
        pair = {"type": "array", "items": anything, "minItems": 2, "maxItems": 2}
        hints = get_type_hints(Measurement, include_extras=True)
        fields: Schema = {
            name: {**inlined(adapter(hints[name]).json_schema()), **about.described}
            for name, about in Measurement.parameters().items()
        }
        baseline = {"type": "array", "items": {"enum": [*BASELINE]}}
        words = "What of the base line is free: offset, tilt and shift, or some of them."
        fields["baseline"] = {"description": words, **baseline}
        fields["value"] = {"description": "A measured number.", **anything}
        for key, words in _LAYOUT_WORDS.items():
            fields[key] = {"description": words}
        words = "Its standard deviation, in its unit or in %."
        fields["error"] = {"description": words, **anything}
        words = "The parameters that are sought, each with a range: [low, high]."
        one = {"anyOf": [pair, _closed(ends, ["from", "to"])]}
        free = {"description": words, "type": "object", "additionalProperties": one}
        data = {"type": "array", "items": _closed(fields, ["quantity"]), "minItems": 1}
        data["description"] = "What was measured."
        words = "Draws of the posterior: by an ensemble sampler, or none; by default where needed."
        sampler = {"description": words, "enum": [*_SAMPLERS]}
        keys = {"free": free, "data": data, "sampler": sampler}
        return _closed(keys, ["free", "data"])


def read_free(ranges: object, problems: Problems) -> tuple[FreeParameter, ...]:
    """Read the ranges of the section, and collect the problems of those that are wrong."""
    if not isinstance(ranges, Mapping) or not ranges:
        problems.add(".free", ranges, "must hold ranges of parameters", _FREE_EXAMPLE)
        return ()
    free = []
    for name, ends in ranges.items():
        with problems.at(f".free.{name}", ends):
            free.append(_read_range(name, ends))
    return (*free,)


def with_sought(
    free: Sequence[FreeParameter],
    base: Mapping[str, object],
    vary: Mapping[str, object],
    problems: Problems,
) -> dict[str, object]:
    """The plain keys of `base` with a value within its range for what is sought, if missing."""
    filled = dict(base)
    for parameter in free:
        whole, _, further = parameter.name.partition(".")
        if whole in vary or parameter.name in vary:
            rule = "is varied too: every test has its own value already"
            remedy = "leave it out of vary and write each: true beside its range"
            problems.add(f"fit.free.{parameter.name}", None, rule, remedy)
        elif further in _places(parameter_of(whole)) and not is_list(filled.get(whole, [])):
            rule = "is of one body, but base has one value for both together"
            remedy = f"write {whole}: [indenter, flat] under base"
            problems.add(f"fit.free.{parameter.name}", None, rule, remedy)
        elif not further and is_list(filled.get(whole)) and _places(parameter_of(whole)) != _BODIES:
            rule = "has two values in base"
            problems.add(f"fit.free.{parameter.name}", None, rule, f"write {whole}.1 or {whole}.2")
        elif parameter.given_in(filled) is None and parameter.name not in filled:
            key, value = parameter.placed(filled, parameter.middle)
            filled[key] = value
    return filled


def _places(about: Parameter) -> tuple[str, ...]:
    """The names of the values of a pair, such as indenter and flat."""
    return tuple(end for end, _ in about.places) if isinstance(about, Quantity) else ()


def _below(about: Parameter, step: str) -> Parameter | None:
    """The parameter of a key within a law."""
    forms = about.forms if isinstance(about, Quantity) else ()
    return next((declared(form)[step] for form in forms if step in declared(form)), None)


def _parameter_at(name: str) -> Parameter | None:
    """The single quantity of a name, which may lead into a pair or a law."""
    whole, *path = name.split(".")
    if name in parameter_names():
        about: Parameter | None = parameter_of(name)
    else:
        about = parameter_of(whole) if whole in base_names() else None
        for step in path:
            if about is not None and step not in _places(about):
                about = _below(about, step)
    return about.single if isinstance(about, Quantity) else about


def _read_range(name: str, given: object) -> FreeParameter:
    about = _parameter_at(name)
    if about is None:
        hint = did_you_mean(name, parameter_names())
        raise QuantityError("is not a case parameter", hint)
    if not isinstance(about, Quantity):
        raise QuantityError("cannot be sought within a range")
    keys = as_mapping(given)
    if is_list(given) and len(given) == 2:
        keys = dict(zip(("from", "to"), given, strict=True))
    if not keys:
        like = f"[{about.example}, {about.example}]"
        raise QuantityError("must be a range of two values", f"such as {name}: {like}")
    for key in keys.keys() - {"from", "to", "each", "scale"}:
        raise QuantityError(f"has {key}, but knows from, to, each and scale")
    if not {"from", "to"} <= keys.keys():
        raise QuantityError("needs from and to")
    low, high = (about.read(keys[end], _UNITS) for end in ("from", "to"))
    if not low < high < np.inf:
        raise QuantityError("must have a lower end below its upper end, both finite")
    if keys.get("scale") == "log" and low <= 0.0:
        raise QuantityError("must begin above 0 on a logarithmic scale")
    logarithmic = keys.get("scale", "log" if low > 0.0 else "linear") == "log"
    return FreeParameter(name, low, high, about, logarithmic, keys.get("each", False) is True)


def _raise(problems: Problems) -> None:
    """Raise the problems as one error that keeps their places, if there are any."""
    if problems:
        raise NestedError(problems)


def _closed(properties: Mapping[str, object], needed: Sequence[str] = ()) -> Schema:
    """The JSON Schema of a mapping that may have these keys and no others."""
    keys = {"type": "object", "additionalProperties": False, "properties": properties}
    return {**keys, "required": [*needed]} if needed else keys


def _read_measurement(given: object, folder: Path) -> Measurement:
    if not isinstance(given, Mapping):
        raise QuantityError("must be a mapping", _EXAMPLE)
    problems, read, fields = Problems(), dict[str, Any](), Measurement.parameters()
    hints = get_type_hints(Measurement, include_extras=True)
    others = ("baseline", "value", "error", "unit", *_LAYOUT)
    for name, value in given.items():
        if name in fields:
            with problems.at(f".{name}", value):
                read[name] = adapter(hints[name]).validate_python(value, context=folder)
        elif name not in others:
            problems.unknown(f".{name}", value, (*fields, *others))
    if "quantity" not in given:
        problems.add(".quantity", None, "is missing", "such as quantity: wear_depth_flat")
    elif read.get("quantity") not in _QUANTITIES:
        hint = did_you_mean(given["quantity"], _QUANTITIES)
        problems.add(".quantity", given["quantity"], "is no result that can be measured", hint)
    if "baseline" in given:
        with problems.at(".baseline", given["baseline"]):
            read["baseline"] = _read_baseline(given["baseline"])
    with problems.at("", given):
        read["layout"], read["unit"] = read_layout(given), given.get("unit")
    _raise(problems)
    measurement = Measurement.unchecked(**read)
    if measurement.quantity in _NUMBERS:
        for name in ("file", "noise", "correlation_length", "baseline", "line", "force_noise"):
            if name in given:
                rule = f"does not apply to the number {measurement.quantity}"
                problems.add(f".{name}", given[name], rule, "it has value and error")
        for name in ("value", "error"):
            if name not in given:
                problems.add(f".{name}", None, "is missing", "such as value: 2.7 um, error: 5 %")
        _raise(problems)
        vars(measurement).update(_read_number(given, _NUMBERS[measurement.quantity], problems))
    else:
        for name in ("value", "error"):
            if name in given:
                problems.add(f".{name}", given[name], "does not apply to readings of a file")
        if measurement.file is None:
            problems.add(".file", None, "is missing", "such as file: scar.csv")
        if measurement.is_loop and measurement.force_noise is None:
            problems.add(".force_noise", None, "is missing", "such as force_noise: 0.2 N")
        _raise(problems)
        with problems.at(".file", given["file"]):
            vars(measurement)["readings"] = readings_of(measurement)
    _raise(problems)
    return measurement


def read_layout(given: Mapping[str, object]) -> Layout:
    """The keys beside the name of a file that say how its table is written."""
    found = {key: given[key] for key in _LAYOUT if key in given}
    for key in ("columns", "units"):
        if key in found:
            value = found[key]
            values = tuple(value) if is_list(value) else (value,)
            kinds = int | str if key == "columns" else str
            if not values or not all(isinstance(one, kinds) for one in values):
                raise QuantityError(f"{key} must be a list such as {_LAYOUT[key]}")
            found[key] = values
    skip, decimal = found.get("skip", 0), found.get("decimal", ".")
    if not isinstance(skip, int) or skip < 0:
        raise QuantityError("skip must be a number of lines, such as 12")
    if decimal not in (".", ","):
        raise QuantityError("decimal must be '.' or ','")
    return Layout(**found)  # type: ignore[arg-type]


def _read_baseline(given: object) -> tuple[str, ...]:
    words = given if is_list(given) else () if given == "none" else (given,)
    if wrong := [word for word in words if word not in BASELINE]:
        hint = did_you_mean(wrong[0], BASELINE)
        raise QuantityError(f"must be a list of {listed(BASELINE, 'or')}, or none", hint)
    return tuple(name for name in BASELINE if name in words)


def _read_number(
    given: Mapping[str, object], about: Variable, problems: Problems
) -> dict[str, float]:
    """A measured value and its standard deviation, which may be in percent."""
    units = dict.fromkeys((LINE_CONTACT.unit(about.si_unit), about.si_unit))
    read, dimension = dict[str, float](), BY_SI_UNIT[about.si_unit]
    with problems.at(".value", given["value"]):
        for unit in units:  # what the value of a line contact or a point contact has
            dimension = {**BY_SI_UNIT, "J m-1": _ENERGY_PER_LENGTH}[unit]
            try:
                number = parse_quantity(given["value"], dimension, units_required=True)
            except QuantityError:
                if unit == about.si_unit:
                    raise
            else:
                read["value"] = FloatWithUnit(number, unit)
                break
    with problems.at(".error", error := given["error"]):
        share = re.fullmatch(r"\s*([\d.eE+-]+)\s*%\s*", error) if isinstance(error, str) else None
        if share and "value" in read:
            read["error"] = abs(read["value"]) * float(share[1]) / 100.0
        elif not share:
            try:
                read["error"] = parse_quantity(error, dimension, units_required=True)
            except QuantityError as wrong:
                if isinstance(error, int | float):
                    wrong.hint = f"did you mean '{error:g} %', of the value?"
                raise
        if not read.get("error", 1.0) > 0.0:
            raise QuantityError("must be larger than 0", "such as 5 %")
    return read
