"""Datasets written for other programs, read back without the library that wrote them."""

import csv
import hashlib
import re
import xml.etree.ElementTree as ElementTree
import zipfile
from importlib.util import find_spec

import numpy as np
import pytest

import fretwear
from fretwear.data.export import ExportError, write_abaqus, write_tables, write_vtk, write_x3p

from ..studies import line_contact, near, steel


@pytest.fixture(scope="module")
def worn():
    return fretwear.simulate(steel(cycles=100, cell="8 um", error_estimate=False))


@pytest.fixture(scope="module")
def line():
    return fretwear.simulate(steel(**line_contact("10 mm", "18 N/mm"), cycles=10))


def appended(path):
    """The arrays of a VTK file in XML whose data follow as raw bytes behind sizes of 8 bytes."""
    text = path.read_bytes()
    head, _, raw = text.partition(b'<AppendedData encoding="raw">')
    raw = raw[raw.index(b"_") + 1 :]
    kinds = {"Float64": "f8", "Float32": "f4", "Int8": "i1", "Int64": "i8", "UInt8": "u1"}
    for array in ElementTree.fromstring(head + b"</VTKFile>").iter("DataArray"):
        start = int(array.get("offset"))
        size = int(np.frombuffer(raw, "u8", 1, start)[0])
        kind = kinds.get(array.get("type"))
        if kind:
            yield array.get("Name"), np.frombuffer(raw[start + 8 : start + 8 + size], kind)


def test_paraview_gets_a_grid_for_each_snapshot(worn, tmp_path):
    *grids, collection = write_vtk(worn, tmp_path / "worn.pvd")
    steps = re.findall(r'timestep="([^"]*)".*?file="([^"]*)"', collection.read_text())
    assert [float(step) for step, _ in steps] == worn.cycle.values.tolist()
    assert [name for _, name in steps] == [grid.name for grid in grids]
    assert all(name.endswith(".vtu") for _, name in steps)  # meshio reads no other file of VTK
    last = dict(appended(grids[-1]))
    for name in ("pressure", "wear_depth", "gap"):
        np.testing.assert_array_equal(last[name], worn[name][-1].values.ravel())
    x, y, z = last["points"].reshape(-1, 3).T
    np.testing.assert_array_equal(x, np.repeat(worn.x, worn.sizes["y"]))
    assert not z.any()
    quads = last["connectivity"].reshape(-1, 4)
    assert {*last["types"].tolist()} == {9}
    np.testing.assert_array_equal(last["offsets"], 4 * np.arange(1, len(quads) + 1))
    # The shoelace formula: each has the area of a cell, so its edges run round it.
    ahead = np.roll(quads, -1, axis=1)
    areas = 0.5 * (x[quads] * y[ahead] - x[ahead] * y[quads]).sum(axis=1)
    np.testing.assert_allclose(areas, np.diff(worn.x)[0] * np.diff(worn.y)[0], rtol=1e-9)


def test_stresses_and_line_contacts_are_meshes_as_well(line, worn, tmp_path):
    write_vtk(line, tmp_path / "line.pvd")
    mesh = dict(appended(tmp_path / "line-0001.vtu"))
    assert mesh["connectivity"].reshape(-1, 2).tolist() == [
        [place, place + 1] for place in range(line.sizes["x"] - 1)
    ]
    box = worn.pressure[-1].expand_dims(z=[1e-6, 2e-6]).to_dataset()
    write_vtk(box, tmp_path / "box.pvd")
    mesh = dict(appended(tmp_path / "box-0000.vtu"))
    corners = mesh["points"].reshape(-1, 3)[mesh["connectivity"].reshape(-1, 8)]
    assert {*mesh["types"].tolist()} == {12}
    edges = [corners[:, end] - corners[:, 0] for end in (1, 3, 4)]
    volumes = np.einsum("ki,ki->k", np.cross(edges[0], edges[1]), edges[2])
    cell = np.diff(worn.x)[0] * np.diff(worn.y)[0] * 1e-6
    np.testing.assert_allclose(np.abs(volumes), cell, rtol=1e-9)
    ends = corners.max(axis=1) - corners.min(axis=1)
    np.testing.assert_allclose(ends.prod(axis=1), cell, rtol=1e-9)


def test_a_dataset_without_fields_is_refused(worn, tmp_path):
    with pytest.raises(ExportError, match="no fields"):
        write_vtk(worn[["wear_volume"]].drop_dims(["x", "y"], errors="ignore"), tmp_path / "a.pvd")
    with pytest.raises(ExportError, match="lacks wear_depth"):
        write_abaqus(worn.drop_vars("wear_depth"), tmp_path / "a.inp")
    assert not [*tmp_path.iterdir()]


