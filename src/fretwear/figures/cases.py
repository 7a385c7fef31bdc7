"""One case on a page, and two cases laid over each other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from fretwear.data.dataset import (
    Compared,
    compared_cycles,
    compared_results,
    different_parameters,
)
from fretwear.figures.axes import ValueAxis, label_curves, outside_key, set_cycle_axis
from fretwear.figures.datasets import (
    Array,
    Cycles,
    check_cases,
    coordinate_value,
    half_profiles,
    variable_of,
)
from fretwear.figures.history import HALF_WIDTH_LABEL, draw_zone_widths
from fretwear.figures.maps import add_scale, depth_scale, draw_wear_map, take_wear_map
from fretwear.figures.profiles import (
    cycle_colors,
    cycle_key,
    draw_curves,
    draw_profiles,
    frame_of,
    is_traction,
)
from fretwear.figures.style import CATEGORICAL, LINE_STYLES, MUTED, JournalFigure, styled
from fretwear.study.parameters import symbol_text
from fretwear.units import MICROMETRE, cycle_text, number_text, readable_unit
from fretwear.vocabulary import RESULTS

_PANELS = ("pressure", "shear_traction", "gap", "wear_depth")
_HEADLINE = (
    "load",
    "tangential_ratio",
    "sliding_amplitude",
    "friction",
    "roughness_amplitude",
    "plastic_limit",
)

_COMPARED = ("pressure", "wear_depth", "wear_rate")
# These are derived from others, or say little without them.
_DERIVED = {
    "hertz_radius",
    "hertz_pressure",
    "tangential_load",
    "cell_x",
    "cell_y",
    "roughness_slope_x",
    "roughness_slope_y",
}
_MOST_TOLD = 4
_LEAST_SPREAD = 1.25
_MARGIN = 1.25
_ROOM_ABOVE = 1.05


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
        Six panels over two journal columns; the map is of the last snapshot of the case. In the
        place of the map, which a line contact has none of, is the slip along x.

    Raises
    ------
    TypeError
        When `dataset` is not a dataset.
    ValueError
        When `dataset` has no fields or no such snapshot.
    """
    panels = [half_profiles(dataset, name, cycles) for name in _PANELS]
    colors = cycle_colors(panels[0].cycles)
    figure = JournalFigure(2, 126.0)
    grid = figure.subplots(2, 3, width_ratios=(1.0, 1.0, 1.08))
    for axes, profiles in zip(grid[:, :2].flat, panels, strict=True):
        draw_profiles(axes, profiles, colors)
    place, zones = grid[:, 2]
    if "y" in dataset.dims:
        scar = take_wear_map(dataset, None)
        unit = readable_unit(scar.depth, "m")
        image = draw_wear_map(place, scar, unit, depth_scale(unit.of(scar.depth.max())))
        label = f"{RESULTS['wear_depth'].label} ({unit.name})"
        place.set_title(f"{label}, cycle {cycle_text(scar.cycle)}")
        add_scale(figure, [place], image, "", aspect=24)
    else:
        draw_profiles(place, half_profiles(dataset, "slip", cycles), colors)
    curves = draw_zone_widths(zones, dataset if history is None else history)
    zones.set_title("Contact and stick zone")
    figure.suptitle(headline(dataset), fontsize=8, x=0.005, ha="left")
    cycle_key(figure, colors, "outside lower left")
    label_curves(zones, curves, [str(curve.get_label()) for curve in curves])
    return figure


def headline(dataset: xr.Dataset) -> str:
    """Return the parameters that identify a case, in symbols."""
    return _in_symbols(dataset, _HEADLINE)


def _in_symbols(case: xr.Dataset, names: Sequence[str]) -> str:
    there = (name for name in names if name in case.coords)
    return ", ".join(symbol_text(name, coordinate_value(case[name])) for name in there)


@dataclass(frozen=True)
class _Side:
    """One of two cases, with what it is drawn in."""

    title: str
    case: xr.Dataset
    cycle: int
    style: Mapping[str, Any]
    history: xr.Dataset

    @property
    def cycles(self) -> Array:
        """The cycles of the history."""
        return np.asarray(self.history["cycle"].values, dtype=np.float64)


@styled
def compare_cases(
    cases: Mapping[str, xr.Dataset], histories: Mapping[str, xr.Dataset] | None = None
) -> Figure:
    """Lay two cases over each other: profiles, widths and volume over the cycles, ratios.

    Parameters
    ----------
    cases : mapping of str to xarray.Dataset
        Two cases, by what the key calls them.
    histories : mapping of str to xarray.Dataset, optional
        Their dense histories, by the same names; without them the snapshots are joined.

    Returns
    -------
    matplotlib.figure.Figure
        Six panels over two journal columns. Profiles and ratios are those of the last snapshot
        that both cases have (`fretwear.data.dataset.compared_cycles`).

    Raises
    ------
    TypeError
        When `cases` is not a mapping of titles to datasets.
    ValueError
        When there are not two of them, or one has no fields.
    """
    check_cases(cases, *_COMPARED)
    if len(cases) != 2:
        raise ValueError(
            f"Two cases are compared, not {len(cases)}; compare_profiles and compare_wear_maps "
            "draw more in panels."
        )
    first, second = cases.values()
    sides = [
        _Side(title, case, cycle, {"color": c, "linestyle": s}, (histories or {}).get(title, case))
        for (title, case), cycle, c, s in zip(
            cases.items(), compared_cycles(first, second), CATEGORICAL, LINE_STYLES, strict=False
        )
    ]
    figure = JournalFigure(2, 118.0)
    grid = figure.subplots(2, 3)
    for axes, name in zip(grid[0], _COMPARED, strict=True):
        _draw_profiles(axes, sides, name)
    _draw_widths(grid[1, 0], sides)
    _draw_volumes(grid[1, 1], sides)
    _draw_ratios(grid[1, 2], compared_results(first, second), sides)
    outside_key(figure, [Line2D([], [], **side.style) for side in sides], _described(sides))
    cycles = " and ".join(dict.fromkeys(cycle_text(side.cycle) for side in sides))
    figure.suptitle(f"Profiles and ratios at cycle {cycles}", fontsize=7.5, x=0.99, ha="right")
    return figure


