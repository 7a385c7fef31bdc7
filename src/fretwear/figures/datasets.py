"""Data that figures take from datasets: snapshots, fields along x, envelopes of rough profiles."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from typing import Any

import numpy as np
import xarray as xr

from fretwear.arrays import Array
from fretwear.data.dataset import gap_beyond, line_near_the_middle
from fretwear.data.merge import MERGED_PROFILES
from fretwear.data.stack import representative_cycles
from fretwear.vocabulary import FIELDS, RESULTS, ContactState, Variable

Cycles = Sequence[int] | int | None
"""The snapshots that a figure shows; None: a few representative ones."""
Envelope = Callable[[Array, Array, float], Array]
"""Turns x, values and a wavelength into the values of a curve that can be read."""

BEYOND_CONTACT = 1.12
"""Distance to which profiles are shown, in half-widths of the contact."""

_CELLS_PER_WAVE = 4.0
_ALIKE = 1e-3
_PEAKS_MATTER = ("pressure", "shear_traction", "wear_rate")


@dataclass(frozen=True)
class HalfProfiles:
    """One field at several cycles along x > 0, or along all of x if it is not even; SI units."""

    field: Variable
    x: Array  # n cell centres
    cycles: Array
    values: Array  # shape (k, n), at the k cycles
    contact_half_width: Array
    stick_half_width: Array
    wavelength: float  # of the roughness along x, 0 if the surface is smooth along x
    is_capped: bool = False  # whether the pressure has a plastic limit
    stick: Array | None = None  # centres that stick at the last cycle, if fields are not even

    @property
    def is_even(self) -> bool:
        """Whether one side shows everything."""
        return bool(self.x[0] > 0.0)

    @property
    def is_wavy(self) -> bool:
        """Whether waves crowd the profile, so that an envelope helps to read it."""
        resolved = self.wavelength >= _CELLS_PER_WAVE * float(self.x[1] - self.x[0])
        return resolved and self.wavelength < 0.5 * float(np.nanmax(self.contact_half_width))

    def readable(self, envelope: Envelope | None = None) -> HalfProfiles:
        """Return the profiles or, if waves crowd them, an envelope that suits the field."""
        if not self.is_wavy:
            return self
        smooth = envelope or envelope_of(self.field)
        curves = [smooth(self.x, values, self.wavelength) for values in self.values]
        return replace(self, values=np.array(curves))


def half_profiles(
    dataset: xr.Dataset, field: Variable | str, cycles: Cycles = None, reach: float = 0.0
) -> HalfProfiles:
    """Take one field on the line nearest y = 0, along x > 0 or, if it is not even, along all of x.

    The gap extends to `reach`, m; beyond the cells stored it is computed from the pressure. Raises
    the errors of `snapshots`, and a `ValueError` if a dataset varies in more than cycle, x and y.
    """
    check_dataset(dataset)
    field = field_of(field)
    merged = (name for name, about in MERGED_PROFILES.items() if about.name == field.name)
    name = next((name for name in (field.name, *merged) if name in dataset), field.name)
    picked = snapshots(dataset, cycles, name)
    if extra := set(picked[name].dims) - {"cycle", "x", "y"}:
        raise ValueError(
            f"{name} varies along {sorted(map(str, extra))}: "
            "select one point first, for example with dataset.isel(...)."
        )
    line = line_near_the_middle(picked[name]).transpose("cycle", "x")
    x, values = line["x"].values.astype(np.float64), line.values.astype(np.float64)
    tolerance = _ALIKE * float(np.nanmax(np.abs(values), initial=0.0))
    if x[0] < 0.0 and np.allclose(values, values[:, ::-1], 0.0, tolerance, equal_nan=True):
        x, values = x[x > 0.0], values[:, x > 0.0]
    stick = None
    if x[0] < 0.0 and "contact_state" in picked:
        state = line_near_the_middle(picked["contact_state"].isel(cycle=-1)).values
        stick = x[state == ContactState.STICK]
    parameters = dataset.coords
    slope = float(parameters.get("roughness_slope_x", 0.0))
    height = 4.0 * float(parameters.get("roughness_amplitude", 0.0))
    wavelength = height / math.tan(slope) if slope > 0.0 else 0.0
    contact, stuck = (
        picked[f"{zone}_half_width_x"].values.astype(np.float64) for zone in ("contact", "stick")
    )
    if math.isnan(field.outside):
        reach = max(reach, BEYOND_CONTACT * float(contact.max(initial=0.0)))
        x, values = gap_beyond(picked, x, values, reach + wavelength)
    is_capped = math.isfinite(float(parameters.get("plastic_limit", math.inf)))
    at = picked["cycle"].values.astype(np.float64)
    return HalfProfiles(field, x, at, values, contact, stuck, wavelength, is_capped, stick)


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


def envelope_of(field: Variable) -> Envelope:
    """Return the envelope that suits a field: through its peaks if these carry the load."""
    return peak_envelope if field.name in _PEAKS_MATTER else wave_mean


def peak_envelope(x: Array, values: Array, wavelength: float) -> Array:
    """Return the curve through the highest value of every wave.

    `x` are the n cell centres in m, `values` n values, none of them negative, and `wavelength` is
    the wavelength along x in m. The n values returned lie on shape-preserving cubics through the
    peaks, which overshoot none of them.
    """
    crest_in_the_middle = float(np.nansum(values * np.cos(2.0 * np.pi * x / wavelength))) >= 0.0
    wave = np.floor(x / wavelength + (0.5 if crest_in_the_middle else 0.0))
    knots, heights = [], []
    for index in np.unique(wave):
        cells = np.flatnonzero((wave == index) & np.isfinite(values))
        if cells.size:
            highest = cells[np.argmax(values[cells])]
            knots.append(float(x[highest] if values[highest] > 0.0 else x[cells].mean()))
            heights.append(float(values[highest]))
    if len(knots) < 2:
        return values
    from scipy.interpolate import PchipInterpolator  # only studies with waves need it

    inside = np.clip(x, knots[0], knots[-1])
    curve = np.asarray(PchipInterpolator(knots, heights)(inside))
    return np.where((x > knots[-1]) & np.isnan(values), np.nan, curve)


def wave_mean(x: Array, values: Array, wavelength: float) -> Array:
    """Return the running mean over a wave, for quantities whose peaks say little.

    Parameters and result are as in `peak_envelope`. A profile of one side is continued evenly at
    x = 0; near an end, where the mean would need values beyond, the result is NaN. The mean is
    taken twice, because a single one leaves ripples if a wave is not a whole number of cells.
    """
    cells = max(1, round(wavelength / float(x[1] - x[0])))
    window = np.convolve(np.full(cells, 1.0 / cells), np.full(cells, 1.0 / cells))
    half = window.size // 2
    if values.size <= half:
        return values
    before = values[:half][::-1] if x[0] > 0.0 else np.full(half, np.nan)
    return np.convolve(np.concatenate([before, values, np.full(half, np.nan)]), window, "valid")


def check_dataset(dataset: Any) -> None:
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


def check_cases(cases: Any, *fields: str) -> None:
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
