"""The sections of a study file: what each may hold, and their problems."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from fretwear.mechanics.materials import Course
from fretwear.parts import Choice, Part, Quantity
from fretwear.study.case import SNAPSHOTS
from fretwear.study.members import PartOf
from fretwear.study.parameters import (
    base_names,
    parameter_names,
    parameter_of,
    read_value,
    schema_required,
)
from fretwear.study.points import MAX_POINTS, Axis, Design, Grid, Range, Sampled, Zip
from fretwear.study.problems import Problem, Problems
from fretwear.units import QuantityError, exact_text

NAMES = ("title", "base", "vary", "seeds", "design", "invalid", "batch", "output")
SEEDS = "roughness.seed"
"""What the section `seeds` varies."""
MAX_TITLE = 200

_DESIGN = PartOf(
    Design,
    "design",
    example="{kind: latin_hypercube, points: 64, seed: 1}",
    description="How the varied values are combined.",
    may_be_partial=False,
)
_GRID = Grid()
_INVALID = Choice("", "", ("stop", "skip"), description="What to do about points such as Q >= µP.")


@dataclass(frozen=True)
class Sections:
    """The sections of a study file; invalid ones count as left out."""

    title: str = ""
    base: Mapping[str, Any] = field(default_factory=dict)
    vary: Mapping[str, Any] = field(default_factory=dict)
    design: Design | None = _GRID  # None where it could not be read
    invalid: str = "stop"
    batch: int | None = None  # cases per job; None: as many as take a few minutes
    output: Mapping[str, Any] = field(default_factory=dict)
    has_seeds: bool = False  # whether the section `seeds` is what varies them

    def place(self, name: str) -> str:
        """Return the key that holds the values of a varied parameter."""
        return "seeds" if self.has_seeds and name == SEEDS else f"vary.{name}"


def read_sections(raw: Mapping[str, Any], problems: Problems) -> Sections:
    """Read the sections, and add what is wrong with them to the problems."""
    found: dict[str, Any] = {"design": None} if "design" in raw else {}
    for name, given in ((name, given) for name, given in raw.items() if name != "seeds"):
        if read := _READ.get(name):
            with problems.at(name, given):
                found[name] = read(given)
            continue
        known = () if name in parameter_names() else NAMES
        hint = f"known are {', '.join(NAMES)}" if known else f"put it under base: base.{name}"
        rule = "is not a section of a study"
        problems.append(Problem(name, given, rule, hint, written=name, known=known))
    problems.unknown("output", found.get("output", {}), ("cycles",))
    vary = found.get("vary", {})
    if "seeds" in raw and (twice := [name for name in vary if name in (SEEDS, "roughness")]):
        rule = f"would vary what vary.{twice[0]} varies"
        problems.add("seeds", raw["seeds"], rule, "leave one of them out")
    elif "seeds" in raw:
        found |= {"vary": {**vary, SEEDS: raw["seeds"]}, "has_seeds": True}
    return Sections(**found)


def _title(given: object) -> str:
    if not isinstance(given, str) or not given.strip():
        raise QuantityError("must be text", "put it in quotes")
    if not given.isprintable():
        raise QuantityError("must be one line of printable text")
    if len(given.strip()) > MAX_TITLE:
        raise QuantityError(f"must have at most {MAX_TITLE} characters")
    return given.strip()


def _mapping(given: object) -> Mapping[str, Any]:
    if isinstance(given, Mapping):
        return given
    if given is None:
        raise QuantityError("is empty", "leave it out, or fill it")
    raise QuantityError("must hold keys with values, one to a line")


def _batch(given: object) -> int | None:
    if given == "auto":
        return None
    if type(given) is not int or not 1 <= given <= MAX_POINTS:
        rule = f"must be auto, or a whole number of cases from 1 to {MAX_POINTS}"
        raise QuantityError(rule, "auto gives a job a few minutes of work", ("auto",))
    return given


_READ: Mapping[str, Callable[[object], Any]] = {
    "title": _title,
    "base": _mapping,
    "vary": _mapping,
    "design": lambda given: _DESIGN.read(given, True),
    "invalid": lambda given: _INVALID.read(given, True),
    "batch": _batch,
    "output": _mapping,
}


def read_axes(sections: Sections, problems: Problems) -> tuple[Axis, ...]:
    """Read the varied parameters; return the valid axes and add the rest to `problems`.

    Nothing is returned if the design could not be read.
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
        return _drawn(read, design) if read else ()
    if design is None:
        return ()
    axes = tuple(axis for axis in read.values() if isinstance(axis, Axis))
    lengths = {axis.name: len(axis.values) for axis in axes}
    if isinstance(design, Zip):
        if len(set(lengths.values())) > 1:
            listed = ", ".join(f"{name} has {length}" for name, length in lengths.items())
            rule = f"must have lists of equal length under design: zip, but {listed}"
            problems.add("vary", None, rule, "design: grid takes every combination")
            return ()
        seen: dict[object, int] = {}
        for row, values in enumerate(zip(*(axis.values for axis in axes), strict=True)):
            first = seen.setdefault(_identity(values), row)
            if first != row:
                given = ", ".join(f"{axis.name} {axis.labels[row]}" for axis in axes)
                rule = f"make point {row + 1} the same as point {first + 1} under design: zip"
                problems.add("vary", given, rule, "leave one of them out of every list")
    if (size := design.size([*lengths.values()])) > MAX_POINTS:
        rule = f"makes {size} points, more than the limit of {MAX_POINTS}"
        problems.add("vary", None, rule, "split the study")
        return ()
    return axes


