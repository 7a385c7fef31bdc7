"""The sections of a study file as typed models, and what is wrong with them in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    StrictInt,
    StrictStr,
    ValidationError,
)

from fretwear.parts import Quantity, refuse
from fretwear.study.case import schema_of, schema_required
from fretwear.study.designs import KINDS, LISTED, MAX_POINTS, SAMPLED, Design
from fretwear.study.problems import Problem
from fretwear.study.tree import base_names, parameter_names, parameter_of

MAX_TITLE = 200


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Listed(_Model):
    """Values that are listed, combined or paired."""

    kind: Literal[LISTED] = "grid"  # type: ignore[valid-type]


class Sampled(_Model):
    """Points that are drawn over ranges."""

    kind: Literal[SAMPLED]  # type: ignore[valid-type]
    points: Annotated[StrictInt, Field(ge=1, le=MAX_POINTS)]
    seed: Annotated[StrictInt, Field(ge=0, le=2**32 - 1)] = 0


class Output(_Model):
    """What is kept."""

    cycles: Any = ()


def _by_name(value: object) -> object:
    """``design: zip`` is short for ``design: {kind: zip}``; without a kind it is a grid."""
    named = {"kind": "grid", **value} if isinstance(value, Mapping) else {"kind": value}
    if named["kind"] not in KINDS:
        raise refuse(f"must be one of {', '.join(KINDS)}")
    return named


class Sections(_Model):
    """A study of fretting wear: base values, varied values, output."""

    title: Annotated[
        StrictStr | None,
        Field(
            min_length=1,
            max_length=MAX_TITLE,
            description="For people; the name of the study is that of its file.",
        ),
    ] = None
    base: Annotated[
        dict[str, Any], Field(description="One value for every parameter that is not varied.")
    ] = {}
    vary: Annotated[
        dict[str, Any], Field(description="The varied parameters, each with its values.")
    ] = {}
    design: Annotated[
        Listed | Sampled,
        BeforeValidator(_by_name),
        Field(discriminator="kind", description="How the varied values are combined."),
    ] = Listed()
    invalid: Annotated[
        Literal["stop", "skip"], Field(description="What to do about points such as Q >= µP.")
    ] = "stop"
    batch: Annotated[
        Literal["auto"] | Annotated[StrictInt, Field(ge=1, le=MAX_POINTS)],
        Field(description="Cases of a job; auto: as many as take a few minutes."),
    ] = "auto"
    output: Output = Output()


NAMES = tuple(Sections.model_fields)


def read_sections(raw: Mapping[str, Any], problems: list[Problem]) -> Sections:
    """Read the sections; what is wrong is told, and stands as if it were left out."""
    sound = dict(raw)
    title = raw.get("title")
    if isinstance(title, str) and title.strip():
        if title.isprintable():
            sound["title"] = title.strip()
        else:
            del sound["title"]
            problems.append(Problem("title", title, "must be one line of printable text"))
    elif "title" in raw:
        del sound["title"]
        problems.append(Problem("title", title, "must be text", "put it in quotes"))
    while True:
        try:
            return Sections.model_validate(sound)
        except ValidationError as error:
            wrong: dict[str, Problem] = {}
            for details in error.errors(include_url=False):
                problem = _problem(details, raw)
                wrong.setdefault(problem.key, problem)
                sound.pop(str(details["loc"][0]), None)
            problems.extend(wrong.values())


def _problem(details: Mapping[str, Any], raw: Mapping[str, Any]) -> Problem:
    section, kind = str(details["loc"][0]), details["type"]
    value = raw.get(section)
    if section not in NAMES:
        rule = "is not a section of a study"
        if section in parameter_names():
            return Problem(section, value, rule, f"put it under base: base.{section}")
        remedy = f"known are {', '.join(NAMES)}"
        return Problem(section, value, rule, remedy, written=section, known=NAMES)
    match section:
        case "title":
            return Problem("title", value, f"must have at most {MAX_TITLE} characters")
        case "invalid":
            return Problem("invalid", value, "must be stop or skip")
        case "batch":
            rule = f"must be auto, or a whole number of cases from 1 to {MAX_POINTS}"
            remedy = "auto gives a job a few minutes of work"
            return Problem("batch", value, rule, remedy, written=value, known=("auto",))
        case "design":
            return _design_problem(details, raw[section])
        case "output" if kind == "extra_forbidden":
            name = str(details["loc"][1])
            key, given = f"output.{name}", details["input"]
            known = ("cycles",)
            return Problem(key, given, "is not known", "known is cycles", written=name, known=known)
    if raw[section] is None:
        return Problem(section, None, "is empty", f"leave {section} out, or fill it")
    return Problem(section, value, "must hold keys with values, one to a line")


def _design_problem(details: Mapping[str, Any], raw: object) -> Problem:
    given = raw if isinstance(raw, Mapping) else {"kind": raw}
    name = str(details["loc"][-1])
    if details["type"] == "fretwear":
        kind, key = given.get("kind"), "design.kind" if given is raw else "design"
        rule = f"must be one of {', '.join(KINDS)}"
        return Problem(key, kind, rule, written=kind, known=KINDS)
    kind = str(given.get("kind", "grid"))
    known = tuple(Sampled.model_fields) if kind in SAMPLED else ("kind",)
    if name not in known:
        rule, remedy = "is not known", f"{kind} knows {', '.join(known)}"
        return Problem(f"design.{name}", given[name], rule, remedy, written=name, known=known)
    if name not in given:
        rule = f"is missing: {kind} needs it"
        return Problem(f"design.{name}", None, rule, f"such as {name}: 64")
    least, most = (1, MAX_POINTS) if name == "points" else (0, 2**32 - 1)
    rule = f"must be a whole number from {least} to {most}"
    return Problem(f"design.{name}", given[name], rule)


def design_of(sections: Sections) -> Design:
    """Return the design of a study."""
    return Design(**sections.design.model_dump())


def study_schema() -> dict[str, Any]:
    """Return the JSON Schema (2020-12) of a study file, made from what reads it.

    It knows names, kinds of values and their descriptions.  What depends on several values at
    once (Q < µP, a cell fine enough for the roughness, equal lengths under ``zip``) is checked
    by `load_study` only.
    """
    schema = Sections.model_json_schema()
    definitions = schema["$defs"]
    base = {name: schema_of(name) for name in base_names()}
    properties = schema["properties"]
    properties["title"] = {**properties["title"].pop("anyOf")[0], **properties["title"]}
    properties["base"] |= {"additionalProperties": False, "properties": base}
    properties["vary"] |= {
        "additionalProperties": False,
        "properties": {name: _varied(name) for name in parameter_names()},
    }
    short = {"enum": list(LISTED)}
    listed = [definitions.pop(name) for name in ("Listed", "Sampled")]
    properties["design"] = {
        "description": properties["design"]["description"],
        "default": "grid",
        "anyOf": [short, *listed],
    }
    number = schema_of("output.cycles")
    properties["output"] = {
        "type": "object",
        "additionalProperties": False,
        "properties": {
            "cycles": {
                "type": "array",
                "items": number,
                "description": "Cycles at which the fields are kept.",
            }
        },
    }
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **_untitled(schema),
        "title": "fretwear study",
        "$defs": {},
        "allOf": schema_required(),
    }


def _varied(name: str) -> dict[str, Any]:
    value = schema_of(name)
    listed = {"type": "array", "items": value, "minItems": 1, "uniqueItems": True}
    if type(parameter_of(name)) is not Quantity:
        return listed
    interval = {
        "type": "object",
        "description": "A range, for sampled designs.",
        "additionalProperties": False,
        "required": ["from", "to"],
        "properties": {"from": value, "to": value, "scale": {"enum": ["linear", "log"]}},
    }
    return {"anyOf": [listed, interval]}


def _untitled(schema: Any) -> Any:
    """Drop the titles that pydantic makes of names: descriptions say more."""
    if isinstance(schema, list):
        return [_untitled(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    names = schema.get("properties", {})
    rest = {
        key: _untitled(item)
        for key, item in schema.items()
        if key not in ("title", "properties", "$defs") or not isinstance(item, str | dict)
    }
    if names:
        rest["properties"] = {key: _untitled(item) for key, item in names.items()}
    return rest
