"""Two cases laid over each other, and by which factor their results differ."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from fretwear.data.dataset import (
    Compared,
    compared_cycles,
    compared_results,
    different_parameters,
)
from fretwear.figures.cycle_axis import set_cycle_axis
from fretwear.figures.datasets import check_cases, missing_variable
from fretwear.figures.half_profile import HalfProfiles, half_profiles
from fretwear.figures.keys import outside_key
from fretwear.figures.profile_frames import Frame, frame_of
from fretwear.figures.profile_kinds import PRESSURE, WEAR, WEAR_RATE, ProfileKind
from fretwear.figures.style import CATEGORICAL, LINE_STYLES, MUTED, JournalFigure, styled
from fretwear.figures.value_axis import is_wide, set_linear_axis, set_logarithmic_axis, unit_of_axis
from fretwear.figures.wording import MICROMETRE, cycle_number, number, symbol_text

_HEIGHT = 118.0
_FIELDS = ("pressure", "wear_depth", "wear_rate")
_SHORT = {
    "contact_half_width_x": "contact half-width",
    "stick_half_width_x": "stick half-width",
    "central_pressure": "pressure in the middle",
    "peak_pressure": "highest pressure",
    "dissipated_energy": "energy per cycle",
    "wear_volume": "wear volume",
    "plastic_volume": "plastic volume",
    "maximum_wear_depth": "deepest wear",
}
# These follow from others, or say little without them.
_FOLLOWING = {
    "hertz_radius",
    "hertz_pressure",
    "tangential_load",
    "cell_x",
    "cell_y",
    "roughness_slope_x",
    "roughness_slope_y",
}
_MOST_TOLD = 4
_LEAST_SPREAD = 1.25
_MARGIN = 1.25
_ROOM_ABOVE = 1.05


@dataclass(frozen=True)
class _Side:
    """One of the two cases, with what it is drawn in."""

    title: str
    case: xr.Dataset
    history: xr.Dataset
    cycle: int
    color: str
    style: Any


@styled
def compare_cases(
    cases: Mapping[str, xr.Dataset], histories: Mapping[str, xr.Dataset] | None = None
) -> Figure:
    """Lay two cases over each other: profiles, widths and volume over the cycles, ratios.

    Parameters
    ----------
    cases : mapping of str to xarray.Dataset
        Two cases, by what the key calls them.
    histories : mapping of str to xarray.Dataset, optional
        Their dense histories, by the same names; without them the snapshots are joined.

    Returns
    -------
    matplotlib.figure.Figure
        Six panels over two journal columns. Profiles and ratios are those of the last snapshot
        that both cases have (`fretwear.data.dataset.compared_cycles`).

    Raises
    ------
    TypeError
        When `cases` is no mapping of titles to datasets.
    ValueError
        When there are not two of them, or one has no fields.
    """
    sides = _sides(cases, histories or {})
    figure = JournalFigure(2, _HEIGHT)
    grid = figure.subplots(2, 3)
    for axes, kind in zip(grid[0], (PRESSURE, WEAR, WEAR_RATE), strict=True):
        _draw_profiles(axes, sides, kind)
    _draw_widths(grid[1, 0], sides)
    _draw_volumes(grid[1, 1], sides)
    first, second = sides
    _draw_ratios(grid[1, 2], compared_results(first.case, second.case), sides)
    lines = [Line2D([], [], color=side.color, linestyle=side.style) for side in sides]
    outside_key(figure, lines, _described(sides))
    cycles = " and ".join(dict.fromkeys(cycle_number(side.cycle) for side in sides))
    title = f"Profiles and ratios at cycle {cycles}"
    figure.suptitle(title, fontsize=7.5, x=0.99, ha="right")
    return figure


def _sides(
    cases: Mapping[str, xr.Dataset], histories: Mapping[str, xr.Dataset]
) -> tuple[_Side, _Side]:
    check_cases(cases)
    if len(cases) != 2:
        raise ValueError(
            f"Two cases are compared, not {len(cases)}; compare_profiles and compare_wear_maps "
            "draw more in panels."
        )
    for case in cases.values():
        for name in _FIELDS:
            if name not in case:
                raise missing_variable(case, name)
    first, second = cases
    cycles = compared_cycles(cases[first], cases[second])
    return (
        _Side(
            first,
            cases[first],
            histories.get(first, cases[first]),
            cycles[0],
            CATEGORICAL[0],
            LINE_STYLES[0],
        ),
        _Side(
            second,
            cases[second],
            histories.get(second, cases[second]),
            cycles[1],
            CATEGORICAL[1],
            LINE_STYLES[1],
        ),
    )


def _described(sides: tuple[_Side, _Side]) -> list[str]:
    """Return the titles with the parameters in which the cases differ."""
    first, second = sides
    names = different_parameters(first.case, second.case)
    told = [name for name in names if name not in _FOLLOWING][:_MOST_TOLD]
    words = []
    for side in sides:
        values = [
            symbol_text(name, side.case[name].values[()])
            for name in told
            if name in side.case.coords
        ]
        described = ", ".join(values)
        says_more = described not in ("", side.title)
        words.append(f"{side.title}: {described}" if says_more else side.title)
    return words


def _draw_profiles(axes: Axes, sides: tuple[_Side, _Side], kind: ProfileKind) -> None:
    profiles = [half_profiles(side.case, kind.variable, side.cycle) for side in sides]
    frame = _frame(kind, sides, profiles)
    for side, profile in zip(sides, profiles, strict=True):
        x, values = MICROMETRE.of(profile.x), profile.values[0]
        if profile.is_wavy:
            axes.plot(x, frame.unit.of(values), color=side.color, lw=0.5, alpha=0.6, label="_raw")
            values = kind.envelope(profile.x, values, profile.wavelength)
        axes.plot(
            x, frame.unit.of(values), color=side.color, linestyle=side.style, label=side.title
        )
    top = float(frame.unit.of(frame.top))
    axes.set_xlim(*MICROMETRE.of([frame.left, frame.right]))
    axes.set_ylim((top, 0.0) if kind.downward else (0.0, top))
    axes.set_xlabel("x (µm)")
    axes.set_ylabel(f"{kind.label} ({frame.unit.name})")


def _frame(
    kind: ProfileKind, sides: tuple[_Side, _Side], profiles: Sequence[HalfProfiles]
) -> Frame:
    if not kind.is_traction:
        return frame_of(kind, profiles)
    # By the first peak it is known how much of a later, singular one is to be seen.
    from_first = [
        half_profiles(side.case, kind.variable, sorted({int(side.case["cycle"][0]), side.cycle}))
        for side in sides
    ]
    highest = max(float(np.nanmax(profile.values)) for profile in profiles)
    frame = frame_of(kind, from_first)
    return replace(frame, top=min(frame.top, _ROOM_ABOVE * highest))


def _draw_widths(axes: Axes, sides: tuple[_Side, _Side]) -> None:
    highest, cycles = 0.0, []
    for side in sides:
        cycles.append(side.history["cycle"].values)
        for zone, width in (("contact", 1.1), ("stick", 0.6)):
            values = MICROMETRE.of(side.history[f"{zone}_half_width_x"].values)
            axes.plot(
                cycles[-1],
                values,
                color=side.color,
                linestyle=side.style,
                lw=width,
                label=f"{side.title}, {zone}",
            )
            highest = max(highest, float(np.nanmax(values)))
    axes.set_ylim(0.0, 1.1 * highest)
    axes.set_ylabel("Half-width along x (µm)")
    axes.set_title("thick: contact, thin: stick")
    set_cycle_axis(axes, np.concatenate(cycles))


def _draw_volumes(axes: Axes, sides: tuple[_Side, _Side]) -> None:
    cycles = [side.history["cycle"].values for side in sides]
    volumes = [side.history["wear_volume"].values for side in sides]
    everything = np.concatenate(volumes)
    logarithmic = is_wide(everything)
    unit = unit_of_axis(everything, "m3", logarithmic)
    for side, at, volume in zip(sides, cycles, volumes, strict=True):
        axes.plot(at, unit.of(volume), color=side.color, linestyle=side.style, label=side.title)
    along = np.concatenate(cycles)
    set_cycle_axis(axes, along[everything > 0.0] if logarithmic else along)
    if logarithmic:
        set_logarithmic_axis(axes, unit.of(everything[along >= 1.0]))
    else:
        set_linear_axis(axes, unit.of(everything), from_zero=True)
    axes.set_ylabel(f"Wear volume ({unit.name})")


def _draw_ratios(axes: Axes, results: list[Compared], sides: tuple[_Side, _Side]) -> None:
    """Draw the ratios as points about 1, each with its number."""
    shown = [result for result in results if result.ratio > 0.0 and np.isfinite(result.ratio)]
    ratios = np.array([result.ratio for result in shown])
    rows = np.arange(len(shown))[::-1]
    axes.axvline(1.0, color=MUTED, lw=0.6)
    axes.hlines(rows, np.minimum(ratios, 1.0), np.maximum(ratios, 1.0), color="#bbbbbb", lw=1.0)
    axes.plot(ratios, rows, "o", color=sides[1].color, markersize=3.5, label="ratio")
    low = min(float(ratios.min(initial=1.0)), 1.0 / _LEAST_SPREAD)
    high = max(float(ratios.max(initial=1.0)), _LEAST_SPREAD)
    axes.set_xscale("log")
    axes.set_xlim(low / _MARGIN, high * _MARGIN)
    axes.set_ylim(-0.6, len(shown) - 0.4)
    axes.set_yticks(rows, [_SHORT[result.variable.name] for result in shown])
    for row, ratio in zip(rows, ratios, strict=True):
        axes.annotate(
            f"×{number(float(f'{ratio:.3g}'))}",
            (1.03, row),
            xycoords=axes.get_yaxis_transform(),
            annotation_clip=False,
            ha="left",
            va="center",
            fontsize=6.5,
        )
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < 50.0 * low else (1.0,)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.tick_params(axis="y", length=0)
    axes.spines["left"].set_visible(False)
    axes.set_xlabel(f"{sides[1].title} / {sides[0].title}")
