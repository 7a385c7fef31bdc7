"""From a YAML file to a study, with all problems reported at once."""

from __future__ import annotations

import copy
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, StringConstraints

from fretwear.plugins import StudySection, plugins, study_sections
from fretwear.quantity import PartOf, Schema, inlined, required
from fretwear.study.case import Case
from fretwear.study.contact import (
    SNAPSHOTS_SCHEMA,
    case_keys,
    read_snapshots,
    with_parts_of_distance,
)
from fretwear.study.designs import MAX_POINTS, Combinations, Design, Sampled, read_axes
from fretwear.study.materials import DESCRIPTION, MATERIAL, material_table, with_materials
from fretwear.study.plan import Plan, PlannedCases
from fretwear.study.problems import Problem, Problems, StudyError, few_of
from fretwear.study.rules import findings
from fretwear.study.study import ALL_POINTS, Point, Study, as_mapping
from fretwear.study.yamlfile import parse_value, read_document
from fretwear.units import QuantityError, did_you_mean

OPTION = "--set"
SEEDS = "roughness.seed"
"""The parameter that the section `seeds` varies."""
MAX_TITLE = 200
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,99}")
_LISTED_PER_RULE = 8
_Text = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1)]


class Output(BaseModel):
    """What is written beside the results; packages beside the core may add keys."""

    model_config = ConfigDict(extra="allow")

    cycles: Annotated[Any, Field(json_schema_extra=SNAPSHOTS_SCHEMA)] = "auto"


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
    seeds: Annotated[Any, Field(description=f"Short for {SEEDS} under vary.")] = None
    design: Annotated[
        Design, PartOf(Design, "design", like="grid", description="How varied values combine.")
    ] = Combinations()
    invalid: Annotated[
        Literal["stop", "skip"], Field(description="What to do about points such as Q >= µP.")
    ] = "stop"
    batch: Annotated[
        Literal["auto"] | Annotated[int, Field(ge=1, le=MAX_POINTS)],
        Field(description="Cases of a job; auto: as many as take a few minutes."),
    ] = "auto"
    output: Output = Output()
    creator: Annotated[_Text, Field(description="Who made the study, for its datasets.")] = ""
    license: Annotated[_Text, Field(description="License of the results.")] = ""
    institution: Annotated[_Text, Field(description="Where the study was made.")] = ""
    references: Annotated[_Text, Field(description="Publications about the study.")] = ""


def section_names() -> tuple[str, ...]:
    """The sections that a study file may have."""
    added = plugins("fretwear.study_sections")
    return *Sections.model_fields, *(place for place in added if "." not in place)


def load_study(
    path: str | Path,
    assignments: Sequence[str] = (),
    *,
    points: tuple[int, int | None] = ALL_POINTS,
    visit: Callable[[Point], None] | None = None,
) -> Study:
    """Read and check a study file (YAML), changed by assignments ``name=value``.

    The rules between parameters are checked at `points` from a first to a last number: a job needs
    no others. `visit` is called with each of these, in order, as soon as it turns out to be valid.

    Raises
    ------
    StudyError
        If the file or the assignments are invalid; the message lists all problems.
    """
    file = Path(path)
    document = read_document(file)
    problems = Problems(document.problems)
    if not _NAME.fullmatch(file.stem):
        rule = (
            "names the folder of its results: the file name may have letters, digits, '.', '_' and "
            "'-', up to 100, and must begin with a letter or digit"
        )
        problems.add("", None, f"{file.name!r} {rule}", "rename the file")
    if not isinstance(document.data, Mapping):
        rule = "must hold keys such as base and vary, not a single value or a list"
        raise StudyError(file, [Problem("", document.data, rule), *problems])
    return _checked(file, document.data, assignments, problems, document.lines, points, visit)


def load_plan(path: str | Path, assignments: Sequence[str] = ()) -> Plan:
    """Read a study as `load_study` does, and plan each point while its rules are checked."""
    planned = PlannedCases()
    return Plan(load_study(path, assignments, visit=planned.add), planned)


