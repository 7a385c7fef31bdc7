"""Profiles along x at several cycles: one case, or several in panels."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fretwear.data.positions import representative_cycles
from fretwear.figures.axes import Place, label_curves, label_outer, make_panels, outside_key
from fretwear.figures.datasets import (
    BEYOND_CONTACT,
    Cycles,
    Envelope,
    HalfProfiles,
    available_cycles,
    check_cases,
    field_of,
    half_profiles,
)
from fretwear.figures.style import (
    INK,
    MUTED,
    STICK_SHADE,
    Columns,
    JournalFigure,
    one_panel,
    sequential_colours,
    styled,
)
from fretwear.units import MICROMETRE, Unit, cycle_text, readable_unit
from fretwear.vocabulary import Field

_DOWNWARD = ("wear_depth", "plastic_depth")

_BEFORE_EDGE = 0.75
_ABOVE = 1.05
_INSIDE_CONTACT = 0.8
_ROOM_OVER_WAVES = 1.6
_SHARE_OF_FIRST_GAP = 0.3
_ROOM_OVER_FIRST = 3.0
_TRIANGLE = 0.985
_RAW: dict[str, Any] = {"lw": 0.5, "alpha": 0.6, "label": "_raw"}
_BAR: dict[str, Any] = {"lw": 1.6, "solid_capstyle": "butt", "label": "_zone", "clip_on": False}
_BAR_NAME: dict[str, Any] = {"fontsize": 6.5, "ha": "center", "va": "bottom"}


@styled
def field_profiles(
    dataset: xr.Dataset,
    quantity: Field | str,
    cycles: Cycles = None,
    *,
    columns: Columns = 1,
    ax: Axes | None = None,
) -> Figure:
    """Draw any field along x at y = 0 at several cycles.

    Parameters
    ----------
    dataset : xarray.Dataset
        One case (quarter or whole contact), or one point of a merged study.
    quantity : str
        The field, such as ``pressure``. Wear depth is drawn downwards.
    cycles : int or sequence of int, optional
        Snapshots to draw; left out, at most six of those there are.
    columns : {1, 2}
        Journal columns that the figure spans, 90 mm or 190 mm.
    ax : matplotlib.axes.Axes, optional
        Where to draw, in a figure of your own; `columns` then says nothing.

    Returns
    -------
    matplotlib.figure.Figure
        Pressure in MPa over x in µm, for example. Where roughness crowds a profile, a thin line
        is the profile and a thick one its envelope, or its mean over a wave. A triangle at the
        top is the peak of a traction that continues above: in elastic bodies the one at the edge
        of the stick zone grows with a finer grid, without end, and more than three times the
        first peak is not shown.

    Raises
    ------
    TypeError
        When `dataset` is not a dataset.
    ValueError
        When `dataset` has no such field or snapshot, or varies in a case parameter.
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
        lines = [Line2D([], [], color=color) for color in colors.values()]
        panel.legend(lines, names, title="cycle")
    return figure


class ProfileFigure(Protocol):
    """Draws one field along x, as `field_profiles` does."""

    def __call__(
        self,
        dataset: xr.Dataset,
        cycles: Cycles = None,
        *,
        columns: Columns = 1,
        ax: Axes | None = None,
    ) -> Figure:
        """Return the figure."""


def _profiles_of(name: str, quantity: str, words: str) -> ProfileFigure:
    def draw(
        dataset: xr.Dataset,
        cycles: Cycles = None,
        *,
        columns: Columns = 1,
        ax: Axes | None = None,
    ) -> Figure:
        return field_profiles(dataset, quantity, cycles, columns=columns, ax=ax)

    draw.__name__ = draw.__qualname__ = name
    draw.__doc__ = f"Draw {words} along x; parameters are those of `field_profiles`."
    return draw


pressure_profiles = _profiles_of("pressure_profiles", "pressure", "the normal pressure")
shear_profiles = _profiles_of("shear_profiles", "shear_traction", "the shear traction at +Q")
gap_profiles = _profiles_of("gap_profiles", "gap", "the gap at load P")
wear_rate_profiles = _profiles_of("wear_rate_profiles", "wear_rate", "the wear of one cycle")
wear_profiles = _profiles_of("wear_profiles", "wear_depth", "the worn depth, downwards,")


