"""A figure with its name and caption."""

from __future__ import annotations

from typing import NamedTuple

from matplotlib.figure import Figure


class StudyFigure(NamedTuple):
    """A figure of a study: file name without ending, caption, category, and the figure."""

    name: str
    caption: str
    category: str
    figure: Figure
