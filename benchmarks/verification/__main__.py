"""The page docs/verification.md: run ``python -m benchmarks.verification``."""

import platform
import sys
import time
from importlib.metadata import version

from benchmarks.pages import Data, Page
from benchmarks.verification import (
    closed_forms,
    convergence,
    coverage,
    explicit,
    limiting_state,
    peak,
    peers,
    rings,
    tangential,
    trust,
)

PARTS = (
    closed_forms,
    limiting_state,
    rings,
    tangential,
    explicit,
    convergence,
    coverage,
    peak,
    peers,
)

INTRODUCTION = """\
# Verification in detail

The tables behind [Verification](verification.md).

Unless a section says otherwise the contact is the study's: a steel sphere on a steel flat,
R = 10 mm (our choice: the study gives no radius), P = 50 N, µ = 0.5, E = 208 GPa, ν = 0.3,
K_w = 7e-13 / Pa; Hertz radius a = 148.6 µm, pressure p0 = 1081 MPa; X = Q/µP is the load ratio,
κ = E*/G*, and τ = 4 K_w µ κ p0 N the number of cycles without dimension (30000 cycles are
τ = 55.1). Spacings are given as fractions of a. "Capped" is elastic–perfectly plastic with
p ≤ 4500 MPa = 4.16 p0. Deviations are signed: computed over reference, minus one.

## Summary

{summary}

## Repeat it

`python -m benchmarks.verification` measures everything on this page in about {minutes} minutes of
one core, from the repository's root, with the package installed with its extras `test` and `bench`.
It keeps what it found in `verification.json` beside this page, and writes both pages and their
figures from that file. Names of sections ({names})
run just those, and `--render` only writes the pages.
"""


def surroundings() -> Data:
    """Versions of the software and its libraries."""
    packages = {name: version(name) for name in ("fretwear", "numpy", "scipy")}
    return {"versions": {"Python": platform.python_version(), **packages}}


def footer(entry: Data) -> str:
    """Time and versions."""
    versions = ", ".join(f"{name} {number}" for name, number in entry["versions"].items())
    return f"{entry['seconds']} s of one core; {versions}"


PAGE = Page(
    "verification",
    INTRODUCTION,
    tuple(part.SECTION for part in PARTS),
    surroundings,
    footer,
    time.process_time,
    trust.FRONT,
    "checks",
)

if __name__ == "__main__":
    sys.exit(PAGE.main())
