"""Results over the cycles: a line for each point of a study."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize, to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullLocator

from fretwear.data.effects import (
    BOOKKEEPING,
    LEAST_SEEDS,
    SEED,
    final_results,
    levels_of,
    point_dims,
    varied_names,
)
from fretwear.figures.axes import (
    ValueAxis,
    add_key,
    add_scale,
    make_panels,
    parameter_values,
    set_cycle_axis,
)
from fretwear.figures.colours import CATEGORICAL
from fretwear.figures.datasets import (
    Curve,
    history_of,
    quantile_curves,
    require_variables,
    side_by_side,
    study_curves,
)
from fretwear.figures.style import (
    LINE_STYLES,
    MUTED,
    Columns,
    caption,
    one_panel,
    root_figure,
    sequential_colormap,
    sequential_colours,
    styled,
)
from fretwear.results import POINT, RESULTS, PointStatus
from fretwear.study.parameters import symbol_text, words_text
from fretwear.variable import Variable

MOST_KEYED = 8
"""Largest number of levels with a key; more levels have a colour bar."""

_MOST_ACROSS = 3
_MOST_CONTRASTS = 2
_CONSTANT = 1e-3
_WIDE = 10.0


@dataclass(frozen=True)
class Colours:
    """The colour of each level of a parameter, with a key by labels or with a colour bar."""

    tints: Sequence[str] = (CATEGORICAL[0],)
    key: dict[str, Line2D] = field(default_factory=dict)
    bar: ScalarMappable | None = None
    label: str = ""  # of the bar


def level_text(dataset: xr.Dataset, place: Mapping[str, int]) -> str:
    """Return the values of parameters at a place, in symbols: ``$P$ = 30 N, elastic``."""
    return ", ".join(symbol_text(n, levels_of(dataset, n)[i]) for n, i in place.items())


def _means_over_seeds(curves: Sequence[Curve]) -> list[Curve]:
    """Return the means of curves that differ in their seed alone, at every cycle of any of them."""
    groups: dict[tuple[tuple[str, int], ...], list[Curve]] = {}
    for curve in curves:
        others = tuple((name, index) for name, index in curve.place.items() if name != SEED)
        groups.setdefault(others, []).append(curve)
    means = []
    for place, group in groups.items():
        cycles, table = side_by_side(group)
        deviation = table.std(axis=0, ddof=1) if len(group) > 1 else None
        means.append(Curve(dict(place), cycles, table.mean(axis=0), deviation))
    return means


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

    Lines go through every step of the `history`, by default from the file of the dataset,
    or else through the snapshots. The parameter with the most values has colours, the
    next one line styles; the others have panels. Points of a study that are not done (NaN) are left
    out; three seeds or more are drawn by their mean and standard deviation, more than eight points
    of a sample by their median and quantiles. Values that span more than a factor of 30 have a
    logarithmic axis if the result allows one. Raises a `ValueError` if the dataset lacks the
    result, if no point has a value of it, or if `ax` is given and the parameters take several
    panels.
    """
    name = quantity if isinstance(quantity, str) else quantity.name
    steps = history_of(dataset) if history is None else history
    steps = steps if name in steps else dataset
    curves = study_curves(steps, name)
    if not curves:
        raise ValueError(f"No point has a value of {name}: there is nothing to draw.")
    variable = quantity if isinstance(quantity, Variable) else RESULTS[quantity].in_dataset(steps)
    cases = f"{len(curves)} case{'s' if len(curves) > 1 else ''}"
    sentences = [f"{variable.label} against the number of cycles, {cases}."]
    if steps.sizes.get(SEED, 0) >= LEAST_SEEDS and SEED in curves[0].place:
        curves = _means_over_seeds(curves)
        sentences.append(f"Mean and standard deviation over {steps.sizes[SEED]} seeds.")
    is_drawn = any("drawn_from" in coordinate.attrs for coordinate in steps.coords.values())
    is_sample = is_drawn and len(curves) > MOST_KEYED
    if is_sample:
        sentences[0] = sentences[0].replace(cases, f"median of {cases}")
        sentences.append("Half of the curves lie in the inner band, 80 % in both.")
    varied = [dim for dim in curves[0].place if len({curve.place[dim] for curve in curves}) > 1]
    colour, style = (*sorted(varied, key=lambda dim: -steps.sizes[dim]), "", "")[:2]
    if style and steps.sizes[style] > len(LINE_STYLES):
        style = ""
    facets = [dim for dim in varied if dim not in (colour, style)]
    indices = itertools.product(*(range(steps.sizes[dim]) for dim in facets))
    places = [dict(zip(facets, index, strict=True)) for index in indices]
    places = [place for place in places if any(curve.is_at(place) for curve in curves)]
    if ax is None:
        titles = [level_text(steps, place) for place in places]
        across = min(steps.sizes[facets[-1]] if facets else 1, _MOST_ACROSS, len(places))
        row = 46.0 if len(places) > across else 56.0
        figure: Figure
        figure, panels = make_panels(columns if facets else 1, titles, across, (16.0, row))
    elif len(places) == 1:
        figure, panels = root_figure(ax), [ax]
    else:
        raise ValueError(
            f"This study takes {len(places)} panels, which do not fit into one axes: leave "
            "out ax, or select a part of the study first, for example with dataset.isel(...)."
        )
    axis = ValueAxis(variable, np.concatenate([curve.values for curve in curves]))
    colours = _colours(steps, colour, curves) if colour and not is_sample else Colours()
    mark = "" if "step" in steps.dims else "o"
    cycles = [c.cycles[c.values > 0.0] if axis.is_logarithmic else c.cycles for c in curves]
    for panel, place in zip(panels, places, strict=True):
        panel.grid(axis="y")
        if is_sample:
            _draw_quantiles(panel, curves, axis)
        for curve in (curve for curve in curves if curve.is_at(place) and not is_sample):
            tint = colours.tints[curve.place.get(colour, 0)]
            dashes = LINE_STYLES[curve.place.get(style, 0)]
            values = axis.unit.of(curve.values)
            panel.plot(curve.cycles, values, color=tint, linestyle=dashes, marker=mark)
            if curve.deviation is not None:
                half = axis.unit.of(curve.deviation)
                band = (values - half, values + half)
                panel.fill_between(curve.cycles, *band, color=tint, alpha=0.2, lw=0.0)
        set_cycle_axis(panel, np.concatenate(cycles))
        axis.apply(panel)
    if len(panels) == 1:
        panels[0].set_ylabel(axis.wrapped_label(34))
    else:
        figure.supylabel(axis.label, fontsize=7.5)
    key = dict(colours.key)
    for index in range(steps.sizes[style] if style else 0):
        example = Line2D([], [], color=MUTED, linestyle=LINE_STYLES[index])
        key[level_text(steps, {style: index})] = example
    if colours.bar is not None:
        add_scale(figure, panels, colours.bar, colours.label, aspect=40.0)
    if key:
        add_key(ax or figure, [*key.values()], [*key])
    for sentence in sentences:
        caption(figure, sentence)
    return figure


