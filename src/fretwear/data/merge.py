"""A study as one dataset: the merged file of scalars and profiles, and the fields of all cases."""

from __future__ import annotations

import json
import math
import tempfile
from collections.abc import Collection, Iterator, Sequence
from contextlib import AbstractContextManager, closing
from dataclasses import dataclass
from functools import cached_property
from numbers import Integral
from os import PathLike
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, NamedTuple

import netCDF4
import numpy as np
from numpy.typing import NDArray

from fretwear.data.files import (
    COMPRESSION,
    HISTORY_GROUP,
    CaseFile,
    add_checksum,
    open_summary,
    opened_case,
    write_group,
)
from fretwear.data.labels import CONVENTIONS, Column, history_line
from fretwear.data.positions import positions_inside, resampled
from fretwear.data.safe import (
    CaseFileError,
    CaseFilesError,
    DataFileError,
    atomic_path,
)
from fretwear.version import code_digest
from fretwear.vocabulary import (
    CASE_DIMS,
    CASE_ID,
    CODE_DIGEST,
    CYCLE,
    FIELDS,
    HEADLINES,
    LINE_DIMS,
    LINE_SCALARS,
    POINT,
    RESULTS,
    SCALARS,
    STATUS,
    STEP,
    Field,
    PointStatus,
    Variable,
    X,
    Y,
)

if TYPE_CHECKING:
    import xarray as xr

    from fretwear.study.case import Case
    from fretwear.study.points import Axis, Point
    from fretwear.study.study import Study

MOST_POSITIONS = 4096
"""Most positions on either side of the middle that cases share."""

_FIELDS = {field.name: field for field in FIELDS}

PROFILES: dict[str, Field] = {
    "pressure_profile": _FIELDS["pressure"],
    "shear_profile": _FIELDS["shear_traction"],
    "gap_profile": _FIELDS["gap"],
    "wear_profile": _FIELDS["wear_depth"],
    "wear_rate_profile": _FIELDS["wear_rate"],
    "contact_state_profile": _FIELDS["contact_state"],
}
"""Fields along x on the line nearest y = 0, by their names in a merged study."""

NOT_DONE = -1
"""What ``contact_state`` is at points and cycles that are not there; other fields are NaN."""

_HISTORIES = (CYCLE.name, *HEADLINES, "tangential_force")
_CHUNK_BYTES = 32 << 20
_MOST_SOURCES = 10
_OTHER_CODE = "it was computed by another version of the code (its code_digest differs)"
_KEEP_OR_RUN = "Run the case again, or keep it with --keep-older"


@dataclass(frozen=True)
class Tally:
    """How many points of a study are done, failed and invalid; what is said of older ones."""

    done: int
    failed: int
    invalid: int
    older: str = ""


