#!/usr/bin/env bash
# frictionless 5.21.0: with `bareNumber: false`, by which Table Schema lets a number carry its unit, a number
# from 0 to 1 written without the zero loses its point: ".5 um" is read as 5, ".05" as 5. Only letters and
# signs around the number ought to go. A minus keeps the point, "-.5 um" is -0.5, so that a profile of
# heights becomes wrong on one side of its mean line only. `validate` finds the table valid. Without the
# option, ".05" is 0.05; a leading point is a valid number of Table Schema.
#
# Seen: 0.5 um -> 0.5, .5 um -> 5, .05 -> 5, -.5 um -> -0.5; without the option .05 -> 0.05.
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet frictionless==5.21.0
cd "$folder"
printf '%s\n' height "0.5 um" ".5 um" ".05" "-.5 um" > table.csv
printf '%s\n' height .05 > bare.csv
"$folder/env/bin/python" - <<'PYTHON'
from frictionless import Resource, Schema


def table(path, **options):
    schema = Schema.from_descriptor({"fields": [{"name": "height", "type": "number", **options}]})
    return Resource(path=path, schema=schema)


found = [float(row["height"]) for row in table("table.csv", bareNumber=False).read_rows()]
bare = [float(row["height"]) for row in table("bare.csv").read_rows()]
valid = table("table.csv", bareNumber=False).validate().valid
print("with unit:", found, "valid:", valid, "bare:", bare)
assert found == [0.5, 5.0, 5.0, -0.5]
assert valid
assert bare == [0.05]
PYTHON
