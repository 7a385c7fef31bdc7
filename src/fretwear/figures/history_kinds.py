"""The quantities that are drawn against cycles: label, unit and axis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fretwear.figures.grouping import Line
from fretwear.figures.value_axis import is_wide
from fretwear.figures.wording import MICROMETRE, Unit


@dataclass(frozen=True)
class HistoryKind:
    """What a figure over the cycles shows.

    Parameters
    ----------
    variable : str
        Name of the quantity.
    label : str
        What the y axis says, without the unit.
    base : str
        SI unit of the quantity.
    unit : Unit or None
        Unit of the y axis; None chooses one by the size of the values.
    from_zero : bool
        Whether a linear y axis begins at zero.
    may_be_logarithmic : bool
        Whether a wide range of values is shown on a logarithmic axis.
    """

    variable: str
    label: str
    base: str
    unit: Unit | None = None
    from_zero: bool = True
    may_be_logarithmic: bool = False

    def is_logarithmic(self, lines: Sequence[Line]) -> bool:
        """Whether these lines are drawn on a logarithmic y axis."""
        return self.may_be_logarithmic and is_wide(np.concatenate([n.quantity for n in lines]))


HALF_WIDTH = HistoryKind(
    "contact_half_width_x", "Contact half-width along x", "m", MICROMETRE, from_zero=False
)
STICK_HALF_WIDTH = HistoryKind(
    "stick_half_width_x", "Stick half-width along x", "m", MICROMETRE, from_zero=False
)
WEAR_VOLUME = HistoryKind("wear_volume", "Wear volume", "m3", may_be_logarithmic=True)
DISSIPATED_ENERGY = HistoryKind(
    "dissipated_energy", "Dissipated energy per cycle", "J", may_be_logarithmic=True
)

HISTORY_KINDS = {
    "contact_half_width": HALF_WIDTH,
    "stick_half_width": STICK_HALF_WIDTH,
    "wear_volume": WEAR_VOLUME,
    "dissipated_energy": DISSIPATED_ENERGY,
}
