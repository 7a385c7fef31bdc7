"""The sections of a study file: what each holds, and its schema for editors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, cast

from fretwear.parts import Choice, keys_schema
from fretwear.plugins import plugins, study_sections
from fretwear.problems import Problems, in_words
from fretwear.study.case import SNAPSHOTS_SCHEMA
from fretwear.study.materials import DESCRIPTION, MATERIAL, material_table, with_materials
from fretwear.study.members import PartOf
from fretwear.study.parameters import (
    base_names,
    missing_parameters,
    parameter_names,
    parameter_of,
    read_values,
    schema_required,
    section_names,
    with_parts_of_distance,
)
from fretwear.study.points import MAX_POINTS, Axis, Combinations, Design
from fretwear.study.yamlfile import as_mapping
from fretwear.units import QuantityError, listed

_OF_SNAPSHOTS = {"snapshots", "frames", "every", "times"}
_OF_DESIGNS = ("points", "samples", "n_samples")
SEEDS = "roughness.seed"
"""The parameter that the section `seeds` varies."""
MAX_TITLE = 200
_DESIGN = PartOf(
    Design,
    "design",
    example="{kind: latin_hypercube, points: 64, seed: 1}",
    description="How the varied values are combined.",
    may_be_partial=False,
)
_INVALID = Choice("", "", ("stop", "skip"), description="What to do about points such as Q >= µP.")


@dataclass(frozen=True)
class Sections:
    """The sections of a study file; invalid ones count as left out."""

    title: str = ""
    base: Mapping[str, object] = field(default_factory=dict)
    vary: Mapping[str, object] = field(default_factory=dict)
    design: Design | None = Combinations()  # noqa: RUF009 - frozen; None where it could not be read
    invalid: str = "stop"
    batch: int | None = None
    output: Mapping[str, object] = field(default_factory=dict)


def read_sections(raw: Mapping[str, object], problems: Problems) -> Sections:
    """Read the sections, and add their problems."""
    sections: dict[str, Any] = {"design": None} if "design" in raw else {}
    loose = [name for name in raw if name in base_names() and not isinstance(raw[name], list)]
    if is_flat := "base" not in raw and len(loose) > 1:
        rule = f"is missing, and {listed(loose)} stand outside of it"
        problems.add("base", None, rule, "write base: above them, and indent them")
    for name, given in raw.items():
        if is_flat and name in loose:
            continue
        if name not in section_names():
            valid = () if name in parameter_names() else section_names()
            where = "vary" if isinstance(given, list) else "base"
            hint = (
                f"known are {', '.join(valid)}"
                if valid
                else f"put it under {where}: {where}.{name}"
            )
            if name in _OF_DESIGNS:
                valid, hint = (
                    (),
                    f"write design: {{kind: latin_hypercube, points: {in_words(given)}}}",
                )
            rule = "is not a section of a study"
            problems.add(name, given, rule, hint, valid_words=valid, written=name)
        elif name != "seeds" and name not in plugins("fretwear.study_sections"):
            with problems.at(name, given):
                sections[name] = _read_section(name, given)
    output = dict(sections.get("output", {}))
    for name in _OF_SNAPSHOTS & output.keys():
        hint = "write cycles, a list of those at which fields are kept"
        problems.add(f"output.{name}", output.pop(name), "is not known", hint)
    added = [place.partition(".")[2] for place in plugins("fretwear.study_sections")]
    problems.unknown("output", output, ("cycles", *filter(None, added)))
    vary = sections.get("vary", {})
    if "seeds" in raw and (twice := [name for name in vary if name in (SEEDS, "roughness")]):
        rule = f"would vary the same as vary.{twice[0]}"
        problems.add("seeds", raw["seeds"], rule, "leave one of them out")
    elif "seeds" in raw:
        sections["vary"] = {**vary, SEEDS: raw["seeds"]}
    return Sections(**sections)


_SUCH_AS = {
    "output": "write output: {cycles: [0, 1000]}",
    "vary": "write vary: {load: [20 N, 50 N]}",
    "base": "write base: {radius: 10 mm, load: 50 N, ...}",
}


def _read_section(name: str, given: object) -> object:
    if name in ("design", "invalid"):
        return (_DESIGN if name == "design" else _INVALID).read(given, True)
    if name == "title":
        if given is None:
            raise QuantityError("has no value", "write a title, or leave the line out")
        if not isinstance(given, str) or not given.strip():
            raise QuantityError("must be text", "put it in quotes")
        if not given.isprintable():
            raise QuantityError("must be one line of printable text")
        if len(given.strip()) > MAX_TITLE:
            raise QuantityError(f"must have at most {MAX_TITLE} characters")
        return given.strip()
    if name == "batch":
        if given != "auto" and not (type(given) is int and 1 <= given <= MAX_POINTS):
            rule = f"must be auto, or a whole number of cases from 1 to {MAX_POINTS}"
            raise QuantityError(rule, "auto gives a job a few minutes of work", ("auto",))
        return None if given == "auto" else given
    if given is None:
        raise QuantityError("is empty", "leave it out, or fill it")
    if not isinstance(given, Mapping):
        hint = _SUCH_AS.get(name, "")
        if isinstance(given, list) and all(isinstance(item, Mapping) for item in given):
            hint = "leave out the dashes"
        raise QuantityError("must hold keys with values, one to a line", hint)
    return given


def read_base(
    sections: Sections,
    axes: tuple[Axis, ...],
    content: Mapping[str, object],
    problems: Problems,
) -> dict[str, object]:
    """Read the fixed values; of a part with varied fields, read the other fields.

    The value that base may have for a varied parameter is not used.
    """
    varied = [name for name in sections.vary if name in parameter_names()]
    base, parts = with_materials(sections.base, problems, "base.", varied), dict[str, list[str]]()
    base = with_parts_of_distance(base, varied)
    for name in varied:
        whole, _, part_field = name.partition(".")
        if part_field and whole not in sections.vary:
            base.setdefault(whole, {})
            parts.setdefault(whole, []).append(part_field)
    read = read_values(base, "base.", problems, units_required=True, varied=parts)
    of_points: list[Any] = [read.get("blocks", ())]
    for axis in axes:
        of_points = [*axis.values] if axis.name == "blocks" else of_points
    blocks = [block for of_point in of_points for block in of_point]
    # What stands in the wrong place has a problem already, and is not missing.
    misplaced = {name for name in content if name not in section_names()}
    misplaced |= {key for name in misplaced for key in as_mapping(content[name])}
    missing = [*missing_parameters({*base, *varied, *misplaced}, blocks)]
    are_wrong = not all(isinstance(content.get(name, {}), Mapping) for name in ("base", "vary"))
    if are_wrong or any(problem.key == "base" for problem in problems):
        missing = []
    elif "base" not in content and len(missing) > 1:
        examples = [f"{problem.key}: {parameter_of(problem.key).example}" for problem in missing]
        problems.add("base", None, "is missing", f"such as base: {{{', '.join(examples)}}}")
        missing = []
    for problem in missing:
        key = f"vary.{problem.key}" if problem.key in sections.vary else f"base.{problem.key}"
        problems.append(replace(problem, key=key, given=sections.base.get(problem.key)))
    read_names = {axis.name for axis in axes}
    for whole, fields in parts.items():
        if (part := read.get(whole)) is None:
            continue
        of_kind = [*part.parameters()]
        for foreign in (name for name in fields if name not in of_kind):
            name, rule = f"{whole}.{foreign}", f"{foreign} is not a parameter of {part.kind}"
            given, remedy = sections.vary[name], f"it has {', '.join(of_kind)}"
            about = cast("PartOf", parameter_of(whole))
            if having := [n for n, kind in about.kinds.items() if foreign in kind.parameters()]:
                remedy += f"; kind: {having[0]} has {foreign}"
            problems.add(f"vary.{name}", given, rule, remedy, valid_words=of_kind, written=foreign)
        if not all(name in of_kind and f"{whole}.{name}" in read_names for name in fields):
            del read[whole]
    return {name: value for name, value in read.items() if name not in varied}


def study_schema() -> dict[str, object]:
    """Return the JSON Schema (2020-12) of a study file, made from the declarations that read it.

    It covers names, kinds of values and their descriptions. Only `load_study` checks rules on
    several values at once (Q < µP, a cell fine enough for the roughness, equal lengths under
    ``zip``).
    """
    whole = {"type": "integer", "minimum": 1, "maximum": MAX_POINTS}
    title = {"type": "string", "minLength": 1, "maxLength": MAX_TITLE}
    base = {name: parameter_of(name).described() for name in base_names()}
    name = {"enum": [*material_table()]}
    two = {"type": "array", "items": name, "minItems": 2, "maxItems": 2}
    base[MATERIAL] = _about(DESCRIPTION, {"anyOf": [name, two]})
    vary = {name: _varied(name) for name in parameter_names()}
    sections = {
        "title": _about("For people; the study takes its name from the file.", title),
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
    }
    output: dict[str, object] = {"cycles": SNAPSHOTS_SCHEMA}
    for place, reader in study_sections():
        *outer, key = place.split(".")
        (output if outer else sections)[key] = reader.section_schema()
    sections["output"] = keys_schema(output)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "fretwear study",
        "description": "A study of fretting wear: base values, varied values, output.",
        **keys_schema(sections),
        "allOf": schema_required(),
    }


def _about(description: str, content: Mapping[str, object]) -> dict[str, object]:
    return {"description": description, **content}


def _varied(name: str) -> dict[str, object]:
    value = parameter_of(name).described()
    listed = {"type": "array", "items": value, "minItems": 1, "uniqueItems": True}
    if not parameter_of(name).may_be_drawn:
        return listed
    ends = {"from": value, "to": value, "scale": {"enum": ["linear", "log"]}}
    interval = _about("A range, for sampled designs.", keys_schema(ends, ["from", "to"]))
    return {"anyOf": [listed, interval]}
