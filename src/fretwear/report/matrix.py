"""The matrix of a report: by how much each parameter of a study changes each result."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd

from fretwear.arrays import Array
from fretwear.data.effects import SEED, Indices, Points, plain_unit
from fretwear.results import headlines
from fretwear.study.parameters import parameter, value_text
from fretwear.units import NO_UNIT, axis_label, number_text, with_unit
from fretwear.variable import Variable

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
    is_clear: bool = False  # whether on that parameter alone


class MatrixRow(NamedTuple):
    """A result."""

    label: str
    values: str  # its range after the last cycle
    cells: Sequence[Cell]


class Matrix(NamedTuple):
    """Rows of results over columns of parameters."""

    columns: Sequence[tuple[str, str]]  # words of a parameter, its first and last level
    rows: Sequence[MatrixRow]  # factors, or in a sampled study shares of the variance
    ranks: Sequence[MatrixRow]  # rank correlations of a sampled study

    @property
    def tables(self) -> list[tuple[str, Sequence[MatrixRow]]]:
        """The tables that have rows, with their keys."""
        key = "Share of the variance (95 % interval)" if self.ranks else "Factor (range)"
        both = (key, self.rows), ("Rank correlation", self.ranks)
        return [(words, rows) for words, rows in both if rows]

    @property
    def opening(self) -> Cell | None:
        """The cell of the first result that another parameter turns round, or the strongest."""
        first = [cell for row in (self.rows or self.ranks)[:1] for cell in row.cells]
        shown = [cell for cell in first if cell.text != "–"]
        return max(shown, key=lambda c: (c.is_clear, c.is_opposed, c.shade), default=None)


def build_matrix(points: Points, effects: pd.DataFrame) -> Matrix:
    """Return the matrix of a study of listed values, or of a sampled one with Sobol indices."""
    names = [n for n in points.levels if points.drawn or (effects["parameter"] == n).any()]
    is_whole = effects["where"].map(len) == 0
    whole, parts = (
        effects[kind].set_index(["result", "parameter"]) for kind in (is_whole, ~is_whole)
    )
    rows, ranks = [], []
    for result in headlines(points.results):
        values = points.results[result]
        if not np.nan_to_num(values).any():
            continue
        variable = points.variables[result]
        label = variable.label, range_text(variable, values)
        if points.drawn:
            ranks.append(MatrixRow(*label, _rank_cells(points, result)))
            if (indices := points.good_indices(result)) is not None:
                rows.append(MatrixRow(*label, _share_cells(points, result, indices)))
            continue
        cells = [
            _cell(whole.loc[(result, name)], parts[parts.index == (result, name)]) for name in names
        ]
        rows.append(MatrixRow(*label, cells))
    columns = [(axis_label(parameter(name).words, NO_UNIT), _ends(points, name)) for name in names]
    return Matrix(columns, rows if names else [], ranks if names else [])


def _ends(points: Points, name: str) -> str:
    """Return the first and the last level of a parameter, or the range it was drawn from."""
    if name == SEED:
        return f"{len(points.levels[name])} seeds"
    return " → ".join(value_text(name, end) for end in points.ends(name))


def _cell(effect: pd.Series, parts: pd.DataFrame) -> Cell:
    """Return the cell of an effect on all pairs, and on parts of them."""
    result, name = effect.name
    key, factor = f"{result}/{name}", float(effect["factor"])
    low, high = effect["lowest_factor"], effect["highest_factor"]
    if math.isnan(factor):
        texts = [word for word in ("appears", "vanishes") if effect[word]]
        grows = texts[:1] == ["appears"]
        return Cell(key, texts[0], "", 100, grows) if len(texts) == 1 else Cell(key)
    if name == SEED:
        return Cell(key, f"±{50.0 * (high - low):.2g}\u00a0%", f"{low:.2f}–{high:.2f}")
    marks = {"→ 0": effect["vanishes"], "0 →": effect["appears"]}
    changes = [f"{mark} in {count}/{effect['pairs']}" for mark, count in marks.items() if count]
    shade = round(100.0 * min(1.0, abs(math.log(factor)) / _STRONG))
    opposed = low < 1.0 - UNCHANGED and high > 1.0 + UNCHANGED
    falls = parts["highest_factor"] < 1.0 - UNCHANGED
    grows = parts["lowest_factor"] > 1.0 + UNCHANGED
    clear = bool(falls.any() and grows.any() and (falls | grows).all())
    is_same = max(abs(low - 1.0), abs(high - 1.0)) < UNCHANGED
    text = "=" if is_same else f"×{factor_text(factor)}"
    spread = ", ".join(filter(None, [spread_text(effect), *changes]))
    return Cell(key, text, spread, shade, factor > 1.0, opposed, clear)


def _share_cells(points: Points, result: str, indices: Indices) -> list[Cell]:
    """Return cells with the total Sobol indices and their intervals."""
    ranks, cells = points.rank_correlations(result), []
    for place, name in enumerate(points.levels):
        total, (low, high) = indices.total[place], indices.total_ends[:, place]
        text, spread = f"{100.0 * total:.0f}\u00a0%", f"{100.0 * low:.0f}–{100.0 * high:.0f}"
        grows = float(ranks[name]) > 0.0
        cells.append(Cell(f"{result}/{name}", text, spread, round(100.0 * total), grows))
    return cells


def _rank_cells(points: Points, result: str) -> list[Cell]:
    """Return cells with rank correlations."""
    cells = []
    for name, rank in points.rank_correlations(result).items():
        key = f"{result}/{name}"
        text = f"ρ {rank:.2f}".replace("-", "−")
        known = Cell(key, text, "", round(100.0 * rank**2), rank > 0.0)
        cells.append(known if math.isfinite(rank) else Cell(key))
    return cells


def factor_text(factor: float) -> str:
    """Return a factor with three digits at most, and two decimals at most."""
    if 0.1 <= factor < 10.0:
        return f"{factor:.2f}"
    return number_text(factor, 2 if factor < 0.1 else 3)


def spread_text(effect: pd.Series) -> str:
    """Return the least and the largest factor of an effect, if they differ: ``1.33–1.40``."""
    ends = [factor_text(effect[end]) for end in ("lowest_factor", "highest_factor")]
    return "–".join(ends) if ends[0] != ends[1] else ""


def range_text(variable: Variable, values: Array) -> str:
    """Return the range of values: ``8.2 to 63 µm``, ``62.9 µm³ to 1.11·10⁶ µm³``."""
    finite = values[np.isfinite(values)]
    unit = plain_unit(variable, finite)
    ends = [float(unit.of(finite.min())), float(unit.of(finite.max()))]
    low, high = (number_text(end, 3) for end in ends)
    if low == high:
        return with_unit(low, unit)
    first = with_unit(low, unit) if ends[1] > _DECADES * ends[0] > 0.0 else low
    return f"{first} to {with_unit(high, unit)}"
