"""A study as one dataset: its case files merged into one, with the status of its points."""

from __future__ import annotations

import json
import math
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from itertools import chain
from os import PathLike
from pathlib import Path
from typing import IO, TYPE_CHECKING, NamedTuple

import netCDF4
import numpy as np
import xarray as xr
from numpy.typing import NDArray

from fretwear.data.contents import HISTORY_GROUP
from fretwear.data.excerpts import MERGED_HISTORIES, MERGED_PROFILES, Excerpt
from fretwear.data.files import (
    COMPRESSION,
    READS_BACK,
    check_attributes,
    check_group,
    new_netcdf,
    read_excerpt,
    unusable,
    write_group,
)
from fretwear.data.labels import CONVENTIONS, history_line
from fretwear.data.safe import (
    DataFileError,
    atomic_path,
    remove_stale_temporaries,
)
from fretwear.data.stack import (
    common_positions,
    empty_value,
    positions_inside,
    resampled,
    window,
)
from fretwear.version import code_digest
from fretwear.vocabulary import (
    CASE_ID,
    CODE_DIGEST,
    CYCLE,
    POINT,
    STATUS,
    STEP,
    PointStatus,
    Variable,
    X,
    scalars_of,
)

if TYPE_CHECKING:
    from fretwear.study.case import Case
    from fretwear.study.points import Axis
    from fretwear.study.study import Study

_Done = tuple[tuple[int, ...], "Case", Path]
"""The position of a point whose case file exists, its case and the file."""

_BLOCK_BYTES = 1 << 22
"""Largest size of what is written, or read back, at a time, unless a case has more."""
_MOST_SOURCES = 10
_OTHER_CODE = "it was computed by another version of the code (its code_digest differs)"
_KEEP_OR_RUN = "Run the case again, or keep it with --keep-older"


def _columns(study: Study) -> tuple[dict[str, xr.Variable], dict[str, xr.Variable]]:
    """Coordinates (varied values, case ids, shared parameters), and parameters of single points.

    Varied values that are not single numbers (a roughness, a pair of moduli) are text, as written
    in the study file; a parameter that a point lacks is NaN or empty text.
    """
    cases = {point.place: point.case for point in study.points() if point.case is not None}
    attributes: dict[str, dict[str, object]] = {}
    given: dict[str, dict[tuple[int, ...], float | str]] = {}
    for place, case in cases.items():
        for name, (value, units, words) in case.scalar_coordinates().items():
            attributes.setdefault(name, Variable(name, units, words=words).attributes)
            given.setdefault(name, {})[place] = value
    parameters = {name: _laid(study, given[name], attributes[name]) for name in given}
    for name, by_place in given.items():
        if len(by_place) == len(cases) and len(set(by_place.values())) == 1:
            shared = np.asarray(parameters[name].values[next(iter(by_place))])
            parameters[name] = xr.Variable((), shared, attributes[name])
    coordinates = dict[str, xr.Variable]()
    for axis in study.axes:
        coordinates[axis.coordinate] = _varied(study, axis, parameters.pop(axis.coordinate, None))
    if POINT.name in study.sizes:
        numbers = np.arange(study.size, dtype=POINT.dtype)
        coordinates[POINT.name] = xr.Variable((POINT.name,), numbers, POINT.attributes)
    ids = {point.place: point.id for point in study.points()}
    coordinates[CASE_ID.name] = _laid(study, ids, CASE_ID.attributes)
    coordinates |= {name: column for name, column in parameters.items() if not column.dims}
    return coordinates, {name: column for name, column in parameters.items() if column.dims}


def _laid(
    study: Study, given: Mapping[tuple[int, ...], float | str], about: Mapping[str, object]
) -> xr.Variable:
    """Arrange values like the points, NaN or empty text where one is missing."""
    is_text = any(isinstance(value, str) for value in given.values())
    values = np.full(study.shape, "" if is_text else math.nan, object)
    for place, value in given.items():
        values[place] = value
    return xr.Variable(tuple(study.sizes), values.astype(str if is_text else np.float64), about)


def _varied(study: Study, axis: Axis, parameter: xr.Variable | None) -> xr.Variable:
    attributes = {"long_name": axis.name} if parameter is None else dict(parameter.attrs)
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


