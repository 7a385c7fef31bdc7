#!/usr/bin/env bash
# npTDMS 1.13.0 and soundfile 0.14.0: arrays in the other byte order than the machine's, as they come from a
# netCDF-3 file by scipy or from instruments with most significant byte first, are written as they stand
# and read in the order of the machine: other numbers without a word. asammdf 8.8.28 keeps the
# order in the file, and numpy shows the same numbers in both orders.
#
# Seen of friction 1, 2, 3.5 from a netCDF-3 file: TDMS 3e-319, 3e-322, 1.5e-320, WAV the same, MDF 1, 2, 3.5; of 16-bit
# integers 1, 2, 3: TDMS 256, 512, 768.
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet npTDMS==1.13.0 soundfile==0.14.0 asammdf==8.8.28 scipy==1.17.1 numpy==2.4.6
cd "$folder"
"$folder/env/bin/python" -W ignore - <<'PYTHON'
import numpy as np
import soundfile
from asammdf import MDF, Signal
from nptdms import ChannelObject, TdmsFile, TdmsWriter
from scipy.io import netcdf_file


def read_tdms(values):
    """Values of a channel that has been written and read."""
    with TdmsWriter("rig.tdms") as file:
        file.write_segment([ChannelObject("rig", "friction", values)])
    return TdmsFile.read("rig.tdms")["rig"]["friction"][:]


def read_wav(values):
    """The same of a WAV file of doubles."""
    soundfile.write("rig.wav", values, 100, subtype="DOUBLE")
    return soundfile.read("rig.wav")[0]


def read_mdf(values):
    """The same of an MDF file."""
    file = MDF()
    file.append([Signal(values, np.arange(len(values)) / 100.0, name="friction")])
    file.save("rig.mf4", overwrite=True)
    return MDF("rig.mf4").get("friction").samples


with netcdf_file("rig.nc", "w") as file:
    file.createDimension("time", 3)
    file.createVariable("friction", "f8", ("time",))[:] = [1.0, 2.0, 3.5]
    file.createVariable("count", "i2", ("time",))[:] = [1, 2, 3]
with netcdf_file("rig.nc", mmap=False) as file:
    friction, count = file.variables["friction"][:], file.variables["count"][:]
print("netCDF-3", friction, friction.dtype, count, count.dtype)
read = {function.__name__: function(friction) for function in (read_tdms, read_wav, read_mdf)}
counts = read_tdms(count)
print(*(f"{name} {values}" for name, values in read.items()), "counts", counts)
assert np.abs(read["read_tdms"]).max() < 1e-300
assert np.abs(read["read_wav"]).max() < 1e-300
assert read["read_mdf"].tolist() == [1.0, 2.0, 3.5]
assert counts.tolist() == [256, 512, 768]
assert all(np.array_equal(function(friction.astype(float)), friction) for function in (read_tdms, read_wav, read_mdf))
PYTHON
