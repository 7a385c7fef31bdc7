"""Figures as parts of the page itself."""

from __future__ import annotations

import base64
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from fretwear.data.safe import DataFileError
from fretwear.figures.study import FigureEntry, read_figure_index
from fretwear.figures.style import COLUMN_WIDTH

_LARGE = 1_000_000
_HEAD = 2000
_MM_PER_POINT = 25.4 / 72.0
_MIME = {".svg": "image/svg+xml", ".png": "image/png"}


@dataclass(frozen=True)
class EmbeddedFigure:
    """A figure with its image as a data URI.

    Parameters
    ----------
    name, caption : str
        As in the index of the figures.
    uri : str
        The image.
    share : float
        Its width as a share of a journal page's, so that text is as large in every figure.
    """

    name: str
    caption: str
    uri: str
    share: float


@dataclass(frozen=True)
class FigureGroup:
    """Figures of one category, in their order."""

    category: str
    figures: tuple[EmbeddedFigure, ...]


def figure_groups(folder: Path) -> list[FigureGroup]:
    """Return the figures of a folder by category, in the order of its index.

    Parameters
    ----------
    folder : pathlib.Path
        As written by `fretwear.figures.study.write_study_figures`.

    Raises
    ------
    fretwear.data.safe.DataFileError
        When the index or a figure is missing or damaged.
    """
    entries = read_figure_index(folder)
    categories = dict.fromkeys(entry.category for entry in entries)
    return [FigureGroup(category, _embedded(folder, entries, category)) for category in categories]


def _embedded(
    folder: Path, entries: Sequence[FigureEntry], category: str
) -> tuple[EmbeddedFigure, ...]:
    return tuple(
        EmbeddedFigure(
            entry.name,
            entry.caption,
            _data_uri(_lighter(folder, entry.name)),
            _share(folder / f"{entry.name}.svg"),
        )
        for entry in entries
        if entry.category == category
    )


def _lighter(folder: Path, name: str) -> Path:
    """Return the vector file, or the bitmap where the vector one is large and heavier."""
    vector, bitmap = folder / f"{name}.svg", folder / f"{name}.png"
    size = _size(vector)
    return bitmap if size > _LARGE and _size(bitmap) < size else vector


def _size(path: Path) -> int:
    try:
        size = path.stat().st_size
    except OSError:
        size = 0
    if not size:
        raise DataFileError(path, "this figure is missing or empty", "Draw the figures again")
    return size


def _data_uri(path: Path) -> str:
    # An image of its own, not inline SVG: the ids inside two inlined SVGs would collide.
    text = base64.b64encode(path.read_bytes()).decode("ascii")
    return f"data:{_MIME[path.suffix]};base64,{text}"


def _share(vector: Path) -> float:
    """Return the width of a figure as a share of the two columns of a journal page."""
    with vector.open(encoding="utf-8") as lines:
        head = lines.read(_HEAD)
    found = re.search(r'<svg[^>]*\swidth="([\d.]+)pt"', head)
    millimetres = float(found[1]) * _MM_PER_POINT if found else COLUMN_WIDTH[2]
    return round(min(1.0, millimetres / COLUMN_WIDTH[2]), 3)
