"""Data that figures take from datasets: snapshots, histories, and fields along x."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from fretwear.arrays import Array
from fretwear.data.dataset import line_near_the_middle, require_dataset
from fretwear.data.files import open_history
from fretwear.data.stack import representative_cycles
from fretwear.results import BODY_FIELDS, FIELDS, FRICTION_FIELD, RESULTS, STATUS
from fretwear.units import did_you_mean
from fretwear.variable import ContactState, Variable

Cycles = Sequence[int] | int | None
"""The snapshots that a figure shows; None: a few representative ones."""

TitledCases = xr.Dataset | Mapping[str, xr.Dataset]
"""One case, or several by the titles of their panels."""

_ALIKE = 1e-3
_OVER_FIRST = 3.0
# A result that every contact has at every cycle.
_ALWAYS = "contact_half_width_x"
_VOLUMES = ("wear_volume", "wear_volume_indenter", "wear_volume_flat")
_MOST_CYCLES = 200
# Where variables are that a case lacks.
_HOLDERS = {
    "force": "fretwear.open_loops(file) has it",
    "status": "the summary.nc of a study has it",
    "worn_through_cycle": "cases with coating.wear_coefficient have it",
}

QUANTILES = (0.1, 0.25, 0.5, 0.75, 0.9)
"""Quantiles of the curves of a sample: the ends of two bands around the median."""


@dataclass(frozen=True)
class Profiles:
    """One field at k cycles along x > 0, or along all of x if it is not even; SI units."""

    field: Variable
    x: Array  # n cell centres
    cycles: Array
    values: Array  # shape (k, n)
    zones: NDArray[np.int8]  # `ContactState` of the cells, shape (k, n)
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
    def from_middle(self) -> tuple[Array, Array]:
        """Cell centres and values, with the cell beyond x = 0 of an even profile, (m,), (k, m)."""
        if not self.is_even:
            return self.x, self.values
        return np.append(-self.x[0], self.x), np.hstack([self.values[:, :1], self.values])


def profiles_of(dataset: xr.Dataset, field: Variable | str, cycles: Cycles = None) -> Profiles:
    """Take one field on the line nearest y = 0, along x > 0 or, if it is not even, along all of x.

    Raises the errors of `snapshots`.
    """
    field = field_of(field)
    picked = snapshots(dataset, cycles, field.name, "contact_state")
    line = line_near_the_middle(picked[[field.name, "contact_state"]]).transpose("cycle", "x")
    x, values = (line[name].values.astype(np.float64) for name in ("x", field.name))
    zones = line["contact_state"].values.astype(np.int8)
    if field.name == "slip":  # cells that do not touch wear nothing, whatever their displacement
        values = np.where(zones == ContactState.OPEN, math.nan, values)
    tolerance = _ALIKE * float(np.nanmax(np.abs(values), initial=0.0))
    is_even = np.allclose(values, values[:, ::-1], 0.0, tolerance, equal_nan=True)
    if x[0] < 0.0 and is_even:
        x, values, zones = x[x > 0.0], values[:, x > 0.0], zones[:, x > 0.0]
    contact, stick = (
        picked[f"{zone}_half_width_x"].values.astype(np.float64) for zone in ("contact", "stick")
    )
    ceiling, error = math.inf, RESULTS["peak_pressure"].error.name
    if field.si_unit == "Pa" and error in picked and np.isposinf(picked[error].values).any():
        # The later peak at a singular edge of stick would hide the rest.
        ceiling = _OVER_FIRST * float(np.nanmax(values[0]))
    numbers, is_rough = picked["cycle"].values.astype(np.float64), not is_smooth(dataset)
    return Profiles(field, x, numbers, values, zones, contact, stick, is_rough, ceiling)


@dataclass(frozen=True)
class Curve:
    """One point of a study, or the mean of points that differ in their seed, over the cycles."""

    place: Mapping[str, int]  # by the dimensions of the study
    cycles: Array
    values: Array  # NaN where undefined
    deviation: Array | None = None  # standard deviation of a mean

    def is_at(self, place: Mapping[str, int]) -> bool:
        """Whether the curve belongs to a panel."""
        return all(self.place[name] == index for name, index in place.items())


def history_of(dataset: xr.Dataset) -> xr.Dataset:
    """Return the values at every step from the file that a dataset was opened from.

    A part of a merged study has the part of the history. A dataset without a file, or a history
    itself, is returned as it is.
    """
    require_dataset(dataset)
    source = dataset.encoding.get("source", "")
    if "step" in dataset.dims or not source or not Path(source).is_file():
        return dataset
    history = open_history(source)
    chosen = {n: dataset[n].values for n in history.dims if n in dataset.coords and n != "step"}
    return history.sel(chosen)


def study_curves(dataset: xr.Dataset, name: str) -> list[Curve]:
    """Return a curve for each finished point of a study, at its snapshots or at its steps.

    The width of a zone steps where a spot has joined its outline or left it, by what exceeds the
    growth at the rate before. A wear volume has a value at cycle 1, to which it grows
    in proportion to the dissipated energy.

    The dataset is a merged study (varied names or ``point``, then ``cycle``), one case, or the
    history of either (…, ``step``). Raises a `ValueError` if it lacks the result.
    """
    require_variables(dataset, name)
    if "cycle" in dataset.coords and dataset["cycle"].ndim == 0:
        dataset = dataset.expand_dims("cycle")
    dims = [str(dim) for dim in dataset[name].dims if dim not in ("cycle", "step")]
    # A result undefined over some cycles, as without a stick zone, leaves a gap in its line.
    always = dataset[_ALWAYS if _ALWAYS in dataset else name]
    none = xr.zeros_like(always)
    zone, _, extent = name.partition("_")
    # An area does not step: a spot has none when it joins.
    spots = none if extent == "area" else dataset.get(f"{zone}_spots", none)
    energy = dataset.get("dissipated_energy", none) if name in _VOLUMES else none
    # Coordinates, of which there are dozens, would have to be merged.
    parts = dataset["cycle"], dataset[name], always, spots, energy
    variables: list[Any] = [part.variable for part in parts]
    sizes = {dim: dataset.sizes[dim] for dim in dims}
    sizes |= {str(dim): size for each in variables for dim, size in each.sizes.items()}
    cycles, values, there, moved, energies = (
        each.set_dims(sizes).values.astype(np.float64) for each in variables
    )
    curves = []
    for place in np.ndindex(values.shape[:-1]):
        stored = np.isfinite(there[place]) & np.isfinite(cycles[place])
        if not np.isfinite(values[place][stored]).any():
            continue
        x, y = cycles[place][stored], values[place][stored]
        steps = np.flatnonzero(moved[place][stored] > 0.0)
        slopes = np.diff(y, prepend=y[0]) / np.diff(x, prepend=x[0] - 1.0)
        for step in steps:
            slopes[step] = slopes[step - 1]
        added, grown = x[steps], slopes[steps - 1] * (x[steps] - x[steps - 1])
        of_added = np.clip(y[steps - 1] + grown, *np.sort([y[steps - 1], y[steps]], axis=0))
        rates = energies[place][stored][:2]
        if rates.all() and x[0] == y[0] == 0.0 and x[1] > 1.0:
            # V is proportional to the energy since cycle 0, the integral of a linear rate.
            share = (rates[0] + 0.5 * (rates[1] - rates[0]) / x[1]) / (rates.mean() * x[1])
            steps, added, of_added = np.array([1]), np.array([1.0]), share * y[1:2]
        x, y = np.insert(x, steps, added), np.insert(y, steps, of_added)
        curves.append(Curve(dict(zip(dims, place, strict=True)), x, y))
    return curves


def side_by_side(curves: Sequence[Curve]) -> tuple[Array, Array]:
    """Return n common cycles of k curves and their values there, shape (k, n).

    These are all their cycles, or a few hundred of many. A curve has NaN after its last cycle.
    """
    cycles = np.unique(np.concatenate([curve.cycles for curve in curves]))
    cycles = cycles[np.linspace(0, cycles.size - 1, min(cycles.size, _MOST_CYCLES)).astype(int)]
    rows = [np.interp(cycles, curve.cycles, curve.values, right=math.nan) for curve in curves]
    return cycles, np.stack(rows)


def quantile_curves(curves: Sequence[Curve]) -> tuple[Array, Array]:
    """Return n cycles and the `QUANTILES` of curves there, a row for each, of those that go on."""
    cycles, table = side_by_side(curves)
    known = np.isfinite(table).any(axis=0)
    return cycles[known], np.nanquantile(table[:, known], QUANTILES, axis=0)


def is_smooth(dataset: xr.Dataset) -> bool:
    """Whether the bodies of a case are smooth."""
    return float(dataset.coords.get("roughness_amplitude", math.nan)) == 0.0


def field_of(quantity: Variable | str) -> Variable:
    """Return a field by its name; a `ValueError` lists the fields that have profiles."""
    if isinstance(quantity, Variable):
        return quantity
    drawn = (*FIELDS, *BODY_FIELDS, FRICTION_FIELD)
    fields = {field.name: field for field in drawn if not field.flags}
    if quantity not in fields:
        known = did_you_mean(quantity, fields) or f"there are profiles of {', '.join(fields)}"
        raise ValueError(f"quantity = {quantity!r}: {known}")
    return fields[quantity]


def width_names(dataset: xr.Dataset) -> tuple[str, str]:
    """Return the names of the widths of contact and stick zone: radii where the dataset has them.

    Files of earlier versions, and line contacts, have half-widths along x alone.
    """
    has_radii = "contact_radius" in dataset and "stick_radius" in dataset
    end = "radius" if has_radii else "half_width_x"
    return f"contact_{end}", f"stick_{end}"


def snapshots(dataset: xr.Dataset, cycles: Cycles, *names: str) -> xr.Dataset:
    """Return a dataset at the given cycles or, without any, at a few representative ones.

    Raises a `ValueError` for a dataset that lacks a cycle or one of the variables `names`.
    """
    require_variables(dataset, *names)
    if STATUS.name in dataset and (count := dataset[STATUS.name].size) > 1:
        remedy = "choose one, for example by .fretwear.point(load='25 N', ...)"
        raise ValueError(f"The dataset has {count} points of a study: {remedy}.")
    if "cycle" in dataset.coords and dataset["cycle"].ndim == 0:  # one snapshot was selected
        dataset = dataset.expand_dims("cycle")
    stored, width = dataset["cycle"].values, dataset.get(_ALWAYS)
    if width is not None and width.dims == ("cycle",):
        # Other points of a study may have snapshots where this one has none.
        stored = stored[np.isfinite(width.values)]
    available = [int(cycle) for cycle in stored]
    chosen = representative_cycles(available) if cycles is None else np.atleast_1d(cycles).tolist()
    asked = [int(cycle) for cycle in chosen]
    if not asked or not set(asked) <= set(available):
        raise ValueError(f"cycles = {asked}: this dataset has snapshots at {available}.")
    return dataset.sel(cycle=asked)


def titled(cases: TitledCases) -> Mapping[str, xr.Dataset]:
    """Return cases by their titles; a single one has none."""
    cases = (
        cases if isinstance(cases, Mapping) and not isinstance(cases, xr.Dataset) else {"": cases}
    )
    for case in cases.values():
        require_dataset(case)
    return cases


def require_variables(dataset: xr.Dataset, *names: str) -> None:
    """Raise a `ValueError` if a dataset lacks a variable."""
    require_dataset(dataset)
    for name in names:
        if name not in dataset:
            there = sorted(n for n in map(str, dataset.data_vars) if not n.endswith("_error"))
            known = _HOLDERS.get(name) or did_you_mean(name, there)
            known = known or f"it has {', '.join(there) or 'none'}"
            raise ValueError(f"The dataset has no variable {name!r}; {known}.")
