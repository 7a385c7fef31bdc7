#!/usr/bin/env bash
# ccx2paraview 3.2.0 (vtk 9.7.2): the file of a step holds results of earlier ones. All steps fill the same
# grid, and a field that CalculiX wrote in an early step alone stays in the files of all later ones, with
# its old values and without a warning. `E_Mises`, the "von Mises equivalent strain", is the formula of
# stress applied to strain, without the factor 2/3. Files are written here one after the other, not
# in threads as by default, so that the result does not depend on timing.
#
# Seen of 2 steps, reaction force 7 in the first alone: RF = 7 in the file of step 2, whose displacement is its
# own; of a plastic strain (0.01, -0.005, -0.005) E_Mises 0.015 instead of 0.01.
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet ccx2paraview==3.2.0 vtk==9.7.2 pyvista==0.49.1 numpy==2.4.6
cd "$folder"
"$folder/env/bin/python" -W ignore - <<'PYTHON'
import itertools
import threading

import numpy as np
import pyvista
from ccx2paraview import common

STEPS, NODES = 2, range(1, 9)
corners = [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
strain = (0.01, -0.005, -0.005, 0.0, 0.0, 0.0)
blocks = itertools.count(1)


def row(node, values):
    return f" -1{node:10d}" + "".join(f"{value:12.5E}" for value in values)


def block(step, name, components, values):
    total = [" -5  ALL         1    2    0    0    1ALL"] if len(values) == 3 else []
    return [
        f"    1PSTEP{next(blocks):26d}{1:12d}{step:12d}          ",
        f"  100CL{100 + step:5d}{step:12.9f}{8:12d}{0:22d}{step:5d}{1:12d}",
        f" -4  {name:8}{len(components) + len(total):5d}    1",
        *(f" -5  {component:8}    1    2{n:5d}    0" for n, component in enumerate(components, 1)),
        *total,
        *(row(node, values) for node in NODES),
        " -3",
    ]


lines = ["    1C", "    2C" + f"{8:30d}{1:38d}"]
lines += [row(node, corner) for node, corner in zip(NODES, corners, strict=True)] + [" -3"]
lines += ["    3C" + f"{1:30d}{1:38d}", f" -1{1:10d}    1    0    1", " -2" + "".join(f"{n:10d}" for n in NODES), " -3"]
for step in range(1, STEPS + 1):
    lines += block(step, "DISP", ("D1", "D2", "D3"), (float(step), 0.0, 0.0))
    lines += block(step, "TOSTRAIN", ("EXX", "EYY", "EZZ", "EXY", "EYZ", "EZX"), strain)
    lines += block(step, "FORC", ("F1", "F2", "F3"), (7.0, 0.0, 0.0)) if step == 1 else []
with open("cube.frd", "w") as file:
    file.write("\n".join([*lines, " 9999", ""]))


class Immediately(threading.Thread):
    start = threading.Thread.run

    def join(self, timeout=None):
        pass


common.threading.Thread = Immediately
common.Converter("cube.frd", ["vtu"]).run()
files = [pyvista.read(f"cube.{step}.vtu") for step in range(1, STEPS + 1)]
moved = np.array([file["U"][0, 0] for file in files])
print("displacements in the files of steps 1 and 2:", moved)
print("reaction force in the file of step 2:", files[1]["RF"][0])
print("E:", files[0]["E"][0], "E_Mises:", files[0]["E_Mises"][0])
assert moved.tolist() == [1.0, 2.0]
assert files[1]["RF"][0, 0] == 7.0
assert np.isclose(files[0]["E_Mises"][0], 1.5 * 0.01)
PYTHON
