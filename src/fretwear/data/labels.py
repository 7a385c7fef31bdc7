"""Labelled arrays, from which datasets are made and case files written.

xarray is slow to import and a run does without it: datasets are made on request.
"""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fretwear.study.doubts import doubts
from fretwear.version import __version__, code_digest
from fretwear.vocabulary import (
    BODY_FIELDS,
    BODY_SCALARS,
    CASE_DIMS,
    CODE_DIGEST,
    CONVOLUTIONS,
    CYCLE,
    ERROR_ESTIMATE,
    FIELDS,
    LINE_DIMS,
    LOOP,
    PHASE,
    SCALARS,
    STEP,
    SYMMETRIES,
    Field,
    Variable,
    X,
    Y,
    of_steps,
    scalars_of,
)

if TYPE_CHECKING:
    import xarray as xr

    from fretwear.study.case import Case

CONVENTIONS = "CF-1.11"

# Fraction of the largest value of a result below which its relative error is meaningless.
_TRACE = 0.01


class Column(NamedTuple):
    """An array, the names of its dimensions, and its attributes."""

    dims: tuple[str, ...]
    values: NDArray[Any]
    attrs: Mapping[str, Any]


@dataclass(frozen=True)
class Labelled:
    """Variables, coordinates and attributes, named as in `xarray.Dataset`."""

    data_vars: Mapping[str, Column]
    coords: Mapping[str, Column]
    attrs: Mapping[str, Any]

    @property
    def variables(self) -> Mapping[str, Column]:
        """All of them."""
        return {**self.data_vars, **self.coords}

    def dataset(self) -> xr.Dataset:
        """The dataset, which shares the arrays."""
        import xarray as xr

        # Registers the accessor of datasets.
        import fretwear.data.dataset  # noqa: F401

        return xr.Dataset(self.data_vars, self.coords, self.attrs)


def labelled_case(
    case: Case,
    x: ArrayLike,
    y: ArrayLike | None,
    cycles: ArrayLike,
    fields: Mapping[str, ArrayLike],
    scalars: Mapping[str, ArrayLike],
    errors: Mapping[str, ArrayLike] | None = None,
    *,
    trouble: str = "",
    symmetry: str = "even_xy",
    title: str = "",
    command: str = "fretwear.simulate",
) -> Labelled:
    """Label the results of one case, along ``cycle``, ``x`` and ``y``.

    The parameters of the `case` become scalar coordinates and the attribute ``parameters``. `x` and
    `y` are cell centres in m, increasing, all positive along axes in which the contact is even by
    `symmetry` and only one side is held; `y` is None in a line contact, whose fields have no y.
    `cycles`, of shape (ncycles,), increase from 0. `fields`, of shape (ncycles, nx, ny), are all of
    `FIELDS` and those of `BODY_FIELDS` that are known; `scalars`, of shape (ncycles,), are all of
    `SCALARS`, for the whole contact, and those of `BODY_SCALARS` that are known; all in SI units.
    `errors` are the estimated errors of scalars by their names, or empty; `trouble` says why they
    are missing although the case asks for them. By default the title names the case id.

    It is a ValueError if variables are missing, unknown, of the wrong shape or not finite, or a
    coordinate does not increase; the message lists all of them.
    """
    coordinates = {
        variable.name: _labelled(variable, (variable.name,), np.atleast_1d(np.asarray(values)))
        for variable, values in ((CYCLE, cycles), (X, x), (Y, y))
        if values is not None
    }
    dims = CASE_DIMS if y is not None else LINE_DIMS
    shape = tuple(coordinates[name].values.size for name in dims)
    problems = _coordinate_problems(coordinates, symmetry)
    known_fields = (*FIELDS, *(each for each in BODY_FIELDS if each.name in fields))
    of_bodies = [each for each in BODY_SCALARS if each.name in scalars]
    known_scalars = (
        *scalars_of(dims),
        *(each if y is not None else each.per_length for each in of_bodies),
    )
    told_errors = {f"{name}_error": values for name, values in (errors or {}).items()}
    known_errors = [each.error for each in known_scalars] if errors else []
    variables = {
        **_variables("field", known_fields, fields, dims, shape, problems),
        **_variables("scalar", known_scalars, scalars, dims[:1], shape[:1], problems),
        **_variables("error", known_errors, told_errors, dims[:1], shape[:1], problems),
    }
    _raise_all(problems)
    for name, (value, units, long_name) in case.scalar_coordinates().items():
        is_text = isinstance(value, str)
        attributes = Variable(name, "" if is_text else units, words=long_name).attributes
        coordinates[name] = Column(
            (), np.asarray(value, None if is_text else np.float64), attributes
        )
    attributes = {
        "title": title or f"Fretting wear of case {case.case_id}",
        "Conventions": CONVENTIONS,
        "source": source(),
        "history": history_line(command),
        "parameters": json.dumps(case.canonical_parameters(), sort_keys=True, allow_nan=False),
        "case_id": case.case_id,
        CODE_DIGEST.name: code_digest(),
        "symmetry": symmetry,
        "warnings": "\n".join(
            map(str, doubts(case, _relative(known_scalars, scalars, errors or {}), trouble))
        ),
    }
    return Labelled(variables, coordinates, attributes)


