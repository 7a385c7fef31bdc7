"""Draw profiles into axes, name their zones, and add the key to their cycles."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fretwear.figures.direct_labels import Curve
from fretwear.figures.half_profile import HalfProfiles
from fretwear.figures.keys import Place, outside_key
from fretwear.figures.profile_frames import Frame, frame_of
from fretwear.figures.profile_kinds import ProfileKind
from fretwear.figures.style import INK, MUTED, STICK_SHADE, sequential_colours
from fretwear.figures.wording import MICROMETRE, cycle_number

_RAW_WIDTH, _RAW_ALPHA = 0.5, 0.6
_TOP = 0.985


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
            axes.plot(
                x, unit.of(values), color=color, lw=_RAW_WIDTH, alpha=_RAW_ALPHA, label="_raw"
            )
            shown = kind.envelope(profiles.x, values, profiles.wavelength)
        axes.plot(x, unit.of(shown), color=color, label=cycle_number(cycle))
        curves.append(Curve(x, unit.of(shown), cycle_number(cycle), color))
        if kind.is_traction and np.nanmax(shown) > frame.top:
            _mark_peak_above(axes, float(x[np.nanargmax(shown)]), color)
    axes.set_xlim(*MICROMETRE.of([frame.left, frame.right]))
    top = float(unit.of(frame.top))
    axes.set_ylim((top, 0.0) if kind.downward else (0.0, top))
    axes.set_xlabel("x (µm)")
    axes.set_ylabel(f"{kind.label} ({unit.name})")
    return curves


def _mark_peak_above(axes: Axes, position: float, color: str) -> None:
    """Say with a triangle that a curve goes on above the axes."""
    axes.plot(
        [position],
        [_TOP],
        transform=axes.get_xaxis_transform(),
        marker="^",
        markersize=3.5,
        color=color,
        label="_above",
    )


def name_zones(axes: Axes, profiles: HalfProfiles) -> None:
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


def cycle_key(
    figure: Figure, colors: Mapping[int, str], place: Place = "outside upper left"
) -> None:
    """Add the key of colours that tell cycles, above the axes of a figure or elsewhere."""
    lines = [Line2D([], [], color=color) for color in colors.values()]
    labels = [cycle_number(cycle) for cycle in colors]
    title = Line2D([], [], color="none")
    outside_key(figure, [title, *lines], ["cycle", *labels], place, handlelength=1.4)
