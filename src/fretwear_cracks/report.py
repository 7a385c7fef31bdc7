"""The section of a report on cracks: where the first is expected, and how wear moved that place."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from markupsafe import Markup

from fretwear.arrays import Array
from fretwear.data.effects import point_values, varied_names
from fretwear.report import Section, table_html
from fretwear.study.parameters import parameter, value_text
from fretwear.units import cycle_text, number_text
from fretwear_cracks.variables import FATIGUE, FATIGUE_HEADS, FATIGUE_OUTCOMES

_MOST_ROWS = 2000
_WORDS = (
    "The first crack is expected where the Smith–Watson–Topper parameter is largest on the plane "
    "y = 0. The table has this place from the first snapshot to the last (→), and the angle of its "
    "plane, downwards from the direction of slip."
)
_OF_LIVES = (
    " Lives are those at the stresses of one snapshot. Damage is Miner’s sum over points fixed in "
    "the material that wear has not removed; at 1 a crack is expected. Wear wins where it prevents "
    "a crack or wears one away."
)


def crack_table(summary: xr.Dataset) -> pd.DataFrame:
    """Texts about the finished points that have stresses: before wear → after it."""
    lives = "life" in summary
    points = np.ndindex(summary["status"].shape)
    varied = {name: point_values(summary, name) for name in varied_names(summary)}
    rows = []
    for number, place in enumerate(points):

        def values(name: str, place: tuple[int, ...] = place) -> Array:
            found: Array = summary[name].values[place]
            return found[np.isfinite(found)]

        if not values("largest_smith_watson_topper").size:
            continue
        row = {
            parameter(name).words.capitalize(): value_text(name, of_points[number])
            for name, of_points in varied.items()
        }
        for about, (head, size) in zip(FATIGUE[1:7], FATIGUE_HEADS[1:7], strict=True):
            if (name := about.name) in summary:
                ends = [values(name)[end] / size for end in (0, -1) if values(name).size]
                texts = [number_text(float(end), 3) for end in ends] or ["–"]
                row[head] = " → ".join(dict.fromkeys(texts))
        if lives:
            row["outcome"] = FATIGUE_OUTCOMES[int(values("fatigue_outcome")[-1])]
            # Only a study of lives waits for matplotlib.
            from fretwear_cracks.figures import first_crack

            if (first := np.nan_to_num(first_crack(summary).values[place]).max()) > 0.0:
                row["outcome"] += f", first at cycle {cycle_text(float(np.round(first)))}"
        rows.append(row)
    return pd.DataFrame(rows)


def crack_sections(summary: xr.Dataset, cases: Path) -> Iterator[Section]:  # noqa: ARG001
    """Yield the section of a study that asks for stresses."""
    if "largest_smith_watson_topper" not in summary or (table := crack_table(summary)).empty:
        return
    words = Markup("<p>{}</p>").format(_WORDS + _OF_LIVES * ("life" in table))
    yield Section("cracks", "Cracks", words + table_html(table.head(_MOST_ROWS)))
