"""The merged study: scalars and profiles of all cases in one file with labelled dimensions."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from functools import reduce
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import netCDF4
import numpy as np
import xarray as xr
from numpy.typing import NDArray

from fretwear.data import provenance
from fretwear.data.atomic import atomic_path
from fretwear.data.casefile import CaseFile, opened_case
from fretwear.data.errors import CaseFileError, CaseFilesError, DataFileError
from fretwear.data.layout import StudyLayout
from fretwear.data.netcdf import open_lazily, plain_encoding
from fretwear.data.profiles import PROFILES, CaseProfiles, ProfileSpool, Reach
from fretwear.data.schema import CONVENTIONS
from fretwear.data.seal import damage, seal
from fretwear.data.uninterrupted import uninterrupted
from fretwear.data.variables import CYCLE, SCALARS, X

if TYPE_CHECKING:
    from fretwear.study.case import Case
    from fretwear.study.file import Study


class Status(IntEnum):
    """What became of a point of a study."""

    DONE = 0
    FAILED = 1
    INVALID = 2


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
    (…, cycle) of the cases, the profiles (…, cycle, x) of `fretwear.data.profiles.PROFILES`, the
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
    status = np.full(layout.shape, Status.INVALID, dtype=np.int8)
    found: list[_Found] = []
    for position, point in layout.points():
        if point.case is not None:
            file = Path(cases) / f"{point.id}.nc"
            status[position] = Status.DONE if file.exists() else Status.FAILED
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
        seal(temporary)
    counts = [int((status == kind).sum()) for kind in Status]
    return Tally(*counts)


def open_summary(path: str | PathLike[str]) -> xr.Dataset:
    """Open a merged study lazily.

    The file is read once to compare it with its checksum. Close the dataset, or use it in a
    ``with`` statement, to release the file.

    Raises
    ------
    DataFileError
        When the file is missing, unfinished, cut short or damaged.
    """
    if problem := damage(Path(path), "merged study"):
        raise DataFileError(Path(path), problem, "Merge the study again")
    return open_lazily(path)


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
        "flag_values": np.array(list(Status), dtype=np.int8),
        "flag_meanings": " ".join(kind.name.lower() for kind in Status),
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
            "source": provenance.source(),
            "history": provenance.history_line(command),
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
