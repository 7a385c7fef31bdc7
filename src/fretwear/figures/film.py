"""Films: bitmaps with the time that each is shown, written as GIF or MP4."""

from __future__ import annotations

import shutil
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from fretwear.data.safe import atomic_path

FORMATS = (".gif", ".mp4")

_COLORS = 128
_FRAMES_PER_SECOND = 20
_MILLISECONDS = 1000


class FfmpegMissingError(RuntimeError):
    """An MP4 file was asked for where the program ffmpeg is not installed."""


@dataclass(frozen=True)
class Picture:
    """One picture of a film.

    Parameters
    ----------
    pixels : array of shape (height, width, 3)
        Red, green and blue from 0 to 255.
    seconds : float
        How long it is shown.
    """

    pixels: NDArray[np.uint8]
    seconds: float


def check_format(path: Path) -> None:
    """Refuse a name whose ending tells no film, or one that cannot be written here.

    Raises
    ------
    ValueError
        When the name ends in something else.
    FfmpegMissingError
        For MP4 where there is no ffmpeg.
    """
    ending = path.suffix.lower()
    if ending not in FORMATS:
        raise ValueError(
            f"{path.name}: {ending or 'no ending'} is no format for animations; "
            "end the name in .gif or .mp4."
        )
    if ending == ".mp4" and shutil.which("ffmpeg") is None:
        raise FfmpegMissingError(
            f"{path.name}: .mp4 needs the program ffmpeg, which is not on the PATH. Install it, "
            f"or write {path.with_suffix('.gif').name} instead, which needs nothing else."
        )


def pixels_of(figure: Figure, dots_per_inch: float) -> NDArray[np.uint8]:
    """Draw a figure; return red, green and blue of its pixels, shape (height, width, 3)."""
    figure.set_dpi(dots_per_inch)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()  # type: ignore[no-untyped-call]
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()  # type: ignore[no-untyped-call]


def write_film(pictures: Iterable[Picture], path: Path) -> Path:
    """Write a film; the ending of the name tells the format.

    Parameters
    ----------
    pictures : iterable of Picture
        The pictures, all of one size.
    path : pathlib.Path
        File to write; it appears only when it is whole.

    Raises
    ------
    ValueError, FfmpegMissingError
        As `check_format`.
    DataFileError
        When the file cannot be written.
    """
    check_format(path)
    write = _write_gif if path.suffix.lower() == ".gif" else _write_mp4
    with atomic_path(path) as temporary:
        write(pictures, temporary)
    return path


def _write_gif(pictures: Iterable[Picture], path: Path) -> None:
    durations: list[int] = []

    def images() -> Iterator[Image.Image]:
        for picture in pictures:
            durations.append(round(_MILLISECONDS * picture.seconds))
            image = Image.fromarray(picture.pixels)
            yield image.quantize(_COLORS, dither=Image.Dither.NONE)

    first, *others = images()
    first.save(
        path,
        format="GIF",
        save_all=True,
        append_images=others,
        duration=durations,
        loop=0,
        optimize=False,
    )


def _write_mp4(pictures: Iterable[Picture], path: Path) -> None:
    # It takes as long to import as the rest of matplotlib: only films need it.
    from matplotlib.animation import FFMpegWriter

    # The writer takes figures; what it draws here is a picture that fills one.
    # Many players know H.264 with halved colours only.
    arguments = ["-pix_fmt", "yuv420p", "-crf", "20", "-f", "mp4"]
    writer = FFMpegWriter(fps=_FRAMES_PER_SECOND, codec="libx264", extra_args=arguments)
    figure: Figure | None = None
    for picture in pictures:
        height, width = picture.pixels.shape[:2]
        even = picture.pixels[: height - height % 2, : width - width % 2]
        if figure is None:
            figure = Figure(figsize=(even.shape[1] / 100, even.shape[0] / 100), dpi=100)
            FigureCanvasAgg(figure)
            writer.setup(figure, str(path), dpi=100)
        figure.figimage(even)
        for _ in range(max(1, round(_FRAMES_PER_SECOND * picture.seconds))):
            writer.grab_frame()
        figure.images.clear()
    writer.finish()
