"""``fretwear animate``: one case as it moves."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from fretwear.cli.arguments import CaseFile, Format, Quiet
from fretwear.cli.commands import open_log
from fretwear.cli.inputs import check_results
from fretwear.cli.log import LogFormat, shows_a_bar
from fretwear.cli.outputs import check_file
from fretwear.cli.status import Status, failing_as


def animate(
    context: typer.Context,
    file: CaseFile,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="WEAR.gif",
            help="File to write: .gif, or .mp4 where the program ffmpeg is installed.",
            show_default="OUT.gif",
        ),
    ] = None,
    dots: Annotated[
        float,
        typer.Option(
            "--dpi",
            metavar="NUMBER",
            min=30.0,
            max=600.0,
            help="Dots per inch; the pictures are 190 mm wide, at 120 dpi 897 pixels.",
        ),
    ] = 120.0,
    quiet: Quiet = False,
    log_format: Format = LogFormat.AUTO,
) -> None:
    """Animate pressure, wear depth and contact zones of a case over its cycles.

    Only the snapshots that the case has kept are shown, longer where the next
    one is further away on a logarithmic axis. Some thirty move smoothly:
    'output: {cycles: [0, 1, 2, 3, 5, 8, 10, ...]}' in the study file.
    """
    log = open_log(context, log_format, quiet=quiet)
    check_results(file)
    path = check_file(output or file.with_suffix(".gif"), ".gif", ".mp4")

    from fretwear.data.files import open_case, open_history
    from fretwear.data.safe import DataFileError
    from fretwear.figures.film import FfmpegMissingError, check_format

    with (
        failing_as(Status.WRONG_INPUT, DataFileError, FfmpegMissingError),
        open_case(file) as case,
        open_history(file) as history,
    ):
        check_format(path)

        from fretwear.figures.animation import FEW_SNAPSHOTS, animation, well_spaced_cycles

        moving = animation(case, history)
        with failing_as(Status.FAILED, DataFileError), _bar(log_format, quiet=quiet) as progress:
            moving.save(path, dots_per_inch=dots, progress=progress)
    pictures, size = len(moving.cycles), path.stat().st_size
    log.result(path, f"{pictures} pictures, {size / 1e6:.2f} MB", pictures=pictures, bytes=size)
    if pictures < FEW_SNAPSHOTS:
        cycles = ", ".join(map(str, well_spaced_cycles(moving.cycles[-1])))
        log.note(
            f"{file} has {pictures} snapshots. For a smoother animation let the study keep more, "
            f"for example output: {{cycles: [{cycles}]}}"
        )


@contextmanager
def _bar(log_format: LogFormat, *, quiet: bool) -> Iterator[Callable[[int, int], None]]:
    """Give what shows on a terminal how many pictures are done; anywhere else it does nothing."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    console = Console(stderr=True)
    hidden = quiet or log_format is not LogFormat.AUTO or not shows_a_bar()
    columns = (TextColumn("picture"), MofNCompleteColumn(), BarColumn(bar_width=24))
    with Progress(*columns, console=console, transient=True, disable=hidden) as bar:
        task = bar.add_task("", total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)