def select_case(
    path: str | Path, case_id: str | None = None, assignments: Sequence[str] = ()
) -> Case:
    """Return one case of a study file, changed by assignments ``name=value``.

    An id, or the beginning of exactly one id, chooses a case of the unchanged study, to which the
    assignments are then applied.  Without an id the changed study must have a single case.  Raises
    `StudyError` if the study or the case is invalid, or there is no such case.
    """
    study = load_study(path, () if case_id else assignments)
    points = {point.id: point for point in study.points() if point.id}
    matching = [n for n in points if n.startswith(case_id or "")]
    if case_id in points:
        matching = [case_id]
    if len(matching) != 1:
        listed = "".join(f"\n    {line}" for line in few_of(matching))
        rule = f"is the beginning of {len(matching)} ids"
        hint = f"give more of it, to choose one of{listed}"
        if not case_id:
            rule = f"has {len(points)} cases, and one must be chosen"
            hint = f"give --case ID, one of{listed}"
        elif not matching:
            rule = f"is not one of the {len(points)} cases of this study"
            hint = did_you_mean(case_id, points) or "fretwear plan lists the cases"
        raise StudyError(study.file, [Problem("--case" if case_id else "", case_id, rule, hint)])
    point = points[matching[0]]
    if case_id and assignments:
        point = _checked(study.file, content_of(point), assignments).points()[0]
    assert point.case is not None
    return point.case


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
    changed, problems = copy.deepcopy(dict(raw)), Problems()
    valid = (*case_keys().all_names, MATERIAL, "output.cycles", "title")
    for assignment in assignments:
        name, equals, text = assignment.partition("=")
        name = name.strip()
        if not equals:
            rule = "must have the form name=value"
            problems.add(OPTION, assignment, rule, "such as --set 'load=30 N'")
        elif name not in valid:
            hint = did_you_mean(name, valid)
            problems.add(f"{OPTION} {name}", text, "is not a parameter", hint)
        else:
            with problems.at(f"{OPTION} {name}", text):
                assign(changed, name, parse_value(text))
    return changed, problems


def assign(content: dict[str, Any], name: str, value: object) -> None:
    """Give a parameter one value in the plain content of a study file, as for `override`."""
    if name in ("title", "output.cycles"):
        section, _, key = name.partition(".")
        content[section] = {**as_mapping(content.get(section)), key: value} if key else value
        return
    base, vary = (as_mapping(content.get(section)) for section in ("base", "vary"))
    gone = case_keys().replaced_by(name)
    base = {key: given for key, given in base.items() if key not in gone}
    replaced = tuple(f"{key}." for key in (*gone, name))
    vary = {key: given for key, given in vary.items() if not f"{key}.".startswith(replaced)}
    content |= {"base": base, "vary": vary}
    if SEEDS in (name, f"{name}.seed"):
        content.pop("seeds", None)
    whole, _, part = name.partition(".")
    if part and whole in vary:
        raise QuantityError(f"cannot be set while vary.{whole} varies the whole of it")
    base[whole] = {**as_mapping(base.get(whole)), part: value} if part else value
    if not vary:
        del content["vary"]
        if "seeds" not in content:
            # A sampled design with nothing to sample would be an error.
            content.pop("design", None)


def _checked(
    file: Path,
    given: Mapping[str, Any],
    assignments: Sequence[str],
    before: Sequence[Problem] = (),
    lines: Mapping[str, int] | None = None,
    points: tuple[int, int | None] = ALL_POINTS,
    visit: Callable[[Point], None] | None = None,
) -> Study:
    """Turn the plain content of a study file, changed by assignments, into a `Study`."""
    folder, (content, problems) = file.parent, override(given, assignments)
    problems[:0] = before
    content, added = _with_added(content, folder, problems)
    sections = _sections(content, folder, problems)
    vary = dict(sections.vary)
    if sections.seeds is not None:
        if twice := [name for name in vary if name in (SEEDS, "roughness")]:
            problems.add("seeds", sections.seeds, f"would vary the same as vary.{twice[0]}")
        vary.setdefault(SEEDS, sections.seeds)
    axes = read_axes(vary, sections.design, folder, problems)
    fixed = _read_base(sections.base, vary, folder, problems)
    snapshots = None
    with problems.at("output.cycles", sections.output.cycles):
        snapshots = read_snapshots(sections.output.cycles, in_file=True)
    for name in (sections.output.model_extra or {}).keys() - {*_added_to("output")}:
        problems.unknown(f"output.{name}", None, ("cycles", *_added_to("output")))
    if needed := [section.cycles for section in added.values() if section.cycles is not None]:
        snapshots = tuple(sorted({*(snapshots or ()), *chain(*needed)}))
    study = Study(
        file,
        sections.title or file.stem,
        axes,
        sections.design,
        fixed,
        content,
        snapshots,
        None if sections.batch == "auto" else sections.batch,
        added,
    )
    if len(axes) == len(vary) and not any(_is_of_case(problem) for problem in problems):
        chosen = ALL_POINTS if added else points
        _try_points(study, problems, sections.invalid == "skip", chosen, visit)
    else:  # cases cannot be made, but what is missing or redundant is known
        written = {*_long_form(sections.base, vary, Problems())}
        written |= {name.partition(".")[0] for name in vary}
        case_keys().members_of(fixed, written, problems, "base.")
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