@dataclass(frozen=True)
class StudyLayout:
    """Where each point of a study stands in a merged dataset.

    A grid has one dimension for each varied name, in the order of the study. Every other design
    has the one dimension ``point``, with the varied values along it.
    """

    study: Study

    @property
    def is_grid(self) -> bool:
        """Whether the points are every combination of the varied values."""
        return self.study.design.kind == "grid" or not self.study.axes

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the dimensions."""
        if self.is_grid:
            return tuple(axis.coordinate for axis in self.study.axes)
        return (POINT.name,)

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the dimensions."""
        return self.study.shape if self.study.axes else ()

    def points(self) -> Iterator[tuple[tuple[int, ...], Point]]:
        """Iterate over the points, each with its position along the dimensions."""
        for number, point in enumerate(self.study.points()):
            yield (point.index if self.is_grid else (number,)), point

    def cycles(self) -> NDArray[np.float64]:
        """Every cycle at which some case keeps its fields, in order."""
        cases = self.study.cases().values()
        found = sorted({cycle for case in cases for cycle in case.output_cycles})
        return np.array(found, dtype=np.float64)

    def coordinates(self) -> dict[str, Column]:
        """Coordinates: varied values, case ids, and the parameters that all cases share.

        Varied values that are not single numbers (a roughness, a pair of moduli) are text, in the
        words of the study file.
        """
        found = {axis.coordinate: self._varied(axis) for axis in self.study.axes}
        if not self.is_grid:
            numbers = np.arange(*self.shape, dtype=POINT.dtype)
            found[POINT.name] = Column((POINT.name,), numbers, POINT.attributes)
        ids = np.full(self.shape, "", dtype=object)
        for position, point in self.points():
            ids[position] = point.id
        found[CASE_ID.name] = Column(self.dims, ids.astype(str), CASE_ID.attributes)
        shared = {name: each for name, each in self._parameters.items() if not each.dims}
        return {**found, **shared, **found}

    def dependent(self) -> dict[str, Column]:
        """Parameters that depend on the varied ones, as the Hertz radius does on the load.

        They lie along the dimensions of the study, NaN or empty where a point has none.
        """
        varied = {axis.coordinate for axis in self.study.axes}
        along = {name: each for name, each in self._parameters.items() if each.dims}
        return {name: each for name, each in along.items() if name not in varied}

    @cached_property
    def _parameters(self) -> dict[str, Column]:
        """Every parameter of the cases: a scalar where they share it, else along the points."""
        labels: dict[str, Variable] = {}
        columns: dict[str, NDArray[Any]] = {}
        cases = [(place, point.case) for place, point in self.points() if point.case is not None]
        for place, case in cases:
            for name, (value, units, long_name) in case.scalar_coordinates().items():
                if name not in labels:
                    si_unit = "" if isinstance(value, str) else units
                    labels[name] = Variable(name, si_unit, words=long_name)
                    columns[name] = np.full(self.shape, None)
                columns[name][place] = value
        found = {}
        for name, column in columns.items():
            given = [value for value in column.ravel() if value is not None]
            is_text = any(isinstance(value, str) for value in given)
            dims, shape = self.dims, self.shape
            if len(given) == len(cases) and len(set(given)) == 1:
                dims, shape, values = (), (), given[:1]
            else:
                empty = "" if is_text else np.nan
                values = [empty if value is None else value for value in column.ravel()]
            typed = np.array(values, dtype=str if is_text else np.float64).reshape(shape)
            found[name] = Column(dims, typed, labels[name].attributes)
        return found

    def _varied(self, axis: Axis) -> Column:
        known = self._parameters.get(axis.coordinate)
        attributes = {"long_name": axis.name} if known is None else dict(known.attrs)
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
        return Column((axis.coordinate if self.is_grid else POINT.name,), values, attributes)


class _Done(NamedTuple):
    """A point whose case file is there."""

    position: tuple[int, ...]
    case: Case
    path: Path

    def snapshots(self, file: CaseFile) -> NDArray[np.intp]:
        """Say which snapshots of the file are those of the study."""
        if file.attribute("case_id") != self.case.case_id:
            raise file.unusable(f"it holds another case, {file.attribute('case_id')}")
        stored = file.read(CYCLE.name)
        wanted = np.array(self.case.output_cycles, dtype=np.float64)
        if lacking := sorted(set(wanted) - set(stored)):
            numbers = ", ".join(f"{cycle:.0f}" for cycle in lacking)
            raise file.unusable(f"it has no snapshot at cycle {numbers}")
        return np.searchsorted(stored, wanted)


class _Window(NamedTuple):
    """How finely and how far a case is resolved along one direction, m, and on which sides."""

    spacing: float
    length: float
    is_whole: bool

    @classmethod
    def of(cls, file: CaseFile, name: str) -> _Window:
        """Return the window of a case along x or y."""
        cells = file.read(name)
        is_whole = bool(cells[0] < 0.0)
        inner, outer = float(cells[0]), float(cells[-1])
        spacing = (outer - inner) / (cells.size - 1) if is_whole else 2.0 * inner
        return cls(spacing, outer + 0.5 * spacing, is_whole)