def remarks_on(digests: Iterable[str]) -> list[str]:
    """Return remarks on cases of other code than the present, by the digests of those done."""
    digests, remarks = list(digests), []
    if older := [digest or "missing" for digest in digests if digest != code_digest()]:
        were = f"case{'s' * (len(digests) > 1)} {'was' if len(older) == 1 else 'were'}"
        remarks.append(
            f"{len(older)} of {len(digests)} {were} computed by another version of the code: "
            f"their code_digest is {', '.join(sorted(set(older)))}, not {code_digest()}"
        )
    return remarks


def remarks_on_summary(summary: xr.Dataset) -> list[str]:
    """Return the remarks of a merged study, on the present code."""
    done = summary[STATUS.name].values == PointStatus.DONE
    return remarks_on(summary[CODE_DIGEST.name].values[done].tolist())


class Tally(NamedTuple):
    """Numbers of done, failed and invalid points of a study, and remarks on their code."""

    done: int
    failed: int
    invalid: int
    remarks: str = ""


_Shape = tuple[int, int]
"""Numbers of cells along x and of accepted steps of a case."""


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
    ``history`` holds the `command`. Memory grows by about 1 kB for each point; fields are read one
    case at a time.

    Sections that packages beside the core have read add their results; `tell` takes their remarks.

    Raises a `DataFileError`, and writes nothing, if no case is done, if the file cannot be written,
    or if case files are damaged, belong to other cases or, unless `keep_older`, to other code; it
    then names them all.
    """
    status = np.full(study.shape, PointStatus.INVALID, dtype=STATUS.dtype)
    done: list[_Done] = []
    for point in study.points():
        if point.case is not None:
            file = Path(cases) / f"{point.id}.nc"
            status[point.place] = PointStatus.DONE if file.exists() else PointStatus.FAILED
            done += [(point.place, point.case, file)] if file.exists() else []
    if not done:
        raise DataFileError(
            Path(path),
            f"not written, because no case of the study is done in {cases}",
            "Run the study; if it was run, its log says why every case failed",
        )
    with suppress(OSError):
        # A power failure may leave temporary files beside finished cases, which no run rewrites.
        remove_stale_temporaries(Path(cases))
    with (
        atomic_path(Path(path)) as temporary,
        # Opening every case file again, once the common positions are known, would take longer than
        # the rest of the merge, so an unnamed file keeps the profiles on disk.
        tempfile.TemporaryFile(dir=temporary.parent) as spool,
    ):
        read = partial(_read_case, scalars=_scalars(done), keep_older=keep_older)
        dataset, shapes = _gathered(study, status, done, read, spool, command, tell)
        _write(temporary, dataset, done, shapes, spool)
    count, failed, invalid = (int((status == kind).sum()) for kind in PointStatus)
    return Tally(count, failed, invalid, dataset.attrs["warnings"])


def _scalars(done: Sequence[_Done]) -> list[Variable]:
    """Return the scalars of the cases, and their errors, which not every case has."""
    expected = scalars_of(done[0][1].frame)
    return [*expected, *(scalar.error for scalar in expected)]


def _read_case(path: Path, case: Case, *, scalars: Sequence[Variable], keep_older: bool) -> Excerpt:
    """Read the excerpt of a case at its snapshots; `DataFileError` if it cannot be used."""
    asked = np.array(case.output_cycles, np.float64)
    excerpt = read_excerpt(path)
    if (other := excerpt.texts[CASE_ID.name]) != case.case_id:
        raise unusable(path, f"it holds another case, {other}")
    if lacking := sorted(set(asked) - set(excerpt.cycles)):
        numbers = ", ".join(f"{cycle:.0f}" for cycle in lacking)
        raise unusable(path, f"it has no snapshot at cycle {numbers}")
    if excerpt.texts[CODE_DIGEST.name] != code_digest() and not keep_older:
        raise DataFileError(path, _OTHER_CODE, _KEEP_OR_RUN)
    at = np.searchsorted(excerpt.cycles, asked)
    kept = dict[str, NDArray[np.float64]]()
    for scalar in scalars:
        if (values := excerpt.scalars.get(scalar.name)) is not None:
            kept[scalar.name] = values[at]
            if not scalar.allows(kept[scalar.name]):
                raise unusable(path, f"{scalar.name} holds values that are not finite")
    profiles = [profile[at] for profile in excerpt.profiles]
    return replace(excerpt, cycles=asked, scalars=kept, profiles=profiles)


def _gathered(
    study: Study,
    status: NDArray[np.int8],
    done: Sequence[_Done],
    read: Callable[[Path, Case], Excerpt],
    spool: IO[bytes],
    command: str,
    tell: Callable[[str], None],
) -> tuple[xr.Dataset, list[_Shape]]:
    """Gather scalars in a dataset, and copy the rest, in the cells of each case, to the spool."""
    digests, sources = np.full(status.shape, "", dtype=object), set()
    snapshots = (case.output_cycles for case in study.cases().values())
    cycles = np.unique(np.concatenate([*snapshots])).astype(np.float64)
    named = {scalar.name for scalar in scalars_of(done[0][1].frame)}
    scalars = {scalar.name: scalar for scalar in _scalars(done)}
    values = {name: np.full((*status.shape, cycles.size), math.nan) for name in scalars}
    windows, errors, shapes = set(), [], list[_Shape]()
    for position, case, path in done:
        try:
            part = read(path, case)
            more = [s.extra_results(path, part.cycles, tell) for s in study.added.values()]
        except DataFileError as error:
            errors.append(error)
            continue
        digests[position] = part.texts[CODE_DIGEST.name]
        sources.add(part.texts["source"])
        columns = np.searchsorted(cycles, part.cycles)
        for scalar in chain(*more):
            scalars[scalar.name] = scalar
            values.setdefault(scalar.name, np.full((*status.shape, cycles.size), math.nan))
        of_more = {scalar.name: at for added in more for scalar, at in added.items()}
        for name, at_snapshots in (part.scalars | of_more).items():
            values[name][position][columns] = at_snapshots
        windows.add(window(part.cells))
        shapes.append((part.cells.size, part.history.shape[1]))
        for array in (part.cells, part.history, *part.profiles):
            spool.write(array.astype(np.float64).tobytes())
    if errors:
        first, *others = errors
        raise DataFileError(first.path, first.problem, "\n".join(map(str, (first.remedy, *others))))
    of_cases = digests[status == PointStatus.DONE].tolist()
    flags = {
        "long_name": STATUS.words,
        "flag_values": np.array(list(PointStatus), dtype=STATUS.dtype),
        "flag_meanings": " ".join(kind.word for kind in PointStatus),
    }
    coordinates, depending = _columns(study)
    dims = tuple(study.sizes)
    dataset = xr.Dataset(
        {
            STATUS.name: xr.Variable(dims, status, flags),
            CODE_DIGEST.name: xr.Variable(dims, digests.astype(str), CODE_DIGEST.attributes),
            **depending,
            **{
                name: xr.Variable((*dims, CYCLE.name), values[name], scalar.attributes)
                for name, scalar in scalars.items()
                if name in named or not np.isnan(values[name]).all()
            },
        },
        {
            **coordinates,
            CYCLE.name: xr.Variable((CYCLE.name,), cycles, CYCLE.attributes),
            X.name: xr.Variable((X.name,), common_positions(windows), X.attributes),
        },
        {
            "source": "; ".join(sorted(sources)[:_MOST_SOURCES]),
            CODE_DIGEST.name: code_digest(),
            "warnings": "\n".join(remarks_on(of_cases)),
            "title": study.title,
            "Conventions": CONVENTIONS,
            "history": history_line(command),
            "study": study.name,
            "design": study.design.kind,
            "study_file": json.dumps(study.content, default=str),
        },
    )
    return dataset, shapes


def _write(
    path: Path,
    dataset: xr.Dataset,
    done: Sequence[_Done],
    shapes: Sequence[_Shape],
    spool: IO[bytes],
) -> None:
    """Write a dataset to a new file, profiles and histories from the spool, a few cases at a time.

    All of it is read back, because the netCDF library may omit parts when memory is short.
    """
    variables = dataset.variables
    points = tuple(map(str, variables[STATUS.name].dims))
    number = variables[STATUS.name].size
    sizes = dict(zip(points, variables[STATUS.name].values.shape, strict=True))
    sizes |= {axis: variables[axis].values.size for axis in (CYCLE.name, X.name)}
    beside = " ".join(sorted(str(n) for n, at in dataset.coords.items() if n not in at.dims))
    large: dict[str, tuple[tuple[str, ...], str, float, Mapping[str, object]]] = {}
    for name, field in MERGED_PROFILES.items():
        outside = "zero outside the window of the case, where the surfaces do not touch"
        comments = (
            field.comment,
            "on the line of cells nearest y = 0",
            "of the nearest cell" if field.flags else "interpolated linearly between the cells",
            "NaN outside the window of the case" if math.isnan(field.outside) else outside,
        )
        comment = "; ".join(filter(None, comments))
        attributes = {**field.attributes, "comment": comment, "coordinates": beside}
        large[name] = (CYCLE.name, X.name), field.dtype, empty_value(field), attributes
    for name in MERGED_HISTORIES:
        large[f"{HISTORY_GROUP}/{name}"] = (STEP.name,), "f8", math.nan, variables[name].attrs
    steps = max(steps for _, steps in shapes)
    per_case = steps * len(MERGED_HISTORIES) + sizes[CYCLE.name] * sizes[X.name] * len(
        MERGED_PROFILES
    )
    size = sum(about.values.nbytes for about in variables.values()) + 8 * number * per_case
    with new_netcdf(path, size) as file:
        for dim in sizes:
            file.createDimension(dim, sizes[dim])
        sizes[STEP.name] = steps
        file.createGroup(HISTORY_GROUP).createDimension(STEP.name, steps)
        for name, (dims, dtype, empty, attrs) in large.items():
            chunk = (*(1 for _ in points), *(sizes[dim] for dim in dims))
            variable = file.createVariable(
                name, dtype, (*points, *dims), chunksizes=chunk, fill_value=empty, **COMPRESSION
            )
            variable.setncatts(attrs)
        for name, where, values in _rows(dataset, done, shapes, spool, 8 * per_case):
            file[name][where] = values
        write_group(file, dataset)
    with netCDF4.Dataset(path) as file:
        file.set_auto_maskandscale(False)
        check_group(file, dataset)
        for name, (*_, attrs) in large.items():
            check_attributes(file[name], attrs)
        for name, where, values in _rows(dataset, done, shapes, spool, 8 * per_case):
            if file[name][where].tobytes() != values.tobytes():
                raise RuntimeError(READS_BACK)


def _rows(
    dataset: xr.Dataset,
    done: Sequence[_Done],
    shapes: Sequence[_Shape],
    spool: IO[bytes],
    case_bytes: int,
) -> Iterator[tuple[str, tuple[object, ...], NDArray[np.generic]]]:
    """Yield histories and profiles of cases side by side: their name, their place, their values.

    `case_bytes` are the most that one case takes.
    """
    cycles, positions = (dataset.coords[axis].values for axis in (CYCLE.name, X.name))
    spool.seek(0)

    def read(*shape: int) -> NDArray[np.float64]:
        return np.frombuffer(spool.read(8 * math.prod(shape))).reshape(shape)

    for cases in _side_by_side(done, max(1, _BLOCK_BYTES // case_bytes)):
        place = done[cases[0]][0]
        where: tuple[int | slice, ...] = ()
        every: int | slice = 0  # a study without varied values has one case
        if place:
            every = slice(None)
            where = (*place[:-1], slice(place[-1], place[-1] + len(cases)))
        steps = max(shapes[index][1] for index in cases)
        histories = np.full((len(MERGED_HISTORIES), len(cases), steps), math.nan)
        size = len(cases), cycles.size, positions.size
        profiles = {
            name: np.full(size, empty_value(field), dtype=field.dtype)
            for name, field in MERGED_PROFILES.items()
        }
        for row, index in enumerate(cases):
            width, length = shapes[index]
            columns = np.searchsorted(cycles, done[index][1].output_cycles)
            cells = read(width)
            histories[:, row, :length] = read(len(MERGED_HISTORIES), length)
            inside = positions_inside(cells, positions)
            for name, field in MERGED_PROFILES.items():
                stored = read(columns.size, width).astype(field.dtype)
                values = profiles[name][row]
                values[columns] = field.outside
                profile = resampled(stored, cells, positions[inside], axis=1)
                values[np.ix_(columns, inside)] = profile
        for name, of_cases in zip(MERGED_HISTORIES, histories, strict=True):
            yield f"{HISTORY_GROUP}/{name}", (*where, slice(0, steps)), of_cases[every]
        for name, block in profiles.items():
            yield name, where, block[every]


def _side_by_side(done: Sequence[_Done], most: int) -> Iterator[range]:
    """Yield ranges of cases, at most so many, whose points are neighbours on the last axis."""
    first = 0
    for last, (place, *_) in enumerate(done):
        is_next = last + 1 < len(done) and done[last + 1][0] == (*place[:-1], place[-1] + 1)
        if not is_next or last + 1 - first == most:
            yield range(first, last + 1)
            first = last + 1
