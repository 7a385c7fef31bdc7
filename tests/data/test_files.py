"""Files that are written whole, and opened only when they are."""

import os
import tempfile
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr

from fretwear.data.dataset import mirrored
from fretwear.data.files import (
    READS_BACK,
    add_checksum,
    check_group,
    damage,
    open_case,
    open_history,
    open_lazily,
    open_loops,
    opened_case,
    write_case,
    write_group,
)
from fretwear.data.safe import DataFileError
from fretwear.vocabulary import FIELDS

from ..studies import flip, spoil_chunks


@pytest.mark.parametrize("size", [0, 7, 1 << 20, (1 << 20) + 7])
def test_a_file_with_its_checksum_is_whole_of_any_size_and_every_bit_is_guarded(tmp_path, size):
    path = tmp_path / "file"
    content = np.random.default_rng(1).bytes(size)
    path.write_bytes(content)
    assert "not a complete file" in damage(path, "file")
    add_checksum(path)
    assert damage(path, "file") == ""
    whole = path.read_bytes()
    assert whole[:size] == content
    for bit in range(8 * len(whole)) if size < 10 else ():
        changed = bytearray(whole)
        changed[bit // 8] ^= 1 << bit % 8
        path.write_bytes(changed)
        assert damage(path, "file")


def test_a_case_comes_back_as_it_was_written_also_from_a_copy(results, tmp_path):
    path, copy, before = tmp_path / "a.nc", tmp_path / "b.nc", results.dataset.copy(deep=True)
    write_case(results.dataset, results.history, path)
    xr.testing.assert_identical(results.dataset, before)
    with open_case(path) as dataset, open_history(path) as history:
        xr.testing.assert_equal(dataset.load(), results.dataset)
        assert dataset.attrs == {**results.dataset.attrs, "complete": 1}
        for name, variable in results.dataset.variables.items():
            assert dataset[name].dtype.kind == variable.dtype.kind
            assert dataset[name].dtype == variable.dtype or variable.dtype.kind == "U"
            assert dataset[name].attrs.keys() == variable.attrs.keys()
        xr.testing.assert_identical(history.load(), results.history)
        write_case(dataset, history, copy)
        with open_case(copy) as again:
            xr.testing.assert_identical(again.load(), dataset)
    with pytest.raises(ValueError, match="lacks gap"):
        write_case(results.dataset.drop_vars("gap"), results.history, tmp_path / "case.nc")
    unwritable = results.history.assign(
        notes=("step", np.full(results.history.step.size, 1j, dtype=object))
    )
    with pytest.raises((TypeError, ValueError)):
        write_case(results.dataset, unwritable, tmp_path / "case.nc")
    assert {*tmp_path.iterdir()} == {path, copy}, "what cannot be a case file leaves nothing"


def test_one_compressed_chunk_per_cycle_is_read_when_used_and_closed_datasets_hold_no_file(
    case_path,
):
    with netCDF4.Dataset(case_path) as file:
        assert file["cycle"][:].tolist() == [0.0, 1000.0], "a checksum is ignored by the library"
    for full in (False, True):
        with open_case(case_path, full=full) as dataset, open_history(case_path) as history:
            assert not any(dataset[field.name].variable._in_memory for field in FIELDS)
            dataset.pressure.load()
            history.load()
    for field in FIELDS:
        encoding = dataset[field.name].encoding
        assert encoding["chunksizes"][0] == 1
        assert (encoding["zlib"], encoding["complevel"]) == (True, 1)
        assert (encoding["shuffle"], encoding["fletcher32"]) == (True, True)
    assert not [name for name in dataset.coords if "_FillValue" in dataset[name].encoding]
    with opened_case(case_path):
        pass
    # A file can be open many times.
    opened = [open_case(case_path, full=True) for _ in range(5)]
    for dataset in opened:
        dataset.load().close()
    held = [link.readlink() for link in Path("/proc/self/fd").iterdir() if link.is_symlink()]
    assert case_path not in held


def test_the_whole_contact_is_four_quarters_even_and_evenly_spaced(
    case_path, case, results, tmp_path
):
    with open_case(case_path) as quarter, open_case(case_path, full=True) as whole:
        assert (quarter.attrs["symmetry"], whole.attrs["symmetry"]) == ("even_xy", "none")
        for name, spacing in zip(("x", "y"), case.grid_spacing, strict=True):
            np.testing.assert_allclose(np.diff(whole[name]), spacing, rtol=1e-9)
            np.testing.assert_array_equal(whole[name], -whole[name][::-1])
            assert whole[name].attrs["axis"] == name.upper()
        nx, ny = quarter.sizes["x"], quarter.sizes["y"]
        for field in FIELDS:
            values = whole[field.name].values
            np.testing.assert_array_equal(values[:, nx:, ny:], quarter[field.name])
            np.testing.assert_array_equal(values, values[:, ::-1, :])
            np.testing.assert_array_equal(values, values[:, :, ::-1])
        xr.testing.assert_equal(whole.wear_volume, quarter.wear_volume)
        write_case(whole, results.history, tmp_path / "whole.nc")
        with open_case(tmp_path / "whole.nc", full=True) as again:
            assert again.sizes["x"] == whole.sizes["x"], "what is whole is not mirrored"
        quarter.load()
        assert mirrored(quarter).x.min() == -quarter.x.max()
        assert quarter.x.min() > 0.0


LOST = {
    "a unit": lambda file: file["pressure"].delncattr("units"),
    "an attribute": lambda file: file.delncattr("title"),
    "a group's attribute": lambda file: file["history"].delncattr("title"),
    "a value": lambda file: file["gap"].__setitem__((1, 0, 0), 1.0),
    "a cycle": lambda file: file["pressure"].__setitem__(1, np.nan),
    "a variable": lambda file: file["history"].renameVariable("approach", "approch"),
}


@pytest.mark.parametrize("what", LOST)
def test_what_the_library_loses_without_a_word_is_found_out_before_the_file_has_its_name(
    tmp_path, results, monkeypatch, what
):
    def lose(path):
        with netCDF4.Dataset(path, "a") as file:
            LOST[what](file)
        add_checksum(path)

    monkeypatch.setattr("fretwear.data.files.add_checksum", lose)
    with pytest.raises(DataFileError, match="reads back differently"):
        write_case(results.dataset, results.history, tmp_path / "case.nc")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "other", [np.zeros((2, 2), np.int64), xr.DataArray(np.zeros((2, 2)), dims=("y", "x"))]
)
def test_other_types_and_dimensions_of_the_same_bytes_are_found_out(other):
    content = xr.Dataset({"a": (("x", "y"), np.zeros((2, 2)))})
    with netCDF4.Dataset("memory", "w", diskless=True) as file:
        write_group(file, content)
        check_group(file, content)
        dims = getattr(other, "dims", ("x", "y"))
        with pytest.raises(RuntimeError, match=READS_BACK):
            check_group(file, xr.Dataset({"a": (dims, np.asarray(other))}))


