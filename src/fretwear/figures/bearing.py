"""Bearing-area curves: how much of a rough surface stands above a height, before and after wear."""

from __future__ import annotations

import json

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from fretwear.data.dataset import mirrored
from fretwear.figures.axes import label_or_key
from fretwear.figures.datasets import (
    Cycles,
    check_dataset,
    checked_cycles,
    require,
    with_cycles,
)
from fretwear.figures.profiles import cycle_colors
from fretwear.figures.style import Columns, one_panel, styled
from fretwear.study.case import Case
from fretwear.units import cycle_text, readable_unit

Array = NDArray[np.float64]


def bearing_heights(dataset: xr.Dataset, cycles: Cycles = None) -> dict[int, Array]:
    """Return the heights of the surfaces within the contact at some cycles, highest first.

    Heights, m, are those of roughness, less wear and plastic depth, on the cells within the area
    that is in contact on its outline at the last of the cycles; 0 is the mean of the unworn ones.

    Raises
    ------
    ValueError
        When the case is smooth, or its surface is in a file that is not there.
    """
    check_dataset(dataset)
    require(dataset, "wear_depth", "plastic_depth")
    dataset = with_cycles(dataset)
    shown = checked_cycles(dataset, cycles)
    case = Case(**json.loads(dataset.attrs["parameters"]))
    if case.rough is None:
        raise ValueError("A bearing-area curve tells of roughness, and this case is smooth.")
    if not case.rough.is_known:
        raise ValueError("The surface of this case is in a file, which is not with its dataset.")
    whole = mirrored(dataset[["wear_depth", "plastic_depth"]]).sel(cycle=list(shown))
    x, y = whole["x"].values, whole["y"].values
    last = dataset.sel(cycle=shown[-1])
    half_x, half_y = (float(last[f"contact_half_width_{axis}"]) for axis in ("x", "y"))
    inside = np.hypot(x[:, None] / half_x, y[None, :] / half_y) <= 1.0
    rough = -case.rough.height(x[:, None], y[None, :])
    lost = (whole["wear_depth"] + whole["plastic_depth"]).transpose("cycle", "x", "y").values
    level = float(rough[inside].mean())
    return {
        int(cycle): np.sort((rough - depth)[inside] - level)[::-1]
        for cycle, depth in zip(shown, lost, strict=True)
    }


@styled
def bearing_area(
    dataset: xr.Dataset, cycles: Cycles = None, *, columns: Columns = 1, ax: Axes | None = None
) -> Figure:
    """Draw the bearing-area curves (Abbott and Firestone) of a rough surface as it wears.

    Parameters
    ----------
    dataset : xarray.Dataset
        One case with roughness, of whatever symmetry.
    cycles : int or sequence of int, optional
        Snapshots to draw; left out, the first and the last.
    columns : {1, 2}
        Journal columns that the figure spans, 90 mm or 190 mm.
    ax : matplotlib.axes.Axes, optional
        Where to draw, in a figure of your own; `columns` then says nothing.

    Returns
    -------
    matplotlib.figure.Figure
        Height, that of the roughness less wear and plastic depth, over the share of the contact
        that stands above it.

    Raises
    ------
    TypeError
        When `dataset` is no dataset.
    ValueError
        When the case is smooth, a snapshot is missing, or the surface is in a file that is not
        there.
    """
    if cycles is None:
        check_dataset(dataset)
        available = np.atleast_1d(dataset["cycle"].values).astype(int)
        cycles = sorted({int(available[0]), int(available[-1])})
    curves = bearing_heights(dataset, cycles)
    figure, panel = one_panel(columns, 66.0, ax)
    unit = readable_unit(np.concatenate(list(curves.values())), "m")
    colors = cycle_colors([float(cycle) for cycle in curves])
    for cycle, heights in curves.items():
        share = (np.arange(heights.size) + 0.5) / heights.size
        panel.plot(100.0 * share, unit.of(heights), color=colors[cycle], label=cycle_text(cycle))
    panel.set(xlim=(0.0, 100.0), xlabel="Bearing area (% of the contact)")
    panel.set_ylabel(f"Height ({unit.name})")
    labels = [f"cycle {cycle_text(cycle)}" for cycle in curves]
    label_or_key(figure, panel, panel.get_lines(), labels, outside=ax is None)
    return figure
