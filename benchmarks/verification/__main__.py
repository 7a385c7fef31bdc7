"""The page docs/verification.md: run ``python -m benchmarks.verification``."""

import sys
from itertools import chain

from benchmarks.pages import Data, Page, table
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
)

TABLE = (closed_forms, limiting_state, tangential, peers, rings, explicit, directions)

INTRODUCTION = """\
# Verification

These errors are numerical; [limits](explanation/limits.md) lists what the model leaves out, [experiments](experiments.md) compares scars. `python -m benchmarks.verification` repeats the checks
in about {minutes} of one core (extras `test` and `bench`; {versions}).
"""


def lead(data: Data) -> str:
    """The page below its introduction."""
    rows = chain.from_iterable(part.rows(data[part.SECTION.name]) for part in TABLE)
    return f"""\
## Theory

After very many cycles a smooth elastic contact stops wearing: the stick zone carries the whole load, and pressure and scar have closed forms
(lines). Points are computed after 30000 cycles.

![Pressure and wear depth along x: points on lines](images/verification/limiting_state.svg)

## Largest deviations

Steel on steel, R = 10 mm, P = 50 N, µ = 0.5, K_w = 7e-13 / Pa (a = 149 µm, p0 = 1081 MPa), `slip_model: jaeger` except in the last two rows. X is
Q/µP; τ = 4 K_w µ κ p0 N is 55 after 30000 cycles. Cells are a/110 to a/330 wide, a/14 and a/16 against dense and explicit solutions. Bodies
yield at 4500 MPa in a narrow band at the edge of the stick zone. Default settings compute such a sphere on rings if cells would miss the band.

{table(["what", "against", "largest deviation"], rows, left=3)}

Late energy deviates most on a self-affine surface; on smooth and wavy ones by less than 2 %. Late slip in single cells beside the edge of stick
differs by several per cent.

## Estimated against true errors

{coverage.sentence(data["coverage"])}
## What does not converge

{peak.sentence(data["peak"])}"""


PAGE = Page(
    "verification",
    INTRODUCTION,
    tuple(part.SECTION for part in (*TABLE, coverage, peak)),
    lead,
)

if __name__ == "__main__":
    sys.exit(PAGE.main())
