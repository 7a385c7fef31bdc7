#!/usr/bin/env bash
# asammdf 8.8.28: `MDF.concatenate` of two runs, with `sync=False` or `direct_timestamp_continuation=True`,
# continues each channel group after the last sample of this group, not after the last one of the
# file. Groups that do not record until the end of a run are shifted against the others
# from the second run on. With the default, `sync=True`, the start times of the runs place all groups.
#
# Seen of two runs of 100 s in which friction was recorded from 10 s to 49 s: wear of the second run
# starts at 100 s, its friction not at 110 s but at 50 s, within the first run. With start times
# 200 s apart and `sync=True`: wear at 200 s, friction at 210 s.
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet asammdf==8.8.28 numpy==2.4.6
cd "$folder"
"$folder/env/bin/python" -W ignore - <<'PYTHON'
from datetime import UTC, datetime, timedelta

import numpy as np
from asammdf import MDF, Signal


def run(start):
    """Wear over 100 s and friction over the 40 s in the middle, at 1 Hz."""
    file, times = MDF(), np.arange(100.0)
    file.start_time = start
    file.append([Signal(times / 10.0, times, name="wear", unit="um")])
    file.append([Signal(np.full(40, 30.0), times[10:50], name="friction", unit="N")])
    return file


start, found = datetime(2026, 1, 1, tzinfo=UTC), []
for settings in ({"sync": False}, {"direct_timestamp_continuation": True}, {}):
    both = MDF.concatenate([run(start), run(start + timedelta(seconds=200))], **settings)
    found.append([float(both.get(name).timestamps[half]) for name, half in (("wear", 100), ("friction", 40))])
    print(settings or "default", "second run: wear starts at {} s, friction at {} s".format(*found[-1]))
assert found == [[100.0, 50.0], [100.0, 50.0], [200.0, 210.0]]
PYTHON
