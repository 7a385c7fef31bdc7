"""The index of a folder of figures: what each is called and shows. It takes no matplotlib."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from pathlib import Path

from fretwear.data.safe import DataFileError, read_data

INDEX_NAME = "index.json"
ANSWER_CATEGORY = "What each parameter does"
HISTORY_CATEGORY = "Over the cycles"
PROFILE_CATEGORY = "Along the direction of slip"
MAP_CATEGORY = "Over the contact"

PAGE_WIDTH = 190.0
"""Width in mm of a figure over two journal columns."""

_NAME = re.compile(r"\w[\w.-]*", re.ASCII)
_MOST_BYTES = 10_000_000


@dataclass(frozen=True)
class FigureEntry:
    """What the index of a folder of figures tells of each."""

    name: str
    caption: str
    category: str

    def __post_init__(self) -> None:
        # A name with a path would fetch any file into the report.
        if not (_NAME.fullmatch(self.name) and isinstance(self.caption + self.category, str)):
            raise ValueError(f"{self.name!r} is no name of a figure.")


def read_figure_index(folder: Path) -> list[FigureEntry]:
    """Return what `write_study_figures` has written to a folder, in the same order.

    It raises a `DataFileError` when the index is not there or is none.
    """
    index = folder / INDEX_NAME
    try:
        return [FigureEntry(**entry) for entry in json.loads(read_data(index, _MOST_BYTES))]
    except (OSError, ValueError, TypeError, RecursionError) as cause:
        problem = "there is no such file" if not index.exists() else "it is not a list of figures"
        raise DataFileError(index, problem, "Draw the figures again") from cause


def captions(folder: Path) -> dict[str, str]:
    """Return captions as reStructuredText for Snakemake's report; none before they are drawn.

    The template that puts them in place comes with the package: one that lay among the results
    could come from anywhere, and a template can run whatever it likes.
    """
    try:
        texts = {each.name: " ".join(each.caption.split()) for each in read_figure_index(folder)}
    except DataFileError:
        return {}
    # Text in which reStructuredText finds no markup.
    return {name: re.sub(r"([^\w\s]|_)", r"\\\1", text) for name, text in texts.items()}


def figure_category(folder: Path, name: str) -> str:
    """Return the category of a figure by its name."""
    return {entry.name: entry.category for entry in read_figure_index(folder)}[name]


def figure_labels(folder: Path, name: str) -> dict[str, str]:
    """Return the labels of a figure in a list: its name and the first sentence of its caption."""
    caption = {entry.name: entry.caption for entry in read_figure_index(folder)}[name]
    return {"figure": name, "shows": caption.partition(". ")[0].removesuffix(".")}
