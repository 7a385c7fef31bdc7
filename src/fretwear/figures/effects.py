"""Effects of the parameters of a study on its final results, Sobol indices, regimes of slip."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fretwear.data.effects import Points
from fretwear.figures.axes import (
    ParameterAxis,
    ValueAxis,
    make_logarithmic,
    make_panels,
    outside_key,
)
from fretwear.figures.datasets import variable_of
from fretwear.figures.style import (
    CATEGORICAL,
    MARKERS,
    MUTED,
    Columns,
    JournalFigure,
    caption,
    one_panel,
    sequential_colormap,
    sequential_colours,
    styled,
)
from fretwear.results import headlines
from fretwear.study.parameters import parameter, symbol_text
from fretwear.units import in_unit, readable_unit, with_unit

_ROW, _HEAD = 48.0, 16.0
_UNCHANGED = 5e-3
# Varied parameters that a fretting map may have besides the load.
WAYS = ("displacement_amplitude", "displacement_ratio")
_REGIMES = {
    "partial slip": ("o", CATEGORICAL[0]),
    "mixed": ("D", CATEGORICAL[5]),
    "gross slip": ("s", CATEGORICAL[1]),
}
_LARGEST, _SMALLEST = 11.0, 2.5


def is_changing(points: Points, result: str) -> bool:
    """Whether a final result differs between the cases of a study."""
    values = points.results.get(result, np.array([]))
    finite = values[np.isfinite(values)]
    return bool(finite.size and np.ptp(finite) > _UNCHANGED * np.abs(finite).max())


@styled
def effects(
    points: Points, quantities: Sequence[str] | None = None, *, columns: Columns = 2
) -> JournalFigure:
    """Draw final results of a study, each over the two parameters that change it most.

    The results are by default the `headlines`. The first parameter is on the x axis, at its values;
    the colour shows the second. A line is the median over all other parameters, a faint band their
    range. The points of a sampled study are dots. Results that are the same in all cases are left
    out.
    """
    names = [name for name in quantities or headlines(points.results) if is_changing(points, name)]
    figure, panels = make_panels(columns, [""] * len(names), columns, (2.0, _ROW), "none", "none")
    what = points.variables[names[0]].label if len(names) == 1 else "Results"
    caption(figure, f"{what} after the last cycle over the parameters that matter most.")
    if any(len(points.lines[points.leading(n)[0]]) and len(points.levels) > 2 for n in names):
        caption(figure, "Lines: median over all other parameters; bands: range.")
    for axes, name in zip(panels, names, strict=True):
        _draw_effect(axes, points, name)
    return figure


def _draw_effect(axes: Axes, points: Points, name: str) -> None:
    first, second = [*points.leading(name), None][:2]
    assert first is not None
    if second and not _is_numeric(points, first) and _is_numeric(points, second):
        first, second = second, first  # a line needs numbers
    values = points.results[name]
    across = ParameterAxis(first, points.levels[first])
    axis = ValueAxis(points.variables[name], values)
    x = across.places([points.levels[first][i] for i in points.place(first)])
    y = axis.unit.of(values)
    if is_joined := bool(points.lines[first]):
        levels = points.levels[second] if second else ("",)
        tints = _tints(levels)
        group = points.place(second) if second else np.zeros(len(y), dtype=int)
        for place, tint in enumerate(tints):
            at = np.unique(x[group == place])
            inside = [y[(group == place) & (x == here)] for here in at]
            known = [i for i, found in enumerate(inside) if np.isfinite(found).any()]
            bounds = np.array([np.nanquantile(inside[i], [0.0, 0.5, 1.0]) for i in known])
            if known:
                label = symbol_text(second, levels[place]) if second else ""
                axes.fill_between(
                    at[known], bounds[:, 0], bounds[:, 2], color=tint, alpha=0.12, lw=0
                )
                mark = MARKERS[place % len(MARKERS)]
                axes.plot(at[known], bounds[:, 1], color=tint, marker=mark, label=label)
        if second:
            axes.legend(fontsize=7.0, loc="best", labelspacing=0.2)
    else:
        shade, seen = MUTED, np.isfinite(y)
        if second:
            other = ParameterAxis(second, points.levels[second])
            shown = other.places([points.levels[second][i] for i in points.place(second)])
            scale = LogNorm if other.is_logarithmic else Normalize
            norm = scale(float(shown.min()), float(shown.max()))
            shade = shown[seen]
        dots = axes.scatter(
            x[seen],
            y[seen],
            8.0,
            shade,
            cmap=sequential_colormap() if second else None,
            norm=norm if second else None,
            linewidths=0.0,
        )
        if second:
            bar = axes.figure.colorbar(dots, ax=axes, aspect=25.0, pad=0.02)
            bar.outline.set_visible(False)
            other.apply(bar.ax.yaxis)
    across.apply(axes.xaxis)
    axis.apply(axes.yaxis)
    if is_joined and across.is_logarithmic and not axis.is_logarithmic and np.nanmin(y) > 0.0:
        make_logarithmic(axes.yaxis, is_wide=False)  # a proportional law stays straight
        axes.set_ylim(0.8 * np.nanmin(y), 1.25 * np.nanmax(y))
    axes.margins(x=0.06)
    axes.set_ylabel(axis.wrapped_label(30))


def _is_numeric(points: Points, name: str) -> bool:
    return all(isinstance(v, float | int) and np.isfinite(v) for v in points.levels[name])


def _tints(levels: Sequence[float | str]) -> list[str]:
    if any(isinstance(level, str) for level in levels):
        return [CATEGORICAL[i % len(CATEGORICAL)] for i in range(len(levels))]
    return sequential_colours(len(levels))


@styled
def sensitivity(points: Points, quantities: Sequence[str]) -> Figure:
    """Draw the Sobol indices of results of a sample: alone (full), with interactions (open).

    Bars are intervals of 95 %, from the covariance of the emulator's coefficients.
    """
    figure, panels = make_panels(
        2, [points.variables[name].label for name in quantities], 3, (_HEAD, 40.0), "all", "none"
    )
    caption(
        figure,
        "Sobol indices of final results: each parameter alone (full marks) and with its "
        "interactions (open marks), with intervals of 95 %.",
    )
    about = [parameter(name) for name in points.levels]
    for axes, name in zip(panels, quantities, strict=True):
        indices = points.indices[name]
        for side, middle, ends, fill in (
            (-0.15, indices.first, indices.first_range, "full"),
            (0.15, indices.total, indices.total_range, "none"),
        ):
            for place, (low, high) in enumerate(zip(*ends, strict=True)):
                color = CATEGORICAL[place % len(CATEGORICAL)]
                axes.plot([place + side] * 2, [low, high], color=color, lw=1.0)
                axes.plot(place + side, middle[place], "o", color=color, fillstyle=fill, ms=4.0)
        axes.axhline(0.0, color=MUTED, lw=0.5)
        axes.set(xlim=(-0.6, len(about) - 0.4), ylim=(-0.03, 1.03))
        axes.set_xticks(range(len(about)), [varied.symbol or varied.words for varied in about])
    figure.supylabel("Sobol index", fontsize=7.5)
    texts = [f"{varied.symbol}  {varied.words}" for varied in about]
    colors = [CATEGORICAL[place % len(CATEGORICAL)] for place in range(len(texts))]
    handles = [Line2D([], [], color=color, marker="o", ls="none") for color in colors]
    outside_key(figure, handles, texts)
    return figure


@styled
def fretting_map(summary: xr.Dataset, *, ax: Axes | None = None) -> Figure:
    """Draw the regime of sliding over load and displacement; dots grow with the wear volume.

    `summary` is a merged study that varies the load and the displacement amplitude or ratio; other
    varied parameters are shown at their first value. Slip that is partial in some snapshots and
    gross in others is mixed. The width of a dot is proportional to the cube root of the wear
    volume.
    """
    across = next(name for name in WAYS if name in summary["status"].dims)
    rest = {n: 0 for n in summary["status"].dims if n not in ("normal_load", across)}
    shown = summary.isel(rest).transpose("normal_load", across, ...)
    gross = shown["regime"].mean("cycle", skipna=True).values
    volume = shown["wear_volume"].max("cycle").values
    figure, axes = one_panel(1, 76.0, ax)
    caption(figure, "Regime of slip over load and displacement; dots grow with the wear volume.")
    axes.set(xscale="log", yscale="log")
    places = []
    for name, axis in ((across, axes.xaxis), ("normal_load", axes.yaxis)):
        units = shown[name].attrs.get("units", "")
        levels = [in_unit(value, units) for value in shown[name].values.tolist()]
        along = ParameterAxis(name, levels)
        places.append(along.places(levels))
        along.apply(axis)
    x, y = np.meshgrid(*places)
    kinds = np.where(gross == 0.0, "partial slip", np.where(gross == 1.0, "gross slip", "mixed"))
    worn, greatest = variable_of(shown, "wear_volume"), float(np.nanmax(volume))
    widths = np.maximum(_LARGEST * np.cbrt(volume / greatest), _SMALLEST)
    handles = []
    for regime, (marker, color) in _REGIMES.items():
        here = (kinds == regime) & np.isfinite(gross)
        if here.any():
            axes.scatter(x[here], y[here], widths[here] ** 2, color, marker=marker, linewidths=0.0)
            handles.append(Line2D([], [], color=color, marker=marker, ls="none", label=regime))
    axes.margins(0.15)
    unit = readable_unit(volume, worn.si_unit)
    largest = with_unit(f"{unit.of(greatest):.3g}", unit)
    title = f"width of dots: cube root of {worn.words}, at most {largest}"
    axes.legend(
        handles=handles,
        loc="lower left",
        bbox_to_anchor=(-0.02, 1.0),
        ncols=3,
        title=title,
        alignment="left",
    )
    return figure
