"""Curves of cases at several cycles: profiles along x, scars, bearing areas, fretting loops."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from fretwear.arrays import Array
from fretwear.data.dataset import line_near_the_middle, mirrored
from fretwear.data.stack import representative_cycles
from fretwear.figures.axes import Place, label_curves, label_or_key, outside_key
from fretwear.figures.compare import Shared, Tiles, draw_case, draw_cases
from fretwear.figures.datasets import (
    BEYOND_CONTACT,
    Cycles,
    Profiles,
    available_cycles,
    field_of,
    profiles_of,
    snapshots,
    stored_name,
)
from fretwear.figures.style import (
    CATEGORICAL,
    INK,
    MUTED,
    STICK_SHADE,
    Columns,
    caption,
    one_panel,
    root_figure,
    sequential_colours,
    styled,
)
from fretwear.study.case import Case
from fretwear.units import MICROMETRE, Unit, cycle_text, number_text, readable_unit, span, with_unit
from fretwear.vocabulary import BODY_FIELDS, LOOP, RESULTS, ContactState, Variable

ZONE_COLORS = {
    ContactState.OPEN: "#f4f4f4",
    ContactState.SLIP: "#8cc5e3",
    ContactState.STICK: "#084a8c",
}
"""From light to dark, so that zones can be distinguished in grey too."""
ZONES = ListedColormap([ZONE_COLORS[zone] for zone in ContactState])

_DOWNWARD = ("wear_depth", "plastic_depth")
_BEFORE_EDGE = 0.75
_ABOVE = 1.05
_INSIDE_CONTACT = 0.8
_ROOM_OVER_WAVES = 1.6
_SHARE_OF_FIRST_GAP = 0.3
_WORN, _INVISIBLE = 0.01, 0.1
_TRIANGLE = 0.985
_STRIP = 0.05
_SAME_LOOP = 0.005
_FIRST_WIDTH, _LAST_WIDTH = 0.6, 0.7
_FILL = "#d9d9d9"


def _profiles(
    cases: Mapping[str, xr.Dataset], cycles: Cycles, *, field: Variable, alone: bool
) -> Tiles:
    """Take the curves of a field at several cycles, or filled profiles if bodies are rough.

    Curves of rough contacts at several cycles hide each other. Their first profile stands beside
    the last one or, in panels that must stand `alone`, behind it.
    """
    shown = _cycles_of(cases, cycles, field)
    widest = max(float(case["contact_half_width_x"].max()) for case in cases.values())
    reach = BEYOND_CONTACT * widest if len(cases) > 1 else 0.0
    profiles = {n: profiles_of(case, field, shown[n], reach) for n, case in cases.items()}
    every = sorted({int(cycle) for case in profiles.values() for cycle in case.cycles})
    is_filled = any(case.is_rough for case in profiles.values())
    if is_filled and not alone:
        # A figure with rough contacts shows its smooth ones in the same way.
        profiles = {
            f"{title}{', ' * bool(title)}cycle {cycle_text(case.cycles[place])}": case.at(place)
            for title, case in profiles.items()
            for place in (case.first, len(case.cycles) - 1)
        }
    contents, per_row = [*profiles.values()], 2 if is_filled or len(cases) > 1 else 1
    by_row, common = is_filled or at_edge(field), frame_of(contents)
    frames, titles = list[Frame](), list[str]()
    for index, (title, case) in enumerate(profiles.items()):
        row = contents[index - index % per_row :][:per_row]
        frame, close = frame_of(row) if by_row else common, frame_of([case])
        is_small = close.top < _INVISIBLE * frame.top
        frame = close if is_small else frame
        is_whole = is_filled or not at_edge(field)
        frames.append(replace(common, top=frame.top, unit=frame.unit) if is_whole else frame)
        titles.append(f"{title}, own scale" if is_small else title)
    has_own = any(title not in profiles for title in titles)

    def draw(panels: Sequence[Axes], ax: Axes | None) -> None:
        about = "y = 0" if any("y" in case.dims for case in cases.values()) else ""
        on_line = f" on the line nearest {about}" if about else ""
        caption(panels[0], f"{field.label} along the direction of slip{on_line}.")
        if has_own:
            seen = "Panels titled “own scale” hold values too small for the scale of the others."
            caption(panels[0], seen)
        figure, colors = root_figure(panels[0]), cycle_colours(every)
        curves: list[Line2D] = []
        for axes, content, frame in zip(panels, contents, frames, strict=True):
            if is_filled:
                draw_filled(axes, content, frame)
            else:
                curves = draw_profiles(axes, content, colors, frame)
        if is_filled:
            zone_key(figure if ax is None else ax, contents)
            caption(panels[0], "Strip: where the surfaces stick, slip and are apart.")
            return
        names = [cycle_text(cycle) for cycle in every]
        if len(panels) == 1:
            _name_zones(panels[0], contents[0])
            if label_curves(panels[0], curves, [f"cycle {names[0]}", *names[1:]]):
                return
        if ax is None:
            cycle_key(figure, colors)
        else:
            ax.legend(curves, names, title="cycle")

    share_y: Shared = "none" if is_filled or has_own else "row" if at_edge(field) else "all"
    return Tiles(titles, draw, "all" if not at_edge(field) else "row", share_y)


def _cycles_of(
    cases: Mapping[str, xr.Dataset], cycles: Cycles, field: Variable
) -> dict[str, Sequence[int]]:
    """Return the cycles that are drawn of each case: of those asked for, the ones that it has."""
    if len(cases) == 1:
        ((title, case),) = cases.items()
        return {
            title: snapshots(case, cycles, stored_name(case, field.name))["cycle"]
            .values.astype(int)
            .tolist()
        }
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
    return {title: [n for n in shown if n in had] for title, had in available.items()}


def field_profiles(
    dataset: xr.Dataset,
    quantity: Variable | str,
    cycles: Cycles = None,
    *,
    columns: Columns = 1,
    ax: Axes | None = None,
) -> Figure:
    """Draw any field, such as ``pressure``, along x at y = 0 at several cycles.

    Pressure is in MPa over x in µm, for example; wear depth is drawn downwards. Profiles of rough
    bodies are filled, the first beside the last one, over a strip that shows where the surfaces
    slip and stick; drawn into `ax`, the last one stands before the line of the first. If the
    pressure was found to be singular at the edge of the stick zone, where it grows without bound as
    cells get narrower, axes end at three times the first peak, and the highest value is written.
    """
    picture = partial(_profiles, field=field_of(quantity), alone=ax is not None)
    return draw_case(dataset, picture, cycles, columns, ax)


def compare_profiles(
    cases: Mapping[str, xr.Dataset],
    quantity: Variable | str,
    cycles: Cycles = None,
    *,
    columns: Columns = 2,
) -> Figure:
    """Draw `field_profiles` of several cases, by the titles of their panels.

    Each of the `cycles` is drawn in the cases that have it; a cycle that no case has, or a case
    that has none of the cycles, raises a ValueError.
    """
    picture = partial(_profiles, field=field_of(quantity), alone=False)
    return draw_cases(cases, picture, cycles, columns=columns)


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
    if at_edge(field) and is_even and not any(panel.is_rough for panel in panels):
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
        top = min(top, panel.ceiling)
        tops.append(top)
    unit = field.unit or readable_unit(tops, field.si_unit)
    return Frame(left, right, _ABOVE * max(tops) or 1.0, unit)


def cycle_colours(cycles: Sequence[float] | Array) -> dict[int, str]:
    """Return a colour for each cycle, darker for later ones."""
    colours = sequential_colours(len(cycles))
    return {int(cycle): colour for cycle, colour in zip(cycles, colours, strict=True)}


def draw_profiles(
    axes: Axes, profiles: Profiles, colors: Mapping[int, str], frame: Frame | None = None
) -> list[Line2D]:
    """Draw profiles in colours by cycle with the last stick zone, and return their curves.

    Panels may share a `frame`; by default it fits these profiles.
    """
    frame = frame or frame_of([profiles])
    x, curves = MICROMETRE.of(profiles.x), list[Line2D]()
    shade_stick(axes, profiles)
    for cycle, values in zip(profiles.cycles, profiles.values, strict=True):
        y, color = frame.unit.of(values), colors[int(cycle)]
        curves += axes.plot(x, y, color=color, label=cycle_text(cycle))
    mark_peak(axes, profiles, frame)
    frame.apply(axes, profiles.field)
    return curves


def draw_filled(
    axes: Axes, profiles: Profiles, frame: Frame | None = None
) -> Callable[[int], None]:
    """Draw the last profile, filled, over a strip of its zones and before the line of the first.

    Return a function that shows another one of the profiles, given by its place.
    """
    frame = frame or frame_of([profiles])
    x, values = MICROMETRE.of(profiles.x), frame.unit.of(profiles.values)
    if len(values) > 1 and profiles.values[0].any():
        axes.plot(x, values[0], color=MUTED, lw=_FIRST_WIDTH, label="_first")
    fill = axes.fill_between(x, 0.0, 0.0, color=_FILL, lw=0)
    (line,) = axes.plot(x, values[-1], color=INK, lw=_LAST_WIDTH, label=profiles.field.label)
    below, half = -_STRIP * float(frame.unit.of(frame.top)), 0.5 * float(x[1] - x[0])
    extent = (float(x[0]) - half, float(x[-1]) + half, below, 0.0)
    strip = axes.imshow(
        profiles.zones[-1:], ZONES, aspect="auto", extent=extent, vmin=0, vmax=len(ZONE_COLORS) - 1
    )
    mark_peak(axes, profiles, frame)
    frame.apply(axes, profiles.field)
    axes.set_ylim(*(limit or below for limit in axes.get_ylim()))

    def update(place: int) -> None:
        line.set_ydata(values[place])
        fill.set_data(x, 0.0, values[place])
        strip.set_data(profiles.zones[place : place + 1])

    update(-1 % len(values))
    return update


def zone_key(
    inside: Figure | Axes, contents: Sequence[Profiles], place: Place = "outside upper left"
) -> None:
    """Add the key of the zones, and of the line of the first profile if there is one."""
    handles: list[Artist] = [Patch(color=color) for color in reversed(ZONE_COLORS.values())]
    labels = [state.name.lower() for state in reversed(ZONE_COLORS)]
    if starts := sorted({int(p.cycles[0]) for p in contents if len(p.cycles) > 1}):
        handles.append(Line2D([], [], color=MUTED, lw=_FIRST_WIDTH))
        labels.append(f"cycle {span(starts, cycle_text)}")
    if isinstance(inside, Axes):
        inside.legend(handles, labels)
    else:
        outside_key(inside, handles, labels, place, handlelength=1.2)


def mark_peak(axes: Axes, profiles: Profiles, frame: Frame) -> None:
    """Mark where profiles continue above the axes, and write the highest value."""
    top = float(frame.unit.of(frame.top))
    across = axes.get_xaxis_transform()
    values = frame.unit.of(profiles.values)
    for row in (
        np.flatnonzero(np.nanmax(values, axis=1) > top) if profiles.field.si_unit == "Pa" else ()
    ):
        x = float(MICROMETRE.of(profiles.x[np.nanargmax(values[row])]))
        axes.plot([x], [_TRIANGLE], "^", color=INK, ms=3.5, transform=across, label="_above")
    if top < np.nanmax(values) and profiles.field.si_unit == "Pa":
        text = f" {with_unit(number_text(float(np.nanmax(values)), 3), frame.unit)}"
        axes.text(x, 0.95, text, transform=across, fontsize=6.0, va="top")
        caption(
            axes,
            f"Triangles: the {profiles.field.words} is singular at this edge of the stick zone, "
            "where it grows without bound as cells get narrower; the number is the highest value "
            "of a cell.",
        )


def shade_stick(axes: Axes, profiles: Profiles) -> None:
    """Shade the stick zone of the last cycle."""
    if profiles.is_even:
        edge = float(MICROMETRE.of(profiles.stick_half_width[-1]))
        axes.axvspan(0.0, edge, color=STICK_SHADE, lw=0)
        is_seen = edge > 0.0
    else:
        inside = profiles.zones[-1] == ContactState.STICK
        x, across, is_seen = MICROMETRE.of(profiles.x), axes.get_xaxis_transform(), inside.any()
        axes.fill_between(
            x, 0.0, 1.0, where=inside, color=STICK_SHADE, lw=0, transform=across, step="mid"
        )
    if is_seen:
        caption(axes, "Grey: stick zone at the last cycle.")


def _name_zones(axes: Axes, profiles: Profiles) -> None:
    """Name the stick and slip zones of the last cycle above the axes."""
    left, _ = axes.get_xlim()
    stick, contact = (
        float(MICROMETRE.of(width[-1]))
        for width in (profiles.stick_half_width, profiles.contact_half_width)
    )
    first, last = (left, max(left, stick)) if profiles.is_even else (-stick, stick)
    inside = profiles.x[profiles.zones[-1] == ContactState.STICK]
    if not profiles.is_even and inside.size:
        first, last = MICROMETRE.of(inside[[0, -1]]).tolist()
    zones = [(first, last, "stick", INK), (last, contact, "slip", MUTED)]
    if not profiles.is_even:
        zones.append((-contact, first, "slip", MUTED))
    across = axes.get_xaxis_transform()
    for start, end, name, color in zones:
        if end > start:
            (bar,) = axes.plot([start, end], [1.02, 1.02], color=color, lw=1.6, transform=across)
            bar.set(solid_capstyle="butt", label="_zone", clip_on=False)
            middle = 0.5 * (start + end)
            text = axes.text(middle, 1.035, name, transform=across, color=color, fontsize=6.5)
            text.set(ha="center", va="bottom")


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


def _loops(cases: Mapping[str, xr.Dataset], cycles: Cycles) -> Tiles:
    """Take tangential force against displacement round a cycle."""
    names = [variable.name for variable in LOOP]
    every = partial(representative_cycles, most=8)
    contents = [snapshots(loops, cycles, *names, default=every) for loops in cases.values()]

    def draw(panels: Sequence[Axes], ax: Axes | None) -> None:
        caption(panels[0], "Fretting loops: tangential force against displacement round a cycle.")
        caption(panels[0], "The area of a loop is the energy dissipated in the cycle.")
        colors = cycle_colours(sorted({int(n) for loops in contents for n in loops["cycle"]}))
        force = LOOP[0].in_units(contents[0][names[0]].attrs.get("units", LOOP[0].si_unit))
        unit = readable_unit(
            [float(abs(loops[names[0]]).max()) for loops in contents], force.si_unit
        )
        # Under a stroke the loop of a constant load is the same rectangle in every cycle.
        spread = [
            float((loops[name].max("cycle") - loops[name].min("cycle")).max())
            / float(loops[name].max())
            for loops in contents
            for name in names
        ]
        if all(len(loops["cycle"]) > 1 for loops in contents) and max(spread) < _SAME_LOOP:
            caption(panels[0], "The loops of all cycles shown coincide.")
        for axes, loops in zip(panels, contents, strict=True):
            axes.axhline(0.0, color="0.7", linewidth=0.5, zorder=0)
            axes.axvline(0.0, color="0.7", linewidth=0.5, zorder=0)
            curves = []
            for cycle in loops["cycle"].values:
                y, x = (loops[name].sel(cycle=cycle).values for name in names)
                color = colors[int(cycle)]
                curves += axes.plot(MICROMETRE.of(x), unit.of(y), color=color)
            axes.margins(x=0.03)
            axes.set(xlabel=f"{LOOP[1].label} (µm)", ylabel=f"{force.label} ({unit.name})")
        if len(panels) == 1:
            first, *others = map(cycle_text, colors)
            label_or_key(panels[0], curves, [f"cycle {first}", *others], ax)
        else:
            cycle_key(root_figure(panels[0]), colors)

    return Tiles([*cases], draw, "none", "none")


def compare_loops(cases: Mapping[str, xr.Dataset], *, columns: Columns = 2) -> Figure:
    """Draw `fretting_loops` of several cases, by the titles of their panels."""
    return draw_cases(cases, _loops, columns=columns)


def fretting_loops(
    loops: xr.Dataset, cycles: Sequence[int] | None = None, *, ax: Axes | None = None
) -> Figure:
    """Draw tangential force against displacement round a cycle, one loop for each snapshot.

    `fretwear.open_loops` returns `loops`; `cycles` are all of them by default, or eight of many.
    """
    return draw_case(loops, _loops, cycles, 1, ax)


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


def _bearing(
    cases: Mapping[str, xr.Dataset], cycles: Cycles, *, cases_by_id: Mapping[str, Case]
) -> Tiles:
    """Take bearing-area curves; `cases_by_id` name the files of measured surfaces."""
    contents = [
        bearing_heights(case, cycles, cases_by_id.get(case.attrs.get("case_id", "")))
        for case in cases.values()
    ]

    def draw(panels: Sequence[Axes], ax: Axes | None) -> None:
        caption(panels[0], "Bearing area before and after wear.")
        caption(
            panels[0],
            "Share of the contact that lies above each height. A height is the roughness "
            "less wear and plastic depth; 0 is the mean before wear.",
        )
        unit = readable_unit(np.concatenate([h for of in contents for h in of.values()]), "m")
        for panel, heights in zip(panels, contents, strict=True):
            colors = cycle_colours(list(heights))
            for cycle, height in heights.items():
                share = 100.0 * (np.arange(height.size) + 0.5) / height.size
                panel.plot(share, unit.of(height), color=colors[cycle], label=cycle_text(cycle))
            panel.set(xlim=(0.0, 100.0), xlabel="Bearing area (% of the contact)")
            panel.set_ylabel(f"Height ({unit.name})")
        ends = [sorted({[*heights][end] for heights in contents}) for end in (0, -1)]
        lines = panels[-1].get_lines()
        labels = [f"cycle {span(cycles, cycle_text)}" for cycles in ends][: len(lines)]
        if len(panels) == 1:
            labels = [f"cycle {cycle_text(cycle)}" for cycle in contents[0]]
            label_or_key(panels[0], lines, labels, ax)
        else:
            outside_key(root_figure(panels[0]), lines, labels)

    return Tiles([*cases], draw)


def bearing_area(
    dataset: xr.Dataset, cycles: Cycles = None, *, columns: Columns = 1, ax: Axes | None = None
) -> Figure:
    """Draw the bearing-area curves (Abbott and Firestone) of a rough surface as it wears.

    The height of the roughness less wear and plastic depth is drawn over the share of the contact
    that lies above it; `cycles` are by default the first and the last snapshot. Raises a ValueError
    if the case is smooth, or the file of its surface is missing.
    """
    return draw_case(dataset, partial(_bearing, cases_by_id={}), cycles, columns, ax)


def compare_bearing_areas(
    cases: Mapping[str, xr.Dataset],
    cases_by_id: Mapping[str, Case] | None = None,
    *,
    columns: Columns = 2,
) -> Figure:
    """Draw bearing-area curves of several cases, by title, on one scale of heights.

    `cases_by_id` are the cases of the study, which name the files of measured surfaces.
    """
    return draw_cases(cases, partial(_bearing, cases_by_id=cases_by_id or {}), columns=columns)
