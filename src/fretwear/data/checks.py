"""Checks of a results file before its contents are trusted.

A checksum reveals damage, but not who wrote the file. So an intact file is checked before its
arrays are read: that they are no larger than the file can hold, that numbers are numbers,
coordinates increase, states are known, and parameters lie in their range.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from typing import Any

import netCDF4
import numpy as np

from fretwear.study.parameters import parameter
from fretwear.vocabulary import (
    CASE_ID,
    CODE_DIGEST,
    CONVOLUTIONS,
    CYCLE,
    ERROR_ESTIMATE,
    FIELDS,
    STATUS,
    STEP,
    SYMMETRIES,
    PointStatus,
    Variable,
    X,
    Y,
    of_steps,
    scalars_of,
)

# Fields compress to a half as a rule, and to a tenth where the bodies hardly touch.
_MOST_EXPANSION = 100
_ALWAYS_ALLOWED = 10_000_000
_MOST_TEXT = 10_000_000
# Attributes by which a library changes the stored numbers.
_CHANGING = {"scale_factor", "add_offset", "_Unsigned", "missing_value", "dtype", "valid_range"}

_CASE_TEXTS = ("title", "source", "case_id", "parameters", "symmetry")
_OPTIONAL_TEXTS = ("warnings", "history", CODE_DIGEST.name)
_STUDY_TEXTS = ("title", "source", "study", "design", "study_file")


def case_problem(file: netCDF4.Dataset, size: int, *, own: bool = True) -> str:
    """Return what is wrong with a case file before its arrays are read; empty if nothing.

    Its variables must have the dimensions of a case and fit its size in bytes. Files that are not
    our `own` may hold text as xarray saves it.
    """
    groups = (file, *file.groups.values())
    problem = _size_problem(groups, size, words=not own) or _text_problem(file, _CASE_TEXTS)
    if not problem and file.getncattr("symmetry") not in SYMMETRIES:
        problem = f"its symmetry is none of {', '.join(SYMMETRIES)}"
    axes = (axis for axis in (CYCLE, X, Y) if axis.name in file.variables)
    return problem or next(filter(None, (_axis_problem(file, axis) for axis in axes)), "")


def value_problem(file: netCDF4.Dataset) -> str:
    """Return which number of a case file no run could have left; empty if there is none.

    Fields are not read: they are used as they are.
    """
    # Files saved by xarray have no history.
    history = file.groups.get("history")
    scalars = scalars_of(file.variables)
    errors = (each.error for each in scalars if each.error.name in file.variables)
    steps = (*of_steps(scalars), ERROR_ESTIMATE, CONVOLUTIONS, STEP, CYCLE)
    problems = (
        *(_unit_problem(file[each.name], each) for each in FIELDS if each.name in file.variables),
        *(_scalar_problem(file, each, CYCLE.name) for each in (*scalars, *errors)),
        *(_scalar_problem(history, each, STEP.name) for each in steps if history is not None),
        *_parameter_problems(file),
    )
    return next(filter(None, problems), "")


def summary_problem(file: netCDF4.Dataset, size: int) -> str:
    """Return what is wrong with a merged study before its arrays are read; empty if nothing."""
    if problem := _size_problem((file,), size) or _text_problem(file, _STUDY_TEXTS):
        return problem
    required = {CYCLE.name, X.name, STATUS.name, CASE_ID.name, "contact_state_profile"}
    lacking = required - file.variables.keys()
    if lacking:
        return f"it lacks {', '.join(sorted(lacking))}"
    points = file[STATUS.name].dimensions
    for scalar in scalars_of(file.variables):
        known = file.variables.get(scalar.name)
        if known is None or known.dimensions != (*points, CYCLE.name) or known.dtype.kind != "f":
            return f"it lacks {scalar.name}"
        if problem := _unit_problem(known, scalar):
            return problem
    if problem := _axis_problem(file, CYCLE) or _axis_problem(file, X):
        return problem
    if not np.isin(file[STATUS.name][...], list(PointStatus)).all():
        return "its status has unknown values"
    return next(filter(None, _parameter_problems(file)), "")


def _size_problem(groups: tuple[Any, ...], size: int, *, words: bool = False) -> str:
    announced = 0
    for group in groups:
        for name, variable in group.variables.items():
            if words and variable.dtype is str and not variable.dimensions:
                continue  # as xarray saves it
            if not isinstance(variable.dtype, np.dtype) or variable.dtype.kind not in "ifuS":
                return f"{name} holds neither numbers nor plain text"
            announced += math.prod(variable.shape) * variable.dtype.itemsize
            if changing := _CHANGING & set(variable.ncattrs()):
                return f"{name} has the attribute {min(changing)}, which changes its meaning"
    if announced > _ALWAYS_ALLOWED and announced > _MOST_EXPANSION * size:
        return f"it announces {announced / 1e6:.0f} MB of values but has {size / 1e6:.1f} MB"
    return ""


def _text_problem(file: netCDF4.Dataset, names: tuple[str, ...]) -> str:
    optional = (name for name in _OPTIONAL_TEXTS if name in file.ncattrs())
    for name in (*names, *optional):
        text = file.getncattr(name) if name in file.ncattrs() else None
        if not isinstance(text, str) or len(text) > _MOST_TEXT:
            return f"its attribute {name} is not text"
        if name in ("parameters", "study_file"):
            try:
                content = json.loads(text)
            except (ValueError, RecursionError):
                content = None
            if not isinstance(content, dict):
                return f"its attribute {name} is not a JSON object"
    return ""


def _axis_problem(file: netCDF4.Dataset, axis: Variable) -> str:
    known = file[axis.name]
    if known.dimensions != (axis.name,) or known.dtype.kind != "f" or not known.size:
        return f"{axis.name} is not an axis"
    values = known[...]
    if not (np.isfinite(values).all() and (np.diff(values) > 0).all()):
        return f"{axis.name} does not increase from value to value"
    if axis is CYCLE and values[0] < 0:
        return f"{axis.name} begins before 0"
    return ""


def _scalar_problem(group: Any, scalar: Variable, along: str) -> str:
    known = group.variables.get(scalar.name)
    if known is None or known.dimensions != (along,) or known.dtype.kind not in "if":
        return f"it lacks {group.name}/{scalar.name}".replace("//", "")
    if problem := _unit_problem(known, scalar):
        return problem
    is_finite = np.isfinite(known[...]).all()
    return "" if is_finite else f"{scalar.name} holds values that are not finite"


def _unit_problem(known: Any, variable: Variable) -> str:
    unit = known.getncattr("units") if "units" in known.ncattrs() else ""
    if unit == variable.si_unit:
        return ""
    return f"{variable.name} is in {unit or 'no unit'}, not in {variable.si_unit or 'any'}"


def _parameter_problems(file: netCDF4.Dataset) -> Iterator[str]:
    """Check the parameters, which are scalars or have a value for each point."""
    points: Mapping[str, Any] = {
        name: variable
        for name, variable in file.variables.items()
        if getattr(variable.dtype, "kind", "") == "f" and CYCLE.name not in variable.dimensions
    }
    for name, variable in points.items():
        about = parameter(name)
        for value in np.unique(variable[...]).tolist():
            if math.isnan(value) and variable.dimensions:
                continue
            if not about.allows(value):
                yield f"{name} is {value:g}, which is out of its range"
