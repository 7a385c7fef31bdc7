"""The figures of the source study, drawn from our datasets under their original numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullLocator

from fretwear.figures.axes import add_key, set_cycle_axis
from fretwear.figures.colours import CATEGORICAL
from fretwear.figures.datasets import Profiles, field_of, profiles_of
from fretwear.figures.page import HALF_WIDTH_LABEL
from fretwear.figures.profiles import (
    Frame,
    at_edge,
    cycle_colours,
    cycle_key,
    draw_filled,
    draw_profiles,
    frame_of,
    shade_stick,
    zone_key,
)
from fretwear.figures.study import StudyFigure
from fretwear.figures.style import LINE_STYLES, MUTED, JournalFigure, styled
from fretwear.results import RESULTS
from fretwear.units import MICROMETRE, NANOMETRE, cycle_text, readable_unit
from fretwear.variable import Variable
from fretwear_source_study.parameters import PLASTIC_LIMIT
from fretwear_source_study.reference_cases import RUN_IN, Cases, reference_cases

Drawn = tuple[Figure, list[str]]
"""A figure, and the sentences of its caption."""

SHOWN_CYCLES = (0, 100, 1000, 7000, 30000)

_PROFILE_HEIGHT, _WIDTH_HEIGHT, _KEY_HEIGHT = 52.0, 72.0, 14.0
_ROOM_ABOVE = 1.08
_ROOM_OVER_FIRST = 1.5
_SLIP_ZONE_TOP = 500e6
_MARGIN = 0.03

_AT_Y = "on the line nearest y = 0"
_AT_EDGE = "Around the edge of the contact, within the window of the case."
_STICK = "Grey: stick zone at the last cycle shown."
_SINGULAR = (
    "Curves that leave the panel at the top are elastic: their peak at the edge of the stick zone "
    "grows without bound as the grid is refined."
)
_STEPS = "A rough contact widens by steps: one more row of tips at a time."

_PRESSURE, _SHEAR, _GAP = (field_of(name) for name in ("pressure", "shear_traction", "gap"))
_WEAR_RATE = replace(field_of("wear_rate"), unit=NANOMETRE)
_COMPARED = ("wear_volume", "maximum_wear_depth", "stick_area", "contact_area")
_SMOOTH, _ROUGH = ("smooth elastic", "smooth plastic"), ("rough elastic", "rough plastic")

_AT_STICK = (lambda p: p.stick_half_width[0]), "at the first edge of stick"
_ZOOMS: dict[str, tuple[Callable[[Profiles], float], str]] = {
    "pressure": _AT_STICK,
    "shear_traction": _AT_STICK,
    "gap": (lambda p: float(p.contact_half_width[[0, -1]].mean()), "at the edge of the contact"),
    "wear_rate": (
        lambda p: 0.5 * (p.stick_half_width[0] + p.contact_half_width[0]),
        "in the middle of the slip zone",
    ),
}
"""The middle, m, of the two waves that a figure enlarges, and this place in its caption."""


def source_figures(summary: xr.Dataset, folder: Path) -> Iterator[StudyFigure]:
    """Yield the figures of the source study, numbered as there, and one of its last claim.

    They show case files of a merged study; one without the four cases of the source study has none.
    """
    for _, _, cases in islice(reference_cases(summary, folder), 1):
        for name, draw in _FIGURES.items():
            figure, caption = draw(cases)
            yield StudyFigure(name, " ".join(caption), figure)


@styled
def _profiles(cases: Cases, *, field: Variable, titles: Sequence[str]) -> Drawn:
    """Draw a field of smooth cases side by side, or of rough ones in rows with a zoom."""
    # The study's cycles that all four cases have; if these are few, all common cycles.
    common = set.intersection(*(set(case.cycles) for case in cases.values()))
    cycles = [cycle for cycle in SHOWN_CYCLES if cycle in common]
    cycles = cycles if len(cycles) > 2 else sorted(common)
    surface, body = titles[0].split()
    is_rough, both = surface == "rough", len(titles) > 1
    if is_rough and both and field is _PRESSURE:
        # The study compares elastic and plastic pressures of rough bodies up to this cycle.
        cycles = [cycle for cycle in cycles if cycle <= RUN_IN]
    profiles = [profiles_of(cases[title].dataset, field, cycles) for title in titles]
    friction = cases[titles[0]].parameter("friction") if field is _SHEAR else 1.0
    tops = [_top(profile, friction) for profile in profiles]
    down, across = (len(titles), 2) if is_rough else (1, len(titles))
    figure = JournalFigure(2 if across > 1 else 1, _KEY_HEIGHT + _PROFILE_HEIGHT * down)
    panels = figure.subplots(down, across, squeeze=False)
    colors = cycle_colours(cycles)
    wavelength = 2.0 * np.pi / cases[titles[0]].roughness.wavenumbers[0] if is_rough else 0.0
    for index, (title, profile, top) in enumerate(zip(titles, profiles, tops, strict=True)):
        frame = frame_of([profile])
        frame = replace(frame, right=min(frame.right, float(profile.x[-1])), top=top)
        whole = panels[index, 0] if is_rough else panels[0, index]
        if is_rough:
            _draw_waves(panels[index, 1], profile, colors, wavelength)
            panels[index, 1].set_title(f"{title}, zoom")
            draw_filled(whole, profile, replace(frame, left=0.0))
        else:
            # The features at the edge of smooth contacts differ in size between cases.
            frame = frame if at_edge(field) else replace(frame, top=max(tops))
            draw_profiles(whole, profile, colors, frame)
        whole.set_title(title if is_rough or both else "")
    cycle_key(figure, colors)
    if is_rough:
        zone_key(figure, profiles, "outside lower left")
    contact = f"{surface} contact" if both else f"{surface} {body} contact"
    bodies = ": elastic, and with a plastic limit" if both else ""
    caption = [f"{field.label} of the {contact} along x {_AT_Y}{bodies}."]
    if is_rough:
        caption.append(
            f"Left: cycle {cycle_text(cycles[-1])}, filled, over a strip of its zones, and the "
            f"line of cycle {cycle_text(cycles[0])}. Right: two waves "
            f"{_ZOOMS[field.name][1]}; marks are the cells. {_STICK}"
        )
    else:
        caption.append(_AT_EDGE if at_edge(field) else _STICK)
    if field.si_unit == _PRESSURE.si_unit:
        caption.append(_SINGULAR)
    return figure, caption


def _top(profile: Profiles, friction: float = 1.0) -> float:
    """The highest value that a panel shows.

    For tractions it is the study's plastic limit, times µ for shear, or the peak of cycle 0,
    whichever is higher: the peak of an elastic run at the stick edge is limited only by the grid.
    """
    if profile.field.si_unit != _PRESSURE.si_unit:
        return frame_of([profile]).top
    return _ROOM_ABOVE * max(friction * PLASTIC_LIMIT, float(np.nanmax(profile.values[0])))


def _draw_waves(axes: Axes, profile: Profiles, colors: Mapping[int, str], reach: float) -> None:
    """Draw two waves of a rough profile as they are, one length `reach`, m, to either side."""
    find_middle, _ = _ZOOMS[profile.field.name]
    middle = min(max(find_middle(profile), reach), float(profile.x[-1]) - reach)
    distance = np.abs(profile.x - middle)
    highest = float(np.nanmax(profile.values[:, distance <= reach]))
    if profile.field.si_unit == _PRESSURE.si_unit:
        highest = min(highest, _ROOM_OVER_FIRST * float(np.nanmax(profile.values[0])))
    unit = profile.field.unit or readable_unit(highest, profile.field.si_unit)
    shade_stick(axes, profile)
    shown = distance <= 2.0 * reach
    for cycle, values in zip(profile.cycles, profile.values, strict=True):
        x, curve = MICROMETRE.of(profile.x[shown]), unit.of(values[shown])
        axes.plot(x, curve, ".-", color=colors[int(cycle)], lw=0.8, markersize=2.4)
    frame = Frame(middle - reach, middle + reach, _ROOM_ABOVE * highest or 1.0, unit)
    frame.apply(axes, profile.field)


@styled
def _plastic_pressures(cases: Cases) -> Drawn:
    """Draw the pressure of both contacts with a plastic limit, whole and enlarged in slip."""
    smooth, rough = cases["smooth plastic"], cases["rough plastic"]
    run_in = smooth.nearest(RUN_IN)
    shown = [(smooth, run_in, "smooth"), (rough, run_in, "rough")]
    shown += [(smooth, smooth.last, "plastic")] * (smooth.last > run_in)
    labels = [
        f"{'rough' if case is rough else 'smooth'} plastic, cycle {cycle_text(cycle)}"
        for case, cycle, _ in shown
    ]
    styles = [_style(title) for *_, title in shown]
    profiles = [profiles_of(case.dataset, _PRESSURE, [cycle]) for case, cycle, _ in shown]
    frame = frame_of(profiles)
    top = max(map(_top, profiles))
    figure = JournalFigure(2, _KEY_HEIGHT + _PROFILE_HEIGHT)
    panels = figure.subplots(1, 2)
    zoom = "foot of the curves, in the slip zone"
    for axes, highest, title in zip(panels, (top, _SLIP_ZONE_TOP), ("whole", zoom), strict=True):
        for profile, style in zip(profiles, styles, strict=True):
            x, values = MICROMETRE.of(profile.x), frame.unit.of(profile.values[0])
            axes.plot(x, values, lw=0.7 if profile.is_rough else None, **style)
        replace(frame, top=highest).apply(axes, _PRESSURE)
        axes.set_title(title)
    panels[1].set_ylabel("")
    add_key(figure, [Line2D([], [], **style) for style in styles], labels)
    return figure, [
        f"Pressure of the contacts with a plastic limit along x {_AT_Y}, smooth and rough after "
        f"{run_in} cycles and smooth after {smooth.last}; right: the same, enlarged.",
        "The thin line is the profile of the rough contact.",
    ]


@styled
def _widths(cases: Cases, *, zoom: bool) -> Drawn:
    """Draw the half-widths of both zones over the cycles or, as a zoom, the edge of the contact.

    The zoom spreads early cycles out and fits the elastic cases; others may leave at the top.
    """
    figure = JournalFigure(2, _WIDTH_HEIGHT)
    axes = figure.subplots()
    contact, stick = (
        {t: MICROMETRE.of(case.history[f"{zone}_half_width_x"].values) for t, case in cases.items()}
        for zone in ("contact", "stick")
    )
    cycles = {title: case.history["cycle"].values for title, case in cases.items()}
    for widths, width in ((contact, 1.1), (stick, 0.7))[: 1 if zoom else 2]:
        for title, values in widths.items():
            axes.plot(cycles[title], values, lw=width, **_style(title))
    axes.grid(axis="y")
    axes.set_ylabel(HALF_WIDTH_LABEL)
    add_key(figure, [Line2D([], [], **_style(title)) for title in cases], list(cases))
    if zoom:
        elastic = np.concatenate([contact[title] for title in (_SMOOTH[0], _ROUGH[0])])
        room = _MARGIN * float(np.ptp(elastic))
        axes.set_ylim(float(elastic.min()) - room, float(elastic.max()) + 4.0 * room)
        every = np.concatenate(list(cycles.values()))
        # Early steps are fractions of a cycle, in which little changes.
        set_cycle_axis(axes, every[(every == 0.0) | (every >= 1.0)])
        words = (
            "The edge of the contact enlarged; the axis of cycles is logarithmic to the right of "
            "the break. With a plastic limit the contact continues to grow."
        )
        return figure, [words, _STEPS]
    axes.set_ylim(bottom=0.0)
    axes.margins(x=0.0)
    axes.set_xlabel("Cycle")
    words = "Half-widths along x of the contact (thick) and of the stick zone (thin)"
    return figure, [f"{words} against the number of cycles.", _STEPS]


@styled
def _rough_over_smooth(cases: Cases) -> Drawn:
    """Draw results of the rough contacts, divided by those of the smooth ones, over the cycles."""
    figure = JournalFigure(2, _KEY_HEIGHT + _PROFILE_HEIGHT)
    panels = figure.subplots(1, 2, sharey=True)
    for axes, *pair in zip(panels, _ROUGH, _SMOOTH, strict=True):
        rough, smooth = (cases[title].history for title in pair)
        cycles = rough["cycle"].values[rough["cycle"].values >= 1.0]
        for name, color in zip(_COMPARED, CATEGORICAL, strict=False):
            values = [np.interp(cycles, run["cycle"], run[name]) for run in (rough, smooth)]
            axes.plot(cycles, values[0] / values[1], color=color)
        axes.axhline(1.0, color=MUTED, lw=0.6, zorder=0)
        axes.set(xscale="log", xlabel="Cycle", title=pair[0].removeprefix("rough "))
    panels[0].set(ylabel="Rough over smooth", yscale="log")
    panels[0].set_yticks(ticks := [0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0], [f"{n:g}" for n in ticks])
    panels[0].yaxis.set_minor_locator(NullLocator())
    keys = [Line2D([], [], color=color) for color in CATEGORICAL[: len(_COMPARED)]]
    add_key(figure, keys, [RESULTS[name].words for name in _COMPARED])
    return figure, ["Results of the rough contacts, divided by those of the smooth ones."]


def _style(title: str) -> dict[str, Any]:
    """The style of a case: colour shows roughness, line style plasticity."""
    color, linestyle = CATEGORICAL["rough" in title], LINE_STYLES["plastic" in title]
    return {"color": color, "linestyle": linestyle}


_FIGURES: dict[str, Callable[[Cases], Drawn]] = {
    "fig04_pressure_smooth_elastic": partial(_profiles, field=_PRESSURE, titles=_SMOOTH[:1]),
    "fig05_pressure_rough_elastic": partial(_profiles, field=_PRESSURE, titles=_ROUGH[:1]),
    "fig06_pressure_rough_elastic_and_plastic": partial(_profiles, field=_PRESSURE, titles=_ROUGH),
    "fig07_pressure_plastic": _plastic_pressures,
    "fig08_shear_smooth": partial(_profiles, field=_SHEAR, titles=_SMOOTH),
    "fig09_shear_rough": partial(_profiles, field=_SHEAR, titles=_ROUGH),
    "fig10_gap_smooth": partial(_profiles, field=_GAP, titles=_SMOOTH),
    "fig11_gap_rough": partial(_profiles, field=_GAP, titles=_ROUGH),
    "fig13_wear_rate_smooth": partial(_profiles, field=_WEAR_RATE, titles=_SMOOTH),
    "fig14_wear_rate_rough": partial(_profiles, field=_WEAR_RATE, titles=_ROUGH),
    "fig15_contact_half_width": partial(_widths, zoom=False),
    "fig16_contact_half_width_zoom": partial(_widths, zoom=True),
    "claim12_rough_over_smooth": _rough_over_smooth,
}
"""The functions that draw the figures, by name."""
