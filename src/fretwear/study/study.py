"""Studies: their points and the cases of these, from values read and checked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any
from weakref import WeakValueDictionary

from fretwear.plugins import StudySection
from fretwear.quantity import Part
from fretwear.study.case import Case
from fretwear.study.contact import case_keys
from fretwear.study.designs import Axis, Design, Sobol
from fretwear.study.problems import Problems, few_of, html_table, in_words

_MOST_SHOWN = 12
ALL_POINTS = (1, None)
"""The first and the last number of all points of a study."""


def as_mapping(given: object) -> Mapping[str, Any]:
    """The content of a section, empty if it is no mapping."""
    return given if isinstance(given, Mapping) else {}


@dataclass(frozen=True)
class Study:
    """A study: every value is read, and `load_study` checks the rules at the points asked for."""

    file: Path  # the file it was read from
    title: str  # for people
    axes: tuple[Axis, ...]  # the varied parameters in the order of the file
    design: Design  # how the varied values are combined
    fixed: Mapping[str, Any]  # values of the other keys in SI units; of a varied part, as written
    content: Mapping[str, Any]  # plain content of the file, overrides included
    snapshots: tuple[int, ...] | None = None  # cycles at which fields are kept; None: about eight
    batch: int | None = None  # cases per job; None: as many as take a few minutes
    # Sections of packages beside the core, by their place in the file.
    added: Mapping[str, StudySection] = field(default_factory=dict)
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
    def remarks(self) -> list[str]:
        """Sentences on what the file says without effect, or not as well as it could."""
        sentences, base = list[str](), as_mapping(self.content.get("base"))
        if isinstance(self.design, Sobol) and (number := self.design.points) & (number - 1):
            below = 1 << (number.bit_length() - 1)
            sentences.append(
                f"design.points = {number} is not a power of two, so the Sobol sequence fills the "
                f"ranges unevenly; {below} or {2 * below} points do it evenly"
            )
        for axis in self.axes:
            given = {axis.key: base.get(axis.key)}
            if "." in axis.name:
                given = {f"{axis.key}.{n}": v for n, v in as_mapping(given[axis.key]).items()}
            if (value := given.get(axis.name)) is not None:
                text = f"base.{axis.name} = {in_words(value)}"
                sentences.append(f"{text} is not used, because {axis.name} is varied")
        vary = {axis.key for axis in self.axes}
        is_none = "accuracy" not in vary and in_words(base.get("accuracy")) == "none"
        reason = "accuracy is none" if is_none else ""
        reason = "cell is given" if "cell" in {*base, *vary} else reason
        for name in ("accuracy", "budget") if reason else ():
            place = "vary" if name in vary else "base"
            value = as_mapping(self.content.get(place)).get(name)
            if value is not None and in_words(value) != "none":
                text = f"{place}.{name} = {in_words(value)}"
                sentences.append(f"{text} is not used, because {reason}")
        return sentences

    def points(self, first: int = 1, last: int | None = None) -> tuple[Point, ...]:
        """Return the points in order, or those from a first to a last number, counted from 1."""
        return self._points[first - 1 : last]

    def cases(self) -> dict[str, Case]:
        """Return the cases to run by id, each once even if several points share it."""
        return {point.id: point.case for point in self.points() if point.case is not None}

    def case(self, index: tuple[int, ...]) -> Case:
        """Return the case of a point, whose rules are not checked."""
        if (case := self._held.get(index)) is None:
            problems = Problems()
            parts = self.members(index, problems)
            assert not problems, problems
            self._held[index] = case = Case.of({**parts, "output_cycles": self.snapshots})
        return case

    @cached_property
    def _held(self) -> WeakValueDictionary[tuple[int, ...], Case]:
        """The cases that somebody holds, by the index of their point."""
        return WeakValueDictionary()

    def members(self, index: tuple[int, ...], problems: Problems) -> dict[str, Any]:
        """The members of the case of a point, by name; problems of its values are collected."""
        values, fields = dict(self.fixed), dict[str, dict[str, Any]]()
        for axis, position in zip(self.axes, index, strict=True):
            whole, _, part = axis.name.partition(".")
            if part:
                fields.setdefault(whole, {})[part] = axis.values[position]
            else:
                values[axis.name] = axis.values[position]
        for whole, varied in fields.items():
            if isinstance(values.get(whole), Part):
                changed = {**vars(values[whole]), **varied}
                values[whole] = type(values[whole]).unchecked(**changed)
                continue
            content = {**as_mapping(values.pop(whole, {})), **varied}
            with problems.at(f"base.{whole}", None):
                values[whole] = case_keys()[whole].read(content)
        return case_keys().members_of(values, {*values, *fields}, problems, "base.")


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