def test_tables_have_units_and_every_value(line, tmp_path):
    line = line.assign(wears=(("cycle", "x"), line.wear_depth.values > 0.0))
    written = {path.name: path for path in write_tables(line, tmp_path / "line.csv")}
    assert written.keys() >= {"line-cycle-x.csv", "line-cycle.csv"}
    with written["line-cycle-x.csv"].open(newline="") as stream:
        head, *rows = csv.reader(stream)
    assert head[:2] == ["cycle", "x (m)"]
    assert "pressure (Pa)" in head
    assert {"contact_state", "wears"} < {*head}
    values = np.array([row[head.index("pressure (Pa)")] for row in rows], dtype=float)
    np.testing.assert_array_equal(values.astype("f4"), line.pressure.values.ravel())
    # Positions are read back, although 15 digits are shorter than 17.
    places = [row[head.index("x (m)")] for row in rows[: line.sizes["x"]]]
    np.testing.assert_allclose(np.array(places, float), line.x, rtol=1e-15, atol=0.0)
    assert any(len(repr(float(place))) > 20 for place in line.x)
    assert max(map(len, places)) < 20


def test_tables_of_parquet_have_every_bit(line, tmp_path):
    pd = pytest.importorskip("pandas")
    if not any(find_spec(name) for name in ("pyarrow", "fastparquet")):
        with pytest.raises(ExportError, match="pip install pyarrow"):
            write_tables(line, tmp_path / "line.parquet")
        assert not [*tmp_path.iterdir()]
        return
    written = {path.name: path for path in write_tables(line, tmp_path / "line.parquet")}
    table = pd.read_parquet(written["line-cycle-x.parquet"])
    np.testing.assert_array_equal(table["pressure (Pa)"], line.pressure.values.ravel())
    np.testing.assert_array_equal(table["x (m)"][: line.sizes["x"]], line.x)


def blocks(path):
    """Data lines of an input file of Abaqus by their keyword."""
    found = {}
    for row in path.read_text().splitlines():
        if row.startswith("*"):
            keyword = row.split(",")[0]
        else:
            found.setdefault(keyword, []).append([each.strip() for each in row.split(",")])
    return {name: np.array(rows) for name, rows in found.items() if name != "*HEADING"}


def test_abaqus_gets_the_worn_profile_and_forces_that_balance_the_load(worn, line, tmp_path):
    (file,) = write_abaqus(worn, tmp_path / "worn.inp")
    found = blocks(file)
    nodes, loads = found["*NODE"].astype(float), found["*CLOAD"].astype(float)
    assert nodes[:, 3].min() == near(-float(worn.wear_depth[-1].max()), rel=1e-6)
    elements = found["*ELEMENT"].astype(int)
    assert len(elements) == (worn.sizes["x"] - 1) * (worn.sizes["y"] - 1)
    first = nodes[elements[0, 1:] - 1][:, 1:3]
    (along, _), (_, across) = first[1] - first[0], first[2] - first[1]
    cells = float(worn.x[1] - worn.x[0]), float(worn.y[1] - worn.y[0])
    assert (along, across) == near(cells, rel=1e-6)
    for direction, force in ((1, 20.0), (3, -50.0)):
        assert loads[loads[:, 1] == direction, 2].sum() == near(force, rel=2e-3)
    (file,) = write_abaqus(line, tmp_path / "line.inp")
    loads = blocks(file)["*CLOAD"].astype(float)
    assert loads[loads[:, 1] == 2, 2].sum() == near(-18e3, rel=2e-3)


def test_programs_for_surfaces_read_the_heights_of_the_worn_flat(worn, tmp_path):
    surfaces = pytest.importorskip("SurfaceTopography")
    (file,) = write_x3p(worn, tmp_path / "worn.x3p")
    read = surfaces.read_topography(str(file)).to_unit("m")
    depth = worn.wear_depth.isel(cycle=-1).transpose("x", "y").values
    np.testing.assert_allclose(-read.heights(), depth, rtol=1e-6, atol=1e-6 * depth.max())
    cells = [size / number for size, number in zip(read.physical_sizes, depth.shape, strict=True)]
    assert cells == near([8e-6, 8e-6])
    with zipfile.ZipFile(file) as archive:
        digest, name = archive.read("md5checksum.hex").decode().split()
        assert digest == hashlib.md5(archive.read("main.xml")).hexdigest()
    assert name.strip("*") == "main.xml"


@pytest.mark.slow
@pytest.mark.parametrize("module", ["x3pio", "surfalize"])
def test_readers_that_check_the_digest_read_the_worn_flat(worn, tmp_path, module):
    reader = pytest.importorskip(module)
    skewed = worn.wear_depth * (1.0 + (worn.x + 2.0 * worn.y) / 1e-3)
    (file,) = write_x3p(worn.assign(wear_depth=skewed), tmp_path / "worn.x3p")
    if module == "x3pio":
        heights = reader.read(file).layers[0].z
    else:
        heights = 1e-6 * reader.Surface.load(file).data  # µm
    depth = skewed.isel(cycle=-1).transpose("y", "x").values
    np.testing.assert_allclose(-heights, depth, atol=1e-6 * depth.max())
