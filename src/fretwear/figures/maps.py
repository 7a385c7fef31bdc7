"""Maps over the contact."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, Normalize, PowerNorm
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from numpy.typing import ArrayLike, NDArray

from fretwear.arrays import Array
from fretwear.data.dataset import mirrored
from fretwear.figures.axes import add_scale, outside_key
from fretwear.figures.datasets import check_cases, check_dataset, is_smooth, snapshots
from fretwear.figures.profiles import case_panels
from fretwear.figures.style import (
    CATEGORICAL,
    COLUMN_WIDTH,
    INK,
    MUTED,
    Columns,
    caption,
    depth_colormap,
    styled,
)
from fretwear.results import RESULTS, ContactState
from fretwear.units import MICROMETRE, Unit, cycle_text, readable_unit

_BEYOND_CONTACT = 1.06
_SHALLOW = 0.01
_UNEQUAL = 4.0
_SQUARE_ROOT = 0.5
# Arrows of slip along the diameter of a contact.
_ARROWS = 11
_EDGES = {"contact": MUTED, "stick": CATEGORICAL[0]}


@dataclass(frozen=True)
class WearMap:
    """The scar on the whole contact at a cycle, in m."""

    x: Array  # nx cell centres from −L to L
    y: Array
    depth: Array  # shape (nx, ny)
    fractions: Mapping[str, Array]  # parts of the cells in contact and sticking, shape (nx, ny)
    cycle: int
    is_smooth: bool
    # Arrows of unit length along the slip at +Q, (x, y, along x, along y), shape (4, k); none
    # where friction acts along x alone.
    arrows: Array

    @property
    def reach(self) -> float:
        """Half-length in m of a square that shows contact and scar."""
        seen = (self.depth > _SHALLOW * self.depth.max()) | (self.fractions["contact"] > 0.0)
        ends = [np.abs(self.x[seen.any(axis=1)]), np.abs(self.y[seen.any(axis=0)])]
        return float(max(e.max(initial=0.0) for e in ends)) * _BEYOND_CONTACT or float(self.x[-1])


def wear_map(
    dataset: xr.Dataset, cycle: int | None = None, *, columns: Columns = 1, ax: Axes | None = None
) -> Figure:
    """Draw the wear depth over the whole contact with the edges of contact and stick zone.

    The depth is shown after `cycle`, by default the last snapshot, over x and y in µm. On rough
    surfaces edges surround each spot of contact.
    """
    check_dataset(dataset)
    return _draw_maps({"": dataset}, cycle, columns, ax)


def compare_wear_maps(
    cases: Mapping[str, xr.Dataset], cycle: int | None = None, *, columns: Columns = 2
) -> Figure:
    """Draw `wear_map` for several cases, by the titles of their panels, with one scale of depth.

    If one scar is more than four times as deep as another, colours vary as the square root of the
    depth, so that both are visible.
    """
    return _draw_maps(cases, cycle, columns, None)


@styled
def _draw_maps(
    cases: Mapping[str, xr.Dataset], cycle: int | None, columns: Columns, ax: Axes | None
) -> Figure:
    check_cases(cases)
    scars = [take_wear_map(case, cycle) for case in cases.values()]
    across = columns if len(cases) > 1 else 1.25 * columns
    figure, panels = case_panels(cases, columns, ax, (COLUMN_WIDTH[columns] - 30.0) / across, "all")
    depths = np.array([scar.depth.max() for scar in scars])
    unit, label = readable_unit(depths, "m"), RESULTS["wear_depth"].label
    scale = depth_scale(unit.of(depths))
    for axes, scar in zip(panels, scars, strict=True):
        image = draw_wear_map(axes, scar, unit, scale)
    # All panels share the frame of the largest scar.
    limit = MICROMETRE.of(max(scar.reach for scar in scars))
    panels[0].set(xlim=(-limit, limit), ylim=(-limit, limit))
    add_scale(figure, panels, image, f"{label} ({unit.name})")
    when = f"cycle {cycle_text(scars[0].cycle)}" if cycle is not None else "the last cycle"
    caption(figure, f"{label} of both bodies after {when}.")
    if isinstance(scale, PowerNorm):
        caption(figure, "Colours vary as the square root of the depth.")
    if any(scar.arrows.size for scar in scars):
        caption(figure, "Arrows: slip at the tangential load +Q.")
    keys = [Line2D([], [], color=color) for color in _EDGES.values()]
    names = ["edge of contact", "edge of stick zone"]
    if ax is None:
        outside_key(figure, keys, names)
    else:
        ax.legend(keys, names, loc="upper right")
    return figure


def take_wear_map(dataset: xr.Dataset, cycle: int | None) -> WearMap:
    """Take the scar of one case, mirrored to the whole contact."""
    state = snapshots(dataset, cycle, "wear_depth", "contact_state").isel(cycle=-1)
    fields = ["wear_depth", "contact_state", "contact_fraction", "stick_fraction"]
    whole = mirrored(state[[name for name in fields if name in state]]).transpose("x", "y")
    x, y, depth = (whole[name].values.astype(np.float64) for name in ("x", "y", "wear_depth"))
    zone = whole["contact_state"]
    cells = {"contact": zone != ContactState.OPEN, "stick": zone == ContactState.STICK}
    fractions = {
        name: whole.get(f"{name}_fraction", inside).values.astype(np.float64)
        for name, inside in cells.items()
    }
    arrows = slip_arrows(mirrored(state)) if "slip_y" in state else np.empty((4, 0))
    return WearMap(x, y, depth, fractions, int(state["cycle"]), is_smooth(dataset), arrows)


def slip_arrows(whole: xr.Dataset) -> Array:
    """Where the contact of a snapshot slips, at every few cells, x and y in m and the direction."""
    names = ("slip_x", "slip_y", "contact_state")
    along, across, zone = (whole[name].transpose("x", "y").values for name in names)
    x, y = (whole[name].values.astype(np.float64) for name in "xy")
    touching = np.abs(x[(zone != ContactState.OPEN).any(axis=1)])
    every = max(1, round(2.0 * touching.max(initial=0.0) / (x[1] - x[0]) / _ARROWS))
    places = np.ix_(*(np.arange(every // 2, axis.size, every) for axis in (x, y)))
    length = np.hypot(along, across)[places]
    slips = (zone[places] == ContactState.SLIP) & (length > 0.0)
    at = [axis.ravel()[place.ravel()] for axis, place in zip((x, y), places, strict=True)]
    grid = np.meshgrid(*at, indexing="ij")
    directions = (field[places][slips] / length[slips] for field in (along, across))
    return np.stack([*(axis[slips] for axis in grid), *directions])


def depth_scale(deepest: ArrayLike) -> Normalize:
    """Return colours for scars of these depths, by the square root if the depths differ much."""
    highest = float(np.max(deepest)) or 1.0
    is_unequal = float(np.min(deepest)) < highest / _UNEQUAL
    return PowerNorm(_SQUARE_ROOT, 0.0, highest) if is_unequal else Normalize(0.0, highest)


def draw_wear_map(axes: Axes, scar: WearMap, unit: Unit, scale: Normalize) -> AxesImage:
    """Draw a scar into axes; `scale` is in `unit`."""
    values = unit.of(scar.depth)
    image = draw_map(axes, scar.x, scar.y, values, scar.reach, scale, depth_colormap())
    x, y = MICROMETRE.of(scar.x), MICROMETRE.of(scar.y)
    for name, color in _EDGES.items():
        part = scar.fractions[name]
        if part.min() < 0.5 < part.max():
            width = 1.0 if scar.is_smooth else 0.5
            axes.contour(x, y, part.T, [0.5], colors=[color], linewidths=width)
    if scar.arrows.size:
        (x, y), directions = MICROMETRE.of(scar.arrows[:2]), scar.arrows[2:]
        arrows = axes.quiver(
            x, y, *directions, units="inches", scale=10.0, width=0.012, pivot="mid"
        )
        arrows.set(facecolor="white", edgecolor=INK, linewidth=0.4)
    axes.set_xlabel(
        "x (µm), direction of slip" if not scar.arrows.size else "x (µm), direction of force"
    )
    return image


def draw_map(
    axes: Axes,
    x: Array,
    y: Array,
    values: NDArray[np.generic],
    reach: float,
    scale: Normalize,
    colors: Colormap,
) -> AxesImage:
    """Draw values of shape (nx, ny) over a square of half-length `reach`, to scale; all in m."""
    x, y, limit = MICROMETRE.of(x), MICROMETRE.of(y), MICROMETRE.of(reach)
    half_x, half_y = 0.5 * (x[1] - x[0]), 0.5 * (y[1] - y[0])
    extent = (x[0] - half_x, x[-1] + half_x, y[0] - half_y, y[-1] + half_y)
    image = axes.imshow(values.T, colors, scale, aspect="equal", origin="lower", extent=extent)
    axes.set(xlim=(-limit, limit), ylim=(-limit, limit), xlabel="x (µm)", ylabel="y (µm)")
    return image
