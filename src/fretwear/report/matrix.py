"""The matrix of a report: by how much each parameter of a study changes each result."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd

from fretwear.arrays import Array
from fretwear.data.effects import GOOD, SEED, Indices, Points, plain_unit
from fretwear.results import Variable, headlines
from fretwear.study.parameters import parameter, value_text
from fretwear.units import NO_UNIT, axis_label, in_unit, number_text, with_unit

UNCHANGED = 0.02
"""Relative change of a result that is within the errors of its computation."""
_DECADES = 1000.0
_STRONG = math.log(4.0)  # logarithm of the factor with the full colour


class Cell(NamedTuple):
    """The change of a result by a parameter."""

    curve: str  # key of its curve
    text: str = "–"
    spread: str = ""  # over the other parameters
    shade: int = 0  # strength of the colour, %
    grows: bool = True
    is_opposed: bool = False  # whether the direction depends on another parameter
    is_clear: bool = False  # whether it does so on that one alone


class MatrixRow(NamedTuple):
    """A result."""

    label: str
    values: str  # its range after the last cycle
    cells: Sequence[Cell]


class Matrix(NamedTuple):
    """Rows of results over columns of parameters."""

    columns: Sequence[tuple[str, str]]  # words of a parameter, its first and last level
    rows: Sequence[MatrixRow]
    is_sampled: bool

    @property
    def opening(self) -> Cell | None:
        """The cell whose curve is shown first: opposite directions, else the strongest."""
        clear = [cell for row in self.rows for cell in row.cells if cell.is_clear]
        first = [cell for row in self.rows[:1] for cell in row.cells if cell.text != "–"]
        return max(clear[:1] or first, key=lambda cell: (cell.is_opposed, cell.shade), default=None)


def build_matrix(points: Points, effects: pd.DataFrame) -> Matrix:
    """Return the matrix of a study of listed values, or of a sampled one with Sobol indices."""
    names = [n for n in points.levels if points.drawn or (effects["parameter"] == n).any()]
    is_whole = effects["where"].map(len) == 0
    whole, parts = (
        effects[kind].set_index(["result", "parameter"]) for kind in (is_whole, ~is_whole)
    )
    rows = []
    for result in headlines(points.results):
        values = points.results[result]
        if not np.nan_to_num(values).any():
            continue
        if points.drawn:
            cells = _sampled_cells(points, result)
        else:
            cells = [
                _cell(whole.loc[(result, name)], parts[parts.index == (result, name)])
                for name in names
            ]
        about = points.variables[result]
        rows.append(MatrixRow(about.label, range_text(about, values), cells))
    columns = [(axis_label(parameter(name).words, NO_UNIT), _ends(points, name)) for name in names]
    return Matrix(columns, rows if names else [], bool(points.drawn))


def _ends(points: Points, name: str) -> str:
    """Return the first and the last level of a parameter, or the range it was drawn from."""
    if name == SEED:
        return f"{len(points.levels[name])} seeds"
    levels = points.levels[name]
    ends: Sequence[object] = levels[0], levels[-1]
    if drawn := points.drawn.get(name):
        units = str(drawn.get("units", ""))
        ends = [in_unit(float(drawn[key]), units) for key in ("drawn_from", "drawn_to")]
    return " → ".join(value_text(name, end) for end in ends)


def _cell(effect: pd.Series, parts: pd.DataFrame) -> Cell:
    """Return the cell of an effect on all pairs, and on parts of them."""
    result, name = effect.name
    key, factor = f"{result}/{name}", float(effect["factor"])
    low, high = effect["lowest_factor"], effect["highest_factor"]
    if math.isnan(factor):
        words = {"appears": "appears", "vanishes": "vanishes"}
        texts = [word for word in words if effect[word]]
        grows = texts[:1] == ["appears"]
        return Cell(key, texts[0], "", 100, grows) if len(texts) == 1 else Cell(key)
    if name == SEED:
        return Cell(key, f"±{50.0 * (high - low):.2g}\u00a0%", f"{low:.2f}–{high:.2f}")
    marks = {"→ 0": effect["vanishes"], "0 →": effect["appears"]}
    changes = [f"{mark} in {count}/{effect['pairs']}" for mark, count in marks.items() if count]
    texts = [factor_text(value) for value in (low, high)]
    spread = "–".join(texts) if texts[0] != texts[1] else ""
    shade = round(100.0 * min(1.0, abs(math.log(factor)) / _STRONG))
    opposed = low < 1.0 - UNCHANGED and high > 1.0 + UNCHANGED
    falls = parts["highest_factor"] < 1.0 - UNCHANGED
    grows = parts["lowest_factor"] > 1.0 + UNCHANGED
    clear = bool(falls.any() and grows.any() and (falls | grows).all())
    is_same = max(abs(low - 1.0), abs(high - 1.0)) < UNCHANGED
    text = "=" if is_same else f"×{factor_text(factor)}"
    spread = ", ".join(filter(None, [spread, *changes]))
    return Cell(key, text, spread, shade, factor > 1.0, opposed, clear)


def _sampled_cells(points: Points, result: str) -> list[Cell]:
    """Return cells with Sobol indices, or with rank correlations where no emulator is good."""
    ranks, cells = points.rank_correlations(result), []
    indices: Indices | None = points.indices.get(result)
    for place, name in enumerate(points.levels):
        key, rank = f"{result}/{name}", float(ranks[name])
        if indices is not None and indices.quality >= GOOD:
            total, first = indices.total[place], indices.first[place]
            text = f"{100.0 * total:.0f}\u00a0%"
            alone = f"alone {100.0 * first:.0f}\u00a0%" if total - first > UNCHANGED else ""
            cells.append(Cell(key, text, alone, round(100.0 * total), rank > 0.0))
        elif math.isfinite(rank):
            text = f"ρ {rank:.2f}".replace("-", "−")
            cells.append(Cell(key, text, "", round(100.0 * rank**2), rank > 0.0))
        else:
            cells.append(Cell(key))
    return cells


def factor_text(factor: float) -> str:
    """Return a factor with three digits at most, and two decimals at most."""
    if 0.1 <= factor < 10.0:
        return f"{factor:.2f}"
    return number_text(factor, 2 if factor < 0.1 else 3)


def range_text(about: Variable, values: Array) -> str:
    """Return the range of values: ``8.2 to 63 µm``, ``62.9 µm³ to 1.11·10⁶ µm³``."""
    finite = values[np.isfinite(values)]
    unit = plain_unit(about, finite)
    ends = [float(unit.of(finite.min())), float(unit.of(finite.max()))]
    low, high = (number_text(end, 3) for end in ends)
    if low == high:
        return with_unit(low, unit)
    first = with_unit(low, unit) if ends[1] > _DECADES * ends[0] > 0.0 else low
    return f"{first} to {with_unit(high, unit)}"
