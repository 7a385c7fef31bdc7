"""Files that are complete or absent, and open with older and newer versions."""

import re

import h5py
import netCDF4
import numpy as np
import pytest
import xarray as xr

from fretwear.data.atomic import DataFileError, atomic_path
from fretwear.data.files import (
    _storage,
    finished_by,
    open_case,
    open_history,
    open_loops,
    reading,
    write_case,
    write_groups,
)
from fretwear.data.groups import without_text
from fretwear.results import FIELDS


@pytest.fixture
def changed(case_path):
    """Change a case file with the netCDF library."""

    def change(edit):
        with netCDF4.Dataset(case_path, "a") as file:
            edit(file)
        return case_path

    return change


def test_a_case_comes_back_as_it_was_written_also_from_a_copy(results, tmp_path):
    path, copy = tmp_path / "a.nc", tmp_path / "b.nc"
    write_case(results.dataset, results.history, path, results.loops, {"license": "CC0-1.0"})
    with open_case(path) as dataset, open_history(path) as history, open_loops(path) as loops:
        xr.testing.assert_equal(dataset.load(), results.dataset)
        assert dataset.attrs == {**results.dataset.attrs, "license": "CC0-1.0"}
        for name, variable in results.dataset.variables.items():
            assert dataset[name].dtype.kind == variable.dtype.kind
            assert dataset[name].attrs.keys() == variable.attrs.keys()
        xr.testing.assert_identical(history.load(), results.history)
        xr.testing.assert_identical(loops.load(), results.loops)
        write_case(dataset, history, copy)
        with open_case(copy) as again:
            xr.testing.assert_identical(again.load(), dataset)


def test_groups_are_those_that_xarray_writes_one_by_one(results, tmp_path):
    texts = xr.Dataset({"warnings": ("point", ["shear exceeds µp", ""]), "title": "Größe"})
    groups = {"": results.dataset, "history": results.history, "loop": results.loops, "text": texts}
    write_groups(tmp_path / "once.nc", groups)
    for name, labelled in groups.items():
        content = without_text(labelled)
        encoding = {n: {**_storage(v)} for n, v in content.variables.items()}
        for n, each in encoding.items():
            each["_FillValue"] = each.pop("fill_value")
            each |= {"dtype": "S1"} if content[n].dtype.kind == "U" else {}
        place = {"path": tmp_path / "each.nc", "mode": "a" if name else "w", "group": name or None}
        content.drop_encoding().to_netcdf(**place, engine="netcdf4", encoding=encoding)
        stored = [xr.load_dataset(tmp_path / file, group=name) for file in ("once.nc", "each.nc")]
        xr.testing.assert_identical(*stored)
        for variable in stored[0].variables:
            once, each = (file[variable].encoding for file in stored)
            assert repr({**once, "source": ""}) == repr({**each, "source": ""})  # with NaN


def test_a_dataset_that_xarray_saves_is_a_case_with_its_snapshots_as_history(results, tmp_path):
    path = tmp_path / "saved.nc"
    results.dataset.to_netcdf(path)
    with open_case(path) as dataset, open_history(path) as history:
        xr.testing.assert_equal(dataset.load(), results.dataset)
        np.testing.assert_array_equal(history.wear_volume, dataset.wear_volume)


def test_fields_are_read_when_used_and_stored_one_cycle_to_a_checked_chunk(case_path):
    with open_case(case_path, full=True) as dataset:
        assert not any(dataset[field.name].variable._in_memory for field in FIELDS)
    with open_case(case_path) as dataset:
        for field in FIELDS:
            encoding = dataset[field.name].encoding
            assert encoding["chunksizes"] == (1, *dataset[field.name].shape[1:])
        assert not [name for name in dataset.coords if "_FillValue" in dataset[name].encoding]


def unreadable(file):
    """What stops iris, cfdm, Octave or a virtual store of Zarr at the file, by name."""
    texts = {name for name, stored in file.variables.items() if stored.dtype in (str, "S1")}
    for name, stored in file.variables.items():
        if texts & {*getattr(stored, "coordinates", "").split()}:
            yield f"{name} has coordinates of text"
        if name in texts and (stored.dtype is str or name in stored.dimensions):
            yield f"{name} is text along itself, or of variable length"
        # numcodecs cannot undo it after a shuffle of doubles.
        if stored.filters()["fletcher32"]:
            yield f"{name} has a checksum of HDF5"
    for name, group in file.groups.items():
        yield from (f"{name}/{problem}" for problem in unreadable(group))


def test_no_program_is_stopped_by_the_text_or_the_checksums_of_a_file(case_path, results):
    with netCDF4.Dataset(case_path) as file:
        assert [*unreadable(file)] == []
        assert file.slip_model == results.dataset.slip_model.item()
        assert all(each.filters()["zlib"] for each in file.variables.values() if each.size > 300)


@pytest.mark.filterwarnings("ignore:Dataset has no geotransform")
def test_a_raster_has_x_downwards_in_metres(case_path, results):
    """In QGIS too, which reads by GDAL. Without marked axes x is upwards, and cells are of 1."""
    rasterio = pytest.importorskip("rasterio", reason="GDAL: every night")
    depth = results.dataset["wear_depth"][-1]
    with rasterio.open(f"netcdf:{case_path}:wear_depth") as raster:
        np.testing.assert_array_equal(raster.read(raster.count), depth)
        width, height = (2 * float(depth[name][0]) for name in ("y", "x"))
        assert (raster.transform.a, raster.transform.e) == pytest.approx((width, height))


