#!/usr/bin/env bash
# pyvista 0.49.1 (vtk 9.7.2): `pyvista.read` of a .pvd file, a list of meshes over time, returns the
# first time alone, as a MultiBlock with one block, without a warning. All times need
# `pyvista.get_reader`, `set_active_time_point` and a `read` for each.
#
# Seen: read: 1 block, p = 0; reader: times 0, 10 and 1000, p = 0, 1 and 2.
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet pyvista==0.49.1 vtk==9.7.2
cd "$folder"
"$folder/env/bin/python" - <<'PYTHON'
from pathlib import Path

import pyvista

times, entries = [0.0, 10.0, 1000.0], []
for number, time in enumerate(times):
    mesh = pyvista.ImageData(dimensions=(4, 3, 1)).cast_to_unstructured_grid()
    mesh.point_data["p"] = [float(number)] * mesh.n_points
    mesh.save(f"{number}.vtu")
    entries.append(f'<DataSet timestep="{time}" part="0" file="{number}.vtu"/>')
content = f'<VTKFile type="Collection" version="0.1"><Collection>{"".join(entries)}</Collection></VTKFile>'
Path("all.pvd").write_text(content)

blocks = pyvista.read("all.pvd")
print("read:", len(blocks), "block, p =", blocks[0]["p"].max())
assert len(blocks) == 1
assert blocks[0]["p"].max() == 0.0
reader, largest = pyvista.get_reader("all.pvd"), []
for point in range(reader.number_time_points):
    reader.set_active_time_point(point)
    largest.append(float(reader.read()[0]["p"].max()))
print("reader: times", reader.time_values, "p =", largest)
assert reader.time_values == times
assert largest == [0.0, 1.0, 2.0]
PYTHON
