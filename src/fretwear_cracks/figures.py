"""Cracks: the parameter through the thickness, results over the cycles, and who wins."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure

from fretwear.data.effects import levels_of
from fretwear.data.groups import open_group
from fretwear.figures.axes import add_scale, make_panels
from fretwear.figures.colours import CATEGORICAL
from fretwear.figures.history import representative_cases, scalar_history
from fretwear.figures.study import StudyFigure
from fretwear.figures.style import MUTED, Columns, depth_colormap, one_panel, styled
from fretwear.results import PointStatus
from fretwear.study.parameters import parameter, value_text
from fretwear.units import MEGAPASCAL, MICROMETRE, NO_UNIT, axis_label, cycle_text
from fretwear_cracks.variables import CRACKS, FATIGUE, FATIGUE_OUTCOMES

_SHOWN = {variable.name: variable for variable in FATIGUE}
_HISTORIES = ("largest_smith_watson_topper", "largest_damage")
_OUTCOME = "fatigue_outcome"
_COLORS = (MUTED, CATEGORICAL[0], CATEGORICAL[1])


@styled
def crack_map(cracks: xr.Dataset, *, columns: Columns = 2) -> Figure:
    """Draw the Smith–Watson–Topper parameter through the thickness, first and last snapshot.

    `cracks` is the dataset of `fretwear.fatigue`. A cross marks the largest value, a line the plane
    on which it acts.
    """
    swt = CRACKS[0]
    snapshots = [cracks.isel(cycle=place) for place in sorted({0, cracks.sizes["cycle"] - 1})]
    titles = [f"cycle {cycle_text(float(snapshot['cycle']))}" for snapshot in snapshots]
    figure, panels = make_panels(columns, titles, len(titles), (20.0, 55.0))
    largest = MEGAPASCAL.of(float(cracks[swt.name].max()))
    x, z = (MICROMETRE.of(cracks[name].values) for name in ("x", "z"))
    for axes, now in zip(panels, snapshots, strict=True):
        image = axes.pcolormesh(
            x,
            z,
            MEGAPASCAL.of(now[swt.name].values.T),
            vmin=0.0,
            vmax=largest,
            cmap=depth_colormap(),
            shading="gouraud",
            rasterized=True,
        )
        place = [MICROMETRE.of(float(now[name])) for name in ("crack_x", "crack_depth")]
        angle, length = np.radians(float(now["crack_angle"])), 0.15 * z[-1]
        axes.plot(
            [place[0], place[0] + length * np.cos(angle)],
            [place[1], place[1] + length * np.sin(angle)],
            color=CATEGORICAL[1],
        )
        axes.plot(*place, marker="+", color=CATEGORICAL[1], linestyle="none")
        axes.set(xlabel="x (µm)", ylabel="Depth (µm)", ylim=(z[-1], z[0]))
    add_scale(figure, panels, image, f"{swt.label} (MPa)")
    return figure


@styled
def fatigue_map(summary: xr.Dataset, *, ax: Axes | None = None) -> Figure:
    """Draw whether wear or a crack wins at the last cycle, over one or two varied parameters.

    `summary` is a merged study with ``output: {stress: …}``. The two parameters with most values
    are shown, others at their first value; text is the cycle of the first crack.
    """
    sizes = {str(name): size for name, size in summary["status"].sizes.items() if size > 1}
    shown = sorted(sizes, key=lambda name: -sizes[name])[:2]
    rest = {name: 0 for name in summary["status"].dims if name not in shown}
    # A study in which no crack appears has no such result.
    first = summary.get("crack_cycle", np.nan * summary[_OUTCOME])
    last = summary[["status", _OUTCOME]].assign(first=first)
    last = last.isel(rest).isel(cycle=-1).transpose(*shown)
    outcome = np.where(last["status"] == PointStatus.DONE, last[_OUTCOME], np.nan)
    shape = (*outcome.shape, 1, 1)[:2]
    outcome, crack = outcome.reshape(shape), last["first"].values.reshape(shape)
    figure, axes = one_panel(1, 66.0, ax)
    scale = BoundaryNorm([-0.5, 0.5, 1.5, 2.5], 3)
    axes.imshow(outcome.T, cmap=ListedColormap(_COLORS), norm=scale, origin="lower", aspect="auto")
    for axis, name in zip((axes.xaxis, axes.yaxis), [*shown, ""], strict=False):
        if not name:
            axis.set_ticks([])
            continue
        levels = levels_of(summary, name)
        axis.set_ticks(range(len(levels)), [value_text(name, level) for level in levels])
        axis.set_label_text(axis_label(parameter(name).words, NO_UNIT))
    for (row, column), first in np.ndenumerate(crack):
        if np.isfinite(first) and outcome[row, column] == FATIGUE_OUTCOMES.index("crack wins"):
            axes.text(
                row,
                column,
                cycle_text(float(f"{first:.2g}")),
                ha="center",
                va="center",
                fontsize="small",
            )
    handles = [
        axes.scatter([], [], marker="s", color=color, label=word)
        for color, word in zip(_COLORS, FATIGUE_OUTCOMES, strict=True)
    ]
    axes.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return figure


def crack_figures(summary: xr.Dataset, cases: Path) -> Iterator[StudyFigure]:
    """Yield the figures of a merged study on cracks, with maps of a few representative cases."""
    if not (_HISTORIES[0] in summary and summary[_HISTORIES[0]].notnull().any()):
        return
    for name in _HISTORIES:
        if name in summary and bool((summary[name] > 0.0).any()):
            figure = scalar_history(summary, _SHOWN[name], summary)
            words = f"{_SHOWN[name].label} against the number of cycles."
            yield StudyFigure(name, words, figure)
    varied = [size for size in summary["status"].sizes.values() if size > 1]
    if _OUTCOME in summary and varied and "point" not in summary.dims:
        caption = (
            "Whether wear or a crack wins by the last cycle; numbers are the cycle of the first "
            "crack."
        )
        yield StudyFigure("fatigue_map", caption, fatigue_map(summary))
    for number, (title, case_id) in enumerate(representative_cases(summary).ids.items(), 1):
        file = cases.parent / "fatigue" / f"{case_id}.nc"
        if file.exists():
            with open_group(file) as cracks:
                of_case = f", {title}" if title else ""
                caption = (
                    f"{CRACKS[0].label} through the thickness at y = 0{of_case}, before and after "
                    "wear; the cross marks where a crack is expected, the line its plane."
                )
                yield StudyFigure(f"crack_map_{number}", caption, crack_map(cracks))
