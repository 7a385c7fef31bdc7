"""Bearing-area curves: how much of a rough surface lies above a height, before and after wear."""

from __future__ import annotations

import json
from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from fretwear.figures.axes import label_or_key, label_outer, make_panels, outside_key
from fretwear.figures.datasets import Cycles, check_cases, snapshots
from fretwear.figures.profiles import cycle_colors
from fretwear.figures.style import Columns, one_panel, styled
from fretwear.study.case import Case
from fretwear.units import Unit, cycle_text, readable_unit, span

Array = NDArray[np.float64]


def bearing_heights(
    dataset: xr.Dataset, cycles: Cycles = None, case: Case | None = None
) -> dict[int, Array]:
    """Return the heights of the surfaces at some cycles, the first and the last if left out.

    See `Roughness.in_contact`. A dataset does not record where the file of a measured surface is;
    its case from a study does. It is a `ValueError` when the case is smooth, or its surface is in a
    file that is not there.
    """
    states = snapshots(
        dataset, cycles, "wear_depth", "plastic_depth", default=lambda n: sorted({n[0], n[-1]})
    )
    case = case or Case(**json.loads(dataset.attrs["parameters"]))
    if case.rough is None:
        raise ValueError("A bearing-area curve describes roughness, and this case is smooth.")
    if not case.rough.is_known:
        raise ValueError("The surface of this case is in a file that the dataset does not contain.")
    axes = [axis for axis in ("x", "y") if axis in dataset.coords]
    states = states.transpose("cycle", *axes, ...)
    half_widths = [float(states[f"contact_half_width_{axis}"][-1]) for axis in axes]
    lost = (states["wear_depth"] + states["plastic_depth"]).values
    heights = case.rough.in_contact([dataset[axis].values for axis in axes], half_widths, lost)
    return {int(cycle): each for cycle, each in zip(states["cycle"].values, heights, strict=True)}


@styled
def bearing_area(
    dataset: xr.Dataset, cycles: Cycles = None, *, columns: Columns = 1, ax: Axes | None = None
) -> Figure:
    """Draw the bearing-area curves (Abbott and Firestone) of a rough surface as it wears.

    The height, that of the roughness less wear and plastic depth, is drawn over the share of the
    contact that lies above it; `cycles` left out are the first and the last snapshot. It is a
    ValueError when the case is smooth, or its surface is in a file that is not there.
    """
    curves = bearing_heights(dataset, cycles)
    figure, panel = one_panel(columns, 66.0, ax)
    unit = readable_unit(np.concatenate(list(curves.values())), "m")
    lines = _draw(panel, curves, unit)
    panel.set_ylabel(f"Height ({unit.name})")
    labels = [f"cycle {cycle_text(cycle)}" for cycle in curves]
    label_or_key(figure, panel, lines, labels, outside=ax is None)
    return figure


@styled
def compare_bearing_areas(
    cases: Mapping[str, xr.Dataset],
    known: Mapping[str, Case] | None = None,
    *,
    columns: Columns = 2,
) -> Figure:
    """Draw bearing-area curves of several cases, by title, on one scale of heights.

    `known` are the cases of the study by id, which know the files of measured surfaces.
    """
    check_cases(cases)
    curves = [
        bearing_heights(each, None, (known or {}).get(each.attrs["case_id"]))
        for each in cases.values()
    ]
    unit = readable_unit(np.concatenate([h for each in curves for h in each.values()]), "m")
    across = min(len(curves), columns)
    figure, panels = make_panels(columns, len(curves), across, (16.0, 50.0))
    for panel, title, own in zip(panels, cases, curves, strict=True):
        lines = _draw(panel, own, unit)
        panel.set_title(title)
    label_outer(panels, across)
    figure.supylabel(f"Height ({unit.name})", fontsize=7.5)
    ends = [sorted({list(own)[end] for own in curves}) for end in (0, -1)]
    outside_key(figure, lines, [f"cycle {span(each, cycle_text)}" for each in ends][: len(lines)])
    return figure


def _draw(panel: Axes, curves: Mapping[int, Array], unit: Unit) -> list[Line2D]:
    colors = cycle_colors(list(curves))
    for cycle, heights in curves.items():
        share = (np.arange(heights.size) + 0.5) / heights.size
        panel.plot(100.0 * share, unit.of(heights), color=colors[cycle], label=cycle_text(cycle))
    panel.set(xlim=(0.0, 100.0), xlabel="Bearing area (% of the contact)")
    return list(panel.get_lines())
