"""Where and when a case is expected to crack, and whether wear comes first, as a dataset."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from itertools import chain, islice
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from fretwear.arrays import Array
from fretwear.data.atomic import DataFileError
from fretwear.data.dataset import line_near_the_middle, require_dataset
from fretwear.data.files import open_case, write_groups
from fretwear.data.groups import open_group
from fretwear.data.labels import attributes_from
from fretwear.results import CYCLE, X
from fretwear.units import NO_UNIT, cycle_text, number_text
from fretwear.version import code_digest
from fretwear_cracks import StressError
from fretwear_cracks.constants import LAWS
from fretwear_cracks.inputs import KEYS, read_pair, read_quantity, snapshot_of, usual_depths
from fretwear_cracks.life import Damage, StrainLife, summed_damage
from fretwear_cracks.stresses import place_of_largest, stress, warnings_of_depth
from fretwear_cracks.variables import (
    CRACKS,
    EDGE_STRESSES,
    FATIGUE,
    FATIGUE_HEADS,
    FATIGUE_OUTCOMES,
)

# Number of depths of stresses.
_COUNT = 20
# Points of the material above the first depth, as parts of it.
_ABOVE = np.array([0.125, 0.25, 0.5])
_SWT, _TENSION = CRACKS[0], EDGE_STRESSES[0].name
_MATERIAL = "material_z"


def fatigue(
    ds: xr.Dataset,
    cycles: Iterable[float] | None = None,
    *,
    depth: float | str | None = None,
    basquin: Sequence[float | str] | None = None,
    manson_coffin: Sequence[float | str] | None = None,
    phases: int = 32,
    mean_stress: float | str = 0.0,
    stress_ratio: float | None = None,
) -> xr.Dataset:
    """Find where a case is expected to crack at its snapshots, and whether wear comes first.

    The criterion is the parameter of Smith, Watson and Topper on the plane y = 0. With constants of
    the material it gives lives, and by Miner's sum over the snapshots the damage of points fixed in
    the flat, which wear brings to the surface and removes. Between snapshots wear and stresses
    change linearly; above the first depth the damage is that at this depth.

    Parameters
    ----------
    ds : xarray.Dataset
        The dataset of a case, of `fretwear.simulate` or `fretwear.open_case`.
    cycles : iterable of float, optional
        Snapshots, by default all.
    depth : float or str, optional
        Largest depth examined, m; by default 2 contact half-widths.
    basquin : (float or str, float), optional
        Fatigue strength σ_f', Pa, and exponent b < 0 in σ_a = σ_f' (2N)^b.
    manson_coffin : (float, float), optional
        Fatigue ductility ε_f' and exponent c < 0 in ε_a,p = ε_f' (2N)^c; without it strains are
        elastic.
    phases : int
        Equal steps of the tangential force over a loop.
    mean_stress, stress_ratio : float or str, optional
        Mean of the bulk stress, Pa, or its ratio R, as of `fretwear.stress`.

    Returns
    -------
    xarray.Dataset
        ``smith_watson_topper`` (cycle, x, z), Pa, at depths below the surface of each snapshot, and
        over ``cycle`` ``largest_tension``, ``largest_smith_watson_topper`` with its place,
        ``crack_x``, ``crack_depth``, and ``crack_angle``, degrees, of the plane from +x downwards.
        With constants also ``damage`` (cycle, x, material_z) at depths below the unworn surface,
        NaN where it is worn away, and ``life``, ``largest_damage``, ``crack_cycle`` and
        ``fatigue_outcome``.

    Raises
    ------
    StressError
        As `fretwear.stress`, or if constants are wrong.
    """
    require_dataset(ds)
    life = _life(basquin, manson_coffin)
    stored = np.atleast_1d(ds[CYCLE.name].values) if CYCLE.name in ds.coords else np.zeros(0)
    asked = stored if cycles is None else np.unique(np.array([*cycles], float))
    if not asked.size:
        raise StressError("the dataset has no snapshots")
    last = None if depth is None else read_quantity("depth", depth, KEYS["depth"])
    depths = usual_depths(snapshot_of(ds, asked[0]), _COUNT, last)
    compute = partial(
        stress, ds, depths=depths, phases=phases, mean_stress=mean_stress, stress_ratio=stress_ratio
    )
    at_cycles = [compute(cycle) for cycle in asked]
    names = [_SWT.name, f"{_SWT.name}_normal"]
    swt = xr.concat([state[names].isel(y=0, drop=True) for state in at_cycles], CYCLE.name)
    parameters, normals = (swt[name].values for name in names)
    places = [place_of_largest(field) for field in parameters]
    x = swt[X.name].values
    # Where the surface is singular there is none.
    tensions = [float(s[_TENSION].max()) if _TENSION in s else np.nan for s in at_cycles]
    # From +x downwards: along the plane, across its normal.
    planes = [normal[place] for normal, place in zip(normals, places, strict=True)]
    angles = [np.degrees(np.arctan2(abs(n[0]), -n[2] if n[0] > 0.0 else n[2])) for n in planes]
    largest = np.array([field[place] for field, place in zip(parameters, places, strict=True)])
    values: dict[str, object] = {
        "largest_tension": tensions,
        "largest_smith_watson_topper": largest,
        "crack_x": [x[place[0]] for place in places],
        "crack_depth": [depths[place[1]] for place in places],
        "crack_angle": angles,
    }
    result = swt[[_SWT.name]]
    warnings = dict.fromkeys(
        warning for state in at_cycles for warning in state.attrs["warnings"].splitlines()
    )
    if any(place[0] in (0, x.size - 1) for place in places):
        warnings["the largest parameter lies at the border of the window"] = None
    # One for all snapshots.
    of_depth = chain.from_iterable(warnings_of_depth(field, depths) for field in parameters)
    warnings |= dict.fromkeys(islice(of_depth, 1))
    constants = {} if life is None else {name: float(v) for name, v in vars(life).items()}
    if life is not None:
        modulus = float(ds.coords.get("youngs_modulus_2", ds.coords.get("youngs_modulus")))
        worn, further = _worn_flat(ds, asked, x)
        warnings |= dict.fromkeys(further)
        points = np.concatenate([_ABOVE * depths[0], depths])
        damage = summed_damage(asked, parameters, depths, worn, points, life, modulus)
        values |= _outcomes(asked, damage, 1.0 / life.cycles(parameters[0], modulus))
        values["life"] = life.cycles(largest, modulus)
        left = np.where(damage.removed, np.nan, damage.sums)
        words = {"long_name": "fatigue damage", "units": "1", "comment": "1 is a crack"}
        result["damage"] = (CYCLE.name, X.name, _MATERIAL), left, words
        words = {"long_name": "depth below the unworn surface of the flat", "units": "m"}
        result.coords[_MATERIAL] = _MATERIAL, points, words
    scalars = {
        variable.name: (CYCLE.name, np.asarray(values[variable.name], float), variable.attributes)
        for variable in FATIGUE
        if variable.name in values
    }
    result.attrs = {
        **attributes_from(ds, "Fatigue and wear", "fretwear.fatigue"),
        **constants,
        "mean_stress": at_cycles[0].attrs["mean_stress"],
        "warnings": "\n".join(warnings),
    }
    return result.assign(scalars)


def stored_fatigue(
    case: Path, cycles: Iterable[int] | None, depth: float | None, constants: Mapping[str, Any]
) -> xr.Dataset:
    """The fatigue of a case file, from the folder ``fatigue`` beside the folder of cases.

    It is computed where it is missing, or of another case file, request or code. `StressError` if
    stresses of the case are not known, `DataFileError` if a file cannot be read or written.
    """
    path = case.parent.parent / "fatigue" / case.name
    code = code_digest("fretwear_cracks")
    asked = [cycles, depth, constants, case.stat().st_mtime_ns, code]
    settings = json.dumps(asked, default=str)
    with suppress(DataFileError), open_group(path) as stored:
        if stored.attrs.get("asked") == settings:
            return stored.load()
    with open_case(case) as ds:
        snapshots = {*ds[CYCLE.name].values.tolist()}
        shown = None if cycles is None else snapshots & {0.0, *map(float, cycles)}
        outcome = fatigue(ds, shown, depth=depth, **constants)
    outcome.attrs["asked"] = settings
    write_groups(path, {"": outcome})
    return outcome


def fatigue_table(outcome: xr.Dataset) -> list[tuple[str, ...]]:
    """Rows of text about the snapshots of `fatigue`, below a row of words."""
    columns = [(CYCLE.name, *map(cycle_text, outcome[CYCLE.name].values))]
    for variable, head in zip(FATIGUE, FATIGUE_HEADS, strict=True):
        if variable.name in outcome:
            values, unit = outcome[variable.name].values, variable.unit or NO_UNIT
            head = f"{head} ({unit.name})" if unit.name else head
            texts = [number_text(v / unit.size, 4) if np.isfinite(v) else "–" for v in values]
            if variable.name == "fatigue_outcome":
                texts = [FATIGUE_OUTCOMES[int(code)] for code in values]
            columns.append((head, *texts))
    return [*zip(*columns, strict=True)]


def _outcomes(cycles: Array, damage: Damage, rate_without_wear: Array) -> dict[str, Array]:
    """Largest damage, first crack and outcome at each snapshot."""
    left = np.where(damage.removed, 0.0, damage.sums)
    cracked = (left >= 1.0).any(axis=(1, 2))
    without = rate_without_wear.max() * (cycles - cycles[0]) >= 1.0
    was = (damage.sums >= 1.0).any(axis=(1, 2))
    outcome = np.where(cracked, 2, np.where(without | was, 1, 0))
    first = damage.first_crack.min()
    return {
        "largest_damage": left.max(axis=(1, 2)),
        "crack_cycle": np.where(cycles >= first, first, np.nan),
        "fatigue_outcome": outcome,
    }


def _worn_flat(ds: xr.Dataset, cycles: Array, x: Array) -> tuple[Array, list[str]]:
    """What wear has taken off the flat along x at y = 0, m, shape (k, nx), and warnings of it."""
    whole = ds.fretwear.full()
    name = "wear_depth_flat" if "wear_depth_flat" in whole else "wear_depth"
    rows = line_near_the_middle(whole[name]).sel({CYCLE.name: cycles})
    worn = np.stack([np.interp(x, rows[X.name].values, row) for row in rows.values])
    if name == "wear_depth_flat":
        return worn, []
    warning = "the case has the wear of both bodies together: half of it is taken to be of the flat"
    return 0.5 * worn, [warning] if worn.any() else []


def _life(
    basquin: Sequence[float | str] | None, manson_coffin: Sequence[float | str] | None
) -> StrainLife | None:
    """The constants of lives, or None; `StressError` if they are wrong."""
    pairs = zip(LAWS.items(), (basquin, manson_coffin), strict=True)
    read = [
        read_pair(law, pair, (KEYS[constant], KEYS[exponent]))
        for (law, (constant, exponent)), pair in pairs
        if pair is not None
    ]
    if manson_coffin is not None and basquin is None:
        raise StressError("manson_coffin: give basquin too, the elastic part of a life")
    return StrainLife(*chain.from_iterable(read)) if read else None
