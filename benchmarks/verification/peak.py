"""What does not converge: the peak pressure of an elastic run."""

from benchmarks.pages import Data, Section
from benchmarks.verification.problems import snapshots
from tests.mechanics.problems import P0, fretting

CELLS = (32, 64, 128, 256)
CYCLE = 30000.0


def run() -> Data:
    found = {cells: snapshots(fretting(cells), [CYCLE])[CYCLE].measures for cells in CELLS}
    return {
        "cells": CELLS,
        "peak": [each.peak_pressure / P0 for each in found.values()],
        "central": [each.central_pressure / P0 for each in found.values()],
    }


def sentence(data: Data) -> str:
    """The paragraph of the page."""
    cells = ", ".join(f"a/{each}" for each in data["cells"])
    peaks = ", ".join(f"{each:.1f}" for each in data["peak"])
    change = 100.0 * (max(data["central"]) / min(data["central"]) - 1)
    return f"""\
The pressure of a worn elastic contact is infinite at the edge of the stick zone. Its computed peak grows about as 1/√h with the width h of cells:
after {CYCLE:.0f} cycles at X = 0.8 it is {peaks} p0 on cells of {cells}. The central pressure changes by {change:.1f} %.
"""


SECTION = Section("peak", "What does not converge: the elastic peak pressure", run)
