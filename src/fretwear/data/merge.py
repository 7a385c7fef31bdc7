"""A study as one dataset: where its points stand, and its case files merged into one."""

from __future__ import annotations

import json
import math
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, NamedTuple

import netCDF4
import numpy as np
from numpy.typing import NDArray

from fretwear.data.files import (
    COMPRESSION,
    HISTORY_GROUP,
    READS_BACK,
    check_attributes,
    check_group,
    new_netcdf,
    opened_case,
    write_group,
)
from fretwear.data.labels import CONVENTIONS, Column, history_line
from fretwear.data.safe import (
    CaseFileError,
    CaseFilesError,
    DataFileError,
    atomic_path,
    remove_stale_temporaries,
)
from fretwear.data.stack import (
    Window,
    common_positions,
    missing,
    positions_inside,
    resampled,
)
from fretwear.version import code_digest
from fretwear.vocabulary import (
    CASE_ID,
    CODE_DIGEST,
    CYCLE,
    FIELDS,
    HEADLINES,
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

_HISTORIES = (CYCLE.name, *HEADLINES, "tangential_force")
_MOST_SOURCES = 10
_OTHER_CODE = "it was computed by another version of the code (its code_digest differs)"
_KEEP_OR_RUN = "Run the case again, or keep it with --keep-older"


@dataclass(frozen=True)
class StudyLayout:
    """The place of each point of a study in a merged dataset.

    A grid has one dimension for each varied name, in the order of the study. Every other design
    has the one dimension ``point``, with the varied values along it.
    """

    study: Study

    @property
    def is_grid(self) -> bool:
        """Whether the points are all combinations of the varied values."""
        return self.study.design.kind == "grid" or not self.study.axes

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the dimensions."""
        return tuple(self._axes) if self.is_grid else (POINT.name,)

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the dimensions."""
        return self.study.shape if self.study.axes else ()

    def points(self) -> Iterator[tuple[tuple[int, ...], Point]]:
        """Iterate over the points, each with its position along the dimensions."""
        for number, point in enumerate(self.study.points()):
            yield (point.index if self.is_grid else (number,)), point

    def coordinates(self) -> dict[str, Column]:
        """Coordinates: varied values, case ids, and the parameters that all cases share.

        Varied values that are not single numbers (a roughness, a pair of moduli) are text, as
        written in the study file.
        """
        found = {name: self._varied(axis) for name, axis in self._axes.items()}
        if not self.is_grid:
            numbers = np.arange(*self.shape, dtype=POINT.dtype)
            found[POINT.name] = Column((POINT.name,), numbers, POINT.attributes)
        ids = np.full(self.shape, "", dtype=object)
        for position, point in self.points():
            ids[position] = point.id
        found[CASE_ID.name] = Column(self.dims, ids.astype(str), CASE_ID.attributes)
        for name, each in self._parameters.items():
            if not each.dims:  # a varied parameter of one value only is known by now
                found.setdefault(name, each)
        return found

    def dependent(self) -> dict[str, Column]:
        """Parameters that depend on the varied ones, as the Hertz radius does on the load.

        They have the dimensions of the study, with NaN or empty text where a point has none.
        """
        varied = {axis.coordinate for axis in self.study.axes}
        return {
            name: each
            for name, each in self._parameters.items()
            if each.dims and name not in varied
        }

    @property
    def _axes(self) -> dict[str, Axis]:
        return {axis.coordinate: axis for axis in self.study.axes}

    @cached_property
    def _parameters(self) -> dict[str, Column]:
        """Every parameter of the cases: a scalar where they share it, else along the points."""
        cases = {place: point.case for place, point in self.points() if point.case is not None}
        labels: dict[str, Variable] = {}
        columns: dict[str, dict[tuple[int, ...], Any]] = {}
        for place, case in cases.items():
            for name, (value, units, long_name) in case.scalar_coordinates().items():
                is_text = isinstance(value, str)
                labels.setdefault(name, Variable(name, "" if is_text else units, words=long_name))
                columns.setdefault(name, {})[place] = value
        found = {}
        for name, given in columns.items():
            is_text = any(isinstance(value, str) for value in given.values())
            dims: tuple[str, ...] = ()
            if len(given) == len(cases) and len(set(given.values())) == 1:
                values = np.array(next(iter(given.values())), dtype=str if is_text else np.float64)
            else:
                dims, values = self.dims, np.full(self.shape, "" if is_text else math.nan, object)
                for place, value in given.items():
                    values[place] = value
                values = values.astype(str if is_text else np.float64)
            found[name] = Column(dims, values, labels[name].attributes)
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


@dataclass(frozen=True)
class Tally:
    """Numbers of done, failed and invalid points of a study, and a remark on older ones."""

    done: int
    failed: int
    invalid: int
    older: str = ""


class _Done(NamedTuple):
    """A point whose case file exists."""

    position: tuple[int, ...]
    case: Case
    path: Path


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
        Whether cases computed by other code are merged too, rather than refused.

    Raises
    ------
    CaseFilesError
        If case files are damaged or belong to other cases or code; all are named, nothing is
        written.
    DataFileError
        If no case is done, or the file cannot be written.
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
    with suppress(OSError):
        # What a power failure has left beside cases that are done: nobody writes these again.
        remove_stale_temporaries(Path(cases))
    with (
        atomic_path(Path(path)) as temporary,
        # Opening every case file again, once the common positions are known, would take longer than
        # anything else: the profiles are kept on disk, in an unnamed file.
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

    The dataset has the coordinate ``x`` common to all cases, and the code that computed each; the
    number is the length of the longest history.
    """
    digests, sources = np.full(layout.shape, "", dtype=object), set()
    snapshots = (case.output_cycles for case in layout.study.cases().values())
    cycles = np.unique(np.concatenate([*snapshots])).astype(np.float64)
    known = LINE_SCALARS if done[0].case.indenter.is_line else SCALARS
    # Errors are not estimated in every case.
    scalars = {each.name: each for each in (*known, *(scalar.error for scalar in known))}
    values: dict[str, NDArray[np.float64]] = {}
    windows, errors, most_steps = set(), [], 0
    for position, case, path in done:
        try:
            with opened_case(path) as file:
                if file.attribute("case_id") != case.case_id:
                    raise file.unusable(f"it holds another case, {file.attribute('case_id')}")
                stored, wanted = file.read(CYCLE.name), np.array(case.output_cycles, np.float64)
                if lacking := sorted(set(wanted) - set(stored)):
                    numbers = ", ".join(f"{cycle:.0f}" for cycle in lacking)
                    raise file.unusable(f"it has no snapshot at cycle {numbers}")
                at, columns = np.searchsorted(stored, wanted), np.searchsorted(cycles, wanted)
                digests[position] = digest = file.attribute(CODE_DIGEST.name)
                if digest != code_digest() and not keep_older:
                    raise CaseFileError(path, _OTHER_CODE, _KEEP_OR_RUN)
                sources.add(file.attribute("source"))
                for name in scalars.keys() & file.file.variables.keys():
                    if not np.isfinite(own := file.read(name)[at]).all():
                        raise file.unusable(f"{name} holds values that are not finite")
                    if name not in values:
                        values[name] = np.full((*layout.shape, cycles.size), math.nan)
                    values[name][position][columns] = own
                windows.add(Window.of(file, X.name))
                row: tuple[Any, ...] = np.s_[:, :]
                if not file.is_line:
                    row = np.s_[:, :, int(np.abs(file.read(Y.name)).argmin())]
                profiles = [file.read(field.name, row)[at] for field in PROFILES.values()]
                history = np.stack([file.read(f"{HISTORY_GROUP}/{name}") for name in _HISTORIES])
                for each in (file.read(X.name), history, *profiles):
                    np.save(spool, each, allow_pickle=False)
                most_steps = max(most_steps, history.shape[1])
        except CaseFileError as error:
            errors.append(error)
    if errors:
        raise CaseFilesError(errors)
    of_cases = digests[status == PointStatus.DONE].tolist()
    older = [digest or "missing" for digest in of_cases if digest != code_digest()]
    were = f"case{'s' * (len(of_cases) > 1)} {'was' if len(older) == 1 else 'were'}"
    words = (
        f"{len(older)} of {len(of_cases)} {were} computed by another version of the code: "
        f"their code_digest is {', '.join(sorted(set(older)))}, not {code_digest()}"
    )
    # Reading just the layout of a study must not import xarray.
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
                name: (dims, values[name], scalar.attributes)
                for name, scalar in scalars.items()
                if name in values
            },
        },
        {
            **layout.coordinates(),
            CYCLE.name: (CYCLE.name, cycles, CYCLE.attributes),
            X.name: (X.name, common_positions(windows), X.attributes),
        },
        {
            "source": "; ".join(sorted(sources)[:_MOST_SOURCES]),
            CODE_DIGEST.name: code_digest(),
            "warnings": words if older else "",
        },
    )
    return dataset, most_steps


def _write(
    path: Path, dataset: xr.Dataset, done: Sequence[_Done], spool: IO[bytes], steps: int
) -> None:
    """Write a dataset to a new file, profiles and histories from the spool, one case at a time.

    All of it is read back: where memory is short the netCDF library may leave something out.
    """
    points = tuple(str(dim) for dim in dataset[STATUS.name].dims)
    sizes = {**dataset.sizes, STEP.name: steps}
    names = {*points, CYCLE.name, X.name}
    beside = " ".join(sorted(str(name) for name in dataset.coords if name not in names))
    large: dict[str, tuple[tuple[str, ...], str, float, dict[str, Any]]] = {}
    for name, field in PROFILES.items():
        outside = "zero outside the window of the case, where the surfaces do not touch"
        comments = (
            field.comment,
            "on the line of cells nearest y = 0",
            "of the nearest cell" if field.flags else "interpolated linearly between the cells",
            "NaN outside the window of the case" if math.isnan(field.outside) else outside,
        )
        comment = "; ".join(filter(None, comments))
        attributes = {**field.attributes, "comment": comment, "coordinates": beside}
        large[name] = (CYCLE.name, X.name), field.dtype, missing(field), attributes
    told = (RESULTS[n].in_units(dataset[n].attrs["units"]) for n in _HISTORIES[1:])
    for each in (CYCLE, *told):
        large[f"{HISTORY_GROUP}/{each.name}"] = (STEP.name,), "f8", math.nan, each.attributes
    each_point = sum(math.prod(sizes[dim] for dim in dims) for dims, *_ in large.values())
    with new_netcdf(path, dataset.nbytes + 8 * dataset[STATUS.name].size * each_point) as file:
        for dim in (*points, CYCLE.name, X.name, STEP.name):
            owner = file.createGroup(HISTORY_GROUP) if dim == STEP.name else file
            owner.createDimension(dim, sizes[dim])
        for name, (dims, dtype, empty, attributes) in large.items():
            chunk = (*(1 for _ in points), *(sizes[dim] for dim in dims))
            variable = file.createVariable(
                name, dtype, (*points, *dims), chunksizes=chunk, fill_value=empty, **COMPRESSION
            )
            variable.setncatts(attributes)
        for name, where, values in _rows(dataset, done, spool):
            file[name][where] = values
        write_group(file, dataset)
    with netCDF4.Dataset(path) as file:
        file.set_auto_maskandscale(False)
        check_group(file, dataset)
        for name, (_, _, _, attributes) in large.items():
            check_attributes(file[name], attributes)
        for name, where, values in _rows(dataset, done, spool):
            if file[name][where].tobytes() != values.tobytes():
                raise RuntimeError(READS_BACK)


def _rows(
    dataset: xr.Dataset, done: Sequence[_Done], spool: IO[bytes]
) -> Iterator[tuple[str, Any, NDArray[Any]]]:
    """Yield each history and each profile of each case: its name, where it belongs, its values."""
    cycles, positions = dataset[CYCLE.name].to_numpy(), dataset[X.name].to_numpy()
    spool.seek(0)
    for point in done:
        columns = np.searchsorted(cycles, point.case.output_cycles)
        cells, history = np.load(spool), np.load(spool)
        for name, values in zip(_HISTORIES, history, strict=True):
            yield f"{HISTORY_GROUP}/{name}", (*point.position, slice(0, values.size)), values
        inside = positions_inside(cells, positions)
        for name, field in PROFILES.items():
            values = np.full((cycles.size, positions.size), missing(field), dtype=field.dtype)
            values[columns] = field.outside
            own = resampled(np.load(spool), cells, positions[inside], axis=1)
            values[np.ix_(columns, inside)] = own
            yield name, point.position, values
