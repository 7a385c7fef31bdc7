"""Studies: from a YAML file to points, with all problems reported at once."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any

from fretwear.parts import Part, required
from fretwear.study.case import SNAPSHOTS, Case
from fretwear.study.parameters import (
    by_member,
    html_table,
    make_member,
    member_of,
    missing,
    parameter_names,
    read_values,
)
from fretwear.study.points import Axis, Design, Grid, Point, read_axes
from fretwear.study.problems import Problem, Problems, StudyError, few_of
from fretwear.study.rules import RULES, Rule
from fretwear.study.sections import OPTION, Sections, assign, override, read_sections
from fretwear.study.tree import CaseTree, members
from fretwear.study.yamlfile import read_document
from fretwear.topography import Located
from fretwear.units import did_you_mean

_MOST_SHOWN = 12

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,99}")
_LISTED_PER_RULE = 8


@dataclass(frozen=True)
class Study:
    """A study: every value read, every rule checked where `load_study` returned it."""

    file: Path  # the file it was read from
    title: str  # for people
    axes: tuple[Axis, ...]  # the varied parameters in the order of the file
    design: Design  # how their values are combined
    fixed: Mapping[str, Any]  # values of the other parameters, in SI units
    content: Mapping[str, Any]  # plain content of the file, overrides included
    batch: int | None = None  # cases per job; None: as many as take a few minutes
    # Points left out, with the reason.
    invalid: dict[tuple[int, ...], str] = field(default_factory=dict)

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
        return len(self.indices)

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the axes of a grid; the number of points for every other design."""
        if self.design.kind == "grid":
            return tuple(len(axis.values) for axis in self.axes)
        return (self.size,)

    @cached_property
    def indices(self) -> Sequence[tuple[int, ...]]:
        """The points as positions along the axes, the last varied parameter fastest."""
        return [*self.design.indices([len(axis.values) for axis in self.axes])]

    @cached_property
    def _points(self) -> tuple[Point, ...]:
        return self._some_of(self.indices)

    def _some_of(self, indices: Sequence[tuple[int, ...]]) -> tuple[Point, ...]:
        each = ((index, self.invalid.get(index, "")) for index in indices)
        return tuple(Point(self.axes, i, None if why else self.case(i), why) for i, why in each)

    def points(self, first: int = 1, last: int | None = None) -> tuple[Point, ...]:
        """Return the points in order, the last varied parameter fastest.

        Of a large study a few neighbours, by their numbers from 1, come much sooner than all.
        """
        some = first > 1 or (last or self.size) < self.size
        return self._some_of(self.indices[first - 1 : last]) if some else self._points

    def cases(self) -> dict[str, Case]:
        """Return the cases to run by id, each once even if several points share it."""
        return {point.id: point.case for point in self.points() if point.case is not None}

    def case(self, index: tuple[int, ...]) -> Case:
        """Return the case of a point from values already read and checked."""
        members = {name: self._member(name, index) for name in self.valid if self._given[name][1]}
        return Case.of({**self.valid, **members})

    @cached_property
    def valid(self) -> Mapping[str, Any]:
        """The members of a case whose values are all valid, as in the first point."""
        found = {}
        for member in self._given:
            with suppress(KeyError):  # Others that its values need may be wrong.
                found[member] = self._member(member, (0,) * len(self.axes))
        return found

    @cached_property
    def _given(self) -> Mapping[str, tuple[dict[str, Any], list[int], dict[tuple[int, ...], Any]]]:
        """Of each member its fixed values by name, the axes that vary others, and those made."""
        found: dict[str, tuple[dict[str, Any], list[int], dict[tuple[int, ...], Any]]] = {
            member: (values, [], {}) for member, values in by_member(self.fixed).items()
        }
        for position, axis in enumerate(self.axes):
            found.setdefault(axis.member, ({}, [], {}))[1].append(position)
        return found

    def _member(self, member: str, index: tuple[int, ...]) -> Any:
        # Points share parts, so each combination of a part's values is made once.
        fixed, axes, made = self._given[member]
        key = tuple([index[i] for i in axes])
        if key not in made:
            drawn = {self.axes[i].name: self.axes[i].values[index[i]] for i in axes}
            base = fixed.get(member)
            if drawn and isinstance(base, Part):
                fields = {name.rpartition(".")[2]: value for name, value in drawn.items()}
                drawn = {member: type(base).unchecked(**{**vars(base), **fields})}
            made[key] = make_member(member, {**fixed, **drawn})
        return made[key]


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
    axes = read_axes(sections.vary, sections.places, sections.design, found)
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
    title = sections.title or file.stem
    # If the design cannot be read, fixed values are still checked.
    study = Study(file, title, axes, sections.design or Grid(), fixed, content, sections.batch)
    _try_rules(study, found, skip=sections.invalid == "skip")
    if not (problems or found) and len(study.invalid) == study.size:
        found.add("vary", None, f"leaves no point to run: {next(iter(study.invalid.values()))}")
    if problems or found:
        raise StudyError(file, _in_order([*problems, *found], lines, assignments))
    return study


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
        whole, _, own = name.partition(".")
        if own and whole not in sections.vary:
            base.setdefault(whole, {})
            parts.setdefault(whole, []).append(own)
    read = read_values(base, "base.", problems, units_required=True, varied=parts)
    for problem in missing({*base, *varied}, in_file=True):
        key = f"vary.{problem.key}" if problem.key in sections.vary else f"base.{problem.key}"
        problems.append(replace(problem, key=key, given=sections.base.get(problem.key)))
    known = {axis.name for axis in axes}
    for whole, fields in parts.items():
        if (part := read.get(whole)) is None:
            continue
        of_kind = [*part.parameters()]
        for own in (each for each in fields if each not in of_kind):
            name, rule = f"{whole}.{own}", f"is nothing that {part.kind} has"
            key, remedy = sections.places.get(name, f"vary.{name}"), f"it has {', '.join(of_kind)}"
            problems.add(key, sections.vary[name], rule, remedy, of_kind, own)
        if not all(own in of_kind and f"{whole}.{own}" in known for own in fields):
            del read[whole]
    return {name: value for name, value in read.items() if name not in varied}


