"""What the simpler slip model costs: both models side by side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fretwear.figures.axes import outside_key, unit_of_axis
from fretwear.figures.datasets import half_profiles
from fretwear.figures.profiles import Frame, is_traction
from fretwear.figures.style import CATEGORICAL, INK, LINE_STYLES, MUTED, JournalFigure, styled
from fretwear.units import MICROMETRE

_PANEL_HEIGHT = 54.0
_LEAST_SHOWN = 2e-3
_PRESSURE_TOP = 1.05 * 4500e6


@styled
def compare_slip_models(
    cases: Mapping[str, Sequence[xr.Dataset]],
    histories: Mapping[str, Sequence[xr.Dataset]],
    cycle: int,
) -> Figure:
    """Draw wear volume against cycles, and slip, pressure and wear along x, for both models.

    Parameters
    ----------
    cases : mapping of str to two xarray.Dataset
        Cases by what the key calls them: first with the slip of the worn shape, then with that
        of the unworn sphere.
    histories : mapping of str to two xarray.Dataset
        Their histories.
    cycle : int
        Snapshot of the profiles.

    Returns
    -------
    matplotlib.figure.Figure
        Volumes of all cases; profiles of the first.
    """
    figure = JournalFigure(2, 14.0 + 2 * _PANEL_HEIGHT)
    (volume, slip), (pressure, wear) = figure.subplots(2, 2)
    _draw_volumes(volume, histories)
    title = next(iter(cases))
    for axes, name in ((slip, "slip"), (pressure, "pressure"), (wear, "wear_depth")):
        _draw_profiles(axes, cases[title], name, cycle)
        axes.set_title(f"{title}, cycle {cycle}")
    models = [Line2D([], [], color=MUTED, linestyle=style) for style in LINE_STYLES[:2]]
    outside_key(
        figure,
        [*models, *(Line2D([], [], color=color) for color in CATEGORICAL[: len(cases)])],
        ["slip of the worn shape", "slip of the unworn sphere", *cases],
    )
    return figure


def _draw_volumes(axes: Axes, histories: Mapping[str, Sequence[xr.Dataset]]) -> None:
    volumes = np.concatenate([h["wear_volume"].values for pair in histories.values() for h in pair])
    unit = unit_of_axis(volumes, "m3", logarithmic=True)
    for pair, color in zip(histories.values(), CATEGORICAL, strict=False):
        for history, style in zip(pair, LINE_STYLES[:2], strict=True):
            axes.plot(
                history["cycle"].values,
                unit.of(history["wear_volume"].values),
                color=color,
                linestyle=style,
            )
    axes.set_yscale("log")
    highest = float(unit.of(volumes.max()))
    axes.set_ylim(_LEAST_SHOWN * highest, 1.5 * highest)
    axes.set_xlabel("Cycle")
    axes.set_ylabel(f"Wear volume ({unit.name})")
    axes.grid(axis="y")


def _draw_profiles(axes: Axes, pair: Sequence[xr.Dataset], name: str, cycle: int) -> None:
    profiles = [half_profiles(case, name, [cycle]) for case in pair]
    field = profiles[0].field
    right = 1.08 * max(float(profile.contact_half_width[0]) for profile in profiles)
    highest = max(float(np.nanmax(p.values[0][p.x <= right])) for p in profiles)
    top = min(highest * 1.06, _PRESSURE_TOP) if is_traction(field) else highest * 1.06
    frame = Frame(0.0, right, top, field.unit or MICROMETRE)
    for profile, style in zip(profiles, LINE_STYLES[:2], strict=True):
        values = frame.unit.of(profile.values[0])
        axes.plot(MICROMETRE.of(profile.x), values, color=INK, linestyle=style)
    frame.apply(axes, field)
