"""One case on a page, and two cases superimposed."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from fretwear.data.dataset import compared_cycles, compared_results, different_parameters
from fretwear.figures.axes import ValueAxis, label_curves, outside_key, set_cycle_axis
from fretwear.figures.datasets import Array, Cycles, check_cases, half_profiles, variable_of
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
from fretwear.study.parameters import replaced_by, symbol_text, value_text
from fretwear.units import MICROMETRE, cycle_text, in_unit, number_text, readable_unit
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

    The map is of the last snapshot of the case; a line contact has none, in its place is the slip
    along x. The zones are those of the case's dense `history` or, without it, of the snapshots.
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


def headline(case: xr.Dataset, names: Sequence[str] = _HEADLINE) -> str:
    """Return the parameters that identify a case, in symbols, each value once that blocks give."""
    blocks = json.loads(case.attrs.get("parameters", "{}")).get("blocks") or [{}]
    replaced = {name for block in blocks for key in block for name in replaced_by(key)}
    told = []
    for known in (case[name] for name in names if name in case.coords and name not in replaced):
        name, unit = str(known.name), known.attrs.get("units", "")
        values = dict.fromkeys(block.get(name, known.item()) for block in blocks)
        first, *others = (in_unit(value, unit) for value in values)
        told.append(" → ".join([symbol_text(name, first), *(value_text(name, n) for n in others)]))
    return ", ".join(told)


@dataclass(frozen=True)
class _Side:
    """One of two cases, at one of its cycles, with what it is drawn in."""

    title: str
    case: xr.Dataset
    cycle: int
    style: Mapping[str, Any]
    history: xr.Dataset

    def over_cycles(self, name: str) -> tuple[Array, Array]:
        """The cycles of the history, and a result at each."""
        cycles, values = (np.asarray(self.history[each].values) for each in ("cycle", name))
        return cycles.astype(np.float64), values


@styled
def compare_cases(
    cases: Mapping[str, xr.Dataset], histories: Mapping[str, xr.Dataset] | None = None
) -> Figure:
    """Superimpose two cases: profiles, widths and volume over the cycles, ratios.

    The key calls the cases by their titles. Profiles and ratios are those of the last snapshot that
    both have; `histories` are their dense histories by the same titles, without which snapshots are
    joined by straight lines. More or fewer cases than two are a ValueError.
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
    (*profiles,), (widths, volumes, ratios) = figure.subplots(2, 3)
    for axes, name in zip(profiles, _COMPARED, strict=True):
        _draw_profiles(axes, sides, name)
    for side in sides:
        for zone, width in (("contact", 1.1), ("stick", 0.6)):
            cycles, values = side.over_cycles(f"{zone}_half_width_x")
            label = f"{side.title}, {zone}"
            widths.plot(cycles, MICROMETRE.of(values), lw=width, label=label, **side.style)
    widths.set_ylim(0.0, 1.1 * widths.dataLim.ymax)
    widths.set_ylabel(HALF_WIDTH_LABEL)
    widths.set_title("thick: contact, thin: stick")
    worn = [side.over_cycles("wear_volume") for side in sides]
    cycles, values = (np.concatenate(each) for each in zip(*worn, strict=True))
    set_cycle_axis(widths, cycles)
    axis = ValueAxis.of(variable_of(first, "wear_volume"), values)
    for side, (at, volume) in zip(sides, worn, strict=True):
        volumes.plot(at, axis.unit.of(volume), label=side.title, **side.style)
    axis.set_cycles(volumes, cycles, values)
    axis.set_limits(volumes, cycles, values)
    volumes.set_ylabel(axis.label)
    _draw_ratios(ratios, sides)
    names = [name for name in different_parameters(first, second) if name not in _DERIVED]
    texts = (headline(side.case, names[:_MOST_TOLD]) for side in sides)
    described = [
        f"{side.title}: {text}" if text not in ("", side.title) else side.title
        for side, text in zip(sides, texts, strict=True)
    ]
    outside_key(figure, [Line2D([], [], **side.style) for side in sides], described)
    at_cycles = " and ".join(dict.fromkeys(cycle_text(side.cycle) for side in sides))
    figure.suptitle(f"Profiles and ratios at cycle {at_cycles}", fontsize=7.5, x=0.99, ha="right")
    return figure


def _draw_profiles(axes: Axes, sides: Sequence[_Side], name: str) -> None:
    # The first peak determines how much of a later, singular one is shown.
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


def _draw_ratios(axes: Axes, sides: Sequence[_Side]) -> None:
    """Draw the ratios of results as points about 1, each with its number."""
    first, second = sides
    results = compared_results(first.case, second.case)
    shown = [result for result in results if result.ratio > 0.0 and np.isfinite(result.ratio)]
    ratios = np.array([result.ratio for result in shown])
    rows = np.arange(len(shown))[::-1]
    axes.axvline(1.0, color=MUTED, lw=0.6)
    axes.hlines(rows, np.minimum(ratios, 1.0), np.maximum(ratios, 1.0), color="#bbbbbb", lw=1.0)
    axes.plot(ratios, rows, "o", color=second.style["color"], markersize=3.5, label="ratio")
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
    axes.set_xlabel(f"{second.title} / {first.title}")
