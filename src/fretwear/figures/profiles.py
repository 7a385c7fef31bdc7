"""Curves of cases at several cycles: profiles along x and fretting loops."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from fretwear.arrays import Array
from fretwear.figures.axes import Place, Shared, add_key, make_panels
from fretwear.figures.colours import CATEGORICAL
from fretwear.figures.datasets import (
    Cycles,
    Profiles,
    TitledCases,
    field_of,
    profiles_of,
    snapshots,
    titled,
)
from fretwear.figures.style import (
    INK,
    STICK_SHADE,
    Columns,
    caption,
    one_panel,
    sequential_colours,
    styled,
)
from fretwear.results import LOOP
from fretwear.units import MICROMETRE, Unit, cycle_text, number_text, readable_unit, with_unit
from fretwear.variable import ContactState, Variable

ZONE_COLORS = {
    ContactState.OPEN: "#f4f4f4",
    ContactState.SLIP: "#8cc5e3",
    ContactState.STICK: "#084a8c",
}
"""From light to dark, so that zones can be distinguished in grey too."""
ZONES = ListedColormap([ZONE_COLORS[zone] for zone in ContactState])

_DOWNWARD = ("wear_depth", "wear_depth_flat", "plastic_depth")
_BEYOND_CONTACT = 1.12  # distance to which profiles are shown, in half-widths of the contact
_BEFORE_EDGE = 0.75
_ABOVE = 1.05
_SHARE_OF_FIRST_GAP = 0.3
_WORN = 0.01
_UNEQUAL = 5.0
_STRIP = 0.05
_FIRST_WIDTH, _LAST_WIDTH = 0.6, 0.7
_FILL = "#d9d9d9"


def case_panels(
    cases: Mapping[str, object], columns: Columns, ax: Axes | None, height: float, share_y: Shared
) -> tuple[Figure, list[Axes]]:
    """Return a figure with a panel for each case, or with `ax` for a single one."""
    if len(cases) == 1:
        figure, axes = one_panel(1, height + 16.0, ax)
        axes.set_title(next(iter(cases)))
        return figure, [axes]
    if ax is not None:
        raise ValueError("Several cases need panels: leave out ax.")
    across = columns if len(cases) != 3 else min(3, columns + 1)
    return make_panels(columns, [*cases], across, (16.0, height), share_y)


@styled
def field_profiles(
    cases: TitledCases,
    quantity: Variable | str,
    cycles: Cycles = None,
    *,
    columns: Columns = 2,
    ax: Axes | None = None,
) -> Figure:
    """Draw any field, such as ``pressure``, along x at y = 0 at several cycles.

    Pressure is in MPa over x in µm, for example; wear depth is drawn downwards. Of a rough contact,
    whose curves would hide each other, the last profile is filled, before the line of the first
    and over a strip that shows where the surfaces slip and stick. If the pressure was found to be
    singular at the edge of the stick zone, where it grows without bound as cells get narrower, axes
    end at three times the first peak, and the highest value is written.
    """
    cases = titled(cases)
    field = field_of(quantity)
    contents = [profiles_of(case, field, cycles) for case in cases.values()]
    frames = [frame_of([content]) for content in contents]
    tops = [frame.top for frame in frames]
    if is_shared := max(tops) <= _UNEQUAL * min(tops):
        frames = [frame_of(contents)] * len(contents)
    figure, panels = case_panels(cases, columns, ax, 50.0, "all" if is_shared else "none")
    on_line = " at y = 0" if any("y" in case.dims for case in cases.values()) else ""
    caption(figure, f"{field.label} along the direction of slip{on_line}.")
    every = sorted({int(cycle) for content in contents for cycle in content.cycles})
    colors, is_filled = cycle_colours(every), any(content.is_rough for content in contents)
    for panel, content, frame in zip(panels, contents, frames, strict=True):
        if is_filled:
            draw_filled(panel, content, frame)
        else:
            draw_profiles(panel, content, colors, frame)
    if is_filled:
        zone_key(ax or figure, contents)
    else:
        cycle_key(ax or figure, colors)
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
        # A power of ten above the axis would lie over the title.
        axes.ticklabel_format(axis="y", style="plain", useOffset=False)
        axes.set_xlabel("x (µm)")
        axes.set_ylabel(f"{field.label} ({self.unit.name})")


def at_edge(field: Variable) -> bool:
    """Return whether a field vanishes inside the contact, so that its edge matters."""
    return math.isnan(field.outside)


def frame_of(panels: Sequence[Profiles]) -> Frame:
    """Return a frame that fits several panels of one field.

    A field that vanishes inside a smooth contact is shown around its edge, up to the values of the
    last cycle. A traction with a singular edge is shown up to its ceiling.
    """
    field, is_even = panels[0].field, all(panel.is_even for panel in panels)
    widest = max(float(panel.contact_half_width.max()) for panel in panels)
    right = _BEYOND_CONTACT * widest
    if at_edge(field):  # known within the window of a case
        right = min(right, max(float(panel.x[-1]) for panel in panels))
    if field.name in ("wear_depth", "wear_rate"):  # beyond the contact by the stroke
        for panel in panels:
            deepest = panel.values.max(axis=0)
            worn = np.abs(panel.x[deepest > _WORN * deepest.max()])
            right = max(right, float(worn.max(initial=0.0)))
    left = 0.0 if is_even else -right
    if at_edge(field) and is_even and not any(panel.is_rough for panel in panels):
        left = _BEFORE_EDGE * min(float(panel.contact_half_width.min()) for panel in panels)
    tops = []
    for panel in panels:
        shown = panel.values[:, np.abs(panel.x) <= right]
        top = float(np.nanmax(shown))
        if at_edge(field):  # the bodies approach each other, so that the first gap is the largest
            top = max(float(np.nanmax(shown[-1])), _SHARE_OF_FIRST_GAP * top)
        tops.append(min(top, panel.ceiling))
    unit = field.unit or readable_unit(tops, field.si_unit)
    return Frame(left, right, _ABOVE * max(tops) or 1.0, unit)


def cycle_colours(cycles: Sequence[float] | Array) -> dict[int, str]:
    """Return a colour for each cycle, darker for later ones."""
    colours = sequential_colours(len(cycles))
    return {int(cycle): colour for cycle, colour in zip(cycles, colours, strict=True)}


def draw_profiles(
    axes: Axes, profiles: Profiles, colors: Mapping[int, str], frame: Frame | None = None
) -> None:
    """Draw profiles in colours by cycle with the last stick zone.

    Panels may share a `frame`; by default it fits these profiles.
    """
    frame = frame or frame_of([profiles])
    x, rows = profiles.from_middle
    shade_stick(axes, profiles)
    for cycle, values in zip(profiles.cycles, rows, strict=True):
        color, y = colors[int(cycle)], frame.unit.of(values)
        axes.plot(MICROMETRE.of(x), y, color=color, label=cycle_text(cycle))
    write_peak(axes, profiles, frame)
    frame.apply(axes, profiles.field)


def draw_filled(axes: Axes, profiles: Profiles, frame: Frame | None = None) -> None:
    """Draw the last profile, filled, over a strip of its zones and before the line of the first."""
    frame = frame or frame_of([profiles])
    x, values = profiles.from_middle
    x, values = MICROMETRE.of(x), frame.unit.of(values)
    if len(values) > 1 and values[0].any():
        axes.plot(x, values[0], color=CATEGORICAL[1], lw=_FIRST_WIDTH, label="_first")
    axes.fill_between(x, 0.0, values[-1], color=_FILL, lw=0)
    axes.plot(x, values[-1], color=INK, lw=_LAST_WIDTH, label=profiles.field.label)
    bottom, half = -_STRIP * float(frame.unit.of(frame.top)), 0.5 * float(x[1] - x[0])
    extent = (float(x[-profiles.x.size]) - half, float(x[-1]) + half, bottom, 0.0)
    axes.imshow(
        profiles.zones[-1:], ZONES, aspect="auto", extent=extent, vmin=0, vmax=len(ZONE_COLORS) - 1
    )
    write_peak(axes, profiles, frame)
    frame.apply(axes, profiles.field)
    axes.set_ylim(*(limit or bottom for limit in axes.get_ylim()))


def zone_key(
    canvas: Figure | Axes, contents: Sequence[Profiles], place: Place = "outside upper left"
) -> None:
    """Add the key of the zones and of the lines of the first and the last profile."""
    handles: list[Artist] = [Patch(color=color) for color in reversed(ZONE_COLORS.values())]
    labels = [state.name.lower() for state in reversed(ZONE_COLORS)]
    ends = [{int(p.cycles[end]) for p in contents} for end in (0, -1)]
    if ends[0] != ends[1]:
        for cycles, color in zip(ends, (CATEGORICAL[1], INK), strict=True):
            handles.append(Line2D([], [], color=color, lw=_FIRST_WIDTH))
            texts = dict.fromkeys(map(cycle_text, (min(cycles), max(cycles))))
            labels.append(f"cycle {' to '.join(texts)}")
    add_key(canvas, handles, labels, place)


def write_peak(axes: Axes, profiles: Profiles, frame: Frame) -> None:
    """Write the highest traction of a cell where it lies above the axes."""
    highest = float(np.nanmax(profiles.values))
    if profiles.field.si_unit == "Pa" and highest > frame.top:
        x = profiles.x[np.nanargmax(np.nanmax(profiles.values, axis=0))]
        text = with_unit(number_text(float(frame.unit.of(highest)), 3), frame.unit)
        label = axes.text(float(MICROMETRE.of(x)), 0.97, f"  ↑ {text}", va="top", fontsize=7.0)
        label.set_transform(axes.get_xaxis_transform())
        caption(
            axes,
            "Arrow: singular at this edge of the stick zone, where it grows as cells get narrower; "
            "the number is the highest value of a cell.",
        )


def shade_stick(axes: Axes, profiles: Profiles) -> None:
    """Shade the stick zone of the last cycle."""
    sticking = profiles.zones[-1] == ContactState.STICK
    if profiles.is_even:
        edge = float(MICROMETRE.of(profiles.stick_half_width[-1]))
        axes.axvspan(0.0, edge, color=STICK_SHADE, lw=0)
    else:
        x, across = MICROMETRE.of(profiles.x), axes.get_xaxis_transform()
        shade = axes.fill_between(x, 0.0, 1.0, where=sticking, step="mid", transform=across)
        shade.set(color=STICK_SHADE, linewidth=0.0)
    if sticking.any():
        caption(axes, "Grey: stick zone at the last cycle.")


def cycle_key(
    canvas: Figure | Axes, colors: Mapping[int, str], place: Place = "outside upper left"
) -> None:
    """Add the key of the colours of cycles."""
    lines = [Line2D([], [], color=color) for color in colors.values()]
    first, *others = map(cycle_text, colors)
    add_key(canvas, lines, [f"cycle {first}", *others], place)


@styled
def fretting_loops(
    cases: TitledCases, cycles: Cycles = None, *, columns: Columns = 2, ax: Axes | None = None
) -> Figure:
    """Draw tangential force against displacement round a cycle, one loop for each snapshot.

    `fretwear.open_loops` returns the loops of a case; `cycles` are at most six by default.
    """
    cases = titled(cases)
    force, displacement = (variable.name for variable in LOOP)
    contents = [snapshots(loops, cycles, force, displacement) for loops in cases.values()]
    figure, panels = case_panels(cases, columns, ax, 50.0, "none")
    caption(figure, "Tangential force against displacement round a cycle.")
    caption(figure, "The area of a loop is the energy dissipated in the cycle.")
    colors = cycle_colours(sorted({int(n) for loops in contents for n in loops["cycle"]}))
    quantity = LOOP[0].in_dataset(contents[0])
    unit = readable_unit([float(abs(loops[force]).max()) for loops in contents], quantity.si_unit)
    for axes, loops in zip(panels, contents, strict=True):
        axes.axhline(0.0, color="0.7", linewidth=0.5, zorder=0)
        axes.axvline(0.0, color="0.7", linewidth=0.5, zorder=0)
        for cycle in loops["cycle"].values:
            y, x = (loops[name].sel(cycle=cycle).values for name in (force, displacement))
            color, label = colors[int(cycle)], cycle_text(cycle)
            axes.plot(MICROMETRE.of(x), unit.of(y), color=color, label=label)
        axes.margins(x=0.03)
        axes.set(xlabel=f"{LOOP[1].label} (µm)", ylabel=f"{quantity.label} ({unit.name})")
    cycle_key(ax or figure, colors)
    return figure
