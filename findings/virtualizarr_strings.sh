#!/usr/bin/env bash
# virtualizarr 2.5.1: a single netCDF-4 variable of strings of variable length keeps the whole file
# from being opened as a virtual dataset, the numbers beside it included. xarray and h5netcdf write
# such strings by default for coordinates of text. Characters along a dimension (`S1`) do not.
#
# Seen: AttributeError: 'bytes' object has no attribute 'item', for the file with strings; the same
# file with characters opens, and its numbers are right.
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet virtualizarr==2.5.1 xarray==2026.9.0 netCDF4==1.7.5.1.post1 \
    h5netcdf==1.8.2 h5py==3.16.0 obstore obspec-utils
cd "$folder"
"$folder/env/bin/python" - <<'PYTHON'
from pathlib import Path

import numpy as np
import xarray as xr
from obspec_utils.registry import ObjectStoreRegistry
from obstore.store import LocalStore
from virtualizarr import open_virtual_dataset
from virtualizarr.parsers import HDFParser


def opened(path):
    registry = ObjectStoreRegistry({"file://": LocalStore()})
    return open_virtual_dataset(f"file://{Path(path).resolve()}", registry, HDFParser())


depths = xr.DataArray(np.arange(3.0), dims="specimen")
for kind, text in (("strings", np.array(["steel", "brass", "tin"], object)), ("chars", np.array([b"st", b"br", b"ti"]))):
    xr.Dataset({"depth": depths, "material": ("specimen", text)}).to_netcdf(f"{kind}.nc", engine="netcdf4")
try:
    opened("strings.nc")
except AttributeError as error:
    print("strings:", error)
    assert "item" in str(error)
else:
    raise SystemExit("strings of variable length open now")
assert "depth" in opened("chars.nc")
print("chars: depth is there")
PYTHON
