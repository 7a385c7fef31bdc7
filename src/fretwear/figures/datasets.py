"""What figures take from datasets: a field along x, snapshots, envelopes of rough profiles."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from fretwear.data.dataset import mirrored
from fretwear.data.merge import PROFILES
from fretwear.data.positions import representative_cycles
from fretwear.study.case import Case
from fretwear.units import in_unit
from fretwear.vocabulary import FIELDS, RESULTS, ContactState, Field, Variable

Array = NDArray[np.float64]
Cycles = Sequence[int] | int | None
"""Which snapshots a figure shows: these, or a few of those there are."""
Envelope = Callable[[Array, Array, float], Array]
"""Turns x, values and a wavelength into the values of a curve that can be read."""

BEYOND_CONTACT = 1.12
"""How far profiles are shown, in half-widths of the contact."""

_CELLS_PER_WAVE = 4.0
_ALIKE = 1e-3
_PEAKS_MATTER = ("pressure", "shear_traction", "wear_rate")


@dataclass(frozen=True)
class HalfProfiles:
    """One field at several cycles along x > 0, or along all of x where it is not even; SI units.

    `x` are the n cell centres, `values` of shape (k, n) the field at the k `cycles`, at which the
    zones have the half-widths given. `wavelength` is that of the roughness along x, 0 where it is
    smooth along x; `is_capped` tells whether the pressure has a plastic limit. `stick` are the
    centres of the cells that stick at the last cycle, where fields are not even.
    """

    field: Field
    x: Array
    cycles: Array
    values: Array
    contact_half_width: Array
    stick_half_width: Array
    wavelength: float
    is_capped: bool = False
    stick: Array | None = None

    @property
    def is_even(self) -> bool:
        """Whether one side is all there is to show."""
        return bool(self.x[0] > 0.0)

    @property
    def is_wavy(self) -> bool:
        """Whether waves crowd the profile, so that an envelope helps to read it."""
        spacing = float(self.x[1] - self.x[0])
        resolved = self.wavelength >= _CELLS_PER_WAVE * spacing
        return resolved and self.wavelength < 0.5 * float(np.nanmax(self.contact_half_width))

    def readable(self, envelope: Envelope | None = None) -> HalfProfiles:
        """Return the profiles themselves or, where waves crowd them, their envelopes.

        `envelope` is `peak_envelope` or `wave_mean`; left out, the default of the field.
        """
        if not self.is_wavy:
            return self
        smooth = envelope or envelope_of(self.field)
        curves = [smooth(self.x, values, self.wavelength) for values in self.values]
        return replace(self, values=np.array(curves))


def half_profiles(
    dataset: xr.Dataset, field: Field | str, cycles: Cycles = None, reach: float = 0.0
) -> HalfProfiles:
    """Take one field on the line nearest y = 0: along x > 0, or all of x where it is not even.

    Parameters
    ----------
    dataset : xarray.Dataset
        One case, quarter or whole, or one point of a merged study.
    field : Field or str
        Field of a case, or its name, such as ``pressure``.
    cycles : sequence of int, optional
        Snapshots to take; if left out at most six of those that `dataset` has.
    reach : float
        How far, m, the gap is wanted: beyond the cells stored it is computed from the pressure.

    Raises
    ------
    TypeError
        When `dataset` is not a dataset.
    ValueError
        When `dataset` lacks the field, varies in more than cycle, x and y, or lacks a cycle.
    """
    check_dataset(dataset)
    field = field_of(field)
    dataset = with_cycles(dataset)
    merged = [name for name, each in PROFILES.items() if each.name == field.name]
    name = next((name for name in (field.name, *merged) if name in dataset), field.name)
    require(dataset, name)
    extra = set(dataset[name].dims) - {"cycle", "x", "y"}
    if extra:
        raise ValueError(
            f"{name} varies along {sorted(map(str, extra))}: "
            "select one point first, for example with dataset.isel(...)."
        )
    picked = dataset.sel(cycle=list(checked_cycles(dataset, cycles)))
    line = line_near_the_middle(picked[name])
    line = line.transpose("cycle", "x")
    if line["x"][0] < 0.0 and is_even(line.values):
        line = line.isel(x=np.flatnonzero(line["x"].values > 0.0))
    x, values = line["x"].values.astype(np.float64), line.values.astype(np.float64)
    stick = None
    if x[0] < 0.0 and "contact_state" in picked:
        state = line_near_the_middle(picked["contact_state"].isel(cycle=-1)).values
        stick = x[state == ContactState.STICK]
    contact = picked["contact_half_width_x"].values.astype(np.float64)
    if math.isnan(field.outside):
        reach = max(reach, BEYOND_CONTACT * float(contact.max(initial=0.0)))
        x, values = _with_gap_outside(picked, x, values, reach + roughness_wavelength(dataset))
    return HalfProfiles(
        field=field,
        x=x,
        cycles=picked["cycle"].values.astype(np.float64),
        values=values,
        contact_half_width=contact,
        stick_half_width=picked["stick_half_width_x"].values.astype(np.float64),
        wavelength=roughness_wavelength(dataset),
        is_capped=bool(np.isfinite(float(dataset.coords.get("plastic_limit", np.inf)))),
        stick=stick,
    )


def _with_gap_outside(
    dataset: xr.Dataset, x: Array, gaps: Array, reach: float
) -> tuple[Array, Array]:
    """Continue gaps along x to a reach where the shape of the case and its pressure are known.

    There the surface is unworn: its gap, and by Boussinesq the displacement u = Σ p dA/πE*r of the
    cells under pressure, which are far away; in a line contact u = −Σ 2 p dx ln(r)/πE*. Both are
    counted from the last cell stored.
    """
    more = np.arange(x[-1] + x[1] - x[0], reach, x[1] - x[0])
    if not more.size or "pressure" not in dataset or "parameters" not in dataset.attrs:
        return x, gaps
    case = Case(**json.loads(dataset.attrs["parameters"]))
    if not all(part.is_known for part in case.surfaces.values()):
        return x, gaps
    whole = mirrored(dataset[["pressure"]]).transpose("cycle", "x", ...)
    pressure, at_x, at_y = whole["pressure"].values, whole["x"].values[:, None], np.zeros((1, 1))
    area, pressure = float(at_x[1, 0] - at_x[0, 0]), pressure.reshape(*pressure.shape[:2], -1)
    width = 0.0
    if not case.indenter.is_line:
        at_y = whole["y"].values[None, :]
        width = float(at_y[0, 1] - at_y[0, 0])
        area *= width
    y = np.abs(at_y).min(axis=1)
    loaded = (pressure > 0.0).any(axis=0)
    forces = area / (math.pi * case.composite_modulus) * pressure[:, loaded].astype(np.float64)
    at_x, at_y = (np.broadcast_to(each, loaded.shape)[loaded] for each in (at_x, at_y))

    def changes(points: Array) -> Array:
        heights = case.indenter.gap(points[:, None], y[None, :])[:, 0]
        if case.rough is not None:
            cell = None if case.indenter.is_line else (points[1] - points[0], width)
            heights = heights + case.rough.on_cells(points, y, cell)[:, 0]
        distances = (np.hypot(point - at_x, y - at_y) for point in points)
        kernels = (-2.0 * np.log(r) if case.indenter.is_line else 1.0 / r for r in distances)
        changed = heights + np.column_stack([forces @ kernel for kernel in kernels])
        return np.asarray(changed[:, 1:] - changed[:, :1])

    right = gaps[:, -1:] + changes(np.concatenate([x[-1:], more]))
    if x[0] > 0.0:
        return np.concatenate([x, more]), np.concatenate([gaps, right], axis=1)
    left = (gaps[:, :1] + changes(np.concatenate([x[:1], -more])))[:, ::-1]
    return np.concatenate([-more[::-1], x, more]), np.concatenate([left, gaps, right], axis=1)


def is_even(values: NDArray[Any]) -> bool:
    """Tell whether profiles over the whole of x look alike on both sides."""
    tolerance = _ALIKE * float(np.nanmax(np.abs(values), initial=0.0))
    return np.allclose(values, values[:, ::-1], rtol=0.0, atol=tolerance, equal_nan=True)


def field_of(quantity: Field | str) -> Field:
    """Return a field by its name; a `ValueError` names those of which there are profiles."""
    if isinstance(quantity, Field):
        return quantity
    fields = {field.name: field for field in FIELDS if not field.flags}
    if quantity not in fields:
        raise ValueError(
            f"quantity = {quantity!r}: there are profiles of {', '.join(map(repr, fields))}."
        )
    return fields[quantity]


def variable_of(dataset: xr.Dataset, name: str) -> Variable:
    """Return what a result of a dataset is: in a line contact it may be per length."""
    return RESULTS[name].in_units(dataset[name].attrs.get("units", RESULTS[name].si_unit))


def coordinate_value(coordinate: xr.DataArray) -> Any:
    """Return the value of a scalar coordinate as its texts need it."""
    return in_unit(coordinate.item(), coordinate.attrs.get("units", ""))


def line_near_the_middle(values: xr.DataArray) -> xr.DataArray:
    """Return the line of cells nearest y = 0 of a field, which may be that line already."""
    if "y" not in values.dims:
        return values
    return values.isel(y=int(np.abs(values["y"].values).argmin()))


def roughness_wavelength(dataset: xr.Dataset) -> float:
    """Return the wavelength 4A/tan θ_x of the waves along x in m, 0 when there are none."""
    if not {"roughness_amplitude", "roughness_slope_x"} <= set(dataset.coords):
        return 0.0
    slope = math.tan(float(dataset["roughness_slope_x"]))
    amplitude = float(dataset["roughness_amplitude"])
    return 4.0 * amplitude / slope if slope > 0.0 else 0.0


def with_cycles(dataset: xr.Dataset) -> xr.Dataset:
    """Give a dataset from which one snapshot was selected its dimension ``cycle`` back."""
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


def checked_cycles(dataset: xr.Dataset, cycles: Cycles) -> Sequence[int]:
    """Return the cycles asked for, or at most six; refuse those without a snapshot."""
    available = available_cycles(dataset)
    if not available:
        raise ValueError("This point of the study is not done: it has no snapshot to draw.")
    if cycles is None:
        return representative_cycles(available)
    wanted: list[int] = np.atleast_1d(cycles).tolist()
    unknown = [cycle for cycle in wanted if cycle not in available]
    if unknown or not wanted:
        raise ValueError(
            f"cycles = {wanted}: there is no snapshot at {unknown}; this dataset has {available}."
            if wanted
            else f"cycles = []: give some of the snapshots of this dataset, {available}."
        )
    return wanted


def envelope_of(field: Field) -> Envelope:
    """Return the envelope that suits a field: through its peaks where these carry the load."""
    return peak_envelope if field.name in _PEAKS_MATTER else wave_mean


def peak_envelope(x: Array, values: Array, wavelength: float) -> Array:
    """Return the curve through the highest value of every wave.

    `x` are the n cell centres in m, `values` n values that are nowhere negative, and `wavelength`
    is that along x in m. The n values returned are those of shape-preserving cubics through the
    peaks: they overshoot none of them.
    """
    crest_in_the_middle = float(np.nansum(values * np.cos(2.0 * np.pi * x / wavelength))) >= 0.0
    wave = np.floor(x / wavelength + (0.5 if crest_in_the_middle else 0.0)).astype(np.int64)
    knots, heights = [], []
    for index in np.unique(wave):
        cells = np.flatnonzero((wave == index) & np.isfinite(values))
        if cells.size:
            highest = cells[np.argmax(values[cells])]
            flat = values[highest] <= 0.0
            knots.append(float(x[cells].mean() if flat else x[highest]))
            heights.append(float(values[highest]))
    if len(knots) < 2:
        return values
    from scipy.interpolate import PchipInterpolator  # studies without waves do without

    curve = np.asarray(PchipInterpolator(knots, heights, extrapolate=False)(x))
    curve = np.where(x < knots[0], heights[0], curve)
    return np.where(x > knots[-1], np.where(np.isfinite(values), heights[-1], np.nan), curve)


def wave_mean(x: Array, values: Array, wavelength: float) -> Array:
    """Return the running mean over a wave, for quantities whose peaks say little.

    Parameters and result are those of `peak_envelope`. At x = 0 a profile of one side is continued
    evenly; near an end, where the mean would need values beyond, the result is NaN. The mean of
    the mean is taken: a single one leaves ripples where a wave is not a whole number of cells.
    """
    cells = max(1, round(wavelength / float(x[1] - x[0])))
    window = np.convolve(np.full(cells, 1.0 / cells), np.full(cells, 1.0 / cells))
    half = window.size // 2
    if values.size <= half:
        return values
    before = values[:half][::-1] if x[0] > 0.0 else np.full(half, np.nan)
    continued = np.concatenate([before, values, np.full(half, np.nan)])
    return np.convolve(continued, window, mode="valid")


def check_dataset(dataset: Any) -> None:
    """Raise a `TypeError` for what is not a dataset, saying how to get a dataset from it."""
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
    """Raise a `TypeError` for what is not a mapping of titles to datasets.

    It is a `ValueError` when there is no case, or one lacks a field.
    """
    if not isinstance(cases, Mapping) or isinstance(cases, xr.Dataset):
        raise TypeError(
            f"Cases are given by their titles, not as a {type(cases).__name__}; "
            'for example {"smooth": first, "rough": second}.'
        )
    if not cases:
        raise ValueError("There is no case to draw.")
    for dataset in cases.values():
        check_dataset(dataset)
        require(dataset, *fields)


def require(dataset: xr.Dataset, *names: str) -> None:
    """Raise a `ValueError` for a dataset that lacks a variable, with what to give instead."""
    missing = next((name for name in names if name not in dataset), None)
    if missing is None:
        return
    if "step" in dataset.dims:
        reason = "it is the history of a case, which has no fields; open_case opens the case"
    elif "status" in dataset:
        reason = (
            "it is a merged study, which has profiles and no fields; open the case with open_case"
        )
    else:
        reason = f"it has {', '.join(sorted(map(str, dataset.data_vars))) or 'none at all'}"
    raise ValueError(f"The dataset has no variable {missing!r}: {reason}.")
