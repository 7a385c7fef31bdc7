#!/usr/bin/env bash
# pyuff 2.5.8: `write_sets(sets, "overwrite")` writes binary recordings (58b) into a file that cannot be read, without
# a word: the file is emptied again for the values of the first one and for the line after them, so
# that its header and values are gone, and no recording is found behind the line that remains.
# Recordings as text, and binary ones added to a new file, are complete.
#
# Seen of two recordings, friction and slip: as text both with "add" and with "overwrite", binary both with "add",
# none with "overwrite"; of a single one a file of 7 bytes is left, the line "-1".
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet pyuff==2.5.8 numpy==2.4.6
cd "$folder"
"$folder/env/bin/python" - <<'PYTHON'
from pathlib import Path

import numpy as np
import pyuff


def recording(name, binary):
    """A second of a channel at 100 Hz."""
    times = np.arange(100) / 100.0
    titles = {"id1": name, "func_type": 1, "rsp_node": 1, "rsp_dir": 1, "ref_node": 1, "ref_dir": 1}
    axes = {"abscissa_spacing": 1, "abscissa_spec_data_type": 17, "ordinate_spec_data_type": 13}
    data = {"x": times, "data": np.sin(times), "orddenom_spec_data_type": 0, "binary": binary}
    return pyuff.prepare_58(**titles, **axes, **data)


left = {}
for binary in (0, 1):
    for mode in ("add", "overwrite"):
        path = Path(f"{mode}{binary}.uff")
        pyuff.UFF(path).write_sets([recording(name, binary) for name in ("friction", "slip")], mode)
        left[binary, mode] = pyuff.UFF(path).get_set_types().tolist().count(58)
        print("binary" if binary else "text", mode, left[binary, mode], "of 2 recordings")
pyuff.UFF("one.uff").write_sets(recording("friction", 1), "overwrite")
print("a single binary recording leaves", Path("one.uff").read_bytes())
assert left.pop((1, "overwrite")) == 0
assert set(left.values()) == {2}
assert len(Path("one.uff").read_bytes()) == 7
PYTHON
