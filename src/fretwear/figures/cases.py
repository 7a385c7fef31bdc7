"""One case on a page or moving over its cycles, and two cases superimposed."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain
from os import PathLike
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from PIL import Image

from fretwear.arrays import Array
from fretwear.data.atomic import atomic_path
from fretwear.data.dataset import (
    compared_cycles,
    compared_results,
    different_parameters,
    mirrored,
)
from fretwear.figures.axes import ValueAxis, label_curves, outside_key, set_cycle_axis
from fretwear.figures.datasets import (
    Cycles,
    Profiles,
    check_cases,
    profiles_of,
    snapshots,
    variable_of,
)
from fretwear.figures.maps import add_scale, depth_scale, draw_map, draw_wear_map, take_wear_map
from fretwear.figures.profiles import (
    ZONE_COLORS,
    ZONES,
    Frame,
    cycle_colours,
    cycle_key,
    draw_filled,
    draw_profiles,
    frame_of,
    mark_peak,
    zone_key,
)
from fretwear.figures.style import (
    CATEGORICAL,
    INK,
    LINE_STYLES,
    MUTED,
    JournalFigure,
    LineLook,
    style_context,
    styled,
)
from fretwear.study.parameters import coordinate, replaced_by, symbol_text, value_text
from fretwear.units import MICROMETRE, cycle_text, in_unit, number_text, readable_unit
from fretwear.vocabulary import RESULTS, ContactState

HALF_WIDTH_LABEL = "Half-width along x (µm)"
FEW_SNAPSHOTS = 12

_PANELS = ("pressure", "shear_traction", "gap", "wear_depth")
_HEADLINE: tuple[str, ...] = ("load", "tangential_ratio", "sliding_amplitude", "friction")
_HEADLINE += ("roughness_amplitude", "plastic_limit")
_COMPARED = ("pressure", "wear_depth", "wear_rate")
# Coordinates derived from others, or hardly meaningful without them.
_DERIVED = {"hertz_radius", "hertz_pressure", "tangential_load", "cell_x", "cell_y"}
_DERIVED |= {"roughness_slope_x", "roughness_slope_y"}
_MOST_TOLD = 4
_LEAST_SPREAD = 1.25
_MARGIN = 1.25
_THIN = 0.7
# Lines along y, and room above the deepest of them.
_DOTS, _ROOM = (0, (1.0, 1.0)), 1.08

_MOVING = ("pressure", "wear_depth", "contact_state")
_BEYOND_CONTACT = 1.1
_MARK = 4.5
_SECONDS_PER_DECADE = 1.2
_SHORTEST, _LONGEST, _LAST = 0.25, 1.2, 2.5
_COLORS = 128
_FRAMES_PER_SECOND = 20
_SCREEN_DPI = 120


@styled
def overview(
    dataset: xr.Dataset, history: xr.Dataset | None = None, cycles: Cycles = None
) -> Figure:
    """Draw pressure, shear, gap and wear along x, a map of the scar, and the zones over the cycles.

    The map shows the last snapshot of the case; a line contact has the slip along x in its place.
    The zones come from the dense `history` of the case or, without it, from the snapshots.
    """
    panels = [profiles_of(dataset, name, cycles) for name in _PANELS]
    colors, is_filled = cycle_colours(panels[0].cycles), panels[0].is_rough
    figure = JournalFigure(2, 126.0)
    grid = figure.subplots(2, 3, width_ratios=(1.0, 1.0, 1.08))

    def draw(axes: Axes, profiles: Profiles) -> None:
        if is_filled:
            draw_filled(axes, profiles)
        else:
            draw_profiles(axes, profiles, colors)

    for axes, profiles in zip(grid[:, :2].flat, panels, strict=True):
        draw(axes, profiles)
    has_both = "slip_y" in dataset
    if has_both and not is_filled:
        worn, axes = panels[-1], grid[1, 1]
        looks = zip(worn.cycles, colors.values(), strict=True)
        draw_across(axes, frame_of([worn]), [(dataset, at, color) for at, color in looks])
    place, zones = grid[:, 2]
    if "y" in dataset.dims:
        scar = take_wear_map(dataset, None)
        unit = readable_unit(scar.depth, "m")
        image = draw_wear_map(place, scar, unit, depth_scale(unit.of(scar.depth.max())))
        label = f"{RESULTS['wear_depth'].label} ({unit.name})"
        place.set_title(f"{label}, cycle {cycle_text(scar.cycle)}")
        add_scale(figure, [place], image, "", aspect=24)
    else:
        draw(place, profiles_of(dataset, "slip", cycles))
    curves = draw_zone_widths(zones, dataset if history is None else history, has_both=has_both)
    zones.set_title("Contact and stick zone" + (", dotted: along y" if has_both else ""))
    figure.suptitle(headline(dataset), fontsize=8, x=0.005, ha="left")
    if is_filled:
        zone_key(figure, panels[:1], "outside lower left")
    else:
        cycle_key(figure, colors, "outside lower left")
    label_curves(zones, curves, [str(curve.get_label()) for curve in curves])
    return figure


def draw_across(axes: Axes, frame: Frame, shown: Sequence[tuple[xr.Dataset, int, str]]) -> None:
    """Add the wear depth along y, next to x = 0, dotted: of cases at cycles, in colours."""
    top = frame.top
    for case, cycle, color in shown:
        depth = mirrored(case[["wear_depth"]].sel(cycle=cycle))["wear_depth"]
        line = depth.isel(x=int(np.abs(depth["x"].values).argmin()))
        y, values = MICROMETRE.of(line["y"].values), frame.unit.of(line.values)
        axes.plot(y, values, lw=_THIN, linestyle=_DOTS, color=color)
        top = max(top, _ROOM * float(line.max()))
    replace(frame, top=top).apply(axes, RESULTS["wear_depth"])
    axes.set_xlabel("x (µm), dotted: y (µm)")


def draw_zone_widths(axes: Axes, history: xr.Dataset, *, has_both: bool = False) -> list[Line2D]:
    """Draw the half-widths of contact and stick zone over the cycles; return their curves.

    They are those along x and, if asked for both, also along y, dotted.
    """
    cycles = np.atleast_1d(history["cycle"].values).astype(np.float64)
    curves, highest = [], 0.0
    for zone, color in (("contact", CATEGORICAL[0]), ("stick", INK)):
        widths = MICROMETRE.of(np.atleast_1d(history[f"{zone}_half_width_x"].values))
        curves += axes.plot(cycles, widths, color=color, label=zone)
        highest = max(highest, float(np.nanmax(widths)))
        if has_both:
            across = MICROMETRE.of(np.atleast_1d(history[f"{zone}_half_width_y"].values))
            axes.plot(cycles, across, color=color, lw=_THIN, linestyle=_DOTS)
    axes.set_ylim(0.0, 1.15 * highest)
    axes.set_ylabel(HALF_WIDTH_LABEL)
    set_cycle_axis(axes, cycles)
    return curves


def headline(case: xr.Dataset, names: Sequence[str] = _HEADLINE) -> str:
    """Return the parameters that identify a case, in symbols; blocks may give several values."""
    blocks = json.loads(case.attrs.get("parameters", "{}")).get("blocks") or [{}]
    replaced = {name for block in blocks for key in block for name in replaced_by(key)}
    texts = []
    stored = {name: case.coords[at] for name in names if (at := coordinate(name)) in case.coords}
    for name in (name for name in stored if name not in replaced):
        unit = stored[name].attrs.get("units", "")
        values = dict.fromkeys(block.get(name, stored[name].item()) for block in blocks)
        first, *others = (in_unit(value, unit) for value in values)
        texts.append(" → ".join([symbol_text(name, first), *(value_text(name, n) for n in others)]))
    return ", ".join(texts)


@styled
def compare_cases(
    cases: Mapping[str, xr.Dataset], histories: Mapping[str, xr.Dataset] | None = None
) -> Figure:
    """Superimpose two cases: profiles, widths and volume over the cycles, ratios.

    The key gives the titles of the cases. Profiles and ratios belong to the last snapshot that both
    have. `histories` are the dense histories by the same titles; without them straight lines join
    the snapshots. Any number of cases but two raises a ValueError.
    """
    check_cases(cases, *_COMPARED)
    if len(cases) != 2:
        raise ValueError(
            f"compare_cases takes two cases, not {len(cases)}; compare_profiles and "
            "compare_wear_maps draw more in panels."
        )
    first, second = cases.values()
    cycles = compared_cycles(first, second)
    styles = [LineLook(color=CATEGORICAL[n], linestyle=LINE_STYLES[n]) for n in range(2)]
    figure = JournalFigure(2, 118.0)
    (*profiles,), (widths, volumes, ratios) = figure.subplots(2, 3)
    for axes, name in zip(profiles, _COMPARED, strict=True):
        # The first peak limits how much of a later, singular one is shown.
        shown = [
            profiles_of(case, name, sorted({int(case["cycle"][0]), cycle})).at(-1)
            for case, cycle in zip(cases.values(), cycles, strict=True)
        ]
        frame = frame_of(shown)
        for title, style, profile in zip(cases, styles, shown, strict=True):
            x, values = MICROMETRE.of(profile.x), frame.unit.of(profile.values[0])
            axes.plot(x, values, lw=_THIN if profile.is_rough else None, label=title, **style)
            mark_peak(axes, profile, frame)
        frame.apply(axes, shown[0].field)
        if name == "wear_depth" and any("slip_y" in case for case in cases.values()):
            looks = zip(cases.values(), cycles, styles, strict=True)
            draw_across(axes, frame, [(case, at, look["color"]) for case, at, look in looks])
    dense = [(histories or {}).get(title, case) for title, case in cases.items()]
    steps, worn = (
        [history[name].values.astype(np.float64) for history in dense]
        for name in ("cycle", "wear_volume")
    )
    every = np.concatenate(steps), np.concatenate(worn)
    axis = ValueAxis(variable_of(first, "wear_volume"), every[1])
    for title, style, history, at, volume in zip(cases, styles, dense, steps, worn, strict=True):
        for zone, width in (("contact", 1.1), ("stick", 0.6)):
            values = MICROMETRE.of(history[f"{zone}_half_width_x"].values)
            widths.plot(at, values, lw=width, label=f"{title}, {zone}", **style)
        volumes.plot(at, axis.unit.of(volume), label=title, **style)
    widths.set_ylim(0.0, 1.1 * widths.dataLim.ymax)
    widths.set(ylabel=HALF_WIDTH_LABEL, title="thick: contact, thin: stick")
    set_cycle_axis(widths, every[0])
    axis.set_cycles(volumes, *every)
    axis.set_limits(volumes, *every)
    volumes.set_ylabel(axis.label)
    _draw_ratios(ratios, first, second)
    ratios.set_xlabel("{1} / {0}".format(*cases))
    names = [name for name in different_parameters(first, second) if name not in _DERIVED]
    texts = {title: headline(case, names[:_MOST_TOLD]) for title, case in cases.items()}
    described = [f"{n}: {text}" if text not in ("", n) else n for n, text in texts.items()]
    outside_key(figure, [Line2D([], [], **style) for style in styles], described)
    compared = " and ".join(dict.fromkeys(map(cycle_text, cycles)))
    figure.suptitle(f"Profiles and ratios at cycle {compared}", fontsize=7.5, x=0.99, ha="right")
    return figure


def _draw_ratios(axes: Axes, first: xr.Dataset, second: xr.Dataset) -> None:
    """Draw the ratios of results as points about 1, each with its number."""
    shown = {
        result.variable.words: result.ratio
        for result in compared_results(first, second)
        if result.ratio > 0.0 and np.isfinite(result.ratio)
    }
    ratios, rows = np.array(list(shown.values())), np.arange(len(shown))[::-1]
    axes.axvline(1.0, color=MUTED, lw=0.6)
    axes.hlines(rows, np.minimum(ratios, 1.0), np.maximum(ratios, 1.0), color="#bbbbbb", lw=1.0)
    axes.plot(ratios, rows, "o", color=CATEGORICAL[1], markersize=3.5, label="ratio")
    low = ratios.min(initial=1.0 / _LEAST_SPREAD)
    high = ratios.max(initial=_LEAST_SPREAD)
    axes.set_xscale("log")
    axes.set(xlim=(low / _MARGIN, high * _MARGIN), ylim=(-0.6, len(shown) - 0.4))
    axes.set_yticks(rows, list(shown))
    for row, ratio in zip(rows, ratios, strict=True):
        text = axes.text(1.03, row, f"×{number_text(ratio, 3)}", fontsize=6.5, va="center")
        text.set_transform(axes.get_yaxis_transform())
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < 50.0 * low else (1.0,)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.tick_params(axis="y", length=0)
    axes.spines["left"].set_visible(False)


class FfmpegMissingError(RuntimeError):
    """An MP4 file needs the program ffmpeg, which is not installed."""


class CaseAnimation:
    """The snapshots of a case as pictures, one after the other.

    `fretwear.figures.animation` returns it. Each picture is a snapshot of the case and shows its
    cycle; nothing is interpolated.

    Attributes
    ----------
    figure : matplotlib.figure.Figure
        The figure, which shows one snapshot at a time; at first the last one.
    cycles : tuple of int
        The cycles shown.
    seconds : tuple of float
        How long each is shown: in proportion to the distance to the next one on a logarithmic axis
        of cycles, within bounds; the last one longest.
    """

    @styled
    def __init__(self, shown: xr.Dataset, history: xr.Dataset) -> None:
        self.cycles = tuple(int(cycle) for cycle in shown["cycle"].values)
        self.seconds = durations(self.cycles)
        self._updates: list[Callable[[int], None]] = []
        whole = mirrored(shown)
        reach = _BEYOND_CONTACT * float(shown["contact_half_width_x"].max())
        self.figure: Figure = JournalFigure(2, 104.0)
        (pressure, zones), (wear, widths) = self.figure.subplots(
            2, 2, width_ratios=(1.55, 1.0), height_ratios=(1.25, 1.0)
        )
        title = self.figure.suptitle("", fontsize=9, x=0.006, ha="left")
        words = [f"Cycle {cycle_text(n)}    {headline(shown)}" for n in self.cycles]
        self._updates.append(lambda index: title.set_text(words[index]))
        for axes, name in ((pressure, "pressure"), (wear, "wear_depth")):
            profiles = profiles_of(whole, name, self.cycles, both_sides=True)
            frame = replace(frame_of([profiles]), left=-reach, right=reach)
            self._updates.append(draw_filled(axes, profiles, frame))
            axes.set_xlabel("x (µm), direction of slip")
        pressure.tick_params(labelbottom=False)
        pressure.set_xlabel("")
        if "y" in whole.dims:
            states = whole["contact_state"].transpose("cycle", "x", "y").values
            x, y = (whole[name].values.astype(np.float64) for name in ("x", "y"))
            scale = Normalize(min(ContactState), max(ContactState))
            image = draw_map(zones, x, y, states[0], reach, scale, ZONES)
            zones.set_facecolor(ZONE_COLORS[ContactState.OPEN])
            self._updates.append(lambda index: image.set_data(states[index].T))
        else:
            zones.remove()
        curves = draw_zone_widths(widths, history)
        for curve in curves:
            values = MICROMETRE.of(shown[f"{curve.get_label()}_half_width_x"].values)
            (mark,) = widths.plot([], [], "o", ms=_MARK, c=curve.get_color())
            self._updates.append(partial(self._mark, mark, values))
        zone_key(self.figure, [profiles], "outside lower left")
        self.show(self.cycles[-1])
        # Marks everywhere on the curves while labels are placed keep later marks off the labels.
        for curve in curves:
            curve.set(marker="o", markersize=_MARK)
        label_curves(widths, curves, [str(curve.get_label()) for curve in curves])
        for curve in curves:
            curve.set_marker("None")

    def _mark(self, mark: Line2D, values: Array, index: int) -> None:
        mark.set_data([self.cycles[index]], [values[index]])

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
        dots_per_inch: float = _SCREEN_DPI,
        progress: Callable[[int, int], None] = lambda _done, _total: None,
    ) -> Path:
        """Write the animation as GIF or, if the program ffmpeg is installed, as MP4.

        The suffix of `path` decides; the file appears only when it is complete. The figure is
        190 mm wide, which 120 `dots_per_inch` make 897 pixels. `progress` is called with the number
        of each picture, from 1, and their total. Raises a `ValueError` for other suffixes, an
        `FfmpegMissingError` for MP4 without ffmpeg, and a `DataFileError` if the file cannot be
        written.
        """
        path = Path(path)
        check_format(path)
        with style_context(), atomic_path(path) as temporary:
            pictures = self._pictures(dots_per_inch, progress)
            if path.suffix.lower() == ".gif":
                first, *others = (n.quantize(_COLORS, dither=Image.Dither.NONE) for n in pictures)
                times = {"duration": [round(1000 * time) for time in self.seconds], "loop": 0}
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

    `cycles` are all snapshots by default; more of them make a smoother animation
    (`well_spaced_cycles`). The half-widths over the cycles come from the dense `history` or,
    without it, from the snapshots. Save it by
    ``fretwear.figures.animation(case).save("wear.gif")``.
    """
    shown = snapshots(dataset, cycles, *_MOVING, default=list)
    return CaseAnimation(shown, dataset if history is None else history)


def durations(cycles: Sequence[int]) -> tuple[float, ...]:
    """Return the seconds for which each snapshot is shown."""
    position = np.log10(1.0 + np.asarray(cycles, dtype=np.float64))
    until_next = np.clip(_SECONDS_PER_DECADE * np.diff(position), _SHORTEST, _LONGEST)
    return (*(float(seconds) for seconds in until_next), _LAST)


def well_spaced_cycles(last: int) -> list[int]:
    """Return about 30 round cycles for a smooth animation, evenly spaced on a logarithmic axis."""
    rounded = {int(float(f"{cycle:.2g}")) for cycle in np.geomspace(1.0, max(last, 2), 30)}
    return sorted({0, last, *(cycle for cycle in rounded if cycle < last)})


def check_format(path: Path) -> None:
    """Refuse names that end in neither .gif nor .mp4, and MP4 if ffmpeg is not installed."""
    ending = path.suffix.lower()
    if ending not in (".gif", ".mp4"):
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
    # Many players accept only H.264 with even sizes and halved colour resolution.
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
