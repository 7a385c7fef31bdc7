"""Half-profiles of the source study's cases: whole, and for rough ones a zoom beside it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fretwear.figures.axes import outside_key
from fretwear.figures.datasets import HalfProfiles, half_profiles, wave_mean
from fretwear.figures.profiles import (
    Frame,
    at_edge,
    cycle_colors,
    cycle_key,
    draw_curves,
    draw_profiles,
    frame_of,
    is_traction,
    shade_stick,
)
from fretwear.figures.style import CATEGORICAL, LINE_STYLES, JournalFigure, styled
from fretwear.units import MICROMETRE, cycle_text, readable_unit
from fretwear.vocabulary import Field

_WAVES_IN_ZOOM = 4.0

MEAN_WORDS = "mean over one wavelength"

_ROOM_ABOVE = 1.08
_ROOM_OVER_FIRST = 1.5
_SHARE_OF_FIRST_GAP = 0.3
_PANEL_HEIGHT = 52.0
_SLIP_ZONE_TOP = 500e6
_PLASTIC_LIMIT = 4500e6

Center = Callable[[HalfProfiles], float]
"""Where a zoom looks, m."""


def stick_edge(profiles: HalfProfiles) -> float:
    """The edge of the stick zone at first, m."""
    return float(profiles.stick_half_width[0])


def contact_edge(profiles: HalfProfiles) -> float:
    """Halfway between the first and the last edge of the contact, m."""
    return 0.5 * float(profiles.contact_half_width[0] + profiles.contact_half_width[-1])


def middle_of_slip(profiles: HalfProfiles) -> float:
    """The middle of the first slip zone, m."""
    return 0.5 * float(profiles.stick_half_width[0] + profiles.contact_half_width[0])


@dataclass(frozen=True)
class CaseLine:
    """One case at one cycle, as a line of its own.

    Parameters
    ----------
    title : str
        What the key says.
    case : xarray.Dataset
        The case.
    cycle : int
        A snapshot of it.
    """

    title: str
    case: xr.Dataset
    cycle: int


@styled
def smooth_profiles(cases: Mapping[str, xr.Dataset], field: Field, cycles: Sequence[int]) -> Figure:
    """Draw profiles of smooth cases, one panel each.

    Parameters
    ----------
    cases : mapping of str to xarray.Dataset
        The cases by the title of their panel.
    field : Field
        What to draw.
    cycles : sequence of int
        Snapshots.
    """
    profiles = [half_profiles(case, field, cycles) for case in cases.values()]
    figure = JournalFigure(1 if len(cases) == 1 else 2, 14.0 + _PANEL_HEIGHT)
    panels = list(figure.subplots(1, len(cases), squeeze=False).flat)
    colors = cycle_colors(cycles)
    tops = [_top(case, p) for case, p in zip(cases.values(), profiles, strict=True)]
    for axes, title, profile, top in zip(panels, cases, profiles, tops, strict=True):
        # What is seen at the edge is of another size in each contact.
        frame = replace(_frame(profile), top=top if at_edge(field) else max(tops))
        draw_profiles(axes, profile, colors, frame)
        axes.set_title(title if len(cases) > 1 else "")
    cycle_key(figure, colors)
    return figure


@styled
def rough_profiles(
    cases: Mapping[str, xr.Dataset], field: Field, cycles: Sequence[int], center: Center
) -> Figure:
    """Draw profiles of rough cases, one row each: the whole with its mean over a wave, a zoom.

    Parameters
    ----------
    cases, field, cycles
        As for `smooth_profiles`.
    center : callable
        Where the zoom looks.
    """
    figure = JournalFigure(2, 14.0 + _PANEL_HEIGHT * len(cases))
    panels = figure.subplots(len(cases), 2, squeeze=False)
    colors = cycle_colors(cycles)
    for (whole, zoom), (title, case) in zip(panels, cases.items(), strict=True):
        profile = half_profiles(case, field, cycles)
        frame = replace(_frame(profile), left=0.0, top=_mean_top(case, profile))
        draw_profiles(whole, profile, colors, frame, wave_mean)
        _draw_waves(zoom, profile, colors, center(profile))
        whole.set_title(title)
        zoom.set_title(f"{title}, zoom")
    cycle_key(figure, colors)
    return figure


@styled
def pressure_of_lines(lines: Sequence[CaseLine]) -> Figure:
    """Draw the pressure of a few cases, each at one cycle: the whole, and its foot in slip.

    Parameters
    ----------
    lines : sequence of CaseLine
        What to draw; lines of the same case have one colour.
    """
    profiles = [half_profiles(line.case, "pressure", [line.cycle]) for line in lines]
    whole = frame_of(profiles)
    tops = [_top(line.case, p) for line, p in zip(lines, profiles, strict=True)]
    whole = replace(whole, top=max(tops))
    figure = JournalFigure(2, 14.0 + _PANEL_HEIGHT)
    panels = figure.subplots(1, 2)
    titles = list(dict.fromkeys(line.title for line in lines))
    for axes, frame, title in (
        (panels[0], whole, "whole"),
        (panels[1], replace(whole, top=_SLIP_ZONE_TOP), "foot of the curves, in the slip zone"),
    ):
        for line, profile in zip(lines, profiles, strict=True):
            same = [other.cycle for other in lines if other.title == line.title]
            color = CATEGORICAL[titles.index(line.title)]
            _draw_line(axes, profile, frame, color, LINE_STYLES[same.index(line.cycle)])
        axes.set_title(title)
        axes.set_xlabel("x (µm)")
    panels[0].set_ylabel(f"{profiles[0].field.label} ({whole.unit.name})")
    handles = [
        Line2D([], [], color=CATEGORICAL[titles.index(line.title)], linestyle=LINE_STYLES[style])
        for line in lines
        for style in [
            [other.cycle for other in lines if other.title == line.title].index(line.cycle)
        ]
    ]
    texts = [f"{line.title}, cycle {cycle_text(line.cycle)}" for line in lines]
    outside_key(figure, handles, texts)
    return figure


def _draw_line(axes: Axes, profile: HalfProfiles, frame: Frame, color: str, style: object) -> None:
    draw_curves(axes, profile, frame.unit, [{"color": color, "linestyle": style}], wave_mean)
    frame.apply(axes, profile.field)
    axes.set_ylabel("")


def _draw_waves(
    axes: Axes, profile: HalfProfiles, colors: Mapping[int, str], middle: float
) -> None:
    """Draw a few waves of a rough profile as they are."""
    reach = 0.5 * _WAVES_IN_ZOOM * profile.wavelength
    middle = min(max(middle, reach), float(profile.x[-1]) - reach)
    shown = np.abs(profile.x - middle) <= reach + profile.wavelength
    near = np.abs(profile.x - middle) <= reach
    highest = float(np.nanmax(profile.values[:, near]))
    if is_traction(profile.field):
        highest = min(highest, _ROOM_OVER_FIRST * float(np.nanmax(profile.values[0])))
    unit = profile.field.unit or readable_unit(highest, "m")
    shade_stick(axes, profile)
    for cycle, values in zip(profile.cycles, profile.values, strict=True):
        x, curve = MICROMETRE.of(profile.x[shown]), unit.of(values[shown])
        axes.plot(x, curve, color=colors[int(cycle)], lw=0.8)
    frame = Frame(middle - reach, middle + reach, _ROOM_ABOVE * highest or 1.0, unit)
    frame.apply(axes, profile.field)


def _frame(profile: HalfProfiles) -> Frame:
    """The frame of one case, no wider than its window."""
    frame = frame_of([profile])
    return replace(frame, right=min(frame.right, float(profile.x[-1])))


def _top(case: xr.Dataset, profile: HalfProfiles) -> float:
    """The highest value that the panel of a smooth case shows.

    For tractions it is the study's plastic limit or the peak of cycle 0, whichever is higher:
    the peak that an elastic run comes to at the edge of stick has no limit but the grid.
    """
    if at_edge(profile.field):
        frame = _frame(profile)
        first = float(np.nanmax(profile.values[0][profile.x <= frame.right]))
        return max(frame.top, _SHARE_OF_FIRST_GAP * first)
    if not is_traction(profile.field):
        return frame_of([profile]).top
    scale = _PLASTIC_LIMIT * (
        float(case["friction"]) if profile.field.name == "shear_traction" else 1.0
    )
    return _ROOM_ABOVE * max(scale, float(np.nanmax(profile.values[0])))


def _mean_top(case: xr.Dataset, profile: HalfProfiles) -> float:
    """The highest value that the panel of a rough case shows: that of the means over a wave."""
    if at_edge(profile.field):
        return frame_of([profile]).top
    means = [wave_mean(profile.x, values, profile.wavelength) for values in profile.values]
    highest = _ROOM_ABOVE * max(float(np.nanmax(mean)) for mean in means)
    return min(highest, _top(case, profile))
