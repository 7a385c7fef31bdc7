"""The dataset of one case: its parts and views, and comparison with another."""

from __future__ import annotations

import json
import math
from collections.abc import Hashable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import xarray as xr

from fretwear.data.labels import mirrored
from fretwear.results import (
    CYCLE,
    FORCES,
    RESULTS,
    Variable,
    X,
    Y,
    headlines,
)
from fretwear.study.case import Case
from fretwear.units import BY_SI_UNIT, readable_unit

_SAME = 1e-12


FieldsT = TypeVar("FieldsT", xr.Dataset, xr.DataArray)


def line_near_the_middle(values: FieldsT) -> FieldsT:
    """Return fields on the line of cells nearest y = 0; those without y stay as they are."""
    if Y.name not in values.dims:
        return values
    return values.isel({Y.name: int(np.abs(values[Y.name].values).argmin())})


@xr.register_dataset_accessor("fretwear")  # type: ignore[no-untyped-call]
class Accessor:
    """Methods for datasets of fretwear, as ``dataset.fretwear``."""

    def __init__(self, dataset: xr.Dataset) -> None:
        self._dataset = dataset

    @property
    def case(self) -> Case:
        """The case that the dataset belongs to.

        It is a ValueError if this is not the dataset of one case, or one of another version.
        """
        if "parameters" not in self._dataset.attrs:
            raise ValueError("the dataset is not a case: it has no attribute 'parameters'")
        return Case(**json.loads(self._dataset.attrs["parameters"]))

    def full(self) -> xr.Dataset:
        """Return the whole contact; see `mirrored`."""
        return mirrored(self._dataset)

    def in_units(self) -> xr.Dataset:
        """Return the dataset in units for people, such as µm and MPa, named by ``units``.

        Numbers without a unit stay as they are. Each variable has the unit in which its largest
        value is from 1 to 1000; x and y share one, and so do a scalar and its estimated error.
        """
        dataset, converted = self._dataset, dict[Hashable, xr.Variable]()
        positions = [name for name in (X.name, Y.name) if name in dataset.variables]
        for name, variable in dataset.variables.items():
            si_unit = variable.attrs.get("units", "")
            if si_unit == "1" or si_unit not in BY_SI_UNIT or variable.dtype.kind != "f":
                continue
            scalar = str(name).removesuffix("_error")
            alike = positions if name in positions else [scalar if scalar in dataset else name]
            values = np.concatenate([dataset[other].values.ravel() for other in alike])
            unit = readable_unit(values, si_unit)
            attributes = {**variable.attrs, "units": unit.name}
            converted[name] = xr.Variable(variable.dims, variable.data / unit.size, attributes)
        coordinates = {name: converted.pop(name) for name in dataset.coords if name in converted}
        return dataset.assign(converted).assign_coords(coordinates)

    def map(self, name: str, cycle: float | None = None) -> xr.DataArray:
        """Return a field of the whole contact over y and x, in units for people.

        Its ``plot()`` has the slip direction to the right. ``cycle`` selects the nearest snapshot,
        the last one by default.
        """
        kept = {X.name, Y.name, CYCLE.name}
        field = self._dataset[[name]].drop_vars(self._dataset.coords.keys() - kept)
        field = field.isel(cycle=-1) if cycle is None else field.sel(cycle=cycle, method="nearest")
        return Accessor(mirrored(field)).in_units()[name].transpose(Y.name, X.name)


@dataclass(frozen=True)
class Compared:
    """One result in two cases."""

    variable: Variable
    first: float  # in its SI unit
    second: float
    errors: tuple[float, float] = (0.0, 0.0)  # of both; zero if not estimated

    @property
    def ratio(self) -> float:
        """Second over first; NaN if the first is zero."""
        return self.second / self.first if self.first else math.nan


def compared_cycles(first: xr.Dataset, second: xr.Dataset) -> tuple[int, int]:
    """Return the cycles at which two cases are compared.

    It is the last snapshot that both have or, if they share only cycle 0, the last one of each.
    """
    mine, other = ({int(cycle) for cycle in case["cycle"].values} for case in (first, second))
    common = max(mine & other, default=0)
    return (common, common) if common else (max(mine), max(other))


def compared_results(first: xr.Dataset, second: xr.Dataset) -> list[Compared]:
    """Return key results of two cases at `compared_cycles`, and forces if they are results."""
    cycles = compared_cycles(first, second)
    states = [case.sel(cycle=cycle) for case, cycle in zip((first, second), cycles, strict=True)]
    results = []
    given = first.coords.keys() & second.coords.keys()
    forces = [name for key, names in FORCES.items() if key not in given for name in names]
    others = "plastic_volume", "central_pressure", "peak_pressure"
    for name in (*headlines([str(name) for name in first if name in second]), *others, *forces):
        variable = RESULTS[name]
        if all(variable.name in state for state in states):
            units = states[0][variable.name].attrs.get("units", variable.si_unit)
            a, b = (float(state[variable.name]) for state in states)
            error = variable.error.name
            apart = [float(state[error]) if error in state else 0.0 for state in states]
            results.append(Compared(variable.in_units(units), a, b, (apart[0], apart[1])))
    return results


def different_parameters(first: xr.Dataset, second: xr.Dataset) -> list[str]:
    """Return the parameters of two cases that differ, in the order of the first."""
    mine, other = (
        {
            str(name): value.item()
            for name, value in case.coords.items()
            if not value.dims and name != CYCLE.name
        }
        for case in (first, second)
    )
    return [name for name in {**mine, **other} if not _agree(mine.get(name), other.get(name))]


def _agree(first: float | str | None, second: float | str | None) -> bool:
    if isinstance(first, int | float) and isinstance(second, int | float):
        return math.isclose(first, second, rel_tol=_SAME)
    return first == second
