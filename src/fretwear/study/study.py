"""Studies: from a YAML file to points, with all problems reported at once."""

from __future__ import annotations

import copy
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any

from fretwear.study.case import SNAPSHOTS, Case
from fretwear.study.parameters import html_table, missing, parameter_names, read_values, replaced_by
from fretwear.study.points import Axis, Design, Grid, Parameters, Point
from fretwear.study.problems import Problem, Problems, StudyError, few_of
from fretwear.study.sections import SEEDS, Sections, read_axes, read_sections
from fretwear.study.yamlfile import parse_value, read_document
from fretwear.topography import Located
from fretwear.units import QuantityError, did_you_mean

OPTION = "--set"

_MOST_SHOWN = 12

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,99}")
_LISTED_PER_RULE = 8


@dataclass(frozen=True)
class Study:
    """A valid study: every value read, every rule checked."""

    file: Path  # the file it was read from
    title: str  # for people
    axes: tuple[Axis, ...]  # the varied parameters in the order of the file
    design: Design  # how their values are combined
    parameters: Parameters  # fixed values, axes, and the points as positions along the axes
    invalid: Mapping[tuple[int, ...], str]  # points left out, with the reason
    content: Mapping[str, Any]  # plain content of the file, overrides included
    batch: int | None = None  # cases per job; None: as many as take a few minutes

    def _repr_html_(self) -> str:
        """Return what is varied as a table, for notebooks."""
        most = _MOST_SHOWN
        rows = (
            (axis.name, ", ".join([*axis.labels[:most], *(["…"] if axis.labels[most:] else [])]))
            for axis in self.axes
        )
        return html_table(f"{self.title}: {self.size} points, design {self.design.kind}", rows)

    @property
    def name(self) -> str:
        """Stem of the file name; names the folder of the results."""
        return self.file.stem

    @property
    def size(self) -> int:
        """Number of points."""
        return len(self.parameters.indices)

    @cached_property
    def _points(self) -> tuple[Point, ...]:
        return tuple(self.parameters.points(self.invalid))

    def points(self, first: int = 1, last: int | None = None) -> tuple[Point, ...]:
        """Return the points in order, the last varied parameter fastest.

        Of a large study a few neighbours, by their numbers from 1, come much sooner than all.
        """
        last = self.size if last is None else last
        if (first, last) == (1, self.size):
            return self._points
        return tuple(self.parameters.points(self.invalid, slice(first - 1, last)))

    def cases(self) -> dict[str, Case]:
        """Return the cases to run by id, each once even if several points share it."""
        return {point.id: point.case for point in self.points() if point.case is not None}

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the axes of a grid; the number of points for every other design."""
        if self.design.kind == "grid":
            return tuple(len(axis.values) for axis in self.axes)
        return (self.size,)


def load_study(path: str | Path, assignments: Sequence[str] = ()) -> Study:
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
        rule = (
            "names the folder of its results: the file name may have letters, digits, '.', '_' and "
            "'-', up to 100, and must begin with a letter or digit"
        )
        problems.add("", None, f"{file.name!r} {rule}", "rename the file")
    if not isinstance(document.data, Mapping):
        rule = "must hold keys such as base and vary, not a single value or a list"
        raise StudyError(file, [Problem("", document.data, rule), *problems])
    content, wrong = override(document.data, assignments)
    return _checked(file, content, [*problems, *wrong], document.lines, assignments)


def _checked(
    file: Path,
    content: Mapping[str, Any],
    problems: Sequence[Problem],
    lines: Mapping[str, int] = MappingProxyType({}),
    assignments: Sequence[str] = (),
) -> Study:
    """Turn the plain content of a study file, assignments applied, into a `Study`."""
    found = Problems()
    sections = read_sections(_located(content, file.parent), found)
    axes = read_axes(sections, found)
    # If the design cannot be read, fixed values are still checked.
    design = sections.design or Grid()
    fixed = _read_base(sections, axes, found)
    asked = sections.output.get("cycles", "auto")
    with found.at("output.cycles", asked):
        fixed["output_cycles"] = SNAPSHOTS.read(asked, True)
    # Parts of unread values are skipped.
    axes = tuple(axis for axis in axes if "." not in axis.name or axis.key in fixed)
    for axis in axes:
        if axis.name == "indenter" and len({part.is_line for part in axis.values}) > 1:
            rule = "has cylinders, whose results are per length, beside others"
            found.add("vary.indenter", None, rule, "make two studies of it")
    parameters = Parameters(fixed, axes, list(design.indices([len(axis.values) for axis in axes])))
    invalid = _try_rules(parameters, design, found, skip=sections.invalid == "skip")
    if not (problems or found) and len(invalid) == len(parameters.indices):
        found.add("vary", None, f"leaves no point to run: {next(iter(invalid.values()))}")
    if problems or found:
        raise StudyError(file, _in_order([*problems, *found], lines, assignments))
    title = sections.title or file.stem
    return Study(file, title, axes, design, parameters, invalid, content, sections.batch)


def _located(value: Any, folder: Path) -> Any:
    """Mark all text as relative to a folder, in case it names a file."""
    if isinstance(value, dict):
        return {key: _located(each, folder) for key, each in value.items()}
    if isinstance(value, list):
        return [_located(each, folder) for each in value]
    return Located.at(value, folder) if type(value) is str else value


def _read_base(sections: Sections, axes: tuple[Axis, ...], problems: Problems) -> dict[str, Any]:
    """Read the fixed values; if some fields of a part are varied, its other fields.

    A varied parameter may have a value in base as well, which is not used.
    """
    varied = [name for name in sections.vary if name in parameter_names()]
    base, parts = dict(sections.base), dict[str, list[str]]()
    for name in varied:
        whole, _, field = name.partition(".")
        if field and whole not in sections.vary:
            base.setdefault(whole, {})
            parts.setdefault(whole, []).append(field)
    read = read_values(base, "base.", problems, units_required=True, varied=parts)
    for problem in missing({*base, *varied}, in_file=True):
        key = f"vary.{problem.key}" if problem.key in sections.vary else f"base.{problem.key}"
        problems.append(replace(problem, key=key, given=sections.base.get(problem.key)))
    known = {axis.name for axis in axes}
    for whole, fields in parts.items():
        if (part := read.get(whole)) is None:
            continue
        of_kind = [*part.parameters()]
        for field in (each for each in fields if each not in of_kind):
            name, rule = f"{whole}.{field}", f"is nothing that {part.kind} has"
            key, remedy = sections.place(name), f"it has {', '.join(of_kind)}"
            found = Problem(key, sections.vary[name], rule, remedy, known=of_kind, written=field)
            problems.append(found)
        if not all(field in of_kind and f"{whole}.{field}" in known for field in fields):
            del read[whole]
    return {name: value for name, value in read.items() if name not in varied}


def _try_rules(
    parameters: Parameters, design: Design, problems: Problems, *, skip: bool
) -> dict[tuple[int, ...], str]:
    """Check the rules between parameters; return the points to skip and report other violations."""
    invalid: dict[tuple[int, ...], str] = {}
    listed = Counter[str]()
    for found in parameters.find():
        if skip and found.where:
            for index in found.points:
                invalid.setdefault(index, found.problem.sentence)
            continue
        subject = found.problem.key
        listed[subject] += 1
        if listed[subject] > _LISTED_PER_RULE:
            continue
        # Where in the file to mend it, and at which values it breaks.
        key = "output.cycles" if subject == "output_cycles" else f"base.{subject}"
        others = []
        for axis, position in found.where:
            if axis.key == subject:
                key = axis.place + ("" if design.is_sampled else f"[{position}]")
            else:
                others.append(f"{axis.name} = {axis.labels[position]}")
        at = f" (at {', '.join(others)})" if others else ""
        problems.append(replace(found.problem, key=key, rule=f"{found.problem.rule}{at}"))
    for subject, count in listed.items():
        if (more := count - _LISTED_PER_RULE) > 0:
            rule = f"is wrong in the same way at {more} more combinations of the varied values"
            problems.add(f"vary ({subject})", None, rule)
    return invalid


def _in_order(
    problems: Iterable[Problem], lines: Mapping[str, int], assignments: Sequence[str]
) -> list[Problem]:
    """Add the line of the key to problems, and mark those set on the command line."""
    placed = []
    names = [assignment.partition("=")[0].strip() for assignment in assignments]
    places = [(name, place) for name in names for place in (f"base.{name}", name)]
    for problem in problems:
        key = problem.key
        for name, place in places:
            if key == place or key.startswith((f"{place}.", f"{place}[")):
                key = f"{OPTION} {name}{key.removeprefix(place)}"
        line = problem.line
        if line is None and key == problem.key and key:
            line = lines.get(key)
        placed.append(replace(problem, key=key, line=line))
    return sorted(placed, key=lambda problem: problem.line or len(lines) * 1000)


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
            rule = "is not a parameter"
            problems.append(Problem(place, text, rule, written=name, known=known))
        else:
            with problems.at(place, text):
                value = parse_value(text)
                with problems.at(place, value):
                    _assign(changed, name, value)
    return changed, problems


def _assign(content: dict[str, Any], name: str, value: Any) -> None:
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


def select_case(
    path: str | Path, case_id: str | None = None, assignments: Sequence[str] = ()
) -> Case:
    """Return one case of a study file, changed by assignments ``name=value``.

    It is chosen by its id in the study as it stands, or the beginning of just one id, and changed
    after that.  Without an id the study, with the assignments applied, must come to a single case.

    Raises
    ------
    StudyError
        The study or the changed case is not valid, or there is no such case.
    """
    study = load_study(path, () if case_id else assignments)
    points = {point.id: point for point in study.points() if point.case is not None}
    if case_id:
        found = [name for name in points if name == case_id]
        found = found or [name for name in points if name.startswith(case_id)]
        if len(found) != 1:
            rule = f"is the beginning of {len(found)} ids"
            hint = f"give more of it, to choose one of{_listed(found)}"
            if not found:
                rule = f"is not one of the {len(points)} cases of this study"
                hint = did_you_mean(case_id, points) or "fretwear plan lists the cases"
            raise StudyError(study.file, [Problem("--case", case_id, rule, hint)])
        chosen = points[found[0]]
        if not assignments and chosen.case is not None:
            return chosen.case
        content = {**study.content}
        for axis, position in zip(study.axes, chosen.index, strict=True):
            _assign(content, axis.name, axis.written[position])
        content, problems = override(content, assignments)
        changed = _checked(study.file, content, problems, assignments=assignments)
        points = {point.id: point for point in changed.points()}
    if len(points) > 1:
        rule = f"has {len(points)} cases, and one must be chosen"
        hint = f"give --case ID, one of{_listed(list(points))}"
        raise StudyError(study.file, [Problem("", None, rule, hint)])
    only = next(iter(points.values())).case
    assert only is not None
    return only


def _listed(ids: Sequence[str]) -> str:
    return "".join(f"\n    {line}" for line in few_of(ids))
