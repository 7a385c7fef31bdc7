#!/usr/bin/env bash
# SALib 1.6.0: `sobol.analyze` refuses values of a sample made with `calc_second_order=False` and asks
# to match the option, but it recognises them only by their number. With 3 or 7 parameters and a
# power of two, as the sampler wants it, N·(D + 2) values are also a multiple of 2·D + 2: they are
# analysed in the wrong order, and the indices look as precise as the right ones.
#
# Seen of Y = 4a + 2b + c + …, S1 of a = 0.75: 2, 4, 5 and 6 parameters are refused; 3 give S1 = 0.12,
# -0.95, -0.04 with an interval of ± 0.09, 7 give 0.35, 0.07, 0.29 …
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet SALib==1.6.0 numpy==2.4.6 scipy==1.17.1 pandas==3.1.1
cd "$folder"
"$folder/env/bin/python" -W ignore - <<'PYTHON'
import numpy as np
from SALib.analyze import sobol as analysis
from SALib.sample import sobol as sample

refused = []
for count in range(2, 8):
    problem = {"num_vars": count, "names": [*"abcdefg"[:count]], "bounds": [[0.0, 1.0]] * count}
    points = sample.sample(problem, 1024, calc_second_order=False, seed=1)
    values = points @ (4.0 / 2.0 ** np.arange(count))
    right = analysis.analyze(problem, values, calc_second_order=False, seed=1)["S1"]
    assert abs(right[0] - 0.75) < 0.06, right
    try:
        wrong = analysis.analyze(problem, values, seed=1)
    except RuntimeError:
        refused.append(count)
        continue
    print(count, "parameters: S1", *right.round(2), "taken as", *wrong["S1"].round(2))
    print("    interval of a ±", wrong["S1_conf"][0].round(2))
    assert wrong["S1"][0] + wrong["S1_conf"][0] < 0.5 < right[0]
print("refused:", refused)
assert refused == [2, 4, 5, 6]
PYTHON