def _draw_quantiles(panel: Axes, curves: Sequence[Curve], axis: ValueAxis) -> None:
    """Draw the median of curves over bands between their quantiles."""
    cycles, quantiles = quantile_curves(curves)
    shown = (quantiles[0] > 0.0) | (not axis.is_logarithmic)
    x, (lowest, low, middle, high, highest) = cycles[shown], axis.unit.of(quantiles[:, shown])
    tint = CATEGORICAL[0]
    for band in ((lowest, highest), (low, high)):
        panel.fill_between(x, *band, color=tint, alpha=0.2, lw=0.0)
    panel.plot(x, middle, color=tint)


@styled
def coating_life(dataset: xr.Dataset, *, ax: Axes | None = None) -> Figure:
    """Draw the cycle of wear through of a coating, with its error, against the thickness.

    The dataset is a merged study of several values of ``coating.thickness``. Coatings that are not
    worn through are left out. Raises a `ValueError` if the study has none that is.
    """
    require_variables(dataset, "worn_through_cycle", "coating_thickness")
    dims, ends = point_dims(dataset), final_results(dataset)
    varied = dataset["coating_thickness"]
    # The thickness of coatings that are varied as a whole lies along all parameters.
    along = dims.index("coating" if "coating" in dims else str((varied.dims or dims)[-1]))
    life = ends["worn_through_cycle"]
    error = ends.get("worn_through_cycle_error", np.zeros_like(life))
    life, error = (np.moveaxis(each, along, -1) for each in (life, error))
    if not np.isfinite(life).any():
        raise ValueError("No coating is worn through: there is nothing to draw.")
    rest = [dim for dim in varied.dims if dim != dims[along]]
    varied = varied.max(rest, keep_attrs=True)
    thickness, label = parameter_values(xr.Dataset({varied.name: varied}), "coating_thickness")
    figure, axes = one_panel(1, 56.0, ax)
    others, tints = [*dims[:along], *dims[along + 1 :]], itertools.cycle(CATEGORICAL)
    # Points of a sample differ in more than the thickness.
    style = "o" if POINT.name in dims else "o-"
    for place, tint in zip(np.ndindex(life.shape[:-1]), tints, strict=False):
        order = [i for i in np.argsort(thickness) if np.isfinite(life[place][i])]
        values = thickness[order], life[place][order], error[place][order]
        words = level_text(dataset, dict(zip(others, place, strict=True)))
        axes.errorbar(*values, fmt=style, color=tint, label=words or None)
    axes.set(xscale="log", yscale="log", xlabel=label, ylabel="Cycle of wear through")
    ticks = thickness[np.isfinite(life).reshape(-1, thickness.size).any(axis=0)]
    if POINT.name in dims or ticks.size > MOST_KEYED:
        ticks = np.quantile(ticks, (0.0, 0.5, 1.0), method="nearest")
    axes.set_xticks(ticks, [f"{each:.3g}" for each in ticks])
    axes.xaxis.set_minor_locator(NullLocator())
    axes.margins(0.08)
    if others:
        axes.legend()
    caption(figure, "Cycle at which the coating is first worn through, against its thickness.")
    return figure


