#!/usr/bin/env bash
# netCDF4 1.7.5 and h5netcdf 1.8.2 with xarray 2026.9.0: arrays of an HDF5 file without dimension scales,
# as h5py writes them, share a dimension if their sizes are equal. A map of 4 x 5 points beside its
# places x and y is read as one expects. In a map of 5 x 5, y gets the dimension of x, so that
# a tilt along y is subtracted along x without a word. `phony_dims` of h5netcdf, "sort" or
# "access", changes nothing.
#
# Seen of a plane tilted along y, less this tilt: 4 x 5 leaves 0, 5 x 5 leaves 12, with all readers.
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet xarray==2026.9.0 netCDF4==1.7.5.1.post1 h5netcdf==1.8.2 h5py==3.16.0
cd "$folder"
"$folder/env/bin/python" - <<'PYTHON'
import h5py
import numpy as np
import xarray as xr

engines = {"netcdf4": {}, "h5netcdf": {"phony_dims": "sort"}, "h5netcdf ": {"phony_dims": "access"}}
left = {}
for shape in ((4, 5), (5, 5)):
    path = f"{shape[0]}x{shape[1]}.h5"
    with h5py.File(path, "w") as file:
        file["x"], file["y"] = np.arange(float(shape[0])), np.arange(float(shape[1]))
        file["height"] = np.broadcast_to(3.0 * np.arange(shape[1]), shape)  # over x, y
    for engine, settings in engines.items():
        with xr.open_dataset(path, engine=engine.strip(), **settings) as map_:
            level = (map_.height - 3.0 * map_.y).values
            left.setdefault(shape, []).append(float(np.abs(level).max()))
            print(path, engine, settings, "y over", *map_.y.dims, "leaves", left[shape][-1])
assert left == {(4, 5): [0.0] * 3, (5, 5): [12.0] * 3}
PYTHON
