"""Figures of measurements: a fit with its interval and residuals, and the cycles of a recording."""

from __future__ import annotations

import numpy as np
import xarray as xr

from fretwear.figures.axes import add_key
from fretwear.figures.colours import CATEGORICAL
from fretwear.figures.profiles import cycle_colours
from fretwear.figures.style import MUTED, JournalFigure, caption, styled
from fretwear.units import cycle_text, readable_unit
from fretwear_fit.loops import Loops

_HEIGHT = 80.0
_MOST_LOOPS = 5


@styled
def fit_figure(
    measured: xr.DataArray, predicted: xr.DataArray, fitted: xr.DataArray, places: xr.DataArray
) -> JournalFigure:
    """A measured profile or loop, the best run with an interval of 95 %, and the residuals.

    The arrays come from the groups ``observed_data``, ``posterior_predictive`` and
    ``constant_data`` of a fit.
    """
    draws = predicted.values.reshape(-1, measured.size)
    best, (low, high) = fitted.values, np.quantile(draws, (0.025, 0.975), axis=0)
    si_unit = str(measured.attrs["units"])
    along, unit = readable_unit(places.values, "m"), readable_unit(measured.values, si_unit)
    x, readings, is_profile = along.of(places.values), unit.of(measured.values), si_unit == "m"
    figure = JournalFigure(1, _HEIGHT)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    keys = upper.plot(x, readings, ".", ms=2.5, color=MUTED)
    ends = unit.of(low), unit.of(high)
    if is_profile:
        upper.fill_between(x, *ends, color=CATEGORICAL[0], alpha=0.2, lw=0)
        upper.invert_yaxis()
    else:
        upper.vlines(x, *ends, color=CATEGORICAL[0], alpha=0.2)
    line = "-" if is_profile else "_"
    keys += upper.plot(x, unit.of(best), line, ms=3, color=CATEGORICAL[0])
    upper.set_ylabel(f"{'Depth' if is_profile else 'Force'} ({unit.name})")
    upper.margins(x=0.02)
    add_key(figure, keys, ["measured", "fitted, 95 %"])
    lower.axhline(0.0, lw=0.6, color=MUTED)
    lower.plot(x, readings - unit.of(best), ".", ms=2.5, color=MUTED)
    lower.set_xlabel(f"{'Position' if is_profile else 'Displacement'} ({along.name})")
    lower.set_ylabel(f"Residual ({unit.name})")
    title = str(measured.attrs["long_name"])
    title = f"{title[:1].upper()}{title[1:]}"
    caption(figure, f"{title}: readings, fit with 95 % of its predictions, and residuals.")
    return figure


@styled
def recording_figure(loops: Loops) -> JournalFigure:
    """The displacement of a recording with its cycles, and force against displacement of some.

    Readings outside whole cycles are grey.
    """
    recording, numbers = loops.recording, loops.table["cycle"].to_numpy()
    shown = np.unique(np.linspace(0, numbers.size - 1, _MOST_LOOPS).round().astype(int))
    colors = cycle_colours(numbers[shown])
    length = readable_unit(recording.displacement, "m")
    force = readable_unit(recording.force, "N")
    x, y = length.of(recording.displacement), force.of(recording.force)
    inside = np.full(x.size, np.nan)
    for cycle in loops.cycles:
        inside[cycle] = x[cycle]
    figure = JournalFigure(1, _HEIGHT)
    upper, lower = figure.subplots(2, 1, height_ratios=(1, 2))
    keys = upper.plot(x, color=MUTED, lw=0.4) + upper.plot(inside, color=CATEGORICAL[0], lw=0.4)
    names = ["left out", f"{numbers.size} cycles"]
    for n in shown:
        cycle = loops.cycles[n]
        upper.plot(np.arange(x.size)[cycle], x[cycle], color=colors[numbers[n]], lw=0.8)
        keys += lower.plot(x[cycle], y[cycle], color=colors[numbers[n]])
        names.append(f"cycle {cycle_text(numbers[n])}")
    upper.set(xlabel="Reading", ylabel=f"Displacement ({length.name})")
    lower.set(xlabel=f"Displacement ({length.name})", ylabel=f"Force ({force.name})")
    add_key(figure, keys, names)
    caption(figure, "Displacement over the readings, and force against displacement in cycles.")
    return figure
