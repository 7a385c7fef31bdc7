"""Maps over the contact."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr
from contourpy import contour_generator
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colorbar import Colorbar
from matplotlib.colors import Colormap, Normalize, PowerNorm
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from numpy.typing import ArrayLike, NDArray

from fretwear.arrays import Array
from fretwear.data.dataset import mirrored
from fretwear.figures.axes import outside_key
from fretwear.figures.compare import Tiles, draw_case, draw_cases
from fretwear.figures.datasets import Cycles, is_smooth, snapshots
from fretwear.figures.style import (
    CATEGORICAL,
    INK,
    MUTED,
    Columns,
    caption,
    depth_colormap,
    root_figure,
)
from fretwear.units import MICROMETRE, Unit, cycle_text, readable_unit
from fretwear.vocabulary import RESULTS, ContactState

_BEYOND_CONTACT = 1.06
_SHALLOW = 0.01
_UNEQUAL = 4.0
_SQUARE_ROOT = 0.5
_MOST_CELLS = 1000
_CORNERS_OF_A_CIRCLE = 181
# Arrows of slip along the diameter of a contact.
_ARROWS = 11
_EDGES = {"edge of contact": MUTED, "edge of stick zone": CATEGORICAL[0]}


class WearMap(NamedTuple):
    """The scar on the whole contact at a cycle, in m."""

    x: Array  # nx cell centres from −L to L
    y: Array
    depth: Array  # shape (nx, ny)
    contact_edge: Array  # closed outlines, shape (k, 2), NaN between several
    stick_edge: Array
    cycle: int
    #: Arrows of unit length along the slip at +Q, (x, y, along x, along y), shape (4, k); none
    #: where friction acts along x alone.
    ways: Array

    def has(self, edge: str) -> bool:
        """Whether it has the edge of contact, or of the stick zone."""
        return bool(self.stick_edge.size if "stick" in edge else self.contact_edge.size)

    @property
    def reach(self) -> float:
        """Half-length in m of a square that shows contact and scar."""
        worn = self.depth > _SHALLOW * self.depth.max()
        scar = [np.abs(self.x[worn.any(axis=1)]), np.abs(self.y[worn.any(axis=0)])]
        edges = np.concatenate([*scar, np.abs(self.contact_edge).ravel()])
        return float(np.nanmax(edges, initial=0.0)) * _BEYOND_CONTACT or float(self.x[-1])


def wear_map(
    dataset: xr.Dataset, cycle: int | None = None, *, columns: Columns = 1, ax: Axes | None = None
) -> Figure:
    """Draw the wear depth over the whole contact with the edges of contact and stick zone.

    The depth is shown after `cycle`, by default the last snapshot, over x and y in µm. Edges of a
    smooth, even contact are ellipses through its half-widths; other edges are contours around the
    cells of a zone, one for each spot of contact.
    """
    return draw_case(dataset, _scars, cycle, columns, ax)


def compare_wear_maps(
    cases: Mapping[str, xr.Dataset], cycle: int | None = None, *, columns: Columns = 2
) -> Figure:
    """Draw `wear_map` for several cases, by the titles of their panels, with one scale of depth.

    If one scar is more than four times as deep as another, colours vary as the square root of the
    depth, so that both are visible.
    """
    return draw_cases(cases, _scars, cycle, columns=columns)


def _scars(cases: Mapping[str, xr.Dataset], cycles: Cycles) -> Tiles:
    """Take scars, which are drawn on one scale of depth."""
    scars = [take_wear_map(case, cycles) for case in cases.values()]

    def draw(panels: Sequence[Axes], ax: Axes | None) -> None:
        figure, depths = root_figure(panels[0]), np.array([scar.depth.max() for scar in scars])
        unit, label = readable_unit(depths, "m"), RESULTS["wear_depth"].label
        scale = depth_scale(unit.of(depths))
        when = "the last cycle" if cycles is None else f"cycle {cycle_text(scars[0].cycle)}"
        caption(figure, f"{label} of both bodies over the contact after {when}.")
        if not all(is_smooth(case) for case in cases.values()):
            caption(figure, "On rough surfaces, outlines surround spots of contact and of stick.")
        for axes, scar in zip(panels, scars, strict=True):
            image = draw_wear_map(axes, scar, unit, scale)
        if any(scar.ways.size for scar in scars):
            caption(figure, "Arrows show the direction of slip at the tangential load +Q.")
        if isinstance(scale, PowerNorm):
            caption(figure, "Colours vary as the square root of the depth.")
        # All panels share the frame of the largest scar.
        limit = MICROMETRE.of(max(scar.reach for scar in scars))
        panels[0].set(xlim=(-limit, limit), ylim=(-limit, limit))
        add_scale(figure, panels, image, f"{label} ({unit.name})")
        edges = {name: color for name, color in _EDGES.items() if any(s.has(name) for s in scars)}
        keys = [Line2D([], [], lw=1.2, color=color) for color in edges.values()]
        if ax is None:
            outside_key(figure, keys, [*edges])
        else:
            ax.legend(keys, [*edges], loc="upper right")

    at = f"cycle {cycle_text(scars[0].cycle)}"
    return Tiles([title or at for title in cases], draw, is_square=True)


def take_wear_map(dataset: xr.Dataset, cycle: Cycles) -> WearMap:
    """Take the scar of one case, mirrored to the whole contact."""
    state = snapshots(dataset, cycle, "wear_depth", "contact_state").isel(cycle=-1)
    whole = mirrored(state[["wear_depth", "contact_state"]]).transpose("x", "y")
    x, y, depth = (whole[name].values.astype(np.float64) for name in ("x", "y", "wear_depth"))
    zone = whole["contact_state"].values
    if is_smooth(dataset) and np.array_equal(zone, zone[::-1]):
        # Half-widths are interpolated inside the cells.
        angle = np.linspace(0.0, 2.0 * np.pi, _CORNERS_OF_A_CIRCLE)
        circle = np.column_stack([np.cos(angle), np.sin(angle)])
        widths = ([float(state[f"{z}_half_width_{n}"]) for n in "xy"] for z in ("contact", "stick"))
        contact, stick = (circle * axes if min(axes) > 0.0 else circle[:0] for axes in widths)
    else:
        contact = _outline(x, y, zone != ContactState.OPEN)
        stick = _outline(x, y, zone == ContactState.STICK)
    ways = slip_ways(mirrored(state)) if "slip_y" in state else np.empty((4, 0))
    return WearMap(x, y, depth, contact, stick, int(state["cycle"]), ways)


def slip_ways(whole: xr.Dataset) -> Array:
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
    # A few cells stay sharp, even in a vector file.
    kind = "none" if max(values.shape) <= _MOST_CELLS else "antialiased"
    image = draw_map(axes, scar.x, scar.y, values, scar.reach, scale, depth_colormap())
    image.set_interpolation(kind)
    for outline, color in zip((scar.contact_edge, scar.stick_edge), _EDGES.values(), strict=True):
        width = 1.0 if len(outline) == _CORNERS_OF_A_CIRCLE else 0.5
        axes.plot(*MICROMETRE.of(outline).T, color=color, linewidth=width)
    (x, y), directions = MICROMETRE.of(scar.ways[:2]), scar.ways[2:]
    if x.size:
        arrows = axes.quiver(
            x, y, *directions, units="inches", scale=10.0, width=0.012, pivot="mid"
        )
        arrows.set(facecolor="white", edgecolor=INK, linewidth=0.4)
    axes.set_xlabel("x (µm), direction of slip" if not x.size else "x (µm), direction of force")
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


def _outline(x: Array, y: Array, inside: NDArray[np.bool_]) -> Array:
    """Return the contours around the cells of a zone, separated by NaN."""
    lines = contour_generator(x, y, inside.T.astype(np.float64)).lines(0.5)
    gap = np.full((1, 2), np.nan)
    return np.concatenate([np.empty((0, 2)), *(part for line in lines for part in (line, gap))])


def add_scale(
    figure: Figure, axes: Sequence[Axes], image: ScalarMappable, label: str, aspect: float = 30.0
) -> Colorbar:
    """Add a colour bar beside axes; `aspect` is its height over its width."""
    bar = figure.colorbar(image, ax=axes, label=label, aspect=aspect, fraction=0.05, pad=0.02)
    bar.outline.set_visible(False)
    return bar
