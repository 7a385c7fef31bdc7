"""JSON Schema of the study file, for editors, made from the same fields that read it."""

from __future__ import annotations

from typing import Any

from fretwear.study.case import OPTIONAL_IN_FILES, Case
from fretwear.study.checks import TANGENTIAL
from fretwear.study.designs import LISTED, MAX_POINTS, SAMPLED
from fretwear.study.parameters import ROUGHNESS, case_fields, parameter_fields, quantity_of
from fretwear.study.sections import MAX_TITLE


def study_schema() -> dict[str, Any]:
    """Return the JSON Schema (2020-12) of a study file.

    It knows names, kinds of values and their descriptions.  What depends on several values at
    once (Q < µP, a cell fine enough for the roughness, equal lengths under ``zip``) is checked
    by `load_study` only.
    """
    case = Case.model_json_schema(ref_template="#/$defs/{model}")
    properties = case["properties"]
    base = {name: _for_files(properties[name]) for name in case_fields()}
    base[ROUGHNESS] = {
        "description": base[ROUGHNESS]["description"],
        "anyOf": [{"const": "none"}, {"$ref": "#/$defs/WavyRoughness"}],
    }
    roughness = _for_files(case["$defs"]["WavyRoughness"])
    parts = {f"{ROUGHNESS}.{name}": part for name, part in roughness["properties"].items()}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "fretwear study",
        "description": "A study of fretting wear: base values, varied values, output.",
        "type": "object",
        "additionalProperties": False,
        "properties": {
            "title": {
                "type": "string",
                "minLength": 1,
                "maxLength": MAX_TITLE,
                "description": "For people; the name of the study is that of its file.",
            },
            "base": {
                "type": "object",
                "description": "One value for every parameter that is not varied.",
                "additionalProperties": False,
                "properties": base,
            },
            "vary": {
                "type": "object",
                "description": "The varied parameters, each with its values.",
                "additionalProperties": False,
                "properties": {
                    name: _varied(name, value) for name, value in {**base, **parts}.items()
                },
            },
            "design": _design(),
            "invalid": {
                "enum": ["stop", "skip"],
                "default": "stop",
                "description": "What to do about points such as Q >= µP.",
            },
            "batch": {
                "description": "Cases of a job; auto: as many as take a few minutes.",
                "default": "auto",
                "anyOf": [
                    {"const": "auto"},
                    {"type": "integer", "minimum": 1, "maximum": MAX_POINTS},
                ],
            },
            "output": {
                "type": "object",
                "additionalProperties": False,
                "properties": {"cycles": _for_files(properties["output_cycles"])},
            },
        },
        "allOf": [
            *(_given(name) for name in case_fields() if _is_required(name)),
            {"oneOf": [_given(name) for name in TANGENTIAL]},
        ],
        "$defs": {"WavyRoughness": roughness},
    }


def _is_required(name: str) -> bool:
    return name not in TANGENTIAL and name not in OPTIONAL_IN_FILES


def _given(name: str) -> dict[str, Any]:
    """A parameter, or a part of it, stands in base or in vary."""
    parts = [part for part in parameter_fields() if part == name or part.startswith(f"{name}.")]
    places = [("base", name), *(("vary", part) for part in parts)]
    return {
        "anyOf": [
            {"required": [section], "properties": {section: {"required": [key]}}}
            for section, key in places
        ]
    }


def _for_files(schema: Any) -> Any:
    """Rewrite a schema of Python values into one of files, which know no null and no default."""
    if isinstance(schema, list):
        return [_for_files(item) for item in schema if item != {"type": "null"}]
    if not isinstance(schema, dict):
        return schema
    left_out = {"title", "required", "default"}
    rewritten = {key: _for_files(item) for key, item in schema.items() if key not in left_out}
    if "properties" in schema:
        rewritten["properties"] = {
            key: _for_files(item) for key, item in schema["properties"].items()
        }
    choices = rewritten.pop("anyOf", [])
    return {**choices[0], **rewritten} if len(choices) == 1 else _with(rewritten, choices)


def _with(schema: dict[str, Any], choices: list[Any]) -> dict[str, Any]:
    return {**schema, "anyOf": choices} if choices else schema


def _varied(name: str, value: dict[str, Any]) -> dict[str, Any]:
    listed = {"type": "array", "items": value, "minItems": 1, "uniqueItems": True}
    if quantity_of(name) is None:
        return listed
    interval = {
        "type": "object",
        "description": "A range, for sampled designs.",
        "additionalProperties": False,
        "required": ["from", "to"],
        "properties": {"from": value, "to": value, "scale": {"enum": ["linear", "log"]}},
    }
    return {"anyOf": [listed, interval]}


def _design() -> dict[str, Any]:
    return {
        "description": "How the varied values are combined.",
        "default": "grid",
        "anyOf": [
            {"enum": list(LISTED)},
            {
                "type": "object",
                "additionalProperties": False,
                "required": ["kind"],
                "properties": {"kind": {"enum": list(LISTED)}},
            },
            {
                "type": "object",
                "additionalProperties": False,
                "required": ["kind", "points"],
                "properties": {
                    "kind": {"enum": list(SAMPLED)},
                    "points": {"type": "integer", "minimum": 1, "maximum": MAX_POINTS},
                    "seed": {"type": "integer", "minimum": 0},
                },
            },
        ],
    }
