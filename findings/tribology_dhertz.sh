#!/usr/bin/env bash
# tribology 0.4.5, the newest that pip installs with Python 3.11: `dhertz`, the approach of two bodies after Hertz,
# wants another modulus than `ahertz` and `eeff` of the same module. With the modulus of `eeff`,
# 2/((1 - ν1²)/E1 + (1 - ν2²)/E2), the contact radius is right and the approach 0.63 (2^(-2/3)) of it. Half of
# this modulus makes it right for balls. Of bodies with two radii, both axes of the contact ellipse get the
# same exponent, and the approach falls further behind the longer the ellipse is.
#
# Seen of steel on a plane at 100 N: ball radius 0.1866 mm right, approach 0.630 of Hertz, 1.000 with half of
# the modulus; radii in the ratio 2, 5 and 10: axes right to 1 %, approach 0.787, 0.451 and 0.282 of Hertz.
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet tribology==0.4.5 matplotlib==3.11.2 numexpr==2.14.2 opencv-python==5.0.0.93 \
    setuptools==65.5.0 numpy==2.4.6 scipy==1.17.1
cd "$folder"
"$folder/env/bin/python" -W ignore - <<'PYTHON'
import numpy as np
import tribology
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

FORCE, RADIUS, PLANE = 100.0, 0.01, float("inf")
contact_modulus = 210e9 / (2.0 * (1.0 - 0.3**2))


def hertz(ratio):
    """Longer and shorter half axis and approach of Hertz with complete elliptic integrals, in m."""
    longer = ratio * RADIUS

    def mismatch(square):
        slope = ellipe(square) / (1.0 - square) - ellipk(square)
        return slope / (ellipk(square) - ellipe(square)) - ratio

    square = brentq(mismatch, 1e-9, 1.0 - 1e-9) if ratio > 1.0 else 0.0
    shape = (ellipk(square) - ellipe(square)) / square if square else np.pi / 4.0
    axis = (3.0 * FORCE * longer * shape / (np.pi * contact_modulus)) ** (1.0 / 3.0)
    return axis, axis * np.sqrt(1.0 - square), 3.0 * FORCE * ellipk(square) / (2.0 * np.pi * contact_modulus * axis)


modulus = tribology.eeff(210e9, 0.3, 210e9, 0.3)
found = []
for ratio in (1, 2, 5, 10):
    longer, shorter, approach = hertz(ratio)
    radii = (RADIUS, ratio * RADIUS, PLANE, PLANE)
    axes = sorted(tribology.ahertz(*tribology.reff(*radii), modulus, FORCE)[:2])
    found.append([float(tribology.dhertz(each, *radii, FORCE) / approach) for each in (modulus, modulus / 2.0)])
    print(f"ratio {ratio}: Hertz {longer:.4e} {shorter:.4e} m, ahertz {axes[1]:.4e} {axes[0]:.4e} m;", end=" ")
    print("dhertz {:.3f}, with half of the modulus {:.3f} of Hertz".format(*found[-1]))
    assert np.allclose(axes, [shorter, longer], rtol=1e-2)
assert np.allclose([first for first, _ in found], [0.630, 0.496, 0.284, 0.178], atol=1e-3)
assert np.allclose([second for _, second in found], [1.000, 0.787, 0.451, 0.282], atol=1e-3)
PYTHON
