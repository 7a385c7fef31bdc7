"""The merged study: the results of all cases in one file with labelled dimensions."""

from __future__ import annotations

import json
import math
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import netCDF4
import numpy as np
import xarray as xr
from numpy.typing import NDArray
from xarray.backends import BackendArray
from xarray.backends.netCDF4_ import NETCDF4_PYTHON_LOCK
from xarray.core import indexing

from fretwear.data.dataset import CONVENTIONS, history_line, source
from fretwear.data.files import (
    CaseFile,
    add_checksum,
    open_summary,
    opened_case,
    plain_encoding,
)
from fretwear.data.safe import (
    CaseFileError,
    CaseFilesError,
    DataFileError,
    atomic_path,
    uninterrupted,
)
from fretwear.vocabulary import (
    CASE_ID,
    CYCLE,
    FIELDS,
    POINT,
    SCALARS,
    Field,
    PointStatus,
    Variable,
    X,
    Y,
)

if TYPE_CHECKING:
    from fretwear.study.case import Case
    from fretwear.study.points import Axis, Point
    from fretwear.study.study import Study


@dataclass(frozen=True)
class Tally:
    """How many points of a study are done, failed and invalid."""

    done: int
    failed: int
    invalid: int


def merge_study(
    study: Study,
    cases: str | PathLike[str],
    path: str | PathLike[str],
    *,
    command: str = "fretwear.merge_study",
) -> Tally:
    """Merge the case files of a study into one file.

    The file has the varied names as dimensions, in the order of the study (a design other than a
    grid: the one dimension ``point``), then ``cycle`` and ``x``. It holds every variable
    (…, cycle) of the cases, the profiles (…, cycle, x) of `PROFILES`, the
    ``status`` of every point, and NaN where a point is not done or has no snapshot at a cycle.
    Memory grows by about 1 kB for each point; fields are read one case at a time.

    Parameters
    ----------
    study : Study
        The study.
    cases : str or path-like
        Folder of the case files ``<case id>.nc``. A point whose file is not there has failed.
    path : str or path-like
        File to write.
    command : str
        What was run, for the attribute ``history``.

    Returns
    -------
    Tally
        How many points are done, failed and invalid.

    Raises
    ------
    CaseFilesError
        When case files are damaged or of other cases; it names them all, nothing is written.
    DataFileError
        When no case is done, or the file cannot be written.
    """
    layout = StudyLayout(study)
    cycles = np.array(layout.cycles(), dtype=np.float64)
    status = np.full(layout.shape, PointStatus.INVALID, dtype=np.int8)
    found: list[_Found] = []
    for position, point in layout.points():
        if point.case is not None:
            file = Path(cases) / f"{point.id}.nc"
            status[position] = PointStatus.DONE if file.exists() else PointStatus.FAILED
            found += [_Found(position, point.case, file)] if file.exists() else []
    if not found:
        raise DataFileError(
            Path(path),
            f"not written, because no case of the study is done in {cases}",
            "Run the study; if it was run, its log says why every case failed",
        )
    with atomic_path(Path(path)) as temporary, ProfileSpool(temporary.parent) as spool:
        scalars, reach = _read_cases(layout, cycles, found, spool)
        coords = {
            CYCLE.name: xr.Variable((CYCLE.name,), cycles, CYCLE.attributes),
            X.name: xr.Variable((X.name,), reach.positions(), X.attributes),
        }
        dataset = _without_profiles(layout, coords, status, scalars, command)
        _write_profiles(temporary, dataset, found, spool)
        encoding = plain_encoding(dataset)
        with uninterrupted():
            dataset.to_netcdf(temporary, mode="a", engine="netcdf4", encoding=encoding)
        add_checksum(temporary)
    counts = [int((status == kind).sum()) for kind in PointStatus]
    return Tally(*counts)


@dataclass(frozen=True)
class _Found:
    """A point whose case file is there."""

    position: tuple[int, ...]
    case: Case
    path: Path

    def snapshots(self, case_file: CaseFile) -> NDArray[np.intp]:
        """Say which snapshots of the file are those of the study."""
        if case_file.attribute("case_id") != self.case.case_id:
            raise case_file.unusable(f"it holds another case, {case_file.attribute('case_id')}")
        stored = case_file.read(CYCLE.name)
        wanted = np.array(self.case.output_cycles, dtype=np.float64)
        if lacking := sorted(set(wanted) - set(stored)):
            numbers = ", ".join(f"{cycle:.0f}" for cycle in lacking)
            raise case_file.unusable(f"it has no snapshot at cycle {numbers}")
        return np.searchsorted(stored, wanted)


