"""The sections of a study file, each read into sound values and a list of problems."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from fretwear.study.case import OPTIONAL_IN_FILES
from fretwear.study.checks import TANGENTIAL, exactly_one_tangential
from fretwear.study.designs import KINDS, MAX_POINTS, SAMPLED, Design
from fretwear.study.parameters import (
    ROUGHNESS,
    case_fields,
    parameter_fields,
    read_parameter,
    such_as,
)
from fretwear.study.problems import Problem, shown, suggestion

TOP_LEVEL = ("title", "base", "vary", "design", "invalid", "batch", "output")
MAX_TITLE = 200


@dataclass
class Draft:
    """What a study file says, as far as it could be read."""

    title: str
    fixed: dict[str, Any] = field(default_factory=dict)
    design: Design = field(default_factory=Design)
    skip_invalid: bool = False
    batch: int | None = None
    problems: list[Problem] = field(default_factory=list)

    def read(self, name: str, raw: object, key: str) -> None:
        """Read a fixed value."""
        reading = read_parameter(name, raw, key)
        self.problems.extend(reading.problems)
        if not reading.problems:
            self.fixed[name] = reading.value


def read_sections(raw: Mapping[str, Any], name: str) -> Draft:
    """Read everything but the varied values."""
    draft = Draft(title=name)
    _refuse_unknown_sections(raw, draft)
    if "title" in raw:
        _read_title(raw["title"], draft)
    base = section(raw, "base", draft)
    varied = tuple(varied_section(raw))
    _read_base(base, varied, draft)
    _require(base, varied, draft)
    _read_output(section(raw, "output", draft), draft)
    _read_design(raw.get("design", "grid"), draft)
    if "invalid" in raw:
        if raw["invalid"] in ("stop", "skip"):
            draft.skip_invalid = raw["invalid"] == "skip"
        else:
            draft.problems.append(Problem("invalid", shown(raw["invalid"]), "must be stop or skip"))
    _read_batch(raw.get("batch", "auto"), draft)
    return draft


def section(raw: Mapping[str, Any], name: str, draft: Draft) -> Mapping[str, Any]:
    """Return a section that is a mapping; report anything else."""
    if name not in raw:
        return {}
    value = raw[name]
    if isinstance(value, Mapping):
        return value
    if value is None:
        draft.problems.append(Problem(name, "", "is empty", f"leave {name} out, or fill it"))
    else:
        rule = "must hold keys with values, one to a line"
        draft.problems.append(Problem(name, shown(value), rule))
    return {}


def varied_section(raw: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the section `vary` where there is a usable one."""
    vary = raw.get("vary")
    return vary if isinstance(vary, Mapping) else {}


def _refuse_unknown_sections(raw: Mapping[str, Any], draft: Draft) -> None:
    for key, value in raw.items():
        if key in TOP_LEVEL:
            continue
        if key in parameter_fields():
            hint = f"put it under base: base.{key}"
        else:
            hint = suggestion(key, TOP_LEVEL) or f"known are {', '.join(TOP_LEVEL)}"
        draft.problems.append(Problem(key, shown(value), "is not a section of a study", hint))


def _read_title(title: object, draft: Draft) -> None:
    if not isinstance(title, str) or not title.strip():
        rule, hint = "must be text", "put it in quotes"
    elif not title.isprintable():
        rule, hint = "must be one line of printable text", ""
    elif len(title) > MAX_TITLE:
        rule, hint = f"must have at most {MAX_TITLE} characters", ""
    else:
        draft.title = title.strip()
        return
    draft.problems.append(Problem("title", shown(title), rule, hint))


def _read_base(base: Mapping[str, Any], varied: Sequence[str], draft: Draft) -> None:
    parts_varied = any(name.startswith(f"{ROUGHNESS}.") for name in varied)
    for key, value in base.items():
        if key in case_fields():
            if key == ROUGHNESS and parts_varied:
                _read_roughness_parts(value, varied, draft)
            else:
                draft.read(key, value, f"base.{key}")
        else:
            hint = suggestion(key, tuple(case_fields())) or _elsewhere(key)
            problem = Problem(f"base.{key}", shown(value), "is not a case parameter", hint)
            draft.problems.append(problem)
    if parts_varied and ROUGHNESS not in base:
        _read_roughness_parts({}, varied, draft)
    # A varied parameter may have a value in base as well: that of the study it departs from.
    for name in varied:
        draft.fixed.pop(name, None)


def _elsewhere(key: str) -> str:
    part = f"{ROUGHNESS}."
    if key.startswith(part) and key in parameter_fields():
        return f"write roughness: {{{key.removeprefix(part)}: ...}}"
    return f"{key} stands at the top level, not under base" if key in TOP_LEVEL else ""


