#!/usr/bin/env bash
# slippy 0.5.2: `hertz_full` is right of a sphere, and of a curved body on a flat, but not if both bodies have
# two different radii: the shape of the ellipse is found with A² + B² + A·B·cos(2ω) in place of
# A² + B² + 2·A·B·cos(2ω). Two equal cylinders crossed at 90° touch in a circle; here they get
# an ellipse. Its `mean_pressure` of a line is twice the right one, above its `max_pressure`, and that of
# an ellipse is the greatest pressure divided by the area, not even a pressure.
#
# Seen of crossed cylinders of radius 10 mm, 10 N: radii 131 and 63 µm instead of 88 and 88, 578 MPa instead
# of 616. Of a line: mean 929 MPa, maximum 591 MPa. Of ellipses: mean 1e16 instead of 3e8.
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet numpy==1.26.4 scipy==1.11.4 numba==0.60.0 sympy tinydb==4.8.2 matplotlib
"$folder/env/bin/pip" install --quiet --no-deps slippy==0.5.2
"$folder/env/bin/python" -W ignore - <<'PYTHON'
import numpy as np
from slippy.contact import hertz_full

radius, modulus, poisson, load = 0.01, 200e9, 0.3, 10.0  # m, Pa, 1, N
stiffness = modulus / (2.0 * (1.0 - poisson**2))
a = (3.0 * load * radius / (4.0 * stiffness)) ** (1.0 / 3.0)
peak = 1.5 * load / (np.pi * a**2)

sphere = hertz_full(radius, np.inf, modulus, poisson, load)
crossed = hertz_full([radius, np.inf], [radius, np.inf], modulus, poisson, load, angle=np.pi / 2.0)
line = hertz_full([radius, np.inf], np.inf, modulus, poisson, 1e5, line=True)
print("right:", a, peak)
for name, solution in {"sphere": sphere, "crossed": crossed, "line": line}.items():
    print(name, *(solution[key] for key in ("relative_radii", "contact_radii", "max_pressure", "mean_pressure")))

assert np.allclose(sphere["contact_radii"], a)
assert np.allclose(sphere["max_pressure"], peak)
assert np.allclose(sphere["max_pressure"] / sphere["mean_pressure"], 1.5)
assert np.allclose(crossed["relative_radii"], radius)
assert np.allclose(crossed["contact_radii"], [1.308e-4, 6.314e-5], rtol=1e-3)
assert np.allclose(crossed["max_pressure"] / peak, 0.9385, rtol=1e-3)
area = np.pi * np.prod(crossed["contact_radii"])
assert np.allclose(crossed["max_pressure"] * area / load, 1.5)
assert np.allclose(crossed["mean_pressure"] * area, crossed["max_pressure"])
assert np.allclose(line["max_pressure"] / line["mean_pressure"], 2.0 / np.pi)  # of a line it is 4/π
PYTHON
