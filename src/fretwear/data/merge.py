"""A study as one dataset: its case files merged into one, with the status of its points."""

from __future__ import annotations

import json
import math
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from os import PathLike
from pathlib import Path
from types import EllipsisType
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from fretwear.arrays import Array
from fretwear.data.arrays import Header, Headers, read_case, survey
from fretwear.data.atomic import DataFileError
from fretwear.data.files import (
    HISTORY_GROUP,
    MERGED_HISTORIES,
    MERGED_PROFILES,
    RUN_AGAIN,
    write_groups,
)
from fretwear.data.labels import FORMAT, history_line, study_attributes
from fretwear.data.stack import NOT_DONE, Ends, common_positions, ends_of, resampled
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
    Y,
)
from fretwear.study.case_warnings import CaseWarning, study_warnings
from fretwear.study.mistakes import few_of
from fretwear.variable import Variable
from fretwear.version import case_digest, code_digest

if TYPE_CHECKING:
    from fretwear.study.case import Case
    from fretwear.study.designs import Axis
    from fretwear.study.study import Study

_MOST_SOURCES, _POINTS_AT_A_TIME = 10, 256
_OF_STEPS = tuple(f"{HISTORY_GROUP}/{name}" for name in MERGED_HISTORIES)
Arrays: TypeAlias = dict[str, NDArray[Any]]


def merge_study(
    study: Study,
    cases: str | PathLike[str],
    path: str | PathLike[str],
    *,
    command: str = "fretwear.merge_study",
    keep_older: bool = False,
    tell: Callable[[str], None] = lambda _: None,
) -> Counter[str]:
    """Merge the case files ``<case id>.nc`` in the folder `cases` into one file.

    The file has the varied names as dimensions, in the order of the study, or the one dimension
    ``point`` if the design is not a grid; then ``cycle`` and ``x``. It holds every scalar
    (…, cycle) of the cases, the profiles (…, cycle, x) of `MERGED_PROFILES`, and the ``status`` of
    every point, which has failed if its case file is missing. Values are NaN where a point is not
    done or has no snapshot at a cycle. The group ``history`` holds the cycle, the `HEADLINES` and
    the tangential force at every accepted step (…, step), NaN after the last; the attribute
    ``history`` holds the `command`.

    Sections that packages beside the core have read add their results; `tell` takes remarks.
    Returns the numbers of ``done``, ``failed`` and ``invalid`` points.

    Raises a `DataFileError`, and writes nothing, if no case is done, if the file cannot be written,
    or if case files are damaged, belong to other cases or, unless `keep_older`, to other code; it
    then names them all.
    """
    files = _CaseFiles(study, Path(cases), keep_older)
    files.survey(tell)
    if not files.ends:
        raise files.error(Path(path))
    axes = {
        axis.name: xr.Variable((axis.name,), np.array(values, axis.dtype), axis.attributes)
        for axis, values in (
            (CYCLE, sorted(files.cycles)),
            (X, common_positions(files.ends)),
            (STEP, range(files.steps)),
        )
    }
    merged = files.variables(axes)
    flags = {
        "long_name": STATUS.words,
        "flag_values": np.array(list(PointStatus), STATUS.dtype),
        "flag_meanings": " ".join(kind.word for kind in PointStatus),
    }
    coordinates, parameters = _columns(study)
    of_steps = {n.rpartition("/")[2]: merged[n] for n in _OF_STEPS if n in merged}
    history = xr.Dataset(of_steps, {STEP.name: axes.pop(STEP.name)})
    of_cycles = {name: each for name, each in merged.items() if name not in _OF_STEPS}
    of_points = {
        STATUS.name: _laid(study, files.status, flags),
        CODE_DIGEST.name: _laid(study, files.digests, CODE_DIGEST.attributes),
        WARNINGS.name: _laid(study, files.warnings, WARNINGS.attributes),
    }
    summary = xr.Dataset({**of_cycles, **of_points, **parameters}, {**axes, **coordinates})
    remarks = files.remarks()
    summary.attrs = {
        "title": study.title,
        **FORMAT,
        "source": "; ".join(sorted(files.sources)[:_MOST_SOURCES]),
        "history": history_line(command),
        CODE_DIGEST.name: code_digest(),
        WARNINGS.name: "\n".join(remarks),
        "study": study.name,
        "design": study.design.kind,
        "study_file": json.dumps(study.content, default=str),
        **study_attributes(study.content),
    }
    pieces = files.pieces(axes[CYCLE.name].values, axes[X.name].values, merged)
    write_groups(path, {"": summary, HISTORY_GROUP: history}, pieces, merged)
    for remark in few_of(remarks):
        tell(remark)
    return Counter(PointStatus(status).word for status in files.status.tolist())


