#!/usr/bin/env bash
# kerchunk 0.2.10 with zarr 3.1.6 and xarray 2026.9.0: references of a file with a group hold the
# group and its arrays, and `open_zarr(…, group="history")` on them gives an empty dataset without a
# word, where a wrong name is an error. The references of the group alone, without its name before
# their keys, give its variables.
#
# Seen: in the references True; by group []; by its own references ['wear'] [1. 2. 3.].
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet \
    kerchunk==0.2.10 zarr==3.1.6 fsspec==2026.9.0 xarray==2026.9.0 h5py==3.16.0 h5netcdf==1.8.2
cd "$folder"
"$folder/env/bin/python" -W ignore - <<'PYTHON'
import numpy as np
import xarray as xr
from kerchunk.hdf import SingleHdf5ToZarr

history = xr.Dataset({"wear": ("step", np.array([1.0, 2.0, 3.0]))})
xr.Dataset({"load": 50.0}).to_netcdf("case.nc", engine="h5netcdf")
history.to_netcdf("case.nc", engine="h5netcdf", group="history", mode="a")

references = SingleHdf5ToZarr("case.nc").translate()["refs"]
print("in the references", "history/wear/.zarray" in references)


def opened(references, **group):
    """The dataset of some references."""
    options = {"fo": {"version": 1, "refs": references}}
    settings = {"consolidated": False, "zarr_format": 2, "storage_options": options}
    return xr.open_zarr("reference://", **settings, **group)


by_name = opened(references, group="history")
print("by group", list(by_name))
own = {key.removeprefix("history/"): of for key, of in references.items() if "history/" in key}
alone = opened(own)
print("by its own references", list(alone), alone.wear.values)
assert "history/wear/.zarray" in references
assert not by_name.variables, "the group is read now"
assert alone.wear.values.tolist() == [1.0, 2.0, 3.0]
PYTHON
