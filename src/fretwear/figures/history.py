"""Results over the cycles: a line for each point of a study."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize, to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fretwear.arrays import Array
from fretwear.data.effects import (
    BOOKKEEPING,
    LEAST_SEEDS,
    SEED,
    final_results,
    rank_correlations,
    varied_names,
)
from fretwear.figures.axes import (
    ParameterAxis,
    Value,
    ValueAxis,
    add_scale,
    make_panels,
    outside_key,
    set_cycle_axis,
)
from fretwear.figures.datasets import check_dataset, history_of, require, variable_of
from fretwear.figures.style import (
    CATEGORICAL,
    LINE_STYLES,
    MUTED,
    Columns,
    caption,
    root_figure,
    sequential_colormap,
    sequential_colours,
    styled,
)
from fretwear.results import POINT, PointStatus, Variable
from fretwear.study.parameters import parameter, symbol_text, words_text
from fretwear.units import in_unit, listed

MOST_KEYED = 8
"""Largest number of levels with a key; more levels have a colour bar."""

_MOST_PANELS, _MOST_ACROSS = 12, 3
_MOST_VECTORS = 300  # lines; more are drawn as pixels
_MOST_CONTRASTS = 2
_CONSTANT = 1e-3
_JUMP, _STEEPER = 0.02, 4.0
# A result that every contact has at every cycle.
_ALWAYS = "contact_half_width_x"


@dataclass(frozen=True)
class Curve:
    """One point of a study, or the mean of points that differ in their seed, over the cycles."""

    place: tuple[int, ...]  # along each dimension of the study
    cycles: Array
    values: Array  # NaN where undefined
    deviation: Array | None = None  # standard deviation of a mean


def levels_of(dataset: xr.Dataset, name: str) -> list[Value]:
    """Return the values of a parameter along its dimension; drawn ones with three digits."""
    about, values = dataset[name].attrs, dataset[name].values.tolist()
    if "drawn_from" in about:
        values = [float(f"{value:.3g}") for value in values]
    return [in_unit(value, about.get("units", "")) for value in values]


def study_curves(dataset: xr.Dataset, name: str) -> list[Curve]:
    """Return a curve for each finished point of a study, at its snapshots or at its steps.

    The dataset is a merged study (varied names or ``point``, then ``cycle``), one case, or the
    history of either (…, ``step``). Raises a `ValueError` if it lacks the result.
    """
    require(dataset, name)
    if "cycle" in dataset.coords and dataset["cycle"].ndim == 0:
        dataset = dataset.expand_dims("cycle")
    dims = [dim for dim in dataset[name].dims if dim not in ("cycle", "step")]
    # A result undefined over some cycles, as without a stick zone, leaves a gap in its line.
    always = dataset[_ALWAYS if _ALWAYS in dataset else name]
    cycles, values, there = (
        array.transpose(*dims, ...).values.astype(np.float64)
        for array in xr.broadcast(dataset["cycle"], dataset[name], always)
    )
    curves = []
    for place in np.ndindex(values.shape[:-1]):
        stored = np.isfinite(there[place]) & np.isfinite(cycles[place])
        if np.isfinite(values[place][stored]).any():
            curves.append(Curve(place, cycles[place][stored], values[place][stored]))
    return curves


def _means(curves: Sequence[Curve], axis: int) -> list[Curve]:
    """Return the means of curves along one dimension, at every cycle of any of them."""
    groups: dict[tuple[int, ...], list[Curve]] = {}
    for curve in curves:
        groups.setdefault(curve.place[:axis] + curve.place[axis + 1 :], []).append(curve)
    means = []
    for place, group in groups.items():
        cycles = np.unique(np.concatenate([curve.cycles for curve in group]))
        table = np.stack([np.interp(cycles, curve.cycles, curve.values) for curve in group])
        deviation = table.std(axis=0, ddof=1) if len(group) > 1 else None
        means.append(Curve(place, cycles, table.mean(axis=0), deviation))
    return means


def with_steps(cycles: Array, values: Array) -> tuple[Array, Array]:
    """Return a curve in which jumps are steps: a corner stands before each value after a jump.

    A jump is a change by more than 2 % that is four times as steep, over the logarithm of cycles,
    as the changes before and after it: an asperity that comes into contact.
    """
    if len(cycles) < 4:
        return cycles, values
    changes = np.abs(np.diff(values))
    slopes = changes / np.maximum(np.diff(np.log1p(cycles)), 1e-12)
    around = np.concatenate([[0.0], slopes, [0.0]])
    is_jump = slopes > _STEEPER * np.maximum(around[:-2], around[2:])
    is_jump &= changes > _JUMP * np.abs(values[:-1])
    after = np.flatnonzero(is_jump) + 1
    return np.insert(cycles, after, cycles[after]), np.insert(values, after, values[after - 1])


def is_constant(dataset: xr.Dataset, name: str) -> bool:
    """Whether no curve of a result changes with the cycles, or no point has the result."""
    curves = [curve.values for curve in study_curves(dataset, name)]
    return all(np.ptp(v) <= _CONSTANT * np.nanmax(np.abs(v)) for v in curves if v.size)


@styled
def scalar_history(
    dataset: xr.Dataset,
    quantity: Variable | str,
    history: xr.Dataset | None = None,
    *,
    columns: Columns = 2,
    ax: Axes | None = None,
) -> Figure:
    """Draw any scalar result, such as ``wear_volume``, against the cycles.

    Lines go through every step of the `history`, by default that of the file from which the dataset
    was opened, or else through the snapshots. The parameter with the most values has colours, the
    next one line styles; the others have panels. Points of a study that are not done (NaN) are left
    out. Values that span more than a factor of 30 have a logarithmic axis if the result allows one;
    jumps are drawn as steps. Raises a `ValueError` if the dataset lacks the result or no point has
    a value of it, or if `ax` is given and the parameters take several panels.
    """
    check_dataset(dataset)
    name = quantity if isinstance(quantity, str) else quantity.name
    steps = history_of(dataset) if history is None else history
    steps = steps if name in steps else dataset
    curves = study_curves(steps, name)
    if not curves:
        raise ValueError(f"No point has a value of {name}: there is nothing to draw.")
    variable = quantity if isinstance(quantity, Variable) else variable_of(steps, quantity)
    dims = [str(dim) for dim in steps[name].dims if dim not in ("cycle", "step")]
    count, seeds = len(curves), steps.sizes.get(SEED, 0)
    if has_means := seeds >= LEAST_SEEDS and SEED in dims:
        # Seeds differ by chance, so their mean and deviation are shown.
        curves = _means(curves, dims.index(SEED))
        dims.remove(SEED)
    varied = [dim for dim in dims if len({c.place[dims.index(dim)] for c in curves}) > 1]
    by_size = sorted(varied, key=lambda dim: -steps.sizes[dim])
    colour, style = ([*by_size, None, None])[:2]
    if style is not None and steps.sizes[style] > len(LINE_STYLES):
        style = None
    facets = [dim for dim in varied if dim not in (colour, style)]
    while math.prod(steps.sizes[dim] for dim in facets) > _MOST_PANELS:
        facets.remove(max(facets, key=lambda dim: steps.sizes[dim]))
    rows = list(itertools.product(*(range(steps.sizes[dim]) for dim in facets)))
    rows = [row for row in rows if any(_is_at(c, dims, facets, row) for c in curves)]
    axis = ValueAxis(variable, np.concatenate([curve.values for curve in curves]))
    if ax is None:
        titles = [
            ", ".join(
                symbol_text(d, levels_of(steps, d)[i]) for d, i in zip(facets, r, strict=True)
            )
            for r in rows
        ]
        span = 1 if len(rows) == 1 else columns
        across = min(len(rows), steps.sizes[facets[-1]] if facets else 1, _MOST_ACROSS)
        height = 46.0 if len(rows) > across else 56.0
        figure, panels = make_panels(span, titles, across, (16.0, height))
    elif len(rows) == 1:
        figure, panels = root_figure(ax), [ax]
    else:
        raise ValueError(
            f"This study takes {len(rows)} panels, which do not fit into one axes: leave "
            "out ax, or select a part of the study first, for example with dataset.isel(...)."
        )
    colours, handles, labels, scale = _colours(steps, colour, curves, dims)
    cycles = [c.cycles[c.values > 0.0] if axis.is_logarithmic else c.cycles for c in curves]
    for panel, row in zip(panels, rows, strict=True):
        panel.grid(axis="y")
        for curve in curves:
            if _is_at(curve, dims, facets, row):
                place = dict(zip(dims, curve.place, strict=True))
                color, dashes = colours[place.get(colour or "", 0)], place.get(style or "", 0)
                _draw(panel, curve, axis, color, dashes, is_dense="step" in steps.dims)
                panel.get_lines()[-1].set_rasterized(count > _MOST_VECTORS)
        set_cycle_axis(panel, np.concatenate(cycles))
        axis.apply(panel.yaxis)
    _label(figure, panels, axis)
    if style:
        for dashes, level in zip(LINE_STYLES, levels_of(steps, style), strict=False):
            handles.append(Line2D([], [], color=MUTED, linestyle=dashes))
            labels.append(symbol_text(style, level))
    if scale is not None:
        bar = add_scale(figure, panels, scale[0], scale[1].label, aspect=40.0)
        scale[1].apply(bar.ax.yaxis)
    if handles and ax is not None:
        ax.legend(handles, labels)
    elif handles:
        outside_key(figure, handles, labels)
    caption(
        figure, f"{variable.label} against the number of cycles, {count} case{'s'[: count > 1]}."
    )
    if has_means:
        caption(figure, f"Mean and standard deviation over {seeds} seeds.")
    hidden = [dim for dim in varied if dim not in (colour, style, *facets)]
    if hidden:
        caption(
            figure, f"Lines that look alike differ in {listed(parameter(n).words for n in hidden)}."
        )
    return figure


def _is_at(curve: Curve, dims: Sequence[str], names: Sequence[str], at: Sequence[int]) -> bool:
    return all(curve.place[dims.index(name)] == i for name, i in zip(names, at, strict=True))


def _draw(
    panel: Axes, curve: Curve, axis: ValueAxis, color: str, style: int, *, is_dense: bool
) -> None:
    unit = axis.unit
    cycles, values = curve.cycles, curve.values
    if is_dense:
        cycles, values = with_steps(cycles, values)
    mark = "" if is_dense else "o"
    panel.plot(cycles, unit.of(values), color=color, ls=LINE_STYLES[style], marker=mark)
    if curve.deviation is not None:
        low, high = (unit.of(curve.values + sign * curve.deviation) for sign in (-1.0, 1.0))
        panel.fill_between(curve.cycles, low, high, color=color, alpha=0.2, lw=0.0)


def _label(figure: Figure, panels: Sequence[Axes], axis: ValueAxis) -> None:
    """Label the axis of a result once for all panels."""
    if len(panels) == 1:
        panels[0].set_ylabel(axis.wrapped_label(34))
    else:
        figure.supylabel(axis.label, fontsize=7.5)


def _colours(
    steps: xr.Dataset, colour: str | None, curves: Sequence[Curve], dims: Sequence[str]
) -> tuple[list[str], list[Line2D], list[str], tuple[ScalarMappable, ParameterAxis] | None]:
    """Return a colour for each level along a dimension, with a key or a colour bar."""
    if colour is None:
        return [CATEGORICAL[0]], [], [], None
    names, size = [colour], steps.sizes[colour]
    if colour not in steps.coords or colour == POINT.name:
        along = [str(n) for n, about in steps.coords.items() if about.dims == (colour,)]
        names = [n for n in along if n not in BOOKKEEPING and len(set(levels_of(steps, n))) > 1]
    levels = {name: levels_of(steps, name) for name in names}
    numeric = {n: v for n, v in levels.items() if not any(isinstance(one, str) for one in v)}
    if size > MOST_KEYED and numeric:
        last = np.array([[curve.values[-1]] for curve in curves])
        shown = [curve.place[dims.index(colour)] for curve in curves]
        table = np.array([np.asarray(v, dtype=np.float64)[shown] for v in numeric.values()]).T
        influence = np.abs(rank_correlations(table, last)[:, 0])
        name = [*numeric][int(np.argmax(np.nan_to_num(influence)))]
        axis = ParameterAxis(name, numeric[name])
        places = axis.places(numeric[name])
        norm = (LogNorm if axis.is_logarithmic else Normalize)(places.min(), places.max())
        tints = [to_hex(tint) for tint in sequential_colormap()(norm(places))]
        return tints, [], [], (ScalarMappable(norm, sequential_colormap()), axis)
    tints = [CATEGORICAL[i % len(CATEGORICAL)] for i in range(size)]
    if names == [colour] and numeric:
        order = np.argsort(numeric[colour])
        tints = [sequential_colours(size)[i] for i in np.argsort(order)]
    labels = [", ".join(symbol_text(n, v[i]) for n, v in levels.items()) for i in range(size)]
    shown = sorted({curve.place[dims.index(colour)] for curve in curves})
    handles = [Line2D([], [], color=tints[i]) for i in shown]
    return tints, handles, [labels[i] for i in shown], None


@dataclass(frozen=True)
class RepresentativeCases:
    """Cases that differ in some names and agree, where possible, in the others."""

    contrasts: tuple[str, ...]  # the names in which they differ
    ids: dict[str, str]  # by title, such as ``smooth, elastic``; empty for a single case
    common: str  # other values, shared by all, in words


def representative_cases(summary: xr.Dataset) -> RepresentativeCases:
    """Return up to four finished cases of a merged study that has some.

    They span the extremes of roughness amplitude and plastic limit, or else of the first two other
    parameters; all other parameters have the last values with which most of them are done. In a
    study by points, they are the cases of least and most wear.
    """
    done, ids = summary["status"] == PointStatus.DONE, summary["case_id"]
    dims = [str(dim) for dim in summary["status"].dims]
    if POINT.name in dims:
        last = final_results(summary)["wear_volume"]
        order = [int(i) for i in np.argsort(last) if np.isfinite(last[i]) and done[int(i)]]
        names = [n for n in varied_names(summary) if len(set(summary[n].values.tolist())) > 1]
        chosen = dict.fromkeys([order[0], order[-1]])
        titles = [
            ", ".join(symbol_text(n, levels_of(summary, n)[i]) for n in names) for i in chosen
        ]
        return RepresentativeCases(
            tuple(names[:_MOST_CONTRASTS]),
            {title: str(ids[i].item()) for title, i in zip(titles, chosen, strict=True)},
            "",
        )
    varied = [dim for dim in dims if summary.sizes[dim] > 1]
    preferred = [n for n in ("roughness_amplitude", "roughness", "plastic_limit") if n in varied]
    contrasts = tuple(dict.fromkeys([*preferred, *varied]))[:_MOST_CONTRASTS]
    ends = {}
    for name in contrasts:
        values = levels_of(summary, name)
        is_text = any(isinstance(value, str) for value in values)
        order = [*range(len(values))] if is_text else [int(i) for i in np.argsort(values)]
        ends[name] = [order[0], order[-1]]
    corners = done.isel(ends)
    others = {n: range(summary.sizes[n] - 1, -1, -1) for n in dims if n not in contrasts}
    best = max(
        (dict(zip(others, at, strict=True)) for at in itertools.product(*others.values())),
        key=lambda at: int(corners.isel(at).sum()),
    )
    cases = {}
    for place in itertools.product(*ends.values()):
        at = best | dict(zip(contrasts, place, strict=True))
        if done.isel(at):
            title = ", ".join(symbol_text(n, levels_of(summary, n)[at[n]]) for n in contrasts)
            cases[title] = str(ids.isel(at).item())
    common = [words_text(n, levels_of(summary, n)[i]) for n, i in best.items() if n in varied]
    return RepresentativeCases(contrasts, cases, ", ".join(common))
