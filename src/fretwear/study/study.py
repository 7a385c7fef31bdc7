"""Studies: their points and cases, from values read and checked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from copy import copy
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from fretwear.study.case import Case, assembled
from fretwear.study.designs import Axis, Design
from fretwear.study.mistakes import Mistake, Mistakes
from fretwear.study.parameters import value_text, words_text
from fretwear.study.sections import StudySection
from fretwear.units import in_unit


def as_mapping(value: object) -> Mapping[str, object]:
    """The content of a section, empty if it is no mapping."""
    return value if isinstance(value, Mapping) else {}


@dataclass(frozen=True)
class Study:
    """A study: every value is read, and `load_study` checks the rules at its points."""

    file: Path  # the file it was read from
    title: str  # for people
    axes: tuple[Axis, ...]  # the varied parameters in the order of the file
    design: Design  # combination of the varied values
    fixed: Mapping[str, object]  # values of the other keys in SI units
    content: Mapping[str, object]  # plain content of the file, overrides included
    snapshots: tuple[int, ...] | None = None  # cycles at which fields are kept; None: about eight
    batch: int | None = None  # cases per job; None: as many as take a few minutes
    # Sections of packages beside the core, by their place in the file.
    added: Mapping[str, StudySection] = field(default_factory=dict)
    unread: Set[str] = frozenset()  # keys with wrong values; empty for a study that can be run
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

    def points(self) -> tuple[Point, ...]:
        """Return the points in order."""
        return self._points

    def cases(self) -> dict[str, Case]:
        """Return the cases to run by id, each once even if several points share it."""
        return {point.id: point.case for point in self.points() if point.case is not None}

    def values(self, index: tuple[int, ...]) -> dict[str, Any]:
        """The values of the keys of the case of a point, including varied fields of parts."""
        values: dict[str, Any] = dict(self.fixed)
        for axis, position in zip(self.axes, index, strict=True):
            whole, _, field = axis.name.partition(".")
            value = axis.values[position]
            if field:
                if (part := values.get(whole)) is None:
                    continue  # it could not be read
                value = type(part).unchecked(**{**vars(part), field: value})
            values[whole] = value
        return values


@dataclass(frozen=True)
class Point:
    """One point of a study."""

    study: Study = field(repr=False)
    index: tuple[int, ...]  # position along each axis (zip and sampled designs: the same along all)

    @property
    def mistake(self) -> str:
        """Why the point is invalid; empty if it is valid."""
        return self.study.invalid.get(self.index, "")

    @property
    def case(self) -> Case | None:
        """The case to run; None if the point is invalid."""
        case, lacking, _ = self._unchecked
        return None if lacking or self.mistake else case

    @property
    def mistakes(self) -> list[Mistake]:
        """Why the values make no case; rules between them are included."""
        case, lacking, found = self._unchecked
        return [*found, *case.mistakes(lacking)]

    @cached_property
    def _unchecked(self) -> tuple[Case, Set[str], Mistakes]:
        """The case before its rules are checked, its unknown members, and mistakes."""
        study = self.study
        members, lacking, found = assembled(study.values(self.index), study.unread, study.snapshots)
        return Case(members), lacking, found

    @cached_property
    def id(self) -> str:
        """Case id, empty if the point is invalid. Points may share a case."""
        return case.case_id if (case := self.case) is not None else ""

    @property
    def values(self) -> dict[str, object]:
        """Varied parameters by dotted name, in SI units."""
        return {a.name: a.values[i] for a, i in zip(self.study.axes, self.index, strict=True)}

    def scalar_coordinates(self) -> dict[str, tuple[float | str, str, str]]:
        """Those of the case, numbers as floats; none if the point is invalid."""
        # A copy takes what it has derived with it.
        stored = copy(self.case).scalar_coordinates() if self.case is not None else {}
        return {
            name: (value if isinstance(value, str) else float(value), unit, words)
            for name, (value, unit, words) in stored.items()
        }

    @property
    def words(self) -> str:
        """The varied values of the point, for people: ``40 N, 0.4 µm, elastic``."""
        texts = []
        for axis, place in zip(self.study.axes, self.index, strict=True):
            if len(axis.values) < 2:
                continue
            value, name = axis.values[place], axis.coordinate
            if not isinstance(value, float | int | str):
                texts.append(f"{axis.name} {axis.labels[place]}")
                continue
            if axis.drawn_from is not None:
                value = in_unit(float(f"{value:.3g}"), getattr(value, "si_unit", ""))
            text = value_text(name, value)
            texts.append(words_text(name, value) if text[-1].isdigit() else text)
        return ", ".join(texts)

    @property
    def labels(self) -> dict[str, str]:
        """Varied parameters by dotted name, as written in the file."""
        return {a.name: a.labels[i] for a, i in zip(self.study.axes, self.index, strict=True)}
