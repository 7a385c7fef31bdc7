"""Stresses and parameters for cracks of a stored contact, as a dataset."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TypeAlias

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from fretwear.arrays import Array
from fretwear.data.labels import attributes_from
from fretwear.results import CYCLE, DEPTH, LOOP, PHASE, X, Y
from fretwear.study.case import Case
from fretwear.units import MEGAPASCAL, NO_UNIT, number_text, readable_unit, with_unit
from fretwear_cracks import StressError
from fretwear_cracks.cracks import OverPlanes, PointLoops, von_mises
from fretwear_cracks.inputs import (
    USUAL_COUNT,
    loaded_case,
    mean_of_bulk_stress,
    read_constants,
    read_depths,
    read_points,
    snapshot_of,
    surface_of,
    usual_depths,
)
from fretwear_cracks.states import LoadedSurface, StressHistory, over_the_loop
from fretwear_cracks.variables import CRACKS, EDGE, EDGE_STRESSES, STRESSES

# Dimensions, values and attributes.
_Labelled: TypeAlias = tuple[tuple[str, ...], Array, Mapping[str, object]]
_AXES, _EDGE = (X.name, Y.name, DEPTH.name), "edge"
_NORMAL = "unit normal of the plane on which it is largest"
# Relative difference of values that are equal but for rounding in single precision.
_ALIKE = 1e-6


def stress(
    ds: xr.Dataset,
    cycle: float = 0,
    points: ArrayLike | None = None,
    *,
    depths: Iterable[float | str] | None = None,
    phases: int = 32,
    fatemi_socie: Sequence[float | str] | None = None,
    crossland: float | None = None,
    mean_stress: float | str = 0.0,
    stress_ratio: float | None = None,
) -> xr.Dataset:
    """Compute stresses in the flat over one cycle of a case, and parameters for cracks.

    Tractions are those in the dataset, uniform on each cell; between +Q and −Q they follow by
    superposition from contacts of the stored shape, and the bulk stress of the case is in phase
    with the force, about its mean. Within a cell of the surface stresses show the cells.

    Parameters
    ----------
    ds : xarray.Dataset
        The dataset of a case, of `fretwear.simulate` or `fretwear.open_case`.
    cycle : float
        A snapshot.
    points : array_like, optional
        Points (x, y, z), m, shape (n, 3), z > 0 their depth. Line contacts ignore y.
    depths : iterable of float or str, optional
        Depths, m or text with a unit, if no points are given; by default 16 from 0.05 to 2 contact
        half-widths, under a punch from two cells; on the plane y = 0.
    phases : int
        Equal steps of the tangential force over the loop, even; the first is +Q, the middle one −Q.
    fatemi_socie : (float, float or str), optional
        k and the yield strength, Pa, of the Fatemi–Socie parameter.
    crossland : float, optional
        Weight α of the mean stress in the Crossland parameter.
    mean_stress : float or str, optional
        Mean of the bulk stress along x in the flat, Pa; it does not change the contact.
    stress_ratio : float, optional
        Instead of the mean, the ratio R < 1 of the least bulk stress to the largest; −1 by default.

    Returns
    -------
    xarray.Dataset
        ``stress_xx`` to ``stress_xz`` and ``von_mises``, Pa, over ``phase`` and
        ``point`` or ``x``, ``y`` and ``z``. ``smith_watson_topper`` and the other parameters, for
        which constants were given, of the loop at each point; ``<name>_normal`` is the normal of
        the worst plane along ``axis``; ``ruiz``, over ``x``, of the surface at y = 0. On the plane
        y = 0 also ``edge_stress_xx``, ``edge_stress_yy`` and ``<name>_edge`` of the surface itself
        at the ends of contact, ``edge_x``, where tension along x is largest. ``force`` is the
        tangential force at each phase.

    Raises
    ------
    StressError
        If the dataset is not a case, has no such snapshot or no shear traction, if a point
        or a depth does not lie below the surface, or if constants are wrong.
    """
    case = loaded_case(ds)
    if phases != int(phases) or phases < 2 or phases % 2:
        raise StressError(f"phases = {phases!r}: must be an even number, such as 32")
    constants = read_constants(fatemi_socie, crossland)
    if points is not None and depths is not None:
        raise StressError("points do not go with depths")
    snapshot = snapshot_of(ds, cycle)
    surface, slip = surface_of(snapshot, case, cycle)
    mean = mean_of_bulk_stress(case, mean_stress, stress_ratio)
    history = StressHistory(surface, int(phases), case.bulk_stress, mean)
    dims: tuple[str, ...]
    if points is not None:
        x, y, z = places = read_points(points).T
        dims = ("point",)
        along = [dims] * 3
        parts = history.at(places.T)
    else:
        z = usual_depths(snapshot, USUAL_COUNT) if depths is None else read_depths(depths)
        x, y, dims = history.tractions.x, np.zeros(1), _AXES
        along = [(name,) for name in dims]
        steady, alternating = zip(*map(history.section, z), strict=True)
        parts = np.stack(steady, -1)[:, :, None], np.stack(alternating, -1)[..., None, :]
    tensors = np.moveaxis(over_the_loop(*parts), 1, 0)
    values = (*tensors, von_mises(tensors))
    variables: dict[str, object] = {
        of.name: ((PHASE.name, *dims), field.astype(of.dtype), of.attributes)
        for of, field in zip(STRESSES, values, strict=True)
    }
    variables |= _cracks(parts, dims, ds, constants)
    pairs = zip((X, Y, DEPTH), along, (x, y, z), strict=True)
    coordinates: dict[str, object] = {
        variable.name: (of, values, variable.attributes) for variable, of, values in pairs
    }
    coordinates["axis"] = ("axis", np.array(["x", "y", "z"]))
    if points is None:
        variables[CRACKS[-1].name] = ((X.name,), _ruiz(history, slip), CRACKS[-1].attributes)
        edges, at_edges = _at_edges(history, ds, constants)
        variables |= at_edges
        coordinates |= edges
    force = LOOP[0].in_frame(case.frame)
    integral = surface.half_space.geometry.integral
    falling = np.array([integral(shear) for shear in history.tractions.shear])
    coordinates |= {
        PHASE.name: (PHASE.name, np.arange(phases) / phases, PHASE.attributes),
        force.name: (PHASE.name, np.concatenate([falling, -falling]), force.attributes),
        CYCLE.name: ((), float(cycle), CYCLE.attributes),
    }
    warnings = [*_warnings(case, snapshot, surface, float(z.min()))]
    attributes = {
        **attributes_from(ds, "Stresses below the surface", "fretwear.stress"),
        "mean_stress": mean,
    }
    if "hertz_pressure" in ds.coords:
        attributes["hertz_pressure"] = float(ds["hertz_pressure"])
    result = xr.Dataset(variables, coordinates, attributes)
    if points is None and depths is None:
        warnings += warnings_of_depth(result[CRACKS[0].name].values[:, 0], z)
    return result.assign_attrs(warnings="\n".join(warnings))


def place_of_largest(values: Array) -> tuple[int, ...]:
    """Return the first place of the largest value, as an index, equal values within rounding.

    The sides of an even contact are equal: which one is larger would be decided by the last bits.
    """
    largest = float(np.nanmax(values))
    first = int(np.flatnonzero(values >= largest - _ALIKE * abs(largest))[0])
    return tuple(int(index) for index in np.unravel_index(first, values.shape))


def largest_values(stresses: xr.Dataset) -> Iterable[tuple[str, str]]:
    """Yield the words of the equivalent stresses and of each parameter, and where it is largest.

    The bodies first yield where an equivalent stress is largest, at the given part of the Hertz
    pressure. The stress along x at the edge of contact is at the surface itself.
    """
    for variable in (*STRESSES[6:], EDGE_STRESSES[0], *CRACKS[:-1]):
        if variable.name not in stresses:
            continue
        field = stresses[variable.name]
        place = dict(zip(field.dims, place_of_largest(field.values), strict=True))
        point = field.isel(place)
        value = float(point)
        unit = readable_unit([value], variable.si_unit) if variable.unit is MEGAPASCAL else NO_UNIT
        text = with_unit(number_text(value / unit.size), unit)
        if variable not in CRACKS and (pressure := stresses.attrs.get("hertz_pressure")):
            text += f" = {number_text(value / pressure, 4)} p0"
        names = {EDGE.name: X.name} if EDGE.name in point.coords else {n: n for n in _AXES}
        places = ((called, float(point[name])) for name, called in names.items())
        text += ", " + ", ".join(
            f"{called} = {number_text(place * 1e6, 4)} µm" for called, place in places
        )
        if PHASE.name in field.dims:
            text += f", phase {number_text(float(point[PHASE.name]), 4)}"
        if (normals := f"{variable.name}_normal") in stresses and value > 0.0:
            normal = stresses[normals].isel(place)
            steepness = np.degrees(np.arccos(min(1.0, abs(float(normal.sel(axis="z"))))))
            text += f", plane {steepness:.0f}° to the surface"
        yield variable.words, text


def _cracks(
    parts: tuple[Array, Array],
    dims: tuple[str, ...],
    ds: xr.Dataset,
    constants: Mapping[str, tuple[float, ...]],
) -> dict[str, _Labelled]:
    """The parameters for which constants were given, with the normals of worst planes."""
    steady, alternating = parts
    shape = steady.shape[1:]
    flat = {
        name: float(ds.coords.get(f"{name}_2", ds.coords.get(name)))
        for name in ("youngs_modulus", "poisson_ratio")
    }
    loops = PointLoops(steady.reshape(6, -1), alternating.reshape(len(alternating), 6, -1), **flat)
    cracks: dict[str, _Labelled] = {}
    for variable in CRACKS:
        if variable.name not in constants:
            continue
        result = getattr(loops, variable.name)(*constants[variable.name])
        attributes = variable.attributes
        if isinstance(result, OverPlanes):
            normal = {"long_name": _NORMAL, "units": "1"}
            values = result.normal.reshape(*shape, 3)
            cracks[f"{variable.name}_normal"] = ((*dims, "axis"), values, normal)
            result = result.value
        cracks[variable.name] = (dims, result.reshape(shape), attributes)
    return cracks


def _at_edges(
    history: StressHistory, ds: xr.Dataset, constants: Mapping[str, tuple[float, ...]]
) -> tuple[dict[str, object], dict[str, object]]:
    """Ends of contact on the plane y = 0, and stresses and parameters at the surface there."""
    if not (ends := history.at_edges()):
        return {}, {}
    x = np.array([place for place, _, _ in ends])
    parts = (np.stack([end[1] for end in ends], -1), np.stack([end[2] for end in ends], -1))
    fields: dict[str, object] = {}
    for component, variable in enumerate(EDGE_STRESSES):
        values = over_the_loop(*parts)[:, component]
        fields[variable.name] = ((PHASE.name, _EDGE), values, variable.attributes)
    for name, (dims, values, attributes) in _cracks(parts, (_EDGE,), ds, constants).items():
        base, normal, _ = name.partition("_normal")
        words = f"{attributes['long_name']} at the edge of contact"
        fields[f"{base}_edge{normal}"] = dims, values, {**attributes, "long_name": words}
    return {EDGE.name: ((_EDGE,), x, EDGE.attributes)}, fields


def _ruiz(history: StressHistory, slip: Array) -> Array:
    """σ_xx τ s of the surface at y = 0, Pa² m, along x.

    C. Ruiz, P. H. B. Boddington and K. C. Chen, "An investigation of fatigue and fretting in a
    dovetail joint", Exp. Mech. 24 (1984).
    """
    steady, alternating = history.section(0.0)
    tension = np.maximum(steady[0] + abs(alternating[:, 0]).max(axis=0), 0.0)
    surface = history.surface
    traction = surface.shear if surface.across is None else np.hypot(surface.shear, surface.across)
    work = abs(traction) * slip
    # The mean of the rows on both sides of y = 0, which are the same if the contact is even.
    middle = 0 if surface.even[1] or surface.plane_strain else work.shape[1] // 2
    row = work[:, max(middle - 1, 0) : middle + 1].mean(axis=1)
    both = np.concatenate([row[::-1], row]) if surface.even[0] else row
    return np.asarray(tension * both)


def warnings_of_depth(parameter: Array, depths: Array) -> Iterable[str]:
    """Warn of a parameter of Smith, Watson and Topper, Pa, (nx, nz), that has no largest value."""
    first, second = (float(column.max()) * 1e-6 for column in parameter.T[:2])
    if first > 0.0 and parameter[:, 0].max() >= parameter.max():
        yield (
            "the Smith–Watson–Topper parameter is largest at the shallowest depth and depends on "
            f"it: {first:.3g} MPa at {depths[0] * 1e6:.3g} µm, {second:.3g} MPa at "
            f"{depths[1] * 1e6:.3g} µm; compare contacts at half of the material's critical "
            "distance, by fretwear stress with --depth"
        )


def _warnings(
    case: Case, snapshot: xr.Dataset, surface: LoadedSurface, shallow: float
) -> Iterable[str]:
    """Warn of stresses that are less accurate, from a shallow depth on, m."""
    cell = max(surface.spacing)
    if shallow < cell:
        yield (
            f"a depth of {shallow * 1e6:.3g} µm is less than a cell, {cell * 1e6:.3g} µm: stresses "
            "there show the cells"
        )
    worn = "wear_depth" in snapshot and bool(snapshot["wear_depth"].values.any())
    if worn and np.isinf(case.plastic_limit) and shallow < 4 * cell:
        yield (
            "the pressure of worn elastic bodies is singular at the edge of stick: stresses have "
            "no limit at the surface"
        )
