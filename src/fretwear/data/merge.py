"""A study as one dataset: its case files merged into one, with the status of its points."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from fretwear.data.atomic import DataFileError
from fretwear.data.files import (
    HISTORY_GROUP,
    MERGED_HISTORIES,
    MERGED_PROFILES,
    RUN_AGAIN,
    Header,
    Headers,
    read_case,
    write_groups,
)
from fretwear.data.labels import FORMAT, history_line, study_attributes
from fretwear.data.stack import NOT_DONE, common_positions, resampled
from fretwear.results import (
    CASE_ID,
    CODE_DIGEST,
    CYCLE,
    POINT,
    STATUS,
    STEP,
    WARNINGS,
    PointStatus,
    X,
)
from fretwear.study.case_warnings import CaseWarning, study_warnings
from fretwear.study.mistakes import few_of
from fretwear.variable import Variable
from fretwear.version import case_digest, code_digest

if TYPE_CHECKING:
    from fretwear.study.case import Case
    from fretwear.study.designs import Axis
    from fretwear.study.study import Study

_MOST_SOURCES = 10
Arrays: TypeAlias = dict[str, NDArray[Any]]


class Tally(NamedTuple):
    """Numbers of done, failed and invalid points of a study."""

    done: int
    failed: int
    invalid: int


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
    names = {point.id: point.words for point in study.points()}
    rows, headers, errors = dict[int, Arrays](), Headers(), list[DataFileError]()
    stored: list[Mapping[str, Any]] = [{} for _ in points]  # attributes
    status = np.full(len(points), PointStatus.INVALID, STATUS.dtype)
    for number, (case_id, case) in enumerate(points):
        if case is None:
            continue
        file = Path(cases) / f"{case_id}.nc"
        status[number] = PointStatus.DONE if file.exists() else PointStatus.FAILED
        if file.exists():
            try:
                stored[number], row = _read_case(file, case, keep_older, headers)
                for section in study.added.values():
                    extra = section.extra_results(file, row[CYCLE.name], tell)
                    for each, values in extra.items():
                        row[each.name] = values
                        header = Header((CYCLE.name,), values.dtype, each.attributes)
                        headers["", each.name] = header
                rows[number] = row
            except DataFileError as error:
                errors.append(error)
    if errors:
        first, *others = errors
        raise DataFileError(first.path, first.fault, "\n".join(map(str, (first.remedy, *others))))
    if not rows:
        fault = f"not written, because no case of the study is done in {cases}"
        remedy = "Run the study; if it was run, its log says why every case failed"
        raise DataFileError(Path(path), fault, remedy)
    x = common_positions([row[X.name] for row in rows.values()])
    cycles = np.unique(np.concatenate([row[CYCLE.name] for row in rows.values()]))
    axes = {
        CYCLE.name: xr.Variable((CYCLE.name,), cycles, CYCLE.attributes),
        X.name: xr.Variable((X.name,), x, X.attributes),
    }
    places = {n: np.searchsorted(cycles, row[CYCLE.name]) for n, row in rows.items()}
    heads = {name: header for (_, name), header in headers.items()}
    scalars = {n: each for n, each in heads.items() if each.dims == (CYCLE.name,) and n not in axes}
    profiles = {
        name: Header((CYCLE.name, X.name), np.dtype(field.dtype), _profile_attributes(field))
        for name, field in MERGED_PROFILES.items()
    }
    for row in rows.values():
        for name, field in MERGED_PROFILES.items():
            if field.name in row:
                row[name] = resampled(row[field.name], [row[X.name]], [x], field.outside)
    summary = _side_by_side(study, rows, places, scalars | profiles, axes)
    of_steps = {name: f"{HISTORY_GROUP}/{name}" for name in MERGED_HISTORIES}
    histories = {
        number: {name: row[stored] for name, stored in of_steps.items() if stored in row}
        for number, row in rows.items()
    }
    accepted = {n: np.arange(history[CYCLE.name].size) for n, history in histories.items()}
    steps = max(accepted.values(), key=np.size).astype(STEP.dtype)
    step = {STEP.name: xr.Variable((STEP.name,), steps, STEP.attributes)}
    over_steps = {name: heads[stored] for name, stored in of_steps.items() if stored in heads}
    history = _side_by_side(study, histories, accepted, over_steps, step)
    flags = {
        "long_name": STATUS.words,
        "flag_values": np.array(list(PointStatus), STATUS.dtype),
        "flag_meanings": " ".join(kind.word for kind in PointStatus),
    }
    digests = [attributes.get(CODE_DIGEST.name, "") for attributes in stored]
    lines = [str(attributes.get(WARNINGS.name, "")) for attributes in stored]
    sources = sorted({attributes["source"] for attributes in stored if "source" in attributes})
    coordinates, parameters = _columns(study, points)
    summary = summary.assign(
        {
            STATUS.name: _laid(study, status, flags),
            CODE_DIGEST.name: _laid(study, digests, CODE_DIGEST.attributes),
            WARNINGS.name: _laid(study, lines, WARNINGS.attributes),
            **parameters,
        }
    ).assign_coords(coordinates)
    remarks = _remarks_on((digests[number], points[number][1]) for number in rows)
    found = {points[n][0]: lines[n].splitlines() for n in rows}
    remarks += study_warnings(
        {names[n]: [*filter(None, map(CaseWarning.read, told))] for n, told in found.items()},
        len(found),
    )
    summary.attrs = {
        "title": study.title,
        **FORMAT,
        "source": "; ".join(sources[:_MOST_SOURCES]),
        "history": history_line(command),
        CODE_DIGEST.name: code_digest(),
        WARNINGS.name: "\n".join(remarks),
        "study": study.name,
        "design": study.design.kind,
        "study_file": json.dumps(study.content, default=str),
        **study_attributes(study.content),
    }
    write_groups(path, {"": summary, HISTORY_GROUP: history})
    for remark in few_of(remarks):
        tell(remark)
    count = Counter(status.tolist())
    return Tally(*(count[kind] for kind in PointStatus))


def _read_case(
    path: Path, case: Case, keep_older: bool, headers: Headers
) -> tuple[dict[str, Any], Arrays]:
    """Read a case at its snapshots; `DataFileError` if it cannot be used."""
    attributes, arrays = read_case(path, headers)
    if (stored_id := attributes[CASE_ID.name]) != case.case_id:
        raise DataFileError(path, f"it holds another case, {stored_id}", RUN_AGAIN)
    cycles, asked = arrays[CYCLE.name], np.array(case.output_cycles, np.float64)
    if lacking := sorted({*asked} - {*cycles}):
        numbers = ", ".join(f"{cycle:.0f}" for cycle in lacking)
        raise DataFileError(path, f"it has no snapshot at cycle {numbers}", RUN_AGAIN)
    if attributes.get(CODE_DIGEST.name) != case_digest(case) and not keep_older:
        fault = "it was computed by another version of the code (its code_digest differs)"
        raise DataFileError(path, fault, "Run the case again, or keep it with --keep-older")
    if asked.size < cycles.size:
        rows = np.searchsorted(cycles, asked)
        code = attributes.get(CODE_DIGEST.name, str(path))
        over_cycles = [n for n in arrays if headers[code, n].dims[0] == CYCLE.name]
        arrays |= {name: arrays[name][rows] for name in over_cycles}
    return attributes, arrays


def _profile_attributes(field: Variable) -> dict[str, object]:
    """The attributes of a field along x at the positions that all cases share."""
    outside = "zero outside the window of the case, where the surfaces do not touch"
    comments = (
        field.comment,
        "on the line of cells nearest y = 0",
        "of the nearest cell" if field.flags else "interpolated linearly between the cells",
        "NaN outside the window of the case" if math.isnan(field.outside) else outside,
    )
    return {**field.attributes, "comment": "; ".join(filter(None, comments))}


def _side_by_side(
    study: Study,
    rows: Mapping[int, Arrays],
    places: Mapping[int, NDArray[np.intp]],
    headers: Mapping[str, Header],
    axes: dict[str, xr.Variable],
) -> xr.Dataset:
    """Variables of points, by number, along the axes of a study; NaN where a point has none.

    `places` index the values of each point on the first axis of a variable.
    """
    variables = {}
    for name, (dims, dtype, attributes) in headers.items():
        there = {number: row[name] for number, row in rows.items() if name in row}
        if not there:
            continue
        shape = [axes[dim].size for dim in dims]
        empty = NOT_DONE if dtype.kind == "i" else math.nan
        values = np.full((math.prod(study.shape), *shape), empty, dtype)
        for number, stored in there.items():
            values[number, places[number]] = stored
        laid = values.reshape(*study.shape, *shape)
        fill = {"_FillValue": empty} if empty == NOT_DONE else None
        variables[name] = xr.Variable((*study.sizes, *dims), laid, attributes, fill)
    return xr.Dataset(variables, axes)


def _columns(
    study: Study, points: Sequence[tuple[str, Case | None]]
) -> tuple[dict[str, xr.Variable], dict[str, xr.Variable]]:
    """Coordinates (varied values, case ids, shared parameters), and parameters of single points.

    Varied values that are not single numbers (a roughness, a pair of moduli) are text, as written
    in the study file; a parameter that a point lacks is NaN or empty text.
    """
    columns, attributes = dict[str, list[float | str]](), dict[str, Mapping[str, object]]()
    for number, (_, case) in enumerate(points):
        for name, (value, units, words) in (case.scalar_coordinates() if case else {}).items():
            attributes.setdefault(name, Variable(name, units, words=words).attributes)
            number_or_text = value if isinstance(value, str) else float(value)
            empty = "" if isinstance(value, str) else math.nan
            columns.setdefault(name, [empty] * len(points))[number] = number_or_text
    coordinates, parameters = dict[str, xr.Variable](), dict[str, xr.Variable]()
    for axis in study.axes:
        coordinates[axis.coordinate] = _varied(study, axis, attributes.get(axis.coordinate))
    done = [number for number, (_, case) in enumerate(points) if case is not None]
    for name, values in columns.items():
        if name in coordinates:
            continue
        if len({values[number] for number in done}) == 1:
            coordinates[name] = xr.Variable((), values[done[0]], attributes[name])
        else:
            parameters[name] = _laid(study, values, attributes[name])
    if POINT.name in study.sizes:
        numbers = np.arange(study.size, dtype=POINT.dtype)
        coordinates[POINT.name] = xr.Variable((POINT.name,), numbers, POINT.attributes)
    ids = [case_id for case_id, _ in points]
    coordinates[CASE_ID.name] = _laid(study, ids, CASE_ID.attributes)
    return coordinates, parameters


def _laid(study: Study, values: object, attributes: Mapping[str, object]) -> xr.Variable:
    """One value for each point, along the axes of a study."""
    return xr.Variable(tuple(study.sizes), np.reshape(np.asarray(values), study.shape), attributes)


def _varied(study: Study, axis: Axis, declared: Mapping[str, object] | None) -> xr.Variable:
    attributes: dict[str, object] = {"long_name": axis.name, **(declared or {})}
    if all(isinstance(value, int | float) for value in axis.values):
        values = np.array(axis.values, dtype=np.float64)
    else:
        is_text = all(isinstance(value, str) for value in axis.values)
        values = np.array(axis.values if is_text else axis.labels, dtype=str)
        attributes.pop("units", None)
    if axis.drawn_from is not None:
        attributes |= {
            "drawn_from": axis.drawn_from.low,
            "drawn_to": axis.drawn_from.high,
            "drawn_on": axis.drawn_from.scale,
        }
    dim = POINT.name if POINT.name in study.sizes else axis.coordinate
    return xr.Variable((dim,), values, attributes)


def _remarks_on(done: Iterable[tuple[str, Case | None]]) -> list[str]:
    """Return a remark if finished cases, given with their digests, were computed by other code."""
    pairs = [(digest, case_digest(case)) for digest, case in done if case is not None]
    older = [digest or "missing" for digest, now in pairs if digest != now]
    remark = (
        f"cases computed by another version of the code: {len(older)} of {len(pairs)}, with "
        f"code_digest {', '.join(sorted({*older}))}, not {code_digest()}"
    )
    return [remark] if older else []


def check_belongs(summary: xr.Dataset, study: Study) -> None:
    """Raise a `DataFileError` if a merged study is of another study, or of an earlier state."""
    ids = summary[CASE_ID.name]
    here = [*ids.sizes.items()], ids.values.ravel().tolist()
    if here != ([*study.sizes.items()], [point.id for point in study.points()]):
        file = Path(summary.encoding.get("source", "summary.nc"))
        fault = f"it has other points than the study {study.name!r}"
        remedy = "Run the same study again, or name its results by --results"
        raise DataFileError(file, fault, remedy)
