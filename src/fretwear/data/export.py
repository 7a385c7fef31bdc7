"""Datasets in files of other programs: tables, meshes of VTK, loads for Abaqus, heights."""

from __future__ import annotations

import hashlib
import io
import math
import tempfile
import zipfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from fretwear.data.atomic import atomic_path, write_text
from fretwear.results import CYCLE, DEPTH, PHASE, POINT, X, Y
from fretwear.units import cycle_text, listed

if TYPE_CHECKING:
    import pandas as pd

_SPACE = (X.name, Y.name, DEPTH.name)
_STEPS = (CYCLE.name, PHASE.name)


class ExportError(ValueError):
    """A dataset cannot be written in another format; the message says why and what to do."""


def at_cycle(ds: xr.Dataset, cycle: float) -> xr.Dataset:
    """The dataset of one snapshot of a case; `ExportError` if there is none of this cycle."""
    stored = np.atleast_1d(ds[CYCLE.name].values).tolist()
    if cycle not in stored:
        there = listed([cycle_text(stored_cycle) for stored_cycle in stored])
        raise ExportError(f"cycle {cycle_text(cycle)} is not a snapshot; there are {there}")
    return ds.sel({CYCLE.name: [cycle]}) if CYCLE.name in ds.dims else ds


def write_tables(ds: xr.Dataset, path: Path) -> list[Path]:
    """Write tables, one for all variables of the same dimensions: ``OUT-cycle-x-y.csv``.

    The header has names and SI units, ``pressure (Pa)``; the last dimension varies fastest. In text
    positions have 15 digits, other numbers as many as their precision needs; ``.parquet`` has all.
    pandas needs pyarrow or fastparquet for it; `ExportError` without them.
    """
    written = []
    for dims, frame in _tables(ds):
        target = path.with_name(f"{path.stem}-{'-'.join(dims)}{path.suffix}")
        written.append(target)
        with atomic_path(target) as temporary:
            if path.suffix == ".csv":
                for name in frame.columns[: len(dims)]:
                    if frame[name].dtype.kind == "f":
                        frame[name] = frame[name].map("{:.15g}".format)
                frame.to_csv(temporary, index=False, lineterminator="\n")
                continue
            try:
                frame.to_parquet(temporary, index=False)
            except ImportError as error:
                reason = "parquet files take the library pyarrow: pip install pyarrow"
                raise ExportError(reason) from error
    return written


def _tables(ds: xr.Dataset) -> Iterator[tuple[tuple[str, ...], pd.DataFrame]]:
    """Yield a table for all variables of the same dimensions; these are its first columns."""
    tables: dict[tuple[str, ...], list[str]] = {}
    for name, variable in ds.data_vars.items():
        if variable.dims and variable.dtype.kind in "fiub":
            tables.setdefault(tuple(map(str, variable.dims)), []).append(str(name))
    for dims, names in tables.items():
        # Coordinates along one of the dimensions stand beside the variables.
        coordinates = [str(n) for n, c in ds.coords.items() if c.dims and {*c.dims} <= {*dims}]
        table = ds[[*names, *coordinates]]
        table = table.drop_vars([name for name, c in table.coords.items() if not c.dims])
        units = {name: table[name].attrs.get("units", "1") for name in table.variables}
        titles = {n: f"{n} ({unit})" for n, unit in units.items() if unit not in ("", "1")}
        yield dims, table.to_dataframe(dim_order=dims).reset_index().rename(columns=titles)


