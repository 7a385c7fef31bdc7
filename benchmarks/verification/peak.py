"""What does not converge: the peak pressure of an elastic run."""

from benchmarks.pages import Data, Section, order_of, points, slope_guide, table
from benchmarks.verification.problems import snapshots
from matplotlib.figure import Figure
from tests.mechanics.problems import P0, fretting

from fretwear.figures.style import JournalFigure, styled

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

    def line(index: int, key: str) -> list[str]:
        found = [row[key][index] for row in data["spacings"]]
        finest = order_of(spacing[-4:], found[-4:])
        return [*(f"{value:.3f}" for value in found), f"{finest:+.2f}"]

    header = ["", *(f"a/{cells}" for cells in CELLS), "exponent of h"]
    rows = [
        [f"{label}, N = {cycle:.0f}", *line(index, key)]
        for key, label in (("peak", "peak / p0"), ("central", "central / p0"))
        for index, cycle in enumerate(CYCLES)
    ]
    return f"""\
In an elastic run the pressure at the stick edge tends to that of a flat punch, infinite; a grid cuts it off as
h^−½. Smooth, elastic, X = 0.8:

{table(header, rows)}

{{figure:peak}}

Compare the central pressure, depths, volumes and radii instead; with a plastic limit the peak is the limit.
"""


@styled
def figures(data: Data) -> dict[str, Figure]:
    figure = JournalFigure(1, 62)
    axes = figure.subplots()
    spacing = [1 / row["cells"] for row in data["spacings"]]
    for index, cycle in enumerate(CYCLES):
        peaks = [row["peak"][index] for row in data["spacings"]]
        points(axes, spacing, peaks, index, f"N = {cycle:.0f}")
    slope_guide(axes, spacing[::-1], 24.0, -0.5, r"$h^{-1/2}$")
    axes.set(xscale="log", yscale="log", xlabel="spacing h/a", ylabel="peak pressure p/p0")
    axes.set_xticks([1 / 32, 1 / 64, 1 / 128, 1 / 256], ["1/32", "1/64", "1/128", "1/256"])
    axes.set_yticks([1, 2, 5, 10, 20], ["1", "2", "5", "10", "20"])
    axes.minorticks_off()
    axes.margins(x=0.12)
    axes.legend(loc="center left", bbox_to_anchor=(0.0, 0.42))
    return {"peak": figure}


SECTION = Section(
    "peak", "What does not converge: the elastic peak pressure", run, text, figures=figures
)