def _described(sides: Sequence[_Side]) -> list[str]:
    """Return the titles with the parameters in which the cases differ."""
    names = different_parameters(sides[0].case, sides[1].case)
    told = [name for name in names if name not in _DERIVED][:_MOST_TOLD]
    texts = [_in_symbols(side.case, told) for side in sides]
    return [
        f"{side.title}: {text}" if text not in ("", side.title) else side.title
        for side, text in zip(sides, texts, strict=True)
    ]


def _draw_profiles(axes: Axes, sides: Sequence[_Side], name: str) -> None:
    # By the first peak it is known how much of a later, singular one is to be shown.
    both = [
        half_profiles(side.case, name, sorted({int(side.case["cycle"][0]), side.cycle}))
        for side in sides
    ]
    shown = [replace(each, cycles=each.cycles[-1:], values=each.values[-1:]) for each in both]
    frame = frame_of(both if is_traction(both[0].field) else shown)
    highest = max(float(np.nanmax(each.values)) for each in shown)
    frame = replace(frame, top=min(frame.top, _ROOM_ABOVE * highest) or frame.top)
    for side, profile in zip(sides, shown, strict=True):
        draw_curves(axes, profile, frame.unit, [{**side.style, "label": side.title}])
    frame.apply(axes, both[0].field)


def _draw_widths(axes: Axes, sides: Sequence[_Side]) -> None:
    for side in sides:
        for zone, width in (("contact", 1.1), ("stick", 0.6)):
            values = MICROMETRE.of(side.history[f"{zone}_half_width_x"].values)
            label = f"{side.title}, {zone}"
            axes.plot(side.cycles, values, lw=width, label=label, **side.style)
    axes.set_ylim(0.0, 1.1 * axes.dataLim.ymax)
    axes.set_ylabel(HALF_WIDTH_LABEL)
    axes.set_title("thick: contact, thin: stick")
    set_cycle_axis(axes, np.concatenate([side.cycles for side in sides]))


def _draw_volumes(axes: Axes, sides: Sequence[_Side]) -> None:
    cycles = np.concatenate([side.cycles for side in sides])
    volumes = np.concatenate([side.history["wear_volume"].values for side in sides])
    axis = ValueAxis.of(variable_of(sides[0].case, "wear_volume"), volumes)
    for side in sides:
        values = axis.unit.of(side.history["wear_volume"].values)
        axes.plot(side.cycles, values, label=side.title, **side.style)
    axis.set_cycles(axes, cycles, volumes)
    axis.set_limits(axes, cycles, volumes)
    axes.set_ylabel(axis.label)


def _draw_ratios(axes: Axes, results: Sequence[Compared], sides: Sequence[_Side]) -> None:
    """Draw the ratios as points about 1, each with its number."""
    shown = [result for result in results if result.ratio > 0.0 and np.isfinite(result.ratio)]
    ratios = np.array([result.ratio for result in shown])
    rows = np.arange(len(shown))[::-1]
    axes.axvline(1.0, color=MUTED, lw=0.6)
    axes.hlines(rows, np.minimum(ratios, 1.0), np.maximum(ratios, 1.0), color="#bbbbbb", lw=1.0)
    axes.plot(ratios, rows, "o", color=sides[1].style["color"], markersize=3.5, label="ratio")
    low = min(float(ratios.min(initial=1.0)), 1.0 / _LEAST_SPREAD)
    high = max(float(ratios.max(initial=1.0)), _LEAST_SPREAD)
    axes.set_xscale("log")
    axes.set_xlim(low / _MARGIN, high * _MARGIN)
    axes.set_ylim(-0.6, len(shown) - 0.4)
    axes.set_yticks(rows, [result.variable.words for result in shown])
    beside: dict[str, Any] = {"transform": axes.get_yaxis_transform(), "va": "center"}
    for row, ratio in zip(rows, ratios, strict=True):
        axes.text(1.03, row, f"×{number_text(ratio, 3)}", fontsize=6.5, **beside)
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < 50.0 * low else (1.0,)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.tick_params(axis="y", length=0)
    axes.spines["left"].set_visible(False)
    axes.set_xlabel(f"{sides[1].title} / {sides[0].title}")