def _relative(
    known: Iterable[Variable], scalars: Mapping[str, ArrayLike], errors: Mapping[str, ArrayLike]
) -> dict[str, float]:
    """The largest relative error of each scalar, by its words, where it is more than a trace."""
    found = {}
    for each in known:
        if each.name in errors and each.is_headline:
            values, apart = (np.abs(np.asarray(e[each.name])) for e in (scalars, errors))
            counts = values > _TRACE * values.max(initial=0.0)
            found[each.words] = float((apart[counts] / values[counts]).max(initial=0.0))
    return found


def labelled_history(
    cycles: ArrayLike,
    scalars: Mapping[str, ArrayLike],
    error_estimate: ArrayLike,
    convolutions: ArrayLike,
    variables: tuple[Variable, ...] = SCALARS,
) -> Labelled:
    """Label the history of a run along ``step``: scalars at every accepted step, shape (nsteps,).

    The scalars are those of `variables`, except those known `AT_SNAPSHOTS` only, in SI units and
    for the whole contact, at the increasing, possibly fractional cycle of each step; with them come
    the estimated relative error of each step and its convolutions. ValueError as for
    `labelled_case`.
    """
    dims = (STEP.name,)
    cycle = _labelled(CYCLE, dims, np.asarray(cycles))
    given = {
        **scalars,
        ERROR_ESTIMATE.name: error_estimate,
        CONVOLUTIONS.name: convolutions,
    }
    problems = _coordinate_problems({CYCLE.name: cycle}, "none")
    expected = (*of_steps(variables), ERROR_ESTIMATE, CONVOLUTIONS)
    labelled = _variables("scalar", expected, given, dims, cycle.values.shape, problems)
    _raise_all(problems)
    return Labelled(
        labelled,
        {STEP.name: _labelled(STEP, dims, np.arange(cycle.values.size)), CYCLE.name: cycle},
        {"title": "Every accepted step of the run", "Conventions": CONVENTIONS},
    )


def labelled_loops(
    cycles: ArrayLike, loops: Mapping[str, ArrayLike], *, in_line: bool = False
) -> Labelled:
    """Label the loops of force and displacement at the snapshots, shape (ncycles, nphases).

    They hold every variable of `LOOP` in SI units, from +Q over −Q back to +Q, with a ``phase``
    from 0 to 1; forces may be per length.
    """
    dims = (CYCLE.name, PHASE.name)
    problems: list[str] = []
    shape = np.shape(loops[LOOP[0].name])
    known = [each.per_length if in_line else each for each in LOOP]
    variables = _variables("loop", known, loops, dims, shape, problems)
    _raise_all(problems)
    phase = np.linspace(0.0, 1.0, shape[1])
    return Labelled(
        variables,
        {
            CYCLE.name: _labelled(CYCLE, dims[:1], np.asarray(cycles)),
            PHASE.name: _labelled(PHASE, dims[1:], phase),
        },
        {"title": "Force and displacement round a cycle", "Conventions": CONVENTIONS},
    )


