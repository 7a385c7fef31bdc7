#!/usr/bin/env bash
# h5netcdf 1.8.2: a variable does not keep its file: in `File("map.nc")["depth"][:]` the file has gone
# before the values are read, and the error speaks of neither. h5py 3.16.0, on which it is built,
# reads the same expression.
#
# Seen: h5py [0. 1. 2.]; h5netcdf AttributeError: 'NoneType' object has no attribute '_root'; with
# the file in a variable of its own [0. 1. 2.].
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet h5netcdf==1.8.2 h5py==3.16.0
cd "$folder"
"$folder/env/bin/python" - <<'PYTHON'
import h5netcdf
import h5py

with h5netcdf.File("map.nc", "w") as file:
    file.dimensions = {"x": 3}
    file.create_variable("depth", ("x",), float)[:] = [0.0, 1.0, 2.0]

print("h5py", h5py.File("map.nc")["depth"][:])
try:
    h5netcdf.File("map.nc")["depth"][:]
except AttributeError as error:
    print("h5netcdf AttributeError:", error)
    assert "NoneType" in str(error)
else:
    raise SystemExit("the variable keeps its file now")
file = h5netcdf.File("map.nc")
print("kept", file["depth"][:])
assert file["depth"][:].tolist() == [0.0, 1.0, 2.0]
PYTHON
