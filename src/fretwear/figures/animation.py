"""An animation of one case over its cycles."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from os import PathLike
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from numpy.typing import NDArray

from fretwear.figures.datasets import check_dataset, missing_variable
from fretwear.figures.film import Picture, check_format, pixels_of, write_film
from fretwear.figures.half_profile import checked_cycles
from fretwear.figures.moving import MovingFigure, take_snapshots
from fretwear.figures.style import style_context

SCREEN_DPI = 120
FEW_SNAPSHOTS = 12

_FIELDS = ("pressure", "wear_depth", "contact_state")
_SECONDS_PER_DECADE = 1.2
_SHORTEST, _LONGEST, _LAST = 0.25, 1.2, 2.5


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

    def __init__(self, dataset: xr.Dataset, history: xr.Dataset, cycles: Sequence[int]) -> None:
        self.cycles = tuple(int(cycle) for cycle in cycles)
        self.seconds = pace(self.cycles)
        with style_context():
            self._moving = MovingFigure(
                dataset, history, take_snapshots(dataset, list(self.cycles))
            )
            self._moving.show(len(self.cycles) - 1)

    @property
    def figure(self) -> Figure:
        """The figure, as it is."""
        return self._moving.figure

    def show(self, cycle: int) -> Figure:
        """Show the snapshot at a cycle, and return the figure.

        Raises
        ------
        ValueError
            When the animation does not have it.
        """
        if cycle not in self.cycles:
            raise ValueError(f"cycle = {cycle}: this animation shows {list(self.cycles)}.")
        with style_context():
            self._moving.show(self.cycles.index(cycle))
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
            File to write; its ending tells the format.
        dots_per_inch : float
            The figure is 190 mm wide: 120 make it 898 pixels.
        progress : callable
            Called after each picture with the numbers of those done and of all.

        Raises
        ------
        ValueError
            When the name ends in neither .gif nor .mp4.
        FfmpegMissingError
            For MP4 where there is no ffmpeg; a `RuntimeError`.
        DataFileError
            When the file cannot be written.
        """
        check_format(Path(path))

        def pictures() -> Iterator[Picture]:
            for number, (cycle, seconds) in enumerate(
                zip(self.cycles, self.seconds, strict=True), start=1
            ):
                yield Picture(self._pixels(cycle, dots_per_inch), seconds)
                progress(number, len(self.cycles))

        return write_film(pictures(), Path(path))

    def _pixels(self, cycle: int, dots_per_inch: float) -> NDArray[np.uint8]:
        figure = self.show(cycle)
        with style_context():
            return pixels_of(figure, dots_per_inch)


def animation(
    dataset: xr.Dataset, history: xr.Dataset | None = None, cycles: Sequence[int] | None = None
) -> CaseAnimation:
    """Animate a case: pressure, wear depth and contact zones, snapshot after snapshot.

    Parameters
    ----------
    dataset : xarray.Dataset
        One case, quarter or whole; more snapshots make a smoother animation
        (`well_spaced_cycles`).
    history : xarray.Dataset, optional
        The case's dense history, for the half-widths over the cycles; without it they are those
        of the snapshots.
    cycles : sequence of int, optional
        Snapshots to show; left out, all.

    Returns
    -------
    CaseAnimation
        To be saved: ``fretwear.figures.animation(case).save("wear.gif")``.

    Raises
    ------
    TypeError
        When `dataset` is no dataset.
    ValueError
        When `dataset` has no fields or no such snapshot.
    """
    check_dataset(dataset)
    for name in _FIELDS:
        if name not in dataset:
            raise missing_variable(dataset, name)
    everything = [int(cycle) for cycle in np.atleast_1d(dataset["cycle"].values)]
    shown = checked_cycles(dataset, everything if cycles is None else cycles)
    return CaseAnimation(dataset, dataset if history is None else history, shown)


def pace(cycles: Sequence[int]) -> tuple[float, ...]:
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
