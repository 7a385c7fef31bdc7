"""A study as one dataset: its case files merged into one, with the status of its points."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import netCDF4
import numpy as np
import xarray as xr
from numpy.typing import NDArray

from fretwear.arrays import Array
from fretwear.data.atomic import DataFileError
from fretwear.data.files import (
    HISTORY_GROUP,
    MERGED_HISTORIES,
    MERGED_PROFILES,
    check_case,
    opened_case,
    write_groups,
)
from fretwear.data.labels import FORMAT, history_line, study_attributes
from fretwear.data.stack import NOT_DONE, common_positions, empty_value, resampled
from fretwear.results import (
    CASE_ID,
    CODE_DIGEST,
    CYCLE,
    POINT,
    STATUS,
    STEP,
    PointStatus,
    Variable,
    X,
    Y,
)
from fretwear.version import case_digest, code_digest

if TYPE_CHECKING:
    from fretwear.study.case import Case
    from fretwear.study.designs import Axis
    from fretwear.study.study import Study

_MOST_SOURCES = 10
_RUN_AGAIN = "Remove the file and run the case again"


class Tally(NamedTuple):
    """Numbers of done, failed and invalid points of a study."""

    done: int
    failed: int
    invalid: int


class _Row(NamedTuple):
    """What the merged study takes from one case."""

    cycles: Array  # of its snapshots
    x: Array
    results: dict[str, NDArray[Any]]  # scalars, shape (ncycles,), and profiles (ncycles, nx)
    history: dict[str, Array]  # shape (nsteps,)
    digest: str
    source: str


def merge_study(
    study: Study,
    cases: str | PathLike[str],
    path: str | PathLike[str],
    *,
    command: str = "fretwear.merge_study",
    keep_older: bool = False,
    tell: Callable[[str], None] = lambda _: None,
) -> Tally:
    """Merge the case files ``<case id>.nc`` in the folder `cases` into one file.

    The file has the varied names as dimensions, in the order of the study, or the one dimension
    ``point`` if the design is not a grid; then ``cycle`` and ``x``. It holds every scalar
    (…, cycle) of the cases, the profiles (…, cycle, x) of `MERGED_PROFILES`, and the ``status`` of
    every point, which has failed if its case file is missing. Values are NaN where a point is not
    done or has no snapshot at a cycle. The group ``history`` holds the cycle, the `HEADLINES` and
    the tangential force at every accepted step (…, step), NaN after the last; the attribute
    ``history`` holds the `command`.

    Sections that packages beside the core have read add their results; `tell` takes remarks.

    Raises a `DataFileError`, and writes nothing, if no case is done, if the file cannot be written,
    or if case files are damaged, belong to other cases or, unless `keep_older`, to other code; it
    then names them all.
    """
    points = [(point.id, point.case) for point in study.points()]
    rows, errors = dict[int, _Row](), list[DataFileError]()
    about = dict[str, dict[str, Any]]()
    status = np.full(len(points), PointStatus.INVALID, STATUS.dtype)
    for number, (case_id, case) in enumerate(points):
        if case is None:
            continue
        file = Path(cases) / f"{case_id}.nc"
        status[number] = PointStatus.DONE if file.exists() else PointStatus.FAILED
        if file.exists():
            try:
                row = _read_case(file, case, keep_older, about)
                for section in study.added.values():
                    for each, values in section.extra_results(file, row.cycles, tell).items():
                        row.results[each.name] = np.asarray(values)
                        about[each.name] = each.attributes
                rows[number] = row
            except DataFileError as error:
                errors.append(error)
    if errors:
        first, *others = errors
        raise DataFileError(first.path, first.problem, "\n".join(map(str, (first.remedy, *others))))
    if not rows:
        problem = f"not written, because no case of the study is done in {cases}"
        remedy = "Run the study; if it was run, its log says why every case failed"
        raise DataFileError(Path(path), problem, remedy)
    summary, histories = _side_by_side(study, rows, about)
    flags = {
        "long_name": STATUS.words,
        "flag_values": np.array(list(PointStatus), STATUS.dtype),
        "flag_meanings": " ".join(kind.word for kind in PointStatus),
    }
    digests = [rows[n].digest if n in rows else "" for n in range(len(points))]
    coordinates, parameters = _columns(study, points)
    summary = summary.assign(
        {
            STATUS.name: _laid(study, status, flags),
            CODE_DIGEST.name: _laid(study, digests, CODE_DIGEST.attributes),
            **parameters,
        }
    ).assign_coords(coordinates)
    remarks = _remarks_on((row.digest, points[number][1]) for number, row in rows.items())
    summary.attrs = {
        "title": study.title,
        **FORMAT,
        "source": "; ".join(sorted({row.source for row in rows.values()})[:_MOST_SOURCES]),
        "history": history_line(command),
        CODE_DIGEST.name: code_digest(),
        "warnings": "\n".join(remarks),
        "study": study.name,
        "design": study.design.kind,
        "study_file": json.dumps(study.content, default=str),
        **study_attributes(study.content),
    }
    write_groups(path, {"": summary, HISTORY_GROUP: histories})
    for remark in remarks:
        tell(remark)
    count = Counter(status.tolist())
    return Tally(*(count[kind] for kind in PointStatus))


def _read_case(path: Path, case: Case, keep_older: bool, about: dict[str, dict[str, Any]]) -> _Row:
    """Read a case at its snapshots; `DataFileError` if it cannot be used.

    The attributes of variables that are read for the first time are added to `about`. The netCDF
    library takes a tenth of the time that xarray takes to open a small file.
    """
    asked = np.array(case.output_cycles, np.float64)
    with opened_case(path) as file:
        check_case(path, vars(file), file.variables)
        if (other := file.getncattr(CASE_ID.name)) != case.case_id:
            raise DataFileError(path, f"it holds another case, {other}", _RUN_AGAIN)
        cycles = file[CYCLE.name][:]
        if lacking := sorted({*asked} - {*cycles}):
            numbers = ", ".join(f"{cycle:.0f}" for cycle in lacking)
            raise DataFileError(path, f"it has no snapshot at cycle {numbers}", _RUN_AGAIN)
        digest = getattr(file, CODE_DIGEST.name, "")
        if digest != case_digest(case) and not keep_older:
            problem = "it was computed by another version of the code (its code_digest differs)"
            raise DataFileError(path, problem, "Run the case again, or keep it with --keep-older")
        at = np.searchsorted(cycles, asked)
        results = {}
        for name, variable in file.variables.items():
            if variable.dimensions == (CYCLE.name,) and name != CYCLE.name:
                results[name] = variable[:][at]
                if name not in about:
                    about[name] = _attributes(variable)
        middle = [int(np.abs(file[Y.name][:]).argmin())] if Y.name in file.variables else []
        for name, field in MERGED_PROFILES.items():
            if field.name in file.variables:
                results[name] = file[field.name][(at, slice(None), *middle)]
        group = file.groups[HISTORY_GROUP].variables
        history = {name: group[name][:] for name in MERGED_HISTORIES if name in group}
        for name in history.keys() - about.keys():
            about[name] = _attributes(group[name])
        return _Row(asked, file[X.name][:], results, history, digest, getattr(file, "source", ""))


def _attributes(variable: netCDF4.Variable[Any]) -> dict[str, Any]:
    """The attributes but those by which xarray encodes a variable."""
    names = [name for name in variable.ncattrs() if name not in ("coordinates", "_FillValue")]
    return {name: variable.getncattr(name) for name in names}


def _side_by_side(
    study: Study, rows: Mapping[int, _Row], about: Mapping[str, Mapping[str, Any]]
) -> tuple[xr.Dataset, xr.Dataset]:
    """Results and histories of points, by number, along the axes of a study; NaN where missing."""
    cycles = np.unique(np.concatenate([row.cycles for row in rows.values()]))
    x, dims = common_positions([row.x for row in rows.values()]), tuple(study.sizes)
    steps = np.arange(max(row.history[CYCLE.name].size for row in rows.values()))
    results, histories = dict[str, NDArray[Any]](), dict[str, NDArray[Any]]()
    for number, row in rows.items():
        at = np.searchsorted(cycles, row.cycles)
        for name, values in row.results.items():
            profile = MERGED_PROFILES.get(name)
            if name not in results:
                shape = math.prod(study.shape), cycles.size, *([x.size] if profile else [])
                empty = empty_value(profile) if profile else math.nan
                results[name] = np.full(shape, empty, profile.dtype if profile else np.float64)
            if profile:
                values = resampled(values, [row.x], [x], profile.outside)
            results[name][number, at] = values
        for name, values in row.history.items():
            if name not in histories:
                histories[name] = np.full((math.prod(study.shape), steps.size), math.nan)
            histories[name][number, : values.size] = values
    variables = {
        name: xr.Variable(
            (*dims, CYCLE.name, X.name)[: len(dims) + values.ndim - 1],
            values.reshape(*study.shape, *values.shape[1:]),
            _profile_attributes(MERGED_PROFILES[name]) if name in MERGED_PROFILES else about[name],
        )
        for name, values in results.items()
    }
    if "contact_state_profile" in variables:
        variables["contact_state_profile"].encoding["_FillValue"] = np.int8(NOT_DONE)
    of_steps = {
        name: ((*dims, STEP.name), values.reshape(*study.shape, steps.size), about[name])
        for name, values in histories.items()
    }
    axes = {
        CYCLE.name: (CYCLE.name, cycles, CYCLE.attributes),
        X.name: (X.name, x, X.attributes),
    }
    step = {STEP.name: (STEP.name, steps.astype(STEP.dtype), STEP.attributes)}
    return xr.Dataset(variables, axes), xr.Dataset(of_steps, step)


def _profile_attributes(field: Variable) -> dict[str, Any]:
    """The attributes of a field along x at the positions that all cases share."""
    outside = "zero outside the window of the case, where the surfaces do not touch"
    comments = (
        field.comment,
        "on the line of cells nearest y = 0",
        "of the nearest cell" if field.flags else "interpolated linearly between the cells",
        "NaN outside the window of the case" if math.isnan(field.outside) else outside,
    )
    return {**field.attributes, "comment": "; ".join(filter(None, comments))}


def _columns(
    study: Study, points: Sequence[tuple[str, Case | None]]
) -> tuple[dict[str, xr.Variable], dict[str, xr.Variable]]:
    """Coordinates (varied values, case ids, shared parameters), and parameters of single points.

    Varied values that are not single numbers (a roughness, a pair of moduli) are text, as written
    in the study file; a parameter that a point lacks is NaN or empty text.
    """
    given, about = dict[str, list[float | str]](), dict[str, Mapping[str, object]]()
    for number, (_, case) in enumerate(points):
        for name, (value, units, words) in (case.scalar_coordinates() if case else {}).items():
            about.setdefault(name, Variable(name, units, words=words).attributes)
            number_or_text = value if isinstance(value, str) else float(value)
            empty = "" if isinstance(value, str) else math.nan
            given.setdefault(name, [empty] * len(points))[number] = number_or_text
    coordinates, parameters = dict[str, xr.Variable](), dict[str, xr.Variable]()
    for axis in study.axes:
        coordinates[axis.coordinate] = _varied(study, axis, about.get(axis.coordinate))
    done = [number for number, (_, case) in enumerate(points) if case is not None]
    for name, values in given.items():
        if name in coordinates:
            continue
        if len({values[number] for number in done}) == 1:
            coordinates[name] = xr.Variable((), values[done[0]], about[name])
        else:
            parameters[name] = _laid(study, values, about[name])
    if POINT.name in study.sizes:
        numbers = np.arange(study.size, dtype=POINT.dtype)
        coordinates[POINT.name] = xr.Variable((POINT.name,), numbers, POINT.attributes)
    ids = [case_id for case_id, _ in points]
    coordinates[CASE_ID.name] = _laid(study, ids, CASE_ID.attributes)
    return coordinates, parameters


def _laid(study: Study, values: object, about: Mapping[str, object]) -> xr.Variable:
    """One value for each point, along the axes of a study."""
    return xr.Variable(tuple(study.sizes), np.reshape(np.asarray(values), study.shape), about)


def _varied(study: Study, axis: Axis, about: Mapping[str, object] | None) -> xr.Variable:
    attributes: dict[str, object] = {"long_name": axis.name, **(about or {})}
    values = np.array(axis.labels, dtype=str)
    if all(isinstance(value, int | float) for value in axis.values):
        values = np.array(axis.values, dtype=np.float64)
    elif all(isinstance(value, str) for value in axis.values):
        values = np.array(axis.values, dtype=str)
    else:
        attributes.pop("units", None)
    if axis.drawn_from is not None:
        attributes |= {
            "drawn_from": axis.drawn_from.low,
            "drawn_to": axis.drawn_from.high,
            "drawn_on": "log" if axis.drawn_from.logarithmic else "linear",
        }
    dim = POINT.name if POINT.name in study.sizes else axis.coordinate
    return xr.Variable((dim,), values, attributes)


def _remarks_on(done: Iterable[tuple[str, Case | None]]) -> list[str]:
    """Return a remark if cases that are done, given with their digests, are of other code."""
    pairs = [(digest, case_digest(case)) for digest, case in done if case is not None]
    older = [digest or "missing" for digest, now in pairs if digest != now]
    were = f"case{'s' * (len(pairs) > 1)} {'was' if len(older) == 1 else 'were'}"
    remark = (
        f"{len(older)} of {len(pairs)} {were} computed by another version of the code: "
        f"their code_digest is {', '.join(sorted(set(older)))}, not {code_digest()}"
    )
    return [remark] if older else []


def check_belongs(summary: xr.Dataset, study: Study) -> None:
    """Raise a `DataFileError` if a merged study is of another study, or of an earlier state."""
    file = Path(summary.encoding.get("source", "summary.nc"))
    remedy = "Run the same study again, or name its results by --results"
    status, ids = summary[STATUS.name], summary[CASE_ID.name]
    if [*(sizes := dict(status.sizes)).items()] != [*study.sizes.items()]:
        problem = f"it has points {sizes}, but the study {study.name!r} has {study.sizes}"
        raise DataFileError(file, problem, remedy)
    for point in study.points():
        if (stored := str(ids.values[point.place])) != point.id:
            now = point.id or "an invalid point"
            problem = f"it has case {stored} where the study {study.name!r} has {now}"
            raise DataFileError(file, problem, remedy)
