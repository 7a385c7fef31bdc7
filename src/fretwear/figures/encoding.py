"""How the levels of a parameter look: colours, marks and their key, alike in all figures."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize, to_hex
from matplotlib.lines import Line2D

from fretwear.data.effects import Value
from fretwear.figures.style import MARKERS, look, sequential_colormap, sequential_colours
from fretwear.study.parameters import parameter, symbol_text

MOST_KEYED = 8
"""Largest number of levels with a key; more levels have a colour bar."""
_WIDE = 20.0


def rounded(value: Value) -> Value:
    """Return a level with as many digits as a key or a title needs, if it was drawn at random."""
    return value if isinstance(value, str) else float(f"{value:.3g}")


class Coding:
    """Colours and marks of the levels of a parameter; one look if the name is None.

    Levels that are text have unordered colours, numbers a ramp that ends in the darkest.
    """

    def __init__(self, name: str | None, levels: Sequence[Value]) -> None:
        self.name, self.levels = name, tuple(levels)
        self.norm: Normalize | None = None
        if isinstance(levels[0], str):
            self.colors = [look(place)[0] for place in range(len(levels))]
        elif len(levels) <= MOST_KEYED:
            self.colors = sequential_colours(len(levels))
        else:
            values = np.asarray(levels, dtype=np.float64)
            finite = values[np.isfinite(values)]
            low, high = float(finite.min()), float(finite.max())
            self.norm = (LogNorm if low > 0.0 and high > _WIDE * low else Normalize)(low, high)
            self.colors = [to_hex(color) for color in sequential_colormap()(self.norm(values))]

    @property
    def is_keyed(self) -> bool:
        """Whether a key names every level."""
        return self.norm is None

    def mark(self, place: int) -> str:
        """Return the mark of a level, the same for all if there is a colour bar."""
        return MARKERS[place % len(MARKERS) if self.is_keyed else 0]

    def scale(self) -> ScalarMappable:
        """Return the scale of a colour bar."""
        return ScalarMappable(self.norm, sequential_colormap())

    def key(self, shown: Sequence[int]) -> tuple[list[Line2D], list[str]]:
        """Return handles and texts of the levels shown, given by place, or of the ends of many."""
        if self.name is None:
            return [], []
        places = sorted(set(shown))
        places = places if self.is_keyed else [places[0], places[-1]]
        handles = [
            Line2D([], [], color=self.colors[place], marker=self.mark(place)) for place in places
        ]
        values = [self.levels[place] for place in places]
        if not self.is_keyed:
            values = [rounded(value) for value in values]
        texts = [symbol_text(self.name, value) for value in values]
        return handles, texts

    def number(self, value: float) -> str:
        """Return the text of a number on the colour bar."""
        return f"{parameter(self.name).unit.of(value):g}" if self.name else ""
