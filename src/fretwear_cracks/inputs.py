"""What stresses are computed from: a stored contact, places and constants, read and checked."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from functools import partial

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from fretwear.arrays import Array
from fretwear.data.dataset import require_dataset
from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.slip.models import Cerruti
from fretwear.mechanics.surfaces.setup import block_at
from fretwear.quantity import Quantity, declared
from fretwear.results import CYCLE, FRICTION_FIELD, SYMMETRIES, X, Y
from fretwear.study.case import Case
from fretwear.theory import LineContact
from fretwear.units import QuantityError, cycle_text, listed
from fretwear_cracks import StressError
from fretwear_cracks.constants import StressConstants
from fretwear_cracks.states import LoadedSurface

KEYS = {key: q for key, q in declared(StressConstants).items() if isinstance(q, Quantity)}
"""Quantities of `StressConstants` by their keys."""
# k and the yield strength, and the weight of the mean stress.
_FATEMI_SOCIE = (
    Quantity("1", "", "", like="1", ge=0.0),
    Quantity("Pa", "", "", "MPa", "1000 MPa", gt=0.0),
)
_CROSSLAND = Quantity("1", "", "")

# First and last depth that are looked at unless others are asked for, in contact half-widths, and
# how many there are. Edges of a punch are narrower than its contact: there the first is in cells.
_FIRST, _LAST, USUAL_COUNT = 0.05, 2.0, 16
_FIRST_CELLS = 2.0
_FIELDS, _ACROSS = ("pressure", "shear_traction", "gap", "slip"), "shear_traction_y"


def loaded_case(ds: xr.Dataset) -> Case:
    """The case of a dataset; `StressError` if there is none, or none whose stresses are known."""
    require_dataset(ds)
    try:
        parameters = json.loads(ds.attrs["parameters"])
        # What is left of a roughness is in the fields; files of heights may have gone.
        smooth = {n: v for n, v in parameters.items() if n not in ("roughness", "counterface")}
        case = Case(**smooth)
    except (KeyError, TypeError, ValueError) as error:
        reason = "has no attribute 'parameters'" if "parameters" not in ds.attrs else str(error)
        raise StressError(f"the dataset is not a case: {reason}") from error
    if lacking := [name for name in _FIELDS if name not in ds]:
        raise StressError(f"the dataset lacks {listed(lacking)}; run the case again")
    return case


def snapshot_of(ds: xr.Dataset, cycle: float) -> xr.Dataset:
    """The dataset at a snapshot; `StressError` if there is none."""
    stored = ds[CYCLE.name].values
    if cycle not in stored:
        there = listed([*map(cycle_text, stored)])
        raise StressError(f"cycle {cycle_text(cycle)} is not a snapshot; there are {there}")
    snapshot: xr.Dataset = ds.sel(cycle=cycle)
    return snapshot


def surface_of(snapshot: xr.Dataset, case: Case, cycle: float) -> tuple[LoadedSurface, Array]:
    """The surface of a snapshot, and slip, on the cells of the positive sides where it is even."""
    blocks = [(end, block) for end, block in case.in_blocks() if block is not None]
    setup = block_at(blocks, cycle).at(cycle)
    refused = {
        "a contact that slides over a stroke moves over the flat": setup.loading.stroke,
        "the flat has a coating, a layer on a substrate": setup.coating is not None,
        "cattaneo_mindlin has the slip of the unworn contact": not setup.slip_model.follows_shape,
        "tractions of a pulsating load depend on how it began": setup.normal.pulsating_load < 1.0,
    }
    for reason in (reason for reason, holds in refused.items() if holds):
        raise StressError(f"{reason}: its stresses are not computed")
    names = [n for n in (*_FIELDS, _ACROSS, FRICTION_FIELD.name) if n in snapshot]
    fields = {name: np.asarray(snapshot[name].values, np.float64) for name in names}
    if not fields["shear_traction"].any():
        raise StressError("there is no shear traction in this snapshot, so no loop of stresses")
    even, axes = list(SYMMETRIES[snapshot.attrs["symmetry"]]), case.frame.axes
    if Y.name not in axes:
        fields, even[1] = {name: field[:, None] for name, field in fields.items()}, False
    for axis in range(len(axes)):
        if not even[axis] and all(
            np.array_equal(field, np.flip(-field if name == _ACROSS else field, axis))
            for name, field in fields.items()
        ):
            fields = {name: np.split(field, 2, axis)[1] for name, field in fields.items()}
            even[axis] = True
    steps = [float(np.diff(snapshot[name].values).mean()) for name in axes]
    hertz, friction = setup.hertz, setup.friction_law.coefficient
    flat = snapshot.coords.get("poisson_ratio_2", snapshot.coords.get("poisson_ratio"))
    # The case has lost its roughness.
    parameters = json.loads(snapshot.attrs["parameters"])
    rough = any(parameters.get(name) is not None for name in ("roughness", "counterface"))
    surface = LoadedSurface(
        fields["pressure"],
        fields["shear_traction"],
        fields["gap"],
        spacing=(steps[0], steps[-1]),
        even=(even[0], even[1]),
        friction=friction,
        composite_modulus=setup.composite_modulus,
        poisson_ratio=float(flat),
        reference=hertz.reference if isinstance(hertz, LineContact) else None,
        across=fields.get(_ACROSS),
        coupling=setup.bodies.coupling,
        is_directed=isinstance(setup.slip_model, Cerruti)
        and (rough or case.cells.geometry is Grid),
        tilt=setup.tilt,
        ratio=fields.get(FRICTION_FIELD.name, friction) / friction,
    )
    return surface, fields["slip"]


def usual_depths(snapshot: xr.Dataset, count: int, last: float | None = None) -> Array:
    """Depths in geometric progression, m, down to 2 contact half-widths or another depth."""
    half_width = float(snapshot["contact_half_width_x"])
    first = _FIRST * half_width
    if "hertz_pressure" not in snapshot.coords:
        cell = float(np.diff(snapshot[X.name].values).mean())
        first = min(first, _FIRST_CELLS * cell)
    if last is not None and not last > first:
        raise StressError(f"depth = {last * 1e6:.3g} µm: must be more than {first * 1e6:.3g} µm")
    return np.geomspace(first, _LAST * half_width if last is None else last, count)


def read_constants(
    fatemi_socie: Sequence[float | str] | None, crossland: float | None
) -> dict[str, tuple[float, ...]]:
    """Constants by the parameter that they are for."""
    constants: dict[str, tuple[float, ...]] = {"smith_watson_topper": ()}
    if fatemi_socie is not None:
        constants["fatemi_socie"] = read_pair("fatemi_socie", fatemi_socie, _FATEMI_SOCIE)
    if crossland is not None:
        constants["crossland"] = (read_quantity("crossland", crossland, _CROSSLAND),)
    return constants


def mean_of_bulk_stress(case: Case, mean_stress: float | str, stress_ratio: float | None) -> float:
    """The mean σ_m of the stress along x in the flat, Pa: itself, or by R from its amplitude σ_a.

    R, the least stress over the largest, is (σ_m − σ_a)/(σ_m + σ_a).
    """
    mean = read_quantity("mean_stress", mean_stress, KEYS["mean_stress"])
    if stress_ratio is None:
        return mean
    ratio = read_quantity("stress_ratio", stress_ratio, KEYS["stress_ratio"])
    if mean:
        raise StressError("give stress_ratio or mean_stress, not both")
    return case.bulk_stress * (1.0 + ratio) / (1.0 - ratio)


def read_pair(
    name: str, pair: Sequence[float | str], quantities: tuple[Quantity, Quantity]
) -> tuple[float, float]:
    """Two constants of a law, in SI units; text has a comma between them."""
    parts = [part.strip() for part in pair.split(",")] if isinstance(pair, str) else pair
    values = np.atleast_1d(np.asarray(parts, object))
    if values.size != 2:
        example = ", ".join(quantity.example for quantity in quantities)
        raise StressError(f"{name} = {pair!r}: must be two constants, such as {example!r}")
    first, second = map(partial(read_quantity, name), values, quantities)
    return first, second


def read_quantity(name: str, value: object, quantity: Quantity) -> float:
    """A number, or text with a unit, in SI units; `StressError` if it is not one of a quantity."""
    try:
        number: float = quantity.read(value)
    except QuantityError as error:
        raise StressError(f"{name} = {value!r}: {error}") from error
    return number


def read_points(points: ArrayLike) -> Array:
    """Points below the surface, m, shape (n, 3)."""
    places = np.atleast_2d(np.asarray(points, np.float64))
    if places.ndim != 2 or places.shape[1] != 3 or not np.isfinite(places).all():
        raise StressError("points must be (x, y, z) in m, as an array of shape (n, 3)")
    if not (places[:, 2] > 0.0).all():
        raise StressError("points: z must be larger than 0, a depth in m")
    return places


def read_depths(depths: Iterable[float | str]) -> Array:
    """Increasing depths, m."""
    values = np.array([read_quantity("depth", depth, KEYS["depth"]) for depth in depths])
    if not values.size or not (np.diff(values, prepend=0.0) > 0.0).all():
        raise StressError("depths must increase from one to the next, the first above 0")
    return values
