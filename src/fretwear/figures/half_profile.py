"""Half-profiles along x on the line nearest y = 0, and envelopes that make rough ones readable."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from fretwear.figures.datasets import check_dataset, missing_variable

Array = NDArray[np.float64]

_MERGED_NAME = {
    "pressure": "pressure_profile",
    "shear_traction": "shear_profile",
    "gap": "gap_profile",
    "wear_depth": "wear_profile",
    "wear_rate": "wear_rate_profile",
}
_CELLS_PER_WAVE = 4.0


@dataclass(frozen=True)
class HalfProfiles:
    """One quantity along x > 0 at several cycles.

    Parameters
    ----------
    x : array of shape (n,)
        Cell centres in m.
    cycles : array of shape (k,)
        The cycles.
    values : array of shape (k, n)
        The quantity in its SI unit.
    contact_half_width, stick_half_width : array of shape (k,)
        Half-widths along x in m.
    wavelength : float
        Wavelength of the roughness along x in m; 0 when smooth along x.
    is_capped : bool
        Whether the pressure has a plastic limit.
    """

    x: Array
    cycles: Array
    values: Array
    contact_half_width: Array
    stick_half_width: Array
    wavelength: float
    is_capped: bool = False

    @property
    def is_wavy(self) -> bool:
        """Whether waves crowd the profile, so that an envelope helps to read it."""
        spacing = float(self.x[1] - self.x[0])
        resolved = self.wavelength >= _CELLS_PER_WAVE * spacing
        return resolved and self.wavelength < 0.5 * float(np.nanmax(self.contact_half_width))


def half_profiles(
    dataset: xr.Dataset, variable: str, cycles: Sequence[int] | int | None = None
) -> HalfProfiles:
    """Take one quantity along x > 0 on the line nearest y = 0.

    Parameters
    ----------
    dataset : xarray.Dataset
        One case, quarter or whole, or one point of a merged study.
    variable : str
        Name of a field of a case, such as ``pressure``.
    cycles : sequence of int, optional
        Snapshots to take; if left out at most six of those that `dataset` has.

    Raises
    ------
    TypeError
        When `dataset` is no dataset.
    ValueError
        When `dataset` lacks the quantity, varies in more than cycle, x and y, or lacks a cycle.
    """
    check_dataset(dataset)
    dataset = with_cycles(dataset)
    field = _field(dataset, variable)
    picked = dataset.sel(cycle=list(checked_cycles(dataset, cycles)))
    line = _line_near_the_middle(picked[field])
    line = line.isel(x=np.flatnonzero(line["x"].values > 0.0)).transpose("cycle", "x")
    return HalfProfiles(
        x=line["x"].values.astype(np.float64),
        cycles=picked["cycle"].values.astype(np.float64),
        values=line.values.astype(np.float64),
        contact_half_width=picked["contact_half_width_x"].values.astype(np.float64),
        stick_half_width=picked["stick_half_width_x"].values.astype(np.float64),
        wavelength=roughness_wavelength(dataset),
        is_capped=bool(np.isfinite(float(dataset.coords.get("plastic_limit", np.inf)))),
    )


def with_cycles(dataset: xr.Dataset) -> xr.Dataset:
    """Give a dataset from which one snapshot was selected its dimension ``cycle`` back."""
    if "cycle" in dataset.coords and dataset["cycle"].ndim == 0:
        return dataset.expand_dims("cycle")
    return dataset


def available_cycles(dataset: xr.Dataset) -> tuple[int, ...]:
    """Return the cycles at which a case, or one point of a study, has snapshots."""
    cycles = np.atleast_1d(dataset["cycle"].values)
    width = dataset.get("contact_half_width_x")
    if width is not None and width.dims == ("cycle",):
        # Other points of a study may have snapshots where this one has none.
        cycles = cycles[np.isfinite(width.values)]
    return tuple(int(cycle) for cycle in cycles)


def representative_cycles(available: Collection[int], most: int = 6) -> tuple[int, ...]:
    """Choose at most `most` cycles, first and last included, that look different.

    They are evenly spread in the fourth root of the cycle: in the logarithm too many early ones
    would be among them, whose profiles coincide.
    """
    ordered = sorted(available)
    if len(ordered) <= most:
        return tuple(ordered)
    position = np.asarray(ordered, dtype=np.float64) ** 0.25
    wanted = np.linspace(position[0], position[-1], most)
    nearest = {int(np.abs(position - level).argmin()) for level in wanted}
    return tuple(ordered[index] for index in sorted(nearest | {0, len(ordered) - 1}))


def roughness_wavelength(dataset: xr.Dataset) -> float:
    """Return the wavelength 4A/tan θ_x of the waves along x in m, 0 when there are none."""
    if not {"roughness_amplitude", "roughness_slope_x"} <= set(dataset.coords):
        return 0.0
    slope = math.tan(float(dataset["roughness_slope_x"]))
    amplitude = float(dataset["roughness_amplitude"])
    return 4.0 * amplitude / slope if slope > 0.0 else 0.0


def peak_envelope(x: Array, values: Array, wavelength: float) -> Array:
    """Return the curve through the highest value of every wave.

    Parameters
    ----------
    x : array of shape (n,)
        Cell centres in m.
    values : array of shape (n,)
        A quantity that is nowhere negative, in any unit, of a surface even in x.
    wavelength : float
        Wavelength along x in m.

    Returns
    -------
    array of shape (n,)
        Shape-preserving cubics through the peaks: they overshoot none of them.
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
    return _through(np.asarray(knots), np.asarray(heights), x, values)


def wave_mean(x: Array, values: Array, wavelength: float) -> Array:
    """Return the running mean over a wave, for quantities whose peaks say little.

    Parameters and result are those of `peak_envelope`. At x = 0 the profile is continued evenly;
    near its end, where the mean would need values beyond, the result is NaN. The mean of the mean
    is taken: a single one leaves ripples where a wave is not a whole number of cells.
    """
    cells = max(1, round(wavelength / float(x[1] - x[0])))
    window = np.convolve(np.full(cells, 1.0 / cells), np.full(cells, 1.0 / cells))
    half = window.size // 2
    if values.size <= half:
        return values
    continued = np.concatenate([values[:half][::-1], values, np.full(half, np.nan)])
    return np.convolve(continued, window, mode="valid")


def _through(knots: Array, heights: Array, x: Array, values: Array) -> Array:
    if knots.size < 2:
        return values
    curve = np.asarray(PchipInterpolator(knots, heights, extrapolate=False)(x))
    curve = np.where(x < knots[0], heights[0], curve)
    return np.where(x > knots[-1], np.where(np.isfinite(values), heights[-1], np.nan), curve)


def checked_cycles(dataset: xr.Dataset, cycles: Sequence[int] | int | None) -> Sequence[int]:
    """Return the cycles asked for, or at most six; refuse those without a snapshot."""
    available = list(available_cycles(dataset))
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


def _field(dataset: xr.Dataset, variable: str) -> str:
    """Return the name under which a dataset of a case or a point has a field."""
    for name in (variable, _MERGED_NAME.get(variable, variable)):
        if name in dataset:
            break
    else:
        raise missing_variable(dataset, variable)
    extra = set(dataset[name].dims) - {"cycle", "x", "y"}
    if extra:
        raise ValueError(
            f"{name} varies along {sorted(map(str, extra))}: "
            "select one point first, for example with dataset.isel(...)."
        )
    return name


def _line_near_the_middle(field: xr.DataArray) -> xr.DataArray:
    if "y" not in field.dims:
        return field
    return field.isel(y=int(np.abs(field["y"].values).argmin()))
