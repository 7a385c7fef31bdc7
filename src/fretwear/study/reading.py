"""From a YAML file to a study, with all problems reported at once."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path

from fretwear.mechanics.surfaces.files import Located
from fretwear.plugins import StudySection, plugins
from fretwear.problems import Problem, Problems
from fretwear.study.case import Case, read_snapshots
from fretwear.study.overrides import OPTION, assign, override
from fretwear.study.plan import Plan, PlannedCases
from fretwear.study.points import Combinations, read_axes
from fretwear.study.problems import StudyError, few_of
from fretwear.study.sections import SEEDS, read_base, read_sections
from fretwear.study.study import ALL_POINTS, Point, Study
from fretwear.study.trials import try_rules
from fretwear.study.yamlfile import as_mapping, read_document
from fretwear.units import did_you_mean

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,99}")


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


def content_of(point: Point) -> dict[str, object]:
    """The plain content of a study that has a single point."""
    content = {**point.study.content}
    for axis, position in zip(point.study.axes, point.index, strict=True):
        assign(content, axis.name, axis.written[position])
    return {key: value for key, value in content.items() if key not in point.study.added}


def case_of_content(file: Path, content: Mapping[str, object]) -> Case:
    """The case of the plain content of a study of a single point; `StudyError` if it is invalid."""
    (point,) = _checked(file, content, ()).points()
    assert point.case is not None
    return point.case


def _checked(
    file: Path,
    given: Mapping[str, object],
    assignments: Sequence[str],
    problems: Sequence[Problem] = (),
    lines: Mapping[str, int] | None = None,
    points: tuple[int, int | None] = ALL_POINTS,
    visit: Callable[[Point], None] | None = None,
) -> Study:
    """Turn the plain content of a study file, changed by assignments, into a `Study`."""
    content, wrong = override(given, assignments)
    before, problems = [*problems, *wrong], Problems()
    content, added = _with_added(content, file.parent, problems)
    sections = read_sections(as_mapping(_located(content, file.parent)), problems)
    axes = read_axes(sections.vary, sections.design, problems)
    fixed = read_base(sections, axes, content, problems)
    asked, snapshots = sections.output.get("cycles", "auto"), None
    with problems.at("output.cycles", asked):
        fixed["output_cycles"] = snapshots = read_snapshots(asked, in_file=True)
    needed = [section.cycles for section in added.values() if section.cycles is not None]
    if needed:
        fixed["output_cycles"] = tuple(sorted({*(snapshots or ()), *chain(*needed)}))
    # Axes within a part that could not be read are skipped.
    axes = tuple(axis for axis in axes if "." not in axis.name or axis.key in fixed)
    for axis in axes:
        if axis.name == "indenter" and len({part.frame for part in axis.values}) > 1:
            rule = "has cylinders, whose results are per length, beside others"
            problems.add("vary.indenter", None, rule, "make two studies of it")
    title = sections.title or file.stem
    # If the design cannot be read, fixed values are still checked.
    design = sections.design or Combinations()
    study = Study(file, title, axes, design, fixed, content, sections.batch, added)
    visit = None if before or problems else visit
    points = ALL_POINTS if added else points
    try_rules(study, problems, skip=sections.invalid == "skip", points=points, visit=visit)
    if not (before or problems) and len(study.invalid) == study.size:
        problems.add("vary", None, f"leaves no point to run: {next(iter(study.invalid.values()))}")
    if added and not (before or problems):
        for section in added.values():
            section.check([point.case for point in study.points()], problems)
    if before or problems:
        raise StudyError(file, _in_order([*before, *problems], lines or {}, assignments))
    return study


def _with_added(
    content: dict[str, object], folder: Path, problems: Problems
) -> tuple[dict[str, object], dict[str, StudySection]]:
    """The content with a completed `base`, and what packages beside the core read of it."""
    added = {}
    for place, entry in plugins("fretwear.study_sections").items():
        *outer, key = place.split(".")
        around = as_mapping(content.get(outer[0])) if outer else content
        if key not in around:
            continue
        reader: type[StudySection] = entry.load()
        given = _located(around[key], folder)
        with problems.at(place, around[key]):
            added[place] = reader.read(given)
        base, vary = (as_mapping(content.get(section)) for section in ("base", "vary"))
        if (completed := reader.complete_base(given, base, vary, problems)) is not base:
            content = {**content, "base": completed}
    return content, added


def _located(value: object, folder: Path) -> object:
    """Mark all text as relative to a folder, in case it names a file."""
    if isinstance(value, dict):
        return {key: _located(item, folder) for key, item in value.items()}
    if isinstance(value, list):
        return [_located(item, folder) for item in value]
    return Located.at(value, folder) if type(value) is str else value


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
        placed.append(replace(problem, key=key, line=problem.line or lines.get(key)))
    return sorted(placed, key=lambda problem: problem.line or len(lines) * 1000)