def write_vtk(ds: xr.Dataset, path: Path) -> list[Path]:
    """Write fields for ParaView: cells or points for each cycle or phase, and ``OUT.pvd`` of all.

    Each file, ``.vtu``, has lines, quadrilaterals or hexahedra between the centres of cells, with
    the values there; z is the depth, downwards. `ExportError` without the library pyevtk, or if the
    dataset has no fields.
    """
    try:
        from pyevtk import hl, vtk
    except ImportError as error:
        reason = "VTK files take the library pyevtk: pip install 'fretwear[vtk]'"
        raise ExportError(reason) from error

    on_points = POINT.name in ds.dims
    space = (POINT.name,) if on_points else tuple(dim for dim in _SPACE if dim in ds.dims)
    step_dim = next((dim for dim in _STEPS if dim in ds.dims), "")
    fields = {
        str(name): field.transpose(..., *space)
        for name, field in ds.data_vars.items()
        if space and {*space} <= {*field.dims} <= {*space, step_dim}
    }
    if not fields:
        raise ExportError("the dataset has no fields on cells or points")
    places = [np.atleast_1d(ds[n].values) if n in ds.coords else np.zeros(1) for n in _SPACE]
    if not on_points:
        places = [*np.meshgrid(*places, indexing="ij")]
    points = [np.ascontiguousarray(np.ravel(place), np.float64) for place in places]
    corners, kind = _cells_between(places[0].shape)
    cells = (corners.ravel(), np.arange(1, len(corners) + 1) * corners.shape[1])
    kinds = np.full(len(corners), kind.tid, np.uint8)
    with tempfile.TemporaryDirectory(dir=path.parent) as folder:
        base = Path(folder, path.stem)
        collection = vtk.VtkGroup(str(base))
        for number, step in enumerate(ds[step_dim].values.tolist() if step_dim else [0.0]):
            data = {}
            for name, field in fields.items():
                now = field.isel({step_dim: number}) if step_dim in field.dims else field
                data[name] = np.ascontiguousarray(np.ravel(now.values))
            name = f"{base}-{number:04d}"
            collection.addFile(
                hl.unstructuredGridToVTK(name, *points, *cells, kinds, pointData=data), step
            )
        collection.save()
        written = [path.with_name(file.name) for file in sorted(base.parent.glob("*.vt?"))]
        for file in (*written, path):
            base.with_name(file.name).replace(file)
    return [*written, path]


def _cells_between(shape: tuple[int, ...]) -> tuple[NDArray[np.int64], Any]:
    """Return the corners of the cells of VTK between points of a shape, and their kind."""
    from pyevtk.vtk import VtkHexahedron, VtkLine, VtkQuad, VtkVertex

    number = np.arange(math.prod(shape)).reshape(shape)
    axes = [axis for axis, size in enumerate(shape) if size > 1] if len(shape) > 1 else []
    corners = number[..., None]
    for count, axis in enumerate(axes):
        near, far = (np.delete(corners, end, axis) for end in (-1, 0))
        # The second edge of a quadrilateral runs backwards; hexahedra have one above the other.
        far = far[..., ::-1] if count == 1 else far
        corners = np.concatenate([near, far], axis=-1)
    kind = (VtkVertex, VtkLine, VtkQuad, VtkHexahedron)[len(axes)]
    return corners.reshape(-1, corners.shape[-1]), kind


