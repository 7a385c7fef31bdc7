"""Maps over the contact."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from contourpy import contour_generator
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize, PowerNorm
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from numpy.typing import ArrayLike, NDArray

from fretwear.arrays import Array
from fretwear.data.dataset import mirrored
from fretwear.figures.axes import make_panels, outside_key
from fretwear.figures.datasets import check_cases, snapshots
from fretwear.figures.style import (
    CATEGORICAL,
    COLUMN_WIDTH,
    MUTED,
    Columns,
    depth_colormap,
    one_panel,
    styled,
)
from fretwear.units import MICROMETRE, Unit, cycle_text, readable_unit
from fretwear.vocabulary import RESULTS, ContactState

_BEYOND_CONTACT = 1.06
_SHALLOW = 0.01
_UNEQUAL = 4.0
_SQUARE_ROOT = 0.5
_MOST_CELLS = 1000
_CORNERS_OF_A_CIRCLE = 181
_EDGES = {"edge of contact": MUTED, "edge of stick zone": CATEGORICAL[0]}


class WearMap(NamedTuple):
    """The scar on the whole contact at a cycle, in m."""

    x: Array  # nx cell centres from −L to L
    y: Array
    depth: Array  # shape (nx, ny)
    contact_edge: Array  # closed outlines, shape (k, 2), NaN between several
    stick_edge: Array
    cycle: int

    @property
    def reach(self) -> float:
        """Half-length in m of a square that shows contact and scar."""
        worn = self.depth > _SHALLOW * self.depth.max()
        scar = [np.abs(self.x[worn.any(axis=1)]), np.abs(self.y[worn.any(axis=0)])]
        edges = np.concatenate([*scar, np.abs(self.contact_edge).ravel()])
        return float(np.nanmax(edges, initial=0.0)) * _BEYOND_CONTACT or float(self.x[-1])


@styled
def wear_map(
    dataset: xr.Dataset, cycle: int | None = None, *, columns: Columns = 1, ax: Axes | None = None
) -> Figure:
    """Draw the wear depth over the whole contact with the edges of contact and stick zone.

    The depth is shown after `cycle`, by default the last snapshot, over x and y in µm. Edges of a
    smooth, even contact are ellipses through its half-widths; other edges are contours around the
    cells of a zone, one for each spot of contact.
    """
    scar = take_wear_map(dataset, cycle)
    figure, panel = one_panel(columns, 80.0 if columns == 1 else 144.0, ax)
    keys = _draw_scars(figure, [panel], [scar])
    panel.set_title(f"cycle {cycle_text(scar.cycle)}")
    if ax is None:
        outside_key(figure, keys, list(_EDGES))
    else:
        panel.legend(keys, list(_EDGES), loc="upper right")
    return figure


@styled
def compare_wear_maps(
    cases: Mapping[str, xr.Dataset], cycle: int | None = None, *, columns: Columns = 2
) -> Figure:
    """Draw `wear_map` for several cases, by the titles of their panels, with one scale of depth.

    If one scar is more than four times as deep as another, colours vary as the square root of the
    depth, so that both are visible.
    """
    check_cases(cases)
    scars = [take_wear_map(case, cycle) for case in cases.values()]
    across = min(len(scars), columns)
    row = (COLUMN_WIDTH[columns] - 34.0) / across + 6.0
    figure, panels = make_panels(columns, list(cases), across, (20.0, row))
    keys = _draw_scars(figure, panels, scars)
    # All panels share the frame of the largest scar.
    limit = MICROMETRE.of(max(scar.reach for scar in scars))
    panels[0].set(xlim=(-limit, limit), ylim=(-limit, limit))
    outside_key(figure, keys, list(_EDGES))
    return figure


def _draw_scars(figure: Figure, panels: Sequence[Axes], scars: Sequence[WearMap]) -> list[Line2D]:
    """Draw scars with a common depth scale; return lines for a key to the edges."""
    depths = np.array([scar.depth.max() for scar in scars])
    unit = readable_unit(depths, "m")
    for axes, scar in zip(panels, scars, strict=True):
        image = draw_wear_map(axes, scar, unit, depth_scale(unit.of(depths)))
    add_scale(figure, panels, image, f"{RESULTS['wear_depth'].label} ({unit.name})")
    return [Line2D([], [], lw=1.2, color=color) for color in _EDGES.values()]


def take_wear_map(dataset: xr.Dataset, cycle: int | None) -> WearMap:
    """Take the scar of one case, mirrored to the whole contact."""
    state = snapshots(dataset, cycle, "wear_depth", "contact_state").isel(cycle=-1)
    whole = mirrored(state[["wear_depth", "contact_state"]]).transpose("x", "y")
    x, y, depth = (whole[name].values.astype(np.float64) for name in ("x", "y", "wear_depth"))
    zone = whole["contact_state"].values
    is_smooth = float(state.coords.get("roughness_amplitude", np.inf)) == 0.0
    if is_smooth and np.array_equal(zone, zone[::-1]):
        # Half-widths are interpolated inside the cells.
        angle = np.linspace(0.0, 2.0 * np.pi, _CORNERS_OF_A_CIRCLE)
        circle = np.column_stack([np.cos(angle), np.sin(angle)])
        widths = ([float(state[f"{z}_half_width_{n}"]) for n in "xy"] for z in ("contact", "stick"))
        contact, stick = (circle * axes if min(axes) > 0.0 else circle[:0] for axes in widths)
    else:
        contact = _outline(x, y, zone != ContactState.OPEN)
        stick = _outline(x, y, zone == ContactState.STICK)
    return WearMap(x, y, depth, contact, stick, int(state["cycle"]))


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
    options: dict[str, Any] = {"norm": scale, "cmap": depth_colormap(), "interpolation": kind}
    image = draw_map(axes, scar.x, scar.y, values, scar.reach, **options)
    for outline, color in zip((scar.contact_edge, scar.stick_edge), _EDGES.values(), strict=True):
        width = 1.0 if len(outline) == _CORNERS_OF_A_CIRCLE else 0.5
        axes.plot(*MICROMETRE.of(outline).T, color=color, linewidth=width)
    axes.set_xlabel("x (µm), direction of slip")
    return image


def draw_map(
    axes: Axes, x: Array, y: Array, values: NDArray[Any], reach: float, **options: Any
) -> AxesImage:
    """Draw values of shape (nx, ny) over a square of half-length `reach`, to scale; all in m."""
    x, y, limit = MICROMETRE.of(x), MICROMETRE.of(y), MICROMETRE.of(reach)
    half_x, half_y = 0.5 * (x[1] - x[0]), 0.5 * (y[1] - y[0])
    extent = (x[0] - half_x, x[-1] + half_x, y[0] - half_y, y[-1] + half_y)
    image = axes.imshow(values.T, origin="lower", extent=extent, aspect="equal", **options)
    axes.set(xlim=(-limit, limit), ylim=(-limit, limit), xlabel="x (µm)", ylabel="y (µm)")
    return image


def _outline(x: Array, y: Array, inside: NDArray[np.bool_]) -> Array:
    """Return the contours around the cells of a zone, separated by NaN."""
    lines = contour_generator(x, y, inside.T.astype(np.float64)).lines(0.5)
    gap = np.full((1, 2), np.nan)
    return np.concatenate([np.empty((0, 2)), *(part for line in lines for part in (line, gap))])


def add_scale(
    figure: Figure, axes: Sequence[Axes], image: ScalarMappable, label: str, **options: Any
) -> None:
    """Add a colour bar beside axes; `options` go to `colorbar`."""
    options = {"aspect": 30, "fraction": 0.05, "pad": 0.02} | options
    bar = figure.colorbar(image, ax=axes, label=label, **options)
    bar.outline.set_visible(False)
