"""Where the points of a study stand in a merged dataset, and what is told of each."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from fretwear.data.labels import Column
from fretwear.vocabulary import CASE_ID, POINT, Field, Variable

if TYPE_CHECKING:
    from fretwear.study.points import Axis, Point
    from fretwear.study.study import Study

NOT_DONE = -1
"""What ``contact_state`` is at points and cycles that are not there; other fields are NaN."""


def missing(field: Field) -> float:
    """Return what a field is at points and cycles that are not there."""
    return NOT_DONE if field.flags else math.nan


@dataclass(frozen=True)
class StudyLayout:
    """The place of each point of a study in a merged dataset.

    A grid has one dimension for each varied name, in the order of the study. Every other design
    has the one dimension ``point``, with the varied values along it.
    """

    study: Study

    @property
    def is_grid(self) -> bool:
        """Whether the points are all combinations of the varied values."""
        return self.study.design.kind == "grid" or not self.study.axes

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the dimensions."""
        return tuple(self._axes) if self.is_grid else (POINT.name,)

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the dimensions."""
        return self.study.shape if self.study.axes else ()

    def points(self) -> Iterator[tuple[tuple[int, ...], Point]]:
        """Iterate over the points, each with its position along the dimensions."""
        for number, point in enumerate(self.study.points()):
            yield (point.index if self.is_grid else (number,)), point

    def coordinates(self) -> dict[str, Column]:
        """Coordinates: varied values, case ids, and the parameters that all cases share.

        Varied values that are not single numbers (a roughness, a pair of moduli) are text, as
        written in the study file.
        """
        found = {name: self._varied(axis) for name, axis in self._axes.items()}
        if not self.is_grid:
            numbers = np.arange(*self.shape, dtype=POINT.dtype)
            found[POINT.name] = Column((POINT.name,), numbers, POINT.attributes)
        ids = np.full(self.shape, "", dtype=object)
        for position, point in self.points():
            ids[position] = point.id
        found[CASE_ID.name] = Column(self.dims, ids.astype(str), CASE_ID.attributes)
        shared = {name: each for name, each in self._parameters.items() if not each.dims}
        return {**found, **shared, **found}

    def dependent(self) -> dict[str, Column]:
        """Parameters that depend on the varied ones, as the Hertz radius does on the load.

        They have the dimensions of the study, with NaN or empty text where a point has none.
        """
        varied = {axis.coordinate for axis in self.study.axes}
        return {
            name: each
            for name, each in self._parameters.items()
            if each.dims and name not in varied
        }

    @property
    def _axes(self) -> dict[str, Axis]:
        return {axis.coordinate: axis for axis in self.study.axes}

    @cached_property
    def _parameters(self) -> dict[str, Column]:
        """Every parameter of the cases: a scalar where they share it, else along the points."""
        cases = {place: point.case for place, point in self.points() if point.case is not None}
        labels: dict[str, Variable] = {}
        columns: dict[str, dict[tuple[int, ...], Any]] = {}
        for place, case in cases.items():
            for name, (value, units, long_name) in case.scalar_coordinates().items():
                is_text = isinstance(value, str)
                labels.setdefault(name, Variable(name, "" if is_text else units, words=long_name))
                columns.setdefault(name, {})[place] = value
        found = {}
        for name, given in columns.items():
            is_text = any(isinstance(value, str) for value in given.values())
            dims: tuple[str, ...] = ()
            if len(given) == len(cases) and len(set(given.values())) == 1:
                values = np.array(next(iter(given.values())), dtype=str if is_text else np.float64)
            else:
                dims, values = self.dims, np.full(self.shape, "" if is_text else math.nan, object)
                for place, value in given.items():
                    values[place] = value
                values = values.astype(str if is_text else np.float64)
            found[name] = Column(dims, values, labels[name].attributes)
        return found

    def _varied(self, axis: Axis) -> Column:
        known = self._parameters.get(axis.coordinate)
        attributes = {"long_name": axis.name} if known is None else dict(known.attrs)
        values = np.array(axis.labels, dtype=str)
        if all(isinstance(value, int | float) for value in axis.values):
            values = np.array(axis.values, dtype=np.float64)
        elif all(isinstance(value, str) for value in axis.values):
            values = np.array(axis.values, dtype=str)
        else:
            attributes.pop("units", None)
        if axis.drawn_from is not None:
            attributes |= {
                "drawn_from": axis.drawn_from.low,
                "drawn_to": axis.drawn_from.high,
                "drawn_on": "log" if axis.drawn_from.logarithmic else "linear",
            }
        return Column((axis.coordinate if self.is_grid else POINT.name,), values, attributes)
