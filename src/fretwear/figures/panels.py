"""Grids of panels with common axes, labelled once along each side."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from matplotlib.axes import Axes
from matplotlib.figure import Figure


def make_panels(
    figure: Figure,
    count: int,
    across: int,
    share_y: Literal["row", "all"],
    share_x: Literal["row", "all"] = "all",
) -> list[Axes]:
    """Return `count` axes in rows of `across`, the last row perhaps shorter.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        The figure to divide.
    count, across : int
        Number of panels, and of panels in a row.
    share_y, share_x : {"row", "all"}
        Which panels have the same y axis, and the same x axis.
    """
    down = -(-count // across)
    grid = figure.subplots(down, across, sharex=share_x, sharey=share_y, squeeze=False)
    for axes in grid.flat[count:]:
        axes.remove()
    return list(grid.flat[:count])


def label_outer(panels: Sequence[Axes], across: int, *, every_x: bool = False) -> None:
    """Keep labels and tick labels only at the left end and the lower end of each column.

    Parameters
    ----------
    panels : sequence of matplotlib.axes.Axes
        As from `make_panels`; all have their labels.
    across : int
        Number of panels in a row.
    every_x : bool
        Whether every row has an x axis of its own, and keeps its numbers.
    """
    for index, axes in enumerate(panels):
        lowest = index + across >= len(panels)
        axes.tick_params(axis="x", which="both", labelbottom=lowest or every_x)
        if not lowest:
            axes.set_xlabel("")
        axes.tick_params(axis="y", which="both", labelleft=index % across == 0)
        if index % across:
            axes.set_ylabel("")