def _read_cases(
    layout: StudyLayout,
    cycles: NDArray[np.float64],
    found: Sequence[_Found],
    spool: ProfileSpool,
) -> tuple[dict[str, NDArray[np.float64]], Reach]:
    scalars = {variable.name: np.full((*layout.shape, cycles.size), np.nan) for variable in SCALARS}
    reaches: list[Reach] = []

    def read(point: _Found) -> None:
        columns = np.searchsorted(cycles, point.case.output_cycles)
        with opened_case(point.path) as case_file:
            snapshots = point.snapshots(case_file)
            for name, values in scalars.items():
                values[point.position][columns] = case_file.read(name)[snapshots]
            is_whole = case_file.attribute("symmetry") == "none"
            profiles = CaseProfiles.read(case_file, snapshots)
        reaches.append(Reach.of_case(profiles.x, is_whole))
        spool.add(profiles)

    _for_each(found, read)
    return scalars, reduce(Reach.joined, reaches)


def _write_profiles(
    path: Path, dataset: xr.Dataset, found: Sequence[_Found], spool: ProfileSpool
) -> None:
    with netCDF4.Dataset(path, "w") as file:
        variables = _profile_variables(file, dataset)
        cycles, positions = dataset[CYCLE.name].to_numpy(), dataset[X.name].to_numpy()
        for point, profiles in zip(found, spool, strict=True):
            columns = np.searchsorted(cycles, point.case.output_cycles)
            for name, values in profiles.at(positions).items():
                whole = np.full((cycles.size, positions.size), np.nan, dtype=np.float32)
                whole[columns] = values
                variables[name][point.position] = whole


def _profile_variables(file: netCDF4.Dataset, dataset: xr.Dataset) -> dict[str, Any]:
    dims = (*(str(dim) for dim in dataset["status"].dims), CYCLE.name, X.name)
    for name in dims:
        file.createDimension(name, dataset.sizes[name])
    beside = " ".join(sorted(str(name) for name in dataset.coords if name not in dims))
    variables = {}
    for profile in PROFILES:
        variable = file.createVariable(
            profile.name,
            "f4",
            dims,
            zlib=True,
            complevel=1,
            shuffle=True,
            fletcher32=True,
            chunksizes=(*(1 for _ in dims[:-2]), *(dataset.sizes[name] for name in dims[-2:])),
            fill_value=np.nan,
        )
        variable.setncatts({**profile.attributes, "coordinates": beside})
        variables[profile.name] = variable
    return variables


def _without_profiles(
    layout: StudyLayout,
    coords: Mapping[str, xr.Variable],
    status: NDArray[np.int8],
    scalars: Mapping[str, NDArray[np.float64]],
    command: str,
) -> xr.Dataset:
    study = layout.study
    flags = {
        "long_name": "what became of the point",
        "flag_values": np.array(list(PointStatus), dtype=np.int8),
        "flag_meanings": " ".join(kind.name.lower() for kind in PointStatus),
    }
    dims = (*layout.dims, CYCLE.name)
    return xr.Dataset(
        {
            "status": (layout.dims, status, flags),
            **layout.following(),
            **{
                variable.name: (dims, scalars[variable.name], variable.attributes)
                for variable in SCALARS
            },
        },
        {**layout.coordinates(), **coords},
        {
            "title": study.title,
            "Conventions": CONVENTIONS,
            "source": source(),
            "history": history_line(command),
            "study": study.name,
            "design": study.design.kind,
            "study_file": json.dumps(study.content, default=str),
        },
    )


def _for_each(found: Sequence[_Found], do: Callable[[_Found], None]) -> None:
    """Do the same for every case file; tell all that is wrong with them at the end."""
    errors = []
    for point in found:
        try:
            do(point)
        except CaseFileError as error:
            errors.append(error)
    if errors:
        raise CaseFilesError(errors)


