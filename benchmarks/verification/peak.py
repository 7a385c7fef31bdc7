"""What does not converge: the peak pressure of an elastic run."""

from benchmarks.pages import Data, Section, order_of, table
from benchmarks.verification.problems import snapshots
from tests.mechanics.problems import P0, fretting

CELLS = (32, 45, 64, 91, 128, 181, 256)
CYCLES = (1000.0, 7000.0, 30000.0)


def run() -> Data:
    rows = []
    for cells in CELLS:
        found = snapshots(fretting(cells), list(CYCLES))
        rows.append(
            {
                "cells": cells,
                "peak": [found[cycle].measures.peak_pressure / P0 for cycle in CYCLES],
                "central": [found[cycle].measures.central_pressure / P0 for cycle in CYCLES],
            }
        )
    return {"spacings": rows}


def text(data: Data) -> str:
    spacing = [1 / row["cells"] for row in data["spacings"]]
    shown = [row for row in data["spacings"] if row["cells"] in (32, 64, 128, 256)]

    def line(index: int, key: str) -> list[str]:
        finest = [row[key][index] for row in data["spacings"]][-4:]
        return [
            *(f"{row[key][index]:.3f}" for row in shown),
            f"{order_of(spacing[-4:], finest):+.2f}",
        ]

    rows = [
        [f"{label}, N = {CYCLES[index]:.0f}", *line(index, key)]
        for key, label in (("peak", "peak / p0"), ("central", "central / p0"))
        for index in (0, 2)
    ]
    return f"""\
In a worn elastic contact the pressure tends to infinity at the edge of the stick zone; on a grid of spacing h its peak grows as
h^−½. X = 0.8:

{table(["", *(f"a/{row['cells']}" for row in shown), "exponent of h"], rows)}
"""


SECTION = Section("peak", "What does not converge: the elastic peak pressure", run, text)