def _common_positions(windows: Collection[_Window]) -> NDArray[np.float64]:
    """Return positions in m that serve all cases.

    They are centres of cells as fine as the finest case's, to the end of the largest window:
    where all cases have one spacing, these are their own cells and nothing is interpolated.
    Above `MOST_POSITIONS` on a side the spacing is as fine as that many allow.
    """
    spacing = min(window.spacing for window in windows)
    length = max(window.length for window in windows)
    # The margin keeps a division's last bit from adding a cell.
    number = math.ceil(length / spacing * (1.0 - 1e-9))
    if number > MOST_POSITIONS:
        number, spacing = MOST_POSITIONS, length / MOST_POSITIONS
    x = (np.arange(number, dtype=np.float64) + 0.5) * spacing
    return np.concatenate([-x[::-1], x]) if any(window.is_whole for window in windows) else x


def merge_study(
    study: Study,
    cases: str | PathLike[str],
    path: str | PathLike[str],
    *,
    command: str = "fretwear.merge_study",
    keep_older: bool = False,
) -> Tally:
    """Merge the case files of a study into one file.

    The file has the varied names as dimensions, in the order of the study (a design other than a
    grid: the one dimension ``point``), then ``cycle`` and ``x``. It holds every variable
    (…, cycle) of the cases, the profiles (…, cycle, x) of `PROFILES`, the ``status`` of every
    point, and NaN where a point is not done or has no snapshot at a cycle. Its group ``history``
    holds the cycles and the `HEADLINES` of every accepted step (…, step), NaN after the last.
    Memory grows by about 1 kB for each point; fields are read one case at a time.

    Parameters
    ----------
    study, cases, path
        The study, the folder of its case files ``<case id>.nc``, of which a point has failed if
        its own is not there, and the file to write.
    command
        What was run, for the attribute ``history``.
    keep_older
        Whether cases that other code has computed are merged too, rather than refused.

    Raises
    ------
    CaseFilesError
        When case files are damaged, of other cases or of other code; it names them all, nothing
        is written.
    DataFileError
        When no case is done, or the file cannot be written.
    """
    layout = StudyLayout(study)
    status = np.full(layout.shape, PointStatus.INVALID, dtype=STATUS.dtype)
    done = []
    for position, point in layout.points():
        if point.case is not None:
            file = Path(cases) / f"{point.id}.nc"
            status[position] = PointStatus.DONE if file.exists() else PointStatus.FAILED
            done += [_Done(position, point.case, file)] if file.exists() else []
    if not done:
        raise DataFileError(
            Path(path),
            f"not written, because no case of the study is done in {cases}",
            "Run the study; if it was run, its log says why every case failed",
        )
    with (
        atomic_path(Path(path)) as temporary,
        # Opening every case file once more, when the common positions are known, would take
        # longer than anything else: the profiles wait on disk, in a file without a name.
        tempfile.TemporaryFile(dir=temporary.parent) as spool,
    ):
        dataset, steps = _read_cases(layout, status, done, spool, keep_older=keep_older)
        dataset.attrs |= {
            "title": study.title,
            "Conventions": CONVENTIONS,
            "history": history_line(command),
            "study": study.name,
            "design": study.design.kind,
            "study_file": json.dumps(study.content, default=str),
        }
        _write(temporary, dataset, done, spool, steps)
        add_checksum(temporary)
    count, failed, invalid = (int((status == kind).sum()) for kind in PointStatus)
    return Tally(count, failed, invalid, dataset.attrs["warnings"])


