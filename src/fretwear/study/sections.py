"""The sections of a study file: what each may hold, their schema, and changes from outside."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from fretwear.parts import Choice, keys_schema
from fretwear.study.case import SNAPSHOTS
from fretwear.study.members import PartOf
from fretwear.study.parameters import (
    base_names,
    parameter_names,
    parameter_of,
    replaced_by,
    schema_required,
)
from fretwear.study.points import MAX_POINTS, Design, Grid
from fretwear.study.problems import Problems
from fretwear.study.yamlfile import parse_value
from fretwear.units import QuantityError

NAMES = ("title", "base", "vary", "seeds", "design", "invalid", "batch", "output")
SEEDS = "roughness.seed"
"""What the section `seeds` varies."""
OPTION = "--set"
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
    places: Mapping[str, str] = field(default_factory=dict)  # of varied values not under `vary`


def read_sections(raw: Mapping[str, Any], problems: Problems) -> Sections:
    """Read the sections, and add what is wrong with them to the problems."""
    found: dict[str, Any] = {"design": None} if "design" in raw else {}
    for name, given in raw.items():
        if read := _READ.get(name):
            with problems.at(name, given):
                found[name] = read(given)
        elif name != "seeds":
            known = () if name in parameter_names() else NAMES
            hint = f"known are {', '.join(NAMES)}" if known else f"put it under base: base.{name}"
            problems.add(name, given, "is not a section of a study", hint, known, name)
    problems.unknown("output", found.get("output", {}), ("cycles",))
    vary = found.get("vary", {})
    if "seeds" in raw and (twice := [name for name in vary if name in (SEEDS, "roughness")]):
        rule = f"would vary what vary.{twice[0]} varies"
        problems.add("seeds", raw["seeds"], rule, "leave one of them out")
    elif "seeds" in raw:
        found |= {"vary": {**vary, SEEDS: raw["seeds"]}, "places": {SEEDS: "seeds"}}
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


def override(raw: Mapping[str, Any], assignments: Iterable[str]) -> tuple[dict[str, Any], Problems]:
    """Apply assignments ``name=value`` to the plain content of a study file.

    The value replaces that in `base`, and the parameter is no longer varied. Setting one of several
    alternative keys, such as the two tangential ones, drops the others; keys that belong to both,
    such as `rig_stiffness`, stay. ``output.cycles`` and ``title`` can be set too. Returned are a
    changed copy, whose values are not checked yet, and what was wrong with the assignments.
    """
    changed, problems = copy.deepcopy(dict(raw)), Problems()
    known = (*parameter_names(), "output.cycles", "title")
    for assignment in assignments:
        name, equals, text = assignment.partition("=")
        name = name.strip()
        place = f"{OPTION} {name}"
        if not equals:
            rule = "must have the form name=value"
            problems.add(OPTION, assignment, rule, "such as --set 'load=30 N'")
        elif name not in known:
            problems.add(place, text, "is not a parameter", known=known, written=name)
        else:
            with problems.at(place, text):
                value = parse_value(text)
                with problems.at(place, value):
                    assign(changed, name, value)
    return changed, problems


def assign(content: dict[str, Any], name: str, value: Any) -> None:
    """Give a parameter one value in the plain content of a study file, as for `override`."""
    if name in ("title", "output.cycles"):
        section, _, key = name.partition(".")
        content[section] = {key: value} if key else value
        return
    present = (content.get(section) for section in ("base", "vary"))
    base, vary = (dict(each) if isinstance(each, Mapping) else {} for each in present)
    content |= {"base": base, "vary": vary}
    gone = replaced_by(name)
    for other in gone:
        base.pop(other, None)
    for varied in [*vary]:
        if any(f"{varied}.".startswith(f"{each}.") for each in (*gone, name)):
            del vary[varied]
    if SEEDS in (name, f"{name}.seed"):
        content.pop("seeds", None)
    whole, _, part = name.partition(".")
    if part and whole in vary:
        raise QuantityError(f"cannot be set while vary.{whole} varies the whole of it")
    if part:
        given = base.get(whole)
        value = {**(given if isinstance(given, Mapping) else {}), part: value}
    base[whole] = value
    if not vary:
        del content["vary"]
        if "seeds" not in content:
            # A sampled design without anything to sample would be an error of its own.
            content.pop("design", None)


def study_schema() -> dict[str, Any]:
    """Return the JSON Schema (2020-12) of a study file, made from what reads it.

    It covers names, kinds of values and their descriptions. Rules on several values at once (Q <
    µP, a cell fine enough for the roughness, equal lengths under ``zip``) is checked by
    `load_study` only.
    """
    whole = {"type": "integer", "minimum": 1, "maximum": MAX_POINTS}
    title = {"type": "string", "minLength": 1, "maxLength": MAX_TITLE}
    base = {name: parameter_of(name).described() for name in base_names()}
    vary = {name: _varied(name) for name in parameter_names()}
    sections = {
        "title": _about("For people; the name of the study is that of its file.", title),
        "base": _about("One value for every parameter that is not varied.", keys_schema(base)),
        "vary": _about("The varied parameters, each with its values.", keys_schema(vary)),
        "seeds": _about(f"Short for {SEEDS} under vary.", _varied(SEEDS)),
        "design": {**_DESIGN.described(), "default": "grid"},
        "invalid": {**_INVALID.described(), "default": "stop"},
        "batch": {
            "description": "Cases of a job; auto: as many as take a few minutes.",
            "default": "auto",
            "anyOf": [{"const": "auto"}, whole],
        },
        "output": keys_schema({"cycles": SNAPSHOTS.described()}),
    }
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "fretwear study",
        "description": "A study of fretting wear: base values, varied values, output.",
        **keys_schema(sections),
        "allOf": schema_required(),
    }


def _about(description: str, content: Mapping[str, Any]) -> dict[str, Any]:
    return {"description": description, **content}


def _varied(name: str) -> dict[str, Any]:
    value = parameter_of(name).described()
    listed = {"type": "array", "items": value, "minItems": 1, "uniqueItems": True}
    if not parameter_of(name).may_be_drawn:
        return listed
    ends = {"from": value, "to": value, "scale": {"enum": ["linear", "log"]}}
    interval = _about("A range, for sampled designs.", keys_schema(ends, ["from", "to"]))
    return {"anyOf": [listed, interval]}
