"""Half-widths of contact and stick zone of one case over the cycles."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from fretwear.figures.cycle_axis import set_cycle_axis
from fretwear.figures.direct_labels import Curve
from fretwear.figures.style import CATEGORICAL, INK
from fretwear.figures.wording import MICROMETRE

ZONES = {"contact": CATEGORICAL[0], "stick": INK}
"""The zones and their colours."""


def zone_curves(history: xr.Dataset) -> list[Curve]:
    """Return the half-widths in µm over the cycles, of a case or of its dense history."""
    cycles = np.atleast_1d(history["cycle"].values).astype(np.float64)
    return [
        Curve(cycles, MICROMETRE.of(history[f"{zone}_half_width_x"].values), zone, color)
        for zone, color in ZONES.items()
    ]


def draw_zone_widths(axes: Axes, history: xr.Dataset) -> None:
    """Draw the half-widths into axes; `zone_curves` are what labels belong to."""
    curves = zone_curves(history)
    for curve in curves:
        axes.plot(curve.x, curve.y, color=curve.color, label=curve.label)
    axes.set_ylim(0.0, 1.15 * max(float(np.nanmax(curve.y)) for curve in curves))
    axes.set_ylabel("Half-width along x (µm)")
    set_cycle_axis(axes, curves[0].x)