def _labelled(variable: Variable, dims: tuple[str, ...], values: NDArray[Any]) -> Column:
    return Column(dims, values.astype(variable.dtype, copy=False), variable.attributes)


def _variables(
    kind: str,
    expected: Iterable[Variable],
    given: Mapping[str, ArrayLike],
    dims: tuple[str, ...],
    shape: tuple[int, ...],
    problems: list[str],
) -> dict[str, Column]:
    """Label the valid arrays, and add the problems of the others to `problems`."""
    by_name = {variable.name: variable for variable in expected}
    if missing := sorted(by_name.keys() - given.keys()):
        problems.append(f"missing {kind} {', '.join(missing)}")
    if unknown := sorted(given.keys() - by_name.keys()):
        problems.append(f"unknown {kind} {', '.join(unknown)}")
    found = {}
    for name, variable in by_name.items():
        if name not in given:
            continue
        values = np.asarray(given[name])
        flags = variable.flags if isinstance(variable, Field) else ()
        if values.shape != shape:
            problems.append(f"{name} has shape {values.shape}, expected {shape}")
        elif flags and not np.isin(values, flags).all():
            meanings = variable.attributes["flag_meanings"]
            problems.append(f"{name} holds other values than {meanings}")
        elif not flags and not np.isfinite(values).all():
            problems.append(f"{name} holds values that are not finite")
        else:
            found[name] = _labelled(variable, dims, values)
    return found


def _coordinate_problems(coordinates: Mapping[str, Column], symmetry: str) -> list[str]:
    problems = []
    one_sided = dict(zip(("x", "y"), SYMMETRIES.get(symmetry, ()), strict=False))
    if symmetry not in SYMMETRIES:
        problems.append(f"symmetry is {symmetry!r}, expected one of {', '.join(SYMMETRIES)}")
    for name, coordinate in coordinates.items():
        values = coordinate.values
        if values.size == 0:
            problems.append(f"{name} is empty")
        elif not (np.isfinite(values).all() and (np.diff(values) > 0).all()):
            problems.append(f"{name} does not increase from value to value")
        elif name == CYCLE.name and values[0] < 0:
            problems.append(f"{name} begins at {values[0]:g}, expected 0 or more")
        elif one_sided.get(name) and values[0] <= 0:
            problems.append(f"{name} begins at {values[0]:g} m, but one side has only {name} > 0")
        elif one_sided.get(name) is False and values[0] >= 0:
            problems.append(f"{name} begins at {values[0]:g} m, but both sides have {name} < 0")
    return problems


def _raise_all(problems: list[str]) -> None:
    if problems:
        raise ValueError("The dataset would not be complete: " + "; ".join(problems) + ".")


@cache
def source() -> str:
    """Package name and version, with the commit when the package runs from a checkout."""
    version = f"fretwear {__version__}"
    commit = _commit(Path(__file__).resolve().parents[3])
    return f"{version} (commit {commit})" if commit else version


def _commit(root: Path) -> str | None:
    # An installed package may lie inside a checkout of something else (a virtual environment in
    # a user's project), so only a repository with our own sources at its root counts.
    if not (root / ".git").exists() or not (root / "src" / "fretwear").is_dir():
        return None
    describe = ["describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"]
    try:
        answer = subprocess.run(
            ["git", "-C", str(root), *describe],
            capture_output=True,
            text=True,
            timeout=5,
            check=True,
            env={**os.environ, "GIT_OPTIONAL_LOCKS": "0"},
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return answer.stdout.strip() or None


def history_line(command: str) -> str:
    """One line of the CF ``history`` attribute: time in UTC, then the command."""
    return f"{datetime.now(UTC).isoformat(timespec='seconds')} {command}"
