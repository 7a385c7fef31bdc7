#!/usr/bin/env bash
# pint 0.25.3 and UDUNITS-2 (cf-units 3.3.1): a cycle is the angle 2π, and angles are plain numbers, so
# 1 Hz is not one cycle per second. A test at 20 Hz for 1000 s has 3183 cycles instead of 20000, a
# rig at 60 rpm runs at 6.28 Hz, and wear per cycle times a count of cycles is the volume over 2π.
# No error is raised, since the dimensions agree. astropy 8.0.2 refuses to convert Hz to cycle/s.
#
# Seen: pint 3183.1 cycles, 6.283 Hz, 3000 mm³/cycle times 100 = 47746 mm³; UDUNITS 20 Hz = 3.183
# cycle/s, 60 rpm = 6.283 Hz; astropy UnitConversionError.
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet pint==0.25.3 cf-units==3.3.1 astropy==8.0.2
cd "$folder"
"$folder/env/bin/python" -W ignore - <<'PYTHON'
import math

import astropy.units
import cf_units
import pint

of = pint.UnitRegistry().Quantity
cycles = (of("20 Hz") * of("1000 s")).to("cycle").magnitude
speed = of("60 rpm").to("Hz").magnitude
volume = (of("3000 mm^3/cycle") * 100).to("mm^3").magnitude
print("pint:", cycles, "cycles,", speed, "Hz,", volume, "mm³")
assert math.isclose(cycles, 20_000 / (2 * math.pi))
assert math.isclose(speed, 2 * math.pi)
assert math.isclose(volume, 300_000 / (2 * math.pi))

frequency = cf_units.Unit("Hz").convert(20.0, "cycle/s")
speed = cf_units.Unit("rpm").convert(60.0, "Hz")
print("UDUNITS:", frequency, "cycle/s,", speed, "Hz")
assert math.isclose(frequency, 20 / (2 * math.pi))
assert math.isclose(speed, 2 * math.pi)

try:
    (20 * astropy.units.Hz).to("cycle/s")
except astropy.units.UnitConversionError as error:
    print("astropy:", error)
else:
    raise SystemExit("astropy converts now")
PYTHON
