"""Labelled datasets of one case: made from plain arrays, mirrored, compared."""

from __future__ import annotations

import json
import math
import os
import subprocess
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

import fretwear
from fretwear.vocabulary import (
    CASE_DIMS,
    CONVOLUTIONS,
    CYCLE,
    ERROR_ESTIMATE,
    FIELDS,
    MAXIMUM_WEAR_DEPTH,
    RESULTS,
    SCALARS,
    STEP,
    SYMMETRIES,
    Field,
    Variable,
    X,
    Y,
)

if TYPE_CHECKING:
    from fretwear.study.case import Case


CONVENTIONS = "CF-1.11"

Symmetry = Literal["even_xy", "none"]


def case_dataset(
    case: Case,
    x: ArrayLike,
    y: ArrayLike,
    cycles: ArrayLike,
    fields: Mapping[str, ArrayLike],
    scalars: Mapping[str, ArrayLike],
    *,
    symmetry: Symmetry = "even_xy",
    title: str = "",
    command: str = "fretwear.simulate",
) -> xr.Dataset:
    """Label the results of one case.

    Parameters
    ----------
    case : Case
        The case; its parameters become scalar coordinates and the attribute ``parameters``.
    x, y : array_like, shape (nx,) and (ny,)
        Cell centres in m, increasing; all positive when only a quarter is stored.
    cycles : array_like, shape (ncycles,)
        Cycle number of each snapshot, increasing from 0.
    fields : mapping of str to array_like, shape (ncycles, nx, ny)
        Every variable of `fretwear.vocabulary.FIELDS`, SI units.
    scalars : mapping of str to array_like, shape (ncycles,)
        Every variable of `fretwear.vocabulary.SCALARS`, SI units, for the whole contact.
    symmetry : {"even_xy", "none"}
        ``"even_xy"`` when the arrays are the quarter x > 0, y > 0 of a contact even in both.
    title : str
        Title of the dataset; the case's id serves when it is empty.
    command : str
        What was run, for the attribute ``history``.

    Returns
    -------
    xarray.Dataset
        Dimensions ``cycle``, ``x``, ``y``. Fields are float32 (``contact_state`` int8), scalars
        and coordinates float64.

    Raises
    ------
    ValueError
        When a variable is missing, not known, of the wrong shape or not finite, or when a
        coordinate does not increase. The message lists all of these.
    """
    coords = {
        "cycle": _coordinate(CYCLE, cycles),
        "x": _coordinate(X, x),
        "y": _coordinate(Y, y),
    }
    sizes = {name: values.size for name, values in coords.items()}
    arrays = {name: np.asarray(values) for name, values in {**fields, **scalars}.items()}
    field_shape = tuple(sizes[dim] for dim in CASE_DIMS)
    _raise_all(
        [
            *_coordinate_problems(coords, symmetry),
            *_name_problems("field", FIELDS, fields),
            *_name_problems("scalar", SCALARS, scalars),
            *_array_problems(FIELDS, arrays, field_shape),
            *_array_problems(SCALARS, arrays, field_shape[:1]),
        ]
    )
    variables = {field.name: _labelled(field, CASE_DIMS, arrays[field.name]) for field in FIELDS}
    variables |= {
        scalar.name: _labelled(scalar, CASE_DIMS[:1], arrays[scalar.name]) for scalar in SCALARS
    }
    attributes = {
        "title": title or f"Fretting wear of case {case.case_id}",
        "Conventions": CONVENTIONS,
        "source": source(),
        "history": history_line(command),
        "parameters": json.dumps(case.canonical_parameters(), sort_keys=True, allow_nan=False),
        "case_id": case.case_id,
        "symmetry": symmetry,
    }
    return xr.Dataset(variables, {**coords, **scalar_coordinates(case)}, attributes)


