"""Profiles along x at several cycles, one function per quantity."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fretwear.figures.datasets import check_cases
from fretwear.figures.direct_labels import label_curves
from fretwear.figures.half_profile import (
    HalfProfiles,
    available_cycles,
    half_profiles,
    representative_cycles,
)
from fretwear.figures.panels import label_outer, make_panels
from fretwear.figures.profile_drawing import (
    cycle_colors,
    cycle_key,
    draw_profiles,
    name_zones,
)
from fretwear.figures.profile_frames import frame_of
from fretwear.figures.profile_kinds import (
    GAP,
    PRESSURE,
    SHEAR,
    WEAR,
    WEAR_RATE,
    ProfileKind,
    kind_of,
)
from fretwear.figures.style import (
    Columns,
    JournalFigure,
    root_figure,
    styled,
)
from fretwear.figures.wording import cycle_number

Cycles = Sequence[int] | int | None
"""Which snapshots a figure shows: these, or a few of those there are."""


def pressure_profiles(
    dataset: xr.Dataset,
    cycles: Cycles = None,
    *,
    columns: Columns = 1,
    axes: Axes | None = None,
) -> Figure:
    """Draw the normal pressure along x at y = 0 at several cycles.

    Parameters
    ----------
    dataset : xarray.Dataset
        One case (quarter or whole contact), or one point of a merged study.
    cycles : int or sequence of int, optional
        Snapshots to draw; left out, at most six of those there are.
    columns : {1, 2}
        Journal columns that the figure spans, 90 mm or 190 mm.
    axes : matplotlib.axes.Axes, optional
        Where to draw, in a figure of your own; `columns` then says nothing.

    Returns
    -------
    matplotlib.figure.Figure
        Pressure in MPa over x in µm. Where roughness crowds a profile, a thin line is the
        profile and a thick one its envelope. A triangle at the top is the peak of a curve that
        goes on above: in elastic bodies the one at the edge of the stick zone grows with a finer
        grid, without end, and more than three times the first peak is not shown.

    Raises
    ------
    TypeError
        When `dataset` is no dataset.
    ValueError
        When `dataset` has no such field or snapshot, or varies in a case parameter.
    """
    return _single(dataset, PRESSURE, cycles, columns, axes)


def shear_profiles(
    dataset: xr.Dataset,
    cycles: Cycles = None,
    *,
    columns: Columns = 1,
    axes: Axes | None = None,
) -> Figure:
    """Draw the shear traction along x at +Q, in MPa; otherwise as `pressure_profiles`."""
    return _single(dataset, SHEAR, cycles, columns, axes)


def gap_profiles(
    dataset: xr.Dataset,
    cycles: Cycles = None,
    *,
    columns: Columns = 1,
    axes: Axes | None = None,
) -> Figure:
    """Draw the gap at load P in µm, with its mean over a wave when rough.

    Otherwise as `pressure_profiles`.
    """
    return _single(dataset, GAP, cycles, columns, axes)


def wear_rate_profiles(
    dataset: xr.Dataset,
    cycles: Cycles = None,
    *,
    columns: Columns = 1,
    axes: Axes | None = None,
) -> Figure:
    """Draw the wear of one cycle; otherwise as `pressure_profiles`."""
    return _single(dataset, WEAR_RATE, cycles, columns, axes)


def wear_profiles(
    dataset: xr.Dataset,
    cycles: Cycles = None,
    *,
    columns: Columns = 1,
    axes: Axes | None = None,
) -> Figure:
    """Draw the worn depth in µm, downwards, with its mean over a wave when rough.

    Otherwise as `pressure_profiles`.
    """
    return _single(dataset, WEAR, cycles, columns, axes)


@styled
def compare_profiles(
    cases: Mapping[str, xr.Dataset],
    quantity: str | ProfileKind,
    cycles: Cycles = None,
    *,
    columns: Columns = 2,
) -> Figure:
    """Draw one kind of profile of several cases in panels; those of a row have the same axes.

    Parameters
    ----------
    cases : mapping of str to xarray.Dataset
        The cases by the title of their panel.
    quantity : {"pressure", "shear_traction", "gap", "wear_depth", "wear_rate"}
        What to draw, by the name of the field.
    cycles : int or sequence of int, optional
        Snapshots to draw, each in the cases that have it; left out, at most six.
    columns : {1, 2}
        Journal columns that the figure spans, 90 mm or 190 mm.

    Returns
    -------
    matplotlib.figure.Figure
        One panel per case and one key to the cycles.

    Raises
    ------
    TypeError
        When `cases` is no mapping of titles to datasets.
    ValueError
        When there is no case, no such quantity, or none of the cases has one of the snapshots.
    """
    check_cases(cases)
    kind = kind_of(quantity)
    snapshots = {title: available_cycles(case) for title, case in cases.items()}
    shown = _shown_cycles(snapshots, cycles)
    colors = cycle_colors(shown)
    profiles = {
        title: half_profiles(case, kind.variable, [n for n in shown if n in snapshots[title]])
        for title, case in cases.items()
    }
    across = min(len(cases), 2 if columns == 2 else 1)
    down = -(-len(cases) // across)
    figure = JournalFigure(columns, 14.0 + 50.0 * down)
    # What is seen at the edge is elsewhere for rough and for smooth cases.
    panels = make_panels(figure, len(cases), across, "row", "row" if kind.at_edge else "all")
    everything = frame_of(kind, list(profiles.values()))
    for start in range(0, len(panels), across):
        row = slice(start, start + across)
        frame = frame_of(kind, list(profiles.values())[row])
        if not kind.at_edge:
            frame = replace(everything, top=frame.top)
        for axes, (title, profile) in zip(panels[row], list(profiles.items())[row], strict=True):
            draw_profiles(axes, profile, kind, colors, frame)
            axes.set_title(title)
    label_outer(panels, across, every_x=kind.at_edge)
    cycle_key(figure, colors)
    return figure


def _shown_cycles(
    snapshots: Mapping[str, Sequence[int]], cycles: Sequence[int] | int | None
) -> Sequence[int]:
    """Return the cycles to show of several cases; refuse one that none of them has."""
    available = sorted(set().union(*snapshots.values()))
    if cycles is None:
        return representative_cycles(available)
    wanted: list[int] = np.atleast_1d(cycles).tolist()
    lacking = {title: had for title, had in snapshots.items() if not set(wanted).intersection(had)}
    unknown = sorted(set(wanted).difference(available))
    if unknown or lacking or not wanted:
        had = next(iter(lacking.values()), available)
        raise ValueError(
            f"cycles = {wanted}: every cycle must be a snapshot of some case, and every case must "
            f"have one of them; {next(iter(lacking), 'all cases together')!r} has {list(had)}."
        )
    return wanted


def _single(
    dataset: xr.Dataset, kind: ProfileKind, cycles: Cycles, columns: Columns, axes: Axes | None
) -> Figure:
    return _draw_single(half_profiles(dataset, kind.variable, cycles), kind, columns, axes)


@styled
def _draw_single(
    profiles: HalfProfiles, kind: ProfileKind, columns: Columns, given: Axes | None
) -> Figure:
    if given is None:
        figure: Figure = JournalFigure(columns, 66.0 if columns == 1 else 90.0)
        axes = figure.subplots()
    else:
        figure, axes = root_figure(given), given
    colors = cycle_colors([int(cycle) for cycle in profiles.cycles])
    curves = draw_profiles(axes, profiles, kind, colors)
    name_zones(axes, profiles)
    first = replace(curves[0], label=f"cycle {curves[0].label}")
    if not profiles.is_wavy and label_curves(axes, [first, *curves[1:]]):
        return figure
    if given is None:
        cycle_key(figure, colors)
    else:
        lines = [Line2D([], [], color=color) for color in colors.values()]
        axes.legend(lines, [cycle_number(cycle) for cycle in colors], title="cycle")
    return figure
