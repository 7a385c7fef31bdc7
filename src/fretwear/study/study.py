"""Studies: their points and the cases of these, from values read and checked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any
from weakref import WeakValueDictionary

from fretwear.plugins import StudySection
from fretwear.study.case import Case, case_keys
from fretwear.study.designs import Axis, Design, Sobol
from fretwear.study.problems import Problems, in_words

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
    fixed: Mapping[str, Any]  # values of the other keys in SI units
    content: Mapping[str, Any]  # plain content of the file, overrides included
    snapshots: tuple[int, ...] | None = None  # cycles at which fields are kept; None: about eight
    batch: int | None = None  # cases per job; None: as many as take a few minutes
    # Sections of packages beside the core, by their place in the file.
    added: Mapping[str, StudySection] = field(default_factory=dict)
    # Points left out, with the reason.
    invalid: dict[tuple[int, ...], str] = field(default_factory=dict)

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
            given = base.get(axis.key)
            if "." in axis.name:
                given = as_mapping(given).get(axis.name.partition(".")[2])
            if given is not None:
                text = f"base.{axis.name} = {in_words(given)}"
                sentences.append(f"{text} is not used, because {axis.name} is varied")
        return sentences

    def points(self, first: int = 1, last: int | None = None) -> tuple[Point, ...]:
        """Return the points in order, or those from a first to a last number, counted from 1."""
        return self._points[first - 1 : last]

    def cases(self) -> dict[str, Case]:
        """Return the cases to run by id, each once even if several points share it."""
        return {point.id: point.case for point in self.points() if point.case is not None}

    def case(self, index: tuple[int, ...], problems: Problems | None = None) -> Case | None:
        """Return the case of a point, whose rules are not checked.

        It is None if a part cannot be made of the values; `problems` then say why.
        """
        if (case := self._held.get(index)) is None:
            values, wrong = self._values(index), Problems() if problems is None else problems
            members = case_keys().members_of(values, values, wrong, "base.")
            if wrong:
                return None
            self._held[index] = case = Case.of({**members, "output_cycles": self.snapshots})
        return case

    @cached_property
    def _held(self) -> WeakValueDictionary[tuple[int, ...], Case]:
        """The cases that somebody holds, by the index of their point."""
        return WeakValueDictionary()

    def _values(self, index: tuple[int, ...]) -> dict[str, Any]:
        """The values of the keys of the case of a point, varied fields of parts among them."""
        values = dict(self.fixed)
        for axis, position in zip(self.axes, index, strict=True):
            whole, _, field = axis.name.partition(".")
            value = axis.values[position]
            if field:
                part = values[whole]
                value = type(part).unchecked(**{**vars(part), field: value})
            values[whole] = value
        return values


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
