"""One case as it moves: what is drawn once, and what each snapshot changes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import FillBetweenPolyCollection
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.text import Text
from numpy.typing import NDArray

from fretwear.data.dataset import mirrored
from fretwear.figures.direct_labels import label_curves
from fretwear.figures.half_profile import half_profiles
from fretwear.figures.keys import outside_key
from fretwear.figures.overview import headline
from fretwear.figures.profile_frames import frame_of
from fretwear.figures.profile_kinds import PRESSURE, WEAR, ProfileKind
from fretwear.figures.style import INK, MUTED, JournalFigure
from fretwear.figures.wording import MICROMETRE, Unit, cycle_number
from fretwear.figures.zone_widths import draw_zone_widths, zone_curves
from fretwear.vocabulary import ContactState

Array = NDArray[np.float64]

_HEIGHT = 104.0
_BEYOND_CONTACT = 1.1
_STRIP = 0.04
_FIRST_WIDTH = 0.7
_OPEN, _SLIP, _STICK = "#f4f4f4", "#8cc5e3", "#084a8c"
ZONE_COLORS = {
    ContactState.OPEN: _OPEN,
    ContactState.SLIP: _SLIP,
    ContactState.STICK: _STICK,
}
"""Light to dark: they can be told apart in grey too."""


@dataclass(frozen=True)
class Snapshots:
    """What an animation shows, on the whole contact.

    Parameters
    ----------
    cycles : array of shape (n,)
        The cycles.
    x, y : array of shape (nx,), (ny,)
        Cell centres in m, from −L to L.
    pressure, depth : array of shape (n, nx)
        Pressure in Pa and wear depth in m on the line nearest y = 0.
    zones : array of shape (n, nx, ny)
        What each cell does, as `ContactState`.
    """

    cycles: Array
    x: Array
    y: Array
    pressure: Array
    depth: Array
    zones: NDArray[np.int8]


def take_snapshots(dataset: xr.Dataset, cycles: list[int]) -> Snapshots:
    """Take some snapshots of a case, mirrored to the whole contact when a quarter is stored."""
    whole = mirrored(dataset.sel(cycle=cycles)[["pressure", "wear_depth", "contact_state"]])
    line = whole.isel(y=int(np.abs(whole["y"].values).argmin())).transpose("cycle", "x")
    return Snapshots(
        whole["cycle"].values.astype(np.float64),
        whole["x"].values.astype(np.float64),
        whole["y"].values.astype(np.float64),
        line["pressure"].values.astype(np.float64),
        line["wear_depth"].values.astype(np.float64),
        whole["contact_state"].transpose("cycle", "x", "y").values.astype(np.int8),
    )


class MovingFigure:
    """A figure of one case whose curves and map follow the cycle; its axes stay.

    Parameters
    ----------
    dataset : xarray.Dataset
        One case.
    history : xarray.Dataset
        What the half-widths are drawn from: the dense history, or the dataset itself.
    snapshots : Snapshots
        What is shown.
    """

    def __init__(self, dataset: xr.Dataset, history: xr.Dataset, snapshots: Snapshots) -> None:
        self.figure: Figure = JournalFigure(2, _HEIGHT)
        self._snapshots = snapshots
        self._profiles = [
            _Profile(kind, _limits(dataset, kind, snapshots), values)
            for kind, values in ((PRESSURE, snapshots.pressure), (WEAR, snapshots.depth))
        ]
        grid = self.figure.subplots(2, 2, width_ratios=(1.55, 1.0), height_ratios=(1.25, 1.0))
        for axes, profile in zip(grid[:, 0], self._profiles, strict=True):
            profile.prepare(axes, snapshots)
        grid[0, 0].tick_params(labelbottom=False)
        grid[0, 0].set_xlabel("")
        self._map = _prepare_map(grid[0, 1], snapshots, self._profiles[0].reach)
        self._widths = zone_curves(dataset.sel(cycle=snapshots.cycles))
        draw_zone_widths(grid[1, 1], history)
        self._marks = [
            grid[1, 1].plot([], [], "o", markersize=4.5, color=curve.color, label="_now")[0]
            for curve in self._widths
        ]
        self._title: Text = self.figure.suptitle("", fontsize=9, x=0.006, ha="left")
        self._headline = headline(dataset)
        _add_key(self.figure, snapshots)
        self.show(0)
        marked = [replace(curve, is_marked=True) for curve in zone_curves(history)]
        label_curves(grid[1, 1], marked)

    def show(self, index: int) -> None:
        """Show the snapshot of a number."""
        cycle = float(self._snapshots.cycles[index])
        self._title.set_text(f"Cycle {cycle_number(cycle)}    {self._headline}")
        for profile in self._profiles:
            profile.show(index, self._snapshots)
        self._map.set_data(self._snapshots.zones[index].T)
        for mark, curve in zip(self._marks, self._widths, strict=True):
            mark.set_data([curve.x[index]], [curve.y[index]])


@dataclass(frozen=True)
class _Limits:
    reach: float
    top: float
    unit: Unit


class _Profile:
    """A profile along the whole x axis over a strip that tells its zones."""

    def __init__(self, kind: ProfileKind, limits: _Limits, values: Array) -> None:
        self.reach = limits.reach
        self._kind, self._limits, self._values = kind, limits, values
        self._line: Line2D
        self._fill: FillBetweenPolyCollection
        self._strip: AxesImage

    def prepare(self, axes: Axes, snapshots: Snapshots) -> None:
        """Draw what stays: axes, the first snapshot in grey, and empty artists."""
        unit, x = self._limits.unit, MICROMETRE.of(snapshots.x)
        top = float(unit.of(self._limits.top))
        bottom = -_STRIP * top
        if not self._kind.downward:
            axes.plot(x, unit.of(self._values[0]), color=MUTED, lw=_FIRST_WIDTH, label="_first")
        self._fill = axes.fill_between(x, 0.0, 0.0, color="#d9d9d9", lw=0)
        (self._line,) = axes.plot(x, np.zeros_like(x), color=INK, label=self._kind.label)
        reach = float(MICROMETRE.of(self.reach))
        half = 0.5 * float(x[1] - x[0])
        self._strip = axes.imshow(
            np.zeros((1, x.size)),
            extent=(x[0] - half, x[-1] + half, bottom, 0.0),
            origin="lower",
            aspect="auto",
            cmap=_zone_map(),
            vmin=min(ContactState),
            vmax=max(ContactState),
        )
        axes.set_xlim(-reach, reach)
        axes.set_ylim((top, bottom) if self._kind.downward else (bottom, top))
        axes.set_xlabel("x (µm), direction of slip")
        axes.set_ylabel(f"{self._kind.label} ({unit.name})")

    def show(self, index: int, snapshots: Snapshots) -> None:
        """Show the snapshot of a number."""
        x, values = MICROMETRE.of(snapshots.x), self._limits.unit.of(self._values[index])
        self._line.set_ydata(values)
        self._fill.set_data(x, 0.0, values)
        row = int(np.abs(snapshots.y).argmin())
        self._strip.set_data(snapshots.zones[index, :, row][None, :])


def _limits(dataset: xr.Dataset, kind: ProfileKind, snapshots: Snapshots) -> _Limits:
    """Return limits that hold every snapshot."""
    profiles = half_profiles(dataset, kind.variable, [int(cycle) for cycle in snapshots.cycles])
    frame = frame_of(kind, [profiles])
    reach = _BEYOND_CONTACT * float(profiles.contact_half_width.max())
    return _Limits(reach, frame.top, frame.unit)


def _prepare_map(axes: Axes, snapshots: Snapshots, reach: float) -> AxesImage:
    x, y = MICROMETRE.of(snapshots.x), MICROMETRE.of(snapshots.y)
    half_x, half_y = 0.5 * (x[1] - x[0]), 0.5 * (y[1] - y[0])
    image = axes.imshow(
        snapshots.zones[0].T,
        origin="lower",
        extent=(x[0] - half_x, x[-1] + half_x, y[0] - half_y, y[-1] + half_y),
        cmap=_zone_map(),
        vmin=min(ContactState),
        vmax=max(ContactState),
        aspect="equal",
    )
    limit = float(MICROMETRE.of(reach))
    axes.set_facecolor(_OPEN)
    axes.set_xlim(-limit, limit)
    axes.set_ylim(-limit, limit)
    axes.set_xlabel("x (µm)")
    axes.set_ylabel("y (µm)")
    return image


def _add_key(figure: Figure, snapshots: Snapshots) -> None:
    zones = list(reversed(ContactState))
    first = Line2D([], [], color=MUTED, lw=_FIRST_WIDTH)
    outside_key(
        figure,
        [*(Patch(color=ZONE_COLORS[zone]) for zone in zones), first],
        [
            *(zone.name.lower() for zone in zones),
            f"pressure at cycle {cycle_number(snapshots.cycles[0])}",
        ],
        "outside lower left",
        handlelength=1.2,
    )


def _zone_map() -> ListedColormap:
    return ListedColormap([ZONE_COLORS[zone] for zone in ContactState])
