"""An animation of one case over its cycles, written as GIF or MP4."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import chain
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from PIL import Image

from fretwear.data.dataset import mirrored
from fretwear.data.safe import atomic_path
from fretwear.figures.axes import label_curves, outside_key
from fretwear.figures.cases import headline
from fretwear.figures.datasets import half_profiles, line_near_the_middle, snapshots
from fretwear.figures.history import draw_zone_widths
from fretwear.figures.maps import draw_map
from fretwear.figures.profiles import frame_of
from fretwear.figures.style import INK, MUTED, JournalFigure, style_context
from fretwear.units import MICROMETRE, cycle_text
from fretwear.vocabulary import ContactState

FORMATS = (".gif", ".mp4")
SCREEN_DPI = 120
FEW_SNAPSHOTS = 12
ZONE_COLORS = {
    ContactState.OPEN: "#f4f4f4",
    ContactState.SLIP: "#8cc5e3",
    ContactState.STICK: "#084a8c",
}
"""Light to dark: they can be told apart in grey too."""

_ZONES: dict[str, Any] = {
    "cmap": ListedColormap([ZONE_COLORS[zone] for zone in ContactState]),
    "vmin": min(ContactState),
    "vmax": max(ContactState),
}
_FIELDS = ("pressure", "wear_depth", "contact_state")
_HEIGHT = 104.0
_BEYOND_CONTACT = 1.1
_STRIP = 0.04
_FIRST_WIDTH = 0.7
_MARK = 4.5
_SECONDS_PER_DECADE = 1.2
_SHORTEST, _LONGEST, _LAST = 0.25, 1.2, 2.5
_COLORS = 128
_FRAMES_PER_SECOND = 20


class FfmpegMissingError(RuntimeError):
    """An MP4 file was asked for where the program ffmpeg is not installed."""


class CaseAnimation:
    """The snapshots of a case as pictures, one after the other.

    Made by `fretwear.figures.animation`. Nothing is made up between the snapshots that the case
    has: each picture is one of them and tells its cycle.

    Attributes
    ----------
    figure : matplotlib.figure.Figure
        The figure, which shows one snapshot at a time; at first the last one.
    cycles : tuple of int
        The cycles shown.
    seconds : tuple of float
        How long each is shown: by its distance from the next one on a logarithmic axis of cycles,
        the last one longest.
    """

    def __init__(self, shown: xr.Dataset, history: xr.Dataset) -> None:
        self.cycles = tuple(int(cycle) for cycle in shown["cycle"].values)
        self.seconds = durations(self.cycles)
        self._shown, self._whole = shown, mirrored(shown[list(_FIELDS)])
        self._reach = _BEYOND_CONTACT * float(shown["contact_half_width_x"].max())
        self._updates: list[Callable[[int], None]] = []
        with style_context():
            self.figure: Figure = JournalFigure(2, _HEIGHT)
            (pressure, zones), (wear, widths) = self.figure.subplots(
                2, 2, width_ratios=(1.55, 1.0), height_ratios=(1.25, 1.0)
            )
            title = self.figure.suptitle("", fontsize=9, x=0.006, ha="left")
            words = [f"Cycle {cycle_text(n)}    {headline(shown)}" for n in self.cycles]
            self._updates.append(lambda index: title.set_text(words[index]))
            self._add_profile(pressure, "pressure")
            self._add_profile(wear, "wear_depth")
            pressure.tick_params(labelbottom=False)
            pressure.set_xlabel("")
            self._add_map(zones)
            curves = draw_zone_widths(widths, history)
            marks = [widths.plot([], [], "o", ms=_MARK, c=c.get_color())[0] for c in curves]
            values = [MICROMETRE.of(shown[f"{c.get_label()}_half_width_x"].values) for c in curves]

            def mark_widths(index: int) -> None:
                for mark, each in zip(marks, values, strict=True):
                    mark.set_data([self.cycles[index]], [each[index]])

            self._updates.append(mark_widths)
            states = list(reversed(ContactState))
            first = Line2D([], [], color=MUTED, lw=_FIRST_WIDTH)
            handles = [*(Patch(color=ZONE_COLORS[state]) for state in states), first]
            labels = [state.name.lower() for state in states]
            labels.append(f"pressure at cycle {cycle_text(self.cycles[0])}")
            outside_key(self.figure, handles, labels, "outside lower left", handlelength=1.2)
            self.show(self.cycles[-1])
            # No mark comes to lie on a label: each curve has them everywhere while it is placed.
            for curve in curves:
                curve.set(marker="o", markersize=_MARK)
            label_curves(widths, curves, [str(curve.get_label()) for curve in curves])
            for curve in curves:
                curve.set_marker("None")

    def _add_profile(self, axes: Axes, name: str) -> None:
        """Draw a profile along the whole x axis over a strip that tells its zones."""
        half = half_profiles(self._shown, name, self.cycles)
        frame = replace(frame_of([half]), left=-self._reach, right=self._reach)
        x = MICROMETRE.of(self._whole["x"].values)
        curves, zones = (
            line_near_the_middle(self._whole[each]).transpose("cycle", "x").values
            for each in (name, "contact_state")
        )
        values = frame.unit.of(curves.astype(np.float64))
        frame.apply(axes, half.field)
        axes.set_xlabel("x (µm), direction of slip")
        top = float(frame.unit.of(frame.top))
        is_downward = axes.yaxis_inverted()
        if not is_downward:
            axes.plot(x, values[0], color=MUTED, lw=_FIRST_WIDTH, label="_first")
        fill = axes.fill_between(x, 0.0, 0.0, color="#d9d9d9", lw=0)
        (line,) = axes.plot(x, values[0], color=INK, label=half.field.label)
        edge, limits = x[-1] + 0.5 * (x[1] - x[0]), (-_STRIP * top, top)
        extent = (-edge, edge, limits[0], 0.0)
        strip = axes.imshow(zones[:1], extent=extent, aspect="auto", **_ZONES)
        axes.set_xlim(MICROMETRE.of(-self._reach), MICROMETRE.of(self._reach))
        axes.set_ylim(limits[::-1] if is_downward else limits)

        def update(index: int) -> None:
            line.set_ydata(values[index])
            fill.set_data(x, 0.0, values[index])
            strip.set_data(zones[index : index + 1])

        self._updates.append(update)

    def _add_map(self, axes: Axes) -> None:
        if "y" not in self._whole.dims:
            axes.remove()
            return
        zones = self._whole["contact_state"].transpose("cycle", "x", "y").values
        x, y = (self._whole[name].values.astype(np.float64) for name in ("x", "y"))
        image = draw_map(axes, x, y, zones[0], self._reach, **_ZONES)
        axes.set_facecolor(ZONE_COLORS[ContactState.OPEN])
        self._updates.append(lambda index: image.set_data(zones[index].T))

    def show(self, cycle: int) -> Figure:
        """Show the snapshot at a cycle, and return the figure; a ValueError if there is none."""
        if cycle not in self.cycles:
            raise ValueError(f"cycle = {cycle}: this animation shows {list(self.cycles)}.")
        for update in self._updates:
            update(self.cycles.index(cycle))
        return self.figure

    def save(
        self,
        path: str | PathLike[str],
        *,
        dots_per_inch: float = SCREEN_DPI,
        progress: Callable[[int, int], None] = lambda _done, _total: None,
    ) -> Path:
        """Write the animation as GIF or, where the program ffmpeg is installed, as MP4.

        Parameters
        ----------
        path : str or path-like
            File to write, which appears only when it is whole; its suffix determines the format.
        dots_per_inch : float
            The figure is 190 mm wide: 120 make it 897 pixels.
        progress : callable
            Called with the number of each picture, from 1, and that of all.

        Raises
        ------
        ValueError
            When the name ends in neither .gif nor .mp4.
        FfmpegMissingError
            For MP4 where there is no ffmpeg; a `RuntimeError`.
        DataFileError
            When the file cannot be written.
        """
        path = Path(path)
        check_format(path)
        with style_context(), atomic_path(path) as temporary:
            pictures = self._pictures(dots_per_inch, progress)
            if path.suffix.lower() == ".gif":
                first, *others = (n.quantize(_COLORS, dither=Image.Dither.NONE) for n in pictures)
                times = {"duration": [round(1000 * each) for each in self.seconds], "loop": 0}
                first.save(temporary, "GIF", save_all=True, append_images=others, **times)
            else:
                _write_mp4(temporary, pictures, self.seconds)
        return path

    def _pictures(
        self, dots_per_inch: float, progress: Callable[[int, int], None]
    ) -> Iterator[Image.Image]:
        before = self.figure.dpi
        self.figure.set_dpi(dots_per_inch)
        canvas = FigureCanvasAgg(self.figure)
        for number, cycle in enumerate(self.cycles, 1):
            self.show(cycle)
            canvas.draw()  # type: ignore[no-untyped-call]
            progress(number, len(self.cycles))
            pixels = np.asarray(canvas.buffer_rgba())  # type: ignore[no-untyped-call]
            yield Image.fromarray(pixels).convert("RGB")
        self.figure.set_dpi(before)


def animation(
    dataset: xr.Dataset, history: xr.Dataset | None = None, cycles: Sequence[int] | None = None
) -> CaseAnimation:
    """Animate a case: pressure, wear depth and contact zones, snapshot after snapshot.

    `cycles` left out are all snapshots; more of them make a smoother animation
    (`well_spaced_cycles`). The half-widths over the cycles are those of the dense `history` or,
    without it, of the snapshots. Save it by ``fretwear.figures.animation(case).save("wear.gif")``.
    """
    shown = snapshots(dataset, cycles, *_FIELDS, default=list)
    return CaseAnimation(shown, dataset if history is None else history)


def durations(cycles: Sequence[int]) -> tuple[float, ...]:
    """Return the seconds that each snapshot is shown."""
    position = np.log10(1.0 + np.asarray(cycles, dtype=np.float64))
    until_next = np.clip(_SECONDS_PER_DECADE * np.diff(position), _SHORTEST, _LONGEST)
    return (*(float(seconds) for seconds in until_next), _LAST)


def well_spaced_cycles(last: int, number: int = 30) -> list[int]:
    """Return about `number` cycles for a smooth animation, evenly spread on a logarithmic axis.

    They are rounded to two digits, for ``output: {cycles: [...]}`` of a study file.
    """
    spread = np.geomspace(1.0, max(last, 2), number)
    rounded = {int(float(f"{cycle:.2g}")) for cycle in spread}
    return sorted({0, last, *(cycle for cycle in rounded if cycle < last)})


def check_format(path: Path) -> None:
    """Raise a `ValueError` for a name that ends in neither .gif nor .mp4.

    It is an `FfmpegMissingError` for MP4 where there is no ffmpeg.
    """
    ending = path.suffix.lower()
    if ending not in FORMATS:
        raise ValueError(
            f"{path.name}: {ending or 'no ending'} is not a format for animations; "
            "end the name in .gif or .mp4."
        )
    if ending == ".mp4" and shutil.which("ffmpeg") is None:
        raise FfmpegMissingError(
            f"{path.name}: .mp4 needs the program ffmpeg, which is not on the PATH. Install it, "
            f"or write {path.with_suffix('.gif').name} instead, which needs nothing else."
        )


def _write_mp4(path: Path, pictures: Iterator[Image.Image], seconds: Sequence[float]) -> None:
    """Have ffmpeg show each picture in as many frames as its time takes."""
    first = next(pictures)
    # Many players know H.264 of even sizes with halved colours only.
    width, height = (side - side % 2 for side in first.size)
    source = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}"]
    coding = ["-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", "20", "-f", "mp4"]
    rate = ["-r", str(_FRAMES_PER_SECOND), "-i", "-"]
    command = ["ffmpeg", "-y", "-v", "error", *source, *rate, *coding, str(path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE) as ffmpeg:
        for picture, time in zip(chain([first], pictures), seconds, strict=True):
            frames = max(1, round(_FRAMES_PER_SECOND * time))
            if ffmpeg.stdin is not None:
                ffmpeg.stdin.write(picture.crop((0, 0, width, height)).tobytes() * frames)
    if ffmpeg.returncode:
        raise OSError(f"ffmpeg ended with status {ffmpeg.returncode}")
