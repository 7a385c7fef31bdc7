#!/usr/bin/env bash
# UDUNITS-2 (cf-units 3.3.1): the root in a stress intensity or a toughness becomes a factor. Exponents are
# integers, and instead of an error, what follows the integer is multiplied: "MPa m^0.5" is taken for
# MPa · m⁰ · 0.5 or · 5, that is, a pressure. A Paris law of ΔK in this unit, checked or converted by any
# program that uses UDUNITS, passes as one of stress; CF names UDUNITS as its authority for units.
# pint 0.25.3 and astropy 8.0.2 keep the root.
#
# Seen: 1 "MPa m^0.5" = 5e6 Pa, "MPa m0.5" = 5e5 Pa, "MPa m1/2" = 5e5 Pa m; pint and astropy: Pa m^0.5.
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet cf-units==3.3.1 pint==0.25.3 astropy==8.0.2
"$folder/env/bin/python" - <<'PYTHON'
import astropy.units
import cf_units
import pint

for text, other, expected in (
    ("MPa m^0.5", "Pa", 5e6),
    ("MPa m0.5", "Pa", 5e5),
    ("MPa m1/2", "Pa m", 5e5),
):
    unit = cf_units.Unit(text)
    print(f"UDUNITS: 1 {text!r} = {unit.convert(1.0, other)} {other}, definition {unit.definition}")
    assert abs(unit.convert(1.0, other) / expected - 1.0) < 1e-9
right = pint.UnitRegistry()("MPa m^0.5")
print("pint:", right.to("Pa m^0.5"), right.dimensionality)
assert right.dimensionality["[length]"] == -0.5
right = astropy.units.Unit("MPa m(1/2)")
print("astropy:", right.decompose())
assert abs(right.to("Pa m(1/2)") / 1e6 - 1.0) < 1e-9
PYTHON
