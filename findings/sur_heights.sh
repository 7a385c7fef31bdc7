#!/usr/bin/env bash
# SurfaceTopography 1.27.1, rosettasciio 0.15.0 and surfalize 0.19.2: they read heights of a .sur file (Digital
# Surf) that differ by a constant, which depends on the range of heights. surfalize adds the offset
# in the header to the scaled integers, rosettasciio also subtracts the smallest integer, and
# SurfaceTopography adds no offset. Roughness is the same. The difference of two maps is not: unworn
# less worn gives the depth of wear only in the library that wrote both.
#
# Seen of a scar 8 µm deep, as depths (outside, inside) the scar. Written by surfalize: read by surfalize
# (0, 8), rosettasciio (-3.53, 4.47), SurfaceTopography (-3.53, 4.47). Written by rosettasciio:
# surfalize (3.53, 11.53), rosettasciio (0, 8), SurfaceTopography (-3.53, 4.47).
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet SurfaceTopography==1.27.1 rosettasciio==0.15.0 surfalize==0.19.2 numpy==2.4.6
cd "$folder"
"$folder/env/bin/python" -W ignore - <<'PYTHON'
import numpy as np
from rsciio.digitalsurf import file_reader, file_writer
from SurfaceTopography import open_topography
from surfalize import Surface

unworn = np.random.default_rng(0).normal(size=(30, 40))  # µm, every 0.5 µm
worn = unworn.copy()
worn[10:20, 10:20] -= 8.0


def write_by_rosettasciio(path, heights):
    sides = zip("YX", heights.shape, strict=True)
    scale = {"scale": 0.5, "offset": 0.0, "units": "um", "navigate": False}
    axes = [{"name": name, "size": size, "index_in_array": n, **scale} for n, (name, size) in enumerate(sides)]
    metadata = {"General": {}, "Signal": {"quantity": "Height (um)"}}
    file_writer(path, {"data": heights, "axes": axes, "metadata": metadata, "original_metadata": {}}, compressed=False)


writers = {
    "surfalize": lambda path, heights: Surface(heights, 0.5, 0.5).save(path),
    "rosettasciio": write_by_rosettasciio,
}
readers = {
    "surfalize": lambda path: Surface.load(path).data,
    "rosettasciio": lambda path: file_reader(path)[0]["data"],
    "SurfaceTopography": lambda path: open_topography(path).topography().heights().T,
}
found = {}
for writer, write in writers.items():
    write("unworn.sur", unworn)
    write("worn.sur", worn)
    for reader, read in readers.items():
        depth = read("unworn.sur") - read("worn.sur")
        assert abs(read("unworn.sur").std() - unworn.std()) < 1e-6
        found[writer, reader] = (float(depth[0, 0]), float(depth[15, 15]))
        print(f"by {writer}, read by {reader}: outside {depth[0, 0]:.2f}, scar {depth[15, 15]:.2f}")
shift = 3.534  # half the difference of the two ranges of heights
for (writer, reader), depths in found.items():
    expected = 0.0 if writer == reader else shift if reader == "surfalize" else -shift
    assert np.allclose(depths, [expected, 8.0 + expected], atol=1e-3), (writer, reader)
PYTHON
