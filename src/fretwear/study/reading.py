"""From a YAML file to a study, with all problems reported at once."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, StringConstraints

from fretwear.plugins import StudySection, plugins, study_sections
from fretwear.quantity import AUTO, PartOf, Schema, auto_or, inlined
from fretwear.study.case import Case
from fretwear.study.contact import case_keys
from fretwear.study.cycles import Snapshots, with_parts_of_distance
from fretwear.study.designs import MAX_POINTS, Axis, Combinations, Design, read_axes
from fretwear.study.materials import DESCRIPTION, MATERIAL, material_table, with_materials
from fretwear.study.problems import Problem, Problems, StudyError, few_of
from fretwear.study.rules import findings
from fretwear.study.study import Point, Study, as_mapping
from fretwear.study.yamlfile import parse_value, read_document
from fretwear.units import QuantityError, did_you_mean

OPTION = "--set"
MAX_TITLE = 200
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,99}")
_Text = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1)]


class Output(BaseModel):
    """What is written beside the results; packages beside the core may add keys."""

    model_config = ConfigDict(extra="allow")

    cycles: Snapshots = None


class Sections(BaseModel):
    """The sections of a study file."""

    model_config = ConfigDict(extra="forbid")

    title: Annotated[
        str,
        StringConstraints(strip_whitespace=True, min_length=1, max_length=MAX_TITLE),
        Field(description="For people; the study takes its name from the file."),
    ] = ""
    base: Annotated[
        dict[str, Any], Field(description="One value for every parameter that is not varied.")
    ] = {}
    vary: Annotated[
        dict[str, Any], Field(description="The varied parameters, each with its values.")
    ] = {}
    design: Annotated[
        Design, PartOf(Design, "design", like="grid", description="How varied values combine.")
    ] = Combinations()
    invalid: Annotated[
        Literal["stop", "skip"], Field(description="What to do about points such as Q >= µP.")
    ] = "stop"
    batch: Annotated[
        int | None,
        Field(ge=1, le=MAX_POINTS, description="Cases of a job; auto: as many as take minutes."),
        AUTO,
        auto_or({"type": "integer", "minimum": 1}),
        Field(json_schema_extra={"default": "auto"}),
    ] = None
    output: Output = Output()
    creator: Annotated[_Text, Field(description="Who made the study, for its datasets.")] = ""
    license: Annotated[_Text, Field(description="License of the results.")] = ""
    institution: Annotated[_Text, Field(description="Where the study was made.")] = ""
    references: Annotated[_Text, Field(description="Publications about the study.")] = ""


def load_study(
    path: str | Path,
    assignments: Sequence[str] = (),
) -> Study:
    """Read and check a study file (YAML), changed by assignments ``name=value``.

    Raises
    ------
    StudyError
        If the file or the assignments are invalid; the message lists all problems.
    """
    file = Path(path)
    document = read_document(file)
    problems = Problems(document.problems)
    if not _NAME.fullmatch(file.stem):
        rule = "must have up to 100 letters, digits, '.', '_' and '-', a letter or digit first"
        problems.add("", None, f"the name of the file {rule}")
    if not isinstance(document.data, Mapping):
        raise StudyError(file, [Problem("", document.data, "must hold keys such as base and vary")])
    return _checked(file, document.data, assignments, problems, document.lines)


def select_point(
    study: Study, case_id: str | None = None, assignments: Sequence[str] = ()
) -> Point:
    """Return the point of a case, changed by assignments ``name=value``.

    An id, or the beginning of exactly one id, chooses the case, to which the assignments are then
    applied. Without an id the study must have a single case. Raises `StudyError` if the changed
    case is invalid, or there is no such case.
    """
    points = {point.id: point for point in study.points() if point.id}
    matching = [n for n in points if n.startswith(case_id or "")]
    if case_id in points:
        matching = [case_id]
    if len(matching) != 1:
        rule = f"chooses {len(matching)} of the {len(points)} cases of this study"
        hint = "".join(["give --case ID, one of", *(f"\n    {n}" for n in few_of(matching))])
        if not matching:
            hint = did_you_mean(case_id, points) or "fretwear plan lists the cases"
        raise StudyError(study.file, [Problem("--case", case_id, rule, hint)])
    point = points[matching[0]]
    if case_id and assignments:
        (point,) = _checked(study.file, content_of(point), assignments).points()
    return point


def content_of(point: Point) -> dict[str, Any]:
    """The plain content of a study that has a single point."""
    content = {**point.study.content}
    for axis, position in zip(point.study.axes, point.index, strict=True):
        assign(content, axis.name, axis.written[position])
    return {key: value for key, value in content.items() if key not in point.study.added}


def case_of_content(file: Path, content: Mapping[str, Any]) -> Case:
    """The case of the plain content of a study of a single point; `StudyError` if it is invalid."""
    (point,) = _checked(file, content, ()).points()
    assert point.case is not None
    return point.case


def override(raw: Mapping[str, Any], assignments: Iterable[str]) -> tuple[dict[str, Any], Problems]:
    """Return plain content changed by assignments ``name=value``, and problems of the assignments.

    The new value replaces the value in `base`, and the parameter is no longer varied. Setting one
    of several alternative keys, such as the two tangential ones, drops the others; keys that belong
    to both, such as `rig_stiffness`, stay. ``output.cycles`` and ``title`` can be set too.
    """
    changed, problems = {**raw}, Problems()
    valid = (*case_keys().all_names, MATERIAL, "output.cycles", "title")
    for assignment in assignments:
        name, equals, text = assignment.partition("=")
        name = name.strip()
        if not equals:
            problems.add(OPTION, assignment, "must have the form name=value")
        elif name not in valid:
            problems.unknown(f"{OPTION} {name}", text, valid, "is not a parameter")
        else:
            with problems.at(f"{OPTION} {name}", text):
                assign(changed, name, parse_value(text))
    return changed, problems


def assign(content: dict[str, Any], name: str, value: object) -> None:
    """Give a parameter one value in the plain content of a study file, as for `override`."""
    whole, _, part = name.partition(".")
    if whole in ("title", "output"):
        content[whole] = {**as_mapping(content.get(whole)), part: value} if part else value
        return
    gone = case_keys().replaced_by(name)
    replaced = tuple(f"{key}." for key in (*gone, name))
    base, vary = (as_mapping(content.get(section)) for section in ("base", "vary"))
    base = {key: given for key, given in base.items() if key not in gone}
    vary = {key: given for key, given in vary.items() if not f"{key}.".startswith(replaced)}
    if part and whole in vary:
        raise QuantityError(f"cannot be set while vary.{whole} varies the whole of it")
    base[whole] = {**as_mapping(base.get(whole)), part: value} if part else value
    content |= {"base": base, "vary": vary}
    if not vary:  # a sampled design with nothing to sample would be an error
        content.pop("design", None)


def _checked(
    file: Path,
    given: Mapping[str, Any],
    assignments: Sequence[str],
    before: Sequence[Problem] = (),
    lines: Mapping[str, int] | None = None,
) -> Study:
    """Turn the plain content of a study file, changed by assignments, into a `Study`."""
    folder, (content, problems) = file.parent, override(given, assignments)
    problems[:0] = before
    content, added = _with_added(content, folder, problems)
    sections = _sections(content, folder, problems)
    axes = read_axes(sections.vary, sections.design, folder, problems)
    fixed = _read_base(sections.base, sections.vary, axes, folder, problems)
    snapshots = sections.output.cycles
    if needed := [section.cycles for section in added.values() if section.cycles is not None]:
        snapshots = tuple(sorted({*(snapshots or ()), *chain(*needed)}))
    title = sections.title or file.stem
    settings = snapshots, sections.batch, added
    study = Study(file, title, axes, sections.design, fixed, content, *settings)
    if len(axes) == len(sections.vary) and not any(map(_is_of_case, problems)):
        _try_points(study, problems, sections.invalid == "skip")
    else:  # cases cannot be made, but what is missing or redundant is known
        names = [name.partition(".")[0] for name in sections.vary]
        written = _long_form(sections.base, sections.vary, Problems())
        found = Problems()
        case_keys().members_of(fixed, {*written, *names}, found)
        problems += [replace(one, key=f"base.{one.key}") for one in found]
    if not problems and len(study.invalid) == study.size:
        problems.add("vary", None, f"leaves no point to run: {next(iter(study.invalid.values()))}")
    for section in added.values() if not problems else ():
        section.check([point.case for point in study.points()], problems)
    if problems:
        raise StudyError(file, _in_order(problems, lines or {}, assignments))
    return study


def _with_added(
    content: dict[str, Any], folder: Path, problems: Problems
) -> tuple[dict[str, Any], dict[str, StudySection]]:
    """The content with a completed `base`, and what packages beside the core read of it."""
    added = {}
    for place, reader in study_sections():
        *outer, key = place.split(".")
        around = as_mapping(content.get(outer[0])) if outer else content
        if key not in around:
            continue
        with problems.at(place, around[key]):
            added[place] = reader.read(around[key], folder)
        base, vary = (as_mapping(content.get(section)) for section in ("base", "vary"))
        if (completed := reader.complete_base(around[key], base, vary, problems)) is not base:
            content = {**content, "base": completed}
    return content, added


def _is_of_case(problem: Problem) -> bool:
    """Whether a problem keeps cases from being made; unknown names do not."""
    return "is not a case parameter" not in problem.rule and problem.key.startswith(
        ("base", "vary", OPTION, "design")
    )


def _sections(content: Mapping[str, Any], folder: Path, problems: Problems) -> Sections:
    """Read the sections; invalid ones count as left out."""
    places = plugins("fretwear.study_sections")
    known, right = [*Sections.model_fields, *places], dict[str, Any]()
    for name, given in content.items():
        if name not in known:
            problems.unknown(name, given, known, "is not a section of a study")
        elif name in Sections.model_fields:
            with problems.at("", given):
                read = Sections.model_validate({name: given}, context=folder)
                right[name] = getattr(read, name)
    for name in as_mapping(content.get("output")):
        if f"output.{name}" not in ("output.cycles", *places):
            inner = [place.partition(".")[2] for place in ("output.cycles", *places)]
            problems.unknown(f"output.{name}", None, inner)
    return Sections.model_construct(**right)


def _long_form(
    base: Mapping[str, Any], vary: Mapping[str, Any], problems: Problems
) -> dict[str, Any]:
    """The keys of `base` with all that a material and a sliding distance stand for."""
    return with_parts_of_distance(with_materials(base, problems, vary), vary)


def _read_base(
    base: Mapping[str, Any],
    vary: Mapping[str, Any],
    axes: Sequence[Axis],
    folder: Path,
    problems: Problems,
) -> dict[str, Any]:
    """Read the fixed values; a part with varied fields has their first values.

    The value that base may have for a varied parameter is not used.
    """
    found = Problems()
    given = _long_form(base, vary, found)
    first = {axis.name: axis.written[0] for axis in axes}
    varied = [name for name in vary if "." in name and name.partition(".")[0] not in vary]
    for name in varied:
        whole, _, field = name.partition(".")
        written = given.get(whole, {})
        content = {"kind": written} if isinstance(written, str) else as_mapping(written)
        kept = {key: value for key, value in content.items() if key != field}
        given[whole] = {**kept, field: first[name]} if name in first else kept
    fixed = case_keys().read_values(given, found, folder)
    for one in found:
        if one.key not in varied:
            problems.append(replace(one, key=f"base.{one.key}"))
        elif one.key in first:  # otherwise told where it is varied
            problems.append(replace(one, key=f"vary.{one.key}"))
    return {name: value for name, value in fixed.items() if name not in vary}


def _try_points(study: Study, problems: Problems, skip: bool) -> None:
    """Check the rules between parameters; with `skip`, mark points that break one as invalid.

    A broken rule is told once, for the first point.
    """
    broken: dict[tuple[str, str], list[tuple[Problem, str]]] = {}
    for point in study.points():
        case, found = point.unchecked
        wrong = findings(case) if case is not None else found
        if wrong and skip and study.axes:
            study.invalid[point.index] = wrong[0].sentence
        elif wrong:
            for problem in wrong:
                placed, where = _placed(problem, point)
                kind = placed.key.partition("[")[0], re.sub(r"[\d.e+-]+", "#", problem.rule)
                broken.setdefault(kind, []).append((placed, where))
    for (first, where), *others in broken.values():
        more = f" and at {len(others)} more points" if others else ""
        is_everywhere = not where or len(others) + 1 == study.size
        rule = first.rule if is_everywhere else f"{first.rule} (at {where}{more})"
        problems.append(replace(first, rule=rule))


def _placed(problem: Problem, point: Point) -> tuple[Problem, str]:
    """The problem of a point at the key of the file that has the value, and the other values."""
    name = problem.key
    key = "output.cycles" if name == "output_cycles" else f"base.{name}"
    others = []
    for axis, position in zip(point.study.axes, point.index, strict=True):
        if f"{name}.".startswith(f"{axis.key}."):
            key = f"vary.{axis.name}" + (f"[{position}]" if axis.drawn_from is None else "")
        else:
            others.append(f"{axis.name} = {axis.labels[position]}")
    return replace(problem, key=key), ", ".join(others)


def _in_order(
    problems: Iterable[Problem], lines: Mapping[str, int], assignments: Sequence[str]
) -> list[Problem]:
    """Give problems the line of their key or the option that set it, and sort them by line."""
    names = [assignment.partition("=")[0].strip() for assignment in assignments]
    shown = {place: f"{OPTION} {name}" for name in names for place in (f"base.{name}", name)}
    told: dict[tuple[str, str], Problem] = {}
    for problem in problems:
        key = problem.key
        for place, name in shown.items():
            if f"{key}.".startswith((f"{place}.", f"{place}[")):
                key = name + key.removeprefix(place)
        line, at = problem.line or lines.get(key), key
        while line is None and at:  # the line of the whole that lacks a key
            at = at[: max(at.rfind("."), at.rfind("["), 0)]
            line = lines.get(at) if at else None
        told[key, problem.rule] = replace(problem, key=key, line=line)
    return sorted(told.values(), key=lambda one: one.line or len(lines) * 1000)


def study_schema() -> Schema:
    """Return the JSON Schema (2020-12) of a study file, made from the models that read it.

    It covers names, kinds of values and their descriptions. Only `load_study` checks rules on
    several values at once (Q < µP, a cell fine enough for the roughness, equal lengths under
    ``zip``).
    """
    schema = inlined(Sections.model_json_schema())
    name = {"enum": [*material_table(), *(int(n) for n in material_table() if n.isdigit())]}
    two = {"type": "array", "items": name, "minItems": 2, "maxItems": 2}
    keys = case_keys()
    base = {key: keys.value_schema(key) for key in keys.names}
    base[MATERIAL] = {"description": DESCRIPTION, "anyOf": [name, two]}
    sections = schema["properties"]
    closed = {"type": "object", "additionalProperties": False}
    sections["base"] |= {**closed, "properties": base}
    sections["vary"] |= {**closed, "properties": {n: _varied(n) for n in keys.all_names}}
    for place, reader in study_sections():
        *outer, key = place.split(".")
        (sections[outer[0]]["properties"] if outer else sections)[key] = reader.section_schema()
    sections["output"]["additionalProperties"] = False
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **schema,
        "title": "fretwear study",
        "description": "A study of fretting wear: base values, varied values, output.",
    }


def _varied(name: str) -> Schema:
    value = case_keys().value_schema(name)
    listed = {"type": "array", "items": value, "minItems": 1}
    if not case_keys()[name].about.may_be_drawn:
        return listed
    ends = {"from": value, "to": value, "scale": {"enum": ["linear", "log"]}}
    interval = {"type": "object", "additionalProperties": False, "properties": ends}
    return {"anyOf": [listed, {**interval, "required": ["from", "to"]}]}
