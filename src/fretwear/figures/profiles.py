"""Profiles along x at several cycles, one function per quantity."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fretwear.figures.direct_labels import Curve, label_curves
from fretwear.figures.half_profile import (
    HalfProfiles,
    half_profiles,
    representative_cycles,
)
from fretwear.figures.panels import label_outer, make_panels
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
from fretwear.figures.wording import (
    MICROMETRE,
    Unit,
    cycle_number,
    readable_unit,
)


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
        Snapshots to draw; left out, at most six of those of the first case.
    columns : {1, 2}
        Journal columns that the figure spans.

    Returns
    -------
    matplotlib.figure.Figure
        One panel per case and one key to the cycles.
    """
    if not cases:
        raise ValueError("There is no case to draw.")
    shown = cycles or representative_cycles(next(iter(cases.values())))
    profiles = {title: half_profiles(case, kind.variable, shown) for title, case in cases.items()}
    across = min(len(cases), 2 if columns == 2 else 1)
    down = -(-len(cases) // across)
    figure = JournalFigure(columns, 14.0 + 50.0 * down)
    panels = make_panels(figure, len(cases), across, "row")
    unit = _unit(kind, list(profiles.values()))
    for axes, (title, profile) in zip(panels, profiles.items(), strict=True):
        draw_profiles(axes, profile, kind, unit)
        axes.set_title(title)
    reach = max(axes.get_xlim()[1] for axes in panels)
    panels[0].set_xlim(0.0, reach)
    label_outer(panels, across)
    _cycle_key(figure, next(iter(profiles.values())))
    return figure


def draw_profiles(
    axes: Axes, profiles: HalfProfiles, kind: ProfileKind, unit: Unit | None = None
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
    unit : Unit, optional
        Unit of the y axis, when several panels must agree on one.
    """
    unit = unit or _unit(kind, [profiles])
    x = MICROMETRE.of(profiles.x)
    axes.axvspan(0.0, MICROMETRE.of(profiles.stick_half_width)[-1], color=STICK_SHADE, lw=0)
    curves = []
    for cycle, values, color in zip(
        profiles.cycles, profiles.values, sequential_colours(len(profiles.cycles)), strict=True
    ):
        shown = values
        if profiles.is_wavy:
            axes.plot(x, unit.of(values), color=color, lw=0.35, alpha=0.45, label="_raw")
            shown = kind.envelope(profiles.x, values, profiles.wavelength)
        axes.plot(x, unit.of(shown), color=color, label=cycle_number(cycle))
        curves.append(Curve(x, unit.of(shown), cycle_number(cycle), color))
    axes.set_xlim(0.0, float(MICROMETRE.of(profiles.contact_half_width).max() * kind.reach))
    axes.set_xlabel("x (µm)")
    axes.set_ylabel(f"{kind.label} ({unit.name})")
    _set_y_limits(axes, curves, kind, profiles, unit)
    return curves


def _single(
    dataset: xr.Dataset, kind: ProfileKind, cycles: Sequence[int] | None, columns: Columns
) -> Figure:
    return _draw_single(half_profiles(dataset, kind.variable, cycles), kind, columns)


@styled
def _draw_single(profiles: HalfProfiles, kind: ProfileKind, columns: Columns) -> Figure:
    figure = JournalFigure(columns, 66.0 if columns == 1 else 90.0)
    axes = figure.subplots()
    curves = draw_profiles(axes, profiles, kind)
    _name_zones(axes, profiles)
    first = replace(curves[0], label=f"cycle {curves[0].label}")
    if not profiles.is_wavy and label_curves(axes, [first, *curves[1:]]):
        return figure
    _cycle_key(figure, profiles)
    return figure


def _unit(kind: ProfileKind, profiles: Sequence[HalfProfiles]) -> Unit:
    if kind.unit is not None:
        return kind.unit
    return readable_unit([np.nanmax(profile.values) for profile in profiles], "m")


def _set_y_limits(
    axes: Axes, curves: Sequence[Curve], kind: ProfileKind, profiles: HalfProfiles, unit: Unit
) -> None:
    right = axes.get_xlim()[1]
    visible = unit.of(profiles.values)[:, curves[0].x <= right]
    low, high = axes.get_ylim() if axes.get_shared_y_axes().get_siblings(axes)[1:] else (0.0, 0.0)
    top = max(float(np.nanmax(visible)) * 1.05, low, high)
    axes.set_ylim((top, 0.0) if kind.downward else (0.0, top))


def _name_zones(axes: Axes, profiles: HalfProfiles) -> None:
    """Name the stick and slip zones of the last cycle above the axes."""
    stick = float(MICROMETRE.of(profiles.stick_half_width)[-1])
    contact = float(MICROMETRE.of(profiles.contact_half_width)[-1])
    above = axes.get_xaxis_transform()
    for start, end, name, color in ((0.0, stick, "stick", INK), (stick, contact, "slip", MUTED)):
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


def _cycle_key(figure: Figure, profiles: HalfProfiles) -> None:
    colors = sequential_colours(len(profiles.cycles))
    lines = [Line2D([], [], color=color) for color in colors]
    labels = [cycle_number(cycle) for cycle in profiles.cycles]
    title = Line2D([], [], color="none")
    figure.legend(
        [title, *lines],
        ["cycle", *labels],
        loc="outside upper left",
        ncols=len(labels) + 1,
        handlelength=1.4,
        columnspacing=0.9,
    )