def test_what_a_library_cannot_read_of_an_intact_file_is_told_and_other_errors_are_not_hidden(
    case_path,
):
    """The checksum of the file matches, the one of a chunk of it, which HDF5 compares, does not."""
    spoil_chunks(case_path)
    with (
        pytest.raises(DataFileError, match=r"cannot be read \(NetCDF: HDF error\)"),
        opened_case(case_path) as file,
    ):
        file["pressure"][...]
    with pytest.raises(LookupError, match="mine"), opened_case(case_path):
        raise LookupError("mine")


def test_a_file_that_fails_while_it_is_read_is_told_with_the_reason():
    assert damage(Path("/proc/self/mem"), "case file") == "it cannot be read (Input/output error)"


def test_a_file_that_is_no_netcdf_or_seems_empty_is_not_opened_lazily(tmp_path):
    path = tmp_path / "a.nc"
    path.write_bytes(b"text")
    with pytest.raises(DataFileError, match=r"it cannot be read \("):
        open_lazily(path)
    netCDF4.Dataset(path, "w").close()
    with pytest.raises(DataFileError, match="it appears empty"):
        open_lazily(path)


def test_a_case_without_loops_says_so(case_path):
    with pytest.raises(DataFileError, match="it holds no loops of force and displacement"):
        open_loops(case_path)


