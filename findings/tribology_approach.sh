#!/usr/bin/env bash
# tribology 0.5.16: `dhertz`, the approach of two bodies by Hertz, does not fit to its own `eeff` and `ahertz`.
# `eeff` is twice the contact modulus E*, and `ahertz` counts on this; `dhertz` takes its argument of the
# same name for E*, so that a sphere approaches 0.63 = 2^(-2/3) of a²/R. Of an ellipse both semi-axes
# in it are the small one. `ahertz` says that its first half axis lies along x, but returns the
# smaller one first, also if the larger radius lies along x: turning the body by 90° changes nothing.
#
# Seen of steel, 10 N: sphere of 10 mm, a 86.6 µm, approach 0.473 µm instead of 0.750; 20 mm along x and 10 mm
# along y: half axes 77 along x and 121 along y, instead of 122 and 77; approach 0.33 instead of 0.66 µm.
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet numpy==2.4.6 scipy==1.17.1 numexpr matplotlib opencv-python-headless
"$folder/env/bin/pip" install --quiet --no-deps tribology==0.5.16
"$folder/env/bin/python" -W ignore - <<'PYTHON'
import numpy as np
import tribology
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

load, modulus, flat = 10.0, tribology.eeff(210e9, 0.3, 210e9, 0.3), 1e9
stiffness = 210e9 / (2.0 * (1.0 - 0.3**2))  # E*
assert np.isclose(modulus, 2.0 * stiffness)


def hertz(large, small):
    """Semi-axes and approach of an ellipse by Johnson, Contact Mechanics, equations 4.25 to 4.31."""
    if large == small:
        a = (3.0 * load * large / (4.0 * stiffness)) ** (1.0 / 3.0)
        return a, a, a**2 / large
    ratio = brentq(
        lambda k: (ellipe(1 - k**2) / k**2 - ellipk(1 - k**2)) / (ellipk(1 - k**2) - ellipe(1 - k**2)) - large / small,
        1e-3,
        1.0 - 1e-6,
    )
    m = 1.0 - ratio**2
    a = (3.0 * load * large / (np.pi * stiffness) * (ellipk(m) - ellipe(m)) / m) ** (1.0 / 3.0)
    return a, ratio * a, 1.5 * load / (np.pi * stiffness * a) * ellipk(m)


def found(along_x, along_y):
    radii = (along_x, along_y, flat, flat)
    half_x, half_y, _ = tribology.ahertz(*tribology.reff(*radii), modulus, load)
    return half_x, half_y, tribology.dhertz(modulus, *radii, load)


sphere, along_x, along_y = found(0.01, 0.01), found(0.02, 0.01), found(0.01, 0.02)
right_sphere, right = hertz(0.01, 0.01), hertz(0.02, 0.01)
print("sphere:", sphere, "right:", right_sphere)
print("20 mm along x:", along_x, "right:", right)
print("20 mm along y:", along_y)
assert np.allclose(sphere[:2], right_sphere[:2], rtol=1e-6)
assert np.isclose(sphere[2] / right_sphere[2], 2.0 ** (-2.0 / 3.0), rtol=1e-6)
assert np.allclose(along_y[:2], right[1::-1], rtol=0.01)
assert np.allclose(along_x, along_y)
assert np.isclose(along_x[2] / right[2], 0.496, rtol=0.01)
PYTHON
