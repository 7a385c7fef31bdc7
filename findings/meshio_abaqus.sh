#!/usr/bin/env bash
# meshio 5.3.5: a mesh of quadrilaterals becomes CAX4P in a .inp file, which Abaqus takes for
# axisymmetric elements with pore pressure, not for shells or plane elements; values at points are
# left out without a word. A .vtu file of the same mesh keeps them.
#
# Seen: *ELEMENT, TYPE=CAX4P; point data read back: none from .inp, p from .vtu.
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet meshio==5.3.5 numpy==2.4.6
cd "$folder"
"$folder/env/bin/python" - <<'PYTHON'
from pathlib import Path

import meshio
import numpy as np

corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
mesh = meshio.Mesh(corners, [("quad", [[0, 1, 2, 3]])], point_data={"p": np.arange(4.0)})
for ending in ("inp", "vtu"):
    mesh.write(f"square.{ending}")
(line,) = (line for line in Path("square.inp").read_text().splitlines() if line.startswith("*ELEMENT"))
kept = {ending: [*meshio.read(f"square.{ending}").point_data] for ending in ("inp", "vtu")}
print(line, "point data:", kept)
assert line == "*ELEMENT, TYPE=CAX4P"
assert kept == {"inp": [], "vtu": ["p"]}
PYTHON