def _drawn(read: Mapping[str, Axis | Range], design: Sampled) -> tuple[Axis, ...]:
    pools = [
        axis if isinstance(axis, Range) else [*zip(axis.values, axis.written, strict=True)]
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


def _identity(value: Any) -> object:
    """Return a key that equal values of an axis share, whatever their units."""
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


def study_schema() -> dict[str, Any]:
    """Return the JSON Schema (2020-12) of a study file, made from what reads it.

    It covers names, kinds of values and their descriptions. Rules on several values at once (Q <
    µP, a cell fine enough for the roughness, equal lengths under ``zip``) is checked by
    `load_study` only.
    """
    whole = {"type": "integer", "minimum": 1, "maximum": MAX_POINTS}
    sections = {
        "title": {
            "description": "For people; the name of the study is that of its file.",
            "type": "string",
            "minLength": 1,
            "maxLength": MAX_TITLE,
        },
        "base": {
            "description": "One value for every parameter that is not varied.",
            **_object({name: parameter_of(name).described() for name in base_names()}),
        },
        "vary": {
            "description": "The varied parameters, each with its values.",
            **_object({name: _varied(name) for name in parameter_names()}),
        },
        "seeds": {"description": f"Short for {SEEDS} under vary.", **_varied(SEEDS)},
        "design": {**_DESIGN.described(), "default": "grid"},
        "invalid": {**_INVALID.described(), "default": "stop"},
        "batch": {
            "description": "Cases of a job; auto: as many as take a few minutes.",
            "default": "auto",
            "anyOf": [{"const": "auto"}, whole],
        },
        "output": _object({"cycles": SNAPSHOTS.described()}),
    }
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "fretwear study",
        "description": "A study of fretting wear: base values, varied values, output.",
        **_object(sections),
        "allOf": schema_required(),
    }


def _object(properties: Mapping[str, Any], *required: str) -> dict[str, Any]:
    keys = {"type": "object", "additionalProperties": False, "properties": properties}
    return {**keys, "required": list(required)} if required else keys


def _varied(name: str) -> dict[str, Any]:
    value = parameter_of(name).described()
    listed = {"type": "array", "items": value, "minItems": 1, "uniqueItems": True}
    if not parameter_of(name).may_be_drawn:
        return listed
    ends = {"from": value, "to": value, "scale": {"enum": ["linear", "log"]}}
    interval = {"description": "A range, for sampled designs.", **_object(ends, "from", "to")}
    return {"anyOf": [listed, interval]}
