"""Study files: from YAML to a `Study`, with everything that is wrong said at once."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any

from fretwear.study.axes import read_axes
from fretwear.study.case import Case
from fretwear.study.designs import Design
from fretwear.study.document import read_document
from fretwear.study.override import override, renamed
from fretwear.study.parameters import ROUGHNESS
from fretwear.study.points import Axis, Parameters, Point, PointFinding
from fretwear.study.problems import Problem, StudyError, shown
from fretwear.study.sections import Draft, read_sections, section

__all__ = ["Problem", "Study", "StudyError", "load_study"]

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,99}")
_LISTED_PER_RULE = 8


@dataclass(frozen=True)
class Study:
    """A sound study: every value read, every rule tried.

    Attributes
    ----------
    file : Path
        Where it came from.
    name : str
        Stem of the file name; names the folder of the results.
    title : str
        For people.
    axes : tuple of Axis
        The varied parameters in the order of the file.
    design : Design
        How their values are combined.
    parameters : Parameters
        Fixed values, axes, and the points as positions along the axes.
    invalid : dict
        Points left out under ``invalid: skip``, with the reason.
    content : dict
        The plain content of the file, overrides included.
    batch : int or None
        Cases of a job; None: as many as take a few minutes.
    """

    file: Path
    name: str
    title: str
    axes: tuple[Axis, ...]
    design: Design
    parameters: Parameters
    invalid: Mapping[tuple[int, ...], str]
    content: Mapping[str, Any]
    batch: int | None = None

    @property
    def size(self) -> int:
        """Number of points."""
        return len(self.parameters.indices)

    @cached_property
    def _points(self) -> tuple[Point, ...]:
        return tuple(self.parameters.points(self.invalid))

    def points(self, first: int = 1, last: int | None = None) -> tuple[Point, ...]:
        """Return the points in order, the last varied parameter fastest.

        Parameters
        ----------
        first, last : int
            Numbers of the first and the last of neighbouring points, counted from 1; a few points
            of a large study come much sooner than all of them.
        """
        last = self.size if last is None else last
        if (first, last) == (1, self.size):
            return self._points
        few = replace(self.parameters, indices=self.parameters.indices[first - 1 : last])
        return tuple(few.points(self.invalid))

    def cases(self) -> dict[str, Case]:
        """Return the cases to run by id: each once, even where several points come to it."""
        return {point.id: point.case for point in self.points() if point.case is not None}

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the axes of a grid; the number of points for every other design."""
        if self.design.kind == "grid":
            return tuple(len(axis.values) for axis in self.axes)
        return (self.size,)


def load_study(path: str | Path, assignments: Sequence[str] = ()) -> Study:
    """Read and check a study file.

    Parameters
    ----------
    path : str or Path
        The YAML file.
    assignments : sequence of str
        Changes ``name=value`` to it, see `override`.

    Raises
    ------
    StudyError
        With everything that is wrong with the file and the assignments.
    """
    file = Path(path)
    document = read_document(file)
    problems = [*_name_problems(file), *document.problems]
    if not isinstance(document.data, Mapping):
        rule = "must hold keys such as base and vary, not a single value or a list"
        raise StudyError(file, [Problem("", shown(document.data), rule), *problems])
    content, wrong_assignments = override(document.data, assignments)
    problems += wrong_assignments
    return check_content(file, content, problems, document.lines, assignments)


def check_content(
    file: Path,
    content: Mapping[str, Any],
    problems: Sequence[Problem] = (),
    lines: Mapping[str, int] = MappingProxyType({}),
    assignments: Sequence[str] = (),
) -> Study:
    """Turn the plain content of a study file into a `Study`.

    Parameters
    ----------
    file : Path
        For messages and the name of the study.
    content : dict
        The content, assignments already applied.
    problems : sequence of Problem
        Problems found so far; they are raised together with those found here.
    lines : dict
        Line in the file by dotted key.
    assignments : sequence of str
        The assignments, so that messages can name them.

    Raises
    ------
    StudyError
        With everything that is wrong.
    """
    draft = read_sections(content, file.stem)
    axes = read_axes(section(content, "vary", draft), draft.design, draft.problems)
    roughness_sound = not any(_is_about_roughness(problem.key) for problem in draft.problems)
    fixed = {name: v for name, v in draft.fixed.items() if roughness_sound or "." not in name}
    axes = tuple(axis for axis in axes if roughness_sound or "." not in axis.name)
    indices = list(draft.design.indices([len(axis.values) for axis in axes]))
    parameters = Parameters(fixed, axes, indices)
    invalid = _try_rules(parameters, draft)
    found = [*problems, *draft.problems]
    if not found and len(invalid) == len(indices):
        rule = f"leaves no point to run: {next(iter(invalid.values()))}"
        found.append(Problem("vary", "", rule))
    if found:
        raise StudyError(file, _in_order(found, lines, assignments))
    return Study(
        file=file,
        name=file.stem,
        title=draft.title,
        axes=axes,
        design=draft.design,
        parameters=parameters,
        invalid=invalid,
        content=content,
        batch=draft.batch,
    )


def _name_problems(file: Path) -> list[Problem]:
    if _NAME.fullmatch(file.stem):
        return []
    rule = (
        "names the folder of its results: the file name may have letters, digits, '.', '_' and "
        "'-', up to 100, and must begin with a letter or digit"
    )
    return [Problem("", "", f"{file.name!r} {rule}", "rename the file")]


def _is_about_roughness(key: str) -> bool:
    return key.startswith((f"base.{ROUGHNESS}", f"vary.{ROUGHNESS}"))


def _try_rules(parameters: Parameters, draft: Draft) -> dict[tuple[int, ...], str]:
    """Try the rules between parameters; return the points to skip, report all others."""
    invalid: dict[tuple[int, ...], str] = {}
    listed: dict[str, int] = {}
    for found, points in parameters.find():
        if draft.skip_invalid and found.where:
            for index in points:
                invalid.setdefault(index, found.finding.sentence())
            continue
        subject = found.finding.subject
        listed[subject] = listed.get(subject, 0) + 1
        if listed[subject] <= _LISTED_PER_RULE:
            draft.problems.append(_point_problem(found, draft.design))
    for subject, count in listed.items():
        if count > _LISTED_PER_RULE:
            more = count - _LISTED_PER_RULE
            rule = f"is wrong in the same way at {more} more combinations of the varied values"
            draft.problems.append(Problem(f"vary ({subject})", "", rule))
    return invalid


def _point_problem(found: PointFinding, design: Design) -> Problem:
    """Say where in the file a broken rule is to be mended, and at which values it breaks."""
    finding = found.finding
    key = f"base.{finding.subject}"
    if finding.subject == "output_cycles":
        key = "output.cycles"
    others = []
    for axis, position in found.where:
        if axis.field == finding.subject:
            key = f"vary.{axis.name}" + ("" if design.is_sampled else f"[{position}]")
        else:
            others.append(f"{axis.name} = {axis.labels[position]}")
    at = f" (at {', '.join(others)})" if others else ""
    return Problem(key, finding.value, f"{finding.rule}{at}", finding.hint)


def _in_order(
    problems: Iterable[Problem], lines: Mapping[str, int], assignments: Sequence[str]
) -> list[Problem]:
    placed = []
    for problem in problems:
        key = renamed(problem.key, assignments)
        line = problem.line
        if line is None and key == problem.key:
            line = lines.get(key) if key else None
        placed.append(replace(problem, key=key, line=line))
    return sorted(placed, key=lambda problem: problem.line or len(lines) * 1000)