@styled
def compare_profiles(
    cases: Mapping[str, xr.Dataset],
    quantity: Field | str,
    cycles: Cycles = None,
    *,
    columns: Columns = 2,
) -> Figure:
    """Draw the profiles of one field of several cases in panels; those of a row have the same axes.

    Parameters
    ----------
    cases : mapping of str to xarray.Dataset
        The cases by the title of their panel.
    quantity : str
        What to draw: ``pressure``, ``shear_traction``, ``gap``, ``wear_depth`` or another field
        of a case, by its name.
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
        When `cases` is not a mapping of titles to datasets.
    ValueError
        When there is no case, no such quantity, or none of the cases has one of the snapshots.
    """
    check_cases(cases)
    field = field_of(quantity)
    snapshots = {title: available_cycles(case) for title, case in cases.items()}
    shown = _shown_cycles(snapshots, cycles)
    colors = cycle_colors(shown)
    widest = max(float(case["contact_half_width_x"].max()) for case in cases.values())
    profiles = [
        half_profiles(
            case, field, [n for n in shown if n in snapshots[title]], BEYOND_CONTACT * widest
        )
        for title, case in cases.items()
    ]
    across = min(len(cases), 2 if columns == 2 else 1)
    figure = JournalFigure(columns, 14.0 + 50.0 * -(-len(cases) // across))
    # The edge of the contact is elsewhere for rough and for smooth cases.
    panels = make_panels(figure, len(cases), across, "row", "row" if at_edge(field) else "all")
    everything = frame_of(profiles)
    for index, (axes, title) in enumerate(zip(panels, cases, strict=True)):
        start = index - index % across
        frame = frame_of(profiles[start : start + across])
        frame = frame if at_edge(field) else replace(everything, top=frame.top)
        draw_profiles(axes, profiles[index], colors, frame)
        axes.set_title(title)
    label_outer(panels, across, every_x=at_edge(field))
    cycle_key(figure, colors)
    return figure


def _shown_cycles(snapshots: Mapping[str, Sequence[int]], cycles: Cycles) -> Sequence[int]:
    """Return the cycles to show of several cases; refuse one that none of them has."""
    available = sorted(set().union(*snapshots.values()))
    if cycles is None:
        return representative_cycles(available)
    wanted: list[int] = np.atleast_1d(cycles).tolist()
    lacking = {title: had for title, had in snapshots.items() if not set(wanted).intersection(had)}
    if not wanted or lacking or not set(wanted) <= set(available):
        had = next(iter(lacking.values()), available)
        raise ValueError(
            f"cycles = {wanted}: every cycle must be a snapshot of some case, and every case must "
            f"have one of them; {next(iter(lacking), 'all cases together')!r} has {list(had)}."
        )
    return wanted


@dataclass(frozen=True)
class Frame:
    """Limits of profiles: x and largest value in SI units, with the unit of the y axis."""

    left: float
    right: float
    top: float
    unit: Unit

    def apply(self, axes: Axes, field: Field) -> None:
        """Give axes of a field these limits, and their labels."""
        top = float(self.unit.of(self.top))
        axes.set_xlim(MICROMETRE.of(self.left), MICROMETRE.of(self.right))
        axes.set_ylim((top, 0.0) if field.name in _DOWNWARD else (0.0, top))
        axes.set_xlabel("x (µm)")
        axes.set_ylabel(f"{field.label} ({self.unit.name})")


def at_edge(field: Field) -> bool:
    """Tell whether a field matters at the edge of the contact: it vanishes inside."""
    return math.isnan(field.outside)


def is_traction(field: Field) -> bool:
    """Tell whether a field has a peak at the edge of stick that has no limit in elastic bodies."""
    return field.si_unit == "Pa"


def frame_of(panels: Sequence[HalfProfiles]) -> Frame:
    """Return the frame that shows all of some panels of one field.

    What vanishes inside a smooth contact is shown around its edge; its values then go as far as
    those of the last cycle, and curves of earlier ones leave at the top. The tractions of elastic
    bodies are shown up to three times their first peak: the later one at the edge of the stick
    zone grows without bound as the grid is refined, and would hide the rest.
    """
    field = panels[0].field
    right = BEYOND_CONTACT * max(float(panel.contact_half_width.max()) for panel in panels)
    is_even = all(panel.is_even for panel in panels)
    left = 0.0 if is_even else -right
    if at_edge(field):
        # A merged study has the gap only as far as it is stored.
        right = min(right, max(float(panel.x[-1]) for panel in panels))
        left = 0.0 if is_even else -right
        if is_even and not any(panel.is_wavy for panel in panels):
            left = _BEFORE_EDGE * min(float(panel.contact_half_width.min()) for panel in panels)
    if field.name in ("wear_depth", "wear_rate"):
        # Over a stroke a contact wears beside itself too.
        right = max(right, *(_worn_half_width(panel) for panel in panels))
        left = 0.0 if is_even else -right
    top = max(_top(panel, right) for panel in panels)
    return Frame(left, right, _ABOVE * top or 1.0, field.unit or readable_unit(top, field.si_unit))


def _worn_half_width(profiles: HalfProfiles) -> float:
    """Distance, m, up to which anything is worn off, 1 % of the most."""
    deepest = profiles.values.max(axis=0)
    worn = np.flatnonzero(deepest > 0.01 * deepest.max())
    return float(abs(profiles.x[worn]).max(initial=0.0))


def _top(profiles: HalfProfiles, right: float) -> float:
    distance = np.abs(profiles.x)
    shown = profiles.values[:, distance <= right]
    first, highest = float(np.nanmax(shown[0])), float(np.nanmax(shown))
    if at_edge(profiles.field):
        inside = [
            float(values[distance < _INSIDE_CONTACT * half_width].max(initial=0.0))
            for values, half_width in zip(profiles.values, profiles.contact_half_width, strict=True)
        ]
        near = distance <= BEYOND_CONTACT * profiles.contact_half_width.max()
        last = float(np.nanmax(profiles.values[-1, near]))
        return max(last, _SHARE_OF_FIRST_GAP * first, _ROOM_OVER_WAVES * max(inside))
    if is_traction(profiles.field) and not profiles.is_capped:
        return min(highest, _ROOM_OVER_FIRST * first)
    return highest


def cycle_colors(cycles: Sequence[float] | np.ndarray[Any, Any]) -> dict[int, str]:
    """Return a colour for each of some cycles, the later the darker."""
    colours = sequential_colours(len(cycles))
    return {int(cycle): colour for cycle, colour in zip(cycles, colours, strict=True)}


def draw_profiles(
    axes: Axes,
    profiles: HalfProfiles,
    colors: Mapping[int, str],
    frame: Frame | None = None,
    envelope: Envelope | None = None,
) -> list[Line2D]:
    """Draw profiles with the stick zone of the last cycle; return their curves.

    `colors` are by cycle, `frame` is given when several panels must agree on their limits, and
    `envelope` is as for `HalfProfiles.readable`.
    """
    frame = frame or frame_of([profiles])
    shade_stick(axes, profiles)
    styles = [{"color": colors[int(n)], "label": cycle_text(n)} for n in profiles.cycles]
    curves = draw_curves(axes, profiles, frame.unit, styles, envelope)
    for curve in curves if is_traction(profiles.field) else ():
        x, values = (np.asarray(data) for data in curve.get_data())
        if np.nanmax(values) > frame.unit.of(frame.top):
            # The triangle says that the curve continues above the axes.
            axes.plot(
                [x[np.nanargmax(values)]],
                [_TRIANGLE],
                transform=axes.get_xaxis_transform(),
                marker="^",
                markersize=3.5,
                color=curve.get_color(),
                label="_above",
            )
    frame.apply(axes, profiles.field)
    return curves


def shade_stick(axes: Axes, profiles: HalfProfiles) -> None:
    """Shade the stick zone of the last cycle."""
    if profiles.stick is not None:
        inside, x = np.isin(profiles.x, profiles.stick), MICROMETRE.of(profiles.x)
        across = axes.get_xaxis_transform()
        axes.fill_between(
            x, 0.0, 1.0, where=inside, transform=across, step="mid", color=STICK_SHADE, lw=0
        )
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
    """Draw one curve per cycle, over a thin one of the profile where waves crowd it.

    `unit` is that of the y axis, `styles` are colour, line style and label of each curve, as
    matplotlib names them.
    """
    x, readable, curves = MICROMETRE.of(profiles.x), profiles.readable(envelope), []
    for values, shown, style in zip(profiles.values, readable.values, styles, strict=True):
        if profiles.is_wavy:
            axes.plot(x, unit.of(values), **{"color": style["color"], **_RAW})
        curves += axes.plot(x, unit.of(shown), **style)
    return curves


def _name_zones(axes: Axes, profiles: HalfProfiles) -> None:
    """Name the stick and slip zones of the last cycle above the axes."""
    left, _ = axes.get_xlim()
    stick = max(left, float(MICROMETRE.of(profiles.stick_half_width[-1])))
    contact = float(MICROMETRE.of(profiles.contact_half_width[-1]))
    above = axes.get_xaxis_transform()
    zones = [(left, stick, "stick", INK), (stick, contact, "slip", MUTED)]
    if not profiles.is_even:
        first, last = -stick, stick
        if profiles.stick is not None and profiles.stick.size:
            first, last = (float(MICROMETRE.of(profiles.stick[end])) for end in (0, -1))
        zones = [(first, last, "stick", INK)]
        zones += [(last, contact, "slip", MUTED), (-contact, first, "slip", MUTED)]
    for start, end, name, color in zones:
        if end <= start:
            continue
        axes.plot([start, end], [1.02, 1.02], transform=above, color=color, **_BAR)
        axes.text(0.5 * (start + end), 1.035, name, transform=above, color=color, **_BAR_NAME)


def cycle_key(
    figure: Figure, colors: Mapping[int, str], place: Place = "outside upper left"
) -> None:
    """Add the key of colours that tell cycles, above the axes of a figure or elsewhere."""
    lines = [Line2D([], [], color=color) for color in ("none", *colors.values())]
    labels = ["cycle", *(cycle_text(cycle) for cycle in colors)]
    outside_key(figure, lines, labels, place, handlelength=1.4)
