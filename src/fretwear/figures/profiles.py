"""Curves of cases at several cycles: profiles along x, scars, bearing areas, fretting loops."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fretwear.arrays import Array
from fretwear.data.dataset import line_near_the_middle, mirrored
from fretwear.data.stack import representative_cycles
from fretwear.figures.axes import Place, label_curves, label_or_key, make_panels, outside_key
from fretwear.figures.datasets import (
    BEYOND_CONTACT,
    Cycles,
    Envelope,
    HalfProfiles,
    available_cycles,
    check_cases,
    field_of,
    half_profiles,
    snapshots,
)
from fretwear.figures.style import (
    CATEGORICAL,
    INK,
    MUTED,
    STICK_SHADE,
    Columns,
    of_quantity,
    one_panel,
    sequential_colours,
    styled,
)
from fretwear.study.case import Case
from fretwear.units import MICROMETRE, Unit, cycle_text, readable_unit, span
from fretwear.vocabulary import BODY_FIELDS, LOOP, RESULTS, Variable

PROFILES = {
    "pressure_profiles": "pressure",
    "shear_profiles": "shear_traction",
    "gap_profiles": "gap",
    "wear_rate_profiles": "wear_rate",
    "wear_profiles": "wear_depth",
}
"""The fields that have a named figure, by its name."""

_DOWNWARD = ("wear_depth", "plastic_depth")
_BEFORE_EDGE = 0.75
_ABOVE = 1.05
_INSIDE_CONTACT = 0.8
_ROOM_OVER_WAVES = 1.6
_SHARE_OF_FIRST_GAP = 0.3
_ROOM_OVER_FIRST = 3.0
_WORN = 0.01
_TRIANGLE = 0.985
_ABOVE_TOP: dict[str, Any] = {"marker": "^", "markersize": 3.5, "label": "_above"}
_RAW: dict[str, Any] = {"lw": 0.5, "alpha": 0.6, "label": "_raw"}
_BAR: dict[str, Any] = {"lw": 1.6, "solid_capstyle": "butt", "label": "_zone", "clip_on": False}
_BAR_NAME: dict[str, Any] = {"fontsize": 6.5, "ha": "center", "va": "bottom"}


@styled
def field_profiles(
    dataset: xr.Dataset,
    quantity: Variable | str,
    cycles: Cycles = None,
    *,
    columns: Columns = 1,
    ax: Axes | None = None,
) -> Figure:
    """Draw any field, such as ``pressure``, along x at y = 0 at several cycles.

    Pressure is in MPa over x in µm, for example; wear depth is drawn downwards. Where roughness
    crowds a profile, a thin line is the profile and a thick one its envelope, or its mean over a
    wave. A triangle at the top marks a traction that continues above: in elastic bodies its peak at
    the edge of the stick zone grows without bound as the grid is refined, and axes end at three
    times the first peak.
    """
    profiles = half_profiles(dataset, quantity, cycles)
    figure, panel = one_panel(columns, 66.0 if columns == 1 else 90.0, ax)
    colors = cycle_colors(profiles.cycles)
    curves = draw_profiles(panel, profiles, colors)
    _name_zones(panel, profiles)
    names = [cycle_text(cycle) for cycle in profiles.cycles]
    if not profiles.is_wavy and label_curves(panel, curves, [f"cycle {names[0]}", *names[1:]]):
        return figure
    if ax is None:
        cycle_key(figure, colors)
    else:
        panel.legend(curves, names, title="cycle")
    return figure


pressure_profiles, shear_profiles, gap_profiles, wear_rate_profiles, wear_profiles = (
    of_quantity(field_profiles, name, field) for name, field in PROFILES.items()
)


@styled
def compare_profiles(
    cases: Mapping[str, xr.Dataset],
    quantity: Variable | str,
    cycles: Cycles = None,
    *,
    columns: Columns = 2,
) -> Figure:
    """Draw `field_profiles` of several cases, by the titles of their panels.

    Panels of a row have the same axes. Each of the `cycles` is drawn in the cases that have it; a
    cycle that no case has, or a case that has none of the cycles, raises a ValueError.
    """
    check_cases(cases)
    field = field_of(quantity)
    available = {title: available_cycles(case) for title, case in cases.items()}
    everything = sorted(set().union(*available.values()))
    shown = list(representative_cycles(everything))
    if cycles is not None:
        shown = np.atleast_1d(cycles).tolist()
        lacking = [title for title, had in available.items() if not set(shown) & set(had)]
        if not shown or lacking or not set(shown) <= set(everything):
            title = lacking[0] if lacking else "all cases together"
            raise ValueError(
                f"cycles = {shown}: every cycle must be a snapshot of some case, and every case "
                f"must have one of them; {title!r} has {available.get(title, everything)}."
            )
    colors = cycle_colors(shown)
    reach = BEYOND_CONTACT * max(
        float(case["contact_half_width_x"].max()) for case in cases.values()
    )
    profiles = [
        half_profiles(case, field, [n for n in shown if n in available[title]], reach)
        for title, case in cases.items()
    ]
    across = min(len(cases), columns)
    # The edge of the contact differs between rough and smooth cases.
    figure, panels = make_panels(
        columns, list(cases), across, (14.0, 50.0), "row", "row" if at_edge(field) else "all"
    )
    common = frame_of(profiles)
    for index, (axes, profile) in enumerate(zip(panels, profiles, strict=True)):
        start = index - index % across
        frame = frame_of(profiles[start : start + across])
        frame = frame if at_edge(field) else replace(common, top=frame.top)
        draw_profiles(axes, profile, colors, frame)
    cycle_key(figure, colors)
    return figure


@dataclass(frozen=True)
class Frame:
    """Limits of profiles, x and largest value, in SI units, with the unit of the y axis."""

    left: float
    right: float
    top: float
    unit: Unit

    def apply(self, axes: Axes, field: Variable) -> None:
        """Give axes these limits and the labels of a field."""
        top = float(self.unit.of(self.top))
        axes.set_xlim(MICROMETRE.of(self.left), MICROMETRE.of(self.right))
        axes.set_ylim((top, 0.0) if field.name in _DOWNWARD else (0.0, top))
        axes.set_xlabel("x (µm)")
        axes.set_ylabel(f"{field.label} ({self.unit.name})")


def at_edge(field: Variable) -> bool:
    """Return whether a field vanishes inside the contact, so that its edge matters."""
    return math.isnan(field.outside)


def is_traction(field: Variable) -> bool:
    """Return whether a field has a peak at the stick edge, unbounded in elastic bodies."""
    return field.si_unit == "Pa"


def frame_of(panels: Sequence[HalfProfiles]) -> Frame:
    """Return a frame that fits several panels of one field.

    A field that vanishes inside a smooth contact is shown around its edge, up to the values of the
    last cycle. Tractions of elastic bodies are shown up to three times their first peak: the later
    peak at the stick edge grows without bound as the grid is refined, and would hide the rest.
    """
    field, is_even = panels[0].field, all(panel.is_even for panel in panels)
    right = BEYOND_CONTACT * max(float(panel.contact_half_width.max()) for panel in panels)
    if at_edge(field):
        # A merged study holds the gap only within the window.
        right = min(right, max(float(panel.x[-1]) for panel in panels))
    if field.name in ("wear_depth", "wear_rate"):
        # The wear of a stroke extends beyond the contact.
        for panel in panels:
            deepest = panel.values.max(axis=0)
            worn = np.abs(panel.x[deepest > _WORN * deepest.max()])
            right = max(right, float(worn.max(initial=0.0)))
    left = 0.0 if is_even else -right
    if at_edge(field) and is_even and not any(panel.is_wavy for panel in panels):
        left = _BEFORE_EDGE * min(float(panel.contact_half_width.min()) for panel in panels)
    tops = []
    for panel in panels:
        distance, widths = np.abs(panel.x), panel.contact_half_width
        shown = panel.values[:, distance <= right]
        first, top = float(np.nanmax(shown[0])), float(np.nanmax(shown))
        if at_edge(field):
            inside = distance < _INSIDE_CONTACT * widths[:, None]
            waves = float(panel.values.max(initial=0.0, where=inside))
            last = np.nanmax(panel.values[-1, distance <= BEYOND_CONTACT * widths.max()])
            top = max(float(last), _SHARE_OF_FIRST_GAP * first, _ROOM_OVER_WAVES * waves)
        elif is_traction(field) and not panel.is_capped:
            top = min(top, _ROOM_OVER_FIRST * first)
        tops.append(top)
    unit = field.unit or readable_unit(tops, field.si_unit)
    return Frame(left, right, _ABOVE * max(tops) or 1.0, unit)


def cycle_colors(cycles: Sequence[float] | np.ndarray[Any, Any]) -> dict[int, str]:
    """Return a colour for each cycle, darker for later ones."""
    colours = sequential_colours(len(cycles))
    return {int(cycle): colour for cycle, colour in zip(cycles, colours, strict=True)}


def draw_profiles(
    axes: Axes,
    profiles: HalfProfiles,
    colors: Mapping[int, str],
    frame: Frame | None = None,
    envelope: Envelope | None = None,
) -> list[Line2D]:
    """Draw profiles in colours by cycle with the last stick zone, and return their curves.

    Panels may share a `frame`; by default it fits these profiles.
    """
    frame = frame or frame_of([profiles])
    shade_stick(axes, profiles)
    styles = [{"color": colors[int(n)], "label": cycle_text(n)} for n in profiles.cycles]
    curves = draw_curves(axes, profiles, frame.unit, styles, envelope)
    for curve in curves if is_traction(profiles.field) else ():
        x, values = (np.asarray(data) for data in curve.get_data())
        if np.nanmax(values) > frame.unit.of(frame.top):
            # A triangle marks a curve that continues above the axes.
            mark: dict[str, Any] = {
                "transform": axes.get_xaxis_transform(),
                "color": curve.get_color(),
            }
            axes.plot(x[np.nanargmax(values)], _TRIANGLE, **mark, **_ABOVE_TOP)
    frame.apply(axes, profiles.field)
    return curves


def shade_stick(axes: Axes, profiles: HalfProfiles) -> None:
    """Shade the stick zone of the last cycle."""
    if profiles.stick is not None:
        inside, x = np.isin(profiles.x, profiles.stick), MICROMETRE.of(profiles.x)
        across: dict[str, Any] = {"transform": axes.get_xaxis_transform(), "step": "mid"}
        axes.fill_between(x, 0.0, 1.0, where=inside, color=STICK_SHADE, lw=0, **across)
        return
    edge = float(MICROMETRE.of(profiles.stick_half_width[-1]))
    axes.axvspan(0.0 if profiles.is_even else -edge, edge, color=STICK_SHADE, lw=0)


def draw_curves(
    axes: Axes,
    profiles: HalfProfiles,
    unit: Unit,
    styles: Sequence[Mapping[str, Any]],
    envelope: Envelope | None = None,
) -> list[Line2D]:
    """Draw one curve per cycle in its style, over a thin one if waves crowd the profile."""
    x, readable, curves = MICROMETRE.of(profiles.x), profiles.readable(envelope), []
    for values, shown, style in zip(profiles.values, readable.values, styles, strict=True):
        if profiles.is_wavy:
            axes.plot(x, unit.of(values), **{"color": style["color"], **_RAW})
        curves += axes.plot(x, unit.of(shown), **style)
    return curves


def _name_zones(axes: Axes, profiles: HalfProfiles) -> None:
    """Name the stick and slip zones of the last cycle above the axes."""
    left, _ = axes.get_xlim()
    stick, contact = (
        float(MICROMETRE.of(width[-1]))
        for width in (profiles.stick_half_width, profiles.contact_half_width)
    )
    first, last = (left, max(left, stick)) if profiles.is_even else (-stick, stick)
    if profiles.stick is not None and profiles.stick.size:
        first, last = MICROMETRE.of(profiles.stick[[0, -1]]).tolist()
    zones = [(first, last, "stick", INK), (last, contact, "slip", MUTED)]
    if not profiles.is_even:
        zones.append((-contact, first, "slip", MUTED))
    for start, end, name, color in zones:
        if end > start:
            options: dict[str, Any] = {"transform": axes.get_xaxis_transform(), "color": color}
            axes.plot([start, end], [1.02, 1.02], **options, **_BAR)
            axes.text(0.5 * (start + end), 1.035, name, **options, **_BAR_NAME)


def cycle_key(
    figure: Figure, colors: Mapping[int, str], place: Place = "outside upper left"
) -> None:
    """Add the key of the colours of cycles, above the axes of a figure or elsewhere."""
    lines = [Line2D([], [], color=color) for color in ("none", *colors.values())]
    labels = ["cycle", *(cycle_text(cycle) for cycle in colors)]
    outside_key(figure, lines, labels, place, handlelength=1.4)


@styled
def scars(dataset: xr.Dataset, cycle: int | None = None, *, ax: Axes | None = None) -> Figure:
    """Draw the wear of both bodies along x: the indenter's upward, the flat's downward.

    The scar of the whole contact, after `cycle` or the last snapshot, is shown as a profilometer
    crosses it. A case with one wear coefficient for both bodies together raises a ValueError.
    """
    names = [field.name for field in BODY_FIELDS]
    if isinstance(dataset, xr.Dataset) and names[0] not in dataset:
        raise ValueError(
            "the dataset has no wear of each body: give wear_coefficient as [indenter, flat]"
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


@styled
def fretting_loops(
    loops: xr.Dataset, cycles: Sequence[int] | None = None, *, ax: Axes | None = None
) -> Figure:
    """Draw tangential force against displacement round a cycle, one loop for each snapshot.

    `fretwear.open_loops` returns `loops`; `cycles` are all of them by default.
    """
    shown = snapshots(loops, cycles, *(variable.name for variable in LOOP), default=list)
    force, way = (shown[variable.name] for variable in LOOP)
    about_force = LOOP[0].in_units(force.attrs.get("units", LOOP[0].si_unit))
    unit = readable_unit(force, about_force.si_unit)
    figure, axes = one_panel(1, 66.0, ax)
    axes.axhline(0.0, color="0.7", linewidth=0.5, zorder=0)
    axes.axvline(0.0, color="0.7", linewidth=0.5, zorder=0)
    x, y, colors = (
        MICROMETRE.of(way.values),
        unit.of(force.values),
        cycle_colors(shown["cycle"].values),
    )
    curves = [axes.plot(*xy, color=c)[0] for *xy, c in zip(x, y, colors.values(), strict=True)]
    axes.margins(x=0.03)
    axes.set(xlabel=f"{LOOP[1].label} (µm)", ylabel=f"{about_force.label} ({unit.name})")
    first, *others = map(cycle_text, colors)
    label_or_key(axes, curves, [f"cycle {first}", *others], ax)
    return figure


def bearing_heights(
    dataset: xr.Dataset, cycles: Cycles = None, case: Case | None = None
) -> dict[int, Array]:
    """Return the heights of the surfaces at some cycles, by default the first and the last.

    See `Roughness.in_contact`. A dataset does not record the place of the file of a measured
    surface; its `case` from a study does. Raises a `ValueError` if the case is smooth, or the file
    of its surface is missing.
    """
    states = snapshots(
        dataset, cycles, "wear_depth", "plastic_depth", default=lambda n: sorted({n[0], n[-1]})
    )
    case = case or dataset.fretwear.case
    if case.rough is None:
        raise ValueError("A bearing-area curve describes roughness, and this case is smooth.")
    if not case.rough.is_known:
        raise ValueError("The surface of this case is in a file that the dataset does not contain.")
    axes = [axis for axis in ("x", "y") if axis in dataset.coords]
    half_widths = [float(states[f"contact_half_width_{axis}"][-1]) for axis in axes]
    lost = (states["wear_depth"] + states["plastic_depth"]).transpose("cycle", *axes).values
    heights = case.rough.in_contact([dataset[axis].values for axis in axes], half_widths, lost)
    return dict(zip(states["cycle"].values.astype(int).tolist(), heights, strict=True))


@styled
def bearing_area(
    dataset: xr.Dataset, cycles: Cycles = None, *, columns: Columns = 1, ax: Axes | None = None
) -> Figure:
    """Draw the bearing-area curves (Abbott and Firestone) of a rough surface as it wears.

    The height of the roughness less wear and plastic depth is drawn over the share of the contact
    that lies above it; `cycles` are by default the first and the last snapshot. Raises a ValueError
    if the case is smooth, or the file of its surface is missing.
    """
    heights = bearing_heights(dataset, cycles)
    figure, panel = one_panel(columns, 66.0, ax)
    label, (lines,) = _draw_bearing_areas([panel], [heights])
    panel.set_ylabel(label)
    label_or_key(panel, lines, [f"cycle {cycle_text(cycle)}" for cycle in heights], ax)
    return figure


@styled
def compare_bearing_areas(
    cases: Mapping[str, xr.Dataset],
    cases_by_id: Mapping[str, Case] | None = None,
    *,
    columns: Columns = 2,
) -> Figure:
    """Draw bearing-area curves of several cases, by title, on one scale of heights.

    `cases_by_id` are the cases of the study, which name the files of measured surfaces.
    """
    check_cases(cases)
    heights = [
        bearing_heights(dataset, None, (cases_by_id or {}).get(dataset.attrs["case_id"]))
        for dataset in cases.values()
    ]
    across = min(len(cases), columns)
    figure, panels = make_panels(columns, list(cases), across, (16.0, 50.0))
    label, (*_, lines) = _draw_bearing_areas(panels, heights)
    figure.supylabel(label, fontsize=7.5)
    ends = [sorted({list(by_cycle)[end] for by_cycle in heights}) for end in (0, -1)]
    labels = [f"cycle {span(cycles, cycle_text)}" for cycles in ends]
    outside_key(figure, lines, labels[: len(lines)])
    return figure


def _draw_bearing_areas(
    panels: Sequence[Axes], heights: Sequence[Mapping[int, Array]]
) -> tuple[str, list[list[Line2D]]]:
    """Draw curves by cycle into each panel; return the label of their heights, and the curves."""
    unit = readable_unit(np.concatenate([h for panel in heights for h in panel.values()]), "m")
    for panel, curves in zip(panels, heights, strict=True):
        colors = cycle_colors(list(curves))
        for cycle, height in curves.items():
            share = 100.0 * (np.arange(height.size) + 0.5) / height.size
            panel.plot(share, unit.of(height), color=colors[cycle], label=cycle_text(cycle))
        panel.set(xlim=(0.0, 100.0), xlabel="Bearing area (% of the contact)")
    return f"Height ({unit.name})", [list(panel.get_lines()) for panel in panels]