def history_dataset(
    cycles: ArrayLike,
    scalars: Mapping[str, ArrayLike],
    error_estimate: ArrayLike,
    convolutions: ArrayLike,
) -> xr.Dataset:
    """Label the dense history of a run: the scalars at every accepted step.

    Parameters
    ----------
    cycles : array_like, shape (nsteps,)
        Cycle number reached by each step, increasing; fractions occur.
    scalars : mapping of str to array_like, shape (nsteps,)
        Every variable of `fretwear.vocabulary.SCALARS`, SI units, for the whole contact.
    error_estimate : array_like, shape (nsteps,)
        Estimated relative error of each step.
    convolutions : array_like of int, shape (nsteps,)
        Convolutions that each step has cost.

    Returns
    -------
    xarray.Dataset
        Dimension ``step``; ``cycle`` is a coordinate along it.

    Raises
    ------
    ValueError
        As for `case_dataset`.
    """
    cycle = _labelled(CYCLE, (STEP.name,), np.asarray(cycles))
    arrays = {name: np.asarray(values) for name, values in scalars.items()}
    arrays[ERROR_ESTIMATE.name] = np.asarray(error_estimate)
    arrays[CONVOLUTIONS.name] = np.asarray(convolutions)
    expected = (*SCALARS, ERROR_ESTIMATE, CONVOLUTIONS)
    _raise_all(
        [
            *_coordinate_problems({CYCLE.name: cycle}, "none"),
            *_name_problems("scalar", expected, arrays),
            *_array_problems(expected, arrays, (cycle.size,)),
        ]
    )
    return xr.Dataset(
        {scalar.name: _labelled(scalar, (STEP.name,), arrays[scalar.name]) for scalar in expected},
        {
            STEP.name: _labelled(STEP, (STEP.name,), np.arange(cycle.size)),
            CYCLE.name: cycle,
        },
        {"title": "Every accepted step of the run", "Conventions": CONVENTIONS},
    )


def scalar_coordinates(case: Case) -> dict[str, xr.Variable]:
    """Every parameter of a case as a scalar coordinate, float64 or a string, with its units."""
    coordinates = {}
    for name, (value, units, long_name) in case.scalar_coordinates().items():
        attributes = Variable(name, units, long_name).attributes
        if isinstance(value, str):
            attributes.pop("units", None)
            coordinates[name] = xr.Variable((), value, attributes)
        else:
            coordinates[name] = xr.Variable((), np.float64(value), attributes)
    return coordinates


def _coordinate(variable: Variable, values: ArrayLike) -> xr.Variable:
    return _labelled(variable, (variable.name,), np.atleast_1d(np.asarray(values)))


def _labelled(variable: Variable, dims: tuple[str, ...], values: NDArray[Any]) -> xr.Variable:
    return xr.Variable(dims, values.astype(variable.dtype), variable.attributes)


def _raise_all(problems: list[str]) -> None:
    if problems:
        raise ValueError("The dataset would not be whole: " + "; ".join(problems) + ".")


def _coordinate_problems(coords: Mapping[str, xr.Variable], symmetry: str) -> Iterable[str]:
    if symmetry not in SYMMETRIES:
        yield f"symmetry is {symmetry!r}, expected one of {', '.join(SYMMETRIES)}"
    for name, coordinate in coords.items():
        values = coordinate.to_numpy()
        if values.size == 0:
            yield f"{name} is empty"
        elif not (np.isfinite(values).all() and (np.diff(values) > 0).all()):
            yield f"{name} does not increase from value to value"
        elif name == CYCLE.name and values[0] < 0:
            yield f"{name} begins at {values[0]:g}, expected 0 or more"
        elif name != CYCLE.name and symmetry == "even_xy" and values[0] <= 0:
            yield f"{name} begins at {values[0]:g} m, but a quarter has only {name} > 0"


def _name_problems(
    kind: str, expected: Iterable[Variable], given: Mapping[str, Any]
) -> Iterable[str]:
    names = {variable.name for variable in expected}
    if missing := sorted(names - given.keys()):
        yield f"missing {kind} {', '.join(missing)}"
    if unknown := sorted(given.keys() - names):
        yield f"unknown {kind} {', '.join(unknown)}"


def _array_problems(
    expected: Iterable[Variable], arrays: Mapping[str, NDArray[Any]], shape: tuple[int, ...]
) -> Iterable[str]:
    for variable in expected:
        values = arrays.get(variable.name)
        if values is None:
            continue
        if values.shape != shape:
            yield f"{variable.name} has shape {values.shape}, expected {shape}"
        elif isinstance(variable, Field) and variable.flags:
            if not np.isin(values, variable.flags).all():
                meanings = variable.attributes["flag_meanings"]
                yield f"{variable.name} holds other values than {meanings}"
        elif not np.isfinite(values).all():
            yield f"{variable.name} holds values that are not finite"


