"""The section of a report on cracks: where the first is expected, and how wear moved that place."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from fretwear.figures.cracks import first_crack
from fretwear.report.results import PointResult
from fretwear.units import MEGAPASCAL, MICROMETRE, cycle_text, number_text
from fretwear.vocabulary import FATIGUE_OUTCOMES

if TYPE_CHECKING:
    import xarray as xr


class ExpectedCrack(NamedTuple):
    """A row of the table: texts of a case before and after wear."""

    title: str
    parameter: str  # largest Smith–Watson–Topper parameter, MPa
    x: str  # place along x, µm
    depth: str  # µm
    angle: str  # degrees
    life: str  # cycles; empty without constants of the material
    damage: str
    outcome: str


def expected_cracks(summary: xr.Dataset, results: Sequence[PointResult]) -> list[ExpectedCrack]:
    """Return a row for each finished point, or none if the study asks for no stresses."""
    if "largest_smith_watson_topper" not in summary:
        return []
    has_lives = "life" in summary

    def pair(name: str, place: tuple[int, ...], size: float = 1.0, digits: int = 3) -> str:
        """A value before wear and after, rounded."""
        value = summary[name].values[place]
        value = value[np.isfinite(value)] / size
        texts = [number_text(float(value[end]), digits) for end in (0, -1)] if value.size else ["–"]
        return " → ".join(dict.fromkeys(texts))

    first_cracks = first_crack(summary).values if has_lives else np.empty(0)
    rows = []
    places = np.ndindex(summary["status"].shape)
    for result, place in zip(results, places, strict=True):
        swt = summary["largest_smith_watson_topper"].values[place]
        if not result.done or not np.isfinite(swt).any():
            continue
        outcome = ""
        if has_lives:
            kind = summary["fatigue_outcome"].values[place]
            outcome = FATIGUE_OUTCOMES[int(kind[np.isfinite(kind)][-1])]
            first = np.nanmax(np.append(first_cracks[place], 0.0))
            outcome += f", first at cycle {cycle_text(float(np.round(first)))}" if first else ""
        rows.append(
            ExpectedCrack(
                result.title,
                pair("largest_smith_watson_topper", place, MEGAPASCAL.size),
                pair("crack_x", place, MICROMETRE.size),
                pair("crack_depth", place, MICROMETRE.size),
                pair("crack_angle", place, 1.0, 2),
                pair("life", place) if has_lives else "",
                pair("largest_damage", place) if has_lives else "",
                outcome,
            )
        )
    return rows
