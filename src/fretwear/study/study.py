"""Studies: from a YAML file to points, with all problems reported at once."""

from __future__ import annotations

import copy
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache, partial
from pathlib import Path
from typing import Any, cast
from weakref import WeakValueDictionary

from fretwear.mechanics.surface_files import Located
from fretwear.parts import Choice, Part, keys_schema, required
from fretwear.problems import Problem, Problems, in_words
from fretwear.study.case import SNAPSHOTS_SCHEMA, Case, read_snapshots
from fretwear.study.fits import FitRequest, read_free, with_sought
from fretwear.study.materials import DESCRIPTION, MATERIAL, material_table, with_materials
from fretwear.study.members import Block, PartOf
from fretwear.study.parameters import (
    base_names,
    by_member,
    html_table,
    make_member,
    member_of,
    missing_parameters,
    parameter_names,
    parameter_of,
    read_values,
    replaced_by,
    schema_required,
    with_parts_of_distance,
)
from fretwear.study.points import MAX_POINTS, Axis, Combinations, Design, Sampled, read_axes
from fretwear.study.problems import StudyError, few_of
from fretwear.study.rules import RULES, Rule
from fretwear.study.setup import IN_BLOCKS, members
from fretwear.study.stresses import StressOutput
from fretwear.study.yamlfile import parse_value, read_document
from fretwear.units import QuantityError, did_you_mean

SECTIONS = ("title", "base", "vary", "seeds", "design", "invalid", "batch", "output", "fit")
OPTION = "--set"
SEEDS = "roughness.seed"
"""The parameter that the section `seeds` varies."""
MAX_TITLE = 200

_Varied = tuple[list[int], Callable[..., object]]

_MOST_PARTS = 1024  # kept of each member, so that neighbouring points share them
_MOST_SHOWN = 12
_LISTED_PER_RULE = 8
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,99}")
_DESIGN = PartOf(
    Design,
    "design",
    example="{kind: latin_hypercube, points: 64, seed: 1}",
    description="How the varied values are combined.",
    may_be_partial=False,
)
_INVALID = Choice("", "", ("stop", "skip"), description="What to do about points such as Q >= µP.")


