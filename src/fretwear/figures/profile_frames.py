"""Which part of the plane profiles are shown in: limits and unit of the axes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fretwear.figures.half_profile import HalfProfiles
from fretwear.figures.profile_kinds import ProfileKind
from fretwear.figures.wording import Unit, readable_unit

_BEYOND_CONTACT = 1.12
_BEFORE_EDGE = 0.75
_ABOVE = 1.05
_INSIDE_CONTACT = 0.8
_ROOM_OVER_WAVES = 1.6
_SHARE_OF_FIRST_GAP = 0.3
_ROOM_OVER_FIRST = 3.0


@dataclass(frozen=True)
class Frame:
    """Limits of the axes of one or more panels of profiles.

    Parameters
    ----------
    left, right : float
        Limits of x in m.
    top : float
        Largest value shown, in the SI unit of the quantity.
    unit : Unit
        Unit of the y axis.
    """

    left: float
    right: float
    top: float
    unit: Unit


def frame_of(kind: ProfileKind, panels: Sequence[HalfProfiles]) -> Frame:
    """Return the frame that shows all of some panels.

    What vanishes inside a smooth contact is shown around its edge; its values then go as far as
    those of the last cycle, and curves of earlier ones leave at the top. The tractions of elastic
    bodies are shown up to three times their first peak: the later one at the edge of the stick
    zone grows with a finer grid, without end, and would hide the rest.

    Parameters
    ----------
    kind : ProfileKind
        What is drawn.
    panels : sequence of HalfProfiles
        The profiles of each panel.
    """
    right = _BEYOND_CONTACT * max(float(p.contact_half_width.max()) for p in panels)
    if kind.at_edge:
        # Outside the window the gap is not stored.
        right = min(right, max(float(p.x[-1]) for p in panels))
    left = 0.0
    if kind.at_edge and not any(panel.is_wavy for panel in panels):
        left = _BEFORE_EDGE * min(float(p.contact_half_width.min()) for p in panels)
    top = max(_top(kind, panel, right) for panel in panels)
    return Frame(left, right, _ABOVE * top or 1.0, kind.unit or readable_unit(top, "m"))


def _top(kind: ProfileKind, profiles: HalfProfiles, right: float) -> float:
    if kind.at_edge:
        return _highest_at_edge(profiles, right)
    shown = profiles.values[:, profiles.x <= right]
    highest = float(np.nanmax(shown))
    if kind.is_traction and not profiles.is_capped:
        return min(highest, _ROOM_OVER_FIRST * float(np.nanmax(shown[0])))
    return highest


def _highest_at_edge(profiles: HalfProfiles, right: float) -> float:
    last = float(np.nanmax(profiles.values[-1, profiles.x <= right]))
    inside = [
        values[profiles.x < _INSIDE_CONTACT * half_width].max(initial=0.0)
        for values, half_width in zip(profiles.values, profiles.contact_half_width, strict=True)
    ]
    first = float(np.nanmax(profiles.values[0, profiles.x <= right]))
    return max(last, _SHARE_OF_FIRST_GAP * first, _ROOM_OVER_WAVES * float(max(inside)))
