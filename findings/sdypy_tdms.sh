#!/usr/bin/env bash
# sdypy_io_tdms 0.1.2 (npTDMS 1.13.0): signals after SEP005, the exchange format of SDyPy, are not what they were
# after `write_tdms` and `read_tdms`. Values become single precision, so that a counter of cycles stands
# still; the start time of a signal is not stored, so that signals that began at different times
# begin together; and a name loses what stands beside a slash, also in files of other programs.
#
# Seen of cycles 20000000 to 20000005: 20000000 twice, 20000002, 20000004 three times; starts 12:00:00 and 12:00:30
# come back as none; "F/N" comes back as an empty name. npTDMS reads the name in the same file.
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet sdypy_io_tdms==0.1.2 npTDMS==1.13.0 sdypy-sep005==1.0.1 numpy==2.4.6
cd "$folder"
"$folder/env/bin/python" -W ignore - <<'PYTHON'
import numpy as np
from nptdms import TdmsFile
from sdypy_io_tdms.tdms import read_tdms, write_tdms

cycles = 20000000.0 + np.arange(6.0)
channels = (
    ("cycles", cycles, "1", "2026-01-01T12:00:00"),
    ("wear", np.arange(6.0), "um", "2026-01-01T12:00:30"),
    ("F/N", np.ones(6), "N", "2026-01-01T12:00:00"),
)
keys = ("name", "data", "unit_str", "start_timestamp")
written = [{"group": "rig", "fs": 100.0, **dict(zip(keys, channel, strict=True))} for channel in channels]
write_tdms(written, "rig.tdms")
read = read_tdms("rig.tdms")
for before, after in zip(written, read, strict=True):
    starts = before["start_timestamp"], after.get("start_timestamp")
    print(repr(before["name"]), "becomes", repr(after["name"]), "start", *starts, after["data"].dtype)
print("cycles", read[0]["data"].astype(int).tolist())
names = [channel.name for channel in TdmsFile("rig.tdms")["rig"].channels()]
print("npTDMS finds", names)
assert read[0]["data"].astype(int).tolist() == [20000000, 20000000, 20000002, 20000004, 20000004, 20000004]
assert not any("start_timestamp" in signal for signal in read)
assert [signal["name"] for signal in read] == ["cycles", "wear", ""]
assert names == ["cycles", "wear", "F/N"]
PYTHON
