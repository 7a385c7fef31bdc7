"""What must hold in an open file before its arrays are read.

Its variables are all there, no larger than the file can hold, numbers or plain text; coordinates
increase, and parameters lie in their range. The first problem is raised and ends the reading, as
each check relies on those before it.
"""

from __future__ import annotations

import json
import math
from collections.abc import Hashable, Iterable, Iterator, Mapping
from contextlib import suppress

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
    contact_frame,
    of_steps,
    scalars_of,
)

HISTORY_GROUP = "history"
COMPLETE = "complete"
"""Attribute of case files of finished runs."""

_OF_STEPS = (ERROR_ESTIMATE, CONVOLUTIONS, STEP, CYCLE)

# Fields usually compress to a half, and to a tenth if the bodies hardly touch.
_MOST_EXPANSION = 100
_ALWAYS_ALLOWED = 10_000_000
_MOST_TEXT = 10_000_000
# Attributes by which a library changes the stored numbers.
_CHANGING = {"scale_factor", "add_offset", "_Unsigned", "missing_value", "dtype", "valid_range"}
_CASE_TEXTS = ("title", "source", "case_id", "parameters", "symmetry")
_STUDY_TEXTS = ("title", "source", "study", "design", "study_file")
_OPTIONAL_TEXTS = ("warnings", "history", CODE_DIGEST.name)


def lacking_variables(dims: Mapping[Hashable, tuple[Hashable, ...]]) -> list[str]:
    """Return the variables of a case that are missing or have wrong dimensions."""
    frame = contact_frame(dims)
    of_case = frame.dims
    expected = {
        **{name: (name,) for name in of_case},
        **{scalar.name: of_case[:1] for scalar in scalars_of(frame)},
        **{field.name: of_case for field in FIELDS},
    }
    return [name for name, right in expected.items() if dims.get(name) != right]


def case_problems(file: netCDF4.Dataset, size: int, *, by_us: bool, values: bool) -> Iterator[str]:
    """Yield the problems of a case file of some bytes, first of its structure, then of its values.

    A file need not be written `by_us`: xarray stores no history, and its text is not plain.
    """
    if by_us and str(file.__dict__.get(COMPLETE)) != "1":
        yield "the run that wrote it did not finish"
    lacking = lacking_variables(
        {name: variable.dimensions for name, variable in file.variables.items()}
    )
    if HISTORY_GROUP in file.groups:
        # Files saved by xarray have no history.
        steps = (*of_steps(scalars_of(contact_frame(file.variables))), *_OF_STEPS)
        history = file[HISTORY_GROUP].variables
        lacking += [f"{HISTORY_GROUP}/{of.name}" for of in steps if of.name not in history]
    elif by_us:
        lacking.append(HISTORY_GROUP)
    if lacking:
        yield f"it lacks {', '.join(lacking)}"
    yield from size_problems((file, *file.groups.values()), size, words=not by_us)
    yield from _text_problems(file, _CASE_TEXTS)
    if file.getncattr("symmetry") not in SYMMETRIES:
        yield f"its symmetry is none of {', '.join(SYMMETRIES)}"
    for axis in (CYCLE, X, Y):
        if axis.name in file.variables:
            yield from _axis_problems(file[axis.name], axis)
    if values:
        scalars = scalars_of(contact_frame(file.variables))
        errors = (scalar.error for scalar in scalars if scalar.error.name in file.variables)
        yield from _variable_problems(file, FIELDS, file[FIELDS[0].name].dimensions, finite=False)
        yield from _variable_problems(file, (*scalars, *errors), (CYCLE.name,))
        if HISTORY_GROUP in file.groups:
            steps = (*of_steps(scalars), *_OF_STEPS)
            yield from _variable_problems(file[HISTORY_GROUP], steps, (STEP.name,))
        yield from _parameter_problems(file)


