"""The index of a folder of figures: their names and captions. It does not need matplotlib."""

from __future__ import annotations

import json
from pathlib import Path
from typing import NamedTuple

from fretwear.data.atomic import DataFileError
from fretwear.results import BODY_FIELDS, FIELDS, FRICTION_FIELD, OPTIONAL_SCALARS, SCALARS

INDEX_NAME = "index.json"

_SHORT = {"shear_traction": "shear", "wear_depth": "wear"}
PROFILES = {
    f"{_SHORT.get(field.name, field.name)}_profiles": field.name
    for field in (*FIELDS, *BODY_FIELDS, FRICTION_FIELD)
    if not field.flags
}
"""The fields drawn along x, by the names of their figures."""
HISTORIES = {
    scalar.name.removesuffix("_x"): scalar.name for scalar in (*SCALARS, *OPTIONAL_SCALARS)
}
"""The results drawn over the cycles, by the names of their figures."""


class FigureEntry(NamedTuple):
    """The entry of a figure in the index of its folder."""

    name: str
    caption: str


def read_figure_index(folder: Path) -> list[FigureEntry]:
    """Return the figures that `write_study_figures` has written to a folder, in the same order.

    Raises a `DataFileError` if the index is missing or not a list of figures.
    """
    index = folder / INDEX_NAME
    try:
        return [FigureEntry(**entry) for entry in json.loads(index.read_bytes())]
    except (OSError, ValueError, TypeError) as cause:
        problem = "there is no such file" if not index.exists() else "it is not a list of figures"
        raise DataFileError(index, problem, "Draw the figures again") from cause