@pytest.mark.parametrize("content", [b"", b"not a netCDF file", b"\x89HDF\r\n\x1a\n" + bytes(200)])
def test_a_file_that_is_missing_or_no_case_is_named_and_a_pipe_is_not_waited_for(tmp_path, content):
    path = tmp_path / "case.nc"
    with pytest.raises(DataFileError, match="no such file") as error:
        open_case(path)
    assert error.value.path == path
    path.write_bytes(content)
    with pytest.raises(DataFileError, match=r"case\.nc: .* run the case again"):
        open_case(path)
    path.unlink()
    os.mkfifo(path)
    # With a writer a reader does not wait for ever, but fails in another way.
    writer = os.open(path, os.O_RDWR)
    os.write(writer, b"x")
    with pytest.raises(DataFileError, match="it is not a file"):
        open_case(path)
    os.close(writer)


def test_a_dataset_that_lacks_variables_is_not_written(tmp_path, results):
    path = tmp_path / "a.nc"
    with pytest.raises(ValueError, match="would not be complete: the dataset lacks gap"):
        write_case(results.dataset.drop_vars("gap"), results.history, path)
    assert not path.exists()


@pytest.mark.parametrize("name", ["cycle", "step", "wear_volume", "tangential_force"])
def test_a_history_that_lacks_a_variable_is_refused_before_its_values_are_read(
    name, case_path, tmp_path
):
    path = tmp_path / "case.nc"
    path.write_bytes(case_path.read_bytes())
    with netCDF4.Dataset(path, "a") as file:
        file["history"].renameVariable(name, "other")
    add_checksum(path)
    with pytest.raises(DataFileError, match=f"lacks history/{name}"), opened_case(path):
        pass


def test_a_file_that_another_program_wrote_lacks_something_or_is_of_another_kind(tmp_path, results):
    path, study_file, merged = (tmp_path / name for name in ("a.nc", "study.yaml", "summary.nc"))
    results.dataset.to_netcdf(path)
    with pytest.raises(DataFileError, match="unfinished"), opened_case(path):
        pass
    add_checksum(path)
    with pytest.raises(DataFileError, match="did not finish"):
        open_case(path)
    results.dataset.drop_vars("gap").assign_attrs(complete=1).to_netcdf(path)
    add_checksum(path)
    with pytest.raises(DataFileError, match="lacks gap, history"):
        open_case(path)
    study_file.write_text("title: Loads\n")
    results.dataset[["wear_volume"]].drop_attrs().to_netcdf(merged)
    add_checksum(merged)
    for path, problem in (study_file, "not a netCDF-4 file"), (merged, "not the file of one case"):
        with pytest.raises(DataFileError, match=f"{problem}.*Check the name") as error:
            open_case(path)
        assert "Remove" not in str(error.value)


@pytest.mark.parametrize("opening", [open_case, open_history])
def test_a_file_that_is_damaged_cut_short_or_longer_is_not_opened(case_path, opening):
    whole = case_path.read_bytes()
    flip(case_path)
    with pytest.raises(DataFileError, match=r"damaged.*run the case again"):
        opening(case_path)
    for share in (0.02, 0.3, 0.7, 0.999, None):
        case_path.write_bytes(whole + b"x" if share is None else whole[: int(len(whole) * share)])
        with pytest.raises(DataFileError, match="cut short or changed by another program"):
            opening(case_path)


def test_small_files_are_made_in_memory_and_large_ones_in_their_folder(
    results, tmp_path, monkeypatch
):
    memory, used, made = tmp_path / "memory", [], tempfile.NamedTemporaryFile
    memory.mkdir()

    def noted(**options):
        used.append(options["dir"])
        return made(**options)

    monkeypatch.setattr("fretwear.data.files.tempfile.NamedTemporaryFile", noted)
    monkeypatch.setattr("fretwear.data.files._MEMORY", memory)
    write_case(results.dataset, results.history, tmp_path / "a.nc")
    monkeypatch.setattr("fretwear.data.files._IN_MEMORY_BYTES", 0)
    write_case(results.dataset, results.history, tmp_path / "b.nc")
    assert used == [memory]
    assert list(memory.iterdir()) == []
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()
