#!/usr/bin/env bash
# openrainflow 1.0.0: `rainflow_count`, "based on ASTM E1049-85", misses the largest range of a record, from its
# highest peak to its lowest valley, and counts half cycles of the standard as whole ones. The
# largest range does most of the damage. A record that starts and ends at its highest peak, like the
# one for repeated histories in the standard, is counted correctly.
#
# Seen of the example of the standard: range 3 (1 cycle), 4 (1), 6 (0.5), 8 (1.5) instead of 3 (0.5), 4 (1.5),
# 6 (0.5), 8 (1), 9 (0.5), which rainflow 3.2.0 finds. Of a load from 0 to 100, -100, 50, -50, 25 and 0: largest
# range 150 instead of 200, with 0.24 times the sum of range^5.
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet openrainflow==1.0.0 matplotlib==3.11.2 rainflow==3.2.0 numpy==2.4.6
cd "$folder"
"$folder/env/bin/python" - <<'PYTHON'
import numpy as np
import openrainflow
import rainflow

records = {
    "example": [-2.0, 1.0, -3.0, 5.0, -1.0, 3.0, -4.0, 4.0, -2.0],
    "repeated": [5.0, -1.0, 3.0, -4.0, 4.0, -3.0, 1.0, -2.0, 5.0],
    "decaying": [0.0, 100.0, -100.0, 50.0, -50.0, 25.0, 0.0],
}
found = {}
for name, record in records.items():
    right = {float(length): float(count) for length, count in rainflow.count_cycles(record)}
    cycles = openrainflow.rainflow_count(np.array(record))
    lengths = np.unique(cycles["range"])
    counted = {float(length): float(cycles["count"][cycles["range"] == length].sum()) for length in lengths}
    damages = [sum(count * length**5 for length, count in counts.items()) for counts in (counted, right)]
    found[name] = counted, right, round(damages[0] / damages[1], 2)
    print(name, "openrainflow", counted, "rainflow", right, "sums of range^5", found[name][2])
assert found["example"][0] == {3.0: 1.0, 4.0: 1.0, 6.0: 0.5, 8.0: 1.5}
assert found["example"][1] == {3.0: 0.5, 4.0: 1.5, 6.0: 0.5, 8.0: 1.0, 9.0: 0.5}
assert found["repeated"][0] == found["repeated"][1]
assert max(found["decaying"][0]) == 150.0
assert max(found["decaying"][1]) == 200.0
assert found["decaying"][2] == 0.24
PYTHON
