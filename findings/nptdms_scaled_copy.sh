#!/usr/bin/env bash
# npTDMS 1.13.0: copying channels with scaling, by passing the channels read to `TdmsWriter.write_segment` as
# the chapter on writing shows, writes the scaled values together with the properties that scale
# them. The copy of a channel of doubles is scaled a second time when it is read; that of 16-bit
# integers, as a card records them, cannot be read. `TdmsWriter.defragment` copies both.
#
# Seen of a force of 10 N + 0.5 N per step: doubles 10, 10.5, 11 become 15, 15.25, 15.5; integers
# ValueError; defragmented 10, 10.5, 11.
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet nptdms==1.13.0 numpy==2.4.6
cd "$folder"
"$folder/env/bin/python" - <<'PYTHON'
import numpy as np
from nptdms import ChannelObject, RootObject, TdmsFile, TdmsWriter

scale = {"Scale_Type": "Linear", "Linear_Slope": 0.5, "Linear_Y_Intercept": 10.0, "Linear_Input_Source": 0xFFFFFFFF}
properties = {"NI_Number_Of_Scales": 1, "NI_Scaling_Status": "unscaled"}
properties |= {f"NI_Scale[0]_{key}": value for key, value in scale.items()}
found = {}
for kind in ("float64", "int16"):
    with TdmsWriter("recording.tdms") as writer:
        writer.write_segment([ChannelObject("rig", "force", np.arange(100, dtype=kind), properties)])
    recording = TdmsFile.read("recording.tdms")
    with TdmsWriter("copy.tdms") as writer:
        groups = recording.groups()
        channels = [channel for group in groups for channel in group.channels()]
        writer.write_segment([RootObject(recording.properties), *groups, *channels])
    TdmsWriter.defragment("recording.tdms", "defragmented.tdms")
    for path in ("recording", "copy", "defragmented"):
        try:
            found[kind, path] = TdmsFile.read(f"{path}.tdms")["rig"]["force"][:3].tolist()
        except ValueError as error:
            found[kind, path] = type(error).__name__
        print(kind, path, found[kind, path])
for kind, copied in (("float64", [15.0, 15.25, 15.5]), ("int16", "ValueError")):
    assert found[kind, "recording"] == found[kind, "defragmented"] == [10.0, 10.5, 11.0]
    assert found[kind, "copy"] == copied
PYTHON