def _read_roughness_parts(value: object, varied: Sequence[str], draft: Draft) -> None:
    """Read `base.roughness` where parts of it are varied: part by part."""
    parts = {
        name.split(".", 1)[1]: name
        for name in parameter_fields()
        if name.startswith(ROUGHNESS + ".")
    }
    if not isinstance(value, Mapping):
        first = next(name for name in varied if name.startswith(f"{ROUGHNESS}."))
        rule = f"must give the other parts of the roughness, because {first} is varied"
        problem = Problem("base.roughness", shown(value), rule, such_as(ROUGHNESS))
        draft.problems.append(problem)
        return
    for part, raw in value.items():
        if part in parts:
            draft.read(parts[part], raw, f"base.roughness.{part}")
        else:
            hint = suggestion(part, tuple(parts)) or f"known are {', '.join(parts)}"
            key = f"base.roughness.{part}"
            draft.problems.append(Problem(key, shown(raw), "is not known", hint))
    for part, name in parts.items():
        if part == "kind":
            draft.fixed.setdefault(name, "wavy")
        elif part not in value and name not in varied:
            problem = Problem(f"base.roughness.{part}", "", "is missing", such_as(name))
            draft.problems.append(problem)


def _require(base: Mapping[str, Any], varied: Sequence[str], draft: Draft) -> None:
    given = {*base, *(name.split(".", 1)[0] for name in varied)}
    unknown = [key for key in base if key not in case_fields()]
    for name in case_fields():
        if name in given or name in TANGENTIAL or name in OPTIONAL_IN_FILES:
            continue
        if any(suggestion(key, (name,)) for key in unknown):
            continue  # misspelt, which has been said
        draft.problems.append(Problem(f"base.{name}", "", "is missing", such_as(name)))
    tangential = exactly_one_tangential(given)
    if tangential is not None:
        subject = tangential.subject
        key = f"vary.{subject}" if subject in varied else f"base.{subject}"
        value = shown(base.get(subject)) if subject in base else ""
        draft.problems.append(Problem(key, value, tangential.rule, tangential.hint))


def _read_output(output: Mapping[str, Any], draft: Draft) -> None:
    draft.fixed["output_cycles"] = ()
    for key, value in output.items():
        if key != "cycles":
            hint = suggestion(key, ("cycles",)) or "known is cycles"
            draft.problems.append(Problem(f"output.{key}", shown(value), "is not known", hint))
            continue
        reading = read_parameter("output.cycles", value, "output.cycles")
        draft.problems.extend(reading.problems)
        if reading.problems:
            del draft.fixed["output_cycles"]
            continue
        draft.fixed["output_cycles"] = reading.value
        for position, cycle in enumerate(reading.value):
            if cycle in reading.value[:position]:
                key = f"output.cycles[{position}]"
                draft.problems.append(Problem(key, str(cycle), "is given twice"))


def _read_batch(batch: object, draft: Draft) -> None:
    if batch == "auto":
        return
    if isinstance(batch, int) and not isinstance(batch, bool) and 1 <= batch <= MAX_POINTS:
        draft.batch = batch
        return
    rule = f"must be auto, or a whole number of cases from 1 to {MAX_POINTS}"
    hint = "auto gives a job a few minutes of work"
    if isinstance(batch, str):
        hint = suggestion(batch, ("auto",))
    draft.problems.append(Problem("batch", shown(batch), rule, hint))


def _read_design(design: object, draft: Draft) -> None:
    given: Mapping[str, Any] = design if isinstance(design, Mapping) else {"kind": design}
    key = "design.kind" if isinstance(design, Mapping) else "design"
    kind = given.get("kind", "grid")
    if kind not in KINDS:
        hint = suggestion(kind, KINDS) if isinstance(kind, str) else ""
        problem = Problem(key, shown(kind), f"must be one of {', '.join(KINDS)}", hint)
        draft.problems.append(problem)
        return
    numbers = {"points": 0, "seed": 0}
    allowed = ("kind", *numbers) if kind in SAMPLED else ("kind",)
    for name, value in given.items():
        if name not in allowed:
            hint = suggestion(name, allowed) or f"{kind} knows {', '.join(allowed)}"
            draft.problems.append(Problem(f"design.{name}", shown(value), "is not known", hint))
        elif name in numbers:
            least, most = (1, MAX_POINTS) if name == "points" else (0, 2**32 - 1)
            if isinstance(value, int) and not isinstance(value, bool) and least <= value <= most:
                numbers[name] = value
            else:
                rule = f"must be a whole number from {least} to {most}"
                draft.problems.append(Problem(f"design.{name}", shown(value), rule))
    if kind in SAMPLED and "points" not in given:
        problem = Problem("design.points", "", f"is missing: {kind} needs it", "such as points: 64")
        draft.problems.append(problem)
    draft.design = Design(kind, numbers["points"], numbers["seed"])