def _added_to(section: str) -> list[str]:
    """The keys that packages beside the core add to a section."""
    places = plugins("fretwear.study_sections")
    return [key for place in places for outer, _, key in [place.partition(".")] if outer == section]


def _is_of_case(problem: Problem) -> bool:
    """Whether a problem keeps cases from being made; unknown names do not."""
    return "is not a case parameter" not in problem.rule and problem.key.startswith(
        ("base", "vary", OPTION, "design", "output", "seeds")
    )


def _sections(content: Mapping[str, Any], folder: Path, problems: Problems) -> Sections:
    """Read the sections; invalid ones count as left out."""
    known, right = section_names(), dict[str, Any]()
    for name, given in content.items():
        if name not in known:
            hint = f"put it under base: base.{name}" if name in case_keys().all_names else ""
            hint = hint or did_you_mean(name, known) or f"known are {', '.join(known)}"
            problems.add(name, given, "is not a section of a study", hint)
        elif name in Sections.model_fields:
            with problems.at("", given):
                read = Sections.__pydantic_validator__.validate_python(
                    {name: given}, context=folder
                )
                right[name] = getattr(read, name)
    # Errors of sections begin with their name.
    problems[:] = [replace(one, key=one.key.removeprefix(".")) for one in problems]
    return Sections.model_construct(**right)


def _long_form(
    base: Mapping[str, Any], vary: Mapping[str, Any], problems: Problems
) -> dict[str, Any]:
    """The keys of `base` with all that a material and a sliding distance stand for."""
    return with_parts_of_distance(with_materials(base, problems, "base.", vary), vary)


def _read_base(
    base: Mapping[str, Any], vary: Mapping[str, Any], folder: Path, problems: Problems
) -> dict[str, Any]:
    """Read the fixed values; a part with varied fields stays as written.

    The value that base may have for a varied parameter is not used.
    """
    given = _long_form(base, vary, problems)
    partial = {name.partition(".")[0] for name in vary if "." in name} - {*vary}
    fixed = case_keys().read_values(given, "base.", problems, folder, left=partial)
    fixed = {name: value for name, value in fixed.items() if name not in vary}
    for whole in partial:
        written = given.get(whole, {})
        content = {"kind": written} if isinstance(written, str) else as_mapping(written)
        varied = {name.partition(".")[2] for name in vary if name.startswith(f"{whole}.")}
        fixed[whole] = _read_partial(whole, content, varied, folder, problems)
    return fixed


def _read_partial(
    whole: str, content: Mapping[str, Any], varied: Iterable[str], folder: Path, problems: Problems
) -> dict[str, Any]:
    """The fields of a part that are not varied."""
    about = case_keys()[whole].about
    assert isinstance(about, PartOf)
    kinds = about.family.kinds()
    usual = [name for name, kind in kinds.items() if {*varied} <= kind.parameters().keys()]
    kind = content.get("kind", next(iter(usual or kinds)))
    fields: dict[str, Any] = {"kind": kind}
    if kind not in kinds:
        problems.add(f"base.{whole}.kind", kind, f"must be one of {', '.join(kinds)}")
        return fields
    known = kinds[kind].parameters()
    for name in varied:
        if name not in known:
            rule = f"is not a parameter of {kind}"
            problems.unknown(f"vary.{whole}.{name}", None, known, rule)
    for name, value in content.items():
        place = f"base.{whole}.{name}"
        if name not in (*known, "kind"):
            problems.unknown(place, value, known)
        elif name != "kind" and name not in varied:
            with problems.at(place, value):
                fields[name] = case_keys().of_kind(f"{whole}.{name}", kind).read(value, folder)
    for name in required(kinds[kind]) - fields.keys() - {*varied}:
        if name not in content:
            such = f"such as {name}: {known[name].example}"
            problems.add(f"base.{whole}.{name}", None, "is missing", such)
    return fields