def test_paraview_bends_marked_axes_onto_a_sphere_unless_told_otherwise(case_path, results):
    """Otherwise it has y to the right, x upwards and the cycle as height."""
    vtk = pytest.importorskip("vtk", reason="ParaView's reader: every night")
    bounds = []
    for is_spherical in (True, False):
        reader = vtk.vtkNetCDFCFReader()
        reader.SetFileName(str(case_path))
        reader.SetSphericalCoordinates(is_spherical)
        reader.UpdateMetaData()
        reader.SetDimensions("(cycle, x, y)")
        reader.Update()
        bounds.append(reader.GetOutputDataObject(0).GetBounds())
    ends = [float(results.dataset[name][end]) for name in ("y", "x", "cycle") for end in (0, -1)]
    assert bounds[1] == pytest.approx(ends)
    assert bounds[0] != pytest.approx(ends)


def test_a_file_of_the_format_with_text_as_coordinates_opens(results, tmp_path):
    path = tmp_path / "older.nc"
    older = results.dataset.assign_attrs(format_version=2)
    older = older.assign_coords(case_id=("case_id", [older.attrs["case_id"]]))
    encoding = {"slip_model": {"dtype": "S1"}, "case_id": {"dtype": "S1"}}
    older.to_netcdf(path, encoding=encoding)
    with netCDF4.Dataset(path) as file:
        assert [*unreadable(file)]
    with open_case(path) as dataset:
        xr.testing.assert_equal(dataset.load(), results.dataset)


def test_the_whole_contact_is_four_quarters(case_path):
    with open_case(case_path) as quarter, open_case(case_path, full=True) as whole:
        assert (quarter.attrs["symmetry"], whole.attrs["symmetry"]) == ("even_xy", "none")
        nx, ny = quarter.sizes["x"], quarter.sizes["y"]
        np.testing.assert_array_equal(whole.x, -whole.x[::-1])
        for field in FIELDS:
            values = whole[field.name].values
            np.testing.assert_array_equal(values[:, nx:, ny:], quarter[field.name])
            np.testing.assert_array_equal(values, values[:, ::-1, :])
            np.testing.assert_array_equal(values, values[:, :, ::-1])
        xr.testing.assert_equal(whole.wear_volume, quarter.wear_volume)


def test_a_version_that_knows_one_more_scalar_and_one_that_knows_one_less_read_the_file(
    changed, results, case
):
    """An older file lacks a scalar, a newer one has one more; both are finished cases."""

    def older(file):
        file.renameVariable("sliding_criterion", "other")
        file.renameVariable("normal_load", "load")
        file["history"].renameVariable("sliding_ratio", "other")
        file.delncattr("format_version")

    path = changed(older)
    with open_case(path) as dataset, open_history(path) as history:
        assert "sliding_criterion" not in dataset
        assert dataset["normal_load"] == case.load
        assert float(dataset.wear_volume[-1]) == results.dataset.wear_volume[-1]
        np.testing.assert_array_equal(history.wear_volume, results.history.wear_volume)
    assert finished_by(path, case) == results.dataset.attrs["code_digest"]


WRONG = {
    "did not finish": lambda file: file.setncattr("complete", 0),
    "it lacks pressure": lambda file: file.renameVariable("pressure", "presure"),
    "its symmetry is none of even_xy": lambda file: file.setncattr("symmetry", "odd"),
    "pressure is in MPa, not in Pa": lambda file: file["pressure"].setncattr("units", "MPa"),
    "x does not increase": lambda file: file["x"].__setitem__(2, 0.0),
    "not the file of one case": lambda file: file.delncattr("case_id"),
}


@pytest.mark.parametrize("fault", WRONG)
def test_an_honest_mistake_is_one_sentence_with_the_name_of_the_file(changed, fault):
    path = changed(WRONG[fault])
    for opening in (open_case, open_history):
        with pytest.raises(DataFileError, match=f"^{re.escape(str(path))}: .*{fault}"):
            opening(path)


@pytest.mark.parametrize(
    "content", [None, b"", b"text", b"\x89HDF\r\n\x1a\n" + bytes(200), 0.3, 0.9]
)
def test_a_file_that_is_missing_foreign_or_cut_short_is_named(case_path, content):
    whole = case_path.read_bytes()
    case_path.unlink()
    if content is not None:
        is_share = isinstance(content, float)
        case_path.write_bytes(whole[: int(content * len(whole))] if is_share else content)
    expected = "no such file" if content is None else "damaged, or not a netCDF-4 file"
    with pytest.raises(DataFileError, match=f"^{re.escape(str(case_path))}: .*{expected}"):
        open_case(case_path)


def test_a_bit_flipped_in_a_field_is_found_when_the_field_is_read(case_path):
    with h5py.File(case_path) as file:
        first = file["pressure"].id.get_chunk_info(0).byte_offset
    content = bytearray(case_path.read_bytes())
    content[first + 6] ^= 1
    case_path.write_bytes(content)
    with (
        pytest.raises(DataFileError, match=r"case\.nc: it is damaged"),
        reading(case_path),
        open_case(case_path) as dataset,
    ):
        dataset.load()


def test_a_file_that_is_not_finished_leaves_the_one_before_it_and_no_trace(tmp_path):
    path = tmp_path / "new" / "a.txt"
    with atomic_path(path) as temporary:
        temporary.write_text("first")
        assert not path.exists()
    for error in (ValueError, KeyboardInterrupt):
        with pytest.raises(error), atomic_path(path) as temporary:  # noqa: PT012
            temporary.write_text("second")
            raise error
    assert [file.name for file in path.parent.iterdir()] == ["a.txt"]
    assert path.read_text() == "first"
