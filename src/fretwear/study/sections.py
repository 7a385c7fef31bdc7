"""The sections of a study file: what each may hold, and what is wrong with them in words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from fretwear.study.case import SNAPSHOT, schema_of, schema_required
from fretwear.study.designs import KINDS, LISTED, MAX_POINTS, SAMPLED, Design
from fretwear.study.problems import Problem, Problems
from fretwear.study.tree import base_names, parameter_names, parameter_of
from fretwear.units import QuantityError

NAMES = ("title", "base", "vary", "seeds", "design", "invalid", "batch", "output")
SEEDS = "roughness.seed"
"""What the section `seeds` varies."""
MAX_TITLE = 200

_NUMBERS = {"points": (1, MAX_POINTS), "seed": (0, 2**32 - 1)}
_CYCLES = ("cycles",)


@dataclass(frozen=True)
class Sections:
    """The sections of a study file; what is wrong stands as if it were left out."""

    title: str = ""
    base: Mapping[str, Any] = field(default_factory=dict)
    vary: Mapping[str, Any] = field(default_factory=dict)
    design: Design = field(default_factory=Design)
    skip_invalid: bool = False
    batch: int | None = None  # cases of a job; None: as many as take a few minutes
    cycles: Any = "auto"  # as written


def read_sections(raw: Mapping[str, Any], problems: Problems) -> Sections:
    """Read the sections, and add what is wrong with them to the problems."""
    found: dict[str, Any] = {}
    for name, given in raw.items():
        with problems.at(name, given):
            match name:
                case "title":
                    found[name] = _title(given)
                case "base" | "vary" | "output":
                    found[name] = _mapping(name, given)
                case "design":
                    found[name] = _design(given, problems)
                case "invalid":
                    found["skip_invalid"] = given == "skip"
                    if given not in ("stop", "skip"):
                        raise QuantityError("must be stop or skip")
                case "batch":
                    found[name] = given if _is_whole(given, 1, MAX_POINTS) else None
                    if found[name] is None and given != "auto":
                        rule = f"must be auto, or a whole number of cases from 1 to {MAX_POINTS}"
                        hint = "auto gives a job a few minutes of work"
                        raise QuantityError(rule, hint, ("auto",))
                case _:
                    known = () if name in parameter_names() else NAMES
                    hint = f"known are {', '.join(NAMES)}"
                    hint = hint if known else f"put it under base: base.{name}"
                    rule = "is not a section of a study"
                    problems.append(Problem(name, given, rule, hint, written=name, known=known))
    output = found.pop("output", {})
    problems.unknown("output", output, _CYCLES)
    return Sections(**found, cycles=output.get("cycles", "auto"))


def unfolded(content: Mapping[str, Any], problems: Problems) -> Mapping[str, Any]:
    """Return the content of a study file with its `seeds` where they belong, under `vary`."""
    if "seeds" not in content:
        return content
    others = {name: section for name, section in content.items() if name != "seeds"}
    vary = content.get("vary", {})
    if not isinstance(vary, Mapping):
        return others
    if twice := [name for name in vary if name in (SEEDS, "roughness")]:
        rule = f"would vary what vary.{twice[0]} varies"
        problems.add("seeds", content["seeds"], rule, "leave one of them out")
        return others
    return {**others, "vary": {**vary, SEEDS: content["seeds"]}}


def _is_whole(given: object, least: int, most: int) -> bool:
    return type(given) is int and least <= given <= most


def _title(given: object) -> str:
    if not isinstance(given, str) or not given.strip():
        raise QuantityError("must be text", "put it in quotes")
    if not given.isprintable():
        raise QuantityError("must be one line of printable text")
    if len(given.strip()) > MAX_TITLE:
        raise QuantityError(f"must have at most {MAX_TITLE} characters")
    return given.strip()


def _mapping(name: str, given: object) -> Mapping[str, Any]:
    if isinstance(given, Mapping):
        return given
    if given is None:
        raise QuantityError("is empty", f"leave {name} out, or fill it")
    raise QuantityError("must hold keys with values, one to a line")


def _design(given: object, problems: Problems) -> Design:
    """Read a design; ``design: zip`` is short for ``design: {kind: zip}``."""
    keys = given if isinstance(given, Mapping) else {"kind": given}
    kind = keys.get("kind", "grid")
    if kind not in KINDS:
        key = "design.kind" if keys is given else "design"
        problems.add(key, kind, f"must be one of {', '.join(KINDS)}", known=KINDS)
        return Design()
    known = ("kind", *_NUMBERS) if kind in SAMPLED else ("kind",)
    problems.unknown("design", keys, known, f"{kind} knows")
    found: dict[str, Any] = {}
    for name in [name for name in keys if name in known[1:]]:
        least, most = _NUMBERS[name]
        with problems.at(f"design.{name}", keys[name]):
            if not _is_whole(keys[name], least, most):
                raise QuantityError(f"must be a whole number from {least} to {most}")
            found[name] = keys[name]
    if kind in SAMPLED and "points" not in keys:
        rule = f"is missing: {kind} needs it"
        problems.add("design.points", None, rule, "such as points: 64")
    return Design(kind, **found)


def study_schema() -> dict[str, Any]:
    """Return the JSON Schema (2020-12) of a study file, made from what reads it.

    It knows names, kinds of values and their descriptions.  What depends on several values at
    once (Q < µP, a cell fine enough for the roughness, equal lengths under ``zip``) is checked
    by `load_study` only.
    """
    base = {name: schema_of(name) for name in base_names()}
    numbers = {name: _whole_numbers(*ends) for name, ends in _NUMBERS.items()}
    listed = {"kind": {"enum": list(LISTED), "default": "grid"}}
    sampled = {"kind": {"enum": list(SAMPLED)}, **numbers}
    cycles = {
        "description": "Cycles at which the fields are kept, beside 0 and the last; auto: about "
        "eight, powers of ten and three times these.",
        "default": "auto",
        "anyOf": [{"const": "auto"}, {"type": "array", "items": SNAPSHOT.described()}],
    }
    sections = {
        "title": {
            "description": "For people; the name of the study is that of its file.",
            "type": "string",
            "minLength": 1,
            "maxLength": MAX_TITLE,
        },
        "base": {
            "description": "One value for every parameter that is not varied.",
            **_object(base),
        },
        "vary": {
            "description": "The varied parameters, each with its values.",
            **_object({name: _varied(name) for name in parameter_names()}),
        },
        "seeds": {"description": f"Short for {SEEDS} under vary.", **_varied(SEEDS)},
        "design": {
            "description": "How the varied values are combined.",
            "default": "grid",
            "anyOf": [
                {"enum": list(LISTED)},
                {"description": "Values that are listed, combined or paired.", **_object(listed)},
                {
                    "description": "Points that are drawn over ranges.",
                    **_object(sampled, "kind", "points"),
                },
            ],
        },
        "invalid": {
            "description": "What to do about points such as Q >= µP.",
            "default": "stop",
            "enum": ["stop", "skip"],
        },
        "batch": {
            "description": "Cases of a job; auto: as many as take a few minutes.",
            "default": "auto",
            "anyOf": [{"const": "auto"}, _whole_numbers(1, MAX_POINTS)],
        },
        "output": _object({"cycles": cycles}),
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


def _whole_numbers(least: int, most: int) -> dict[str, Any]:
    return {"type": "integer", "minimum": least, "maximum": most}


def _varied(name: str) -> dict[str, Any]:
    value = schema_of(name)
    listed = {"type": "array", "items": value, "minItems": 1, "uniqueItems": True}
    if not getattr(parameter_of(name), "may_be_drawn", False):
        return listed
    ends = {"from": value, "to": value, "scale": {"enum": ["linear", "log"]}}
    interval = {"description": "A range, for sampled designs.", **_object(ends, "from", "to")}
    return {"anyOf": [listed, interval]}
