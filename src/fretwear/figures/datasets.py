"""Data that figures take from datasets: snapshots, and fields along x."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from os import PathLike

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from fretwear.arrays import Array
from fretwear.data.dataset import gap_beyond, line_near_the_middle
from fretwear.data.files import MERGED_PROFILES
from fretwear.data.stack import representative_cycles
from fretwear.vocabulary import FIELDS, RESULTS, ContactState, Variable

Cycles = Sequence[int] | int | None
"""The snapshots that a figure shows; None: a few representative ones."""

BEYOND_CONTACT = 1.12
"""Distance to which profiles are shown, in half-widths of the contact."""

_ALIKE = 1e-3
_VISIBLE = 0.05
_OVER_FIRST = 3.0


@dataclass(frozen=True)
class Profiles:
    """One field at k cycles along x > 0, or along all of x if it is not even; SI units."""

    field: Variable
    x: Array  # n cell centres
    cycles: Array
    values: Array  # shape (k, n)
    zones: NDArray[np.int8]  # `ContactState` of the cells, shape (k, n), open beyond those stored
    contact_half_width: Array  # shape (k,)
    stick_half_width: Array
    is_rough: bool
    # Value above which a traction is cut, because it has a singular edge; infinite without one.
    ceiling: float = math.inf

    @property
    def is_even(self) -> bool:
        """Whether one side shows everything."""
        return bool(self.x[0] > 0.0)

    @property
    def first(self) -> int:
        """The place of the first profile that can be seen beside the last one."""
        highest = np.nanmax(np.abs(self.values), axis=1)
        return int(np.argmax(highest[:-1] >= _VISIBLE * highest[-1])) if highest.size > 1 else 0

    def at(self, *places: int) -> Profiles:
        """Return the profiles at some of the cycles, given by their places."""
        chosen = list(places)
        return replace(
            self,
            cycles=self.cycles[chosen],
            values=self.values[chosen],
            zones=self.zones[chosen],
            contact_half_width=self.contact_half_width[chosen],
            stick_half_width=self.stick_half_width[chosen],
        )


def profiles_of(
    dataset: xr.Dataset,
    field: Variable | str,
    cycles: Cycles = None,
    reach: float = 0.0,
    *,
    both_sides: bool = False,
) -> Profiles:
    """Take one field on the line nearest y = 0, along x > 0 or, if it is not even, along all of x.

    `both_sides` of a whole contact are kept even so.
    The gap extends to `reach`, m; beyond the cells stored it is computed from the pressure. Raises
    the errors of `snapshots`, and a `ValueError` if a dataset varies in more than cycle, x and y.
    """
    check_dataset(dataset)
    field = field_of(field)
    picked = snapshots(dataset, cycles, stored_name(dataset, field.name))
    line = _line(picked, field.name)
    x, values = line["x"].values.astype(np.float64), line.values.astype(np.float64)
    zones = np.full(values.shape, ContactState.OPEN, np.int8)
    if stored_name(picked, "contact_state") in picked:
        zones = _line(picked, "contact_state").values.astype(np.int8)
    if field.name == "slip":  # of what does not touch, it wears nothing
        values = np.where(zones == ContactState.OPEN, math.nan, values)
    tolerance = _ALIKE * float(np.nanmax(np.abs(values), initial=0.0))
    is_even = np.allclose(values, values[:, ::-1], 0.0, tolerance, equal_nan=True)
    if x[0] < 0.0 and is_even and not both_sides:
        x, values, zones = x[x > 0.0], values[:, x > 0.0], zones[:, x > 0.0]
    contact, stick = (
        picked[f"{zone}_half_width_x"].values.astype(np.float64) for zone in ("contact", "stick")
    )
    if math.isnan(field.outside):
        reach, stored = max(reach, BEYOND_CONTACT * float(contact.max(initial=0.0))), x
        x, values = gap_beyond(picked, stored, values, reach)
        beyond = int((x < stored[0]).sum()), int((x > stored[-1]).sum())
        zones = np.pad(zones, ((0, 0), beyond))
    ceiling, error = math.inf, RESULTS["peak_pressure"].error.name
    if field.si_unit == "Pa" and error in picked and np.isposinf(picked[error].values).any():
        # The later peak at a singular edge of stick would hide the rest.
        ceiling = _OVER_FIRST * float(np.nanmax(values[0]))
    at = picked["cycle"].values.astype(np.float64)
    is_rough = not is_smooth(dataset)
    return Profiles(field, x, at, values, zones, contact, stick, is_rough, ceiling)


def stored_name(dataset: xr.Dataset, field: str) -> str:
    """Return the name of a field in a case, or of its profile in a merged study."""
    merged = (name for name, about in MERGED_PROFILES.items() if about.name == field)
    return next((name for name in (field, *merged) if name in dataset), field)


def _line(picked: xr.Dataset, field: str) -> xr.DataArray:
    name = stored_name(picked, field)
    if extra := set(picked[name].dims) - {"cycle", "x", "y"}:
        raise ValueError(
            f"{name} varies along {sorted(map(str, extra))}: "
            "select one point first, for example with dataset.isel(...)."
        )
    return line_near_the_middle(picked[name]).transpose("cycle", "x")


def is_smooth(dataset: xr.Dataset) -> bool:
    """Whether the bodies of a case are smooth."""
    return float(dataset.coords.get("roughness_amplitude", math.nan)) == 0.0


def field_of(quantity: Variable | str) -> Variable:
    """Return a field by its name; a `ValueError` lists the fields that have profiles."""
    if isinstance(quantity, Variable):
        return quantity
    fields = {field.name: field for field in FIELDS if not field.flags}
    if quantity not in fields:
        raise ValueError(
            f"quantity = {quantity!r}: there are profiles of {', '.join(map(repr, fields))}."
        )
    return fields[quantity]


def variable_of(dataset: xr.Dataset, name: str) -> Variable:
    """Return the variable of a result, per length if the dataset has it so."""
    return RESULTS[name].in_units(dataset[name].attrs.get("units", RESULTS[name].si_unit))


def with_cycles(dataset: xr.Dataset) -> xr.Dataset:
    """Restore the dimension ``cycle`` of a dataset from which one snapshot was selected."""
    if "cycle" in dataset.coords and dataset["cycle"].ndim == 0:
        return dataset.expand_dims("cycle")
    return dataset


def available_cycles(dataset: xr.Dataset) -> list[int]:
    """Return the cycles at which a case, or one point of a study, has snapshots."""
    cycles = np.atleast_1d(dataset["cycle"].values)
    width = dataset.get("contact_half_width_x")
    if width is not None and width.dims == ("cycle",):
        # Other points of a study may have snapshots where this one has none.
        cycles = cycles[np.isfinite(width.values)]
    return [int(cycle) for cycle in cycles]


def snapshots(
    dataset: xr.Dataset,
    cycles: Cycles,
    *names: str,
    default: Callable[[list[int]], Sequence[int]] = representative_cycles,
) -> xr.Dataset:
    """Return a dataset at the given cycles or, without any, at the cycles that `default` picks.

    Raises a `TypeError` for anything but a dataset, and a `ValueError` for a dataset that lacks a
    cycle or one of the variables `names`.
    """
    check_dataset(dataset)
    require(dataset, *names)
    dataset = with_cycles(dataset)
    available = available_cycles(dataset)
    if not available:
        raise ValueError("This point of the study is not done: it has no snapshot to draw.")
    asked = list(default(available)) if cycles is None else np.atleast_1d(cycles).tolist()
    unknown = [cycle for cycle in asked if cycle not in available]
    if unknown or not asked:
        raise ValueError(
            f"cycles = {asked}: there is no snapshot at {unknown}; this dataset has {available}."
            if asked
            else f"cycles = []: give some of the snapshots of this dataset, {available}."
        )
    return dataset.sel(cycle=asked)


def check_dataset(dataset: object) -> None:
    """Raise a `TypeError` for anything but a dataset, saying how to get one."""
    if isinstance(dataset, xr.Dataset):
        return
    given = type(dataset).__name__
    remedy = "open_case and simulate of fretwear return such a dataset"
    if isinstance(dataset, str | PathLike):
        remedy = f"open the file first: fretwear.open_case({str(dataset)!r})"
    elif isinstance(dataset, xr.DataArray):
        remedy = "give the whole dataset, not one of its variables"
    elif isinstance(dataset, Mapping):
        remedy = "give one of its datasets; several cases are drawn by the functions compare_..."
    elif given == "Case":
        remedy = "simulate it first: fretwear.simulate(case)"
    raise TypeError(f"A figure is drawn from an xarray.Dataset, not from a {given}; {remedy}.")


def check_cases(cases: object, *fields: str) -> None:
    """Refuse anything but a mapping of titles to datasets that have the fields, at least one."""
    if not isinstance(cases, Mapping) or isinstance(cases, xr.Dataset):
        raise TypeError(
            f"Give cases by their titles, not as a {type(cases).__name__}; "
            'for example {"smooth": first, "rough": second}.'
        )
    if not cases:
        raise ValueError("There is no case to draw.")
    for dataset in cases.values():
        check_dataset(dataset)
        require(dataset, *fields)


def require(dataset: xr.Dataset, *names: str) -> None:
    """Raise a `ValueError` if a dataset lacks a variable, saying what to give instead."""
    missing = next((name for name in names if name not in dataset), None)
    if missing is None:
        return
    reason = f"it has {', '.join(sorted(map(str, dataset.data_vars))) or 'no variables'}"
    if "step" in dataset.dims:
        reason = "it is the history of a case, which has no fields; open_case opens the case"
    elif "status" in dataset:
        reason = (
            "it is a merged study, which has profiles and no fields; open the case with open_case"
        )
    raise ValueError(f"The dataset has no variable {missing!r}: {reason}.")
