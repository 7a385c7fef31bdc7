"""Maps over the contact, and the fretting map of a study."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import Normalize, PowerNorm
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.transforms import ScaledTranslation
from numpy.typing import ArrayLike

from fretwear.arrays import Array
from fretwear.data.labels import mirrored
from fretwear.figures.axes import add_key, add_scale, parameter_values
from fretwear.figures.colours import CATEGORICAL
from fretwear.figures.datasets import TitledCases, is_smooth, require_variables, snapshots, titled
from fretwear.figures.profiles import case_panels
from fretwear.figures.style import (
    COLUMN_WIDTH,
    MUTED,
    Columns,
    caption,
    depth_colormap,
    one_panel,
    root_figure,
    styled,
)
from fretwear.results import RESULTS
from fretwear.units import MICROMETRE, Unit, axis_label, cycle_text, readable_unit, with_unit
from fretwear.variable import ContactState

WAYS = ("displacement_amplitude", "displacement_ratio")
"""Varied parameters that a fretting map may have besides the load."""

_BEYOND_CONTACT = 1.06
_LINE, _PADS = 1.5, 16.0  # of an x axis: height of a line over its letters, and pads in points
_SHALLOW = 0.01
_UNEQUAL = 4.0
_EDGES = {"contact": MUTED, "stick": CATEGORICAL[0]}
_EXPOSED, _WORN_THROUGH = CATEGORICAL[2], 0.9999  # of the thickness, which wear may not exceed
_REGIMES = {
    "partial slip": ("o", CATEGORICAL[0]),
    "mixed": ("D", CATEGORICAL[5]),
    "gross slip": ("s", CATEGORICAL[1]),
}
_LARGEST, _SMALLEST = 11.0, 2.5


@dataclass(frozen=True)
class WearMap:
    """The scar on the whole contact at a cycle, in m."""

    x: Array  # nx cell centres from −L to L
    y: Array
    depth: Array  # shape (nx, ny)
    fractions: Mapping[str, Array]  # parts of the cells in contact and sticking, shape (nx, ny)
    thinned: Array | None  # wear depth of a coated flat over the thickness; None: uncoated
    cycle: int
    is_smooth: bool

    @property
    def reach(self) -> float:
        """Half-length in m of a square that shows contact and scar."""
        seen = (self.depth > _SHALLOW * self.depth.max()) | (self.fractions["contact"] > 0.0)
        ends = [np.abs(self.x[seen.any(axis=1)]), np.abs(self.y[seen.any(axis=0)])]
        return float(max(e.max(initial=0.0) for e in ends)) * _BEYOND_CONTACT or float(self.x[-1])


@styled
def wear_map(
    cases: TitledCases, cycle: int | None = None, *, columns: Columns = 2, ax: Axes | None = None
) -> Figure:
    """Draw the wear depth over the whole contact with the edges of contact and stick zone.

    Where a coating is worn through, the edge of the exposed substrate is dashed.

    The depth is shown after `cycle`, by default the last snapshot, over x and y in µm. On rough
    surfaces edges surround each spot of contact. Several cases have one scale of depth: if one scar
    is more than four times as deep as another, colours vary as the square root of the depth, so
    that both are visible.
    """
    cases = titled(cases)
    scars = [take_wear_map(case, cycle) for case in cases.values()]
    height = (COLUMN_WIDTH[columns] - 26.0) / columns if len(cases) > 1 else 48.0
    figure, panels = case_panels(cases, columns, ax, height, "all")
    depths = np.array([scar.depth.max() for scar in scars])
    unit, label = readable_unit(depths, "m"), RESULTS["wear_depth"].label
    scale = depth_scale(unit.of(depths))
    for axes, scar in zip(panels, scars, strict=True):
        image = draw_wear_map(axes, scar, unit, scale)
    # All panels share the frame of the largest scar.
    limit = MICROMETRE.of(max(scar.reach for scar in scars))
    panels[0].set(xlim=(-limit, limit), ylim=(-limit, limit))
    add_scale(figure, panels, image, axis_label(label, unit))
    when = f"cycle {cycle_text(scars[0].cycle)}" if cycle is not None else "the last cycle"
    caption(figure, f"{label} of both bodies after {when}.")
    if isinstance(scale, PowerNorm):
        caption(figure, "Colours vary as the square root of the depth.")
    keys = [Line2D([], [], color=color) for color in _EDGES.values()]
    names = ["edge of contact", "edge of stick zone"]
    if any(scar.thinned is not None for scar in scars):
        keys.append(Line2D([], [], color=_EXPOSED, linestyle="--"))
        names.append("edge of exposed substrate")
    if ax is None:
        add_key(figure, keys, names)
    else:  # below the axes: inside, it would lie on the scar
        letters = float(ax.xaxis.label.get_fontsize())  # points, about as high as the numbers
        inches = (2.0 * _LINE * letters + _PADS) / 72.0
        below = ScaledTranslation(0.0, -inches, root_figure(ax).dpi_scale_trans)
        ax.legend(
            keys, names, loc="upper left", borderaxespad=0.0, ncols=2,
            bbox_to_anchor=(0.0, 0.0), bbox_transform=ax.transAxes + below,
        )  # fmt: skip
    return figure


def take_wear_map(dataset: xr.Dataset, cycle: int | None) -> WearMap:
    """Take the scar of one case, mirrored to the whole contact."""
    state = snapshots(dataset, cycle, "wear_depth", "contact_state").isel(cycle=-1)
    if "y" not in state.dims:
        remedy = 'field_profiles(dataset, "wear_depth") draws the scar'
        raise ValueError(f"a line contact has no map; {remedy}")
    fields = [
        "wear_depth",
        "wear_depth_flat",
        "contact_state",
        "contact_fraction",
        "stick_fraction",
    ]
    whole = mirrored(state[[name for name in fields if name in state]]).transpose("x", "y")
    x, y, depth = (whole[name].values.astype(np.float64) for name in ("x", "y", "wear_depth"))
    zone = whole["contact_state"]
    cells = {"contact": zone != ContactState.OPEN, "stick": zone == ContactState.STICK}
    fractions = {
        name: whole.get(f"{name}_fraction", region).values.astype(np.float64)
        for name, region in cells.items()
    }
    thinned = None
    if "coating_thickness" in dataset.coords:
        worn = whole.get("wear_depth_flat", whole["wear_depth"]).values.astype(np.float64)
        thinned = worn / float(dataset["coating_thickness"])
    return WearMap(x, y, depth, fractions, thinned, int(state["cycle"]), is_smooth(dataset))


def depth_scale(deepest: ArrayLike) -> Normalize:
    """Return colours for scars of these depths, by the square root if the depths differ much."""
    highest = float(np.max(deepest)) or 1.0
    is_unequal = float(np.min(deepest)) < highest / _UNEQUAL
    return PowerNorm(0.5, 0.0, highest) if is_unequal else Normalize(0.0, highest)


def draw_wear_map(axes: Axes, scar: WearMap, unit: Unit, scale: Normalize) -> AxesImage:
    """Draw a scar into axes, to scale, over a square; the `scale` of colours is in `unit`."""
    x, y, limit = MICROMETRE.of(scar.x), MICROMETRE.of(scar.y), MICROMETRE.of(scar.reach)
    half_x, half_y = 0.5 * (x[1] - x[0]), 0.5 * (y[1] - y[0])
    extent = (x[0] - half_x, x[-1] + half_x, y[0] - half_y, y[-1] + half_y)
    image = axes.imshow(
        unit.of(scar.depth).T,
        depth_colormap(),
        scale,
        aspect="equal",
        origin="lower",
        extent=extent,
    )
    for name, color in _EDGES.items():
        part = scar.fractions[name]
        if part.min() < 0.5 < part.max():
            width = 1.0 if scar.is_smooth else 0.5
            axes.contour(x, y, part.T, [0.5], colors=[color], linewidths=width)
    if scar.thinned is not None and scar.thinned.min() < _WORN_THROUGH < scar.thinned.max():
        axes.contour(x, y, scar.thinned.T, [_WORN_THROUGH], colors=[_EXPOSED], linestyles="--")
    axes.set(xlim=(-limit, limit), ylim=(-limit, limit))
    axes.set(xlabel="x (µm), direction of slip", ylabel="y (µm)")
    return image


@styled
def fretting_map(summary: xr.Dataset, *, ax: Axes | None = None) -> Figure:
    """Draw the regime of sliding over load and displacement; dots grow with the wear volume.

    `summary` is a merged study that varies the load and the displacement amplitude or ratio; other
    varied parameters are shown at their first value. Slip that is partial in some snapshots and
    gross in others is mixed. The width of a dot is proportional to the cube root of the wear
    volume.
    """
    require_variables(summary, "status", "regime", "wear_volume")
    names = (next(name for name in WAYS if name in summary["status"].dims), "normal_load")
    rest = {name: 0 for name in summary["status"].dims if name not in names}
    shown = summary.isel(rest).transpose(*names[::-1], ...)
    gross = shown["regime"].mean("cycle", skipna=True).values
    volume = shown["wear_volume"].max("cycle").values
    figure, axes = one_panel(1, 76.0, ax)
    caption(figure, "Regime of slip over load and displacement; dots grow with the wear volume.")
    axes.set(xscale="log", yscale="log")
    places = []
    for name, axis in zip(names, (axes.xaxis, axes.yaxis), strict=True):
        values, label = parameter_values(shown, name)
        axis.set_ticks(values.tolist(), [f"{value:.3g}" for value in values])
        axis.set_ticks([], minor=True)
        axis.set_label_text(label)
        places.append(values)
    x, y = np.meshgrid(*places)
    kinds = np.where(gross == 0.0, "partial slip", np.where(gross == 1.0, "gross slip", "mixed"))
    greatest = float(np.nanmax(volume))
    widths = np.maximum(_LARGEST * np.cbrt(volume / greatest), _SMALLEST)
    for regime, (marker, color) in _REGIMES.items():
        here = (kinds == regime) & np.isfinite(gross)
        if here.any():
            axes.scatter(x[here], y[here], widths[here] ** 2, color, marker=marker, linewidths=0.0)
            axes.plot([], [], marker, color=color, label=regime)
    axes.margins(0.15)
    worn = RESULTS["wear_volume"].in_dataset(shown)
    unit = readable_unit(volume, worn.si_unit)
    largest = with_unit(f"{unit.of(greatest):.3g}", unit)
    title = f"width of dots: cube root of {worn.words}, at most {largest}"
    key = axes.legend(loc="lower left", bbox_to_anchor=(-0.02, 1.0), ncols=3, title=title)
    key.set_alignment("left")
    return figure
