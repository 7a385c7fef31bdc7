#!/usr/bin/env bash
# fatpack 0.7.8: `find_rainflow_ranges` first moves all peaks onto 65 levels between the smallest and the
# largest load of the record (`k=64`), so that a single overload changes or removes all other
# cycles, and damage by orders of magnitude. Without overload it counts them exactly.
#
# Seen of 1000 cycles of range 0.7, 0.8 and 2.0 beside one of 100: none of 0.7, and 1000 of 1.5625 for
# both others; their sums of range^5 are 0, 28 and 0.29 times the right ones, which rainflow 3.2.0
# finds.
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet fatpack==0.7.8 rainflow==3.2.0 numpy==2.4.6
cd "$folder"
"$folder/env/bin/python" - <<'PYTHON'
import fatpack
import numpy as np
import rainflow

found = []
for size in (0.7, 0.8, 2.0):
    cycles = np.tile([0.0, size], 1000)
    for record in (cycles, np.append([0.0, 100.0], cycles)):
        ranges = fatpack.find_rainflow_ranges(record)
        small = ranges[ranges < 50.0]
        overloaded = len(record) > len(cycles)
        counted = {float(length): count for length, count in rainflow.count_cycles(record)}
        ratio = np.sum(small**5) / (1000 * size**5)
        print(f"range {size}, overload {overloaded}: rainflow {counted}, fatpack {len(small)} of", end=" ")
        print(*{*small.round(4).tolist()}, f"with {ratio:.3g} times the sum of range^5")
        assert 999.0 <= counted[size] <= 1000.0
        if overloaded:
            found.append(ratio.round(2))
        else:
            assert abs(ratio - 1.0) < 2e-3
assert found == [0.0, 28.42, 0.29]
PYTHON
