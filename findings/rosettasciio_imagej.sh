#!/usr/bin/env bash
# rosettasciio 0.15.0 (the files of HyperSpy): of a TIFF from ImageJ, whose units and scale are read as its
# documentation says, the unit is known only if it is spelt "micron". With nm, mm, um or inch the scale is
# kept and its unit dropped without a word: images at 250 nm and 0.25 µm per pixel differ by 1000.
#
# Seen of pixels of 0.25 µm: micron 0.25 µm; um 0.25, nm 250 and mm 0.00025 without a unit. tifffile 2026.3.3
# finds every unit in the same files.
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet rosettasciio==0.15.0 tifffile==2026.3.3 numpy==2.4.6
cd "$folder"
"$folder/env/bin/python" - <<'PYTHON'
import numpy as np
import tifffile
from rsciio import tiff

found = {}
for unit, width in (("micron", 0.25), ("um", 0.25), ("nm", 250.0), ("mm", 0.00025)):
    heights = np.zeros((3, 4), np.float32)
    settings = {"resolution": (1.0 / width, 1.0 / width), "metadata": {"unit": unit, "axes": "YX"}}
    tifffile.imwrite("map.tif", heights, imagej=True, **settings)
    axes = tiff.file_reader("map.tif")[0]["axes"]
    found[unit] = [(axis["scale"], axis["units"]) for axis in axes]
    with tifffile.TiffFile("map.tif") as file:
        kept = file.imagej_metadata["unit"]
    print(f"{width} {unit}: rosettasciio", *found[unit], "tifffile", kept)
    assert kept == unit
    assert np.allclose([scale for scale, _ in found[unit]], width, rtol=1e-6)
assert [unit for _, unit in found.pop("micron")] == ["µm", "µm"]
assert all(unit is None for axes in found.values() for _, unit in axes)
PYTHON
