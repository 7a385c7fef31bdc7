#!/usr/bin/env bash
# openrainflow 1.0.0: `use_cutoff=False`, which leaves no range without damage, does not continue the curve
# below the cut-off limit: the life there is 0 cycles instead of infinitely many, and one harmless cycle
# makes the damage of the whole record infinite. A limit of its own below all ranges,
# `FatigueCurve(..., delta_sigma_L=1.0)`, continues the curve.
#
# Seen of 20 MPa with detail category 71 (limit 28.7 MPa): 0 cycles, with a lower limit 6.12e8 cycles; a
# record of 1000 cycles of 100 MPa and one of 1 MPa: damage inf, with the cut-off 0.0014.
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet openrainflow==1.0.0 matplotlib==3.11.2 numpy==2.4.6
cd "$folder"
"$folder/env/bin/python" -W ignore - <<'PYTHON'
import numpy as np
from openrainflow import EurocodeCategory, FatigueCurve, calculate_damage, rainflow_count

curve = EurocodeCategory.get_curve("71")
continued = FatigueCurve("71", 71.0, delta_sigma_L=1.0)
lives = [float(each.get_cycles_to_failure(20.0, use_cutoff=False)) for each in (curve, continued)]
print(f"limit {curve.delta_sigma_L:.1f} MPa, life at 20 MPa {lives[0]}, with a lower limit {lives[1]:.4g} cycles")
record = np.append(np.tile([0.0, 100.0], 1000), [99.0, 100.0, 0.0])
cycles = rainflow_count(record)
damages = [float(calculate_damage(cycles, curve, use_cutoff=cutoff)) for cutoff in (False, True)]
print("damage without cut-off", damages[0], "with it", round(damages[1], 4))
assert lives[0] == 0.0
assert abs(lives[1] / (1e8 * (curve.delta_sigma_L / 20.0) ** 5) - 1.0) < 1e-9
assert damages[0] == np.inf
assert abs(damages[1] - 1000 / (2e6 * 0.71**3)) < 1e-5
PYTHON
