"""Datasets of a run: arrays with names, units and attributes."""

from __future__ import annotations

import json
import math
import subprocess
from collections.abc import Iterable, Mapping
from contextlib import suppress
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from fretwear.results import (
    BODY_FIELDS,
    CODE_DIGEST,
    CONTACT_SPOTS,
    CONVOLUTIONS,
    CYCLE,
    ERROR_ESTIMATE,
    FIELDS,
    FRICTION_FIELD,
    LOOP,
    PHASE,
    STEP,
    STICK_SPOTS,
    SYMMETRIES,
    VECTOR_FIELDS,
    WARNINGS,
    X,
    Y,
    of_steps,
    scalars_of,
)
from fretwear.study.case_warnings import CaseWarning, case_warnings
from fretwear.units import ContactFrame
from fretwear.variable import Variable
from fretwear.version import __version__, case_digest

if TYPE_CHECKING:
    from fretwear.study.case import Case

FORMAT: Mapping[str, object] = {"Conventions": "CF-1.11, ACDD-1.3", "format_version": 3}
"""Attributes of every dataset; those without a version call the normal load ``load``, version 2 has
text as coordinates."""

STUDY_ATTRIBUTES = ("creator", "institution", "license", "references")
"""Sections of a study file that become attributes of its datasets, named as in ACDD."""

# Fraction of the largest value of a result below which its relative error is meaningless.
_TRACE = 0.01
_ROOT = Path(__file__).resolve().parents[3]  # of a checkout


def case_dataset(
    case: Case,
    x: ArrayLike,
    y: ArrayLike,
    cycles: ArrayLike,
    fields: Mapping[str, ArrayLike],
    scalars: Mapping[str, ArrayLike],
    errors: Mapping[str, ArrayLike],
    *,
    computed: Case,
    trouble: str,
    unreached: CaseWarning | None,
    beyond_friction: float,
    symmetry: str,
    command: str,
) -> xr.Dataset:
    """Return the results of one case, along ``cycle``, ``x`` and ``y``.

    The parameters of the `case` become scalar coordinates and the attribute ``parameters``. `x` and
    `y` are cell centres in m, increasing, and all positive along axes in which the contact is even
    by `symmetry`; a line contact has no `y`. `cycles`, of shape (ncycles,), increase from 0.
    `fields`, of shape (ncycles, nx, ny), are all of `FIELDS` and the available `BODY_FIELDS`,
    `VECTOR_FIELDS` and `FRICTION_FIELD`; `scalars`, of shape (ncycles,), are all of `SCALARS`, for
    the whole contact, and the available `OPTIONAL_SCALARS`; all in SI units. `errors` are estimated
    errors by the names of the scalars, or empty; `trouble` says why they are missing although the
    case asks for them, and `beyond_friction` is the share of the stick zone in which shear had to
    be cut. A case that asks for an accuracy was `computed` on cells of its own, and may not have
    reached it.

    A KeyError names a variable that is missing, a ValueError one with values that
    `Variable.allows` refuses.
    """
    dims = case.frame.dims
    axes = dict(zip(dims, (cycles, x, y), strict=False))
    coordinates = _variables((CYCLE, X, Y)[: len(dims)], axes)
    may_be = (*BODY_FIELDS, *VECTOR_FIELDS, FRICTION_FIELD)
    optional = (field for field in may_be if field.name in fields)
    of_scalars = scalars_of(case.frame, scalars)
    of_errors = [scalar.error for scalar in of_scalars] if errors else []
    by_name = {f"{name}_error": values for name, values in errors.items()}
    variables = {
        **_variables((*FIELDS, *optional), fields, dims),
        **_variables(of_scalars, scalars, dims[:1]),
        **_variables(of_errors, by_name, dims[:1]),
    }
    for name, (value, units, words) in computed.scalar_coordinates().items():
        values = np.asarray(value, None if isinstance(value, str) else np.float64)
        attributes = Variable(name, units, words=words).attributes
        coordinates[name] = xr.Variable((), values, attributes)
    # Largest relative error of each scalar, over the cycles at which its value is no trace.
    relative = {}
    for scalar in (s for s in of_scalars if s.name in errors and s.is_headline):
        values, apart = (np.abs(np.asarray(table[scalar.name])) for table in (scalars, errors))
        counts = values > _TRACE * np.nan_to_num(values).max(initial=0.0)
        relative[scalar.words] = float((apart[counts] / values[counts]).max(initial=0.0))
    of_run = trouble, beyond_friction, unreached, _thinned(computed, fields)
    measured = math.isfinite(case.accuracy)
    reasons = case_warnings(computed, relative, *of_run, measured=measured)
    attributes = {
        "title": f"Fretting wear of case {case.case_id}",
        **FORMAT,
        "source": source(),
        "history": history_line(command),
        "parameters": json.dumps(case.canonical_parameters(), sort_keys=True, allow_nan=False),
        "case_id": case.case_id,
        CODE_DIGEST.name: case_digest(case),
        "symmetry": symmetry,
        WARNINGS.name: "\n".join(map(str, reasons)),
        "complete": 1,
    }
    return xr.Dataset(variables, coordinates, attributes)


