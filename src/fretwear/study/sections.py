"""The sections of a study file: what each may hold, and what is wrong with them in words."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from fretwear.parts import Choice
from fretwear.study.case import SNAPSHOTS, schema_required
from fretwear.study.designs import MAX_POINTS, Design, Grid
from fretwear.study.members import PartOf
from fretwear.study.parameters import base_names, parameter_names, parameter_of
from fretwear.study.problems import Problem, Problems
from fretwear.units import QuantityError

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
    """The sections of a study file; what is wrong stands as if it were left out."""

    title: str = ""
    base: Mapping[str, Any] = field(default_factory=dict)
    vary: Mapping[str, Any] = field(default_factory=dict)
    design: Design | None = _GRID  # None where it could not be read
    invalid: str = "stop"
    batch: int | None = None  # cases of a job; None: as many as take a few minutes
    output: Mapping[str, Any] = field(default_factory=dict)
    has_seeds: bool = False  # whether the section `seeds` is what varies them

    def place(self, name: str) -> str:
        """Return the key under which the values of a varied parameter stand."""
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


def study_schema() -> dict[str, Any]:
    """Return the JSON Schema (2020-12) of a study file, made from what reads it.

    It knows names, kinds of values and their descriptions.  What depends on several values at
    once (Q < µP, a cell fine enough for the roughness, equal lengths under ``zip``) is checked
    by `load_study` only.
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
