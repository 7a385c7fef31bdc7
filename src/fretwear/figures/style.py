"""The look that all figures share: style sheet, journal sizes, colours."""

from __future__ import annotations

import io
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any, Literal, ParamSpec, TypeVar

import matplotlib
import matplotlib.colors
import matplotlib.style
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

STYLE_SHEET = Path(__file__).with_name("fretwear.mplstyle")

Columns = Literal[1, 2]
"""Width of a figure in columns of a journal page."""

COLUMN_WIDTH = {1: 90.0, 2: 190.0}
"""Width in mm of a figure over one and over two journal columns."""

STICK_SHADE = "#efefef"
MUTED = "#666666"
INK = "#1a1a1a"

CATEGORICAL = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000")
"""Okabe and Ito's colours, which people with any colour vision can tell apart."""

MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")
LINE_STYLES: tuple[Any, ...] = ("-", (0, (4, 1.6)), (0, (1, 1.3)), (0, (5, 1.4, 1, 1.4)))

_MM_PER_INCH = 25.4
_LIGHTEST, _DARKEST = 0.82, 0.0

P = ParamSpec("P")
T = TypeVar("T")


class JournalFigure(Figure):
    """A matplotlib Figure of journal size that a notebook shows without pyplot.

    Parameters
    ----------
    columns : {1, 2}
        Journal columns that the figure spans, 90 mm or 190 mm.
    height : float
        Height in mm.
    """

    def __init__(self, columns: Columns, height: float) -> None:
        if columns not in COLUMN_WIDTH:
            raise ValueError(f"columns = {columns!r}: a figure spans 1 or 2 journal columns.")
        size = (COLUMN_WIDTH[columns] / _MM_PER_INCH, height / _MM_PER_INCH)
        super().__init__(figsize=size, layout="constrained")
        FigureCanvasAgg(self)

    def _repr_png_(self) -> bytes:
        buffer = io.BytesIO()
        with style_context():
            self.savefig(buffer, format="png")
        return buffer.getvalue()


def style_context() -> Any:
    """Return a context in which matplotlib follows fretwear's style sheet."""
    return matplotlib.style.context(["default", str(STYLE_SHEET)])


def styled(function: Callable[P, T]) -> Callable[P, T]:
    """Make a function draw in fretwear's style, whatever the caller's settings are."""

    @wraps(function)
    def inside(*args: P.args, **kwargs: P.kwargs) -> T:
        with style_context():
            return function(*args, **kwargs)

    return inside


def sequential_colours(count: int) -> list[str]:
    """Return `count` colours of one perceptual ramp, the last the darkest.

    The light end of viridis is left out: it is lost on white paper.
    """
    positions = np.linspace(_LIGHTEST, _DARKEST, count) if count > 1 else [_DARKEST]
    colormap = matplotlib.colormaps["viridis"]
    return [matplotlib.colors.to_hex(colormap(position)) for position in positions]


def sequential_colormap() -> matplotlib.colors.Colormap:
    """Return the continuous form of `sequential_colours`, for long series."""
    samples: NDArray[np.float64] = np.linspace(_LIGHTEST, _DARKEST, 256)
    colors = matplotlib.colormaps["viridis"](samples)
    return matplotlib.colors.ListedColormap(colors, name="fretwear_sequence")
