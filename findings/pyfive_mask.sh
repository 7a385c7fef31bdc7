#!/usr/bin/env bash
# pyfive 1.3.0: a boolean dataset comes back as integers 0 and 1, where h5py 3.16.0, whose interface it follows
# and which wrote the file, gives booleans. `heights[worn]` with such a mask does not select the worn
# points but repeats points 0 and 1, and `~worn` is -1 and -2: numpy takes all of it without a word. An
# array of which some chunks were never written, as of a run that goes on, raises a KeyError that names
# a chunk; h5py fills with the fill value of the file, as pyfive does if no chunk was written.
#
# Seen of heights 10 11 12 13 and worn F F T T: mean of worn points 12.5 by h5py, 10.5 by pyfive;
# half-written array: h5py 1 1 nan nan, pyfive KeyError (2,); empty array nan by both.
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet pyfive==1.3.0 h5py==3.16.0 numpy==2.4.6
cd "$folder"
"$folder/env/bin/python" - <<'PYTHON'
import h5py
import numpy as np
import pyfive

with h5py.File("map.h5", "w") as file:
    file["heights"] = np.arange(10.0, 14.0)
    file["worn"] = np.array([False, False, True, True])
    for name in ("half", "empty"):
        file.create_dataset(name, (4,), float, chunks=(2,), fillvalue=np.nan)
    file["half"][:2] = 1.0

found = {}
for library in (h5py, pyfive):
    with library.File("map.h5") as file:
        heights, worn, empty = (file[name][:] for name in ("heights", "worn", "empty"))
        found[library.__name__] = heights[worn].mean()
        print(library.__name__, worn.dtype, heights[worn], heights[~worn], empty)
        assert np.isnan(empty).all()
        try:
            print("   ", file["half"][:])
            assert library is h5py
        except KeyError as error:
            print("    KeyError", error)
            assert library is pyfive
assert found == {"h5py": 12.5, "pyfive": 10.5}
PYTHON