def _read_cases(
    layout: StudyLayout,
    status: NDArray[np.int8],
    done: Sequence[_Done],
    spool: IO[bytes],
    *,
    keep_older: bool,
) -> tuple[xr.Dataset, int]:
    """Read scalars into a dataset; profiles of each case in its own cells, and history, to spool.

    The dataset has the coordinate ``x`` that serves all cases, and says what computed each; the
    number is that of the steps of the longest history.
    """
    digests, sources = np.full(layout.shape, "", dtype=object), set()
    cycles = layout.cycles()
    known = LINE_SCALARS if done[0].case.indenter.is_line else SCALARS
    known = (*known, *(scalar.error for scalar in known))
    scalars = {scalar: np.full((*layout.shape, cycles.size), np.nan) for scalar in known}
    found: set[str] = set()
    windows = set()
    errors = []
    most_steps = 0
    for point in done:
        columns = np.searchsorted(cycles, point.case.output_cycles)
        try:
            with opened_case(point.path) as file:
                snapshots = point.snapshots(file)
                digests[point.position] = digest = file.attribute(CODE_DIGEST.name)
                if digest != code_digest() and not keep_older:
                    raise CaseFileError(point.path, _OTHER_CODE, _KEEP_OR_RUN)
                sources.add(file.attribute("source"))
                for scalar, values in scalars.items():
                    if scalar.name not in file.file.variables:
                        continue  # errors are not estimated in every case
                    found.add(scalar.name)
                    values[point.position][columns] = own = file.read(scalar.name)[snapshots]
                    if not np.isfinite(own).all():
                        raise file.unusable(f"{scalar.name} holds values that are not finite")
                windows.add(_Window.of(file, X.name))
                row: tuple[Any, ...] = np.s_[:, :]
                if not file.is_line:
                    row = np.s_[:, :, int(np.abs(file.read(Y.name)).argmin())]
                profiles = [file.read(field.name, row)[snapshots] for field in PROFILES.values()]
                history = np.stack([file.read(f"{HISTORY_GROUP}/{name}") for name in _HISTORIES])
                for each in (file.read(X.name), history, *profiles):
                    np.save(spool, each, allow_pickle=False)
                most_steps = max(most_steps, history.shape[1])
        except CaseFileError as error:
            errors.append(error)
    if errors:
        raise CaseFilesError(errors)
    # What only reads the layout of a study does not wait for xarray.
    import xarray as xr

    dims = (*layout.dims, CYCLE.name)
    flags = {
        "long_name": STATUS.words,
        "flag_values": np.array(list(PointStatus), dtype=STATUS.dtype),
        "flag_meanings": " ".join(kind.word for kind in PointStatus),
    }
    dataset = xr.Dataset(
        {
            STATUS.name: (layout.dims, status, flags),
            CODE_DIGEST.name: (layout.dims, digests.astype(str), CODE_DIGEST.attributes),
            **layout.dependent(),
            **{
                scalar.name: (dims, values, scalar.attributes)
                for scalar, values in scalars.items()
                if scalar.name in found
            },
        },
        {
            **layout.coordinates(),
            CYCLE.name: (CYCLE.name, cycles, CYCLE.attributes),
            X.name: (X.name, _common_positions(windows), X.attributes),
        },
        {
            "source": "; ".join(sorted(sources)[:_MOST_SOURCES]),
            CODE_DIGEST.name: code_digest(),
            "warnings": _older_words(digests[status == PointStatus.DONE].tolist()),
        },
    )
    return dataset, most_steps


def _older_words(digests: Sequence[str]) -> str:
    """Say how many cases were computed by another version of the code; empty if none was."""
    older = [digest or "missing" for digest in digests if digest != code_digest()]
    if not older:
        return ""
    return (
        f"{len(older)} of {len(digests)} cases were computed by another version of the code: "
        f"their code_digest is {', '.join(sorted(set(older)))}, not {code_digest()}"
    )