@dataclass(frozen=True)
class StudyLayout:
    """Where each point of a study stands in a merged dataset.

    A grid has one dimension for each varied name, in the order of the study. Every other design
    has the one dimension ``point``, with the varied values along it.

    Attributes
    ----------
    study : Study
        The study.
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

    def cycles(self) -> tuple[int, ...]:
        """Every cycle at which some case keeps its fields, in order."""
        cases = self.study.cases().values()
        return tuple(sorted({cycle for case in cases for cycle in case.output_cycles}))

    def coordinates(self) -> dict[str, xr.Variable]:
        """Coordinates: varied values, case ids, and the parameters that all cases share.

        Varied values that are not single numbers (a roughness, a pair of moduli) are text, in the
        words of the study file.
        """
        found = {
            axis.coordinate: self._varied(axis, self._parameters.get(axis.coordinate))
            for axis in self.study.axes
        }
        if not self.is_grid:
            numbers = np.arange(*self.shape, dtype=POINT.dtype)
            found[POINT.name] = xr.Variable((POINT.name,), numbers, POINT.attributes)
        ids = np.full(self.shape, "", dtype=object)
        for position, point in self.points():
            ids[position] = point.id
        found[CASE_ID.name] = xr.Variable(self.dims, ids.astype(str), CASE_ID.attributes)
        for parameter in self._unvaried:
            if parameter.is_shared:
                value = np.array(next(iter(parameter.distinct)))
                value = value if value.dtype.kind == "U" else value.astype(np.float64)
                found[parameter.label.name] = xr.Variable((), value, parameter.label.attributes)
        return found

    def following(self) -> dict[str, xr.Variable]:
        """Parameters that follow from the varied ones, as the Hertz radius does from the load.

        They lie along the dimensions of the study, NaN or empty where a point has none.
        """
        return {
            parameter.label.name: xr.Variable(
                self.dims, parameter.typed(), parameter.label.attributes
            )
            for parameter in self._unvaried
            if not parameter.is_shared
        }

    @property
    def _unvaried(self) -> list[_Parameter]:
        varied = {axis.coordinate for axis in self.study.axes}
        return [found for name, found in self._parameters.items() if name not in varied]

    @cached_property
    def _parameters(self) -> dict[str, _Parameter]:
        valid = [(place, point.case) for place, point in self.points() if point.case is not None]
        found: dict[str, _Parameter] = {}
        for place, case in valid:
            for name, (value, units, long_name) in case.scalar_coordinates().items():
                if name not in found:
                    label = Variable(name, "" if isinstance(value, str) else units, long_name)
                    found[name] = _Parameter(label, np.full(self.shape, None), len(valid))
                found[name].values[place] = value
        return found

    def _varied(self, axis: Axis, parameter: _Parameter | None) -> xr.Variable:
        dims = (axis.coordinate,) if self.is_grid else (POINT.name,)
        label = parameter.label if parameter else Variable(axis.coordinate, "", axis.name)
        if all(isinstance(value, int | float) for value in axis.values):
            return xr.Variable(dims, np.array(axis.values, dtype=np.float64), label.attributes)
        if all(isinstance(value, str) for value in axis.values):
            return xr.Variable(dims, np.array(axis.values, dtype=str), label.attributes)
        words = Variable(axis.coordinate, "", label.words)
        return xr.Variable(dims, np.array(axis.labels, dtype=str), words.attributes)


@dataclass(frozen=True)
class _Parameter:
    """One parameter of all cases: None where a point is invalid or its case has no such one."""

    label: Variable
    values: NDArray[Any]
    cases: int

    @cached_property
    def distinct(self) -> set[float | str]:
        return set(self._given)

    @property
    def is_shared(self) -> bool:
        return len(self.distinct) == 1 and len(self._given) == self.cases

    @property
    def _given(self) -> list[float | str]:
        return [value for value in self.values.ravel() if value is not None]

    def typed(self) -> NDArray[Any]:
        empty = "" if any(isinstance(value, str) for value in self.distinct) else np.nan
        filled = [empty if value is None else value for value in self.values.ravel()]
        return np.array(filled).reshape(self.values.shape)


MOST_POSITIONS = 4096

_INTERPOLATED = (
    "on the line of cells nearest y = 0; between the cells of the case interpolated linearly"
)
_ZERO_OUTSIDE = "zero outside the window of the case, where the surfaces do not touch"
_UNKNOWN_OUTSIDE = "NaN outside the window of the case"


@dataclass(frozen=True)
class Profile:
    """A field along x on the line nearest y = 0.

    Attributes
    ----------
    name : str
        Name in a merged study.
    field : Field
        The field of the cases.
    """

    name: str
    field: Field

    @property
    def attributes(self) -> dict[str, str]:
        """CF attributes."""
        outside = _UNKNOWN_OUTSIDE if math.isnan(self.field.outside) else _ZERO_OUTSIDE
        comments = (self.field.comment, _INTERPOLATED, outside)
        return {
            "long_name": self.field.words,
            "units": self.field.si_unit,
            "comment": "; ".join(comment for comment in comments if comment),
        }


_BY_NAME = {field.name: field for field in FIELDS}

PROFILES: tuple[Profile, ...] = (
    Profile("pressure_profile", _BY_NAME["pressure"]),
    Profile("shear_profile", _BY_NAME["shear_traction"]),
    Profile("gap_profile", _BY_NAME["gap"]),
    Profile("wear_profile", _BY_NAME["wear_depth"]),
    Profile("wear_rate_profile", _BY_NAME["wear_rate"]),
)


@dataclass(frozen=True)
class Reach:
    """How far and how finely cases are resolved along x.

    Attributes
    ----------
    spacing : float
        Finest grid spacing, m.
    length : float
        Distance in m from the middle to the end of the largest window.
    is_whole : bool
        Whether some case has x < 0 too.
    """

    spacing: float
    length: float
    is_whole: bool

    @classmethod
    def of_case(cls, x: NDArray[np.float64], is_whole: bool) -> Reach:
        """Reach of one case with cell centres `x` in m."""
        spacing = float(2.0 * x[0]) if not is_whole else float((x[-1] - x[0]) / (x.size - 1))
        return cls(spacing, float(x[-1]) + 0.5 * spacing, is_whole)

    def joined(self, other: Reach) -> Reach:
        """Reach of both."""
        return Reach(
            min(self.spacing, other.spacing),
            max(self.length, other.length),
            self.is_whole or other.is_whole,
        )

    def positions(self) -> NDArray[np.float64]:
        """Return positions in m that serve all cases.

        They are centres of cells as fine as the finest case's, to the end of the largest window:
        where all cases have one spacing, these are their own cells and nothing is interpolated.
        Above `MOST_POSITIONS` on a side the spacing is as fine as that many allow.
        """
        # The margin keeps a division's last bit from adding a cell.
        number = math.ceil(self.length / self.spacing * (1.0 - 1e-9))
        spacing = self.spacing
        if number > MOST_POSITIONS:
            number, spacing = MOST_POSITIONS, self.length / MOST_POSITIONS
        x = (np.arange(number, dtype=np.float64) + 0.5) * spacing
        return np.concatenate([-x[::-1], x]) if self.is_whole else x


@dataclass(frozen=True)
class CaseProfiles:
    """The profiles of a case in its own cells.

    Attributes
    ----------
    x : numpy.ndarray, shape (n,)
        Cell centres in m.
    values : numpy.ndarray, shape (nprofiles, ncycles, n)
        The profiles, float32, in the order of `PROFILES`.
    """

    x: NDArray[np.float64]
    values: NDArray[np.float32]

    @classmethod
    def read(cls, case_file: CaseFile, snapshots: NDArray[np.intp]) -> CaseProfiles:
        """Take the profiles of a case at some of its snapshots."""
        row = int(np.abs(case_file.read(Y.name)).argmin())
        fields = [case_file.read(each.field.name, np.s_[:, :, row])[snapshots] for each in PROFILES]
        return cls(case_file.read(X.name), np.stack(fields))

    def at(self, positions: NDArray[np.float64]) -> dict[str, NDArray[np.float32]]:
        """Bring the profiles to positions in m; by name, shape (ncycles, npositions)."""
        along_x = Resampling(self.x, positions)
        profiles = {}
        for profile, own in zip(PROFILES, self.values, strict=True):
            values = along_x.linear(own, axis=1)
            values[:, along_x.is_outside] = profile.field.outside
            profiles[profile.name] = values
        return profiles


class ProfileSpool:
    """Profiles of many cases, kept on disk until it is known which positions serve them all.

    Used as a context: opening a case file once more would take longer than anything else.

    Parameters
    ----------
    folder : path-like
        Where the profiles are kept meanwhile, in a file without a name.
    """

    def __init__(self, folder: Path) -> None:
        self._file = tempfile.TemporaryFile(dir=folder)  # noqa: SIM115 -- closed by __exit__

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._file.close()

    def add(self, profiles: CaseProfiles) -> None:
        """Keep the profiles of one more case."""
        np.save(self._file, profiles.x, allow_pickle=False)
        np.save(self._file, profiles.values, allow_pickle=False)

    def __iter__(self) -> Iterator[CaseProfiles]:
        """Iterate over the profiles in the order in which they were added."""
        end = self._file.tell()
        self._file.seek(0)
        while self._file.tell() < end:
            x = np.load(self._file, allow_pickle=False)
            yield CaseProfiles(x, np.load(self._file, allow_pickle=False))


class Resampling:
    """From the cells of one case to other positions, along one direction.

    Parameters
    ----------
    nodes : numpy.ndarray, shape (n,)
        Cell centres in m, increasing; all positive for the quarter of a contact that is even.
    positions : numpy.ndarray, shape (m,)
        Where values are wanted, m.
    """

    def __init__(self, nodes: NDArray[np.float64], positions: NDArray[np.float64]) -> None:
        self._nodes = nodes
        self._positions = positions

    @property
    def is_outside(self) -> NDArray[np.bool_]:
        """Where a position lies beyond the last cell centre, shape (m,)."""
        outermost = float(np.abs(self._nodes).max())
        return np.asarray(np.abs(self._positions) > outermost * (1.0 + 1e-12))

    def linear(self, values: NDArray[Any], axis: int) -> NDArray[Any]:
        """Interpolate linearly; beyond the outermost cells the values there go on.

        Where a position is a cell centre, the value is that of the cell to the last bit. A
        quarter is even, so that nearer the middle than its first cell the value there goes on.

        Parameters
        ----------
        values : numpy.ndarray
            n values along `axis`.
        axis : int
            Which one.

        Returns
        -------
        numpy.ndarray
            m values along `axis`, type as given.
        """
        lower, weight = self._places
        upper = np.minimum(lower + 1, self._nodes.size - 1)
        weight = weight.reshape([-1 if i == axis else 1 for i in range(values.ndim)])
        below, above = np.take(values, lower, axis), np.take(values, upper, axis)
        return np.asarray((1.0 - weight) * below + weight * above).astype(values.dtype)

    def nearest(self, values: NDArray[Any], axis: int) -> NDArray[Any]:
        """Take the value of the nearest cell; arguments as for `linear`."""
        lower, weight = self._places
        return np.take(values, lower + (weight >= 0.5), axis)

    @cached_property
    def _places(self) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
        """Cell below each position, and how far the position is on the way to the next."""
        nodes = self._nodes
        where = np.abs(self._positions) if nodes[0] > 0.0 else self._positions
        lower = np.clip(np.searchsorted(nodes, where, side="right") - 1, 0, nodes.size - 2)
        weight = (where - nodes[lower]) / (nodes[lower + 1] - nodes[lower])
        return lower, np.clip(weight, 0.0, 1.0)


NOT_DONE = -1
"""What ``contact_state`` is at points and cycles that are not there; other fields are NaN."""

_CHUNK_BYTES = 32 << 20


def open_study(path: str | PathLike[str]) -> xr.Dataset:
    """Open the merged study together with the fields of all its cases.

    Fields are dask arrays that read one case at a time, so a reduction over any number of cases
    needs little memory: ``open_study("results/demo").wear_depth.max(("x", "y")).compute()``.
    They are brought to the cells of the finest case, in the largest window, by interpolation
    (none where all cases have one grid spacing; ``contact_state`` is that of the nearest cell).
    Outside the window of a case nothing touches and the gap is NaN.

    Parameters
    ----------
    path : str or path-like
        Folder of the results of a study, with ``summary.nc`` and the folder ``cases``.

    Returns
    -------
    xarray.Dataset
        The merged study and every field, dimensions (…, ``cycle``, ``x``, ``y``). Fields are NaN
        (``contact_state`` is `NOT_DONE`) where a point is not done or has no such snapshot.

    Raises
    ------
    DataFileError
        When the merged study or one of its case files is missing or damaged.
    """
    folder = Path(path)
    summary = open_summary(folder / "summary.nc")
    files = np.full(summary["status"].shape, None)
    done = summary["status"].to_numpy() == PointStatus.DONE
    for position in zip(*np.nonzero(done), strict=True) if files.ndim else ((),):
        files[position] = folder / "cases" / f"{summary[CASE_ID.name].to_numpy()[position]}.nc"
    x = summary[X.name].to_numpy()
    y = _common_y([file for file in files.ravel() if file is not None])
    dims = (*summary["status"].dims, CYCLE.name, X.name, Y.name)
    stacked = summary.assign_coords({Y.name: xr.Variable((Y.name,), y, Y.attributes)})
    for field in FIELDS:
        array = StackedField(files, field, summary[CYCLE.name].to_numpy(), x, y)
        lazy = xr.Variable(dims, indexing.LazilyIndexedArray(array), field.attributes)
        stacked[field.name] = lazy.chunk(dict(zip(dims, array.chunks, strict=True)))
    stacked.set_close(summary.close)
    return stacked


class StackedField(BackendArray):
    """One field of all cases as one array; every access reads from the case files.

    Parameters
    ----------
    files : numpy.ndarray of pathlib.Path or None
        Case files, laid out as the points of the study; None where a point is not done.
    field : Field
        The field.
    cycles, x, y : numpy.ndarray
        Cycles, and positions in m, that all cases share.
    """

    def __init__(
        self,
        files: NDArray[Any],
        field: Field,
        cycles: NDArray[np.float64],
        x: NDArray[np.float64],
        y: NDArray[np.float64],
    ) -> None:
        self.files = files
        self.field = field
        self.cycles = cycles
        self.x = x
        self.y = y
        self.shape = (*files.shape, cycles.size, x.size, y.size)
        self.dtype = np.dtype(field.dtype)

    @property
    def chunks(self) -> tuple[int, ...]:
        """Sizes of pieces: one case, and as many cycles of it as make a reasonable piece."""
        cycle_bytes = self.x.size * self.y.size * self.dtype.itemsize
        cycles = min(self.cycles.size, max(1, _CHUNK_BYTES // cycle_bytes))
        return (*(1 for _ in self.files.shape), cycles, self.x.size, self.y.size)

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        """Read a part, as xarray asks for it."""
        return indexing.explicit_indexing_adapter(
            key, self.shape, indexing.IndexingSupport.BASIC, self._read
        )

    def _read(self, key: tuple[int | slice, ...]) -> NDArray[Any]:
        points = self.files.ndim
        files = np.asarray(self.files[key[:points]], dtype=object)
        cycles = np.atleast_1d(self.cycles[key[points]])
        missing = NOT_DONE if self.field.flags else np.nan
        shape = (*files.shape, cycles.size, self.x.size, self.y.size)
        values = np.full(shape, missing, dtype=self.dtype)
        for position in np.ndindex(files.shape):
            if files.item(position) is not None:
                self._read_case(files.item(position), cycles, values[position])
        cycle_key = 0 if isinstance(key[points], int | np.integer) else slice(None)
        return values[(*(slice(None) for _ in files.shape), cycle_key, *key[points + 1 :])]

    def _read_case(self, path: Path, cycles: NDArray[np.float64], into: NDArray[Any]) -> None:
        # The netCDF library must not be used by two threads, opening included.
        with NETCDF4_PYTHON_LOCK, netCDF4.Dataset(path) as file:
            file.set_auto_mask(False)
            stored = file[CYCLE.name][:]
            snapshots = {
                place: file[self.field.name][int(np.searchsorted(stored, cycle))]
                for place, cycle in enumerate(cycles)
                if cycle in stored
            }
            along_x = Resampling(file[X.name][:], self.x)
            along_y = Resampling(file[Y.name][:], self.y)
        for place, values in snapshots.items():
            into[place] = self._resampled(values, along_x, along_y)

    def _resampled(
        self, values: NDArray[Any], along_x: Resampling, along_y: Resampling
    ) -> NDArray[Any]:
        if self.field.flags:
            resampled = along_y.nearest(along_x.nearest(values, 0), 1)
        else:
            resampled = along_y.linear(along_x.linear(values, 0), 1)
        outside = np.logical_or.outer(along_x.is_outside, along_y.is_outside)
        resampled[outside] = self.field.outside
        return resampled


def _common_y(files: list[Path]) -> NDArray[np.float64]:
    reaches = []
    for file in files:
        with opened_case(file) as case_file:
            is_whole = case_file.attribute("symmetry") == "none"
            reaches.append(Reach.of_case(case_file.read(Y.name), is_whole))
    return reduce(Reach.joined, reaches).positions()
