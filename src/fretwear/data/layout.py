"""The points of a study as the dimensions and coordinates of a merged dataset."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from fretwear.data.variables import Variable

if TYPE_CHECKING:
    from fretwear.study.file import Study
    from fretwear.study.points import Axis, Point

POINT = Variable("point", "1", "point of the study", dtype="int32")
CASE_ID = Variable("case_id", "", "id of the case and name of its file")


@dataclass(frozen=True)
class StudyLayout:
    """Where each point of a study stands in a merged dataset.

    A grid has one dimension for each varied name, in the order of the study. Every other design
    has the one dimension ``point``, with the varied values along it.

    Attributes
    ----------
    study : Study
        The study.
    """

    study: Study

    @property
    def is_grid(self) -> bool:
        """Whether the points are every combination of the varied values."""
        return self.study.design.kind == "grid" or not self.study.axes

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the dimensions."""
        if self.is_grid:
            return tuple(axis.coordinate for axis in self.study.axes)
        return (POINT.name,)

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the dimensions."""
        return self.study.shape if self.study.axes else ()

    def points(self) -> Iterator[tuple[tuple[int, ...], Point]]:
        """Iterate over the points, each with its position along the dimensions."""
        for number, point in enumerate(self.study.points()):
            yield (point.index if self.is_grid else (number,)), point

    def cycles(self) -> tuple[int, ...]:
        """Every cycle at which some case keeps its fields, in order."""
        cases = self.study.cases().values()
        return tuple(sorted({cycle for case in cases for cycle in case.output_cycles}))

    def coordinates(self) -> dict[str, xr.Variable]:
        """Coordinates: varied values, case ids, and the parameters that all cases share.

        Varied values that are not single numbers (a roughness, a pair of moduli) are text, in the
        words of the study file.
        """
        found = {
            axis.coordinate: self._varied(axis, self._parameters.get(axis.coordinate))
            for axis in self.study.axes
        }
        if not self.is_grid:
            numbers = np.arange(*self.shape, dtype=POINT.dtype)
            found[POINT.name] = xr.Variable((POINT.name,), numbers, POINT.attributes)
        ids = np.full(self.shape, "", dtype=object)
        for position, point in self.points():
            ids[position] = point.id
        found[CASE_ID.name] = xr.Variable(self.dims, ids.astype(str), CASE_ID.attributes)
        for parameter in self._unvaried:
            if parameter.is_shared:
                value = np.array(next(iter(parameter.distinct)))
                value = value if value.dtype.kind == "U" else value.astype(np.float64)
                found[parameter.label.name] = xr.Variable((), value, parameter.label.attributes)
        return found

    def following(self) -> dict[str, xr.Variable]:
        """Parameters that follow from the varied ones, as the Hertz radius does from the load.

        They lie along the dimensions of the study, NaN or empty where a point has none.
        """
        return {
            parameter.label.name: xr.Variable(
                self.dims, parameter.typed(), parameter.label.attributes
            )
            for parameter in self._unvaried
            if not parameter.is_shared
        }

    @property
    def _unvaried(self) -> list[_Parameter]:
        varied = {axis.coordinate for axis in self.study.axes}
        return [found for name, found in self._parameters.items() if name not in varied]

    @cached_property
    def _parameters(self) -> dict[str, _Parameter]:
        valid = [(place, point.case) for place, point in self.points() if point.case is not None]
        found: dict[str, _Parameter] = {}
        for place, case in valid:
            for name, (value, units, long_name) in case.scalar_coordinates().items():
                if name not in found:
                    label = Variable(name, "" if isinstance(value, str) else units, long_name)
                    found[name] = _Parameter(label, np.full(self.shape, None), len(valid))
                found[name].values[place] = value
        return found

    def _varied(self, axis: Axis, parameter: _Parameter | None) -> xr.Variable:
        dims = (axis.coordinate,) if self.is_grid else (POINT.name,)
        label = parameter.label if parameter else Variable(axis.coordinate, "", axis.name)
        if all(isinstance(value, int | float) for value in axis.values):
            return xr.Variable(dims, np.array(axis.values, dtype=np.float64), label.attributes)
        if all(isinstance(value, str) for value in axis.values):
            return xr.Variable(dims, np.array(axis.values, dtype=str), label.attributes)
        words = Variable(axis.coordinate, "", label.long_name)
        return xr.Variable(dims, np.array(axis.labels, dtype=str), words.attributes)


@dataclass(frozen=True)
class _Parameter:
    """One parameter of all cases: None where a point is invalid or its case has no such one."""

    label: Variable
    values: NDArray[Any]
    cases: int

    @cached_property
    def distinct(self) -> set[float | str]:
        return set(self._given)

    @property
    def is_shared(self) -> bool:
        return len(self.distinct) == 1 and len(self._given) == self.cases

    @property
    def _given(self) -> list[float | str]:
        return [value for value in self.values.ravel() if value is not None]

    def typed(self) -> NDArray[Any]:
        empty = "" if any(isinstance(value, str) for value in self.distinct) else np.nan
        filled = [empty if value is None else value for value in self.values.ravel()]
        return np.array(filled).reshape(self.values.shape)
