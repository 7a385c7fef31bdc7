"""The index of a folder of figures: their names and captions. It does not need matplotlib."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from pathlib import Path

from fretwear.data.atomic import DataFileError
from fretwear.results import BODY_FIELDS, BODY_SCALARS, FIELDS, SCALARS

INDEX_NAME = "index.json"
ANSWER_CATEGORY = "What each parameter does"
HISTORY_CATEGORY = "Over the cycles"
PROFILE_CATEGORY = "Along the direction of slip"
MAP_CATEGORY = "Over the contact"

LEAD = "answer"
"""Name of the figure that answers the question of a study."""
PAGE_WIDTH = 190.0
"""Width in mm of a figure over two journal columns."""

_SHORT = {"shear_traction": "shear", "wear_depth": "wear"}
PROFILES = {
    f"{_SHORT.get(field.name, field.name)}_profiles": field.name
    for field in (*FIELDS, *BODY_FIELDS)
    if not field.flags
}
"""The fields drawn along x, by the names of their figures."""
HISTORIES = {scalar.name.removesuffix("_x"): scalar.name for scalar in (*SCALARS, *BODY_SCALARS)}
"""The results drawn over the cycles, by the names of their figures."""

_NAME = re.compile(r"\w[\w.-]*", re.ASCII)


@dataclass(frozen=True)
class FigureEntry:
    """The entry of a figure in the index of its folder."""

    name: str
    caption: str
    category: str

    def __post_init__(self) -> None:
        # A name with a path would fetch any file into the report.
        if not (_NAME.fullmatch(self.name) and isinstance(self.caption + self.category, str)):
            raise ValueError(f"{self.name!r} is not a valid name of a figure.")


def read_figure_index(folder: Path) -> list[FigureEntry]:
    """Return the figures that `write_study_figures` has written to a folder, in the same order.

    Raises a `DataFileError` if the index is missing or not a list of figures.
    """
    index = folder / INDEX_NAME
    try:
        return [FigureEntry(**entry) for entry in json.loads(index.read_bytes())]
    except (OSError, ValueError, TypeError, RecursionError) as cause:
        problem = "there is no such file" if not index.exists() else "it is not a list of figures"
        raise DataFileError(index, problem, "Draw the figures again") from cause


def captions(folder: Path) -> dict[str, str]:
    """Return captions as reStructuredText for Snakemake's report; none before they are drawn.

    The template that shows them comes with the package: a template among the results could come
    from anyone, and templates can run any code.
    """
    try:
        entries = read_figure_index(folder)
    except DataFileError:
        return {}
    texts = {entry.name: " ".join(entry.caption.split()) for entry in entries}
    # Escape everything that could be markup.
    return {name: re.sub(r"([^\w\s]|_)", r"\\\1", text) for name, text in texts.items()}


def figure_category(folder: Path, name: str) -> str:
    """Return the category of a named figure."""
    return {entry.name: entry.category for entry in read_figure_index(folder)}[name]


def figure_labels(folder: Path, name: str) -> dict[str, str]:
    """Return the labels of a figure: its name and the first sentence of its caption."""
    caption = {entry.name: entry.caption for entry in read_figure_index(folder)}[name]
    return {"figure": name, "shows": caption.partition(". ")[0].removesuffix(".")}