def _write(
    path: Path, dataset: xr.Dataset, done: Sequence[_Done], spool: IO[bytes], steps: int
) -> None:
    """Write a dataset to a new file, profiles and histories from the spool, one case at a time."""
    points = tuple(str(dim) for dim in dataset[STATUS.name].dims)
    dims = (*points, CYCLE.name, X.name)
    beside = " ".join(sorted(str(name) for name in dataset.coords if name not in dims))
    cycles, positions = dataset[CYCLE.name].to_numpy(), dataset[X.name].to_numpy()
    spool.seek(0)
    with netCDF4.Dataset(path, "w") as file:
        for dim in dims:
            file.createDimension(dim, dataset.sizes[dim])
        for name, field in PROFILES.items():
            chunk = (*(1 for _ in points), cycles.size, positions.size)
            variable = file.createVariable(
                name, field.dtype, dims, chunksizes=chunk, fill_value=_missing(field), **COMPRESSION
            )
            variable.setncatts({**_profile_attributes(field), "coordinates": beside})
        group = file.createGroup(HISTORY_GROUP)
        group.createDimension(STEP.name, steps)
        told = (RESULTS[n].in_units(dataset[n].attrs["units"]) for n in _HISTORIES[1:])
        for each in (CYCLE, *told):
            chunk = (*(1 for _ in points), steps)
            variable = group.createVariable(
                each.name, "f8", (*points, STEP.name), chunksizes=chunk, fill_value=np.nan,
                **COMPRESSION,
            )  # fmt: skip
            variable.setncatts(each.attributes)
        for point in done:
            columns = np.searchsorted(cycles, point.case.output_cycles)
            cells, history = np.load(spool), np.load(spool)
            for name, values in zip(_HISTORIES, history, strict=True):
                group[name][(*point.position, slice(0, values.size))] = values
            inside = positions_inside(cells, positions)
            for name, field in PROFILES.items():
                shape = cycles.size, positions.size
                values = np.full(shape, _missing(field), dtype=field.dtype)
                values[columns] = field.outside
                own = resampled(np.load(spool), cells, positions[inside], axis=1)
                values[np.ix_(columns, inside)] = own
                file[name][point.position] = values
        write_group(file, dataset)


def _missing(field: Field) -> float:
    return NOT_DONE if field.flags else math.nan


def _profile_attributes(field: Field) -> dict[str, Any]:
    outside = "zero outside the window of the case, where the surfaces do not touch"
    comments = (
        field.comment,
        "on the line of cells nearest y = 0",
        "of the nearest cell" if field.flags else "interpolated linearly between the cells",
        "NaN outside the window of the case" if math.isnan(field.outside) else outside,
    )
    return {**field.attributes, "comment": "; ".join(filter(None, comments))}


