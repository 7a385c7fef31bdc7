"""Half-widths of contact and stick zone against cycles: whole, and a zoom on the edge."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fretwear.figures.axes import outside_key, set_cycle_axis
from fretwear.figures.style import CATEGORICAL, LINE_STYLES, JournalFigure, styled
from fretwear.units import MICROMETRE

CONTACT, STICK = "contact_half_width_x", "stick_half_width_x"
_HEIGHT = 72.0
_FIRST_CYCLE = 1.0
_MARGIN = 0.03


@dataclass(frozen=True)
class Look:
    """Colour and line style of a case."""

    color: str
    style: Any

    @classmethod
    def of(cls, rough: bool, plastic: bool) -> Look:
        """Colour tells roughness, the line style whether bodies yield."""
        return cls(CATEGORICAL[int(rough)], LINE_STYLES[int(plastic)])


@styled
def half_widths(histories: Mapping[str, xr.Dataset], looks: Mapping[str, Look]) -> Figure:
    """Draw the half-widths of contact and stick zone from the middle outwards.

    Parameters
    ----------
    histories : mapping of str to xarray.Dataset
        Histories of cases by what the key calls them.
    looks : mapping of str to Look
        How each is drawn.
    """
    figure = JournalFigure(2, _HEIGHT)
    axes = figure.subplots()
    for title, history in histories.items():
        for variable, width in ((CONTACT, 1.1), (STICK, 0.7)):
            _draw(axes, history, variable, looks[title], width)
    axes.set_ylim(bottom=0.0)
    axes.margins(x=0.0)
    axes.set_xlabel("Cycle")
    _finish(figure, axes, looks)
    _name_zones(axes, list(histories.values()))
    return figure


@styled
def edge_of_contact(
    histories: Mapping[str, xr.Dataset], looks: Mapping[str, Look], within: Sequence[str]
) -> Figure:
    """Draw the half-width of the contact alone, early cycles spread out.

    Parameters
    ----------
    histories, looks
        As for `half_widths`.
    within : sequence of str
        Cases whose whole range is shown; others may leave at the top.
    """
    figure = JournalFigure(2, _HEIGHT)
    axes = figure.subplots()
    for title, history in histories.items():
        _draw(axes, history, CONTACT, looks[title], 1.1)
    values = np.concatenate([MICROMETRE.of(histories[title][CONTACT].values) for title in within])
    room = _MARGIN * float(np.ptp(values))
    axes.set_ylim(float(values.min()) - room, float(values.max()) + 4.0 * room)
    cycles = np.concatenate([history["cycle"].values for history in histories.values()])
    # Early steps are of fractions of a cycle; nothing is to be seen before the first.
    set_cycle_axis(axes, cycles[(cycles == 0.0) | (cycles >= _FIRST_CYCLE)])
    _finish(figure, axes, looks)
    return figure


def _draw(axes: Axes, history: xr.Dataset, variable: str, look: Look, width: float) -> None:
    axes.plot(
        history["cycle"].values,
        MICROMETRE.of(history[variable].values),
        color=look.color,
        linestyle=look.style,
        lw=width,
    )


def _finish(figure: Figure, axes: Axes, looks: Mapping[str, Look]) -> None:
    axes.grid(axis="y")
    axes.set_ylabel("Half-width along x (µm)")
    handles = [Line2D([], [], color=look.color, linestyle=look.style) for look in looks.values()]
    outside_key(figure, handles, list(looks))


def _name_zones(axes: Axes, histories: list[xr.Dataset]) -> None:
    """Write between the lines what is between them."""
    cycle = float(histories[0]["cycle"].values[-1])
    place = 0.985 * cycle
    stick = max(float(MICROMETRE.of(h[STICK].values[-1])) for h in histories)
    contact = min(float(MICROMETRE.of(h[CONTACT].values[-1])) for h in histories)
    top = axes.get_ylim()[1]
    lowest = min(float(MICROMETRE.of(h[STICK].values[-1])) for h in histories)
    for height, name in ((0.5 * lowest, "stick"), (0.5 * (stick + contact), "slip")):
        axes.text(place, height, name, ha="right", va="center", fontsize=6.5)
    axes.text(0.02 * cycle, 0.98 * top, "open", va="top", fontsize=6.5)
