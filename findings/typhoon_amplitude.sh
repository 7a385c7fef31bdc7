#!/usr/bin/env bash
# typhoon-rainflow 0.2.5: range and amplitude are exchanged in its documentation. The `threshold` of `rainflow`,
# "minimum cycle amplitude to count", is a range: cycles of half the amplitude asked for are counted. What
# `goodman_transform` returns as "equivalent range" is an amplitude: with an S-N curve of ranges, as
# in Eurocode 3, the damage at a slope of 5 is 32 times too small.
#
# Seen of cycles from 0 to 150 (amplitude 75): with a threshold of 100 all 999 are counted, with one of 151 none;
# a cycle from -100 to 100 (range 200) becomes 100.
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet typhoon-rainflow==0.2.5 numpy==2.4.6
cd "$folder"
"$folder/env/bin/python" - <<'PYTHON'
from importlib.metadata import metadata

import numpy as np
import typhoon

text = metadata("typhoon-rainflow").get_payload() or metadata("typhoon-rainflow")["Description"]
for sentence in ("minimum cycle amplitude to count", "is the equivalent range"):
    print(f"documentation: {sentence!r}", sentence in text)
    assert sentence in text
record = np.tile([0.0, 150.0], 1000)
counts = [sum(typhoon.rainflow(record, threshold=limit)[0].values()) for limit in (100.0, 151.0)]
print("cycles of amplitude 75 counted: threshold 100", counts[0], "threshold 151", counts[1])
equivalent = typhoon.goodman_transform({(-100.0, 100.0): 1.0}, m=0.3)
print("a cycle from -100 to 100 becomes", equivalent)
assert counts == [999, 0]
assert equivalent == {100.0: 1.0}
PYTHON