@dataclass(frozen=True)
class Study:
    """A study: every value is read, and every rule checked if `load_study` returned it."""

    file: Path  # the file it was read from
    title: str  # for people
    axes: tuple[Axis, ...]  # the varied parameters in the order of the file
    design: Design  # how the varied values are combined
    fixed: Mapping[str, Any]  # values of the other parameters, in SI units
    content: Mapping[str, object]  # plain content of the file, overrides included
    batch: int | None = None  # cases per job; None: as many as take a few minutes
    stress: StressOutput | None = None  # what is asked for of stresses; None: nothing
    fit: FitRequest | None = None  # what is sought, and what was measured; None: nothing
    # Points left out, with the reason.
    invalid: dict[tuple[int, ...], str] = field(default_factory=dict)

    def _repr_html_(self) -> str:
        """Return the varied parameters as a table, for notebooks."""
        shown = ((axis.name, few_of(axis.labels, _MOST_SHOWN)) for axis in self.axes)
        head = f"{self.title}: {self.size} points, design {self.design.kind}"
        return html_table(head, ((name, ", ".join(labels)) for name, labels in shown))

    @property
    def name(self) -> str:
        """Stem of the file name; names the folder of the results."""
        return self.file.stem

    @property
    def size(self) -> int:
        """Number of points."""
        return len(self.indices)

    @cached_property
    def sizes(self) -> dict[str, int]:
        """Dimensions of the merged study: the varied names of a grid, else ``point``."""
        if self.design.kind == "grid" or not self.axes:
            return {axis.coordinate: len(axis.values) for axis in self.axes}
        return {"point": self.size}

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the axes of a grid; the number of points for every other design."""
        return tuple(self.sizes.values())

    @cached_property
    def indices(self) -> Sequence[tuple[int, ...]]:
        """The points as positions along the axes, the last varied parameter fastest."""
        return [*self.design.indices([len(axis.values) for axis in self.axes])]

    @cached_property
    def _points(self) -> tuple[Point, ...]:
        return tuple(Point(self, index) for index in self.indices)

    @property
    def unused(self) -> list[str]:
        """Sentences on values of `base` that varied ones replace."""
        sentences, base = list[str](), _mapping(self.content.get("base"))
        for axis in self.axes:
            given = {axis.key: base.get(axis.key)}
            if "." in axis.name:
                given = {f"{axis.key}.{n}": v for n, v in _mapping(given[axis.key]).items()}
            if (value := given.get(axis.name)) is not None:
                text = f"base.{axis.name} = {in_words(value)}"
                sentences.append(f"{text} is not used, because {axis.name} is varied")
        return sentences

    def points(self, first: int = 1, last: int | None = None) -> tuple[Point, ...]:
        """Return the points in order, or those from a first to a last number, counted from 1."""
        return self._points[first - 1 : last]

    def cases(self) -> dict[str, Case]:
        """Return the cases to run by id, each once even if several points share it."""
        return {point.id: point.case for point in self.points() if point.case is not None}

    def case(self, index: tuple[int, ...]) -> Case:
        """Return the case of a point from values already read and checked."""
        if (case := self._held.get(index)) is None:
            fixed, varied = self._fixed_and_varied
            parts = {name: of(*[index[i] for i in axes]) for name, (axes, of) in varied.items()}
            self._held[index] = case = Case.of(fixed | parts)
        return case

    @cached_property
    def _held(self) -> WeakValueDictionary[tuple[int, ...], Case]:
        """The cases that somebody holds, by the index of their point."""
        return WeakValueDictionary()

    @cached_property
    def _fixed_and_varied(self) -> tuple[dict[str, object], dict[str, _Varied]]:
        members = self.members.items()
        fixed = {name: part_of() for name, (axes, part_of) in members if not axes}
        return fixed, {name: (axes, part_of) for name, (axes, part_of) in members if axes}

    @cached_property
    def members(self) -> Mapping[str, _Varied]:
        """The members of a case that have valid values, by name.

        Each has the axes that vary it, and a function that returns its part at positions along
        these; neighbouring points share parts.
        """
        of_case: dict[str, _Varied] = {}
        positions = {axis.name: position for position, axis in enumerate(self.axes)}
        fixed, varied = by_member(self.fixed, positions), by_member(positions, self.fixed)
        for member in {**fixed, **varied}:
            given, names = fixed.get(member, {}), varied.get(member, {})
            axes = [*names.values()]
            part_of = lru_cache(_MOST_PARTS)(partial(self._part, member, given, names))
            # Blocks decide point by point whether they complete a member.
            tried = self.indices if "blocks" in {*given, *names} else self.indices[:1]
            with suppress(KeyError):  # Values that the member needs too may be wrong.
                for index in tried:
                    part_of(*[index[i] for i in axes])
                of_case[member] = axes, part_of
        return of_case

    def _part(
        self, member: str, given: Mapping[str, Any], names: Mapping[str, int], *at: int
    ) -> object:
        axes = zip(names.items(), at, strict=True)
        drawn = {name: self.axes[axis].values[place] for (name, axis), place in axes}
        if drawn and isinstance(base := given.get(member), Part):
            fields = {name.rpartition(".")[2]: value for name, value in drawn.items()}
            drawn = {member: base.unchecked(**{**vars(base), **fields})}
        return make_member(member, {**given, **drawn})


@dataclass(frozen=True)
class Point:
    """One point of a study."""

    study: Study = field(repr=False)
    index: tuple[int, ...]  # position along each axis (zip and sampled designs: the same along all)

    @property
    def place(self) -> tuple[int, ...]:
        """Position along the dimensions of a merged study."""
        return self.index[: len(self.study.sizes)]

    @property
    def problem(self) -> str:
        """Why the point is invalid; empty if it is valid."""
        return self.study.invalid.get(self.index, "")

    @property
    def case(self) -> Case | None:
        """The case to run, made anew unless somebody holds it; None if the point is invalid."""
        return None if self.problem else self.study.case(self.index)

    @cached_property
    def id(self) -> str:
        """Case id, empty if the point is invalid. Points may share a case."""
        return case.case_id if (case := self.case) is not None else ""

    @property
    def values(self) -> dict[str, object]:
        """Varied parameters by dotted name, in SI units."""
        return {a.name: a.values[i] for a, i in zip(self.study.axes, self.index, strict=True)}

    @property
    def labels(self) -> dict[str, str]:
        """Varied parameters by dotted name, as written in the file."""
        return {a.name: a.labels[i] for a, i in zip(self.study.axes, self.index, strict=True)}


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
    return _checked(file, document.data, assignments, problems, document.lines)


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
    content.pop("fit", None)
    return content


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
) -> Study:
    """Turn the plain content of a study file, changed by assignments, into a `Study`."""
    content, wrong = override(given, assignments)
    before, problems = [*problems, *wrong], Problems()
    content, fit = _with_fit(content, file.parent, problems)
    sections = _read_sections(_located(content, file.parent), problems)
    axes = read_axes(sections.vary, sections.design, problems)
    fixed = _read_base(sections, axes, content, problems)
    asked, snapshots = sections.output.get("cycles", "auto"), None
    with problems.at("output.cycles", asked):
        fixed["output_cycles"] = snapshots = read_snapshots(asked, in_file=True)
    stress = None
    if "stress" in sections.output:
        with problems.at("output.stress", sections.output["stress"]):
            stress = StressOutput.read(sections.output["stress"])
            if stress.cycles is not None:
                fixed["output_cycles"] = tuple(sorted({*(snapshots or ()), *stress.cycles}))
    # Axes within a part that could not be read are skipped.
    axes = tuple(axis for axis in axes if "." not in axis.name or axis.key in fixed)
    for axis in axes:
        if axis.name == "indenter" and len({part.frame for part in axis.values}) > 1:
            rule = "has cylinders, whose results are per length, beside others"
            problems.add("vary.indenter", None, rule, "make two studies of it")
    title = sections.title or file.stem
    # If the design cannot be read, fixed values are still checked.
    design = sections.design or Combinations()
    study = Study(file, title, axes, design, fixed, content, sections.batch, stress, fit)
    _try_rules(study, problems, skip=sections.invalid == "skip")
    if not (before or problems) and len(study.invalid) == study.size:
        problems.add("vary", None, f"leaves no point to run: {next(iter(study.invalid.values()))}")
    if fit is not None and not (before or problems):
        fit.check([point.case for point in study.points()], problems)
    if before or problems:
        raise StudyError(file, _in_order([*before, *problems], lines or {}, assignments))
    return study


def _with_fit(
    content: dict[str, object], folder: Path, problems: Problems
) -> tuple[dict[str, object], FitRequest | None]:
    """The content with values of `base` for what is sought, and what the section `fit` asks for."""
    if "fit" not in content:
        return content, None
    given, fit = _located(content["fit"], folder), None
    # What can be read is filled in even if there are problems elsewhere in the section.
    free = read_free(_mapping(given).get("free"), Problems())
    base, vary = (_mapping(content.get(section)) for section in ("base", "vary"))
    with problems.at("fit", content["fit"]):
        fit = FitRequest.read(given)
    return {**content, "base": with_sought(free, base, vary, problems)}, fit


def _located(value: object, folder: Path) -> Any:
    """Mark all text as relative to a folder, in case it names a file."""
    if isinstance(value, dict):
        return {key: _located(item, folder) for key, item in value.items()}
    if isinstance(value, list):
        return [_located(item, folder) for item in value]
    return Located.at(value, folder) if type(value) is str else value


@dataclass(frozen=True)
class _Sections:
    """The sections of a study file; invalid ones count as left out."""

    title: str = ""
    base: Mapping[str, object] = field(default_factory=dict)
    vary: Mapping[str, object] = field(default_factory=dict)
    design: Design | None = Combinations()  # noqa: RUF009 - frozen; None where it could not be read
    invalid: str = "stop"
    batch: int | None = None
    output: Mapping[str, object] = field(default_factory=dict)


def _read_sections(raw: Mapping[str, object], problems: Problems) -> _Sections:
    """Read the sections, and add their problems."""
    sections: dict[str, Any] = {"design": None} if "design" in raw else {}
    for name, given in raw.items():
        if name not in SECTIONS:
            valid = () if name in parameter_names() else SECTIONS
            where = "vary" if isinstance(given, list) else "base"
            hint = (
                f"known are {', '.join(valid)}"
                if valid
                else f"put it under {where}: {where}.{name}"
            )
            rule = "is not a section of a study"
            problems.add(name, given, rule, hint, valid_words=valid, written=name)
        elif name not in ("seeds", "fit"):
            with problems.at(name, given):
                sections[name] = _read_section(name, given)
    problems.unknown("output", sections.get("output", {}), ("cycles", "stress"))
    vary = sections.get("vary", {})
    if "seeds" in raw and (twice := [name for name in vary if name in (SEEDS, "roughness")]):
        rule = f"would vary the same as vary.{twice[0]}"
        problems.add("seeds", raw["seeds"], rule, "leave one of them out")
    elif "seeds" in raw:
        sections["vary"] = {**vary, SEEDS: raw["seeds"]}
    return _Sections(**sections)


def _read_section(name: str, given: object) -> object:
    if name in ("design", "invalid"):
        return (_DESIGN if name == "design" else _INVALID).read(given, True)
    if name == "title":
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
        hint = "write output: {cycles: [0, 1000]}" if name == "output" else ""
        if isinstance(given, list) and all(isinstance(item, Mapping) for item in given):
            hint = "leave out the dashes"
        raise QuantityError("must hold keys with values, one to a line", hint)
    return given


def _read_base(
    sections: _Sections,
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
    # What stands in the wrong place is told already, and not missing.
    misplaced = {name for name in content if name not in SECTIONS}
    misplaced |= {key for name in misplaced for key in _mapping(content[name])}
    missing = [*missing_parameters({*base, *varied, *misplaced}, blocks)]
    if not isinstance(content.get("base", {}), Mapping):
        missing = []
    elif "base" not in content and len(missing) > 1:
        examples = [f"{each.key}: {parameter_of(each.key).example}" for each in missing]
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


def _try_rules(study: Study, problems: Problems, *, skip: bool) -> None:
    """Check the rules between parameters; with `skip`, mark points that break one as invalid.

    A rule is tried once for each combination of the valid values that it needs.
    """
    defaulted = {*members(), "output_cycles"} - required(Case) - {a.member for a in study.axes}
    blocks = {"cycles"} if "blocks" in study.members else set()
    # Each rule with the axes that matter to it, and its problems by positions along these.
    trials: list[tuple[Rule, tuple[int, ...], dict[tuple[int, ...], Problem]]] = []
    for rule in RULES:
        needed = {member_of(name) for name in rule.needs}
        if needed <= {*study.members} | defaulted | blocks:
            by_blocks = needed & IN_BLOCKS.keys()
            of_blocks = {i for name in by_blocks for i in study.members[name][0]}
            relevant = tuple(
                i
                for i, axis in enumerate(study.axes)
                if {axis.member, axis.name} & rule.needs
                or (axis.name == "blocks" and i in of_blocks)
            )
            trials.append((rule, relevant, {}))
    by_axes = {
        axes: [(rule, broken) for rule, relevant, broken in trials if relevant == axes]
        for axes in {relevant: None for _, relevant, _ in trials}
    }
    is_grid, tried = isinstance(study.design, Combinations), set[tuple[tuple[int, ...], ...]]()
    # Going point by point makes each case once for all rules.
    for index in study.indices:
        case: Case | None = None
        for axes, rules in by_axes.items():
            positions = tuple([index[i] for i in axes])
            # Otherwise no two points have the same positions.
            if not axes or (is_grid and len(axes) < len(index)):
                if (axes, positions) in tried:
                    continue
                tried.add((axes, positions))
            case = case or study.case(index)
            for rule, broken in rules:
                if (problem := rule.find(case)) is not None:
                    broken[positions] = problem
        for _, relevant, broken in trials if skip else ():
            if relevant and (problem := broken.get(tuple([index[i] for i in relevant]))):
                study.invalid.setdefault(index, problem.sentence)
    listed = not isinstance(study.design, Sampled)

    def gives(blocks: Sequence[Block] | None, name: str) -> bool:
        """Whether the first block gives the value, and nothing fixed does."""
        return name in dict(blocks[0].values if blocks else ()) and name not in study.fixed

    # By subject, then by rule and key: the problem at each combination of the other values.
    broken_rules: dict[str, dict[tuple[int, str], list[tuple[Problem, str]]]] = {}
    for trial, (_, relevant, broken) in enumerate(trials):
        for positions, problem in broken.items() if not (skip and relevant) else ():
            # The place in the file to mend, and the values at which the rule breaks.
            key = "output.cycles" if problem.key == "output_cycles" else f"base.{problem.key}"
            if gives(study.fixed.get("blocks"), problem.key):
                key = f"base.blocks[0].{problem.key}"
            others = []
            for axis, position in zip((study.axes[i] for i in relevant), positions, strict=True):
                at = f"[{position}]" if listed else ""
                if axis.key == problem.key:
                    key = f"vary.{axis.name}{at}"
                elif axis.name == "blocks" and gives(axis.values[position], problem.key):
                    key = f"vary.blocks{at}[0].{problem.key}"
                else:
                    others.append(f"{axis.name} = {axis.labels[position]}")
            placed = replace(problem, key=key), ", ".join(others)
            broken_rules.setdefault(problem.key, {}).setdefault((trial, key), []).append(placed)
    for subject, by_key in broken_rules.items():
        for (problem, at), *more in [*by_key.values()][:_LISTED_PER_RULE]:
            also = f", and at {len(more)} more combinations" if more[1:] else ""
            also = f", and at {more[0][1]}" if more and not more[1:] else also
            where = f" (at {at}{also})" if at else ""
            problems.append(replace(problem, rule=f"{problem.rule}{where}"))
        if (left := len(by_key) - _LISTED_PER_RULE) > 0:
            alike = f"is wrong in the same way for {left} more of the varied values"
            problems.add(f"vary ({subject})", None, alike)


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


def override(
    raw: Mapping[str, object], assignments: Iterable[str]
) -> tuple[dict[str, object], Problems]:
    """Return plain content changed by assignments ``name=value``, and problems of the assignments.

    The new value replaces the value in `base`, and the parameter is no longer varied. Setting one
    of several alternative keys, such as the two tangential ones, drops the others; keys that belong
    to both, such as `rig_stiffness`, stay. ``output.cycles`` and ``title`` can be set too.
    """
    changed, problems = copy.deepcopy(dict(raw)), Problems()
    valid = (*parameter_names(), MATERIAL, "output.cycles", "title")
    for assignment in assignments:
        name, equals, text = assignment.partition("=")
        name = name.strip()
        place = f"{OPTION} {name}"
        if not equals:
            rule = "must have the form name=value"
            problems.add(OPTION, assignment, rule, "such as --set 'load=30 N'")
        elif name not in valid:
            problems.add(place, text, "is not a parameter", valid_words=valid, written=name)
        else:
            with problems.at(place, text):
                value = parse_value(text)
                with problems.at(place, value):
                    assign(changed, name, value)
    return changed, problems


def assign(content: dict[str, object], name: str, value: object) -> None:
    """Give a parameter one value in the plain content of a study file, as for `override`."""
    if name in ("title", "output.cycles"):
        section, _, key = name.partition(".")
        content[section] = {key: value} if key else value
        return
    base, vary = (_mapping(content.get(section)) for section in ("base", "vary"))
    gone = replaced_by(name)
    base = {key: given for key, given in base.items() if key not in gone}
    replaced = tuple(f"{key}." for key in (*gone, name))
    vary = {key: given for key, given in vary.items() if not f"{key}.".startswith(replaced)}
    content |= {"base": base, "vary": vary}
    if SEEDS in (name, f"{name}.seed"):
        content.pop("seeds", None)
    whole, _, part = name.partition(".")
    if part and whole in vary:
        raise QuantityError(f"cannot be set while vary.{whole} varies the whole of it")
    base[whole] = {**_mapping(base.get(whole)), part: value} if part else value
    if not vary:
        del content["vary"]
        if "seeds" not in content:
            # A sampled design with nothing to sample would be an error.
            content.pop("design", None)


def _mapping(given: object) -> Mapping[str, object]:
    return given if isinstance(given, Mapping) else {}


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
        "output": keys_schema(
            {"cycles": SNAPSHOTS_SCHEMA, "stress": StressOutput.section_schema()}
        ),
        "fit": FitRequest.section_schema(),
    }
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
