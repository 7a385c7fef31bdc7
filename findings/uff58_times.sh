#!/usr/bin/env bash
# Universal file format 58, as text (pyuff 2.5.8): "double precision" holds for the values of a recording, not
# for its times, which have six digits (E13.5). Of a recording with a time for each sample, which is what
# pyuff writes unless `abscissa_spacing=1` is set, many samples share a time after a few minutes, and
# rates computed from them are infinite. With even spacing the step has six digits.
#
# Seen at 1 kHz from 1980 s on: 20000 samples at 2001 different times, values right to 5e-13; the binary form
# (58b) keeps all times. A rate of 3000 Hz comes back as 3000.003 Hz, 3.6 ms or 11 samples in an hour.
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet pyuff==2.5.8 numpy==2.4.6
cd "$folder"
"$folder/env/bin/python" - <<'PYTHON'
import numpy as np
import pyuff


def copy(path, times, **settings):
    """Times and values of a recording that has been written and read."""
    nodes = {"func_type": 1, "rsp_node": 1, "rsp_dir": 1, "ref_node": 1, "ref_dir": 1}
    kinds = {"abscissa_spec_data_type": 17, "ordinate_spec_data_type": 13, "orddenom_spec_data_type": 0}
    pyuff.UFF(path).write_sets(pyuff.prepare_58(**nodes, **kinds, x=times, data=np.sin(times), **settings), "add")
    read = pyuff.UFF(path).read_sets()
    return read["x"], read["data"]


times = 1980.0 + np.arange(20000) / 1000.0
distinct = []
for path, binary in (("text.uff", 0), ("binary.uff", 1)):
    read, values = copy(path, times, binary=binary)
    error = np.abs(values - np.sin(times)).max()
    distinct.append(len(np.unique(read)))
    print(path, len(read), "samples at", distinct[-1], f"times, error of the values {error:.0e}")
    assert error < 1e-11
read, _ = copy("even.uff", np.arange(6000) / 3000.0, binary=0, abscissa_spacing=1)
rate = 1.0 / (read[1] - read[0])
print(f"even spacing: 3000 Hz comes back as {rate:.3f} Hz")
assert distinct == [2001, 20000]
assert abs(rate - 1.0 / 3.33333e-4) < 1e-4
PYTHON
