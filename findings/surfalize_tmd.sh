#!/usr/bin/env bash
# surfalize 0.19.2: lengths and heights of a .tmd file (GelSight, TrueMap) are millimetres, as GelSight's own reader
# and SurfaceTopography 1.27.1 take them. surfalize takes them for its micrometres: a scar measured 5 µm deep
# is 5 nm deep there, and one that it writes is 5 mm deep for the others. Slopes are right, so that
# nothing looks wrong; depths and lengths are 1000 times, volumes 1e9 times off.
#
# Seen of a map 10 µm wide with a scar of 5 µm, written by surfalize: SurfaceTopography finds 10 mm and 5 mm; with the
# lengths in mm, as an instrument writes them: SurfaceTopography 0.01 mm and 0.005 mm, surfalize 0.01 µm
# and 0.005 µm. The .x3p of the same map is read alike by both.
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet surfalize==0.19.2 SurfaceTopography==1.27.1 numpy==2.4.6
cd "$folder"
"$folder/env/bin/python" -W ignore - <<'PYTHON'
import struct
from pathlib import Path

import numpy as np
from surfalize import Surface
from SurfaceTopography import read_topography

heights = np.zeros((4, 5))
heights[1:3, 1:4] = -5.0  # µm
surface = Surface(heights, 2.0, 2.0)
surface.save("written.tmd")
surface.save("written.x3p")
header = struct.pack("<32s24sII4f", b"Binary TrueMap Data File v2.0\r\n", b"scar\r\n", 5, 4, 0.01, 0.008, 0.0, 0.0)
Path("measured.tmd").write_bytes(header + (heights / 1000.0).astype("<f4").tobytes())  # mm
found = []
for path in ("written.tmd", "measured.tmd", "written.x3p"):
    topography, own = read_topography(path), Surface.load(path)
    metres = {"mm": 1e-3, "m": 1.0}[topography.unit]
    sizes = topography.physical_sizes[0] * metres, np.ptp(topography.heights()) * metres
    found.append([*sizes, own.size.x * own.step_x * 1e-6, np.ptp(own.data) * 1e-6])
    print(path, "width and depth: SurfaceTopography {:.0e} m {:.0e} m, surfalize {:.0e} m {:.0e} m".format(*found[-1]))
scar = np.array([1e-5, 5e-6])
assert np.allclose(found[0], [*1000.0 * scar, *scar], rtol=1e-5, atol=0.0)
assert np.allclose(found[1], [*scar, *scar / 1000.0], rtol=1e-5, atol=0.0)
assert np.allclose(found[2], [*scar, *scar], rtol=1e-5, atol=0.0)
PYTHON
