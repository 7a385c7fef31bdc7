"""Pictures of one case, or of several side by side in one frame."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Literal, NamedTuple

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fretwear.figures.axes import make_panels
from fretwear.figures.datasets import Cycles, check_cases, check_dataset
from fretwear.figures.style import COLUMN_WIDTH, Columns, one_panel, styled

Shared = Literal["all", "row", "none"]


class Tiles(NamedTuple):
    """What a picture took from cases: the title of each panel, and how all of them are drawn."""

    titles: list[str]  # as many for each case
    draw: Callable[[Sequence[Axes], Axes | None], None]  # with a key; within the axes if given
    share_x: Shared = "all"
    share_y: Shared = "all"
    is_square: bool = False


Picture = Callable[[Mapping[str, xr.Dataset], Cycles], Tiles]
"""Takes cases by their titles, and the cycles to draw."""


@styled
def draw_cases(
    cases: Mapping[str, xr.Dataset],
    picture: Picture,
    cycles: Cycles = None,
    *,
    columns: Columns = 2,
    ax: Axes | None = None,
) -> Figure:
    """Draw a picture of several cases by the titles of their panels, or of one case, into `ax`."""
    check_cases(cases)
    tiles = picture(cases, cycles)
    if len(tiles.titles) == 1:
        narrow, wide = (80.0, 144.0) if tiles.is_square else (66.0, 90.0)
        figure, panel = one_panel(columns, narrow if columns == 1 else wide, ax)
        panel.set_title(tiles.titles[0])
        tiles.draw([panel], ax)
        return figure
    per_case = len(tiles.titles) // len(cases)
    across = per_case if per_case > 1 else min(len(cases), columns)
    row = (COLUMN_WIDTH[columns] - 34.0) / across + 6.0 if tiles.is_square else 50.0
    figure, panels = make_panels(
        columns, tiles.titles, across, (16.0, row), tiles.share_y, tiles.share_x
    )
    tiles.draw(panels, None)
    return figure


def draw_case(
    dataset: xr.Dataset, picture: Picture, cycles: Cycles, columns: Columns, ax: Axes | None
) -> Figure:
    """Draw a picture of one case, in a figure of its own or into `ax`."""
    check_dataset(dataset)
    return draw_cases({"": dataset}, picture, cycles, columns=columns, ax=ax)