class _CaseFiles:
    """The case files of a study: checked first, then read a few at a time."""

    def __init__(self, study: Study, folder: Path, keep_older: bool) -> None:
        self.study, self.folder, self.keep_older = study, folder, keep_older
        self.headers, self.errors = Headers(), list[DataFileError]()
        self.status = np.full(study.size, PointStatus.INVALID, STATUS.dtype)
        self.digests, self.warnings = ([""] * study.size for _ in range(2))
        self.sources, self.cycles, self.ends = set[str](), set[int](), set[Ends]()
        self.steps = 0  # of the longest history
        self.done = dict[int, Sequence[int]]()  # cycles of a case, by the number of its point
        self.extra = dict[int, Arrays]()  # results that sections add, over the cycles of the case

    def survey(self, tell: Callable[[str], None]) -> None:
        """Check all files, and read everything except the arrays."""
        for number, point in enumerate(self.study.points()):
            if point.case is not None:
                self.status[number] = PointStatus.FAILED
                if (file := self.folder / f"{point.id}.nc").exists():
                    try:
                        self._add(number, file, point.case, tell)
                    except DataFileError as error:
                        self.errors.append(error)

    def _add(self, number: int, file: Path, case: Case, tell: Callable[[str], None]) -> None:
        attributes, axes, steps = survey(file, self.headers)
        if (stored_id := attributes[CASE_ID.name]) != case.case_id:
            raise DataFileError(file, f"it holds another case, {stored_id}", RUN_AGAIN)
        asked = np.array(case.output_cycles, np.float64)
        if lacking := sorted({*asked} - {*axes[CYCLE.name]}):
            cycles = ", ".join(f"{cycle:.0f}" for cycle in lacking)
            raise DataFileError(file, f"it has no snapshot at cycle {cycles}", RUN_AGAIN)
        if attributes[CODE_DIGEST.name] != case_digest(case) and not self.keep_older:
            fault = "it was computed by another version of the code (its code_digest differs)"
            raise DataFileError(file, fault, "Run the case again, or keep it with --keep-older")
        for section in self.study.added.values():
            for each, values in section.extra_results(file, asked, tell).items():
                self.extra.setdefault(number, {})[each.name] = values
                header = Header((CYCLE.name,), values.dtype, each.attributes)
                self.headers.setdefault("", {})[each.name] = header
        self.status[number], self.done[number] = PointStatus.DONE, case.output_cycles
        self.digests[number] = sys.intern(attributes[CODE_DIGEST.name])
        self.warnings[number] = attributes.get(WARNINGS.name, "")
        self.sources |= {attributes["source"]} if "source" in attributes else set()
        self.cycles.update(case.output_cycles)
        self.ends.add(ends_of(axes[X.name]))
        self.steps = max(self.steps, steps)

    def error(self, path: Path) -> DataFileError:
        """The error of all files that cannot be used, or of a merged study without a case."""
        if not self.errors:
            fault = f"not written, because no case of the study is done in {self.folder}"
            remedy = "Run the study; if it was run, its log says why every case failed"
            return DataFileError(path, fault, remedy)
        first, *others = self.errors
        return DataFileError(first.path, first.fault, "\n".join(map(str, (first.remedy, *others))))

    def remarks(self) -> list[str]:
        """What is doubtful in the cases that are done, one sentence each."""
        points = self.study.points()
        numbers = {points[number].id: number for number in self.done}  # points may share a case
        told = {
            points[number].words: [*filter(None, map(CaseWarning.read, lines.splitlines()))]
            for number in numbers.values()
            if (lines := self.warnings[number])
        }
        older = [
            self.digests[number] or "missing"
            for number in self.done
            if (case := points[number].case) and self.digests[number] != case_digest(case)
        ]
        remark = (
            f"cases computed by another version of the code: {len(older)} of {len(self.done)}, "
            f"with code_digest {', '.join(sorted({*older}))}, not {code_digest()}"
        )
        return [remark] * bool(older) + study_warnings(told, len(numbers))

    def variables(self, axes: Mapping[str, xr.Variable]) -> dict[str, xr.Variable]:
        """The merged variables, as named in the file; all values are missing and take no memory."""
        heads = {name: head for of_code in self.headers.values() for name, head in of_code.items()}
        laid = {n: h for n, h in heads.items() if h.dims == (CYCLE.name,) and n not in axes}
        for name, field in MERGED_PROFILES.items():
            if field.name in heads:
                along = CYCLE.name, X.name
                laid[name] = Header(along, np.dtype(field.dtype), _profile_attributes(field))
        laid |= {name: heads[name] for name in _OF_STEPS if name in heads}
        variables = {}
        for name, (dims, dtype, attributes) in laid.items():
            shape = *self.study.shape, *(axes[dim].size for dim in dims)
            empty = NOT_DONE if dtype.kind == "i" else math.nan
            fill = {"_FillValue": empty} if empty == NOT_DONE else None
            missing = np.broadcast_to(np.array(empty, dtype), shape)
            variables[name] = xr.Variable((*self.study.sizes, *dims), missing, attributes, fill)
        return variables

    def pieces(
        self, cycles: Array, x: Array, merged: Mapping[str, xr.Variable]
    ) -> Iterator[tuple[slice | EllipsisType, Arrays]]:
        """Yield the values of some points at a time: places on the first axis, arrays by name.

        `cycles` and `x`, m, are those of the `merged` variables. Raises a `DataFileError` at the
        end if files cannot be used.
        """
        shape = self.study.shape
        inner = math.prod(shape[1:])
        most = max(1, _POINTS_AT_A_TIME // inner)
        for first in range(0, self.study.size // inner, most):
            place = slice(first, first + most) if shape else ...
            piece = {name: np.array(each[place], order="C") for name, each in merged.items()}
            rows = {n: each.reshape(-1, *each.shape[len(shape) :]) for n, each in piece.items()}
            numbers = range(first * inner, min((first + most) * inner, self.study.size))
            for number in self.done.keys() & {*numbers}:
                for name, (along, values) in self._values(number, cycles, x).items():
                    if name in rows:
                        rows[name][number - numbers.start, along] = values
            yield place, piece
        if self.errors:
            raise self.error(self.folder)

    def _values(
        self, number: int, cycles: Array, x: Array
    ) -> dict[str, tuple[slice | NDArray[np.intp], NDArray[Any]]]:
        """Values of a point by name, with their places on the axis of cycles or of steps."""
        file = self.folder / f"{self.study.points()[number].id}.nc"
        try:
            arrays = read_case(file, self.digests[number], self.headers)
        except DataFileError as error:
            self.errors.append(error)
            return {}
        asked = np.array(self.done[number], np.float64)
        rows, along = (np.searchsorted(each, asked) for each in (arrays[CYCLE.name], cycles))
        values: dict[str, tuple[slice | NDArray[np.intp], NDArray[Any]]] = {
            name: (slice(each.size), each) if name in _OF_STEPS else (along, each[rows])
            for name, each in arrays.items()
            if name not in (X.name, Y.name)
        }
        for name, field in MERGED_PROFILES.items():
            if field.name in values:
                _, stored = values[field.name]
                values[name] = along, resampled(stored, [arrays[X.name]], [x], field.outside)
        return values | {name: (along, each) for name, each in self.extra.get(number, {}).items()}


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


def _columns(study: Study) -> tuple[dict[str, xr.Variable], dict[str, xr.Variable]]:
    """Coordinates (varied values, case ids, shared parameters), and parameters of single points.

    Varied values that are not single numbers (a roughness, a pair of moduli) are text, as written
    in the study file; a parameter that a point lacks is NaN or empty text.
    """
    columns, attributes = dict[str, list[float | str]](), dict[str, Mapping[str, object]]()
    done = []
    for number, point in enumerate(study.points()):
        if point.case is not None:
            done.append(number)
        for name, (value, units, words) in point.scalar_coordinates().items():
            if name not in columns:
                attributes[name] = Variable(name, units, words=words).attributes
                columns[name] = ["" if isinstance(value, str) else math.nan] * study.size
            columns[name][number] = value
    coordinates, parameters = dict[str, xr.Variable](), dict[str, xr.Variable]()
    for axis in study.axes:
        coordinates[axis.coordinate] = _varied(study, axis, attributes.get(axis.coordinate))
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
    ids = [point.id for point in study.points()]
    coordinates[CASE_ID.name] = _laid(study, ids, CASE_ID.attributes)
    return coordinates, parameters


def _laid(study: Study, values: object, attributes: Mapping[str, object]) -> xr.Variable:
    """One value for each point, along the axes of a study."""
    return xr.Variable(tuple(study.sizes), np.reshape(np.asarray(values), study.shape), attributes)


def _varied(study: Study, axis: Axis, declared: Mapping[str, object] | None) -> xr.Variable:
    attributes: dict[str, object] = {"long_name": axis.name, **(declared or {})}
    values = np.array(axis.plain)
    if axis.plain is axis.labels:
        attributes.pop("units", None)
    if axis.drawn_from is not None:
        attributes |= {
            "drawn_from": axis.drawn_from.low,
            "drawn_to": axis.drawn_from.high,
            "drawn_on": axis.drawn_from.scale,
        }
    dim = POINT.name if POINT.name in study.sizes else axis.coordinate
    return xr.Variable((dim,), values, attributes)


def check_belongs(summary: xr.Dataset, study: Study) -> None:
    """Raise a `DataFileError` if a merged study is of another study, or of an earlier state."""
    ids = summary[CASE_ID.name]
    here = [*ids.sizes.items()], ids.values.ravel().tolist()
    if here != ([*study.sizes.items()], [point.id for point in study.points()]):
        file = Path(summary.encoding.get("source", "summary.nc"))
        fault = f"it has other points than the study {study.name!r}"
        remedy = "Run the same study again, or name its results by --results"
        raise DataFileError(file, fault, remedy)