def _colours(steps: xr.Dataset, name: str, curves: Sequence[Curve]) -> Colours:
    """Return a colour for each level along a dimension: a parameter, or ``point``.

    Many points have the colours of the first parameter with numbers.
    """
    size, names = steps.sizes[name], [name]
    if name not in steps.coords or name == POINT.name:
        lying = [str(n) for n, coordinate in steps.coords.items() if coordinate.dims == (name,)]
        names = [n for n in lying if n not in BOOKKEEPING and len(set(levels_of(steps, n))) > 1]
    numbers = {n: steps[n].values for n in names if steps[n].dtype.kind in "fiu"}
    finite = [n for n, values in numbers.items() if np.isfinite(values).all()]
    shown = sorted({curve.place[name] for curve in curves})
    if size > MOST_KEYED and finite:
        values, label = parameter_values(steps, finite[0])
        is_wide = 0.0 < values.min() < values.max() / _WIDE
        scale = (LogNorm if is_wide else Normalize)(values.min(), values.max())
        bar = ScalarMappable(scale, sequential_colormap())
        return Colours([*map(to_hex, bar.to_rgba(values))], {}, bar, label)
    tints = [CATEGORICAL[index % len(CATEGORICAL)] for index in range(size)]
    if names == [name] and numbers:
        order = np.argsort(np.argsort(numbers[name]))
        tints = [sequential_colours(size)[index] for index in order]
    lines = {i: Line2D([], [], color=tints[i]) for i in shown}
    key = {level_text(steps, dict.fromkeys(names, i)): line for i, line in lines.items()}
    return Colours(tints, key)


@dataclass(frozen=True)
class RepresentativeCases:
    """Cases that differ in some names and agree, where possible, in the others."""

    contrasts: tuple[str, ...]  # the names in which they differ
    ids: dict[str, str]  # by title, such as ``smooth, elastic``; empty for a single case
    common: str  # which cases of the study these are, in words


def representative_cases(summary: xr.Dataset) -> RepresentativeCases:
    """Return up to four finished cases of a merged study that has some; `common` counts them.

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
        shown = dict.fromkeys([order[0], order[-1]])
        chosen = {level_text(summary, dict.fromkeys(names, i)): str(ids[i].item()) for i in shown}
        ends = f"the least and the most wear of {len(order)} cases"
        return RepresentativeCases(tuple(names[:_MOST_CONTRASTS]), chosen, ends)
    varied = [dim for dim in dims if summary.sizes[dim] > 1]
    preferred = [n for n in ("roughness_amplitude", "roughness", "plastic_limit") if n in varied]
    contrasts = tuple(dict.fromkeys([*preferred, *varied]))[:_MOST_CONTRASTS]
    extremes = {}
    for name in contrasts:
        values = summary[name].values
        sizes = np.arange(values.size) if values.dtype.kind in "OUS" else values
        extremes[name] = sorted([int(np.argmin(sizes)), int(np.argmax(sizes))])
    corners = done.isel(extremes)
    others = {n: range(summary.sizes[n] - 1, -1, -1) for n in dims if n not in contrasts}
    best = max(
        (dict(zip(others, levels, strict=True)) for levels in itertools.product(*others.values())),
        key=lambda levels: int(corners.isel(levels).sum()),
    )
    cases = {}
    for corner in itertools.product(*extremes.values()):
        contrast = dict(zip(contrasts, corner, strict=True))
        if done.isel(best | contrast):
            cases[level_text(summary, contrast)] = str(ids.isel(best | contrast).item())
    common = [words_text(n, levels_of(summary, n)[i]) for n, i in best.items() if n in varied]
    count = int(done.sum())
    if len(cases) < count:
        common.append(f"{len(cases)} of {count} cases")
    return RepresentativeCases(contrasts, cases, ", ".join(common))
