"""Drawings of a report by plotly: the curves of the cells of its matrix, and its explorer."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from plotly.colors import sample_colorscale

from fretwear.arrays import Array
from fretwear.data.effects import (
    SEED,
    Points,
    levels_of,
    plain_unit,
    point_dims,
    point_values,
    varied_names,
)
from fretwear.data.files import MERGED_PROFILES
from fretwear.figures.colours import CATEGORICAL
from fretwear.figures.datasets import quantile_curves, study_curves
from fretwear.report.matrix import factor_text, spread_text
from fretwear.results import CASE_ID, POINT, STATUS, PointStatus
from fretwear.study.parameters import parameter, value_text, words_text
from fretwear.units import NO_UNIT, Unit, axis_label, cycle_text, number_text, readable_unit
from fretwear.variable import Variable

EXPLORED = ("pressure_profile", "shear_profile", "wear_profile")
_MOST_LINES, _MOST_CASES, _MOST_PLACES, _DIGITS = 60, 36, 6000, 4
_WIDE, _BETWEEN = 8.0, 0.04
_MARGIN = 0.05  # decades beyond the last cycle, for its label
_LAYOUT: dict[str, Any] = {
    "template": None,
    "font": {"family": "system-ui, sans-serif", "size": 13, "color": "#1b1f24"},
    "margin": {"l": 62, "r": 12, "t": 34, "b": 48},
    "paper_bgcolor": "rgba(0,0,0,0)",
    "plot_bgcolor": "rgba(0,0,0,0)",
}
_AXIS: dict[str, Any] = {
    "showgrid": False, "zeroline": False, "showline": True, "linecolor": "#5b6570", "linewidth": 1,
    "ticks": "outside", "ticklen": 4, "tickcolor": "#5b6570", "exponentformat": "power",
    "minexponent": 5, "automargin": True, "tickangle": 0, "title": {"font": {"size": 13}},
}  # fmt: skip


def rounded(values: Array) -> list[float | None]:
    """Return values with four digits, None for those that are not finite."""
    numbers = np.asarray(values, dtype=np.float64).tolist()
    return [float(f"{v:.{_DIGITS}g}") if math.isfinite(v) else None for v in numbers]


def log_ticks(values: Array) -> dict[str, object]:
    """Return a logarithmic axis with ticks at decades, or also at 2 and 5 if there are few."""
    low, high = np.log10(values.min()), np.log10(values.max())
    digits = (1.0,) if math.floor(high) - math.ceil(low) > 1 else (1.0, 2.0, 5.0)
    ticks = [d * 10.0**k for k in range(math.floor(low), math.ceil(high) + 1) for d in digits]
    return {
        "type": "log",
        "tickvals": ticks,
        "ticktext": [number_text(tick).removeprefix("1·") for tick in ticks],
    }


def _is_wide(values: Array) -> bool:
    return bool(values.size and values.min() > 0.0 and values.max() > _WIDE * values.min())


def _unit(variable: Variable, values: Array) -> Unit:
    """Return the unit of an axis; a logarithmic one needs no power of ten in it."""
    if _is_wide(values[np.isfinite(values)]):
        return plain_unit(variable, values)
    return variable.unit or readable_unit(values, variable.si_unit)


def curve(points: Points, effects: pd.DataFrame, result: str, name: str) -> dict[str, object]:
    """A final result over a parameter, with a colour for each level of a second parameter.

    Thin lines are all combinations of the others, thick ones their geometric mean; the points of a
    sample are dots with the ids of their cases. The figure is the JSON of plotly, which takes
    longer to check it than to draw.
    """
    variable, values = points.variables[result], points.results[result]
    unit = _unit(variable, values)
    of_cell = effects[(effects["result"] == result) & (effects["parameter"] == name)]
    parts = of_cell[of_cell["where"].map(len) > 0]
    others = [parameter for parameter in points.levels if parameter not in (name, SEED)]
    second = next(iter(parts["where"].iloc[0] if len(parts) else others), "")
    levels_x, ticks = _places(points, name)
    traces: list[dict[str, object]] = []
    codes = {level: points.table[level].to_numpy() for level in points.levels}
    x, y = levels_x[points.place(name)], unit.of(values)
    known = np.flatnonzero(~np.isnan(y))
    if points.drawn:
        marker = {"size": 7, "color": CATEGORICAL[0]}
        xs, ys = rounded(x[known]), rounded(y[known])
        dots: dict[str, object] = {"x": xs, "y": ys, "mode": "markers", "marker": marker}
        traces.append(dots | {"customdata": [*map(str, points.table.index[known])]})
    else:
        # Points of one combination of the other parameters follow each other, in the order of x.
        rest = [codes[level] for level in points.levels if level not in (name, second)]
        known = known[np.lexsort([key[known] for key in (x, *reversed(rest))])]
        levels = points.levels[second] if second else ("",)
        factors = {next(iter(row["where"].values())): row for _, row in parts.iterrows()}
        for place, (level, color) in enumerate(zip(levels, _colours(len(levels)), strict=True)):
            here = known[codes[second][known] == place] if second else known
            label = value_text(second, level) if second else variable.label
            if level in factors:
                spread = spread_text(factors[level])
                label += f"  ×{factor_text(factors[level]['factor'])}" + f" ({spread})" * bool(
                    spread
                )
            is_next = np.any([np.diff(key[here]) != 0 for key in rest], axis=0) if rest else []
            lines = np.split(here, np.flatnonzero(is_next) + 1)
            shown = lines[:_MOST_LINES]
            # None breaks the line between two combinations.
            thin_x, thin_y = (
                [place for line in shown for place in (*rounded(axis[line]), None)]
                for axis in (x, y)
            )
            if len(lines) > 1:
                thin = _line(thin_x, thin_y, color, 1, 4)
                traces.append(thin | {"opacity": 0.35, "showlegend": False})
            places = np.unique(x[here])
            means = np.array([_mean(y[here][x[here] == each]) for each in places])
            thick = _line(rounded(places), rounded(means), color, 3, 8)
            traces.append(thick | {"name": label})
    label = axis_label(parameter(name).words, ticks if isinstance(ticks, Unit) else NO_UNIT)
    of_x: dict[str, object] = {**_AXIS, "title": {**_AXIS["title"], "text": label}}
    if not isinstance(ticks, Unit):
        span = [-0.2, levels_x[-1] + 0.2]
        of_x |= {"tickvals": levels_x.tolist(), "ticktext": list(ticks), "range": span}
    elif _is_wide(levels_x):
        of_x |= log_ticks(levels_x)
    of_y: dict[str, object] = {**_AXIS, "rangemode": "tozero"}
    if _is_wide(y[known]):
        of_y |= log_ticks(y[known])
    layout = {
        **_titled(variable, unit),
        "showlegend": bool(second) and not points.drawn,
        "legend": {
            "title": {"text": parameter(second).words if second else "", "side": "top"},
            "font": {"size": 12},
            "orientation": "h", "y": -0.24, "yanchor": "top", "x": 0,
        },
        "xaxis": of_x,
        "yaxis": of_y,
    }  # fmt: skip
    return {"data": [{"type": "scatter", **trace} for trace in traces], "layout": layout}


def _titled(variable: Variable, unit: Unit) -> dict[str, Any]:
    """Return a layout with the words of a result as title."""
    title = {"text": axis_label(variable.words, unit), "x": 0, "xref": "paper"}
    return {**_LAYOUT, "height": 390, "title": title | {"font": {"size": 15}}}


def courses(points: Points, history: xr.Dataset, result: str) -> dict[str, object]:
    """A result of a sample over the cycles: its median over bands that hold 50 % and 80 %.

    The ``curves`` of all points are under the ids of their cases, for the last trace, still empty.
    """
    variable, curves = points.variables[result], study_curves(history, result)
    cycles, quantiles = quantile_curves(curves)
    shown = cycles > 0.0
    if is_wide := _is_wide(quantiles[quantiles > 0.0]):
        shown &= quantiles[0] > 0.0
    x, unit = cycles[shown], _unit(variable, quantiles[:, shown])
    lowest, low, middle, high, highest = y = unit.of(quantiles[:, shown])
    lines: list[dict[str, Any]] = [
        {
            "x": rounded(np.append(x, x[::-1])), "y": rounded(np.append(upper, lower[::-1])),
            "fill": "toself", "fillcolor": "rgba(0,114,178,0.18)", "line": {"width": 0},
            "hoverinfo": "skip",
        }
        for lower, upper in ((lowest, highest), (low, high))
    ]  # fmt: skip
    lines.append({"x": rounded(x), "y": rounded(middle), "name": "median"})
    lines.append({"x": [], "y": []})
    for line, color in zip(lines[2:], CATEGORICAL, strict=False):
        line["line"] = {"color": color, "width": 3}
    layout = {
        **_titled(variable, unit),
        "showlegend": False,
        "xaxis": {
            **_AXIS,
            **log_ticks(x),
            "title": {**_AXIS["title"], "text": "Cycle"},
            "range": [math.log10(x[0]), math.log10(x[-1]) + _MARGIN],
        },
        "yaxis": {**_AXIS, "rangemode": "tozero"} | (log_ticks(y) if is_wide else {}),
    }
    of_points, ids = {}, history[CASE_ID.name].values
    for curve in curves:
        x, y = curve.cycles[curve.cycles > 0.0], unit.of(curve.values[curve.cycles > 0.0])
        of_points[str(ids[curve.place[POINT.name]])] = {"x": rounded(x), "y": rounded(y)}
    return {
        "data": [{**line, "mode": "lines"} for line in lines],
        "layout": layout,
        "curves": of_points,
    }


def _line(x: object, y: object, color: str, width: int, dots: int) -> dict[str, object]:
    """Return a line, `width` px wide, with dots of a size in px."""
    style = {"line": {"color": color, "width": width}, "marker": {"size": dots}}
    return {"x": x, "y": y, "mode": "lines+markers", **style}


def _places(points: Points, name: str) -> tuple[Array, Unit | Sequence[str]]:
    """Return where the levels of a parameter stand, and its unit, or words for levels in words."""
    levels = points.levels[name]
    if name != SEED and all(not isinstance(v, str) and np.isfinite(v) for v in levels):
        unit = parameter(name).in_frame_of(levels[0]).unit
        return np.array([unit.of(float(level)) for level in levels]), unit
    return np.arange(len(levels), dtype=np.float64), [value_text(name, level) for level in levels]


def _mean(values: Array) -> float:
    """Return the geometric mean, in agreement with factors; the mean if a value is zero."""
    return float(np.exp(np.log(values).mean()) if (values > 0.0).all() else values.mean())


def _colours(count: int) -> Sequence[str]:
    """Return colours of levels: distinct ones for a few, a scale for many."""
    if count <= len(CATEGORICAL):
        return CATEGORICAL[:count]
    return list(sample_colorscale("Cividis", np.linspace(0, 0.95, count)))


def explorer(summary: xr.Dataset) -> dict[str, Any] | None:
    """Draw profiles of two cases side by side, with a slider for the cycle.

    The cycle chosen is drawn thick and all others thin. The ``cases`` to choose from, by their
    varied values, hold the traces of one side: at most 36 cases, evenly spread. A single case has
    no explorer.
    """
    cases = _profiles(summary)
    if len(cases) < 2:
        return None
    titles, cycles = list(cases), summary["cycle"].values
    labels = {}
    for name in EXPLORED:
        variable, largest = MERGED_PROFILES[name], float(np.nanmax(np.abs(summary[name].values)))
        unit = variable.unit or readable_unit([largest], variable.si_unit)
        labels[name] = axis_label(variable.words, unit)
        for curves in cases.values():
            curves[name] = [rounded(unit.of(row)) for row in curves[name]]
    sides = [titles[0], titles[-1]]
    shades = sample_colorscale("Blues", np.linspace(0.35, 1.0, len(cycles)))
    traces, axes = [], dict[str, Any]()
    for column, title in enumerate(sides):
        for row, name in enumerate(EXPLORED):
            first_of_row = 1 + row * len(sides)
            number = first_of_row + column if row + column else ""
            is_lowest = row == len(EXPLORED) - 1
            axes[f"xaxis{number}"] = {
                **_AXIS, "domain": _part(column, len(sides)), "anchor": f"y{number}",
                "matches": "x", "showticklabels": is_lowest,
                "title": {**_AXIS["title"], "text": "x (µm)" if is_lowest else ""},
            }  # fmt: skip
            axes[f"yaxis{number}"] = {
                **_AXIS, "domain": _part(len(EXPLORED) - 1 - row, len(EXPLORED)),
                "anchor": f"x{number}", "matches": f"y{first_of_row if row else ''}",
                "showticklabels": not column, "autorange": "reversed" if is_lowest else True,
                "title": {**_AXIS["title"], "text": "" if column else labels[name]},
            }  # fmt: skip
            for place, (cycle, shade) in enumerate(zip(cycles, shades, strict=True)):
                traces.append({
                    "type": "scatter", "mode": "lines", "name": f"cycle {cycle_text(cycle)}",
                    "x": cases[title]["x"], "y": cases[title][name][place], "showlegend": False,
                    "xaxis": f"x{number}", "yaxis": f"y{number}",
                    "line": {"color": shade, "width": 3 if cycle == cycles[-1] else 1},
                })  # fmt: skip
    each = len(EXPLORED) * len(cycles)
    contents = {
        title: {"x": [curves["x"]] * each, "y": [row for name in EXPLORED for row in curves[name]]}
        for title, curves in cases.items()
    }
    steps = [
        {
            "label": cycle_text(cycle),
            "method": "restyle",
            "args": [{"line.width": [3 if snapshot == cycle else 1 for snapshot in cycles]
                      * len(EXPLORED) * len(sides)}],
        }
        for cycle in cycles
    ]  # fmt: skip
    slider = {
        "active": len(steps) - 1,
        "steps": steps,
        "currentvalue": {"prefix": "Cycle "},
        "pad": {"t": 50},
    }
    layout = {
        **_LAYOUT, "height": 780, "hovermode": "closest",
        "margin": {**_LAYOUT["margin"], "t": 10},
        "sliders": [slider] if len(steps) > 1 else [],
    }  # fmt: skip
    return {"data": traces, "layout": layout | axes, "cases": contents}


def _part(place: int, count: int) -> list[float]:
    """Return both ends of one of `count` panels side by side in a figure of width 1."""
    size = (1.0 - _BETWEEN * (count - 1)) / count
    return [place * (size + _BETWEEN), place * (size + _BETWEEN) + size]


def _profiles(summary: xr.Dataset) -> Mapping[str, dict[str, list[Any]]]:
    """Return places in µm and profiles, a row for each cycle, of cases by their varied values."""
    dims = point_dims(summary)
    done = np.flatnonzero(point_values(summary, STATUS.name) == PointStatus.DONE)
    few = np.linspace(0, done.size - 1, min(_MOST_CASES, done.size)).astype(int)
    ids = point_values(summary, CASE_ID.name)
    varied = {n: levels_of(summary, n, point_values(summary, n)) for n in varied_names(summary)}
    rows = {name: summary[name].transpose(*dims, "cycle", "x").values for name in EXPLORED}
    flat = {name: values.reshape(ids.size, *values.shape[-2:]) for name, values in rows.items()}
    x, cases = 1e6 * summary["x"].values, {}
    for place in done[few].tolist():
        curves = {name: values[place] for name, values in flat.items()}
        # Beyond the contact and the scar there is nothing to see.
        shown = [
            np.abs(np.nan_to_num(curves[name])) for name in ("pressure_profile", "wear_profile")
        ]
        touched = np.any([row > 1e-3 * row.max() for row in shown], axis=(0, 1))
        reach = 1.15 * np.abs(x[touched]).max(initial=0.0)
        drawn = np.flatnonzero(np.abs(x) <= reach)
        drawn = drawn[:: -(-len(drawn) * few.size // _MOST_PLACES) or 1]
        words = [words_text(name, values[place]) for name, values in varied.items()]
        title = ", ".join(words) or str(ids[place])
        title += f" ({place + 1})" if title in cases else ""
        cases[title] = {"x": rounded(x[drawn])} | {n: c[:, drawn] for n, c in curves.items()}
    return cases