def summary_problems(file: netCDF4.Dataset) -> Iterator[str]:
    """Yield the problems of a merged study."""
    yield from _text_problems(file, _STUDY_TEXTS)
    required = {CYCLE.name, X.name, STATUS.name, CASE_ID.name, "contact_state_profile"}
    if lacking := required - file.variables.keys():
        yield f"it lacks {', '.join(sorted(lacking))}"
    dims = (*file[STATUS.name].dimensions, CYCLE.name)
    yield from _variable_problems(
        file, scalars_of(contact_frame(file.variables)), dims, finite=False
    )
    for axis in (CYCLE, X):
        yield from _axis_problems(file[axis.name], axis)
    if not np.isin(file[STATUS.name][...], list(PointStatus)).all():
        yield "its status has unknown values"
    yield from _parameter_problems(file)


def size_problems(
    groups: Iterable[netCDF4.Dataset], size: int, *, words: bool = False
) -> Iterator[str]:
    """Yield the problems of variables of a file of `size` bytes, as announced before they are read.

    With `words`, text of variable length is allowed.
    """
    announced = 0
    for name, variable in ((n, v) for group in groups for n, v in group.variables.items()):
        if words and variable.dtype is str and not variable.dimensions:
            continue  # text as xarray saves it
        if not isinstance(variable.dtype, np.dtype) or variable.dtype.kind not in "ifuS":
            yield f"{name} holds neither numbers nor plain text"
        announced += math.prod(variable.shape) * variable.dtype.itemsize
        if changing := _CHANGING & set(variable.ncattrs()):
            yield f"{name} has the attribute {min(changing)}, which changes its meaning"
    if announced > _ALWAYS_ALLOWED and announced > _MOST_EXPANSION * size:
        yield f"it announces {announced / 1e6:.0f} MB of values but has {size / 1e6:.1f} MB"


def _text_problems(file: netCDF4.Dataset, names: Iterable[str]) -> Iterator[str]:
    attributes = file.__dict__  # `vars` would hide an error of the library
    for name in (*names, *(optional for optional in _OPTIONAL_TEXTS if optional in attributes)):
        text = attributes.get(name)
        if not isinstance(text, str) or len(text) > _MOST_TEXT:
            yield f"its attribute {name} is not text"
        elif name in ("parameters", "study_file"):
            content = None
            with suppress(ValueError, RecursionError):
                content = json.loads(text)
            if not isinstance(content, dict):
                yield f"its attribute {name} is not a JSON object"


def _axis_problems(stored: netCDF4.Variable[np.float64], axis: Variable) -> Iterator[str]:
    if stored.dimensions != (axis.name,) or stored.dtype.kind != "f" or not stored.size:
        yield f"{axis.name} is not an axis"
    values = stored[...]
    if not (np.isfinite(values).all() and (np.diff(values) > 0).all()):
        yield f"{axis.name} does not increase from value to value"
    if axis is CYCLE and values[0] < 0:
        yield f"{axis.name} begins before 0"


def _variable_problems(
    group: netCDF4.Dataset,
    expected: Iterable[Variable],
    dims: tuple[str, ...],
    *,
    finite: bool = True,
) -> Iterator[str]:
    for variable in expected:
        name, stored = variable.name, group.variables.get(variable.name)
        if stored is None or stored.dimensions != dims or stored.dtype.kind not in "if":
            yield f"it lacks {group.name}/{name}".replace("//", "")
            continue
        unit = stored.__dict__.get("units", "")
        if unit != variable.si_unit:
            yield f"{name} is in {unit or 'no unit'}, not in {variable.si_unit or 'any'}"
        if finite and not variable.allows(stored[...]):
            yield f"{name} holds values that are not finite"


def _parameter_problems(file: netCDF4.Dataset) -> Iterator[str]:
    """Check the parameters, which are scalars or have a value for each point."""
    for name, variable in file.variables.items():
        if getattr(variable.dtype, "kind", "") != "f" or CYCLE.name in variable.dimensions:
            continue
        for value in np.unique(variable[...]).tolist():
            is_missing = math.isnan(value) and variable.dimensions
            if not is_missing and not parameter(name).allows(value):
                yield f"{name} is {value:g}, which is out of its range"
