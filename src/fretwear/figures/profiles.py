"""Profiles along x at several cycles, one function per quantity."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fretwear.figures.direct_labels import Curve, label_curves
from fretwear.figures.half_profile import (
    HalfProfiles,
    available_cycles,
    half_profiles,
    representative_cycles,
)
from fretwear.figures.panels import label_outer, make_panels
from fretwear.figures.profile_frames import Frame, frame_of
from fretwear.figures.profile_kinds import (
    GAP,
    PRESSURE,
    SHEAR,
    WEAR,
    WEAR_RATE,
    ProfileKind,
)
from fretwear.figures.style import (
    INK,
    MUTED,
    STICK_SHADE,
    Columns,
    JournalFigure,
    sequential_colours,
    styled,
)
from fretwear.figures.wording import MICROMETRE, cycle_number


def pressure_profiles(
    dataset: xr.Dataset, cycles: Sequence[int] | None = None, *, columns: Columns = 1
) -> Figure:
    """Draw the normal pressure along x at y = 0 at several cycles.

    Parameters
    ----------
    dataset : xarray.Dataset
        One case (quarter or whole contact), or one point of a merged study.
    cycles : sequence of int, optional
        Snapshots to draw; left out, at most six of those there are.
    columns : {1, 2}
        Journal columns that the figure spans.

    Returns
    -------
    matplotlib.figure.Figure
        Pressure in MPa over x in µm. Where roughness crowds a profile, a thin line is the
        profile and a thick one its envelope.

    Raises
    ------
    ValueError
        When `dataset` has no such field or snapshot, or varies in a case parameter.
    """
    return _single(dataset, PRESSURE, cycles, columns)


def shear_profiles(
    dataset: xr.Dataset, cycles: Sequence[int] | None = None, *, columns: Columns = 1
) -> Figure:
    """Draw the shear traction along x at +Q, in MPa; otherwise as `pressure_profiles`."""
    return _single(dataset, SHEAR, cycles, columns)


def gap_profiles(
    dataset: xr.Dataset, cycles: Sequence[int] | None = None, *, columns: Columns = 1
) -> Figure:
    """Draw the gap at load P in µm, with its mean over a wave when rough.

    Otherwise as `pressure_profiles`.
    """
    return _single(dataset, GAP, cycles, columns)


def wear_rate_profiles(
    dataset: xr.Dataset, cycles: Sequence[int] | None = None, *, columns: Columns = 1
) -> Figure:
    """Draw the wear of one cycle; otherwise as `pressure_profiles`."""
    return _single(dataset, WEAR_RATE, cycles, columns)


def wear_profiles(
    dataset: xr.Dataset, cycles: Sequence[int] | None = None, *, columns: Columns = 1
) -> Figure:
    """Draw the worn depth in µm, downwards, with its mean over a wave when rough.

    Otherwise as `pressure_profiles`.
    """
    return _single(dataset, WEAR, cycles, columns)


@styled
def compare_profiles(
    cases: Mapping[str, xr.Dataset],
    kind: ProfileKind,
    cycles: Sequence[int] | None = None,
    *,
    columns: Columns = 2,
) -> Figure:
    """Draw one kind of profile of several cases in panels; those of a row have the same axes.

    Parameters
    ----------
    cases : mapping of str to xarray.Dataset
        The cases by the title of their panel.
    kind : ProfileKind
        What to draw, for example `PRESSURE`.
    cycles : sequence of int, optional
        Snapshots to draw, each in the cases that have it; left out, at most six.
    columns : {1, 2}
        Journal columns that the figure spans.

    Returns
    -------
    matplotlib.figure.Figure
        One panel per case and one key to the cycles.
    """
    if not cases:
        raise ValueError("There is no case to draw.")
    snapshots = {title: available_cycles(case) for title, case in cases.items()}
    shown = cycles or representative_cycles(set().union(*snapshots.values()))
    colors = cycle_colors(shown)
    profiles = {
        title: half_profiles(case, kind.variable, [n for n in shown if n in snapshots[title]])
        for title, case in cases.items()
    }
    across = min(len(cases), 2 if columns == 2 else 1)
    down = -(-len(cases) // across)
    figure = JournalFigure(columns, 14.0 + 50.0 * down)
    panels = make_panels(figure, len(cases), across, "row")
    everything = frame_of(kind, list(profiles.values()))
    for start in range(0, len(panels), across):
        row = slice(start, start + across)
        top = frame_of(kind, list(profiles.values())[row]).top
        for axes, (title, profile) in zip(panels[row], list(profiles.items())[row], strict=True):
            draw_profiles(axes, profile, kind, colors, replace(everything, top=top))
            axes.set_title(title)
    label_outer(panels, across)
    cycle_key(figure, colors)
    return figure


def cycle_colors(cycles: Sequence[int]) -> dict[int, str]:
    """Return a colour for each of some cycles, the later the darker."""
    return dict(zip(cycles, sequential_colours(len(cycles)), strict=True))


def draw_profiles(
    axes: Axes,
    profiles: HalfProfiles,
    kind: ProfileKind,
    colors: Mapping[int, str],
    frame: Frame | None = None,
) -> list[Curve]:
    """Draw profiles into axes and return the curves that labels belong to.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where to draw.
    profiles : HalfProfiles
        What to draw.
    kind : ProfileKind
        How to draw it.
    colors : mapping of int to str
        Colour of each cycle.
    frame : Frame, optional
        Limits and unit of the axes, when several panels must agree on them.
    """
    frame = frame or frame_of(kind, [profiles])
    unit = frame.unit
    x = MICROMETRE.of(profiles.x)
    axes.axvspan(0.0, MICROMETRE.of(profiles.stick_half_width)[-1], color=STICK_SHADE, lw=0)
    curves = []
    for cycle, values in zip(profiles.cycles, profiles.values, strict=True):
        color, shown = colors[int(cycle)], values
        if profiles.is_wavy:
            axes.plot(x, unit.of(values), color=color, lw=0.35, alpha=0.45, label="_raw")
            shown = kind.envelope(profiles.x, values, profiles.wavelength)
        axes.plot(x, unit.of(shown), color=color, label=cycle_number(cycle))
        curves.append(Curve(x, unit.of(shown), cycle_number(cycle), color))
    axes.set_xlim(*MICROMETRE.of([frame.left, frame.right]))
    top = float(unit.of(frame.top))
    axes.set_ylim((top, 0.0) if kind.downward else (0.0, top))
    axes.set_xlabel("x (µm)")
    axes.set_ylabel(f"{kind.label} ({unit.name})")
    return curves


def _single(
    dataset: xr.Dataset, kind: ProfileKind, cycles: Sequence[int] | None, columns: Columns
) -> Figure:
    return _draw_single(half_profiles(dataset, kind.variable, cycles), kind, columns)


@styled
def _draw_single(profiles: HalfProfiles, kind: ProfileKind, columns: Columns) -> Figure:
    figure = JournalFigure(columns, 66.0 if columns == 1 else 90.0)
    axes = figure.subplots()
    colors = cycle_colors([int(cycle) for cycle in profiles.cycles])
    curves = draw_profiles(axes, profiles, kind, colors)
    _name_zones(axes, profiles)
    first = replace(curves[0], label=f"cycle {curves[0].label}")
    if not profiles.is_wavy and label_curves(axes, [first, *curves[1:]]):
        return figure
    cycle_key(figure, colors)
    return figure


def _name_zones(axes: Axes, profiles: HalfProfiles) -> None:
    """Name the stick and slip zones of the last cycle above the axes."""
    left, _ = axes.get_xlim()
    stick = max(left, float(MICROMETRE.of(profiles.stick_half_width)[-1]))
    contact = float(MICROMETRE.of(profiles.contact_half_width)[-1])
    above = axes.get_xaxis_transform()
    for start, end, name, color in ((left, stick, "stick", INK), (stick, contact, "slip", MUTED)):
        if end <= start:
            continue
        axes.plot(
            [start, end],
            [1.02, 1.02],
            transform=above,
            clip_on=False,
            lw=1.6,
            color=color,
            solid_capstyle="butt",
            label="_zone",
        )
        axes.text(
            0.5 * (start + end),
            1.035,
            name,
            transform=above,
            color=color,
            fontsize=6.5,
            ha="center",
            va="bottom",
        )


def cycle_key(figure: Figure, colors: Mapping[int, str]) -> None:
    """Add the key of colours that tell cycles, above the axes of a figure."""
    lines = [Line2D([], [], color=color) for color in colors.values()]
    labels = [cycle_number(cycle) for cycle in colors]
    title = Line2D([], [], color="none")
    figure.legend(
        [title, *lines],
        ["cycle", *labels],
        loc="outside upper left",
        ncols=len(labels) + 1,
        handlelength=1.4,
        columnspacing=0.9,
    )
