"""Save figures so that the same data always give the same bytes."""

from __future__ import annotations

from os import PathLike, fspath
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from fretwear.data.safe import atomic_path
from fretwear.figures.style import style_context

_METADATA: dict[str, dict[str, Any]] = {
    ".svg": {"Date": None, "Creator": "fretwear"},
    ".png": {"Software": None},
    ".pdf": {"CreationDate": None, "Creator": "fretwear", "Producer": None},
}


def save_figure(
    figure: Figure, stem: str | PathLike[str], formats: tuple[str, ...] = ("svg", "png")
) -> list[Path]:
    """Write a figure once per format; each file appears only when it is whole.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        The figure.
    stem : pathlib.Path
        Folder and name of the files, without the ending.
    formats : tuple of str
        Endings, such as ``svg``, ``png`` (300 dots per inch) and ``pdf``.

    Returns
    -------
    list of pathlib.Path
        The files written. They carry no date, and their inner names follow from the content.
    """
    return [save_as(figure, f"{fspath(stem)}.{ending}") for ending in formats]


def save_as(figure: Figure, path: str | PathLike[str]) -> Path:
    """Write a figure to one file whose ending tells the format; see `save_figure`.

    Raises
    ------
    ValueError
        When matplotlib cannot write such a format.
    """
    path = Path(path)
    ending = path.suffix.lower()
    known = figure.canvas.get_supported_filetypes()
    if ending.removeprefix(".") not in known:
        raise ValueError(
            f"{path.name}: {ending or 'no ending'} is no format for figures; "
            "end the name in .png, .svg or .pdf."
        )
    with style_context(), atomic_path(path) as temporary:
        figure.savefig(temporary, format=ending.removeprefix("."), metadata=_METADATA.get(ending))
    return path
