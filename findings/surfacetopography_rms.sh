#!/usr/bin/env bash
# SurfaceTopography 1.27.1: `fourier_synthesis(rms_height=1.0)` makes surfaces whose rms height is
# not 1 but, of self-affine surfaces down to the longest wave, between 0.6 and 1.2: the height given
# is one of the ensemble, whose few long waves have random amplitudes. With amplitudes of one,
# `amplitude_distribution=np.ones`, each surface has it. `rms_slope=1.0` is the length of the
# gradient: the slope of profiles is 1/√2 of it.
#
# Seen: rms heights 1.19, 1.06, 1.19, 0.60 of four seeds, and 1.000 with amplitudes of one; there
# rms_gradient 0.998, rms_slope_from_profile 0.706.
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet SurfaceTopography==1.27.1
"$folder/env/bin/python" - <<'PYTHON'
import numpy as np
from SurfaceTopography.Generation import fourier_synthesis


def surface(seed, **given):
    np.random.seed(seed)
    return fourier_synthesis((256, 256), (1.0, 1.0), 0.8, short_cutoff=0.05, **given)


random = [surface(seed, rms_height=1.0, long_cutoff=1.0).rms_height_from_area() for seed in range(4)]
ones = [
    surface(seed, rms_height=1.0, long_cutoff=1.0, amplitude_distribution=np.ones).rms_height_from_area()
    for seed in range(4)
]
steep = surface(0, rms_slope=1.0, long_cutoff=0.25, amplitude_distribution=np.ones)
print("rms heights of 1:", np.round(random, 2), "with amplitudes of one:", np.round(ones, 3))
print("slope of 1: gradient", steep.rms_gradient(), "profile", steep.rms_slope_from_profile())
assert max(random) > 1.1
assert min(random) < 0.7
assert np.allclose(ones, 1.0, atol=1e-3)
assert abs(steep.rms_gradient() - 1.0) < 0.01
assert abs(steep.rms_slope_from_profile() - 0.5**0.5) < 0.01
PYTHON