def write_abaqus(ds: xr.Dataset, path: Path) -> list[Path]:
    """Write the worn surface of the flat and its nodal forces at +Q as an input file of Abaqus.

    Nodes are the centres of cells; a point contact has surface elements between them, `SFM3D4`. The
    body lies below: the last coordinate is minus the worn depth, and forces are traction times the
    area of a cell, so that they add up to P and Q. A line contact is plane, with forces per length.
    The snapshot is the last one. `ExportError` if the dataset is not a case.
    """
    depth = "wear_depth_flat" if "wear_depth_flat" in ds else "wear_depth"
    if lacking := [n for n in (depth, "pressure", "shear_traction") if n not in ds]:
        raise ExportError(f"the dataset lacks {lacking[0]}: Abaqus takes the file of a case")
    last = ds.isel({CYCLE.name: -1})
    x, area = ds[X.name].values, float(np.diff(ds[X.name].values).mean())
    plane_strain = Y.name not in ds.dims
    y = np.zeros(1) if plane_strain else ds[Y.name].values
    area *= 1.0 if plane_strain else float(np.diff(y).mean())
    rows, columns = (axis.ravel() for axis in np.meshgrid(x, y, indexing="ij"))
    worn, pressure, shear = (
        np.asarray(last[name].values, np.float64).ravel()
        for name in (depth, "pressure", "shear_traction")
    )
    number = np.arange(1, rows.size + 1).reshape(x.size, y.size)
    places = [rows, -worn] if plane_strain else [rows, columns, -worn]
    body = "flat" if depth.endswith("flat") else "both bodies together"
    lines = [
        "*HEADING",
        f"{ds.attrs.get('case_id', 'contact')}, cycle {float(last[CYCLE.name]):g}: wear of {body}",
        "** SI units; nodes lie at the centres of cells",
        "*NODE, NSET=WORN",
        *_data_lines([number.ravel(), *places]),
    ]
    if not plane_strain:
        corners = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
        elements = np.arange(1, corners[0].size + 1)
        lines += ["*ELEMENT, TYPE=SFM3D4, ELSET=WORN"]
        lines += _data_lines([elements, *(axis.ravel() for axis in corners)])
    lines += ["*STEP", "*STATIC", "*CLOAD"]
    for direction, force in ((1, shear * area), (len(places), -pressure * area)):
        loaded = force != 0.0
        of_nodes = number.ravel()[loaded]
        lines += _data_lines([of_nodes, np.full(of_nodes.size, direction), force[loaded]])
    write_text(path, "\n".join([*lines, "*END STEP", ""]))
    return [path]


def write_x3p(ds: xr.Dataset, path: Path) -> list[Path]:
    """Write the heights of the worn flat, m, in a format of programs for measured surfaces.

    The heights are minus the wear depth at the last snapshot, upwards; the depth of both bodies
    together if the wear of the flat is unknown. `ExportError` without the library
    SurfaceTopography, or if the dataset has no map of wear.
    """
    try:
        from SurfaceTopography import Topography
    except ImportError as error:
        reason = "x3p files take SurfaceTopography: pip install 'fretwear[surfaces]'"
        raise ExportError(reason) from error
    depth = "wear_depth_flat" if "wear_depth_flat" in ds else "wear_depth"
    if depth not in ds or Y.name not in ds.dims:
        raise ExportError("an x3p file has a map of wear, as the file of a point contact has it")
    worn = ds[depth].isel({CYCLE.name: -1}).transpose(X.name, Y.name)
    sizes = [worn[name].size * float(np.diff(worn[name]).mean()) for name in worn.dims]
    heights = Topography(-worn.values.astype(np.float64), sizes, unit="m", periodic=False)
    archive = io.BytesIO()
    heights.to_x3p(archive, manufacturer="fretwear", model="fretwear")
    # SurfaceTopography writes the digest of the heights; ISO 25178-72 requires main.xml's.
    with zipfile.ZipFile(archive) as members:
        content = {name: members.read(name) for name in members.namelist()}
    digest = hashlib.md5(content["main.xml"], usedforsecurity=False).hexdigest()
    content["md5checksum.hex"] = f"{digest} *main.xml\n".encode()
    with atomic_path(path) as temporary, zipfile.ZipFile(temporary, "w") as members:
        for name, data in content.items():
            members.writestr(name, data, zipfile.ZIP_DEFLATED)
    return [path]


def _data_lines(columns: Iterable[NDArray[np.generic]]) -> list[str]:
    kept = (column.tolist() for column in columns)
    return [", ".join(f"{value:.9g}" for value in row) for row in zip(*kept, strict=True)]


WRITERS: Mapping[str, tuple[str, Callable[..., list[Path]]]] = {
    "csv": (".csv", write_tables),
    "parquet": (".parquet", write_tables),
    "vtk": (".pvd", write_vtk),
    "abaqus": (".inp", write_abaqus),
    "x3p": (".x3p", write_x3p),
}
"""Formats: the ending of the file that is named, and what writes it."""
