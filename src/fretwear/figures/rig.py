"""What a rig shows: loops of force and displacement, scars of both bodies, a fretting map."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fretwear.data.dataset import mirrored
from fretwear.figures.axes import label_or_key, parameter_label
from fretwear.figures.datasets import line_near_the_middle, snapshots, variable_of
from fretwear.figures.style import CATEGORICAL, one_panel, sequential_colours, styled
from fretwear.study.parameters import parameter
from fretwear.units import (
    FORCE_PER_LENGTH,
    MICROMETRE,
    PerLength,
    cycle_text,
    readable_unit,
    with_unit,
)
from fretwear.vocabulary import BODY_FIELDS, LOOP, RESULTS

MAPPED = ("displacement_amplitude", "displacement_ratio")
"""Varied parameters that a fretting map may have beside the load."""

_REGIMES = {
    "partial slip": ("o", CATEGORICAL[0]),
    "mixed": ("D", CATEGORICAL[5]),
    "gross slip": ("s", CATEGORICAL[1]),
}
_LARGEST, _SMALLEST = 14.0, 2.5
_APART = 0.7
"""Widest dot over the distance of neighbours, of which diamonds touch."""


@styled
def fretting_loops(
    loops: xr.Dataset, cycles: Sequence[int] | None = None, *, ax: Axes | None = None
) -> Figure:
    """Draw tangential force against displacement round a cycle, one loop for each snapshot.

    `loops` are those of `fretwear.open_loops`; `cycles` left out are all of them.
    """
    shown = snapshots(loops, cycles, *(each.name for each in LOOP), default=list)
    force, way = (shown[each.name].values for each in LOOP)
    known = LOOP[0].in_units(shown[LOOP[0].name].attrs.get("units", LOOP[0].si_unit))
    unit = readable_unit(force, known.si_unit)
    figure, axes = one_panel(1, 66.0, ax)
    names = [cycle_text(cycle) for cycle in shown["cycle"].values]
    curves = [
        axes.plot(MICROMETRE.of(x), unit.of(y), color=color)[0]
        for x, y, color in zip(way, force, sequential_colours(len(names)), strict=True)
    ]
    axes.axhline(0.0, color="0.7", linewidth=0.5, zorder=0)
    axes.axvline(0.0, color="0.7", linewidth=0.5, zorder=0)
    axes.margins(x=0.03)
    axes.set(xlabel=f"{LOOP[1].label} (µm)", ylabel=f"{known.label} ({unit.name})")
    label_or_key(figure, axes, curves, [f"cycle {names[0]}", *names[1:]], outside=ax is None)
    return figure


@styled
def scars(dataset: xr.Dataset, cycle: int | None = None, *, ax: Axes | None = None) -> Figure:
    """Draw the wear of both bodies along x: the indenter's upward, the flat's downward.

    The scar, after `cycle` or the last snapshot, is that of the whole contact, as a profilometer
    crosses it. It is a ValueError where the case has one wear coefficient for both bodies together.
    """
    names = [field.name for field in BODY_FIELDS]
    if isinstance(dataset, xr.Dataset) and names[0] not in dataset:
        raise ValueError(
            "the wear of each body is not known: give wear_coefficient as [indenter, flat]"
        )
    line = mirrored(snapshots(dataset, cycle, *names)[names].isel(cycle=-1))
    figure, axes = one_panel(1, 66.0, ax)
    x = MICROMETRE.of(line.x.values)
    for field, sign, color in zip(BODY_FIELDS, (1.0, -1.0), CATEGORICAL, strict=False):
        depth = sign * MICROMETRE.of(line_near_the_middle(line[field.name]).values)
        axes.fill_between(x, depth, color=color, alpha=0.3, linewidth=0.0)
        axes.plot(x, depth, color=color, label=field.label)
    axes.set(xlabel="x (µm), direction of slip", ylabel=f"{RESULTS['wear_depth'].label} (µm)")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    return figure


def has_fretting_map(summary: xr.Dataset) -> bool:
    """Whether a study varies a load and a displacement, and so has a fretting map."""
    return "load" in summary["status"].dims and any(n in summary["status"].dims for n in MAPPED)


@styled
def fretting_map(summary: xr.Dataset, *, ax: Axes | None = None) -> Figure:
    """Draw the regime of sliding over load and displacement; dots grow with the wear volume.

    `summary` is a merged study that varies the load and the displacement amplitude or ratio; of
    other varied parameters the first value is shown. Slip that is partial in some snapshots and
    gross in others is mixed. The width of a dot is in proportion to the cube root of the wear
    volume.
    """
    across = next(name for name in MAPPED if name in summary["status"].dims)
    rest = {n: 0 for n in summary["status"].dims if n not in ("load", across)}
    shown = summary.isel(rest).transpose("load", across, ...)
    gross = shown["regime"].mean("cycle", skipna=True).values
    volume = shown["wear_volume"].max("cycle").values
    worn = variable_of(shown, "wear_volume")
    is_line = shown["load"].attrs.get("units") == FORCE_PER_LENGTH.si_unit
    like = {across: 1.0, "load": PerLength(1.0) if is_line else 1.0}
    units = {name: parameter(name).suiting(value).unit for name, value in like.items()}
    way, load = np.meshgrid(*(unit.of(shown[name].values) for name, unit in units.items()))
    figure, axes = one_panel(1, 66.0, ax)
    kinds = np.where(gross == 0.0, "partial slip", np.where(gross == 1.0, "gross slip", "mixed"))
    dots = []
    for regime, (marker, color) in _REGIMES.items():
        here = (kinds == regime) & np.isfinite(gross)
        if here.any():
            options: dict[str, Any] = {"color": color, "marker": marker, "label": regime}
            dots.append((axes.scatter(way[here], load[here], linewidths=0.0, **options), here))
    axes.set(xscale="log", yscale="log")
    for axis, values in ((axes.xaxis, way[0]), (axes.yaxis, load[:, 0])):
        axis.set_ticks(values, [f"{value:g}" for value in values])
        axis.set_ticks([], minor=True)
    along, up = (parameter_label(name, value) for name, value in like.items())
    axes.set(xlabel=along[:1].upper() + along[1:], ylabel=up[:1].upper() + up[1:])
    axes.margins(0.12)
    key = axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), title="Regime")
    for handle in key.legend_handles:
        handle.set_sizes([30.0])  # type: ignore[union-attr]
    greatest = float(np.nanmax(volume))
    unit = readable_unit(volume, worn.si_unit)
    largest = with_unit(f"{unit.of(greatest):.3g}", unit)
    note = f"width of dots: cube root of {worn.words}, largest {largest}"
    axes.set_title(note, fontsize="small", loc="left")
    # How far apart neighbours are is known when the axes have their place.
    figure.draw_without_rendering()
    pixels = axes.transData.transform(np.column_stack([way.ravel(), load.ravel()]))
    x, y = (each.reshape(way.shape) * 72.0 / figure.dpi for each in pixels.T)
    steps = np.abs([*np.diff(x[0]), *np.diff(y[:, 0])])
    widest = min(_LARGEST, _APART * float(steps.min(initial=np.inf)))
    widths = np.maximum(widest * np.cbrt(volume / greatest), _SMALLEST)
    for collection, here in dots:
        collection.set_sizes(widths[here] ** 2)
    return figure
