"""Labelled datasets from plain arrays: the one place that knows how a case file is laid out."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from fretwear.data import provenance
from fretwear.data.variables import (
    CONVOLUTIONS,
    CYCLE,
    DOMAIN_DIMS,
    ERROR_ESTIMATE,
    FIELDS,
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
        Every variable of `fretwear.data.variables.FIELDS`, SI units.
    scalars : mapping of str to array_like, shape (ncycles,)
        Every variable of `fretwear.data.variables.SCALARS`, SI units, for the whole contact.
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
    field_shape = tuple(sizes[dim] for dim in DOMAIN_DIMS)
    _raise_all(
        [
            *_coordinate_problems(coords, symmetry),
            *_name_problems("field", FIELDS, fields),
            *_name_problems("scalar", SCALARS, scalars),
            *_array_problems(FIELDS, arrays, field_shape),
            *_array_problems(SCALARS, arrays, field_shape[:1]),
        ]
    )
    variables = {field.name: _labelled(field, DOMAIN_DIMS, arrays[field.name]) for field in FIELDS}
    variables |= {
        scalar.name: _labelled(scalar, DOMAIN_DIMS[:1], arrays[scalar.name]) for scalar in SCALARS
    }
    attributes = {
        "title": title or f"Fretting wear of case {case.case_id}",
        "Conventions": CONVENTIONS,
        "source": provenance.source(),
        "history": provenance.history_line(command),
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
        Every variable of `fretwear.data.variables.SCALARS`, SI units, for the whole contact.
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
