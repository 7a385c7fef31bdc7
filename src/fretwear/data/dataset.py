"""The dataset of one case: its parts and views."""

from __future__ import annotations

import json
from collections.abc import Hashable
from pathlib import Path
from typing import TypeVar

import numpy as np
import xarray as xr

from fretwear.data.groups import LEVELS, open_group
from fretwear.data.labels import mirrored
from fretwear.quantity import Parameter, Quantity
from fretwear.results import (
    CASE_ID,
    CYCLE,
    STATUS,
    PointStatus,
    X,
    Y,
    contact_frame,
)
from fretwear.study.case import Case
from fretwear.study.keys import coordinate
from fretwear.study.parameters import parameter
from fretwear.units import BY_SI_UNIT, did_you_mean, readable_unit

FieldsT = TypeVar("FieldsT", xr.Dataset, xr.DataArray)


def line_near_the_middle(values: FieldsT) -> FieldsT:
    """Return fields on the line of cells nearest y = 0; fields without y are unchanged."""
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

        Raises a ValueError if this is not the dataset of one case, or one of another version.
        """
        if "parameters" not in self._dataset.attrs:
            remedy = "point(normal_load='50 N') of its accessor opens a case of a study"
            raise ValueError(f"the dataset is not a case: it lacks 'parameters'; {remedy}")
        return Case(**json.loads(self._dataset.attrs["parameters"]))

    def sel(self, **levels: object) -> xr.Dataset:
        """Select points of a study by parameters as in its file: ``plastic_limit="none"``.

        Values are numbers in SI units, text with units, words, lists of these or slices; `load`
        stands for ``normal_load``. A ValueError names the varied parameters, or the levels of one.
        """
        found = self._dataset
        for key, level in levels.items():
            name = coordinate(key)
            if name not in found.coords or not found[name].dims:
                names = [str(n) for n, axis in found.coords.items() if axis.dims]
                known = did_you_mean(key, [*names, "load"]) or f"coordinates are {', '.join(names)}"
                if name in found.coords:
                    known = f"it is {found[name].item()} everywhere"
                raise ValueError(f"{key} does not vary; {known}")
            try:
                value = self._stored(found[name], level)
                if name in found.indexes:
                    found = found.sel({name: value})
                else:
                    (dim,), values = found[name].dims, found[name].values
                    if isinstance(value, slice):
                        first, last = value.start, value.stop
                        kept = values >= (values if first is None else first)
                        kept &= values <= (values if last is None else last)
                    else:
                        kept = np.isin(values, np.asarray(value))
                    if not (places := np.flatnonzero(kept)).size:
                        raise KeyError(level)
                    found = found.isel({dim: places})
            except (KeyError, ValueError) as error:
                there = ", ".join(self._texts(found[name]))
                raise ValueError(f"{key} = {level!r}: the study has {there}") from error
        return found

    def _stored(self, axis: xr.DataArray, level: object) -> object:
        """Return a level as stored in a coordinate, from text as in a study file."""
        if isinstance(level, slice):
            return slice(*(self._stored(axis, end) for end in (level.start, level.stop)))
        if isinstance(level, list | tuple):
            return [self._stored(axis, each) for each in level]
        if isinstance(level, bool):
            return float(level)
        if not isinstance(level, str) or axis.dtype.kind in "OU":
            return level
        if level in (texts := self._texts(axis)):
            place = texts.index(level)
            return place if LEVELS in axis.attrs else axis.values[place]
        declaration = self._declaration(axis)
        return declaration.single.read(level) if isinstance(declaration, Quantity) else float(level)

    def _texts(self, axis: xr.DataArray) -> list[str]:
        """The levels of a coordinate in words, as messages show them."""
        if LEVELS in axis.attrs:
            return str(axis.attrs[LEVELS]).split("\n")
        is_text = axis.dtype.kind in "OU"
        return [*map(str if is_text else self._declaration(axis).text, axis.values.tolist())]

    def _declaration(self, axis: xr.DataArray) -> Parameter:
        return parameter(str(axis.name)).in_frame(contact_frame(self._dataset.variables))

    def point(self, **levels: object) -> xr.Dataset:
        """Open the case of a point of a study, lazily: ``open_study(…).fretwear.point(load=50)``.

        Levels as for `sel` name the point; the file of the case lies beside the ``summary.nc`` of
        the dataset. A ValueError names parameters without a level, or says that the point failed.
        """
        here, source = self.sel(**levels), self._dataset.encoding.get("source", "")
        if CASE_ID.name not in here or STATUS.name not in here or not source:
            raise ValueError("the dataset is not a study opened from its summary.nc")
        if here[CASE_ID.name].size != 1:
            dims = {*here[STATUS.name].dims}
            names = [str(n) for n, c in here.coords.items() if {*c.dims} & dims and n != "case_id"]
            more = f"{here[CASE_ID.name].size} points are left, which differ in {', '.join(names)}"
            raise ValueError(f"{more}: name levels of these as well")
        case_id = str(here[CASE_ID.name].values.item())
        if here[STATUS.name].values.item() != PointStatus.DONE:
            raise ValueError(f"the point {case_id or levels} has no results; see its log")
        return open_group(Path(source).parent / "cases" / f"{case_id}.nc")

    def full(self) -> xr.Dataset:
        """Return the whole contact; see `mirrored`."""
        return mirrored(self._dataset)

    def in_units(self) -> xr.Dataset:
        """Return the dataset in units for people, such as µm and MPa, named by ``units``.

        Numbers without a unit are unchanged. Each variable gets the unit in which its largest value
        is from 1 to 1000; x and y share one, and so do a scalar and its estimated error.
        """
        dataset, converted = self._dataset, dict[Hashable, xr.Variable]()
        positions = [name for name in (X.name, Y.name) if name in dataset.variables]
        for name, variable in dataset.variables.items():
            si_unit = variable.attrs.get("units", "")
            if si_unit == "1" or si_unit not in BY_SI_UNIT or variable.dtype.kind != "f":
                continue
            scalar = str(name).removesuffix("_error")
            alike = positions if name in positions else [scalar if scalar in dataset else name]
            values = np.concatenate([dataset[member].values.ravel() for member in alike])
            unit = readable_unit(values, si_unit)
            attributes = {**variable.attrs, "units": unit.name}
            converted[name] = xr.Variable(variable.dims, variable.data / unit.size, attributes)
        coordinates = {name: converted.pop(name) for name in dataset.coords if name in converted}
        return dataset.assign(converted).assign_coords(coordinates)

    def map(self, name: str, cycle: float | None = None) -> xr.DataArray:
        """Return a field of the whole contact over y and x, in units for people.

        Its ``plot()`` has the slip direction to the right. ``cycle`` selects the nearest snapshot,
        the last one by default. A ValueError names the fields that lie over x and y.
        """
        fields = [str(n) for n, v in self._dataset.items() if {X.name, Y.name} <= {*v.dims}]
        if name not in fields:
            there = ", ".join(fields) or "none, because a line contact has lines instead of maps"
            raise ValueError(f"{name} is no map; maps are {there}")
        kept = {X.name, Y.name, CYCLE.name}
        if not {*self._dataset[name].dims} <= kept:
            raise ValueError(f"{name} is not over x and y of one case")
        field = self._dataset[[name]].drop_vars(self._dataset.coords.keys() - kept)
        field = field.isel(cycle=-1) if cycle is None else field.sel(cycle=cycle, method="nearest")
        return Accessor(mirrored(field)).in_units()[name].transpose(Y.name, X.name)


def require_dataset(dataset: object) -> None:
    """Raise a `TypeError` if a dataset is something else, such as the name of its file."""
    if not isinstance(dataset, xr.Dataset):
        remedy = "fretwear.open_case(file) opens one, fretwear.simulate(case) computes one"
        raise TypeError(f"give a dataset, not {type(dataset).__name__}: {remedy}")