def _try_points(
    study: Study,
    problems: Problems,
    skip: bool,
    points: tuple[int, int | None],
    visit: Callable[[Point], None] | None,
) -> None:
    """Check the rules between parameters; with `skip`, mark points that break one as invalid.

    `visit` is called with each point that breaks none, in order, while its case exists; without
    `skip`, no longer than all points are valid.
    """
    broken: dict[str, tuple[Problem, list[tuple[int, ...]]]] = {}
    for point in study.points(*points):
        wrong = Problems()
        study.members(point.index, wrong)
        # It is held until all of its rules are tried.
        case = None if wrong else study.case(point.index)
        wrong += findings(case) if case is not None else []
        if wrong and skip and study.axes:
            study.invalid[point.index] = wrong[0].sentence
        elif wrong:
            for problem in wrong:
                placed = _placed(problem, study, point)
                broken.setdefault(str(placed), (placed, []))[1].append(point.index)
        elif visit is not None and not broken and not problems:
            visit(point)
    problems.extend(_summarised(broken.values(), study))


def _placed(problem: Problem, study: Study, point: Point) -> Problem:
    """The problem of a point at the key of the file that has the value."""
    name = problem.key.removeprefix("base.")
    key = "output.cycles" if name == "output_cycles" else f"base.{name}"
    listed = not isinstance(study.design, Sampled)
    for axis, position in zip(study.axes, point.index, strict=True):
        if f"{name}.".startswith(f"{axis.key}."):
            key = f"vary.{axis.name}{f'[{position}]' if listed else ''}"
    return replace(problem, key=key, remedy=problem.remedy)


def _summarised(
    broken: Iterable[tuple[Problem, Sequence[tuple[int, ...]]]], study: Study
) -> Iterable[Problem]:
    """Each broken rule once for a key, with the values of other parameters at which it breaks."""
    by_rule: dict[tuple[str, str], list[tuple[Problem, Sequence[tuple[int, ...]]]]] = {}
    for problem, indices in broken:
        words = re.sub(r"[\d.e+-]+", "#", problem.rule)
        by_rule.setdefault((problem.key, words), []).append((problem, indices))
    told: dict[str, int] = {}
    for (key, words), problems in by_rule.items():
        problem, indices = problems[0]
        every = [index for _, some in problems for index in some]
        others = []
        for number, axis in enumerate(study.axes):
            at = {index[number] for index in every}
            if not key.startswith(f"vary.{axis.name}") and len(at) < len(axis.values):
                others.append(f"{axis.name} = {axis.labels[indices[0][number]]}")
        more = f", and at {len(every) - 1} more points" if others and every[1:] else ""
        where = f" (at {', '.join(others)}{more})" if others else ""
        told[words] = told.get(words, 0) + 1
        if told[words] <= _LISTED_PER_RULE:
            yield replace(problem, rule=f"{problem.rule}{where}")


def _in_order(
    problems: Iterable[Problem], lines: Mapping[str, int], assignments: Sequence[str]
) -> list[Problem]:
    """Give problems the line of their key or the option that set it, and sort them by line."""
    names = [assignment.partition("=")[0].strip() for assignment in assignments]
    shown = {place: f"{OPTION} {name}" for name in names for place in (f"base.{name}", name)}
    if "seeds" in lines and f"vary.{SEEDS}" not in lines:
        shown[f"vary.{SEEDS}"] = "seeds"
    placed = []
    for problem in problems:
        key = problem.key
        for place, name in shown.items():
            if f"{problem.key}.".startswith((f"{place}.", f"{place}[")):
                key = name + problem.key.removeprefix(place)
        line, at = problem.line or lines.get(key), key
        while line is None and at:  # the line of the whole that lacks a key
            at = at[: max(at.rfind("."), at.rfind("["), 0)]
            line = lines.get(at) if at else None
        placed.append(replace(problem, key=key, line=line))
    told = {(one.key, one.rule): one for one in placed}
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
    sections["seeds"] |= _varied(SEEDS)
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