def _thinned(case: Case, fields: Mapping[str, ArrayLike]) -> float:
    """Largest mean wear depth of the flat under the contact over the thickness of its coating."""
    if case.coating is None:
        return 0.0
    worn = np.asarray(fields.get("wear_depth_flat", fields["wear_depth"]), np.float64)
    touched = np.asarray(fields["contact_fraction"], np.float64)
    within = tuple(range(1, worn.ndim))
    area = np.maximum(touched.sum(axis=within), np.finfo(np.float64).tiny)
    mean = (worn * touched).sum(axis=within) / area
    return float(mean.max()) / case.coating.thickness


def history_dataset(steps: Mapping[str, ArrayLike], frame: ContactFrame) -> xr.Dataset:
    """Return the history of a run along ``step``: arrays of shape (nsteps,) by name, SI units.

    These are the increasing, possibly fractional ``cycle``, the scalars of every step of a frame,
    the available optional ones, for the whole contact, the ``error_estimate`` of each step, its
    ``convolutions``, and the spots that joined the contact and the stick zone or left them. Raises
    the errors of `case_dataset`.
    """
    arrays = {"step": np.arange(np.size(steps["cycle"])), **steps}
    of_step = ERROR_ESTIMATE, CONVOLUTIONS, CONTACT_SPOTS, STICK_SPOTS
    expected = (*of_steps(scalars_of(frame, steps)), *of_step)
    return xr.Dataset(
        _variables(expected, arrays, (STEP.name,)),
        _variables((STEP, CYCLE), arrays, (STEP.name,)),
        {"title": "Every accepted step of the run", **FORMAT},
    )


def loops_dataset(
    cycles: ArrayLike, loops: Mapping[str, ArrayLike], frame: ContactFrame
) -> xr.Dataset:
    """Return the loops of force and displacement at the snapshots, shape (ncycles, nphases).

    A loop has every variable of `LOOP` in SI units, from +Q over −Q back to +Q, along a ``phase``
    from 0 to 1. Forces of a line contact are per length.
    """
    variables = [variable.in_frame(frame) for variable in LOOP]
    axes = {"cycle": cycles, "phase": np.linspace(0.0, 1.0, np.shape(loops[LOOP[0].name])[1])}
    return xr.Dataset(
        _variables(variables, loops, (*axes,)),
        _variables((CYCLE, PHASE), axes),
        {"title": "Force and displacement round a cycle", **FORMAT},
    )


def _variables(
    expected: Iterable[Variable], arrays: Mapping[str, ArrayLike], dims: tuple[str, ...] = ()
) -> dict[str, xr.Variable]:
    """Return arrays as variables; without dimensions, each has the dimension of its own name."""
    variables = {}
    for variable in expected:
        values = np.asarray(arrays[variable.name])
        if not variable.allows(values):
            raise ValueError(f"{variable.name} holds values that are not finite")
        own_dims = dims or (variable.name,)
        kept = values.astype(variable.dtype, copy=False)
        variables[variable.name] = xr.Variable(own_dims, kept, variable.attributes)
    return variables


@cache
def source() -> str:
    """Package name and version, with the commit when the package runs from a checkout."""
    version = f"fretwear {__version__}"
    if (_ROOT / ".git").exists():
        with suppress(OSError, subprocess.SubprocessError):
            describe = ["describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"]
            found = subprocess.run(
                ["git", "-C", str(_ROOT), *describe], capture_output=True, check=True, text=True
            )
            return f"{version} (commit {found.stdout.strip()})"
    return version


def history_line(command: str) -> str:
    """One line of the CF ``history`` attribute: time in UTC, then the command."""
    return f"{datetime.now(UTC).isoformat(timespec='seconds')} {command}"


def attributes_from(case: xr.Dataset, title: str, command: str) -> dict[str, object]:
    """Attributes of a dataset that a command has computed from the dataset of a case."""
    names = ("parameters", "case_id", *STUDY_ATTRIBUTES)
    return {
        "title": f"{title} of case {case.attrs['case_id']}",
        **FORMAT,
        "source": source(),
        "history": history_line(command),
        **{name: case.attrs[name] for name in names if name in case.attrs},
    }


def study_attributes(content: Mapping[str, object]) -> dict[str, str]:
    """`STUDY_ATTRIBUTES` that the content of a study file has."""
    return {name: str(content[name]) for name in STUDY_ATTRIBUTES if content.get(name)}


def mirrored(dataset: xr.Dataset) -> xr.Dataset:
    """Complete a contact by mirroring it along the axes in which its ``symmetry`` is even.

    Lazily opened data stay lazy; a dataset of the whole contact is returned unchanged.
    """
    even = SYMMETRIES[dataset.attrs["symmetry"]]
    if not any(even):
        return dataset
    order, positions = {}, {}
    for name in (axis.name for axis, is_even in zip((X, Y), even, strict=True) if is_even):
        cells = np.arange(dataset.sizes[name])
        order[name] = np.r_[cells[::-1], cells]
        values = np.r_[-dataset[name].values[::-1], dataset[name].values]
        positions[name] = xr.Variable((name,), values, dataset[name].attrs)
    whole = dataset.isel(order).assign_coords(positions).assign_attrs(symmetry="none")
    for field in VECTOR_FIELDS:
        if field.is_odd and field.name in whole:
            values = whole[field.name]
            for name in positions:
                values = values * np.sign(whole[name]).astype(values.dtype)
            whole[field.name] = values.transpose(*whole[field.name].dims)
            whole[field.name].attrs = dataset[field.name].attrs
    # Closing a derived dataset would not close its file.
    whole.set_close(dataset.close)
    return whole
