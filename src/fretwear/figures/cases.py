"""One case on a page or moving over its cycles, and two cases superimposed."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.animation import FFMpegWriter
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from PIL import Image

from fretwear.data.atomic import atomic_path
from fretwear.data.dataset import (
    compared_cycles,
    compared_results,
    different_parameters,
    mirrored,
)
from fretwear.figures.axes import ValueAxis, add_scale, outside_key, set_cycle_axis
from fretwear.figures.datasets import (
    Cycles,
    check_cases,
    history_of,
    profiles_of,
    snapshots,
    variable_of,
    width_names,
)
from fretwear.figures.maps import depth_scale, draw_map, draw_wear_map, take_wear_map
from fretwear.figures.profiles import (
    ZONE_COLORS,
    ZONES,
    cycle_colours,
    cycle_key,
    draw_filled,
    draw_profiles,
    frame_of,
    write_peak,
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
from fretwear.results import RESULTS, ContactState
from fretwear.study.parameters import coordinate, replaced_by, symbol_text, value_text
from fretwear.units import MICROMETRE, cycle_text, in_unit, number_text, readable_unit

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

_MOVING = ("pressure", "wear_depth", "contact_state")
_BEYOND_CONTACT = 1.1
_MARK = 4.5
_SECONDS_PER_DECADE = 1.2
_SHORTEST, _LONGEST, _LAST = 0.25, 1.2, 2.5
_COLORS = 128
_FRAMES_PER_SECOND = 4
_SCREEN_DPI = 120


@styled
def overview(
    dataset: xr.Dataset, history: xr.Dataset | None = None, cycles: Cycles = None
) -> Figure:
    """Draw pressure, shear, gap and wear along x, a map of the scar, and the zones over the cycles.

    The map shows the last snapshot of the case; a line contact has the slip along x in its place.
    The zones come from the `history` of the case, by default that of its file.
    """
    panels = [profiles_of(dataset, name, cycles) for name in _PANELS]
    colors, is_filled = cycle_colours(panels[0].cycles), panels[0].is_rough
    figure = JournalFigure(2, 126.0)
    grid = figure.subplots(2, 3, width_ratios=(1.0, 1.0, 1.08))
    place, zones = grid[:, 2]
    drawn = [*zip(grid[:, :2].flat, panels, strict=True)]
    if "y" in dataset.dims:
        scar = take_wear_map(dataset, None)
        unit = readable_unit(scar.depth, "m")
        image = draw_wear_map(place, scar, unit, depth_scale(unit.of(scar.depth.max())))
        label = f"{RESULTS['wear_depth'].label} ({unit.name})"
        place.set_title(f"{label}, cycle {cycle_text(scar.cycle)}")
        add_scale(figure, [place], image, "", aspect=24)
    else:
        drawn.append((place, profiles_of(dataset, "slip", cycles)))
    for axes, profiles in drawn:
        if is_filled:
            draw_filled(axes, profiles)
        else:
            draw_profiles(axes, profiles, colors)
    draw_zone_widths(zones, history_of(dataset) if history is None else history)
    zones.legend()
    figure.suptitle(headline(dataset), fontsize=8, x=0.005, ha="left")
    if is_filled:
        zone_key(figure, panels[:1], "outside lower left")
    else:
        cycle_key(figure, colors, "outside lower left")
    return figure


def draw_zone_widths(axes: Axes, history: xr.Dataset) -> list[Line2D]:
    """Draw the widths of contact and stick zone over the cycles; return their curves."""
    cycles = np.atleast_1d(history["cycle"].values).astype(np.float64)
    curves, names = [], width_names(history)
    for zone, name, color in zip(("contact", "stick"), names, (CATEGORICAL[0], INK), strict=True):
        widths = MICROMETRE.of(np.atleast_1d(history[name].values))
        curves += axes.plot(cycles, widths, color=color, label=zone)
    axes.set_ylim(0.0, 1.15 * axes.dataLim.ymax)
    axes.set_ylabel("Radius (µm)" if names[0] == "contact_radius" else HALF_WIDTH_LABEL)
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
    have. `histories` by the same titles are by default those of the files of the cases. Any number
    of cases but two raises a ValueError.
    """
    check_cases(cases)
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
            write_peak(axes, profile, frame)
        frame.apply(axes, shown[0].field)
    dense = [(histories or {}).get(title, history_of(case)) for title, case in cases.items()]
    axis = ValueAxis(
        variable_of(first, "wear_volume"), np.concatenate([one["wear_volume"] for one in dense])
    )
    for title, style, history in zip(cases, styles, dense, strict=True):
        for zone, name, width in zip(
            ("contact", "stick"), width_names(history), (1.1, 0.6), strict=True
        ):
            values = MICROMETRE.of(history[name].values)
            widths.plot(history["cycle"], values, lw=width, label=f"{title}, {zone}", **style)
        volumes.plot(history["cycle"], axis.unit.of(history["wear_volume"]), label=title, **style)
    every = np.concatenate([one["cycle"] for one in dense])
    widths.set_ylim(0.0, 1.1 * widths.dataLim.ymax)
    is_radius = width_names(dense[0])[0] == "contact_radius"
    widths.set_ylabel("Radius (µm)" if is_radius else HALF_WIDTH_LABEL)
    widths.set_title("thick: contact, thin: stick")
    for axes in (widths, volumes):
        set_cycle_axis(axes, every)
    axis.apply(volumes.yaxis)
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
        text = axes.text(1.03, row, f"×{number_text(ratio, 3)}", va="center", fontsize=7.0)
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
        draw_zone_widths(widths, history)
        widths.legend()
        now = widths.axvline(self.cycles[-1], color=MUTED, lw=0.8)
        self._updates.append(lambda index: now.set_xdata([self.cycles[index]] * 2))
        zone_key(self.figure, [profiles], "outside lower left")
        self.show(self.cycles[-1])

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
        is_gif = path.suffix.lower() == ".gif"
        pictures, before = [], self.figure.dpi
        movie = FFMpegWriter(fps=_FRAMES_PER_SECOND, codec="libx264")
        with style_context(), atomic_path(path) as temporary:
            self.figure.set_dpi(dots_per_inch)
            canvas = FigureCanvasAgg(self.figure)
            if not is_gif:
                movie.extra_args = ["-f", "mp4", "-pix_fmt", "yuv420p"]
                movie.setup(self.figure, str(temporary), dots_per_inch)
            for number, (cycle, seconds) in enumerate(
                zip(self.cycles, self.seconds, strict=True), 1
            ):
                self.show(cycle)
                progress(number, len(self.cycles))
                if is_gif:
                    canvas.draw()  # type: ignore[no-untyped-call]
                    pixels = np.asarray(canvas.buffer_rgba())  # type: ignore[no-untyped-call]
                    picture = Image.fromarray(pixels).convert("RGB")
                    pictures.append(picture.quantize(_COLORS, dither=Image.Dither.NONE))
                    continue
                for _ in range(max(1, round(_FRAMES_PER_SECOND * seconds))):
                    movie.grab_frame()
            if is_gif:
                times = {"duration": [round(1000 * time) for time in self.seconds], "loop": 0}
                others = pictures[1:]
                pictures[0].save(temporary, "GIF", save_all=True, append_images=others, **times)
            else:
                movie.finish()
            self.figure.set_dpi(before)
        return path


def animation(
    dataset: xr.Dataset, history: xr.Dataset | None = None, cycles: Sequence[int] | None = None
) -> CaseAnimation:
    """Animate a case: pressure, wear depth and contact zones, snapshot after snapshot.

    `cycles` are all snapshots by default; more of them make a smoother animation
    (`well_spaced_cycles`). The widths over the cycles come from the `history`, by default that of
    the file. Save it by ``fretwear.figures.animation(case).save("wear.gif")``.
    """
    shown = snapshots(dataset, cycles, *_MOVING, default=list)
    return CaseAnimation(shown, history_of(dataset) if history is None else history)


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
