#!/usr/bin/env bash
# xarray 2026.9.0 with zarr 3.1.6: wear that outgrows packed integers comes back negative. Values
# appended to a store are packed like the first ones (here int16 in steps of 0.01, up to 327.67)
# although the call that appends names no packing, and larger values wrap round without an error
# or a warning. So do values with a `scale_factor` in a netCDF file.
#
# Seen: 1, 2, 300 and 400 come back as 1, 2, 300 and -255.36 from int16, unchanged from float32.
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet xarray==2026.9.0 zarr==3.1.6 h5netcdf==1.8.2 h5py==3.16.0
cd "$folder"
"$folder/env/bin/python" - <<'PYTHON'
import warnings

import numpy as np
import xarray as xr

warnings.simplefilter("error")
packed = {"dtype": "int16", "scale_factor": 0.01, "_FillValue": -32768}


def wear(cycles, depths):
    return xr.Dataset({"wear": ("cycle", depths)}, {"cycle": cycles})


found = {}
for name, encoding in (("int16", packed), ("float32", {"dtype": "float32"})):
    first, second = wear([1, 10], [1.0, 2.0]), wear([100, 1000], [300.0, 400.0])
    first.to_zarr(f"{name}.zarr", encoding={"wear": encoding}, consolidated=False)
    second.to_zarr(f"{name}.zarr", append_dim="cycle", consolidated=False)
    found[name] = xr.open_zarr(f"{name}.zarr", consolidated=False).wear.values
    print("appended,", name, found[name])
wear([1, 2], [300.0, 400.0]).to_netcdf("packed.nc", engine="h5netcdf", encoding={"wear": packed})
found["netCDF"] = xr.open_dataset("packed.nc", engine="h5netcdf").wear.values
print("netCDF, int16", found["netCDF"])
assert np.allclose(found["int16"], [1.0, 2.0, 300.0, -255.36])
assert found["float32"].tolist() == [1.0, 2.0, 300.0, 400.0]
assert np.allclose(found["netCDF"], [300.0, -255.36])
PYTHON
