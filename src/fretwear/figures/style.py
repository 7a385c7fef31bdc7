"""Shared by all figures: style sheet, journal sizes, colours, captions, saving."""

from __future__ import annotations

import io
from collections.abc import Callable
from contextlib import AbstractContextManager
from functools import wraps
from os import PathLike
from pathlib import Path
from typing import Any, Literal, ParamSpec, TypeVar

import matplotlib
import matplotlib.colors
import matplotlib.style
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backend_bases import get_registered_canvas_class
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from fretwear.data.atomic import atomic_path

STYLE_SHEET = Path(__file__).with_name("fretwear.mplstyle")

Columns = Literal[1, 2]

COLUMN_WIDTH = {1: 90.0, 2: 190.0}
"""Width in mm of a figure over one and over two journal columns."""

STICK_SHADE = "#efefef"
MUTED = "#666666"
INK = "#1a1a1a"

LINE_STYLES: tuple[Any, ...] = ("-", (0, (4, 1.6)), (0, (1, 1.3)), (0, (5, 1.4, 1, 1.4)))


_MM_PER_INCH = 25.4
_SCREEN_DPI = 150
_LIGHTEST, _DARKEST = 0.8, 0.0

P = ParamSpec("P")
Q = TypeVar("Q")


class JournalFigure(Figure):
    """A matplotlib Figure of 1 or 2 journal columns and a height in mm, shown without pyplot."""

    def __init__(self, columns: Columns, height: float) -> None:
        size = (COLUMN_WIDTH[columns] / _MM_PER_INCH, height / _MM_PER_INCH)
        super().__init__(figsize=size, layout="constrained")
        self.sentences: list[str] = []
        FigureCanvasAgg(self)

    @property
    def caption(self) -> str:
        """What the figure shows, in sentences."""
        return " ".join(self.sentences)

    def savefig(self, fname: Any, **options: Any) -> None:
        """Save as matplotlib does, in fretwear's style whatever the user's settings."""
        with style_context():
            super().savefig(fname, **options)

    def _repr_png_(self) -> bytes:
        buffer = io.BytesIO()
        self.savefig(buffer, format="png", dpi=_SCREEN_DPI)
        return buffer.getvalue()


def root_figure(axes: Axes) -> Figure:
    """Return the figure to which axes, or the subfigure around them, belong."""
    figure = axes.get_figure(root=True)
    if figure is None:
        raise ValueError("The axes do not belong to a figure: they have been removed from it.")
    return figure


def caption(place: Figure | Axes, sentence: str) -> None:
    """Add a sentence to the caption of a figure, unless it is there or the figure is not ours."""
    figure = place if isinstance(place, Figure) else root_figure(place)
    if isinstance(figure, JournalFigure) and sentence not in figure.sentences:
        figure.sentences.append(sentence)


def one_panel(columns: Columns, height: float, ax: Axes | None) -> tuple[Figure, Axes]:
    """Return a new figure, `height` mm high, with its axes, or the figure of the given axes."""
    axes = ax or JournalFigure(columns, height).subplots()
    return root_figure(axes), axes


def style_context() -> AbstractContextManager[None]:
    """Return a context in which matplotlib draws in fretwear's style."""
    return matplotlib.style.context(["default", str(STYLE_SHEET)])


def styled(function: Callable[P, Q]) -> Callable[P, Q]:
    """Make a function draw in fretwear's style, whatever the caller's settings."""

    @wraps(function)
    def drawing(*args: P.args, **kwargs: P.kwargs) -> Q:
        with style_context():
            return function(*args, **kwargs)

    return drawing


def save_as(figure: Figure, *files: str | PathLike[str]) -> None:
    """Write a figure to files, such as ``.svg``, ``.png`` (300 dots per inch) and ``.pdf``.

    Each file appears only when it is complete. The layout is made once, and each format drawn once:
    `Figure.savefig` draws it twice.
    """
    layout, canvas, dpi = figure.get_layout_engine(), figure.canvas, figure.dpi
    try:
        with style_context():
            figure.dpi = matplotlib.rcParams["savefig.dpi"]
            if layout is not None:
                # The first layout moves axes to scale, and the labels beside them.
                is_to_scale = any(axes.get_aspect() != "auto" for axes in figure.axes)
                for _ in range(1 + is_to_scale):
                    layout.execute(figure)
                figure.set_layout_engine("none")
            for path in map(Path, files):
                ending = path.suffix.lower().removeprefix(".")
                options = {"metadata": {"Date": None}} if ending == "svg" else {}
                if (canvas_class := get_registered_canvas_class(ending)) is None:
                    raise ValueError(f"Format {ending!r} is not supported.")
                figure.dpi = matplotlib.rcParams["savefig.dpi"]  # an SVG leaves 72
                printing = canvas_class(figure)
                with atomic_path(path) as temporary:
                    getattr(printing, f"print_{ending}")(temporary, **options)
    finally:
        figure.dpi = dpi
        figure.set_canvas(canvas)
        figure.set_layout_engine(layout)


def sequential_colours(count: int) -> list[str]:
    """Return `count` colours of a perceptual ramp, the last one darkest."""
    shades = sequential_colormap()(np.linspace(1.0, 0.0, count)[::-1])
    return [matplotlib.colors.to_hex(shade) for shade in shades]


def sequential_colormap() -> matplotlib.colors.Colormap:
    """Return the ramp: inferno without its light end, which is lost on white paper.

    Six colours of this ramp are farther apart than six of viridis, even to people who confuse red
    and green.
    """
    colors = matplotlib.colormaps["inferno"](np.linspace(_LIGHTEST, _DARKEST, 256))
    return matplotlib.colors.ListedColormap(colors, name="fretwear_sequence")


def depth_colormap() -> matplotlib.colors.Colormap:
    """Return the colours of a depth: white for zero, then the `sequential_colormap`."""
    ramp = sequential_colormap()(np.linspace(0.0, 1.0, 200))
    fading = np.linspace(1.0, 0.0, 56, endpoint=False)[:, None]
    colors = np.concatenate([fading + (1.0 - fading) * ramp[0], ramp])
    return matplotlib.colors.ListedColormap(colors, name="fretwear_depth")