def open_study(path: str | PathLike[str]) -> xr.Dataset:
    """Open the merged study together with the fields of all its cases.

    Fields are dask arrays that read one case at a time, so a reduction over any number of cases
    needs little memory: ``open_study("results/demo").wear_depth.max(("x", "y")).compute()``.
    They are brought to the cells of the finest case, in the largest window, by interpolation
    (none where all cases have one grid spacing; ``contact_state`` is that of the nearest cell).
    Outside the window of a case nothing touches and the gap is NaN; so are all fields
    (``contact_state`` is `NOT_DONE`) where a point is not done or has no such snapshot.

    Parameters
    ----------
    path : str or path-like
        Folder of the results of a study, with ``summary.nc`` and the folder ``cases``.

    Returns
    -------
    xarray.Dataset
        The merged study and every field, dimensions (…, ``cycle``, ``x``, ``y``), in line contacts
        (…, ``cycle``, ``x``).

    Raises
    ------
    DataFileError
        When the merged study or one of its case files is missing or damaged.
    """
    # Only this function needs dask, which takes a while to import.
    import dask.array as da
    import xarray as xr

    folder = Path(path)
    summary = open_summary(folder / "summary.nc")
    status, ids = summary[STATUS.name], summary[CASE_ID.name].to_numpy()
    files = np.full(status.shape, None)
    windows = set()
    dims: tuple[str, ...] = CASE_DIMS
    for position, state in np.ndenumerate(status.to_numpy()):
        if state == PointStatus.DONE:
            files[position] = file = folder / "cases" / f"{ids[position]}.nc"
            with opened_case(file) as case_file:
                if case_file.is_line:
                    dims = LINE_DIMS
                else:
                    windows.add(_Window.of(case_file, Y.name))
    opened = xr.backends.NetCDF4DataStore.open(folder / "summary.nc")  # type: ignore[no-untyped-call]
    with closing(opened) as store:
        # What xarray itself takes for the netCDF library, which no two threads may use at once.
        lock = store.lock
    stacked = summary.copy()
    if dims == CASE_DIMS:
        y = _common_positions(windows)
        stacked = summary.assign_coords({Y.name: ((Y.name,), y, Y.attributes)})
    axes = tuple(stacked[name].to_numpy() for name in dims)
    for field in FIELDS:
        array = _StackedField(files, field, axes, lock)
        cycle_bytes = math.prod(axis.size for axis in axes[1:]) * array.dtype.itemsize
        cycles = min(axes[0].size, max(1, _CHUNK_BYTES // cycle_bytes))
        chunks = (*(1 for _ in files.shape), cycles, *(axis.size for axis in axes[1:]))
        lazy = da.from_array(array, chunks, name=False)  # type: ignore[no-untyped-call]
        stacked[field.name] = ((*status.dims, *dims), lazy, field.attributes)
    stacked.set_close(summary.close)
    return stacked


class _StackedField:
    """One field of all cases as one array; every part that is taken reads the case files.

    The case files lie as the points of the study do, None where a point is not done; the axes are
    the cycles and the positions along x and y in m that all cases share. The lock is held by
    whoever uses the netCDF library.
    """

    def __init__(
        self,
        files: NDArray[Any],
        field: Field,
        axes: tuple[NDArray[np.float64], ...],
        lock: AbstractContextManager[Any],
    ) -> None:
        self.files, self.field, self.axes, self.lock = files, field, axes, lock
        self.shape = (*files.shape, *(axis.size for axis in axes))
        self.ndim = len(self.shape)
        self.dtype = np.dtype(field.dtype)

    def __getitem__(self, key: tuple[int | slice, ...]) -> NDArray[Any]:
        """Read a part, along every dimension a slice or an index."""
        at, within = key[: self.files.ndim], key[self.files.ndim :]
        files = np.asarray(self.files[at], dtype=object)
        axes = [np.atleast_1d(axis[part]) for axis, part in zip(self.axes, within, strict=True)]
        shape = (*files.shape, *map(len, axes))
        values = np.full(shape, _missing(self.field), dtype=self.dtype)
        for position, file in np.ndenumerate(files):
            if file is not None:
                self._read_case(file, axes, values[position])
        single: list[Any] = [0 if isinstance(part, Integral) else np.s_[:] for part in within]
        return np.asarray(values[(..., *single)])

    def _read_case(
        self, path: Path, axes: Sequence[NDArray[np.float64]], into: NDArray[Any]
    ) -> None:
        cycles, *places = axes
        # Opening a file is a use of the library too.
        with self.lock, netCDF4.Dataset(path) as file:
            file.set_auto_mask(False)
            stored = file[CYCLE.name][:]
            snapshots = {
                place: file[self.field.name][int(np.searchsorted(stored, cycle))]
                for place, cycle in enumerate(cycles)
                if cycle in stored
            }
            cells = [file[name][:] for name in CASE_DIMS[1 : 1 + len(places)]]
        inside = [positions_inside(own, wanted) for own, wanted in zip(cells, places, strict=True)]
        for place, values in snapshots.items():
            for axis, (own, wanted) in enumerate(zip(cells, places, strict=True)):
                values = resampled(values, own, wanted[inside[axis]], axis=axis)
            into[place] = self.field.outside
            into[place][np.ix_(*inside)] = values