def _broken(study: Study) -> Iterator[tuple[Problem, list[tuple[Axis, int]], list[Any]]]:
    """Yield each broken rule, the positions along the axes that break it, and their points.

    A rule is tried once for each combination of the valid values that it needs.
    """
    defaulted = {*members(), "output_cycles"} - required(CaseTree) - {a.member for a in study.axes}
    blocks = ("cycles",) if "blocks" in study.valid else ()
    known = {*study.valid, *defaulted, *blocks}
    trials: list[tuple[Rule, list[int], dict[Any, tuple[Problem | None, list[Any]]]]] = []
    for rule in RULES:
        if {member_of(name) for name in rule.needs} <= known:
            # Blocks have cycles of their own.
            needs = rule.needs | ({"blocks"} if "cycles" in rule.needs else set())
            axes = enumerate(study.axes)
            trials.append((rule, [i for i, a in axes if {a.member, a.name} & needs], {}))
    # Point by point, so that each case is made once for all rules.
    for index in study.indices:
        case: Case | None = None
        for rule, relevant, tried in trials:
            positions = tuple([index[i] for i in relevant])
            if positions not in tried:
                case = case or study.case(index)
                tried[positions] = rule.find(case), []
            problem, points = tried[positions]
            if problem is not None:
                points.append(index)
    for _, relevant, tried in trials:
        for positions, (problem, points) in tried.items():
            if problem is not None:
                axes_of = [study.axes[i] for i in relevant]
                yield problem, [*zip(axes_of, positions, strict=True)], points


def _try_rules(study: Study, problems: Problems, *, skip: bool) -> None:
    """Check the rules between parameters; leave points out that are to be skipped."""
    listed = Counter[str]()
    for problem, where, points in _broken(study):
        if skip and where:
            for index in points:
                study.invalid.setdefault(index, problem.sentence)
            continue
        subject = problem.key
        listed[subject] += 1
        if listed[subject] > _LISTED_PER_RULE:
            continue
        # Where in the file to mend it, and at which values it breaks.
        key = "output.cycles" if subject == "output_cycles" else f"base.{subject}"
        others = []
        for axis, position in where:
            if axis.key == subject:
                key = axis.place + ("" if study.design.is_sampled else f"[{position}]")
            else:
                others.append(f"{axis.name} = {axis.labels[position]}")
        at = f" (at {', '.join(others)})" if others else ""
        problems.append(replace(problem, key=key, rule=f"{problem.rule}{at}"))
    for subject, count in listed.items():
        if (more := count - _LISTED_PER_RULE) > 0:
            rule = f"is wrong in the same way at {more} more combinations of the varied values"
            problems.add(f"vary ({subject})", None, rule)


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
            assign(content, axis.name, axis.written[position])
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
