"""Keys outside the axes of a figure, in as many columns as its width holds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.legend import Legend

Place = Literal["outside upper left", "outside lower left"]
"""Where a key stands, as matplotlib's legends name it."""


def outside_key(
    figure: Figure,
    handles: Sequence[Artist],
    labels: Sequence[str],
    place: Place = "outside upper left",
    handlelength: float = 2.4,
) -> Legend:
    """Add a key above or below the axes that is no wider than the figure.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        A figure with constrained layout.
    handles, labels : sequences
        What the key shows, and what it says.
    place : {"outside upper left", "outside lower left"}
        Where it stands.
    handlelength : float
        Length of the handles in font sizes.
    """
    key: Legend
    for columns in range(len(labels), 0, -1):
        key = figure.legend(
            handles, labels, loc=place, ncols=columns, handlelength=handlelength, columnspacing=1.0
        )
        width = key.get_window_extent().width
        if width <= figure.bbox.width or columns == 1:
            break
        key.remove()
    return key
