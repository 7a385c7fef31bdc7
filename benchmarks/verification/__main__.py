"""The page docs/verification.md: run ``python -m benchmarks.verification``."""

import sys

from benchmarks.pages import Page
from benchmarks.verification import (
    closed_forms,
    coverage,
    directions,
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
    directions,
    explicit,
    coverage,
    peak,
    peers,
)

INTRODUCTION = """\
# Verification in detail

`python -m benchmarks.verification` repeats these checks in about {minutes} of one core (extras `test` and `bench`; {versions}); it also takes
names of sections: {names}.

The contact is the [source study's](paper.md) with `slip_model: jaeger`, which has closed forms: steel on steel, R = 10 mm, P = 50 N, µ = 0.5,
E = 208 GPa, ν = 0.3, K_w = 7e-13 / Pa, hence a = 148.6 µm and p0 = 1081 MPa. X = Q/µP; τ = 4 K_w µ κ p0 N is 55 after 30000 cycles. Spacings
are fractions of a; "capped" means p ≤ 4500 MPa. Deviations are computed over reference values, less one.
"""


PAGE = Page(
    "verification",
    INTRODUCTION,
    tuple(part.SECTION for part in PARTS),
    trust.FRONT,
    "checks",
)

if __name__ == "__main__":
    sys.exit(PAGE.main())