def mirrored(dataset: xr.Dataset) -> xr.Dataset:
    """Mirror the quarter of a contact that is even in x and y to the whole contact.

    Lazily opened data stay lazy; a dataset of the whole contact is returned as it is.

    Parameters
    ----------
    dataset : xarray.Dataset
        nx × ny cells with x > 0 and y > 0, attribute ``symmetry``.

    Returns
    -------
    xarray.Dataset
        2 nx × 2 ny cells, ``symmetry = "none"``.
    """
    if dataset.attrs["symmetry"] == "none":
        return dataset
    inward_then_outward = {
        name: np.r_[np.arange(dataset.sizes[name])[::-1], np.arange(dataset.sizes[name])]
        for name in (X.name, Y.name)
    }
    positions = {
        name: xr.Variable(
            (name,), np.r_[-dataset[name].values[::-1], dataset[name].values], dataset[name].attrs
        )
        for name in (X.name, Y.name)
    }
    whole = dataset.isel(inward_then_outward).assign_coords(positions)
    whole = whole.assign_attrs(symmetry="none")
    # A derived dataset does not close the file that it reads from.
    whole.set_close(dataset.close)
    return whole


@cache
def source() -> str:
    """Package name and version, with the commit when the package runs from a checkout."""
    version = f"fretwear {fretwear.__version__}"
    commit = _commit(Path(fretwear.__file__).resolve().parents[2])
    return f"{version} (commit {commit})" if commit else version


def history_line(command: str) -> str:
    """One line of the CF ``history`` attribute: time in UTC, then the command."""
    return f"{datetime.now(UTC).isoformat(timespec='seconds')} {command}"


def _commit(root: Path) -> str | None:
    # An installed package may lie inside a checkout of something else (a virtual environment in
    # a user's project), so only a repository with our own sources at its root counts.
    if not (root / ".git").exists() or not (root / "src" / "fretwear").is_dir():
        return None
    try:
        answer = subprocess.run(
            [
                "git",
                "-C",
                str(root),
                "describe",
                "--always",
                "--dirty",
                "--abbrev=12",
                "--exclude=*",
            ],
            capture_output=True,
            text=True,
            timeout=5,
            check=True,
            env={**os.environ, "GIT_OPTIONAL_LOCKS": "0"},
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return answer.stdout.strip() or None


KEY_RESULTS = (
    "contact_half_width_x",
    "stick_half_width_x",
    "central_pressure",
    "peak_pressure",
    "dissipated_energy",
    "wear_volume",
    "plastic_volume",
)
"""Quantities over the cycles that tell two cases apart; the maximum wear depth is added to them."""

_SAME = 1e-12


@dataclass(frozen=True)
class Compared:
    """One result of two cases.

    Attributes
    ----------
    variable : Variable
        The result.
    first, second : float
        Its values in its SI unit.
    """

    variable: Variable
    first: float
    second: float

    @property
    def ratio(self) -> float:
        """Second to first; NaN where the first is zero."""
        return self.second / self.first if self.first else math.nan


def compared_cycles(first: xr.Dataset, second: xr.Dataset) -> tuple[int, int]:
    """Return the cycles at which two cases are compared.

    That is the last snapshot that both have; where they share none but cycle 0, the last one of
    each.
    """
    mine, other = ({int(cycle) for cycle in case["cycle"].values} for case in (first, second))
    common = max(mine & other, default=0)
    return (common, common) if common else (max(mine), max(other))


def different_parameters(first: xr.Dataset, second: xr.Dataset) -> list[str]:
    """Return the parameters of two cases that differ, in the order of the first."""
    names = [
        str(name) for name, value in first.coords.items() if not value.dims and name != "cycle"
    ]
    names += [str(n) for n, v in second.coords.items() if not v.dims and n not in {*names, "cycle"}]
    return [name for name in names if not _agree(first.coords.get(name), second.coords.get(name))]


def compared_results(first: xr.Dataset, second: xr.Dataset) -> list[Compared]:
    """Return the key results of two cases at `compared_cycles`."""
    cycles = compared_cycles(first, second)
    states = [case.sel(cycle=cycle) for case, cycle in zip((first, second), cycles, strict=True)]
    results = []
    for name in KEY_RESULTS:
        values = (float(state[name]) for state in states)
        results.append(Compared(RESULTS[name], *values))
    depths = (float(state["wear_depth"].max()) for state in states)
    return [*results, Compared(MAXIMUM_WEAR_DEPTH, *depths)]


def _agree(first: xr.DataArray | None, second: xr.DataArray | None) -> bool:
    if first is None or second is None:
        return False
    mine, other = first.item(), second.item()
    if isinstance(mine, str) or isinstance(other, str):
        return bool(mine == other)
    return mine == other or math.isclose(mine, other, rel_tol=_SAME)
