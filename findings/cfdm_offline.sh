#!/usr/bin/env bash
# cfdm 1.13.3.0: reading a local netCDF file asks the network for the table of standard names, and
# again for every coordinate of every field when it does not get it: the failure is not remembered.
# A machine without network waits for the time limit (5 s, and that of its name server) each time,
# for hours with the 25 scalar coordinates and 80 fields of one file. Neither an option of `read`
# nor a log says so. Here the network is one that refuses at once, and counts.
#
# Seen: 3 variables with 4 scalar coordinates each, no standard_name anywhere: more than 12 requests.
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet cfdm==1.13.3.0 netCDF4==1.7.5.1.post1
cd "$folder"
HOME="$folder" "$folder/env/bin/python" -W ignore - <<'PYTHON'
import urllib.error
import urllib.request

import netCDF4

with netCDF4.Dataset("local.nc", "w") as file:
    file.Conventions = "CF-1.11"
    file.createDimension("x", 5)
    for letter in "abcd":
        file.createVariable(letter, "f8").units = "m"
        file[letter][...] = 1.0
    for name in ("depth", "width", "height"):
        file.createVariable(name, "f8", ("x",)).setncatts({"units": "m", "coordinates": "a b c d"})
        file[name][:] = range(5)

requests = []


def refuse(address, *_, **__):
    requests.append(address)
    raise urllib.error.URLError("no network")


urllib.request.urlopen = refuse
import cfdm

fields = cfdm.read("local.nc")
print(len(fields), "fields,", len(requests), "requests to", {*requests})
assert len(fields) == 3
assert len(requests) >= 12
PYTHON
