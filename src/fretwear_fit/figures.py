"""The figures of a fit: data with fit, interval and residuals."""

from __future__ import annotations

import numpy as np
import xarray as xr

from fretwear.figures.style import CATEGORICAL, MUTED, JournalFigure, caption, styled
from fretwear.units import readable_unit

_HEIGHT = 80.0


@styled
def fit_figure(
    measured: xr.DataArray, predicted: xr.DataArray, places: xr.DataArray
) -> JournalFigure:
    """A measured profile or loop, the fit with its interval of 95 %, and the residuals.

    The arrays come from the groups ``observed_data`` and ``posterior_predictive`` of a fit.
    """
    draws = predicted.values.reshape(-1, measured.size)
    mean, (low, high) = draws.mean(axis=0), np.quantile(draws, (0.025, 0.975), axis=0)
    si_unit = str(measured.attrs["units"])
    along, unit = readable_unit(places.values, "m"), readable_unit(measured.values, si_unit)
    x, readings, is_profile = along.of(places.values), unit.of(measured.values), si_unit == "m"
    figure = JournalFigure(1, _HEIGHT)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    upper.plot(x, readings, ".", ms=2.5, color=MUTED, label="measured")
    ends = unit.of(low), unit.of(high)
    if is_profile:
        upper.fill_between(x, *ends, color=CATEGORICAL[0], alpha=0.2, lw=0)
        upper.invert_yaxis()
    else:
        upper.vlines(x, *ends, color=CATEGORICAL[0], alpha=0.2)
    line = "-" if is_profile else "_"
    upper.plot(x, unit.of(mean), line, ms=3, color=CATEGORICAL[0], label="fitted, 95 %")
    upper.set_ylabel(f"{'Depth' if is_profile else 'Force'} ({unit.name})")
    upper.legend()
    lower.axhline(0.0, lw=0.6, color=MUTED)
    lower.plot(x, readings - unit.of(mean), ".", ms=2.5, color=MUTED)
    lower.set_xlabel(f"{'Position' if is_profile else 'Displacement'} ({along.name})")
    lower.set_ylabel(f"Residual ({unit.name})")
    title = str(measured.attrs["long_name"])
    caption(figure, f"{title}: readings, fit with 95 % of its predictions, and residuals.")
    return figure
