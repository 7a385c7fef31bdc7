"""``fretwear plot`` and ``fretwear animate``: one case as a figure, and as it moves."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fretwear.cli.common import (
    FIGURE_FORMATS,
    CaseFile,
    CommandError,
    Format,
    LogFormat,
    Quiet,
    begin,
    check_output,
    opened,
    option,
    say,
)

_FIGURE = "File to write: .png, .svg or .pdf."
_FILM = "File to write: .gif, or .mp4 where the program ffmpeg is installed."
_DOTS = "Dots per inch; the pictures are 190 mm wide, at 120 dpi 897 pixels."


def plot(
    file: CaseFile,
    output: Annotated[
        Path | None,
        option("-o/--output", "FIG.png", "File to write: .png, .svg or .pdf.", "OUT.png"),
    ] = None,
) -> None:
    """Draw pressure, shear, gap and wear along x, and a map of the scar."""
    with opened(file) as (case, history):
        path = check_output(output or file.with_suffix(".png"), *FIGURE_FORMATS)

        from fretwear.figures import overview, save_as

        save_as(overview(case, history), path)
    say(str(path))


def animate(
    context: typer.Context,
    file: CaseFile,
    output: Annotated[Path | None, option("-o/--output", "WEAR.gif", _FILM, "OUT.gif")] = None,
    dots: Annotated[
        float, typer.Option("--dpi", metavar="NUMBER", min=30.0, max=600.0, help=_DOTS)
    ] = 120.0,
    quiet: Quiet = False,
    log_format: Format = LogFormat.AUTO,
) -> None:
    """Animate pressure, wear depth and contact zones of a case over its cycles.

    Only the snapshots in the case file are shown, each the longer the further away
    the next one is on a logarithmic axis. Some thirty move smoothly:
    'output: {cycles: [0, 1, 2, 3, 5, 8, 10, ...]}' in the study file.
    """
    log = begin(context, log_format, quiet=quiet)
    with opened(file) as (case, history):
        path = check_output(output or file.with_suffix(".gif"), ".gif", ".mp4")

        from fretwear.figures.animation import (
            FEW_SNAPSHOTS,
            FfmpegMissingError,
            animation,
            check_format,
            well_spaced_cycles,
        )

        try:
            check_format(path)
        except FfmpegMissingError as error:
            raise CommandError(str(error)) from error
        moving = animation(case, history)
        with log.counting("picture") as progress:
            moving.save(path, dots_per_inch=dots, progress=progress)
    pictures, size = len(moving.cycles), path.stat().st_size
    log.result(path, f"{pictures} pictures, {size / 1e6:.2f} MB", pictures=pictures, bytes=size)
    if pictures < FEW_SNAPSHOTS:
        cycles = ", ".join(map(str, well_spaced_cycles(moving.cycles[-1])))
        log.note(
            f"{file} has {pictures} snapshots. For a smoother animation let the study keep more, "
            f"for example output: {{cycles: [{cycles}]}}"
        )
