"""One case on a page."""

from __future__ import annotations

import json

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fretwear.figures.axes import add_scale, set_cycle_axis
from fretwear.figures.colours import CATEGORICAL
from fretwear.figures.datasets import Cycles, history_of, profiles_of, study_curves, width_names
from fretwear.figures.maps import depth_scale, draw_wear_map, take_wear_map
from fretwear.figures.profiles import cycle_colours, cycle_key, draw_filled, draw_profiles, zone_key
from fretwear.figures.style import INK, JournalFigure, styled
from fretwear.results import RESULTS
from fretwear.study.case import case_keys
from fretwear.study.keys import coordinate
from fretwear.study.parameters import symbol_text
from fretwear.units import MICROMETRE, cycle_text, in_unit, readable_unit

HALF_WIDTH_LABEL = "Half-width along x (µm)"

_PANELS = ("pressure", "shear_traction", "gap", "wear_depth")
_HEADLINE: tuple[str, ...] = ("load", "tangential_ratio", "sliding_amplitude", "friction")
_HEADLINE += ("roughness_amplitude", "plastic_limit")


@styled
def overview(dataset: xr.Dataset, cycles: Cycles = None) -> Figure:
    """Draw pressure, shear, gap and wear along x, a map of the scar, and the zones over the cycles.

    The map shows the last of these cycles; a line contact has the slip along x in its place.
    """
    panels = [profiles_of(dataset, name, cycles) for name in _PANELS]
    colors, is_filled = cycle_colours(panels[0].cycles), panels[0].is_rough
    figure = JournalFigure(2, 126.0)
    grid = figure.subplots(2, 3, width_ratios=(1.0, 1.0, 1.08))
    place, zones = grid[:, 2]
    drawn = [*zip(grid[:, :2].flat, panels, strict=True)]
    if "y" in dataset.dims:
        scar = take_wear_map(dataset, int(panels[0].cycles[-1]))
        unit = readable_unit(scar.depth, "m")
        image = draw_wear_map(place, scar, unit, depth_scale(unit.of(scar.depth.max())))
        label = f"{RESULTS['wear_depth'].label} ({unit.name})"
        place.set_title(f"{label}, cycle {cycle_text(scar.cycle)}")
        add_scale(figure, [place], image, "", aspect=24)
    else:
        drawn.append((place, profiles_of(dataset, "slip", cycles)))
    for axes, profiles in drawn:
        if is_filled:
            draw_filled(axes, profiles)
        else:
            draw_profiles(axes, profiles, colors)
    _draw_zone_widths(zones, history_of(dataset))
    zones.legend()
    figure.suptitle(_headline(dataset), fontsize=8, x=0.005, ha="left")
    if is_filled:
        zone_key(figure, panels[:1], "outside lower left")
    else:
        cycle_key(figure, colors, "outside lower left")
    return figure


def _draw_zone_widths(axes: Axes, history: xr.Dataset) -> None:
    """Draw the widths of contact and stick zone over the cycles."""
    cycles = np.atleast_1d(history["cycle"].values).astype(np.float64)
    names = width_names(history)
    for zone, name, color in zip(("contact", "stick"), names, (CATEGORICAL[0], INK), strict=True):
        for curve in study_curves(history, name):
            axes.plot(curve.cycles, MICROMETRE.of(curve.values), color=color, label=zone)
    axes.set_ylim(0.0, 1.15 * axes.dataLim.ymax)
    axes.set_ylabel("Outline radius (µm)" if names[0] == "contact_radius" else HALF_WIDTH_LABEL)
    set_cycle_axis(axes, cycles)


def _headline(case: xr.Dataset) -> str:
    """Return the parameters that identify a case, in symbols, but for those that blocks change."""
    blocks = json.loads(case.attrs.get("parameters", "{}")).get("blocks") or []
    replaced = {key for block in blocks for key in block}
    changed = replaced.union(*map(case_keys().replaced_by, replaced))
    stored = {name: case.coords.get(coordinate(name)) for name in _HEADLINE if name not in changed}
    return ", ".join(
        symbol_text(name, in_unit(value.item(), value.attrs.get("units", "")))
        for name, value in stored.items()
        if value is not None
    )
