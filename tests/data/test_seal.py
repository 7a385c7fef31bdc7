import netCDF4
import numpy as np
import pytest

from fretwear.data.files import Seal, add_checksum, check_seal


@pytest.mark.parametrize("size", [0, 1, 1 << 20, (1 << 20) + 7])
def test_a_sealed_file_is_intact_whatever_its_size(tmp_path, size):
    path = tmp_path / "file"
    content = np.random.default_rng(1).bytes(size)
    path.write_bytes(content)
    assert check_seal(path) is Seal.MISSING
    add_checksum(path)
    assert check_seal(path) is Seal.INTACT
    assert path.read_bytes()[:size] == content


def test_every_bit_of_a_small_file_is_guarded(tmp_path):
    path = tmp_path / "file"
    path.write_bytes(b"content")
    add_checksum(path)
    whole = path.read_bytes()
    for bit in range(8 * len(whole)):
        changed = bytearray(whole)
        changed[bit // 8] ^= 1 << bit % 8
        path.write_bytes(changed)
        assert check_seal(path) is not Seal.INTACT


def test_the_netcdf_library_reads_a_sealed_file_and_writing_to_it_shows(tmp_path):
    path = tmp_path / "file.nc"
    with netCDF4.Dataset(path, "w") as file:
        file.createDimension("x", 3)
        file.createVariable("x", "f8", ("x",))[:] = [1.0, 2.0, 3.0]
    add_checksum(path)
    with netCDF4.Dataset(path) as file:
        assert file["x"][:].tolist() == [1.0, 2.0, 3.0]
    assert check_seal(path) is Seal.INTACT
    with netCDF4.Dataset(path, "a") as file:
        file.setncattr("comment", "added later")
    assert check_seal(path) is not Seal.INTACT
