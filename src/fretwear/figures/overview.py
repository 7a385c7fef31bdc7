"""One case at a glance."""

from __future__ import annotations

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fretwear.figures.direct_labels import label_curves
from fretwear.figures.half_profile import half_profiles
from fretwear.figures.maps import depth_scale, draw_wear_map, take_wear_map
from fretwear.figures.profile_drawing import cycle_colors, cycle_key, draw_profiles
from fretwear.figures.profile_kinds import GAP, PRESSURE, SHEAR, WEAR
from fretwear.figures.profiles import Cycles
from fretwear.figures.style import (
    JournalFigure,
    styled,
)
from fretwear.figures.wording import cycle_number, readable_unit, symbol_text
from fretwear.figures.zone_widths import draw_zone_widths, zone_curves

_PANELS = (PRESSURE, SHEAR, GAP, WEAR)
_HEADLINE = ("load", "tangential_ratio", "friction", "roughness_amplitude", "plastic_limit")


@styled
def overview(
    dataset: xr.Dataset, history: xr.Dataset | None = None, cycles: Cycles = None
) -> Figure:
    """Draw pressure, shear, gap and wear along x, a map of the scar and the zones over cycles.

    Parameters
    ----------
    dataset : xarray.Dataset
        One case, quarter or whole.
    history : xarray.Dataset, optional
        The case's dense history; without it the snapshots show how the zones change.
    cycles : int or sequence of int, optional
        Snapshots of the profiles; left out, at most six of those there are.

    Returns
    -------
    matplotlib.figure.Figure
        Six panels over two journal columns; the map is of the last snapshot of the case.

    Raises
    ------
    TypeError
        When `dataset` is no dataset.
    ValueError
        When `dataset` has no fields or no such snapshot.
    """
    panels = {kind: half_profiles(dataset, kind.variable, cycles) for kind in _PANELS}
    colors = cycle_colors([int(cycle) for cycle in panels[PRESSURE].cycles])
    figure = JournalFigure(2, 126.0)
    grid = figure.subplots(2, 3, width_ratios=(1.0, 1.0, 1.08))
    for axes, (kind, profiles) in zip(grid[:, :2].flat, panels.items(), strict=True):
        draw_profiles(axes, profiles, kind, colors)
    _draw_map(figure, grid[0, 2], dataset)
    widths = dataset if history is None else history
    draw_zone_widths(grid[1, 2], widths)
    grid[1, 2].set_title("Contact and stick zone")
    figure.suptitle(headline(dataset), fontsize=8, x=0.005, ha="left")
    cycle_key(figure, colors, "outside lower left")
    label_curves(grid[1, 2], zone_curves(widths))
    return figure


def headline(dataset: xr.Dataset) -> str:
    """Return the parameters that tell a case, in symbols."""
    parts = [
        symbol_text(name, dataset[name].values[()]) for name in _HEADLINE if name in dataset.coords
    ]
    return ", ".join(parts)


def _draw_map(figure: Figure, axes: Axes, dataset: xr.Dataset) -> None:
    scar = take_wear_map(dataset, None)
    unit = readable_unit(scar.depth, "m")
    image = draw_wear_map(axes, scar, unit, depth_scale([float(unit.of(scar.depth).max())]))
    axes.set_title(f"Wear depth ({unit.name}), cycle {cycle_number(scar.cycle)}")
    bar = figure.colorbar(image, ax=axes, aspect=24, fraction=0.05, pad=0.02)
    bar.outline.set_visible(False)
