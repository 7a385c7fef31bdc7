"""What a rig shows: loops of force and displacement, scars of both bodies, a fretting map."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from fretwear.figures.style import JournalFigure, sequential_colours, styled
from fretwear.study.parameters import parameter
from fretwear.units import FORCE, MICROMETRE, cycle_text, readable_unit, with_unit
from fretwear.vocabulary import BODY_FIELDS, LOOP, RESULTS

MAPPED = ("displacement_amplitude", "displacement_ratio")
"""Varied parameters that a fretting map may have beside the load."""

_REGIMES = {
    "partial slip": ("o", "#0072b2"),
    "mixed": ("D", "#e69f00"),
    "gross slip": ("s", "#d55e00"),
}
_SIZES = (15.0, 200.0)


@styled
def fretting_loops(loops: xr.Dataset, cycles: Sequence[int] | None = None) -> Figure:
    """Draw tangential force against displacement round a cycle, one loop for each snapshot.

    Parameters
    ----------
    loops : xarray.Dataset
        From `fretwear.open_loops`.
    cycles : sequence of int, optional
        Snapshots to draw; all of them by default.

    Returns
    -------
    matplotlib.figure.Figure
    """
    shown = loops if cycles is None else loops.sel(cycle=list(cycles))
    force, way = (shown[each.name].values for each in LOOP)
    known = LOOP[0].in_units(shown[LOOP[0].name].attrs.get("units", LOOP[0].si_unit))
    unit = readable_unit(force, known.si_unit)
    figure: Figure = JournalFigure(1, 66.0)
    axes = figure.subplots()
    for row, color in enumerate(sequential_colours(shown.sizes["cycle"])):
        label = cycle_text(shown["cycle"].values[row])
        axes.plot(MICROMETRE.of(way[row]), unit.of(force[row]), color=color, label=label)
    axes.axhline(0.0, color="0.7", linewidth=0.5, zorder=0)
    axes.axvline(0.0, color="0.7", linewidth=0.5, zorder=0)
    axes.set(xlabel=f"{LOOP[1].label} (µm)", ylabel=f"{known.label} ({unit.name})")
    axes.legend(title="Cycle", loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return figure


@styled
def scars(dataset: xr.Dataset, cycle: int | None = None) -> Figure:
    """Draw the wear of both bodies along x: the indenter's upward, the flat's downward.

    Parameters
    ----------
    dataset : xarray.Dataset
        A case whose wear coefficients are known for each body.
    cycle : int, optional
        The snapshot; the last one by default.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    ValueError
        When the case has one wear coefficient for both bodies together.
    """
    if BODY_FIELDS[0].name not in dataset:
        raise ValueError(
            "the wear of each body is not known: give wear_coefficient as [indenter, flat]"
        )
    state = dataset.isel(cycle=-1) if cycle is None else dataset.sel(cycle=cycle)
    line = state if "y" not in state.dims else state.isel(y=int(np.abs(state.y.values).argmin()))
    figure: Figure = JournalFigure(1, 66.0)
    axes = figure.subplots()
    x = MICROMETRE.of(line.x.values)
    for field, sign, color in zip(BODY_FIELDS, (1.0, -1.0), ("#0072b2", "#d55e00"), strict=True):
        depth = sign * MICROMETRE.of(line[field.name].values)
        axes.fill_between(x, depth, color=color, alpha=0.3, linewidth=0.0)
        axes.plot(x, depth, color=color, label=field.label)
    axes.set(xlabel="x (µm), direction of slip", ylabel=f"{RESULTS['wear_depth'].label} (µm)")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    return figure


def has_fretting_map(summary: xr.Dataset) -> bool:
    """Whether a study varies a load and a displacement, and so has a fretting map."""
    return "load" in summary["status"].dims and any(n in summary["status"].dims for n in MAPPED)


@styled
def fretting_map(summary: xr.Dataset) -> Figure:
    """Draw the regime of sliding over load and displacement, the wear volume as the size of dots.

    Slip that is partial in some snapshots and gross in others is mixed.

    Parameters
    ----------
    summary : xarray.Dataset
        A merged study that varies the load and the displacement amplitude or ratio; of other
        varied parameters the first value is shown.

    Returns
    -------
    matplotlib.figure.Figure
    """
    across = next(name for name in MAPPED if name in summary["status"].dims)
    rest = {n: 0 for n in summary["status"].dims if n not in ("load", across)}
    shown = summary.isel(rest).transpose("load", across, ...)
    gross = shown["regime"].mean("cycle", skipna=True).values
    volume = shown["wear_volume"].max("cycle").values
    unit = readable_unit(volume, "m3")
    about = parameter(across)
    way, load = np.meshgrid(shown[across].values / about.unit.size, shown["load"].values)
    sizes = np.interp(np.sqrt(volume / np.nanmax(volume)), (0.0, 1.0), _SIZES)
    figure: Figure = JournalFigure(1, 66.0)
    axes = figure.subplots()
    kinds = np.where(gross == 0.0, "partial slip", np.where(gross == 1.0, "gross slip", "mixed"))
    for regime, (marker, color) in _REGIMES.items():
        here = (kinds == regime) & np.isfinite(gross)
        axes.scatter(
            way[here], load[here], sizes[here], color=color, marker=marker, alpha=0.8, label=regime
        )
    axes.set(xscale="log", yscale="log")
    for axis, values in ((axes.xaxis, way[0]), (axes.yaxis, load[:, 0])):
        axis.set_ticks(values, [f"{value:g}" for value in values])
        axis.set_ticks([], minor=True)
    name = f" ({about.unit.name})" if about.unit.name else ""
    axes.set(xlabel=f"{about.words.capitalize()}{name}", ylabel=f"Normal load ({FORCE.typed})")
    axes.margins(0.1)
    key = axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), title="Regime")
    for handle in key.legend_handles:
        handle.set_sizes([30.0])  # type: ignore[union-attr]
    largest = with_unit(f"{unit.of(float(np.nanmax(volume))):.3g}", unit)
    note = f"largest dot: {RESULTS['wear_volume'].words} {largest}"
    axes.set_title(note, fontsize="small", loc="left")
    return figure
