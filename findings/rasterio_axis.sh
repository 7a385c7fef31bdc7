#!/usr/bin/env bash
# rasterio 1.4.4 (GDAL 3.10): the order in which the rows of a netCDF variable are read depends on
# attributes that do not speak of order. With `Conventions` of the file and `axis` X and Y of the
# coordinates, the rows of (x, y) are read as stored, and the height of a cell is positive. Without
# `Conventions` the last row comes first, and the height is negative; without `axis` the last row
# comes first, and the height is 1.
#
# Seen: first rows 0 1 2, 9 10 11, 9 10 11; heights of cells 2e-06, -2e-06, 1.
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet rasterio==1.4.4 netCDF4==1.7.5.1.post1
cd "$folder"
"$folder/env/bin/python" -W ignore - <<'PYTHON'
import netCDF4
import numpy as np
import rasterio

found = []
for conventions, is_marked in (("CF-1.11", True), ("", True), ("CF-1.11", False)):
    with netCDF4.Dataset("map.nc", "w") as file:
        if conventions:
            file.Conventions = conventions
        for name, size, step in (("x", 4, 2e-6), ("y", 3, 5e-6)):
            file.createDimension(name, size)
            file.createVariable(name, "f8", (name,)).units = "m"
            file[name][:] = step * (0.5 + np.arange(size))
            if is_marked:
                file[name].axis = name.upper()
        file.createVariable("height", "f8", ("x", "y"))[:] = np.arange(12.0).reshape(4, 3)
    with rasterio.open("netcdf:map.nc:height") as raster:
        found.append((raster.read(1)[0].tolist(), round(raster.transform.e, 9)))
    print(conventions or "no Conventions,", "axis" if is_marked else "no axis", *found[-1])
assert found == [([0.0, 1.0, 2.0], 2e-6), ([9.0, 10.0, 11.0], -2e-6), ([9.0, 10.0, 11.0], 1.0)]
PYTHON
